"""Makes a map from its file: chunk by chunk, on as many cores or machines as there are, and where it left off."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from vireport.analysis import STABILITIES
from vireport.errors import NumericalError
from vireport.scenario import load_map
from vireport.sweep.cells import MapPlan
from vireport.sweep.plan import map_plan

if TYPE_CHECKING:
    from vireport.sweep.store import Store

Progress = Callable[[int, int], None]
"""Told how many cells are done, and how many there are."""


def run_map(
    path: str,
    folder: Path,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
    draw: bool = True,
) -> str:
    """Compute a map, or what is missing of it, draw it, and return a summary in words.

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
        Told cells done and cells in all, now and then; see `terminal_progress`.
    draw : bool
        Whether to draw heat maps, where the map is a grid over two parameters.

    Raises
    ------
    UsageError, ScenarioError
        Where the file cannot be used, or the folder holds another map or cannot be written to.
    NumericalError
        Where a map cannot be computed: outside the theory, or a package or the workers are missing.
    """
    try:
        from vireport.sweep import store as map_store
    except ImportError as error:
        raise NumericalError("a map needs pyarrow: pip install 'vireport[sweep]'") from error
    loaded = load_map(path)
    plan = map_plan(loaded)
    if plan.sampling in ("latin_hypercube", "sobol"):
        _need_scipy()
    store = map_store.Store(folder, plan, map_store.identity_of(loaded, plan), loaded.text)
    with map_store.opened(store):
        if not map_store.is_complete(store):
            there = map_store.chunks_there(store)
            done = sum(plan.rows(index) for index in there)
            say = progress or (lambda done, total: None)
            say(done, plan.cells)
            todo = (index for index in range(plan.chunks) if index not in there)
            for index in _stored(store, todo, plan.chunks - len(there), scheduler, workers):
                done += plan.rows(index)
                say(done, plan.cells)
            map_store.finish(store)
        drawn = _draw(store.result, folder, plan) if draw else []
        counts = map_store.stability_counts(store)
    note = "; heat maps are drawn of a grid over two parameters" if draw and not drawn else ""
    return _summary(plan, counts, [store.result, *drawn]) + note


def _need_scipy() -> None:
    try:
        import scipy.stats  # type: ignore[import-untyped]  # noqa: F401
    except ImportError as error:
        raise NumericalError("samples need scipy: pip install 'vireport[sweep]'") from error


def _stored(
    store: Store, todo: Iterator[int], chunks: int, scheduler: str | None, workers: int | None
) -> Iterator[int]:
    """Compute and store chunks, and yield each."""
    from vireport.sweep import workers as map_workers
    from vireport.sweep.store import written

    count = min(workers or cores(), chunks)
    with written(store.folder):
        if scheduler is not None:
            yield from map_workers.on_cluster(store.plan, todo, store.chunk, scheduler)
        elif count > 1:
            yield from map_workers.on_cores(store.plan, todo, store.chunk, count)
        else:
            yield from map_workers.here(store.plan, todo, store.chunk)


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _draw(result: Path, folder: Path, plan: MapPlan) -> list[Path]:
    """Draw the heat maps that are not there yet."""
    from vireport.figures import png_of
    from vireport.files import write_whole
    from vireport.sweep.figures import map_figures, picture_names
    from vireport.sweep.store import written

    paths = [folder / f"{name}.png" for name in picture_names(plan)]
    if not all(path.exists() for path in paths):
        with written(folder):
            for name, figure in map_figures(plan, result).items():
                write_whole(folder / f"{name}.png", png_of(figure))
    return paths


def _summary(plan: MapPlan, counts: dict[str | None, int], files: list[Path]) -> str:
    stable = sum(counts.get(word, 0) for word in STABILITIES if word.attracts)
    parts = (stable, counts.get("unstable node", 0), counts.get(None, 0))
    shares = [f"{100 * part / plan.cells:.3g} %" for part in parts]
    axes = " x ".join(plan.names)
    return (
        f"{plan.cells:,} cells ({axes}): {shares[0]} with a stable 1:1 motion, {shares[1]} with an unstable one only, "
        f"{shares[2]} with none\nwrote {', '.join(map(str, files))}"
    )


def terminal_progress() -> Progress:
    """A bar with rate and remaining time on standard error, by tqdm.

    Raises
    ------
    NumericalError
        Where tqdm is missing.
    """
    try:
        from tqdm import tqdm  # type: ignore[import-untyped]
    except ImportError as error:
        raise NumericalError("the progress bar needs tqdm: pip install 'vireport[sweep]'") from error
    bars: list[tqdm] = []

    def show(done: int, total: int) -> None:
        if not bars:
            bars.append(
                tqdm(total=total, initial=done, unit=" cells", unit_scale=True, dynamic_ncols=True, leave=False)
            )
        bars[0].update(done - bars[0].n)
        if done >= total:
            bars[0].close()

    return show
