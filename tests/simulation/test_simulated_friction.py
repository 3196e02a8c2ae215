"""The event search of a ball with friction: against a simulator in 40 digits that is written from the model alone."""

from __future__ import annotations

from itertools import pairwise
from math import pi, sqrt

import numpy as np
import pytest
from conftest import first
from exact_friction import Reference
from mpmath import mp, mpf
from numpy.typing import NDArray

from vireport.design.from_rest import CREEPS, Destination, StartingDevice, from_rest
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions
from vireport.simulation.attractors import Outcome, find_attractor
from vireport.simulation.cycles import jacobians
from vireport.simulation.events import (
    BOTTOM,
    TOP,
    Impact,
    InFlight,
    check_model,
    check_start,
    follow_impacts,
    follow_one,
)
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, TURN, VELOCITY, WALL

Array = NDArray[np.float64]

CASES = {
    "turns and sticking": (Groups(0.46, 0.28, 0.5, (), 0.15), 0.9, 0.4),
    "much friction": (Groups(0.6, 0.1, 0.6, (), 0.45), 0.8, 2.0),
    "level": (Groups(0.5, 0.0, 0.5, (), 0.2), 0.7, 0.3),
    "unlike membranes": (Groups(0.3, 0.3, Restitutions(0.7, 0.4), (), 0.05), 0.5, 5.0),
    "harmonics": (Groups(0.4, 0.3, 0.5, (Harmonic.of(2, 30.0, 100.0), Harmonic.of(3, 10.0, 0.0)), 0.2), 0.6, 1.0),
}

CREEPING_BALL = Groups(26.7, 0.0, 0.974, (Harmonic.of(2, 9.0, 40.0),), 0.0134)
"""Of a long capsule: the force carries the ball to and fro, and the second harmonic a little farther one way."""


def free_impacts(groups: Groups[float], velocity: float, phase: float) -> tuple[Array, Array, Array]:
    """Impacts of a start on the bottom membrane after which the ball is not held, those after them, and the model."""
    model = check_model(groups)[0]
    rows, _ = follow_one(model, check_start(Impact(BOTTOM, velocity, phase), groups.d), 40, compiled=False)
    free = rows[:-1, SETTLING] + rows[:-1, RIDING] == 0
    return rows[:-1][free], rows[1:][free], model


@pytest.mark.parametrize("case", first(2, CASES))
def test_impacts_are_those_of_forty_digits_with_all_stops_between(case: str) -> None:
    groups, velocity, phase = CASES[case]
    rows, _ = follow_one(
        check_model(groups)[0], check_start(Impact(BOTTOM, velocity, phase), groups.d), 7, compiled=False
    )
    stops, seen = 0, 0
    with mp.workdps(40):
        exact = Reference(groups)
        for before, after in pairwise(rows):
            if before[SETTLING] + before[RIDING] > 0 or abs(before[VELOCITY]) < 1e-3:
                continue
            wall, time, speed, x, held = exact.next_impact(
                int(before[WALL]), mpf(float(before[VELOCITY])), mpf(float(before[PHASE]))
            )
            assert after[WALL] == wall
            sharp = 1 + 1 / abs(float(speed))
            assert after[FLIGHT] == pytest.approx(float(time), abs=1e-13 * sharp)
            assert after[VELOCITY] == pytest.approx(float(speed), abs=1e-13 * sharp)
            assert after[PHASE] == pytest.approx(float(x) % TURN, abs=1e-12 * sharp)
            stops, seen = stops + held, seen + 1
    assert seen > 4
    if case in ("turns and sticking", "much friction", "level", "harmonics"):
        assert stops > 0


@pytest.mark.parametrize("case", CASES)
def test_an_impact_moves_with_the_one_before_as_differences_say(case: str) -> None:
    groups, velocity, phase = CASES[case]
    model, seen = check_model(groups)[0], 0
    rows, _ = follow_one(model, check_start(Impact(BOTTOM, velocity, phase), groups.d), 8, compiled=False)
    for before, after in pairwise(rows):
        if before[SETTLING] + before[RIDING] > 0 or abs(after[VELOCITY]) < 0.05 or abs(before[VELOCITY]) < 0.05:
            continue
        (matrix,) = jacobians(model, before[None], after[None])
        step, columns = 1e-6, []
        for column in (PHASE, VELOCITY):
            ends = []
            for sign in (1, -1):
                moved = before.copy()
                moved[column] += sign * step
                end, _ = follow_one(model, (before[WALL], 0.0, moved[VELOCITY], moved[PHASE]), 1, compiled=False)
                ends.append(end[-1, [PHASE, VELOCITY]])
            columns.append((ends[0] - ends[1]) / (2 * step))
        np.testing.assert_allclose(matrix, np.array(columns).T, atol=3e-4 * max(1.0, float(np.abs(matrix).max())))
        seen += 1
    assert seen > 2


@pytest.mark.parametrize(("case", "start"), [*CASES.items(), ("creeping", (CREEPING_BALL, 1.0, 0.3))])
def test_many_impacts_at_once_move_as_those_before_say(case: str, start: tuple[Groups[float], float, float]) -> None:
    before, after, model = free_impacts(*start)
    together = jacobians(model, before, after)
    ones = np.concatenate([jacobians(model, before[k, None], after[k, None]) for k in range(len(before))])
    np.testing.assert_array_equal(together, ones, case)
    assert len(ones) > 3


