"""The catalogue of extreme cases: every case passes, and the judge fails what is wrong."""

from __future__ import annotations

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest
from conftest import EXAMPLES

from vireport import load
from vireport.analysis.design import DesignPoint
from vireport.errors import NumericalError
from vireport.extremes.catalogue import ABSENT, Outcome, catalogue, judge, run_catalogue
from vireport.extremes.checks import PAPER, Case, Finding, NotThereError, base_of, examine
from vireport.extremes.text import summary, table_data, table_text
from vireport.scenario.parameters import Parameter

CHEAP = ("restitution", "inclination", "length", "share of the period", "membrane", "grazing")


def named(cases: tuple[Case, ...]) -> list:
    return [pytest.param(case, id=f"{case.group}: {case.name}") for case in cases]


@pytest.mark.parametrize("case", named(catalogue()))
def test_around_the_paper_s_device(case: Case) -> None:
    outcome = judge(case)
    assert outcome.verdict == "passed", outcome.found
    assert not outcome.found.startswith(ABSENT), "the paper's device has every point of the catalogue"


HORIZONTAL = tuple(case for case in catalogue(load(EXAMPLES / "horizontal.yaml")) if case.group in CHEAP)


@pytest.mark.parametrize("case", named(HORIZONTAL))
def test_around_a_horizontal_capsule(case: Case) -> None:
    outcome = judge(case)
    assert outcome.verdict == "passed", outcome.found


@pytest.mark.parametrize("name", ["horizontal", "inclined", "inclined-forcing", "design-point"])
def test_cases_are_built_around_the_device_of_a_scenario(name: str, example) -> None:
    base = base_of(load(example(name)))
    scenario = load(example(name)).scenario
    assert base.device.restitution == scenario.device.restitution
    assert None not in [getattr(base.device, field) for field in base.device.__slots__]
    d, gbar = base.with_groups(d=0.3, gbar=0.2).device.groups(Parameter.FREQUENCY, base.device.frequency_hz)
    assert (d, gbar) == pytest.approx((0.3, 0.2), rel=1e-14)


def test_a_device_that_is_refused_itself_has_no_catalogue(example) -> None:
    loaded = load(example("inclined"), ["device.restitution=1"])
    with pytest.raises(NumericalError, match=r"device\.restitution"):
        run_catalogue(loaded)


def made(run, **more) -> Outcome:
    return judge(Case("made up", "judge", "", run, **{"needs": (), **more}))


def test_an_error_beyond_its_bound_fails() -> None:
    assert made(lambda: Finding("", 1e-13, 1e-12)).verdict == "passed"
    assert made(lambda: Finding("", 1e-11, 1e-12)).verdict == "failed"
    assert made(lambda: Finding("", float("nan"), 1e-12)).verdict == "failed"
    assert made(lambda: Finding("", 1e-13, 1e-12, right=False)).verdict == "failed"


