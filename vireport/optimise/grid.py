"""The grid of a search: cells with their values, and the judgements of runs on these and on designs between them."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import cast

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError, ScenarioError
from vireport.design.point import DesignPoint
from vireport.optimise.cells import CellValues, corner_slack, evaluate
from vireport.optimise.problem import Problem, smallest_margin
from vireport.scenario.blocks import WIDEST_MARGIN, Objective
from vireport.scenario.demands import Need
from vireport.scenario.rules import needing
from vireport.study.judging.designs import keeps_motion
from vireport.study.judging.evidence import unmet_criteria
from vireport.study.study import Study

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

CHUNK = 1024
"""Cells that are tried at once for a margin, and for what else rules them out."""

SAME_VALUE = 1e-9
"""Relative difference up to which a cell and a run have the same objective: rounding is far less."""

APART = 4.0
"""Spacings up to which cells are near a design, and starts are not apart."""


OFF = 1e-3
"""How far from its value an input of a built device is, over the value: it must start by itself there as well."""


class JudgedDesign(Struct, frozen=True, eq=False):
    """A design, with its results as a run has them, and its signed objective.

    Attributes
    ----------
    t : array
    study : Study
    value : float
    repeats : bool
        Whether devices that are `OFF` in one input start by themselves, too, where that is required. Where a long
        irregular transient ends on the motion by chance, they do not, and no device can be built that surely does.
    """

    t: Floats
    study: Study
    value: float
    repeats: bool = True

    @property
    def tolerated(self) -> bool:
        """Whether every device within the tolerances is proved to work, or as many do as are required."""
        tolerances = self.study.findings.get(Need.TOLERANCES)
        enough = any(line.key in needing(Need.TOLERANCES) and line.passed for line in self.study.criteria)
        return tolerances is None or tolerances.proved or enough

    def meets_requirements(self, but: frozenset[str] = frozenset()) -> bool:
        """Whether all requirements are met, but for those with some keys, and the tolerances, and devices repeat it."""
        return self.repeats and self.tolerated and all(line.key in but for line in unmet_criteria(self.study.criteria))

    @property
    def margin(self) -> float:
        """The smallest margin as a share; infinite where stable motion ends in no input."""
        return smallest_margin(cast(DesignPoint, self.study.solution.design))

    @property
    def shortfall(self) -> float:
        """Distance by which the worst requirement is missed, over its limit; infinite where it is no number."""
        lines = unmet_criteria(self.study.criteria)
        if not (self.tolerated and self.repeats) or any(line.outcome.margin is None for line in lines):
            return inf
        return max((-cast(float, line.outcome.margin) / line.limit.value for line in lines), default=0.0)


class Judged(Struct, eq=False):
    """The verdicts of runs on designs, so that none is judged twice.

    Attributes
    ----------
    count : int
        Number of designs that were judged.
    verdicts : dict
        Whether each design meets all requirements, by the bytes of its t.
    best : JudgedDesign or None
        The best of the designs that do.
    nearest : JudgedDesign or None
        The one that misses the requirements by least.
    """

    count: int = 0
    verdicts: dict[bytes, bool] = field(default_factory=dict)
    best: JudgedDesign | None = None
    nearest: JudgedDesign | None = None

    def add(self, point: JudgedDesign) -> None:
        """Take in a design with stable motion."""
        self.verdicts[point.t.tobytes()] = point.meets_requirements()
        if point.meets_requirements() and (self.best is None or point.value > self.best.value):
            self.best = point
        if self.nearest is None or point.shortfall < self.nearest.shortfall:
            self.nearest = point


class DesignGrid(Struct, frozen=True, eq=False):
    """The cells of a search: designs t (cells, inputs) on a regular grid, ends included, and the judgements of runs."""

    problem: Problem
    counts: tuple[int, ...]
    t: Floats
    cells: CellValues
    judged: Judged = field(default_factory=Judged)

    @property
    def spacing(self) -> Floats:
        """Distance between neighbouring cells along each input, as a share of its range."""
        return 1 / (np.array(self.counts) - 1)

    @property
    def by_margin(self) -> bool:
        """Whether the objective is the margin, of which cells have no value."""
        return self.problem.objective is Objective.MARGIN

    def within(self) -> Ints:
        """Cells that meet the limits, the best first; in their order where the objective is a margin."""
        rows = np.flatnonzero(self.cells.stable & (np.nan_to_num(self.cells.slack, nan=-1.0) >= 0).all(axis=1))
        value = self.cells.value[rows]
        return rows if np.isnan(value).all() else rows[np.argsort(-value, kind="stable")]

    def tolerated(self, rows: Ints, share: float = 1.0) -> Ints:
        """Those of some cells that have stable motion at all corners of the tolerances, scaled by a share."""
        slack = corner_slack(self.problem, self.t[rows], share)
        return rows[(np.nan_to_num(slack, nan=-1.0) >= 0).all(axis=1)]

    def passing(self, rows: Ints, share: float) -> Iterator[int]:
        """Select those of some cells, in their order, that may have a margin, and meet what only a run judges."""
        for part in portions(rows):
            yield from part[self.problem.may_meet(self.t[part], share)]

    def keeping(self, rows: Ints, share: float) -> Ints:
        """Select those of some cells, in their order, that have stable motion where any one input is off by a share."""
        kept = (part[keeps_motion(self.problem.designs(self.t[part]), share)] for part in portions(rows))
        return np.concatenate([rows[:0], *kept])

    def better(self, rows: Ints) -> Ints:
        """Select those of some cells that may be better than the best design by the objective, where there is one."""
        best = self.judged.best
        if best is None:
            return rows
        # A margin may be infinite, where stable motion ends in no input: then nothing is better.
        if best.value == inf:
            return rows[:0]
        if self.by_margin:
            # Whether a cell keeps its motion when an input is off by the margin is decided in closed form for all
            # cells at once; its own margin would take a run for each.
            rows = self.keeping(rows, min(best.margin, WIDEST_MARGIN / 100))
        else:
            rows = rows[self.cells.value[rows] > best.value + SAME_VALUE * abs(best.value)]
        return rows[[not self.judged.verdicts.get(self.t[row].tobytes(), False) for row in rows]] if rows.size else rows

    def unjudged(self, rows: Ints) -> Ints:
        """Select those of some cells that no run has judged."""
        return rows[[self.t[row].tobytes() not in self.judged.verdicts for row in rows]] if rows.size else rows

    def candidates(self, rows: Ints) -> Ints:
        """Select cells, in their order, that may be better than the best design and meet the requirements."""
        rows = np.array(list(self.passing(self.better(rows), self.problem.share)), dtype=np.intp)
        return rows[self.problem.may_yield(self.t[rows])]

    def judge(self, t: Floats) -> JudgedDesign | None:
        """The results of a design; None where it has no stable motion, or a run ends without results."""
        self.judged.count += 1
        # A design that a run cannot compute has been judged as well, and is not tried again.
        self.judged.verdicts[t.tobytes()] = False
        point = judged_design(self.problem, t)
        if point is not None:
            self.judged.add(point)
        return point

    def judge_better(self, t: Floats) -> JudgedDesign | None:
        """The results of a design that may be better than the best; None, too, where it does not start by itself."""
        # What does not start is told in a tenth of the time of a run, and most cells with more of the objective do not.
        # It is as far from being met as can be: it is no nearest design either, but for the first one.
        may_be_skipped = self.judged.nearest is not None and self.problem.starts_by_itself
        if not may_be_skipped or self.problem.starts(t) is not False:
            return self.judge(t)
        self.judged.count += 1
        self.judged.verdicts[t.tobytes()] = False
        return None

    def tolerating(self, share: float) -> DesignGrid:
        """Return the grid with stable motion required at all corners of a share of the tolerances."""
        return replace(self, problem=replace(self.problem, tolerated=share))

    def near(self, point: JudgedDesign) -> NDArray[np.bool_]:
        """Cells within `APART` of a design."""
        return np.asarray(np.max(np.abs(self.t - point.t) / self.spacing, axis=1) <= APART)

    def changes(self) -> Floats:
        """For each cell the sum over the inputs of half the largest difference of the objective to a neighbour."""
        value, total = self.cells.value.reshape(self.counts), np.zeros(self.counts)
        for axis in range(value.ndim):
            step = np.nan_to_num(np.abs(np.diff(value, axis=axis)))
            pad = [(0, 0)] * value.ndim
            # The edges of the grid have a neighbour on one side only, and the missing difference counts as zero.
            sides = []
            for side in ((1, 0), (0, 1)):
                pad[axis] = side
                sides.append(np.pad(step, pad))
            total += np.maximum(*sides) / 2
        return total.ravel()


def judged_design(problem: Problem, t: Floats) -> JudgedDesign | None:
    """The results of a design; None where it has no stable motion, or a run ends without results."""
    try:
        study = problem.study(t)
    except (NumericalError, ScenarioError):
        return None
    design = study.solution.design
    if design is None or not design.motions.stable_mask.any():
        return None
    point = JudgedDesign(t, study, problem.value_of(study, t))
    if not point.meets_requirements() or not problem.starts_by_itself:
        return point
    return replace(point, repeats=all(_starts(problem, other) for other in _off(problem, t)))


def _off(problem: Problem, t: Floats) -> Iterator[Floats]:
    """A design with one input after the other `OFF`, upwards and downwards, within its range."""
    values = problem.values(t)
    steps = OFF * np.where(values == 0, 1.0, np.abs(values) / problem.widths)
    for k, step in enumerate(steps.tolist()):
        for side in (step, -step):
            other = t.copy()
            other[k] += side
            if 0 <= other[k] <= 1:
                yield other


def _starts(problem: Problem, t: Floats) -> bool:
    """Whether a design comes from rest to a motion that is allowed."""
    if (starts := problem.starts(t)) is not None:
        return starts
    try:
        evidence = problem.study(t).evidence
    except (NumericalError, ScenarioError):
        return False
    return evidence.is_reached_from_rest


def portions(rows: Ints) -> Iterator[Ints]:
    """Cells in portions that are tried at once."""
    for first in range(0, len(rows), CHUNK):
        yield rows[first : first + CHUNK]


def grid_of(problem: Problem) -> DesignGrid:
    """Evaluate the cells of a search."""
    axes = len(problem.paths)
    # With fewer than three cells along an input no cell has a neighbour on both sides, and `changes` says nothing.
    count = max(round(problem.design.cells ** (1 / axes)), 3)
    counts = (count,) * axes
    t = np.stack(np.meshgrid(*[np.linspace(0, 1, count)] * axes, indexing="ij"), axis=-1).reshape(-1, axes)
    parts = [evaluate(problem, part) for part in np.array_split(t, max(len(t) // 100_000, 1))]
    columns = (np.concatenate([getattr(part, name) for part in parts]) for name in ("stable", "value", "slack"))
    return DesignGrid(problem, counts, t, CellValues(*columns))
