"""What a device comes to that is switched on, against a simulator of the tests' own, and against facts of the model.

The circles of figures 2 and 7 are what a ball from rest comes to along a sweep.
"""

from __future__ import annotations

from math import acos, ceil, pi
from pathlib import Path

import numpy as np
import pytest
from conftest import solved
from exact_friction import Reference
from exact_rest import periods
from mpmath import mp, mpf
from msgspec.structs import replace
from rest_devices import PAPER, device_of, found
from rest_simulator import outcome

from vireport import analyse, load, loads
from vireport.design.attractors_from_rest import VALUES, attractors_from_rest
from vireport.design.from_rest import Destination, StartingDevice, Target, from_rest, pressed_outcomes, started
from vireport.design.outcomes_from_rest import outcomes_at
from vireport.design.point import motions_at
from vireport.design.solution import solution_of
from vireport.design.switched_on import switched_on_at_once
from vireport.figures.captions import caption_facts
from vireport.figures.curves import simulated_points
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.attractors import attractors
from vireport.simulation.events import BOTTOM, Impact, check_model, follow_one
from vireport.simulation.kernel import RIDING, VELOCITY, WALL
from vireport.simulation.release import presses
from vireport.simulation.starts import random_starts, start_speed
from vireport.study.plan import Task
from vireport.study.study import sweep_of
from vireport.text.templates import Words


def held_against_the_own_simulator(seed: int, count: int, compiled: bool = False) -> list[str]:
    rng, kinds = np.random.default_rng(seed), []
    for _ in range(count):
        device = device_of(rng.uniform(0.1, 0.6), rng.uniform(0.05, 0.8), rng.uniform(0.3, 0.7))
        groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
        told = found(device, compiled)
        chaotic = told.destination is Destination.CHAOTIC
        expected = outcome(*groups[:3], impacts=120 if chaotic else 400) if told.decided else None
        if expected is None:
            kinds.append(told.destination if chaotic else "open")
            continue
        if told.destination is Destination.REST_CYCLE and not told.periods:
            assert expected[0] == "rest_cycle"
            kinds.append("untold")
            continue
        word = "" if "~" in told.word else told.word
        assert (told.destination, word, told.periods) == expected, groups
        kinds.append(expected[0])
    return kinds


def test_a_few_random_devices_come_to_what_an_own_simulator_finds() -> None:
    kinds = held_against_the_own_simulator(1, 8)
    assert kinds.count("open") + kinds.count("chaotic") < 4
    assert {"reaches_1_1", "rest_cycle"} <= set(kinds)


@pytest.mark.slow
def test_random_devices_come_to_what_an_own_simulator_finds() -> None:
    kinds = held_against_the_own_simulator(2, 100, compiled=True)
    assert kinds.count("open") < 10
    assert kinds.count("chaotic") < 25
    assert all(kinds.count(kind) > 12 for kind in ("reaches_1_1", "rest_cycle", "other_motion"))


@pytest.mark.parametrize(
    ("force", "destination", "periods"),
    [(2.2, "rest_cycle", 3), (3.0, "reaches_1_1", 1), (3.6, "rest_cycle", 3), (4.0, "rest_cycle", 2)],
)
def test_the_device_of_the_paper_over_its_force(force: float, destination: str, periods: int) -> None:
    told = found(PAPER.with_values({Parameter.AMPLITUDE: force}))
    assert (told.destination, told.periods) == (destination, periods)


def test_a_ball_that_is_too_heavy_rests_and_a_long_way_is_not_told_exactly() -> None:
    assert found(PAPER.with_values({Parameter.AMPLITUDE: 0.5})).destination is Destination.AT_REST
    long = found(PAPER.with_values({Parameter.AMPLITUDE: 3.0, Parameter.LENGTH: 1.25}))
    assert (long.destination, long.periods, long.word) == (Destination.REST_CYCLE, 0, "")
    assert "at irregular times" in long.name


@pytest.mark.slow
def test_a_period_that_is_not_told_is_another_one_with_the_last_bit_of_the_length() -> None:
    """At 3 N and 1.25 m a lap loses 45 digits: 103 periods or 76. One that is told stays."""

    def exactly(device: Device, digits: int) -> list[int | None]:
        d, gbar, r = map(float, device.groups(Parameter.LENGTH, device.length_m)[:3])
        return [periods(d * (1 + k * 2.0**-52), gbar, r, digits) for k in range(2)]

    long = PAPER.with_values({Parameter.AMPLITUDE: 3.0, Parameter.LENGTH: 1.25})
    exact = exactly(long, 60)
    assert exact == exactly(long, 80)
    assert None not in exact
    assert exact[0] != exact[1]
    short = PAPER.with_values({Parameter.AMPLITUDE: 2.2})
    assert exactly(short, 60) == [found(short).periods] * 2


