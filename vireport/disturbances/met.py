"""The periodic motions that a ball from rest comes to, at values along a sweep: the circles of the paper's figures.

Simulated without the compiler, which takes longer to start than all of it.
"""

from __future__ import annotations

import numpy as np
from msgspec import Struct

from vireport.base import brief
from vireport.disturbances.from_rest import presses
from vireport.motions import Sweep
from vireport.physics import Groups
from vireport.simulation import BOTTOM, RUNNING, Cycle, approached, as_start, check_model, follow_one

VALUES = 21
"""Values along a sweep, its ends among them: 30 to 60 ms for the paper's sweeps, and 150 ms where all is chaotic."""

IMPACTS = 96, 160, 256
"""Impacts after which it is looked whether they nearly repeat, one after another."""


class Met(Struct, frozen=True, eq=False):
    """A periodic motion that a ball from rest comes to.

    Attributes
    ----------
    value : float
        Of the swept parameter.
    d : float
        The group d there.
    cycle : Cycle
        It attracts, and has no rests.
    """

    value: float
    d: float
    cycle: Cycle

    __repr__ = brief


def met_along(sweep: Sweep) -> tuple[Met, ...]:
    """The periodic motions that a ball comes to that lies on the bottom membrane when the force sets in.

    Parameters
    ----------
    sweep : Sweep

    Returns
    -------
    tuple of Met
        In the order of the sweep. There is none at a value where the ball stays at rest or comes to rest again and
        again, or comes to nothing periodic within some 500 impacts.
    """
    found = []
    for value in np.linspace(sweep.start, sweep.end, VALUES).tolist():
        groups = sweep.device.groups(sweep.parameter, value).as_floats()
        cycle = _met(groups)
        if cycle is not None:
            found.append(Met(value, groups.d, cycle))
    return tuple(found)


def _met(groups: Groups[float]) -> Cycle | None:
    releases = presses(groups)
    if not releases:
        return None
    model, start = check_model(groups)[0], (float(BOTTOM), 0.0, 0.0, releases[0].release)
    for impacts in IMPACTS:
        rows, status = follow_one(model, start, impacts, compiled=False)
        if status[2] != RUNNING:
            return None
        cycle = approached(model, rows, compiled=False)
        if cycle is not None and cycle.growth < 1:
            return None if cycle.sticks else cycle
        start = as_start(rows[-1])
    return None
