"""Alerts: each is raised where its cause is, not elsewhere, and each can be explained."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import EXAMPLES, first
from definitions import device_of
from pages import read_back
from scipy.optimize import brentq

from vireport import analyse, loads
from vireport.base.errors import UsageError
from vireport.design.sensitivity import contact_share, mass_elasticity, restitution_effect
from vireport.design.solution import solution_of
from vireport.measurement.shaker import ShakerDoubt, ShakerFinding
from vireport.motions.events import Event
from vireport.motions.one_to_one import impact_velocities
from vireport.motions.stability import Stability
from vireport.physics.device import Device
from vireport.physics.energy import Dielectric, Membrane, MembraneStretch, area_growth, deflection
from vireport.physics.groups import Groups, SpeedLaw
from vireport.physics.motion import Symmetry
from vireport.scenario.loading import Loaded
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.study.judging.alerts import CAUSES, Alert, causes_of
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.verdict import Status
from vireport.study.study import Study, sweep_of
from vireport.text.alerts import CATALOGUE, AlertCode, Explanation, explanation
from vireport.text.formatting import OF_A_MODEL, ROUGHLY, rounded_text
from vireport.text.patterns import patterns

DIELECTRIC = "thickness_m: 1e-3, relative_permittivity: 4.7"


@cache
def codes(name: str, *overrides: str) -> set[str]:
    text = (EXAMPLES / f"{name}.yaml").read_text()
    return {alert.code for alert in analyse(loads(text, overrides=list(overrides)), ("json",)).alerts}


def test_every_code_has_one_check_and_is_explained() -> None:
    assert [known.code for known in CATALOGUE] == list(AlertCode)
    # Those of a recorded shaker and of compliant membranes are raised by what additions find.
    raised_by_additions = {AlertCode.RECORD_DOUBTFUL, AlertCode.NOT_RIGID}
    assert list(CAUSES) == [code for code in AlertCode if code not in raised_by_additions]
    for known in CATALOGUE:
        text = explanation(known.code.lower())
        assert text.startswith(f"{known.code} ({known.severities}): {known.title}")
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
        (
            "VR017",
            "inclined",
            [f"device.membrane={{{DIELECTRIC}, breakdown_field_v_m: 2e8, bias_voltage_v: 6000}}"],
            [f"device.membrane={{{DIELECTRIC}, breakdown_field_v_m: 2e8, bias_voltage_v: 5000}}"],
        ),
        (
            "VR017",
            "inclined",
            [
                f"device.membrane={{{DIELECTRIC}, breakdown_field_v_m: 2e8, bias_voltage_v: 6000}}",
                *("device.restitution=", "device.restitution_bottom=0.5", "device.restitution_top=0.49"),
            ],
            ["device.restitution=", "device.restitution_bottom=0.5", "device.restitution_top=0.49"],
        ),
        ("VR011", "inclined", [], ["device.membrane.stiffness=1e12"]),
        ("VR012", "inclined", [], ["device.membrane.exponent=12"]),
        ("VR022", "inclined", ["excitation.amplitude_n=0.85", "sweep.from=0.2"], []),
    ],
)
def test_raised_where_its_cause_is(code: str, name: str, there: list[str], elsewhere: list[str], example) -> None:
    assert code in codes(name, *there)
    assert code not in codes(name, *elsewhere)


PAPER = {"horizontal": (4.40, 2.52, 0.386), "inclined": (5.33, 3.05, 0.568), "inclined-forcing": (6.13, 3.50, 0.751)}
"""Area ratio, depth over radius and the thickness [mm] at 100 MV/m of the paper's design points."""

GIVEN_FILM = {"thickness_m": 1e-3, "relative_permittivity": 4.7, "breakdown_field_v_m": 2e8}


def deep_alert(study: Study) -> Alert | None:
    return next((alert for alert in study.alerts if alert.code == "VR010"), None)


