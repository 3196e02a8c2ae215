"""The design point of a map: its place over the axes, what a run says of it, and where its motion ends along them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from msgspec import Struct

from vireport.motions.events import Event
from vireport.study.judging.alerts import Alert
from vireport.study.study import Study
from vireport.text.formatting import OF_A_MODEL, Exactness


class MapMargin(Struct, frozen=True, eq=False):
    """How far a design point is, one way along one axis of a map, from where its motion ends or another takes over.

    Attributes
    ----------
    axis : int
    event : Event
        What happens there.
    value, distance : float
        Of the input there, and less that of the design point, in its unit.
    error_bound : float or None
        Of the value; None where it is not known.
    taken_over : bool
        Whether another motion takes over the stability there.
    """

    axis: int
    event: Event
    value: float
    distance: float
    error_bound: float | None
    taken_over: bool

    @property
    def relative(self) -> float | None:
        """The distance over the design value; None where that is zero."""
        value = self.value - self.distance
        return self.distance / value if value else None


AnyMargin = TypeVar("AnyMargin", bound=MapMargin)


def nearest_either_way(margins: Iterable[AnyMargin]) -> tuple[AnyMargin, ...]:
    """The nearest margins below and above the design point along each axis, in this order."""
    nearest: dict[tuple[int, bool], AnyMargin] = {}
    for margin in sorted(margins, key=lambda margin: abs(margin.distance)):
        nearest.setdefault((margin.axis, margin.distance > 0), margin)
    return tuple(nearest[key] for key in sorted(nearest))


class MapDesign(Struct, frozen=True, eq=False):
    """The design point of a map.

    Attributes
    ----------
    inputs : tuple of float
        Its values along the axes.
    margins : tuple of MapMargin
        Of its stable motions, the nearest either way along each axis.
    study : Study or None
        What a run finds of it; None where a run ends without results.
    inside : bool
        Whether its values are within the ends of all axes.
    """

    inputs: tuple[float, ...]
    margins: tuple[MapMargin, ...]
    study: Study | None = None
    inside: bool = True

    def nearest(self, axis: int) -> MapMargin | None:
        """The smallest margin along an axis."""
        margins = (margin for margin in self.margins if margin.axis == axis)
        return min(margins, key=lambda margin: abs(margin.distance), default=None)


def alerts_of(design: MapDesign | None) -> tuple[Alert, ...]:
    """What must be known of a design point, as a run says it."""
    return () if design is None or design.study is None else design.study.alerts


def exactness_of(design: MapDesign | None) -> Exactness:
    """How exact the numbers of a map are: as those of the run of its design point."""
    return OF_A_MODEL if design is None or design.study is None else design.study.evidence.exactness
