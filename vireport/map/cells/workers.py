"""Who computes the chunks of a map: this process, the cores of this machine, or the workers of a Dask scheduler.

Processes and cluster are driven through one interface, that of `concurrent.futures` (Dask's own processes on this
machine would take seconds to start), in any order, with a bounded number of chunks under way, so that memory does not
grow with the map.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from functools import partial
from importlib import import_module
from logging import CRITICAL
from multiprocessing import connection, forkserver, parent_process, resource_tracker
from multiprocessing.context import BaseContext
from typing import Any
from urllib.parse import urlsplit

from vireport.base import interrupts
from vireport.base.errors import NumericalError, UsageError, install_command
from vireport.base.files import write_whole
from vireport.map.cells.store import (
    RejectedFileError,
    Store,
    encoded_chunk,
    read_chunk,
    require_space,
    stored_chunks,
    write_chunk,
    writing,
)

AHEAD = 2
"""Chunks under way for each worker: one that it computes, and one that waits for it."""

MOST_LOSSES = 5
"""Times in a row that processes may be lost without one chunk done; then something kills them that will not stop."""

POLL = 2.0
"""Time between two looks at the workers of a cluster [s]."""

ANSWER = 30.0
"""How long a scheduler may take to answer [s]."""

PATIENCE = 45.0
"""How long a scheduler may be without any worker, and a worker without a sign of life [s]; they report every few
seconds. With start and end of the command, less than a minute."""

SCHEMES = ("tcp", "tls", "ucx", "ucxx", "ws", "wss")
"""Protocols of a scheduler's address."""

SAME_VERSIONS = ("vireport", "numpy", "scipy")
"""Packages on whose versions the bits of the results depend."""

NEEDED = (*SAME_VERSIONS, "pyarrow", "filelock")
"""Packages without which a worker cannot even read its tasks."""

SILENT = dict.fromkeys(("asyncio", "distributed", "distributed.client", "tornado", "tornado.application"), CRITICAL)
SILENT["distributed.protocol.core"] = CRITICAL + 1
"""Logs of a lost connection, unless others are configured: what there is to say of it is said by this module. What
cannot be decoded Dask logs as critical, with its traceback."""

RESUME = "What is computed so far is kept: run the same command again to go on"


CellProgress = Callable[[int, int], None]
"""Called with how many cells are done, and how many there are."""


def complete(store: Store, scheduler: str | None, workers: int, progress: CellProgress, rejected: list[str]) -> None:
    """Compute and store the chunks of a map that are not stored yet; the parameters are those of `compute`.

    Parameters
    ----------
    progress : callable
    rejected : list of str
        Here it is said which stored chunks cannot be used.
    """
    plan = store.plan
    with writing(store.folder):
        finished = stored_chunks(store, rejected)
        require_space(store, finished)
        done = sum(map(plan.rows, finished))
        progress(done, plan.cells)
        todo = deque(chunk for chunk in range(plan.chunks) if chunk not in finished)
        with closing(compute(store, todo, scheduler, min(workers, len(todo)))) as chunks:
            for chunk in chunks:
                done += plan.rows(chunk)
                progress(done, plan.cells)


def compute(store: Store, todo: deque[int], scheduler: str | None, workers: int) -> Generator[int, None, None]:
    """Compute and store chunks, and yield the number of each that is stored.

    Parameters
    ----------
    store : Store
    todo : deque of int
        Numbers of the chunks; those that are done are taken out.
    scheduler : str or None
        Address of a Dask scheduler.
    workers : int
        Processes on this machine, where there is no scheduler.

    Raises
    ------
    NumericalError
        Where the workers are lost for good, or those of a cluster have other versions.
    """
    if scheduler is not None and todo:
        yield from _on_cluster(store, todo, scheduler)
    elif workers > 1:
        yield from _on_cores(store, todo, workers)
    else:
        while todo:
            write_chunk(store, todo[0])
            yield todo.popleft()


def _complete(
    todo: deque[int], submit: Callable[[int], Future[Any]], room: Callable[[], int]
) -> Iterator[tuple[int, Any]]:
    """Keep chunks under way until none is left, and yield what each returns.

    `room` says how many may be under way, and is asked at least every `POLL` seconds. Whatever ends the work, the
    chunks that are not done are in `todo` again.
    """
    pending: dict[Future[Any], int] = {}
    try:
        while todo or pending:
            most = room()
            while todo and len(pending) < most:
                future = submit(todo[0])
                pending[future] = todo.popleft()
            for future in wait(pending, POLL, FIRST_COMPLETED).done:
                result = future.result()
                yield pending.pop(future), result
    finally:
        todo.extend(pending.values())