def test_the_periods_until_settled_are_those_after_which_impacts_stay_within_a_hundredth() -> None:
    """Counted on the impacts of the simulation."""
    device = PAPER.with_values({Parameter.AMPLITUDE: 3.0, Parameter.LENGTH: 0.7})
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    motions, _, _ = motions_at(device, Parameter.LENGTH)
    phase, velocity = float(motions.phi_bottom[0]), float(motions.velocity_bottom[0])
    from vireport.simulation.events import check_model, check_start, follow_one
    from vireport.simulation.kernel import FLIGHT, PHASE, VELOCITY, WALL

    start = Impact(BOTTOM, 0.0, acos(-groups.gbar))
    rows, _ = follow_one(check_model(groups)[0], check_start(start, groups.d), 400, compiled=False)
    time = np.cumsum(rows[:, FLIGHT]) / 2
    bottom = rows[:, WALL] == BOTTOM
    far = (np.abs(rows[bottom, VELOCITY] / velocity - 1) > 0.01) | (np.abs(rows[bottom, PHASE] - phase) > 0.01)
    settled = time[bottom][np.flatnonzero(far)[-1] + 1]
    told = found(device)
    assert told.is_one_to_one
    assert told.settles_after == ceil(settled)


@pytest.mark.slow
def test_a_seventh_of_the_force_sweep_of_the_paper_is_not_reached_from_rest() -> None:
    values = np.linspace(3.0, 5.35, 2001)
    outcomes = list(outcomes_at(PAPER, Parameter.AMPLITUDE, values, True))
    missed = np.mean([not outcome.is_one_to_one for outcome in outcomes])
    assert 0.12 < missed < 0.16


def test_a_small_disturbance_is_down_to_a_hundredth_after_the_recovery() -> None:
    solution = solved("design-point")
    told = switched_on_at_once(solution).recovery
    motions, groups = solution.design.motions, solution.device.groups(Parameter.LENGTH, 0.7).as_floats()
    from vireport.simulation.events import check_model, check_start, follow_one
    from vireport.simulation.kernel import PHASE, VELOCITY, WALL

    phase, velocity = float(motions.phi_bottom[0]), float(motions.velocity_bottom[0])
    start = check_start(Impact(BOTTOM, velocity * (1 + 1e-6), phase), groups.d)
    rows, _ = follow_one(check_model(groups)[0], start, 240, compiled=False)
    bottom = rows[rows[:, WALL] == BOTTOM]
    off = np.hypot(bottom[:, VELOCITY] - velocity, bottom[:, PHASE] - phase)
    first, later = 10, 10 + round(told.periods)
    assert off[later] / off[first] == pytest.approx(0.01 ** ((later - first) / told.periods), rel=0.05)
    assert told.seconds == pytest.approx(told.periods / 2)
    assert 0 < told.error_bound < 1e-9


def test_interpreted_and_compiled_agree() -> None:
    for force in (2.2, 3.6, 4.5):
        device = PAPER.with_values({Parameter.AMPLITUDE: force})
        assert found(device).kind == found(device, True).kind


def test_a_start_beside_the_motion_reaches_it_at_once() -> None:
    solution = solved("design-point")
    motions = solution.design.motions
    groups = solution.device.groups(Parameter.LENGTH, 0.7).as_floats()
    start = (float(BOTTOM), 0.0, float(motions.velocity_bottom[0]), float(motions.phi_bottom[0]))
    told = started(start, StartingDevice(groups, Target.of(motions)), False)
    assert told.is_one_to_one
    assert told.settles_after == 0


RESTING = """
schema_version: 1
device: {capsule_mass_kg: 0.1245, restitution: 0.5, length_m: 1.1}
excitation: {amplitude_n: 2.0, frequency_hz: 2.0}
inclination_deg: 45.0
"""
"""A device without stable 1:1 motion that comes to rest every 8 periods, while a third of the starts bounce on for ever
at the bottom alone."""


def test_a_stable_motion_that_only_starts_find_is_solved_for_and_followed() -> None:
    """One impact on the bottom in 2 periods: the impact law and the flight leave (1 + r) v = 4 gbar."""
    study = analyse(loads(RESTING), ("json",))
    told = study.switched_on
    assert (told.from_rest.destination, told.motion_from_rest) == (Destination.REST_CYCLE, None)
    (motion,) = told.by_starts
    groups = study.solution.device.groups(Parameter.LENGTH, 1.1).as_floats()
    assert motion.name == "B every 2 forcing periods"
    assert motion.motion.velocity[0] == pytest.approx(4 * groups.gbar / 1.5, rel=1e-14)
    assert motion.low < 1.1 < motion.high
    data = study.to_dict()["disturbances"]
    assert data["from_rest"]["motion"] is None
    assert data["found_by_starts"][0]["velocity"] == motion.motion.velocity.tolist()
    start = Impact(BOTTOM, float(motion.motion.velocity[0]), float(motion.motion.phase[0]) + 1e-3)
    assert attractors(groups, [start])[0][0].name == motion.name
    assert any("Some starts in flight come to B every 2 forcing periods" in str(alert.cause) for alert in study.alerts)


