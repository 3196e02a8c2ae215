"""The best design: a grid and a global solver over all designs, the best refined, and what is proved of the others.

What arrays of designs are not judged by, a run judges, one design at a time: first the designs that solver and
refinement find, then every cell that could be better, the best first, until one meets the requirements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain, islice

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.progress import Progress
from vireport.motions.events import CRITICAL
from vireport.optimise.bound import largest_value
from vireport.optimise.built import built_design
from vireport.optimise.evolution import POPULATION, evolve
from vireport.optimise.grid import APART, CHUNK, DesignGrid, JudgedDesign, grid_of
from vireport.optimise.problem import Problem
from vireport.optimise.refine import refine
from vireport.scenario.blocks import WIDEST_MARGIN
from vireport.study.judging.requirements import OfMargin

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

STARTS, MOST_REFINED = 2, 8
"""Cells that are refined from at first, and the most cells."""

HALVINGS = 12
"""Steps in which the largest margin of the cells, or the share of the tolerances that a yield takes, is bracketed, to
0.02 % and 0.1 %."""

LEVELS = (0.0, 0.01, 0.02, 0.03, 0.05, 0.07, 0.10, 0.14, 0.20, 0.28, 0.40, 0.55)
"""Margins that the front is computed for, as shares of the input in which each is smallest."""

BETWEEN = 5
"""Halvings of the way from a design that a run passes to the refined one that it does not: to 3 % of it."""

MOST_JUDGED, MOST_COSTLY = 1000, 60
"""Cells that are judged by runs at most, some minute; where each run follows motions, simulates or proves, some
minutes. A number, not a time, so that the same search has the same result everywhere."""


class SearchEvidence(Struct, frozen=True, eq=False):
    """What a search says of all designs.

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
    candidates, candidates_judged : int
        Cells that could be better than the best design, or meet the requirements where none is known that does, as far
        as all cells are judged; and how many of them runs have judged, none of which meets the requirements.
    best_cell : float or None
        What no cell that meets all requirements has more of than; None where there is no best design.
    step : float
        Largest difference of the objective between neighbouring cells within `grid.APART` of the best design.
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
    candidates: int = 0
    candidates_judged: int = 0
    best_cell: float | None = None
    step: float = 0.0
    widest: float | None = None
    bound: float | None = None
    elsewhere: int = 0

    @property
    def complete(self) -> bool:
        """Whether every cell was judged that could be better."""
        return self.candidates_judged == self.candidates


class SearchResult(Struct, frozen=True, eq=False):
    """The outcome of a search for the best design.

    Attributes
    ----------
    problem : Problem
    best : JudgedDesign or None
        None where no design was found that meets the requirements.
    nearest : JudgedDesign or None
        Then the one that comes nearest to it; None where no design has a stable motion.
    front : tuple of JudgedDesign
        The best designs for rising margins.
    evidence : SearchEvidence
    built : JudgedDesign or None
        The best design rounded to few digits, with which it still meets all requirements; None where there is none.
    """

    problem: Problem
    best: JudgedDesign | None
    nearest: JudgedDesign | None
    front: tuple[JudgedDesign, ...]
    evidence: SearchEvidence
    built: JudgedDesign | None = None

    @property
    def reported(self) -> JudgedDesign | None:
        """The design that page, terminal and best.yaml have: the rounded one, else the best, else the nearest."""
        return self.built or self.best or self.nearest


def optimise(problem: Problem, progress: Progress | None = None) -> SearchResult:
    """Find the best design, the evidence that it is, and the front of margin against the objective.

    Parameters
    ----------
    problem : Problem
    progress : callable, optional
        Called with each long step as it begins.
    """
    say = progress or (lambda what: None)
    result = _searched(problem, say)
    if result.best is None:
        return result
    say("rounding the best design")
    return replace(result, built=built_design(problem, result.best))


