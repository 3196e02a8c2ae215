"""One ball followed from impact to impact, until something recognises what it comes to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from vireport.simulation.events import as_start, follow_one
from vireport.simulation.kernel import RUNNING

Array = NDArray[np.float64]

ROUNDINGS = 64 * 2.2e-16
TWINS = ROUNDINGS, -ROUNDINGS, 3 * ROUNDINGS
"""By how much a twin starts off, over the velocity of its impact: of several, one would end alike by chance."""


class Trajectory:
    """A ball that is followed block by block: its last impacts, and whether it still strikes a membrane.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    rows : array (n, 6)
        Impacts so far, see `kernel`; the first may be the start.
    summary : array (3,)
        Of `follow_one`.
    keep : int, optional
        Impacts kept of a block; all by default.
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
        """The trajectory from a row of `check_start`, after its first block of impacts."""
        return cls(model, *follow_one(model, start, impacts, keep, compiled), keep, compiled)

    @property
    def moving(self) -> bool:
        """Whether it struck a membrane at the end of its last block, and so goes on."""
        return self.status == RUNNING

    @property
    def last(self) -> tuple[float, float, float, float]:
        """The last impact, as a start."""
        return as_start(self.rows[-1])

    def go_on(self, impacts: int, whole: bool = False) -> None:
        """Follow it for another block: its impacts take the place of those before, or with `whole` come after them."""
        rows, summary = follow_one(self.model, self.last, impacts, self.keep, self.compiled)
        self.rows = np.concatenate([self.rows, rows[1:]]) if whole else rows
        self.status, self.impacts = float(summary[2]), self.impacts + int(summary[0])


def twins(row: Array, count: int) -> Iterator[tuple[float, float, float, float]]:
    """Starts a few roundings from an impact: where they end alike, rounding does not decide the end."""
    for off in TWINS[:count]:
        wall, position, velocity, phase = as_start(row)
        yield wall, position, velocity * (1 + off), phase
