"""A ball with friction: its shocks, jitter and ramps, where friction vanishes and where it does not."""

from __future__ import annotations

from math import cos, floor, pi

import numpy as np
import pytest
from conftest import first
from devices import Case, of
from exact_friction import Reference
from mpmath import mp, mpf
from test_jitter import monte_carlo
from test_shock import lead_out, least

from vireport.design.point import motions_at
from vireport.findings.outcomes.deviations import flight_matrices, kick_effects
from vireport.findings.outcomes.impact_map import forwards
from vireport.findings.outcomes.jitter import Jitter, jitter
from vireport.findings.outcomes.moments import ramped
from vireport.findings.outcomes.shock import LeastShock
from vireport.physics.device import Device
from vireport.physics.groups import Groups
from vireport.physics.numbers import wrapped
from vireport.scenario.parameters import Parameter


def rubbed(
    friction: float, force: float = 4.0, length: float = 0.75, inclination: float = 45.0, r: float = 0.5
) -> Case:
    """A device of the paper's kind whose ball rubs."""
    return of(Device(0.1245, r, 9.8, length, force, 2.0, inclination, friction=friction))


def test_jacobians_are_differences_of_the_simulation_and_those_of_the_closed_form() -> None:
    device = Device(0.1245, 0.5, 9.8, 0.75, 4.0, 2.0, 45.0, friction=0.1)
    found, _, _ = motions_at(device, Parameter.LENGTH)
    (row,) = np.flatnonzero(found.stable_mask)
    groups, motion = device.groups(Parameter.LENGTH, 0.75).as_floats(), found.motion(int(row), 1)
    matrices, effects, step = flight_matrices(groups, motion), kick_effects(groups, motion), 1e-6
    lap = matrices[1] @ matrices[0]
    assert np.trace(lap) == pytest.approx(found.trace[row], rel=1e-10)
    assert np.linalg.det(lap) == pytest.approx(0.5**4, rel=1e-10)
    for i in range(2):
        here = motion.time[i], -0.5 * motion.velocity[i]
        moved = np.array([(step, 0), (-step, 0), (0, step), (0, -step)]) + here
        ends = forwards(groups, motion.word.walls[i], *moved.T)
        slopes = np.array([np.array(each)[::2] - np.array(each)[1::2] for each in ends[1:]]) / (2 * step)
        np.testing.assert_allclose(slopes[:, 0], matrices[i][:, 0], rtol=1e-7)
        np.testing.assert_allclose(slopes[:, 1], effects[i], rtol=1e-7)


@pytest.mark.slow
def test_friction_that_vanishes_changes_nothing() -> None:
    plain, same = rubbed(0.0), rubbed(1e-12)
    assert least(same).jump == pytest.approx(least(plain).jump, abs=1e-11)
    spreads = [jitter(each.groups, each.stable[0], 1e-3, 2e-3) for each in (plain, same)]
    assert all(isinstance(spread, Jitter) for spread in spreads)
    np.testing.assert_allclose(spreads[1].covariance, spreads[0].covariance, rtol=1e-9)
    assert spreads[1].error == pytest.approx(spreads[0].error, rel=1e-6)
    for phase, periods in ((0.3, 3.0), (2.0, 5.0)):
        ends = [ramped(each.groups, phase, periods) for each in (plain, same)]
        np.testing.assert_allclose(*ends, atol=1e-10)


@pytest.mark.parametrize(
    "over",
    first(
        1,
        [
            {},
            {"force": 4.9374, "length": 0.6488, "inclination": 0.0, "r": 0.7878},
            {"force": 5.3472, "length": 1.3455, "inclination": 62.8729, "r": 0.2176},
            {"force": 4.7361, "length": 1.2562, "inclination": 53.3102, "r": 0.4105},
            {"force": 3.0627, "length": 1.7751, "inclination": 39.4464, "r": 0.6275},
        ],
    ),
)
def test_two_ways_give_one_least_shock(over: dict[str, float]) -> None:
    """By search, and on the stable manifold of the unstable motion; none of 10,000 smaller ones leads out."""
    device = rubbed(0.02, **over)
    found = least(device)
    assert found.jump is not None
    assert found.companion in device.unstable
    assert found.by_search == pytest.approx(found.jump, rel=1e-9)
    assert lead_out(device, found, 5000, found.jump * (1 - 1e-9)) == 0
    assert lead_out(device, found, 5000, found.jump * 1.5) > 0


def test_friction_moves_the_least_shock() -> None:
    """At 4 N it is 0.1600 without friction: what holds the ball back makes the basin another."""
    assert least(rubbed(0.02)).jump == pytest.approx(0.1593538865891, abs=1e-11)


