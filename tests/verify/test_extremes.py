"""The rows of extreme cases, which `vireport verify --extremes` runs: all pass, and planted faults are caught."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES, first
from msgspec import convert
from msgspec.structs import replace

from vireport import load
from vireport.base.encoding import json_text
from vireport.base.errors import NumericalError
from vireport.motions.one_to_one import Motions
from vireport.scenario.parameters import Parameter
from vireport.study.study import Study
from vireport.verify import critical, motions
from vireport.verify.catalogue import catalogue, run_catalogue
from vireport.verify.harvester import Harvester, harvester_of
from vireport.verify.results import CaseData, cases_data
from vireport.verify.rows import Case, CaseFinding, CaseVerdict, NotThereError, as_text, exit_status, run

UNLIKE = {"device.restitution": None, "device.restitution_bottom": 0.55, "device.restitution_top": 0.45}
CHEAP = ("restitution", "inclination", "length", "membrane", "grazing")
AROUND_UNLIKE = (
    "inclination: beta = 0 deg",
    "critical points: 0.0001 inside a fold",
    "critical points: narrow range of foci, gbar = 0.001",
    "grazing: gap +1e-14",
)
CASES = {row.title: row for row in catalogue()}
"""Around the paper's device, which has every point of the catalogue."""

HORIZONTAL = [row for row in catalogue(load(EXAMPLES / "horizontal.yaml")) if row.group in CHEAP]
OF_UNLIKE = [row for row in catalogue(load(EXAMPLES / "inclined.yaml", UNLIKE)) if row.title in AROUND_UNLIKE]


@pytest.mark.slow
@pytest.mark.parametrize("row", [*CASES.values(), *HORIZONTAL, *OF_UNLIKE], ids=lambda row: row.title)
def test_every_case_passes(row: Case) -> None:
    outcome = run(row)
    assert outcome.verdict is CaseVerdict.PASSED, outcome.finding


PITCHFORK, GRAZE = "critical points: pitchfork", "grazing: gap 0"


@pytest.mark.parametrize(
    ("name", "over", "title"), [("horizontal", UNLIKE, PITCHFORK), ("inclined", {"device.restitution": 0}, GRAZE)]
)
def test_a_point_that_a_device_does_not_have_does_not_apply(name: str, over, title: str, example) -> None:
    rows = {row.title: row for row in catalogue(load(example(name), over))}
    assert run(rows[title]).verdict is CaseVerdict.DOES_NOT_APPLY


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
    with pytest.raises(NumericalError, match=r"device\.restitution"):
        run_catalogue(load(example("inclined"), ["device.restitution=1"]))


def of_motions(change: Callable[[Motions], Motions]) -> Callable[[Study], Study]:
    def altered(study: Study) -> Study:
        design = study.solution.design
        return replace(study, solution=replace(study.solution, design=replace(design, motions=change(design.motions))))

    return altered


def of_diagram(name: str, change: Callable[[tuple], tuple]) -> Callable[[Study], Study]:
    def altered(study: Study) -> Study:
        diagram = study.solution.diagram
        diagram = replace(diagram, **{name: change(getattr(diagram, name))})
        return replace(study, solution=replace(study.solution, diagram=diagram))

    return altered


def every_other(motions: Motions) -> Motions:
    arrays = (name for name in Motions.__struct_fields__ if name != "restitution")
    return replace(motions, **{name: getattr(motions, name)[1::2] for name in arrays})


def moved(points: tuple) -> tuple:
    return (replace(points[0], sweep_value=points[0].sweep_value * (1 + 1e-13)), *points[1:])


def another_trace(branches: tuple) -> tuple:
    return tuple(replace(x, motions=replace(x.motions, trace=x.motions.trace + 1e-8)) for x in branches)


STUDY = Harvester, "study"
FAULTS: tuple[tuple[str, str, tuple[Any, str], Callable[[Any], Any]], ...] = (
    ("membrane: deflection rb", "another voltage", (motions, "voltages"),
     lambda volts: replace(volts, average_v=volts.average_v * (1 + 1e-9))),
    ("length: d = 0.001", "a number that is not finite", STUDY,
     of_motions(lambda m: replace(m, wall_gap=m.wall_gap * np.nan))),
    ("inclination: beta = 90 deg", "a velocity off in the tenth digit", STUDY,
     of_motions(lambda m: replace(m, velocity_bottom=m.velocity_bottom * (1 + 1e-10)))),
    ("sweep: relative width 2e-9", "a motion that is missing", STUDY, of_motions(every_other)),
    ("sweep: reversed", "a critical point beyond its bound", STUDY, of_diagram("critical_points", moved)),
    ("gravity over forcing: gbar = 1e-14", "another trace", STUDY, of_diagram("branches", another_trace)),
    ("critical points: fold", "a fold that is moved", (critical, "_points"), moved),
    ("critical points: 1e-06 inside a fold", "one of the two motions", STUDY, of_motions(every_other)),
    ("grazing: gap +1e-14", "a motion called inadmissible", STUDY,
     of_motions(lambda m: replace(m, admissible_mask=~m.admissible_mask))),
    ("critical points: narrow range of foci, gbar = 0.001", "two changes that are missing", STUDY,
     of_diagram("critical_points", lambda points: tuple(p for p in points if p.label not in ("A1", "A2")))),
)  # fmt: skip


