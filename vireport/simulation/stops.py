"""The ways of a ball with friction between two impacts, from stop to stop.

With dry friction the flight between two impacts is piecewise smooth: the ball slips one way, stops, and turns or is
held until the force lets it go. Each such piece is a way, on which the sign of Z' is constant. The search of `kernel`
gives impacts only; a path that is drawn, and the derivative of an impact by the one before (over all stops between,
by saltation), needs the ways. They are computed again, by the steps of the search.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vireport.physics.groups import Groups
from vireport.physics.numbers import ARRAYS
from vireport.simulation import kernel
from vireport.simulation.compiled import compiled_ways
from vireport.simulation.events import BOTTOM, TOP, groups_of, search_data
from vireport.simulation.kernel import PHASE, RIDING, SETTLING, VELOCITY, WALL

Array = NDArray[np.float64]

WAYS_PER_FLIGHT = 4
"""Rows for the ways of one flight with which the arrays begin; they grow where a ball stops more often."""


class Way(NamedTuple):
    """A part of a flight with friction on which Z' keeps its sign, or on which the ball is held.

    Attributes
    ----------
    sign : float
        Sign of Z'; 0 where friction holds the ball.
    time : float
        Duration [t_c].
    phase : float
        Forcing phase at its beginning [rad].
    velocity, end : float
        Z' at its beginning and at its end [y_c].
    """

    sign: float
    time: float
    phase: float
    velocity: float
    end: float


class _SearchedDevice(NamedTuple):
    """A device with friction as the event search takes it: its groups, and the arrays of `search_data`."""

    groups: Groups[float]
    plain: Array
    harmonics: Array
    zeros: Array

    @staticmethod
    def of(model: Array) -> _SearchedDevice:
        """The device of a row of `check_model`."""
        return _SearchedDevice(groups_of(model), *(part[0] for part in search_data(model[None])))


def ways(model: Array, before: Array, position: float = 0.0) -> Iterator[Way]:
    """The ways of a ball from one impact to the next.

    Parameters
    ----------
    model : array (6 + 3 h + 1,)
        A row of `check_model`, with friction.
    before : array (6,)
        The impact that they begin with, a row of `kernel`, or a start in flight.
    position : float
        Position of a start in flight [x_c].

    Yields
    ------
    Way
        Ways up to the next impact; without end if there is none.
    """
    groups, plain, harmonics, zeros = _SearchedDevice.of(model)
    wall, held = float(before[WALL]), float(before[SETTLING] + before[RIDING])
    phase, gone = kernel.turned(float(before[PHASE]) + pi * held), 0.0
    if wall:
        velocity, sign = 0.0 if held else float(groups.after(int(wall), before[VELOCITY])), -wall
        walls = (-groups.d, 0.0) if wall > 0 else (0.0, groups.d)
    else:
        velocity, walls = float(before[VELOCITY]), (-groups.d / 2 - position, groups.d / 2 - position)
        sign = kernel.begins(velocity, phase, plain, harmonics)
    parts, strikes = np.empty((len(harmonics), 3)), 0.0
    with np.errstate(all="ignore"):
        while not strikes:
            ends = walls[0] - gone, walls[1] - gone
            begun = phase, velocity
            time, covered, velocity, phase, strikes, onward, _ = kernel.next_way(
                sign, velocity, phase, plain, harmonics, parts, zeros, ends
            )
            yield Way(sign, float(time), *begun, float(velocity))
            gone, sign = gone + covered, onward


def moved_on(model: Array, before: Array, position: float, left: float) -> tuple[float, float]:
    """Position [x_c] and velocity [y_c] of a ball with friction a time after an impact or a start in flight.

    Parameters
    ----------
    model, before, position
        As of `ways`.
    left : float
        The time [t_c], which ends before the next impact.
    """
    groups = groups_of(model)
    wall, held = float(before[WALL]), float(before[SETTLING] + before[RIDING])
    place, left = (wall * groups.d / 2 if wall else position), left - held
    for way in ways(model, before, position):
        t, sign = min(left, way.time), int(way.sign)
        begun, now = groups.wave(way.phase, ARRAYS), groups.wave(way.phase + pi * t, ARRAYS)
        if not sign:
            t = 0.0
        covered, speed = groups.flown(t, way.velocity, begun, now, sign) if sign else (0.0, 0.0)
        place += float(covered)
        if left <= way.time:
            return place, float(speed)
        left -= way.time
    return place, 0.0


def path_between(model: Array, before: Array, samples: int) -> tuple[Array, Array, Array]:
    """Sample the path of a ball with friction between two impacts.

    Parameters
    ----------
    model, before
        As of `ways`.
    samples : int
        Points on each way, its two ends included.

    Returns
    -------
    time, position, velocity : array
        Time since the release [t_c], Z less that of the membrane left [x_c], and Z' [y_c].
    """
    groups, clock, place = groups_of(model), 0.0, 0.0
    pieces = []
    for way in ways(model, before):
        t = np.linspace(0.0, way.time, samples)
        begun, now = groups.wave(way.phase, ARRAYS), groups.wave(way.phase + pi * t, ARRAYS)
        sign = int(way.sign)
        covered, speed = (state * abs(sign) for state in groups.flown(t, way.velocity, begun, now, sign))
        pieces.append((clock + t, place + covered, speed))
        clock, place = clock + way.time, place + float(covered[-1])
    time, position, velocity = (np.concatenate(column) for column in zip(*pieces, strict=True))
    return time, position, velocity


def jacobians(model: Array, before: Array, compiled: bool = False) -> Array:
    """Exact derivatives of impacts by those before, in (phase, velocity before the impact), over all stops between.

    The derivative of each way is that of its smooth flow, corrected for the change of its duration (the saltation
    matrix); they are multiplied. Where the ball was held on the way the product is of rank one, as it forgets.

    Parameters
    ----------
    model : array
        A row of `check_model`, with friction.
    before : array (n, 6)
        The impacts before, after none of which the ball is held.
    compiled : bool
        Whether to compile the search for the stops, where numba is there.

    Returns
    -------
    array (n, 2, 2)
    """
    searched = _SearchedDevice.of(model)
    r = np.where(before[:, WALL] > 0, *(searched.groups.restitution_at(wall) for wall in (BOTTOM, TOP)))
    passed, ends = _ways_after(searched, before, r, compiled)
    matrices = _way_derivatives(searched.groups, passed, ends)
    moved = np.zeros((len(before), 3, 2))  # position, velocity and phase, just after the impact
    moved[:, 1, 1], moved[:, 2, 0] = -r, 1.0
    begins = np.concatenate([[0], ends[:-1]])
    # Way k of all flights at once, of those that have as many.
    for k in range(int((ends - begins).max(initial=0))):
        more = begins + k < ends
        moved[more] = matrices[begins[more] + k] @ moved[more]
    return np.asarray(moved[:, [2, 1]])


def _ways_after(searched: _SearchedDevice, before: Array, r: Array, compiled: bool) -> tuple[Array, NDArray[np.intp]]:
    """The ways of many flights, one after the other.

    Parameters
    ----------
    searched : _SearchedDevice
    before : array (n, 6)
        The impacts with which the flights begin, after none of which the ball is held.
    r : array (n,)
        Their restitutions.
    compiled : bool

    Returns
    -------
    array (m, 5)
        The fields of `Way` as columns.
    array of int (n,)
        Row at which the ways of each flight end.
    """
    d, wall = searched.groups.d, before[:, WALL]
    phase = [kernel.turned(place) for place in before[:, PHASE].tolist()]
    begun = np.column_stack([-wall, -r * before[:, VELOCITY], phase])
    walls = np.where(wall[:, None] > 0, (-d, 0.0), (0.0, d))
    follow = (compiled_ways() if compiled else None) or kernel.follow_ways
    ends, room = np.zeros(len(before), dtype=np.intp), WAYS_PER_FLIGHT * (len(before) + 1)
    while True:
        passed = np.empty((room, len(Way._fields)))
        with np.errstate(all="ignore"):  # as in the search for impacts
            if follow(begun, walls, searched.plain, searched.harmonics, searched.zeros, passed, ends):
                return passed[: int(ends[-1]) if len(ends) else 0], ends
        room *= 4


def _way_derivatives(groups: Groups[float], passed: Array, ends: NDArray[np.intp]) -> Array:
    """Derivatives of position, velocity and phase at the end of each way by those at its beginning, (m, 3, 3)."""
    sign, time, phase, _, end = passed.T
    strikes = np.zeros(len(passed), dtype=bool)
    strikes[ends - 1] = True
    begun, now = groups.wave(phase, ARRAYS), groups.wave(phase + pi * time, ARRAYS)
    # At the same time as before: position by velocity and by phase, velocity by phase.
    free = np.zeros((len(time), 3, 3))
    free[:, [0, 1, 2], [0, 1, 2]] = 1.0
    free[:, 0, 1] = time
    free[:, 0, 2] = (now.impulse - begun.impulse) / pi**2 - begun.force * time / pi
    free[:, 1, 2] = (now.force - begun.force) / pi
    # Saltation: a way ends at another time for a neighbour, on a wall by its Z, at a stop by its Z'.
    pull = groups.pull(now.force, sign)
    ending = np.where(strikes[:, None], free[:, 0], free[:, 1])
    later = -ending / np.where(strikes, end, pull)[:, None]
    moved = free + np.stack([end, pull, np.full_like(end, pi)], axis=-1)[:, :, None] * later[:, None, :]
    # A held ball is let go at a phase of the force alone, at rest: only the place is kept.
    moved[sign == 0] = np.diag([1.0, 0.0, 0.0])
    return np.asarray(moved)
