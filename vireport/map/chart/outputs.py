"""A chart as files, JSON and text."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from vireport.base.records import keyed
from vireport.map.chart.chart import Chart
from vireport.map.chart.opening import chart_opening
from vireport.map.chart.report import ChartReport
from vireport.map.chart.results import chart_data
from vireport.map.chart.tables import points_table
from vireport.map.chart.words import naming
from vireport.map.design import alerts_of
from vireport.map.outputs import MapOutput, drawn, page_files
from vireport.scenario.loading import Loaded
from vireport.study.judging.alerts import named_alerts
from vireport.study.plan import FIGURE_FORMATS, Task
from vireport.study.provenance import Provenance
from vireport.study.results import json_bytes
from vireport.text.tables import Table, markdown_of, markdown_text, plain_text
from vireport.text.templates import Words

if TYPE_CHECKING:
    from vireport.figures.style import Picture


def files(chart: Chart, loaded: Loaded, output: MapOutput) -> dict[str, bytes]:
    """The files of a chart by their names; only what they need is imported.

    Parameters
    ----------
    chart : Chart
    loaded : Loaded
        The scenario.
    output : MapOutput
        With formats among those of `CHART_FILES`.
    """
    contents, wanted = dict[str, bytes](), {*output.formats}
    if wanted & {Task.HTML, Task.PDF, *FIGURE_FORMATS}:
        from vireport.map.chart.figure import picture

        contents |= page_files(report_of(chart, loaded, output, lambda: [picture(chart, output.templates)]), output)
    if Task.JSON in wanted:
        contents["chart.json"] = chart_json(chart, output.provenance(loaded, {}))
    if Task.MARKDOWN in wanted:
        contents["chart.md"] = markdown(chart, output.templates).encode()
    return contents


def report_of(
    chart: Chart, loaded: Loaded, output: MapOutput, draw: Callable[[], Iterable[Picture]] = tuple
) -> ChartReport:
    """What the page of a chart knows, with the pictures that are drawn."""
    pictures = drawn(output, draw)
    return ChartReport(loaded, pictures, output.provenance(loaded, pictures), output.templates, chart=chart)


def text(chart: Chart, templates: Path | None = None, tables: bool = False) -> str:
    """The text of a chart for a terminal: the answer, and with `tables` all numbers."""
    opening = chart_opening(chart, naming(chart, templates)).worded(templates)
    facts = [fact for _, fact in opening.facts[1:]]
    rest = plain_text([*facts, *_parts(chart, templates)]) if tables else ""
    return "\n\n".join(filter(None, ("\n".join(opening.lines), rest))) + "\n"


def markdown(chart: Chart, templates: Path | None = None) -> str:
    """The text of a chart in Markdown."""
    opening = chart_opening(chart, naming(chart, templates)).worded(templates)
    parts = [opening.sentence, *(fact for _, fact in opening.facts), *_parts(chart, templates)]
    said = "\n\n".join(markdown_text(part) if isinstance(part, str) else markdown_of(part) for part in parts)
    return f"{said.rstrip()}\n"


def _parts(chart: Chart, templates: Path | None) -> Iterator[str | Table]:
    """The alerts, what was found and what was not, and the points of codimension two."""
    if alerts := alerts_of(chart.design):
        yield named_alerts(alerts, templates)
    yield Words("chart", templates)("summary", chart)
    if chart.meetings:
        yield points_table(chart, templates)


def chart_json(chart: Chart, provenance: Provenance) -> bytes:
    """A chart as JSON, one top-level key a line."""
    return json_bytes(keyed(chart_data(chart)), provenance)
