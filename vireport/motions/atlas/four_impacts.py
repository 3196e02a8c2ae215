"""Candidates for motions with four impacts, by a search over a grid of the times of three of them.

For every three times after the first impact there is one solution of the linear conditions, and it is a motion of a
sweep if two further conditions hold. They hold on a curve, which passes cells at whose corners the signs of both
differ. The search proves nothing: a curve inside a cell is missed.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vireport.motions.atlas.surface import (
    Candidates,
    FlightTimes,
    HomogeneousSolution,
    candidates_above,
    into_range,
    onto_sweep,
    solution,
    sweep_conditions,
    within,
)
from vireport.motions.periodicity import Model
from vireport.motions.sweep import Held
from vireport.physics.groups import Restitution, Restitutions
from vireport.physics.word import Word

Floats = NDArray[np.float64]

FINEST, MOST_POINTS = 1 / 16, 400_000
"""Least side of the cells [t_c], and the number of corners above which the side is larger."""

LAYERS = 8
"""Layers of cells evaluated at once: few enough for the processor's cache, and many enough for NumPy."""

FARTHEST, INSIDE = 2.0, 0.5
"""Distance from the centre of a cell up to which the linearised conditions may be zero, in sides: half a side for the
cell, the rest for the curvature of both functions. And the same where d at the centre has the other sign."""

CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
"""The corners of a cell, in sides from the one with the least times."""

FIT = np.vstack([(CORNERS - 0.5).T / 2, np.full(8, 1 / 8)]).astype(np.float32)
"""Matrix from the values of a function at the corners of a cell to its three slopes per side and its mean."""

SIGNS = np.array([1, -1], np.float32)
"""Signs that the factor of a solution may have."""

SLACK = 0.25
"""How far a function may go inside a cell beyond its values in the corners, as a share of their range."""


def side_of(word: Word) -> float:
    """Side of the cells in which motions are searched for [t_c]."""
    period = 2 * word.periods
    return float(max(FINEST, period / round((6 * MOST_POINTS) ** (1 / 3))))


def four_impacts(model: Model, low: float, high: float, word: Word) -> tuple[Candidates, Floats]:
    """Search for motions with four impacts; returns them with all their flight times but the last.

    Parameters
    ----------
    model : Model
        Groups over the sweep.
    low, high : float
        Range of the coordinate.
    word : Word
        Four impacts, on both membranes.
    """
    # For membranes that are alike the solutions of a word are those of its mirror image, too.
    alike = not isinstance(model.r, Restitutions)
    side, canonical, starts = side_of(word), word.canonical(mirror=alike), [np.empty((3, 0))]
    # Each image that is the word if its impacts are counted from impact i.
    both = (canonical, canonical.mirrored()) if alike else (canonical,)
    images = [(image, i) for image in both for i in range(4) if image.rotated(i) == word]
    if model.level.horizontal or canonical.rotated(2) == canonical:
        del images[1:]  # whose motions are the same
    for layer in _layers(canonical, model.r):
        for image, first in images:
            # Half a period later and in the mirror, all unknowns have the other sign but d.
            x = layer.solution
            seen = layer if image == canonical else layer._replace(solution=x._replace(d=-x.d))
            conditions = sweep_conditions(seen.solution, model)
            cells = np.stack(np.nonzero(np.logical_and.reduce([_crossed(condition) for condition in conditions])))
            # Indices of the times of the third, the second and the fourth impact; only cells in which they can be in
            # order are of use.
            third, second, fourth = cells
            cells = cells[:, (second <= third + layer.first) & (fourth >= third)]
            third, second, fourth = _starts(seen, cells, image, model, (low, high))
            time = side * np.stack([second, third + layer.first, fourth + layer.first])
            flights = np.diff(time, axis=0, prepend=0.0, append=2.0 * word.periods)
            starts.append(np.roll(flights, -first, axis=0)[:-1])
    flights = np.maximum(np.concatenate(starts, axis=1), side / 4)  # where two times are in one cell
    motions, flights = onto_sweep(word, flights, model, 2 * side)
    flights = into_range(motions, flights, model, 2 * side, (low, high))
    motions, rows = within(candidates_above(word, flights, model.r), model.level, low, high)
    return motions, flights[:, rows]


class Layer(NamedTuple):
    """Solutions at the corners of some layers of cells, in single precision.

    Attributes
    ----------
    first : int
        Number of the first layer: the time of the third impact over the side of a cell.
    solution : HomogeneousSolution
        Without its vectors.
    velocity : list of ndarray
        Before each impact, times the factor of the solution.
    """

    first: int
    solution: HomogeneousSolution
    velocity: list[Any]