@pytest.mark.parametrize("name", first(1, PAPER))
def test_a_deep_deflection_says_what_is_open_with_numbers(name: str, example) -> None:
    """Against (5.2)-(5.5) as printed; the thickness only where the scenario gives none."""
    text = example(name).read_text()
    study = analyse(loads(text), ("json",))
    device, design = device_of(study.to_dict()["scenario"]), study.solution.design
    bottom, top = (float(abs(v[design.motions.stable_mask]).max()) for v in at_design_speeds(study))
    fastest = max(bottom, top)
    depth, peak = device.deflection(fastest), device.gain(fastest) + 2000.0
    area, thickness = (peak / 2000.0) ** 0.5, peak / 1e8
    assert (area, depth / 6.3e-3, 1e3 * thickness) == pytest.approx(PAPER[name], rel=2e-3)
    stretch = study.to_dict()["stretch"]
    assert stretch == pytest.approx(
        {
            "deflection_m": depth,
            "deflection_over_radius": depth / 6.3e-3,
            "area_ratio": area,
            "u_imp_v": peak,
            "thickness_needed_m": thickness,
            "at_field_v_m": 1e8,
        },
        rel=1e-11,
    )
    alert = deep_alert(study)
    assert alert.severity == ("warning" if name == "inclined-forcing" else "note")
    for part in (
        f"up to {rounded_text(1e3 * depth)} mm, "
        f"{rounded_text(depth / 6.3e-3, ROUGHLY)} times its active radius of 6.3 mm",
        f"its area grows {rounded_text(area)} times",
        "K delta^h is extrapolated",
        f"At a breakdown field of 100 MV/m its {rounded_text(peak / 1e3)} kV need a thickness of "
        f"{rounded_text(1e3 * thickness, ROUGHLY)} mm",
    ):
        assert part in str(alert.cause)
    film = analyse(loads(text, overrides={f"device.membrane.{key}": value for key, value in GIVEN_FILM.items()}))
    assert "thickness" not in str(deep_alert(film).cause)
    assert film.to_dict()["stretch"]["thickness_needed_m"] == pytest.approx(thickness / 2, rel=1e-11)


def at_design_speeds(study: Study) -> tuple[np.ndarray, np.ndarray]:
    return impact_velocities(study.solution.device, study.solution.parameter, study.solution.design.motions)


@pytest.mark.parametrize(("area", "severities"), [(None, (None, "note")), (5.9, ("note", "warning"))])
def test_severity_of_a_deep_deflection_changes_at_the_radius_and_at_what_is_demonstrated(
    area: float | None, severities: tuple[str | None, str], example
) -> None:
    """The ball's mass with which the deepest impact is as deep as the radius, or stretches 5.9 times, and a bit off."""
    text = example("inclined").read_text()
    solution = analyse(loads(text), ("json",)).solution
    depth = solution.membrane.active_radius_m
    if area is not None:
        depth = brentq(lambda x: 1 + float(area_growth(x, solution.membrane)) - area, 0.01, 0.05, xtol=1e-16)
    mass = 0.0041 * (depth / solution.stretch.depth_m) ** 3.6
    for off, severity in zip((-1e-9, 1e-9), severities, strict=True):
        study = analyse(loads(text, overrides={"device.ball_mass_kg": mass * (1 + off)}), ("json",))
        alert = deep_alert(study)
        assert (None if alert is None else alert.severity) == severity
        mark = {None: Status.GOOD, "note": Status.NEUTRAL, "warning": Status.CAUTION}[severity]
        assert study.verdict.voltage.status is mark


NO_AMPLITUDE = "With this membrane no amplitude gives both short contacts and shallow dents"