@pytest.mark.slow
def test_of_stable_motions_that_many_starts_find_a_few_find_most() -> None:
    """At random devices without a stable 1:1 motion whose ball comes from rest to no periodic motion: each that is
    told attracts, and of those that a seventh of the starts come to few are missed."""
    rng, common, told = np.random.default_rng(11), 0, 0
    while common < 3:
        device = device_of(rng.uniform(0.1, 0.6), rng.uniform(0.05, 0.8), rng.uniform(0.3, 0.7))
        if motions_at(device, Parameter.LENGTH)[0].stable_mask.any() or found(device, True).is_motion:
            continue
        groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
        starts = random_starts(groups.d, start_speed(groups.restitution), 20, 5)
        (ends,) = attractors(groups, starts, 300, 600, workers=1)
        known = {end.name for end in ends if end.cycle is not None and not end.cycle.sticks}
        often = sum(end.name in known for end in ends) >= 3
        by_starts = switched_on_at_once(solution_of(device, None, None, True)).by_starts
        for each in by_starts:
            start = Impact(each.motion.word.walls[0], float(each.motion.velocity[0]) * (1 + 1e-7), each.motion.phase[0])
            assert attractors(groups, [start])[0][0].name == each.name
        common, told = common + often, told + (often and len(by_starts) > 0)
    assert told >= 2


def laps_in_forty_digits(groups: Groups, word: str, laps: int) -> list[list[tuple[str, float, float, int]]]:
    """Wall, phase [rad], velocity and stops before each impact of a ball that the bottom membrane releases."""
    with mp.workdps(40):
        reference = Reference(groups)
        # Friction holds it back on its way: it leaves where the force is larger than gravity and friction together.
        wall, before, x, rows = BOTTOM, mpf(0), mp.acos(-(reference.gbar + reference.friction)), []
        for _ in range(laps * len(word)):
            wall, _, before, x, stops = reference.next_impact(wall, before, x)
            rows.append(("B" if wall == BOTTOM else "T", float(x % (2 * mp.pi)), float(before), stops))
    return [rows[k : k + len(word)] for k in range(0, len(rows), len(word))]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("length_m", "amplitude_n", "inclination_deg", "restitution", "word", "stops"),
    [
        pytest.param(0.8334, 5.622, 11.09, 0.537, "BT", False, id="the 1:1 motion"),
        pytest.param(0.5790, 5.117, 18.92, 0.4193, "BT", True, id="a 1:1 motion with stops"),
        pytest.param(0.5087, 5.666, 12.89, 0.4949, "BBT", True, id="another motion"),
    ],
)
def test_from_rest_a_ball_with_friction_comes_to_what_it_does_in_forty_digits(
    length_m: float, amplitude_n: float, inclination_deg: float, restitution: float, word: str, stops: bool
) -> None:
    device = replace(
        PAPER,
        friction=0.05,
        length_m=length_m,
        amplitude_n=amplitude_n,
        inclination_deg=inclination_deg,
        restitution=restitution,
    )
    told, targets = found(device), Target.of(motions_at(device, Parameter.LENGTH)[0])
    assert (told.word, told.periods) == (word, 1)
    groups = device.groups(Parameter.LENGTH, length_m).as_floats()
    *_, before, last = laps_in_forty_digits(groups, word, told.settles_after + 8)
    assert "".join(wall for wall, *_ in last) in 2 * word
    numbers, earlier = ([row[1:3] for row in lap] for lap in (last, before))
    np.testing.assert_allclose(numbers, earlier, atol=0.01)
    assert any(count for *_, count in last) == stops
    assert len(targets) == (0 if stops else 1)
    for target in targets:
        (own,) = (row[1:3] for row in last if row[0] == "B")
        np.testing.assert_allclose(own, (target.phase % (2 * pi), target.velocity), atol=0.01)


def test_a_ball_that_rests_once_at_each_of_two_phases_of_release_goes_on_to_the_motion() -> None:
    """It rests on its way, and is let go at another phase than before: that is no motion that repeats itself."""
    device = replace(PAPER, length_m=0.96, amplitude_n=2.94, inclination_deg=30.0, restitution=0.36)
    device = replace(device, harmonics=(Harmonic.of(2, 62, 303),))
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    (target,) = Target.of(motions_at(device, Parameter.LENGTH)[0])
    assert [end.destination for _, end in pressed_outcomes(StartingDevice(groups, [target]), False)] == [
        Destination.ONE_TO_ONE
    ] * 2
    walls = []
    for press in presses(groups):
        rows, _ = follow_one(check_model(groups)[0], (1.0, 0.0, 0.0, press.release), 200, compiled=False)
        walls.append(rows[rows[:, RIDING] > 0, WALL].tolist())
        np.testing.assert_allclose(rows[rows[:, WALL] > 0][-3:, VELOCITY], target.velocity, atol=1e-6)
    assert [1.0] in walls  # the start itself is none of its rests


