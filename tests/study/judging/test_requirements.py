"""What a scenario requires is met on one side of its limit and not on the other."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import markdown, solved
from msgspec.structs import replace

from vireport import analyse, load, loads
from vireport.cli.app import main
from vireport.physics.energy import generated_voltage
from vireport.physics.groups import Groups
from vireport.physics.numbers import ROUNDED, Rounded
from vireport.report.context import Report
from vireport.scenario.blocks import RequirementsBlock
from vireport.scenario.demands import LimitKind
from vireport.scenario.keys import names_in_order
from vireport.simulation.attractors import attractors
from vireport.simulation.starts import random_starts
from vireport.study.judging.evidence import Criterion, Evidence, Limit, held_against, unmet
from vireport.study.judging.ranges import with_peaks
from vireport.study.judging.requirements import assess, requirements
from vireport.study.judging.verdict import Status
from vireport.study.plan import Task, plan
from vireport.study.provenance import provenance_of
from vireport.study.study import results
from vireport.text.alerts import AlertCode
from vireport.text.patterns import Pattern, patterns
from vireport.text.requirements import Question, Remark

ROOT = Path(__file__).resolve().parents[3]
CI = ROOT / "examples" / "ci"


def judged(name: str, required: dict[str, object], **overrides: object) -> dict[str, Criterion]:
    """The criteria of an example with requirements, by their keys."""
    over = {f"requirements.{key}": value for key, value in required.items()}
    given = {path.replace("__", "."): value for path, value in overrides.items()}
    loaded = load(ROOT / "examples" / f"{name}.yaml", over | given)
    return {criterion.key: criterion for criterion in assess(loaded, Evidence(solved(name, **overrides)))}


def only(name: str, required: dict[str, object], **overrides: object) -> Criterion:
    """The criterion of the one requirement that is given; the usual limit of the efficiency stands beside it."""
    (criterion,) = (x for x in judged(name, required, **overrides).values() if not x.limit.usual)
    return criterion


def test_every_key_of_the_block_is_required_by_one_row() -> None:
    """None is accepted and not judged: without the addition whose row judges it, a key is an unknown one."""
    keys = [key for requirement in requirements() for key in requirement.keys]
    assert keys == names_in_order(RequirementsBlock)


def test_every_remark_and_title_has_its_pattern_and_is_made_by_what_judges() -> None:
    titles = [(row.file, row.key) for row in requirements()]
    remarks = [(kind.file, name.value) for kind in Pattern.__subclasses__() for name in kind]
    for file in {file for file, _ in titles}:
        assert sorted(patterns(file)) == sorted(name for of, name in titles + remarks if of == file)
    judging = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "vireport/study/judging").glob("*.py"))
    assert set(re.findall(r"\bRemark\.([A-Z_]+)", judging)) == set(Remark.__members__)


def volts(solution) -> dict[str, float]:
    """The voltages of the stable motions at the design point, each the worst of them."""
    stable, x = solution.design.motions.stable_mask, solution.design.voltages_by_motion
    return {
        "u_ave_at_least_v": float(x.average_v[stable].min()),
        "u_bottom_top_difference_at_most_v": float(np.abs(x.bottom_v - x.top_v)[stable].max()),
        "deflection_at_most_m": float(x.deflection_m[stable].max()),
    }


@pytest.mark.parametrize("key", ["u_ave_at_least_v", "u_bottom_top_difference_at_most_v", "deflection_at_most_m"])
@pytest.mark.parametrize("name", ["inclined", "design-point"])
def test_voltages_on_both_sides_of_their_limit(name: str, key: str) -> None:
    value, least = volts(solved(name))[key], key.endswith("least_v")
    for change in (-1e-9, 0.0, 1e-9):
        criterion = only(name, {key: value * (1 + change)})
        assert criterion.outcome.value == value
        assert criterion.passed is (change < 0 if least else change > 0)
        assert 0 < criterion.outcome.error_bound < 1e-11 * value
        # Exactly on the limit it is open on which side the true value lies, and what is open is not met.
        assert ("not decided" in str(criterion.outcome.why)) is (change == 0)
        assert change == 0 or str(criterion.outcome.text).split()[0] != criterion.limit.text.split()[2]


def test_of_two_stable_motions_the_worst_is_judged() -> None:
    two = {"inclination_deg": 1.0, "device__length_m": 0.36}
    solution = solved("horizontal", **two)
    x, stable = solution.design.voltages_by_motion, solution.design.motions.stable_mask
    for values in (x.average_v, x.bottom_v - x.top_v, x.deflection_m):
        assert np.ptp(values[stable]) > 1e-4 * values.max()
    for key, value in volts(solution).items():
        criterion = only("horizontal", {key: 1.0}, **two)
        assert criterion.outcome.value == value
        assert "of 2 stable motions" in str(criterion.outcome.why)


DIELECTRIC = {"thickness_m": 0.5e-3, "relative_permittivity": 4.7, "breakdown_field_v_m": 1e8}
ELECTRICAL = {f"device.membrane.{key}": value for key, value in DIELECTRIC.items()}


@pytest.mark.parametrize("key", ["power_at_least_mw", "field_at_most_percent"])
def test_power_and_field_on_both_sides_of_their_limit(key: str) -> None:
    x = solved("design-point", **ELECTRICAL).design
    assert x.motions.stable_mask.tolist() == [True, False]
    value, least = (
        (x.power_mw if key[0] == "p" else 1e-6 * x.field_v_m for x in [x.conversion_by_motion]),
        key[0] == "p",
    )
    value = float(next(value)[0])
    for change in (-1e-9, 0.0, 1e-9):
        criterion = only("design-point", {key: value * (1 + change)}, **ELECTRICAL)
        assert criterion.outcome.value == pytest.approx(value, rel=1e-15)
        assert criterion.passed is (change < 0 if least else change > 0)
        assert 0 < criterion.outcome.error_bound < 1e-11 * value


@pytest.mark.parametrize("key", ["margin_period_doubling_percent", "margin_any_percent"])
@pytest.mark.parametrize("name", ["inclined", "design-point"])
def test_margin_to_the_period_doubling_that_is_nearest(name: str, key: str, study_of) -> None:
    nearest = study_of(name).solution.design.endings()[0]
    assert (nearest.event, nearest.parameter) == ("period_doubling", "frequency_hz")
    value = 100 * abs(nearest.relative)
    for limit, passed in ((value - 1e-9, True), (value + 1e-9, False)):
        criterion = only(name, {key: limit})
        assert criterion.passed is passed
        assert criterion.outcome.value == pytest.approx(value, rel=1e-12)
        assert "period doubling B1 at frequency_hz = " in str(criterion.outcome.why)


@pytest.mark.parametrize("key", ["margin_period_doubling_percent", "margin_any_percent"])
def test_no_sweep_hides_a_margin(key: str) -> None:
    narrow = {"sweep__from": 0.69, "sweep__to": 0.70}
    for limit, passed in ((4.7, True), (4.8, False)):
        criterion = only("inclined", {key: limit}, **narrow)
        assert criterion.passed is passed
        assert criterion.outcome.value == only("inclined", {key: limit}).outcome.value


def test_only_another_restitution_of_the_top_would_have_the_motion_graze() -> None:
    criterion = only("inclined", {"margin_grazing_percent": 5})
    assert criterion.passed
    assert criterion.outcome.value == pytest.approx(95.701178, abs=1e-5)
    assert "restitution_top = 0.0215" in str(criterion.outcome.why)


def test_no_grazing_point_ends_stability() -> None:
    criterion = only("inclined", {"margin_grazing_percent": 5}, device__restitution=0.3)
    assert criterion.passed
    assert (criterion.outcome.value, criterion.outcome.margin, str(criterion.outcome.text)) == (
        None,
        None,
        "none in any input",
    )


def test_margin_is_that_of_the_motion_that_ends_first() -> None:
    # Nearly horizontal, the stable motion at 0.42 m doubles its period at B2; the stable range goes on to B1, with
    # another motion that is not there at 0.42 m: it begins in the fold C1, near 0.375 m.
    solution = solved("horizontal", inclination_deg=1, device__length_m=0.42)
    assert solution.design.motions.stable_mask.sum() == 1
    value = {point.label: point.sweep_value for point in solution.critical_points}
    assert value["B1"] == solution.stable_ranges[0].start < value["B2"] < value["C1"] < 0.42
    for at, below in ((0.42, ["B2"]), (0.36, ["C1", "B2", "B1"]), (0.40, ["B2"])):
        design = solved("horizontal", inclination_deg=1, device__length_m=at).design
        ends = [ending for ending in design.endings() if ending.parameter == "length_m" and ending.label]
        assert {ending.label for ending in ends} <= {"B1", "B2", "C1"}
        assert ends[0].label == below[0]


def test_no_mark_of_approval_stands_beside_a_requirement_that_is_not_met() -> None:
    study = analyse(load(CI / "failing.yaml"))
    status = {fact.question: fact.status for fact in study.verdict.answers.values()}
    missed = {criterion.question for criterion in study.criteria if not criterion.passed}
    assert missed == {Question.WHERE, Question.MARGIN, Question.VOLTAGE}
    assert {status[question] for question in missed} == {Status.BAD}


@pytest.mark.parametrize(
    ("key", "value"),
    [("acceleration_at_most_g", 3 / 0.1245 / 9.80665), ("stroke_at_most_m", None), ("force_at_most_n", 3.0)],
)
def test_what_the_shaker_must_do(key: str, value: float | None) -> None:
    # The capsule's displacement is F/(M omega^2) to either side.
    value = 2 * 3 / (0.1245 * (4 * np.pi) ** 2) if value is None else value
    for limit, passed in ((value * (1 + 1e-12), True), (value * (1 - 1e-12), False)):
        criterion = only("inclined", {key: limit})
        assert criterion.passed is passed
        assert criterion.outcome.value == pytest.approx(value, rel=1e-14)
    # Without a design point it is the most that the sweep asks for: here its largest force.
    swept = judged("inclined-forcing", {key: 1e3}, excitation__amplitude_n=None)
    sweep = load(ROOT / "examples/inclined-forcing.yaml").scenario.sweep
    assert swept[key].outcome.value == pytest.approx(value * max(sweep.from_, sweep.to) / 3, rel=1e-12)


def test_stable_range_is_strict_at_a_critical_point_and_open_at_the_end_of_the_sweep(study_of) -> None:
    start = study_of("inclined").solution.stable_ranges[0].start
    for low, passed in ((start + 1e-12, True), (start, False), (start - 1e-12, False)):
        criterion = only("inclined", {"stable_from": 0.75, "stable_to": low})
        assert criterion.passed is passed
        assert criterion.outcome.margin == pytest.approx(low - start, abs=1e-16)
        assert ("period doubling" in str(criterion.outcome.why)) is not passed
    assert only("horizontal", {"stable_from": 0.45, "stable_to": 0.75}).passed
    assert only("horizontal", {"stable_from": 0.30, "stable_to": 0.75}).passed  # across the pitchfork C1
    nowhere = only("inclined", {"stable_from": 0.6, "stable_to": 0.62})
    assert (nowhere.passed, nowhere.outcome.value, str(nowhere.outcome.text)) == (False, 0.0, "nowhere")
    # Of its two ends, from 0.629 m to the fold at 1.432 m, the nearer one.
    within = only("inclined", {"stable_from": 0.7, "stable_to": 1.0}, sweep__to=1.6)
    assert within.passed
    assert within.outcome.margin == pytest.approx(0.7 - start, abs=1e-12)
    # Of two stable ranges within the one required it is the wider one that falls short.
    over = {"device__length_m": 0.4, "excitation__amplitude_n": 5, "excitation__frequency_hz": 2.5}
    over |= {"inclination_deg": 30, "sweep__from": 0.24, "sweep__to": 0.42}
    criterion = only("inclined", {"stable_from": 0.28, "stable_to": 0.41}, **over)
    assert criterion.outcome.margin == pytest.approx(0.28 - 0.40332559901987)


@pytest.mark.parametrize(
    "sweep",
    [
        {"sweep__parameter": "length_m", "sweep__from": 0.59, "sweep__to": 0.75},
        {"sweep__parameter": "inclination_deg", "sweep__from": 20, "sweep__to": 60},
        {"sweep": None},
    ],
)
def test_inclinations_up_to_the_period_doubling(sweep: dict[str, object]) -> None:
    margins = solved("design-point").design.margins
    (end,) = (m.sweep_value for m in margins if m.parameter == "inclination_deg" and m.event == "period_doubling")
    for to, passed in ((end - 1e-9, True), (end + 1e-9, False)):
        required = {"inclination_from_deg": 40, "inclination_to_deg": to}
        criterion = only("inclined", required, device__length_m=0.70, **sweep)
        assert criterion.passed is passed
        assert criterion.outcome.margin == pytest.approx(end - to, abs=1e-12)


def test_difference_of_u_ave_is_that_of_the_largest_and_the_least_along_the_sweep() -> None:
    (branch,) = (branch for branch in solved("inclined").branches if branch.family.stable_runs)
    ((first, last),) = branch.family.stable_runs
    voltages = branch.voltages_by_motion.average_v[first : last + 1]
    for limit, passed in ((0.98, False), (1.02, True)):
        difference = float(voltages.max() - voltages.min())
        criterion = only("inclined", {"u_ave_difference_at_most_v": limit * difference})
        assert criterion.outcome.value == pytest.approx(difference, rel=1e-3)
        assert criterion.passed is passed
        least, most = map(float, re.findall(r"(\d+) to (\d+) V", str(criterion.outcome.why))[0])
        assert least < most


@pytest.mark.slow
def test_difference_of_u_ave_is_that_of_many_design_points() -> None:
    low, high = 0.65, 0.74
    points = [solved("inclined", device__length_m=float(value)) for value in np.linspace(low, high, 5)]
    values = [volts(point)["u_ave_at_least_v"] for point in points]
    expected = max(values) - min(values)
    ends = {"stable_from": low, "stable_to": high}
    for change, passed in ((-1e-9, False), (1e-9, True)):
        criteria = judged("inclined", {"u_ave_difference_at_most_v": expected * (1 + change), **ends})
        assert criteria["u_ave_difference_at_most_v"].outcome.value == pytest.approx(expected, rel=1e-11)
        assert criteria["u_ave_difference_at_most_v"].passed is passed
        said = f"U_ave from {float(f'{min(values):.3g}'):.0f} to {float(f'{max(values):.3g}'):.0f} V"
        assert said in str(criteria["u_ave_difference_at_most_v"].outcome.why)
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
    return {criterion.key: criterion for criterion in study.criteria}


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
    criteria = {criterion.key: criterion for criterion in study.criteria}
    assert criteria["word"].passed is passed
    # Where a motion was asked for that is the stable one, nothing is to be warned of.
    causes = [str(alert.cause) for alert in study.alerts if alert.code is AlertCode.DESIGN_NOT_STABLE]
    assert len(causes) == (not passed)
    assert all("Stable there: B" in cause for cause in causes)
    assert criteria["word"].outcome.margin is None
    assert ("not allowed" in str(criteria["word"].outcome.why)) is not passed
    # Margins are of the 1:1 motion, which is not stable here.
    assert str(criteria["margin_any_percent"].outcome.why) == "there is no stable 1:1 motion at the design point"


@pytest.mark.slow
def test_voltages_are_those_of_the_stable_motion() -> None:
    study = analyse(loads(HYSTERESIS.format(length=0.23, words="[BBT]", least=1)), ("json",))
    d, gbar, *_ = study.solution.device.groups(study.solution.parameter, 0.23).as_floats()
    end = attractors(Groups([d], gbar, 0.5), random_starts([d], 1.0, 1, 1))[0][0]
    assert end.word == "BBT"
    unit = float(study.solution.device.velocity_unit(study.solution.parameter, 0.23))
    mean = float(generated_voltage(unit * end.cycle.velocity, study.solution.membrane).mean())
    value = next(criterion for criterion in study.criteria if criterion.key == "u_ave_at_least_v").outcome.value
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
    outcomes = {criterion.key: criterion.outcome for criterion in study.criteria}
    assert outcomes["u_ave_at_least_v"].value == pytest.approx(min(means), rel=1e-9)
    assert outcomes["u_bottom_top_difference_at_most_v"].value == pytest.approx(max(spans), rel=1e-9)
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
    assert [word.letters for word in study.verdict.motion.data.instead] == ["BBT"]
    assert "Stable instead of 1:1: BBT." in [text for _, text in study.opening.worded().facts]


@pytest.mark.slow
def test_without_a_design_point_the_first_page_says_what_is_stable_in_the_sweep_instead() -> None:
    text = HYSTERESIS.format(length=0.23, words="[BBT]", least=1)
    text = text.replace(", length_m: 0.23", "").partition("requirements:")[0]
    study = analyse(loads(text), ("json",))
    assert study.solution.design is None
    assert (study.verdict.status, study.verdict.word) == ("caution", "Stable, but not 1:1")
    said = " ".join(markdown(study, "run").split())
    assert "Stable instead of 1:1: BBT" in said
    assert "BBBT" in said
    assert (study.verdict.where.data, study.verdict.where.status) == ((), Status.NEUTRAL)
    pictures = {name: name for name in ("figure-2", "figure-atlas")}
    report = Report(study, pictures, provenance_of(study.loaded, "run"))
    assert report.proof == "figure-atlas"


@pytest.mark.slow
def test_motions_that_coexist_with_the_stable_1_1_motion_are_named() -> None:
    over = {"motions.impacts": 4, "device.length_m": 0.632}
    study = analyse(load(ROOT / "examples" / "inclined.yaml", over), ("json",))
    assert {family.word.letters for family, _ in study.atlas.stable_at(0.632)} == {"BT", "BTBT"}
    assert [word.letters for word in study.verdict.motion.data.other_words] == ["BTBT"]


@pytest.mark.slow
def test_the_stable_ranges_of_the_verdict_are_those_of_the_1_1_motion() -> None:
    text = HYSTERESIS.format(length=0.3, words="[BBT]", least=1).replace("from: 0.21, to: 0.25", "from: 0.29, to: 0.42")
    said = markdown(analyse(loads(text), ("json",)), "run")
    assert "Stable instead of 1:1: BBT" in said
    assert "above 0.403 m" in said.replace("\u00a0", " ")


def test_a_1_1_motion_is_judged_by_its_error_bounds_where_it_alone_is_stable(example) -> None:
    over = {"motions.impacts": 2, "motions.periods": 1, "sweep.from": 0.68, "sweep.to": 0.7}
    given = load(example("inclined"), over | {"requirements.word": "TB", "requirements.u_ave_at_least_v": 1})
    study = analyse(given, ("json",))
    word, volt = study.criteria
    assert (word.passed, str(word.outcome.text), word.limit.text) == (True, "BT every forcing period", "only TB")
    assert volt.outcome.value == volts(study.solution)["u_ave_at_least_v"]
    assert word.to_dict()["limit_value"] is None


def test_without_stable_motion_nothing_is_met() -> None:
    keys = ("margin_period_doubling_percent", "margin_grazing_percent", "u_ave_at_least_v", "deflection_at_most_m")
    criteria = judged("inclined", dict.fromkeys(keys, 1), device__length_m=0.6)
    assert len(criteria) == 4
    for criterion in criteria.values():
        assert not criterion.passed
        assert criterion.outcome.value is None
        assert str(criterion.outcome.why) == "there is no stable 1:1 motion at the design point"


def test_what_an_error_bound_leaves_open_is_not_met() -> None:
    percent = Limit(LimitKind.AT_LEAST, (4.9,), "%")
    assert held_against(5.0, percent, "", 0.09).passed
    undecided = held_against(5.0, percent, "B1", 0.11)
    assert not undecided.passed
    assert str(undecided.why) == "not decided: known to within 0.12 % only; B1"  # a bound is rounded up
    volts = Limit(LimitKind.AT_MOST, (5.0,), "V")
    assert held_against(5.0, volts).passed
    assert held_against(5 + 1e-13, volts).text == "5.0000000000001 V"
    assert held_against(np.float64(4.0), volts, bound=np.float64(0.1)).passed is True


def crosscheck(**given: object):
    """A simulation that found something."""
    usual = {"passed": True, "orbits": 9, "misses": (), "velocity_difference": 1e-14, "phase_difference": 2e-14}
    return SimpleNamespace(**usual | {"tolerance": 1e-9} | given)


def test_a_cross_check_is_required_and_puts_the_rest_in_doubt() -> None:
    over = ["requirements={crosscheck_passed: true, u_ave_at_least_v: 1}", "simulation={samples: 2}"]
    loaded = load(ROOT / "examples/inclined.yaml", over)
    plain = replace(loaded, scenario=loaded.scenario.model_copy(update={"simulation": None}))
    study = analyse(plain)
    volt, check = assess(loaded, Evidence(study.solution, crosscheck()))
    assert volt.passed
    assert check.passed
    assert check.outcome.margin == 1e-9 - 2e-14
    volt, check = assess(loaded, Evidence(study.solution, crosscheck(passed=False, misses=(1,))))
    assert not volt.passed
    assert str(volt.outcome.why) == "the simulation does not agree with the solution"
    assert not check.passed
    assert str(check.outcome.why) == "8 of 9 stable motions found again"
    volt, check = assess(loaded, Evidence(study.solution, crosscheck(orbits=0)))
    assert volt.passed
    assert not check.passed
    assert "no stable motion" in str(check.outcome.why)


def test_results_and_verdict_say_what_is_not_met() -> None:
    study = analyse(load(CI / "failing.yaml"))
    accepted = results(study, provenance_of(study.loaded, "test"))["requirements"]
    assert not accepted["passed"]
    failed = [criterion["key"] for criterion in accepted["criteria"] if not criterion["passed"]]
    assert failed == [
        *("inclination_from_deg", "margin_period_doubling_percent", "margin_any_percent", "deflection_at_most_m")
    ]
    json.dumps(accepted, allow_nan=False)
    verdict = study.verdict
    assert (verdict.status, verdict.word) == ("bad", "Requirements not met")
    worded = study.opening.worded()
    assert worded.sentence == "It runs, and starts by itself, but does not meet its requirements."
    assert worded.facts[0][1].startswith(
        "Requirements not met, 4 of 9: Stable 1:1 motion over the inclinations; Margin"
    )
    passing = analyse(load(CI / "passing.yaml"))
    assert passing.verdict.word == "Stable, margin to use less than required"
    assert unmet(passing.criteria) is None
    assert results(passing, provenance_of(passing.loaded, "test"))["requirements"]["passed"]


@pytest.mark.slow
def test_without_the_block_nothing_is_judged_and_no_room_for_it_imported(study_of) -> None:
    assert study_of("inclined").criteria == ()
    assert results(study_of("inclined"), provenance_of(study_of("inclined").loaded, "test"))["requirements"] is None
    code = "import sys; from vireport.cli.app import main; main(sys.argv[1:]); print(*sys.modules, file=sys.stderr)"
    command = [sys.executable, "-c", code, "run", str(ROOT / "examples/inclined.yaml"), "--json"]
    loaded = subprocess.run(command, capture_output=True, text=True, check=True).stderr.split()
    assert "vireport.study.study" in loaded
    others = (
        "comparison.comparison",
        "report.context",
        "figures.layout",
        "findings.proofs.proved",
        "findings.certificates.proofs",
    )
    assert not {f"vireport.{module}" for module in others} & set(loaded)


@pytest.mark.parametrize(("name", "code"), [("passing", 0), ("failing", 1)])
def test_exit_code(name: str, code: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = str(CI / f"{name}.yaml")
    assert main([path, "-o", str(tmp_path), "--format", "json,csv,junit,markdown", "--quiet"]) == code
    out, err = capfd.readouterr()
    assert out == ""
    assert json.loads((tmp_path / "results.json").read_bytes())["requirements"]["passed"] is (code == 0)
    assert ("4 of 9 requirements are not met" in err) is (code == 1)
    assert ("Deflection (at most 0.015 m)" in err) is (code == 1)
    assert {file.name for file in tmp_path.iterdir()} == {"results.json", "branches.csv", "junit.xml", "summary.md"}


@pytest.mark.parametrize(("first", "second", "rounded"), [(5.0, 3.0, False), (3.0, 5.0, False), (5.0, 2.0, True)])
def test_a_difference_of_near_numbers_is_not_rounded(first: float, second: float, rounded: bool) -> None:
    distance = ROUNDED.distance(Rounded(first, 1e-9), Rounded(second, 2e-9))
    assert distance.value == abs(first - second)
    assert bool(distance.error > 1e-9 + 2e-9) is rounded
    assert distance.error == pytest.approx(3e-9, rel=1e-6)


CHAOS = """
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5, length_m: 0.75}
excitation: {amplitude_n: 6.9375, frequency_hz: 2.0}
inclination_deg: 45.0
sweep: {parameter: amplitude_n, from: 6.9, to: 6.975}
motions: {impacts: 6, periods: 4}
requirements: {word: BBT}
"""


@pytest.mark.slow
def test_a_word_that_is_stable_but_not_reached_from_rest_is_not_met() -> None:
    """Most starts are chaotic there, though a motion BBT is stable."""
    study = analyse(loads(CHAOS), ("json",))
    (line,) = study.criteria
    assert "BBT" in str(line.outcome.text)
    assert line.passed is (study.switched_on.from_rest.word == "BBT")
    assert not line.passed
    assert "from rest the device comes to" in str(line.outcome.why)
    share = sum(
        each.share for each in study.outcomes.attracting.motions if each.motion.word.canonical().letters == "BBT"
    )
    assert f"{100 * share:.2g} % of 2000 random starts come to BBT" in str(line.outcome.why)
    assert 0 < share < 0.5


STANDING = """
schema_version: 1
device: {{capsule_mass_kg: 0.1245, restitution: 0.5, length_m: {length}}}
excitation: {{amplitude_n: 3.0, frequency_hz: 2.0}}
inclination_deg: {inclination}
requirements: {{withstands_distortion_percent: {least}}}
"""


def test_the_least_harmonic_of_either_order_is_what_a_design_withstands() -> None:
    """3.85 % of the second at 45 degrees; a design without a stable motion withstands none."""
    for length, inclination, least, passed, why in (
        (0.6934, 45, 3.85, True, "of order 2, at 226 degrees"),
        (0.6934, 45, 3.86, False, "of order 2, at 226 degrees"),
        (0.3718, 45, 1.0, False, "there is no stable 1:1 motion at the design point"),
    ):
        (line,) = analyse(
            loads(STANDING.format(length=length, inclination=inclination, least=least)), ("json",)
        ).criteria
        assert line.passed is passed
        assert why in str(line.outcome.why)
    assert line.outcome.value is None
