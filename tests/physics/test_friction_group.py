"""Friction of the ball among the groups of a device."""

from __future__ import annotations

from math import cos, radians

import numpy as np
import pytest
from mpmath import mp, mpf
from msgspec.structs import replace

from vireport.motions.polish import DECIMALS, in_decimals
from vireport.physics.device import Device
from vireport.physics.groups import Groups
from vireport.physics.numbers import ARRAYS
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DesignInput, Parameter

RUBBED = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 40.0, ball_mass_kg=0.0041, friction=0.15)


def test_friction_is_the_weight_across_the_capsule_over_the_force() -> None:
    own = RUBBED.groups(Parameter.LENGTH, 0.7).friction
    assert own == pytest.approx(0.15 * 0.1245 * 9.8 * cos(radians(40)) / 3, rel=1e-14)
    free = replace(RUBBED, capsule=CapsuleMotion.FREE).groups(Parameter.LENGTH, 0.7).friction
    assert free == pytest.approx(own * (1 + 0.0041 / 0.1245), rel=1e-14)
    with in_decimals(), mp.workdps(50):
        exact = mpf(0.15) * mpf(0.1245) * mpf(9.8) * mp.cos(mp.radians(40)) / 3
        digits = RUBBED.groups(Parameter.LENGTH, 0.7, DECIMALS).friction
        assert abs(mpf(str(digits)) / exact - 1) < 1e-35
    several = RUBBED.groups(Parameter.AMPLITUDE, np.array([3.0, 6.0]), ARRAYS).friction
    np.testing.assert_allclose(several, [own, own / 2], rtol=1e-14)


def test_friction_is_against_the_velocity_in_either_flight() -> None:
    groups = Groups(0.5, 0.3, 0.5, (), 0.1)
    assert (groups.gravity(-1), groups.gravity(1)) == (0.4, pytest.approx(0.2))
    assert (groups.pull(0.5, -1), groups.pull(0.5)) == (0.9, 0.8)
    plain = groups._replace(friction=None)
    assert plain.gravity(-1) == plain.gravity(1) == 0.3
    assert groups.with_numbers(groups.numbers).friction == 0.1


@pytest.mark.parametrize("capsule", CapsuleMotion)
def test_slopes_of_friction_are_its_differences(capsule: CapsuleMotion) -> None:
    device = replace(RUBBED, capsule=capsule)
    for varied in DesignInput:
        value = float(device.value_of(varied))
        ends = (device.with_values({varied: value * (1 + step)}) for step in (1e-5, -1e-5))
        high, low = (end.groups(Parameter.LENGTH, end.length_m).friction for end in ends)
        assert device.friction_slope(varied) == pytest.approx((high - low) / (2e-5 * value), rel=1e-8, abs=1e-12)


def test_upright_or_without_a_coefficient_there_is_none() -> None:
    assert replace(RUBBED, inclination_deg=90.0).groups(Parameter.LENGTH, 0.7).friction is None
    assert replace(RUBBED, friction=0.0).groups(Parameter.LENGTH, 0.7).friction is None


def test_a_free_capsule_is_pushed_by_friction_too() -> None:
    free = replace(RUBBED, capsule=CapsuleMotion.FREE)
    smooth = replace(free, friction=0.0)
    more = free.shaker(Parameter.LENGTH, 0.7).acceleration_m_s2 - smooth.shaker(Parameter.LENGTH, 0.7).acceleration_m_s2
    assert more == pytest.approx(0.15 * 0.0041 * 9.8 * cos(radians(40)) / 0.1245, rel=1e-9)
