"""Families from a word and a value that a user gives: the motions there against other searches and the simulation."""

from __future__ import annotations

from functools import cache

import pytest
from conftest import EXAMPLES, first
from exact import printed_maps
from mpmath import mp, mpf

from vireport.base.errors import ScenarioError, UsageError
from vireport.map.chart.over import chart_of
from vireport.motions.atlas.families import atlas
from vireport.motions.atlas.guesses import motions_of
from vireport.motions.periodicity import Model, model_of
from vireport.motions.sweep import Sweep
from vireport.motions.switching import Limits
from vireport.physics.device import Device
from vireport.physics.motion import Motion
from vireport.physics.numbers import ARRAYS
from vireport.physics.word import Word
from vireport.scenario.loading import load
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import attractors
from vireport.simulation.starts import random_starts, start_speed
from vireport.study.plan import Task
from vireport.study.study import analyse

HARMONIC = {"order": 3, "percent": 1.0, "phase_deg": 40.0}


def swept(low: float, high: float, **more: object) -> Sweep:
    loaded = load(EXAMPLES / "inclined.yaml", {"sweep": None, "device.length_m": 0.5} | more)
    return Sweep(Device.of(loaded.scenario), Parameter.LENGTH, low, high)


def found(sweep: Sweep, letters: str, periods: int, value: float) -> list[Motion]:
    low, high = map(float, sweep.coordinate_range)
    return motions_of(Word.of(letters, periods), model(sweep), low, high, float(sweep.coordinate_of(value)))


def model(sweep: Sweep) -> Model:
    return model_of(sweep, ARRAYS)


def matched(ours: list[Motion], others: list[Motion], mirror: bool = False) -> bool:
    """Whether two lists hold the same motions."""
    near = [[one.distance(other, mirror=mirror) < 1e-7 for other in others] for one in ours]
    return len(ours) == len(others) and all(sum(row) == 1 for row in near)


@cache
def known(value: float, inclination: float) -> tuple[Sweep, list[Motion]]:
    """Every motion of up to three impacts, by exclusion over all flight times."""
    sweep = swept(value - 0.01, value + 0.01, inclination_deg=inclination)
    return sweep, [motion for _, motion in atlas(sweep, Limits(3, 2)).at(value)]


@pytest.mark.parametrize(
    ("letters", "periods", "value", "inclination"),
    first(0, [("BT", 1, 0.5, 45.0), ("BBT", 2, 0.5, 45.0), ("BBT", 1, 0.26, 10.0)], unpacked=True),
)
def test_it_finds_the_motions_that_exclusion_over_all_flight_times_finds(letters, periods, value, inclination) -> None:
    sweep, every = known(value, inclination)
    word = Word.of(letters, periods).canonical()
    others = [motion for motion in every if motion.word.canonical() == word]
    assert others
    assert matched(found(sweep, letters, periods, value), others)


@pytest.mark.slow
@pytest.mark.parametrize("letters", ["BBT", "TBB"])
def test_what_it_finds_solves_the_printed_maps_in_40_digits(letters: str) -> None:
    sweep, _ = known(0.5, 45.0)
    motions = found(sweep, letters, 2, 0.5)
    assert motions
    groups = model(sweep).groups(motions[0].coordinate)
    with mp.workdps(40):
        for motion in motions:
            x = list(map(mpf, (*motion.velocity.tolist(), *motion.time.tolist())))
            residual = printed_maps(motion.word, x, mpf(float(groups.d)), mpf(float(groups.gbar)), mpf("0.5"))
            assert max(map(abs, residual)) < 1e-12


@pytest.mark.slow
def test_a_stable_motion_of_eight_impacts_is_that_of_the_simulation() -> None:
    sweep = swept(0.09, 0.11, inclination_deg=0.0)
    groups = model(sweep).groups(float(sweep.coordinate_of(0.1))).as_floats()
    (ends,) = attractors(groups, random_starts(groups.d, start_speed(groups.restitution), 8, 1), 3000)
    simulated = ends[0].cycle.motion(float(sweep.coordinate_of(0.1))).canonical()
    assert simulated.word.letters == "BBTTBBTT"
    motions = found(sweep, "BBTTBBTT", 2, 0.1)
    assert min(motion.distance(simulated, mirror=True) for motion in motions) < 1e-6
    assert all(motion.primitive() is motion for motion in motions)


