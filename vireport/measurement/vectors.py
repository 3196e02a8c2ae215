"""Named vectors that a library reads from a file: what they may unfold to, and the table that they make."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vireport.base.errors import UsageError, VireportError
from vireport.measurement.tables import LARGEST_FILE_OF_SIGNALS, RecordedTable, Title, Wanted
from vireport.text.foreign import visible

LEAST_BUDGET, MOST_UNFOLDED = 100_000_000, 100
"""Bytes that any file may unfold to, and how many times its size if that is more. Recorded signals are packed to a
tenth at best, a channel without one to a thousandth."""

NOTHING = np.empty(0, dtype=object)
"""Stands for what holds no real numbers."""

RATE = "sampling_rate_hz"
"""Name of the number of samples in a second, among vectors."""

Stored = Callable[[Sequence[int]], Mapping[int, Any]]
"""From places of variables to their arrays; empty ones stand for what holds no real numbers."""


def budget_of(data: bytes) -> int:
    """Bytes that a file may unfold to."""
    return min(LARGEST_FILE_OF_SIGNALS, max(LEAST_BUDGET, MOST_UNFOLDED * len(data)))


def library_read(name: str, kind: str, read: Callable[[], RecordedTable]) -> RecordedTable:
    """Read by a library, which may raise anything of bytes that are no file of its kind.

    Raises
    ------
    UsageError
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read()
    except VireportError:
        raise
    except Exception as error:
        raise UsageError(f"{name} cannot be read as {kind}: {visible(str(error), 200)}") from error


def table_of_vectors(name: str, kind: str, titles: list[Title], stored: Stored, wanted: Wanted) -> RecordedTable:
    """A table of named vectors of one length, among which a number of the name `RATE` is its rate.

    Raises
    ------
    UsageError
        If what is wanted is no vector of real numbers, or not as long as the others.
    """
    if not titles:
        raise UsageError(f"{name}: the file has no variables (allowed: vectors named as columns)")
    signals = [k for k, title in enumerate(titles) if title.name != RATE]
    places = [signals[k] for k in wanted([titles[k] for k in signals])]
    of_rate = [k for k, title in enumerate(titles) if title.name == RATE]
    arrays, columns = stored([*places, *of_rate]), {}
    for k in places:
        values = arrays[k]
        if values.dtype.kind not in "fiu" or values.size != max(values.shape, default=0):
            raise UsageError(f"{name}: {titles[k].name}: is no vector of real numbers (allowed: one)")
        columns[signals.index(k)] = np.asarray(values, dtype=float).ravel()
    if len(lengths := {len(column) for column in columns.values()}) > 1:
        raise UsageError(f"{name}: vectors of {min(lengths)} to {max(lengths)} samples (allowed: all of one length)")
    step = 0.0
    for k in of_rate:
        rate = arrays[k]
        if rate.size != 1 or rate.dtype.kind not in "fiu" or not 0 < (hertz := float(rate.ravel()[0])) < np.inf:
            raise UsageError(f"{name}: {RATE}: is no positive number (allowed: samples in a second)")
        step = 1 / hertz
    return RecordedTable(kind, tuple(titles[k] for k in signals), columns, step)


def too_large(name: str) -> UsageError:
    """The error about a file that unfolds to more than its budget."""
    allowed = f"(allowed: up to {MOST_UNFOLDED} times its size, or {LEAST_BUDGET // 10**6} MB)"
    return UsageError(f"{name}: it unfolds to more than signals that were recorded {allowed}")
