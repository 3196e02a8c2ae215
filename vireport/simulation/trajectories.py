"""Paths of simulated motions between their impacts, and the portraits of motions that are drawn from them.

It turns groups and impacts into paths. It shares the closed-form flight and the impact law with the analytic solution
and nothing else, so that an agreement of both is evidence.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.physics.forcing import Harmonic, wave
from vireport.physics.groups import Groups
from vireport.simulation.attractors import Attractor, attractors
from vireport.simulation.events import (
    BOTTOM,
    Impact,
    Start,
    as_start,
    check_model,
    check_start,
    follow_one,
    groups_of,
)
from vireport.simulation.kernel import (
    FLIGHT,
    PHASE,
    RIDING,
    SETTLING,
    VELOCITY,
    WALL,
)
from vireport.simulation.stops import path_between

Array = NDArray[np.float64]

# Periods of a periodic motion in a portrait; impacts of a motion that is not periodic, and of the transient before it.
PORTRAIT_PERIODS, PORTRAIT_IMPACTS, LEFT_OUT = 2, 12, 2000


def path(model: Array, rows: Array, samples: int = 40) -> tuple[Array, Array, Array]:
    """Sample time, position and velocity of a ball between its impacts, by (2.11) and (2.12).

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    rows : array (n, 6)
        Successive impacts, see `kernel`; the path begins at the first.
    samples : int
        Points in each flight, its two ends included. The velocity jumps where a time occurs twice.

    Returns
    -------
    time, position, velocity : array
        In t_c, x_c and y_c.
    """
    groups = groups_of(model)
    clock = 0.0
    pieces = [(np.zeros(0),) * 3]
    for before, after in pairwise(rows):
        # While it settles and rides, the ball is drawn as lying still; it flies from its release on.
        held = before[SETTLING] + before[RIDING]
        speed = 0.0 if held else groups.after(before[WALL], before[VELOCITY])
        clock, phase = clock + held, before[PHASE] + pi * held
        if groups.friction is not None:
            since, covered, velocity = path_between(model, before, samples)
            pieces.append((clock + since, before[WALL] * groups.d / 2 + covered, velocity))
            clock += after[FLIGHT]
            continue
        t = np.linspace(0.0, after[FLIGHT], samples)
        begun, now = (wave(np.sin(x), np.cos(x), groups.harmonics) for x in (phase, phase + pi * t))
        covered, velocity = groups.flown(t, speed, begun, now)
        pieces.append((clock + t, before[WALL] * groups.d / 2 + covered, velocity))
        clock += after[FLIGHT]
    time, position, velocity = (np.concatenate(column) for column in zip(*pieces, strict=True))
    return time, position, velocity


class Portrait(Struct, frozen=True, eq=False):
    """A simulated motion with its path over time.

    Attributes
    ----------
    label : str
        Title of the drawing.
    d, gbar, r : float
        The groups, and the restitution; `Restitutions` where the membranes are not alike.
    attractor : Attractor
        The motion.
    phase : float
        Forcing phase at time zero, at an impact on the bottom where there is one [rad].
    time, position, velocity : ndarray
        Path of the ball [t_c, x_c, y_c]; the velocity jumps where a time occurs twice.
    harmonics : tuple of Harmonic
        Harmonics of the force.
    """

    label: str
    d: float
    gbar: float
    r: Any
    attractor: Attractor
    phase: float
    time: Array
    position: Array
    velocity: Array
    harmonics: tuple[Harmonic, ...] = ()

    __repr__ = brief


def portrait(groups: Groups[float], starts: Sequence[Start], label: str = "", compiled: bool = True) -> Portrait:
    """The portrait of the first periodic motion without rest that a start leads to; else of the first start's motion.

    Parameters
    ----------
    groups : Groups
        Groups of the device, as numbers.
    starts : sequence of Impact or InFlight
        At least one.
    label : str
        See `Portrait`.
    compiled : bool
        Whether to compile the search, where numba is there.
    """
    model, ends = check_model(groups)[0], attractors(groups, starts, compiled=compiled)[0]
    attractor = next((end for end in ends if end.cycle is not None and not end.cycle.sticks), ends[0])
    if attractor.cycle is not None and not attractor.cycle.sticks:
        cycle, first = attractor.cycle, int(np.argmax(attractor.cycle.wall == BOTTOM))
        start = Impact(int(cycle.wall[first]), float(cycle.velocity[first]), float(cycle.phase[first]))
        begin, count = check_start(start, groups.d), PORTRAIT_PERIODS * len(cycle.wall)
    else:
        begin, count = check_start(starts[0], groups.d), PORTRAIT_IMPACTS
        settled, _ = follow_one(model, begin, LEFT_OUT, compiled=compiled)
        if len(settled) > 1:
            begin = as_start(settled[-1])
    rows, _ = follow_one(model, begin, count, compiled=compiled)
    return Portrait(label, *groups[:3], attractor, float(rows[0, PHASE]), *path(model, rows), groups.harmonics)
