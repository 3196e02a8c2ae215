"""Attractors: what is called periodic is an orbit with a residual, however slow the approach to it."""

from __future__ import annotations

from math import inf, log, pi, radians, sin

import numpy as np
import pytest

from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups
from vireport.physics.motion import multipliers
from vireport.simulation import cycles
from vireport.simulation.attractors import SETTLED, Outcome, attractors, diagram, find_attractor
from vireport.simulation.cycles import (
    exponent,
    jacobians,
    product,
    refine,
    word_of,
)
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
from vireport.simulation.kernel import FLIGHT, PHASE, REST, RIDING, RUNNING, SETTLING, VELOCITY, WALL
from vireport.simulation.release import presses

INCLINED = 0.1245 * 9.8 * sin(radians(45)) / 3
CHAOS = (0.2545, 0.3, 0.5)
STARTS = [Impact(BOTTOM, 0.7, 0.2), Impact(BOTTOM, 0.3, 2.0), Impact(TOP, -0.5, 4.0), InFlight(0.0, 0.4, 1.0)]
# Period doubling at 45 degrees and 3 N, and pitchfork of the horizontal device, in 40-digit arithmetic.
DOUBLING, PITCHFORK = 0.4179595416, 0.2634315843


def trajectory(model, start, impacts):
    return follow_one(check_model(Groups(*model))[0], check_start(start, model[0]), impacts)[0]


def test_the_period_four_orbit_of_figure_3gh() -> None:
    d, g = 0.2545, 0.1245 * 9.8 * sin(radians(45)) / 5.87
    for start in STARTS:
        attractor = find_attractor(Groups(d, g, 0.5), start)
        assert (attractor.outcome, attractor.word, attractor.period) == (Outcome.PERIODIC, "BTBT", 2)
        cycle = attractor.cycle
        assert cycle is not None
        assert cycle.velocity[0] == pytest.approx(0.71495891, abs=0.6e-8)
        assert cycle.phase[0] == pytest.approx(0.23548277, abs=0.6e-8)
        assert np.round(np.roll(cycle.flight, -1), 4).tolist() == [1.2131, 0.7495, 1.4245, 0.6129]
        assert cycle.residual < 1e-14
        assert attractor.lyapunov == pytest.approx(log(0.08597951) / 2, abs=1e-6)


@pytest.mark.parametrize(("away", "word"), [(1e-3, "BT"), (1e-5, "BT"), (-1e-5, "BTBT"), (-1e-3, "BTBT")])
def test_near_a_period_doubling_the_transient_is_as_long_as_it_must_be(away: float, word: str) -> None:
    attractor = find_attractor(Groups(DOUBLING + away, INCLINED, 0.5), Impact(BOTTOM, 0.9, 0.6), budget=2_000_000)
    assert (attractor.outcome, attractor.word) == (Outcome.PERIODIC, word)
    assert attractor.distance <= SETTLED
    assert attractor.cycle is not None
    assert attractor.cycle.residual < 1e-14
    rate = abs(attractor.cycle.multipliers[0])
    assert rate == pytest.approx(1 - abs(away) * (3.756 if away > 0 else 15.03), abs=5 * abs(away) ** 1.4)
    if abs(away) < 1e-4:
        needed = log(1e-4 / SETTLED) / -log(rate) * len(word)
        assert needed / 2 < attractor.impacts < 10 * needed


def test_a_transient_cut_by_the_budget_is_reported_with_its_distance() -> None:
    attractor = find_attractor(Groups(DOUBLING + 1e-6, INCLINED, 0.5), Impact(BOTTOM, 0.9, 0.6), budget=400_000)
    assert (attractor.outcome, attractor.word, attractor.impacts) == (Outcome.PERIODIC, "BT", 400_000)
    assert SETTLED < attractor.distance < 1e-2


def test_the_pitchfork_has_two_mirror_orbits() -> None:
    pair = [find_attractor(Groups(PITCHFORK - 1e-4, 0.0, 0.5), start).cycle for start in STARTS[:2]]
    assert pair[0] is not None
    assert pair[1] is not None
    assert pair[0].word == pair[1].word == "BT"
    assert pair[0].flight == pytest.approx(pair[1].flight[::-1], abs=1e-12)
    assert abs(pair[0].flight[0] - 1) > 0.01
    assert pair[0].velocity == pytest.approx(-pair[1].velocity[::-1], abs=1e-12)


