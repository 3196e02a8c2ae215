"""What a design point comes to where its membranes are not alike, and what either of two that are alike does alone."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import first
from msgspec.structs import replace

from vireport.design.devices import devices_off, stable_motions
from vireport.design.point import design_point
from vireport.design.sensitivity import restitution_effect
from vireport.findings.tolerances.proof import Leaf, prove_again, prove_region
from vireport.findings.tolerances.region import region_of
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.energy import Dielectric, Membrane, Strikes, conversion, voltages
from vireport.physics.groups import Restitutions
from vireport.physics.motion import Symmetry
from vireport.scenario.parameters import DesignInput, Parameter

PAPER = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0)
"""The device of Fig. 3 (c)-(d), whose margin in frequency is 4.7 %."""

LEVEL = replace(PAPER, length_m=0.5554, inclination_deg=0.0)
UNLIKE = replace(PAPER, restitution=Restitutions(0.475, 0.5))
ALONE = DesignInput.RESTITUTION_BOTTOM, DesignInput.RESTITUTION_TOP


@pytest.mark.parametrize(
    ("restitution", "moved", "left"),
    first(
        3,
        [
            (Restitutions(0.475, 0.5), 3.9, 1.0),
            (Restitutions(0.525, 0.5), -4.4, 9.0),
            (Restitutions(0.5, 0.475), -3.8, 8.3),
            (Restitutions(0.5, 0.525), 4.0, 0.9),
            (0.475, 0.3, 4.5),
            (0.525, -0.5, 5.2),
        ],
        unpacked=True,
    ),
)
def test_one_membrane_moves_the_period_doubling_ten_times_as_far_as_both(
    restitution: float | Restitutions, moved: float, left: float
) -> None:
    """B1 in frequency, derived apart from this in two ways and simulated; 5 % of the restitution each."""

    def doubling(device: Device) -> float:
        points = solve(Sweep(device, Parameter.FREQUENCY, 1.5, 2.4)).critical_points
        return next(point.sweep_value for point in points if point.event is Event.PERIOD_DOUBLING)

    at, before = doubling(replace(PAPER, restitution=restitution)), doubling(PAPER)
    assert 100 * (at / before - 1) == pytest.approx(moved, abs=0.06)
    assert 100 * (1 - at / 2.0) == pytest.approx(left, abs=0.06)
    margin = next(m for m in design_point(replace(PAPER, restitution=restitution), None).margins if m.distance < 0)
    assert margin.parameter is DesignInput.FREQUENCY
    assert margin.sweep_value == pytest.approx(at, rel=1e-14)


@pytest.mark.slow
def test_where_stable_motion_ends_along_one_restitution_another_design_has_that_point() -> None:
    ends = [m for m in design_point(PAPER, None).margins if m.parameter in ALONE and m.event is Event.PERIOD_DOUBLING]
    assert {m.parameter for m in ends} == set(ALONE)
    for margin in ends:
        at = PAPER.with_values({margin.parameter: margin.sweep_value})
        points = solve(Sweep(at, Parameter.LENGTH, 0.6, 0.8)).critical_points
        nearest = min(abs(point.sweep_value - PAPER.length_m) for point in points if point.event is margin.event)
        assert nearest < 1e-13
        for name in (*ALONE, DesignInput.RESTITUTION, DesignInput.LENGTH):
            if name is not margin.parameter:
                step = 1e-6 * PAPER.value_of(name)
                values = []
                for sign in (-1, 1):
                    device = PAPER.with_values({name: PAPER.value_of(name) + sign * step})
                    found = [m for m in design_point(device, None).margins if m.parameter is margin.parameter]
                    values.append(min((m.sweep_value for m in found), key=lambda x: abs(x - margin.sweep_value)))
                slope = (values[1] - values[0]) / (2 * step)
                assert margin.derivatives[name] == pytest.approx(slope, rel=1e-5), (margin.parameter, name)


def test_both_together_are_the_sum_of_either() -> None:
    for margin in design_point(PAPER, None).margins:
        if margin.parameter not in (*ALONE, DesignInput.RESTITUTION):
            alone = sum(margin.derivatives[name] for name in ALONE)
            assert margin.derivatives[DesignInput.RESTITUTION] == pytest.approx(alone, rel=1e-9, abs=1e-12)


def test_a_pitchfork_has_a_cusp_in_one_restitution() -> None:
    passing = [m for m in design_point(LEVEL, None).margins if m.event is Event.PITCHFORK]
    assert passing
    for margin in passing:
        assert [margin.derivatives[name] for name in ALONE] == [None, None]
        assert margin.derivatives[DesignInput.RESTITUTION] is not None or margin.parameter is DesignInput.RESTITUTION
    assert not [m for m in design_point(replace(LEVEL, restitution=Restitutions(0.49, 0.5)), None).margins
                if m.event is Event.PITCHFORK]  # fmt: skip


def test_tolerances_of_one_membrane_are_proved_or_refuted() -> None:
    """What both may be off together, one alone may not: the proof, its corners and random devices agree."""
    half = {DesignInput.RESTITUTION: 0.025}
    region = region_of(PAPER, half)
    proof = prove_region(region)
    assert Leaf.OPEN not in proof.halved
    assert proof.failing is None
    for varied in ALONE:
        region = region_of(PAPER, {varied: 0.025})
        proof = prove_region(region)
        assert Leaf.OPEN not in proof.halved
        assert prove_again(region, proof.halved, proof.motions) == 1
        failing = prove_region(region_of(PAPER, {varied: 0.04}))
        assert failing.failing is not None or Leaf.OPEN in failing.halved
    region = region_of(UNLIKE, {DesignInput.RESTITUTION: 0.02, DesignInput.RESTITUTION_TOP: 0.002})
    proof = prove_region(region)
    assert Leaf.OPEN not in proof.halved
    steps = np.random.default_rng(1).uniform(-1, 1, (2, 300))
    devices = devices_off(UNLIKE, {DesignInput.RESTITUTION: 0.02, DesignInput.RESTITUTION_TOP: 0.002}, steps)
    np.testing.assert_allclose(devices.restitution.top - devices.restitution.bottom, 0.025 + 0.002 * steps[1])
    assert len(set(stable_motions(devices)[0])) == 300


def test_impacts_lose_by_the_restitution_of_their_membrane() -> None:
    dielectric = Dielectric(1e-3, 4.7, 1e8)
    membrane = Membrane(4.0847e5, 2.6, 6.3e-3, 5e-3, 2000.0, 2.2e-6, dielectric)
    gained = conversion(Strikes((10.0, 20.0), (1.0, 2.0), Restitutions(0.4, 0.6)), membrane, dielectric, 0.5)
    lost = 2.2e-6 / 2 * ((1 - 0.16) * 1.0 + (1 - 0.36) * 4.0)
    assert gained.efficiency == pytest.approx((gained.energy_bottom_j + gained.energy_top_j) / lost, rel=1e-14)
    assert voltages(1.0, 2.0, membrane).average_v > 0


def test_the_effect_of_a_restitution_is_that_of_both_together() -> None:
    design = design_point(UNLIKE, None)
    effect = restitution_effect(UNLIKE, design.motions)
    assert effect is not None
    assert effect.lost_at is None or 0.9 < effect.lost_at / 0.4875 < 1.1


def test_no_point_of_a_horizontal_device_with_unlike_membranes_is_of_a_symmetric_motion() -> None:
    """Also where both impacts lose their velocity at once, at q = 1/2: the branch that ends there is of no mirror."""
    device = replace(LEVEL, restitution=Restitutions(0.55, 0.45))
    points = solve(Sweep(device, Parameter.LENGTH, 0.25, 1.0)).critical_points
    (rest,) = [point for point in points if point.rest is not None]
    assert abs(rest.closed.u) < 1e-30
    assert rest.d == pytest.approx(2 / np.pi**2, rel=1e-15)
    assert {point.symmetry for point in points} == {Symmetry.ASYMMETRIC}