@pytest.mark.parametrize(
    ("overrides", "code", "percent"),
    [
        ({}, "VR010", 5.1),
        ({"device.restitution": 0.7}, "VR010", 4.6),
        ({"excitation.frequency_hz": 2.5}, "VR010", 6.3),
        ({"device.membrane.exponent": 1.0, "device.membrane.stiffness": 700.0}, "VR010", 1.6),
        ({"device.membrane.exponent": 0.9}, None, None),  # there contacts get shorter the gentler they are
        (  # shallow dents, long contacts: the horizontal motion of the paper with less of everything
            {"inclination_deg": 0.0, "excitation.amplitude_n": 0.237, "device.length_m": 0.04388, "sweep": None},
            *("VR011", 5.1),
        ),
        ({"device.membrane.stiffness": 1e12}, None, None),  # short ones
    ],
)
def test_that_no_amplitude_helps_is_said_once_where_it_is_so(
    overrides: dict[str, float | None], code: str | None, percent: float | None, example
) -> None:
    study = analyse(loads(example("inclined").read_text(), overrides=overrides), ("json",))
    saying = [alert for alert in study.alerts if NO_AMPLITUDE in str(alert.cause)]
    assert [alert.code for alert in saying] == ([] if code is None else [code])
    if percent is not None:
        assert f"the contact lasts {percent} % of a period" in str(saying[0].cause)


@pytest.mark.slow
def test_deep_deflections_of_another_motion_are_told_where_no_1_1_motion_is_stable(example) -> None:
    text = example("inclined").read_text()
    over = {"device.length_m": 0.6, "motions.impacts": 4, "motions.periods": 2}
    assert deep_alert(analyse(loads(text, overrides={"device.length_m": 0.6}))) is None
    study = analyse(loads(text, overrides=over), ("json",))
    depths = [
        float(deflection(abs(unit * motion.velocity), study.solution.membrane).max())
        for unit in [3 / (2 * 0.1245 * 2)]
        for _, motion in study.evidence.stable
    ]
    assert f"up to {1e3 * max(depths):.3g} mm" in str(deep_alert(study).cause)


@pytest.mark.parametrize("way", first(1, range(3)))
def test_each_change_that_keeps_deflections_within_the_radius_does(way: int, example) -> None:
    text = example("inclined").read_text()
    exact = list(analyse(loads(text), ("json",)).to_dict()["fits_membrane"].values())[way]
    path = ["ball_mass_kg", "membrane.stiffness", "membrane.active_radius_m"][way]
    solution = analyse(loads(text, overrides={f"device.{path}": exact}), ("json",)).solution
    assert 1 - 1e-11 < solution.deepest_m / solution.membrane.active_radius_m <= 1
    assert solution.fitting is None


@pytest.mark.slow
def test_next_to_a_fold_digits_are_said_to_be_missing(example, study_of) -> None:
    text = example("horizontal").read_text()
    tilted = analyse(loads(text, overrides=["inclination_deg=0.5"]))
    fold = next(c for c in tilted.solution.critical_points if c.event == "fold").sweep_value
    at = [f"device.length_m={float(np.nextafter(fold, side))!r}" for side in (0.0, 1.0)]
    raised = [codes("horizontal", "inclination_deg=0.5", place) for place in at]
    assert any("VR008" in alerts for alerts in raised)
    assert "VR008" not in {alert.code for alert in study_of("horizontal").alerts}


@pytest.mark.slow
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
    row = np.flatnonzero(study.solution.design.motions.stable_mask)[0]
    before = study.solution.design.motions.velocity_bottom[row]
    seen = []
    for r in (0.475, 0.525):
        text = study.loaded.document.text
        other = analyse(loads(text, overrides=[f"device.restitution={r}"])).solution.design.motions
        seen.append(abs(other.velocity_bottom[np.flatnonzero(other.stable_mask)[0]] / before - 1) / 0.05)
    assert effect.elasticity == pytest.approx(max(seen), rel=1e-9)


def test_mass_elasticity_of_gentle_impacts_is_that_of_the_deflection(study_of) -> None:
    """Shallow: the voltage grows as the square of the deflection, the deflection as m^(1/(h+1))."""
    membrane = study_of("inclined").solution.membrane
    elasticity = mass_elasticity(np.array([1e-6]), np.array([1e-6]), membrane)
    assert elasticity == pytest.approx(2 / (membrane.exponent + 1), rel=1e-3)


