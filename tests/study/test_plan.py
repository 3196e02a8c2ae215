"""The plan of a run: every step is run or left out for a reason, and what is not asked for is not listed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from importlib import import_module

import pytest

from vireport import ScenarioError, UsageError, analyse, load, loads
from vireport.base.additions import ADDITIONS
from vireport.cli.app import main
from vireport.scenario.blocks import Scenario, keys_left_out
from vireport.scenario.keys import added_keys
from vireport.study.judging.findings import findings
from vireport.study.plan import ALL_FORMATS, FIGURES, FORMATS, Task, declared_steps, plan

DESIGN = """\
schema_version: 1
device: {capsule_mass_kg: 0.1, ball_mass_kg: 0.004, restitution: 0.5, length_m: 0.7}
excitation: {amplitude_n: 3, frequency_hz: 2}
inclination_deg: 45
"""
SWEEP = "sweep: {parameter: length_m, from: 0.6, to: 0.8}\n"
ELECTRICAL = {"thickness_m": 1e-3, "relative_permittivity": 4.7, "breakdown_field_v_m": 1e8}
SIMULATION = "simulation: {portraits: [0.7], displacement: [0.7], diagram: true}\n"
OTHERS = "motions: {portraits: [BBT]}\naccuracy: {}\ntolerances: {length_percent: 1}\n"
OTHERS += "requirements: {margin_any_percent: 5}\n"
EVERYTHING = f"{DESIGN}{SWEEP}{SIMULATION}{OTHERS}".replace("diagram: true", "diagram: true, follow: up")
EVERYTHING += "disturbances: {jitter_m_s: 0.01, prove: true, basin: true}\n"
if "escape" in ADDITIONS:
    EVERYTHING = EVERYTHING.replace("basin: true", "basin: true, escape: true")
EVERYTHING += "measured: [{impacts: impacts.csv}]\n"
EVERYTHING += "design: {maximise: u_ave_v, vary: [{path: device.length_m, from: 0.6, to: 0.8}]}\n"
EVERYTHING += "".join(f"{block}: {{}}\n" for block in added_keys() if f"\n{block}:" not in EVERYTHING)

INSTEAD = {Task.SAMPLED_FROM_REST, Task.CIRCLES}
"""What is done where there is no design point, or no simulation block."""

ADDED = {row.task for finding in findings().values() for row in finding.steps()}
"""What additions to a study do."""

RECORDED = {"driven", "figure-driven"}
"""What is done where the shaker's acceleration was recorded, of one device."""


def of(text: str, *formats: str, **overrides: object):
    over = {path.replace("__", "."): value for path, value in overrides.items()}
    return plan(loads(text, overrides=over).scenario, formats or FORMATS)


def why(planned, task: Task) -> str:
    (step,) = [step for step in planned.steps if step.task is task]
    assert not step.runs
    return step.why


def test_every_task_is_listed_once_and_runs_where_everything_is_asked_for():
    planned = of(EVERYTHING, *ALL_FORMATS, "certificates", inclination_deg=0, device__membrane=ELECTRICAL)
    assert sorted(step.task for step in planned.steps) == sorted(({*Task} | ADDED) - INSTEAD - RECORDED)
    assert [step.task for step in planned.left_out] == [Task.OPTIMISE]
    assert "vireport optimise" in why(planned, Task.OPTIMISE)


def test_a_record_is_driven_through_the_device_of_the_design_point():
    recorded = "excitation.record"
    planned = of(EVERYTHING, *ALL_FORMATS, **{recorded: "shaker.csv", "design": None})
    assert {step.task for step in planned.steps if step.runs} >= RECORDED
    planned = of(DESIGN + SWEEP, device__length_m=None, **{recorded: "shaker.csv"})
    assert {step.task for step in planned.left_out} >= RECORDED
    assert not planned.runs(*RECORDED)


def test_a_sweep_without_a_design_point_has_outcomes_from_rest_where_nothing_is_stable():
    planned = of(DESIGN + SWEEP, device__length_m=None)
    assert planned.runs(Task.SAMPLED_FROM_REST)
    assert not planned.runs(Task.FROM_REST)


