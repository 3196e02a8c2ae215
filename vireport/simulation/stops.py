"""The ways of a ball with friction between two impacts: it stops, turns or is held, and is let go.

The search of `kernel` gives impacts only; what is drawn, and how an impact depends on the one before, needs the ways
between. They are found anew, by the search's own steps.
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

WAYS_EACH = 4
"""Ways between two impacts for which there is room at first."""


class Way(NamedTuple):
    """A part of a flight on which Z' keeps its sign.

    Attributes
    ----------
    sign : float
        Of Z'; 0 where friction holds the ball.
    time : float
        That it takes [t_c].
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


class _Searched(NamedTuple):
    """What the search takes of a device, see `search_data`."""

    groups: Groups[float]
    plain: Array
    harmonics: Array
    still: Array

    @staticmethod
    def of(model: Array) -> _Searched:
        """That of a row of `check_model`."""
        return _Searched(groups_of(model), *(part[0] for part in search_data(model[None])))


def ways(model: Array, before: Array, position: float = 0.0) -> Iterator[Way]:
    """The ways from one impact to the next, of a row of `check_model` and a row of impacts, see `kernel`.

    Where the row is a start in flight, from its position [x_c] to the first impact: without end, if there is none.
    """
    return _ways(_Searched.of(model), before, position)


def _ways(searched: _Searched, before: Array, position: float = 0.0) -> Iterator[Way]:
    """`ways` of a device whose search is prepared, which takes ten times as long as a way."""
    groups, plain, harmonics, still = searched
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
                sign, velocity, phase, plain, harmonics, parts, still, ends
            )
            yield Way(sign, float(time), *begun, float(velocity))
            gone, sign = gone + covered, onward


def moved_on(model: Array, before: Array, position: float, left: float) -> tuple[float, float]:
    """Position [x_c] and velocity [y_c] of a ball with friction a time after an impact or a start in flight.

    Parameters are those of `ways`, and that time [t_c], which is before the next impact.
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
    """Time since the release, distance from the membrane left and velocity of a ball between two impacts, to draw it.

    Parameters are those of `ways`, and how many points each way has.
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

    Where the ball was held on the way they are of rank one.

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
    searched = _Searched.of(model)
    r = np.where(before[:, WALL] > 0, *(searched.groups.restitution_at(wall) for wall in (BOTTOM, TOP)))
    passed, ends = _after_each(searched, before, r, compiled)
    matrices = _onward(searched.groups, passed, ends)
    moved = np.zeros((len(before), 3, 2))  # position, velocity and phase, just after the impact
    moved[:, 1, 1], moved[:, 2, 0] = -r, 1.0
    begins = np.concatenate([[0], ends[:-1]])
    for k in range(int((ends - begins).max(initial=0))):
        more = begins + k < ends
        moved[more] = matrices[begins[more] + k] @ moved[more]
    return np.asarray(moved[:, [2, 1]])


def _after_each(searched: _Searched, before: Array, r: Array, compiled: bool) -> tuple[Array, NDArray[np.intp]]:
    """The ways after some impacts, with the fields of `Way` as columns, and how many there are up to each next one.

    `r` are the restitutions. The ball is not held after any of the impacts.
    """
    d, wall = searched.groups.d, before[:, WALL]
    phase = [kernel.turned(place) for place in before[:, PHASE].tolist()]
    begun = np.column_stack([-wall, -r * before[:, VELOCITY], phase])
    walls = np.where(wall[:, None] > 0, (-d, 0.0), (0.0, d))
    follow = (compiled_ways() if compiled else None) or kernel.follow_ways
    ends, room = np.zeros(len(before), dtype=np.intp), WAYS_EACH * (len(before) + 1)
    while True:
        passed = np.empty((room, len(Way._fields)))
        with np.errstate(all="ignore"):  # as in the search for impacts
            if follow(begun, walls, searched.plain, searched.harmonics, searched.still, passed, ends):
                return passed[: int(ends[-1]) if len(ends) else 0], ends
        room *= 4


def _onward(groups: Groups[float], passed: Array, ends: NDArray[np.intp]) -> Array:
    """How position, velocity and phase at the end of each way move with those at its beginning, (n, 3, 3)."""
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
    # The end comes at another time: on a wall where Z does, else where Z' is zero.
    pull = groups.pull(now.force, sign)
    ending = np.where(strikes[:, None], free[:, 0], free[:, 1])
    later = -ending / np.where(strikes, end, pull)[:, None]
    moved = free + np.stack([end, pull, np.full_like(end, pi)], axis=-1)[:, :, None] * later[:, None, :]
    # Let go at a phase of the force alone, at rest: only the place is kept.
    moved[sign == 0] = np.diag([1.0, 0.0, 0.0])
    return np.asarray(moved)
