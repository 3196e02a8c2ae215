"""The share of devices that a measurement allows with stable motion, held against borders that are known."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import EXAMPLES

from vireport import analyse, load
from vireport.design.measured import measured_share
from vireport.physics.device import Device
from vireport.scenario.parameters import DesignInput

LENGTH, AMPLITUDE = DesignInput.LENGTH, DesignInput.AMPLITUDE


def device() -> Device:
    return Device.of(load(EXAMPLES / "design-point.yaml").scenario)


def border() -> float:
    """By how much the length may change until the design point's stable motion ends."""
    point = analyse(EXAMPLES / "design-point.yaml").solution.design
    ends = [margin.distance for margin in point.endings() if margin.parameter is LENGTH]
    return float(min(ends, key=abs))


def test_far_from_the_ends_all_devices_are_stable() -> None:
    found = measured_share(device(), [LENGTH], np.array([[1e-8]]))
    assert (found.stable, found.said, found.costly) == (4096, True, None)


def test_correlated_errors_that_leave_the_motion_as_it_is_cost_nothing() -> None:
    """Length and force in proportion, with g as well, leave d; so errors along that way are worth less than across."""
    own = device()
    size = 0.05
    along = np.array([size * own.length_m, size * own.amplitude_n])
    together = measured_share(own, [LENGTH, AMPLITUDE], np.outer(along, along))
    apart = measured_share(own, [LENGTH, AMPLITUDE], np.outer(along, along) * np.array([[1, -1], [-1, 1]]))
    assert together.stable > apart.stable


def test_what_costs_most_is_named_with_the_error_that_would_do() -> None:
    own = device()
    reach = abs(border())
    # The other input is known well.
    covariance = np.diag([reach**2, (1e-4 * own.amplitude_n) ** 2])
    found = measured_share(own, [LENGTH, AMPLITUDE], covariance)
    assert not found.said
    assert found.costly is LENGTH
    # Known as well as that, the end is three deviations away or so.
    assert found.needed == pytest.approx(reach / 3, rel=0.6)
