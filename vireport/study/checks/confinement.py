"""Proofs that the ball stays between the membranes: flights in ball arithmetic, halved until every part is settled.

The counterpart of `vireport.motions.turning`, which finds the turning points in doubles. Here nothing is found;
every time of a flight is covered by parts, and on each part the distance to either wall is proved to be positive, or to
be zero at one known time only.
"""

from __future__ import annotations

from collections import deque

from vireport.physics.flight import Flight
from vireport.study.checks.enclosures import Ball, BallOps, dyadic

DEEPEST, MOST_PARTS = 100, 3000
"""Halvings of a flight, and parts of it, before it is left undecided whether the ball stays between the membranes."""


def stays_between(way: Flight, touch: tuple[Ball | None, bool] | None, returns: bool = False) -> bool | None:
    """Whether the ball is proved to stay between the membranes in a flight, or proved not to, by halving its time.

    Parameters
    ----------
    way : Flight
        Of balls; it leaves and arrives with velocities of the right signs, or with zero velocity.
    touch : (ball or None, bool) or None
        A time [t_c] at which the ball touches a membrane by the condition of the critical point, and whether that is
        the membrane left. None for the time means that the ball leaves with neither velocity nor acceleration.
    returns : bool
        Whether the flight ends on the membrane that it left.
    """
    time, at_start = touch or (None, False)
    unpressed = touch is not None and time is None
    # Breadth first, so that a part outside is found before the ends of such parts are halved for ever.
    parts, done = deque([(0, 0)]), 0
    while parts:
        place, depth = parts.popleft()
        done += 1
        t = dyadic(2 * place + 1, depth + 1, depth + 1) * way.duration
        covered, speed, away = _moving(way, t)
        left = way.d - covered
        if covered < 0 or left < 0:
            return False
        touches = time is not None and t.overlaps(time)
        curve = _moving(way, t.union(time))[2] if touches else away
        # Where distance and velocity are zero at one time, the sign of the acceleration settles the times beside it.
        leaves = place == 0 and (speed > 0 or away > 0 or (unpressed and _jerk(way, t) > 0))
        last = place + 1 == 1 << depth
        comes_back = returns and last and (speed < 0 or away > 0)
        arrives = not returns and last and (speed > 0 or away < 0)
        from_start = covered > 0 or leaves or comes_back or (touches and at_start and curve > 0)
        from_end = left > 0 or arrives or (touches and not at_start and curve < 0)
        if from_start and from_end:
            continue
        if depth == DEEPEST or done > MOST_PARTS:
            return None
        parts += [(2 * place, depth + 1), (2 * place + 1, depth + 1)]
    return True


def _moving(way: Flight, t: Ball) -> tuple[Ball, Ball, Ball]:
    """Distance covered, velocity and acceleration away from the wall left, each over all times in a ball.

    By the mean value theorem from the middle of it.
    """
    ops, middle = BallOps(), t.mid()
    acceleration = way.pressing(way.turned(*t.sin_cos_pi())[1])
    sine, cosine = way.turned(*middle.sin_cos_pi())
    speed = way.speed(middle, sine, ops.pi) + acceleration * (t - middle)
    return way.covered(middle, cosine, ops.pi) + speed * (t - middle), speed, acceleration


def _jerk(way: Flight, t: Ball) -> Ball:
    """Rate of the acceleration away from the wall left, over all times in a ball."""
    return way.jerk(way.turned(*t.sin_cos_pi())[0], BallOps().pi)
