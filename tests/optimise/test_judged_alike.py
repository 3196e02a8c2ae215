"""Run and optimise judge alike, whatever is required: what arrays of designs decide, a run decides in the same way."""

from __future__ import annotations

import json
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from design_texts import DEVICE, UNLIMITED, unlimited

from vireport import analyse, loads
from vireport.cli.app import main
from vireport.optimise import outputs
from vireport.optimise.cells import evaluate
from vireport.optimise.grid import DesignGrid, grid_of, judged_design
from vireport.optimise.problem import Problem, problem_of
from vireport.optimise.search import SearchEvidence, SearchResult, optimise
from vireport.scenario.demands import LimitKind, Need
from vireport.scenario.json_schema import schema
from vireport.scenario.parameters import Parameter
from vireport.study.judging.requirements import OfMotions, OfShaker, Requirement, requirements
from vireport.study.judging.verdict import Conclusion, Status

pytestmark = pytest.mark.usefixtures("without_a_front")

BLOCKS = {
    Need.SWEEP: "sweep: {parameter: length_m, from: 0.55, to: 0.9}\n",
    Need.TOLERANCES: "tolerances: {length_percent: 2, frequency_percent: 3, restitution: 0.05, samples: 256}\n",
    Need.SIMULATION: "simulation: {samples: 2, starts: 1}\n",
    Need.DISTURBANCES: "disturbances: {}\n",
    Need.JITTER: "disturbances: {jitter_m_s: 0.001}\n",
    Need.ESCAPE: "disturbances: {jitter_m_s: 0.4, escape: true}\n",
}
"""What requirements need beside a device with all its numbers."""

VARIED = (
    *("{path: excitation.amplitude_n, from: 2, to: 5}", "{path: inclination_deg, from: 5, to: 80}"),
    *("{path: device.restitution, from: 0.35, to: 0.65}", "{path: device.length_m, from: 0.6, to: 0.85}"),
)
DESIGNS, FEW, WRITTEN = 10, 6, 2
"""Random designs on which run and search are held against each other; those whose medians are required; those of which
the run has outputs: what only these show, as outcomes along a sweep, takes three times as long and decides nothing."""


APART = {LimitKind.WORDS: 1, LimitKind.RANGE: 2}
"""Limits that change what other limits are asked of: a required range is the one over which voltages may differ."""

COSTLY = {Need.TOLERANCES: 3, Need.SIMULATION: 4, Need.DISTURBANCES: 5, Need.JITTER: 5, Need.ESCAPE: 6}


def runs_of(requirement: Requirement) -> int:
    """What runs it is judged of: requirements of the same runs are judged of them together, each by itself."""
    demand = requirement.demand
    return APART.get(demand.kind, max((COSTLY.get(need, 0) for need in demand.needs), default=0))


GROUPS = [tuple(rows) for _, rows in groupby(sorted(requirements(), key=runs_of), runs_of)]


def scenario(requirements: Iterable[Requirement], given: dict[str, object]) -> str:
    """A scenario with some requirements, the blocks that they need, and inputs that vary."""
    demands = [requirement.demand for requirement in requirements]
    needs = {need for demand in demands for need in demand.needs}
    needs -= {Need.DISTURBANCES} if Need.JITTER in needs else set()
    blocks = "".join(text for need, text in BLOCKS.items() if need in needs)
    blocks += "motions: {impacts: 2, periods: 2}\n" if any(demand.kind is LimitKind.WORDS for demand in demands) else ""
    design = f"design: {{maximise: u_ave_v, cells: 16, vary: [{', '.join(VARIED)}]}}\n"
    return f"{DEVICE}{blocks}requirements: {json.dumps(UNLIMITED | given)}\n{design}"


def run(search: Problem, t: np.ndarray, formats: tuple[str, ...] = ("json",)):
    """The acceptance table that a run of a design has, by its keys, and whether it has a stable 1:1 motion."""
    study = analyse(loads(search.scenario_text(t)), formats)
    return {line.key: line for line in study.criteria}, bool(study.solution.design.motions.stable_mask.any())


def joined(limits: dict[str, dict[str, object]]) -> dict[str, object]:
    return {key: limit for given in limits.values() for key, limit in given.items()}


def required(requirements: tuple[Requirement, ...], designs: np.ndarray) -> dict[str, dict[str, object]]:
    """For each a limit that some designs meet: of numbers the median of what runs find, or the largest allowed."""
    limits: dict[str, dict[str, object]] = {}
    for requirement in requirements:
        kind = requirement.demand.kind
        if kind is LimitKind.RANGE:
            ends = (0.65, 0.75) if requirement.demand.over is not Parameter.INCLINATION else (20.0, 60.0)
            limits[requirement.key] = dict(zip(requirement.keys, ends, strict=True))
        elif kind is LimitKind.WORDS:
            limits[requirement.key] = {requirement.key: "BT"}
        elif kind in (LimitKind.AGREEMENT, LimitKind.HELD):
            limits[requirement.key] = {requirement.key: True}
        else:
            limits[requirement.key] = {requirement.key: 1e-9 if kind is LimitKind.AT_LEAST else 1e9}
    loose = problem_of(loads(scenario(requirements, joined(limits))))
    found = [lines for lines, stable in (run(loose, t, ()) for t in designs[:FEW]) if stable]
    for requirement in requirements:
        key = requirement.key
        if requirement.demand.kind in (LimitKind.AT_LEAST, LimitKind.AT_MOST):
            values = [value for lines in found if (value := lines[key].outcome.value) is not None]
            most = schema()["$defs"]["RequirementsBlock"]["properties"][key].get("maximum", np.inf)
            limits[key] = {key: min(float(np.median(values)), most)}
    return limits


