"""Who computes the chunks of a map: this process, the cores of this machine, or the workers of a Dask scheduler.

Each yields the numbers of chunks as they are stored, in any order, with a bounded number under way, so that memory
does not grow with the map.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from importlib import import_module
from itertools import islice
from multiprocessing.context import BaseContext
from pathlib import Path
from typing import Any

from vireport.errors import NumericalError
from vireport.sweep.cells import MapPlan
from vireport.sweep.chunk import begin_worker, chunk_bytes, made_by, store_chunk, write_durably

PathOf = Callable[[int], Path]
"""Where a chunk is to be stored."""

AHEAD = 2
"""Chunks under way for each worker: one that it computes, and one that waits for it."""

MOST_LOSSES = 5
"""Times in a row that workers may be lost without one chunk done; then something kills them that will not stop."""

RETRIES = 3
"""Workers of a cluster that may be lost over one chunk."""

PATIENCE = 60.0
"""How long a scheduler may be without any worker [s]."""

KEPT = "What is computed so far is kept: run the same command again to go on"


def here(plan: MapPlan, todo: Iterator[int], path_of: PathOf) -> Iterator[int]:
    """Compute chunks in this process."""
    for index in todo:
        store_chunk(plan, index, path_of(index))
        yield index


def on_cores(plan: MapPlan, todo: Iterator[int], path_of: PathOf, workers: int) -> Iterator[int]:
    """Compute chunks in processes of this machine; one that is killed is replaced.

    Raises
    ------
    NumericalError
        Where the processes are killed again and again.
    """
    pending: dict[Future[None], int] = {}
    again: list[int] = []
    losses = 0
    while True:
        pool = ProcessPoolExecutor(workers, _context(), begin_worker)
        try:
            while True:
                while len(pending) < AHEAD * workers and (index := again.pop() if again else next(todo, -1)) >= 0:
                    pending[pool.submit(store_chunk, plan, index, path_of(index))] = index
                if not pending:
                    return
                for future in wait(pending, return_when=FIRST_COMPLETED).done:
                    future.result()
                    losses = 0
                    yield pending.pop(future)
        except BrokenProcessPool as error:
            losses += 1
            if losses > MOST_LOSSES:
                raise NumericalError(
                    f"worker processes were killed {losses} times in a row (out of memory?). {KEPT}, with fewer workers"
                ) from error
            again += pending.values()
            pending.clear()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _context() -> BaseContext:
    """How processes begin: where the system can, as copies of one that has imported everything."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["vireport.sweep.chunk"])
    return context


def on_cluster(plan: MapPlan, todo: Iterator[int], path_of: PathOf, scheduler: str) -> Iterator[int]:
    """Compute chunks on the workers of a Dask scheduler, which gives those of a lost worker to another.

    They come back here to be stored: the workers may be on machines that share no disk.

    Raises
    ------
    NumericalError
        Where the scheduler cannot be reached or is lost, or its workers have other versions.
    """
    try:
        distributed = import_module("distributed")
    except ImportError as error:
        raise NumericalError("--scheduler needs dask.distributed: pip install 'vireport[cluster]'") from error
    for index, data in _gathered(distributed, plan, todo, scheduler):
        write_durably(path_of(index), data)
        yield index


def _gathered(distributed: Any, plan: MapPlan, todo: Iterator[int], scheduler: str) -> Iterator[tuple[int, bytes]]:
    try:
        client = distributed.Client(scheduler, set_as_default=False)
        client.wait_for_workers(1, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise NumericalError(f"--scheduler {scheduler}: cannot be reached, or has no workers ({error})") from error
    with client:
        try:
            index_of: dict[Any, int] = {}
            futures = distributed.as_completed(loop=client.loop)
            while True:
                room = AHEAD * max(sum(client.nthreads().values()), 1) - len(index_of)  # workers may come and go
                for index in islice(todo, max(room, 0)):
                    future = client.submit(chunk_bytes, plan, index, pure=False, retries=RETRIES)
                    index_of[future.key] = index
                    futures.add(future)
                if not index_of:
                    return
                future = next(futures)
                versions, data = future.result()
                if versions != made_by():
                    raise NumericalError(
                        f"--scheduler {scheduler}: a worker has {versions}, this process {made_by()}; the results of "
                        "both are not mixed (install the same everywhere)"
                    )
                index = index_of.pop(future.key)
                del future
                yield index, data
        except (distributed.KilledWorker, CancelledError, OSError) as error:
            raise NumericalError(
                f"--scheduler {scheduler}: the scheduler or its workers were lost ({type(error).__name__}). {KEPT}"
            ) from error