def test_distortion_is_looked_for_where_a_block_or_a_requirement_asks_for_it():
    required = "requirements: {withstands_distortion_percent: 1}\n"
    assert "withstands_distortion_percent" in why(of(DESIGN), Task.DISTORTION)
    assert of(DESIGN + "disturbances: {}\n", "json").runs(Task.DISTORTION)
    assert of(DESIGN + required, "json").runs(Task.DISTORTION)
    # Designs of a search are only judged.
    assert plan(loads(DESIGN + required).scenario, ()).runs(Task.DISTORTION)
    assert not plan(loads(DESIGN + "disturbances: {}\n").scenario, ()).runs(Task.DISTORTION)


def test_a_ball_from_rest_is_followed_along_a_sweep_where_that_is_drawn_or_begins_families():
    assert of(DESIGN + SWEEP, "html").runs(Task.CIRCLES)
    assert of(DESIGN + SWEEP + "motions: {}\n", "json").runs(Task.CIRCLES)
    assert not of(DESIGN + SWEEP, "json").runs(Task.CIRCLES)
    assert not of(DESIGN + "motions: {}\n", "html").runs(Task.CIRCLES)


@pytest.mark.parametrize("text", [DESIGN, DESIGN + SWEEP, EVERYTHING])
@pytest.mark.parametrize("format_", ["png", "svg", "figure-pdf"])
def test_figures_alone_are_those_of_the_report(text: str, format_: str):
    drawn, reported = ({task for task in FIGURES if of(text, own).runs(task)} for own in (format_, "html"))
    assert drawn == reported


@pytest.mark.parametrize("text", [DESIGN, DESIGN + SWEEP, EVERYTHING])
def test_every_step_has_words_of_its_own(text: str):
    steps = of(text).steps
    assert len({step.what for step in steps}) == len(steps)
    for step in steps:
        assert step.what
        assert step.why
        assert "{" not in step.what + step.why


def test_the_time_of_families_grows_with_their_limits():
    def told(impacts: int, periods: int) -> str:
        planned = of(DESIGN + SWEEP + f"motions: {{impacts: {impacts}, periods: {periods}}}\n")
        return next(step.what for step in planned.steps if step.task is Task.MOTIONS)

    assert "about 0.5 s, or up to 2 s where many coexist" in told(4, 1)
    assert "about 5 s, or up to 80 s where many coexist" in told(10, 10)


def test_a_design_point_has_no_branches_and_two_figures():
    planned, drawn = of(DESIGN), {Task.FIGURE_DEVICE, Task.FIGURE_MARGINS}
    assert not planned.runs(Task.BRANCHES, Task.CRITICAL, Task.CSV, *set(FIGURES) - drawn)
    assert planned.runs(Task.DESIGN)
    assert all(planned.runs(figure) for figure in (*drawn, Task.PNG))
    assert why(planned, Task.FIGURE_2) == "no sweep: a single design point has no branches to follow"


def test_reasons_name_what_is_missing():
    planned = of(DESIGN + SWEEP, device__length_m=None, device__ball_mass_kg=None)
    assert why(planned, Task.DESIGN) == "device.length_m is not given"
    assert why(planned, Task.ENERGY) == why(planned, Task.FIGURE_7) == "device.ball_mass_kg is not given"
    assert why(planned, Task.SYMMETRIC).startswith("gravity along the capsule")
    assert why(of(DESIGN, inclination_deg=0, period_ratio=2), Task.SYMMETRIC).startswith("for an even period ratio")


def test_figures_are_drawn_only_where_an_output_shows_them():
    planned = of(EVERYTHING, "json", "csv")
    assert not planned.runs(*FIGURES)
    assert why(planned, Task.FIGURE_2) == "no figure, HTML or PDF is asked for"
    assert why(planned, Task.HTML) == "not among the formats asked for"
    assert of(EVERYTHING, "png").runs(Task.FIGURE_7)


def test_what_only_some_runs_have_is_not_listed_in_the_others():
    listed = {step.task for step in of(DESIGN + SWEEP).steps}
    assert listed.isdisjoint({Task.REQUIREMENTS, "figure-accuracy", Task.JUNIT, Task.MARKDOWN, Task.GITHUB})
    massless = of(EVERYTHING, device__ball_mass_kg=None, design=None)
    assert "figure-accuracy" in {step.task for step in massless.steps}
    assert "figure-stiffness" not in {step.task for step in massless.steps}


