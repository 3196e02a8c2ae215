"""The event search under a force with harmonics: against flights in fixed steps, by compiler and interpreter alike."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest
from conftest import first
from mpmath import mp, mpf
from raw_flights import Flights

from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions
from vireport.simulation.cycles import jacobians
from vireport.simulation.events import BOTTOM, TOP, Impact, check_model, check_start, follow_impacts, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, REST, RIDING, SETTLING, TURN, VELOCITY, WALL
from vireport.simulation.trajectories import path

Parts = tuple[tuple[int, float, float], ...]
"""Order, share and phase in degrees of harmonics."""

FORCES: tuple[Parts, ...] = (
    ((2, 0.05, 225.0),),
    ((2, 0.5, 10.0), (3, 0.3, 200.0)),
    ((8, 0.5, 70.0), (5, 0.2, 0.0)),
    ((3, 0.1, 0.0),),
)


def groups_of(d: float, gbar: float, r: object, parts: Parts) -> Groups:
    return Groups(d, gbar, r, tuple(Harmonic.of(j, 100 * p, psi) for j, p, psi in parts))


@pytest.mark.parametrize("parts", first(2, FORCES))
def test_each_impact_is_the_first_that_small_steps_find(parts: Parts) -> None:
    rng = np.random.default_rng(7)
    seen = 0
    for _ in range(3):
        d, gbar = float(rng.uniform(0.1, 0.8)), float(rng.uniform(0.0, 0.6))
        groups = groups_of(d, gbar, Restitutions(0.6, 0.5), parts)
        model = check_model(groups)[0]
        rows, _ = follow_one(model, check_start(Impact(BOTTOM, 0.9, 0.4), d), 40, compiled=False)
        for before, after in zip(rows[-8:-1], rows[-7:], strict=True):
            if before[SETTLING] + before[RIDING] > 0 or abs(before[VELOCITY]) < 1e-2:
                continue
            flights = Flights(groups, [(j, p, radians(psi)) for j, p, psi in parts], np)
            wall, time, speed = flights.struck(int(before[WALL]), before[VELOCITY], before[PHASE] / pi)
            if abs(speed) < 1e-3:
                continue  # a touch that steps may not see
            assert after[WALL] == wall
            assert after[FLIGHT] == pytest.approx(time, abs=1e-11)
            assert after[VELOCITY] == pytest.approx(speed, abs=1e-10)
            assert after[PHASE] == pytest.approx((before[PHASE] + pi * time) % TURN, abs=1e-10)
            seen += 1
    assert seen > 5


@pytest.mark.slow
def test_compiled_and_interpreted_searches_agree_over_devices_with_zeros_of_different_number() -> None:
    pytest.importorskip("numba")
    parts = FORCES[1]
    groups = groups_of(np.array([0.2, 0.5, 0.9]), np.array([0.0, 0.3, 1.7]), 0.5, parts)
    model = check_model(groups)
    starts = np.array([check_start(Impact(BOTTOM, 0.8, 0.3), 0.2)] * 3)
    both = [follow_impacts(model, starts, 60, compiled=compiled)[0] for compiled in (True, False)]
    for row in range(3):
        alone, summary = follow_one(model[row], tuple(starts[row]), 60, compiled=False)
        count = int(summary[0])
        ended = both[1][row, -count - 1 :] if count < 60 else both[1][row]
        np.testing.assert_allclose(ended, alone, rtol=0, atol=1e-9)
    finite = np.isfinite(both[0]) & np.isfinite(both[1])
    assert np.array_equal(np.isfinite(both[0]), np.isfinite(both[1]))
    np.testing.assert_allclose(both[0][finite][:60], both[1][finite][:60], rtol=0, atol=1e-9)


def test_without_harmonics_to_speak_of_impacts_are_those_of_the_sine() -> None:
    for gbar in (0.0, 0.4, 1.3):
        plain, more = (
            follow_one(check_model(groups)[0], check_start(Impact(BOTTOM, 0.7, 1.0), 0.45), 12, compiled=False)[0]
            for groups in (Groups(0.45, gbar, 0.5), groups_of(0.45, gbar, 0.5, ((3, 1e-15, 0.0),)))
        )
        count = min(len(plain), len(more))
        np.testing.assert_allclose(plain[:count], more[:count], rtol=0, atol=1e-10)
        assert len(plain) == len(more)


def test_a_ball_at_rest_leaves_where_the_force_no_longer_presses_it() -> None:
    """Laid on the bottom, it rides to a zero of the pull at which that turns; pressed for ever it stays."""
    parts = FORCES[1]
    groups = groups_of(0.5, 0.2, 0.5, parts)
    model = check_model(groups)[0]
    seen = set()
    for phase in np.linspace(0, TURN, 25, endpoint=False):
        rows, _ = follow_one(model, (float(BOTTOM), 0.0, 0.0, float(phase)), 1, compiled=False)
        released = (phase + pi * rows[0, RIDING]) % TURN
        x = np.array([released - 1e-6, released, released + 1e-6])
        pull = 0.2 + np.cos(x) + sum(p * np.cos(j * x + radians(psi)) for j, p, psi in parts)
        if rows[0, RIDING] > 0:
            assert pull[0] > 0 > pull[2]
            assert abs(pull[1]) < 1e-12
            seen.add(round(float(released), 6))
    assert seen
    pressed = check_model(groups_of(0.5, 2.0, 0.5, parts))[0]
    _, summary = follow_one(pressed, (float(BOTTOM), 0.0, 0.0, 1.0), 5, compiled=False)
    assert summary[2] == REST


def test_chatter_ends_where_many_small_hops_do() -> None:
    """A ball that is let fall a little way: the time of all its hops is the geometric sum that the search takes."""
    parts = ((2, 0.1, 40.0),)
    groups = groups_of(0.5, 0.3, 0.3, parts)
    model = check_model(groups)[0]
    rows, _ = follow_one(model, check_start(Impact(BOTTOM, 1e-3, 5.5), 0.5), 12, compiled=False)
    first = int(np.argmax(rows[:, SETTLING] > 0))
    assert rows[first, SETTLING] > 0
    with mp.workdps(40):
        flights = Flights(groups, [(2, mpf(0.1), 40 * mp.pi / 180)])
        clock, speed, start = mpf(0), mpf(float(rows[0, VELOCITY])), mpf(5.5) / mp.pi
        for _ in range(16):
            phase, after = mp.pi * start, mpf(0.3) * speed
            pull = 0.3 + mp.cos(phase) + 0.1 * mp.cos(2 * phase + 40 * mp.pi / 180)
            hop = mp.findroot(lambda t, v=speed, x=start: flights.flown(1, v, x, t)[1] / t, 2 * after / pull)
            speed, clock, start = flights.flown(1, speed, start, hop)[0], clock + hop, start + hop
    told = float(rows[1 : first + 1, FLIGHT].sum() + rows[first, SETTLING])
    assert told == pytest.approx(float(clock), rel=1e-8)


def test_paths_end_on_the_walls_of_their_impacts() -> None:
    groups = groups_of(0.46, 0.29, 0.5, FORCES[0])
    model = check_model(groups)[0]
    rows, _ = follow_one(model, check_start(Impact(BOTTOM, 1.0, 0.57), 0.46), 6, compiled=False)
    time, position, velocity = path(model, rows, samples=30)
    ends = np.flatnonzero(np.diff(time) == 0)
    assert len(ends) == 5
    np.testing.assert_allclose(np.abs(position[ends]), 0.23, atol=1e-12)
    np.testing.assert_allclose(velocity[ends], rows[1:-1, VELOCITY], atol=1e-12)
    assert set(rows[:, WALL]) == {BOTTOM, TOP}


def test_derivatives_of_impacts_are_those_of_impacts_beside_them() -> None:
    groups = groups_of(0.46, 0.29, Restitutions(0.45, 0.55), FORCES[1])
    model, d = check_model(groups)[0], 0.46

    def impact(velocity: float, phase: float) -> np.ndarray:
        return follow_one(model, check_start(Impact(BOTTOM, velocity, phase), d), 1, compiled=False)[0]

    for velocity, phase in ((1.0, 0.57), (0.8, 2.0)):
        rows, step = impact(velocity, phase), 1e-6
        found = jacobians(model, rows[:1], rows[1:])[0]
        moved = []
        for by_phase, by_velocity in ((step, 0.0), (0.0, step)):
            ends = [impact(velocity + way * by_velocity, phase + way * by_phase)[1] for way in (1, -1)]
            moved.append([(ends[0][column] - ends[1][column]) / (2 * step) for column in (PHASE, VELOCITY)])
        np.testing.assert_allclose(found, np.array(moved).T, rtol=1e-6, atol=1e-7)
