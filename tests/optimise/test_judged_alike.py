"""Run and optimise judge alike, whatever is required: what arrays of designs decide, a run decides in the same way."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from design_texts import DEVICE, UNLIMITED, unlimited

from vireport import analyse, loads
from vireport.cli import main
from vireport.gate import REQUIREMENTS, OfMotions, OfShaker, Requirement
from vireport.optimise import DesignGrid, Problem, grid_of, optimise, problem_of
from vireport.optimise.cells import evaluate
from vireport.scenario import LimitKind, Need, Parameter, schema

pytestmark = pytest.mark.usefixtures("without_a_front")

BLOCKS = {
    Need.SWEEP: "sweep: {parameter: length_m, from: 0.55, to: 0.9}\n",
    Need.TOLERANCES: "tolerances: {length_percent: 2, frequency_percent: 3, restitution: 0.05, samples: 256}\n",
    Need.SIMULATION: "simulation: {samples: 2, starts: 1}\n",
    Need.DISTURBANCES: "disturbances: {}\n",
    Need.JITTER: "disturbances: {jitter_m_s: 0.001}\n",
}
"""What requirements need beside a device with all its numbers."""

VARIED = (
    *("{path: excitation.amplitude_n, from: 2, to: 5}", "{path: inclination_deg, from: 5, to: 80}"),
    *("{path: device.restitution, from: 0.35, to: 0.65}", "{path: device.length_m, from: 0.6, to: 0.85}"),
)
DESIGNS, FEW = 50, 6
"""Random designs on which run and search are held against each other; in the quick tests."""


def scenario(requirement: Requirement, given: dict[str, object]) -> str:
    """A scenario with one requirement, the blocks that it needs, and inputs that vary."""
    demand = requirement.demand
    blocks = "".join(text for need, text in BLOCKS.items() if need in demand.needs)
    blocks += "motions: {impacts: 2, periods: 2}\n" if demand.kind is LimitKind.WORDS else ""
    design = f"design: {{maximise: u_ave_v, cells: 16, vary: [{', '.join(VARIED)}]}}\n"
    return f"{DEVICE}{blocks}requirements: {json.dumps(UNLIMITED | given)}\n{design}"


def run(search: Problem, t: np.ndarray):
    """The acceptance table that a run of a design has, by its keys, and whether it has a stable 1:1 motion."""
    study = analyse(loads(search.scenario_text(t)), ("json",))
    return {line.key: line for line in study.criteria}, bool(study.solution.design.motions.stable.any())


def required(requirement: Requirement, designs: np.ndarray) -> dict[str, object]:
    """A limit that some of the designs meet: of numbers the median of what runs find, or the largest allowed."""
    kind = requirement.demand.kind
    if kind is LimitKind.RANGE:
        ends = (0.65, 0.75) if requirement.demand.over is not Parameter.INCLINATION else (20.0, 60.0)
        return dict(zip(requirement.keys, ends, strict=True))
    if kind is LimitKind.WORDS:
        return {requirement.key: "BT"}
    if kind in (LimitKind.AGREEMENT, LimitKind.HELD):
        return {requirement.key: True}
    loose = problem_of(loads(scenario(requirement, {requirement.key: 1e-9 if kind is LimitKind.AT_LEAST else 1e9})))
    values = [
        lines[requirement.key].outcome.value for lines, stable in (run(loose, t) for t in designs[:FEW]) if stable
    ]
    most = schema()["$defs"]["RequirementsBlock"]["properties"][requirement.key].get("maximum", np.inf)
    return {requirement.key: min(float(np.median([value for value in values if value is not None])), most)}


def judged_alike(requirement: Requirement, count: int) -> set[bool]:
    """Whether designs meet a requirement, found out by runs and by the search."""
    designs = np.random.default_rng(7).uniform(size=(count, len(VARIED)))
    search = problem_of(loads(scenario(requirement, required(requirement, designs))))
    grid = DesignGrid(search, (2,) * len(VARIED), designs, evaluate(search, designs))
    within = grid.within()
    kept = set(within[search.may_yield(designs[within])]) & set(grid.passing(within, search.share))
    outcomes = set()
    for row, t in enumerate(designs):
        lines, stable = run(search, t)
        line = lines[requirement.key]
        point = grid.judge(t)
        assert stable == bool(grid.cells.stable[row]) == (point is not None)
        if point is None:
            continue
        assert [own.to_dict() for own in point.study.criteria] == [other.to_dict() for other in lines.values()]
        if row not in kept:
            assert not line.passed
        elif isinstance(requirement.quantity, OfMotions | OfShaker):
            assert line.passed or "not decided" in line.outcome.why
        outcomes.add(line.passed)
    return outcomes


QUICK = ("u_bottom_top_difference_at_most_v", "stroke_at_most_m", "inclination_from_deg", "margin_any_percent")


@pytest.mark.parametrize("requirement", [row for row in REQUIREMENTS if row.key in QUICK], ids=lambda row: row.key)
def test_a_few_designs_are_judged_alike(requirement: Requirement) -> None:
    assert judged_alike(requirement, FEW) == {False, True}


@pytest.mark.slow
@pytest.mark.parametrize("requirement", REQUIREMENTS, ids=lambda row: row.key)
def test_run_and_optimise_judge_designs_alike(requirement: Requirement) -> None:
    outcomes = judged_alike(requirement, DESIGNS)
    assert True in outcomes
    assert False in outcomes or requirement.demand.kind in (LimitKind.AGREEMENT, LimitKind.WORDS)


LENGTH, FORCE = "{path: device.length_m, from: 0.6, to: 0.9}", "{path: excitation.amplitude_n, from: 2, to: 6}"


def looked_for(required: str, cells: int, objective: str = "u_ave_v", vary: tuple[str, ...] = (LENGTH, FORCE)) -> str:
    design = f"design: {{maximise: {objective}, cells: {cells}, vary: [{', '.join(vary)}]}}\n"
    return f"{DEVICE}requirements: {{{unlimited(required)}}}\n{design}"


TILTED = "inclination_from_deg: 0, inclination_to_deg: 88"


@pytest.mark.slow
def test_a_design_that_a_run_passes_is_found_far_down_the_grid() -> None:
    """The designs with the most voltage are not stable when upright."""
    problem = problem_of(loads(looked_for(TILTED, 64, vary=(FORCE,)).replace("length_m: 0.7", "length_m: 0.9")))
    grid = grid_of(problem)
    cells = [grid.t[row] for row in grid.within()]
    passed = next(k for k, t in enumerate(cells) if grid.judge(t).met())
    assert passed > 8
    result = optimise(problem)
    assert result.best.met()
    assert result.best.value >= grid.judged.best.value
    assert result.evidence.complete
    assert all(line.passed for line in run(problem, result.best.t)[0].values())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("required", "objective"),
    [
        (TILTED, "u_ave_v"),
        (TILTED, "margin_percent"),
        ("margin_period_doubling_percent: 12", "u_ave_v"),
        ("margin_period_doubling_percent: 12, inclination_from_deg: 30, inclination_to_deg: 80", "wall_gap"),
    ],
)
def test_no_cell_that_a_run_passes_is_better(required: str, objective: str) -> None:
    problem = problem_of(loads(looked_for(required, 49, objective)))
    result, grid = optimise(problem), grid_of(problem)
    for row in grid.within():
        grid.judge(grid.t[row])
    assert 0 < sum(grid.judged.met.values()) < len(grid.judged.met)
    assert result.best.met()
    assert result.best.value >= grid.judged.best.value * (1 - 1e-9)
    assert result.evidence.complete
    # Those that could have been better do not meet the requirements.
    better = [row for row in grid.within() if grid.cells.value[row] > result.best.value * (1 + 1e-9)]
    assert result.evidence.candidates <= len(better) or objective == "margin_percent"


@pytest.mark.slow
def test_what_was_not_judged_is_not_said_to_fail(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr("vireport.optimise.search.MOST_JUDGED", 4)
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(looked_for("margin_period_doubling_percent: 70", 64, vary=(FORCE,)))
    assert main(["optimise", str(scenario), "-o", str(tmp_path / "out")]) == 1
    said = " ".join(capsys.readouterr().out.split())
    evidence = json.loads((tmp_path / "out/optimise.json").read_text())["evidence"]
    judged, count = evidence["candidates_judged"], evidence["candidates"]
    assert 4 <= judged < count == evidence["within_limits"]
    assert f"None of the {judged} designs judged, of {count} candidates on the grid, meets the requirements" in said
    assert f"The other {count - judged} are open" in said
    assert "no design" not in said.lower()
