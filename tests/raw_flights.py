"""Flights between the membranes of any device, by the integrals of its force's cosines and nothing of the package.

In 40 digits by mpmath, or in doubles by NumPy: these also as arrays, and with derivatives as imaginary parts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from mpmath import mp, mpf

from vireport.motions.one_to_one import Motions
from vireport.physics.groups import Groups

Parts = Sequence[tuple[int, Any, Any]]
"""Order, share and phase [rad] of harmonics."""

LARGEST = 0.99
"""Restitution that a law which falls with speed ends at."""


class Flights:
    """What happens between impacts, and at them; times are in half periods of the force.

    Harmonics are those of the groups where they are not stated otherwise.
    """

    def __init__(self, groups: Groups, harmonics: Parts | None = None, ops: Any = mp) -> None:
        self.ops = ops
        number = float if ops is np else lambda x: x if isinstance(x, mpf) else mpf(float(x))
        self.d, self.gbar, self.friction = map(number, (groups.d, groups.gbar, groups.friction or 0))
        self.r = [number(getattr(groups.restitution, wall, groups.restitution)) for wall in ("bottom", "top")]
        law = groups.restitution if hasattr(groups.restitution, "exponent") else None
        self.law = None if law is None else (number(law.exponent), number(law.speed))
        parts = [(h.order, number(h.cosine), number(h.sine)) for h in groups.harmonics]
        if harmonics is not None:
            shares = [(k, number(p), number(psi)) for k, p, psi in harmonics]
            parts = [(k, p * ops.cos(psi), -p * ops.sin(psi)) for k, p, psi in shares]
        self.parts = [(1, number(1), number(0)), *parts]

    def restitution_of(self, wall: int, velocity: Any) -> Any:
        """Restitution of an impact."""
        r = self.r[wall < 0]
        if self.law is not None:
            exponent, speed = self.law
            r = r * (wall * velocity / speed) ** exponent
        return LARGEST if self.law is not None and r.real > LARGEST else r

    def moved(self, velocity: Any, gravity: Any, start: Any, t: Any) -> tuple[Any, Any]:
        """Velocity and way a time after one with a velocity, by the force and a constant acceleration."""
        speed, way = velocity + gravity * t, velocity * t + gravity * t * t / 2
        cos, sin = self.ops.cos, self.ops.sin
        for k, c, s in self.parts:
            turn = k * self.ops.pi
            first, last = turn * start, turn * (start + t)
            by_sine, by_cosine = sin(last) - sin(first), cos(last) - cos(first)
            speed = speed + (c * by_sine - s * by_cosine) / turn
            way = way - (c * by_cosine + s * by_sine) / turn**2 - (c * sin(first) - s * cos(first)) * t / turn
        return speed, way

    def flown(self, wall: int, before: Any, start: Any, t: Any) -> tuple[Any, Any]:
        """Velocity and way a time after an impact on a wall, from the velocity before it."""
        # From the bottom, 1, Z falls: friction is against it.
        return self.moved(-self.restitution_of(wall, before) * before, self.gbar + wall * self.friction, start, t)

    def arrival(self, wall: int, other: int, velocity: mpf, start: mpf, guess: mpf) -> tuple[mpf, mpf]:
        """Velocity before the next impact, and its time."""
        way = (other - wall) * self.d / 2
        t = mp.findroot(lambda t: self.flown(wall, velocity, start, t)[1] - way, guess - start)
        return self.flown(wall, velocity, start, t)[0], start + t

    def missed(self, *x: Any, period: int = 2, walls: Sequence[int] = (1, -1)) -> list[Any]:
        """What is zero of a motion of a word, by its velocities and then its times; by default with one impact on each.

        It is velocities and ways of the flights, in turn.
        """
        count, left = len(walls), []
        for i, wall in enumerate(walls):
            j = (i + 1) % count
            speed, way = self.flown(wall, x[i], x[count + i], x[count + j] + (0 if j else period) - x[count + i])
            left += [speed - x[j], way - (walls[j] - wall) // 2 * self.d]
        return left

    def nearest(self, motions: Motions, row: int, n: int = 1) -> tuple[mpf, mpf, mpf, mpf]:
        """Velocities at bottom and top, and times, of the 1:n motion next to one in doubles."""
        near = (float(getattr(motions, name)[row]) for name in ("velocity_bottom", "velocity_top", "phi_bottom", "u"))
        v0, v1, phase, u = map(mpf, near)
        t0 = phase / mp.pi
        guess = v0, v1, t0, t0 + n * (1 + 2 * u)
        return tuple(mp.findroot(lambda *x: self.missed(*x, period=2 * n), guess, tol=mpf(10) ** -mp.dps))

    def from_anywhere(self, rng: np.random.Generator, starts: int, period: int = 2) -> Iterator[np.ndarray]:
        """What Newton's method finds in doubles from random starts: velocities at bottom and top, and times."""
        for _ in range(starts):
            x = rng.uniform((0, -2.5, 0, 0), (2.5, 0, 2, period))
            x[3] += x[2]
            with np.errstate(all="ignore"):
                for _ in range(40):
                    value = np.array(self.missed(*x, period=period))
                    slopes = np.imag([self.missed(*(x + 1e-30j * row), period=period) for row in np.eye(4)]).T / 1e-30
                    if not abs(np.linalg.det(slopes)) > 1e-12:
                        break
                    step = np.linalg.solve(slopes, value)
                    x = x - step / max(1.0, 2 * float(np.abs(step).max()))
                    if np.abs(step).max() < 1e-13:
                        break
                settled = np.abs(self.missed(*x, period=period)).max() < 1e-11
            if settled and x[0] > 1e-6 and x[1] < -1e-6 and 1e-6 < x[3] - x[2] < period - 1e-6:
                yield x

    def gap(self, v0: Any, v1: Any, t0: Any, t1: Any, period: int = 2) -> float:
        """Least distance in doubles from a membrane where the ball turns between the impacts, d where it never does."""
        least = self.d
        for wall, v, start, end in ((1, v0, t0, t1), (-1, v1, t1, t0 + period)):
            speed, way = self.flown(wall, v, start, np.linspace(0, end - start, 40001))
            turned = np.flatnonzero(speed[1:-2] * speed[2:-1] < 0) + 1
            least = min([least, *(min(-wall * way[i], self.d + wall * way[i]) for i in turned)])
        return least

    def struck(self, wall: int, before: float, start: float) -> tuple[int, float, float]:
        """Wall, time since the last impact and velocity of the next one, in doubles by small steps and bisections."""

        def risen(t: Any) -> Any:
            return -wall * self.flown(wall, before, start, t)[1]

        t = np.linspace(1e-9, 4, 10_001)
        away = risen(t)
        i = int(np.argmax((away < 0) | (away > self.d)))
        across, low, high = bool(away[i] > self.d), (t[i - 1] if i else 0.0), t[i]
        for _ in range(60):
            middle = (low + high) / 2
            inside = risen(middle) < self.d if across else risen(middle) > 0
            low, high = (middle, high) if inside else (low, middle)
        return (-wall if across else wall), float(high), float(self.flown(wall, before, start, high)[0])

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

    def map_of(self, v0: mpf, v1: mpf, t0: mpf, t1: mpf, period: int = 2) -> tuple[mpf, mpf]:
        """Trace and determinant of a motion with one impact on each wall."""
        return self.multipliers((1, -1), v0, t0, (t1, t0 + period))

    def periodic(self, walls: Sequence[int], velocity: float, times: Sequence[float], period: int) -> tuple[mpf, ...]:
        """Velocity and time of the first impact of the motion next to one in doubles, its trace and determinant."""
        guesses = [*map(mpf, times[1:]), mpf(times[0]) + period]

        def missed(velocity: mpf, start: mpf) -> list[mpf]:
            after, then = self.lap(walls, velocity, start, guesses)
            return [after - velocity, then - start - period]

        velocity, start = mp.findroot(missed, (mpf(velocity), mpf(times[0])))
        return velocity, start, *self.multipliers(walls, velocity, start, guesses)
