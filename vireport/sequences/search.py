"""Motions with four impacts, searched for over a grid of all their flight times.

Above each triple of flight times there is one solution, and it is a motion of a sweep where two conditions hold: a
curve, which passes cells in whose corners the signs of both differ.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.sequences.equations import Model
from vireport.sequences.motions import Sequence
from vireport.sequences.surface import Motions, Solution, motions_above, onto_sweep, solution, sweep_conditions

Floats = NDArray[np.float64]

FINEST, MOST_POINTS = 1 / 16, 400_000
"""Side of the cells [t_c], and the number of corners from which they are larger."""

FARTHEST = 1.0
"""Sides of a cell from its centre: half of one, and as much again for the curvature of both functions."""

LAYER = 1 << 14
"""Corners that are evaluated at once: their numbers stay in the processor's cache."""

CORNERS = np.indices((2, 2, 2)).reshape(3, 8)
"""Of a cell, by their distance from its first one."""

SLOPES = (2 * CORNERS.T - 1) / 4
"""From the values of a function in the corners of a cell, in their order, to its slopes over the cell's side."""

SLACK = 0.25
"""Of the range of a function in the corners of a cell: how far beyond it the function may go inside."""


def side_of(sequence: Sequence) -> float:
    """Side of the cells in which motions are searched for [t_c]."""
    period = 2 * sequence.periods
    return float(max(FINEST, period / round((6 * MOST_POINTS) ** (1 / 3))))


def four_impacts(model: Model, low: float, high: float, sequence: Sequence) -> tuple[Motions, Floats]:
    """Motions of a sweep, in the cells that its curve passes, with all their flight times but the last.

    Parameters
    ----------
    model : Model
    low, high : float
        Range of the coordinate.
    sequence : Sequence
        Four impacts, on both membranes.
    """
    side = side_of(sequence)
    count, found = round(2 * sequence.periods / side), []
    for first, x in _grid(sequence, model.r):
        cells = _passed(np.stack(np.broadcast_arrays(*sweep_conditions(x, model))))
        found.append(cells + np.array([[first], [0], [0]]))
    index = np.concatenate(found, axis=1)
    centre = np.asarray((index[:, index.sum(axis=0) < count] + 0.5) * side)
    motions, flights = onto_sweep(motions_above(sequence, centre, model.r), centre, model.level, 2 * side)
    coordinate = motions.coordinate(model.level)
    inside = (coordinate > low) & (coordinate < high) & motions.admissible
    return motions[inside], flights[:, inside]


@lru_cache(maxsize=8)
def _grid(sequence: Sequence, r: float) -> list[tuple[int, Solution]]:
    """The solutions above the corners of the cells, which are those of every sweep with this restitution coefficient.

    In layers of planes, each with the number of its first one; few digits are enough.
    """
    side = side_of(sequence)
    count = round(2 * sequence.periods / side)
    half = sequence.rotated(2) == sequence  # counted from the third impact, the motions are the same once more
    found, first = [], 0
    while first < count:
        grid = np.float32(side) * np.arange(count - first + 2, dtype=np.float32)
        rows = grid[: max(count // 2 + 3 - first, 2)] if half else grid
        last = min(first + max(LAYER // (len(rows) * len(grid)), 1), count)
        planes = np.float32(side) * np.arange(first, last + 1, dtype=np.float32)
        x = solution(sequence, [planes[:, None, None], rows[:, None], grid], r)
        found.append((first, x._replace(velocity=[])))
        first = last
    return found


def _passed(values: NDArray[Any]) -> NDArray[np.intp]:
    """Cells that the curve may pass on which both conditions are zero, whose values in the corners these are (3, n).

    Either may be zero there, and the point that is next to the centre on the line on which the functions are, as linear
    ones, is not far from the cell.
    """
    least = largest = values
    for axis in (1, 2, 3):
        ahead, behind = ((np.s_[:],) * axis + (part,) for part in (np.s_[1:], np.s_[:-1]))
        least, largest = np.minimum(least[ahead], least[behind]), np.maximum(largest[ahead], largest[behind])
    slack = SLACK * (largest - least)
    cells = np.stack(np.nonzero((least <= slack).all(axis=0) & (largest >= -slack).all(axis=0)))
    at = values[:, *(cells[:, :, None] + CORNERS[:, None, :])].astype(float)
    (a, b), (f, g) = at @ SLOPES, at.mean(axis=-1)
    aa, ab, bb = (a * a).sum(axis=1), (a * b).sum(axis=1), (b * b).sum(axis=1)
    size = aa * bb - ab * ab
    with np.errstate(all="ignore"):
        step = ((bb * f - ab * g) / size)[:, None] * a + ((aa * g - ab * f) / size)[:, None] * b
    return cells[:, ~(np.abs(step).max(axis=1) > FARTHEST)]