def test_contacts_of_slow_impacts_are_the_longest(study_of) -> None:
    membrane = study_of("inclined").solution.membrane
    single, both = (contact_share(np.array(v), membrane, 0.5, np.full(len(v), 2.0)) for v in ([1.0], [4.0, 1.0]))
    assert single == both
    assert contact_share(np.array([1.0]), membrane, 0.0, np.array([2.0])) is None


def causes(code: AlertCode) -> set[str]:
    """Names of the sentences on the cause of an alert."""
    names = {name.removeprefix(f"{code}.") for name in patterns("alerts") if name.startswith(f"{code}.")}
    assert names > {"title", "meaning", "remedy"}
    return names - {"title", "meaning", "remedy"}


def cause_of(known: Explanation, evidence: Evidence) -> str:
    """What raises an alert, with its numbers; "" where nothing does."""
    return str(known.cause(causes_of(known.code, evidence)))


def implausible(loaded: Loaded) -> str:
    """What the alert on inputs says of a scenario, without margins, which take most of a study."""
    device, membrane = Device.of(loaded.scenario), Membrane.of(loaded.scenario)
    (known,) = (known for known in CATALOGUE if known.code is AlertCode.IMPLAUSIBLE_INPUT)
    return cause_of(known, Evidence(solution_of(device, membrane, sweep_of(loaded.scenario), design=False)))


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
    assert asks in implausible(loads(example("inclined").read_text(), overrides=overrides))


@pytest.mark.parametrize(
    "overrides",
    [
        *(["inclination_deg=0.8"], ["inclination_deg=1"], ["inclination_deg=0"], ["inclination_deg=90"]),
        *(["excitation.frequency_hz=17.6"], ["excitation.frequency_hz=2.2"], ["excitation.frequency_hz=44"]),
        *(["device.ball_mass_kg=0.0249"], ["device.length_m=15"], ["gravity_m_s2=24.8"]),
    ],
)
def test_a_value_that_can_be_meant_is_not_asked_about(overrides: list[str], example) -> None:
    assert implausible(loads(example("inclined").read_text(), overrides=overrides)) == ""


def known(**results: object) -> SimpleNamespace:
    """A solution of which nothing is known but what is given."""
    nothing = {"diagram": None, "stable_ranges": (), "branches": (), "design": None, "membrane": None, "sweep": None}
    nothing |= {"critical_points": (), "horizontal": False, "stretch": None, "on_table": False}
    nothing |= {"device": SimpleNamespace(rubs=False, law=None)}
    return SimpleNamespace(**nothing | results)


def stretches(*stable: Stability) -> tuple[SimpleNamespace, ...]:
    """A branch that passes through a membrane along some stretches."""
    parts = [SimpleNamespace(admissible=False, stability=x, first=k, last=k) for k, x in enumerate(stable)]
    motions = SimpleNamespace(wall_gap=-0.01 * np.arange(1.0, 1 + len(parts)))
    return (SimpleNamespace(family=SimpleNamespace(segments=parts), motions=motions),)


class Rows(SimpleNamespace):
    def __len__(self) -> int:
        return len(self.stable_mask)


def design(count: int, stable: int = 0, **more: object) -> SimpleNamespace:
    flags = np.arange(count) < stable
    motions = Rows(stable_mask=flags, d=np.full(count, 0.5), wall_gap=0.009 + 5e-4 * np.arange(count))
    families = (Symmetry.ASYMMETRIC,) * count
    of = {"motions": motions, "parameter": Parameter.LENGTH, "value": 0.7, "families": families, "endings": list}
    return SimpleNamespace(**of | more)


