"""The points of codimension two of a chart as a table."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite

from vireport.chart.chart import Chart
from vireport.chart.meetings import Meeting
from vireport.motions.events import Event
from vireport.scenario.parameters import DesignInput
from vireport.text.formatting import bounded, error_bound, exact
from vireport.text.tables import Table, numbers, texts

SHOWN = 1e-8
"""Relative error below which no digit of a point is printed on a terminal."""

NOTE = (
    "Two grazings: two touches in one motion. Degenerate grazing: period doublings and folds of the motion with the "
    "further impact begin. Cusp: two curves of folds end together. Degenerate period doubling: it changes from soft "
    "to hard, and a curve of folds begins."
)


def shown_points(chart: Chart) -> Table:
    """The points of codimension two, to the digits that are justified, and to eight at the most."""
    rows = (
        [bounded(x, max(bound, SHOWN * abs(x)) if isfinite(bound) else SHOWN * abs(x)) for x, bound in _inputs(point)]
        for point in chart.meetings
    )
    heads = [_head(varied) for varied in chart.plane.inputs]
    return _table(chart, heads, rows, f"{NOTE} chart.json has all digits and the error bounds.")


def exact_points(chart: Chart) -> Table:
    """The points of codimension two to the last digit, with error bounds."""
    rows = (
        [x for value, bound in _inputs(point) for x in (exact(value), error_bound(bound) if isfinite(bound) else "")]
        for point in chart.meetings
    )
    return _table(chart, [column for varied in chart.plane.inputs for column in (_head(varied), "±")], rows, NOTE)


def _table(chart: Chart, heads: Sequence[str], rows: Iterable[Sequence[str]], note: str) -> Table:
    named = tuple(
        (str(number), name_of(point), point.word, *cells)
        for number, (point, cells) in enumerate(zip(chart.meetings, rows, strict=True), 1)
    )
    return Table("Points of codimension two", (*texts("No.", "What", "Motion"), *numbers(*heads)), named, note)


def _head(varied: DesignInput) -> str:
    return f"{varied.quantity} [{varied.unit}]" if varied.unit else varied.quantity


def _inputs(point: Meeting) -> list[tuple[float, float]]:
    return list(zip(map(float, point.inputs), map(float, point.error_bound), strict=True))


def name_of(point: Meeting) -> str:
    """What happens at a point."""
    own, other = point.events
    if other is not Event.GRAZING:
        return other.words
    if own is Event.GRAZING:
        return "two grazings"
    return own.words if own is Event.DEGENERATE_GRAZING else f"{own.words} with grazing"
