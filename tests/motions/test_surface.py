"""The surface of motions: its identities, its symmetries, its level curves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from scipy.optimize import minimize_scalar
from strategies import phases, shares

from vireport.motions.level_curve import evaluate, find_strands
from vireport.motions.level_plane import SweptPlane
from vireport.motions.orbits import coefficients, orbits
from vireport.motions.sweep import Held, Level, level_residual

restitutions = st.floats(0, 0.999)
ratios = st.integers(1, 5)


@given(shares, phases, restitutions, ratios)
def test_printed_equations_hold(u: float, phi: float, r: float, n: int) -> None:
    o = orbits(u, phi, r, n)
    period, q = 2 * n, 0.5 + u
    up, down = period * q, period * (1 - q)
    a, s, c = np.pi * up, np.sin(phi), np.cos(phi)
    v, g, d = o.velocity_bottom, o.gbar, o.d
    size = 1 + abs(v) + abs(g) * period + abs(d)
    eq39 = (r - 1) * v - (np.cos(a) - 1) / np.pi * s - np.sin(a) / np.pi * c + g * (period / (1 + r) - up)
    eq310 = (r * up - down) * v + period / np.pi * s - period / 2 * (up - down) * g
    eq311 = (
        (np.cos(a) - 1) / np.pi**2 * c
        - np.sin(a) / np.pi**2 * s
        + up * down / (2 * period) * (2 * (1 + r) * v - g * period)
        - d
    )
    assert abs(eq39) < 1e-12 * size
    assert abs(eq310) < 1e-12 * size * period
    assert abs(eq311) < 1e-12 * size * period


@given(shares, restitutions, ratios)
def test_determinant_never_vanishes(u: float, r: float, n: int) -> None:
    assert coefficients(u, r, n).determinant <= -n * n * (1 - r) ** 2 / (1 + r) * (1 - 1e-9)


@given(shares, phases, st.floats(0.01, 0.99), st.sampled_from([1, 3, 5]))
def test_mirror_image_is_a_motion_against_gravity(u: float, phi: float, r: float, n: int) -> None:
    """Z to -Z with the forcing half a period later: q to 1 - q, gravity reversed, impact velocities exchanged."""
    orbit = orbits(u, phi, r, n)
    two = orbits(-u, np.arctan2(orbit.sin_top, orbit.cos_top) + np.pi, r, n)
    scale = 1 + abs(orbit.velocity_bottom) + abs(orbit.velocity_top) + abs(orbit.d)
    assert two.gbar == pytest.approx(-orbit.gbar, abs=1e-11 * scale)
    assert two.d == pytest.approx(orbit.d, abs=1e-11 * scale * n)
    assert two.velocity_bottom == pytest.approx(-orbit.velocity_top, abs=1e-11 * scale)


def test_symmetric_family_in_closed_form() -> None:
    phi, r = np.linspace(0, 2 * np.pi, 50), 0.37
    o = orbits(np.zeros(50), phi, r, 1)
    np.testing.assert_allclose(o.gbar, 0, atol=1e-16)
    np.testing.assert_allclose(o.velocity_bottom, 2 * np.sin(phi) / (np.pi * (1 - r)), rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(
        o.d, (1 + r) * o.velocity_bottom / 2 - 2 * np.cos(phi) / np.pi**2, rtol=1e-13, atol=1e-15
    )
    np.testing.assert_allclose(o.velocity_top, -o.velocity_bottom, rtol=1e-14, atol=1e-15)


@given(st.floats(1e-15, 1e-3), phases, st.floats(0, 0.98))
def test_gbar_keeps_its_digits_next_to_the_symmetric_motion(u: float, phi: float, r: float) -> None:
    with mp.workdps(50):
        m, q, p = mpf(r), mpf(u) + mpf(1) / 2, mpf(phi)
        up, down = 2 * q, 2 - 2 * q
        matrix = mp.matrix([[m - 1, 2 / (1 + m) - up], [m * up - down, -(up - down)]])
        a = mp.pi * up
        right = mp.matrix([((mp.cos(a) - 1) * mp.sin(p) + mp.sin(a) * mp.cos(p)) / mp.pi, -2 * mp.sin(p) / mp.pi])
        exact = mp.lu_solve(matrix, right)[1]
        k = coefficients(u, r, 1)
        size = abs(float(k.gbar_sine)) + abs(float(k.gbar_cosine))
        assert abs(mpf(float(orbits(u, phi, r, 1).gbar)) - exact) <= 1e-14 * size


@pytest.mark.parametrize(
    "level",
    [
        Level(Held.GBAR, 0.0),
        Level(Held.GBAR, 0.3),
        Level(Held.GBAR, 1.1),
        Level(Held.GBAR, 1e-9),
        Level(Held.RATIO, 1.7),
        Level(Held.D, 0.5),
        Level(Held.D, 0.9),
    ],
)
@pytest.mark.parametrize("n", [1, 2, 3])
def test_strands_lie_on_their_level(level: Level, n: int) -> None:
    strands = find_strands(SweptPlane(level, 0.5, n))
    for k, strand in enumerate(strands):
        w = np.linspace(strand.start, strand.end, 301)
        o = evaluate(SweptPlane(level, 0.5, n), strands, k, w)
        scale = 1 + np.abs(o.d) + np.abs(o.gbar)
        assert np.max(np.abs(level_residual(level, o)) / scale) < 1e-13 * n * n
        if strand.closed:
            assert o.u[0] == pytest.approx(o.u[-1], abs=1e-12)
        else:
            assert np.abs(o.u[[0, -1]]) == pytest.approx(0.5)


def test_strands_cover_every_share_at_which_the_level_has_motions() -> None:
    for level in (
        Level(Held.GBAR, 0.2875),
        Level(Held.GBAR, 0.05),
        Level(Held.GBAR, 1.1),
        Level(Held.D, 0.05),
        Level(Held.D, 0.9),
    ):
        u = np.linspace(-0.4999, 0.4999, 100_003)
        a, b, c = SweptPlane(level, 0.5, 1).terms(coefficients(u, 0.5, 1), u)
        exists = np.hypot(a, b) > np.abs(c)
        covered = np.zeros_like(exists)
        for strand in find_strands(SweptPlane(level, 0.5, 1)):
            covered |= (u > strand.low) & (u < strand.high)
        assert (exists == covered).all()


@pytest.mark.parametrize(("held", "n"), [(Held.D, 1), (Held.GBAR, 1), (Held.D, 2)])
def test_a_tiny_interval_of_motions_between_two_samples_is_found(held: Held, n: int) -> None:
    """Just below the largest d or gbar of any motion, motions exist only in slivers of q."""

    def reach(u: float) -> float:
        k = coefficients(u, 0.5, n)
        return float(np.hypot(k.d_sine, k.d_cosine) if held is Held.D else np.hypot(k.gbar_sine, k.gbar_cosine))

    u = np.linspace(-0.49, 0.49, 2001)
    k = int(np.argmax([reach(at) for at in u]))
    top = -minimize_scalar(lambda at: -reach(at), bracket=u[k - 1 : k + 2], tol=1e-14).fun
    strands = find_strands(SweptPlane(Level(held, top * (1 - 1e-10)), 0.5, n))
    assert any(s.low < u[k] + 1e-3 and s.high > u[k] - 1e-3 for s in strands)
    assert 0 < sum(s.high - s.low for s in strands) < 1e-3
    assert find_strands(SweptPlane(Level(held, top * (1 + 1e-7)), 0.5, n)) == []
