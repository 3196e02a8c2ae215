"""Spread under random kicks: against Monte Carlo, and refused where linear theory is wrong."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from conftest import first
from devices import DISTORTED, case, of

from vireport.findings.outcomes.deviations import flight_matrices, kick_effects, stationary
from vireport.findings.outcomes.impact_map import backwards, forwards
from vireport.findings.outcomes.jitter import TOLERANCE, Jitter, NoJitter, Unsettled, jitter
from vireport.physics.device import Device
from vireport.physics.energy import Membrane, generated_voltage
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import wrapped
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import InFlight, check_model, follow_impacts

MEMBRANE = Membrane(4.0847e5, 2.6, 6.3e-3, 5e-3, 2000.0, 0.0041)


def kicked(
    groups: Groups[float], motion: Motion, kick: float, scatter: float, starts: int, wait: int, periods: int
) -> list[np.ndarray]:
    """Deviations (2, n) of time and velocity before each impact of kicked trajectories, by the simulation alone."""
    random, count = np.random.default_rng(5), len(motion.word)
    phase, velocity = np.full(starts, pi * motion.time[0]), np.full(starts, motion.velocity[0])
    model, times = np.repeat(check_model(groups), starts, axis=0), np.append(motion.time, 0.0)
    seen: list[list[np.ndarray]] = [[] for _ in range(count)]
    for step in range((wait + periods) * count):
        i, j = step % count, (step + 1) % count
        r = groups.restitution
        after = -(r + scatter * random.standard_normal(starts)) * velocity + kick * random.standard_normal(starts)
        rows = np.stack([np.full(starts, motion.word.walls[i]), 0 * phase, -after / r, np.mod(phase, 2 * pi)], axis=1)
        ends = follow_impacts(model, rows, 1, 1)[0][:, -1]
        assert (ends[:, 0] == motion.word.walls[j]).all()
        phase, velocity = ends[:, 1], ends[:, 3]
        if step >= wait * count:
            seen[j].append(np.stack([wrapped(phase - pi * times[j]) / pi, velocity - motion.velocity[j]]))
    return [np.concatenate(each, axis=1) for each in seen]


def monte_carlo(*given: Any) -> np.ndarray:
    """Their covariances, (N, 2, 2)."""
    return np.array([np.cov(each) for each in kicked(*given)])


@pytest.mark.parametrize("harmonics", [(), DISTORTED], ids=["sine", "harmonics"])
def test_the_map_is_that_of_the_simulation_and_its_inverse(harmonics: tuple[Harmonic, ...]) -> None:
    """Backwards undoes forwards, and the Jacobians are its differences."""
    groups, (motion,), _, _ = case(harmonics=harmonics)
    rng = np.random.default_rng(1)
    wall = np.repeat([1.0, -1.0], 100)
    time, after = rng.uniform(0, 2, 200), -wall * rng.uniform(0.05, 1.5, 200)
    ends = forwards(groups, wall, time, after)
    back = backwards(groups, ends.wall, ends.time, ends.velocity)
    np.testing.assert_array_equal(back.wall, wall)
    np.testing.assert_allclose(back.time, time, atol=1e-10)
    np.testing.assert_allclose(back.velocity, after, atol=1e-10)
    step = 1e-6
    for i, (matrix, effect) in enumerate(
        zip(flight_matrices(groups, motion), kick_effects(groups, motion), strict=True)
    ):
        here = motion.time[i], -groups.restitution * motion.velocity[i]
        moved = np.array([(step, 0), (-step, 0), (0, step), (0, -step)]) + here
        ends = forwards(groups, motion.word.walls[i], *moved.T)
        slopes = np.array([np.array(each)[::2] - np.array(each)[1::2] for each in ends[1:]]) / (2 * step)
        np.testing.assert_allclose(slopes[:, 0], matrix[:, 0], rtol=1e-7)
        np.testing.assert_allclose(slopes[:, 1], effect, rtol=1e-7)
        np.testing.assert_allclose(-groups.restitution * effect, matrix[:, 1], rtol=1e-12)


def test_the_lyapunov_equation_is_solved() -> None:
    matrix, source = np.array([[0.3, -0.8], [0.5, 0.2]]), np.array([[2.0, 0.7], [0.7, 1.0]])
    found = stationary(matrix, source)
    np.testing.assert_allclose(found, matrix @ found @ matrix.T + source, rtol=1e-13)


@pytest.mark.parametrize(
    ("kick", "scatter", "harmonics"),
    first(1, [(1e-3, 2e-3, ()), (1e-3, 0.0, ()), (0.0, 3e-3, ()), (1e-3, 2e-3, DISTORTED)], unpacked=True),
)
def test_spread_is_that_of_kicked_trajectories(kick: float, scatter: float, harmonics: tuple[Harmonic, ...]) -> None:
    groups, (motion,), _, _ = case(3.6, harmonics=harmonics)
    found = jitter(groups, motion, kick, scatter)
    assert isinstance(found, Jitter)
    assert found.error < 0.01
    seen = monte_carlo(groups, motion, kick, scatter, 4000, 20, 10)
    np.testing.assert_allclose(seen / found.covariance, 1, atol=0.08)
    np.testing.assert_allclose(found.phase_rad, pi * np.sqrt(seen[:, 0, 0]), rtol=0.03)
    np.testing.assert_allclose(found.velocity, np.sqrt(seen[:, 1, 1]), rtol=0.03)


@pytest.mark.slow
def test_spread_of_a_motion_with_more_impacts() -> None:
    """The 2:1 motion that every start of a device with 0.3 m leads to."""
    groups = case(3.0, 0.3).groups
    cycle = find_attractor(groups, InFlight(0.0, 0.5, 1.0)).cycle
    assert cycle is not None
    motion = cycle.motion(groups.d)
    found = jitter(groups, motion, 1e-5)
    assert isinstance(found, Jitter)
    assert len(found.phase_rad) == len(motion.word) > 2
    seen = monte_carlo(groups, motion, 1e-5, 0.0, 4000, 30, 10)
    np.testing.assert_allclose(found.velocity, np.sqrt(seen[:, 1, 1]), rtol=0.03)
    np.testing.assert_allclose(found.phase_rad, pi * np.sqrt(seen[:, 0, 0]), rtol=0.03)


def test_near_the_period_doubling_no_wrong_figure_is_given() -> None:
    """At 5.31 N, next to B1 at 5.349 N, a kick of 1e-3 spreads the impacts half as far as linear theory has it."""
    groups, (motion,), _, _ = case(5.31)
    refused = jitter(groups, motion, 1e-3)
    assert isinstance(refused, NoJitter)
    assert refused.reason is Unsettled.TOO_LARGE
    assert 0.1 < refused.valid_up_to < 0.5
    allowed = jitter(groups, motion, 0.99e-3 * refused.valid_up_to)
    assert isinstance(allowed, Jitter)
    assert allowed.error == pytest.approx(TOLERANCE, rel=0.1)
    assert allowed.valid_up_to == pytest.approx(1, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "kick", "wait"), [(5.2, 7e-4, 100), (5.0, 1.9e-3, 50), (5.31, 2e-4, 300), (3.6, 1e-2, 20)]
)
def test_the_error_told_is_the_error_made(force: float, kick: float, wait: int) -> None:
    """Where linear theory is off by some per cent, it says by how much."""
    groups, (motion,), _, _ = case(force)
    found = jitter(groups, motion, kick)
    assert isinstance(found, Jitter)
    seen = monte_carlo(groups, motion, kick, 0.0, 6000, wait, 50)
    off = np.abs(np.sqrt(np.diagonal(seen / found.covariance, axis1=1, axis2=2)) - 1).max()
    assert 0.4 * found.error - 0.005 < off < 1.2 * found.error + 0.005


@pytest.mark.slow
def test_the_error_told_covers_that_of_random_devices() -> None:
    """Up to what the number of kicks leaves open, four standard errors; linear theory alone is off by up to 6 %."""
    rng, held, starts = np.random.default_rng(1), 0, 500
    while held < 8:
        angle = 0.0 if rng.random() < 0.3 else rng.uniform(1, 60)
        parts = DISTORTED if rng.random() < 0.25 else ()
        r, length, force = rng.uniform(0.15, 0.8), rng.uniform(0.2, 1.2), rng.uniform(2, 6)
        groups, stable, _, _ = of(Device(0.1245, r, 9.8, length, force, 2.0, angle, harmonics=parts))
        known = jitter(groups, stable[0], 1e-7) if stable else None
        if not isinstance(known, Jitter):
            continue
        kick = 1e-7 * known.valid_up_to * rng.uniform(0.6, 1.0)
        found = jitter(groups, stable[0], kick)
        lap = np.linalg.multi_dot([*flight_matrices(groups, stable[0])[::-1], np.eye(2)])
        wait = 20 + round(10 / -np.log(np.abs(np.linalg.eigvals(lap)).max()))
        if not isinstance(found, Jitter) or wait > 100:
            continue
        seen = kicked(groups, stable[0], kick, 0.0, starts, wait, 100)
        for linear, deviations in zip(found.covariance, seen, strict=True):
            squares = (deviations - deviations.mean(axis=1)[:, None]) ** 2
            of_starts = squares.reshape(2, 100, starts).mean(axis=1) / np.diag(linear)[:, None]
            spread, unsure = np.sqrt(of_starts.mean(axis=1)), of_starts.std(axis=1) / np.sqrt(starts) / 2
            assert (np.abs(spread - 1) < found.error + 4 * unsure).all(), (r, length, force, angle, kick)
        held += 1


@pytest.mark.slow
def test_the_refused_figure_would_be_twice_the_spread() -> None:
    groups, (motion,), _, _ = case(5.31)
    near = jitter(groups, motion, 1e-5)
    assert isinstance(near, Jitter)
    seen = monte_carlo(groups, motion, 1e-3, 0.0, 2000, 300, 50)
    assert np.sqrt(seen[0, 1, 1]) / (100 * near.velocity[0]) < 0.8


def test_spread_grows_in_proportion_and_is_the_same_in_all_units() -> None:
    groups, (motion,), _, unit = case(3.6)
    tiny, small, none = (jitter(groups, motion, kick) for kick in (1e-12, 1e-4, 0.0))
    assert isinstance(tiny, Jitter)
    assert isinstance(small, Jitter)
    assert isinstance(none, Jitter)
    np.testing.assert_allclose(tiny.phase_rad * 1e8, small.phase_rad, rtol=1e-12)
    assert tiny.valid_up_to == pytest.approx(small.valid_up_to * 1e8, rel=1e-2)
    assert not none.covariance.any()
    assert not none.covariance.any()
    heavy, (other,), _, heavy_unit = case(3.6, scale=7.3)
    scaled = jitter(heavy, other, 1e-3 / heavy_unit)
    own = jitter(groups, motion, 1e-3 / unit)
    assert isinstance(scaled, Jitter)
    assert isinstance(own, Jitter)
    np.testing.assert_allclose(scaled.phase_rad, own.phase_rad, rtol=1e-9)
    np.testing.assert_allclose(scaled.voltage_v(MEMBRANE, heavy_unit), own.voltage_v(MEMBRANE, unit), rtol=1e-9)


def test_both_sources_add() -> None:
    groups, (motion,), _, _ = case(3.6)
    kicks, scatter, both = (jitter(groups, motion, *each) for each in ((1e-3, 0.0), (0.0, 2e-3), (1e-3, 2e-3)))
    assert isinstance(kicks, Jitter)
    assert isinstance(scatter, Jitter)
    assert isinstance(both, Jitter)
    np.testing.assert_allclose(kicks.covariance + scatter.covariance, both.covariance, rtol=1e-12)
    np.testing.assert_allclose(kicks.mean + scatter.mean, both.mean, rtol=0.02, atol=1e-9)


def test_mean_and_spread_of_the_voltage_are_those_of_kicked_trajectories() -> None:
    """The mean is off that of the motion by 10 times what the number of trajectories leaves open."""
    groups, (motion,), _, unit = case(3.6)
    found = jitter(groups, motion, 1e-3, 9e-3)
    assert isinstance(found, Jitter)
    seen = kicked(groups, motion, 1e-3, 9e-3, 10_000, 15, 10)
    speeds = (unit * np.abs(v + off[1]) for v, off in zip(motion.velocity, seen, strict=True))
    volts = np.array([generated_voltage(speed, MEMBRANE) for speed in speeds])
    own = generated_voltage(unit * np.abs(motion.velocity), MEMBRANE)
    shift = found.mean_voltage_v(MEMBRANE, unit) - own
    assert (shift < -12).all()
    np.testing.assert_allclose(shift, volts.mean(axis=1) - own, atol=4)
    np.testing.assert_allclose(found.voltage_v(MEMBRANE, unit), volts.std(axis=1), rtol=0.03)


def test_no_restitution_beyond_what_is_possible() -> None:
    """At r = 0.02 a scatter of 0.01 has one impact in forty leave into the membrane."""
    groups, (motion, *_), _, _ = case(3.0, 0.5, 0.0, r=0.02)
    assert jitter(groups, motion, 0.0, 0.01) == NoJitter(Unsettled.IMPOSSIBLE, pytest.approx(2 / 3))
    allowed = jitter(groups, motion, 0.0, 0.006)
    assert isinstance(allowed, Jitter)
    assert allowed.valid_up_to == pytest.approx(10 / 9)


def test_voltage_spreads_by_its_slope() -> None:
    groups, (motion,), _, unit = case(3.6)
    found = jitter(groups, motion, 1e-4)
    assert isinstance(found, Jitter)
    speed, spread = unit * np.abs(motion.velocity), unit * found.velocity
    ends = (generated_voltage(speed + sign * spread / 10, MEMBRANE) for sign in (1, -1))
    np.testing.assert_allclose(found.voltage_v(MEMBRANE, unit), 5 * (next(ends) - next(ends)), rtol=1e-4)


def test_both_impacts_of_a_symmetric_motion_spread_alike() -> None:
    groups, (motion,), _, _ = case(3.0, 0.6, 0.0)
    found = jitter(groups, motion, 1e-4)
    assert isinstance(found, Jitter)
    assert found.phase_rad[0] == pytest.approx(found.phase_rad[1], rel=1e-9)
    assert found.velocity[0] == pytest.approx(found.velocity[1], rel=1e-9)
    assert found.covariance[0, 0, 1] == pytest.approx(-found.covariance[1, 0, 1], rel=1e-9)


def test_balls_that_do_not_bounce_have_no_room_for_kicks() -> None:
    """They leave a membrane without velocity, and half of the kicks would press them into it."""
    groups, stable, _, _ = case(3.0, 0.5, 0.0, r=0.0)
    assert jitter(groups, stable[0], 1e-4) == NoJitter(Unsettled.TOO_LARGE, 0.0)


def test_what_is_impossible_is_refused() -> None:
    groups, (motion,), unstable, _ = case(3.6)
    assert motion.durations.sum() == pytest.approx(2)
    assert jitter(groups, unstable[0], 1e-4) == NoJitter(Unsettled.UNSTABLE, 0.0)
    for kick, scatter in ((-1e-3, 0.0), (1e-3, -0.1), (float("nan"), 0.0), (float("inf"), 0.0)):
        with pytest.raises(ValueError, match="standard deviations"):
            jitter(groups, motion, kick, scatter)
