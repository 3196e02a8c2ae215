"""A force as it was recorded: flights under its spline, against closed forms, 40 digits and steps of fixed length."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi

import mpmath as mp
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from vireport import load
from vireport.design.solution import solution_of
from vireport.physics.cubics import Cubics
from vireport.physics.device import Device
from vireport.physics.groups import Groups, Restitutions, SpeedLaw
from vireport.simulation.events import Impact, check_model, check_start, follow_one, follow_recorded
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, VELOCITY, WALL

BEGUN = 0.3
"""Phase of the force at the first sample [rad]."""

PLAIN = Groups(0.4648, 0.28758, 0.5)
UNALIKE = Groups(0.3, 0.2, Restitutions(0.55, 0.45))
FALLING = Groups(0.4648, 0.28758, SpeedLaw(0.5, 0.5, -0.15, 1.0))
RESTING = Groups(0.9, 0.75, 0.4)


def sine(samples: int, periods: int, noise: float = 0.0, seed: int = 0) -> tuple[np.ndarray, float]:
    """Samples of a sine, so many in a period, and their step."""
    step = 2 / samples
    own = np.cos(pi * step * np.arange(periods * samples + 1) + BEGUN)
    return own + noise * np.random.default_rng(seed).standard_normal(len(own)), step


def driven(groups: Groups, samples: np.ndarray, step: float, start: Impact, **how: bool) -> tuple[np.ndarray, Cubics]:
    cubics = Cubics.of(samples, step, groups.gbar)
    how = {"compiled": False} | how
    rows, _ = follow_recorded(check_model(groups)[0], check_start(start, groups.d), cubics, 10_000, **how)
    return rows, cubics


def test_a_sampled_sine_gives_the_closed_form_to_the_fourth_order_of_the_step() -> None:
    device = Device.of(load("examples/design-point.yaml").scenario)
    motions = solution_of(device, None, None, True).design.motions
    k = int(np.argmax(motions.stable_mask))
    speed, phase = float(motions.velocity_bottom[k]), float(motions.phi_bottom[k])
    groups = Groups(float(motions.d[k]), float(motions.gbar[k]), 0.5)
    errors = []
    for samples in (25, 50, 100, 200):
        step = 2 / samples
        own = np.cos(pi * step * np.arange(12 * samples + 1) + phase)
        rows, _ = driven(groups, own, step, Impact(1, speed, phase))
        bottom = rows[rows[:, WALL] > 0][2:]
        assert len(bottom) >= 9
        errors.append(max(np.abs(bottom[:, VELOCITY] - speed).max(), np.abs(bottom[:, PHASE] - phase).max()))
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (orders > 3.8).all(), orders
    assert errors[-1] < 2e-8


@pytest.mark.parametrize("groups", [PLAIN, UNALIKE, FALLING, RESTING], ids=["plain", "unalike", "falling", "resting"])
def test_a_sampled_sine_gives_the_impacts_of_the_sine(groups: Groups) -> None:
    start = Impact(1, 0.6, BEGUN)
    expected, _ = follow_one(check_model(groups)[0], check_start(start, groups.d), 24, compiled=False)
    rows, _ = driven(groups, *sine(800, 14), start)
    count = min(len(rows), len(expected))
    assert count > 15
    assert np.array_equal(rows[:count, WALL], expected[:count, WALL])
    np.testing.assert_allclose(rows[:count, 1:], expected[:count, 1:], atol=3e-8)
    assert ((rows[:, SETTLING] > 0).any() and (rows[:, RIDING] > 0).any()) == (groups is RESTING)


def replayed(v: mp.mpf, left: mp.mpf, cubics: Cubics, place: int, since: mp.mpf) -> list[mp.mpf]:
    """The quintic of Z from a place of a row on, in 40 digits, highest power first."""
    _, *given, _ = map(mp.mpf, cubics.rows[place])
    a, b, c, e = given
    a, b, c = a + since * (b + since * (c / 2 + since * e / 6)), b + since * (c + since * e / 2), c + since * e
    return [e / 120, c / 24, b / 6, a / 2, v, left]


@pytest.mark.filterwarnings("ignore:Descending:DeprecationWarning")
def test_flights_are_replayed_in_40_digits_and_no_impact_is_missed() -> None:
    own, step = sine(12, 4, noise=0.1, seed=1)
    rows, cubics = driven(PLAIN, own, step, Impact(1, 0.6, BEGUN))
    d, r = PLAIN.d, PLAIN.restitution
    with mp.workdps(40):
        place, since = 0, mp.mpf(0)
        for before, after in pairwise(rows):
            assert not before[SETTLING]
            z, v = mp.mpf(before[WALL]) * d / 2, -mp.mpf(r) * mp.mpf(before[VELOCITY])
            time, flight = mp.mpf(0), mp.mpf(after[FLIGHT])
            while True:
                length = mp.mpf(cubics.rows[place, 0]) - since
                quintic = replayed(v, z, cubics, place, since)
                last = time + length >= flight
                t = flight - time if last else length
                for wall in (d / 2, -d / 2):
                    roots = mp.polyroots([*quintic[:-1], z - wall], maxsteps=200, extraprec=200)
                    real = [x.real for x in map(mp.mpc, roots) if abs(x.imag) < 1e-25]
                    assert not [x for x in real if 1e-13 < x < t - mp.mpf(1e-13)]
                derivative = [(5 - k) * quintic[k] for k in range(5)]
                z, v = mp.polyval(quintic, t), mp.polyval(derivative, t)
                time += t
                if last:
                    since += t
                    break
                place, since = place + 1, mp.mpf(0)
            assert abs(z - mp.mpf(after[WALL]) * d / 2) < 1e-13
            assert abs(v - mp.mpf(after[VELOCITY])) < 1e-13


def test_steps_of_fixed_length_meet_the_same_impacts() -> None:
    own, step = sine(30, 8, noise=0.02)
    rows, _ = driven(PLAIN, own, step, Impact(1, 0.6, BEGUN))
    spline, d, r = CubicSpline(step * np.arange(len(own)), own), PLAIN.d, PLAIN.restitution
    t, z, v, h, met = 0.0, d / 2, -r * 0.6, step / 16, []

    def moved(t: float, z: float, v: float, h: float) -> tuple[float, float]:
        a, b, c = PLAIN.gbar + spline([t, t + h / 2, t + h])
        return z + h * v + h * h / 6 * (a + 2 * b), v + h / 6 * (a + 4 * b + c)

    while t + h < step * (len(own) - 1):
        new, speed = moved(t, z, v, h)
        if abs(new) <= d / 2:
            t, z, v = t + h, new, speed
            continue
        wall, low, high = np.sign(new), 0.0, h
        for _ in range(50):
            low, high = (low, (low + high) / 2) if abs(moved(t, z, v, (low + high) / 2)[0]) > d / 2 else (
                (low + high) / 2, high)  # fmt: skip
        _, v = moved(t, z, v, low)
        t, z = t + low, wall * d / 2
        met.append((t, wall, v))
        v *= -r
    times = np.cumsum(rows[1:, FLIGHT])
    assert len(met) > 12
    np.testing.assert_allclose(met, np.column_stack([times, rows[1:, WALL], rows[1:, VELOCITY]])[: len(met)], atol=2e-6)


def test_the_ball_lies_until_it_is_let_go_and_then_for_as_long_as_nothing_lifts_it() -> None:
    own, step = sine(100, 3)
    lifted = PLAIN._replace(gbar=0.5)
    rows, _ = driven(lifted, own, step, Impact(1, 0.0, BEGUN))
    assert rows[0, RIDING] == pytest.approx((np.arccos(-0.5) - BEGUN) / pi, abs=1e-6)
    heavy = PLAIN._replace(gbar=1.5)
    rows, _ = driven(heavy, own, step, Impact(1, 0.0, BEGUN))
    assert len(rows) == 1
    assert np.isinf(rows[0, RIDING])


def test_pieces_go_through_the_samples_and_have_one_sign_each() -> None:
    own, step = sine(9, 6, noise=0.5)
    cubics = Cubics.of(own, step, 0.3)
    assert cubics.duration == pytest.approx(step * (len(own) - 1), rel=1e-14)
    assert len(cubics.rows) > len(own)
    ends = np.concatenate([[0.0], np.cumsum(cubics.rows[:, 0])])
    spline = CubicSpline(step * np.arange(len(own)), own + 0.3)
    for row, start in zip(cubics.rows, ends, strict=False):
        inside = row[0] * np.linspace(0.01, 0.99, 9)
        values = row[1] + inside * (row[2] + inside * (row[3] / 2 + inside * row[4] / 6))
        np.testing.assert_allclose(values, spline(start + inside), atol=1e-12)
        assert (np.sign(values) == -row[5]).all()


def test_what_cannot_be_followed_is_refused() -> None:
    own, step = sine(20, 2)
    with pytest.raises(ValueError, match="4 are needed"):
        Cubics.of(own[:3], step, 0.3)
    with pytest.raises(ValueError, match="friction is not simulated with a recorded force"):
        driven(PLAIN._replace(friction=0.1), own, step, Impact(1, cos(1.0), BEGUN))


@pytest.mark.slow
def test_compiled_and_interpreted_are_the_same() -> None:
    own, step = sine(60, 20, noise=0.05)
    for groups in (PLAIN, RESTING):
        rows, _ = driven(groups, own, step, Impact(1, 0.6, BEGUN))
        compiled, _ = driven(groups, own, step, Impact(1, 0.6, BEGUN), compiled=True)
        np.testing.assert_array_equal(rows, compiled)