def ending(relative: float, taken_over: bool = False) -> SimpleNamespace:
    of = {"parameter": Parameter.LENGTH, "name": "fold D1", "taken_over": taken_over}
    end = SimpleNamespace(relative=relative, distance=0.7 * relative, size=abs(relative), **of)
    return design(1, 1, limits=lambda: [end])


def come_to(word: str, sticks: bool = False) -> SimpleNamespace:
    return SimpleNamespace(name=word, word=word, cycle=SimpleNamespace(sticks=sticks), is_one_to_one=word == "BT")


def sampled(*ends: SimpleNamespace) -> SimpleNamespace:
    return SimpleNamespace(sampled=[SimpleNamespace(start=0.25 + k / 100, outcome=end) for k, end in enumerate(ends)])


def rough(*labels: str) -> tuple[SimpleNamespace, ...]:
    return tuple(SimpleNamespace(label=x, error_bound=1e-9, sweep_value=0.7) for x in labels)


def deep(area: float, dielectric: Dielectric | None = None) -> dict[str, object]:
    stretch = MembraneStretch(0.0189, 3.0, area, 61300.0)
    membrane = Membrane(4.0847e5, 2.6, 6.3e-3, 5.0e-3, 2000.0, 0.0041, dielectric)
    device = SimpleNamespace(rubs=False, law=None, restitution=0.5)
    return {"solution": known(membrane=membrane, stretch=stretch, device=device), "impacts": (np.full(1, 2.0),) * 3}


def simulated(**given: object) -> dict[str, object]:
    motion = SimpleNamespace(count=5, name="BBT every forcing period", stays=True)
    usual = {"passed": False, "orbits": 9, "misses": (1, 2), "velocity_difference": 1e-3, "phase_difference": 2e-3}
    usual |= {"tolerance": 1e-9, "elsewhere": (motion,) * 4, "motions": (motion,), "trials": 40, "arrivals": 20}
    return {"crosscheck": SimpleNamespace(**usual | given)}


def given(**values: object) -> SimpleNamespace:
    """A device with some values, and others that can be meant."""
    usual = {"length_m": 0.7, "amplitude_n": 3.0, "frequency_hz": 2.0, "inclination_deg": 45.0}
    usual |= {"capsule_mass_kg": 0.1245, "restitution": 0.5, "gravity_m_s2": 9.8}
    device = SimpleNamespace(
        **{"groups": lambda *_: Groups(0.5, 1.25, 0.5), "harmonics": (), "ball_mass_kg": None} | usual | values
    )
    device.inputs = tuple(DesignInput(key) for key in usual if key != "gravity_m_s2")
    device.value_of = lambda varied: getattr(device, varied)
    return device


def doubtful(*doubts: ShakerFinding) -> dict[str, object]:
    """Results that rest on a record of the shaker which may be wrong."""
    return {"findings": {"driven": SimpleNamespace(doubts=doubts)}}


