"""The best design as it can be built."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import EXAMPLES
from design_texts import DEVICE, unlimited
from msgspec.structs import replace

from vireport.base.records import plain
from vireport.cli.outputs import PageSettings
from vireport.optimise import outputs
from vireport.optimise.built import LOSS, built_design
from vireport.optimise.grid import JudgedDesign, judged_design
from vireport.optimise.problem import Problem, problem_of
from vireport.optimise.results import OptimiseData
from vireport.optimise.search import SearchEvidence, SearchResult, optimise
from vireport.scenario.loading import load, loads
from vireport.study.judging.verdict import Status
from vireport.study.provenance import provenance_of
from vireport.study.reading import read_record
from vireport.text.folders import TEMPLATES

LENGTH = "{path: device.length_m, from: 0.4, to: 1.0}"


@cache
def shortest() -> SearchResult:
    """The shortest device that has a margin of 5 %: what is shorter, also by rounding, fails that."""
    required = unlimited("margin_any_percent: 5")
    design = f"design: {{minimise: length_m, cells: 16, vary: [{LENGTH}]}}"
    return optimise(problem_of(loads(f"{DEVICE}requirements: {{{required}}}\n{design}\n")))


def test_a_design_is_rounded_to_the_first_that_meets_all(monkeypatch: pytest.MonkeyPatch) -> None:
    design = f"design: {{maximise: u_ave_v, cells: 16, vary: [{LENGTH}]}}"
    problem = problem_of(loads(f"{DEVICE}requirements: {{{unlimited('margin_any_percent: 5')}}}\n{design}\n"))
    best = judged_design(problem, np.array([0.5912345]))
    tried: list[float] = []

    def judged(problem: Problem, t: np.ndarray) -> JudgedDesign:
        tried.append(float(problem.values(t)[0]))
        return replace(best, t=t, repeats=len(tried) == 3)

    monkeypatch.setattr("vireport.optimise.built.judged_design", judged)
    built = built_design(problem, best)
    assert len(tried) == 3
    assert float(problem.values(built.t)[0]) == tried[-1]


@pytest.mark.slow
def test_a_rounded_design_has_few_digits_meets_all_and_loses_little() -> None:
    result = shortest()
    (value,), (exact,) = (result.problem.values(point.t).tolist() for point in (result.built, result.best))
    assert value == pytest.approx(float(f"{value:.3g}"), rel=1e-14)
    # Rounded to the nearest it would be shorter, and fail, or longer: only the latter is taken.
    assert exact < value < exact * (1 + LOSS)
    assert result.built.meets_requirements()
    below = result.problem.study((np.array([float(f"{exact:.3g}") - 0.001]) - 0.4) / 0.6)
    assert not all(line.passed for line in below.criteria)


@pytest.mark.slow
def test_page_and_files_are_of_the_rounded_design_and_json_has_both() -> None:
    result = shortest()
    (value,), (exact,) = (result.problem.values(point.t).tolist() for point in (result.built, result.best))
    study = outputs.run_of(result)
    assert study.solution.device.length_m == value
    told = outputs.text(result, study, tables=True)
    first, numbers, fact, *_ = told.splitlines()
    assert outputs.text(result, study).splitlines() == [first, numbers, fact]
    assert first == f"Best: length {value:.3g} m."
    own = study.opening.worded()
    assert numbers == own.lines[1]
    assert fact == own.sentence
    assert f"{value:.3g}" in next(line for line in told.splitlines() if line.startswith("device.length_m"))
    assert "Rounded so that it can be built" in told
    written = outputs.files(result, study, provenance_of(result.problem.loaded, "x"), PageSettings())
    assert loads(written["best.yaml"].decode()).scenario.device.length_m == value
    assert loads(written["unrounded.yaml"].decode()).scenario.device.length_m == exact
    data = json.loads(written["optimise.json"])
    assert [data[name]["inputs"]["device.length_m"] for name in ("best", "built")] == [exact, value]
    search = {key: value for key, value in data.items() if key not in ("schema_version", "provenance")}
    assert plain(read_record(data, OptimiseData, "optimise.json")) == search
    assert data["built"]["alerts"] == [alert.to_dict() for alert in study.alerts]


@pytest.mark.slow
def test_what_an_optimum_opens_with_is_what_a_run_of_it_says() -> None:
    result = shortest()
    study = outputs.run_of(result)
    opening, run = outputs.opening(result, study).worded(), study.opening.worded()
    assert opening.status is run.status
    assert opening.tiles == run.tiles  # the objective, a length, stands in the sentence
    assert opening.facts[0] == (run.status, run.sentence)
    grave = [fact for fact in run.facts if fact[0] in (Status.BAD, Status.CAUTION)]
    assert list(opening.facts[1 : 1 + len(grave)]) == grave


def edged() -> SearchResult:
    """As a search might end whose best design is at two limits."""
    vary = f"{LENGTH}, {{path: excitation.frequency_hz, from: 2.0, to: 3.0}}"
    problem = problem_of(loads(f"{DEVICE}design: {{maximise: stroke_m, cells: 16, vary: [{vary}]}}\n"))
    best = judged_design(problem, np.array([1.0, 0.0]))
    return SearchResult(problem, best, None, (), SearchEvidence((4, 4), 9, 9), built_design(problem, best))


@pytest.mark.slow
def test_limits_and_the_objective_are_named_in_the_words_of_the_templates(tmp_path: Path) -> None:
    result = edged()
    opening = outputs.opening(result, outputs.run_of(result))
    limits = (
        "At the upper limit of length_m, at the lower limit of frequency_hz: a wider range may hold a better design."
    )
    worded = opening.worded()
    assert limits in [text for _, text in worded.facts]
    assert worded.tiles[0].label == "Stroke of the shaker"
    assert worded.tiles[0].value.replace("\u00a0", " ") == f"{1e3 * result.best.value:.3g} mm"
    words = (TEMPLATES / "words" / "optimise.j2").read_text()
    for before, after in (
        ("the upper limit of", "the top of"),
        ("{{ name }} {{ value }}", "{{ name }} of {{ value }}"),
        ("In the scenario", "Before"),
    ):
        assert before in words
        words = words.replace(before, after)
    (tmp_path / "words").mkdir()
    (tmp_path / "words" / "optimise.j2").write_text(words)
    reworded = opening.worded(tmp_path)
    assert limits.replace("the upper limit of", "the top of") in [text for _, text in reworded.facts]
    (length, frequency) = (f"{value:.3g}" for value in result.problem.values(result.reported.t))
    assert reworded.sentence == f"Best: length of {length} m, frequency of {frequency} Hz."
    (table, *_), _ = outputs.section(result, tmp_path)
    assert [column.title for column in table.columns][1:3] == ["Value", "Before"]
    terminal = outputs.text(result, outputs.run_of(result), tmp_path, tables=True)
    assert reworded.sentence in terminal.splitlines()
    assert "In the scenario" not in terminal


@pytest.mark.slow
def test_a_design_that_starts_by_chance_is_not_taken() -> None:
    """A long irregular beginning ends at these numbers on the motion, and 0.1 % beside them it does not."""
    problem = problem_of(load(EXAMPLES / "best-design.yaml"))
    chance = np.array([1.0743718592964824 + 2e-7 - 0.2, (2.1608040201005023 - 1.0) / 3])
    point = judged_design(problem, chance)
    assert all(line.passed for line in point.study.criteria)
    assert not point.repeats
    assert not point.meets_requirements()
    assert built_design(problem, point) is None
    steady = judged_design(problem, np.array([1.13 - 0.2, (2.02 - 1.0) / 3]))
    assert steady.meets_requirements()


@pytest.mark.slow
def test_a_design_at_an_end_of_its_range_stays_there() -> None:
    result = shortest()
    at_end = result.problem.study(np.array([1.0]))
    best = type(result.best)(np.array([1.0]), at_end, result.problem.value_of(at_end, np.array([1.0])))
    built = built_design(result.problem, best)
    assert built.t.tolist() == [1.0]


def test_inputs_that_are_no_margins_stand_with_name_and_unit_of_their_keys() -> None:
    """As they are declared, and with the prefix that brings the number between 1 and 1000."""
    paths = {"bias_voltage_v": (80, 2080), "stiffness": (4e5, 5e5), "ball_radius_m": (0.001, 0.0057)}
    vary = ", ".join(f"{{path: device.membrane.{key}, from: {low}, to: {high}}}" for key, (low, high) in paths.items())
    design = f"design: {{maximise: u_ave_v, cells: 27, vary: [{vary}]}}"
    problem = problem_of(loads(f"{DEVICE}requirements: {{{unlimited()}}}\n{design}\n"))
    best, other = (judged_design(problem, np.array([t, 0.5, 1.0])) for t in (0.5, 2 / 3))
    result = SearchResult(problem, best, None, (best, other), SearchEvidence((3, 3, 3), 27, 27))
    sentence = outputs.opening(result, best.study).worded().sentence
    assert sentence == "Best: bias voltage 1.08 kV, stiffness 450 kN/mʰ, ball radius 5.7 mm."
    rows = [line.split()[-3:] for line in outputs.text(result, best.study, tables=True).splitlines()]
    assert ["1410", "450000", "0.0057"] in rows  # and not 1413.3333 V