def test_an_unstable_orbit_is_not_an_attractor() -> None:
    """Started on the 1:1 orbit below its period doubling, the motion leaves it for the doubled one."""
    d = DOUBLING - 0.01
    model = check_model(Groups(d, INCLINED, 0.5))[0]
    doubled = find_attractor(Groups(d, INCLINED, 0.5), STARTS[0]).cycle
    assert doubled is not None
    middle = np.array([[1.0, doubled.phase[::2].mean(), 0.0, doubled.velocity[::2].mean(), 0.0, 0.0]])
    single = refine(model, np.repeat(middle, 3, axis=0), 2)
    assert single is not None
    assert (single.word, single.growth > 1) == ("BT", True)
    start = Impact(BOTTOM, float(single.velocity[0]), float(single.phase[0]))
    assert find_attractor(Groups(d, INCLINED, 0.5), start).word == "BTBT"


def test_twice_round_is_not_twice_the_period() -> None:
    model = check_model(Groups(0.4604, INCLINED, 0.5))[0]
    rows = trajectory((0.4604, INCLINED, 0.5), Impact(BOTTOM, 1.0, 0.5), 400)
    cycle = refine(model, rows, 6)
    assert cycle is not None
    assert (cycle.word, cycle.period) == ("BT", 1)


def test_chaos_has_a_positive_exponent_and_no_word() -> None:
    attractor = find_attractor(Groups(*CHAOS), STARTS[0], budget=50_000)
    assert (attractor.outcome, attractor.word, attractor.period, attractor.cycle) == (Outcome.APERIODIC, "", 0, None)
    assert attractor.impacts == 50_000
    assert attractor.distance == inf
    assert attractor.lyapunov > 0.1


def test_exponent_is_the_growth_of_a_small_difference() -> None:
    """Two trajectories side by side, drawn together again at every impact, against the Jacobians' product."""
    model = check_model(Groups(*CHAOS))[0]
    rows = trajectory(CHAOS, STARTS[0], 3000)
    apart, growth = np.array([1e-7, 0.0]), 0.0
    for i in range(2000, 3000):
        wall, z, velocity, phase = as_start(rows[i])
        lap = follow_one(model, (wall, z, velocity + apart[1], phase + apart[0]), 1)[0][1]
        apart = np.array(
            [(lap[PHASE] - rows[i + 1, PHASE] + pi) % (2 * pi) - pi, lap[VELOCITY] - rows[i + 1, VELOCITY]]
        )
        size = np.abs(apart).max()
        if lap[WALL] != rows[i + 1, WALL] or size > 1e-3:  # on two sides of a graze: begin anew
            apart = np.array([1e-7, 0.0])
            continue
        growth += log(size / 1e-7)
        apart *= 1e-7 / size
    span = rows[2001:3001, cycles.FLIGHT].sum() / 2
    assert exponent(model, rows[2000:3001]) == pytest.approx(growth / span, abs=0.05)


def test_jacobians_are_the_derivatives_of_the_map() -> None:
    model = check_model(Groups(*CHAOS))[0]
    rows = trajectory(CHAOS, STARTS[2], 300)
    exact = jacobians(model, rows[:-1], rows[1:])
    checked, step = 0, 1e-6
    for i in range(100, 300):
        if abs(rows[i + 1, VELOCITY]) < 0.2:
            continue
        columns = []
        for dp, dv in ((step, 0.0), (0.0, step)):
            ends = []
            for sign in (1, -1):
                wall, z, velocity, phase = as_start(rows[i])
                ends.append(follow_one(model, (wall, z, velocity + sign * dv, phase + sign * dp), 1)[0][1])
            if ends[0][WALL] == ends[1][WALL] == rows[i + 1, WALL]:
                columns.append((ends[0] - ends[1])[[PHASE, VELOCITY]] / (2 * step))
        if len(columns) == 2 and abs(columns[0][0]) < 100:
            checked += 1
            assert np.abs(np.array(columns).T - exact[i]).max() < 1e-6 * (1 + np.abs(exact[i]).max())
    assert checked > 100


def test_area_shrinks_by_the_square_of_r_and_is_kept_without_loss() -> None:
    for r in (1.0, 0.7):
        model = check_model(Groups(0.3, 0.2, r))[0]
        rows = follow_one(model, check_start(Impact(BOTTOM, 0.8, 0.3), 0.3), 200_000)[0]
        v = np.abs(rows[:, VELOCITY])
        fine = (v[1:] > 1e-2) & (v[:-1] > 1e-2) & (rows[:-1, RIDING] + rows[:-1, SETTLING] == 0)
        (a, b), (c, d) = np.moveaxis(jacobians(model, rows[:-1], rows[1:]), 0, -1)
        determinant = a * d - b * c
        # In phase and energy, v dv: what r takes is r^2 an impact, and nothing else.
        area = determinant * rows[1:, VELOCITY] / rows[:-1, VELOCITY]
        assert fine.sum() > 100_000
        assert np.abs(area[fine] / (r * r) - 1).max() < 1e-9


