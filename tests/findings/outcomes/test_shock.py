"""The least shock: by the search and by the companion's manifold, and no smaller one leads out."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from conftest import first
from devices import DISTORTED, Case, case, of
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.findings.outcomes.manifold import on_shocks, stable_manifold
from vireport.findings.outcomes.returning import Elsewhere, core_of, endings
from vireport.findings.outcomes.shock import (
    SCAN,
    SEARCH,
    Effort,
    LeastShock,
    MotionsByStability,
    Shock,
    descended,
    least_shock,
    shocked,
)
from vireport.physics import flight
from vireport.physics.device import Device
from vireport.physics.groups import Groups, Restitutions
from vireport.simulation.attractors import Outcome, attractors, find_attractor
from vireport.simulation.events import check_start, start_of
from vireport.simulation.starts import random_starts

FRACTAL = 3.6
"""Force at which bands of jumps that lead out accumulate at the least one [N]; plain bisection gives 0.1708 there."""


def least(device: Case, **more: object) -> LeastShock:
    return least_shock(device.groups, device.stable[0], MotionsByStability(device.stable, device.unstable), **more)  # type: ignore[arg-type]


def lead_out(device: Case, found: LeastShock, count: int, largest: float) -> int:
    """How many random shocks at most as large lead out, found one by one from where the simulation ends."""
    random, groups, motion = np.random.default_rng(7), device.groups, device.stable[0]
    cores, times, out = [core_of(groups, motion)], np.append(motion.time, motion.time[0] + 2), 0
    for impact in range(2):
        delay = np.where(random.random(count) < 0.5, 0, (times[impact + 1] - times[impact]) * random.random(count))
        jump = largest * random.uniform(-1, 1, count)
        out += int((endings(groups, shocked(groups, motion, impact, delay, jump), cores) != 0).sum())
    return out


def test_a_shock_changes_the_velocity_alone() -> None:
    groups, (motion,), _, _ = case()
    delay = np.array([0.0, 0.0, 0.3, 1.0])
    plain, moved = (shocked(groups, motion, 0, delay, np.full(4, jump)) for jump in (0.0, 0.1))
    after = -groups.restitution * motion.velocity[0]
    np.testing.assert_allclose(plain[:2, 2], motion.velocity[0], rtol=1e-15)
    np.testing.assert_allclose(moved[:2, 2], -(after + 0.1) / groups.restitution, rtol=1e-14)
    np.testing.assert_allclose((moved - plain)[2:], [[0, 0, 0.1, 0]] * 2, atol=1e-15)
    start = pi * motion.time[0]
    sine, cosine = np.sin(start), np.cos(start)
    z = flight.displacement(0.3, after, sine, cosine, np.cos(start + 0.3 * pi), groups.gbar)
    assert plain[2, 1] == pytest.approx(groups.d / 2 + z)
    # driven into the membrane that it touches, the ball bounces at once
    into = shocked(groups, motion, 0, np.zeros(1), np.array([1.0]))[0]
    assert tuple(into[[0, 2]]) == (1.0, pytest.approx(after + 1.0))
    for row in (*plain, *moved, into):
        assert check_start(start_of(row), groups.d) == pytest.approx(tuple(row))


@pytest.mark.parametrize("force", first(1, [FRACTAL, 5.0]))
def test_starts_end_where_they_settle(force: float) -> None:
    """What is recognised after a few impacts is what it settles to."""
    device = case(force)
    starts = random_starts(device.groups.d, 2.0, 100, 4)[0]
    found = endings(device.groups, starts, [core_of(device.groups, motion) for motion in device.stable])
    reached = attractors(device.groups, [start_of(row) for row in starts])[0]
    for end, attractor in zip(found.tolist(), reached, strict=True):
        assert (end == 0) == (attractor.word == "BT" and attractor.period == 1)
        assert (end == Elsewhere.RESTS) == (attractor.outcome is Outcome.STICKING)
    interpreted = endings(device.groups, starts[:10], [core_of(device.groups, device.stable[0])], compiled=False)
    np.testing.assert_array_equal(interpreted, found[:10])


def test_the_least_of_folded_bands_is_found() -> None:
    """At 3.6 N bisection finds 0.1708; the bands of jumps that lead out begin below, on the companion's manifold."""
    device = case(FRACTAL)
    found = least(device)
    assert found.jump == pytest.approx(0.1693971999264, abs=1e-12)
    assert found.by_search == pytest.approx(found.jump, abs=1e-12)
    assert found.companion is device.unstable[0]
    assert (found.sign, found.impact, found.delay) == (1, 0, 0.0)
    assert found.leads_to is not None
    assert found.leads_to.name == "B~ every 3 forcing periods"
    assert lead_out(device, found, 5000, found.jump * (1 - 1e-9)) == 0
    assert lead_out(device, found, 5000, found.jump * 1.3) > 0


