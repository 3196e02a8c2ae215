"""Valid scenarios of every decade: an answer without NaN that holds its invariants, or a refusal that says why.

`EXAMPLES=20000 pytest tests/motions/test_any_scenario.py` tries as many, at random.
"""

from __future__ import annotations

import json
import os

import numpy as np
import pytest
from exact import return_determinant
from hypothesis import given, settings
from strategies import solvable_trees

from vireport import analyse, loads
from vireport.base.errors import NumericalError
from vireport.cli.outputs import RunPages, run_files
from vireport.motions.one_to_one import Motions
from vireport.motions.orbits import orbits
from vireport.study.provenance import provenance_of
from vireport.study.study import results_json

EXAMPLES = int(os.environ.get("EXAMPLES", "0"))


@pytest.mark.slow
@settings(max_examples=EXAMPLES or 20, derandomize=not EXAMPLES)
@given(solvable_trees())
def test_any_scenario_is_answered_or_refused(tree: dict) -> None:
    loaded = loads(json.dumps(tree))
    try:
        study = analyse(loaded, ("json",))
    except NumericalError:
        return
    json.loads(results_json(study, provenance_of(loaded, "")))  # has no NaN and no infinity, or it raises
    n, bounds = loaded.scenario.period_ratio, study.solution.bounds
    for branch, bound in zip(study.solution.branches, bounds.branches, strict=True):
        check(branch.motions, bound, n)
    if study.solution.design is not None:
        check(study.solution.design.motions, bounds.design, n)
    if study.crosscheck is not None:
        count = len(study.crosscheck.values) * loaded.scenario.simulation.starts
        assert sum(motion.count for motion in study.crosscheck.motions) == count
        # Towards r = 1 motions attract so slowly that the budget of impacts may end first.
        assert study.crosscheck.passed or loaded.scenario.device.restitution > 0.99, study.crosscheck.misses
    designs = () if study.solution.design is None else (study.solution.design,)
    for volts in (source.voltages_by_motion for source in (*study.solution.branches, *designs)):
        if volts is not None:
            for name in ("bottom_v", "top_v", "average_v", "deflection_m"):
                assert np.all(np.isfinite(getattr(volts, name)) & (getattr(volts, name) >= 0)), name


@pytest.mark.slow
@settings(max_examples=EXAMPLES // 100 or 4, derandomize=not EXAMPLES)
@given(solvable_trees().filter(lambda tree: "simulation" in tree))
def test_any_scenario_is_drawn_and_reported_or_refused(tree: dict) -> None:
    if "sweep" in tree:
        tree["simulation"] |= {"diagram": True, "portraits": [tree["sweep"]["from"]]}
    loaded = loads(json.dumps(tree))
    try:
        study = analyse(loaded, ("html", "png"))
    except NumericalError:
        return
    files = run_files(study, "", RunPages(), lambda what: None)
    assert b"Where the starts end" in files["report.html"]
    assert ("figure-3.png" in files) == ("sweep" in tree)


def check(m: Motions, bound: dict[str, np.ndarray], n: int) -> None:
    for name in Motions.__struct_fields__:
        assert np.all(np.isfinite(getattr(m, name))), name
    assert all(np.all(b >= 0) for b in bound.values())
    # What is no motion anyway may end a hair beyond where an impact loses its velocity.
    slack = np.where(m.admissible_mask, 1e-14, 1e-9)
    assert np.all(m.velocity_bottom >= -bound["velocity_bottom"] - slack)
    assert np.all(m.velocity_top <= bound["velocity_top"] + slack)
    assert np.all((m.d > 0) & (m.q >= 0) & (m.q <= 1) & (m.wall_gap <= m.d))
    assert not np.any(m.admissible_mask & (m.wall_gap <= 0))
    r = m.restitution
    assert np.all(np.abs(m.trace[m.stable_mask]) <= 1 + r**4 + bound["trace"][m.stable_mask])
    # det DP = r^4, and the impacts take what gravity gives: (3.8).
    fast = np.minimum(m.velocity_bottom, -m.velocity_top) > 1e-2
    determinant = return_determinant(orbits(m.u[fast], m.phi_bottom[fast], r, n), r)
    assert np.all(np.abs(determinant - r**4) <= 1e-6 * np.maximum(m.trace[fast] ** 2, 1.0))
    rise = 2 * n / (1 + r)
    room = bound["velocity_bottom"] + bound["velocity_top"] + rise * (bound["gbar"] + 1e-15 * m.gbar) + 1e-15
    assert np.all(np.abs(m.velocity_bottom + m.velocity_top - rise * m.gbar) <= room)
