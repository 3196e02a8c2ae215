"""The best design: a grid over all designs, the best of its cells refined, and what the grid proves of the others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import DesignPoint
from vireport.optimise.cells import Cells, evaluate, keeps_motion
from vireport.optimise.problem import Problem, smallest_margin
from vireport.optimise.refine import refine
from vireport.progress import Progress
from vireport.scenario import WIDEST_MARGIN, Objective
from vireport.study import Study

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

CHUNK = 1024
"""Cells that are tried at once for a margin."""

STARTS, APART, MOST_REFINED = 2, 4.0, 8
"""Cells that are refined from at first, how many spacings they are apart, and the most cells."""

HALVINGS = 12
"""Steps in which the largest margin of the cells is bracketed, to 0.02 %."""

LEVELS = (0.0, 0.01, 0.02, 0.03, 0.05, 0.07, 0.10, 0.14, 0.20, 0.28, 0.40, 0.55)
"""Margins of the front."""


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """A design, with its results as a run has them, and its objective."""

    t: Floats
    study: Study
    value: float

    @property
    def met(self) -> bool:
        """Whether all requirements are met."""
        return all(criterion.passed for criterion in self.study.criteria)

    @property
    def margin(self) -> float:
        """The smallest margin as a share; infinite where stable motion ends in no input."""
        return smallest_margin(cast(DesignPoint, self.study.solution.design))


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What the grid says of all designs.

    Attributes
    ----------
    counts : tuple of int
        Cells along each input.
    stable, within : int
        Cells with a stable motion, and those of them that meet the limits that every cell is judged by.
    best_cell : float or None
        Objective of the best cell that meets all requirements, None where there is none.
    step : float
        Largest difference of the objective between neighbouring cells within `APART` of the best design.
    widest : float or None
        A margin, as a share, that no cell within the limits has; None where it was not looked for.
    elsewhere : int
        Parts of the grid that may hold a better design, by the differences between neighbouring cells to first order,
        and were not refined from.
    """

    counts: tuple[int, ...]
    stable: int
    within: int
    best_cell: float | None = None
    step: float = 0.0
    widest: float | None = None
    elsewhere: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """What a search comes to.

    Attributes
    ----------
    problem : Problem
    best : Point or None
        None where no design was found that meets the requirements.
    nearest : Point or None
        Then the one that comes nearest to it; None where no design has a stable motion.
    front : tuple of Point
        The best designs for rising margins.
    evidence : Evidence
    """

    problem: Problem
    best: Point | None
    nearest: Point | None
    front: tuple[Point, ...]
    evidence: Evidence


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """The cells of a search: designs t (cells, inputs) on a regular grid, ends included."""

    problem: Problem
    counts: tuple[int, ...]
    t: Floats
    cells: Cells

    @property
    def spacing(self) -> Floats:
        """Between neighbouring cells, as shares of the ranges."""
        return 1 / (np.array(self.counts) - 1)

    def within(self) -> Ints:
        """Cells that meet the limits, the best first; in their order where the objective is a margin."""
        rows = np.flatnonzero(self.cells.stable & (np.nan_to_num(self.cells.slack, nan=-1.0) >= 0).all(axis=1))
        value = self.cells.value[rows]
        return rows if np.isnan(value).all() else rows[np.argsort(-value, kind="stable")]

    def near(self, point: Point) -> NDArray[np.bool_]:
        """Cells within `APART` of a design."""
        return np.asarray(np.max(np.abs(self.t - point.t) / self.spacing, axis=1) <= APART)

    def changes(self) -> Floats:
        """For each cell the sum over the inputs of half the largest difference of the objective to a neighbour."""
        value, total = self.cells.value.reshape(self.counts), np.zeros(self.counts)
        for axis in range(value.ndim):
            step = np.nan_to_num(np.abs(np.diff(value, axis=axis)))
            pad = [(0, 0)] * value.ndim
            sides = []
            for side in ((1, 0), (0, 1)):
                pad[axis] = side
                sides.append(np.pad(step, pad))
            total += np.maximum(*sides) / 2
        return total.ravel()


