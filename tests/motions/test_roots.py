"""Roots and extrema of arrays of brackets: to the last bit, and never outside."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from vireport.motions.roots import (
    Crossing,
    Guesses,
    bracketed_root,
    cubic_root,
    golden_minimum,
    golden_section,
    may_hide_zeros,
    newton_root,
    path_root,
    secant_root,
)

SHIFT = np.array([0.1, 1e-8, 0.7, 3.0])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_bracket_is_closed_to_the_last_bit(sign: float) -> None:
    zero = bracketed_root(lambda x: sign * (x**3 - SHIFT), np.zeros(4), np.full(4, 2.0))
    np.testing.assert_allclose(zero, np.cbrt(SHIFT), rtol=1e-15)
    swapped = bracketed_root(lambda x: sign * (x**3 - SHIFT), np.full(4, 2.0), np.zeros(4))
    np.testing.assert_allclose(swapped, np.cbrt(SHIFT), rtol=1e-15)


@pytest.mark.parametrize("shift", [0.1, 0.7, 3.0])
def test_a_bracket_is_closed_in_a_quarter_of_the_steps_of_bisection(shift: float) -> None:
    """Which takes 54 evaluations from a width of 2 to the last bit."""
    at = []
    bracketed_root(lambda x: at.append(x) or x**3 - shift, np.zeros(1), np.full(1, 2.0))
    assert len(at) <= 13


def test_a_bracket_is_closed_where_values_are_infinite_or_none() -> None:
    """NaN counts as one side; what is left is the end on the side of the other one that was given."""
    for beyond in (np.nan, -np.inf):
        function = partial(lambda beyond, x: np.where(x < SHIFT, beyond, 1.0 + x), beyond)
        zero = bracketed_root(function, np.zeros(4), np.full(4, 4.0))
        np.testing.assert_allclose(zero, SHIFT, rtol=1e-15)
        assert np.all(zero >= SHIFT)


def test_a_bracket_is_closed_to_a_tolerance_or_better() -> None:
    rough = bracketed_root(lambda x: x**3 - SHIFT, np.zeros(4), np.full(4, 2.0), 1e-7)
    assert np.all(np.abs(rough - np.cbrt(SHIFT)) <= 1e-7)
    assert bracketed_root(np.sin, np.empty(0), np.empty(0)).size == 0


@pytest.mark.parametrize("guess", [0.0, 0.2, 5.0, 20.0, np.nan])
@pytest.mark.parametrize("count", [4, 4000])
def test_newton_steps_stay_in_the_bracket(count: int, guess: float) -> None:
    """On arctan, from far away, they would diverge; a slope of zero is a bisection."""
    middle, start = np.linspace(0.1, 9.9, count), np.full(count, guess)

    def function(x: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        away = 50 * (x - middle[which])
        assert np.all((x > 0) & (x < 10))
        return -np.arctan(away), -50 / (1 + away * away)

    zero = newton_root(function, np.zeros(count), np.full(count, 10.0), start, np.zeros(count, dtype=bool), 1e-15)
    np.testing.assert_allclose(zero, middle, rtol=0, atol=1e-14)


def test_secant_steps_find_the_zero_that_was_called_last() -> None:
    called = np.zeros(4)

    def function(x: np.ndarray, which: np.ndarray) -> np.ndarray:
        called[which] = x
        return x**3 - SHIFT[which]

    guesses = Guesses(np.zeros(4), np.full(4, 2.0), -SHIFT, np.ones(4, dtype=bool), np.full(4, 1.0), np.full(4, 4.0))
    zero = secant_root(function, guesses, 2e-16)
    np.testing.assert_allclose(zero, np.cbrt(SHIFT), rtol=1e-15)
    assert np.array_equal(zero, called)


def test_a_cubic_gives_a_start_for_a_search() -> None:
    rng = np.random.default_rng(1)
    zero, c2, c3 = rng.uniform(0, 1, 100), rng.uniform(-0.2, 0.2, 100), rng.uniform(-0.1, 0.1, 100)
    value = -(zero + c2 * zero**2 + c3 * zero**3)
    root, slope = cubic_root(value, 1 + c2 + c3, (np.ones(100), c2, c3))
    np.testing.assert_allclose(root, zero, rtol=0, atol=0.05)
    np.testing.assert_allclose(slope, 1 + 2 * c2 * zero + 3 * c3 * zero**2, rtol=0.05)


def test_minimum_and_the_zeros_it_may_hide() -> None:
    x, dip = np.linspace(-1, 1, 12), np.array([0.35])

    def function(x: np.ndarray) -> np.ndarray:
        return (x - dip) ** 2 - 1e-4  # two zeros 0.02 apart, between two samples

    values = function(x)
    assert (values > 0).all()
    (row,) = np.flatnonzero(may_hide_zeros(values)) + 1
    lowest = golden_minimum(function, x[[row - 1]], x[[row + 1]], 45)
    assert lowest == pytest.approx(dip, abs=1e-8)
    assert function(lowest) < 0
    assert not may_hide_zeros(values + 1).any()


@pytest.mark.parametrize("end", [2.0, -2.0])
def test_the_zero_of_one_bracket_is_that_of_an_argument_that_was_evaluated(end: float) -> None:
    called = []

    def function(x: float) -> float:
        called.append(x)
        return float(np.sign(end)) * x**3 - 0.7

    zero = path_root(function, end, True, Crossing(end / 3, 4.0 * float(np.sign(end))), 1e-13)
    assert zero.at == pytest.approx(float(np.sign(end)) * np.cbrt(0.7), rel=1e-12)
    assert zero.slope == pytest.approx(3 * np.sign(end) * np.cbrt(0.7) ** 2, rel=1e-3)
    assert zero.at in called
    assert len(called) < 15


def test_a_step_is_bisected_to_the_last_bit() -> None:
    # As the least of several gaps, flat up to where another one falls: secants would go on for ever.
    zero = path_root(lambda x: 1.0 if x > 0.3 else -1e-6, 1.0, True, Crossing(0.9, 1.0), 1e-11)
    assert zero.at == pytest.approx(0.3, abs=1e-15)


def test_a_golden_section_evaluates_once_for_each_step() -> None:
    called = []
    lowest = golden_section(lambda x: called.append(x) or (x - 0.35) ** 2, -1.0, 1.0, 30)
    assert lowest == pytest.approx(0.35, abs=1e-6)
    assert len(called) == 32
