"""Whether a solution of the equations is a motion: whether the ball stays between the membranes in its flights.

The periodicity conditions only know the ends of each flight. The extrema between are the zeros of Z', and Z' is
monotone between the zeros of Z'' = gbar + cos(phase), which are known. So every turning point is found for certain,
without sampling.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.orbits import Orbits
from vireport.physics import flight

Floats = NDArray[np.float64]

ITERATIONS = 60
"""More than bisection needs to exhaust a double; Newton's steps end the search after four to seven."""

SMALLEST_STEP = 1e-15
"""Newton step at which a turning point is found: the position there no longer depends on it, for Z' is zero."""


def wall_gap(orbit: Orbits, r: float, n: int) -> Floats:
    """Smallest distance between the ball and a membrane at the turning points of its flights [x_c].

    Parameters
    ----------
    orbit : Orbits
        Arrays of motions with velocity_bottom > 0 > velocity_top.
    r : float
        Restitution coefficient.
    n : int
        Forcing periods per motion.

    Returns
    -------
    ndarray
        Negative where the ball would have to pass through a membrane, zero at grazing, and d where it crosses from
        wall to wall without ever turning back.

    Notes
    -----
    A flight leaves one wall and arrives at the other with velocities of the same sign, so Z' can only change sign
    in pairs, around an extremum of Z' of the other sign: where Z' is positive at such an extremum of an upward
    flight (or negative in a downward one), there is exactly one zero on either side.
    """
    d = np.asarray(orbit.d, dtype=float)
    gap = d.copy()
    for turn in turning_points(orbit, r, n):
        np.minimum.at(gap.reshape(-1), turn.index, np.minimum(turn.from_start_wall, turn.from_end_wall))
    return gap


@dataclass(frozen=True, slots=True, eq=False)
class Turns:
    """Turning points of one flight of some of the motions.

    Attributes
    ----------
    index : ndarray of int
        Which motions of those given.
    upward : bool
        Whether the flight is the one from the bottom to the top.
    time : ndarray
        Since the flight began [t_c].
    from_start_wall, from_end_wall : ndarray
        Distances to the wall left and to the wall the ball is to arrive at; negative beyond it.
    """

    index: NDArray[np.intp]
    upward: bool
    time: Floats
    from_start_wall: Floats
    from_end_wall: Floats


def turning_points(orbit: Orbits, r: float, n: int) -> Iterator[Turns]:
    """Every turning point of the motions' flights; parameters are those of `wall_gap`."""
    d = np.atleast_1d(np.asarray(orbit.d, dtype=float))
    gbar = np.broadcast_to(np.asarray(orbit.gbar, dtype=float), d.shape)
    # Z' is largest at phase `turn`, the wrong way for an upward flight, and smallest at -turn, for a downward one.
    # Where gbar > 1, Z'' never vanishes; then Z' is not of the wrong sign at phase pi either.
    turn = np.arccos(np.clip(-gbar, -1.0, 1.0))
    rise, fall = 2 * turn / np.pi, 2 - 2 * turn / np.pi
    phase_top = np.arctan2(orbit.sin_top, orbit.cos_top)
    up = (orbit.phi, -r * orbit.velocity_bottom, orbit.sin_phi, orbit.cos_phi, orbit.time_up)
    down = (phase_top, -r * orbit.velocity_top, orbit.sin_top, orbit.cos_top, orbit.time_down)
    for sign, start in ((1.0, up), (-1.0, down)):
        phase, velocity, sine, cosine, duration = (np.broadcast_to(np.asarray(x, dtype=float), d.shape) for x in start)
        first = np.mod(sign * turn - phase, 2 * np.pi) / np.pi
        since, until = (rise, fall) if sign > 0 else (fall, rise)
        for lap in range(n + 1):
            worst = first + 2 * lap
            index = np.nonzero(worst < duration)[0]
            w, p, v, s, g = (x[index] for x in (worst, phase, velocity, sine, gbar))
            index = index[sign * flight.velocity(w, v, s, np.sin(p + np.pi * w), g) > 0]
            if not index.size:
                continue
            w, p, v, s, c, g = (x[index] for x in (worst, phase, velocity, sine, cosine, gbar))
            before = np.maximum(w - since[index], 0.0)
            after = np.minimum(w + until[index], duration[index])
            for low, high in ((before, w), (w, after)):
                t = _velocity_zero(low, high, p, v, s, g)
                covered = -sign * flight.displacement(t, v, s, c, np.cos(p + np.pi * t), g)
                yield Turns(index, sign > 0, t, covered, d[index] - covered)


def _velocity_zero(low: Floats, high: Floats, phase: Floats, velocity: Floats, sine: Floats, gbar: Floats) -> Floats:
    """Zero of a monotone Z' between two times where its sign differs, by Newton's method kept inside the bracket."""
    low, high = low.copy(), high.copy()
    rising = flight.velocity(high, velocity, sine, np.sin(phase + np.pi * high), gbar) > 0
    t = (low + high) / 2
    for _ in range(ITERATIONS):
        angle = phase + np.pi * t
        value = flight.velocity(t, velocity, sine, np.sin(angle), gbar)
        upper = (value > 0) == rising
        high = np.where(upper, t, high)
        low = np.where(upper, low, t)
        slope = flight.acceleration(np.cos(angle), gbar)
        step = value / np.where(slope == 0, 1.0, slope)
        done = (np.abs(step) <= SMALLEST_STEP * np.maximum(t, 1.0)) & (slope != 0)
        if done.all():
            break
        inside = (t - step > low) & (t - step < high) & (slope != 0)
        t = np.where(done, t, np.where(inside, t - step, (low + high) / 2))
    return t
