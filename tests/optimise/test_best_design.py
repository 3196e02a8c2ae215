"""The best design: cells and gradients are those of a run, no map has a better one, and what is written runs."""

from __future__ import annotations

import json
import re
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES, first, sentences
from design_texts import DEVICE, unlimited
from mpmath import mp, mpf
from msgspec.structs import replace

from vireport import analyse, load, loads
from vireport.base.boxes import Boxes
from vireport.base.errors import UsageError
from vireport.cli.app import main
from vireport.motions.pointwise import find_motions
from vireport.motions.stability import UNSTABLE, classify
from vireport.optimise.bound import _bounds, displaced, largest_value, picture_of
from vireport.optimise.cells import AT_FOLD, corner_slack, evaluate
from vireport.optimise.evolution import evolve
from vireport.optimise.grid import JudgedDesign, grid_of
from vireport.optimise.outputs import picture_front
from vireport.optimise.problem import Problem, problem_of, smallest_margin
from vireport.optimise.refine import SLOTS, _linear
from vireport.optimise.search import optimise
from vireport.physics.groups import Groups
from vireport.scenario.blocks import Objective
from vireport.scenario.parameters import Parameter
from vireport.study.checks import reference
from vireport.study.judging.designs import keeps_motion

LENGTH = "{path: device.length_m, from: 0.1, to: 1.2}"
FREQUENCY = "{path: excitation.frequency_hz, from: 1, to: 4}"
INCLINATION = "{path: inclination_deg, from: 10, to: 80}"
FORCE = "{path: excitation.amplitude_n, from: 2, to: 6}"
RESTITUTION = "{path: device.restitution, from: 0.3, to: 0.7}"
BALL = "{path: device.ball_mass_kg, from: 1e-3, to: 6e-3}"
CAPSULE = "{path: device.capsule_mass_kg, from: 0.1, to: 0.15}"

OF_MOTIONS = (
    *(Objective.U_AVE, Objective.VOLTAGE_RATE, Objective.POWER, Objective.EFFICIENCY),
    *(Objective.U_BOTTOM, Objective.U_TOP, Objective.VELOCITY_BOTTOM, Objective.WALL_GAP, Objective.DEFLECTION),
)
"""What stable motions differ in, but for the margin."""

PROBLEMS = {
    "rate": ("voltage_rate_v_s", (LENGTH, FREQUENCY), "margin_any_percent: 5, stroke_at_most_m: 0.35"),
    "power": (
        "power_mw",
        (LENGTH, FREQUENCY, INCLINATION),
        "margin_any_percent: 6, acceleration_at_most_g: 3, field_at_most_percent: 50",
    ),
}


def text_of(objective: str, vary: tuple[str, ...], required: str = "", cells: int = 900) -> str:
    design = f"design: {{maximise: {objective}, cells: {cells}, vary: [{', '.join(vary)}]}}\n"
    return f"{DEVICE}requirements: {{{unlimited(required)}}}\n{design}"


def problem(*arguments: object, free: bool = False) -> Problem:
    text = text_of(*arguments)
    return problem_of(loads(text.replace("  restitution", "  capsule: free\n  restitution") if free else text))


