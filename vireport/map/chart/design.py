"""The design point in the plane of a chart: which motions are stable there, and how far away these end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from msgspec.structs import asdict

from vireport.design.followed import followed_motion
from vireport.design.lines import line_of, reach
from vireport.design.margins import margins_of
from vireport.design.point import motions_at
from vireport.map.chart.plane import DevicePlane
from vireport.map.chart.regions import PIXELS, ROOM, StableMotion, stable_motions
from vireport.map.design import MapDesign, MapMargin, nearest_either_way
from vireport.motions.events import Event
from vireport.motions.switching import Limits
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter

BEYOND = 2 * ROOM / PIXELS
"""Share of a range beyond the end of a motion at which it is told what is stable there."""


class ChartMargin(MapMargin, frozen=True, eq=False):
    """A margin of the design point of a chart.

    Attributes
    ----------
    beyond : tuple of StableMotion or None
        All that are stable next to it on the other side, in the chart or beyond its edge; None where rounding does not
        resolve motions.
    """

    beyond: tuple[StableMotion, ...] | None


class ChartedDesign(MapDesign, frozen=True, eq=False, kw_only=True):
    """The design point of a scenario in the plane of a chart.

    Attributes
    ----------
    motions : tuple of StableMotion or None
        All that are stable there within the limits, 1:1 motions first; None where rounding does not resolve motions.
    margins : tuple of ChartMargin
        Of the first of them, or of all 1:1 motions: the nearest along each input and either way, where there is one.
    """

    motions: tuple[StableMotion, ...] | None
    margins: tuple[ChartMargin, ...]


def charted_design(device: Device, plane: DevicePlane, limits: Limits) -> ChartedDesign | None:
    """Find what is stable at a device in the plane, and its margins; None where it has no place there.

    Parameters
    ----------
    device : Device
        Of the scenario.
    plane : DevicePlane
    limits : Limits
        Of the motions.
    """
    values = [device.value_of(varied) for varied in plane.inputs]
    if any(value is None for value in values):
        return None
    x, y = map(float, values)
    if plane.room((x, y)) < 0:
        return None
    motions = stable_motions(plane, (x, y), limits)
    ends = _ends(device, plane, (x, y), motions[0]) if motions else ()
    margins_there = tuple(_with_beyond(device, plane, (x, y), end, limits) for end in nearest_either_way(ends))
    return ChartedDesign(inputs=(x, y), motions=motions, margins=margins_there)


def _with_beyond(
    device: Device, plane: DevicePlane, at: tuple[float, float], end: MapMargin, limits: Limits
) -> ChartMargin:
    """A margin with what is stable beyond it."""
    k, past = end.axis, np.array(at)
    limit = reach(device, plane.inputs[k])[end.distance > 0]
    past[k] = end.value + np.sign(end.distance) * min(BEYOND * plane.widths[k], abs(limit - end.value) / 2)
    return ChartMargin(**asdict(end), beyond=stable_motions(plane, (float(past[0]), float(past[1])), limits))


def _ends(device: Device, plane: DevicePlane, at: tuple[float, float], stable: StableMotion) -> Iterator[MapMargin]:
    """Where the motions like a stable one end."""
    if not stable.one_to_one or stable.word.periods != device.period_ratio:
        for k, varied in enumerate(plane.inputs):
            ending = followed_motion(device, stable.motion, varied)
            for event, value in ((ending.below, ending.low), (ending.above, ending.high)) if ending else ():
                if event not in (Event.SWEEP_END, Event.LOST):
                    yield MapMargin(k, event, value, value - at[k], None, False)
        return
    motions, *_ = motions_at(device, Parameter.LENGTH)
    lines = list(dict.fromkeys(line_of(varied, device) for varied in plane.inputs))
    for margin in margins_of(device, motions, lines).margins:
        if margin.parameter in plane.inputs:
            k, value = plane.inputs.index(margin.parameter), margin.sweep_value
            yield MapMargin(k, margin.event, value, value - at[k], margin.error_bound, margin.taken_over)
