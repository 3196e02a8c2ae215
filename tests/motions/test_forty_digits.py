"""Branches and critical points against 40-digit arithmetic on the printed equations, over random scenarios."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import first
from exact import motion_near, quantities, unknowns
from mpmath import mpf
from strategies import random_sweeps

from vireport.extremes.compared import critical_motion
from vireport.motions.diagram import solve

pytestmark = pytest.mark.usefixtures("forty_digits")

SWEEPS = random_sweeps(130, seed=20190301)
BATCHES = 13  # not 12, as kinds of sweeps come in turn
TOLERANCE = 1e-12
ROWS = 5


@pytest.mark.parametrize("batch", first(1, range(BATCHES)))
def test_branch_values(batch: int) -> None:
    checked = 0
    for sweep in SWEEPS[batch::BATCHES]:
        for m in (branch.motions for branch in solve(sweep).branches):
            for row in np.unique(np.linspace(0, len(m) - 1, ROWS).astype(int)):
                slowest = min(m.velocity_bottom[row], -m.velocity_top[row])
                if slowest < 1e-5:
                    continue  # next to an impact of no velocity, which is a critical point and tested as one
                checked += 1
                exact = quantities(sweep, motion_near(sweep, unknowns(m, row)))
                for name in ("velocity_bottom", "phi_bottom", "q", "sweep_value"):
                    away = abs(mpf(float(getattr(m, name)[row])) - exact[name])
                    assert away <= TOLERANCE * abs(exact[name]), (sweep, row, name)
                away = abs(mpf(float(m.velocity_top[row])) - exact["velocity_top"])
                assert away <= TOLERANCE * max(abs(exact["velocity_bottom"]), 1), (sweep, row)
                trace = exact["trace"]
                assert abs(mpf(float(m.trace[row])) - trace) <= 1e-11 * (1 + abs(trace) / slowest), (sweep, row)
    assert checked > 50


@pytest.mark.parametrize("batch", first(1, range(BATCHES)))
def test_critical_points_within_their_bounds(batch: int) -> None:
    checked = 0
    for sweep in SWEEPS[batch::BATCHES]:
        for critical in solve(sweep).critical_points:
            value, point = critical_motion(critical, sweep.device, sweep.parameter)[3], critical
            checked += 1
            assert abs(mpf(point.sweep_value) - value) <= point.error_bound, (sweep, critical)
            assert point.error_bound <= TOLERANCE * abs(point.sweep_value)
    assert checked > 15
