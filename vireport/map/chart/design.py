"""The design point in the plane of a chart: what is stable there, and how far it is from the ends of that."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from msgspec import Struct

from vireport.design import margins
from vireport.design.followed import followed_motion
from vireport.design.lines import line_of, reach
from vireport.design.point import motions_at
from vireport.map.chart.plane import Plane
from vireport.map.chart.regions import PIXELS, ROOM, StableMotion, stable_motions
from vireport.motions.events import Event
from vireport.motions.switching import Limits
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter

BEYOND = 2 * ROOM / PIXELS
"""Share of a range beyond the end of a motion at which it is told what is stable there."""


class ChartMargin(Struct, frozen=True, eq=False):
    """How far a design point is, one way along one input of a chart, from where its motion ends or another takes over.

    Attributes
    ----------
    varied : int
        Which of the two inputs.
    event : Event
        What happens there.
    value, distance : float
        Of the input there, and less that of the design point, in its unit.
    error_bound : float or None
        Of the value; None where it is not known.
    taken_over : bool
        Whether another motion takes over the stability there.
    beyond : tuple of StableMotion or None
        All that are stable next to it on the other side, in the chart or beyond its edge; None where rounding does not
        resolve motions.
    """

    varied: int
    event: Event
    value: float
    distance: float
    error_bound: float | None
    taken_over: bool
    beyond: tuple[StableMotion, ...] | None

    @property
    def relative(self) -> float | None:
        """The distance over the design value; None where that is zero."""
        value = self.value - self.distance
        return self.distance / value if value else None


class ChartedDesign(Struct, frozen=True, eq=False):
    """The design point of a scenario in the plane of a chart.

    Attributes
    ----------
    inputs : tuple of float
        Its values of both.
    motions : tuple of StableMotion or None
        All that are stable there within the limits, 1:1 motions first; None where rounding does not resolve motions.
    margins : tuple of ChartMargin
        Of the first of them, or of all 1:1 motions: the nearest along each input and either way, where there is one.
    """

    inputs: tuple[float, float]
    motions: tuple[StableMotion, ...] | None
    margins: tuple[ChartMargin, ...]

    def along(self, varied: int) -> tuple[ChartMargin, ...]:
        """The margins along one of the inputs, that below the design point first."""
        return tuple(sorted((each for each in self.margins if each.varied == varied), key=lambda each: each.distance))

    def nearest(self, varied: int) -> ChartMargin | None:
        """The smallest margin along one of the inputs."""
        return min(self.along(varied), key=lambda each: abs(each.distance), default=None)


class End(NamedTuple):
    """Where a motion ends along one of the inputs; see `ChartMargin`."""

    varied: int
    event: Event
    value: float
    error_bound: float | None = None
    taken_over: bool = False


def charted_design(device: Device, plane: Plane, limits: Limits) -> ChartedDesign | None:
    """Find what is stable at a device in the plane, and its margins; None where it has no place there.

    Parameters
    ----------
    device : Device
        Of the scenario.
    plane : Plane
    limits : Limits
        Of the motions.
    """
    values = [device.value_of(varied) for varied in plane.inputs]
    if any(value is None for value in values):
        return None
    x, y = map(float, values)
    if plane.room(np.array([x, y])) < 0:
        return None
    motions = stable_motions(plane, (x, y), limits)
    ends = _ends(device, plane, motions[0]) if motions else []
    nearest: dict[tuple[int, bool], End] = {}
    for end in sorted(ends, key=lambda end: abs(end.value - (x, y)[end.varied])):
        nearest.setdefault((end.varied, end.value > (x, y)[end.varied]), end)
    return ChartedDesign(
        (x, y), motions, tuple(_margin(device, plane, (x, y), end, limits) for end in nearest.values())
    )


def _margin(device: Device, plane: Plane, at: tuple[float, float], end: End, limits: Limits) -> ChartMargin:
    """The margin to the end of a motion, with what is stable beyond."""
    k, distance = end.varied, end.value - at[end.varied]
    limit = reach(device, plane.inputs[k])[distance > 0]
    end_point = np.array(at)
    end_point[k] = end.value + np.sign(distance) * min(BEYOND * plane.widths[k], abs(limit - end.value) / 2)
    beyond = stable_motions(plane, (float(end_point[0]), float(end_point[1])), limits)
    return ChartMargin(k, end.event, end.value, distance, end.error_bound, end.taken_over, beyond)


def _ends(device: Device, plane: Plane, stable: StableMotion) -> list[End]:
    """Where the motions like a stable one end."""
    if not stable.one_to_one or stable.word.periods != device.period_ratio:
        followed = ((k, followed_motion(device, stable.motion, varied)) for k, varied in enumerate(plane.inputs))
        pairs = (
            (k, *end)
            for k, ending in followed
            if ending
            for end in ((ending.below, ending.low), (ending.above, ending.high))
        )
        return [End(k, event, value) for k, event, value in pairs if event not in (Event.SWEEP_END, Event.LOST)]
    motions, *_ = motions_at(device, Parameter.LENGTH)
    lines = list(dict.fromkeys(line_of(varied, device) for varied in plane.inputs))
    return [
        End(plane.inputs.index(each.parameter), each.event, each.sweep_value, each.error_bound, each.taken_over)
        for each in margins.margins_of(device, motions, lines).margins
        if each.parameter in plane.inputs
    ]
