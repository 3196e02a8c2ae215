"""A design refined to where no change of its inputs makes it better, with the requirements as constraints.

All derivatives are exact, of the closed form.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.point import design_point
from vireport.optimise.cells import OF_MOTION, corner_slack, evaluate
from vireport.optimise.problem import Problem, design_input
from vireport.physics.device import carried
from vireport.scenario.blocks import Objective
from vireport.scenario.parameters import DesignInput

Floats = NDArray[np.float64]

STEP = 1e-30
"""Imaginary step, as a share of an input's range, that gives derivatives to the last digits."""

PROVABLE = 1.001
"""Share of the tolerances at the corners of which a refined design has stable motion. With all of them it would lie on
the border of what can be proved; boxes of 0.999 of the largest are, on the paper's devices."""

INSIDE = 1e-9
"""How far inside its limits a design is kept, over each limit: more than error bounds and the solver leave open."""

ROUNDS, ITERATIONS, SETTLED = 8, 15, 1e-9
"""Most rounds, each in a window around the best design so far, most steps of a round, and the relative gain up to which
a round ends the search."""

AT_END = 1e-12
"""Share of a range within which a value is its end."""

WINDOW = 2.0
"""Half the width of a window, in spacings of the grid."""

OUTSIDE = -1.0
"""Stands for the slack of a design that has no stable motion, or whose margins are not resolved."""


class Linearised(Struct, frozen=True):
    """Objective and constraints of a design with their gradients; constraints are met from 0 on, margins first."""

    value: float
    slope: Floats
    slack: Floats
    slopes: Floats


class LocalSearch(Struct, eq=False):
    """A local search: the problem, and the best design that it has met.

    Attributes
    ----------
    problem : Problem
    lifted : ndarray
        1 for the constraints of which the least is to be maximised, else 0; the objective is, where none is lifted.
    best : ndarray or None
    score : float
        What is to be maximised, at the best.
    linearised_at : dict
        What is known of designs, by their bytes.
    """

    problem: Problem
    lifted: Floats
    best: Floats | None = None
    score: float = -np.inf
    linearised_at: dict[bytes, Linearised] = field(default_factory=dict)

    def linear(self, t: Floats) -> Linearised:
        """Objective and constraints at a design, computed once."""
        key = t.tobytes()
        if key not in self.linearised_at:
            self.linearised_at[key] = linearised = _linear(self.problem, t)
            lifted = self.lifted > 0
            score = float(linearised.slack[lifted].min()) if lifted.any() else linearised.value
            if np.isfinite(score) and score > self.score and bool((linearised.slack[~lifted] >= 0).all()):
                self.best, self.score = t.copy(), score
        return self.linearised_at[key]


SLOTS = tuple((varied, sign) for varied in DesignInput for sign in (-1, 1))
"""The places of margins: each input, below and above its value."""


def refine(problem: Problem, start: Floats, spacing: Floats, worst_case: bool = False) -> Floats | None:
    """Refine a design by sequential quadratic programming.

    Parameters
    ----------
    problem : Problem
    start : ndarray, shape (inputs,)
    spacing : ndarray
        Of the grid that it comes from, as shares of the ranges.
    worst_case : bool
        Whether the requirement that is farthest from being met is to come as near as possible, whatever the objective.

    Returns
    -------
    ndarray or None
        None where nothing that meets the requirements was found.
    """
    by_margin = problem.objective is Objective.MARGIN
    if by_margin and not problem.share:
        problem = problem.with_margin(0.0)
    margins = len(SLOTS) * len(problem.margins)
    corners = corner_slack(problem, start[None]).shape[1]
    lifted = np.full(margins + OF_MOTION + len(problem.limits) + corners, float(worst_case))
    if by_margin:
        lifted[margins - len(SLOTS) : margins] = 1.0  # to critical points of any kind
    search = LocalSearch(problem, lifted)
    search.linear(start)
    centre = start
    for _ in range(ROUNDS):
        before = search.score
        bounds = np.clip(centre - WINDOW * spacing, 0, 1), np.clip(centre + WINDOW * spacing, 0, 1)
        _round(search, centre, bounds)
        if search.best is None or search.score <= before + SETTLED * max(abs(before), SETTLED):
            break
        centre = search.best
    return search.best


