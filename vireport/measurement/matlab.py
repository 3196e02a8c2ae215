"""Vectors of MATLAB files, read only after it is certain that they are in the file and how large they unfold.

A few kilobytes can stand for gigabytes: packed, never written, or in other files of the machine. What is read is stored
in the file itself, and unfolds to no more than its budget.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Callable, Mapping
from math import prod
from typing import Any

import numpy as np

from vireport.base.errors import UsageError, VireportError, install_command
from vireport.text.foreign import visible

HDF5 = b"\x89HDF\r\n\x1a\n"
"""With which a file of that format begins."""

NUMERIC = "double", "single", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
"""What MATLAB calls arrays of real numbers, which complex ones are as well: these differ by their type."""

LEAST_BUDGET, MOST_UNFOLDED = 100_000_000, 100
"""Bytes that any file may unfold to, and how many times its size if that is more. Recorded signals are packed to a
tenth at best, a channel without one to a thousandth."""

ORDER_AT, FIRST_AT, TAG = 126, 128, 8
"""Where a file up to version 7 tells the order of its bytes, where its first variable begins, and bytes of its tag."""

PACKED = 15
"""Tag of a variable that is packed by zlib."""

ZLIB = 1
FILTERS = {ZLIB, 2, 3}
"""Of HDF5, which MATLAB packs by: zlib, shuffled bytes and a checksum."""

LONGEST_CLASS = 64
"""Bytes of the name of a class."""

Wanted = Callable[[list[str]], list[str]]
"""Which of the variables of some names are read; it refuses names that are not known."""


def vectors(name: str, data: bytes, wanted: Wanted, largest: int) -> Mapping[str, Any]:
    """Arrays of a MATLAB file of any version; empty ones stand for what holds no real numbers.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    data : bytes
    wanted : callable
    largest : int
        Bytes that it may unfold to at most.

    Raises
    ------
    UsageError
        If it is no such file, or what is read is not in it, or larger than its budget.
    """
    budget = min(largest, max(LEAST_BUDGET, MOST_UNFOLDED * len(data)))
    try:
        return (_of_version_7_3 if HDF5 in (data[:8], data[512:520]) else _of_older)(name, data, wanted, budget)
    except VireportError:
        raise
    except Exception as error:  # of bytes that are no MATLAB file, it may raise anything
        raise UsageError(f"{name} cannot be read as a MATLAB file: {visible(str(error), 200)}") from error


def _too_large(name: str) -> UsageError:
    """The error about a file that unfolds to more than its budget."""
    allowed = f"(allowed: up to {MOST_UNFOLDED} times its size, or {LEAST_BUDGET // 10**6} MB)"
    return UsageError(f"{name}: it unfolds to more than signals that were recorded {allowed}")


def _of_older(name: str, data: bytes, wanted: Wanted, budget: int) -> Mapping[str, Any]:
    """As `vectors`, of a file up to version 7."""
    from scipy.io import loadmat, whosmat  # type: ignore[import-untyped]

    plain = _unpacked(name, data, budget)
    kinds = {title: kind for title, _, kind in whosmat(io.BytesIO(plain))}
    titles = wanted(list(kinds))
    # Of cells and structures, which may be nested without end, nothing is looked at.
    numeric = [title for title in titles if kinds[title] in NUMERIC]
    arrays = loadmat(io.BytesIO(plain), variable_names=numeric) if numeric else {}
    return {title: arrays[title] if title in numeric else np.empty(0, dtype=object) for title in titles}


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
            raise _too_large(name)
        parts.append(packed)
        place = end
    return b"".join(parts)


def _of_version_7_3(name: str, data: bytes, wanted: Wanted, budget: int) -> Mapping[str, Any]:
    """As `vectors`, of version 7.3: HDF5 behind a block of text, arrays transposed, with attributes for their class."""
    try:
        import h5py  # type: ignore[import-untyped]
    except ImportError as error:
        needed = f"is a MATLAB file of version 7.3, which needs h5py: {install_command('h5py')}"
        raise UsageError(f"{name} {needed}") from error

    with h5py.File(io.BytesIO(data), "r") as file:
        # Beside variables there are groups of MATLAB's own, such as #refs#.
        titles = wanted([title for title in file if not title.startswith("#")])
        for title in titles:
            if not isinstance(file.get(title, getlink=True), h5py.HardLink):
                raise UsageError(f"{name}: {title}: is a link (allowed: the vector itself, in this file)")
        stored = {title: file[title] for title in titles}
        numeric = {
            title: variable
            for title, variable in stored.items()
            if isinstance(variable, h5py.Dataset) and _is_numeric(variable)
        }
        # All of them are looked at before any is read.
        for title, variable in numeric.items():
            budget -= _unfolded(f"{name}: {title}", variable, data, budget)
        return {
            title: np.asarray(numeric[title][()]).T if title in numeric else np.empty(0, dtype=object)
            for title in titles
        }


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
            raise _too_large(name)
        return taken
    kinds = [creation.get_filter(k)[0] for k in range(creation.get_nfilters())]
    if not FILTERS.issuperset(kinds):
        raise UsageError(f"{name}: is packed in a way that MATLAB does not know (allowed: as it saves with -v7.3)")
    shape, chunk = ([int(length) for length in lengths] for lengths in (stored.shape, stored.chunks))
    parts = prod(-(-whole // part) for whole, part in zip(shape, chunk, strict=True))
    chunk_bytes = size * prod(chunk)
    # A chunk is read as a whole, however little of it is used.
    if (taken := max(taken, parts * chunk_bytes)) > budget:
        raise _too_large(name)
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
            raise _too_large(name)
    return taken
