"""Event location against 40-digit arithmetic, and invariants of long runs.

The reference never asks the code under test how it searches: that a time is a root is checked by Newton's
method in 40 digits, that no root comes before it by excluding intervals with a bound on Z''.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from mpmath import mp, mpf
from msgspec.structs import replace

from vireport.physics.groups import Groups
from vireport.simulation.events import (
    BOTTOM,
    TOP,
    Impact,
    InFlight,
    as_start,
    check_model,
    check_start,
    follow_impacts,
    follow_one,
)
from vireport.simulation.kernel import FLIGHT, FREE, PHASE, REST, RIDING, RUNNING, SETTLING, VELOCITY, WALL

FLIGHTS = 10_000
# Where the terms of Z add up to no more than this many times t |Z'|, the crossing counts as transversal.
TRANSVERSAL = 2.0
ULPS = 4.0
ULPS_PER_CONDITION = 2.5


def one_flight(d, gbar, r, wall, velocity, phase):
    """First impact after each start on a wall: rows of (wall, phase, time, velocity)."""
    model = check_model(Groups(d, gbar, r))
    starts = np.column_stack([wall, np.zeros(len(model)), velocity, phase])
    rows, summary = follow_impacts(model, starts, 1)
    assert (summary[:, 0] == 1).all()
    assert (rows[:, 0, RIDING] + rows[:, 0, SETTLING] == 0).all()
    return rows[:, 1]


def lag(x):
    """x - sin x in numpy, by continued halving of the argument where it would cancel."""
    return np.where(np.abs(x) < 0.1, x**3 / 6 * (1 - x**2 / 20 * (1 - x**2 / 42 * (1 - x**2 / 72))), x - np.sin(x))


def height(t, v, gbar, wall, phase):
    """Distance from the wall that was left, and its rate of change."""
    x, e = pi * t, -wall
    rise = 2 * np.sin(x / 2) ** 2
    u = v * t + e * (gbar * t * t / 2 + (np.cos(phase) * rise - np.sin(phase) * lag(x)) / pi**2)
    return u, v + e * (gbar * t + (np.cos(phase) * np.sin(x) - np.sin(phase) * rise) / pi)


def plain_starts(rng, n):
    return {
        "d": np.exp(rng.uniform(np.log(0.03), np.log(3), n)),
        "gbar": rng.choice([0.0, 1.0, 2.0], n, p=[0.15, 0.7, 0.15]) * rng.random(n),
        "wall": rng.choice([1.0, -1.0], n),
        "v": 10 ** rng.uniform(-6, 0.5, n),
        "phase": rng.uniform(0, 2 * pi, n),
    }


def grazing_far(rng, n):
    """Starts whose first peak comes close to the opposite wall: d is chosen for the gap."""
    s = plain_starts(rng, 4 * n)
    s["v"] = rng.uniform(0.05, 1.5, 4 * n)
    grid = np.linspace(1e-3, 3, 600)[:, None]
    u, du = height(grid, s["v"], s["gbar"], s["wall"], s["phase"])
    turns = (du[:-1] > 0) & (du[1:] <= 0)
    k = np.argmax(turns, axis=0)
    low, high = grid[k, 0], grid[k + 1, 0]
    for _ in range(60):
        middle = (low + high) / 2
        rising = height(middle, s["v"], s["gbar"], s["wall"], s["phase"])[1] > 0
        low, high = np.where(rising, middle, low), np.where(rising, high, middle)
    top = height(low, s["v"], s["gbar"], s["wall"], s["phase"])[0]
    gap = 10 ** rng.uniform(-12, -2, 4 * n) * rng.choice([1, -1], 4 * n)
    s["d"] = top + gap
    before = np.where(np.arange(600)[:, None] <= k, u, np.inf).min(axis=0)
    good = np.flatnonzero(turns.any(axis=0) & (top > 0.03) & (before > 0) & (np.abs(gap) < top / 2))[:n]
    assert len(good) == n
    return {key: value[good] for key, value in s.items()}, gap[good], low[good]


def grazing_near(rng, n):
    """Starts that come back and just miss, or just hit, the wall they left: gbar and v are chosen for it."""
    m = 60 * n
    wall, phase, t = rng.choice([1.0, -1.0], m), rng.uniform(0, 2 * pi, m), rng.uniform(0.3, 2.5, m)
    gap = 10 ** rng.uniform(-12, -3, m) * rng.choice([1, -1], m)
    # u = v t - w g t^2/2 + u0 = gap and u' = v - w g t + du0 = 0 are linear in v and w g.
    u0, du0 = height(t, 0.0, 0.0, wall, phase)
    wg = 2 * (gap - u0 + du0 * t) / (t * t)
    v = wg * t - du0
    curved = -wg - wall * np.cos(phase + pi * t)
    good = np.flatnonzero((v > 0.01) & (wg * wall > 0) & (wg * wall < 1.5) & (curved > 0.1) & (v < 3))
    grid = np.linspace(0, 1, 200)[1:-8, None] * t[good]
    early = height(grid, v[good], wg[good] * wall[good], wall[good], phase[good])[0].min(axis=0)
    good = good[early > 0][:n]
    assert len(good) == n
    top = height(np.linspace(0, 1, 200)[:, None] * t[good], v[good], wg[good] * wall[good], wall[good], phase[good])
    d = top[0].max(axis=0) * 1.2 + 0.05
    s = {"d": d, "gbar": wg[good] * wall[good], "wall": wall[good], "v": v[good], "phase": phase[good]}
    return s, gap[good], t[good]


def exact(t, v, gbar, wall, phase, target):
    """Root in 40 digits from a first guess; condition number; velocity."""
    v, gbar, phase, t = mpf(float(v)), mpf(float(gbar)), mpf(float(phase)), mpf(float(t))
    e, s, c = -int(wall), mp.sin(phase), mp.cos(phase)
    for _ in range(40):
        x = mp.pi * t
        sx, cx = mp.sin(x), mp.cos(x)
        parts = (
            v * t,
            e * gbar * t * t / 2,
            e * c * (1 - cx) / mp.pi**2,
            -e * s * (x - sx) / mp.pi**2,
            -target,
        )
        rate = v + e * (gbar * t + (c * sx - s * (1 - cx)) / mp.pi)
        step = sum(parts) / rate
        t -= step
        if abs(step) <= abs(t) * mpf(10) ** -30:
            return t, float(sum(abs(p) for p in parts) / abs(t * rate)), rate
    return None


def first_is_first(s, impact):
    """Exclude earlier impacts: on an interval u is within max|Z''| h^2/8 of its chord, or it is halved."""
    v, bend, d = s["v"], s["gbar"] + 1, s["d"]
    t, speed = impact[:, FLIGHT], np.abs(impact[:, VELOCITY])
    start = np.minimum(v / bend, d / (2 * v))  # until here u > v t/2 and u < 3 d/4
    stop = t - np.minimum(speed / (2 * bend), t / 2)  # from here u' keeps its sign
    index, a, b = np.arange(len(t)), start, stop
    assert (t > start).all()
    keep = b > a
    index, a, b = index[keep], a[keep], b[keep]
    for _ in range(60):
        if len(index) == 0:
            return
        flight = [s[key][index] for key in ("v", "gbar", "wall", "phase")]
        ua, ub = height(a, *flight)[0], height(b, *flight)[0]
        slack = bend[index] * (b - a) ** 2 / 8
        noise = 2e-15 * (v[index] * b + bend[index] * b * b)
        free = (np.minimum(ua, ub) - slack > noise) & (np.maximum(ua, ub) + slack < d[index] - noise)
        index, a, b = index[~free], a[~free], b[~free]
        middle = (a + b) / 2
        index, a, b = np.tile(index, 2), np.concatenate((a, middle)), np.concatenate((middle, b))
    raise AssertionError(f"{len(index)} intervals before an impact may hold another one: {index[:5]}")


def nearly_released(rng, n):
    """Slow hops while the wall is just about to stop pressing: the pull changes sign during the flight."""
    s = plain_starts(rng, n)
    s["gbar"] = 0.98 * rng.random(n)
    turn = np.where(s["wall"] > 0, np.arccos(-s["gbar"]), 2 * pi - np.arccos(-s["gbar"]))
    left = 10 ** rng.uniform(-6, -1, n)
    s["phase"] = turn - pi * left
    s["v"] = left**2 * 10 ** rng.uniform(-1, 1, n)
    return s


@pytest.fixture(scope="module")
def flights():
    """10,000 flights, a third of them near grazing, and the impacts found."""
    rng = np.random.default_rng(20261)
    far, far_gap, far_turn = grazing_far(rng, FLIGHTS // 6)
    near, near_gap, near_turn = grazing_near(rng, FLIGHTS // 6)
    slow = nearly_released(rng, FLIGHTS // 12)
    plain = plain_starts(rng, FLIGHTS - FLIGHTS // 6 * 2 - FLIGHTS // 12)
    s = {key: np.concatenate([far[key], near[key], slow[key], plain[key]]) for key in plain}
    impact = one_flight(s["d"], s["gbar"], 1.0, s["wall"], s["wall"] * s["v"], s["phase"])
    return s, impact, (far_gap, far_turn), (near_gap, near_turn)


@pytest.mark.slow
def test_no_impact_is_missed_or_invented(flights) -> None:
    s, impact, (far_gap, far_turn), (near_gap, near_turn) = flights
    n = len(far_gap)
    far, near = impact[:n], impact[n : 2 * n]
    hit = far_gap < 0
    assert 0.4 < hit.mean() < 0.6
    assert (far[hit, WALL] == -s["wall"][:n][hit]).all()
    assert (far[hit, FLIGHT] < far_turn[hit]).all()
    assert (far[~hit, FLIGHT] > far_turn[~hit]).all()
    hit = near_gap < 0
    assert 0.4 < hit.mean() < 0.6
    assert (near[hit, WALL] == s["wall"][n : 2 * n][hit]).all()
    assert (near[hit, FLIGHT] < near_turn[hit]).all()
    assert (near[~hit, FLIGHT] > near_turn[~hit]).all()
    first_is_first(s, impact)


@pytest.mark.slow
def test_impact_times_are_exact_to_a_few_ulp(flights) -> None:
    s, impact, _, _ = flights
    worst = 0.0
    with mp.workdps(60):  # 40 good digits of the time need more where short hops cancel
        for i, row in enumerate(impact):
            target = 0 if row[WALL] == s["wall"][i] else mpf(float(s["d"][i]))
            expected = exact(row[FLIGHT], s["v"][i], s["gbar"][i], s["wall"][i], s["phase"][i], target)
            assert expected is not None, s["d"][i]
            t, condition, rate = expected
            ulps = float(abs(t - mpf(float(row[FLIGHT])))) / np.spacing(float(t))
            if condition <= TRANSVERSAL:
                worst = max(worst, ulps)
            else:
                assert ulps <= ULPS_PER_CONDITION * condition
            assert abs(float(rate) + s["wall"][i] * row[VELOCITY]) < 1e-14 * (1 + float(t)) * max(1.0, condition)
            turned = mp.fmod(mpf(float(s["phase"][i])) + mp.pi * mpf(float(row[FLIGHT])) - row[PHASE], 2 * mp.pi)
            assert min(turned, 2 * mp.pi - turned, abs(turned)) < 2e-15 * (1 + float(t))
    assert worst <= ULPS


def test_velocity_is_never_of_the_wrong_sign(flights) -> None:
    _, impact, _, _ = flights
    assert (impact[:, WALL] * impact[:, VELOCITY] >= 0).all()


@pytest.mark.parametrize("drift", [1e-3, 1e-6, 1e-9])
def test_a_long_flight_keeps_its_phase(drift: float) -> None:
    """Up to a billion periods between the walls: the phase comes from what exceeds whole periods."""
    phase, d = 1.25, 0.9
    velocity = np.sin(phase) / pi + drift
    rows, summary = follow_one(check_model(Groups(d, 0.0, 0.5))[0], check_start(InFlight(0.0, velocity, phase), d), 1)
    t, arrival, speed = rows[1, [FLIGHT, PHASE, VELOCITY]]
    assert t * drift > 0.1
    assert summary[1] < 30
    # The velocity at the impact belongs to its phase to the last digit, though t alone knows it to 1e-7 only.
    assert abs(velocity + (np.sin(arrival) - np.sin(phase)) / pi - speed) < 1e-15
    assert abs((phase + pi * t - arrival + pi) % (2 * pi) - pi) < 1e-14 * t
    with mp.workdps(40):
        slow = mpf(float(velocity)) - mp.sin(mpf(phase)) / mp.pi
        rounding = 2e-16 * t  # of the drift, a difference of two numbers near 0.3
        swing = (mp.cos(mpf(phase)) - mp.cos(mpf(float(arrival)))) / mp.pi**2
        assert abs(slow * mpf(float(t)) + swing - mpf(d) / 2) < rounding
        # The peak of the period before stayed inside.
        assert slow * (mpf(float(t)) - 2) + (mp.cos(mpf(phase)) + 1) / mp.pi**2 < mpf(d) / 2 + 2 * drift + rounding


def test_a_hair_decides_whether_the_wall_is_touched() -> None:
    """Membranes a hair closer, or farther, than the first peak of the motion."""
    phase, v = 0.3, 0.2
    grid = np.linspace(0.01, 2, 20000)
    _, du = height(grid, v, 0.0, 1.0, phase)
    k = np.flatnonzero((du[:-1] > 0) & (du[1:] <= 0))[0]
    low, high = grid[k], grid[k + 1]
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if height(middle, v, 0.0, 1.0, phase)[1] > 0 else (low, middle)
    top = float(height(low, v, 0.0, 1.0, phase)[0])
    for inside, touches in ((1e-13, True), (-1e-13, False)):
        row = one_flight(top - inside, 0.0, 1.0, np.array([1.0]), np.array([v]), np.array([phase]))[0]
        assert bool(abs(row[FLIGHT] - low) < 1e-6) is touches
        if touches:
            assert row[WALL] == TOP
            assert abs(row[VELOCITY]) < 1e-6


def test_chatter_is_completed_to_the_sum_of_its_flights() -> None:
    """The closed form against one hop after another in 50 digits, until nothing is left."""
    rng = np.random.default_rng(5)
    seen = 0
    while seen < 12:
        gbar, r, wall = rng.uniform(0, 1.3), rng.choice([0.1, 0.5, 0.8]), rng.choice([1, -1])
        phase, v = rng.uniform(0, 2 * pi), 10 ** rng.uniform(-8, -2)
        if wall * (gbar + np.cos(phase)) < 0.05:
            continue
        rows, _ = follow_one(check_model(Groups(0.5, gbar, r))[0], check_start(Impact(wall, wall * v, phase), 0.5), 400)
        row = rows[np.flatnonzero(rows[:, RIDING] > 0)[0]]
        if row[WALL] != wall:
            continue
        seen += 1
        with mp.workdps(50):
            p, speed, total = mpf(row[PHASE]), mpf(abs(row[VELOCITY])) * mpf(r), mpf(0)
            while speed > mpf(10) ** -24:
                s, c, g = mp.sin(p) * wall, mp.cos(p) * wall, mpf(gbar) * wall
                t = 2 * speed / (g + c)
                for _ in range(8):
                    x = mp.pi * t
                    u = speed * t - g * t * t / 2 - (c * (1 - mp.cos(x)) - s * (x - mp.sin(x))) / mp.pi**2
                    rate = speed - g * t - (c * mp.sin(x) - s * (1 - mp.cos(x))) / mp.pi
                    t -= u / rate
                speed, p, total = -rate * mpf(r), p + mp.pi * t, total + t
            assert abs(total - mpf(row[SETTLING])) < 2e-15


CHAOS = (0.2545, 0.3, 0.5)


def extremes_stay_inside(model, rows) -> float:
    """Largest excursion beyond a wall, at the zeros of Z', found by bisection between those of Z''."""
    d, gbar, r = model
    before, after = rows[:-1], rows[1:]
    plain = before[:, RIDING] + before[:, SETTLING] == 0
    before, after = before[plain], after[plain]
    wall, v, phase, t = before[:, WALL], r * np.abs(before[:, VELOCITY]), before[:, PHASE], after[:, FLIGHT]
    turn = np.arccos(-gbar) if gbar < 1 else pi
    worst = -np.inf
    edges = [np.zeros_like(t)]
    for k in range(int(t.max() / 2) + 2):
        edges += [((-turn - phase) % (2 * pi)) / pi + 2 * k, ((turn - phase) % (2 * pi)) / pi + 2 * k]
    edges = np.minimum(np.sort(np.array([*edges, t]), axis=0), t)
    for a, b in pairwise(edges):
        flight = v, gbar, wall, phase
        fa, fb = height(a, *flight)[1], height(b, *flight)[1]
        has = (fa * fb < 0) & (b > a)
        a, b, flight, fa = a[has], b[has], (v[has], gbar, wall[has], phase[has]), fa[has]
        if len(a) == 0:
            continue
        for _ in range(54):
            m = (a + b) / 2
            same = height(m, *flight)[1] * fa > 0
            a, b = np.where(same, m, a), np.where(same, b, m)
        u = height(a, *flight)[0]
        worst = max(worst, float((-u).max()), float((u - d).max()))
    end = height(t, v, gbar, wall, phase)[0] - np.where(after[:, WALL] == wall, 0, d)
    assert np.abs(end).max() < 2e-15 * (1 + t.max())
    return worst


