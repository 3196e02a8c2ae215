"""What a best design is the best in: an input or a result, as large or as small as possible."""

from __future__ import annotations

import json

import numpy as np
import pytest

from vireport import analyse, loads
from vireport.base.errors import ScenarioError
from vireport.cli.app import main
from vireport.optimise.cells import evaluate
from vireport.optimise.problem import problem_of

DEVICE = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5, length_m: 0.7}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
inclination_deg: 45
"""
LENGTH = "{path: device.length_m, from: 0.6, to: 0.8}"
FREQUENCY = "{path: excitation.frequency_hz, from: 1.8, to: 2.6}"


def text(aim: str, *vary: str, required: str = "margin_any_percent: 5", cells: int = 16) -> str:
    return f"{DEVICE}requirements: {{{required}}}\ndesign: {{{aim}, cells: {cells}, vary: [{', '.join(vary)}]}}\n"


def smallest_margin(length: float) -> float:
    """Of the device with another length, by what a run prints."""
    design = analyse(loads(DEVICE.replace("length_m: 0.7", f"length_m: {length!r}")), ("json",)).to_dict()[
        "design_point"
    ]
    ends = (margin for margin in design["margins"] if margin["ends_stability"] or margin["taken_over"])
    return min(abs(margin["percent"]) for margin in ends)


@pytest.mark.slow
def test_the_shortest_length_keeps_the_margin_and_no_shorter_one_does(tmp_path, capsys) -> None:
    scenario = tmp_path / "short.yaml"
    scenario.write_text(text("minimise: length_m", LENGTH))
    assert main(["optimise", str(scenario), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    length = found["best"]["inputs"]["device.length_m"]
    assert (found["objective"], found["sense"], found["unit"]) == ("length_m", "minimise", "m")
    assert found["best"]["value"] == length
    assert smallest_margin(length) == pytest.approx(5, rel=1e-6)
    assert smallest_margin(length * (1 - 1e-5)) < 5 < smallest_margin(length * (1 + 1e-5))
    assert {line["key"]: line["passed"] for line in found["best"]["requirements"]}["reached_from_rest"]
    assert found["evidence"]["proved_bound"] is None
    assert found["evidence"]["best_cell"] >= length


@pytest.mark.slow
def test_the_least_stroke_is_at_the_highest_frequency_that_is_allowed(tmp_path, capsys) -> None:
    """The stroke is 2 F/(M omega^2): of lengths and frequencies the highest frequency has the least."""
    scenario = tmp_path / "stroke.yaml"
    scenario.write_text(text("minimise: stroke_m", LENGTH, FREQUENCY, cells=64))
    assert main(["optimise", str(scenario), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["best"]
    assert found["inputs"]["excitation.frequency_hz"] == 2.6
    assert found["value"] == pytest.approx(2 * 3.0 / (0.1245 * (2 * np.pi * 2.6) ** 2), rel=1e-12)
    assert found["at_limit"] == {"excitation.frequency_hz": "upper"}


def test_what_shall_be_small_is_searched_with_its_sign_and_worst_motion() -> None:
    t = np.array([[0.25], [0.75]])
    small, large = (problem_of(loads(text(f"{aim}: length_m", LENGTH))) for aim in ("minimise", "maximise"))
    assert evaluate(small, t).value.tolist() == [-0.65, -0.75]
    assert evaluate(large, t).value.tolist() == [0.65, 0.75]
    deep = problem_of(loads(text("minimise: deflection_m", LENGTH)))
    study = deep.study(t[0])
    design = study.to_dict()["design_point"]
    stable = [word.startswith("stable") for word in design["stability"]]
    deepest = max(depth for depth, kept in zip(design["deflection_m"], stable, strict=True) if kept)
    assert evaluate(deep, t).value[0] == pytest.approx(-deepest, rel=1e-12)
    assert deep.value_of(study, t[0]) == -deepest


def test_a_cell_without_stable_motion_is_none_however_short_it_is() -> None:
    short = problem_of(loads(text("minimise: length_m", "{path: device.length_m, from: 0.3, to: 0.8}")))
    cells = evaluate(short, np.array([[0.0], [0.9]]))
    assert cells.stable.tolist() == [False, True]
    assert np.isnan(cells.value[0])


@pytest.mark.parametrize(
    ("aim", "message"),
    [
        ("minimise: frequency_hz", "design.minimise: frequency_hz does not vary (add excitation.frequency_hz to"),
        ("minimise: margin_percent", "design.minimise: a margin is no number to make small"),
        ("minimise: power_mw", "design.minimise: power_mw needs device.membrane.thickness_m"),
        ("maximise: u_ave_v, minimise: length_m", "design.maximise: maximise stands beside minimise (give either"),
    ],
)
def test_one_number_that_varies_or_is_evaluated_is_aimed_at(aim: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        loads(text(aim, LENGTH))
    assert message in str(caught.value)


def test_without_an_aim_the_block_is_at_fault() -> None:
    with pytest.raises(ScenarioError, match="design: maximise is missing"):
        loads(text("cells: 20", LENGTH).replace(", cells: 16", ""))
