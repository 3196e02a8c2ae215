"""Flights under a force with harmonics in 40 digits, by the integrals of its cosines and nothing of the package."""

from __future__ import annotations

from collections.abc import Sequence

from mpmath import mp, mpf

from vireport.physics.groups import Groups, by_wall

Parts = Sequence[tuple[int, float, float]]
"""Order, share and phase [rad] of harmonics."""


class Flights:
    """What happens between impacts, and at them; times are in half periods of the force."""

    friction = mpf(0)

    def __init__(self, groups: Groups, harmonics: Parts) -> None:
        self.d, self.gbar = mpf(float(groups.d)), mpf(float(groups.gbar))
        self.r = [mpf(float(r)) for r in by_wall(groups.restitution)]
        self.parts = [(1, mpf(1), mpf(0)), *((k, mpf(p), mpf(psi)) for k, p, psi in harmonics)]

    def pull(self, t: mpf) -> mpf:
        """Acceleration at a time."""
        return self.gbar + sum(p * mp.cos(k * mp.pi * t + psi) for k, p, psi in self.parts)

    def restitution_of(self, wall: int, velocity: mpf) -> mpf:
        """Restitution of an impact."""
        return self.r[wall < 0]

    def flown(self, wall: int, before: mpf, start: mpf, t: mpf) -> tuple[mpf, mpf]:
        """Velocity and way a time after an impact on a wall, from the velocity before it."""
        velocity = -self.restitution_of(wall, before) * before
        gravity = self.gbar + wall * self.friction  # from the bottom, 1, Z falls: friction is against it
        speed, way = velocity + gravity * t, velocity * t + gravity * t * t / 2
        for k, p, psi in self.parts:
            turn = k * mp.pi
            first, last = turn * start + psi, turn * (start + t) + psi
            speed += p * (mp.sin(last) - mp.sin(first)) / turn
            way += -p * (mp.cos(last) - mp.cos(first)) / turn**2 - p * mp.sin(first) * t / turn
        return speed, way

    def arrival(self, wall: int, other: int, velocity: mpf, start: mpf, guess: mpf) -> tuple[mpf, mpf]:
        """Velocity before the next impact, and its time."""
        way = (other - wall) * self.d / 2
        t = mp.findroot(lambda t: self.flown(wall, velocity, start, t)[1] - way, guess - start)
        return self.flown(wall, velocity, start, t)[0], start + t

    def missed(self, v0: mpf, v1: mpf, t0: mpf, t1: mpf, period: mpf = 2) -> list[mpf]:
        """What is zero of a motion with one impact on each wall, by their velocities and times."""
        at_top, up = self.flown(1, v0, t0, t1 - t0)
        at_bottom, down = self.flown(-1, v1, t1, t0 + period - t1)
        return [at_top - v1, up + self.d, at_bottom - v0, down - self.d]

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
