"""A ball with friction in 40 digits, written from the model alone."""

from __future__ import annotations

from mpmath import mp, mpf
from raw_flights import Flights

STEPS = 64
"""Samples of a forcing period between which the reference looks for a change of sign."""


class Reference(Flights):
    """Z'' = gbar + a - f sign(Z') with sticking, in 40 digits: samples of each way between stops, and bisections."""

    def velocity(self, t: mpf, v: mpf, x: mpf, way: int) -> mpf:
        return self.moved(v, self.gbar - way * self.friction, x / mp.pi, t)[0]

    def covered(self, t: mpf, v: mpf, x: mpf, way: int) -> mpf:
        return self.moved(v, self.gbar - way * self.friction, x / mp.pi, t)[1]

    def pull(self, x: mpf) -> mpf:
        return self.gbar + sum(c * mp.cos(k * x) + s * mp.sin(k * x) for k, c, s in self.parts)

    @staticmethod
    def root(function, low: mpf, high: mpf) -> mpf:
        rising = function(high) > 0
        for _ in range(120):
            middle = (low + high) / 2
            low, high = (low, middle) if (function(middle) > 0) == rising else (middle, high)
        return (low + high) / 2

    def freed(self, x: mpf, leaves: tuple[int, ...]) -> tuple[mpf, int]:
        """How long friction holds the ball, and the way on which it is let go."""
        f, step = self.friction, mpf(2) / (8 * STEPS)
        for k in range(8 * STEPS + 1):
            for way in leaves:
                beyond = way * self.pull(x + mp.pi * step * (k + 1)) - f
                if beyond > 0:
                    there = self.root(
                        lambda t, way=way: way * self.pull(x + mp.pi * t) - f, step * k if k else mpf(0), step * (k + 1)
                    )
                    return there, way
        raise AssertionError("held for ever")

    def next_impact(self, wall: int, before: mpf, x: mpf) -> tuple[int, mpf, mpf, mpf, int]:
        """Wall, time, velocity and phase of the next impact, and how often the ball stops on the way."""
        d, after = self.d, -self.restitution_of(wall, before) * before
        z, way, v, time, stops = wall * d / 2, -wall, after, mpf(0), 0
        while True:
            step, t = mpf(2) / STEPS, mpf(0)
            while True:
                ahead = t + step
                struck = way * (z + self.covered(ahead, v, x, way)) >= d / 2
                stopped = way * self.velocity(ahead, v, x, way) < 0
                if struck or stopped:
                    break
                t = ahead
            if stopped:
                ahead = self.root(lambda t, v=v, x=x, way=way: -way * self.velocity(t, v, x, way), t, ahead)
                struck = way * (z + self.covered(ahead, v, x, way)) >= d / 2
            if struck:
                goal = self.root(
                    lambda t, z=z, v=v, x=x, way=way: way * (z + self.covered(t, v, x, way)) - d / 2, t, ahead
                )
                return way, time + goal, self.velocity(goal, v, x, way), x + mp.pi * goal, stops
            z, x, time, v, stops = (
                z + self.covered(ahead, v, x, way),
                x + mp.pi * ahead,
                time + ahead,
                mpf(0),
                stops + 1,
            )
            pull = self.pull(x)
            if abs(pull) > self.friction:
                way = 1 if pull > 0 else -1
            else:
                held, way = self.freed(x, (-1, 1))
                x, time = x + mp.pi * held, time + held