def test_cost_of_a_simulation_counts_its_impacts():
    (step,) = [step for step in of(EVERYTHING).steps if step.task is Task.SIMULATION]
    assert "41 x 4 starts x 1000 impacts, about 0.08 s, then followed from value to value (up), about 1 s" in step.what


SLOWED = "{samples: 2, starts: 2, impacts: 100, diagram: false}"


def test_missing_packages_are_named_before_work_begins_with_what_they_do(example, monkeypatch, capsys) -> None:
    planning = import_module("vireport.study.plan")
    blocks = [f"simulation={SLOWED}", "disturbances={prove: true}", "accuracy={}"]
    scenario = load(example("inclined"), blocks).scenario
    assert plan(scenario).lacking == ()
    monkeypatch.setattr(planning, "find_spec", lambda name: None)
    compiled, proofs, digits = plan(scenario, (Task.JSON,)).lacking
    assert compiled == (
        "the package numba is missing: pip install 'vireport[simulation]' "
        "(left out: from-rest-windows, shock, coexistence; some hundred times slower: simulation)"
    )
    assert proofs == "the package python-flint is missing: pip install 'vireport[certify]' (left out: proof)"
    assert digits == "the package mpmath is missing: pip install 'vireport[verify]' (left out: accuracy)"
    # What is drawn of a step that is left out is left out for it, too, where it is asked for.
    assert "figure-shocks" in plan(scenario, (Task.JSON, Task.PNG)).lacking[0]
    assert plan(load(example("inclined")).scenario, (Task.JSON,)).lacking == ()

    def begin(*_: object) -> None:
        raise UsageError("work begins")

    monkeypatch.setattr("vireport.cli.outputs.analyse", begin)
    run = ["run", str(example("inclined")), "--json", "--set", f"simulation={SLOWED}"]
    assert main(run) == 2
    first, last = capsys.readouterr().err.splitlines()
    assert first.startswith("vireport: the package numba is missing: pip install 'vireport[simulation]' (some hundred")
    assert last == "vireport: error: work begins"
    assert main([*run[:2], "-q", "--format", "json", *run[3:]]) == 2
    assert capsys.readouterr().err == "vireport: error: work begins\n"


def test_three_lines_say_what_to_add():
    blocks, inputs, every_step = of(DESIGN).left_out_lines()
    gains = ["disturbances: for shocks, jitter, distortion and switch-on windows", "tolerances: for the yield"]
    gains = [gain for gain in gains if gain.partition(":")[0] in {*Scenario.model_fields} - {*keys_left_out(Scenario)}]
    assert blocks.startswith("Add ")
    gains.append("simulation: for a cross-check from random starts")
    assert {*gains} <= {*blocks.removeprefix("Add ").split("; ")}
    with_outcomes = "disturbances, " if "outcomes" in ADDITIONS else ""
    assert blocks.endswith(f"; vireport run --full adds {with_outcomes}motions and simulation.")
    assert inputs.startswith("Give sweep: for branches, ")
    assert "left_out" in every_step
    (every_step,) = of(EVERYTHING, device__membrane=ELECTRICAL, design=None).left_out_lines()
    assert "left_out" in every_step
    assert of(EVERYTHING, device__membrane=ELECTRICAL).left_out_lines()[-1].startswith("The best design, by vireport")
    _, inputs, _ = of(DESIGN + SWEEP, device__length_m=None, device__ball_mass_kg=None).left_out_lines()
    assert "device.length_m for the motions of one design" in inputs
    assert "; device.ball_mass_kg for voltages" in inputs
    blocks, _ = of(EVERYTHING, tolerances=None, design=None).left_out_lines()[:2]
    assert blocks == "Add tolerances: for the yield."


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("device.friction", 0.01),
        ("excitation.harmonics", [{"order": 2, "percent": 5.0, "phase_deg": 0.0}]),
        ("sweep", {"parameter": "restitution", "from": 0.3, "to": 0.6}),
    ],
)
def test_no_block_is_proposed_that_would_be_refused(path: str, value: object):
    blocks = {own for own in plan(loads(DESIGN + SWEEP).scenario).additions if own.is_block}
    refused = set()
    for block in blocks:
        text = DESIGN + SWEEP
        try:
            loads(text, overrides={path: value, str(block): {"length_percent": 1} if block == "tolerances" else {}})
        except ScenarioError:
            refused.add(block)
    planned = plan(loads(DESIGN + SWEEP, overrides={path: value}).scenario)
    proposed = {own for own in planned.additions if own.is_block}
    assert refused or "checks" not in ADDITIONS
    assert proposed == blocks - refused