def _on_cores(store: Store, todo: deque[int], workers: int) -> Iterator[int]:
    """Compute chunks in processes of this machine; where one is killed, all begin anew."""
    losses = 0
    while todo:
        try:
            with closing(_until_one_is_lost(store, todo, workers)) as chunks:
                for number in chunks:
                    losses = 0
                    yield number
        except BrokenProcessPool as error:
            losses += 1
            if losses > MOST_LOSSES:
                raise NumericalError(
                    f"worker processes were killed {losses} times in a row (out of memory?). {RESUME}, with fewer "
                    "workers (--workers)"
                ) from error


def _until_one_is_lost(store: Store, todo: deque[int], workers: int) -> Generator[int, None, None]:
    """Compute chunks in processes of this machine as long as all of them live.

    Raises
    ------
    BrokenProcessPool
        Where one of them was killed, or what begins them.
    """
    with _losses_told():
        pool = ProcessPoolExecutor(workers, _context(), _begin_worker)

    def submit(number: int) -> Future[None]:
        # A process that is left alone as it starts would end in a traceback.
        with _losses_told(), interrupts.deferred():
            future = pool.submit(write_chunk, store, number)
        interrupts.check()
        return future

    try:
        for number, _ in _complete(todo, submit, lambda: AHEAD * workers):
            yield number
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _losses_told() -> Iterator[None]:
    """Say of whatever goes wrong as a process is begun that it was lost: what begins them may have been killed."""
    try:
        yield
    except BrokenProcessPool:
        raise
    except (EOFError, OSError, RuntimeError) as error:  # of its pipe, which ends in the middle, or is closed
        raise BrokenProcessPool("no process can be begun") from error


def _context() -> BaseContext:
    """How processes begin: where the system can, as copies of one that has imported everything."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([__name__])
    # The server inherits that Ctrl-C is held back, which is for this process alone; here it comes once that is started.
    resource_tracker.ensure_running()  # in its own time, it would no longer be held back
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    return context


def _begin_worker() -> None:
    """Prepare a worker process: Ctrl-C is for the process that started it, with which it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:
        sentinel = parent.sentinel

        def watch() -> None:
            connection.wait([sentinel])
            os._exit(1)

        threading.Thread(target=watch, daemon=True).start()


def require_address(scheduler: str) -> None:
    """Refuse what is not the address of a scheduler.

    Raises
    ------
    UsageError
    """
    scheme, separator, place = scheduler.partition("://")
    try:
        parts = urlsplit(f"//{place if separator else scheduler}")
        accepted = not separator or scheme in SCHEMES
        right = accepted and parts.hostname and parts.port and not parts.path.strip("/")
    except ValueError:  # a port that is no number, or brackets that do not match
        right = False
    if not right:
        raise UsageError(
            f"--scheduler: got {scheduler!r} (allowed: scheme://host:port, such as tcp://127.0.0.1:8786, with one of "
            f"the schemes {', '.join(SCHEMES)})"
        )


def _on_cluster(store: Store, todo: deque[int], scheduler: str) -> Iterator[int]:
    """Compute chunks on the workers of a Dask scheduler, which gives those of a lost worker to another.

    They come back here to be stored: the workers may be on machines that share no disk.
    """
    with _connected(scheduler) as client:
        needed = (*NEEDED, *(("numba",) if store.plan.needs_numba else ()))
        watch, executor = _Watch(client, scheduler, needed), client.get_executor(pure=False)
        submit = partial(executor.submit, encoded_chunk, store.plan, store.map_sha256)
        for number, data in _complete(todo, submit, watch.room):
            try:
                read_chunk(store, number, data)
            except RejectedFileError as error:
                raise NumericalError(
                    f"--scheduler {scheduler}: what a worker computed {error} (install the same versions everywhere)"
                ) from error
            write_whole(store.chunk(number), data)
            yield number


@contextmanager
def _connected(scheduler: str) -> Iterator[Any]:
    """A client of a Dask scheduler; its failures are put in words."""
    try:
        dask = import_module("dask")
        with dask.config.set(logging={**SILENT, **dask.config.get("logging", {})}):
            distributed = import_module("distributed")
    except ImportError as error:
        raise NumericalError(f"--scheduler needs dask.distributed: {install_command('dask.distributed')}") from error
    try:
        distributed.utils.LoopRunner().run_sync(_require_scheduler, distributed, scheduler)
        client = distributed.Client(scheduler, timeout=ANSWER, set_as_default=False)
    except Exception as error:  # what something else answers may make the library fail in any way
        raise NumericalError(
            f"--scheduler {scheduler}: cannot be reached, or is no Dask scheduler ({error or type(error).__name__})"
        ) from error
    try:
        yield client
    except ImportError as error:
        raise NumericalError(
            f"--scheduler {scheduler}: a worker lacks a package: {error} (install the same everywhere)"
        ) from error
    except (distributed.KilledWorker, CancelledError) as error:
        raise NumericalError(
            f"--scheduler {scheduler}: the scheduler or its workers were lost ({type(error).__name__}). {RESUME}"
        ) from error
    finally:
        client.close(timeout=POLL)


