"""What a worker of a map runs, and nothing that it does not need: it starts the sooner."""

from __future__ import annotations

import os
import signal
import tempfile
import threading
from multiprocessing import parent_process
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]

from vireport.sweep.cells import MapPlan
from vireport.sweep.mapping import evaluate_chunk
from vireport.version import __version__


def made_by() -> str:
    """Versions that the bits of the results depend on."""
    return f"vireport {__version__}, numpy {np.__version__}"


def chunk_bytes(plan: MapPlan, index: int) -> tuple[str, bytes]:
    """Compute a chunk, as the bytes of its file; the versions that computed it come first."""
    return made_by(), bytes(_arrow_file(plan, index))


def store_chunk(plan: MapPlan, index: int, path: Path) -> None:
    """Compute a chunk and write its file."""
    write_durably(path, _arrow_file(plan, index))


def _arrow_file(plan: MapPlan, index: int) -> Any:
    table = evaluate_chunk(plan, index)
    sink = pa.BufferOutputStream()
    with pa.ipc.new_file(sink, table.schema) as writer:
        writer.write_table(table)
    return sink.getvalue()


def write_durably(path: Path, data: Any) -> None:
    """Write under a temporary name, force it to the disk and rename: not even a power cut leaves a part of a file."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".new.")
    try:
        with os.fdopen(handle, "wb", buffering=0) as file:
            rest = memoryview(data)
            while len(rest):
                rest = rest[file.write(rest) :]
            os.fsync(file.fileno())
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def begin_worker() -> None:
    """Prepare a worker process: Ctrl-C is for the process that started it, with which it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:
        sentinel = parent.sentinel

        def watch() -> None:
            wait([sentinel])
            os._exit(1)

        threading.Thread(target=watch, daemon=True).start()