@pytest.mark.slow
@pytest.mark.parametrize("model", [CHAOS, (0.4, 0.0, 0.5), (0.12, 0.9, 0.7), (0.6, 1.1, 0.95)], ids=str)
def test_ball_is_on_the_wall_at_impacts_and_inside_between(model) -> None:
    rows, summary = follow_one(check_model(Groups(*model))[0], check_start(Impact(TOP, -0.4, 1.0), model[0]), 250_000)
    assert summary[0] == 250_000 or model[1] > 1
    assert extremes_stay_inside(model, rows) < 1e-14
    assert (rows[:, WALL] * rows[:, VELOCITY] >= 0).all()


@pytest.mark.slow
def test_ten_million_impacts_lose_no_accuracy() -> None:
    """The last of ten million flights of a chaotic motion satisfies the equations as the first one does."""
    model = check_model(Groups(*CHAOS))
    rows, summary = follow_impacts(model, np.array([[1.0, 0.0, 0.7, 0.2]]), 10_000_000, keep=2000)
    assert summary[0, 0] == 10_000_000
    assert extremes_stay_inside(CHAOS, rows[0]) < 1e-14
    assert ((rows[0, :, PHASE] >= 0) & (rows[0, :, PHASE] < 2 * pi)).all()
    ahead = np.diff(rows[0, :, PHASE]) - pi * rows[0, 1:, FLIGHT]
    assert np.abs((ahead + pi) % (2 * pi) - pi).max() < 4e-15