def _searched(problem: Problem, say: Progress) -> SearchResult:
    """The outcome of a search, before its best design is rounded."""
    say("evaluating the grid")
    grid = grid_of(problem)
    within = grid.within()
    say("looking for the best design")
    yielding, asks_yield = None, problem.loaded.scenario.tolerances is not None and not problem.tolerated
    if asks_yield:
        yielding = _yielding(grid, within)
        # Where none reaches the yield, the tolerances are in the way, unless no design meets the rest.
        grid = grid.tolerating(float(grid.judged.count > 0) if yielding is None else yielding)
    # Corners are tried of cells that meet the limits only: they cost as many evaluations as there are corners.
    order, share = grid.tolerated(within), 1.0
    ranked, widest = _widest(grid, order) if grid.by_margin else (order, None)
    tried, left = _climb(grid, ranked, widest)
    # A required yield is judged by runs. The share of the tolerances that stands for it steers the search, and must
    # not decide which cells are called hopeless.
    candidates = _judge_candidates(grid, within if asks_yield else order, say)
    nearest = None
    if grid.judged.best is None:
        ranked, widest = _widest(grid, order) if problem.share else (order, None)
        if not order.size:
            ranked, share = _halved(within, 1.0, grid.tolerated)
        nearest, candidates = _nearest(grid, ranked), grid.better(candidates)
    best, judged = grid.judged.best, len(candidates) - len(grid.unjudged(candidates))
    evidence = SearchEvidence(
        grid.counts,
        int(grid.cells.stable.sum()),
        len(within),
        None if yielding is None and not grid.problem.tolerated else len(order),
        yielding=yielding,
        judged=grid.judged.count,
        candidates=len(candidates),
        candidates_judged=judged,
        widest=widest,
    )
    if best is None:
        return SearchResult(problem, None, nearest, (), replace(evidence, tolerances=share))
    if grid.by_margin or not tried:
        return SearchResult(problem, best, None, (), evidence)
    step = 2 * float(grid.changes()[grid.near(best)].max(initial=0.0))
    best_cell = float(grid.cells.value[tried[0]])
    if evidence.complete:
        # Where all candidates were judged, a cell better than the best design has failed a run.
        best_cell = min(best_cell, best.value)
    evidence = replace(evidence, best_cell=best_cell, step=step, elsewhere=len(left))
    say("bounding what any other design may reach")
    evidence = replace(evidence, bound=largest_value(problem, best.value))
    say("trading the objective for margin")
    return SearchResult(problem, best, None, _front(grid, order), evidence)


def _yielding(grid: DesignGrid, within: Ints) -> float | None:
    """The least share of the tolerances at whose corners a design is stable and reaches the required yield, if any is.

    With a larger share the best design has a smaller objective, and more of its devices work.
    """
    # The first share is 0: a design that reaches the yield without any is the best there is, and needs no bracket.
    low, high, share, least = 0.0, 1.0, 0.0, None
    for _ in range(HALVINGS):
        other = grid.tolerating(share)
        kept = other.tolerated(within)
        rows = _widest(other, kept)[0] if grid.by_margin else kept
        row = next(other.passing(rows, other.problem.share), None)
        t = None if row is None else refine(other.problem, grid.t[row], grid.spacing)
        point = None if t is None else other.judge(t)
        if point is None or point.tolerated:
            high, least = share, least if point is None else share
        else:
            # From here on larger shares are tried: a cell that fails at this one fails at those.
            low, within = share, kept
        if high == low:
            break
        share = 1.0 if low == share == 0 else (low + high) / 2
    return least