@pytest.mark.parametrize("word", ["BT", "BTBT", "BBT"])
def test_determinant_of_a_cycle_is_a_power_of_r(word: str) -> None:
    d, g = {"BT": (0.4604, INCLINED), "BTBT": (0.41, INCLINED), "BBT": (0.2, 0.3)}[word]
    attractor = find_attractor(Groups(d, g, 0.5), STARTS[0])
    assert attractor.word == word
    cycle = attractor.cycle
    assert cycle is not None
    model = check_model(Groups(d, g, 0.5))[0]
    lap = follow_one(model, (float(cycle.wall[0]), 0.0, cycle.velocity[0], cycle.phase[0]), len(word))[0]
    matrix, scale = product(jacobians(model, lap[:-1], lap[1:]))
    matrix = matrix * np.exp(scale)
    assert np.linalg.det(matrix) == pytest.approx(0.5 ** (2 * len(word)), rel=1e-10)
    assert sorted(map(abs, cycle.multipliers)) == pytest.approx(sorted(np.abs(np.linalg.eigvals(matrix))), rel=1e-6)


def test_ends_of_every_kind() -> None:
    kinds = {
        Outcome.REST: (0.5, 1.2, 0.5, STARTS[0]),
        Outcome.FREE: (3.0, 0.0, 0.5, InFlight(0.0, 0.0, 0.0)),
        Outcome.STICKING: (0.06, INCLINED, 0.5, STARTS[0]),
        Outcome.PERIODIC: (0.4604, INCLINED, 0.5, STARTS[0]),
        Outcome.APERIODIC: (*CHAOS, STARTS[0]),
    }
    ends = {outcome: find_attractor(Groups(*groups), start, budget=3000) for outcome, (*groups, start) in kinds.items()}
    assert all(end.outcome is outcome for outcome, end in ends.items())
    exponent = {outcome: end.lyapunov for outcome, end in ends.items()}
    assert exponent[Outcome.REST] == exponent[Outcome.STICKING] == -np.inf
    assert -np.inf < exponent[Outcome.PERIODIC] < 0 < exponent[Outcome.APERIODIC] < np.inf
    assert np.isnan(exponent[Outcome.FREE])
    assert ends[Outcome.APERIODIC].distance == np.inf
    assert all(end.distance < 1e-8 for outcome, end in ends.items() if outcome is not Outcome.APERIODIC)


@pytest.mark.slow
def test_what_sticks_again_is_periodic_though_its_cycle_may_not_be_told() -> None:
    """A release is always the same; the cycle from one to the next is computed only if rounding stays small."""
    rng = np.random.default_rng(0)
    kinds = []
    for d, g in zip(rng.uniform(0.03, 0.45, 150), rng.uniform(0.4, 0.75, 150), strict=True):
        attractor = find_attractor(Groups(d, g, 0.7), STARTS[0], budget=8000)
        rows = trajectory((d, g, 0.7), STARTS[0], 8000)
        rides = (rows[rows[:, RIDING] > 0, WALL] == BOTTOM).sum()
        if attractor.outcome is Outcome.STICKING and attractor.cycle is None:
            assert len(attractor.last)
        elif attractor.cycle is not None and attractor.outcome is Outcome.STICKING:
            assert attractor.cycle.sticks
            assert attractor.cycle.residual < cycles.LAP_TOL
            # What comes after a release comes after every release.
            lap = np.flatnonzero(rows[:, RIDING] > 0)[-1]
            assert attractor.cycle.distance(rows[lap]) == 0.0
        kinds.append((attractor.outcome, bool(rides > 1), bool(attractor.cycle), len(attractor.word) > 20))
    assert kinds.count((Outcome.STICKING, True, False, False)) > 5
    assert kinds.count((Outcome.STICKING, True, True, False)) > 20
    assert kinds.count((Outcome.STICKING, True, True, True)) > 1


def test_a_rest_cycle_of_many_periods_is_no_chaos() -> None:
    """At 1.25 m, 3 N and 45 degrees the ball rests every 41 periods: as switching on has it."""
    d, gbar = 1.25 * 0.1245 * 16 / 3, 0.1245 * 9.8 * np.sin(np.pi / 4) / 3
    for velocity in (0.5, 0.7, 1.0):
        attractor = find_attractor(Groups(d, gbar, 0.5), InFlight(0.0, velocity, 1.0))
        assert (attractor.outcome, attractor.cycle) == (Outcome.STICKING, None)


