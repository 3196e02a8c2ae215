"""The plane of shocks: what a shock leads to, by its moment and size.

Coloured by quadtree: only cells whose corners differ, and their neighbours, are looked into.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.findings.outcomes.returning import Recogniser
from vireport.findings.outcomes.shock import shocked
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.simulation.attractors import Attractor

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

COARSEST = 16
"""Cells of the first grid along either axis, up to a factor of 2."""

UNKNOWN = -1
"""What stands where nothing has been evaluated yet."""

Starts = Callable[[Floats, Floats], Floats]
"""From two coordinates, arrays (n,), to rows of `check_start`, (n, 4)."""


class OutcomePlane(Struct, frozen=True, eq=False):
    """The motions and states in which starts on a regular grid end.

    Attributes
    ----------
    x, y : ndarray (n,), (m,)
        The coordinates of the grid.
    outcome : ndarray of int (m, n)
        Index into `outcomes`.
    outcomes : tuple of Attractor
        The motions and states in which starts end; those that were known beforehand come first.
    evaluated : int
        Points of the grid that were simulated; the others lie in cells that are taken to be of one outcome.
    """

    x: Floats
    y: Floats
    outcome: Ints
    outcomes: tuple[Attractor, ...]
    evaluated: int

    __repr__ = brief

    def share(self, outcome: int) -> float:
        """Share of the grid's points with an outcome."""
        return float(np.mean(self.outcome == outcome))


def shock_plane(groups: Groups[float], motions: Sequence[Motion], largest: float, points: int = 257) -> OutcomePlane:
    """What a jump of the relative velocity leads to, by its moment in the period of a motion and its signed size.

    Parameters
    ----------
    groups : Groups
        Of the device.
    motions : sequence of Motion
        Stable motions; the shocks are to the first one.
    largest : float
        Size of the jumps up to which the plane reaches either way [y_c].
    points : int
        Points along either axis: one more than a power of 2, at least 17.

    Returns
    -------
    OutcomePlane
        With x the time since the first impact [t_c] and y the jump [y_c].
    """
    motion = motions[0]
    begins, durations = motion.time - motion.time[0], motion.durations
    # The end of the period is its beginning: the last point is just before the first impact of the next one.
    period = float(durations.sum()) * (1 - 1e-12)

    def starts(time: Floats, jump: Floats) -> Floats:
        impact = np.clip(np.searchsorted(begins, time, side="right") - 1, 0, len(begins) - 1)
        rows = np.zeros((len(time), 4))
        for i in np.unique(impact).tolist():
            after_this = impact == i
            delay = np.minimum(time[after_this] - begins[i], durations[i] * (1 - 1e-12))
            rows[after_this] = shocked(groups, motion, i, delay, jump[after_this])
        return rows

    x, y = np.linspace(0.0, period, points), np.linspace(-largest, largest, points)
    return coloured(Recogniser(groups, motions), x, y, starts)


def coloured(recognise: Recogniser, x: Floats, y: Floats, starts: Starts, coarsest: int = COARSEST) -> OutcomePlane:
    """Colour a grid of one more than a power of 2 points along either axis, coarse cells first.

    Thin bands are found only where the corners of `coarsest` cells along either axis meet them; with as many cells as
    the grid has, every point is followed.
    """
    size = len(x) - 1
    if size < COARSEST or size & (size - 1):
        raise ValueError(f"points must be one more than a power of 2, and at least {COARSEST + 1}, not {len(x)}")
    label = np.full((len(y), len(x)), UNKNOWN, dtype=np.int64)

    def evaluate(rows: Ints, columns: Ints) -> None:
        flat = np.unique(rows * len(x) + columns)
        row, column = np.divmod(flat, len(x))
        new = label[row, column] == UNKNOWN
        row, column = row[new], column[new]
        if len(row):
            label[row, column] = recognise(starts(x[column], y[row]))

    step = size // coarsest
    corner = np.arange(0, size, step)
    row, column = (grid.ravel() for grid in np.meshgrid(corner, corner, indexing="ij"))
    evaluate(*(grid.ravel() for grid in np.meshgrid(np.arange(0, size + 1, step), np.arange(0, size + 1, step))))
    filled: list[tuple[Ints, Ints, int]] = []
    while step > 1:
        corners = np.stack([label[row + a, column + b] for a in (0, step) for b in (0, step)])
        differ = (corners != corners[0]).any(axis=0)
        # With neighbours: a boundary may cut into a cell between two of its corners. One more cell on each side avoids
        # special cases at the edges of the grid.
        near = np.zeros((size // step + 2, size // step + 2), dtype=bool)
        for a in range(3):
            for b in range(3):
                near[row[differ] // step + a, column[differ] // step + b] = True
        split = near[row // step + 1, column // step + 1]
        filled.append((row[~split], column[~split], step))
        row, column, half = row[split], column[split], step // 2
        for a in (0, half, step):
            for b in (0, half, step):
                if a == half or b == half:
                    evaluate(row + a, column + b)
        row, column = (
            np.concatenate([index + offset for offset in offsets])
            for index, offsets in ((row, (0, 0, half, half)), (column, (0, half, 0, half)))
        )
        step = half
    evaluated = int((label != UNKNOWN).sum())
    for rows, columns, width in filled:
        for i, j in zip(rows.tolist(), columns.tolist(), strict=True):
            cell = label[i : i + width + 1, j : j + width + 1]
            # What finer neighbours have evaluated on the common edge stays.
            cell[cell == UNKNOWN] = cell[0, 0]
    return OutcomePlane(x, y, label, tuple(recognise.outcomes), evaluated)
