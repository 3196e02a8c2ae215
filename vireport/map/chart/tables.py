"""The points of codimension two of a chart as a table."""

from __future__ import annotations

from vireport.map.chart.chart import Chart
from vireport.map.chart.meetings import Meeting
from vireport.motions.events import Event
from vireport.text.formatting import rounded_text
from vireport.text.tables import Table, numbers, texts

NOTE = (
    "Two grazings: two touches in one motion. Degenerate grazing: period doublings and folds of the motion with the "
    "further impact begin. Cusp: two curves of folds end together. Degenerate period doubling: it changes from soft "
    "to hard, and a curve of folds begins."
)


def points_table(chart: Chart) -> Table:
    """The points of codimension two."""
    heads = [varied.head for varied in chart.plane.inputs]
    rows = tuple(
        (str(number), name_of(point), point.word, *(rounded_text(float(x), chart.exactness) for x in point.inputs))
        for number, point in enumerate(chart.meetings, 1)
    )
    note = f"{NOTE} chart.json has all digits and the error bounds."
    return Table("Points of codimension two", (*texts("No.", "What", "Motion"), *numbers(*heads)), rows, note)


def name_of(point: Meeting) -> str:
    """What happens at a point."""
    first, other = point.events
    if other is not Event.GRAZING:
        return other.words
    if first is Event.GRAZING:
        return "two grazings"
    return first.words if first is Event.DEGENERATE_GRAZING else f"{first.words} with grazing"
