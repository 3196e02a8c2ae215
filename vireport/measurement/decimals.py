"""Rows of plain decimal numbers, such as -12.345, read twice as fast as by general readers, and to the same bits.

A decimal with an integer below 2^53 and at most 22 places is that integer over a power of ten, both exact in doubles:
one division rounds as a reader digit by digit does. Whatever else stands in a file is left to such a reader.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]

BLOCK = 1 << 18
"""Bytes that are read at once: their numbers stay in the processor's cache."""

MOST_DIGITS, LARGEST, MOST_PLACES = 18, 2**53, 22
"""Digits that an integer of 64 bits holds, the largest that a double holds exactly, and as a power of ten."""

COMMA, LINE, POINT, PLUS, MINUS, NOUGHT = b",\n.+-0"

POWERS = 10 ** np.arange(MOST_DIGITS + 1)
TENS = 10.0 ** np.arange(MOST_PLACES + 1)


def decimal_rows(data: bytes, start: int, columns: int) -> Floats | None:
    """Numbers of lines, separated by commas; None where anything is not a plain decimal number in its place.

    Parameters
    ----------
    data : bytes
        Of a file.
    start : int
        Where its rows begin.
    columns : int
        In each row.

    Returns
    -------
    ndarray, shape (rows, columns), or None
    """
    end = len(data)
    while end > start and data[end - 1] in b"\r\n":
        end -= 1
    blocks = []
    while start < end:
        stop = data.find(b"\n", min(start + BLOCK, end), end)
        stop = end if stop < 0 else stop
        block = data[start:stop] + b"\n"
        if b"\r" in block:
            block = block.replace(b"\r\n", b"\n")
        rows = _block(np.frombuffer(block, np.uint8), columns)
        if rows is None:
            return None
        blocks.append(rows)
        start = stop + 1
    return np.concatenate(blocks) if blocks else None


def _block(text: Bytes, columns: int) -> Floats | None:
    """Numbers of some whole lines; see `decimal_rows`."""
    ends = np.flatnonzero((text == COMMA) | (text == LINE))
    if len(ends) % columns:
        return None
    marks = text[ends].reshape(-1, columns)
    if not ((marks[:, :-1] == COMMA).all() and (marks[:, -1] == LINE).all()):
        return None
    starts = np.concatenate([[0], ends[:-1] + 1])
    digits = text - np.uint8(NOUGHT)  # what is no digit is 10 and more, as bytes have no sign
    are = digits < 10
    before = np.cumsum(are, dtype=np.int32)
    whole = before[ends]
    counts = np.diff(whole, prepend=0)
    if counts.min() < 1 or counts.max() > MOST_DIGITS:
        return None
    points = np.flatnonzero(text == POINT)
    each = len(points) == len(ends) and bool(((points >= starts) & (points < ends)).all())
    cells = np.arange(len(ends)) if each else np.searchsorted(ends, points)
    first = text[starts]
    signs = (first == MINUS) | (first == PLUS)
    # Every byte is a digit, a separator, the one point of its cell or the sign at its beginning.
    if (np.diff(cells) < 1).any() or len(text) != whole[-1] + len(ends) + len(points) + np.count_nonzero(signs):
        return None
    after = np.repeat(whole, ends - starts + 1) - before
    integers = np.add.reduceat((digits * are) * POWERS.take(after, mode="clip"), starts)
    places = np.zeros(len(ends), dtype=np.intp)
    places[cells] = whole[cells] - before[points]
    if integers.max() > LARGEST:
        return None
    values = integers / TENS[places]
    np.negative(values, where=first == MINUS, out=values)
    return np.asarray(values.reshape(-1, columns))
