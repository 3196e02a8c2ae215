"""Flights under a force with harmonics in 40 digits, by the integrals of its cosines and nothing of the package."""

from __future__ import annotations

from collections.abc import Sequence

from mpmath import mp, mpf

from vireport.physics.groups import Groups, by_wall

Parts = Sequence[tuple[int, float, float]]
"""Order, share and phase [rad] of harmonics."""


class Flights:
    """What happens between impacts, and at them; times are in half periods of the force."""

    def __init__(self, groups: Groups, harmonics: Parts) -> None:
        self.d, self.gbar = mpf(float(groups.d)), mpf(float(groups.gbar))
        self.r = [mpf(float(r)) for r in by_wall(groups.restitution)]
        self.parts = [(1, mpf(1), mpf(0)), *((k, mpf(p), mpf(psi)) for k, p, psi in harmonics)]

    def pull(self, t: mpf) -> mpf:
        """Acceleration at a time."""
        return self.gbar + sum(p * mp.cos(k * mp.pi * t + psi) for k, p, psi in self.parts)

    def flown(self, velocity: mpf, start: mpf, t: mpf) -> tuple[mpf, mpf]:
        """Velocity and way a time after another, from the velocity there."""
        speed, way = velocity + self.gbar * t, velocity * t + self.gbar * t * t / 2
        for k, p, psi in self.parts:
            turn = k * mp.pi
            first, last = turn * start + psi, turn * (start + t) + psi
            speed += p * (mp.sin(last) - mp.sin(first)) / turn
            way += -p * (mp.cos(last) - mp.cos(first)) / turn**2 - p * mp.sin(first) * t / turn
        return speed, way

    def arrival(self, wall: int, other: int, velocity: mpf, start: mpf, guess: mpf) -> tuple[mpf, mpf]:
        """Velocity before the next impact, and its time."""
        after, way = -self.r[wall < 0] * velocity, (other - wall) * self.d / 2
        t = mp.findroot(lambda t: self.flown(after, start, t)[1] - way, guess - start)
        return self.flown(after, start, t)[0], start + t

    def lap(self, walls: Sequence[int], velocity: mpf, start: mpf, guesses: Sequence[mpf]) -> tuple[mpf, mpf]:
        """Velocity and time of the impact that ends a period, from the first; each next impact is near a guess."""
        for wall, other, guess in zip(walls, [*walls[1:], walls[0]], guesses, strict=True):
            velocity, start = self.arrival(wall, other, velocity, start, guess)
        return velocity, start

    def multipliers(self, walls: Sequence[int], velocity: mpf, start: mpf, guesses: Sequence[mpf]) -> tuple[mpf, mpf]:
        """Trace and determinant of the map over a period, by differences."""
        step = mpf(10) ** -20
        pairs = [
            [self.lap(walls, velocity + way * a, start + way * b, guesses) for way in (step, -step)]
            for a, b in ((1, 0), (0, 1))
        ]
        (a, c), (b, d) = ([(p - q) / (2 * step) for p, q in zip(*pair, strict=True)] for pair in pairs)
        return a + d, a * d - b * c

    def periodic(self, walls: Sequence[int], velocity: float, times: Sequence[float], period: int) -> tuple[mpf, ...]:
        """Velocity and time of the first impact of the motion next to one in doubles, its trace and determinant."""
        guesses = [*map(mpf, times[1:]), mpf(times[0]) + period]

        def missed(velocity: mpf, start: mpf) -> list[mpf]:
            after, then = self.lap(walls, velocity, start, guesses)
            return [after - velocity, then - start - period]

        velocity, start = mp.findroot(missed, (mpf(velocity), mpf(times[0])))
        return velocity, start, *self.multipliers(walls, velocity, start, guesses)
