"""Simulated motions at single values of the swept parameter, in full: what figures 3 and 6 show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vireport.physics import Device
from vireport.scenario import Parameter
from vireport.simulation.attractors import Attractor, attractors
from vireport.simulation.events import BOTTOM, Impact
from vireport.simulation.trajectories import path, simulate

Floats = NDArray[np.float64]

PERIODS_SHOWN = 2
"""Periods of a periodic motion that are shown."""

IMPACTS_SHOWN = 12
"""Impacts of a motion that is not periodic."""

SETTLE = 2000
"""Impacts left out before a motion that is not periodic is shown."""


@dataclass(frozen=True, slots=True, eq=False)
class Portrait:
    """A simulated motion in full.

    Attributes
    ----------
    parameter : str
        The swept one.
    value : float
        Its value.
    d, gbar, r : float
        The groups, and the restitution.
    attractor : Attractor
        What the motion is.
    phase : float
        Forcing phase at time zero, at an impact on the bottom where there is one [rad].
    time, position, velocity : ndarray
        Dimensionless; the velocity jumps where a time occurs twice.
    """

    parameter: Parameter
    value: float
    d: float
    gbar: float
    r: float
    attractor: Attractor
    phase: float
    time: Floats
    position: Floats
    velocity: Floats


def portrait(device: Device, parameter: Parameter, value: float, starts: Sequence[Impact]) -> Portrait:
    """Simulate until it is known what the first start leads to that leads to a periodic motion, and follow that."""
    d, gbar = (float(x) for x in device.groups(parameter, value))
    r = float(device.restitution)
    found = attractors([d], gbar, r, starts)[0]
    best = next((one for one in found if one.cycle is not None and not one.cycle.sticks), found[0])
    if best.cycle is not None and not best.cycle.sticks:
        first = int(np.argmax(best.cycle.wall == BOTTOM))
        wall = int(best.cycle.wall[first])
        start = Impact(wall, float(best.cycle.velocity[first]), float(best.cycle.phase[first]))
        count = PERIODS_SHOWN * len(best.cycle.wall)
    else:
        settled = simulate(d, gbar, r, starts[0], SETTLE)
        count = IMPACTS_SHOWN
        start = starts[0]
        if len(settled.wall):
            start = Impact(int(settled.wall[-1]), float(settled.velocity[-1]), float(settled.phase[-1]))
    time, position, velocity = path(simulate(d, gbar, r, start, count))
    return Portrait(parameter, value, d, gbar, r, best, start.phase, time, position, velocity)
