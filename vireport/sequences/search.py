"""Motions with four impacts, searched for over a grid of the times of all of them.

At each three times after the first impact there is one solution, and it is a motion of a sweep where two conditions
hold: a curve, which passes cells in whose corners the signs of both differ.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import Held
from vireport.sequences.equations import Model
from vireport.sequences.motions import Sequence
from vireport.sequences.surface import Motions, Solution, motions_above, onto_sweep, solution, sweep_conditions, within

Floats = NDArray[np.float64]

FINEST, MOST_POINTS = 1 / 16, 400_000
"""Side of the cells [t_c], and the number of corners from which they are larger."""

LAYERS = 8
"""Layers of cells evaluated at once: numbers stay in the processor's cache, and are many enough for NumPy."""

FARTHEST, INSIDE = 2.0, 0.5
"""Sides of a cell from its centre: half of one, and the rest for the curvature of both functions; and where the centre
has the other sign of d, within the cell."""

CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
"""Of a cell, from that with the least times."""

SLOPES = (CORNERS - 0.5) / 2
"""From the values of a function in the corners of a cell to its slopes over the cell's side."""

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
    side, found = side_of(sequence), [np.empty((3, 0))]
    count = round(2 * sequence.periods / side)
    images = (sequence, sequence.mirrored()) if model.level.horizontal else (sequence,)
    # Counted from the third impact, the motions are then the same once more.
    last = (count + 1) // 2 if sequence.rotated(2) in images else count
    for i, x in _layers(sequence, model.r, last):
        crossed = np.all([_crossed(condition) for condition in sweep_conditions(x, model)], axis=0)
        cells = np.stack(np.nonzero(crossed))
        layer, row, column = cells
        cells = cells[:, (row <= layer + i) & (column >= layer)]  # in which the impacts can be in order
        layer, row, column = _starts(x, cells, sequence, model, (low, high))
        found.append(np.stack([row, layer + i, column + i]))
    times = np.concatenate(found, axis=1) * side
    flights = np.maximum(np.diff(times, axis=0, prepend=0.0), side / 4)  # where two times are in one cell
    motions, flights = onto_sweep(motions_above(sequence, flights, model.r), flights, model.level, 2 * side)
    motions, rows = within(motions, model.level, low, high)
    return motions, flights[:, rows]


@lru_cache(maxsize=8)
def _layers(sequence: Sequence, r: float, last: int) -> list[tuple[int, Solution]]:
    """The solutions above the corners of the cells, which are those of every sweep with this restitution coefficient.

    In layers up to a last one, each with the number of its first one; few digits are enough.
    """
    side = side_of(sequence)
    count, layers = round(2 * sequence.periods / side), []
    grid = np.float32(side) * np.arange(count + 1, dtype=np.float32)
    for i in range(0, last, LAYERS):
        j = min(i + LAYERS, count)
        second, first, third = grid[i : j + 1, None, None], grid[None, : j + 1, None], grid[None, None, i:]
        layers.append((i, solution(sequence, [first, second - first, third - second], r)))
    return layers


def _crossed(values: NDArray[Any]) -> NDArray[np.bool_]:
    """In which cells of a grid a function may be zero."""
    least = largest = values
    for _ in values.shape:  # each axis in turn
        least = np.minimum(least[1:], least[:-1]).transpose(1, 2, 0)
        largest = np.maximum(largest[1:], largest[:-1]).transpose(1, 2, 0)
    return _within_slack(least, largest)


def _within_slack(least: NDArray[Any], largest: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether a function between these values in the corners of cells may be zero inside."""
    slack = SLACK * (largest - least)
    return np.asarray((least <= slack) & (largest >= -slack))


def _starts(
    x: Solution, cells: NDArray[np.intp], sequence: Sequence, model: Model, limits: tuple[float, float]
) -> Floats:
    """Where motions of a sweep may be next to the cells of a grid of solutions, in sides of a cell, (3, n).

    To first order both conditions are zero on a line, whose point next to the centre must not be far from the cell; up
    to a side of a cell from that point each velocity and the coordinate must be in its range, but for the slack. In a
    cell in which d changes its sign, and so the factor of the motions, all is smooth for either sign alone.
    """
    index = np.ravel_multi_index(tuple(cells[:, None, :] + CORNERS.T[:, :, None]), x.d.shape)
    sine, cosine, gbar, d, excess = (values.ravel()[index].astype(float) for values in x[2:])
    outward = [v.ravel()[index] * wall for v, wall in zip(x.velocity, sequence.walls, strict=True)]
    level, norm = model.level, np.hypot(sine, cosine)
    found: list[NDArray[Any]] = []
    for sign in (1, -1):
        held = {Held.D: d, Held.GBAR: gbar, Held.RATIO: d - gbar * level.value}[level.held]
        off = sign * held - (0.0 if level.held is Held.RATIO else level.value * norm)
        rows = np.flatnonzero((sign * d > 0).any(axis=0) & _within_slack(off.min(axis=0), off.max(axis=0)))
        both = np.stack([off[:, rows], excess[:, rows]])
        (a, b), (f, g) = SLOPES.T @ both, both.mean(axis=1)
        aa, ab, bb = (a * a).sum(axis=0), (a * b).sum(axis=0), (b * b).sum(axis=0)
        with np.errstate(all="ignore"):
            step = ((ab * g - bb * f) * a + (ab * f - aa * g) * b) / (aa * bb - ab * ab)
            along = np.cross(a, b, axis=0)
            along /= np.sqrt((along * along).sum(axis=0))
        centred = sign * d[:, rows].mean(axis=0) > 0
        near = np.abs(step).max(axis=0) <= np.where(centred, FARTHEST, INSIDE)
        rows, step, along, centred = rows[near], step[:, near], along[:, near], centred[near]
        scale, coordinate = norm[:, rows], sign * (gbar if level.held is Held.D else d)[:, rows]
        ranges = coordinate - limits[0] * scale, limits[1] * scale - coordinate
        positive = np.stack([*ranges, *(sign * part[:, rows] for part in (d, *outward))])
        slopes = SLOPES.T @ positive
        nearest, change = (np.einsum("fin,in->fn", slopes, way) for way in (step, along))
        largest = positive.mean(axis=1) + nearest + np.abs(change) + SLACK * np.abs(slopes).sum(axis=1)
        passed = (largest >= 0).all(axis=0)
        found.append(cells[:, rows[passed]] + 0.5 + np.where(centred, 0.0, step)[:, passed])
    return np.concatenate(found, axis=1)
