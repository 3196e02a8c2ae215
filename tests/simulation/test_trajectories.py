"""Trajectories: the published motions, typed ends, chatter and rides, and two integrators beside them."""

from __future__ import annotations

from itertools import pairwise
from math import acos, cos, pi, radians, sin

import numpy as np
import pytest
from conftest import first
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

from vireport.physics.groups import Groups
from vireport.simulation.attractors import Outcome, find_attractor
from vireport.simulation.cycles import jacobians, product
from vireport.simulation.events import BOTTOM, TOP, Impact, InFlight, check_model, check_start, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, VELOCITY, WALL
from vireport.simulation.trajectories import path


def simulate(d: float, g: float, r: float, start: Impact | InFlight, impacts: int) -> np.ndarray:
    """Rows of the start and of the impacts that follow."""
    return follow_one(check_model(Groups(d, g, r))[0], check_start(start, d), impacts)[0]


def sticking(rows: np.ndarray) -> np.ndarray:
    """Which rows are impacts after which the ball stays."""
    return np.flatnonzero(rows[:, SETTLING] + rows[:, RIDING] > 0)


def gbar(force: float) -> float:
    """Gravity of the paper's device at 45 degrees."""
    return 0.1245 * 9.8 * sin(radians(45)) / force


# d, gbar, velocity and phase at the bottom impact, flight times: solved in 40 digits, independently.
PUBLISHED = [
    (0.3688, 0.0, 0.71526064, 0.59651698, (1.0, 1.0)),
    (0.4604, gbar(3.0), 1.00400474, 0.56672469, (2 * 0.58606105, 2 * 0.41393895)),
    (0.2814, gbar(5.31), 0.72606371, 0.21023364, (2 * 0.65061040, 2 * 0.34938960)),
    (0.2545, gbar(5.87), 0.71495891, 0.23548277, (1.2131, 0.7495, 1.4245, 0.6129)),
]