DEVICES = [
    {"force": 4.0},
    {"force": 4.9374, "length": 0.6488, "inclination": 0.0, "r": 0.7878},
    {"force": 5.3472, "length": 1.3455, "inclination": 62.8729, "r": 0.2176},
    {"force": 4.5815, "length": 0.572, "inclination": 0.0, "r": 0.5672},
    {"force": 6.3557, "length": 0.7681, "inclination": 0.0, "r": 0.5984},
    {"force": 4.7361, "length": 1.2562, "inclination": 53.3102, "r": 0.4105},
    {"force": 6.6592, "length": 0.7146, "inclination": 0.0, "r": 0.4208},
    {"force": 4.6846, "length": 1.7581, "inclination": 0.0, "r": 0.6183},
    {"force": 3.4007, "length": 1.8074, "inclination": 0.0, "r": 0.5528},
    {"force": 4.8052, "length": 0.6235, "inclination": 0.0, "r": 0.8023},
    {"force": 3.0627, "length": 1.7751, "inclination": 39.4464, "r": 0.6275},
    {"force": 2.9355, "length": 1.989, "inclination": 0.8406, "r": 0.6491},
    {"force": 6.4033, "length": 0.6934, "inclination": 3.8832, "r": 0.4145},
    {"force": 2.0155, "length": 1.0604, "inclination": 0.0, "r": 0.6084},
    {"force": 5.655, "length": 0.803, "inclination": 0.0, "r": 0.7219},
    {"force": 4.4618, "length": 1.276, "inclination": 27.7382, "r": 0.6408},
    {"force": 4.4641, "length": 1.0665, "inclination": 16.5657, "r": 0.2298},
    {"force": 3.3135, "length": 1.8823, "inclination": 0.0, "r": 0.5595},
    {"force": 4.626, "length": 0.5761, "inclination": 8.6664, "r": 0.6681},
    {"force": 2.9792, "length": 1.0466, "inclination": 0.0, "r": 0.3998},
    {"force": 3.149, "length": 1.1484, "inclination": 0.0, "r": 0.3856},
    {"force": 3.8668, "length": 1.4364, "inclination": 0.0, "r": 0.5306},
    {"force": 5.69, "length": 1.1703, "inclination": 75.6317, "r": 0.3178},
    {"force": 3.2765, "length": 1.1639, "inclination": 40.6089, "r": 0.3985},
    {"force": 5.5982, "length": 0.5243, "inclination": 21.659, "r": 0.5979},
    {"force": 5.8928, "length": 1.3716, "inclination": 69.7762, "r": 0.2508},
    {"force": 2.2873, "length": 1.5025, "inclination": 45.0536, "r": 0.6887},
    {"force": 3.05, "length": 1.35, "inclination": 53.63, "r": 0.51},
    {"force": 5.27, "length": 1.34, "inclination": 74.2, "r": 0.29},
    {"force": 2.77, "length": 0.55, "inclination": 29.98, "r": 0.4},
    {"force": 3.16, "length": 0.67, "inclination": 28.92, "r": 0.27},
    {"force": 4.62, "length": 1.11, "inclination": 55.43, "r": 0.22},
]


@pytest.mark.parametrize("over", first(1, DEVICES), ids=lambda over: "-".join(map(str, over.values())))
def test_two_ways_give_one_least_shock(over: dict[str, float]) -> None:
    device = case(**over)
    found = least(device)
    assert found.jump is not None
    assert found.companion in device.unstable
    assert found.by_search == pytest.approx(found.jump, rel=1e-9)
    assert lead_out(device, found, 10_000, found.jump * (1 - 1e-9)) == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "over", [{"force": 3.9}, DEVICES[1], {"force": 3.2765, "length": 1.1639, "inclination": 40.6, "r": 0.3985}]
)
def test_of_a_force_with_harmonics_two_ways_give_one_least_shock(over: dict[str, float]) -> None:
    device = case(**over, harmonics=DISTORTED)
    found = least(device)
    assert found.jump is not None
    assert found.companion in device.unstable
    assert found.by_search == pytest.approx(found.jump, rel=1e-9)
    assert lead_out(device, found, 10_000, found.jump * (1 - 1e-9)) == 0
    assert lead_out(device, found, 10_000, 1.5 * found.jump) > 0


def bisected(device: Case, found: LeastShock, high: float) -> float | None:
    """An edge between no jump and one that leads out, at the moment of the least shock; None if that one returns."""
    groups, motion, low = device.groups, device.stable[0], 0.0
    cores, delay = [core_of(groups, motion)], np.array([found.delay])

    def leads_out(jump: float) -> bool:
        start = shocked(groups, motion, found.impact, delay, np.array([found.sign * jump]))
        return bool(endings(groups, start, cores)[0] != 0)

    if not leads_out(high):
        return None
    while high - low > 1e-10:
        middle = (low + high) / 2
        low, high = (low, middle) if leads_out(middle) else (middle, high)
    return high


