"""Lifetimes under kicks against a loop that shares nothing with them, and what is claimed of their errors."""

from __future__ import annotations

from math import exp, inf, log, sqrt

import numpy as np
import pytest
from msgspec.structs import replace

from tests.findings.escape.own_loop import times_until_escape
from tests.findings.outcomes.devices import Case, case, of
from vireport.findings.escape import escape
from vireport.findings.escape.escape import SmallKickLaw, Unlimited, escape_from
from vireport.findings.escape.least_kicks import edge_rows, impact_rows, kicked, least_kicks, leaving
from vireport.findings.escape.lifetimes import BOUNDARY, RETURNS, Lifetime, ReturnGrid, lifetime
from vireport.findings.outcomes.returning import Core, Recogniser, core_of, patient
from vireport.findings.outcomes.shock import MotionsByStability
from vireport.physics.device import Device
from vireport.physics.groups import Restitutions, by_wall

pytest.importorskip("numba")


def cores_of(device: Case, which: int = 0) -> list[Core]:
    motions = [device.stable[which], *(device.stable[:which] + device.stable[which + 1 :])]
    return patient(device.groups, [core_of(device.groups, motion, True) for motion in motions], device.unstable)


def grid_of(device: Case, ratio: float = 2.0) -> tuple[ReturnGrid, float]:
    """A grid, and Q."""
    cores = cores_of(device)
    way = least_kicks(device.groups, cores)
    assert way is not None
    exponent = way.path.exponent
    return ReturnGrid(device.groups, cores, sqrt(exponent / ratio)), exponent


UNLIKE = Device(0.1245, Restitutions(0.45, 0.5), 9.8, 0.75, 2.2, 2.0, 45.0)
DEVICES = (
    *(case(force=force) for force in (2.0, 2.2, 2.3, 3.6, 4.0)),
    *(case(force=3.0, length=length) for length in (1.2, 1.3)),
    *(case(force=3.0, length=length, inclination=0.0) for length in (0.3, 0.35, 1.225)),
    case(force=3.0, length=1.3, inclination=20.0),
    of(UNLIKE),
)
RATIOS = (1.5, 2.0, 2.5)
"""Of Q and the variance of kicks: motions then last some ten to some hundred periods."""


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(DEVICES)))
def test_lifetimes_are_those_of_an_independent_loop(number: int) -> None:
    device = DEVICES[number]
    groups, motion = device.groups, device.stable[0]
    grid, exponent = grid_of(device, RATIOS[0])
    kick = sqrt(exponent / RATIOS[number % 3])
    ours = lifetime(grid, kick, number, 10**7, escapes=1500)
    walls = np.array(motion.word.walls)
    model = groups.d, groups.gbar, *by_wall(groups.restitution)
    times = times_until_escape(
        300, kick, np.random.default_rng(100 + number), *model, walls, motion.velocity, motion.phase
    )
    error = sqrt(ours.error**2 + times.var() / len(times) / times.mean() ** 2)
    assert abs(log(times.mean() / ours.mean)) < 3.5 * error
    assert grid.wrong <= grid.checked / 1000


@pytest.mark.slow
def test_intervals_cover_the_mean() -> None:
    grid, exponent = grid_of(case(force=3.0, length=0.35, inclination=0.0))
    kick = sqrt(exponent / 2)
    truth = lifetime(grid, kick, 0, 10**8, escapes=10**6).mean  # of all balls
    covered = 0
    for seed in range(1, 201):
        low, high = lifetime(grid, kick, seed, 10**7, escapes=30, balls=60).interval
        covered += low <= truth <= high
    assert 180 <= covered <= 199  # of 200, 190 with a standard deviation of 3.1


@pytest.mark.slow
def test_the_logarithm_grows_by_the_least_sum_of_squares() -> None:
    grid, exponent = grid_of(case(force=3.0, length=1.225, inclination=0.0))
    ratios = np.array([3.0, 4.0, 5.0, 6.0])
    logs = [log(lifetime(grid, sqrt(exponent / ratio), int(ratio), 10**8, escapes=2500).mean) for ratio in ratios]
    slope, _ = np.polyfit(ratios, logs, 1)
    assert slope == pytest.approx(1.0, abs=0.03)


