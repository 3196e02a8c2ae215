"""The crossing between SI units and dimensionless groups, in every kind of number."""

from __future__ import annotations

from decimal import Decimal, localcontext

import pytest
from mpmath import mpf
from msgspec.structs import replace
from strategies import random_sweeps

from vireport.physics.device import GROUP_ERROR, NO_GRAVITY, Device
from vireport.physics.groups import Restitutions, SpeedLaw
from vireport.physics.numbers import DIGITS, DecimalOps
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
