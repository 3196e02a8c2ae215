"""The report and the figures of a finished map as files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct

from vireport.map.cells.design import map_design
from vireport.map.cells.findings import findings_of
from vireport.map.cells.report import MapReport
from vireport.scenario.loading import Loaded, LoadedMap
from vireport.study.plan import Task, page_and_figure_files
from vireport.study.provenance import provenance_of, with_pages

if TYPE_CHECKING:
    from vireport.map.cells.store import Store

HEAT_MAPS = "map-stability", "map-margin", "map-voltage", "map-from-rest", "map-shock"

MAP_FILES = page_and_figure_files(HEAT_MAPS)
"""Files that a map may be written to beside its cells, by their formats."""

FORMATS = (Task.HTML, Task.PDF, Task.PNG)
"""What is written by default."""


class MapOutput(Struct, frozen=True):
    """What is written of a finished map.

    Attributes
    ----------
    formats : tuple of Task
        Among `MAP_FILES`.
    command : str
        For the record.
    templates : Path, optional
        A folder whose templates come before ours.
    paper : str
        Of the PDF: a4 or letter.
    width_mm : float, optional
        Of the figures, for a column of a paper.
    """

    formats: tuple[Task, ...] = FORMATS
    command: str = "vireport map"
    templates: Path | None = None
    paper: str = "a4"
    width_mm: float | None = None


def report_of(store: Store, loaded: LoadedMap, design: Loaded | None, output: MapOutput) -> MapReport:
    """What a finished map comes to, with its figures drawn.

    Parameters
    ----------
    store : Store
        With the finished map.
    loaded : LoadedMap
        The map file.
    design : Loaded, optional
        Its design point.
    output : MapOutput
    """
    from vireport.figures.style import Sheet, drawn_for
    from vireport.map.cells.figures import map_pictures

    plan = store.plan
    findings, at_design = findings_of(plan, store.result), map_design(design, plan)
    with drawn_for(Sheet.of(output.width_mm)):
        drawn = map_pictures(plan, store.result, findings, at_design, output.templates)
    origin = with_pages(provenance_of(loaded, output.command), drawn=bool(drawn))
    pictures = {picture.name: picture for picture in drawn}
    digest = store.digest.read_text(encoding="utf-8").split()[0]
    return MapReport(plan, loaded, findings, at_design, digest, pictures, origin, output.templates)


def files(report: MapReport, output: MapOutput) -> dict[str, bytes]:
    """The report and the figures of a finished map by their names."""
    from vireport.report.rendering import render_files

    return render_files(report, set(output.formats), output.templates, output.paper)
