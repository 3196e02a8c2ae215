"""Vectors of MATLAB and HDF5 files, read only after it is certain that they are in the file and how large they unfold.

A few kilobytes can stand for gigabytes: packed, never written, or in other files of the machine. What is read is stored
in the file itself, and unfolds to no more than its budget.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from math import prod
from typing import Any

import numpy as np
from msgspec.structs import replace

from vireport.base.errors import UsageError
from vireport.measurement.tables import RecordedTable, Title, Wanted
from vireport.measurement.vectors import NOTHING, budget_of, library_read, table_of_vectors, too_large
from vireport.scenario.blocks import LayoutBlock

HDF5 = b"\x89HDF\r\n\x1a\n"
"""With which a file of that format begins."""

NUMERIC = "double", "single", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
"""What MATLAB calls arrays of real numbers, which complex ones are as well: these differ by their type."""

ORDER_AT, FIRST_AT, TAG = 126, 128, 8
"""Where a file up to version 7 tells the order of its bytes, where its first variable begins, and bytes of its tag."""

PACKED = 15
"""Tag of a variable that is packed by zlib."""

ZLIB = 1
FILTERS = {ZLIB, 2, 3}
"""Of HDF5, which MATLAB packs by: zlib, shuffled bytes and a checksum."""

LONGEST_CLASS = 64
"""Bytes of the name of a class."""


def read_matlab(name: str, data: bytes, keys: LayoutBlock, wanted: Wanted) -> RecordedTable:
    """Read the vectors of a MATLAB file up to version 7.

    Raises
    ------
    UsageError
        If it is no such file, or what is read is not in it, or larger than its budget.
    """
    from scipy.io import loadmat, whosmat  # type: ignore[import-untyped]

    budget = budget_of(data)

    def read() -> RecordedTable:
        plain = _unpacked(name, data, budget)
        kinds = {title: kind for title, _, kind in whosmat(io.BytesIO(plain))}
        names = list(kinds)
        titles = [replace(Title.of(title), numeric=kinds[title] in NUMERIC) for title in names]

        def stored(places: Sequence[int]) -> Mapping[int, Any]:
            # Of cells and structures, which may be nested without end, nothing is looked at.
            numeric = [names[k] for k in places if kinds[names[k]] in NUMERIC]
            arrays = loadmat(io.BytesIO(plain), variable_names=numeric) if numeric else {}
            return {k: arrays.get(names[k], NOTHING) for k in places}

        return table_of_vectors(name, "MATLAB file", titles, stored, wanted)

    return library_read(name, "a MATLAB file", read)


def read_hdf5(name: str, data: bytes, keys: LayoutBlock, wanted: Wanted) -> RecordedTable:
    """Read the vectors of an HDF5 file, among these MATLAB's of version 7.3.

    Raises
    ------
    UsageError
        As `read_matlab`.
    """
    import h5py  # type: ignore[import-untyped]

    of_matlab = not data.startswith(HDF5)

    def read() -> RecordedTable:
        with h5py.File(io.BytesIO(data), "r") as file:
            # Beside variables there are groups of MATLAB's own, such as #refs#.
            paths = [title for title in file if not title.startswith("#")] if of_matlab else list(_datasets(file))
            titles = [_title(file, path, of_matlab) for path in paths]

            def stored(places: Sequence[int]) -> Mapping[int, Any]:
                budget = budget_of(data)
                # All of them are looked at before any is read.
                variables = {k: _variable(f"{name}: {paths[k]}", file, paths[k], of_matlab) for k in places}
                for k, variable in variables.items():
                    if variable is not None:
                        budget -= _unfolded(f"{name}: {paths[k]}", variable, data, budget)
                return {k: NOTHING if v is None else np.asarray(v[()]).T for k, v in variables.items()}

            kind = "MATLAB file of version 7.3" if of_matlab else "HDF5 file"
            return table_of_vectors(name, kind, titles, stored, wanted)

    return library_read(name, "a MATLAB file" if of_matlab else "an HDF5 file", read)


MOST_VARIABLES, DEEPEST = 1000, 5
"""Datasets of a file, and groups that they are in, up to which they are looked at."""


def _datasets(group: Any, before: str = "", depth: int = 0) -> Iterator[str]:
    """Paths of the datasets of a file; what is behind a link is none."""
    import h5py

    for title in islice(group, MOST_VARIABLES):
        if not isinstance(group.get(title, getlink=True), h5py.HardLink):
            continue
        inner = group[title]
        if isinstance(inner, h5py.Dataset):
            yield f"{before}{title}"
        elif isinstance(inner, h5py.Group) and depth < DEEPEST:
            yield from _datasets(inner, f"{before}{title}/", depth + 1)


def _title(file: Any, path: str, of_matlab: bool) -> Title:
    """The title of a dataset, whose unit an attribute may state."""
    import h5py

    if not isinstance(file.get(path, getlink=True), h5py.HardLink) or not isinstance(file[path], h5py.Dataset):
        return Title(path, None, False)
    stored, unit = file[path], ""
    for attribute in ("unit", "units"):
        if attribute in stored.attrs and stored.attrs.get_id(attribute).get_storage_size() <= LONGEST_CLASS:
            text = stored.attrs[attribute]
            unit = text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)
    numeric = stored.dtype.kind in "fiu" and (not of_matlab or _is_numeric(stored))
    return replace(Title.of(path, unit), numeric=numeric)


def _variable(name: str, file: Any, path: str, of_matlab: bool) -> Any:
    """A dataset of real numbers; None of anything else.

    Raises
    ------
    UsageError
        If it is a link.
    """
    import h5py

    if not isinstance(file.get(path, getlink=True), h5py.HardLink):
        raise UsageError(f"{name}: is a link (allowed: the vector itself, in this file)")
    stored = file[path]
    is_vector = isinstance(stored, h5py.Dataset) and stored.dtype.kind in "fiu" and stored.shape is not None
    return stored if is_vector and (not of_matlab or _is_numeric(stored)) else None


def _unpacked(name: str, data: bytes, budget: int) -> bytes:
    """A file up to version 7 with its packed variables unpacked; one of version 4 has none."""
    order = {b"IM": "<", b"MI": ">"}.get(data[ORDER_AT:FIRST_AT])
    if order is None or 0 in data[:4]:
        return data
    parts, place, left = [data[:FIRST_AT]], FIRST_AT, budget
    while place + TAG <= len(data):
        kind, count = struct.unpack_from(f"{order}II", data, place)
        end = place + TAG + count
        packed = data[place:end]
        if kind == PACKED:
            packing = zlib.decompressobj()
            packed = packing.decompress(data[place + TAG : end], left + 1)
            if len(packed) <= left and not packing.eof:
                raise UsageError(f"{name}: the file is cut off (allowed: one that is complete)")
        left -= len(packed)
        if left < 0:
            raise too_large(name)
        parts.append(packed)
        place = end
    return b"".join(parts)


def _is_numeric(stored: Any) -> bool:
    """Whether a variable of version 7.3 is an array of numbers that has some."""
    if "MATLAB_class" not in stored.attrs or "MATLAB_empty" in stored.attrs or not stored.shape:
        return False
    attribute = stored.attrs.get_id("MATLAB_class")
    if attribute.shape != () or attribute.get_storage_size() > LONGEST_CLASS or stored.dtype.kind not in "fiu":
        return False
    kind = stored.attrs["MATLAB_class"]
    return (kind.decode("ascii", "replace") if isinstance(kind, bytes) else str(kind)) in NUMERIC


def _unfolded(name: str, stored: Any, data: bytes, budget: int) -> int:
    """Bytes that an array of version 7.3 takes when it is read.

    Raises
    ------
    UsageError
        If its numbers are not all in the file, or take more than the budget.
    """
    from h5py import h5d

    if stored.is_virtual or stored.external:
        raise UsageError(f"{name}: its numbers are in other files (allowed: in this one)")
    size, count = int(stored.dtype.itemsize), int(stored.size)
    taken = 8 * count
    unwritten = UsageError(f"{name}: samples of it were never written (allowed: a file that is complete)")
    creation = stored.id.get_create_plist()
    if creation.get_layout() != h5d.CHUNKED:
        if stored.id.get_storage_size() != size * count or size * count > len(data):
            raise unwritten
        if taken > budget:
            raise too_large(name)
        return taken
    kinds = [creation.get_filter(k)[0] for k in range(creation.get_nfilters())]
    if not FILTERS.issuperset(kinds):
        raise UsageError(f"{name}: is packed in a way that MATLAB does not know (allowed: as it saves with -v7.3)")
    shape, chunk = ([int(length) for length in lengths] for lengths in (stored.shape, stored.chunks))
    parts = prod(-(-whole // part) for whole, part in zip(shape, chunk, strict=True))
    chunk_bytes = size * prod(chunk)
    # A chunk is read as a whole, however little of it is used.
    if (taken := max(taken, parts * chunk_bytes)) > budget:
        raise too_large(name)
    chunks: list[Any] = []
    stored.id.chunk_iter(chunks.append)
    if len(chunks) != parts:
        raise unwritten
    for piece in chunks:
        if ZLIB not in kinds or piece.filter_mask >> kinds.index(ZLIB) & 1:
            continue
        if piece.size > len(data):
            raise unwritten
        _, raw = stored.id.read_direct_chunk(piece.chunk_offset)
        if len(zlib.decompressobj().decompress(raw, chunk_bytes + 1)) > chunk_bytes:
            raise too_large(name)
    return taken