SAID = [
    ("VR001", {"solution": known(diagram=object())}),
    (
        "VR001",
        {
            "solution": known(diagram=object(), parameter=Parameter.LENGTH),
            "switched_on": sampled(come_to("BBT"), come_to("B~T", sticks=True)),
            "from_rest_along": (come_to("BBT"), come_to("B~T", sticks=True)),
        },
    ),
    ("VR002", {"solution": known(branches=stretches(Stability.UNSTABLE_NODE))}),
    ("VR002", {"solution": known(branches=stretches(Stability.STABLE_NODE))}),
    ("VR002", {"solution": known(branches=stretches(*[Stability.UNSTABLE_NODE] * 3))}),
    ("VR002", {"solution": known(branches=stretches(Stability.UNSTABLE_NODE, Stability.STABLE_FOCUS))}),
    ("VR002", {"solution": known(branches=stretches(*[Stability.STABLE_NODE] * 2), device=SimpleNamespace(rubs=True))}),
    ("VR003", {"solution": known(design=design(0))}),
    ("VR003", {"solution": known(design=design(1))}),
    ("VR003", {"solution": known(design=design(1, lost=0), device=SimpleNamespace(law=SpeedLaw(0.5, 0.5, -0.1, 1.0)))}),
    ("VR003", {"solution": known(design=design(1, lost=2), device=SimpleNamespace(law=SpeedLaw(0.5, 0.5, -0.1, 1.0)))}),
    (
        "VR003",
        {
            "solution": known(design=design(3)),
            "atlas": SimpleNamespace(stable_at=lambda value: [(SimpleNamespace(name=f"{value} BBT"), None)] * 2),
        },
    ),
    ("VR003", {"solution": known(design=design(1)), "from_rest": come_to("BBT")}),
    ("VR003", {"solution": known(design=design(1)), "from_rest": come_to("B~T", sticks=True)}),
    ("VR003", {"solution": known(design=design(1)), "from_rest": come_to("BBTBT")}),
    (
        "VR003",
        {"solution": known(design=design(1), device=SimpleNamespace(rubs=True, law=None)), "from_rest": come_to("BT")},
    ),
    (
        "VR003",
        {
            "solution": known(design=design(1)),
            "motion_from_rest": SimpleNamespace(
                stability=Stability.STABLE_FOCUS,
                varied=DesignInput.LENGTH,
                low=0.6543,
                high=0.7654,
                ends=("grazing", "followed no farther"),
            ),
        },
    ),
    (
        "VR003",
        {
            "solution": known(design=design(1)),
            "by_starts": (
                SimpleNamespace(
                    name="B every 2 forcing periods",
                    stability=Stability.STABLE_FOCUS,
                    varied=DesignInput.LENGTH,
                    low=0.6543,
                    high=0.7654,
                    ends=("grazing", "fold"),
                ),
            ),
        },
    ),
    (
        "VR003",
        {
            "solution": known(design=design(1)),
            "from_rest": SimpleNamespace(name="chaotic", cycle=None, is_one_to_one=False),
        },
    ),
    ("VR004", {"solution": known(design=design(3, 2))}),
    ("VR005", {"solution": known(design=ending(-0.0123))}),
    ("VR005", {"solution": known(design=ending(-0.0123, taken_over=True))}),
    ("VR005", {"solution": known(design=ending(0.0123, taken_over=True))}),
    ("VR005", {"solution": known(design=ending(3.1e-5))}),
    ("VR005", {"solution": known(design=ending(0.0123))}),
    ("VR006", {"solution": known(critical_points=rough("B1"))}),
    ("VR006", {"solution": known(critical_points=rough("B1", "C2"))}),
    ("VR007", {"solution": known(design=design(2, 2))}),
    ("VR010", deep(5.53)),
    ("VR010", deep(5.93, Dielectric(1e-3, 4.7, 1e8))),
    (
        "VR016",
        {
            "solution": known(
                design=SimpleNamespace(
                    conversion_by_motion=SimpleNamespace(field_v_m=np.array([2.5e7, 3.1e7, 9e7])),
                    motions=SimpleNamespace(stable_mask=np.array([True, True, False])),
                ),
                membrane=SimpleNamespace(dielectric=SimpleNamespace(breakdown_field_v_m=2e7)),
            )
        },
    ),
    *(
        ("VR018", doubtful(ShakerFinding(doubt, "a", value, 12.5, 2.5, 24.5)))
        for doubt, value in (
            (ShakerDoubt.FACTOR, 9.81),
            (ShakerDoubt.FACTOR, -1 / 9.81),
            (ShakerDoubt.FACTOR, 1000.0),
            (ShakerDoubt.FACTOR, 0.001),
            (ShakerDoubt.FORCE, 2.0),
            (ShakerDoubt.REVERSED, -1.0),
            (ShakerDoubt.LONE, 300.0),
            (ShakerDoubt.CLIPPED, 0.25),
        )
    ),
    ("VR020", simulated()),
    ("VR021", simulated()),
    ("VR022", simulated()),
    ("VR022", {"solution": known(device=given())}),
    ("VR015", {"solution": known(device=given(length_m=70.0))}),
    ("VR015", {"solution": known(device=given(length_m=300.0, groups=lambda *_: Groups(300.0, 1.25, 0.5)))}),
    ("VR015", {"solution": known(device=given(frequency_hz=12.566), membrane=SimpleNamespace(ball_mass_kg=0.083))}),
    ("VR015", {"solution": known(device=given(gravity_m_s2=981.0, inclination_deg=0.7854))}),
]
"""Alerts, and what results raise them."""

