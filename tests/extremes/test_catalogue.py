"""The catalogue of extreme cases: every case passes, and planted faults are caught."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES
from msgspec.structs import replace

from vireport import load
from vireport.base import NumericalError
from vireport.extremes import run_catalogue, table_data, table_text
from vireport.extremes.catalogue import catalogue, summary
from vireport.extremes.harvester import PAPER, harvester_of
from vireport.extremes.judge import (
    Case,
    CaseFinding,
    CaseOutcome,
    CaseVerdict,
    NotThereError,
    judge,
)
from vireport.motions import Motions
from vireport.physics import Device
from vireport.scenario import Parameter
from vireport.simulation import FLIGHT, REST, VELOCITY
from vireport.study import Study

CHEAP = ("restitution", "inclination", "length", "share of the period", "membrane", "grazing")


def name_of(case: Case) -> str:
    return f"{case.group}: {case.name}"


CASES = {name_of(case): case for case in catalogue()}
"""Around the paper's device, which has every point of the catalogue."""

HORIZONTAL = [case for case in catalogue(load(EXAMPLES / "horizontal.yaml")) if case.group in CHEAP]


@pytest.mark.slow
@pytest.mark.parametrize("case", [*CASES.values(), *HORIZONTAL], ids=name_of)
def test_every_case_passes(case: Case) -> None:
    outcome = judge(case)
    assert outcome.verdict is CaseVerdict.PASSED, outcome.found


UNLIKE = {"device.restitution": None, "device.restitution_bottom": 0.55, "device.restitution_top": 0.45}

AROUND_UNLIKE = (
    ("inclined", "inclination: beta = 0 deg"),
    ("inclined", "critical points: 0.0001 inside a fold"),
    ("inclined", "critical points: narrow range of foci, gbar = 0.001"),
    ("horizontal", "share of the period: q = 1/(1+r)"),
    ("inclined", "grazing: gap +1e-14"),
    ("inclined", "simulation: flight, gbar = 1"),
    ("inclined", "simulation: chatter 0.1 before the release"),
)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "case"), AROUND_UNLIKE)
def test_cases_around_a_device_with_unlike_membranes(name: str, case: str, example) -> None:
    cases = {name_of(case): case for case in catalogue(load(example(name), UNLIKE))}
    outcome = judge(cases[case])
    assert outcome.verdict is CaseVerdict.PASSED, outcome.found


@pytest.mark.slow
def test_a_device_without_mirror_images_has_no_pitchfork(example) -> None:
    cases = {name_of(case): case for case in catalogue(load(example("horizontal"), UNLIKE))}
    outcome = judge(cases["critical points: pitchfork in a sweep"])
    assert outcome.verdict is CaseVerdict.DOES_NOT_APPLY


def test_the_catalogue_notices_a_unit_of_velocity_that_is_off(monkeypatch: pytest.MonkeyPatch) -> None:
    unit = Device.velocity_unit
    assert judge(CASES["units: y_c = F/(2 M f)"]).verdict is CaseVerdict.PASSED
    monkeypatch.setattr(Device, "velocity_unit", lambda *arguments: unit(*arguments) * (1 + 1e-4))
    assert judge(CASES["units: y_c = F/(2 M f)"]).verdict is CaseVerdict.FAILED


@pytest.mark.parametrize("name", ["horizontal", "inclined", "inclined-forcing", "design-point"])
def test_cases_are_built_around_the_device_of_a_scenario(name: str, example) -> None:
    harvester = harvester_of(load(example(name)))
    scenario = load(example(name)).scenario
    assert harvester.device.restitution == scenario.device.restitution
    assert None not in [getattr(harvester.device, field) for field in harvester.device.__struct_fields__]
    changed = harvester.with_groups(d=0.3, gbar=0.2).device
    d, gbar, *_ = changed.groups(Parameter.FREQUENCY, changed.frequency_hz)
    assert (d, gbar) == pytest.approx((0.3, 0.2), rel=1e-14)


def test_a_device_that_is_refused_itself_has_no_catalogue(example) -> None:
    loaded = load(example("inclined"), ["device.restitution=1"])
    with pytest.raises(NumericalError, match=r"device\.restitution"):
        run_catalogue(loaded)


def planted(name: str, fault: Callable[[Any], Any]) -> CaseOutcome:
    """The judgement of a case whose answer is altered before it is checked."""
    answer = fault(CASES[name].answer())
    return judge(replace(CASES[name], answer=lambda: answer))


