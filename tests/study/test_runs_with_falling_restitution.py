"""What a run does with a restitution that falls with speed, and what refuses it before work begins."""

from __future__ import annotations

import json
import math

import pytest
from conftest import EXAMPLES
from pages import render_html

from vireport.base.errors import ScenarioError
from vireport.physics import flight
from vireport.report.context import Report
from vireport.scenario.loading import load
from vireport.study.plan import Task
from vireport.study.provenance import provenance_of
from vireport.study.study import analyse

POINT = {"sweep": None, "simulation": None, "motions": None, "device.length_m": 0.6934, "accuracy": None}
FALLS = {"device.restitution_exponent": -0.1, "device.restitution_speed_m_s": 2.0}
DIELECTRIC = {
    "device.membrane.stiffness": 2e8,
    "device.membrane.thickness_m": 1e-3,
    "device.membrane.relative_permittivity": 4.7,
    "device.membrane.breakdown_field_v_m": 1e8,
}
NAMED = r"device\.restitution_exponent|falls with speed"


@pytest.fixture(scope="module")
def falling():
    over = POINT | FALLS | DIELECTRIC | {"requirements": {"margin_any_percent": 3, "reached_from_rest": True}}
    return analyse(load(EXAMPLES / "inclined.yaml", over), (Task.JSON, Task.HTML))


def test_what_may_be_stated_is_what_the_law_allows() -> None:
    below = math.nextafter(flight.LARGEST_RESTITUTION, 0)
    assert load(EXAMPLES / "inclined.yaml", POINT | FALLS | {"device.restitution": below})
    with pytest.raises(ScenarioError, match=r"device\.restitution:"):
        load(EXAMPLES / "inclined.yaml", POINT | FALLS | {"device.restitution": flight.LARGEST_RESTITUTION})


def test_a_run_has_motions_margins_and_energies_and_says_what_it_claims(falling) -> None:
    data = json.loads(json.dumps(falling.to_dict(), allow_nan=False))
    design = data["design_point"]
    assert design["stability"] == ["stable node", "unstable node"]
    assert (design["claim"], design["not_followed"]) == ("followed", 0)
    # Simulated: the period doubles between 1.9378 and 1.9416 Hz; with a constant restitution at 1.9056 Hz.
    assert design["margins"][0]["sweep_value"] == pytest.approx(1.93969, abs=1e-5)
    assert all(criterion["passed"] for criterion in data["requirements"]["criteria"])
    assert falling.reproduction.passed
    assert data["own_stiffness"] is None
    assert {row["effect"] for row in data["effects"]["rows"]} == {
        *("restitution_bottom", "restitution_top", "capsule", "second_harmonic", "friction")
    }
    law = falling.solution.device.restitution
    device, mass = falling.solution.device, falling.solution.membrane.reduced_mass_kg
    for row, (bottom, top) in enumerate(zip(design["restitution_bottom"], design["restitution_top"], strict=True)):
        unit = device.amplitude_n / (2 * device.capsule_mass_kg * device.frequency_hz)
        v, w = unit * design["velocity_bottom"][row], -unit * design["velocity_top"][row]
        assert (bottom, top) == pytest.approx((0.5 * (v / law.speed) ** -0.1, 0.5 * (w / law.speed) ** -0.1), rel=1e-13)
        lost = mass / 2 * ((1 - bottom**2) * v**2 + (1 - top**2) * w**2)
        gained = design["energy_bottom_j"][row] + design["energy_top_j"][row]
        assert design["efficiency"][row] == pytest.approx(gained / lost, rel=1e-12)
        assert design["determinant"][row] == pytest.approx((0.9 * bottom * top) ** 2, rel=1e-13)


@pytest.mark.slow
def test_the_simulation_and_margins_under_effects_know_the_law(example) -> None:
    asked = {"requirements": {"margin_with_effects_percent": 0.1}}
    over = POINT | FALLS | asked | {"simulation": {"samples": 2, "starts": 4, "impacts": 1000}}
    study = analyse(load(example("inclined"), over), (Task.JSON,))
    assert study.crosscheck is not None
    assert study.crosscheck.passed
    assert [criterion.passed for criterion in study.criteria] == [True]
    least = {row["effect"]: row["least_margin"] for row in study.to_dict()["effects"]["rows"]}
    # That of the bottom restitution less by 5 % is the one in frequency, which its row has.
    assert least["restitution_bottom"] == pytest.approx(0.00623, abs=1e-5)


def test_the_report_shows_the_law_and_says_what_is_claimed(falling) -> None:
    page = render_html(Report(falling, {}, provenance_of(falling.loaded, "test"))).decode()
    assert "There may be others" in page
    assert "The restitution falls with the speed of the impact" in page


def test_where_nothing_is_stable_it_is_not_said_that_there_is_none() -> None:
    over = POINT | FALLS | {"device.length_m": 0.6}
    alerts = analyse(load(EXAMPLES / "inclined.yaml", over), (Task.JSON,)).to_dict()["alerts"]
    (cause,) = [alert["cause"] for alert in alerts if alert["code"] == "VR003"]
    assert "There may be others." in cause
