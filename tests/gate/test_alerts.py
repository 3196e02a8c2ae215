"""Alerts: each is raised where its cause is, not elsewhere, and each can be explained."""

from __future__ import annotations

import re

import numpy as np
import pytest

from vireport import analyse, loads
from vireport.base.errors import UsageError
from vireport.design.sensitivity import contact_share, mass_elasticity, restitution_effect
from vireport.gate.alerts import CAUSES
from vireport.motions import Event
from vireport.text.alerts import CATALOGUE, AlertCode, explanation

DIELECTRIC = "thickness_m: 1e-3, relative_permittivity: 4.7"


def codes(example, name: str, *overrides: str) -> set[str]:
    text = example(name).read_text()
    return {alert.code for alert in analyse(loads(text, overrides=list(overrides)), ("json",)).alerts}


def test_every_code_has_one_check_and_is_explained() -> None:
    assert [known.code for known in CATALOGUE] == list(CAUSES) == list(AlertCode)
    for known in CATALOGUE:
        text = explanation(known.code.lower())
        assert text.startswith(f"{known.code} ({known.severity}): {known.title}")
        assert "Cause:" in text
        assert "Remedy:" in text
        assert max(map(len, text.splitlines())) <= 100
    assert explanation().count("Remedy:") == len(AlertCode)


def test_an_unknown_code_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UsageError, match="VR010"):
        explanation("VR999")


@pytest.mark.parametrize(
    ("code", "name", "there", "elsewhere"),
    [
        ("VR005", "inclined", ["device.length_m=0.632"], ["device.length_m=0.69"]),
        ("VR007", "horizontal", ["device.length_m=0.27", "inclination_deg=14"], []),
        ("VR009", "inclined", ["device.length_m=0.632"], ["device.length_m=0.72"]),
        ("VR010", "inclined", [], ["device.ball_mass_kg=1e-7"]),
        (
            "VR016",
            "inclined",
            [f"device.membrane={{{DIELECTRIC}, breakdown_field_v_m: 2e7}}"],
            [f"device.membrane={{{DIELECTRIC}, breakdown_field_v_m: 2e8}}"],
        ),
        ("VR011", "inclined", [], ["device.membrane.stiffness=1e12"]),
        ("VR012", "inclined", [], ["device.membrane.exponent=12"]),
        ("VR022", "inclined", ["excitation.amplitude_n=0.85", "sweep.from=0.2"], []),
    ],
)
def test_raised_where_its_cause_is(code: str, name: str, there: list[str], elsewhere: list[str], example) -> None:
    assert code in codes(example, name, *there)
    assert code not in codes(example, name, *elsewhere)


@pytest.mark.parametrize("way", range(3))
def test_each_way_into_the_geometry_is_one(way: int, example) -> None:
    """With the numbers of the alert, as printed, and with those of the results."""
    text = example("inclined").read_text()
    study = analyse(loads(text), ("json",))
    (cause,) = (alert.cause for alert in study.alerts if alert.code == "VR010")
    printed = [float(number) for number in re.findall(r"at (?:most|least) (\S+) ", cause)]
    path, scale = [("ball_mass_kg", 1e-3), ("membrane.stiffness", 1.0), ("membrane.active_radius_m", 1e-3)][way]
    exact = list(study.to_dict()["fits_membrane"].values())[way]
    assert printed[way] * scale == pytest.approx(exact, rel=2e-3)
    for value, share in ((printed[way] * scale, 0.998), (exact, 1 - 1e-11)):
        solution = analyse(loads(text, overrides={f"device.{path}": value}), ("json",)).solution
        assert share < solution.deepest_m / solution.membrane.active_radius_m <= 1
        assert solution.fitting is None


def test_next_to_a_fold_digits_are_said_to_be_missing(example, study_of) -> None:
    text = example("horizontal").read_text()
    tilted = analyse(loads(text, overrides=["inclination_deg=0.5"]))
    fold = next(c for c in tilted.solution.critical_points if c.event == "fold").sweep_value
    at = [f"device.length_m={float(np.nextafter(fold, side))!r}" for side in (0.0, 1.0)]
    raised = [codes(example, "horizontal", "inclination_deg=0.5", one) for one in at]
    assert any("VR008" in one for one in raised)
    assert "VR008" not in {alert.code for alert in study_of("horizontal").alerts}