def _climb(grid: DesignGrid, ranked: Ints, widest: float | None) -> tuple[list[int], list[int]]:
    """Judge designs refined from what the global solver finds and from cells; these, and others that may be better."""
    problem, tried, left = grid.problem, list[int](), list[int]()
    first = list(islice(grid.passing(ranked, problem.share), POPULATION // 2))
    # The global solver is not bound to cells: it finds regions narrower than one, at which no cell would start a
    # refinement.
    fittest = evolve(problem, grid.t[first], widest)
    if fittest is not None:
        _refine(grid, fittest)
    starts = _starts(grid, ranked)
    while len(tried) < MOST_REFINED and (row := next(starts, None)) is not None:
        _refine(grid, grid.t[row])
        tried.append(row)
        best = grid.judged.best if len(tried) >= STARTS else None
        if best is not None:
            left = [] if grid.by_margin else _regions(grid, ranked, best, tried)
            starts = iter(left[:1])
    return tried, left


def _judge_candidates(grid: DesignGrid, rows: Ints, say: Progress) -> Ints:
    """Judge cells that could be better than the best design, the best first; those that still could in the end.

    Where there are too many to judge each, one half of those that are judged are the best, the other half is spread
    evenly over the rest: the best that meets the requirements may be far down. One that meets them is refined from, and
    leaves fewer that could be better.
    """
    budget = MOST_COSTLY if grid.problem.is_costly else MOST_JUDGED
    candidates = grid.candidates(rows)
    if grid.by_margin:
        candidates = _widest_first(grid, candidates)
    chosen = grid.unjudged(candidates)
    # The best cells first are the likely ones, but they may all fail alike, for the same requirement.
    if len(chosen) > budget:
        chosen = chosen[: budget // 2]
    while chosen.size:
        for row in chosen:
            say(f"judging cells that could be better: at most {budget} of {len(candidates)} to go")
            point, budget = grid.judge_better(grid.t[row]), budget - 1
            if point is not None and point.meets_requirements():
                _improve(grid, point.t, refine(grid.problem, point.t, grid.spacing))
                break
        # What was left beyond the budget's first half may be all worse than the design just found: it is spread anew.
        candidates = grid.better(candidates)
        rest = grid.unjudged(candidates)
        evenly = np.linspace(0, len(rest) - 1, min(budget, len(rest))).astype(np.intp)
        chosen = rest[evenly]
    return candidates


def _widest_first(grid: DesignGrid, rows: Ints) -> Ints:
    """Some cells, those first that keep stable motion with the largest of `LEVELS`."""
    kept = [rows]
    for share in LEVELS[1:]:
        kept.append(grid.keeping(kept[-1], share))
    level = sum(np.isin(rows, cells).astype(int) for cells in kept)
    return rows[np.argsort(-np.asarray(level), kind="stable")]


def _starts(grid: DesignGrid, ranked: Ints) -> Iterator[int]:
    """Cells that keep the margin required and are some cells apart, the best first."""
    starts: list[int] = []
    for row in islice(grid.passing(ranked, grid.problem.share), CHUNK):
        away = [np.max(np.abs(grid.t[row] - grid.t[other]) / grid.spacing) for other in starts]
        if all(distance >= APART for distance in away):
            starts.append(row)
            yield row


def _widest(grid: DesignGrid, rows: Ints) -> tuple[Ints, float | None]:
    """The cells with the largest margins, to within `HALVINGS` halvings, and a margin that none has."""
    most = WIDEST_MARGIN / 100
    rows, high = _halved(np.array(list(grid.passing(rows, 0.0)), dtype=np.intp), most, grid.keeping)
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


def _refine(grid: DesignGrid, start: Floats) -> None:
    """Judge the design refined from one, and that itself if it does not meet all requirements."""
    # Refinement knows the limits in closed form only: a design at the very limit may fail what a run judges, where
    # its start does not.
    refined = refine(grid.problem, start, grid.spacing)
    point = None if refined is None else grid.judge(refined)
    if point is not None and point.meets_requirements():
        return
    point = grid.judge(start)
    if point is not None and point.meets_requirements() and refined is not None:
        _go_towards(grid, start, refined)


def _improve(grid: DesignGrid, start: Floats, refined: Floats | None) -> None:
    """Judge the design refined from one that meets all requirements and, where it does not, designs between."""
    point = None if refined is None else grid.judge(refined)
    if refined is not None and (point is None or not point.meets_requirements()):
        _go_towards(grid, start, refined)


def _go_towards(grid: DesignGrid, start: Floats, refined: Floats) -> None:
    """Judge designs on the way from one that meets all requirements to one that does not, halving it."""
    low, high = 0.0, 1.0
    for _ in range(BETWEEN):
        share = (low + high) / 2
        point = grid.judge_better(start + share * (refined - start))
        low, high = (share, high) if point is not None and point.meets_requirements() else (low, share)


def _nearest(grid: DesignGrid, ranked: Ints) -> JudgedDesign | None:
    """The design whose worst requirement is nearest to being met: of those judged, and of one refined to be it.

    That is refined from the first cell, or from the one that is nearest to the limits.
    """
    stable = np.flatnonzero(grid.cells.stable)
    if not stable.size:
        return None
    start = int(ranked[0] if ranked.size else stable[np.argmax(grid.cells.slack[stable].min(axis=1))])
    refined = refine(grid.problem, grid.t[start], grid.spacing, worst_case=True)
    point, other = grid.judge(grid.t[start] if refined is None else refined), grid.judged.nearest
    return other if point is None or (other is not None and other.shortfall < point.shortfall) else point


def _front(grid: DesignGrid, order: Ints) -> tuple[JudgedDesign, ...]:
    """The best designs for rising margins: what a larger one costs.

    A cell that fails a margin fails all larger ones, so that each level goes on where the one before has ended.
    """
    points: list[JudgedDesign] = []
    traded = frozenset(row.key for row, _ in grid.problem.required if row.quantity == OfMargin(CRITICAL))
    for level in LEVELS:
        row = next(grid.passing(order, level), None)
        if row is None:
            break
        order = order[int(np.flatnonzero(order == row)[0]) :]
        if points and points[-1].margin >= level:
            continue
        refined = refine(grid.problem.with_margin(level), grid.t[row], grid.spacing)
        judged = chain((grid.judge(t) for t in (refined, grid.t[row]) if t is not None), [grid.judged.best])
        points += islice(
            (point for point in judged if point and point.margin >= level and point.meets_requirements(traded)), 1
        )
    return tuple(points)


def _regions(grid: DesignGrid, order: Ints, best: JudgedDesign, tried: list[int]) -> list[int]:
    """The best cell of each part of the grid that may hold a better design, where none was refined from yet.

    A cell may hold one if it keeps the margin required and the objective, by its differences from the neighbouring
    cells to first order, may exceed that of the best design within it. Connected cells are one part.
    """
    from scipy.ndimage import label  # type: ignore[import-untyped]

    value = grid.cells.value
    promising = order[value[order] + grid.changes()[order] > best.value]
    kept = list(grid.passing(promising, grid.problem.share))
    inside = np.zeros(len(value), dtype=bool)
    inside[kept] = True
    parts = label(inside.reshape(grid.counts), np.ones((3,) * len(grid.counts)))[0].ravel()
    done = {0, *parts[tried], *parts[grid.near(best)]}
    return [row for k, row in enumerate(kept) if parts[row] not in {*done, *parts[kept[:k]]}]
