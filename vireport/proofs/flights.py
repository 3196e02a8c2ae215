"""Proofs that the ball stays between the membranes: flights in ball arithmetic, halved until every part is settled.

The counterpart of `admissibility`, which finds the turning points in doubles. Here nothing is found; every time of a
flight is covered by parts, and on each part the distance to either wall is proved to be positive, or to be zero at
one known time only.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from vireport.analysis import Orbits
from vireport.physics import flight
from vireport.proofs import balls
from vireport.proofs.balls import Ball, BallOps

DEEPEST, MOST_PARTS = 100, 3000
"""Halvings of a flight, and parts of it, before it is left undecided whether the ball stays between the membranes."""


@dataclass(frozen=True, slots=True)
class Flight:
    """One flight of an enclosed motion; a time is a ball too, and means every time in it.

    Attributes
    ----------
    sign : int
        1 for the flight downward, -1 upward: of a velocity away from the wall left.
    after, sine, cosine, gbar, distance, duration : ball
        Velocity after the impact, sine and cosine of the phase at it, gravity, distance of the walls, flight time.
    """

    sign: int
    after: Ball
    sine: Ball
    cosine: Ball
    gbar: Ball
    distance: Ball
    duration: Ball

    @classmethod
    def of(cls, orbit: Orbits, upward: bool, r: Ball) -> Flight:
        """The flight from the bottom upward, or the other."""
        if upward:
            start = (orbit.velocity_bottom, orbit.sin_phi, orbit.cos_phi, orbit.time_up)
        else:
            start = (orbit.velocity_top, orbit.sin_top, orbit.cos_top, orbit.time_down)
        before, sine, cosine, duration = start
        after = flight.reflect(before, r)
        return cls(-1 if upward else 1, after, sine, cosine, orbit.gbar, orbit.d, duration)

    def moving(self, t: Ball) -> tuple[Ball, Ball, Ball]:
        """Distance covered, velocity and acceleration away from the wall left, each over all of a time.

        By the mean value theorem from the middle of it.
        """
        ops, middle = BallOps(), t.mid()
        sine, cosine = self._forcing(t)
        pressing = self.sign * flight.acceleration(cosine, self.gbar)
        sine, cosine = self._forcing(middle)
        speed = self.sign * flight.velocity(middle, self.after, self.sine, sine, self.gbar, pi=ops.pi)
        covered = self.sign * flight.displacement(
            middle, self.after, self.sine, self.cosine, cosine, self.gbar, pi=ops.pi
        )
        speed += pressing * (t - middle)
        return covered + speed * (t - middle), speed, pressing

    def jerk(self, t: Ball) -> Ball:
        """Rate of the acceleration away from the wall left, over all of a time."""
        return -self.sign * BallOps().pi * self._forcing(t)[0]

    def _forcing(self, t: Ball) -> tuple[Ball, Ball]:
        sine, cosine = t.sin_cos_pi()
        return self.sine * cosine + self.cosine * sine, self.cosine * cosine - self.sine * sine


def stays_between(way: Flight, touch: tuple[Ball | None, bool] | None) -> bool | None:
    """Whether the ball is proved to stay between the membranes in a flight, or proved not to, by halving its time.

    Parameters
    ----------
    way : Flight
        That leaves and arrives with velocities of the right signs, or with none.
    touch : (ball or None, bool) or None
        A time at which it is at rest on a wall by the condition of the point; whether on the wall left. No time means
        that it leaves with neither velocity nor acceleration.
    """
    time, at_start = touch or (None, False)
    unpressed = touch is not None and time is None
    # Breadth first, so that a part outside is found before the ends of such parts are halved for ever.
    parts, done = deque([(0, 0)]), 0
    while parts:
        place, depth = parts.popleft()
        done += 1
        share = balls.dyadic(2 * place + 1, depth + 1, depth + 1)
        t = share * way.duration
        covered, speed, away = way.moving(t)
        left = way.distance - covered
        if covered < 0 or left < 0:
            return False
        touches = time is not None and t.overlaps(time)
        curve = way.moving(t.union(time))[2] if touches else away
        # Where distance and velocity are zero at one time, the sign of the acceleration settles the times beside it.
        leaves = place == 0 and (speed > 0 or away > 0 or (unpressed and way.jerk(t) > 0))
        arrives = place + 1 == 1 << depth and (speed > 0 or away < 0)
        from_start = covered > 0 or leaves or (touches and at_start and curve > 0)
        from_end = left > 0 or arrives or (touches and not at_start and curve < 0)
        if from_start and from_end:
            continue
        if depth == DEEPEST or done > MOST_PARTS:
            return None
        parts += [(2 * place, depth + 1), (2 * place + 1, depth + 1)]
    return True
