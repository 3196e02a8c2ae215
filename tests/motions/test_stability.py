"""Jacobians, trace, determinant and Table 1's words."""

from __future__ import annotations

import numpy as np
import pytest
from exact import return_determinant
from hypothesis import given
from hypothesis import strategies as st

from vireport.motions.orbits import orbits
from vireport.motions.stability import STABILITIES, classify, discriminant, eigenvalues, flight_jacobian, return_trace
from vireport.physics import flight


@given(st.floats(-0.45, 0.45), st.floats(0, 6.28), st.floats(0.05, 0.95), st.integers(1, 3))
def test_determinant_is_r_to_the_fourth(u: float, phi: float, r: float, n: int) -> None:
    o = orbits(u, phi, r, n)
    slow = min(abs(o.velocity_bottom), abs(o.velocity_top))
    if slow < 1e-2:
        return
    determinant = return_determinant(o, r)
    assert determinant == pytest.approx(r**4, rel=1e-9, abs=1e-9 / slow**2)


def _arrival(
    d: float, gbar: float, r: float, time: float, velocity: float, guess: float, start: float
) -> tuple[float, float]:
    """Time and velocity of the arrival at the opposite wall, by Newton's method on the closed-form flight."""
    t, after = guess, flight.reflect(velocity, r)
    phase = np.pi * time
    for _ in range(50):
        later = phase + np.pi * t
        z = start + flight.displacement(t, after, np.sin(phase), np.cos(phase), np.cos(later), gbar) + start
        v = flight.velocity(t, after, np.sin(phase), np.sin(later), gbar)
        t -= z / v
    return time + t, v


@pytest.mark.parametrize(
    "where", [(0.086061, 0.566725, 0.5), (0.150610, 0.210234, 0.5), (0.0, 0.6, 0.5), (0.05, 0.8, 0.8)]
)
def test_jacobian_against_central_differences_with_second_order(where: tuple[float, float, float]) -> None:
    u, phi, r = where
    o = orbits(u, phi, r, 1)
    start = float(o.d) / 2
    jacobian = flight_jacobian(
        o.time_up, (o.velocity_bottom, o.velocity_top), (o.gbar + o.cos_phi, o.gbar + o.cos_top), r
    )
    exact = np.array(jacobian).reshape(2, 2)
    x = np.array([phi / np.pi, float(o.velocity_bottom)])

    def image(y: np.ndarray) -> np.ndarray:
        return np.array(_arrival(o.d, o.gbar, r, y[0], y[1], o.time_up, start))

    errors = []
    for h in (2e-3, 1e-3, 5e-4):
        columns = [(image(x + h * e) - image(x - h * e)) / (2 * h) for e in np.eye(2)]
        errors.append(np.abs(np.stack(columns, axis=1) - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 2) < 0.2)


def test_classification_at_and_around_each_boundary() -> None:
    r = 0.5
    edge, focus = 1 + r**4, 2 * r * r
    words = [
        STABILITIES[i]
        for i in classify(
            np.array([0, focus, -focus, np.nextafter(focus, 0), edge, -edge, np.nextafter(edge, 0), 9.0]), r * r
        )
    ]
    assert words == [
        "stable focus",
        "stable node",
        "stable node",
        "stable focus",
        "unstable node",
        "unstable node",
        "stable node",
        "unstable node",
    ]


@given(st.floats(-50, 50), st.floats(0.05, 0.99))
def test_eigenvalues_solve_the_characteristic_equation(trace: float, r: float) -> None:
    larger, smaller = eigenvalues(trace, r * r)
    assert larger >= smaller
    assert larger + smaller == pytest.approx(trace, rel=1e-12, abs=1e-300)
    if discriminant(trace, r * r) >= 0:
        assert larger * smaller == pytest.approx(r**4, rel=1e-12)
        small = min(abs(larger), abs(smaller))
        exact = np.roots([1.0, -trace, r**4]) if discriminant(trace, r * r) > 1e-3 else None
        if exact is not None:
            assert small == pytest.approx(min(abs(exact)), rel=1e-9)
    else:
        assert larger == smaller


def test_types_agree_with_the_eigenvalues() -> None:
    rng = np.random.default_rng(1)
    trace, r = rng.uniform(-3, 3, 10_000), 0.6
    larger, smaller = eigenvalues(trace, r * r)
    largest = np.where(discriminant(trace, r * r) < 0, r * r, np.maximum(np.abs(larger), np.abs(smaller)))
    words = np.array(STABILITIES)[classify(trace, r * r)]
    assert (np.char.startswith(words, "stable") == (largest < 1)).all()
    assert (np.char.endswith(words, "focus") == (discriminant(trace, r * r) < 0)).all()


def test_symmetric_motion_is_a_square_of_its_half_map() -> None:
    """For a horizontal capsule tr DP = s^2 - 2 r^2, with s the trace of the mirrored half map."""
    r, phi = 0.5, np.linspace(0.2, 1.5, 40)
    o = orbits(np.zeros(40), phi, r, 1)
    a11, _, _, a22 = flight_jacobian(o.time_up, (o.velocity_bottom, o.velocity_top), (o.cos_phi, o.cos_top), r)
    np.testing.assert_allclose(return_trace(o, r), (a11 - a22) ** 2 - 2 * r * r, rtol=1e-12)
