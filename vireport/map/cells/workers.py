"""Who computes the chunks of a map: this process, the cores of this machine, or the workers of a Dask scheduler.

They are computed in any order, with a bounded number of chunks under way, so that memory does not grow with the map.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import closing, contextmanager, suppress
from functools import partial
from importlib import import_module
from logging import CRITICAL
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import IO, Any
from urllib.parse import urlsplit
from uuid import uuid4

from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import NumericalError, UsageError, install_command
from vireport.base.files import write_whole
from vireport.map.cells.store import (
    RejectedFileError,
    Store,
    chunk_or_bytes,
    read_chunk,
    require_space,
    stored_chunks,
    write_chunk,
    writing,
)

AHEAD = 2
"""Chunks under way for each worker: one that it computes, and one that waits for it."""

WORTH_HELP = 1.5
"""Processor time of the cells that are left for which a further process is begun [s]: some three times what it takes to
begin, mostly to import what it needs. With less to do, two cores would take longer than one."""

HELPER = "vireport.map.cells.helper"
"""The module that a further process on this machine runs."""

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
    else:
        yield from _on_cores(store, todo, workers)


class Helper(Struct, frozen=True, eq=False):
    """A further process on this machine, see `helper`, with the chunks that it is to compute, in their order."""

    process: subprocess.Popen[bytes]
    orders: IO[bytes]
    reader: Thread
    chunks: deque[int]

    def send(self, data: bytes) -> None:
        """Write to the process; where it is lost, the reader of its output says so."""
        with suppress(OSError):
            self.orders.write(data)
            self.orders.flush()

    def end(self) -> None:
        """Let the process end, after the chunk that it computes."""
        with suppress(OSError):
            self.orders.close()
        self.process.wait()
        self.reader.join()


def _on_cores(store: Store, todo: deque[int], workers: int) -> Iterator[int]:
    """Compute chunks in this process and, as soon as that pays, in further ones at the same time.

    How long the rest takes is estimated from the cells that this process has computed, by processor time: what else
    runs on the machine delays the others as much. Where another process is lost or
    fails, the others take over its chunks, in the end this one, which says what is wrong with them.
    """
    helpers: list[Helper] = []
    stored: SimpleQueue[tuple[Helper, bool]] = SimpleQueue()
    begun, cells, seconds = 0, 0, 0.0

    def waiting() -> bool:
        return any(helper.chunks for helper in helpers)

    try:
        while todo or waiting():
            if todo:
                start = time.process_time()
                write_chunk(store, todo[0])
                seconds, cells = seconds + time.process_time() - start, cells + store.plan.rows(todo[0])
                yield todo.popleft()
                left = seconds / cells * sum(map(store.plan.rows, todo))
                while begun < min(workers - 1, int(left / WORTH_HELP)):
                    begun += 1
                    helpers.append(begin_helper(store, stored))
            with suppress(Empty):
                while True:
                    helper, running = stored.get(block=not todo and waiting())
                    if running:
                        yield helper.chunks.popleft()
                    else:
                        helper.end()
                        helpers.remove(helper)
                        todo.extend(helper.chunks)
            for helper in helpers:
                # The last chunks are shared out one by one, so that all processes end at nearly the same time.
                while todo and len(helper.chunks) < (AHEAD if len(todo) > len(helpers) else 1):
                    helper.chunks.append(todo.popleft())
                    helper.send(b"%d\n" % helper.chunks[-1])
    finally:
        for helper in helpers:
            helper.end()


def begin_helper(store: Store, stored: SimpleQueue[tuple[Helper, bool]]) -> Helper:
    """Begin a process that computes chunks: it is put into `stored`, with True for each that it has, False at its end.

    It imports what this process would, and Ctrl-C does not reach it.
    """
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", HELPER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        start_new_session=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None

    def read(numbers: IO[bytes]) -> None:
        with numbers:
            for _ in numbers:
                stored.put((helper, True))
        stored.put((helper, False))

    helper = Helper(process, process.stdin, Thread(target=read, args=(process.stdout,), daemon=True), deque())
    helper.reader.start()
    helper.send(pickle.dumps(store))
    return helper


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

    Workers that share the folder of the map store them there. The chunks of others come back to be stored here.
    """
    mark = store.chunks / f".{uuid4().hex}.chunk.mark"
    compute_chunk = partial(chunk_or_bytes, replace(store, folder=store.folder.absolute()), mark.name)
    with _connected(scheduler) as client, _marked(mark):
        needed = (*NEEDED, *(("numba",) if store.plan.needs_numba else ()))
        watch, executor = _Watch(client, scheduler, needed), client.get_executor(pure=False)
        pending: dict[Future[bytes | None], int] = {}
        while todo or pending:
            most = watch.room()
            while todo and len(pending) < most:
                future = executor.submit(compute_chunk, todo[0])
                pending[future] = todo.popleft()
            for future in wait(pending, POLL, FIRST_COMPLETED).done:
                number, data = pending.pop(future), future.result()
                try:
                    if data is not None:
                        read_chunk(store, number, data)
                        write_whole(store.chunk(number), data)
                except RejectedFileError as error:
                    raise NumericalError(
                        f"--scheduler {scheduler}: what a worker computed {error} (install the same versions "
                        "everywhere)"
                    ) from error
                yield number


@contextmanager
def _marked(mark: Path) -> Iterator[None]:
    """Keep a file in its place meanwhile."""
    mark.touch()
    try:
        yield
    finally:
        mark.unlink(missing_ok=True)


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

    `compared` has the workers whose versions are ours. `seen` has, for each worker, its last sign of life by the
    scheduler's clock, and when that was new to this process.
    """

    def __init__(self, client: Any, scheduler: str, needed: tuple[str, ...] = NEEDED) -> None:
        self.client, self.scheduler, self.needed = client, scheduler, needed
        self.threads = 0
        self.compared: set[str] = set()
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
        if not workers.keys() <= self.compared:
            self._compare_versions()
            self.compared = set(workers)
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

    def _answer(self, ask: Callable[..., object], **arguments: object) -> Any:
        try:
            return self.client.sync(ask, callback_timeout=ANSWER, **arguments)
        except OSError as error:  # a time-out among them
            raise NumericalError(
                f"--scheduler {self.scheduler}: the scheduler was lost, or has not answered for {ANSWER:g} s. {RESUME}"
            ) from error
