"""Voltages against the printed formulae in 40 digits, their limits, and the geometry they come from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from vireport.physics import Membrane, contact_cosine, deflection, generated_voltage, voltages

PAPER = Membrane(4.0847e5, 2.6, 6.3e-3, 5.0e-3, 2000.0, 0.0041)


def printed(speed: float, membrane: Membrane) -> mpf:
    """U_imp - Uin by Eqs. (5.2)-(5.5) as printed."""
    h, k = mpf(membrane.exponent), mpf(membrane.stiffness)
    rc, rb, uin = mpf(membrane.active_radius_m), mpf(membrane.ball_radius_m), mpf(membrane.bias_voltage_v)
    delta = ((h + 1) / (2 * k) * mpf(membrane.ball_mass_kg) * mpf(speed) ** 2) ** (1 / (h + 1))
    bottom = 2 * (rc**2 + (delta - rb) ** 2)
    cosine = (-2 * rb * (delta - rb) + 2 * rc * mp.sqrt(rc**2 + delta**2 - 2 * delta * rb)) / bottom
    sine = mp.sqrt(1 - cosine**2)
    area = 2 * mp.pi * rb**2 * (1 - cosine) + (mp.pi * rc**2 - mp.pi * (rb * sine) ** 2) / cosine
    return (area / (mp.pi * rc**2)) ** 2 * uin - uin


@given(st.floats(-8, 1.3), st.floats(1e-4, 0.1), st.floats(0.05, 0.98))
def test_every_digit_of_the_printed_formulae(exponent: float, mass: float, ratio: float) -> None:
    speed = 10**exponent
    membrane = Membrane(4.0847e5, 2.6, 6.3e-3, ratio * 6.3e-3, 2000.0, mass)
    with mp.workdps(60):
        exact = printed(speed, membrane)
        assert abs(mpf(float(generated_voltage(np.array(speed), membrane))) - exact) <= 1e-11 * abs(exact)


def test_no_impact_no_voltage() -> None:
    assert generated_voltage(np.array([0.0, 1e-300]), PAPER).tolist() == [0.0, 0.0]


def test_voltage_grows_with_speed_and_mass() -> None:
    speed = np.geomspace(1e-4, 30, 500)
    volts = generated_voltage(speed, PAPER)
    assert np.all(np.diff(volts) > 0)
    assert np.all(generated_voltage(speed, replace(PAPER, ball_mass_kg=0.0082)) > volts)


def test_deflection_takes_up_the_kinetic_energy() -> None:
    delta = deflection(np.array(0.7), PAPER)
    work = PAPER.stiffness * delta ** (PAPER.exponent + 1) / (PAPER.exponent + 1)
    assert work == pytest.approx(0.0041 * 0.7**2 / 2, rel=1e-13)


def test_membrane_leaves_the_ball_along_a_tangent_from_its_rim() -> None:
    """The distance of the ball's centre from the straight flank is its radius, whatever the deflection."""
    for delta in (1e-4, 3e-3, 5e-3, 8e-3, 20e-3):
        cosine, versine = contact_cosine(np.array(delta), PAPER)
        sine = np.sqrt(1 - cosine**2)
        rc, rb = PAPER.active_radius_m, PAPER.ball_radius_m
        # Rim at (Rc, 0), centre at depth delta - rb on the axis, flank descending inward at angle alpha.
        distance = abs(rc * sine - (delta - rb) * cosine)
        assert distance == pytest.approx(rb, rel=1e-9)
        assert 1 - cosine == pytest.approx(versine, rel=1e-9, abs=1e-12)


def test_deflection_of_the_paper_is_outside_the_membrane() -> None:
    """A 4.1 g ball at F = 3 N, beta = 0 and s = 0.5554 m: some 16 mm and 37 kV over 2 kV."""
    speed = 0.71526 * 3.0 / (2 * 0.1245 * 2.0)
    result = voltages(np.array([speed]), np.array([-speed]), PAPER)
    assert result.deflection_m[0] == pytest.approx(16e-3, abs=0.5e-3)
    assert result.bottom_v[0] == pytest.approx(37e3, abs=0.6e3)
    assert result.average_v[0] == result.bottom_v[0] == result.top_v[0]