def with_motions(study: Study, change: Callable[[Motions], Motions]) -> Study:
    design = study.solution.design
    return replace(study, solution=replace(study.solution, design=replace(design, motions=change(design.motions))))


def without_first(motions: Motions) -> Motions:
    arrays = (name for name in Motions.__struct_fields__ if name != "restitution")
    return replace(motions, **{name: getattr(motions, name)[1:] for name in arrays})


def with_points(study: Study, change: Callable[[tuple], tuple]) -> Study:
    diagram = study.solution.diagram
    changed = replace(diagram, critical_points=change(diagram.critical_points))
    return replace(study, solution=replace(study.solution, diagram=changed))


def moved(points, by: float = 1e-13):
    first, *others = points
    value = first.sweep_value * (1 + by)
    return (replace(first, sweep_value=value), *others)


def nudged(rows_and_summary, column: int, by: float):
    rows, summary = rows_and_summary
    rows[-1, column] *= 1 + by
    return rows, summary


def ended(rows_and_summary, end: int):
    rows, summary = rows_and_summary
    summary[2] = end
    return rows, summary


def sped_up(study: Study) -> Study:
    return with_motions(study, lambda m: replace(m, velocity_bottom=m.velocity_bottom * (1 + 1e-10)))


FAULTS: tuple[tuple[str, str, Callable[[Any], Any]], ...] = (
    ("inclination: beta = 90 deg", "a velocity off in the tenth digit", sped_up),
    ("sweep: relative width 2e-9", "a motion that is missing", lambda study: with_motions(study, without_first)),
    (
        "length: d = 0.001",
        "a number that is not finite",
        lambda study: with_motions(study, lambda m: replace(m, wall_gap=m.wall_gap * np.nan)),
    ),
    ("sweep: reversed", "a critical point beyond its bound", lambda study: with_points(study, moved)),
    (
        "gravity over forcing: gbar = 1e-14",
        "a branch with another trace",
        lambda study: replace(
            study,
            solution=replace(
                study.solution,
                diagram=replace(
                    study.solution.diagram,
                    branches=tuple(
                        replace(branch, motions=replace(branch.motions, trace=branch.motions.trace + 1e-8))
                        for branch in study.solution.branches
                    ),
                ),
            ),
        ),
    ),
    ("share of the period: q = 1/2, horizontal", "another d", lambda motion: replace(motion, d=motion.d * (1 + 1e-9))),
    ("membrane: deflection rb", "another voltage", lambda v: replace(v, average_v=v.average_v * (1 + 1e-9))),
    ("units: y_c = F/(2 M f)", "a unit 1e-4 off", lambda units: {p: unit * (1 + 1e-4) for p, unit in units.items()}),
    ("critical points: fold in a sweep", "a fold that is moved", moved),
    (
        "critical points: narrow range of foci, gbar = 0.001",
        "two changes that are missing",
        lambda study: with_points(study, lambda points: tuple(p for p in points if p.label not in ("A1", "A2"))),
    ),
    (
        "critical points: 1e-06 inside a fold",
        "one of the two motions",
        lambda answers: [(without_first(motions), states, d) for motions, states, d in answers],
    ),
    (
        "grazing: gap +1e-14",
        "a motion called inadmissible",
        lambda answers: [(replace(m, admissible_mask=~m.admissible_mask), near, device) for m, near, device in answers],
    ),
    ("simulation: flight, d = 1", "a flight time", lambda answer: nudged(answer, FLIGHT, 1e-11)),
    ("simulation: flight, gbar = 1", "a velocity", lambda answer: nudged(answer, VELOCITY, 1e-11)),
    ("simulation: a slow ball at gbar = 1 - 1e-12", "rest before its time", lambda answer: ended(answer, REST)),
    ("simulation: chatter 0.1 before the release", "a ball never held", lambda a: (a[0] * [1, 1, 1, 1, 0, 0], *a[1:])),
)


LONG = ("critical points: narrow range of foci, gbar = 0.001", "simulation: chatter 0.1 before the release")
"""Cases whose answer takes long."""


@pytest.mark.parametrize(
    ("name", "alter"),
    [
        pytest.param(name, alter, id=f"{name}: {fault}", marks=[pytest.mark.slow] if k % 2 or name in LONG else [])
        for k, (name, fault, alter) in enumerate(FAULTS)
    ],
)
def test_a_planted_fault_is_caught(name: str, alter: Callable[[Any], Any]) -> None:
    assert planted(name, alter).verdict is CaseVerdict.FAILED


def test_an_answer_where_a_refusal_is_due_is_caught() -> None:
    assert judge(replace(CASES["restitution: r = 1"], answer=PAPER.over)).verdict is CaseVerdict.FAILED