BY_RESULTS = {"VR008", "VR009", "VR011", "VR012", "VR013", "VR014", "VR017"}
"""Alerts whose causes are looked at above, beside the verdict and with the membranes, on results of scenarios."""


def test_a_velocity_that_moves_more_than_the_restitution_is_told_by_how_much(monkeypatch) -> None:
    effect = SimpleNamespace(lost_at=None, elasticity=2.46)
    monkeypatch.setattr("vireport.study.judging.alerts.restitution_effect", lambda *_: effect)
    row = next(row for row in CATALOGUE if row.code is AlertCode.SENSITIVE_TO_RESTITUTION)
    said = cause_of(row, evidence_of({"solution": known(design=design(1, 1))}))
    assert said == "1 % of restitution changes the impact velocity by 2.5 %."


def evidence_of(results: dict[str, object]) -> SimpleNamespace:
    nothing = {"solution": known(), "criteria": (), "atlas": None, "crosscheck": None}
    nothing |= {
        "from_rest": None,
        "from_rest_along": (),
        "switched_on": None,
        "motion_from_rest": None,
        "by_starts": (),
        "findings": {},
        "exactness": OF_A_MODEL,
    }
    evidence = SimpleNamespace(**nothing | results)
    evidence.required_motions_met = any(line.names_motions and line.passed for line in evidence.criteria)
    return evidence


def test_causes_say_what_is_kept() -> None:
    rows, lines = {row.code: row for row in CATALOGUE}, []
    for code, results in SAID:
        lines.append(f"{code}: {cause_of(rows[AlertCode(code)], evidence_of(results))}")
        light = given(groups=lambda *_: Groups(0.5, 0.5, 0.5))
        assert not cause_of(rows[AlertCode(code)], Evidence(known(device=light)))
    assert not any("{" in line for line in lines)
    assert read_back("words, causes", lines) == []


@pytest.mark.parametrize(("end", "block"), [(come_to("BBT"), "atlas"), (come_to("B~T", sticks=True), "crosscheck")])
def test_a_block_that_a_scenario_has_is_not_recommended(end: object, block: str) -> None:
    there = SimpleNamespace(stable_at=lambda _: [])
    for row, results in (
        (CAUSES[AlertCode.DESIGN_NOT_STABLE], {"solution": known(design=design(1)), "from_rest": end}),
        (
            CAUSES[AlertCode.NO_STABLE_MOTION],
            {
                "solution": known(diagram=object(), parameter=Parameter.LENGTH),
                "switched_on": sampled(end),
                "from_rest_along": (end,),
            },
        ),
    ):
        without, having = (
            [sentence.name for sentence in row(evidence_of(results | own))] for own in ({}, {block: there})
        )
        assert "shown_by" in without
        assert having == [name for name in without if name != "shown_by"]


def test_every_sentence_on_a_cause_is_said_by_some_results() -> None:
    said = {
        (code, sentence.name)
        for code, results in SAID
        for sentence in causes_of(AlertCode(code), evidence_of(results))
        for sentence in (sentence, *(phrase for x in sentence.values.values() if isinstance(x, list) for phrase in x))
    }
    known_ones = {
        (row.code.value, name) for row in CATALOGUE if row.code not in BY_RESULTS for name in causes(row.code)
    }
    assert known_ones == said