@pytest.mark.parametrize(("title", "fault", "place", "alter"), first(7, FAULTS, unpacked=True))
def test_a_planted_fault_is_caught(title: str, fault: str, place, alter, monkeypatch) -> None:
    original = getattr(*place)
    monkeypatch.setattr(*place, lambda *arguments: alter(original(*arguments)))
    (row,) = (row for row in catalogue() if row.title == title)
    assert run(row).verdict is CaseVerdict.FAILED


def test_an_answer_where_a_refusal_is_due_is_caught() -> None:
    row = CASES["restitution: r = 1"]
    assert run(row).verdict is CaseVerdict.PASSED
    assert run(row._replace(check=lambda *_: CaseFinding(""))).verdict is CaseVerdict.FAILED


def test_an_error_an_exception_and_a_warning_fail() -> None:
    def refuse() -> CaseFinding:
        raise NumericalError("device.restitution: too large")

    def warn() -> CaseFinding:
        warnings.warn("divide by zero", RuntimeWarning, stacklevel=1)
        return CaseFinding("")

    def of(check: Callable[[], CaseFinding], **more: Any) -> str:
        return run(Case("group", "made up", check, **more)).verdict

    assert of(lambda: CaseFinding("", 1e-13, 1e-12)) == "passed"
    assert of(lambda: CaseFinding("", 1e-11, 1e-12)) == "failed"
    assert of(lambda: CaseFinding("", float("nan"), 1e-12)) == "failed"
    assert of(lambda: CaseFinding(str(1 // 0))) == "failed"
    assert of(lambda: CaseFinding(str(np.float64(1) / np.float64(0)))) == "failed"
    assert of(warn) == "failed"
    assert of(refuse) == "failed"
    assert of(refuse, refusal="sweep") == "failed"
    assert of(refuse, refusal="restitution") == "passed"
    assert of(lambda: CaseFinding("an answer"), refusal="restitution") == "passed"
    assert of(lambda: CaseFinding("an answer"), refusal="restitution", answer=False) == "failed"


def made_up() -> list[Case]:
    def absent() -> CaseFinding:
        raise NotThereError("no fold")

    return [
        Case("group", "right", lambda: CaseFinding("an answer", 1e-13)),
        Case("group", "wrong", lambda: CaseFinding("another " * 60, 1e-3)),
        Case("group", "absent", absent),
    ]


def test_text_is_for_a_terminal_and_the_data_are_json(monkeypatch) -> None:
    monkeypatch.setattr("vireport.verify.catalogue.catalogue", lambda loaded: made_up())
    told: list[str] = []
    outcomes = run_catalogue(None, told.append)
    assert told == ["group: right", "group: wrong", "group: absent"]
    wrong, _, *summary = as_text(outcomes).splitlines()
    assert summary[0] == "Of 2 extreme cases that apply to this device 1 failed."
    assert re.fullmatch(
        r"Checked: 2 answers against 40 digits, 0 others; Worst error: 0.001 \(allowed 1 × 10⁻¹¹\); Time: .*s",
        summary[1],
    )
    assert summary[2] == "Cases that do not apply to this device: 1."
    right, again, absent, *_ = as_text(outcomes, every=True).splitlines()
    assert again == wrong
    assert right == "passed  group: right: an answer, error 1 × 10⁻¹³, allowed 1 × 10⁻¹¹"
    assert re.fullmatch(r"FAILED  group: wrong: (another )+\.\.\., error 0\.001, allowed 1 × 10⁻¹¹", wrong)
    assert absent == "does not apply  group: absent: no fold"
    well = as_text(outcomes[:1]).splitlines()
    assert well[0] == "All 1 extreme cases that apply to this device pass."
    assert len(well) == 2
    assert as_text(outcomes[2:]) == "No extreme case applies to this device.\n"
    data = convert(json.loads(json_text(cases_data(outcomes))), list[CaseData])
    assert [(row.case, row.error, row.bound, row.verdict) for row in data] == [
        ("right", 1e-13, 1e-11, "passed"),
        ("wrong", 1e-3, 1e-11, "failed"),
        ("absent", None, None, "does not apply"),
    ]
    assert exit_status(outcomes) == (1, "1 of 3 cases failed")


def test_no_time_decides_a_case(monkeypatch) -> None:
    """A clock on which every case takes an hour."""
    clock = iter(range(0, 1_000_000, 3600))
    monkeypatch.setattr("vireport.verify.rows.perf_counter", lambda: next(clock))
    outcome = run(CASES["membrane: deflection rb"])
    assert (outcome.verdict, outcome.seconds) == (CaseVerdict.PASSED, 3600)