def test_spread_is_that_of_kicked_trajectories() -> None:
    device = rubbed(0.1)
    groups, motion = device.groups, device.stable[0]
    found = jitter(groups, motion, 1e-3, 2e-3)
    assert isinstance(found, Jitter)
    assert found.error < 0.01
    seen = monte_carlo(groups, motion, 1e-3, 2e-3, 4000, 30, 10)
    np.testing.assert_allclose(seen / found.covariance, 1, atol=0.08)


def stepped(groups: Groups, phase: float, periods: float, steps: int) -> tuple[float, float]:
    """Position and velocity at the end of a ramp in short steps, by the equation of motion alone."""
    d, gbar, r, f = groups.d, groups.gbar, groups.restitution, groups.friction
    elapsed, now, z, v = 0.0, phase / pi, groups.d / 2, 0.0
    while elapsed < 2 * periods:
        zero = floor(now - 0.5) + 1.5
        amplitude, h = min((elapsed + (zero - now) / 2) / (2 * periods), 1.0), (zero - now) / steps
        for k in range(steps):
            pull = gbar + amplitude * cos(pi * (now + (k + 0.5) * h))
            if (z >= d / 2 and v == 0 and pull > -f) or (v == 0 and abs(pull) <= f):
                continue
            before, v = v, v + h * (pull - f * np.sign(v or pull))
            v = 0.0 if before * v < 0 else v
            z += h * (before + v) / 2
            if abs(z) > d / 2 and z * v > 0:
                z, v = np.copysign(d / 2, z), -r * v
                v = 0.0 if abs(v) < 2 * h else v
        elapsed, now = elapsed + zero - now, zero
    return float(z), float(v)


@pytest.mark.parametrize(
    ("friction", "phase", "periods"), first(1, [(0.4, 2.0, 5.0), (0.05, 0.3, 3.0), (0.4, 0.3, 3.0)], unpacked=True)
)
def test_a_ramp_is_what_short_steps_come_to(friction: float, phase: float, periods: float) -> None:
    groups = Groups(0.5, 0.22, 0.5, (), friction)
    wall, position, velocity, _ = ramped(groups, phase, periods)
    position = wall * groups.d / 2 if wall else position
    assert (position, velocity) == pytest.approx(stepped(groups, phase, periods, 20_000), abs=3e-4)


def farthest_in_forty_digits(device: Case, found: LeastShock, size: float, impacts: int) -> float:
    """How far the last impacts after a shock are from the motion, by the model in 40 digits, in phase and velocity."""
    motion, wall = device.stable[0], int(device.stable[0].word.walls[found.impact])
    apart: list[float] = []
    with mp.workdps(40):
        reference = Reference(device.groups)
        x = mp.pi * mpf(float(motion.time[found.impact]))
        before = mpf(float(motion.velocity[found.impact])) - found.sign * mpf(size) / reference.r[0]
        for _ in range(impacts):
            wall, _, before, x, _ = reference.next_impact(wall, before, x)
            own = [
                max(abs(wrapped(float(x - mp.pi * mpf(float(time))))), abs(float(before) - velocity))
                for at, time, velocity in zip(motion.word.walls, motion.time, motion.velocity, strict=True)
                if at == wall
            ]
            apart.append(min(own))
    return max(apart[-4:])


HORIZONTAL = {"force": 4.9374, "length": 0.6488, "inclination": 0.0, "r": 0.7878}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "impacts", "over"),
    [
        (0.02, 70, {}),
        (0.02, 110, HORIZONTAL),
        (0.08, 110, HORIZONTAL),
        (0.2, 150, HORIZONTAL),
        (0.02, 250, {"force": 5.3472, "length": 1.3455, "inclination": 62.8729, "r": 0.2176}),
        (0.02, 70, {"force": 3.0627, "length": 1.7751, "inclination": 39.4464, "r": 0.6275}),
    ],
)
def test_in_forty_digits_a_shock_smaller_by_1e_9_returns_and_a_larger_one_does_not(
    friction: float, impacts: int, over: dict[str, float]
) -> None:
    """After as many impacts as the unstable motion on the edge needs to let both go."""
    device = rubbed(friction, **over)
    found = least(device)
    assert found.jump is not None
    assert found.delay == 0
    smaller, larger = (farthest_in_forty_digits(device, found, found.jump * (1 + e), impacts) for e in (-1e-9, 1e-9))
    assert smaller < 0.02
    assert larger > 0.1
