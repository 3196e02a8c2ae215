"""Where a map is kept: chunks while it is made, one Parquet file when it is done; whole files or none.

A chunk is an Arrow file under its number. It is written under another name, forced to the disk and renamed, so that
whatever ends a run leaves whole chunks, and the next run goes on from there.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pq  # type: ignore[import-untyped]

from vireport.errors import UsageError
from vireport.scenario import LoadedMap
from vireport.sweep.cells import MapPlan
from vireport.sweep.chunk import write_durably
from vireport.sweep.mapping import schema_of
from vireport.version import __version__

RESULT = "map.parquet"
CHUNKS = ".chunks"
MANIFEST = "manifest.json"

ROW_GROUP = 131_072
"""Rows of a row group of the result, at least: readers work on one at a time."""

DICTIONARY = ("motions", "stable", "stability", "gbar", "d", "word")
"""Columns beside the axes whose values recur. The others are stored plainly: compression would gain little."""

IDENTITY = b"vireport"
"""Key under which a table says what it was made of."""


@dataclass(frozen=True, slots=True)
class Identity:
    """What a chunk must have been made of to be part of a map.

    Attributes
    ----------
    map_sha256 : str
        Of the map file.
    vireport, numpy : str
        Versions that computed it: results may differ between them in the last bits.
    cells, chunk_cells : int
    layout : int
        Of the stored tables.
    """

    map_sha256: str
    vireport: str
    numpy: str
    cells: int
    chunk_cells: int
    layout: int = 1

    def to_bytes(self) -> bytes:
        """As JSON."""
        return json.dumps(asdict(self), indent=1).encode()


def identity_of(loaded: LoadedMap, plan: MapPlan) -> Identity:
    """What the chunks of a map are made of, by this version."""
    return Identity(loaded.sha256, __version__, np.__version__, plan.cells, plan.chunk_cells)


@dataclass(frozen=True, slots=True)
class Store:
    """The folder of a map.

    Attributes
    ----------
    folder : Path
    plan : MapPlan
    identity : Identity
    text : str
        The map file, which the result carries along.
    """

    folder: Path
    plan: MapPlan
    identity: Identity
    text: str = field(repr=False)

    @property
    def result(self) -> Path:
        """The finished map."""
        return self.folder / RESULT

    @property
    def chunks(self) -> Path:
        """Folder of the chunks."""
        return self.folder / CHUNKS

    def chunk(self, index: int) -> Path:
        """File of a chunk."""
        return self.chunks / f"{index:09d}.arrow"


@contextmanager
def opened(store: Store) -> Iterator[None]:
    """Hold the folder of a map for one run: made if it is not there, cleared of unfinished files.

    Raises
    ------
    UsageError
        Where it holds another map, or another run is at work in it.
    """
    with written(store.folder):
        store.chunks.mkdir(parents=True, exist_ok=True)
    manifest = store.chunks / MANIFEST
    _refuse_other(store, manifest)
    with written(store.folder):
        if not manifest.exists():
            write_durably(manifest, store.identity.to_bytes())
    with open(manifest, "rb") as held:
        _lock(held.fileno(), store.folder)
        for left in [*store.chunks.glob(".*"), *store.folder.glob(f".{RESULT}.*")]:
            left.unlink()
        yield


def _refuse_other(store: Store, manifest: Path) -> None:
    there = None
    if manifest.exists():
        there = manifest.read_bytes()
    elif store.result.exists():
        there = _identity_in(store.result)
    if there is None or there == store.identity.to_bytes():
        return
    try:
        old = json.loads(there)
    except ValueError:
        old = {}
    now = asdict(store.identity)
    words = {"map_sha256": "the map file", "vireport": "the version of vireport", "numpy": "the version of numpy"}
    changed = [words.get(key, key) for key in now if not isinstance(old, dict) or old.get(key) != now[key]]
    raise UsageError(
        f"{store.folder}: holds the results of another map: {', '.join(changed)} changed since. They are not mixed. "
        f"Name another folder (--output), or delete this one"
    )


def _identity_in(path: Path) -> bytes:
    """What a finished map says it was made of; nothing where it is no map of ours."""
    try:
        metadata = pq.read_metadata(path).metadata or {}
    except (pa.ArrowInvalid, OSError):
        return b""
    return bytes(metadata.get(IDENTITY, b""))


def _lock(handle: int, folder: Path) -> None:
    """Lock a file until it is closed, or its process ends however it may; where the system knows no such lock, not."""
    try:
        import fcntl
    except ImportError:
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise UsageError(f"{folder}: another run is writing to this folder") from error


def is_complete(store: Store) -> bool:
    """Whether the result is there, of this map."""
    return store.result.exists() and _identity_in(store.result) == store.identity.to_bytes()


def chunks_there(store: Store) -> set[int]:
    """Chunks that are there and whole; any other file in their place is removed."""
    found = set()
    for path in store.chunks.glob("*.arrow"):
        index = int(path.stem) if path.stem.isdigit() else -1
        if 0 <= index < store.plan.chunks and _rows(path) == store.plan.rows(index):
            found.add(index)
        else:
            path.unlink()
    return found


def _rows(path: Path) -> int:
    try:
        with pa.memory_map(str(path)) as file, pa.ipc.open_file(file) as reader:
            return sum(reader.get_batch(k).num_rows for k in range(reader.num_record_batches))
    except (pa.ArrowInvalid, OSError):
        return -1


@contextmanager
def written(folder: Path) -> Iterator[None]:
    """Say what to do where something cannot be written.

    Raises
    ------
    UsageError
        In the place of an OSError.
    """
    try:
        yield
    except OSError as error:
        raise UsageError(
            f"{error.filename or folder} cannot be written: {error.strerror}. What is computed so far is kept: run the "
            "same command again to go on"
        ) from error


def finish(store: Store) -> None:
    """Put the chunks together, one after the other, as the result, and remove them."""
    plan, schema = store.plan, schema_of(store.plan)
    schema = schema.with_metadata({IDENTITY: store.identity.to_bytes(), b"map": store.text.encode()})
    recurring = [name for name in schema.names if name in plan.names or name in DICTIONARY]
    with written(store.folder):
        handle, name = tempfile.mkstemp(dir=store.folder, prefix=f".{RESULT}.")
        try:
            with os.fdopen(handle, "wb") as file:
                # Arrow's own file under the same name: Python's would copy every column once more.
                with (
                    pa.OSFile(name, "wb") as sink,
                    pq.ParquetWriter(sink, schema, compression="none", use_dictionary=recurring) as writer,
                ):
                    for group in _groups(store):
                        writer.write_table(group.replace_schema_metadata(schema.metadata), row_group_size=len(group))
                os.fsync(file.fileno())
            os.chmod(name, 0o644)
            os.replace(name, store.result)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
        for path in store.chunks.glob("*.arrow"):
            path.unlink()


def _groups(store: Store) -> Iterator[pa.Table]:
    """Chunks in their order, joined until they make a row group."""
    gathered: list[Any] = []
    for index in range(store.plan.chunks):
        with pa.memory_map(str(store.chunk(index))) as file, pa.ipc.open_file(file) as reader:
            gathered.append(reader.read_all())
        if sum(map(len, gathered)) >= ROW_GROUP or index + 1 == store.plan.chunks:
            yield pa.concat_tables(gathered).unify_dictionaries().combine_chunks()
            gathered = []


def stability_counts(store: Store) -> dict[str | None, int]:
    """How many cells of the result have which type of motion; None where there is no motion."""
    counts: Counter[str | None] = Counter()
    with pq.ParquetFile(store.result) as file:
        for batch in file.iter_batches(columns=["stability"], batch_size=ROW_GROUP):
            for pair in batch.column(0).value_counts().to_pylist():
                counts[pair["values"]] += pair["counts"]
    return dict(counts)
