"""Motions with four impacts, searched for over a grid of all their flight times.

Above each triple of flight times there is one solution, and it is a motion of a sweep where two conditions hold: a
curve, which passes cells in whose corners the signs of both differ.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from vireport.sequences.equations import Model
from vireport.sequences.exclusion import may_hold, wanted
from vireport.sequences.motions import Sequence
from vireport.sequences.surface import Motions, motions_above, onto_sweep, solution

Floats = NDArray[np.float64]

FINEST, MOST_POINTS = 1 / 12, 600_000
"""Side of the cells [t_c], and the number of corners from which they are larger."""

SLACK = 0.25
"""Of the range of a function in the corners of a cell: how far beyond it may go inside, by its curvature."""


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
    count = round(2 * sequence.periods / side)
    index = np.indices((count + 1,) * 3).reshape(3, -1)
    index = index[:, index.sum(axis=0) <= count + 2]
    place = np.zeros((count + 2,) * 3, dtype=np.int32)
    place[tuple(index)] = np.arange(index.shape[1])
    conditions = wanted(solution(sequence, list(index * side), model.r), sequence, model, low, high)
    lower = index[:, (index.sum(axis=0) < count) & (index < count).all(axis=0)]
    corners = np.stack([place[tuple(lower + np.array(corner)[:, None])] for corner in product((0, 1), repeat=3)])

    def bounds(values: Floats) -> tuple[Floats, Floats]:
        at = values[corners]
        least, largest = at.min(axis=0), at.max(axis=0)
        return least - SLACK * (largest - least), largest + SLACK * (largest - least)

    centre = np.asarray((lower[:, may_hold(conditions, bounds)] + 0.5) * side)
    motions, flights = onto_sweep(motions_above(sequence, centre, model.r), centre, model.level, 2 * side)
    coordinate = motions.coordinate(model.level)
    inside = (coordinate > low) & (coordinate < high) & motions.admissible
    return motions[inside], flights[:, inside]