def test_a_turn_of_the_phase_changes_nothing() -> None:
    for start in (Impact(BOTTOM, 0.7, 0.25), InFlight(0.05, -0.2, 3.0)):
        turned = replace(start, phase=start.phase + 2 * pi)
        followed = follow_one(check_model(Groups(*CHAOS))[0], check_start(start, CHAOS[0]), 30)[0]
        two = follow_one(check_model(Groups(*CHAOS))[0], check_start(turned, CHAOS[0]), 30)[0]
        assert np.abs(followed[1:, FLIGHT] - two[1:, FLIGHT]).max() < 1e-11
        assert np.array_equal(followed[:, WALL], two[:, WALL])


def test_mirrored_motion_without_gravity() -> None:
    """beta = 0: top and bottom exchanged, half a turn later; each of 20,000 flights on its own."""
    rng = np.random.default_rng(8)
    n = 20_000
    d, v, phase = rng.uniform(0.05, 0.8, n), rng.uniform(0.01, 1.5, n), rng.uniform(0, pi, n)
    flight = one_flight(d, 0.0, 1.0, np.ones(n), v, phase)
    two = one_flight(d, 0.0, 1.0, -np.ones(n), -v, phase + pi)
    assert np.array_equal(flight[:, WALL], -two[:, WALL])
    fast = np.abs(flight[:, VELOCITY]) > 1e-3
    assert np.abs(flight[fast, FLIGHT] - two[fast, FLIGHT]).max() < 1e-12
    assert np.abs(flight[fast, VELOCITY] + two[fast, VELOCITY]).max() < 1e-12


