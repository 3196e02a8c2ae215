"""Motions with four impacts, searched for over a grid of all their flight times.

Above each triple of flight times there is one solution, and it is a motion of a sweep where two conditions hold: a
curve, which passes cells in whose corners the signs of both differ.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vireport.sequences.equations import Model
from vireport.sequences.exclusion import Wanted, may_hold, wanted
from vireport.sequences.motions import Sequence
from vireport.sequences.surface import Motions, motions_above, onto_sweep, solution

Floats = NDArray[np.float64]

FINEST, MOST_POINTS = 1 / 12, 300_000
"""Side of the cells [t_c], and the number of corners from which they are larger."""

SLACK = 0.5
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
    count = round(2 * sequence.periods / side)
    found, before = [], None
    for i in range(count + 1):  # plane by plane, so that numbers stay in the processor's cache
        grid = side * np.arange(count - i + 2.0)
        x = solution(sequence, [np.full((1, 1), i * side), grid[:, None], grid[None, :]], model.r)
        conditions = wanted(x, sequence, model, low, high)
        values = np.stack(np.broadcast_arrays(*conditions.zero, *conditions.inside, *conditions.positive))
        ends = _of_four(np.minimum, values), _of_four(np.maximum, values)
        if before is not None:
            cut = np.s_[:, : ends[0].shape[1], : ends[0].shape[2]]
            least, largest = np.minimum(before[0][cut], ends[0]), np.maximum(before[1][cut], ends[1])
            slack = SLACK * (largest - least)
            bounds = iter(zip(least - slack, largest + slack, strict=True))
            rows, columns = np.nonzero(may_hold(Wanted(*([next(bounds) for _ in part] for part in conditions))))
            found.append(np.stack([np.full(len(rows), i - 1), rows, columns]))
        before = ends
    index = np.concatenate(found, axis=1)
    centre = np.asarray((index[:, index.sum(axis=0) < count] + 0.5) * side)
    motions, flights = onto_sweep(motions_above(sequence, centre, model.r), centre, model.level, 2 * side)
    coordinate = motions.coordinate(model.level)
    inside = (coordinate > low) & (coordinate < high) & motions.admissible
    return motions[inside], flights[:, inside]


def _of_four(choose: np.ufunc, values: Floats) -> Floats:
    """The least or the largest of the values in the corners of each square of a plane."""
    rows = choose(values[:, :-1], values[:, 1:])
    return np.asarray(choose(rows[:, :, :-1], rows[:, :, 1:]))
