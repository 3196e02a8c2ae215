"""Stable motions of any word beside one another: shares, the way from rest and least shocks, by simulation of its own.

`find_attractor` follows each start until it has settled, and knows nothing of the motions.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from conftest import solved
from devices import case

from vireport import analyse, loads
from vireport.design.solution import Solution
from vireport.design.switched_on import switched_on_at_once
from vireport.findings.outcomes.attracting import AttractingMotion, AttractingMotions, attracting_motions
from vireport.findings.outcomes.deviations import growth, lap_matrix
from vireport.findings.outcomes.returning import Core, Elsewhere, core_of, endings, patient
from vireport.findings.outcomes.shock import shocked
from vireport.findings.outcomes.withstood import shocks_around
from vireport.motions.atlas.families import atlas
from vireport.motions.sweep import Sweep
from vireport.motions.switching import Limits
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import Attractor, find_attractor
from vireport.simulation.events import start_of
from vireport.simulation.release import presses
from vireport.simulation.starts import random_starts, start_speed

pytest.importorskip("numba")


def groups_of(solution: Solution) -> Groups[float]:
    return solution.device.groups(Parameter.LENGTH, solution.device.length_m).as_floats()


def found_at(name: str, **over: object) -> tuple[Solution, AttractingMotions]:
    solution = solved(name, **over)
    found = attracting_motions(solution, switched_on_at_once(solution))
    assert found is not None
    return solution, found


@cache
def two_words() -> tuple[Solution, AttractingMotions]:
    """A device with a stable motion BBT beside one BBBT, each with an unstable one between them."""
    solution = solved("hysteresis", device__length_m=0.225, sweep__from=0.224, sweep__to=0.226, simulation=None)
    families = atlas(Sweep(solution.device, Parameter.LENGTH, 0.224, 0.226), Limits(4, 1))
    found = attracting_motions(solution, switched_on_at_once(solution), families)
    assert found is not None
    return solution, found


def is_at(motion: Motion, end: Attractor) -> bool:
    """Whether what a start came to is a motion, and no other of its word."""
    if end.cycle is None or end.cycle.sticks or len(end.cycle.wall) != len(motion.word):
        return False
    apart = np.abs(np.exp(1j * end.cycle.phase[:, None]) - np.exp(1j * motion.phase))
    near = (apart < 1e-3) & (np.abs(end.cycle.velocity[:, None] - motion.velocity) < 1e-3)
    return bool(near.any(axis=1).all())


def share_by_simulation(solution: Solution, each: AttractingMotion, count: int = 250) -> float:
    groups = groups_of(solution)
    fastest = max(float(np.abs(each.motion.velocity).max()) if each.motion is not None else 0.0, 0.0)
    starts = random_starts(groups.d, start_speed(groups.restitution, fastest), count, 77)[0]
    ends = [find_attractor(groups, start_of(row), 4000, compiled=True) for row in starts]
    return float(np.mean([is_at(each.motion, end) for end in ends]))


@pytest.mark.slow
def test_shares_of_a_motion_and_a_rest_cycle_are_those_of_starts_simulated_one_by_one() -> None:
    """At 3.6 N and 0.75 m the device comes from rest to a rest cycle, though most random starts reach 1:1 motion."""
    solution, found = found_at("inclined", device__length_m=0.75, excitation__amplitude_n=3.6)
    moving, resting = found.motions
    assert (moving.from_rest, resting.from_rest) == (False, True)
    assert resting.motion is resting.shock is None
    assert resting.name == "rest every 3 forcing periods (B~)"
    simulated = share_by_simulation(solution, moving)
    assert abs(moving.share - simulated) < 4 * np.sqrt(simulated * (1 - simulated) / 250)
    assert moving.share + resting.share + found.others == pytest.approx(1)
    assert moving.shock.jump * found.velocity_unit == pytest.approx(0.1693971999264 * 3.6 / (2 * 0.1245 * 2), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("device", "harmonic"),
    [
        ({"force": 5.13, "length": 0.43, "inclination": 30, "r": 0.44}, (91, 70)),
        ({"force": 2.75, "length": 0.89, "inclination": 10, "r": 0.29}, (93, 26)),
    ],
)
def test_balls_that_a_force_with_harmonics_releases_at_two_phases_have_two_futures(device, harmonic) -> None:
    groups, (motion,), _, _ = case(**device, harmonics=(Harmonic.of(2, *harmonic),))
    rows = np.zeros((2, 4))
    rows[:, 0], rows[:, 3] = 1, [press.release - 0.01 for press in presses(groups)]
    told = endings(groups, rows, [core_of(groups, motion)]).tolist()
    ends = [find_attractor(groups, start_of(row)) for row in rows]
    assert [is_at(motion, end) for end in ends] == [True, False]
    assert ends[1].cycle is not None
    assert ends[1].cycle.sticks
    assert told == [0, Elsewhere.RESTS]


@pytest.mark.slow
def test_of_two_mirror_images_one_is_reached_from_rest_and_both_have_one_least_shock() -> None:
    solution, found = found_at("horizontal", device__length_m=0.36)
    first, second = found.motions
    assert first.from_rest is not second.from_rest
    end = find_attractor(groups_of(solution), start_of(np.array([1.0, 0.0, 0.0, np.pi / 2])), 4000, compiled=True)
    reached = first if first.from_rest else second
    assert is_at(reached.motion, end)
    assert first.shock.jump == pytest.approx(second.shock.jump, rel=1e-9)
    assert first.share == pytest.approx(second.share, abs=4 * np.sqrt(0.5 / found.starts))


@pytest.mark.slow
def test_a_start_that_passes_next_to_an_unstable_motion_is_waited_for() -> None:
    groups, stable, unstable, _ = case()
    (core,) = patient(groups, [Core(stable[0], np.empty((2, 2, 2)), 0.0, 1)], unstable)
    slowest = min(growth(lap_matrix(groups, motion)) for motion in unstable)
    assert 1e9 <= slowest ** (core.patience / 2) < 1e9 * slowest  # two impacts a period, from 1e-9 away


def test_next_to_a_critical_point_no_share_is_told() -> None:
    """At 5.348 N, B1 being at 5.34924 N."""
    _, found = found_at("inclined", device__length_m=0.75, excitation__amplitude_n=5.348)
    (only,) = [each for each in found.motions if each.motion is not None]
    assert only.share is only.shock is found.others is None
    assert "so near a point where it becomes unstable" in only.unknown
    assert only.from_rest


def test_of_a_capsule_that_lies_flat_the_motions_at_rest_have_no_part() -> None:
    """A ball that stays at one membrane has no impacts left there, and the map no derivative at such a motion."""
    swept = {"sweep__parameter": "inclination_deg", "sweep__from": 0.0, "sweep__to": 40.0}
    solution = solved("horizontal", simulation=None, **swept)
    families = atlas(Sweep(solution.device, Parameter.INCLINATION, 0.0, 40.0), Limits(1, 1))
    assert [motion.word.letters for _, motion in families.at(0.0)] == ["B"]
    found = attracting_motions(solution, switched_on_at_once(solution), families)
    assert found is not None
    assert [(each.name, each.share) for each in found.motions] == [("BT every forcing period", 1.0)]


def test_a_motion_of_another_word_that_is_reached_from_rest_stands_there_without_families() -> None:
    solution, found = found_at("inclined", device__length_m=0.3)
    (only,) = found.motions
    assert (only.name, only.from_rest, only.share) == ("BBT every forcing period", True, 1.0)
    assert only.shock.jump is None
    assert found.withstood(found.motions_from_rest).searched_to_m_s == only.shock.searched_to * found.velocity_unit
    plane, _ = shocks_around(groups_of(solution), found.recognised, only.shock)
    assert plane.share(0) == 1


@pytest.mark.slow
def test_of_two_words_each_has_its_share_and_is_reached_as_the_simulation_says() -> None:
    """From rest it is the one of four impacts; of random starts some two thirds."""
    solution, found = two_words()
    assert {each.name: each.from_rest for each in found.motions} == {
        "BBT every forcing period": False,
        "BBBT every forcing period": True,
    }
    assert found.others == 0
    for each in found.motions:
        simulated = share_by_simulation(solution, each)
        assert abs(each.share - simulated) < 4 * np.sqrt(simulated * (1 - simulated) / 250)
    end = find_attractor(groups_of(solution), start_of(np.array([1.0, 0.0, 0.0, np.pi / 2])), 4000, compiled=True)
    assert end.word == "BBBT"


@pytest.mark.slow
def test_the_least_shock_of_a_word_is_found_two_ways_and_no_smaller_one_leads_out() -> None:
    solution, found = two_words()
    groups, rng = groups_of(solution), np.random.default_rng(5)
    cores = [core_of(groups, each.motion, compiled=True) for each in found.motions]
    for k, each in enumerate(found.motions):
        shock, other = each.shock, found.motions[1 - k]
        assert shock.companion is not None  # an unstable motion of the families, on whose stable manifold the edge lies
        assert shock.jump == pytest.approx(shock.by_search, rel=1e-9)
        assert shock.leads_to.name == other.name
        durations = np.diff(np.append(each.motion.time, each.motion.time[0] + 2 * each.motion.word.periods))
        for impact, duration in enumerate(durations):
            delay = duration * rng.random(1500) * (1 - 1e-9)
            jump = shock.jump * (1 - 1e-9) * rng.uniform(-1, 1, 1500)
            assert (endings(groups, shocked(groups, each.motion, impact, delay, jump), cores) == k).all()
        delay, jump = np.array([shock.delay]), np.array([shock.sign * shock.jump * (1 + 1e-6)])
        assert endings(groups, shocked(groups, each.motion, shock.impact, delay, jump), cores)[0] == 1 - k


WORDS = """\
schema_version: 1
device: {{capsule_mass_kg: 0.1245, restitution: 0.5, length_m: 0.225}}
excitation: {{amplitude_n: 5.0, frequency_hz: 2.5}}
inclination_deg: 30.0
sweep: {{parameter: length_m, from: 0.224, to: 0.226}}
motions: {{impacts: 4, periods: 1}}
disturbances: {{}}
requirements: {{words: {words}, survives_shock_m_s: 0.03}}
"""


@pytest.mark.slow
def test_a_shock_that_must_be_survived_is_that_of_the_motions_whose_words_are_required() -> None:
    """A search for the best design judges by it as well, though it shows nothing."""
    for words, formats, passed in ((["BBBT"], ("json",), True), (["BBT", "BBBT"], (), False)):
        study = analyse(loads(WORDS.format(words=str(words).replace("'", ""))), formats)
        motions, unit = (
            study.outcomes.attracting.motions,
            study.outcomes.attracting.velocity_unit,
        )
        own = [each for each in motions if each.motion.word.letters in words]
        shock, word = (next(x for x in study.criteria if x.key == key) for key in ("survives_shock_m_s", "word"))
        assert shock.passed is passed
        assert shock.outcome.value == min(each.shock.jump * unit for each in own)
        told = "so do" if all(each.from_rest for each in own) or len(own) == 2 else f"to {words[0]} come"
        assert f"{told} {100 * sum(each.share for each in own):.0f} % of 2000 random starts" in str(word.outcome.why)
