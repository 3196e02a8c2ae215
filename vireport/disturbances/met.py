"""What a ball from rest comes to at values along a sweep, looked at briefly.

Without the compiler, which takes longer to start than all of it. What has not settled after some 500 impacts is not
decided here; `from_rest` goes on.
"""

from __future__ import annotations

import numpy as np
from msgspec import Struct

from vireport.base.records import brief
from vireport.disturbances.from_rest import Destination, FromRest, rested
from vireport.motions.sweep import Sweep
from vireport.physics.groups import Groups
from vireport.simulation.cycles import SimulatedMotion, approached
from vireport.simulation.events import BOTTOM, as_start, check_model, follow_one
from vireport.simulation.kernel import REST, RUNNING
from vireport.simulation.release import presses

VALUES = 21
"""Values along a sweep, its ends among them: 30 to 60 ms for the paper's sweeps, and 150 ms where all is chaotic."""

IMPACTS = 96, 160, 256
"""Impacts after which it is looked whether they nearly repeat, one after another."""


class Met(Struct, frozen=True, eq=False):
    """What a ball from rest comes to at a value of an input.

    Attributes
    ----------
    value : float
        Of the input.
    d : float
        The group d there.
    end : FromRest
        Not decided where it has not settled.
    """

    value: float
    d: float
    end: FromRest

    __repr__ = brief

    @property
    def motion(self) -> SimulatedMotion | None:
        """The periodic motion without rests that it comes to."""
        return self.end.cycle if self.end.is_motion else None


def met_along(sweep: Sweep) -> tuple[Met, ...]:
    """What a ball comes to that lies on the bottom membrane when the force sets in, at values along a sweep.

    Parameters
    ----------
    sweep : Sweep

    Returns
    -------
    tuple of Met
        Ascending.
    """
    values = np.linspace(min(sweep.start, sweep.end), max(sweep.start, sweep.end), VALUES).tolist()
    each = (sweep.device.groups(sweep.parameter, value).as_floats() for value in values)
    ratio = sweep.device.period_ratio
    return tuple(Met(value, groups.d, _met(groups, ratio)) for value, groups in zip(values, each, strict=True))


def _met(groups: Groups[float], ratio: int) -> FromRest:
    """What it comes to where it is pressed down at first."""
    releases = presses(groups)
    return _ending(groups, releases[0].release, ratio) if releases else FromRest(Destination.AT_REST)


def _ending(groups: Groups[float], phase: float, ratio: int) -> FromRest:
    """What it comes to that the bottom membrane releases at a phase."""
    model, start, released = check_model(groups)[0], (float(BOTTOM), 0.0, 0.0, phase), True
    for impacts in IMPACTS:
        rows, status = follow_one(model, start, impacts, compiled=False)
        if status[2] != RUNNING:
            return FromRest(Destination.AT_REST if status[2] == REST else Destination.UNDECIDED)
        if (known := rested(model, rows, released, compiled=False)) is not None:
            return known[0]
        cycle = approached(model, rows, compiled=False)
        if cycle is not None and cycle.growth < 1:
            one_to_one = (cycle.word, cycle.period) == ("BT", ratio)
            moving = Destination.ONE_TO_ONE if one_to_one else Destination.OTHER_MOTION
            kind = Destination.REST_CYCLE if cycle.sticks else moving
            return FromRest(kind, cycle.word, cycle.period, cycle=cycle)
        start, released = as_start(rows[-1]), False
    return FromRest(Destination.UNDECIDED)