def judged_alike(requirements: tuple[Requirement, ...], count: int) -> dict[str, set[bool]]:
    """Whether designs meet each of some requirements, found out by runs and by the search."""
    designs = np.random.default_rng(7).uniform(size=(count, len(VARIED)))
    limits = required(requirements, designs)
    kept = {}
    for requirement in requirements:
        alone = problem_of(loads(scenario((requirement,), limits[requirement.key])))
        grid = DesignGrid(alone, (2,) * len(VARIED), designs, evaluate(alone, designs))
        within = grid.within()
        kept[requirement.key] = set(within[alone.may_yield(designs[within])]) & set(grid.passing(within, alone.share))
    together = problem_of(loads(scenario(requirements, joined(limits))))
    grid = DesignGrid(together, (2,) * len(VARIED), designs, evaluate(together, designs))
    outcomes: dict[str, set[bool]] = {requirement.key: set() for requirement in requirements}
    for row, t in enumerate(designs):
        lines, stable = run(together, t, ("json",) if row < WRITTEN else ())
        point = grid.judge(t)
        assert stable == bool(grid.cells.stable[row]) == (point is not None)
        if point is None:
            continue
        # Of a required word outputs tell the share of starts that come to it as well.
        told = {"why"} if row < WRITTEN else set()
        for own in point.study.criteria:
            one, other = own.to_dict(), lines[own.key].to_dict()
            assert {key: one[key] for key in one.keys() - told} == {key: other[key] for key in other.keys() - told}
        assert [own.key for own in point.study.criteria] == [*lines]
        for requirement in requirements:
            line = lines[requirement.key]
            if row not in kept[requirement.key]:
                assert not line.passed
            elif isinstance(requirement.quantity, OfMotions | OfShaker):
                assert line.passed or "not decided" in str(line.outcome.why)
            outcomes[requirement.key].add(line.passed)
    return outcomes


@pytest.mark.slow
@pytest.mark.parametrize("requirements", GROUPS, ids=lambda group: "-".join(row.key for row in group[:2]))
def test_run_and_optimise_judge_designs_alike(requirements: tuple[Requirement, ...]) -> None:
    count = DESIGNS if runs_of(requirements[0]) < COSTLY[Need.DISTURBANCES] else DESIGNS // 2
    for key, outcomes in judged_alike(requirements, count).items():
        kind = next(row for row in requirements if row.key == key).demand.kind
        assert True in outcomes, key
        assert False in outcomes or kind in (LimitKind.AGREEMENT, LimitKind.WORDS), key