def test_a_cell_of_return_returns() -> None:
    grid, _ = grid_of(case())
    motion = grid.motion
    random = np.random.default_rng(5)
    off = random.standard_normal((2, 2000)) * grid.half[0][:, None] / 3
    velocity = np.maximum(motion.velocity[0] + off[1], 1e-3)
    rows = impact_rows(motion.word.walls[0], motion.phase[0] + np.pi * off[0], velocity)
    out = grid.leaving(rows)
    assert 20 < out.sum() < 1000
    assert (out == leaving(grid.groups, rows, grid.cores)).all()
    assert 0 < grid.followed < len(rows)
    assert grid.checked == -(-(len(rows) - grid.followed) // 64)
    # A cell of return that a check finds wrong is none any more.
    grid.cell[0] = RETURNS
    checked = grid.checked
    again = grid.leaving(rows[out])
    assert grid.wrong == grid.checked - checked == (grid.cell[0] == BOUNDARY).sum() == 1
    assert again.sum() < out.sum()


def test_kicks_change_the_velocity_after_an_impact_and_may_drive_the_ball_back() -> None:
    groups = of(UNLIKE).groups
    walls, before = np.array([1.0, -1.0, 1.0, -1.0]), np.array([0.8, -0.6, 0.8, -0.6])
    kicks = np.array([0.1, 0.1, 0.5, -0.5])
    # After the impact -0.36, 0.3; with the kicks -0.26, 0.4, and 0.14, -0.2 towards the membrane.
    expected = [0.26 / 0.45, -0.4 / 0.5, 0.14, -0.2]
    assert kicked(groups, walls, before, kicks) == pytest.approx(expected)


def of_times(escaped: list[float], staying: list[float], transient: float = 2.0) -> Lifetime:
    laps = np.floor(np.array(escaped) - transient).astype(int)
    whole = int(min(staying, default=max(escaped, default=0.0) + 1) - transient)
    return Lifetime(0.1, transient, np.array(escaped), laps, np.array(staying), whole, np.zeros((0, 4)), 0)


def test_a_mean_counts_the_time_of_those_that_stay() -> None:
    found = of_times([1.0, 4.0, 6.0], [8.0, 8.0])
    # Up to 2 periods 1.8 on average; four of five pass, and spend 18 periods for two escapes.
    assert found.mean == pytest.approx(1.8 + 0.8 * 9.0)
    assert found.late == 2
    part = np.array([1.0, 11.0, 11.0, 11.0, 11.0])
    assert found.error == pytest.approx(sqrt(part.var() / 5 + (0.8 * 9) ** 2 / 2) / 9.0)
    assert of_times([1.0, 3.0, 5.0], []).mean == pytest.approx(3.0)


def test_without_an_escape_there_is_a_lower_end() -> None:
    found = of_times([], [100.0, 100.0])
    assert found.mean == np.inf
    assert found.interval == (pytest.approx(200 / -log(0.025)), np.inf)


def test_times_that_are_not_exponential_are_noticed() -> None:
    random = np.random.default_rng(3)
    steady = 2 + random.exponential(30, 2000)
    assert of_times(sorted(steady), []).p_value > 0.01
    ageing = 2 + 30 * random.weibull(1.3, 2000)
    assert of_times(sorted(ageing), []).p_value < 1e-6
    first = np.sort(steady)[:600]
    assert of_times(list(first), [float(first[-1])] * 1400).p_value > 0.01
    assert of_times(sorted(steady)[:40], []).p_value is None


def test_the_same_seed_gives_the_same_times() -> None:
    grid, exponent = grid_of(case(force=3.0, length=0.35, inclination=0.0))
    first, second = (lifetime(grid, sqrt(exponent / 1.5), 7, 10**6, 20, 200) for _ in range(2))
    assert first.followed_laps >= 10  # whose escapes are compared, however soon enough balls have left
    assert (first.escaped == second.escaped).all()
    assert first.impacts == second.impacts
    other = lifetime(grid, sqrt(exponent / 1.5), 8, 10**6, 50, 200)
    assert other.escaped.tolist() != first.escaped.tolist()


def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the effort of a quick test."""
    monkeypatch.setattr(escape, "LEVEL_BUDGET", 600_000)
    monkeypatch.setattr(escape, "BUDGET", 400_000)


@pytest.mark.slow
def test_small_kicks_are_told_by_the_law_and_the_smallest_by_a_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    few(monkeypatch)
    device = case(force=3.0, length=1.225, inclination=0.0)
    motions = MotionsByStability(device.stable, device.unstable)

    def found(kick: float) -> escape.MotionEscape:
        return escape_from(device.groups, device.stable[0], motions, kick)

    large, small, tiny = found(0.12), found(0.03), found(1e-3)
    assert large.simulated is not None
    assert not large.extrapolated
    assert large.reason == ""
    assert 20 < large.periods < 50
    assert sum(share for _, share in large.ends) == pytest.approx(1)
    assert all(not name.startswith("the motion itself") for name, _ in large.ends)
    mirrored = case(force=3.0, length=0.35, inclination=0.0)
    of_both = MotionsByStability(mirrored.stable, mirrored.unstable)
    found_of_one = escape_from(mirrored.groups, mirrored.stable[0], of_both, 0.03)
    assert found_of_one.ends == (("another BT every forcing period", 1.0),)
    recognise = Recogniser(mirrored.groups, mirrored.stable)
    motion = mirrored.stable[0]
    itself = impact_rows(motion.word.walls[0], motion.phase[:1], motion.velocity[:1])
    assert escape._ends(recognise, itself) == (("the motion itself, later than was waited for", 1.0),)
    law = small.law
    assert small.extrapolated
    assert small.simulated is None
    assert small.periods == pytest.approx(exp(law.offset + law.exponent / 0.03**2))
    low, high = small.interval
    assert log(high / low) == pytest.approx(2 * 1.96 * law.error)
    assert tiny.periods is None
    assert tiny.reason == Unlimited.BEYOND_USE
    assert tiny.interval == (None, None)
    # The law is that of what was simulated.
    assert log(large.simulated.mean) == pytest.approx(law.log_periods(0.12), abs=2.5 * law.error)


@pytest.mark.slow
def test_where_nothing_leads_out_there_is_a_reason_and_a_lower_end(monkeypatch: pytest.MonkeyPatch) -> None:
    few(monkeypatch)
    device = case(force=3.0, length=0.7)
    found = escape_from(device.groups, device.stable[0], MotionsByStability(device.stable, device.unstable), 0.02)
    assert found.periods is None
    assert found.reason == Unlimited.NO_WAY_OUT
    assert found.interval[0] > 10_000
    assert found.interval[1] is None
    assert found.ends == ()
    assert found.way is None


@pytest.mark.slow
def test_of_no_bounce_and_near_a_critical_point_nothing_is_told() -> None:
    alive = case(force=3.0, length=0.9, inclination=30.0)
    dead = alive.groups._replace(restitution=0.0)
    found = escape_from(dead, alive.stable[0], MotionsByStability(alive.stable), 0.02)
    assert found.reason == Unlimited.NO_BOUNCE
    critical = case(force=3.0, length=0.63)
    found = escape_from(critical.groups, critical.stable[0], MotionsByStability(critical.stable), 0.02)
    assert "near a point where it becomes unstable" in found.reason


def test_the_law_is_a_line_in_the_inverse_variance() -> None:
    def level(kick: float) -> Lifetime:
        mean = exp(2.0 + 0.004 / kick**2 + 30 * kick**2)
        return of_times([2 + mean] * 400, [])

    kicks = (0.04, 0.035, 0.03, 0.025)
    levels = [replace(level(kick), kick=kick) for kick in kicks]
    law = escape._law(0.004, levels)
    assert law.offset == pytest.approx(2.0, abs=0.05)
    # The error of four means of 400 times each, and of what is left of the second term.
    assert law.error == pytest.approx(0.085, rel=0.1)
    assert escape._law(0.004, levels[:2]) is None
    assert SmallKickLaw(0.004, 2.0, 0.1).log_periods(0.02) == pytest.approx(12.0)


def test_a_motion_that_is_reached_late_is_not_learnt_again() -> None:
    device = case(length=0.5, inclination=0.0, r=0.9)
    recognise = Recogniser(device.groups, device.stable)
    recognise(edge_rows(device.groups, device.stable[0]))
    assert len(recognise.cores) == 2


@pytest.mark.parametrize("escaped", [[], [5.0]])
def test_balls_that_were_followed_in_the_transient_alone_give_a_lower_end_only(escaped: list[float]) -> None:
    """They have not left: the time up to which they were followed is no mean."""
    early = Lifetime(
        0.1, 50.0, np.array(escaped), np.full(len(escaped), -1), np.full(10, 20.0), 0, np.zeros((0, 4)), 400
    )
    low, high = early.interval
    assert (early.mean, high) == (inf, inf)
    followed = 200 + sum(escaped)
    # As few events as were seen, of a Poisson process with that mean time between them.
    assert sum(exp(-followed / low) * (followed / low) ** k for k in range(len(escaped) + 1)) == pytest.approx(0.025)