@pytest.mark.slow  # as the next one
def test_compiled_derivatives_are_the_interpreted_ones() -> None:
    pytest.importorskip("numba")
    for case, start in {**CASES, "creeping": (CREEPING_BALL, 1.0, 0.3)}.items():
        before, after, model = free_impacts(*start)
        one, other = (jacobians(model, before, after, compiled) for compiled in (True, False))
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9, err_msg=case)


@pytest.mark.slow  # it takes a compiler longer than all the others of this file together
def test_the_compiled_search_is_the_interpreted_one() -> None:
    pytest.importorskip("numba")
    groups = Groups(np.array([0.3, 0.5, 0.7]), np.array([0.0, 0.3, 1.2]), 0.5, (), np.array([0.2, 0.1, 0.05]))
    model = check_model(groups)
    starts = np.array([check_start(Impact(BOTTOM, 0.8, 0.3), 0.3)] * 3)
    first, second = (follow_impacts(model, starts, 12, compiled=compiled) for compiled in (True, False))
    np.testing.assert_allclose(first[0], second[0], rtol=0, atol=1e-9)
    assert np.array_equal(first[1][:, [0, 2]], second[1][:, [0, 2]])


def test_without_friction_to_speak_of_impacts_are_those_of_the_frictionless_search() -> None:
    for gbar in (0.0, 0.4):
        rows = [
            follow_one(check_model(Groups(0.46, gbar, 0.5, (), friction))[0], (1.0, 0.0, 0.9, 0.5), 8, compiled=False)[
                0
            ]
            for friction in (None, 1e-15)
        ]
        np.testing.assert_allclose(rows[0][:, :4], rows[1][:, :4], rtol=0, atol=1e-11)


def test_a_ball_stays_on_a_membrane_until_the_pull_exceeds_friction() -> None:
    """Pressed by gbar + cos: off the bottom one where this is -f; a ball that moves not at all waits for either."""
    g, f = 0.3, 0.2
    model = check_model(Groups(2.0, g, 0.5, (), f))[0]
    rows, _ = follow_one(model, check_start(Impact(BOTTOM, 0.0, 0.0), 2.0), 1, compiled=False)
    assert rows[0, RIDING] == pytest.approx(np.arccos(-(g + f)) / pi, abs=1e-15)
    still = 2.0  # |0.3 + cos 2| = 0.116: held at once, let go where 0.3 + cos x = -0.2
    rows, _ = follow_one(model, check_start(InFlight(0.3, 0.0, still), 2.0), 1, compiled=False)
    with mp.workdps(40):
        exact = Reference(Groups(2.0, g, 0.5, (), f))
        held, way = exact.freed(mpf(still), (-1, 1))
        assert way == -1
        assert float(held) == pytest.approx((np.arccos(-(g + f)) - still) / pi, abs=1e-15)
    assert rows[1, FLIGHT] > float(held)


def test_what_friction_holds_for_ever_is_told() -> None:
    ends = ((1.2, InFlight(0.1, 0.4, 0.0), Outcome.HELD), (0.95, Impact(BOTTOM, 0.0, 0.0), Outcome.REST))
    for friction, start, outcome in ends:
        assert find_attractor(Groups(0.5, 0.1, 0.5, (), friction), start, compiled=False).outcome is outcome


def test_a_ball_that_stops_hundreds_of_times_in_a_flight_is_not_followed_to_its_end() -> None:
    end = find_attractor(CREEPING_BALL, Impact(BOTTOM, 1.0, 0.3), compiled=False)
    assert (end.outcome, end.cycle) == (Outcome.CREEPING, None)
    from_rest_of = from_rest(StartingDevice(CREEPING_BALL))
    assert (from_rest_of.destination, from_rest_of.name) == (Destination.UNDECIDED, CREEPS)
    assert not from_rest(StartingDevice(CREEPING_BALL._replace(d=1.0))).creeping


def test_last_hops_together_take_as_long_as_they_do_one_by_one() -> None:
    """Pressed by a force that hardly changes: the sum over the hops of a ball with friction, each in closed form."""
    g, f, r = 0.4, 0.1, 0.5
    model = check_model(Groups(1.0, g, r, (), f))[0]
    rows, _ = follow_one(model, check_start(Impact(BOTTOM, 2e-9, 0.0), 1.0), 1, compiled=False)
    press, v, total = g + 1.0, r * 2e-9, 0.0
    while v > 1e-30:
        high, back = v * v / (2 * (press + f)), sqrt((press - f) / (press + f)) * v
        total += v / (press + f) + 2 * high / back
        v = r * back
    assert rows[0, SETTLING] == pytest.approx(total, rel=1e-7)


def test_a_cycle_is_told_from_its_way_by_its_multipliers() -> None:
    end = find_attractor(Groups(0.46, 0.2876, 0.5, (), 0.0144), Impact(BOTTOM, 1.0, 0.5), compiled=False)
    assert end.word == "BT"
    product = end.cycle.multipliers[0] * end.cycle.multipliers[1]
    assert product == pytest.approx(0.5**4, abs=1e-12)
    assert end.cycle.wall.tolist() == [BOTTOM, TOP]
