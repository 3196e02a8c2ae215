"""What the bench answers has the numbers that a run has, wherever a slider stands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES, first

from vireport.base.errors import NumericalError, ScenarioError, UsageError
from vireport.bench.answers import CURVES, NOTHING, PLANE, STABLE, UNSTABLE, margins_answer, plane_answer, study_answer
from vireport.bench.controls import controls_of, ends_of
from vireport.bench.session import Opened, loaded_of, opened, start_data
from vireport.bench.session import first as first_of
from vireport.design.point import motions_at
from vireport.physics.device import Device
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.study.plan import Task
from vireport.study.study import analyse

NAMES = "inclined", "horizontal", "inclined-forcing", "design-point"
SAME = ("sweep_value", "d", "gbar", "q", "phi_bottom_rad", "phi_top_rad", "velocity_bottom", "velocity_top", "trace")


def random_states(known: Opened, count: int, seed: int) -> list[dict[str, Any]]:
    """States of which each moves up to three sliders anywhere."""
    rng = np.random.default_rng(seed)
    scenario = loaded_of(known, {}).scenario
    sliders = [own for own in controls_of(scenario) if own.slider and own.path in MOVED]
    states = []
    for _ in range(count):
        chosen = rng.choice(len(sliders), size=rng.integers(1, 4), replace=False)
        states.append({sliders[k].path: float(rng.uniform(sliders[k].start, sliders[k].end)) for k in chosen})
    return states


MOVED = {varied.path for varied in DesignInput if varied not in ("restitution_bottom", "restitution_top")}
MOVED |= {"device.ball_mass_kg", "device.membrane.bias_voltage_v"}

STATES = [(name, k) for k in range(50) for name in NAMES]


@pytest.mark.parametrize(("name", "number"), first(6, STATES, unpacked=True))
def test_the_numbers_of_a_page_are_those_of_a_run(name: str, number: int) -> None:
    known = opened(EXAMPLES / f"{name}.yaml")
    state = random_states(known, number + 1, 20)[number]
    try:
        results = analyse(loaded_of(known, state), ("json",)).to_dict()
    except (NumericalError, ScenarioError) as error:
        with pytest.raises(type(error)):
            first_of(known, state)
        return
    told, ends = first_of(known, state), margins_answer(loaded_of(known, state))
    for branch, own in zip(results["branches"], told["branches"], strict=True):
        drawn = [key for key in CURVES if key in branch]
        assert {key: branch[key] for key in drawn} == {key: own[key] for key in drawn}
        for first_row, last, stable in own["pieces"]:
            assert branch["stability"][(first_row + last) // 2].startswith("stable") is stable
    assert [(x["label"], x["sweep_value"]) for x in results["critical_points"]] == [
        (x["label"], x["sweep_value"]) for x in told["points"]
    ]
    assert [[part["from"], part["to"]] for part in results["stable_range"]] == told["stable"]
    design = results["design_point"]
    for key in (*SAME, "stability", "admissible", *(["u_ave_v"] if "u_ave_v" in design else [])):
        assert design[key] == told["motions"][key]
    own = [margin for margin in design["margins"] if margin["ends_stability"] or margin["taken_over"]]
    assert [{key: margin[key] for key in margin if key != "label"} for margin in own] == ends["margins"]
    for path, value in state.items():
        assert told["values"][path] == value


def test_what_follows_is_what_a_run_finds() -> None:
    loaded = opened(EXAMPLES / "inclined.yaml")
    study = analyse(loaded_of(loaded, {"requirements.margin_any_percent": 3.0}), ("json",))
    told = study_answer(study)
    opening = study.opening.worded()
    assert told["verdict"]["sentence"] == opening.sentence
    assert [(fact["status"], fact["text"]) for fact in told["verdict"]["facts"]] == list(opening.facts)
    assert [tile["value"] for tile in told["verdict"]["tiles"]] == [tile.value for tile in opening.tiles]
    assert told["results"]["requirements"] == study.to_dict()["requirements"]
    assert "branches" not in told["results"]
    whats = {row["what"]: row["why"] for row in told["left_out"]}
    assert whats[Task.SIMULATION.what] == "the scenario has no simulation block"
    assert not {Task.FIGURE_2.what, Task.PDF.what} & set(whats)


@pytest.mark.parametrize("name", ["inclined", "horizontal"])
def test_a_cell_of_the_plane_has_what_a_design_there_has(name: str) -> None:
    loaded = loaded_of(opened(EXAMPLES / f"{name}.yaml"), {})
    ranges = ((0.0, 90.0), (0.05, 0.9))
    cells = np.array(plane_answer(loaded, ("inclination_deg", "length_m"), ranges)["cells"])
    assert cells.shape == PLANE[::-1]
    rng, device = np.random.default_rng(3), Device.of(loaded.scenario)
    # At a border a place beside the middle of a cell would tell another thing.
    border = np.argwhere((cells[1:, :-1] != cells[:-1, :-1]) | (cells[:-1, 1:] != cells[:-1, :-1]))
    places = [*rng.choice(border, 30), *rng.integers(0, PLANE[::-1], (15, 2))]
    for j, i in places:
        x, y = (low + (high - low) * (k + 0.5) / n for (low, high), k, n in zip(ranges, (i, j), PLANE, strict=True))
        here = device.with_values({DesignInput.INCLINATION: x, DesignInput.LENGTH: y})
        motions, *_ = motions_at(here, Parameter.LENGTH)
        expected = STABLE if motions.stable_mask.any() else UNSTABLE if motions.admissible_mask.any() else NOTHING
        assert cells[j, i] == expected
    assert set(np.unique(cells)) == {NOTHING, UNSTABLE, STABLE}


@pytest.mark.parametrize(
    ("axes", "ranges", "message"),
    [
        (("length_m", "lenght_m"), ((0.1, 1), (0.1, 1)), "'lenght_m' is no input of the device"),
        (("length_m", "length_m"), ((0.1, 1), (0.1, 1)), "the plane has two inputs"),
        (("length_m", "inclination_deg"), ((0.1, 1), (0, 100)), "no range from 0 to 100 (allowed: ascending, 0 to 90)"),
        (("length_m", "inclination_deg"), ((1, 0.1), (0, 90)), "no range from 1 to 0.1"),
        (("length_m", "restitution_top"), ((0.1, 1), (0, 0.9)), "'restitution_top' is no input of the device"),
    ],
)
def test_a_plane_that_there_is_not_is_refused(axes: Any, ranges: Any, message: str) -> None:
    loaded = loaded_of(opened(EXAMPLES / "inclined.yaml"), {})
    with pytest.raises(UsageError) as refused:
        plane_answer(loaded, axes, ranges)
    assert message in str(refused.value)


def test_a_page_has_a_control_for_every_number_of_the_device() -> None:
    scenario = loaded_of(opened(EXAMPLES / "stiff-membrane.yaml"), {}).scenario
    paths = {control.path for control in controls_of(scenario)}
    assert {varied.path for varied in DesignInput} <= paths
    assert {f"device.membrane.{key}" for key in scenario.device.membrane.model_dump()} <= paths
    assert {"device.ball_mass_kg", "device.friction", "requirements.margin_any_percent"} <= paths


@pytest.mark.parametrize("name", NAMES)
def test_sliders_hold_the_value_and_stay_within_what_is_allowed(name: str) -> None:
    known = opened(EXAMPLES / f"{name}.yaml")
    scenario, values = loaded_of(known, {}).scenario, first_of(known, {})["values"]
    for control in controls_of(scenario):
        value = values[control.path]
        assert control.start < control.end
        assert value is None or control.start <= value <= control.end or not control.slider
    for varied in DesignInput:
        low, high = varied.limits
        assert low <= ends_of(scenario, varied)[0] < ends_of(scenario, varied)[1] <= high


def test_a_page_begins_with_the_words_of_its_inputs() -> None:
    start = start_data(opened(EXAMPLES / "inclined.yaml", ("title=Two <b> & three",)))
    assert start["title"] == "Two <b> & three"
    (length,) = [own for own in start["inputs"] if own["key"] == "length_m"]
    assert (length["symbol"], length["unit"], length["from"], length["to"]) == ("s", "m", 0.59, 0.75)


def test_membranes_that_differ_and_harmonics_can_be_set() -> None:
    known = opened(EXAMPLES / "inclined.yaml")
    apart = {"device.restitution": None, "device.restitution_bottom": 0.48, "device.restitution_top": 0.52}
    harmonics = [{"order": 2, "percent": 1.5, "phase_deg": 30.0}]
    state = apart | {"excitation.harmonics": harmonics}
    values = first_of(known, state)["values"]
    assert {path: values[path] for path in apart} == apart
    assert values["excitation.harmonics"] == harmonics
    stable = [first_of(known, own)["stable"][0][0] for own in ({}, apart, state)]
    assert len(set(stable)) == 3


def test_another_input_can_be_swept_and_none() -> None:
    known = opened(EXAMPLES / "inclined.yaml")
    swept = first_of(known, {"sweep": {"parameter": "frequency_hz", "from": 1.8, "to": 2.4}})
    assert (swept["swept"]["symbol"], swept["swept"]["value"]) == ("f", 2.0)
    assert swept["points"][0]["sweep_value"] == pytest.approx(1.90555, abs=1e-5)
    none = first_of(known, {"sweep": None})
    assert (none["swept"], none["branches"], none["shown"]) == (None, [], 0)


def test_curves_are_drawn_of_motions_alone() -> None:
    told = first_of(opened(EXAMPLES / "inclined.yaml"), {"sweep": {"parameter": "length_m", "from": 0.05, "to": 0.75}})
    hidden = 0
    state = {"sweep": {"parameter": "length_m", "from": 0.05, "to": 0.75}}
    results = analyse(loaded_of(opened(EXAMPLES / "inclined.yaml"), state), ()).to_dict()
    for branch, known in zip(told["branches"], results["branches"], strict=True):
        rows = np.zeros(len(branch["q"]), dtype=bool)
        for start, end, _ in branch["pieces"]:
            assert all(known["admissible"][start + 1 : end])
            rows[start : end + 1] = True
        assert not np.any(np.array(known["admissible"]) & ~rows)
        hidden += int((~rows).sum())
    assert hidden > 10


def test_a_slider_goes_from_the_lower_to_the_upper_end() -> None:
    over = ("sweep={parameter: length_m, from: 0.75, to: 0.7}", "device.membrane.exponent=15")
    scenario = loaded_of(opened(EXAMPLES / "inclined.yaml", over), {}).scenario
    ends = {control.path: (control.start, control.end) for control in controls_of(scenario)}
    assert ends["device.length_m"] == (0.6934, 0.75)
    assert ends["device.membrane.exponent"] == (7.5, 20)
    assert ends["excitation.amplitude_n"] == (1.5, 6)


def test_what_the_page_sets_is_over_what_the_command_line_sets() -> None:
    known = opened(EXAMPLES / "inclined.yaml", ("device.length_m=0.7", "device.restitution=0.48"))
    values = first_of(known, {"device.length_m": 0.66})["values"]
    assert (values["device.length_m"], values["device.restitution"]) == (0.66, 0.48)


def test_where_nothing_exists_no_motion_is_shown() -> None:
    known = opened(EXAMPLES / "inclined.yaml")
    told = first_of(known, {"device.length_m": 0.05, "sweep": None})
    assert told["shown"] is None
    assert told["path"] is None
    assert margins_answer(loaded_of(known, {"device.length_m": 0.05, "sweep": None}))["margins"] == []
