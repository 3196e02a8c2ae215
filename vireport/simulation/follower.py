"""One ball followed from impact to impact in blocks, until a recogniser of its caller says what it comes to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from vireport.simulation.events import as_start, follow_one
from vireport.simulation.kernel import RUNNING

Array = NDArray[np.float64]

ROUNDINGS = 64 * 2.2e-16
TWINS = ROUNDINGS, -ROUNDINGS, 3 * ROUNDINGS
"""Relative changes of an impact velocity from which twins of a trajectory start: a single one would end alike by
chance."""


class Trajectory:
    """The trajectory of one ball, continued block by block: its last impacts, and whether it still strikes a membrane.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    rows : array (n, 6)
        Impacts so far, see `kernel`; the first may be the start.
    summary : array (3,)
        Summary of `follow_one`.
    keep : int, optional
        Number of impacts kept of a block; all by default.
    compiled : bool
        Whether to compile the search, where numba is there.
    """

    def __init__(
        self, model: Array, rows: Array, summary: Array, keep: int | None = None, compiled: bool = True
    ) -> None:
        self.model, self.keep, self.compiled = model, keep, compiled
        self.rows, self.status, self.impacts = rows, float(summary[2]), int(summary[0])

    @classmethod
    def begun(
        cls, model: Array, start: Sequence[float], impacts: int, keep: int | None = None, compiled: bool = True
    ) -> Trajectory:
        """The trajectory from a row of `check_start`, with a first block of at most so many impacts."""
        return cls(model, *follow_one(model, start, impacts, keep, compiled), keep, compiled)

    @property
    def moving(self) -> bool:
        """Whether the ball struck a membrane at the end of its last block, and so goes on."""
        return self.status == RUNNING

    @property
    def last(self) -> tuple[float, float, float, float]:
        """The last impact as a row of `check_start`, to begin a continuation with."""
        return as_start(self.rows[-1])

    def go_on(self, impacts: int, whole: bool = False) -> None:
        """Follow the ball for another block of at most so many impacts.

        Parameters
        ----------
        impacts : int
        whole : bool
            Whether earlier impacts are kept; else those of the block take their place.
        """
        # The last impact is the first row of the block: one that repeats it would count twice.
        rows, summary = follow_one(self.model, self.last, impacts, self.keep, self.compiled)
        self.rows = np.concatenate([self.rows, rows[1:]]) if whole else rows
        self.status, self.impacts = float(summary[2]), self.impacts + int(summary[0])


def twins(row: Array, count: int) -> Iterator[tuple[float, float, float, float]]:
    """Starts a few roundings from an impact, a row of `kernel`: where they end alike, rounding does not decide."""
    for off in TWINS[:count]:
        wall, position, velocity, phase = as_start(row)
        yield wall, position, velocity * (1 + off), phase