@lru_cache(maxsize=8)
def _layers(word: Word, r: Restitution) -> list[Layer]:
    """The solutions at the corners of all cells, which are the same for every sweep with this restitution."""
    side = side_of(word)
    count, layers = round(2 * word.periods / side), []
    grid = np.float32(side) * np.arange(count + 1, dtype=np.float32)
    # Counted from the third impact, the motions or their mirror images are then the same once more.
    twice = word.rotated(2) in ((word,) if isinstance(r, Restitutions) else (word, word.mirrored()))
    for i in range(0, (count + 1) // 2 if twice else count, LAYERS):
        j = min(i + LAYERS, count)
        second, first, third = grid[i : j + 1, None, None], grid[None, : j + 1, None], grid[None, None, i:]
        time = [0 * first, first, second, third]
        flights = [after - before for before, after in pairwise(time)]
        x = solution(word, FlightTimes(flights, time=time), r)
        layers.append(Layer(i, x._replace(vectors=[]), x.velocity))
    return layers


def _crossed(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether a function may be zero in each cell of a grid, by its values at the corners."""
    least = largest = values
    for _ in values.shape:  # all three axes in turn
        least = np.minimum(least[1:], least[:-1]).transpose(1, 2, 0)
        largest = np.maximum(largest[1:], largest[:-1]).transpose(1, 2, 0)
    return _within_slack(least, largest)


def _within_slack(least: NDArray[Any], largest: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether a function with these least and largest values at the corners of cells may be zero inside."""
    slack = SLACK * (largest - least)
    return np.asarray((least <= slack) & (largest >= -slack))


def _starts(layer: Layer, cells: NDArray[np.intp], word: Word, model: Model, limits: tuple[float, float]) -> Floats:
    """Places in cells, or next to them, at which motions of a sweep may be, (3, n), in sides of a cell.

    Parameters
    ----------
    layer : Layer
    cells : ndarray of int (3, m)
        Indices of the cells in it.
    word : Word
    model : Model
        Groups over the sweep.
    limits : tuple of float
        Range of the coordinate.

    Notes
    -----
    To first order both conditions are zero on a line, whose point next to the centre must not be far from the cell; up
    to a side of a cell from that point all velocities and the coordinate must be in their ranges, but for the slack. In
    a cell in which d changes its sign, and so does the factor of the motions, the functions are smooth for either sign
    of the factor by itself.
    """
    x = layer.solution
    index = np.ravel_multi_index(tuple(cells), x.d.shape) + np.ravel_multi_index(CORNERS.T, x.d.shape)[:, None]
    d, level = x.d.take(index), model.level
    either = [np.flatnonzero((sign * d > 0).any(axis=0)) for sign in SIGNS]
    rows, sign = np.concatenate(either), np.repeat(SIGNS, [part.size for part in either])
    index, d = index[:, rows], sign * d[:, rows]
    if level.held is Held.RATIO:
        off = d - np.float32(level.value) * sign * x.gbar.take(index)
    else:
        norm = np.hypot(x.sine.take(index), x.cosine.take(index))
        off = (d if level.held is Held.D else sign * x.gbar.take(index)) - np.float32(level.value) * norm
    (a, b), (f, g) = _fitted(np.stack([off, x.excess[0].take(index)]))
    with np.errstate(all="ignore"):
        direction = _cross(a, b)
        size = (direction * direction).sum(axis=0)
        step, direction = _cross(g * a - f * b, direction) / size, direction / np.sqrt(size)
    centred = FIT[-1] @ d > 0
    near = np.flatnonzero(np.abs(step).max(axis=0) <= np.where(centred, FARTHEST, INSIDE))
    rows, index, sign, step, direction = rows[near], index[:, near], sign[near], step[:, near], direction[:, near]
    d, norm = d[:, near], np.hypot(x.sine.take(index), x.cosine.take(index))
    coordinate = sign * x.gbar.take(index) if level.held is Held.D else d
    outward = [sign * wall * v.take(index) for v, wall in zip(layer.velocity, word.walls, strict=True)]
    slopes, mean = _fitted(np.stack([coordinate - limits[0] * norm, limits[1] * norm - coordinate, d, *outward]))
    nearest, change = ((slopes * way).sum(axis=1) for way in (step, direction))
    largest = mean + nearest + np.abs(change) + SLACK * np.abs(slopes).sum(axis=1)
    passed = np.flatnonzero((largest >= 0).all(axis=0))
    return np.asarray(cells[:, rows[passed]] + 0.5 + np.where(centred[near], 0.0, step)[:, passed])


def _fitted(values: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Slopes (m, 3, n) per side of a cell, and means (m, n), of functions by their values at its corners (m, 8, n)."""
    fit = FIT @ values
    return fit[:, :3], fit[:, 3]


def _cross(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """Vector product of vectors (3, n)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
