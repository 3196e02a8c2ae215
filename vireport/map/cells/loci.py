"""Curves on a map along which 1:1 motions change: where they double, meet, graze or turn from node to focus."""

from __future__ import annotations

import numpy as np
from msgspec import Struct

from vireport.design.plane import Plane
from vireport.map.cells.cells import Floats, MapPlan
from vireport.map.chart.chart import loci_over
from vireport.map.chart.plane import DevicePlane
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.sweep import Sweep
from vireport.motions.switching import Limits
from vireport.physics.device import RESTITUTIONS
from vireport.scenario.parameters import DRIVING, DesignInput


class DrawnLocus(Struct, frozen=True, eq=False):
    """A curve in the plane of a map's two axes, (n, 2), and what happens on it."""

    event: Event
    points: Floats


def loci_of(plan: MapPlan, plane: Plane) -> tuple[DrawnLocus, ...]:
    """Every curve on a map over two parameters, of a grid.

    The ball's mass has no part in the motions: over it, curves are straight.
    """
    low, high = plane.low, plane.high
    at = {name: value for name, value in zip(plan.names, low.tolist(), strict=True) if name != "ball_mass_kg"}
    device = plan.device.with_values(at)
    first, second = plane.inputs
    if isinstance(first, DesignInput) and isinstance(second, DesignInput):
        if DesignInput.RESTITUTION in plane.inputs and first in RESTITUTIONS and second in RESTITUTIONS:
            return ()  # the inputs overlap: a restitution of both is no place beside that of one
        drawn = loci_over(DevicePlane((first, second), low, high, device), Limits(2, device.period_ratio), cuts=0)
        return tuple(DrawnLocus(locus.event, locus.drawn()) for locus in drawn.loci)
    k = int(isinstance(first, DesignInput))
    parameter = next((varied for varied in DRIVING if varied.value == plan.names[1 - k]), None)
    if parameter is None:
        return ()
    sweep = Sweep(device, parameter, float(low[1 - k]), float(high[1 - k]))
    values = ((point.event, point.sweep_value) for point in solve(sweep).critical_points)
    lines = ((event, np.insert(np.full((2, 1), value), k, (low[k], high[k]), axis=1)) for event, value in values)
    return tuple(DrawnLocus(event, points) for event, points in lines)
