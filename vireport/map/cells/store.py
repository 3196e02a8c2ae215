"""Where a map is kept: an Arrow file for each chunk while it is computed, and a Parquet file when it is done.

Every file says in its metadata which map and which chunk it is and what computed it, and has a SHA-256 digest of all
its bytes: a chunk before them, the finished map in a file beside it, in the format of ``sha256sum``. A digest is
compared before a file is read, since a damaged one may end the process that reads it. So a file is used for what it is,
whatever happened to it or to the run that wrote it: one that is damaged, missing or in the wrong place is computed
again. Files are written under another name and renamed.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import stat
from collections.abc import Collection, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from itertools import chain
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pq  # type: ignore[import-untyped]
from filelock import FileLock, Timeout
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.encoding import json_text
from vireport.base.errors import UsageError
from vireport.base.files import writable, write_whole
from vireport.base.version import __version__
from vireport.map.cells.cells import MapPlan
from vireport.map.cells.evaluation import evaluate, schema_of

RESULT = "map.parquet"
DIGEST = "map.parquet.sha256"
UNFINISHED = ".map.parquet.new"
CHUNKS = ".chunks"
LOCK = ".lock"
UNFINISHED_CHUNK = ".*.chunk.*"
CHUNK_NAME = re.compile(r"(\d{9})\.chunk")

ROW_GROUP = 131_072
"""Rows of a row group of the result, at least: readers work on one at a time."""

DICTIONARY = ("motions", "stable", "stability", "gbar", "d", "word", "from_rest", "from_rest_word", "from_rest_periods")
"""Columns beside the axes whose values recur. The others are stored plainly: compression would gain little."""

IDENTITY = b"vireport"
"""Key under which a file says what it is."""

DIGEST_SIZE = hashlib.sha256().digest_size
"""Bytes before the cells of a chunk."""

PART = 8192
"""Cells of a chunk that are evaluated at once: their arrays stay in the processor's cache. Larger ones would be given
back to the system after each step, and asked for anew, by workers of Dask, which hold on to hardly any free memory:
that takes as long as the cells."""

SAMPLE = 1024
"""Cells that are evaluated to estimate the size of a map."""

SIMULATED_BYTES, FROM_REST_BYTES, SHOCK_BYTES, ESCAPE_BYTES = 9, 12, 16, 8
"""Sizes in that estimate of what is simulated in a cell: a share, or numbers, and words that recur."""


class Identity(Struct, frozen=True, forbid_unknown_fields=True):
    """The map, versions and chunk that a file belongs to.

    Attributes
    ----------
    map_sha256 : str
        SHA-256 of the map file.
    vireport, numpy : str
        Versions that computed it: results may differ between them in the last bits.
    cells, chunks : int
        Numbers of cells and chunks of the whole map.
    chunk : int or None
        Number of the chunk; None for the whole map.
    """

    map_sha256: str
    vireport: str
    numpy: str
    cells: int
    chunks: int
    chunk: int | None = None

    def metadata(self) -> dict[bytes, bytes]:
        """Return the identity as metadata of a Parquet file."""
        return {IDENTITY: json_text(self).encode()}


def identity_of(plan: MapPlan, map_sha256: str, chunk: int | None) -> Identity:
    """The identity of a computation: plan, file and program."""
    return Identity(map_sha256, __version__, np.__version__, plan.cells, plan.chunks, chunk)


class RejectedFileError(Exception):
    """A file that is damaged, or is not what its name says; `identity` is what it is, where that can be read."""

    def __init__(self, reason: str, identity: Identity | None = None) -> None:
        self.identity = identity
        super().__init__(reason)


class Store(Struct, frozen=True):
    """The folder in which a map is computed and kept.

    Attributes
    ----------
    folder : Path
    plan : MapPlan
    map_sha256 : str
        Of the map file.
    text : str
        The map file, which the result carries along.
    """

    folder: Path
    plan: MapPlan
    map_sha256: str
    text: str

    @property
    def result(self) -> Path:
        """The file of the finished map."""
        return self.folder / RESULT

    @property
    def digest(self) -> Path:
        """The digest of the finished map."""
        return self.folder / DIGEST

    @property
    def chunks(self) -> Path:
        """The folder in which the chunks of the map are kept."""
        return self.folder / CHUNKS

    def chunk(self, number: int) -> Path:
        """The file in which a chunk is kept, by its number."""
        return self.chunks / f"{number:09d}.chunk"

    def identity(self, chunk: int | None = None) -> Identity:
        """Return the identity of the whole map or of a chunk, computed here and now."""
        return identity_of(self.plan, self.map_sha256, chunk)


@contextmanager
def opened(store: Store) -> Iterator[None]:
    """Hold the folder of a map for one run: made if it is not there, cleared of what killed runs left unfinished.

    Raises
    ------
    UsageError
        Where another run holds it, it cannot be written to, or something other than a file is where one belongs.
    """
    lock = FileLock(store.folder / LOCK, timeout=0)
    with writing(store.folder):
        store.folder.mkdir(parents=True, exist_ok=True)
        _require(store.chunks, stat.S_IFDIR)
        for path in (lock.lock_file, store.result, store.digest):
            _require(Path(path), stat.S_IFREG)
        try:
            # Two runs in one folder would delete each other's unfinished files.
            lock.acquire()
        except Timeout as error:
            raise UsageError(
                f"{store.folder}: another run is writing to this folder (wait until it is done)"
            ) from error
    try:
        with writing(store.folder):
            store.chunks.mkdir(exist_ok=True)
            named = ((store.folder, ".map.parquet.*"), (store.folder, ".map-*.png.*"), (store.chunks, UNFINISHED_CHUNK))
            for path in chain.from_iterable(folder.glob(pattern) for folder, pattern in named):
                path.unlink(missing_ok=True)
        yield
    finally:
        lock.release()


KINDS = {stat.S_IFREG: "a file", stat.S_IFDIR: "a folder", stat.S_IFLNK: "a link", stat.S_IFIFO: "a FIFO"}


def _require(path: Path, kind: int) -> None:
    """Refuse a place where there is something, but not what the map keeps there."""
    with suppress(FileNotFoundError):
        present = stat.S_IFMT(os.lstat(path).st_mode)
        if present != kind:
            raise UsageError(
                f"{path}: is {KINDS.get(present, 'a device')}, where a map keeps {KINDS[kind]} "
                "(delete it, or name another folder with --output)"
            )


def writing(folder: Path) -> AbstractContextManager[None]:
    """Say what to do where something cannot be written.

    Raises
    ------
    UsageError, OutputError
        In the place of an OSError.
    """
    return writable(folder, ". What is computed so far is kept: run the same command again to go on")


def encoded_chunk(plan: MapPlan, map_sha256: str, chunk: int) -> bytes:
    """Compute a chunk, as the bytes of its file."""
    sink, numbers = pa.BufferOutputStream(), plan.numbers(chunk)
    parts = [evaluate(plan, numbers[first : first + PART]) for first in range(0, len(numbers), PART)]
    metadata = identity_of(plan, map_sha256, chunk).metadata()
    table = pa.concat_tables(parts).combine_chunks().replace_schema_metadata(metadata)
    with pa.ipc.new_stream(sink, table.schema) as writer:
        writer.write_table(table)
    data = sink.getvalue()
    return b"".join([hashlib.sha256(data).digest(), data])


def write_chunk(store: Store, chunk: int) -> None:
    """Compute a chunk and write its file."""
    write_whole(store.chunk(chunk), encoded_chunk(store.plan, store.map_sha256, chunk))


def chunk_or_bytes(store: Store, mark: str, chunk: int) -> bytes | None:
    """Compute a chunk on any machine, and write its file if the folder of the map is there; otherwise return its bytes.

    Parameters
    ----------
    store : Store
        With an absolute folder.
    mark : str
        Name of a file among the chunks, by which their folder is recognised.
    chunk : int
    """
    data = encoded_chunk(store.plan, store.map_sha256, chunk)
    if (store.chunks / mark).exists():
        with suppress(OSError):  # as of a folder that may only be read there
            write_whole(store.chunk(chunk), data)
            return None
    return data


def _write(sink: Any, plan: MapPlan, metadata: dict[bytes, bytes], row_groups: Iterable[pa.Table]) -> None:
    schema = schema_of(plan).with_metadata(metadata)
    recurring = [name for name in schema.names if name in plan.names or name in DICTIONARY]
    with pq.ParquetWriter(sink, schema, compression="none", use_dictionary=recurring) as writer:
        for table in row_groups:
            writer.write_table(table.replace_schema_metadata(metadata), row_group_size=len(table))


def read_chunk(store: Store, chunk: int, data: bytes) -> pa.Table:
    """Verify the bytes of the file of a chunk, and read its cells.

    Raises
    ------
    RejectedFileError
    """
    content = memoryview(data)[DIGEST_SIZE:]
    if hashlib.sha256(content).digest() != data[:DIGEST_SIZE]:
        raise RejectedFileError("is damaged")
    try:
        table = pa.ipc.open_stream(content).read_all()
    except pa.ArrowInvalid as error:  # as an earlier version wrote it
        raise RejectedFileError("is of another version") from error
    _require_identity(table.schema.metadata, store.identity(chunk))
    return table


def _require_identity(metadata: Any, expected: Identity) -> None:
    """Refuse what another map, version or chunk has left; the digest of the file has been compared."""
    try:
        identity = msgspec.json.decode(metadata[IDENTITY], type=Identity)
    except (KeyError, TypeError, msgspec.ValidationError):  # of a version that wrote other metadata
        identity = None
    if identity != expected:
        raise RejectedFileError("is of another map or version, or another chunk", identity)


def stored_chunks(store: Store, rejected: list[str]) -> set[int]:
    """Numbers of the chunks that are there and intact; the others are deleted, for a reason added to `rejected`.

    Raises
    ------
    UsageError
        Where all that can be read is of another map: it may be worth keeping. Or where something other than a file is
        in the place of a chunk.
    """
    stored: set[int] = set()
    unusable: list[tuple[Path, RejectedFileError]] = []
    for path in sorted(store.chunks.iterdir()):
        if (name := CHUNK_NAME.fullmatch(path.name)) is None:
            continue
        _require(path, stat.S_IFREG)
        try:
            read_chunk(store, int(name[1]), path.read_bytes())
            stored.add(int(name[1]))
        except RejectedFileError as error:
            unusable.append((path, error))
    others = [reason.identity for _, reason in unusable if reason.identity is not None]
    # Next to chunks that belong to this map, a foreign one is a leftover; alone it may be another map's only copy.
    if not stored:
        _refuse_other_map(store, others)
    for path, reason in unusable:
        path.unlink()
        rejected.append(f"{path} {reason}: computed again")
    return stored


def _refuse_other_map(store: Store, identities: list[Identity]) -> None:
    """Refuse a folder with results of another map, or of this one by other versions."""
    words = {"map_sha256": "the map file", "vireport": "the version of vireport", "numpy": "the version of numpy"}
    stored = store.identity()
    for identity in identities:
        changed = [word for key, word in words.items() if getattr(identity, key) != getattr(stored, key)]
        if changed:
            raise UsageError(
                f"{store.folder}: holds the results of another map: {', '.join(changed)} changed since. They are not "
                "mixed. Name another folder (--output), or delete this one"
            )


def is_finished(store: Store, rejected: list[str]) -> bool:
    """Whether there is the finished map; one that is damaged, or of other versions, is added to `rejected`.

    Raises
    ------
    UsageError
        Where there is a file of that name which is another map, or may be none at all.
    """
    if not store.result.exists():
        return False
    if not store.digest.exists():
        raise UsageError(
            f"{store.result}: is no map, or its digest {DIGEST} is missing (delete it, or name another folder "
            "with --output)"
        )
    if store.digest.read_bytes() != _digest_of(store.result):
        rejected.append(f"{store.result} is damaged: computed again")
        return False
    try:
        with open(store.result, "rb") as finished, pq.ParquetFile(finished) as file:
            _require_identity(file.metadata.metadata, store.identity())
    except RejectedFileError as error:
        _refuse_other_map(store, [error.identity] if error.identity else [])
        rejected.append(f"{store.result} {error}: computed again")
        return False
    return True


def _digest_of(path: Path) -> bytes:
    """The digest of a finished map, as ``sha256sum map.parquet`` prints it."""
    with open(path, "rb") as file:
        return f"{hashlib.file_digest(file, 'sha256').hexdigest()}  {RESULT}\n".encode()


def merge(store: Store, rejected: list[str]) -> None:
    """Put the chunks together as the finished map, with its digest."""
    unfinished = store.folder / UNFINISHED
    metadata = store.identity().metadata() | {b"map": store.text.encode()}
    try:
        # Opened here, as Arrow takes no name that is not UTF-8.
        with open(unfinished, "wb") as file:
            _write(file, store.plan, metadata, _row_groups(store, rejected))
            file.flush()
            # Without it a power failure after the rename could leave the name with an empty file, and the chunks are
            # removed next.
            os.fsync(file.fileno())
        # The digest comes first: a map without one may be a file of the user's, and is not replaced.
        write_whole(store.digest, _digest_of(unfinished))
        os.replace(unfinished, store.result)
    finally:
        unfinished.unlink(missing_ok=True)


def remove_chunks(store: Store) -> None:
    """Remove the chunks of a finished map, and what a process that was killed has left of one."""
    for path in store.chunks.iterdir():
        if CHUNK_NAME.fullmatch(path.name) or path.match(UNFINISHED_CHUNK):
            path.unlink()
    with suppress(OSError):  # there is something else in it
        store.chunks.rmdir()


def _row_groups(store: Store, rejected: list[str]) -> Iterator[pa.Table]:
    """Chunks in their order, joined until they make a row group; one that was damaged meanwhile is computed again."""
    gathered: list[pa.Table] = []
    for number in range(store.plan.chunks):
        path = store.chunk(number)
        try:
            gathered.append(read_chunk(store, number, path.read_bytes()))
        except (FileNotFoundError, RejectedFileError) as error:
            reason = str(error) if isinstance(error, RejectedFileError) else "is missing"
            rejected.append(f"{path} {reason}: computed again")
            write_chunk(store, number)
            gathered.append(read_chunk(store, number, path.read_bytes()))
        if sum(map(len, gathered)) >= ROW_GROUP or number + 1 == store.plan.chunks:
            # Chunks may number their words differently: without one dictionary the writer would need several.
            yield pa.concat_tables(gathered).unify_dictionaries().combine_chunks()
            gathered = []


def require_space(store: Store, stored: Collection[int]) -> None:
    """Refuse a map that will not fit on its disk: its chunks, and the finished file that is made of them.

    The size is that of some cells, spread evenly; in the finished file nulls take no space.

    Raises
    ------
    UsageError
    """
    plan = store.plan
    numbers = np.unique(np.linspace(0, plan.cells - 1, SAMPLE).astype(np.int64))
    sample = evaluate(replace(plan, simulate=None, from_rest=False, shock=False, escape=False), numbers)
    finished = sum(column.type.bit_width / 8 * (len(column) - column.null_count) for column in sample.columns)
    simulated = 0 if plan.simulate is None else SIMULATED_BYTES
    simulated += FROM_REST_BYTES * plan.from_rest + SHOCK_BYTES * plan.shock + ESCAPE_BYTES * plan.escape
    chunk_cell, finished_cell = (size / len(numbers) + simulated for size in (sample.nbytes, finished))
    needed = chunk_cell * (plan.cells - sum(map(plan.rows, stored))) + finished_cell * plan.cells
    free = shutil.disk_usage(store.folder).free
    if needed > free:
        raise UsageError(
            f"{store.folder}: the map needs about {needed / 1e6:,.0f} MB while it is computed, but only "
            f"{free / 1e6:,.0f} MB are free (name a folder on another disk with --output)"
        )
