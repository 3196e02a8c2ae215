"""What no device can do is accepted by no run and found by no search: energy from nothing, breakdown."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from conftest import first
from definitions import device_of
from design_texts import DEVICE
from pages import Page

from vireport import analyse, loads
from vireport.cli.app import main
from vireport.optimise import outputs
from vireport.optimise.bound import largest_value
from vireport.optimise.problem import problem_of
from vireport.optimise.search import optimise
from vireport.study.judging.verdict import Status

pytestmark = pytest.mark.usefixtures("without_a_front")

IMPOSSIBLE = """\
schema_version: 1
device:
  capsule_mass_kg: 0.1245
  ball_mass_kg: 6.0e-5
  restitution: 0.5
  length_m: 0.7
  membrane: {thickness_m: 2.0e-5, relative_permittivity: 4.7, breakdown_field_v_m: 4.0e+8}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
inclination_deg: 45
"""
"""Below breakdown, with an efficiency of 327 %."""

POWER = "requirements.power_at_least_mw=0.001"
BIAS = "{path: device.membrane.bias_voltage_v, from: 100, to: 3000}"
BALL = "{path: device.ball_mass_kg, from: 1e-5, to: 1e-3}"
LENGTH = "{path: device.length_m, from: 0.6, to: 0.9}"
DEVICES = 24
"""Random devices of which runs are judged; searches among a fourth of them."""
CELLS = 16
"""Cells of the grids from which searches start: ascent finds the same designs from 100."""


def searched(objective: str, *vary: str, text: str = IMPOSSIBLE, cells: int = CELLS, required: str = "") -> str:
    requirements = f"requirements: {{{required}}}\n" if required else ""
    return f"{text}{requirements}design: {{maximise: {objective}, cells: {cells}, vary: [{', '.join(vary)}]}}\n"


def random_device(seed: int) -> str:
    """A device with a thin film and a light ball, below breakdown."""
    draw = np.random.default_rng(seed)
    ball, thickness = 10 ** draw.uniform(-5, -4.2), 10 ** draw.uniform(-4.8, -3.7)
    permittivity, bias = draw.uniform(2, 10), 10 ** draw.uniform(3.0, 3.45)
    membrane = f"thickness_m: {thickness!r}, relative_permittivity: {permittivity!r}, breakdown_field_v_m: 6.0e+8"
    membrane += f", bias_voltage_v: {bias!r}"
    old = "thickness_m: 2.0e-5, relative_permittivity: 4.7, breakdown_field_v_m: 4.0e+8"
    text = IMPOSSIBLE.replace(old, membrane).replace("6.0e-5", repr(float(ball)))
    return text.replace("length_m: 0.7", f"length_m: {draw.uniform(0.66, 0.85)!r}")


def efficiency_of(study) -> float:
    design = study.solution.design
    return float(design.conversion_by_motion.efficiency[design.motions.stable_mask].max())


def test_a_device_that_gains_more_than_its_impacts_lose_is_not_accepted(tmp_path: Path, capsys) -> None:
    scenario = tmp_path / "impossible.yaml"
    scenario.write_text(IMPOSSIBLE)
    assert main(["run", str(scenario), "--json", "--set", POWER]) == 1
    data = json.loads(capsys.readouterr().out)
    power, efficiency = data["requirements"]["criteria"]
    assert power["passed"]
    assert (efficiency["key"], efficiency["passed"], efficiency["by_default"]) == (
        *("efficiency_at_most_percent", False, True),
    )
    assert efficiency["value"] == pytest.approx(327.46, abs=0.01)
    assert (data["alerts"][0]["code"], data["alerts"][0]["severity"]) == ("VR017", "error")
    assert "an efficiency of 327 %" in data["alerts"][0]["cause"]


@pytest.mark.parametrize("over", [[], [POWER, "requirements.efficiency_at_most_percent=400"]])
def test_what_is_impossible_is_no_good_verdict_even_where_it_is_allowed(over: list[str]) -> None:
    study = analyse(loads(IMPOSSIBLE, overrides=over))
    assert all(criterion.passed for criterion in study.criteria)
    assert study.verdict.status is Status.BAD
    assert study.verdict.word == "Stable, but with more electrical energy than the impacts lose"
    assert "Lower the bias voltage: it takes 327 % of the energy that the impacts lose." in [
        text for _, text in study.opening.worded().facts
    ]


@pytest.mark.parametrize(
    ("over", "status", "word"),
    [
        (["device.membrane.bias_voltage_v=800"], Status.CAUTION, "Stable, margin small"),
        (["device.membrane.breakdown_field_v_m=5e7"], Status.BAD, "Stable, but with more electrical energy than"),
        (
            ["device.membrane.bias_voltage_v=800", "device.membrane.breakdown_field_v_m=5e7"],
            *(Status.BAD, "Stable, but above the breakdown field"),
        ),
        (
            ["device.ball_mass_kg=0.0041", "device.membrane={}"],
            *(Status.CAUTION, "Stable, margin small"),
        ),
    ],
)
def test_each_limit_of_physics_is_part_of_the_verdict(over: list[str], status: Status, word: str) -> None:
    verdict = analyse(loads(IMPOSSIBLE, overrides=over)).verdict
    assert verdict.status is status
    assert verdict.word.startswith(word)


def test_the_usual_limit_needs_energy_that_is_evaluated_and_a_requirement() -> None:
    margin = "requirements.margin_any_percent=1"
    keys = [
        [criterion.key for criterion in analyse(loads(IMPOSSIBLE, overrides=over)).criteria]
        for over in ([], [margin], [margin, "device.membrane={}"], [margin, "device.length_m=0.1"])
    ]
    only = ["margin_any_percent"]
    assert keys == [[], [*only, "efficiency_at_most_percent"], only, only]


OTHER_WORD = """\
schema_version: 1
device:
  capsule_mass_kg: 0.1245
  ball_mass_kg: 6.0e-5
  restitution_bottom: 0.5
  restitution_top: 0.48
  length_m: 0.25
  membrane: {thickness_m: 2.0e-5, relative_permittivity: 4.7, breakdown_field_v_m: 4.0e+8}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
