"""Turning points of many motions at once: whether the ball stays between the membranes in its flights.

Z' is monotone between the zeros of Z'' = gbar + cos(phase), which are known, so that none is missed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vireport.motions.roots import newton_root
from vireport.physics import flight

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

SETTLED = 1e-10
"""Newton step [t_c] at which a turning point is found: Z' being zero there, its square is what moves the position."""


class Turns(NamedTuple):
    """Turning points: of which motion, in the flight after which impact, how long after it, and how far from the wall.

    The distance is negative where the ball would have passed through the membrane.
    """

    motion: Ints
    after: Ints
    elapsed: Floats
    gap: Floats


def turning_points(
    walls: Ints,
    velocity: Floats,
    time: Floats,
    period: float | Floats,
    groups: tuple[Floats, Floats],
    r: float,
    settled: float = SETTLED,
) -> Turns:
    """Find the turning points of motions with one sequence of impacts.

    Parameters
    ----------
    walls : ndarray (N,)
        The membrane of each impact: 1 bottom, -1 top.
    velocity, time : ndarray (N, n)
        Of the impacts of each motion [y_c], [t_c].
    period : float or ndarray (n,)
        Of the motions [t_c].
    groups : tuple of ndarray (n,)
        Their d and gbar.
    r : float
        Restitution coefficient.
    settled : float
        Newton step at which a turning point is found [t_c].
    """
    d, gbar = groups
    ends = np.concatenate([time[1:], time[:1] + period])
    after, sine = flight.reflect(velocity, r), np.sin(np.pi * time)
    # Z'' is zero at phases of this and the opposite sign; where gbar > 1 it is positive throughout.
    turn = np.arccos(np.clip(-gbar, -1.0, 1.0)) / np.pi
    lap = 2 * np.floor(time / 2)
    laps = int(np.ceil(np.fmax.reduce(ends - lap, axis=None, initial=0.0) / 2))  # NaN are left out
    border_time, border_speed = [time], [after]
    for i in range(laps):
        for at, swing in ((turn, np.sin(np.pi * turn)), (2 - turn, -np.sin(np.pi * turn))):
            t = lap + 2 * i + at
            speed = flight.velocity(t - time, after, sine, swing, gbar)
            speed = np.where(t > time, np.where(t < ends, speed, np.roll(velocity, -1, axis=0)), after)
            border_time.append(np.clip(t, time, ends))
            border_speed.append(speed)
    times, speeds = np.stack([*border_time, ends]), np.stack([*border_speed, np.roll(velocity, -1, axis=0)])
    piece, which, motion = np.nonzero(speeds[:-1] * speeds[1:] < 0)
    low, high = times[piece, which, motion], times[piece + 1, which, motion]
    rising = speeds[piece + 1, which, motion] > 0
    start, v, s, pull = time[which, motion], after[which, motion], sine[which, motion], gbar[motion]

    def speed_at(t: Floats, i: Ints) -> tuple[Floats, Floats]:
        phase = np.pi * t
        value = flight.velocity(t - start[i], v[i], s[i], np.sin(phase), pull[i])
        return value, flight.acceleration(np.cos(phase), pull[i])

    root = newton_root(speed_at, low, high, rising, settled)
    covered = flight.displacement(root - start, v, s, np.cos(np.pi * start), np.cos(np.pi * root), pull)
    leaves, turned = walls[which], np.where(rising, -1, 1)
    gap = d[motion] / 2 * (1 - turned * leaves) - turned * covered
    return Turns(motion, which, root - start, gap)
