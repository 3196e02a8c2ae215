"""Scenarios from all decades and corners: an answer that holds its invariants, or a refusal, and no warning."""

from __future__ import annotations

import numpy as np
import pytest
from exact import return_determinant
from hypothesis import example, given, settings
from hypothesis import strategies as st
from strategies import sweeps

from vireport.design.point import design_point
from vireport.motions.diagram import BifurcationDiagram, solve
from vireport.motions.one_to_one import Motions
from vireport.motions.orbits import orbits
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter

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
