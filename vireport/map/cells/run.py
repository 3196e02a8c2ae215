"""Makes a map from its file: chunk by chunk, on as many cores or machines as there are, and where it left off."""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from vireport.base.errors import NumericalError, install_command
from vireport.base.files import write_files
from vireport.map.cells.cells import MapPlan, map_plan
from vireport.map.outputs import MapOutput, page_files
from vireport.scenario.loading import Overrides, load_map
from vireport.text.templates import Words

if TYPE_CHECKING:
    from vireport.map.cells.workers import CellProgress


def run_map(
    path: str,
    folder: Path,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: CellProgress | None = None,
    draw: bool = True,
    output: MapOutput | None = None,
    overrides: Overrides = (),
) -> str:
    """Compute a map, or what is missing of it, write its report and figures, and return a summary in words.

    The result is the same, bit for bit, however it was computed and however often it was interrupted.

    Parameters
    ----------
    path : str
        The map file.
    folder : Path
        Where the results go; created if it is not there.
    scheduler : str, optional
        Address of a Dask scheduler, ``tcp://host:8786``, whose workers compute.
    workers : int, optional
        Processes on this machine otherwise; by default one for each core.
    progress : callable, optional
        Called with cells done and cells in all, now and then.
    draw : bool
        Whether to write a report, with heat maps where the map is a grid over two parameters.
    output : MapOutput, optional
        What of it is written.
    overrides : sequence of str, or mapping of str to object
        Values that replace those of the file, as in `load`.

    Raises
    ------
    UsageError, ScenarioError
        Where the file or the address cannot be used, or the folder holds another map, cannot be written to or has no
        space for this one.
    NumericalError
        Where a map cannot be computed: outside the theory, or a package or the workers are missing.
    """
    loaded = load_map(path, overrides)
    plan = map_plan(loaded)
    _require_packages(plan)
    from vireport.map.cells import store as map_store
    from vireport.map.cells.workers import complete, require_address

    if scheduler is not None:
        require_address(scheduler)
    # What is wrong with the values of the design point is told before the cells are computed.
    design = loaded.design if draw else None
    store = map_store.Store(folder, plan, loaded.sha256, loaded.text)
    rejected: list[str] = []
    with map_store.opened(store):
        # A map that is finished is only drawn again.
        if not map_store.is_finished(store, rejected):
            complete(store, scheduler, workers or cores(), progress or (lambda done, total: None), rejected)
            with map_store.writing(folder):
                map_store.merge(store, rejected)
        map_store.remove_chunks(store)
        if not draw:
            from vireport.map.cells.findings import findings_of

            counted = Words("map")("counted", plan, findings_of(plan, store.result))
            return "\n".join([*rejected, counted, _written([store.result])])
        from vireport.map.cells.report import report_of

        output = output or MapOutput()
        report = report_of(store, loaded, design, output)
        files = page_files(report, output)
        with map_store.writing(folder):
            write_files(folder, files)
    # Of cells beside a design point the page has the counts.
    note = "" if plan.plane is not None else "; heat maps are drawn of a grid over two parameters"
    written = _written([store.result, *(folder / name for name in files)])
    return "\n".join([*rejected, *report.verdict.lines, written + note])


def _require_packages(plan: MapPlan) -> None:
    missing = [name for name in ("pyarrow", "filelock") if find_spec(name) is None]
    if missing:
        raise NumericalError(f"a map needs {' and '.join(missing)}: {install_command(missing[0])}")
    if plan.needs_numba and find_spec("numba") is None:
        raise NumericalError(f"map.from_rest, map.shock and map.escape need numba: {install_command('numba')}")


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _written(files: list[Path]) -> str:
    return f"wrote {', '.join(map(str, files))}"
