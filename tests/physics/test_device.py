"""The crossing between SI units and dimensionless groups, in every kind of number, also of a ball with friction."""

from __future__ import annotations

from decimal import Decimal, localcontext
from math import cos, radians

import numpy as np
import pytest
from mpmath import mp, mpf
from msgspec.structs import replace
from strategies import random_sweeps

from vireport.motions.polish import DECIMALS, in_decimals
from vireport.physics.device import GROUP_ERROR, NO_GRAVITY, Device
from vireport.physics.groups import Groups, Restitutions, SpeedLaw
from vireport.physics.numbers import ARRAYS, DIGITS, DecimalOps
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DRIVING, DesignInput, Parameter
from vireport.study.checks import reference

DEVICES = [sweep.device for sweep in random_sweeps(200, seed=6)]


@pytest.mark.parametrize("parameter", DRIVING)
def test_groups_are_those_of_40_digits_within_their_stated_error(parameter: Parameter) -> None:
    with reference.precise():
        for device in DEVICES:
            value = getattr(device, parameter)
            exact = reference.groups(device, parameter, value)
            for group, true in zip(device.groups(parameter, value)[:2], exact, strict=True):
                assert abs(mpf(float(group)) - true) <= GROUP_ERROR * true
            with localcontext() as context:
                context.prec = DIGITS
                for group, true in zip(device.groups(parameter, value, DecimalOps())[:2], exact, strict=True):
                    assert abs(mpf(str(group)) - true) <= mpf(10) ** -40 * true


@pytest.mark.parametrize("parameter", DRIVING)
def test_there_and_back(parameter: Parameter) -> None:
    for device in (replace(device, inclination_deg=33.0) for device in DEVICES):
        value = getattr(device, parameter)
        assert device.value(parameter, *device.groups(parameter, value)[:2]) == pytest.approx(value, rel=1e-14)
        with localcontext() as context:
            context.prec, ops = DIGITS, DecimalOps()
            back = device.value(parameter, *device.groups(parameter, value, ops)[:2], ops)
            assert abs(back / Decimal(value) - 1) < Decimal("1e-40")


def test_two_restitutions_keep_their_difference_in_every_kind_of_number() -> None:
    for law in (Restitutions(0.3, 0.7), SpeedLaw(0.3, 0.7, -0.1, 2.0)):
        device = Device(1.0, law, 1.0, 1.0, 1.0, 1.0, 57.3)
        for mean in (0.4, Decimal("0.4")):
            restitution = device.with_values({DesignInput.RESTITUTION: mean}).restitution
            assert float(restitution.bottom) == pytest.approx(0.2, abs=1e-15)
            assert float(restitution.top) == pytest.approx(0.6, abs=1e-15)
            assert type(restitution.bottom) is type(restitution.top) is type(mean)


def test_gravity_that_is_lost_in_rounding_counts_as_none() -> None:
    device = Device(1.0, 0.5, 1.0, 1.0, 1.0, 1.0, None)
    degree = 57.3
    for ops in ((), (DecimalOps(),)):
        assert device.groups(Parameter.INCLINATION, 0.9 * NO_GRAVITY * degree, *ops)[1] == 0
        assert device.groups(Parameter.INCLINATION, 1.1 * NO_GRAVITY * degree, *ops)[1] > 0


def test_a_device_that_rounding_does_not_resolve_says_what_is_lost() -> None:
    device = Device(1.0, 0.5, 1.0, 1.0, 1.0, 1.0, 57.3)
    assert device.unresolved == replace(device, inclination_deg=0.0).unresolved == ""
    assert device.unresolved == replace(device, inclination_deg=1.1 * NO_GRAVITY * 57.3).unresolved
    assert "gravity is lost" in replace(device, inclination_deg=0.9 * NO_GRAVITY * 57.3).unresolved
    assert "length is lost" in replace(device, length_m=1e-17).unresolved
    assert "length is lost" in replace(device, length_m=1e-17, inclination_deg=0.0).unresolved


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