@pytest.mark.parametrize(
    ("gbar", "r", "sine", "word", "period"), [(0.2, 0.2, 1.0, "B~B~", 3), (0.1, 0.1, -0.8, "BBBB~B~", 6)]
)
def test_a_ball_released_at_two_phases_by_turns_rests_twice_in_its_period(gbar, r, sine, word, period) -> None:
    """A force with a strong second harmonic presses the ball down, and lets it go, twice a forcing period."""
    groups = Groups(1.0, gbar, r, (Harmonic(2, 0.0, sine),))
    for press in presses(groups):
        attractor = find_attractor(groups, Impact(BOTTOM, 0.0, press.release), compiled=False)
        assert (attractor.outcome, attractor.word, attractor.period) == (Outcome.STICKING, word, period)
        cycle = attractor.cycle
        assert cycle is not None
        # A lap from one release to the next in the other state would take a part of a forcing period.
        lap = cycle.impacts[:, [FLIGHT, SETTLING, RIDING]].sum()
        assert lap == pytest.approx(2 * period, abs=1e-12)


@pytest.mark.parametrize(
    ("velocities", "rides", "word"),
    [
        ([3, -3, -2, 1], [], "BTTB"),
        ([3, 2, 1, -3], [2], "B~T"),
        ([2, 3, 1, -3], [2], "BB~T"),
        ([-3, 3, 2, -3, -2], [2, 4], "TB~T~"),
        ([3, 2, 1, 0.5], [1, 3], "B~B~"),
    ],
)
def test_words(velocities, rides, word: str) -> None:
    rows = np.zeros((len(velocities), 6))
    rows[:, WALL], rows[:, VELOCITY] = np.sign(velocities), velocities
    rows[rides, RIDING] = 0.1
    assert "".join(word_of(rows)) == word


@pytest.mark.parametrize(
    ("trace", "determinant"),
    [(3.0, 1e-12), (-3.0, 1e-12), (0.1, 0.06), (0.0, 0.0), (-0.5, 0.0625), (2.0, 1.0)],
)
def test_multipliers_solve_their_polynomial(trace: float, determinant: float) -> None:
    larger, smaller = multipliers(trace, determinant)
    assert abs(larger) >= abs(smaller) * (1 - 1e-15)
    assert larger + smaller == pytest.approx(trace, abs=1e-15)
    assert larger * smaller == pytest.approx(determinant, rel=1e-14, abs=1e-300)


def test_product_keeps_order_and_size() -> None:
    rng = np.random.default_rng(3)
    chain = rng.normal(size=(301, 2, 2))
    expected, scale = np.eye(2), 0.0
    for matrix in chain:
        expected = matrix @ expected
        size = np.abs(expected).max()
        expected, scale = expected / size, scale + log(size)
    matrix, logarithm = product(chain)
    assert matrix == pytest.approx(expected, abs=1e-12)
    assert logarithm == pytest.approx(scale, rel=1e-13)
    chain[150] = 0.0
    assert product(chain)[1] == -inf


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    model = check_model(Groups(np.repeat(np.linspace(0.05, 0.6, 41), len(STARTS)), INCLINED, 0.5))
    starts = np.array([check_start(STARTS[i % len(STARTS)], d) for i, d in enumerate(model[:, 0])])
    alone, two, five = (follow_impacts(model, starts, 300, 20, workers=count) for count in (1, 2, 5))
    for rows, summary in (two, five):
        assert np.array_equal(rows, alone[0], equal_nan=True)
        assert np.array_equal(summary, alone[1])
    single = follow_impacts(model[30:31], starts[30:31], 300, 20)[0]
    assert np.array_equal(single[0], alone[0][30])


def test_trajectories_that_end_early_say_so() -> None:
    model = check_model(Groups([0.5, 0.5], [1.3, 0.2], 0.5))
    rows, summary = follow_impacts(model, np.array([check_start(STARTS[0], 0.5)] * 2), 200, keep=50)
    assert summary[:, 2].tolist() == [REST, RUNNING]
    assert summary[0, 0] < 100
    assert np.isfinite(rows[1]).all()


