"""The best design: a grid and a global solver over all designs, the best refined, and what is proved of the others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import cast

import numpy as np
from numpy.typing import NDArray

from vireport.base import Progress
from vireport.design import DesignPoint
from vireport.gate import Question
from vireport.optimise.bound import largest_value
from vireport.optimise.cells import (
    Cells,
    corner_slack,
    evaluate,
    keeps_motion,
)
from vireport.optimise.evolution import POPULATION, evolve
from vireport.optimise.problem import Problem, smallest_margin
from vireport.optimise.refine import refine
from vireport.scenario import WIDEST_MARGIN, Objective
from vireport.study import Study

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

CHUNK = 1024
"""Cells that are tried at once for a margin."""

STARTS, APART, MOST_REFINED = 2, 4.0, 8
"""Cells that are refined from at first, how many spacings they are apart, and the most cells."""

HALVINGS = 12
"""Steps in which the largest margin of the cells, or the share of the tolerances that a yield takes, is bracketed, to
0.02 % and 0.1 %."""

LEVELS = (0.0, 0.01, 0.02, 0.03, 0.05, 0.07, 0.10, 0.14, 0.20, 0.28, 0.40, 0.55)
"""Margins of the front."""


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """A design, with its results as a run has them, and its objective."""

    t: Floats
    study: Study
    value: float

    @property
    def tolerated(self) -> bool:
        """Whether every device within the tolerances is proved to work, or as many do as are required."""
        found = self.study.tolerances
        enough = any(one.question is Question.TOLERANCES and one.passed for one in self.study.criteria)
        return found is None or found.proved or enough

    @property
    def met(self) -> bool:
        """Whether all requirements are met, and the tolerances."""
        return self.tolerated and all(criterion.passed for criterion in self.study.criteria)

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
    tolerated : int or None
        Those of the latter with stable motion at all corners of the tolerances, or of the share of them that a required
        yield takes; None where neither counts.
    tolerances : float
        Where there are none, a share of the tolerances at which there are none either; else 1.
    yielding : float or None
        The share of the tolerances at whose corners the best design has stable motion so that it reaches the yield
        required; None where none smaller than 100 % is, or it is not reached.
    judged : int
        Designs judged as a run judges them, with the proof over the tolerances, or the yield.
    best_cell : float or None
        Objective of the best cell that meets all requirements, None where there is none.
    step : float
        Largest difference of the objective between neighbouring cells within `APART` of the best design.
    widest : float or None
        A margin, as a share, that no cell within the limits has; None where it was not looked for.
    bound : float or None
        A value that no design in the ranges exceeds that meets the requirements, proved; None where none is known.
    elsewhere : int
        Parts of the grid that may hold a better design, by the differences between neighbouring cells to first order,
        and were not refined from.
    """

    counts: tuple[int, ...]
    stable: int
    within: int
    tolerated: int | None = None
    tolerances: float = 1.0
    yielding: float | None = None
    judged: int = 0
    best_cell: float | None = None
    step: float = 0.0
    widest: float | None = None
    bound: float | None = None
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
    """The cells of a search: designs t (cells, inputs) on a regular grid, ends included; and what was judged of it."""

    problem: Problem
    counts: tuple[int, ...]
    t: Floats
    cells: Cells
    judged: list[Point | None] = field(default_factory=list)

    @property
    def spacing(self) -> Floats:
        """Between neighbouring cells, as shares of the ranges."""
        return 1 / (np.array(self.counts) - 1)

    def within(self) -> Ints:
        """Cells that meet the limits, the best first; in their order where the objective is a margin."""
        rows = np.flatnonzero(self.cells.stable & (np.nan_to_num(self.cells.slack, nan=-1.0) >= 0).all(axis=1))
        value = self.cells.value[rows]
        return rows if np.isnan(value).all() else rows[np.argsort(-value, kind="stable")]

    def tolerated(self, rows: Ints, share: float = 1.0) -> Ints:
        """Those of some cells that have stable motion at all corners of a share of the tolerances."""
        slack = corner_slack(self.problem, self.t[rows], share)
        return rows[(np.nan_to_num(slack, nan=-1.0) >= 0).all(axis=1)]

    def judge(self, t: Floats) -> Point | None:
        """The results of a design; None where it has no stable motion."""
        study = self.problem.study(t)
        design = study.solution.design
        stable = design is not None and bool(design.motions.stable.any())
        self.judged.append(Point(t, study, self.problem.value_of(study)) if stable else None)
        return self.judged[-1]

    @property
    def best(self) -> Point | None:
        """The best of the designs judged that meet all requirements."""
        met = [point for point in self.judged if point is not None and point.met]
        return max(met, key=lambda point: point.value, default=None)

    def tolerating(self, share: float) -> Grid:
        """The same with stable motion required at all corners of a share of the tolerances."""
        return replace(self, problem=replace(self.problem, tolerated=share))

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
    within = grid.within()
    say("looking for the best design")
    yielding = None
    if problem.loaded.scenario.tolerances is not None and not problem.tolerated:
        yielding = _yielding(grid, within)
        # Where none reaches the yield, the tolerances are in the way, unless no design meets the rest.
        grid = grid.tolerating(float(len(grid.judged) > 0) if yielding is None else yielding)
    order, share = grid.tolerated(within), 1.0
    by_margin = problem.objective is Objective.MARGIN
    ranked, widest = _widest(grid, order) if by_margin else (order, None)
    tried, left = _climb(grid, ranked, widest)
    tolerated = None if yielding is None and not grid.problem.tolerated else len(order)
    evidence = Evidence(
        grid.counts, int(grid.cells.stable.sum()), len(within), tolerated, yielding=yielding, widest=widest
    )
    if grid.best is None:
        ranked, widest = _widest(grid, order) if problem.share else (order, None)
        if not order.size:
            ranked, share = _halved(within, 1.0, grid.tolerated)
        nearest = _nearest(grid, ranked)
        if grid.best is None:
            evidence = replace(evidence, widest=widest, tolerances=share, judged=len(grid.judged))
            return Result(problem, None, nearest, (), evidence)
    best, evidence = grid.best, replace(evidence, judged=len(grid.judged))
    if by_margin or not tried:
        return Result(problem, best, None, (), evidence)
    step = 2 * float(grid.changes()[grid.near(best)].max(initial=0.0))
    evidence = replace(evidence, best_cell=float(grid.cells.value[tried[0]]), step=step, elsewhere=len(left))
    say("bounding what any other design may reach")
    evidence = replace(evidence, bound=largest_value(problem, best.value))
    say("trading the objective for margin")
    return Result(problem, best, None, _front(grid, order), evidence)