def _round(search: LocalSearch, start: Floats, bounds: tuple[Floats, Floats]) -> None:
    """One run of the solver in a window; what it meets on the way is recorded."""
    from scipy.optimize import minimize  # type: ignore[import-untyped]

    first = search.linear(start)
    lifted, auxiliary = search.lifted, bool(search.lifted.any())
    scale = abs(first.value) if np.isfinite(first.value) and first.value and not auxiliary else 1.0
    width = bounds[1] - bounds[0]

    # In the unit cube of the window, with the auxiliary variable where there is one.
    def at(x: Floats) -> Linearised:
        t = bounds[0] + width * x[: len(start)]
        return search.linear(np.where(t < AT_END, 0.0, np.where(t > 1 - AT_END, 1.0, t)))

    def value(x: Floats) -> tuple[float, Floats]:
        if auxiliary:
            return -float(x[-1]), np.append(np.zeros(len(start)), -1.0)
        current = at(x)
        return (
            (-current.value / scale, -current.slope * width / scale) if np.isfinite(current.value) else (0.0, 0 * width)
        )

    def slack(x: Floats) -> Floats:
        return at(x).slack - INSIDE - (lifted * x[-1] if auxiliary else 0.0)

    def slopes(x: Floats) -> Floats:
        steps = at(x).slopes * width
        return np.column_stack([steps, -lifted]) if auxiliary else steps

    x = np.where(width > 0, (start - bounds[0]) / np.where(width > 0, width, 1.0), 0.0)
    limits: list[Any] = [(0.0, 1.0)] * len(start)
    if auxiliary:
        x, limits = np.append(x, first.slack[lifted > 0].min()), [*limits, (None, None)]
    minimize(
        value,
        x,
        jac=True,
        method="SLSQP",
        bounds=limits,
        constraints={"type": "ineq", "fun": slack, "jac": slopes},
        options={"maxiter": ITERATIONS, "ftol": SETTLED / 10},
    )


def _linear(problem: Problem, t: Floats) -> Linearised:
    """Evaluate a design, with exact derivatives."""
    n = len(t)
    stepped = np.vstack([t + 0j, t + 1j * STEP * np.eye(n)])
    cells, corners = evaluate(problem, stepped), corner_slack(problem, stepped, PROVABLE)
    margin_slack, margin_slopes = _margins(problem, t)
    columns = np.hstack([cells.slack, corners])
    slack = np.concatenate([margin_slack, columns[0].real])
    slopes = np.concatenate([margin_slopes, columns[1:].imag.T / STEP])
    if not (np.isfinite(slack).all() and np.isfinite(slopes).all()):
        return Linearised(np.nan, np.zeros(n), np.full_like(slack, OUTSIDE), np.zeros_like(slopes))
    return Linearised(float(cells.value[0].real), cells.value[1:].imag / STEP, slack, slopes)


def _margins(problem: Problem, t: Floats) -> tuple[Floats, Floats]:
    """Slack of the margins required, in each of `SLOTS`, as shares, and their gradients; NaN where not resolved."""
    count, n = len(SLOTS) * len(problem.margins), len(t)
    slack, slopes = np.ones(count), np.zeros((count, n))
    if not count:
        return slack, slopes
    device, _ = problem.at(t)
    try:
        with np.errstate(all="ignore"):  # where a polish leaves the range of doubles, it fails and says so
            point = design_point(device, None)
    except (NumericalError, ArithmeticError):
        return np.full(count, np.nan), slopes
    if point.unresolved_inputs or not point.motions.stable_mask.any():
        return np.full(count, np.nan), slopes
    for which, (kinds, share) in enumerate(problem.margins):
        slack[which * len(SLOTS) :][: len(SLOTS)] -= share
        for end in reversed(point.limits(*kinds)):  # the nearest last, so that it is what stays
            if end.relative is None:
                continue
            sign, value = (1 if end.distance > 0 else -1), float(device.value_of(end.parameter))
            row = which * len(SLOTS) + SLOTS.index((end.parameter, sign))
            slack[row] = end.size - share
            # The share is of the value, which moves with the inputs that it overlaps with.
            derivatives = [
                0.0
                if varied is None
                else (end.derivatives.get(varied) or 0.0) - carried(end.parameter, varied) * end.sweep_value / value
                for varied in map(design_input, problem.paths)
            ]
            slopes[row] = [sign * slope / value for slope in derivatives] * problem.widths
    return slack, slopes