def test_at_a_grazing_point_it_is_undecided_whether_there_is_a_motion(example) -> None:
    text = example("horizontal").read_text()
    tilted = analyse(loads(text, overrides=["inclination_deg=14"]))
    grazing = next(
        c.sweep_value for c in tilted.solution.critical_points if c.event is Event.GRAZING and c.rest is None
    )
    for length, raised in ((grazing, True), (1.001 * grazing, False)):
        study = analyse(loads(text, overrides=["inclination_deg=14", f"device.length_m={length!r}"]))
        assert ("VR014" in {alert.code for alert in study.alerts}) == raised
        assert any(study.to_dict()["design_point"]["admissible_undecided"]) == raised


def test_restitution_effect_is_the_derivative(study_of) -> None:
    """Against the same design solved anew at another restitution."""
    study = study_of("inclined")
    effect = restitution_effect(study.solution.device, study.solution.design.motions)
    assert effect.lost_at is None
    row = np.flatnonzero(study.solution.design.motions.stable)[0]
    before = study.solution.design.motions.velocity_bottom[row]
    found = []
    for r in (0.475, 0.525):
        text = study.loaded.document.text
        other = analyse(loads(text, overrides=[f"device.restitution={r}"])).solution.design.motions
        found.append(abs(other.velocity_bottom[np.flatnonzero(other.stable)[0]] / before - 1) / 0.05)
    assert effect.elasticity == pytest.approx(max(found), rel=1e-9)


def test_mass_elasticity_of_gentle_impacts_is_that_of_the_deflection(study_of) -> None:
    """Shallow: the voltage grows as the square of the deflection, the deflection as m^(1/(h+1))."""
    membrane = study_of("inclined").solution.membrane
    found = mass_elasticity(np.array([1e-6]), np.array([1e-6]), membrane)
    assert found == pytest.approx(2 / (membrane.exponent + 1), rel=1e-3)


def test_contacts_of_slow_impacts_are_the_longest(study_of) -> None:
    membrane = study_of("inclined").solution.membrane
    one, both = (contact_share(np.array(v), membrane, 0.5, np.full(len(v), 2.0)) for v in ([1.0], [4.0, 1.0]))
    assert one == both
    assert contact_share(np.array([1.0]), membrane, 0.0, np.array([2.0])) is None


@pytest.mark.parametrize(
    ("overrides", "asks"),
    [
        (["device.length_m=693.4", "device.ball_mass_kg="], "device.length_m = 693.4: metres, or is it 693.4 mm"),
        (["inclination_deg=0.785"], "inclination_deg = 0.785: degrees, or is it 0.785 rad, which is 45 degrees?"),
        (["inclination_deg=1.0472"], "which is 60 degrees?"),
        (["device.ball_mass_kg=4.1"], "device.ball_mass_kg = 4.1: 32.9 times the capsule's 0.1245 kg, or is it 4.1 g?"),
        (
            ["excitation.frequency_hz=12.566"],
            "excitation.frequency_hz = 12.566: hertz, or is it 12.566 rad/s, which is 2",
        ),
        (["excitation.frequency_hz=6.28"], "which is 1 Hz?"),
        (["gravity_m_s2=981"], "gravity_m_s2 = 981: m/s^2, or is it 981 cm/s^2, which is 9.81 m/s^2?"),
        (["sweep.to=750"], "sweep.to = 750: metres, or is it 750 mm"),
        (["device.membrane.active_radius_m=63"], "device.membrane.active_radius_m = 63: metres, or is it 63 mm"),
    ],
)
def test_a_value_in_another_unit_is_asked_about_and_not_refused(overrides: list[str], asks: str, example) -> None:
    study = analyse(loads(example("inclined").read_text(), overrides=overrides), ("json",))
    (alert,) = [alert for alert in study.alerts if alert.code == AlertCode.IMPLAUSIBLE_INPUT]
    assert asks in alert.cause


@pytest.mark.parametrize(
    "overrides",
    [
        *(["inclination_deg=0.8"], ["inclination_deg=1"], ["inclination_deg=0"], ["inclination_deg=90"]),
        *(["excitation.frequency_hz=17.6"], ["excitation.frequency_hz=2.2"], ["excitation.frequency_hz=44"]),
        *(["device.ball_mass_kg=0.0249"], ["device.length_m=15"], ["gravity_m_s2=24.8"]),
    ],
)
def test_a_value_that_can_be_meant_is_not_asked_about(overrides: list[str], example) -> None:
    study = analyse(loads(example("inclined").read_text(), overrides=overrides), ("json",))
    assert AlertCode.IMPLAUSIBLE_INPUT not in {alert.code for alert in study.alerts}
