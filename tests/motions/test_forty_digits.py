"""Branches and critical points against 40-digit arithmetic on the printed equations, over random scenarios."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import first
from mpmath import mpf
from strategies import random_sweeps

from vireport.motions.diagram import solve
from vireport.study.checks.forty_digits import critical_motion, motion_errors

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
            slowest = np.minimum(m.velocity_bottom, -m.velocity_top)
            # Next to an impact of no velocity it is a critical point, and tested as one.
            rows = [k for k in np.unique(np.linspace(0, len(m) - 1, ROWS).astype(int)) if slowest[k] >= 1e-5]
            checked += len(rows)
            errors = motion_errors(m, rows, sweep.device, sweep.parameter, near=True)
            assert max(errors, default=0.0) <= TOLERANCE, sweep
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