def best_of_map(problem: Problem, count: int) -> float:
    """The best of all designs of a map with so many values of each input, judged one by one as a run judges them."""
    axes = len(problem.paths)
    t = np.stack(np.meshgrid(*[np.linspace(0, 1, count)] * axes, indexing="ij"), axis=-1).reshape(-1, axes)
    cells = evaluate(problem, t)
    rows = np.flatnonzero(cells.stable & (np.nan_to_num(cells.slack, nan=-1) >= 0).all(axis=1))
    rows = rows[np.argsort(-cells.value[rows], kind="stable")]
    for part in np.array_split(rows, max(len(rows) // 500, 1)):
        for row in part[keeps_motion(problem.designs(t[part]), problem.share)]:
            if all(criterion.passed for criterion in problem.study(t[row]).criteria):
                return float(cells.value[row])
    return -np.inf


@pytest.mark.slow
@pytest.mark.parametrize("objective", first(1, OF_MOTIONS))
def test_cells_are_what_a_run_has(objective: Objective) -> None:
    limits = "u_ave_at_least_v: 3e4, u_bottom_top_difference_at_most_v: 2e4, deflection_at_most_m: 0.018, "
    limits += "power_at_least_mw: 15, field_at_most_percent: 60, acceleration_at_most_g: 2.5, stroke_at_most_m: 0.3"
    search = problem(objective, (RESTITUTION, FREQUENCY, FORCE, BALL), limits)
    t = np.random.default_rng(2).uniform(size=(60, 4))
    cells = evaluate(search, t)
    compared, outcomes = 0, set()
    for row in range(len(t)):
        study = search.study(t[row])
        assert study.solution.design.motions.stable_mask.any() == cells.stable[row]
        if cells.stable[row] and compared < 2:
            compared += 1
            assert cells.value[row] == pytest.approx(search.value_of(study, t[row]), rel=1e-10)
            assert len(study.criteria) == 8
            for line, slack in zip(study.criteria, cells.slack[row][2:], strict=True):
                assert line.outcome.margin / line.limit.value == pytest.approx(slack, abs=1e-9)
                outcomes.add(line.passed)
        elif compared == 2:
            break
    assert outcomes == {False, True}


@pytest.mark.slow
def test_a_ball_on_a_free_capsule_moves_it_and_strikes_with_less() -> None:
    search = problem(Objective.U_AVE, (CAPSULE, BALL), "stroke_at_most_m: 0.3", free=True)
    t = np.array([[0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    cells = evaluate(search, t)
    assert cells.stable.all()
    for row in range(len(t)):
        study = search.study(t[row])
        assert cells.value[row] == pytest.approx(search.value_of(study, t[row]), rel=1e-10)


NEARLY_LEVEL = DEVICE.replace("inclination_deg: 45", "inclination_deg: 0.3").replace("length_m: 0.7", "length_m: 0.33")
SEVERAL = "requirements: {u_bottom_top_difference_at_most_v: 1.2e4, deflection_at_most_m: 0.015}\n"


def test_of_several_stable_motions_the_worst_counts() -> None:
    """Every objective by the numbers that a run prints for each motion."""
    study = analyse(loads(NEARLY_LEVEL + SEVERAL))
    design = study.to_dict()["design_point"]
    rows = [i for i, word in enumerate(design["stability"]) if word.startswith("stable") and design["admissible"][i]]
    assert len(rows) == 2
    bottom, top = (np.array(design[key])[rows] for key in ("u_bottom_v", "u_top_v"))
    each = {key: np.array(design[key])[rows] for key in OF_MOTIONS if key in design}
    each["voltage_rate_v_s"] = 2.0 * (bottom + top)  # twice a second
    assert set(each) == {*OF_MOTIONS}
    for objective, values in each.items():
        vary = f"maximise: {objective}, vary: [{{path: device.length_m, from: 0.33, to: 0.34}}]"
        search = problem_of(loads(f"{NEARLY_LEVEL}{SEVERAL}design: {{{vary}}}\n"))
        cells = evaluate(search, np.zeros((1, 1)))
        assert cells.value[0] == pytest.approx(values.min(), rel=1e-9)
        assert search.value_of(study, np.zeros(1)) == values.min()
        limits = [max(bottom - top) / 1.2e4, max(design["deflection_m"][i] for i in rows) / 0.015]
        assert cells.slack[0, 2:4] == pytest.approx(1 - np.array(limits), rel=1e-9)


@pytest.mark.slow
def test_what_has_a_margin_keeps_its_motion() -> None:
    search = problem("u_ave_v", (LENGTH, FREQUENCY, INCLINATION))
    t = np.random.default_rng(4).uniform(size=(40, 3))
    t = t[evaluate(search, t).stable][:4]
    margins = np.array([smallest_margin(search.study(row).solution.design) for row in t])
    for share in (0.02, 0.05, 0.1):
        assert (keeps_motion(search.designs(t), share) >= (margins > share)).all()
    assert not keeps_motion(search.designs(t), 0.1).all()
    assert keeps_motion(search.designs(t), 1e-9).all()


@pytest.mark.slow
@pytest.mark.parametrize("at", first(1, [(0.52, 0.35, 0.5, 0.5), (0.6, 0.25, 0.2, 0.4)]))
def test_gradients_of_margins(at: tuple[float, ...]) -> None:
    """By differences here; they are held against 40 digits with the margins themselves."""
    search = problem("power_mw", (LENGTH, FREQUENCY, INCLINATION, RESTITUTION), "margin_any_percent: 5")
    t, step, count = np.array(at), 1e-5, len(SLOTS)
    here = _linear(search, t)
    assert np.isfinite(here.value)
    for k in range(4):
        aside = step * np.eye(4)[k]
        after, before = (_linear(search, t + side).slack[:count] for side in (aside, -aside))
        assert here.slopes[:count, k] == pytest.approx((after - before) / (2 * step), rel=1e-4, abs=1e-4)


LIMITED = (
    "stroke_at_most_m: 0.35, field_at_most_percent: 75, u_bottom_top_difference_at_most_v: 2e4, "
    "deflection_at_most_percent: 300, efficiency_at_most_percent: 60, deflection_at_most_m: 0.02"
)
FILM = ("thickness_m, from: 5e-4, to: 2e-3", "exponent, from: 2, to: 3", "ball_radius_m, from: 4e-3, to: 6e-3")
DIFFERENTIATED = {
    "motion": ((LENGTH, FREQUENCY, INCLINATION, RESTITUTION), (0.52, 0.35, 0.5, 0.5)),
    "device": ((LENGTH, FORCE, CAPSULE, BALL), (0.55, 0.26, 0.5, 0.5)),
    "membrane": ((FREQUENCY, *(f"{{path: device.membrane.{x}}}" for x in FILM)), (0.35, 0.4, 0.3, 0.6)),
}


def with_inputs(search: Problem, t: list[Any]) -> tuple[Any, Any]:
    """Device and membrane of a design, in decimals, by the names of the keys."""
    device, membrane = search.at(np.array(t, dtype=float))
    for varied, share in zip(search.design.vary, t, strict=True):
        name, value = varied.path.rpartition(".")[2], varied.from_ + (mpf(varied.to) - varied.from_) * share
        if name == "thickness_m":
            membrane = replace(membrane, dielectric=replace(membrane.dielectric, **{name: value}))
        elif varied.path.startswith("device.membrane.") or name == "ball_mass_kg":
            membrane = replace(membrane, **{name: value})
        else:
            device = replace(device, **{name: value})
    return device, membrane


def exact_motion(device: Any, guess: list[Any]) -> tuple[Any, ...]:
    """The motion near a guess, with its slacks of stability and gap, by the printed equations."""
    d, gbar = reference.groups(device, Parameter.LENGTH, device.length_m)
    r = mpf(device.restitution)
    state = reference.motion(guess, d, gbar, r, 1)
    gap = reference.wall_gap(state, d, gbar, r, 1) / d
    share = reference.trace(state, gbar, r, 1) / (1 + r**4)
    return state, reference.velocity_top(state, gbar, r, 1), min(1 + share, (1 - share) ** AT_FOLD), gap


def exact(search: Problem, t: list[Any], guess: list[Any]) -> list[Any]:
    """Objective (power) and slacks of `LIMITED` at a design."""
    device, membrane = with_inputs(search, t)
    state, top, stability, gap = exact_motion(device, guess)
    force, mass, f = (mpf(x) for x in (device.amplitude_n, device.capsule_mass_kg, device.frequency_hz))
    speeds = [abs(v) * force / (2 * mass * f) for v in (state[0], top)]
    gains = [reference.voltage(speed, membrane)[1] for speed in speeds]
    bias, film = membrane.bias_voltage_v, membrane.dielectric
    flat = mpf("8.8541878188e-12") * film.relative_permittivity * mp.pi * mpf(membrane.active_radius_m) ** 2
    power = 1e3 * f * sum(flat / film.thickness_m / 2 * gain * (gain + bias) for gain in gains)
    lost = mpf(membrane.ball_mass_kg) / 2 * (1 - mpf(device.restitution) ** 2) * sum(speed**2 for speed in speeds)
    efficiency = power / 1e3 / f / lost
    depth = max(reference.voltage(speed, membrane)[0] for speed in speeds)
    field = (max(gains) + bias) / film.thickness_m / film.breakdown_field_v_m
    stroke = 2 * force / (mass * (2 * mp.pi * f) ** 2)
    slack = [stability, gap, 1 - abs(gains[0] - gains[1]) / 20000, 1 - depth / mpf("0.02")]
    slack += [1 - depth / mpf(membrane.active_radius_m) / 3, 1 - efficiency / mpf("0.6"), 1 - field / mpf("0.75")]
    return [power, *slack, 1 - stroke / mpf("0.35")]


@pytest.mark.parametrize("name", DIFFERENTIATED)
def test_derivatives_are_those_of_40_digits(name: str) -> None:
    vary, at = DIFFERENTIATED[name]
    search = problem("power_mw", vary, LIMITED)
    here = _linear(search, np.array(at))
    motions = search.study(np.array(at)).solution.design.motions
    guess = [mpf(float(x[0])) for x in (motions.velocity_bottom, motions.phi_bottom, motions.u)]
    with reference.precise():
        step, centre = mpf(10) ** -15, [mpf(x) for x in at]
        values = exact(search, centre, guess)
        assert [here.value, *here.slack] == pytest.approx([float(x) for x in values], rel=1e-11)
        for k in range(len(at)):
            ahead = exact(search, [x + step * (i == k) for i, x in enumerate(centre)], guess)
            expected = [float((after - now) / step) for after, now in zip(ahead, values, strict=True)]
            assert [here.slope[k], *here.slopes[:, k]] == pytest.approx(expected, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize("r", first(1, [0.5, 0.2, 0.9]))
def test_every_stable_motion_is_in_the_picture(r: float) -> None:
    low, high, rng, count = np.array([np.log(0.02), 0.05]), np.array([np.log(5.0), 1.5]), np.random.default_rng(3), 3000
    picture = picture_of(r, 1, low, high)
    x, gbar = rng.uniform(low, high, (count, 2)).T
    motions = find_motions(Groups(np.exp(x), gbar, r), 1)
    stable = motions.admissible & (classify(motions.trace, r * r) != UNSTABLE)
    i, j = (picture.index(of[motions.cell[stable]], axis) for axis, of in enumerate((x, gbar)))
    speeds = np.stack([motions.orbit.velocity_bottom, -motions.orbit.velocity_top])[:, stable]
    assert stable.sum() > 40
    assert (picture.slowest[:, i, j] <= speeds).all()
    assert (speeds <= picture.fastest[:, i, j]).all()
    without = np.setdiff1d(np.arange(count), motions.cell[stable])
    empty = picture.fastest[0, picture.index(x[without], 0), picture.index(gbar[without], 1)] < 0
    assert empty.mean() > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.usefixtures("without_a_front")
def test_no_map_has_a_better_design(name: str) -> None:
    search = problem(*PROBLEMS[name])
    result = optimise(search)
    assert result.best is not None
    assert result.best.value >= best_of_map(search, 60 if len(search.paths) == 2 else 16) * (1 - 1e-9)
    assert result.evidence.best_cell <= result.best.value * (1 + 1e-9)
    assert result.best.meets_requirements()
    # What is said to be the most that there is, is more than this design, and not by much; even if it is not known.
    assert result.best.value <= result.evidence.bound <= 1.05 * result.best.value
    assert name != "rate" or largest_value(search, 0.9 * result.best.value) >= result.best.value


BOUNDED = {
    "margin": PROBLEMS["rate"],
    "ball": ("u_ave_v", (BALL, FORCE), "deflection_at_most_m: 0.018"),
    "capsule": ("voltage_rate_v_s", (CAPSULE, FREQUENCY), "acceleration_at_most_g: 2.5, u_ave_at_least_v: 4e4"),
    "force": ("power_mw", (FORCE, LENGTH), "stroke_at_most_m: 0.35, field_at_most_percent: 60"),
    "inclination": ("u_top_v", (INCLINATION, FREQUENCY), "power_at_least_mw: 15"),
}


@pytest.mark.parametrize("case", first(2, [*((name, False) for name in BOUNDED), ("ball", True), ("capsule", True)]))
def test_no_random_design_exceeds_the_bound_of_its_box(case: tuple[str, bool]) -> None:
    (name, free), count = case, 24
    search = problem(*BOUNDED[name], free=free)
    corner = np.indices((count, count)).reshape(2, -1) / count
    bounded = _bounds(search, Boxes(corner, corner + 1 / count), displaced(search.share), together=True)
    assert (bounded.excluded.sum() > 0) == (name == "margin")
    t = np.random.default_rng(1).uniform(size=(4000, 2))
    cells = evaluate(search, t)
    met = cells.stable & (np.nan_to_num(cells.slack, nan=-1) >= 0).all(axis=1)
    if search.share:
        met[met] = keeps_motion(search.designs(t[met]), search.share)
    assert met.sum() > 40
    place = np.ravel_multi_index((t[met] * count).astype(int).T, (count, count))
    assert (cells.value[met] <= bounded.most[place]).all()


@pytest.mark.slow
def test_the_global_solver_needs_no_grid() -> None:
    search = problem(*PROBLEMS["rate"])
    first, again = (evolve(search, np.empty((0, 2)), None) for _ in range(2))
    assert (first == again).all()
    cells = evaluate(search, first[None])
    assert (cells.slack >= 0).all()
    assert keeps_motion(search.designs(first[None]), search.share).all()
    assert cells.value[0] >= 0.9999 * best_of_map(search, 60)


@pytest.mark.slow
@pytest.mark.usefixtures("short_front")
def test_front_falls_and_ends_at_the_largest_margin() -> None:
    _, vary, _ = PROBLEMS["rate"]
    result = optimise(problem("voltage_rate_v_s", vary, "margin_any_percent: 5, stroke_at_most_m: 0.35", 144))
    margins, values = np.array([(point.margin, point.value) for point in result.front]).T
    assert (np.diff(margins) > 0).all()
    assert (np.diff(values) < 0).all()
    assert result.best.value <= np.interp(0.05, margins, values) * (1 + 1e-2)
    assert sentences(picture_front(result).caption) <= 2
    largest = optimise(problem("margin_percent", vary, "stroke_at_most_m: 0.35", 144))
    assert margins[-1] <= largest.best.margin
    assert largest.best.value == 100 * largest.best.margin
    # No margin is larger: the requirement of a little more is not met, and is short by as much.
    more = 100 * largest.best.margin + 0.5
    failing = optimise(problem("voltage_rate_v_s", vary, f"margin_any_percent: {more!r}, stroke_at_most_m: 0.35", 144))
    assert failing.best is None
    missed = next(criterion for criterion in failing.nearest.study.criteria if not criterion.passed)
    assert missed.key == "margin_any_percent"
    assert missed.outcome.margin == pytest.approx(-0.5, abs=1e-4)
    assert failing.evidence.widest * 100 < more


@pytest.mark.slow
@pytest.mark.usefixtures("short_front")
def test_the_best_design_runs_and_gives_the_same_numbers(tmp_path: Path, capsys) -> None:
    scenario = tmp_path / "scenario.yaml"
    sweep = "sweep: {parameter: length_m, from: 0.6, to: 0.8}\n"
    scenario.write_text(
        text_of("u_ave_v", (LENGTH, BALL), "stroke_at_most_m: 0.4, deflection_at_most_m: 0.018") + sweep
    )
    outputs = []
    for folder in ("one", "two"):
        assert main(["optimise", str(scenario), "-o", str(tmp_path / folder)]) == 0
        outputs.append({path.name: path.read_bytes() for path in (tmp_path / folder).iterdir()})
    assert outputs[0] == outputs[1]
    assert set(outputs[0]) >= {"best.yaml", "optimise.json", "report.pdf", "front.png"}
    said = capsys.readouterr().out
    assert said.startswith("Best: length ")
    best, built = (json.loads(outputs[0]["optimise.json"])[name] for name in ("best", "built"))
    assert all(len(repr(value)) <= 8 for value in built["inputs"].values())
    page = outputs[0]["report.html"].decode()
    assert page.index('id="best-design"') < page.index('id="acceptance"') < page.index('id="margins"')
    assert "device.ball_mass_kg" in page
    assert 'data-figure="figure-front"' in page
    assert main(["run", str(tmp_path / "one/report.html"), "--json"]) == 0
    assert "identical" in capsys.readouterr().err
    study = analyse(load(tmp_path / "one/best.yaml"))
    stable = study.solution.design.motions.stable_mask
    assert study.solution.design.voltages_by_motion.average_v[stable].min() == built["value"]
    assert study.solution.device.length_m == built["inputs"]["device.length_m"]
    assert study.solution.membrane.ball_mass_kg == built["inputs"]["device.ball_mass_kg"]
    assert study.solution.sweep is not None
    assert study.scenario.design is None
    assert [criterion.to_dict() | {"line": None} for criterion in study.criteria] == built["requirements"]
    assert all(requirement["passed"] for requirement in built["requirements"])
    assert [alert.to_dict() for alert in study.alerts] == built["alerts"]
    assert study.opening.worded().sentence in said
    study = analyse(load(tmp_path / "one/unrounded.yaml"))
    assert study.solution.design.voltages_by_motion.average_v[stable].min() == best["value"]
    # The membrane allows no deeper impact: the best design is on that limit.
    assert study.solution.design.voltages_by_motion.deflection_m[stable].max() == pytest.approx(0.018, rel=1e-7)


@pytest.mark.slow
@pytest.mark.usefixtures("without_a_front")
def test_the_best_design_starts_by_itself_unless_the_scenario_does_not_ask_for_it() -> None:
    """The shaken length with the most voltage has a stable motion beside that which a ball from rest comes to."""
    text = text_of("voltage_rate_v_s", (LENGTH, FREQUENCY), "stroke_at_most_m: 0.35", 225)
    results = [optimise(problem_of(loads(own))) for own in (text, text.replace("reached_from_rest: false, ", ""))]
    unasked, usual = (result.best for result in results)
    assert [best.study.evidence.is_reached_from_rest for best in (unasked, usual)] == [False, True]
    assert usual.value < unasked.value
    # No cell that starts by itself, and still does 0.1 % beside it, is better.
    assert usual.repeats
    grid = grid_of(results[1].problem)
    cells = (grid.judge(grid.t[row]) for row in grid.within())
    assert usual.value >= next(cell.value for cell in cells if cell is not None and cell.meets_requirements())


@pytest.mark.parametrize(
    ("required", "said"),
    first(
        1,
        [
            ("u_ave_at_least_v: 1e6", "the nearest fails U_ave (at least 1000000 V): "),
            (
                "stroke_at_most_m: 0.01, u_ave_at_least_v: 1",
                "the nearest fails Stroke of the shaker (at most 0.01 m): ",
            ),
        ],
        unpacked=True,
    ),
)
@pytest.mark.usefixtures("without_a_front")
def test_what_is_in_the_way_is_named_and_by_how_much(required: str, said: str, tmp_path: Path, capsys) -> None:
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(text_of("u_ave_v", (LENGTH, FREQUENCY), required, 36))
    assert main(["optimise", str(scenario), "-q", "-o", str(tmp_path / "out")]) == 1
    captured = capsys.readouterr()
    assert said in captured.err
    assert not captured.out
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"optimise.json"}
    data = json.loads((tmp_path / "out/optimise.json").read_text())
    assert data["best"] is None
    assert any(not requirement["passed"] for requirement in data["nearest"]["requirements"])


def test_ranges_without_stable_motion_are_said_to_have_none(tmp_path: Path, capsys) -> None:
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(text_of("u_ave_v", ("{path: device.length_m, from: 0.01, to: 0.02}",), "", 16))
    assert main(["optimise", str(scenario), "-o", str(tmp_path / "out")]) == 1
    assert json.loads((tmp_path / "out/optimise.json").read_text())["nearest"] is None
    assert "No design with a stable 1:1 motion was found in the ranges" in capsys.readouterr().out


TABLE = EXAMPLES / "bouncing-ball.yaml"
REACHED = "design={maximise: margin_percent, vary: [{path: device.length_m, from: 0.01, to: 0.5}]}"
OUT_OF_REACH = REACHED.replace("0.01", "0.1")


@pytest.mark.parametrize(
    ("over", "refused"),
    [
        ((), "the ball does not reach the top, as one on a table"),
        (("excitation.amplitude_n=12", OUT_OF_REACH), "the ball does not reach the top, as one on a table"),
        (("excitation.amplitude_n=12", REACHED), ""),
        (("excitation.amplitude_n=12", OUT_OF_REACH, "device.ball_mass_kg=0.004"), ""),
        (("sweep.to=1000",), "no design block"),
    ],
    ids=["along a sweep", "in all ranges", "in a part of them", "of a harvester", "in a part of a sweep"],
)
def test_a_best_design_of_a_ball_on_a_table_is_refused(over: tuple[str, ...], refused: str) -> None:
    with pytest.raises(UsageError, match=refused) if refused else nullcontext():
        problem_of(load(TABLE, over))


def test_a_scenario_without_a_design_block_is_refused() -> None:
    with pytest.raises(UsageError, match="no design block"):
        problem_of(loads(DEVICE))


@pytest.mark.parametrize(("required", "refused"), [("BBT", True), ("TB", False)])
def test_other_motions_than_1_1_are_refused(required: str, refused: bool) -> None:
    sweep = "sweep: {parameter: length_m, from: 0.6, to: 0.7}\n"
    loaded = loads(text_of("u_ave_v", (LENGTH,), f"word: {required}") + sweep)
    with pytest.raises(UsageError, match="BBT cannot be required") if refused else nullcontext():
        problem_of(loaded)


def test_a_design_block_changes_nothing_in_a_run() -> None:
    text = text_of("u_ave_v", (LENGTH,))
    with_block, without = (analyse(loads(text)).to_dict() for text in (text, text.partition("design:")[0]))
    (extra,) = [step for step in with_block["left_out"] if step not in without["left_out"]]
    assert extra["step"] == "optimise"
    for data in (with_block, without):
        del data["left_out"], data["scenario"]
    assert with_block == without


@pytest.mark.parametrize("vary", first(2, [(LENGTH,), (RESTITUTION,), (FORCE, BALL), (INCLINATION, RESTITUTION)]))
def test_ends_of_the_ranges_are_reached_exactly(vary: tuple[str, ...]) -> None:
    search = problem("u_ave_v", vary)
    ends = [(varied.from_, varied.to) for varied in search.design.vary]
    assert search.values(np.zeros(len(vary))).tolist() == [min(end) for end in ends]
    assert search.values(np.ones(len(vary))).tolist() == [max(end) for end in ends]


TOLERANCES = "tolerances: {length_percent: 2, frequency_percent: 2, restitution: 0.05}\n"


@pytest.mark.slow
@pytest.mark.usefixtures("without_a_front")
def test_every_device_within_the_tolerances_of_the_best_design_works() -> None:
    """And no better design of a map has that: some corner of its tolerances fails, or the proof does."""
    wanted = text_of("voltage_rate_v_s", (LENGTH, FREQUENCY), "stroke_at_most_m: 0.35", 144) + TOLERANCES
    result = optimise(problem_of(loads(wanted)))
    assert result.best.study.tolerances.proved
    assert result.evidence.tolerated < result.evidence.within
    search = problem_of(loads(wanted))
    t = np.stack(np.meshgrid(*[np.linspace(0, 1, 120)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    cells = evaluate(search, t)
    rows = np.flatnonzero(cells.stable & (np.nan_to_num(cells.slack, nan=-1) >= 0).all(axis=1))
    better = rows[cells.value[rows] > result.best.value * (1 + 2e-3)]  # the search keeps 0.1 % off its tolerances
    assert len(better) > 10
    for row in better[np.argsort(-cells.value[better])][:: len(better) // 5]:
        assert not search.study(t[row]).tolerances.proved


@pytest.mark.slow
def test_tolerances_that_no_design_has_are_in_the_way(tmp_path: Path, capsys) -> None:
    scenario = tmp_path / "scenario.yaml"
    wide = "tolerances: {frequency_percent: 45}\n"
    scenario.write_text(text_of("u_ave_v", (LENGTH, FREQUENCY), "", 100) + wide)
    assert main(["optimise", str(scenario), "-o", str(tmp_path / "out"), "-v"]) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "the nearest fails tolerances: towards frequency" in said
    assert "No design of the grid keeps stable motion at all corners of " in said
    assert "VR010 A membrane is pressed in deeper than its radius" in said
    data = json.loads((tmp_path / "out/optimise.json").read_text())
    share = data["evidence"]["no_cell_tolerates_percent"]
    assert 30 < share < 60
    # At a little less of them, there is one.
    search = problem_of(loads(scenario.read_text()))
    nearest = np.array(
        [
            (value - varied.from_) / (varied.to - varied.from_)
            for varied, value in zip(search.design.vary, data["nearest"]["inputs"].values(), strict=True)
        ]
    )
    assert (corner_slack(search, nearest[None], (share - 0.1) / 100) > 0).all()
    assert not (corner_slack(search, nearest[None], share / 100) > 0).all()


@pytest.mark.slow
def test_both_membranes_are_named_where_a_tolerance_of_their_restitutions_is_in_the_way(tmp_path: Path, capsys) -> None:
    scenario = tmp_path / "scenario.yaml"
    text = text_of("u_ave_v", (LENGTH,), "", 60) + "tolerances: {frequency_percent: 45, restitution_percent: 5}\n"
    scenario.write_text(text.replace("restitution: 0.5\n", "restitution_bottom: 0.47\n  restitution_top: 0.54\n"))
    assert main(["optimise", str(scenario), "--json"]) == 1
    said = " ".join(capsys.readouterr().err.split())
    device = r"frequency \d\S* Hz, restitution at the bottom 0\.4\d*, restitution at the top 0\.5\d*"
    assert re.search(f"tolerances: towards {device} stable motion ends", said)


@pytest.mark.slow
@pytest.mark.usefixtures("without_a_front")
def test_no_better_design_reaches_the_required_yield() -> None:
    loose = TOLERANCES.replace("}", ", samples: 512}")
    search = problem_of(loads(text_of("voltage_rate_v_s", (FREQUENCY,), "yield_at_least_percent: 80", 60) + loose))
    result = optimise(search)
    assert result.best.meets_requirements()
    assert not result.best.study.tolerances.proved
    assert 0 < result.evidence.yielding < 1
    t = np.linspace(0, 1, 100)[:, None]
    value = evaluate(search, t).value
    better = np.flatnonzero(value > result.best.value * (1 + 2e-3))
    assert better.size > 2
    assert not any(JudgedDesign(t[row], search.study(t[row]), value[row]).meets_requirements() for row in better)


@pytest.mark.slow
def test_a_yield_that_no_design_reaches_is_named_with_what_is_missing(tmp_path: Path, capsys) -> None:
    scenario = tmp_path / "scenario.yaml"
    wide = "tolerances: {frequency_percent: 45, samples: 512}\n"
    scenario.write_text(text_of("u_ave_v", (LENGTH, FREQUENCY), "yield_at_least_percent: 95", 100) + wide)
    assert main(["optimise", str(scenario), "--json"]) == 1
    captured = capsys.readouterr()
    assert "the nearest fails Yield within the tolerances (at least 95 %): " in captured.err
    data = json.loads(captured.out)
    assert data["evidence"]["yield_takes_percent"] is None
    assert data["evidence"]["judged"] > 1
    (missed,) = (requirement for requirement in data["nearest"]["requirements"] if not requirement["passed"])
    assert -60 < missed["margin"] < 0