def test_what_is_not_there_does_not_apply(example) -> None:
    cases = catalogue(load(example("inclined"), ["device.restitution=0"]))
    case = next(case for case in cases if case.name == "gap 0")
    outcome = judge(case)
    assert outcome.verdict is CaseVerdict.DOES_NOT_APPLY
    assert "1 does not apply" in summary([outcome])


def judged(check: Callable[[], CaseFinding], **more) -> CaseOutcome:
    return judge(Case("judge", "made up", "", lambda: None, lambda answer: check(), **more))


def test_an_error_beyond_its_bound_fails() -> None:
    assert judged(lambda: CaseFinding("", 1e-13, 1e-12)).verdict == "passed"
    assert judged(lambda: CaseFinding("", 1e-11, 1e-12)).verdict == "failed"
    assert judged(lambda: CaseFinding("", float("nan"), 1e-12)).verdict == "failed"
    assert judged(lambda: CaseFinding("", 1e-13, 1e-12, right=False)).verdict == "failed"


def test_an_exception_a_warning_and_an_answer_where_a_refusal_is_due_fail() -> None:
    def refuse() -> CaseFinding:
        raise NumericalError("device.restitution: too large")

    def absent() -> CaseFinding:
        raise NotThereError("no fold")

    def warn() -> CaseFinding:
        warnings.warn("divide by zero", RuntimeWarning, stacklevel=1)
        return CaseFinding("")

    fault = judged(lambda: CaseFinding(str(1 // 0)))
    assert (fault.verdict, fault.found) == ("failed", "ZeroDivisionError: integer division or modulo by zero")
    assert judged(lambda: CaseFinding(str(np.float64(1) / np.float64(0)))).verdict == "failed"
    assert judged(warn).verdict == "failed"
    assert judged(refuse).verdict == "failed"
    assert judged(refuse, refusal="sweep").verdict == "failed"
    assert judged(refuse, refusal="restitution").verdict == "passed"
    assert judged(lambda: CaseFinding("an answer"), refusal="restitution").verdict == "failed"
    assert judged(lambda: CaseFinding("an answer"), refusal="restitution", answers=True).verdict == "passed"
    assert judged(absent).verdict == "does not apply"


def test_a_case_without_its_package_is_left_out_with_the_reason() -> None:
    outcome = judged(lambda: CaseFinding(""), needs="no_such_package")
    assert outcome.verdict == "left out"
    assert "left out: needs no_such_package" in table_text([outcome])


@pytest.fixture(scope="module")
def outcomes() -> tuple[CaseOutcome, ...]:
    cases = [case for case in catalogue() if case.group in ("restitution", "membrane")]
    return tuple(judge(case) for case in cases)


@pytest.mark.slow
def test_the_table_is_for_a_terminal(outcomes) -> None:
    text = table_text(outcomes)
    lines = text.splitlines()
    assert max(map(len, lines)) <= 120
    assert {"RESTITUTION", "MEMBRANE"} <= set(lines)
    assert sum(line.endswith("  passed") for line in lines) == len(outcomes)
    assert summary(outcomes) in text


@pytest.mark.slow
def test_the_machine_form_is_json_and_whole(outcomes) -> None:
    data = json.loads(json.dumps(table_data(outcomes), allow_nan=False))
    assert [row["case"] for row in data] == [outcome.case.name for outcome in outcomes]
    assert {row["verdict"] for row in data} == {"passed"}
    refused = next(row for row in data if row["case"] == "r = 1")
    assert refused["error"] is None
    assert refused["found"].endswith("(allowed here: at most 1 - 1e-06)")


def test_a_run_tells_each_case_as_it_begins(monkeypatch) -> None:
    cases = tuple(Case("group", name, "", lambda: None, lambda answer: CaseFinding("")) for name in ("one", "two"))
    monkeypatch.setattr("vireport.extremes.catalogue.catalogue", lambda loaded: cases)
    told: list[str] = []
    assert [outcome.verdict for outcome in run_catalogue(None, told.append)] == ["passed", "passed"]
    assert told == ["group: one", "group: two"]


def test_no_time_decides_a_case(monkeypatch) -> None:
    """A clock on which every case takes an hour."""
    clock = iter(range(0, 1_000_000, 3600))
    monkeypatch.setattr("vireport.extremes.judge.perf_counter", lambda: next(clock))
    outcome = judge(CASES["units: y_c = F/(2 M f)"])
    assert (outcome.verdict, outcome.seconds) == (CaseVerdict.PASSED, 3600)