@pytest.mark.parametrize(("d", "g", "velocity", "phase", "flights"), PUBLISHED)
def test_published_orbits_are_arrived_at(d, g, velocity, phase, flights) -> None:
    attractor = find_attractor(Groups(d, g, 0.5), Impact(BOTTOM, velocity * 1.01, phase * 0.98))
    assert attractor.outcome is Outcome.PERIODIC
    cycle = attractor.cycle
    assert cycle is not None
    assert cycle.word == "BT" * (len(flights) // 2)
    assert cycle.period == round(sum(flights) / 2)
    assert cycle.residual < 1e-14
    assert cycle.velocity[0] == pytest.approx(velocity, abs=0.6e-8)
    assert cycle.phase[0] == pytest.approx(phase, abs=0.6e-8)
    digits = 6e-5 if len(flights) == 4 else 2e-8
    assert np.roll(cycle.flight, -1) == pytest.approx(flights, abs=digits)
    assert cycle.multipliers[0] * cycle.multipliers[1] == pytest.approx(0.5 ** (2 * len(flights)), rel=1e-12)


def test_at_rest_at_last_when_gravity_wins() -> None:
    start = Impact(TOP, -0.3, 1.0)
    rows = simulate(0.5, 1.2, 0.6, start, 10_000)
    assert find_attractor(Groups(0.5, 1.2, 0.6), start).outcome is Outcome.REST
    assert len(rows) < 100
    assert sticking(rows).tolist() == [len(rows) - 1]
    assert rows[-1, [WALL, RIDING]].tolist() == [BOTTOM, np.inf]
    assert 0 < rows[-1, SETTLING] < 1e-3


@pytest.mark.parametrize("g", [1.0, 1.5])
def test_put_down_at_rest(g: float) -> None:
    rows = simulate(0.5, g, 0.5, Impact(BOTTOM, 0.0, 2.0), 10)
    assert find_attractor(Groups(0.5, g, 0.5), Impact(BOTTOM, 0.0, 2.0)).outcome is Outcome.REST
    assert sticking(rows).tolist() == [0]
    assert len(rows) == 1
    assert all(len(part) == 0 for part in path(check_model(Groups(0.5, g, 0.5))[0], rows))


@pytest.mark.parametrize(("wall", "phase", "release"), [(BOTTOM, 6.0, 1.0), (TOP, 3.0, -1.0)])
def test_a_resting_ball_is_released_where_the_membrane_would_have_to_pull(wall, phase, release) -> None:
    g = 0.4
    held, hit = simulate(0.5, g, 0.5, Impact(wall, 0.0, phase), 1)
    left = (release * acos(-g) - phase) % (2 * pi)
    assert held[SETTLING] == 0.0
    assert held[RIDING] == pytest.approx(left / pi, abs=1e-15)
    # The flight that follows starts at rest, with the acceleration just passing zero.
    phase, s = release * acos(-g), release * sin(acos(-g))
    t, target = hit[FLIGHT], 0.0 if hit[WALL] == wall else -wall * 0.5
    z = g * t * t / 2 - (cos(phase + pi * t) - cos(phase)) / pi**2 - s * t / pi
    assert z == pytest.approx(target, abs=2e-15)
    assert (hit[PHASE] - phase - pi * t + pi) % (2 * pi) - pi == pytest.approx(0, abs=1e-14)


def test_not_pressed_means_not_stuck() -> None:
    """At phase pi and gbar = 0 the bottom leaves the ball, the top presses it."""
    assert sticking(simulate(0.5, 0.0, 0.5, Impact(BOTTOM, 0.0, pi), 3)).size == 0
    assert sticking(simulate(0.5, 0.0, 0.5, Impact(TOP, 0.0, pi), 3))[0] == 0


def test_a_soft_ball_sticks_wherever_it_is_pressed() -> None:
    """r = 0: every impact while pressed is the last one; the ball rides and leaves at the known phase."""
    rows = simulate(0.3, 0.5, 0.0, InFlight(0.0, 0.0, 0.0), 200)
    for row in rows[sticking(rows)]:
        assert row[SETTLING] == 0.0
        end = row[PHASE] + pi * row[RIDING]
        assert 0.5 + cos(end) == pytest.approx(0, abs=1e-14)
        pressed = row[WALL] * (0.5 + np.cos(row[PHASE] + pi * row[RIDING] * np.linspace(0, 0.999, 50)))
        assert (pressed > 0).all()


def test_chatter_repeats_itself_exactly_once_released() -> None:
    rows = simulate(0.06, gbar(3.0), 0.5, Impact(BOTTOM, 0.4, 1.0), 500)
    attractor = find_attractor(Groups(0.06, gbar(3.0), 0.5), Impact(BOTTOM, 0.4, 1.0))
    assert attractor.outcome is Outcome.STICKING
    cycle = attractor.cycle
    assert cycle is not None
    assert cycle.sticks
    assert (cycle.word, cycle.period) == ("B~T", 1)
    assert cycle.lyapunov == -np.inf
    starts = sticking(rows)
    span = cycle.flight.sum() + rows[starts[-2], [SETTLING, RIDING]].sum()
    assert span == pytest.approx(2 * cycle.period, abs=1e-14)
    assert len(starts) > 3
    laps = [rows[a + 1 : b + 1, VELOCITY] for a, b in pairwise(starts[1:])]
    assert all(np.array_equal(lap, laps[0]) for lap in laps)


def test_no_drift_no_impact() -> None:
    still = InFlight(0.0, 0.0, 0.0)
    assert len(simulate(3.0, 0.0, 0.5, still, 10)) == 1
    assert find_attractor(Groups(3.0, 0.0, 0.5), still).outcome is Outcome.FREE


@pytest.mark.parametrize("friction", [None, 0.1])
def test_times_and_path_agree_with_the_impacts(friction: float | None) -> None:
    model = check_model(Groups(0.06, gbar(3.0), 0.5, (), friction))[0]
    rows, _ = follow_one(model, check_start(Impact(BOTTOM, 0.4, 1.0), 0.06), 60, compiled=False)
    impacts, held = rows[1:], rows[:-1, SETTLING] + rows[:-1, RIDING]
    assert held.any()
    time, position, velocity = path(model, rows, 30)
    times = np.cumsum(held + impacts[:, FLIGHT])
    assert np.abs(position).max() <= 0.03 + 1e-15
    assert (np.diff(time) >= 0).all()
    ends = np.searchsorted(time, times - 1e-12)
    assert time[ends] == pytest.approx(times, abs=1e-13)
    assert position[ends] == pytest.approx(impacts[:, WALL] * 0.03, abs=1e-14)
    assert velocity[ends] == pytest.approx(impacts[:, VELOCITY], abs=1e-13)
    ahead = (impacts[:, PHASE] - 1.0 - pi * times + pi) % (2 * pi) - pi
    assert np.abs(ahead).max() < 1e-12


CHAOS = (0.2545, 0.3, 0.5)
STARTS = [(BOTTOM, 0.7, 0.2), (BOTTOM, 0.4, 5.5), (TOP, -0.5, 3.5)]


def ours(start, impacts: int):
    """Rows of impacts, and how much a difference at the start has grown at each of them."""
    model = check_model(Groups(*CHAOS))[0]
    rows, _ = follow_one(model, check_start(Impact(*start), CHAOS[0]), impacts)
    steps = jacobians(model, rows[:-1], rows[1:])
    growth = [np.exp(product(steps[:n])[1]) for n in range(1, len(steps) + 1)]
    return rows, np.maximum.accumulate(growth)


def integrated(start, impacts: int, rtol: float):
    """Same motion with an ODE solver: DOP853, terminal events, no use of the closed form."""
    d, g, r = CHAOS
    wall, speed, phase = start
    z, v, t, history = wall * d / 2, -r * speed, 0.0, []

    def rate(t, y):
        return [y[1], g + np.cos(pi * t + phase)]

    def bottom(t, y):
        return y[0] - d / 2

    def top(t, y):
        return y[0] + d / 2

    bottom.terminal = top.terminal = True
    bottom.direction, top.direction = 1, -1
    while len(history) < impacts:
        run = solve_ivp(
            rate,
            (t, t + 9),
            [z, v],
            "DOP853",
            rtol=rtol,
            atol=1e-3 * rtol,
            events=(bottom, top),
            max_step=0.02,
        )
        side = BOTTOM if len(run.t_events[0]) else TOP
        t, v = run.t[-1], -r * run.y[1, -1]
        z = side * d / 2
        history.append((side, t, run.y[1, -1]))
    return np.array(history)


@pytest.mark.parametrize("start", first(1, STARTS), ids=str)
def test_an_ode_solver_converges_to_the_same_motion(start) -> None:
    impacts = 16
    rows, growth = ours(start, impacts)
    times = np.cumsum(rows[1:, FLIGHT])
    errors = []
    for rtol in (1e-5, 1e-8, 1e-11):
        steps = integrated(start, impacts, rtol)
        assert np.array_equal(steps[:, 0], rows[1:, WALL])
        error = np.maximum(np.abs(steps[:, 1] - times), np.abs(steps[:, 2] - rows[1:, VELOCITY])) / growth
        errors.append(error.max())
    assert errors[0] > 20 * errors[1] > 400 * errors[2] or errors[2] < 1e-13
    assert errors[2] < 1e-10


def horner(series, h):
    """Taylor series, constant term first, at h."""
    value = mpf(0)
    for coefficient in reversed(series):
        value = value * h + coefficient
    return value


def taylor_flight(z, v, c, s, d, g, order=44):
    """Taylor integration of one flight in mpmath, the cosine integrated along with Z; wall, time, v, c, s."""
    total, step = mpf(0), mpf(1) / 8
    while True:
        zs, vs, cs, ss = [z], [v], [c], [s]
        for k in range(order):
            zs.append(vs[k] / (k + 1))
            vs.append((cs[k] + (g if k == 0 else 0)) / (k + 1))
            cs.append(-mp.pi * ss[k] / (k + 1))
            ss.append(mp.pi * cs[k] / (k + 1))
        grid = [step * i / 10 for i in range(1, 11)]
        hit = next((h for h in grid if abs(horner(zs, h)) > d / 2), None)
        if hit is None:
            z, v, c, s = (horner(q, step) for q in (zs, vs, cs, ss))
            total += step
            continue
        wall = 1 if horner(zs, hit) > 0 else -1
        for _ in range(9):
            hit -= (horner(zs, hit) - wall * d / 2) / horner(vs, hit)
        return wall, total + hit, *(horner(q, hit) for q in (vs, cs, ss))


@pytest.mark.slow
@pytest.mark.parametrize("start", STARTS, ids=str)
def test_a_taylor_integration_in_high_precision_agrees_until_chaos_forbids_it(start) -> None:
    """Rounding differs, so the difference grows as the Jacobians say and not faster, up to 1e-4."""
    rows, growth = ours(start, 120)
    impacts = int(np.searchsorted(growth, 1e-4 / 1e-16))
    assert impacts > 25
    with mp.workdps(45):
        d, g, r = (mpf(float(x)) for x in CHAOS)
        wall, v, phase = start
        v, c, s = mpf(v), mp.cos(mpf(phase)), mp.sin(mpf(phase))
        worst = 0.0
        for i in range(1, impacts):
            wall, t, v, c, s = taylor_flight(wall * d / 2, -r * v, c, s, d, g)
            assert wall == rows[i, WALL]
            shift = abs(float(s) - np.sin(rows[i, PHASE])) + abs(float(c) - np.cos(rows[i, PHASE]))
            difference = max(abs(float(t) - rows[i, FLIGHT]), abs(float(v) - rows[i, VELOCITY]), shift)
            worst = max(worst, difference / growth[i - 1])
        assert worst < 2e-14