COMPUTED = {
    Task.DISTORTION: ("vireport.design.point", "distortions"),
    Task.CIRCLES: ("vireport.design.attractors_from_rest", "attractors_from_rest"),
    Task.REPRODUCTION: ("vireport.study.checks.reproduction", "reproduce"),
    Task.EFFECTS: ("vireport.study.study", "shifts"),
    Task.FROM_REST: ("vireport.design.switched_on", "recovery_of"),
    "from-rest-moments": ("vireport.findings.outcomes.moments", "outcomes_by_moment"),
    "from-rest-windows": ("vireport.findings.outcomes.outcomes", "outcomes_along"),
    "shock": ("vireport.findings.outcomes.withstood", "withstood_by"),
    "coexistence": ("vireport.findings.outcomes.attracting", "attracting_motions"),
    Task.SIMULATION: ("vireport.study.checks.crosscheck", "crosscheck"),
    Task.MOTIONS: ("vireport.motions.atlas.families", "atlas"),
    Task.OWN_STIFFNESS: ("vireport.design.compliant.own_stiffness", "own_stiffness"),
    "tolerances": ("vireport.findings.tolerances.tolerances", "assess_tolerances"),
}
"""The function that does each step, beyond the solution itself; of steps of additions, those that are there."""
COMPUTED = {task: home for task, home in COMPUTED.items() if task in {row.task for row in declared_steps()}}

SHORT = f"{DESIGN}{SWEEP}"
LONGER = {
    "disturbances": "disturbances: {}\n",
    "simulation": "simulation: {samples: 2, starts: 1, impacts: 100}\n",
    "tolerances": "tolerances: {length_percent: 0.1, samples: 64}\n",
    "motions": "motions: {impacts: 2, periods: 1}\n",
}


@pytest.mark.parametrize("block", [None, *[pytest.param(own, marks=pytest.mark.slow) for own in LONGER]])
@pytest.mark.parametrize("format_", ["json", "html"])
def test_what_the_plan_lists_is_computed_and_nothing_else(block: str | None, format_: str, monkeypatch) -> None:
    calls: Counter[Task] = Counter()

    def counted(task: Task, of: Callable[..., object]) -> Callable[..., object]:
        def call(*given: object, **more: object) -> object:
            calls[task] += 1
            return of(*given, **more)

        return call

    for task, (module, name) in COMPUTED.items():
        home = import_module(module)
        monkeypatch.setattr(home, name, counted(task, getattr(home, name)))
    study = analyse(loads(SHORT + LONGER.get(block or "", "")), (format_,))
    assert study.verdict
    if study.plan.runs(Task.HTML):
        assert study.reproduction is not None
    ran = {task for task in COMPUTED if study.plan.runs(task)}
    assert set(calls) == ran


@pytest.mark.slow
def test_what_was_not_looked_for_is_null_and_says_why() -> None:
    plain, asked = (analyse(loads(DESIGN + more), ("json",)).to_dict() for more in ("", "disturbances: {}\n"))
    design = plain["design_point"]
    assert design["distortion"] is None
    (left_out,) = [row for row in plain["left_out"] if row["step"] == "distortion"]
    assert design["distortion_reason"] == left_out["why"]
    assert {row["order"] for row in asked["design_point"]["distortion"]} == {2, 3}
    assert asked["design_point"]["distortion_reason"] is None
    assert plain["design_point"].keys() == asked["design_point"].keys()
    assert plain["disturbances"]["from_rest"].keys() == asked["disturbances"]["from_rest"].keys()