def _yielding(grid: Grid, within: Ints) -> float | None:
    """The least share of the tolerances at whose corners a design is stable and reaches the required yield, if any is.

    With a larger share the best design has a smaller objective, and more of its devices work.
    """
    low, high, share, found = 0.0, 1.0, 0.0, None
    by_margin = grid.problem.objective is Objective.MARGIN
    for _ in range(HALVINGS):
        other = grid.tolerating(share)
        kept = other.tolerated(within)
        rows = _widest(other, kept)[0] if by_margin else kept
        row = next(_passing(other, rows, other.problem.share), None)
        t = None if row is None else refine(other.problem, grid.t[row], grid.spacing)
        point = None if t is None else other.judge(t)
        if point is None or point.tolerated:
            high, found = share, found if point is None else share
        else:
            low, within = share, kept
        if high == low:
            break
        share = 1.0 if low == share == 0 else (low + high) / 2
    return found


def _climb(grid: Grid, ranked: Ints, widest: float | None) -> tuple[list[int], list[int]]:
    """Judge designs refined from what the global solver finds and from cells; these, and others that may be better."""
    problem, tried, left = grid.problem, list[int](), list[int]()
    first = list(islice(_passing(grid, ranked, problem.share), POPULATION // 2))
    found = evolve(problem, grid.t[first], widest)
    if found is not None:
        _refine(grid, found)
    starts = _starts(grid, ranked)
    while len(tried) < MOST_REFINED and (row := next(starts, None)) is not None:
        _refine(grid, grid.t[row])
        tried.append(row)
        best = grid.best if len(tried) >= STARTS else None
        if best is not None:
            left = [] if problem.objective is Objective.MARGIN else _regions(grid, ranked, best, tried)
            starts = iter(left[:1])
    return tried, left


def _passing(grid: Grid, rows: Ints, share: float) -> Iterator[int]:
    """Those of some cells that keep stable motion with every input off by a share, in their order."""
    for first in range(0, len(rows), CHUNK):
        part = rows[first : first + CHUNK]
        yield from part if share <= 0 else part[keeps_motion(grid.problem, grid.t[part], share)]


def _starts(grid: Grid, ranked: Ints) -> Iterator[int]:
    """Cells that keep the margin required and are some cells apart, the best first."""
    starts: list[int] = []
    for row in islice(_passing(grid, ranked, grid.problem.share), CHUNK):
        away = [np.max(np.abs(grid.t[row] - grid.t[other]) / grid.spacing) for other in starts]
        if all(distance >= APART for distance in away):
            starts.append(row)
            yield row


def _widest(grid: Grid, rows: Ints) -> tuple[Ints, float | None]:
    """The cells with the largest margins, to within `HALVINGS` halvings, and a margin that none has."""
    most = WIDEST_MARGIN / 100
    rows, high = _halved(rows, most, lambda some, share: np.array(list(_passing(grid, some, share)), dtype=np.intp))
    return rows, high if high < most else None


def _halved(rows: Ints, most: float, passing: Callable[[Ints, float], Ints]) -> tuple[Ints, float]:
    """Those of some cells that pass at the largest share, to within `HALVINGS` halvings, and one at which none does."""
    low, high = 0.0, most
    for _ in range(HALVINGS if rows.size else 0):
        middle = (low + high) / 2
        passed = passing(rows, middle)
        if passed.size:
            rows, low = passed, middle
        else:
            high = middle
    return rows, high


def _refine(grid: Grid, start: Floats) -> None:
    """Judge the design refined from one, and that itself if it does not meet all requirements."""
    for t in (refine(grid.problem, start, grid.spacing), start):
        point = None if t is None else grid.judge(t)
        if point is not None and point.met:
            break


def _nearest(grid: Grid, ranked: Ints) -> Point | None:
    """The design whose worst requirement is nearest to being met, from the first cell or that nearest to the limits."""
    stable = np.flatnonzero(grid.cells.stable)
    if not stable.size:
        return None
    start = int(ranked[0] if ranked.size else stable[np.argmax(grid.cells.slack[stable].min(axis=1))])
    refined = refine(grid.problem, grid.t[start], grid.spacing, worst_case=True)
    return grid.judge(grid.t[start] if refined is None else refined)


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
        point = None if t is None else grid.judge(t)
        if point is not None and point.tolerated and point.margin >= level:
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