def grid_of(problem: Problem) -> Grid:
    """Evaluate the cells of a search."""
    axes = len(problem.paths)
    count = max(round(problem.design.cells ** (1 / axes)), 3)
    counts = (count,) * axes
    t = np.stack(np.meshgrid(*[np.linspace(0, 1, count)] * axes, indexing="ij"), axis=-1).reshape(-1, axes)
    parts = [evaluate(problem, part) for part in np.array_split(t, max(len(t) // 100_000, 1))]
    whole = Cells(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("stable", "value", "slack")))
    return Grid(problem, counts, t, whole)


def optimise(problem: Problem, progress: Progress | None = None) -> Result:
    """Find the best design, the evidence that it is, and the front of margin against the objective.

    Parameters
    ----------
    problem : Problem
    progress : callable, optional
        Called with each long step as it begins.
    """
    say = progress or (lambda what: None)
    say("evaluating the grid")
    grid = grid_of(problem)
    order = grid.within()
    say("looking for the best design")
    by_margin = problem.objective is Objective.MARGIN
    ranked, widest = _widest(grid, order) if by_margin else (order, None)
    best, tried, left = _climbed(grid, ranked)
    evidence = Evidence(grid.counts, int(grid.cells.stable.sum()), len(order), widest=widest)
    if best is None:
        ranked, widest = _widest(grid, order) if problem.share else (order, None)
        best = _nearest(grid, ranked)
        if best is None or not best.met:
            return Result(problem, None, best, (), replace(evidence, widest=widest))
    if by_margin or not tried:
        return Result(problem, best, None, (), evidence)
    step = 2 * float(grid.changes()[grid.near(best)].max(initial=0.0))
    evidence = replace(evidence, best_cell=float(grid.cells.value[tried[0]]), step=step, elsewhere=len(left))
    say("trading the objective for margin")
    return Result(problem, best, None, _front(grid, order), evidence)


def _climbed(grid: Grid, ranked: Ints) -> tuple[Point | None, list[int], list[int]]:
    """The best of the designs refined from cells, these cells, and cells that might hold a better one."""
    starts, tried = _starts(grid, ranked), list[int]()
    best: Point | None = None
    left: list[int] = []
    while starts:
        point = _refined(grid.problem, grid.t[starts[0]], grid.spacing)
        best = point if best is None or (point is not None and point.value > best.value) else best
        tried, starts = [*tried, starts[0]], starts[1:]
        if not starts and best is not None and grid.problem.objective is not Objective.MARGIN:
            left = _regions(grid, ranked, best, tried)
            starts = left[: MOST_REFINED - len(tried)][:1]
    return best, tried, left


def _passing(grid: Grid, rows: Ints, share: float) -> Iterator[int]:
    """Those of some cells that keep stable motion with every input off by a share, in their order."""
    for first in range(0, len(rows), CHUNK):
        part = rows[first : first + CHUNK]
        yield from part if share <= 0 else part[keeps_motion(grid.problem, grid.t[part], share)]


def _starts(grid: Grid, ranked: Ints) -> list[int]:
    """The first cells that keep the margin required and are some cells apart."""
    starts: list[int] = []
    for tried, row in enumerate(_passing(grid, ranked, grid.problem.share)):
        away = [np.max(np.abs(grid.t[row] - grid.t[other]) / grid.spacing) for other in starts]
        if all(distance >= APART for distance in away):
            starts.append(row)
        if len(starts) == STARTS or tried > CHUNK:
            break
    return starts


def _widest(grid: Grid, rows: Ints) -> tuple[Ints, float | None]:
    """The cells with the largest margins, to within `HALVINGS` halvings, and a margin that none has."""
    if not rows.size:
        return rows, None
    low, high = 0.0, WIDEST_MARGIN / 100
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        passing = np.array(list(_passing(grid, rows, middle)), dtype=np.intp)
        if passing.size:
            rows, low = passing, middle
        else:
            high = middle
    return rows, high if 100 * high < WIDEST_MARGIN else None


def _refined(problem: Problem, start: Floats, spacing: Floats) -> Point | None:
    """The design refined from a cell, or else the cell's own, if it meets all requirements."""
    for t in (refine(problem, start, spacing), start):
        point = None if t is None else _judged(problem, t)
        if point is not None and point.met:
            return point
    return None


def _judged(problem: Problem, t: Floats) -> Point | None:
    """The results of a design; None where it has no stable motion."""
    study = problem.study(t)
    design = study.solution.design
    if design is None or not design.motions.stable.any():
        return None
    return Point(t, study, problem.value_of(study))


def _nearest(grid: Grid, ranked: Ints) -> Point | None:
    """The design whose worst requirement is nearest to being met, from the first cell or that nearest to the limits."""
    stable = np.flatnonzero(grid.cells.stable)
    if not stable.size:
        return None
    start = int(ranked[0] if ranked.size else stable[np.argmax(grid.cells.slack[stable].min(axis=1))])
    refined = refine(grid.problem, grid.t[start], grid.spacing, worst_case=True)
    return _judged(grid.problem, grid.t[start] if refined is None else refined)


def _front(grid: Grid, order: Ints) -> tuple[Point, ...]:
    """The best designs for rising margins: what a larger one costs.

    A cell that fails a margin fails all larger ones, so that each level goes on where the one before has ended.
    """
    points: list[Point] = []
    for level in LEVELS:
        row = next(_passing(grid, order, level), None)
        if row is None:
            break
        order = order[int(np.flatnonzero(order == row)[0]) :]
        if points and points[-1].margin >= level:
            continue
        problem = grid.problem.with_margin(level)
        t = refine(problem, grid.t[row], grid.spacing)
        point = None if t is None else _judged(problem, t)
        if point is not None and point.margin >= level:
            points.append(point)
    return tuple(points)


def _regions(grid: Grid, order: Ints, best: Point, tried: list[int]) -> list[int]:
    """The best cell of each part of the grid that may hold a better design, where none was refined from yet.

    A cell may hold one if it keeps the margin required and the objective, by its differences from the neighbouring
    cells to first order, may exceed that of the best design within it. Connected cells are one part.
    """
    from scipy.ndimage import label  # type: ignore[import-untyped]

    value = grid.cells.value
    promising = order[value[order] + grid.changes()[order] > best.value]
    kept = list(_passing(grid, promising, grid.problem.share))
    there = np.zeros(len(value), dtype=bool)
    there[kept] = True
    parts = label(there.reshape(grid.counts), np.ones((3,) * len(grid.counts)))[0].ravel()
    done = {0, *parts[tried], *parts[grid.near(best)]}
    return [row for k, row in enumerate(kept) if parts[row] not in {*done, *parts[kept[:k]]}]