@pytest.mark.slow
@pytest.mark.parametrize("force", [FRACTAL, 4.0, 4.1])
def test_where_bands_are_folded_the_smaller_edge_is_found_and_of_1e5_smaller_jumps_none_leads_out(force: float) -> None:
    """Bisection between no jump and one that leads out gives another edge there, farther out by a half and more."""
    device = case(force)
    found = least(device)
    assert found.jump is not None
    edges = [bisected(device, found, share * found.jump) for share in np.linspace(1.5, 4, 11)]
    told = [edge for edge in edges if edge is not None]
    assert min(told) > found.jump * (1 - 1e-9)
    assert max(told) > 1.5 * found.jump
    assert found.by_search == pytest.approx(found.jump, rel=1e-9)  # which leads out, as the search has seen
    assert lead_out(device, found, 50_000, found.jump * (1 - 1e-9)) == 0


@pytest.mark.parametrize(
    "over", first(1, [{"force": force} for force in (3.6, 3.95, 4.0, 4.1)] + DEVICES[2:3] + DEVICES[16:17])
)
def test_no_fold_of_the_manifold_is_nearer_than_the_least_shock(over: dict[str, float]) -> None:
    """Bands of jumps that lead out, however thin, have their edges on the stable manifold: grown far back, its folds
    come as near as the least shock, within their points' spacing, and nowhere nearer."""
    device = case(**over)
    found, motion = least(device), device.stable[0]
    assert found.jump is not None
    fastest = float(np.abs(motion.velocity).max()) + found.jump
    pieces = [piece for each in device.unstable for piece in stable_manifold(device.groups, each, fastest)]
    lines = [line for piece in pieces for line in on_shocks(device.groups, motion, piece)]
    assert len(lines) > 10
    nearest = min(float(np.abs(line.jump).min()) for line in lines)
    assert found.jump * (1 - 1e-9) <= nearest < 1.05 * found.jump


def test_both_directions_of_a_horizontal_device_are_alike() -> None:
    """The mirror image of a symmetric motion is itself, half a period later."""
    device = case(2.9792, 1.0466, 0.0, 0.3998)
    motion = device.stable[0]
    found, mirrored = (
        least_shock(device.groups, each, MotionsByStability((), device.unstable))
        for each in (motion, motion.mirrored())
    )
    assert found.jump == pytest.approx(mirrored.jump, rel=1e-9)
    assert found.sign * motion.word.walls[found.impact] == mirrored.sign * motion.mirrored().word.walls[mirrored.impact]


def test_it_is_the_same_in_all_units() -> None:
    small, large = case(4.0), case(4.0, scale=20.0)
    one, other = least(small), least(large)
    assert one.jump is not None
    assert other.jump == pytest.approx(one.jump, rel=1e-9)
    assert small.unit == pytest.approx(large.unit)


def test_where_everything_returns_nothing_is_found() -> None:
    found = least(case(3.0, 0.6934))
    assert found.jump is found.leads_to is found.companion is None
    assert found.searched_to == pytest.approx(1.00400474, abs=1e-4)
    assert found.tried > 5000


def test_a_ball_that_floats_was_not_knocked_out() -> None:
    """Of a horizontal device a jump of (1 + r)/2 of the impact velocity leaves no drift; all beside it return."""
    device = case(5.29, 0.81, 0.0, 0.8)
    motion = device.stable[0]
    still = np.array([-0.9 * motion.velocity[1]])
    start = shocked(device.groups, motion, 0, np.array([0.5]), still)
    cores = [core_of(device.groups, motion)]
    assert endings(device.groups, start, cores)[0] == Elsewhere.DRIFTS
    assert endings(device.groups, shocked(device.groups, motion, 0, np.array([0.5]), still * (1 + 1e-9)), cores)[0] == 0
    assert least(device).jump is None


@pytest.mark.slow
def test_a_motion_with_more_impacts_has_its_least_shock() -> None:
    """The 2:1 motion beside a 1:1 motion, with the unstable 1:1 motion between them, or without anything to go by."""
    device = case(5.5982, 0.5243, 21.659, 0.5979)
    groups = device.groups
    reached = attractors(groups, [start_of(row) for row in random_starts(groups.d, 2.0, 30, 1)[0]])[0]
    cycle = next(each.cycle for each in reached if each.word == "BBT")
    assert cycle is not None
    motion = cycle.motion(groups.d)
    found = least_shock(groups, motion, MotionsByStability(device.stable, device.unstable))
    alone = least_shock(groups, motion)
    assert found.jump is not None
    assert found.leads_to is not None
    assert found.leads_to.word == "BT"
    assert alone.companion is None
    assert alone.jump == pytest.approx(found.jump, rel=1e-9)


