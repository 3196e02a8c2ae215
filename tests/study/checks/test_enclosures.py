"""Ball arithmetic: enclosures that hold 40 digits, bounds that are outward, and roots that are proved to be one."""

from __future__ import annotations

import importlib
import sys
from decimal import Decimal

import numpy as np
import pytest
from conftest import solved
from mpmath import mp, mpf
from msgspec.structs import replace
from strategies import random_sweeps

from vireport.base.errors import NumericalError
from vireport.motions.orbits import orbits
from vireport.motions.stability import return_trace
from vireport.scenario.parameters import DRIVING, Parameter
from vireport.study.checks import reference

pytest.importorskip("flint")

from flint import arb

from vireport.study.checks import enclosures
from vireport.study.checks.enclosures import BallOps, UnprovedError, ball, bounds, gradients, precision, prove

pytestmark = pytest.mark.usefixtures("forty_digits")


def contains(bounds, value) -> bool:
    return mpf(bounds[0]) <= value <= mpf(bounds[1])


def test_gradients_are_those_of_40_digits() -> None:
    u, phi, r, n = mpf("0.1"), mpf("0.5"), mpf("0.5"), 1

    def trace(u, phi):
        return return_trace(orbits(u, phi, r, n, mp), r)

    def in_balls(x):
        return [return_trace(orbits(x[0], x[1], arb(0.5), n, BallOps()), arb(0.5))]

    with precision(192):
        box = [arb("0.1"), arb("0.5")]
        exact = (trace(u, phi), mp.diff(trace, (u, phi), (1, 0)), mp.diff(trace, (u, phi), (0, 1)))
        for enclosed, value in zip((*in_balls(box), *gradients(in_balls, box)[0]), exact, strict=True):
            assert contains(bounds(enclosed + arb(0, 1e-15)), value)
        wide = [arb(0, 0.5), arb(0, 4)]
        assert not any(slope.is_finite() for slope in gradients(lambda x: [x[1] / x[0]], wide)[0])


@pytest.mark.parametrize("parameter", DRIVING)
def test_groups_and_sweep_value_are_inverse(parameter: Parameter) -> None:
    for device in (replace(sweep.device, inclination_deg=33.0) for sweep in random_sweeps(12, seed=3)):
        value, ops = getattr(device, parameter), BallOps()
        with precision(192):
            d, gbar, *_ = device.groups(parameter, value, ops)
            back = device.value(parameter, d, gbar, ops)
            assert back.contains(ball(value))
            assert back.rad() < 1e-50 * abs(value)
            for group, exact in zip((d, gbar), reference.groups(device, parameter, value), strict=True):
                low, high = bounds(group)
                assert mpf(low) * (1 - mpf(10) ** -35) <= exact <= mpf(high) * (1 + mpf(10) ** -35)


def test_ninety_degrees_is_not_exceeded() -> None:
    solution = solved("inclined", sweep__parameter="inclination_deg", sweep__from=0, sweep__to=90, device__length_m=0.4)
    device, sweep, ops = solution.device, solution.sweep, BallOps()
    with precision(192):
        gbar = device.groups(Parameter.INCLINATION, 90.0, ops)[1]
        assert not sweep.value(2 * gbar, ops).is_finite()
        gbar = device.groups(Parameter.INCLINATION, 89.9999999, ops)[1]
        assert sweep.value(gbar, ops).contains(ball(89.9999999))


def test_bounds_are_outward() -> None:
    rng = np.random.default_rng(5)
    with precision(128):
        for size in 10.0 ** rng.uniform(-30, 30, 100):
            number = arb(float(size * rng.normal()), float(size * 10 ** rng.uniform(-40, 1)))
            low, high = bounds(number, 7)
            with precision(400):
                assert arb(low) < number.upper()
                assert not arb(low) > number.lower()
                assert not arb(high) < number.upper()
            assert Decimal(high) - Decimal(low) <= Decimal(float(2 * number.rad())) + Decimal(
                max(abs(Decimal(low)), abs(Decimal(high)))
            ) * Decimal("3e-6")
        assert bounds(arb(0)) == ("0", "0")
        assert bounds(arb(-0.5)) == ("-0.5", "-0.5")


def test_a_double_root_is_not_proved() -> None:
    with precision(128), pytest.raises(UnprovedError):
        prove(lambda x: [x[0] * x[0]], [1e-9], [1.0])
    with precision(128), pytest.raises(UnprovedError):
        prove(lambda x: [x[0] + x[1], 2 * x[0] + 2 * x[1]], [0.0, 0.0], [1.0, 1.0])
    with precision(128):
        root = prove(lambda x: [x[0] * x[0] - 2], [1.41421356], [1.0])
        assert root.box[0].contains(arb(2).sqrt())
        assert root.radius == 1e-10


def test_a_missing_package_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "flint", None)
    monkeypatch.delitem(sys.modules, enclosures.__name__)
    with pytest.raises(NumericalError, match=r"vireport\[certify\]"):
        importlib.import_module(enclosures.__name__)


def test_a_box_with_two_roots_is_not_one_with_one() -> None:
    with precision(192):
        root = prove(lambda x: [x[0] * x[0] - ball("1e-22")], [1e-11], [1.0])
        assert root.radius < 1e-11
        assert root.box[0].contains(ball("1e-22").sqrt())
