"""The best design by a global solver: SciPy's differential evolution on the same exact values that a grid has.

It searches all of the ranges, also between the cells; the design that it finds is refined and judged as a cell is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vireport.optimise.cells import corner_slack, evaluate
from vireport.optimise.problem import Problem
from vireport.scenario.blocks import Objective
from vireport.study.judging.designs import keeps_motion

Floats = NDArray[np.float64]

SEED = 0
"""Seed of the random numbers, fixed so that equal inputs give an equal design."""

POPULATION, GENERATIONS = 64, 40
"""Designs of a population, and how often it is replaced. Evaluated at once, 64 cost hardly more than one."""

SETTLED = 1e-4
"""Spread of the population's objective, over its mean, that ends the search: refinement finds the rest."""

HALVINGS = 6
"""Steps in which a margin that is the objective is bracketed."""


def evolve(problem: Problem, cells: Floats, widest: float | None) -> Floats | None:
    """Look for the best design in all of the ranges.

    Parameters
    ----------
    problem : Problem
    cells : ndarray, shape (cells, inputs)
        The best of a grid, half of the first population; the other half are Sobol points.
    widest : float or None
        A margin, as a share, that no cell has; None where no margin is sought.

    Returns
    -------
    ndarray, shape (inputs,), or None
        None where no design was found with stable motion within the limits that may meet what only a run judges.
    """
    from scipy.optimize import differential_evolution  # type: ignore[import-untyped]
    from scipy.stats import qmc  # type: ignore[import-untyped]

    inputs = len(problem.paths)
    cells = cells[: POPULATION // 2]
    spread = qmc.Sobol(inputs, rng=np.random.default_rng(SEED)).random(POPULATION)
    solution = differential_evolution(
        lambda x: _cost(problem, x.reshape(inputs, -1).T, widest),
        [(0.0, 1.0)] * inputs,
        init=np.vstack([cells, spread[len(cells) :]]),
        maxiter=GENERATIONS,
        tol=SETTLED,
        rng=np.random.default_rng(SEED),
        polish=False,
        updating="deferred",
        vectorized=True,
    )
    return np.asarray(solution.x, dtype=float) if solution.fun < 0 else None


def _cost(problem: Problem, t: Floats, widest: float | None) -> Floats:
    """The cost to be minimised: minus the objective or, from 0 upwards, by how much a design misses its limits."""
    cells = evaluate(problem, t)
    slack = np.nan_to_num(np.hstack([cells.slack, corner_slack(problem, t)]), nan=-1.0)
    cost: Floats = -np.minimum(slack, 0.0).sum(axis=1)
    rows = np.flatnonzero(cost == 0)
    kept, better = problem.may_meet(t[rows], problem.share), cells.value[rows]
    if problem.objective is Objective.MARGIN:
        designs = problem.designs(t[rows])
        low, high = np.zeros(len(rows)), np.full(len(rows), 1.5 * widest if widest else 1.0)
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            wide = keeps_motion(designs, middle)
            low, high = np.where(wide, middle, low), np.where(wide, high, middle)
        better = low
    if problem.sign < 0:
        # What shall be small comes as a negative number; a cost is negative only where nothing lacks.
        better = 1 / (1 - better)
    cost[rows] = np.where(kept, -better, 0.0)
    return cost
