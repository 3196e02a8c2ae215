"""Rectangles of two coordinates that are proved, or halved: what a proof consists of, and what repeats it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from vireport.base.boxes import Boxes

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

PROVED, OPEN = -1, -2
"""Codes of cells that are not halved; that of a halved one is the number of the coordinate along which it is."""


class Cells(Boxes, frozen=True, eq=False):
    """Rectangles of two coordinates, each about an impact of a motion.

    Attributes
    ----------
    impact : ndarray of int (k,)
        Number of the impact of the motion that each rectangle is about.
    """

    impact: Ints

    def __getitem__(self, rows: Ints | Mask | slice) -> Cells:
        return Cells(self.low[:, rows], self.high[:, rows], self.impact[rows])

    @property
    def smallest(self) -> Floats:
        """Least modulus of the second coordinate in each cell, which does not change its sign in it."""
        return np.asarray(np.minimum(np.abs(self.low[1]), np.abs(self.high[1])))

    @property
    def area(self) -> Floats:
        """Area of each rectangle, the product of its sides."""
        return np.asarray(np.prod(self.high - self.low, axis=0))

    def halved(self, axes: Ints) -> Cells:
        """Both halves of each cell along its axis in `axes`, about the same impact."""
        halves = Boxes(self.low, self.high).halved(axes)
        return Cells(halves.low, halves.high, np.repeat(self.impact, 2))


class Halving:
    """A binary tree of cells: the first ones, and those that they have been halved into.

    Invariant: the cells that are not halved cover the first ones, without overlap.

    Attributes
    ----------
    cells : Cells
        All of them, in the order in which they came to be.
    code : ndarray of int
        For each cell `PROVED`, `OPEN`, or the coordinate along which it was halved.
    """

    def __init__(self, first: Cells) -> None:
        self.cells, self._first = first, len(first)
        # The number of the lower half of each cell that is halved; the upper one is next.
        self.code, self._child = np.full(len(first), OPEN), np.zeros(len(first), np.intp)

    def halve(self, rows: Ints, coordinate: Ints) -> Ints:
        """Halve some cells along a coordinate each; returns the numbers of their halves."""
        new = len(self.code) + np.arange(2 * len(rows))
        self.code[rows], self._child[rows] = coordinate, new[::2]
        self.cells = joined_cells([self.cells, self.cells[rows].halved(coordinate)])
        self.code = np.concatenate([self.code, np.full(len(new), OPEN)])
        self._child = np.concatenate([self._child, np.zeros(len(new), np.intp)])
        return new

    @property
    def codes(self) -> Ints:
        """The codes generation by generation, each from the lower half of the first cell on.

        With the first cells they determine the tree: the place of a cell follows from the codes of those above it.
        """
        of, rows = [], np.arange(self._first)
        while rows.size:
            of.append(self.code[rows])
            rows = (self._child[rows[self.code[rows] >= 0]][:, None] + np.arange(2)).ravel()
        return np.concatenate(of)


def joined_cells(parts: Sequence[Cells]) -> Cells:
    """Several arrays of cells as one, in their order."""
    low, high = (np.concatenate([getattr(part, end) for part in parts], axis=1) for end in ("low", "high"))
    return Cells(low, high, np.concatenate([part.impact for part in parts]))


def generations(first: Cells, codes: Ints) -> Iterator[tuple[Cells, Ints]]:
    """Rebuild the cells of each generation with their codes, from the first cells and `Halving.codes`.

    Raises
    ------
    ValueError
        If there are fewer codes than cells, or one that is invalid.
    """
    cells = first
    while len(cells):
        code, codes = codes[: len(cells)], codes[len(cells) :]
        # Codes may come from a file: they are claims.
        if len(code) < len(cells) or (code > 1).any() or (code < OPEN).any():
            raise ValueError("the cells of the proof are not complete")
        yield cells, code
        cells = cells[code >= 0].halved(code[code >= 0])
