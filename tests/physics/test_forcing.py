"""What a force with harmonics is and does, by its phase."""

from __future__ import annotations

from decimal import localcontext
from math import cos, pi, radians, sin

import numpy as np
import pytest
from mpmath import mp, mpf

from vireport.physics.forcing import Harmonic, peaks, unaccelerated, unaccelerated_by, wave, with_harmonic
from vireport.physics.numbers import DIGITS, DecimalOps

FORCES = [
    ((2, 0.02, 225.0),),
    ((3, 0.1, 30.0), (2, 0.05, 45.0)),
    ((5, 0.3, 30.0),),
    ((2, 0.5, 10.0), (8, 0.4, 70.0)),
]
"""Order, share and phase in degrees of harmonics."""


def test_peaks_of_a_force_are_those_of_many_phases() -> None:
    x = np.linspace(0, 2 * pi, 200001)
    for parts in FORCES:
        largest = peaks(tuple(Harmonic.of(j, 100 * p, psi) for j, p, psi in parts))
        force, impulse, path = np.cos(x), np.sin(x), np.cos(x)
        for j, p, psi in parts:
            turned = j * x + radians(psi)
            force, impulse, path = (
                force + p * np.cos(turned),
                impulse + p * np.sin(turned) / j,
                path + p * np.cos(turned) / j**2,
            )
        expected = np.abs(force).max(), np.abs(impulse).max(), np.ptp(path) / 2, -force.min()
        assert tuple(largest) == pytest.approx(expected, rel=1e-8)


def test_a_harmonic_is_that_of_its_phase() -> None:
    for order, share, phase in ((2, 0.05, 225.0), (3, 0.2, -77.0), (4, 0.1, 359.0), (2, 0.3, 90.0)):
        own = Harmonic.of(order, 100 * share, phase)
        for x in (0.0, 0.3, 4.0):
            expected = share * cos(order * x + radians(phase))
            assert own.cosine * cos(order * x) + own.sine * sin(order * x) == pytest.approx(expected, abs=1e-15)
        assert own.share == pytest.approx(share, rel=1e-15)
        assert own.phase_deg == pytest.approx(phase % 360, abs=1e-12)
    assert Harmonic.of(2, 30.0, 90.0).cosine == 0
    assert Harmonic.of(2, 30.0, -180.0).sine == 0


def test_a_wave_is_the_force_and_its_integrals() -> None:
    """By differences: the impulse grows with the force, and the path falls with the impulse."""
    for parts in FORCES:
        harmonics, step = tuple(Harmonic.of(j, 100 * p, psi) for j, p, psi in parts), 1e-5
        for x in (0.0, 0.7, 3.9):
            before, here, after = (wave(sin(y), cos(y), harmonics) for y in (x - step, x, x + step))
            expected = cos(x) + sum(p * cos(j * x + radians(psi)) for j, p, psi in parts)
            assert here.force == pytest.approx(expected, abs=1e-14)
            assert (after.impulse - before.impulse) / (2 * step) == pytest.approx(here.force, abs=1e-8)
            assert (after.path - before.path) / (2 * step) == pytest.approx(-here.impulse, abs=1e-8)


def test_the_pull_is_zero_at_all_phases_where_it_changes_sign() -> None:
    x = np.linspace(0, 2 * pi, 20001)
    for parts in FORCES:
        harmonics = tuple(Harmonic.of(j, 100 * p, psi) for j, p, psi in parts)
        for gbar in (0.0, 0.3, 0.9):
            pull = gbar + wave(np.sin(x), np.cos(x), harmonics).force
            crossed = x[:-1][pull[:-1] * pull[1:] < 0]
            found = np.array(unaccelerated(gbar, harmonics))
            assert all(np.abs(found - each).min() < 1e-3 for each in crossed)
            assert len(found) <= 2 * max(own.order for own in harmonics)


def test_of_one_order_parts_are_added() -> None:
    both = with_harmonic((Harmonic(2, 0.1, 0.2), Harmonic(3, 0.3, 0.0)), Harmonic(2, 0.01, -0.2))
    assert [(own.order, own.cosine, own.sine) for own in both] == [(3, 0.3, 0.0), (2, pytest.approx(0.11), 0.0)]


def test_in_decimals_a_harmonic_has_all_digits_of_what_is_given() -> None:
    with mp.workdps(50), localcontext(prec=DIGITS):
        for percent, phase in ((5.1, 225.0), (0.3, -77.7), (49.9, 360.0)):
            own = Harmonic.of(3, percent, phase)
            exact, share, angle = own.exact(DecimalOps()), mpf(percent) / 100, mpf(phase) * mp.pi / 180
            for part, double, true in (
                (exact.cosine, own.cosine, share * mp.cos(angle)),
                (exact.sine, own.sine, -share * mp.sin(angle)),
            ):
                assert abs(mpf(str(part)) - true) < mpf(10) ** -37
                assert abs(double - float(true)) <= 4 * np.spacing(percent / 100)


@pytest.mark.parametrize("size", [1e-6, 1e-9, 1e-11, 1e-13, 1e-300])
def test_a_harmonic_next_to_nothing_hides_no_phase(size: float) -> None:
    for order in (2, 5, 8):
        found = unaccelerated(0.3, (Harmonic(order, size, -size),))
        assert found == pytest.approx((np.arccos(-0.3), 2 * np.pi - np.arccos(-0.3)), abs=3 * size + 1e-6)
        many = unaccelerated_by(np.array([0.3, 2.0]), (Harmonic(order, size, -size),))
        assert [row[~np.isnan(row)].tolist() for row in many] == [list(found), []]
