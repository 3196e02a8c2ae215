"""The report of a finished map of cells, with its figures drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vireport.map.cells.design import map_design
from vireport.map.cells.figures import map_pictures
from vireport.map.cells.findings import findings_of
from vireport.map.cells.report import CellsReport
from vireport.map.outputs import MapOutput, drawn
from vireport.scenario.loading import Loaded, LoadedMap

if TYPE_CHECKING:
    from vireport.map.cells.store import Store


def report_of(store: Store, loaded: LoadedMap, design: Loaded | None, output: MapOutput) -> CellsReport:
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
    plan, templates = store.plan, output.templates
    findings, at_design = findings_of(plan, store.result), map_design(design, plan)
    pictures = drawn(output, lambda: map_pictures(plan, store.result, findings, at_design, templates))
    return CellsReport(
        loaded,
        pictures,
        output.provenance(loaded, pictures),
        templates,
        plan=plan,
        findings=findings,
        design=at_design,
    )