@pytest.mark.slow
def test_an_edge_on_no_companion_is_found_by_the_search() -> None:
    """Between 1:1 motion and one of four periods."""
    found = least(case(5.06, 1.51, 53.61, 0.79))
    assert found.companion is None
    assert found.jump == found.by_search == pytest.approx(0.22614874, rel=1e-6)
    assert found.leads_to is not None
    assert found.leads_to.name == "BTBTBTBT every 4 forcing periods"


@pytest.mark.slow
def test_shocks_that_linger_by_an_unstable_motion_return() -> None:
    """At 3.6 N with unlike membranes a doubled motion is stable, and the 1:1 motion beside it hardly unstable.

    Those that come near the latter take hundreds of periods: they were taken for some that lead out, and the way down
    from these had no end.
    """
    groups = Groups(0.415, 0.23965027325714075, Restitutions(0.475, 0.525))
    unlike = of(Device(0.1245, Restitutions(0.475, 0.525), 9.8, 0.75, 3.6, 2.0, 45.0))
    end = find_attractor(groups, start_of(np.array([1.0, 0.0, 0.96, 0.586])), 4000, compiled=True)
    assert (end.word, end.period) == ("BTBT", 2)
    motion = end.cycle.motion(groups.d)
    found = least_shock(groups, motion, MotionsByStability((), unlike.unstable), effort=SCAN)
    assert found.jump is None
    assert found.patience > core_of(groups, motion).patience


def test_next_to_a_critical_point_nothing_is_claimed() -> None:
    """At 5.348 N, B1 being at 5.34924 N, disturbances fade by 0.05 % in a period."""
    with pytest.raises(NumericalError, match=r"only 0.045 % in a period"):
        least(case(5.348))


def test_what_cannot_be_asked_is_refused() -> None:
    device = case(4.0)
    with pytest.raises(ValueError, match="stable"):
        least_shock(device.groups, device.unstable[0])
    for size in (0.0, -1.0, float("inf"), float("nan")):
        with pytest.raises(ValueError, match="positive"):
            least_shock(device.groups, device.stable[0], searched_to=size)
    flat = case(3.0, 0.5, 0.0, 0.0)
    with pytest.raises(ValueError, match="bounce"):
        least_shock(Groups(*flat.groups), flat.stable[0])


Floats = NDArray[np.float64]


class Bands:
    """Shocks that lead out: above an edge that varies with the delay, and in bands below it; notes what was tried."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.edge, self.tilt = rng.uniform(0.2, 0.6), rng.uniform(-0.3, 0.3)
        self.bands = rng.uniform(0.05, 0.9, (4, 2)) * (1, 0.03)
        self.sign, self.tried, self.out = float(rng.choice([-1.0, 1.0])), list[float](), list[float]()

    def __call__(self, impact: int, delay: Floats, jump: Floats) -> NDArray[np.bool_]:
        size = self.sign * jump
        assert impact == 1
        assert (size >= 0).all()
        assert ((delay >= 0) & (delay < 0.8)).all()
        edge = self.edge + self.tilt * delay
        out = size >= edge
        for low, width in self.bands:
            out |= (size >= low * edge) & (size <= (low + width) * edge)
        self.tried += size.tolist()
        self.out += size[out].tolist()
        return np.asarray(out)


@pytest.mark.parametrize("effort", [SCAN, SEARCH])
@pytest.mark.parametrize("delay", [0.0, 0.3])
def test_the_shock_leads_out_and_no_smaller_one_that_was_tried_does(effort: Effort, delay: float) -> None:
    for seed in range(40):
        bands = Bands(seed)
        first = Shock(1, delay, bands.sign * 0.95)
        least = descended(bands, first, 0.2, 0.8, effort)
        smallest = min([*bands.out, 0.95])
        assert abs(least.jump) == pytest.approx(smallest, rel=1e-12)
        assert (least.impact, np.sign(least.jump)) == (1, bands.sign)
        again = Bands(seed)
        assert again(1, np.array([least.delay]), np.array([least.jump])).all()
        assert (delay == 0) <= (least.delay == 0)  # just after an impact it stays there
        assert len(bands.tried) < 500 * effort.zoom


@pytest.mark.parametrize("delay", [0.0, 0.3])
def test_an_edge_far_below_the_first_shock_is_found_to_its_last_digit(delay: float) -> None:
    """All of a step lead out at first, so that steps grow again."""

    def leads_out(impact: int, at: Floats, jump: Floats) -> NDArray[np.bool_]:
        return np.asarray(jump >= 0.0123)

    least = descended(leads_out, Shock(0, delay, 0.9), 1e-3, 0.8, SCAN)
    assert 0.0123 <= least.jump < 0.0123 * (1 + 1e-6)
