"""What a scenario requires is met on one side of its limit and not on the other, and jobs are told so."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from junitparser import Failure, JUnitXml
from pages import Page

from vireport import analyse, load, loads
from vireport.alerts import AlertCode
from vireport.cli.app import main
from vireport.gate.requirements import (
    REQUIREMENTS,
    Criterion,
    Evidence,
    Limit,
    LimitKind,
    assess,
    held,
    unmet,
    with_peaks,
)
from vireport.gate.verdict import Question, Status
from vireport.physics import generated_voltage
from vireport.report import Report, github, junit, render_html, render_markdown
from vireport.scenario import Requirements
from vireport.scenario.document import read
from vireport.simulation import attractors, random_starts
from vireport.study import results
from vireport.study.plan import ALL_FORMATS, FORMATS, Task, plan
from vireport.study.provenance import provenance_of

ROOT = Path(__file__).resolve().parents[2]
CI = ROOT / "examples" / "ci"


def judged(name: str, required: dict[str, object], **overrides: object) -> dict[str, Criterion]:
    """The criteria of an example with requirements, by their keys."""
    over = {f"requirements.{key}": value for key, value in required.items()}
    given = {path.replace("__", "."): value for path, value in overrides.items()}
    study = analyse(load(ROOT / "examples" / f"{name}.yaml", over | given))
    return {one.key: one for one in study.criteria}


def only(name: str, required: dict[str, object], **overrides: object) -> Criterion:
    (one,) = judged(name, required, **overrides).values()
    return one


def test_every_key_of_the_block_is_required_by_one_row() -> None:
    keys = [key for requirement in REQUIREMENTS for key in requirement.keys]
    assert sorted(keys) == sorted(Requirements.model_fields)


def volts(study) -> dict[str, float]:
    """The voltages of the stable motions at the design point, each the worst of them."""
    stable, x = study.solution.design.motions.stable, study.solution.design.voltages
    return {
        "u_ave_at_least_v": float(x.average_v[stable].min()),
        "u_bottom_top_difference_at_most_v": float(np.abs(x.bottom_v - x.top_v)[stable].max()),
        "deflection_at_most_m": float(x.deflection_m[stable].max()),
    }


@pytest.mark.parametrize("key", ["u_ave_at_least_v", "u_bottom_top_difference_at_most_v", "deflection_at_most_m"])
@pytest.mark.parametrize("name", ["inclined", "design-point"])
def test_voltages_on_both_sides_of_their_limit(name: str, key: str, study_of) -> None:
    value, least = volts(study_of(name))[key], key.endswith("least_v")
    for change in (-1e-9, 0.0, 1e-9):
        one = only(name, {key: value * (1 + change)})
        assert one.outcome.value == value
        assert one.passed is (change < 0 if least else change > 0)
        assert 0 < one.outcome.error_bound < 1e-11 * value
        # Exactly on the limit it is open on which side the true value lies, and what is open is not met.
        assert ("not decided" in one.outcome.why) is (change == 0)
        assert change == 0 or one.outcome.text.split()[0] != one.limit.text.split()[2]


def test_of_two_stable_motions_the_worst_is_judged() -> None:
    two = {"inclination_deg": 1.0, "device__length_m": 0.36}
    study = analyse(load(ROOT / "examples/horizontal.yaml", {key.replace("__", "."): x for key, x in two.items()}))
    x, stable = study.solution.design.voltages, study.solution.design.motions.stable
    for values in (x.average_v, x.bottom_v - x.top_v, x.deflection_m):
        assert np.ptp(values[stable]) > 1e-4 * values.max()
    for key, value in volts(study).items():
        one = only("horizontal", {key: 1.0}, **two)
        assert one.outcome.value == value
        assert "of 2 stable motions" in one.outcome.why


DIELECTRIC = {"thickness_m": 0.5e-3, "relative_permittivity": 4.7, "breakdown_field_v_m": 1e8}
ELECTRICAL = {f"device.membrane.{key}": value for key, value in DIELECTRIC.items()}


@pytest.mark.parametrize("key", ["power_at_least_mw", "field_at_most_percent"])
def test_power_and_field_on_both_sides_of_their_limit(key: str) -> None:
    x = analyse(load(ROOT / "examples/design-point.yaml", ELECTRICAL)).solution.design
    assert x.motions.stable.tolist() == [True, False]
    value, least = (x.power_mw if key[0] == "p" else 1e-6 * x.field_v_m for x in [x.conversion]), key[0] == "p"
    value = float(next(value)[0])
    for change in (-1e-9, 0.0, 1e-9):
        one = only("design-point", {key: value * (1 + change)}, **ELECTRICAL)
        assert one.outcome.value == pytest.approx(value, rel=1e-15)
        assert one.passed is (change < 0 if least else change > 0)
        assert 0 < one.outcome.error_bound < 1e-11 * value


@pytest.mark.parametrize("key", ["margin_period_doubling_percent", "margin_any_percent"])
@pytest.mark.parametrize("name", ["inclined", "design-point"])
def test_margin_to_the_period_doubling_that_is_nearest(name: str, key: str, study_of) -> None:
    nearest = study_of(name).solution.design.endings()[0]
    assert (nearest.kind, nearest.parameter) == ("period_doubling", "frequency_hz")
    value = 100 * abs(nearest.relative)
    for limit, passed in ((value - 1e-9, True), (value + 1e-9, False)):
        one = only(name, {key: limit})
        assert one.passed is passed
        assert one.outcome.value == pytest.approx(value, rel=1e-12)
        assert "period doubling B1 at frequency_hz = " in one.outcome.why


@pytest.mark.parametrize("key", ["margin_period_doubling_percent", "margin_any_percent"])
def test_no_sweep_hides_a_margin(key: str) -> None:
    narrow = {"sweep__from": 0.69, "sweep__to": 0.70}
    for limit, passed in ((4.7, True), (4.8, False)):
        one = only("inclined", {key: limit}, **narrow)
        assert one.passed is passed
        assert one.outcome.value == only("inclined", {key: limit}).outcome.value


def test_no_grazing_point_ends_stability() -> None:
    one = only("inclined", {"margin_grazing_percent": 5})
    assert one.passed
    assert (one.outcome.value, one.outcome.margin, one.outcome.text) == (None, None, "none in any input")


def test_margin_is_that_of_the_motion_that_ends_first() -> None:
    # Nearly horizontal, the stable motion at 0.42 m doubles its period at B2; the stable range goes on to B1, with
    # another motion that is not there at 0.42 m: it begins in the fold C1, near 0.375 m.
    study = analyse(load(ROOT / "examples/horizontal.yaml", {"inclination_deg": 1, "device.length_m": 0.42}))
    assert study.solution.design.motions.stable.sum() == 1
    value = {point.label: point.point.sweep_value for point in study.solution.critical_points}
    assert value["B1"] == study.solution.stable_ranges[0].start < value["B2"] < value["C1"] < 0.42
    for at, below in ((0.42, ["B2"]), (0.36, ["C1", "B2", "B1"]), (0.40, ["B2"])):
        over = {"inclination_deg": 1, "device.length_m": at}
        design = analyse(load(ROOT / "examples/horizontal.yaml", over)).solution.design
        ends = [one for one in design.endings() if one.parameter == "length_m" and one.label]
        assert {one.label for one in ends} <= {"B1", "B2", "C1"}
        assert ends[0].label == below[0]


def test_no_mark_of_approval_stands_beside_a_requirement_that_is_not_met() -> None:
    study = analyse(load(CI / "failing.yaml"))
    status = {fact.question: fact.status for fact in study.verdict.facts}
    missed = {one.question for one in study.criteria if not one.passed}
    assert missed == {Question.WHERE, Question.MARGIN, Question.VOLTAGE}
    assert {status[question] for question in missed} == {Status.BAD}


@pytest.mark.parametrize(
    ("required", "status", "fact", "word"),
    [
        ({}, "caution", "caution", "Stable, but not for every device within the tolerances"),
        ({"requirements.yield_at_least_percent": 50}, "good", "caution", "Stable"),
        ({"requirements.yield_at_least_percent": 99}, "bad", "bad", "Requirements not met"),
    ],
)
def test_tolerances_that_are_not_kept_are_not_approved(
    required: dict[str, int], status: str, fact: str, word: str
) -> None:
    over = {"tolerances": {"frequency_percent": 8, "samples": 64}, **required}
    verdict = analyse(load(ROOT / "examples/design-point.yaml", over)).verdict
    assert (verdict.status, verdict.word) == (status, word)
    assert next(one.status for one in verdict.facts if one.question == Question.TOLERANCES) == fact


@pytest.mark.parametrize(
    ("key", "value"),
    [("acceleration_at_most_g", 3 / 0.1245 / 9.80665), ("stroke_at_most_m", None), ("force_at_most_n", 3.0)],
)
def test_what_the_shaker_must_do(key: str, value: float | None) -> None:
    # The capsule's displacement is F/(M omega^2) to either side.
    value = 2 * 3 / (0.1245 * (4 * np.pi) ** 2) if value is None else value
    for limit, passed in ((value * (1 + 1e-12), True), (value * (1 - 1e-12), False)):
        one = only("inclined", {key: limit})
        assert one.passed is passed
        assert one.outcome.value == pytest.approx(value, rel=1e-14)
    # Without a design point it is the most that the sweep asks for: here its largest force.
    swept = analyse(
        load(ROOT / "examples/inclined-forcing.yaml", [f"requirements.{key}=1e3", "excitation.amplitude_n="])
    )
    sweep = load(ROOT / "examples/inclined-forcing.yaml").scenario.sweep
    assert swept.criteria[0].outcome.value == pytest.approx(value * max(sweep.from_, sweep.to) / 3, rel=1e-12)


def test_stable_range_is_strict_at_a_critical_point_and_open_at_the_end_of_the_sweep(study_of) -> None:
    start = study_of("inclined").solution.stable_ranges[0].start
    for low, passed in ((start + 1e-12, True), (start, False), (start - 1e-12, False)):
        one = only("inclined", {"stable_from": 0.75, "stable_to": low})
        assert one.passed is passed
        assert one.outcome.margin == pytest.approx(low - start, abs=1e-16)
        assert ("period doubling" in one.outcome.why) is not passed
    assert only("horizontal", {"stable_from": 0.45, "stable_to": 0.75}).passed
    assert only("horizontal", {"stable_from": 0.30, "stable_to": 0.75}).passed  # across the pitchfork C1
    nowhere = only("inclined", {"stable_from": 0.6, "stable_to": 0.62})
    assert (nowhere.passed, nowhere.outcome.value, nowhere.outcome.text) == (False, 0.0, "nowhere")
    # Of two stable ranges within the one required it is the wider one that falls short.
    over = {"device__length_m": 0.4, "excitation__amplitude_n": 5, "excitation__frequency_hz": 2.5}
    over |= {"inclination_deg": 30, "sweep__from": 0.24, "sweep__to": 0.42}
    one = only("inclined", {"stable_from": 0.28, "stable_to": 0.41}, **over)
    assert one.outcome.margin == pytest.approx(0.28 - 0.40332559901987)


def test_a_yield_is_all_only_where_that_is_proved() -> None:
    over = {"requirements.yield_at_least_percent": 100, "tolerances.frequency_percent": 1}
    loaded = load(ROOT / "examples/inclined.yaml", over)
    sampled = SimpleNamespace(stable=64, samples=64, low=0.94)
    for proved in (True, False):
        (one,) = assess(loaded, Evidence(None, tolerances=SimpleNamespace(proved=proved, sampled=sampled)))
        assert (one.outcome.value, one.passed) == (100, proved)


@pytest.mark.parametrize(
    "sweep",
    [{"parameter": "length_m", "from": 0.59, "to": 0.75}, {"parameter": "inclination_deg", "from": 20, "to": 60}, None],
)
def test_inclinations_up_to_the_period_doubling(sweep: dict[str, object] | None, study_of) -> None:
    margins = study_of("design-point").solution.design.margins
    (end,) = (m.sweep_value for m in margins if m.parameter == "inclination_deg" and m.kind == "period_doubling")
    for to, passed in ((end - 1e-9, True), (end + 1e-9, False)):
        required = {"inclination_from_deg": 40, "inclination_to_deg": to}
        one = only("inclined", required, device__length_m=0.70, sweep=sweep)
        assert one.passed is passed
        assert one.outcome.margin == pytest.approx(end - to, abs=1e-12)


def test_difference_of_u_ave_is_that_of_many_design_points() -> None:
    low, high = 0.65, 0.74
    points = [
        analyse(load(ROOT / "examples/inclined.yaml", {"device.length_m": float(value)}))
        for value in np.linspace(low, high, 9)
    ]
    found = [volts(point)["u_ave_at_least_v"] for point in points]
    expected = max(found) - min(found)
    ends = {"stable_from": low, "stable_to": high}
    for change, passed in ((-1e-9, False), (1e-9, True)):
        one = judged("inclined", {"u_ave_difference_at_most_v": expected * (1 + change), **ends})
        assert one["u_ave_difference_at_most_v"].outcome.value == pytest.approx(expected, rel=1e-11)
        assert one["u_ave_difference_at_most_v"].passed is passed
    assert only("inclined", {"u_ave_difference_at_most_v": 1e5}).outcome.value > expected
    broken = judged("inclined", {"u_ave_difference_at_most_v": 1e5, "stable_from": 0.6, "stable_to": 0.7})
    assert not broken["u_ave_difference_at_most_v"].passed


def test_peaks_of_a_parabola_are_exact() -> None:
    x = np.array([0.0, 0.3, 0.3, 1.1, 2.0])
    for sign in (1, -1):
        where, height = with_peaks(sign * x, 3 - 2 * (sign * x - sign * 0.7) ** 2)
        assert height.max() == pytest.approx(3, abs=1e-14)
        assert where[height.argmax()] == pytest.approx(sign * 0.7, abs=1e-14)
    assert len(with_peaks(x, x)[0]) == 4


HYSTERESIS = """\
schema_version: 1
device: {{capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5, length_m: {length}}}
excitation: {{amplitude_n: 5, frequency_hz: 2.5}}
inclination_deg: 30
sweep: {{parameter: length_m, from: 0.21, to: 0.25}}
motions: {{impacts: 4, periods: 1}}
requirements: {{words: {words}, u_ave_at_least_v: {least}, margin_any_percent: 1}}
"""
"""2:1 motion is stable above 0.2210 m, 3:1 motion below 0.2280 m."""


def in_hysteresis(length: float, words: str, least: float = 1) -> dict[str, Criterion]:
    study = analyse(loads(HYSTERESIS.format(length=length, words=words, least=least)), ("json",))
    return {one.key: one for one in study.criteria}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("length", "words", "passed"),
    [
        (0.23, "[BBT]", True),
        (0.23, "[TBB, BT]", True),
        (0.23, "[BT]", False),
        (0.225, "[BBT]", False),
        (0.225, "[BBT, BBBT]", True),
        (0.22, "[BBBT]", True),
    ],
)
def test_every_stable_motion_is_one_of_the_words(length: float, words: str, passed: bool) -> None:
    study = analyse(loads(HYSTERESIS.format(length=length, words=words, least=1)), ("json",))
    criteria = {one.key: one for one in study.criteria}
    assert criteria["word"].passed is passed
    # Where a motion was asked for that is the stable one, nothing is to be warned of.
    causes = [alert.cause for alert in study.alerts if alert.code is AlertCode.DESIGN_NOT_STABLE]
    assert len(causes) == (not passed)
    assert all("Stable there: B" in cause for cause in causes)
    assert criteria["word"].outcome.margin is None
    assert ("not allowed" in criteria["word"].outcome.why) is not passed
    # Margins are of the 1:1 motion, which is not stable here.
    assert criteria["margin_any_percent"].outcome.why == "there is no stable 1:1 motion at the design point"


@pytest.mark.slow
def test_voltages_are_those_of_the_stable_motion() -> None:
    study = analyse(loads(HYSTERESIS.format(length=0.23, words="[BBT]", least=1)), ("json",))
    d, gbar = (float(x) for x in study.solution.device.groups(study.solution.parameter, 0.23))
    end = attractors([d], gbar, 0.5, random_starts([d], 1.0, 1, 1))[0][0]
    assert end.word == "BBT"
    unit = float(study.solution.device.velocity_unit(study.solution.parameter, 0.23))
    mean = float(generated_voltage(unit * end.cycle.velocity, study.solution.membrane).mean())
    value = next(one for one in study.criteria if one.key == "u_ave_at_least_v").outcome.value
    assert value == pytest.approx(mean, rel=1e-9)
    assert in_hysteresis(0.23, "[BBT]", 0.999 * mean)["u_ave_at_least_v"].passed
    assert not in_hysteresis(0.23, "[BBT]", 1.001 * mean)["u_ave_at_least_v"].passed


@pytest.mark.slow
def test_of_two_stable_words_the_worst_is_judged() -> None:
    text = HYSTERESIS.format(length=0.2245, words="[BBT, BBBT]", least=1)
    text = text.replace("u_ave_at_least_v: 1", "u_ave_at_least_v: 1, u_bottom_top_difference_at_most_v: 1")
    study = analyse(loads(text), ("json",))
    unit = 5 / (2 * 0.1245 * 2.5)
    two = [generated_voltage(unit * x.velocity, study.solution.membrane) for _, x in study.atlas.stable_at(0.2245)]
    assert [len(volts) for volts in two] == [3, 4]
    means, spans = [volts.mean() for volts in two], [volts.max() - volts.min() for volts in two]
    found = {one.key: one.outcome for one in study.criteria}
    assert found["u_ave_at_least_v"].value == pytest.approx(min(means), rel=1e-9)
    assert found["u_bottom_top_difference_at_most_v"].value == pytest.approx(max(spans), rel=1e-9)
    assert max(means) > 1.03 * min(means)
    assert max(spans) > 1.03 * min(spans)


@pytest.mark.slow
def test_a_word_alone_has_the_motions_followed_and_the_verdict_says_which_is_stable() -> None:
    text = HYSTERESIS.format(length=0.23, words="[BBT]", least=1)
    text = text.replace("motions: {impacts: 4, periods: 1}\n", "").replace(", margin_any_percent: 1", "")
    loaded = loads(text)
    assert plan(loaded.scenario, ("json",)).runs(Task.MOTIONS)
    study = analyse(loaded, ("json",))
    assert (study.atlas.limits.impacts, study.atlas.limits.periods) == (6, 4)
    assert (study.verdict.status, study.verdict.word) == ("good", "Stable")
    assert (
        study.verdict.instead == "the ball strikes the bottom membrane twice and the top once per forcing period (BBT)"
    )
    assert study.verdict.instead in study.verdict.headline


@pytest.mark.slow
def test_without_a_design_point_the_first_page_says_what_is_stable_in_the_sweep_instead() -> None:
    text = HYSTERESIS.format(length=0.23, words="[BBT]", least=1)
    text = text.replace(", length_m: 0.23", "").partition("requirements:")[0]
    study = analyse(loads(text), ("json",))
    assert study.solution.design is None
    assert (study.verdict.status, study.verdict.word) == ("caution", "Stable, but not 1:1")
    said = " ".join(markdown(study, "run").split())
    assert "no such motion is stable in the sweep. Somewhere in it the ball strikes the bottom membrane twice" in said
    assert "three times and the top once per forcing period (BBBT), and stays so" in said
    where = next(fact for fact in study.verdict.facts if fact.question == Question.WHERE)
    assert (where.answer, where.status) == ("Nowhere", Status.NEUTRAL)
    pictures = {name: name for name in ("figure-2", "figure-atlas")}
    report = Report(study, pictures, provenance_of(study.loaded, "run"))
    assert report.proof == "figure-atlas"


@pytest.mark.slow
def test_motions_that_coexist_with_the_stable_1_1_motion_are_named() -> None:
    over = {"motions.impacts": 4, "device.length_m": 0.632}
    study = analyse(load(ROOT / "examples" / "inclined.yaml", over), ("json",))
    assert {family.sequence.word for family, _ in study.atlas.stable_at(0.632)} == {"BT", "BTBT"}
    assert "is a stable node (disturbances die out without turning about it); BTBT is stable there too." in " ".join(
        markdown(study, "run").split()
    )


@pytest.mark.slow
def test_the_stable_ranges_of_the_verdict_are_those_of_the_1_1_motion() -> None:
    text = HYSTERESIS.format(length=0.3, words="[BBT]", least=1).replace("from: 0.21, to: 0.25", "from: 0.29, to: 0.42")
    said = markdown(analyse(loads(text), ("json",)), "run")
    assert "bottom membrane twice" in said
    assert "Along the sweep the 1:1 motion is stable for 0.403326 m" in " ".join(said.split())


def test_a_1_1_motion_is_judged_by_its_error_bounds_where_it_alone_is_stable(example) -> None:
    over = {"motions.impacts": 2, "motions.periods": 1, "sweep.from": 0.68, "sweep.to": 0.7}
    given = load(example("inclined"), over | {"requirements.word": "TB", "requirements.u_ave_at_least_v": 1})
    study = analyse(given, ("json",))
    word, volt = study.criteria
    assert (word.passed, word.outcome.text, word.limit.text) == (True, "BT every forcing period", "only TB")
    assert volt.outcome.value == volts(study)["u_ave_at_least_v"]
    assert word.to_dict()["limit_value"] is None


def test_without_stable_motion_nothing_is_met() -> None:
    keys = ("margin_period_doubling_percent", "margin_grazing_percent", "u_ave_at_least_v", "deflection_at_most_m")
    found = judged("inclined", dict.fromkeys(keys, 1), device__length_m=0.6)
    assert len(found) == 4
    for one in found.values():
        assert not one.passed
        assert one.outcome.value is None
        assert one.outcome.why == "there is no stable 1:1 motion at the design point"


def test_what_an_error_bound_leaves_open_is_not_met() -> None:
    percent = Limit(LimitKind.AT_LEAST, (4.9,), "%")
    assert held(5.0, percent, (), 0.09).passed
    undecided = held(5.0, percent, ("B1",), 0.11)
    assert not undecided.passed
    assert undecided.why.startswith("not decided: known to within 0.1 %")
    volts = Limit(LimitKind.AT_MOST, (5.0,), "V")
    assert held(5.0, volts).passed
    assert held(5 + 1e-13, volts).text == "5.0000000000001 V"


def crosscheck(**found: object):
    """A simulation that found something."""
    usual = {"passed": True, "orbits": 9, "misses": (), "velocity_difference": 1e-14, "phase_difference": 2e-14}
    return SimpleNamespace(**usual | {"tolerance": 1e-9} | found)


def test_a_cross_check_is_required_and_puts_the_rest_in_doubt() -> None:
    over = ["requirements={crosscheck_passed: true, u_ave_at_least_v: 1}", "simulation={samples: 2}"]
    loaded = load(ROOT / "examples/inclined.yaml", over)
    plain = replace(loaded, scenario=loaded.scenario.model_copy(update={"simulation": None}))
    study = analyse(plain)
    volt, check = assess(study.loaded, Evidence(study.solution, crosscheck()))
    assert volt.passed
    assert check.passed
    assert check.outcome.margin == 1e-9 - 2e-14
    volt, check = assess(study.loaded, Evidence(study.solution, crosscheck(passed=False, misses=(1,))))
    assert not volt.passed
    assert volt.outcome.why == "the simulation does not agree with the solution"
    assert not check.passed
    assert check.outcome.why == "8 of 9 stable orbits found again"
    volt, check = assess(study.loaded, Evidence(study.solution, crosscheck(orbits=0)))
    assert volt.passed
    assert not check.passed
    assert "no stable orbit" in check.outcome.why


def test_results_and_verdict_say_what_is_not_met() -> None:
    study = analyse(load(CI / "failing.yaml"))
    found = results(study, provenance_of(study.loaded, "test"))["requirements"]
    assert not found["passed"]
    failed = [one["key"] for one in found["criteria"] if not one["passed"]]
    assert failed == [
        *("inclination_from_deg", "margin_period_doubling_percent", "margin_any_percent", "deflection_at_most_m")
    ]
    json.dumps(found, allow_nan=False)
    verdict = study.verdict
    assert (verdict.status, verdict.word) == ("bad", "Requirements not met")
    assert verdict.headline.startswith("4 of 9 requirements are not met: Stable 1:1 motion over the inclinations (from")
    passing = analyse(load(CI / "passing.yaml"))
    assert passing.verdict.word == "Stable"
    assert unmet(passing.criteria) == ""
    assert results(passing, provenance_of(passing.loaded, "test"))["requirements"]["passed"]


def test_without_the_block_nothing_is_judged_and_no_room_for_it_imported(study_of) -> None:
    assert study_of("inclined").criteria == ()
    assert results(study_of("inclined"), provenance_of(study_of("inclined").loaded, "test"))["requirements"] is None
    code = "import sys; from vireport.cli import main; main(sys.argv[1:]); print(*sys.modules, file=sys.stderr)"
    command = [sys.executable, "-c", code, "run", str(ROOT / "examples/inclined.yaml"), "--json"]
    loaded = subprocess.run(command, capture_output=True, text=True, check=True).stderr.split()
    assert "vireport.study.study" in loaded
    assert not {f"vireport.{room}" for room in ("comparison", "report", "figures", "trust", "proofs")} & set(loaded)


@pytest.mark.parametrize(("name", "code"), [("passing", 0), ("failing", 1)])
def test_exit_code(name: str, code: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = str(CI / f"{name}.yaml")
    assert main([path, "--json"]) == code
    out, err = capfd.readouterr()
    assert json.loads(out)["requirements"]["passed"] is (code == 0)
    assert ("4 of 9 requirements are not met" in err) is (code == 1)
    assert main([path, "-o", str(tmp_path), "--format", "csv,junit,markdown", "--quiet"]) == code
    out, err = capfd.readouterr()
    assert out == ""
    assert ("Deflection (at most 0.015 m)" in err) is (code == 1)
    assert {file.name for file in tmp_path.iterdir()} == {"branches.csv", "junit.xml", "summary.md"}


def test_formats_for_jobs_are_written_only_when_asked_for(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert FORMATS == ("html", "pdf", "png", "json", "csv")
    assert set(ALL_FORMATS) - set(FORMATS) == {"svg", "junit", "markdown", "github"}
    folder = tmp_path / "out"
    assert main([str(CI / "failing.yaml"), "-o", str(folder), "--format", "github"]) == 1
    out, err = capfd.readouterr()
    assert not folder.exists()
    assert out.count("::error ") == 4
    assert "::" not in err
    assert main(["plan", str(CI / "failing.yaml"), "--format", "junit"]) == 0
    out = capfd.readouterr().out
    assert re.search(r"run +junit", out)
    assert not re.search(r"(markdown|github)", out)


def test_junit_is_read_by_a_parser() -> None:
    study = analyse(load(CI / "failing.yaml"))
    assert junit(study) == junit(study)
    parsed = JUnitXml.fromstring(junit(study))
    (suite,) = parsed
    cases = list(suite)
    assert (parsed.tests, parsed.failures, parsed.errors) == (suite.tests, suite.failures, suite.errors) == (9, 4, 0)
    assert (len(cases), sum(not case.is_passed for case in cases)) == (9, 4)
    for case, one in zip(cases, study.criteria, strict=True):
        assert case.name == f"{one.title}: {one.limit.text}"
        assert case.is_passed is one.passed
        if not one.passed:
            (failure,) = case.result
            assert isinstance(failure, Failure)
            assert one.outcome.text in failure.message
            assert failure.type == one.key


def test_junit_without_requirements_is_one_case(study_of) -> None:
    (suite,) = JUnitXml.fromstring(junit(study_of("inclined")))
    (case,) = suite
    assert (case.name, case.is_passed, suite.tests, suite.failures) == ("solved", True, 1, 0)


TITLE = "<script>|%0A`x` *y* _z_ [l](u) & ~s~ $m$: {{ 1 }} #panic() \u05d0\u05d1 ]]> \\|"


@pytest.fixture(scope="module")
def odd():
    text = (CI / "failing.yaml").read_text()
    title = "title: Capsule at 45 degrees, refused"
    assert title in text
    return analyse(loads(text.replace(title, f"title: '{TITLE}'"), "odd,na:me%.yaml"))


def markdown(study, command: str) -> str:
    report = Report(study, {}, provenance_of(study.loaded, command), template="summary.typ.j2")
    return render_markdown(report).decode()


def test_a_title_is_text_in_every_format(odd) -> None:
    (suite,) = JUnitXml.fromstring(junit(odd))
    assert suite.name == TITLE
    text = markdown(odd, "vireport run `a`|<b>.yaml")
    head = "## Requirements not met: &lt;script&gt;\\|%0A\\`x\\` \\*y\\* \\_z\\_ \\[l\\](u) &amp; \\~s\\~ \\$m\\$: "
    assert text.splitlines()[0] == f"{head}{{{{ 1 }}}} #panic() \u05d0\u05d1 \\]\\]&gt; \\\\\\|"
    assert set(re.findall(r"<[^>]*>", text)) == {"<sub>", "</sub>", "<b>"}
    assert "`` vireport run `a`|<b>.yaml ``" in text
    rows = re.search(r"(?:^\|.*\n)+", text, re.MULTILINE)[0].splitlines()
    assert len(rows) == 2 + 9
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {7}
    assert sum("NOT MET" in row for row in rows) == 4


def test_markdown_leads_to_the_line_and_says_how_to_run_it_again(odd, monkeypatch: pytest.MonkeyPatch) -> None:
    text = markdown(odd, "vireport run x_y.yaml")
    assert "Again, with the exit code: `vireport run x_y.yaml`" in text
    assert "| odd,na:me%.yaml:28 |" in text
    for name, value in (("SERVER_URL", "https://github.com"), ("REPOSITORY", "a/b"), ("SHA", "0123")):
        monkeypatch.setenv(f"GITHUB_{name}", value)
    text = markdown(odd, "test")
    assert "[odd,na:me%.yaml:28](https://github.com/a/b/blob/0123/odd%2Cna%3Ame%25.yaml#L28)" in text


def test_characters_that_xml_cannot_hold(odd) -> None:
    loaded = replace(odd.loaded, document=replace(odd.loaded.document, name="a\x1b\udcff.yaml"))
    study = replace(odd, loaded=loaded)
    (suite,) = JUnitXml.fromstring(junit(study))
    assert len(list(suite)) == 9
    github(study).encode()


def test_annotations_point_to_the_lines(odd) -> None:
    lines = github(odd).splitlines()
    failed = [one for one in odd.criteria if not one.passed]
    errors = [line for line in lines if line.startswith("::error ")]
    rows = odd.loaded.document.text.splitlines()
    assert len(errors) == len(failed) == 4
    for line, one in zip(errors, failed, strict=True):
        found = re.fullmatch(r"::error file=odd%2Cna%3Ame%25\.yaml,line=(\d+),title=([^:,]*)::(.*)", line)
        assert found
        assert rows[int(found[1]) - 1].split(":")[0].strip() == one.key
        assert not re.search(r"%(?!25|0A|0D|3A|2C)", found[2] + found[3])
    warnings = [line for line in lines if line.startswith("::warning ")]
    assert len(warnings) == sum(alert.severity == "warning" for alert in odd.alerts) > 0
    assert len(lines) == len(errors) + len(warnings)


def test_annotations_are_seen_from_the_root_of_the_repository(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GITHUB_WORKSPACE", str(ROOT))
    monkeypatch.chdir(CI)
    assert "::error file=examples/ci/failing.yaml,line=28," in github(analyse(load("failing.yaml")))
    standard_input = analyse(loads((CI / "failing.yaml").read_text(), "<stdin>"))
    assert github(standard_input).startswith("::error title=")


def test_what_is_set_over_the_file_has_no_line() -> None:
    study = analyse(load(CI / "passing.yaml", {"requirements.u_ave_at_least_v": 1e6}))
    (one,) = (one for one in study.criteria if not one.passed)
    assert (one.key, one.line) == ("u_ave_at_least_v", None)
    assert "::error file=" in github(study)
    assert "line=" not in github(study).split("::")[1]
    assert sum(one.line is None for one in study.criteria) == 1
    whole = analyse(load(CI / "passing.yaml", {"requirements": {"u_ave_at_least_v": 1}}))
    assert [one.line for one in whole.criteria] == [None]


@pytest.mark.slow
def test_the_report_opens_with_the_table(tmp_path: Path, study_of) -> None:
    assert main([str(CI / "failing.yaml"), "-o", str(tmp_path), "--format", "html", "-q"]) == 1
    page = Page((tmp_path / "report.html").read_bytes())
    assert page.headings[:3] == ["Verdict", "Acceptance", "Key numbers"]
    outcomes = [outcome for (outcome,) in page.tables["Requirements"].columns("Outcome")]
    assert (outcomes.count("✗ NOT MET"), outcomes.count("✓ met")) == (4, 5)
    lines = page.tables["Requirements"].columns("In the scenario")
    rows = (CI / "failing.yaml").read_text().splitlines()
    for (line,), one in zip(lines, analyse(load(CI / "failing.yaml")).criteria, strict=True):
        name, _, number = line.partition(":")
        assert (name, rows[int(number) - 1].split(":")[0].strip()) == ("failing.yaml", one.key)
        assert f"#line-{number}" in page.attributes("href")
    assert "vireport" in page.text[page.text.index("Again, with the exit code") :][:80]
    plain = Report(study_of("inclined"), {}, provenance_of(study_of("inclined").loaded, "test"))
    assert "Acceptance" not in Page(render_html(plain)).headings


@pytest.mark.slow
def test_the_workflow_runs_what_exists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    workflow = read((CI / "vireport.yml").read_text(), "vireport.yml")
    assert not workflow.mistakes
    job = workflow.data["jobs"]["acceptance"]
    assert (ROOT / job["env"]["SCENARIO"]).is_file()
    commands = [shlex.split(step["run"]) for step in job["steps"] if step.get("run", "").startswith("vireport ")]
    assert len(commands) == 1
    summary = tmp_path / "summary"
    monkeypatch.chdir(tmp_path)
    arguments = [str(ROOT / job["env"]["SCENARIO"]) if word == "$SCENARIO" else word for word in commands[0][1:]]
    assert main(arguments) == 0
    (step,) = (step for step in job["steps"] if "GITHUB_STEP_SUMMARY" in step.get("run", ""))
    environment = {"GITHUB_STEP_SUMMARY": str(summary), "PATH": "/usr/bin:/bin"}
    subprocess.run(["bash", "-e", "-c", step["run"]], env=environment, check=True)
    assert summary.read_text().startswith("## Stable: Capsule at 45 degrees, accepted\n")
    (upload,) = (step for step in job["steps"] if "upload-artifact" in step.get("uses", ""))
    assert Path(upload["with"]["path"]).is_dir()
