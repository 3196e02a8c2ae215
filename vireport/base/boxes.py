"""Boxes in several coordinates, which are halved until something is proved of each."""

from __future__ import annotations

from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]


class Boxes(Struct, frozen=True, eq=False):
    """Boxes in some coordinates: each holds all points from its `low` to its `high`, ends included.

    What is cut from boxes covers them again, so that what none of them holds was left out by a proof.

    Attributes
    ----------
    low, high : ndarray, shape (coordinates, k)
        In each coordinate low is at most high.
    """

    low: Floats
    high: Floats
    __repr__ = brief

    @staticmethod
    def grid(*ends: Floats) -> Boxes:
        """The boxes between neighbouring values of each coordinate."""
        parts = [tuple(at[part] for at in ends) for part in (slice(-1), slice(1, None))]
        low, high = (np.stack(np.meshgrid(*part, indexing="ij")).reshape(len(ends), -1) for part in parts)
        return Boxes(low, high)

    def __len__(self) -> int:
        return int(self.low.shape[1])

    def __getitem__(self, rows: Any) -> Boxes:
        return Boxes(self.low[:, rows], self.high[:, rows])

    def halved(self, axes: Ints) -> Boxes:
        """Both halves of each, the lower one first, cut across a coordinate of its own: of `axes` (k,)."""
        low, high = np.repeat(self.low, 2, axis=1), np.repeat(self.high, 2, axis=1)
        lower = 2 * np.arange(len(self))
        high[axes, lower] = low[axes, lower + 1] = (low[axes, lower] + high[axes, lower]) / 2
        return Boxes(low, high)

    def cut(self) -> Boxes:
        """The parts of all, cut in half across every coordinate."""
        low, high = self.low, self.high
        for axis in range(len(low)):
            middle = (low[axis] + high[axis]) / 2
            upper, lower = low.copy(), high.copy()
            upper[axis], lower[axis] = middle, middle
            low, high = np.hstack([low, upper]), np.hstack([lower, high])
        return Boxes(low, high)
