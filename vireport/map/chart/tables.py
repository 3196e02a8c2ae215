"""The points of codimension two of a chart as a table."""

from __future__ import annotations

from pathlib import Path

from vireport.map.chart.chart import Chart
from vireport.map.chart.meetings import Meeting
from vireport.map.design import exactness_of
from vireport.motions.events import Event
from vireport.text.formatting import rounded_text
from vireport.text.said import Said, words_of
from vireport.text.tables import Table, worded_table
from vireport.text.templates import Words

_said = words_of("chart")


def points_table(chart: Chart, templates: Path | None = None) -> Table:
    """The points of codimension two; words of a folder of templates come before ours."""
    said, exactness = Words("chart", templates), exactness_of(chart.design)
    rows = tuple(
        (
            str(number),
            name_of(point).words(templates),
            point.word,
            *(rounded_text(float(x), exactness) for x in point.inputs),
        )
        for number, point in enumerate(chart.meetings, 1)
    )
    inputs = [varied.head for varied in chart.plane.inputs]
    return worded_table(said, "points", "tttnn", rows, inputs, note=said("points_note"))


def name_of(point: Meeting) -> Said:
    """Name of what happens at a point of the chart."""
    first, other = point.events
    if other is not Event.GRAZING:
        return _said("point", other)
    if first is Event.GRAZING:
        return _said("two_grazings")
    return _said("point" if first is Event.DEGENERATE_GRAZING else "point_with_grazing", first)
