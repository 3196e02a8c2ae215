"""What is said of compliant membranes: of the comparison with rigid ones, of its figure, and against a device."""

from __future__ import annotations

from importlib import import_module
from types import SimpleNamespace

import pytest
from branches import say_every_branch
from conftest import solved

from vireport.findings.membranes.compliance import Grade, Unit, moved_or_lost
from vireport.findings.membranes.finding import FINDING
from vireport.motions.events import Event
from vireport.scenario.loading import load
from vireport.scenario.parameters import Parameter
from vireport.study.judging.alerts import alerts
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.verdict import verdict_of
from vireport.study.plan import plan
from vireport.text.alerts import AlertCode
from vireport.text.patterns import patterns


def thing(**of: object) -> SimpleNamespace:
    return SimpleNamespace(**of)


B1 = thing(label="B1", event=Event.PERIOD_DOUBLING)
ORBIT = thing(contact_share=0.0209, stable=True)
RUNG = thing(orbit=ORBIT, critical_value=0.58, reason="")


def compared(name: str, shift: float, *, of_margin: bool = False, moved: float | None = -0.1) -> SimpleNamespace:
    return thing(criterion=thing(name=name, shift=shift), of_margin=of_margin, shift=moved)


def comparison(**of: object) -> SimpleNamespace:
    return thing(**{"unscaled": RUNG, "critical": B1, "grade": Grade.GOOD, "reason": "there is no ball"} | of)


STIFF = {"wrong": 0.01, "order": 0.2778, "failed": [], "exponents": []}
FIGURES = [
    ("figure_stiffness_caption", STIFF),
    ("figure_stiffness_caption", STIFF),
    (
        "figure_stiffness_alt",
        {**STIFF, "failed": ["RK4", "DOP853"], "exponents": [("velocity", -0.277), ("B1", -0.28)]},
    ),
    ("figure_stiffness_alt", STIFF),
]

SAID: list[tuple[str, tuple[object, ...]]] = [
    ("not_rigid", ("It runs",)),
    ("distance", ("",)),
    ("distance", ("B1",)),
    ("errors", (["10⁸"],)),
    ("quantity", ("phase", "rad")),
    ("quantity", ("restitution", "")),
    ("what_is_lost", ("B1",)),
    ("what_is_lost", ("",)),
    ("why", ("lost at 5: no root: none",)),
    ("why", ("lost",)),
    ("verdict", (comparison(unscaled=None), [])),
    ("verdict", (comparison(unscaled=thing(orbit=None, reason="lost: no root")), [])),
    ("verdict", (comparison(unscaled=thing(orbit=thing(stable=False))), [])),
    ("verdict", (comparison(unscaled=thing(orbit=ORBIT, critical_value=None, reason="lost")), [])),
    ("verdict", (comparison(), [])),
    ("verdict", (comparison(critical=None, grade=None), [])),
    (
        "verdict",
        (
            comparison(grade=Grade.INSUFFICIENT),
            [
                compared("U_ave", 0.25),
                compared("B1", -0.6, of_margin=True),
                compared("B1", 2.46, of_margin=True, moved=0.1),
            ],
        ),
    ),
]


def test_every_branch_of_the_words_is_said() -> None:
    figures = (("figures/stiffness", macro, (x,)) for macro, x in FIGURES)
    say_every_branch(*figures, *(("compliant", *row) for row in SAID))


def moved(stable: bool, *shifts: tuple[object, float], **changed: object) -> SimpleNamespace:
    """A rigid model that is not good enough, by some shifts or because something is lost."""
    rows = [
        thing(unit=unit, of_margin=isinstance(unit, Parameter), criterion=thing(name=name, shift=x, grade=Grade(2)))
        for name, unit, x in shifts
    ]
    rung = thing(orbit=thing(stable=stable))
    return thing(**{"grade": Grade.INSUFFICIENT, "quantities": rows, "unscaled": rung, "critical": B1} | changed)


@pytest.mark.parametrize("grade", sorted(Grade))
def test_a_rigid_model_that_is_not_good_enough_is_held_against_a_device(grade: Grade) -> None:
    evidence = Evidence(solved("inclined", device__ball_mass_kg=1e-5), findings={"membranes": moved(True, grade=grade)})
    verdict = verdict_of(evidence)
    assert verdict.added["membranes"].status == ("good", "caution", "bad")[grade]
    assert (verdict.word == "Stable, by a rigid model that is not good enough") is (grade is Grade.INSUFFICIENT)
    assert ("VR013" in {alert.code for alert in alerts(evidence)}) is (grade is Grade.INSUFFICIENT)


def test_where_nothing_is_compared_nothing_is_answered() -> None:
    found = thing(grade=None)
    assert not list(FINDING.answers(found, Evidence(solved("inclined"))))
    assert not FINDING.contradicts_rigid_impacts(found)


@pytest.mark.parametrize(
    ("comparison", "cause"),
    [
        (
            moved(True, ("velocity", Unit.VELOCITY, 0.06), ("U_ave", Unit.VOLTAGE, -0.25)),
            "moves velocity by +6 %, U_ave by \u221225 %.",
        ),
        (moved(True, ("B1", Parameter.LENGTH, -0.6)), "stiffness moves B1 by 0.6 times the margin to it."),
        (moved(True), "B1 is lost."),
        (moved(False), "the stable motion is lost."),
        (moved(True, critical=None), "the stable motion is lost."),
    ],
)
def test_the_alert_says_what_moves_or_is_lost(comparison: SimpleNamespace, cause: str) -> None:
    evidence = Evidence(solved("inclined"), findings={"membranes": comparison})
    assert next(str(alert.cause) for alert in alerts(evidence) if alert.code == "VR013").endswith(cause)


def test_no_alert_where_no_motion_is_stable() -> None:
    evidence = Evidence(solved("inclined", device__length_m=0.6), findings={"membranes": moved(False)})
    assert not evidence.impacts[0].size
    assert "VR013" not in {alert.code for alert in alerts(evidence)}


def test_short_contacts_may_move_a_motion_as_well() -> None:
    """Next to its end: the alerts on long contacts and on the rigid model have each its own cause."""
    solution = solved("inclined", device__membrane__stiffness=1e12)
    stiff = Evidence(solution, findings={"membranes": moved(True, ("U_ave", Unit.VOLTAGE, 0.25))})
    assert {"VR011", "VR013"} & {alert.code for alert in alerts(stiff)} == {"VR013"}


def test_every_sentence_of_the_alert_is_said_above() -> None:
    comparisons = (moved(True, ("U_ave", Unit.VOLTAGE, 0.2), ("B1", Parameter.LENGTH, 1.0)), moved(True), moved(False))
    said = [sentence for comparison in comparisons for sentence in moved_or_lost(comparison)]
    within = [part for sentence in said for part in sentence.values.get("shifts", ())]
    names = {
        f"{AlertCode.NOT_RIGID}.{name}" for name in ("title", "meaning", "remedy", *(x.name for x in said + within))
    }
    assert names == {name for name in patterns("alerts") if name.startswith(AlertCode.NOT_RIGID)}


def test_the_motion_is_followed_without_the_package_of_40_digits(example, monkeypatch) -> None:
    monkeypatch.setattr(import_module("vireport.study.plan"), "find_spec", lambda name: None)
    planned = plan(load(example("inclined"), ["accuracy={}"]).scenario, ("json",))
    assert planned.runs("compliant")
    assert not planned.runs("figure-stiffness", "accuracy")