def test_friction_holds_a_ball_that_the_membrane_would_release() -> None:
    groups = Groups(0.4, 0.9, 0.5, (), 0.08)
    assert presses(groups)[0].release == acos(-0.98)
    assert presses(groups._replace(friction=0.11)) == []
    assert from_rest(StartingDevice(groups._replace(friction=0.11))).destination is Destination.AT_REST


EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def sweep(name: str, *changes: str):
    return sweep_of(load(EXAMPLES / f"{name}.yaml", changes).scenario)


@pytest.mark.parametrize(("name", "found"), [("inclined", 16), ("horizontal", 19), ("inclined-forcing", 14)])
def test_what_a_ball_from_rest_comes_to_is_the_stable_motion(name: str, found: int) -> None:
    along, checked = sweep(name), 0
    for met in attractors_from_rest(along):
        if not met.end.is_one_to_one:
            continue
        cycle = met.motion
        assert cycle is not None
        device = Device.of(load(EXAMPLES / f"{name}.yaml").scenario)
        device = device.with_values({DesignInput(along.parameter): met.value})
        motions = motions_at(device, along.parameter)[0]
        stable = motions.select(motions.stable_mask)
        bottom, top = cycle.wall > 0, cycle.wall < 0
        apart = np.abs(stable.velocity_bottom - cycle.velocity[bottom])
        apart += np.abs(stable.velocity_top - cycle.velocity[top])
        apart += np.abs(np.exp(1j * stable.phi_bottom) - np.exp(1j * cycle.phase[bottom]))
        assert apart.min() < 1e-9
        assert met.d == pytest.approx(stable.d[0], rel=1e-14)
        checked += 1
    assert checked >= found


def test_beyond_the_period_doubling_it_comes_to_the_doubled_motion() -> None:
    words = {met.motion and met.motion.word for met in attractors_from_rest(sweep("inclined")) if met.value < 0.628}
    assert words == {"BTBT", None}  # of which one is not settled after some 500 impacts


def test_no_motion_is_met_where_the_ball_stays_at_rest_or_goes_on_irregularly() -> None:
    resting = attractors_from_rest(
        sweep("inclined-forcing", "sweep.from=0.5", "sweep.to=0.8", "excitation.amplitude_n=0.6")
    )
    assert {met.end.destination for met in resting} == {Destination.AT_REST}
    chaotic = sweep("inclined-forcing", "excitation.amplitude_n=6.9375", "sweep.from=6.937", "sweep.to=6.938")
    ends = [met.end for met in attractors_from_rest(chaotic)]
    assert sum(end.decided for end in ends) < VALUES / 2
    assert not [met for met in resting if met.motion is not None]


@pytest.mark.parametrize("name", ["inclined", "horizontal", "inclined-forcing"])
def test_a_short_look_tells_what_following_to_the_end_tells(name: str) -> None:
    along, device = sweep(name), Device.of(load(EXAMPLES / f"{name}.yaml").scenario)
    values = np.array([met.value for met in attractors_from_rest(along)])
    ends = outcomes_at(device, DesignInput(along.parameter), values, compiled=False)
    for met, end in zip(attractors_from_rest(along), ends, strict=True):
        if met.end.decided:
            assert met.end.kind == end.kind
    assert sum(met.end.decided for met in attractors_from_rest(along)) > VALUES - 2


def test_circles_are_said_to_be_of_a_ball_from_rest_where_no_simulation_is_asked_for() -> None:
    study = analyse(load(EXAMPLES / "inclined.yaml"), ("png",))
    shown = caption_facts(study, Task.FIGURE_2, simulated_points(study))
    caption = Words("figures/sweep")("figure_2_caption", shown)
    values = sum(met.motion is not None and met.motion.word == "BT" for met in study.attractors_from_rest)
    assert f"impacts of periodic motions that a ball from rest comes to at {values} values" in caption
    asked = analyse(load(EXAMPLES / "inclined.yaml", ("simulation.samples=3", "simulation.starts=1")), ("png",))
    assert asked.attractors_from_rest == ()
    caption = Words("figures/sweep")("figure_2_caption", caption_facts(asked, Task.FIGURE_2, simulated_points(asked)))
    assert "impacts of periodic motions at 2 values" in caption


def test_without_figures_nothing_is_simulated_for_them() -> None:
    assert analyse(load(EXAMPLES / "inclined.yaml"), ("json",)).attractors_from_rest == ()