def test_a_start_in_flight_meets_the_flight_it_is_taken_from() -> None:
    """Any moment of a flight is a start that leads to the same impact."""
    d, gbar, v, phase = 0.5, 0.25, 0.4, 5.0
    row = one_flight(d, gbar, 1.0, np.array([-1.0]), np.array([-v]), np.array([phase]))[0]
    for part in (0.05, 0.3, 0.7, 0.95):
        t = part * row[FLIGHT]
        u, rate = height(t, v, gbar, -1.0, phase)
        start = check_start(InFlight(float(u) - d / 2, float(rate), phase + pi * t), d)
        again = follow_one(check_model(Groups(d, gbar, 1.0))[0], start, 1)[0][1]
        assert again[WALL] == row[WALL]
        assert again[FLIGHT] == pytest.approx(row[FLIGHT] - t, abs=1e-14)
        assert again[VELOCITY] == pytest.approx(row[VELOCITY], abs=1e-14)


def test_continuing_is_the_same_as_going_on() -> None:
    model = check_model(Groups(*CHAOS))[0]
    whole = follow_one(model, (1.0, 0.0, 0.7, 0.2), 500)[0]
    half = follow_one(model, (1.0, 0.0, 0.7, 0.2), 200, keep=7)[0]
    assert np.array_equal(half, whole[194:201])
    rest = follow_one(model, as_start(half[-1]), 300)[0]
    assert np.array_equal(rest[1:], whole[201:])