def test_many_attractors_are_those_found_one_by_one() -> None:
    d = np.linspace(0.1, 0.5, 9)
    together = attractors(Groups(d, INCLINED, 0.5), STARTS, impacts=600)
    for row, value in zip(together, d, strict=True):
        for attractor, start in zip(row, STARTS, strict=True):
            alone = find_attractor(Groups(float(value), INCLINED, 0.5), start, budget=20_000)
            assert (attractor.outcome, attractor.word, attractor.period) == (alone.outcome, alone.word, alone.period)


def test_equal_cycles_are_one_object_and_mirror_images_are_two() -> None:
    start, mirrored = Impact(BOTTOM, 0.7, 0.2), Impact(TOP, -0.7, 0.2 + pi)
    (row,) = attractors(Groups([PITCHFORK - 0.03], 0.0, 0.5), [start, mirrored, Impact(BOTTOM, 0.71, 0.2)])
    cycle, image, again = (end.cycle for end in row)
    assert again is cycle
    assert cycle.word == image.word == "BT"
    assert image.flight == pytest.approx(cycle.flight[::-1], abs=1e-12)
    assert abs(cycle.flight[0] - 1) > 0.1


def test_a_diagram_shows_cycles_once_and_names_them() -> None:
    d = np.array([0.2545, 0.4604, 0.06])
    g = [CHAOS[1], INCLINED, INCLINED]
    shown = diagram(attractors(Groups(d, g, 0.5), STARTS))
    names = [{shown.labels[k] for k in shown.label[shown.index == i]} for i in range(3)]
    assert names == [{Outcome.APERIODIC.value}, {"BT"}, {"B~T"}]
    assert (shown.index == 0).sum() == 64 * len(STARTS)
    assert (shown.index == 1).sum() == 2
    bottom = (shown.index == 1) & (shown.wall == BOTTOM)
    assert shown.velocity[bottom] == pytest.approx([1.00400474], abs=1e-8)


def test_a_diagram_does_not_mistake_a_slow_approach_for_a_longer_period() -> None:
    d = DOUBLING + np.array([1e-3, 3e-4, 1e-4])
    shown = diagram(attractors(Groups(d, INCLINED, 0.5), [Impact(BOTTOM, 0.9, 0.6)]))
    assert shown.labels == ("BT",)
    assert len(shown.index) == 2 * len(d)


def test_an_empty_list_of_starts_is_refused() -> None:
    with pytest.raises(ValueError, match="start"):
        attractors(Groups(0.4, 0.2, 0.5), [], 10)


def test_flights_that_lose_the_forcing_phase_are_not_called_chaotic() -> None:
    """Through d = 1e13 a ball flies some 1e13 t_c, after which rounding leaves nothing of the phase."""
    attractor = find_attractor(Groups(1e13, 0.0, 0.5), InFlight(0.0, 0.8, 1.0))
    assert (attractor.outcome, attractor.cycle) == (Outcome.UNRESOLVED, None)
    assert find_attractor(Groups(1e3, 0.0, 0.5), InFlight(0.0, 0.8, 1.0)).outcome is not Outcome.UNRESOLVED


def test_impacts_within_a_moment_are_no_periodic_motion() -> None:
    """Between membranes hardly apart a lap takes no time, so that nothing changes in it: it is not a period."""
    d, r = 1e-20, 1.0
    rows = trajectory((d, 0.0, r), Impact(BOTTOM, 0.5, 1.0), 60)
    assert cycles.recurrences(rows)
    assert all(refine(check_model(Groups(d, 0.0, r))[0], rows, length) is None for length in cycles.recurrences(rows))
    assert find_attractor(Groups(d, 0.0, r), Impact(BOTTOM, 0.5, 1.0), budget=2000).outcome is Outcome.APERIODIC


def test_a_slow_spiral_into_a_cycle_is_on_its_way() -> None:
    """At r = 1 - 1e-6 a motion is approached by 2e-6 in a period while it is circled: it cannot be waited for."""
    phase, velocity = 1.1037086014e-06, 0.7026427185643835
    attractor = find_attractor(Groups(0.5, 0.0, 0.999999), Impact(BOTTOM, velocity * (1 + 1e-6), phase))
    assert (attractor.outcome, attractor.word, attractor.period) == (Outcome.PERIODIC, "BT", 1)
    assert SETTLED < attractor.distance < 1e-5


def test_the_jacobian_of_a_flight_of_any_length_is_finite() -> None:
    rows = trajectory((1e60, 0.0, 0.5), InFlight(0.0, 1.0, 0.3), 3)
    assert rows[1:, 2].min() > 1e50
    assert np.isfinite(jacobians(check_model(Groups(1e60, 0.0, 0.5))[0], rows[:-1], rows[1:])).all()