def with_starts(*rows: dict[str, object], **more: object):
    changed = {"sweep.from": 0.45, "sweep.to": 0.55, "device.length_m": 0.5, "motions": {"starts": list(rows)}}
    return load(EXAMPLES / "inclined.yaml", changed | more)


@pytest.mark.slow
def test_a_family_of_a_distorted_force_is_followed_from_a_word_and_a_value() -> None:
    """It joins no 1:1 motion along the sweep; the search of words comes to the same family by itself."""
    more = {"excitation.harmonics": [HARMONIC], "motions.impacts": 3, "motions.periods": 2}
    more |= {"sweep.from": 0.49, "sweep.to": 0.51}
    study = analyse(with_starts({"word": "BBT", "value": 0.5, "periods": 2}, **more), (Task.JSON,))
    at = [family for family, _ in study.atlas.at(0.5) if family.word.letters == "BBT" and family.stable_runs]
    (stable,) = {family.number for family in at}
    family = study.atlas.families[stable - 1]
    groups = model_of(study.solution.sweep, ARRAYS).groups(float(study.solution.sweep.coordinate_of(0.5))).as_floats()
    (ends,) = attractors(groups, random_starts(groups.d, start_speed(groups.restitution), 8, 1), 3000)
    simulated = ends[0].cycle.motion(float(study.solution.sweep.coordinate_of(0.5)))
    assert min(motion.distance(simulated) for motion in family.at(simulated.coordinate)) < 1e-6
    without = analyse(with_starts(**more), (Task.JSON,))
    assert [family.word for family in without.atlas.families] == [family.word for family in study.atlas.families]


@pytest.mark.slow
def test_where_there_is_no_such_motion_what_there_is_is_named() -> None:
    loaded = with_starts({"word": "BTT", "value": 0.5}, {"word": "BBT", "value": 0.5, "periods": 2})
    with pytest.raises(ScenarioError) as caught:
        analyse(loaded, (Task.JSON,))
    (mistake,) = caught.value.mistakes
    assert mistake.path == "motions.starts.0"
    assert mistake.message.startswith(
        "no motion BTT every forcing period was found at s = 0.5 m (there: BT every forcing"
    )
    assert "BBT every 2 forcing periods" in mistake.message


@pytest.mark.parametrize(
    ("row", "over", "message"),
    [
        ({"word": "BBT", "value": 0.5}, "inclination_deg=40..50,restitution=0.4..0.6", "none of the inputs"),
        ({"word": "BBTBT", "value": 0.5}, "inclination_deg=40..50,length_m=0.4..0.6", "up to 4 impacts"),
        ({"word": "BBT", "value": 0.46}, "inclination_deg=40..50,length_m=0.48..0.6", "not in the plane"),
    ],
)
def test_a_start_that_a_chart_has_no_place_for_is_refused_before_work(row, over: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        chart_of(with_starts(row), over, lambda what: None)


@pytest.mark.slow
def test_a_chart_has_a_sweep_through_each_start() -> None:
    over = "inclination_deg=40..50,length_m=0.48..0.52"
    row = {"word": "BBT", "value": 0.5, "periods": 2}
    limits = {"motions.impacts": 3, "motions.periods": 2}
    drawn = chart_of(with_starts(row, **limits), over, lambda what: None)
    through = [cut for cut in drawn.cuts if cut.line.varied == 1 and cut.line.other == 45.0]
    assert len(through) == 1 + sum(
        cut.line.other == 45.0 and cut.line.varied == 1 for cut in chart_of(with_starts(**limits), over, print).cuts
    )
    with pytest.raises(UsageError, match="no motion BTT every forcing period was found at 45° and"):
        chart_of(with_starts({"word": "BTT", "value": 0.5}, **limits), over, lambda what: None)