@example(d=1651.0, gbar=1.0, r=3.5e-208, velocity=3.4e-89, phase=-pi, wall=BOTTOM)
@example(d=0.0146, gbar=3e-10, r=1.0, velocity=5.1e-205, phase=-8.122774410300824, wall=TOP)
@given(
    d=st.floats(1e-6, 1e6),
    gbar=st.one_of(st.just(0.0), st.just(1.0), st.floats(0, 3), st.floats(0.999999, 1.000001), st.floats(0, 1e-9)),
    r=st.one_of(st.just(0.0), st.just(1.0), st.floats(0, 1)),
    velocity=st.one_of(st.floats(0, 2), st.floats(0, 1e-9), st.floats(0, 1e6)),
    phase=st.floats(-10, 10),
    wall=st.sampled_from([BOTTOM, TOP]),
)
def test_nothing_loops_and_nothing_leaves(d, gbar, r, velocity, phase, wall) -> None:
    """Any start at all: the search ends, stays on the walls, and every impact comes from inside."""
    rows, summary = follow_one(
        check_model(Groups(d, gbar, r))[0], check_start(Impact(wall, wall * velocity, phase), d), 50
    )
    assert np.isfinite(rows[:, :VELOCITY]).all()
    assert (rows[1:, WALL] * rows[1:, VELOCITY] >= 0).all()
    assert (rows[1:, FLIGHT] >= 0).all()
    assert ((rows[:, PHASE] >= 0) & (rows[:, PHASE] < 2 * pi)).all()
    assert summary[0] == len(rows) - 1


