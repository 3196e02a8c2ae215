"""The page and the figures of a map as files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct

from vireport.scenario.loading import Loaded, LoadedMap
from vireport.study.plan import Task, page_and_figure_files
from vireport.study.provenance import Provenance, provenance_of, with_pages

if TYPE_CHECKING:
    from vireport.figures.style import Picture
    from vireport.map.report import MapReport

HEAT_MAPS = "map-stability", "map-margin", "map-voltage", "map-from-rest", "map-shock"

CELL_FILES = page_and_figure_files(HEAT_MAPS)
"""Files that a map of cells may be written to beside the cells, by their formats."""

CHART_FILES = {
    **page_and_figure_files(["figure-chart"]),
    Task.JSON: ("chart.json",),
    Task.MARKDOWN: ("chart.md",),
}
"""Files that a chart may be written to, by their formats."""

FORMATS = (Task.HTML, Task.PDF, Task.PNG)
"""What is written by default."""


class MapOutput(Struct, frozen=True):
    """The files that are written of a map, and how: formats, templates, paper and width.

    Attributes
    ----------
    formats : tuple of Task
    command : str
        For the record.
    templates : Path or None
        A folder whose templates come before ours.
    paper : str
        Of the PDF: a4 or letter.
    width_mm : float or None
        Of the figures, for a column of a paper.
    """

    formats: tuple[Task, ...] = FORMATS
    command: str = "vireport map"
    templates: Path | None = None
    paper: str = "a4"
    width_mm: float | None = None

    def provenance(self, loaded: Loaded | LoadedMap, pictures: Mapping[str, Picture]) -> Provenance:
        """Where the numbers come from, and what the page is made with if there is one."""
        made = provenance_of(loaded, self.command)
        return with_pages(made, drawn=bool(pictures)) if {Task.HTML, Task.PDF} & {*self.formats} else made


def drawn(output: MapOutput, draw: Callable[[], Iterable[Picture]]) -> Mapping[str, Picture]:
    """The pictures of a map by their names, drawn as wide as is asked for."""
    from vireport.figures.style import Sheet, drawn_for

    with drawn_for(Sheet.of(output.width_mm)):
        return {picture.name: picture for picture in draw()}


def page_files(report: MapReport, output: MapOutput) -> dict[str, bytes]:
    """The page and the figures of a map by their names."""
    from vireport.report.rendering import render_files

    return render_files(report, {*output.formats}, output.paper)