inclination_deg: 20
sweep: {parameter: length_m, from: 0.24, to: 0.26}
motions: {impacts: 3, periods: 1}
requirements: {word: BBT, power_at_least_mw: 0.1}
"""
"""A light ball on a thin film strikes twice at the bottom and once at the top."""

DOUBLED = {"device.length_m": 0.36, "sweep.from": 0.355, "sweep.to": 0.38, "requirements.word": "BTBT"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("over", "word"), [({}, (1, 1, -1, 1)), pytest.param(DOUBLED, (1, -1, 1, -1, 2), marks=pytest.mark.slow)]
)
def test_energy_of_any_word_is_judged_as_that_of_the_1_1_motion(over: dict[str, object], word: tuple[int, ...]) -> None:
    *walls, periods = word
    over = over | {"motions.periods": periods, "motions.impacts": len(walls)}
    study = analyse(loads(OTHER_WORD, overrides=over), ("json",))
    data = study.to_dict()
    ((_, motion),) = study.evidence.stable
    assert (motion.word.walls, motion.word.periods) == (tuple(walls), periods)
    of = device_of(data["scenario"])
    speeds = np.abs(of.velocity_unit * motion.velocity)
    restitution = {1: of.restitution_bottom, -1: of.restitution_top}
    lost = sum(of.reduced_kg / 2 * (1 - restitution[w] ** 2) * v**2 for w, v in zip(walls, speeds, strict=True))
    gained = sum(map(of.energy, speeds))
    assert gained > lost
    field = (max(map(of.gain, speeds)) + of.membrane["bias_voltage_v"]) / of.membrane["thickness_m"]
    values = {line["key"]: (line["value"], line["passed"]) for line in data["requirements"]["criteria"]}
    assert values["power_at_least_mw"] == (pytest.approx(1e3 * gained * of.frequency_hz / periods, rel=1e-9), True)
    assert values["efficiency_at_most_percent"] == (pytest.approx(100 * gained / lost, rel=1e-9), False)
    (cause,) = [str(alert.cause) for alert in study.alerts if alert.code == "VR017"]
    assert f"an efficiency of {100 * gained / lost:.3g} %" in cause
    allowed = {"requirements.efficiency_at_most_percent": 1000.0, "device.membrane.breakdown_field_v_m": 0.99 * field}
    again = analyse(loads(OTHER_WORD, overrides=over | allowed), ("json",))
    assert [(line.key, str(line.outcome.why)) for line in again.criteria if not line.passed] == []
    assert again.verdict.word == "Stable, but with more electrical energy than the impacts lose"
    (cause,) = [str(alert.cause) for alert in again.alerts if alert.code == "VR016"]
    assert f"{field / 1e8:.3g} × 10⁸ V/m" in cause
    thick = {"device.membrane.thickness_m": 2e-4, "device.membrane.breakdown_field_v_m": 0.099 * field}
    breaking = analyse(loads(OTHER_WORD, overrides=over | thick), ("json",))
    assert breaking.verdict.word == "Stable, but above the breakdown field"


@pytest.mark.slow
def test_of_random_electrical_devices_none_is_accepted_above_what_impacts_lose() -> None:
    above = 0
    for seed in range(DEVICES):
        study = analyse(loads(random_device(seed), overrides=[POWER]))
        accepted = all(criterion.passed for criterion in study.criteria)
        efficiency = efficiency_of(study)
        above += efficiency > 1
        assert accepted == (efficiency <= 1), seed
        assert study.verdict.status is not Status.GOOD or efficiency <= 1
        assert ("VR017" in {alert.code for alert in study.alerts}) == (efficiency > 1)
    assert DEVICES / 8 < above < DEVICES * 4 / 5


@pytest.mark.parametrize(
    ("objective", "vary"),
    [("efficiency", (BIAS,)), pytest.param("power_mw", (LENGTH, BALL), marks=pytest.mark.slow)],
)
def test_a_search_does_not_end_beyond_what_is_possible(objective: str, vary: tuple[str, ...]) -> None:
    text = IMPOSSIBLE.replace("4.7", "1.5") if objective == "power_mw" else IMPOSSIBLE
    problem = problem_of(loads(searched(objective, *vary, text=text)))
    result = optimise(problem)
    study = result.best.study
    assert efficiency_of(study) <= 1
    assert study.solution.within_membrane
    assert study.verdict.status is not Status.BAD
    assert objective != "efficiency" or result.best.value == pytest.approx(1, abs=1e-6)
    free = searched(objective, *vary, text=text, required="efficiency_at_most_percent: 1e6")
    assert efficiency_of(optimise(problem_of(loads(free))).best.study) > 1.05


HEAVY = (
    IMPOSSIBLE.replace("6.0e-5", "0.0041")
    .replace("2.0e-5", "6.26e-5")
    .replace("permittivity: 4.7", "permittivity: 6.21")
    .replace("amplitude_n: 3.0", "amplitude_n: 10.0")
)
"""A steel ball, and more force."""
LONGEST = {
    "efficiency": (IMPOSSIBLE, (1.0, 2.23546), {"device.length_m": (0.8, 1.0), "excitation.frequency_hz": (1.5, 3)}),
    "power_mw": (HEAVY, (1.2, 3.9496), {"device.length_m": (0.9, 1.2), "excitation.frequency_hz": (3, 4)}),
}
"""Devices, the length and frequency at which a search without limits ends, and the ranges that it searches."""


@pytest.mark.parametrize(
    ("objective", "key", "value"),
    first(
        1,
        [("efficiency", "efficiency_at_most_percent", 347.16), ("power_mw", "power_at_least_mw", 7607)],
        unpacked=True,
    ),
)
def test_where_a_search_without_limits_ends_two_requirements_that_are_met_make_no_good_verdict(
    objective: str, key: str, value: float
) -> None:
    """An efficiency of 347 %; 7.6 W in 5.6 times the breakdown field."""
    text, (length, frequency), _ = LONGEST[objective]
    text = text.replace("length_m: 0.7", f"length_m: {length}").replace("hz: 2.0", f"hz: {frequency}")
    study = analyse(loads(f"{text}requirements: {{margin_any_percent: 2, power_at_least_mw: 10}}\n"), ("json",))
    passed = {line.key: line.passed for line in study.criteria}
    assert passed == {"margin_any_percent": True, "power_at_least_mw": True, "efficiency_at_most_percent": False}
    values = {line["key"]: line["value"] for line in study.to_dict()["requirements"]["criteria"]}
    assert values[key] == pytest.approx(value, rel=1e-4)
    assert study.verdict.status is Status.BAD
    beyond_field = [str(alert.cause) for alert in study.alerts if alert.code == "VR016"]
    assert len(beyond_field) == (objective == "power_mw")
    assert all("5.60 times" in cause for cause in beyond_field)


@pytest.mark.slow
@pytest.mark.parametrize("objective", LONGEST)
def test_a_search_without_limits_ends_there_and_one_with_the_usual_ones_says_that_nothing_is_within(objective: str):
    text, found, ranges = LONGEST[objective]
    vary = [f"{{path: {path}, from: {low}, to: {high}}}" for path, (low, high) in ranges.items()]
    limits = ("efficiency", "field", "deflection")
    free = searched(
        objective,
        *vary,
        text=text,
        required=", ".join((*(f"{each}_at_most_percent: 1e6" for each in limits), "reached_from_rest: false")),
    )
    best = optimise(problem_of(loads(free))).best
    device = best.study.solution.device
    assert (device.length_m, device.frequency_hz) == pytest.approx(found, rel=1e-4)
    assert optimise(problem_of(loads(searched(objective, *vary, text=text)))).best is None


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(DEVICES // 4))
@pytest.mark.usefixtures("short_front")
def test_no_search_among_random_electrical_devices_ends_above_what_impacts_lose(seed: int) -> None:
    objective = ("efficiency", "power_mw", "u_ave_v")[seed % 3]
    result = optimise(problem_of(loads(searched(objective, LENGTH, BIAS, text=random_device(seed)))))
    designs = [point for point in (result.best, *result.front) if point is not None]
    assert designs
    for point in designs:
        assert efficiency_of(point.study) <= 1
        assert not {"VR016", "VR017"} & {alert.code for alert in point.study.alerts}


@pytest.mark.slow
def test_limits_that_are_not_given_are_named_and_written_into_the_best_design(tmp_path: Path, capsys) -> None:
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(searched("u_ave_v", LENGTH, BIAS))
    assert main(["optimise", str(scenario), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["limits_by_default"] == {
        "efficiency_at_most_percent": 100,
        "field_at_most_percent": 100,
        "reached_from_rest": True,
    }
    assert {line["key"] for line in data["best"]["requirements"]} == set(data["limits_by_default"])
    assert main(["optimise", str(scenario), "-o", str(tmp_path / "out"), "-v"]) == 0
    said = "Also required, as the scenario does not say otherwise: Reached from rest (reached_from_rest); Electrical"
    assert said in " ".join(capsys.readouterr().out.split())
    assert main(["run", str(tmp_path / "out/best.yaml"), "--json"]) == 0


@pytest.mark.parametrize(
    ("required", "usual"),
    [
        ("deflection_at_most_m: 0.02", {"efficiency_at_most_percent", "field_at_most_percent"}),
        ("area_ratio_at_most: 4.0", {"efficiency_at_most_percent", "field_at_most_percent"}),
        ("field_at_most_percent: 300", {"efficiency_at_most_percent"}),
        ("efficiency_at_most_percent: 40", {"field_at_most_percent"}),
    ],
)
def test_limits_that_are_given_hold_instead(required: str, usual: set[str]) -> None:
    problem = problem_of(loads(searched("u_ave_v", LENGTH, required=required)))
    assert {row.key for row, _ in problem.usual} == usual | {"reached_from_rest"}
    key, value = required.split(": ")
    assert {row.key: limit for row, limit in problem.required}[key].value == float(value)


@pytest.mark.parametrize(
    ("required", "usual"), [("reached_from_rest: false", False), ("word: BT", False), ("stroke_at_most_m: 1", True)]
)
def test_a_best_design_must_start_by_itself_unless_the_scenario_says_otherwise(required: str, usual: bool) -> None:
    text = searched("u_ave_v", LENGTH, required=required, text=f"{IMPOSSIBLE}sweep: {SWEEP}\n")
    assert ("reached_from_rest" in {row.key for row, _ in problem_of(loads(text)).usual}) is usual


SWEEP = "{parameter: length_m, from: 0.6, to: 0.9}"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("required", "found"),
    [("margin_any_percent: 5", True), ("deflection_at_most_percent: 100", False), ("area_ratio_at_most: 5.3", True)],
)
def test_the_device_of_the_paper_has_a_best_design(required: str, found: bool) -> None:
    """At 2.5 to 4 radii deep, below breakdown; within one radius, if that is asked for, none of its motions is."""
    vary = "{path: device.length_m, from: 0.5, to: 0.9}", "{path: excitation.frequency_hz, from: 1.5, to: 2.5}"
    result = optimise(problem_of(loads(searched("voltage_rate_v_s", *vary, text=DEVICE, cells=900, required=required))))
    assert (result.best is not None) == found
    if result.best is None:
        return
    stretch = result.best.study.solution.stretch
    assert stretch.depth_ratio > 2
    assert stretch.thickness_at(1e8) < 1e-3
    assert all(criterion.passed for criterion in result.best.study.criteria)
    if "area" in required:
        assert stretch.area_ratio == pytest.approx(5.3, rel=1e-3)
        assert stretch.area_ratio <= 5.3
    else:
        assert result.best.value == pytest.approx(246_413, rel=1e-4)  # 258,726 where it need not start 0.1 % beside it


SOFT = "device.membrane.stiffness"


@pytest.mark.parametrize(
    ("path", "ends", "said"),
    [
        pytest.param(SOFT, (9e5, 4.5e5), "lower", marks=pytest.mark.slow),
        pytest.param(SOFT, (4.5e5, 9e5), "lower", marks=pytest.mark.slow),
        pytest.param("device.length_m", (0.7, 0.75), "upper", marks=pytest.mark.slow),
    ],
)
def test_a_best_design_at_an_end_of_its_range_says_so(
    path: str, ends: tuple[float, float], said: str, capsys, tmp_path
):
    """Softer membranes go deeper, and longer capsules have faster impacts."""
    vary, loose = f"{{path: {path}, from: {ends[0]}, to: {ends[1]}}}", "efficiency_at_most_percent: 1e6"
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(searched("u_ave_v", vary, required=loose))
    assert main(["optimise", str(scenario), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["best"]["at_limit"] == {path: said}
    result = optimise(problem_of(loads(scenario.read_text())))
    study = outputs.run_of(result)
    facts = [text for _, text in outputs.opening(result, study).worded().facts]
    assert f"At the {said} limit of {path.rpartition('.')[2]}: a wider range may hold a better design." in facts
    assert f"{said} limit" in outputs.text(result, study, tables=True)


@pytest.mark.slow
def test_a_best_design_that_a_limit_holds_is_at_no_end() -> None:
    result = optimise(problem_of(loads(searched("efficiency", BIAS))))
    assert list(result.problem.at_limits(result.best.t)) == []
    assert "wider range" not in outputs.text(result, outputs.run_of(result), tables=True)


def test_an_end_beyond_which_there_is_nothing_is_not_named() -> None:
    problem = problem_of(loads(searched("u_ave_v", "{path: inclination_deg, from: 0, to: 80}")))
    assert [list(problem.at_limits(np.array([t]))) for t in (0.0, 0.5)] == [[], []]
    assert list(problem.at_limits(np.array([1.0]))) == [("inclination_deg", True)]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_the_proved_power_is_at_most_what_the_impacts_may_lose(seed: int) -> None:
    """Even where the search has found nothing, no design has more power than its fastest impacts lose."""
    text = searched("power_mw", LENGTH, BALL, text=random_device(seed), required="efficiency_at_most_percent: 50")
    problem = problem_of(loads(text))
    best = optimise(problem).best
    # Of some devices no design in the ranges meets the limit: then nothing is known to be reached.
    known = 0.0 if best is None else best.value
    bound = largest_value(problem, known)
    assert known <= bound
    t, met = np.random.default_rng(seed).uniform(size=(10, 2)), 0
    for row in t:
        study = problem.study(row)
        design = study.solution.design
        if design.motions.stable_mask.any() and all(line.passed for line in study.criteria):
            met += 1
            assert design.conversion_by_motion.power_mw[design.motions.stable_mask].min() <= bound
    assert best is not None or met == 0


@pytest.mark.slow
def test_the_report_shows_what_is_impossible_as_bad_and_says_what_its_bound_leaves_out(tmp_path: Path) -> None:
    scenario = tmp_path / "impossible.yaml"
    scenario.write_text(IMPOSSIBLE)
    run = ["run", str(scenario), "--set", POWER, "--format", "html", "-q", "-o", str(tmp_path / "out")]
    assert main(run) == 1
    file = (tmp_path / "out/report.html").read_text()
    page = Page(file.encode())
    panels = re.findall(r'<div class="panel (\w+)">(.*?)</div>', file, re.DOTALL)
    assert [status for status, panel in panels if 'id="VR017"' in panel] == ["bad"]
    text = page.text
    assert "Lower the bias voltage: it takes 327 % of the energy that the impacts lose." in text
    (row,) = (row for row in page.tables["Requirements"].rows if "Electrical efficiency" in row[0])
    assert (row[1], row[-1]) == ("✗ NOT MET", "by default")
    assert "An upper bound: constant charge at a fixed bias, no leakage, no load." in text
    assert "Electrical cycle of each impact" in text