def test_a_ball_without_drift_never_arrives() -> None:
    """gbar = 0 and Z' = sin(phase)/pi: the same motion every period, provably without an impact."""
    rows, summary = follow_one(check_model(Groups(3.0, 0.0, 0.5))[0], check_start(InFlight(0.0, 0.0, 0.0), 3.0), 5)
    assert summary[2] == FREE
    assert len(rows) == 1
    rows, summary = follow_one(check_model(Groups(0.1, 0.0, 0.5))[0], check_start(InFlight(0.0, 0.0, 0.0), 0.1), 5)
    assert summary[0] == 5
    # The lowest point of this period comes last in it, just beyond the top membrane.
    late = InFlight(-0.25 + 0.005, np.sin(0.5) * (1 / pi), 0.5)
    rows, summary = follow_one(check_model(Groups(0.5, 0.0, 0.5))[0], check_start(late, 0.5), 1)
    assert (summary[0], rows[-1, WALL]) == (1, TOP)
    assert 1.5 < rows[-1, FLIGHT] < 2


def test_an_impact_that_hardly_is_one_rides_until_the_membrane_lets_go() -> None:
    """It settles in no time, and the release is at arccos(-gbar)."""
    phase, gbar = 0.3, 0.4
    model = check_model(Groups(0.5, gbar, 0.5))[0]
    start = follow_one(model, check_start(Impact(BOTTOM, 1e-300, phase), 0.5), 3)[0][0]
    assert start[SETTLING] < 1e-290
    assert start[SETTLING] + start[RIDING] == pytest.approx((np.arccos(-gbar) - phase) / pi, rel=1e-14)


