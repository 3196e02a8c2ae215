"""Rectangles of two coordinates that are proved, or halved: what a proof consists of, and what repeats it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

PROVED, OPEN = -1, -2
"""What a cell that is not halved came to; what is halved has the number of the coordinate along which it is."""


class Cells(Struct, frozen=True, eq=False):
    """Rectangles of two coordinates: ends (2, k), and the impact of the motion that each is about (k,)."""

    low: Floats
    high: Floats
    impact: Ints

    def __getitem__(self, rows: Ints | Mask | slice) -> Cells:
        return Cells(self.low[:, rows], self.high[:, rows], self.impact[rows])

    def __len__(self) -> int:
        return len(self.impact)

    @property
    def smallest(self) -> Floats:
        """The smallest size of the second coordinate in each."""
        return np.asarray(np.minimum(np.abs(self.low[1]), np.abs(self.high[1])))

    @property
    def area(self) -> Floats:
        """Area of each rectangle, the product of its sides."""
        return np.asarray(np.prod(self.high - self.low, axis=0))

    def halves(self, coordinate: Ints) -> Cells:
        """Both halves of each, the lower one first."""
        low, high = np.repeat(self.low, 2, axis=1), np.repeat(self.high, 2, axis=1)
        lower = 2 * np.arange(len(coordinate))
        middle = (low[coordinate, lower] + high[coordinate, lower]) / 2
        high[coordinate, lower] = low[coordinate, lower + 1] = middle
        return Cells(low, high, np.repeat(self.impact, 2))


class Halving:
    """Cells, and those that they have been halved into.

    Attributes
    ----------
    cells : Cells
    code : ndarray of int
        Of each: `PROVED`, `OPEN`, or the coordinate along which it was halved.
    """

    def __init__(self, first: Cells) -> None:
        self.cells, self._first = first, len(first)
        self.code, self._child = np.full(len(first), OPEN), np.zeros(len(first), np.intp)

    def halve(self, rows: Ints, coordinate: Ints) -> Ints:
        """Halve some cells; the numbers of their halves."""
        new = len(self.code) + np.arange(2 * len(rows))
        self.code[rows], self._child[rows] = coordinate, new[::2]
        self.cells = joined_cells([self.cells, self.cells[rows].halves(coordinate)])
        self.code = np.concatenate([self.code, np.full(len(new), OPEN)])
        self._child = np.concatenate([self._child, np.zeros(len(new), np.intp)])
        return new

    @property
    def codes(self) -> Ints:
        """The codes generation by generation, each from the lower half of the first cell on."""
        of, rows = [], np.arange(self._first)
        while rows.size:
            of.append(self.code[rows])
            rows = (self._child[rows[self.code[rows] >= 0]][:, None] + np.arange(2)).ravel()
        return np.concatenate(of)


def joined_cells(parts: Sequence[Cells]) -> Cells:
    """Cells of several, one after the other."""
    low, high = (np.concatenate([getattr(part, end) for part in parts], axis=1) for end in ("low", "high"))
    return Cells(low, high, np.concatenate([part.impact for part in parts]))


def generations(first: Cells, codes: Ints) -> Iterator[tuple[Cells, Ints]]:
    """The cells of each generation with their codes, from the first ones and all codes.

    Raises
    ------
    ValueError
        If there are not as many cells as it takes.
    """
    cells = first
    while len(cells):
        code, codes = codes[: len(cells)], codes[len(cells) :]
        if len(code) < len(cells) or (code > 1).any() or (code < OPEN).any():
            raise ValueError("the cells of the proof are not complete")
        yield cells, code
        cells = cells[code >= 0].halves(code[code >= 0])
