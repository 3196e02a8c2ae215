"""The kinds of numbers: decimals against mpmath, and doubles whose stated error holds."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from vireport.motions.orbits import ORBIT_NUMBERS, Dynamics, coefficients, orbits_of
from vireport.motions.stability import return_trace
from vireport.physics.forcing import Harmonic
from vireport.physics.numbers import ARRAYS, DIGITS, ROUNDED, DecimalOps, Rounded


@pytest.mark.slow
@given(st.floats(-40, 40))
def test_decimal_sine_and_cosine(x: float) -> None:
    with localcontext() as context, mp.workdps(50):
        context.prec = DIGITS
        ops = DecimalOps()
        for ours, exact in ((ops.sin(Decimal(x)), mp.sin(mpf(x))), (ops.cos(Decimal(x)), mp.cos(mpf(x)))):
            assert abs(mpf(str(ours)) - exact) < mpf(10) ** -42
        assert abs(mpf(str(+ops.pi)) - mp.pi) < mpf(10) ** -43


@given(st.floats(1e-300, 90))
def test_sine_of_degrees_and_its_inverse(angle: float) -> None:
    with localcontext() as context, mp.workdps(50):
        context.prec = DIGITS
        exact = mp.sin(mpf(angle) * mp.pi / 180)
        assert abs(mpf(float(ARRAYS.sin_degrees(angle))) - exact) <= 4e-16 * exact
        ops = DecimalOps()
        sine = ops.sin_degrees(Decimal(angle))
        assert abs(mpf(str(sine)) - exact) < mpf(10) ** -42
        if angle <= 89.9:
            assert abs(ops.arcsin_degrees(sine) - Decimal(angle)) < Decimal("1e-37")
            assert ARRAYS.arcsin_degrees(float(exact)) == pytest.approx(angle, rel=1e-12, abs=1e-300)


def test_sine_is_exact_at_both_ends() -> None:
    assert ARRAYS.sin_degrees(np.array([0.0, 90.0])).tolist() == [0.0, 1.0]
    assert ARRAYS.arcsin_degrees(np.array([0.0, 1.0, 1 + 2e-16])).tolist() == [0.0, 90.0, 90.0]
    with localcontext() as context:
        context.prec = DIGITS
        assert DecimalOps().arcsin_degrees(Decimal(1)) == 90


def test_the_arithmetic_bounds_its_own_rounding() -> None:
    """Every quantity of the surface of motions at random doubles, against 40 digits of the same formulae."""
    rng = np.random.default_rng(8)
    with mp.workdps(40):
        for _ in range(200):
            u, phi, r = float(rng.uniform(-0.49, 0.49)), float(rng.uniform(0, 6.28)), float(rng.uniform(0, 0.99))
            n = int(rng.integers(1, 4))
            parts = [(order, *map(float, rng.uniform(-0.5, 0.5, 2))) for order in (2, 5)[: int(rng.integers(0, 3))]]
            harmonics, same = (tuple(Harmonic(*own).map_numbers(kind) for own in parts) for kind in (Rounded, mpf))
            carried = orbits_of(Dynamics(Rounded(r), n, harmonics), Rounded(u), Rounded(phi), ROUNDED)
            exact = orbits_of(Dynamics(mpf(r), n, same), mpf(u), mpf(phi), mp)
            for name in ORBIT_NUMBERS:
                x, y = getattr(carried, name), getattr(exact, name)
                assert abs(mpf(float(x.value)) - y) <= mpf(float(x.error)), name
            trace, true = (return_trace(o, s) for o, s in ((carried, Rounded(r)), (exact, mpf(r))))
            assert abs(mpf(float(trace.value)) - true) <= mpf(float(trace.error))


def test_a_division_by_what_may_be_zero_has_no_bound() -> None:
    assert (Rounded(1.0) / Rounded(1e-20, 1e-18)).error == np.inf
    k = coefficients(Rounded(0.1, 0.5), Rounded(0.5), 1, ROUNDED)
    assert k.gbar_sine.error > 1
