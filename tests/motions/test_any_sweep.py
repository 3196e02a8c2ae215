"""Scenarios from all decades and corners: an answer that holds its invariants, or a refusal, and no warning.

`EXAMPLES=20000 pytest tests/motions/test_any_sweep.py` tries as many scenarios, at random.
"""

from __future__ import annotations

import json
import os

import numpy as np
import pytest
from exact import return_determinant
from hypothesis import example, given, settings
from hypothesis import strategies as st
from strategies import solvable_trees, sweeps

from vireport import analyse, loads
from vireport.base.errors import NumericalError
from vireport.cli.outputs import PageSettings, run_files
from vireport.design.point import design_point
from vireport.motions.diagram import BifurcationDiagram, solve
from vireport.motions.one_to_one import Motions
from vireport.motions.orbits import orbits
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter
from vireport.study.provenance import provenance_of
from vireport.study.study import results_json

SUBNORMAL = Device(1.0, 0.03125, 9.8, 0.21353156973176252, 0.8541262789270501, 1.0, 2.2250738585072014e-308, 3)
"""A tilt whose conditions have derivatives below the smallest normal double."""


@pytest.mark.slow
@settings(max_examples=80)
@given(sweeps())
@example(Sweep(SUBNORMAL, Parameter.LENGTH, 0.42706313946352503, 0.10676578486588126))
def test_invariants_of_any_sweep(sweep: Sweep) -> None:
    solution = solve(sweep)
    for branch in solution.branches:
        _check(sweep, branch.motions)
    for point in solution.critical_points:
        assert np.isfinite([point.sweep_value, point.error_bound]).all()
        assert point.error_bound >= 0
    _check_design(sweep, solution)


def _check(sweep: Sweep, m: Motions) -> None:
    for name in Motions.__struct_fields__:
        assert np.all(np.isfinite(getattr(m, name))), name
    low, high = sorted((sweep.start, sweep.end))
    assert np.all((m.sweep_value >= low * (1 - 1e-9) - 1e-12) & (m.sweep_value <= high * (1 + 1e-9) + 1e-12))
    assert np.all((m.velocity_bottom > -1e-12) & (m.velocity_top < 1e-12) & (m.d > 0))
    assert np.all((m.q > 0) & (m.q < 1))
    assert np.all(m.wall_gap <= m.d * (1 + 1e-12))
    assert not np.any(m.admissible_mask & (m.wall_gap <= 0))
    assert np.all(np.abs(m.trace[m.stable_mask]) <= (1 + m.restitution**4) * (1 + 1e-9))


def _check_design(sweep: Sweep, solution: BifurcationDiagram) -> None:
    design = design_point(sweep.device, solution)
    d, gbar, *_ = sweep.device.groups(Parameter.LENGTH, sweep.device.length_m)
    for name in ("d", "gbar"):
        np.testing.assert_allclose(getattr(design.motions, name), {"d": d, "gbar": gbar}[name], rtol=1e-12)
    assert np.all((design.motions.velocity_bottom > 0) & (design.motions.velocity_top < 0))


@given(sweeps(), st.floats(-6, 6), st.floats(-6, 6))
@settings(max_examples=30)
def test_only_the_dimensionless_groups_matter(sweep: Sweep, masses: float, forces: float) -> None:
    """Mass and force over twelve decades, the groups held: the same motions."""
    if sweep.parameter is not Parameter.LENGTH:
        return
    device, k, f = sweep.device, 10**masses, 10**forces
    other = Device(
        device.capsule_mass_kg * k,
        device.restitution,
        9.8 * f / k,
        device.length_m * f / k,
        device.amplitude_n * f,
        device.frequency_hz,
        device.inclination_deg,
        device.period_ratio,
    )
    left, right = solve(sweep), solve(Sweep(other, Parameter.LENGTH, sweep.start * f / k, sweep.end * f / k))
    assert [c.label for c in left.critical_points] == [c.label for c in right.critical_points]
    for a, b in zip(left.critical_points, right.critical_points, strict=True):
        np.testing.assert_allclose(b.d, a.d, rtol=1e-9)


def test_a_sweep_reversed_gives_the_same_motions() -> None:
    device = Device(0.1245, 0.5, 9.8, None, 3.0, 2.0, 45.0)
    upward, downward = (
        solve(Sweep(device, Parameter.LENGTH, 0.59, 0.75)),
        solve(Sweep(device, Parameter.LENGTH, 0.75, 0.59)),
    )
    assert [(c.sweep_value, c.closed) for c in upward.critical_points] == [
        (c.sweep_value, c.closed) for c in downward.critical_points
    ]
    for a, b in zip(upward.branches, downward.branches, strict=True):
        np.testing.assert_array_equal(a.motions.sweep_value, b.motions.sweep_value)


def test_no_restitution_at_all() -> None:
    solution = solve(Sweep(Device(0.1245, 0.0, 9.8, None, 3.0, 2.0, 30.0), Parameter.LENGTH, 0.1, 2.0))
    assert solution.branches
    assert all(np.all(branch.motions.discriminant >= 0) for branch in solution.branches)
    assert not [c for c in solution.critical_points if c.event == "node_focus"]


def test_higher_period_ratios_are_motions_of_their_period() -> None:
    for n in (2, 3):
        solution = solve(Sweep(Device(0.1245, 0.5, 9.8, None, 3.0, 2.0, 10.0, n), Parameter.LENGTH, 0.3, 4.0))
        assert solution.branches
        for branch in solution.branches:
            m = branch.motions
            o = orbits(m.q - 0.5, m.phi_bottom, 0.5, n)
            np.testing.assert_allclose(o.d, m.d, rtol=1e-8, atol=1e-8)
            slow = np.minimum(m.velocity_bottom, -m.velocity_top) > 1e-2
            np.testing.assert_allclose(return_determinant(o, 0.5)[slow], 0.5**4, rtol=1e-6)


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
    files = run_files(study, "", PageSettings(), lambda what: None)
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