KINDS = {
    "as it is": ("restitution: 0.5", "restitution: 0.5"),
    "a free capsule": ("restitution: 0.5", "restitution: 0.5\n  capsule: free"),
    "two restitutions": ("restitution: 0.5", "restitution_bottom: 0.6\n  restitution_top: 0.4"),
    "horizontal": ("inclination_deg: 45", "inclination_deg: 0"),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_what_starts_by_itself_is_told_without_a_run(kind: str) -> None:
    device = DEVICE.replace(*KINDS[kind])
    vary = "{path: device.length_m, from: 0.3, to: 1.2}, {path: excitation.amplitude_n, from: 1.5, to: 6}"
    required = f"requirements: {{{unlimited('reached_from_rest: true')}}}\n"
    problem = problem_of(loads(f"{device}{required}design: {{maximise: u_ave_v, cells: 16, vary: [{vary}]}}\n"))
    told = set()
    for t in np.random.default_rng(5).uniform(size=(24, 2)):
        reached = problem.study(t).evidence.is_reached_from_rest
        assert problem.starts(t) is reached
        told.add(reached)
    assert told == {False, True}


def test_a_run_alone_tells_whether_a_design_starts_at_any_moment_or_comes_to_a_word() -> None:
    vary = f"design: {{maximise: u_ave_v, cells: 16, vary: [{LENGTH}]}}\n"
    start = f"{DEVICE}{vary}requirements: {{reached_from_rest: true"
    for text in (
        f"{start}}}\ndisturbances: {{}}\n",
        f"{start}, word: BT}}\nmotions: {{impacts: 2}}\nsweep: {{parameter: length_m, from: 0.6, to: 0.8}}\n",
    ):
        assert problem_of(loads(text)).starts(np.array([0.5])) is None
    assert problem_of(loads(f"{start}}}\n")).starts(np.array([0.5])) is True


def test_a_design_that_does_not_start_takes_no_run_once_one_is_nearest(monkeypatch: pytest.MonkeyPatch) -> None:
    text = f"{DEVICE}requirements: {{{unlimited('reached_from_rest: true')}}}\n"
    text += f"design: {{maximise: u_ave_v, cells: 16, vary: [{LENGTH}]}}\n"
    grid, runs = grid_of(problem_of(loads(text))), list[float]()
    monkeypatch.setattr(Problem, "starts", lambda problem, t: bool(t[0] > 0.9))

    def judged(problem: Problem, t: np.ndarray):
        runs.append(float(t[0]))
        return judged_design(problem, t)

    monkeypatch.setattr("vireport.optimise.grid.judged_design", judged)
    points = [grid.judge_better(np.array([share])) for share in (0.4, 0.6, 1.0)]
    assert [point is None for point in points] == [False, True, False]
    assert runs == [0.4, 1.0]
    assert grid.judged.count == len(grid.judged.verdicts) == 3


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
    passed = next(k for k, t in enumerate(cells) if grid.judge(t).meets_requirements())
    assert passed > 8
    result = optimise(problem)
    assert result.best.meets_requirements()
    assert result.best.value >= grid.judged.best.value
    assert result.evidence.complete
    assert all(line.passed for line in run(problem, result.best.t)[0].values())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("required", "objective"),
    [
        (TILTED, "u_ave_v"),
        ("margin_period_doubling_percent: 12", "u_ave_v"),
        ("margin_period_doubling_percent: 12, inclination_from_deg: 30, inclination_to_deg: 80", "wall_gap"),
    ],
)
def test_no_cell_that_a_run_passes_is_better(required: str, objective: str) -> None:
    problem = problem_of(loads(looked_for(required, 16, objective)))
    result, grid = optimise(problem), grid_of(problem)
    for row in grid.within():
        grid.judge(grid.t[row])
    assert 0 < sum(grid.judged.verdicts.values()) < len(grid.judged.verdicts)
    assert result.best.meets_requirements()
    assert result.best.value >= grid.judged.best.value * (1 - 1e-9)
    assert result.evidence.complete
    # Those that could have been better do not meet the requirements.
    better = [row for row in grid.within() if grid.cells.value[row] > result.best.value * (1 + 1e-9)]
    assert result.evidence.candidates <= len(better)


@pytest.mark.slow
def test_what_was_not_judged_is_not_said_to_fail(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr("vireport.optimise.search.MOST_JUDGED", 4)
    monkeypatch.setattr("vireport.optimise.search.MOST_REFINED", 1)
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(looked_for("margin_period_doubling_percent: 70", 64, vary=(FORCE,)))
    assert main(["optimise", str(scenario), "-o", str(tmp_path / "out"), "-v"]) == 1
    said = " ".join(capsys.readouterr().out.split())
    evidence = json.loads((tmp_path / "out/optimise.json").read_text())["evidence"]
    judged, count = evidence["candidates_judged"], evidence["candidates"]
    assert 4 <= judged < count == evidence["within_limits"]
    assert f"None of the {judged} designs judged, of {count} candidates on the grid, meets the requirements" in said
    assert f"meet the requirements, and were not judged: {count - judged}." in said
    assert "no design" not in said.lower()


STIFF = """\
schema_version: 1
device:
  capsule_mass_kg: 0.1245
  ball_mass_kg: 0.002
  restitution: 0.5
  length_m: 0.7
  membrane: {stiffness: 3.0e+7, active_radius_m: 8.0e-3, ball_radius_m: 6.0e-3}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
inclination_deg: 45
"""
"""A device of which nothing but the margin is doubtful."""


@pytest.mark.slow
def test_no_opening_is_green_where_less_is_left_to_use_than_is_required() -> None:
    """Of random designs that meet the requirement by rigid impacts, some leave less with a neglected effect."""
    vary = "{path: device.length_m, from: 0.69, to: 0.80}, {path: excitation.frequency_hz, from: 1.98, to: 2.05}"
    search = problem_of(
        loads(f"{STIFF}requirements: {{margin_any_percent: 5}}\ndesign: {{minimise: length_m, vary: [{vary}]}}\n")
    )
    told = set()
    for t in np.random.default_rng(3).uniform(size=(6, 2)):
        best = judged_design(search, t)
        if best is None or not best.meets_requirements():
            continue
        result = SearchResult(search, best, None, (), SearchEvidence((2, 2), 4, 4))
        study = analyse(loads(search.scenario_text(t)), ("json",))
        use = study.verdict.margin.data.to_use
        short = use.gone or use.relative < 0.05
        assert (Conclusion.MARGIN_SHORT in study.verdict.conclusions) is short
        run, optimum = study.opening.worded(), outputs.opening(result, outputs.run_of(result)).worded()
        assert (run.status is Status.GOOD) is not short
        assert optimum.status is run.status
        assert optimum.facts[0] == (run.status, run.sentence)
        assert optimum.tiles == run.tiles
        assert any("by rigid impacts only" in text for _, text in optimum.facts) is short
        told.add(short)
    assert told == {False, True}