def test_an_exception_a_warning_and_an_answer_where_a_refusal_is_due_fail() -> None:
    def refuse() -> Finding:
        raise NumericalError("device.restitution: too large")

    def absent() -> Finding:
        raise NotThereError("no fold")

    def warn() -> Finding:
        warnings.warn("divide by zero", RuntimeWarning, stacklevel=1)
        return Finding("")

    fault = made(lambda: Finding(str(1 // 0)))
    assert (fault.verdict, fault.found) == ("failed", "ZeroDivisionError: integer division or modulo by zero")
    assert made(lambda: Finding(str(np.float64(1) / np.float64(0)))).verdict == "failed"
    assert made(warn).verdict == "failed"
    assert made(refuse).verdict == "failed"
    assert made(refuse, refusal="sweep").verdict == "failed"
    assert made(refuse, refusal="restitution").verdict == "passed"
    assert made(lambda: Finding("an answer"), refusal="restitution").verdict == "failed"
    assert made(lambda: Finding("an answer"), refusal="restitution", answers=True).verdict == "passed"
    assert made(absent).found == f"{ABSENT}: no fold"


def test_a_case_without_its_package_is_left_out_with_the_reason() -> None:
    outcome = made(lambda: Finding(""), needs=("no_such_package",))
    assert outcome.verdict == "left out"
    assert "no_such_package" in outcome.needs
    assert "left out: needs no_such_package" in table_text([outcome])


def broken(**changes) -> Finding:
    """The judgement of the paper's study with something in it altered."""
    study = PAPER.over()
    assert study.solution.design is not None
    altered = {name: change(getattr(study.solution.design, name)) for name, change in changes.items()}
    return examine(replace(study, solution=replace(study.solution, design=replace(study.solution.design, **altered))))


def test_a_velocity_off_in_the_tenth_digit_is_noticed() -> None:
    right = broken()
    assert right.right
    assert right.error is not None
    assert right.error < 1e-13
    wrong = broken(motions=lambda m: replace(m, velocity_bottom=m.velocity_bottom * (1 + 1e-10)))
    assert wrong.error is not None
    assert wrong.bound is not None
    assert wrong.error > wrong.bound


def test_a_motion_that_is_missing_is_noticed() -> None:
    def without_first(motions):
        names = [name for name in motions.__slots__ if name != "restitution"]
        return replace(motions, **{name: getattr(motions, name)[1:] for name in names})

    def without_first_error(errors):
        return tuple(error[1:] for error in errors)

    def without_first_family(families):
        return families[1:]

    assert not broken(motions=without_first, errors=without_first_error, families=without_first_family).right


def test_a_number_that_is_not_finite_is_noticed() -> None:
    with pytest.raises(FloatingPointError, match="motions"):
        broken(motions=lambda m: replace(m, wall_gap=m.wall_gap * np.nan))


def test_a_critical_point_beyond_its_stated_bound_is_noticed() -> None:
    study = PAPER.over()
    assert study.solution.diagram is not None
    assert isinstance(study.solution.design, DesignPoint)
    first, *others = study.solution.critical_points
    value = first.point.sweep_value
    moved = replace(first, point=replace(first.point, sweep_value=value * (1 + 1e-13)))
    diagram = replace(study.solution.diagram, critical_points=(moved, *others))
    found = examine(replace(study, solution=replace(study.solution, diagram=diagram)))
    assert not found.right
    assert first.label in found.text


@pytest.fixture(scope="module")
def outcomes() -> tuple[Outcome, ...]:
    cases = [case for case in catalogue() if case.group in ("restitution", "membrane")]
    return tuple(judge(case) for case in cases)


def test_the_table_is_for_a_terminal(outcomes) -> None:
    text = table_text(outcomes)
    lines = text.splitlines()
    assert max(map(len, lines)) <= 120
    assert {"RESTITUTION", "MEMBRANE"} <= set(lines)
    start = lines[0].index("verdict")
    assert sum(line[start:].strip() == "passed" for line in lines) == len(outcomes)
    assert summary(outcomes) in text


def test_the_machine_form_is_json_and_whole(outcomes) -> None:
    data = json.loads(json.dumps(table_data(outcomes), allow_nan=False))
    assert [row["case"] for row in data] == [outcome.case.name for outcome in outcomes]
    assert {row["verdict"] for row in data} == {"passed"}
    refused = next(row for row in data if row["case"] == "r = 1")
    assert refused["error"] is None
    assert refused["found"].endswith("(allowed here: at most 1 - 1e-06)")


def test_a_run_tells_each_case_as_it_begins(monkeypatch) -> None:
    cases = (Case("one", "group", "", lambda: Finding("")), Case("two", "group", "", lambda: Finding("")))
    monkeypatch.setattr("vireport.extremes.catalogue.catalogue", lambda loaded: cases)
    told: list[str] = []
    assert [outcome.verdict for outcome in run_catalogue(None, told.append)] == ["passed", "passed"]
    assert told == ["group: one", "group: two"]