@pytest.mark.parametrize(("gbar", "end"), [(1 - 1e-12, RUNNING), (1.0, REST), (1 + 1e-12, REST)])
def test_a_slow_ball_comes_to_rest_where_gravity_is_as_large_as_the_force(gbar: float, end: int) -> None:
    model = check_model(Groups(0.5, gbar, 0.5))[0]
    _, summary = follow_one(model, check_start(Impact(BOTTOM, 1e-3, 0.0), 0.5), 1000)
    assert summary[2] == end


@pytest.mark.parametrize(
    ("start", "d"),
    [
        (Impact(BOTTOM, -0.1, 0.0), 1.0),
        (Impact(TOP, 0.1, 0.0), 1.0),
        (Impact(0, 0.1, 0.0), 1.0),
        (Impact(BOTTOM, np.nan, 0.0), 1.0),
        (InFlight(0.5, 0.0, 0.0), 1.0),
        (InFlight(0.0, 0.0, np.inf), 1.0),
    ],
)
def test_impossible_starts_are_refused(start, d: float) -> None:
    with pytest.raises(ValueError, match=r"wall|finite|membranes"):
        check_start(start, d)


@pytest.mark.parametrize(
    "model", [(0.0, 0.1, 0.5), (1.0, -0.1, 0.5), (1.0, 0.1, 1.1), (1.0, 0.1, -0.1), (np.nan, 0.1, 0.5)]
)
def test_impossible_devices_are_refused(model) -> None:
    with pytest.raises(ValueError, match="d"):
        check_model(Groups(*model))
