"""Whether a solution of the equations is a motion: whether the ball stays between the membranes in its flights.

The periodicity conditions only know the ends of each flight. The extrema between are the zeros of Z', and Z' is
monotone between the zeros of Z'' = gbar + cos(phase), which are known. So every turning point is found for certain,
without sampling.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vireport.motions.orbits import Flight, Orbits
from vireport.motions.roots import newton_root

Floats = NDArray[np.float64]

SMALLEST_STEP = 1e-10
"""Newton step at which a turning point is found: as Z' is zero there, it moves the position by its square only."""


def wall_gap(orbit: Orbits, r: float | Floats, n: int) -> Floats:
    """Smallest distance between the ball and a membrane at the turning points of its flights [x_c].

    Parameters
    ----------
    orbit : Orbits
        Arrays of motions with velocity_bottom > 0 > velocity_top.
    r : float or ndarray
        Restitution coefficient.
    n : int
        Forcing periods per motion.

    Returns
    -------
    ndarray
        Negative where the ball would have to pass through a membrane, zero at grazing, and d where it crosses from
        wall to wall without ever turning back.
    """
    gap = np.array(orbit.d, dtype=float)
    for turn in flight_turns(orbit, r, n, nearest=True):
        np.minimum.at(gap.reshape(-1), turn.index, np.minimum(turn.from_start_wall, turn.from_end_wall))
    return gap


@dataclass(frozen=True, slots=True, eq=False)
class FlightTurns:
    """Turning points of one flight of some of the motions, on one side of where each flight is slowest.

    Attributes
    ----------
    index : ndarray of int
        Which motions of those given; one that turns in several forcing periods is there as often.
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


class Touch(NamedTuple):
    """A turning point near a wall: its distance, its time in the flight, which flight, and which wall."""

    distance: float
    time: float
    upward: bool
    at_start: bool


def touches(orbit: Orbits, r: float, n: int) -> list[Touch]:
    """The turning points of one motion (arrays of length one) with their distance from either wall, nearest first."""
    return sorted(
        Touch(abs(float(distance)), float(time), turn.upward, at_start)
        for turn in flight_turns(orbit, r, n)
        for at_start, gap in ((True, turn.from_start_wall), (False, turn.from_end_wall))
        for distance, time in zip(gap, turn.time, strict=True)
    )


def flight_turns(orbit: Orbits, r: float | Floats, n: int, nearest: bool = False) -> Iterator[FlightTurns]:
    """Every turning point of the motions' flights, or those that can be the `nearest` to a wall.

    Other parameters are those of `wall_gap`.
    """
    up, down = orbit.flights(r)
    yield from _turns(up, orbit.phi, n, nearest)
    yield from _turns(down, np.arctan2(orbit.sin_top, orbit.cos_top), n, nearest)


def _turns(way: Flight, phase: Floats, n: int, nearest: bool) -> Iterator[FlightTurns]:
    """The turning points of one flight of each motion, from the forcing phase at which it begins.

    A flight leaves one wall and arrives at the other with velocities of the same sign, so Z' can only change sign
    in pairs, around an extremum of Z' of the other sign: where Z' is positive at such an extremum of an upward
    flight (or negative in a downward one), there is exactly one zero on either side.
    """
    # Z' is largest at phase `turn`, the wrong way for an upward flight, and smallest at -turn, for a downward one.
    # Where gbar > 1, Z'' never vanishes; then Z' is not of the wrong sign at phase pi either.
    turn = np.arccos(np.clip(-way.gbar, -1.0, 1.0))
    rise, fall = 2 * turn / np.pi, 2 - 2 * turn / np.pi
    since, until = (rise, fall) if way.direction < 0 else (fall, rise)
    first = np.mod(-way.direction * turn - phase, 2 * np.pi) / np.pi
    each = first[:, None] + 2 * np.arange(n + 1)
    index, lap = np.nonzero(each < way.duration[:, None])
    slowest = each[index, lap]
    speed = way.select(index).speed(slowest, np.sin(phase[index] + np.pi * slowest))
    wrong = speed < 0
    index, middle, speed = index[wrong], slowest[wrong], speed[wrong]
    if nearest and n > 1:
        near = _may_be_nearest(way, phase, index, middle, -speed * np.maximum(since, until)[index])
        index, middle = index[near], middle[near]
    if not index.size:
        return
    part, start = way.select(index), phase[index]
    before = np.maximum(middle - since[index], 0.0)
    after = np.minimum(middle + until[index], part.duration)
    for low, high in ((before, middle), (middle, after)):
        t = _at_rest(part, start, low, high)
        covered = part.covered(t, np.cos(start + np.pi * t))
        yield FlightTurns(index, way.direction < 0, t, covered, part.d - covered)


def _may_be_nearest(
    way: Flight, phase: Floats, index: NDArray[np.intp], middle: Floats, reach: Floats
) -> NDArray[np.bool_]:
    """Which times of slowest flight have next to them the turning point that is nearest to a wall, or may have it.

    One of the two turning points is nearer to a wall than the ball is in the middle between them, but by no more than
    what it flies back from there: `reach`, its speed there times the time that it has.
    """
    part = way.select(index)
    covered = part.covered(middle, np.cos(phase[index] + np.pi * middle))
    room = np.minimum(covered, part.d - covered)
    least = np.full(len(phase), np.inf)
    np.minimum.at(least, index, room)
    return np.asarray(room - reach <= least[index])


def _at_rest(way: Flight, phase: Floats, low: Floats, high: Floats) -> Floats:
    """Zero of a monotone Z' between two times where its sign differs."""

    def speed(t: Floats, which: NDArray[np.intp]) -> tuple[Floats, Floats]:
        part = way if t.size == phase.size else way.select(which)
        angle = phase[which] + np.pi * t
        return part.speed(t, np.sin(angle)), part.pressing(np.cos(angle))

    rising = way.speed(high, np.sin(phase + np.pi * high)) > 0
    return newton_root(speed, low, high, rising, SMALLEST_STEP)
