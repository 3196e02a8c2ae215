"""The event search of a ball with friction: against a simulator in 40 digits that is written from the model alone."""

from __future__ import annotations

from itertools import pairwise
from math import pi, sqrt

import numpy as np
import pytest
from mpmath import mp, mpf

from vireport.physics import Groups, Harmonic, Restitutions
from vireport.simulation import (
    BOTTOM,
    FLIGHT,
    PHASE,
    RIDING,
    SETTLING,
    TOP,
    TURN,
    VELOCITY,
    WALL,
    Impact,
    InFlight,
    Outcome,
    check_model,
    check_start,
    find_attractor,
    follow_impacts,
    follow_one,
)
from vireport.simulation.cycles import jacobians

STEPS = 64
"""Samples of a forcing period between which the reference looks for a change of sign."""


class Reference:
    """Z'' = gbar + a - f sign(Z') with sticking, in 40 digits: samples of each way between stops, and bisections."""

    def __init__(self, groups: Groups) -> None:
        self.groups = groups.each(mpf)

    def force(self, x: mpf) -> mpf:
        return mp.cos(x) + sum(h.cosine * mp.cos(h.order * x) + h.sine * mp.sin(h.order * x) for h in self.parts)

    @property
    def parts(self) -> tuple[Harmonic, ...]:
        return self.groups.harmonics

    def impulse(self, x: mpf) -> mpf:
        own = ((h.cosine * mp.sin(h.order * x) - h.sine * mp.cos(h.order * x)) / h.order for h in self.parts)
        return mp.sin(x) + sum(own)

    def path(self, x: mpf) -> mpf:
        own = ((h.cosine * mp.cos(h.order * x) + h.sine * mp.sin(h.order * x)) / h.order**2 for h in self.parts)
        return mp.cos(x) + sum(own)

    def velocity(self, t: mpf, v: mpf, x: mpf, way: int) -> mpf:
        gravity = self.groups.gbar - way * self.groups.friction
        return v + gravity * t + (self.impulse(x + mp.pi * t) - self.impulse(x)) / mp.pi

    def covered(self, t: mpf, v: mpf, x: mpf, way: int) -> mpf:
        gravity = self.groups.gbar - way * self.groups.friction
        bent = (self.path(x + mp.pi * t) - self.path(x)) / mp.pi**2
        return v * t + gravity * t * t / 2 - self.impulse(x) * t / mp.pi - bent

    def pull(self, x: mpf) -> mpf:
        return self.groups.gbar + self.force(x)

    @staticmethod
    def root(function, low: mpf, high: mpf) -> mpf:
        rising = function(high) > 0
        for _ in range(120):
            middle = (low + high) / 2
            low, high = (low, middle) if (function(middle) > 0) == rising else (middle, high)
        return (low + high) / 2

    def freed(self, x: mpf, leaves: tuple[int, ...]) -> tuple[mpf, int]:
        """How long friction holds the ball, and the way on which it is let go."""
        f, step = self.groups.friction, mpf(2) / (8 * STEPS)
        for k in range(8 * STEPS + 1):
            for way in leaves:
                beyond = way * self.pull(x + mp.pi * step * (k + 1)) - f
                if beyond > 0:
                    there = self.root(
                        lambda t, way=way: way * self.pull(x + mp.pi * t) - f, step * k if k else mpf(0), step * (k + 1)
                    )
                    return there, way
        raise AssertionError("held for ever")

    def next_impact(self, wall: int, before: mpf, x: mpf) -> tuple[int, mpf, mpf, mpf, int]:
        """Wall, time, velocity and phase of the next impact, and how often the ball stops on the way."""
        d = self.groups.d
        after = -self.groups.restitution_at(wall) * before
        z, way, v, time, stops = wall * d / 2, -wall, after, mpf(0), 0
        while True:
            step, t = mpf(2) / STEPS, mpf(0)
            while True:
                ahead = t + step
                struck = way * (z + self.covered(ahead, v, x, way)) >= d / 2
                stopped = way * self.velocity(ahead, v, x, way) < 0
                if struck or stopped:
                    break
                t = ahead
            if stopped:
                ahead = self.root(lambda t, v=v, x=x, way=way: -way * self.velocity(t, v, x, way), t, ahead)
                struck = way * (z + self.covered(ahead, v, x, way)) >= d / 2
            if struck:
                goal = self.root(
                    lambda t, z=z, v=v, x=x, way=way: way * (z + self.covered(t, v, x, way)) - d / 2, t, ahead
                )
                return way, time + goal, self.velocity(goal, v, x, way), x + mp.pi * goal, stops
            z, x, time, v, stops = (
                z + self.covered(ahead, v, x, way),
                x + mp.pi * ahead,
                time + ahead,
                mpf(0),
                stops + 1,
            )
            pull = self.pull(x)
            if abs(pull) > self.groups.friction:
                way = 1 if pull > 0 else -1
            else:
                held, way = self.freed(x, (-1, 1))
                x, time = x + mp.pi * held, time + held


CASES = {
    "turns and sticking": (Groups(0.46, 0.28, 0.5, (), 0.15), 0.9, 0.4),
    "much friction": (Groups(0.6, 0.1, 0.6, (), 0.45), 0.8, 2.0),
    "level": (Groups(0.5, 0.0, 0.5, (), 0.2), 0.7, 0.3),
    "unlike membranes": (Groups(0.3, 0.3, Restitutions(0.7, 0.4), (), 0.05), 0.5, 5.0),
    "harmonics": (Groups(0.4, 0.3, 0.5, (Harmonic.of(2, 30.0, 100.0), Harmonic.of(3, 10.0, 0.0)), 0.2), 0.6, 1.0),
}


@pytest.mark.parametrize("case", CASES)
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
    assert find_attractor(Groups(0.5, 0.1, 0.5, (), 1.2), InFlight(0.1, 0.4, 0.0)).outcome is Outcome.HELD
    assert find_attractor(Groups(0.5, 0.1, 0.5, (), 0.95), Impact(BOTTOM, 0.0, 0.0)).outcome is Outcome.REST


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
