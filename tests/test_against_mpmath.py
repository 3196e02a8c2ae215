"""Branches and critical points against 40-digit arithmetic on the printed equations, over random scenarios."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf
from reference import DIGITS, Case, newton, random_sweeps

from vireport.analysis.admissibility import turning_points
from vireport.analysis.diagram import BifurcationDiagram, solve
from vireport.analysis.orbits import orbits

SWEEPS = random_sweeps(240, seed=20190301)
TOLERANCE = 1e-12
ROWS = 5


@pytest.fixture(scope="module", autouse=True)
def precision():
    with mp.workdps(DIGITS):
        yield


@pytest.mark.parametrize("batch", range(12))
def test_branch_values(batch: int) -> None:
    checked = 0
    for sweep in SWEEPS[20 * batch : 20 * batch + 20]:
        solution = solve(sweep)
        for branch in solution.branches:
            m = branch.motions
            for row in np.unique(np.linspace(0, len(m) - 1, ROWS).astype(int)):
                if min(m.velocity_bottom[row], -m.velocity_top[row]) < 1e-5:
                    continue  # next to an impact of no velocity, which is a critical point and tested as one
                checked += 1
                _check_row(sweep, m, row)
    assert checked > 100


def _check_row(sweep, m, row: int) -> None:
    case = Case(sweep)
    n = sweep.device.period_ratio
    ours = [m.velocity_bottom[row], m.phi_bottom[row], 2 * n * m.q[row], m.sweep_value[row]]
    exact = newton(case.residuals, ours)
    for a, b in zip(ours, exact, strict=True):
        assert abs(mpf(float(a)) - b) <= TOLERANCE * abs(b), (sweep, row)
    assert abs(mpf(float(m.velocity_top[row])) - case.velocity_top(exact)) <= TOLERANCE * max(abs(exact[0]), 1)
    trace = case.trace(exact)
    sensitivity = abs(trace) / min(m.velocity_bottom[row], -m.velocity_top[row])
    assert abs(mpf(float(m.trace[row])) - trace) <= 1e-11 * (1 + sensitivity)


@pytest.mark.parametrize("batch", range(12))
def test_critical_points_within_their_bounds(batch: int) -> None:
    checked = 0
    for sweep in SWEEPS[20 * batch : 20 * batch + 20]:
        solution = solve(sweep)
        for critical in solution.critical_points:
            value = _exact_value(solution, critical)
            checked += 1
            point = critical.point
            assert abs(mpf(point.sweep_value) - value) <= point.error_bound, (sweep, critical)
            assert point.error_bound <= TOLERANCE * abs(point.sweep_value)
    assert checked > 15


def _exact_value(solution: BifurcationDiagram, critical) -> mpf:
    sweep, point = solution.curve.sweep, critical.point
    r, n = mpf(sweep.device.restitution), sweep.device.period_ratio
    case, one = Case(sweep), 1 + mpf(sweep.device.restitution) ** 4
    guess = [point.velocity_bottom, point.phi, 2 * n * (0.5 + point.u), point.sweep_value]
    more, upward, at_bottom = _turning_guess(solution, point)

    def condition(x):
        if critical.kind == "period_doubling":
            return [case.trace(x) + one]
        if critical.kind in ("fold", "pitchfork"):
            return [case.trace(x) - one]
        if critical.kind == "node_focus":
            return [abs(case.trace(x)) - 2 * r**2]
        if "bottom" in critical.change:
            return [x[0]]
        if "top" in critical.change:
            return [case.velocity_top(x)]
        return case.turning(x, upward, at_bottom)

    if critical.kind == "pitchfork":
        # The pitchfork is a double point of the curve: on the symmetric line it is a simple one.
        def symmetric(x):
            full = [x[0], x[1], mpf(n), x[2]]
            return [case.residuals(full)[0], case.velocity_top(full) + x[0], case.trace(full) - one]

        return newton(symmetric, [guess[0], guess[1], guess[3]])[2]
    if critical.kind == "grazing" and "turning" in critical.change:
        guess.append(more)
    return newton(lambda x: case.residuals(x) + condition(x), guess, steps=10)[3]


def _turning_guess(solution: BifurcationDiagram, point) -> tuple[float, bool, bool]:
    r, n = solution.curve.r, solution.curve.n
    orbit = orbits(np.array([point.u]), np.array([point.phi]), r, n)
    if min(point.velocity_bottom, -point.velocity_top) < 1e-9:
        return 0.0, True, True
    turns = [
        (abs(gap[0]), float(t.time[0]), t.upward, from_start == t.upward)
        for t in turning_points(orbit, r, n)
        for from_start, gap in ((True, t.from_start_wall), (False, t.from_end_wall))
    ]
    return min(turns)[1:] if turns else (0.0, True, True)