async def _require_scheduler(distributed: Any, address: str) -> None:
    """Fail in any way where there is no scheduler; a client that finds out by itself cannot always be closed."""
    from asyncio import timeout  # here, as each worker process imports this module, and none needs it

    security = distributed.Security().get_connection_args("client")
    async with timeout(ANSWER), distributed.rpc(address, connection_args=security) as scheduler:
        kind = (await scheduler.identity())["type"]
    if kind != "Scheduler":
        raise ValueError(f"it is a {kind}")


class _Watch:
    """Looks after the workers of a cluster now and then: that there are some, that they live, and what they have.

    `seen` has, for each worker, its last sign of life by the scheduler's clock, and when that was new to this process.
    """

    def __init__(self, client: Any, scheduler: str, needed: tuple[str, ...] = NEEDED) -> None:
        self.client, self.scheduler, self.needed = client, scheduler, needed
        self.threads = 0
        self.known: set[str] = set()
        self.seen: dict[str, tuple[float, float]] = {}
        self.alive = time.monotonic()
        self.looked = -POLL + self.alive

    def room(self) -> int:
        """Chunks that the workers can have under way; while there are no workers, it waits.

        Raises
        ------
        NumericalError
            Where the scheduler does not answer, is without workers for too long, or they have other versions.
        """
        while not self.threads or time.monotonic() - self.looked >= POLL:
            self._look()
            self.looked = time.monotonic()
            if not self.threads:
                time.sleep(POLL / 4)
        return AHEAD * self.threads

    def _look(self) -> None:
        workers = self._answer(self.client.scheduler.identity)["workers"]
        if not workers.keys() <= self.known:
            self._compare_versions()
            self.known = set(workers)
        self.threads = sum(worker["nthreads"] for worker in workers.values())
        now = time.monotonic()
        for address, worker in workers.items():
            if address not in self.seen or self.seen[address][0] != worker["last_seen"]:
                self.seen[address] = worker["last_seen"], now
                self.alive = now
        if now - self.alive > PATIENCE:
            missing = "no sign of life from its workers" if workers else "no workers"
            raise NumericalError(
                f"--scheduler {self.scheduler}: {missing} for {PATIENCE:g} s (start one: dask worker "
                f"{self.scheduler}; where they end at once, their logs say why). {RESUME}"
            )
        if silent := [address for address in workers if now - self.seen[address][1] > PATIENCE]:
            self._give_up(silent)

    def _give_up(self, workers: list[str]) -> None:
        """Have the chunks of frozen workers computed by the others, as the scheduler does, but only after minutes.

        Their nannies start them again; one without a nanny ends as soon as it goes on.
        """
        self._answer(
            self.client.scheduler.restart_workers,
            workers=workers,
            timeout=ANSWER / 2,
            wait_for_workers=False,
            on_error="return",
            stimulus_id=f"no-sign-of-life-{time.time()}",
        )

    def _compare_versions(self) -> None:
        """Refuse a cluster on which other versions, or none, would compute: the results are not mixed."""
        versions = self._answer(self.client.get_versions, packages=list(self.needed))
        client = versions["client"]["packages"]
        nodes = [("the scheduler", "vireport", versions["scheduler"])]  # it reads the tasks, but computes nothing
        nodes += [
            (f"worker {address}", package, node)
            for address, node in versions["workers"].items()
            for package in self.needed
        ]
        for name, package, node in nodes:
            version = node["packages"][package]
            if version != client[package] and (version is None or package in SAME_VERSIONS):
                raise NumericalError(
                    f"--scheduler {self.scheduler}: {name} has {package} in version {version or 'none'}, this process "
                    f"in version {client[package]} (install the same everywhere)"
                )

    def _answer(self, ask: Callable[..., Any], **arguments: Any) -> Any:
        try:
            return self.client.sync(ask, callback_timeout=ANSWER, **arguments)
        except OSError as error:  # a time-out among them
            raise NumericalError(
                f"--scheduler {self.scheduler}: the scheduler was lost, or has not answered for {ANSWER:g} s. {RESUME}"
            ) from error
