"""A sweep gone through slowly: jumps are where families of stable motions end, and loops lie between them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from pages import render_html

from vireport import analyse, load, loads
from vireport.figures.pictures import pictures
from vireport.physics.groups import Groups
from vireport.report.context import Report
from vireport.scenario.blocks import Direction, SimulationBlock
from vireport.simulation.attractors import Outcome
from vireport.simulation.events import BOTTOM
from vireport.simulation.following import Conditions, Stage, course
from vireport.study.checks.hysteresis import follow_sweep
from vireport.study.coexistence import FoundBy, ends_at
from vireport.study.provenance import provenance_of
from vireport.study.study import sweep_of

LITERATURE = """\
schema_version: 1
device: {{capsule_mass_kg: 0.1245, restitution: 0.5}}
excitation: {{amplitude_n: 5, frequency_hz: 2.5}}
inclination_deg: {inclination}
sweep: {{parameter: length_m, from: {start}, to: {end}}}
"""
FOLD, GRAZING = 0.2280387626887032, 0.22104452048219328
"""Where 3:1 motion ends upwards and 2:1 motion downwards, at 30 degrees, as solved for in decimals."""


def sweep(inclination: float, start: float = 0.16, end: float = 0.6):
    return sweep_of(loads(LITERATURE.format(inclination=inclination, start=start, end=end)).scenario)


def test_jumps_are_where_3_1_and_2_1_motion_end_and_the_loop_lies_between_them():
    slowly = follow_sweep(
        sweep(30, 0.2295, 0.2195), np.linspace(0.2295, 0.2195, 5).tolist(), SimulationBlock(follow="both")
    )
    up, down = slowly.courses[Direction.UP], slowly.courses[Direction.DOWN]
    assert [stage.attractor.word for stage in up.stages] == ["BBBT"] * 4 + ["BBT"]
    assert [stage.attractor.word for stage in down.stages] == ["BBT"] * 4 + ["BBBT"]
    assert [stage.value for stage in down.stages] == [stage.value for stage in up.stages][::-1]
    for followed, at in ((up, FOLD), (down, GRAZING)):
        (jump,) = followed.jumps
        assert abs(jump.after.value - jump.before.value) <= 1e-8
        assert jump.value == pytest.approx(at, abs=1e-8)
    (loop,) = slowly.loops
    assert loop.width == pytest.approx(FOLD - GRAZING, abs=2e-8)
    assert (loop.up.attractor.word, loop.down.attractor.word) == ("BBBT", "BBT")


@pytest.mark.slow
def test_a_loop_between_two_values_is_seen():
    slowly = follow_sweep(sweep(30, 0.219, 0.23), [0.219, 0.22, 0.229, 0.23], SimulationBlock(follow="both"))
    (loop,) = slowly.loops
    assert loop.low == pytest.approx(GRAZING, abs=1e-8)
    assert loop.high == pytest.approx(FOLD, abs=1e-8)


def test_one_direction_has_no_loops(example):
    slowly = follow_sweep(sweep(30, 0.23, 0.24), [0.23, 0.24], SimulationBlock(follow="down"))
    assert list(slowly.courses) == [Direction.DOWN]
    assert slowly.loops == ()


@pytest.mark.slow
def test_a_period_doubling_is_no_jump(example):
    swept = sweep_of(load(example("inclined")).scenario)
    slowly = follow_sweep(swept, [0.625, 0.635], SimulationBlock(follow="both"))
    words = [[stage.attractor.word for stage in followed.stages] for followed in slowly.courses.values()]
    assert words == [["BTBT", "BT"], ["BT", "BTBT"]]
    assert not any(followed.jumps for followed in slowly.courses.values())


def test_mirror_images_are_no_hysteresis(example):
    swept = sweep_of(load(example("horizontal")).scenario)
    slowly = follow_sweep(swept, [0.35, 0.4, 0.45], SimulationBlock(follow="both"))
    up, down = slowly.courses[Direction.UP].stages[0], slowly.courses[Direction.DOWN].stages[-1]
    assert up.distance(down) > 0.5
    assert up.distance(down, mirror=True) < 1e-6
    assert slowly.loops == ()


def test_the_distance_of_motions_is_that_of_the_impact_farthest_from_all_of_the_other():
    def stage(*impacts: tuple[float, float, float]) -> Stage:
        return Stage(0.0, SimpleNamespace(outcome=Outcome.PERIODIC, cycle=None), np.array(impacts), None)

    two = stage((1, 1.0, 0.6), (-1, 2.5, -0.5))
    for more, far in (((1, 2.0, 0.7), 0.7), ((-1, 1.0, -0.3), 0.3), ((1, 1.0, 0.9), 0.3)):
        three = stage(*two.impacts, more)
        assert two.distance(three) == three.distance(two) == pytest.approx(far)
    image = stage((-1, 1.0 + np.pi, -0.6), (1, 2.5 + np.pi, 0.5))
    assert two.distance(image) > 0.5
    assert two.distance(image, mirror=True) == pytest.approx(0, abs=1e-12)


def test_a_ball_at_rest_stays_until_the_forcing_lifts_it():
    # gbar = 2 - value: above 1 the ball rests on the bottom; at r = 0 it then hops from rest, lower than jumps are.
    rising = course([0.5, 0.9, 1.2], lambda value: Conditions(Groups(2.0, 2 - value, 0.3), 1.0))
    assert [stage.attractor.outcome for stage in rising.stages[:2]] == [Outcome.REST] * 2
    assert rising.stages[2].attractor.word == "B~"
    assert rising.stages[0].last.wall == BOTTOM


@pytest.mark.slow
def test_chaos_beyond_a_fold_is_a_jump_both_ways(example):
    # Next to the fold a chaotic motion stays beside the former cycle for tens of thousands of impacts.
    swept = sweep_of(load(example("inclined")).scenario)
    slowly = follow_sweep(swept, [0.59, 0.598, 0.75], SimulationBlock(follow="both"))
    for followed in slowly.courses.values():
        assert [stage.attractor.word for stage in sorted(followed.stages, key=lambda stage: stage.value)] == [
            "",
            "BTBT",
            "BT",
        ]
        (jump,) = followed.jumps
        assert jump.value == pytest.approx(0.5969964175550663, abs=2e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["30", "inclined"])
def test_stable_motions_are_left_where_their_family_ends(name: str, example):
    text = LITERATURE.format(inclination=name, start=0.16, end=0.6)
    if not name.isdigit():
        text = example(name).read_text(encoding="utf-8")
    study = analyse(loads(f"{text}\nsimulation: {{follow: both, starts: 1}}\nmotions: {{}}\n"), ("json",))
    check, left = study.crosscheck, 0
    for jump in (jump for followed in check.hysteresis.courses.values() for jump in followed.jumps):
        attractor = jump.before.attractor
        if attractor.cycle is not None and len(attractor.word) <= 6 and attractor.period <= 4:
            left += 1
            assert ends_at(jump, study.atlas, 1e-6 * np.ptp(check.values)) is not None
    assert left >= {"30": 4}.get(name, 1)


@pytest.mark.slow
def test_results_and_coexisting_motions(example):
    study = analyse(load(example("hysteresis")), ("json", "html"))
    (bbt, bbbt) = study.coexisting
    assert (bbt.name, bbbt.name) == ("BBT every forcing period", "BBBT every forcing period")
    ((_, last),) = bbbt.ranges[FoundBy.UP]
    ((_, last_down),) = bbbt.ranges[FoundBy.DOWN]
    assert last == pytest.approx(0.228)
    assert last_down == pytest.approx(0.22)
    assert bbt.ranges[FoundBy.FAMILIES] == [(pytest.approx(GRAZING, abs=1e-15), 0.25)]
    data = study.to_dict()["simulation"]["follow"]
    (jump,) = data["up"]["jumps"]
    assert jump["vertex"]["kind"] == "fold"
    assert jump["from"] < jump["vertex"]["sweep_value"] < jump["to"]
    assert [sample["word"] for sample in data["up"]["samples"]].count("BBBT") == 20
    drawn = pictures(study)
    (picture,) = [picture for picture in drawn if picture.name == "figure-hysteresis"]
    assert "2 jumps; the motion depends on the direction at s = 0.221 to 0.228 m." in picture.caption
    named = {picture.name: picture for picture in drawn}
    page = render_html(Report(study, named, provenance_of(study.loaded, "test"))).decode()
    table = page.partition("The family before ends at")[2].partition("</table>")[0]
    assert table.index("BBBT every") < table.index("fold, 0.228") < table.index("grazing, 0.221")
