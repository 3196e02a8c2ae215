"""What tolerances come to is judged: by the verdict, by a required yield, and in words."""

from __future__ import annotations

import re
from types import SimpleNamespace

import pytest
from conftest import EXAMPLES, solved
from pages import read_back

from vireport import analyse, load
from vireport.findings.tolerances.finding import FINDING, QUESTION
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.opening import opening_of
from vireport.study.judging.requirements import assess
from vireport.study.judging.verdict import Weight, verdict_of
from vireport.text.folders import ROOTS
from vireport.text.said import Said
from vireport.text.templates import Words


def tolerances(proved: bool, worst: object = None, provable: bool = True, stable: int = 48) -> SimpleNamespace:
    sampled = SimpleNamespace(stable=stable, samples=64, low=0.7, high=0.8)
    return SimpleNamespace(proved=proved, worst=worst, provable=provable, sampled=sampled)


OPENINGS = {
    "proved": tolerances(True),
    "refuted": tolerances(False, object()),
    "no device works": tolerances(False, object(), stable=0),
    "open": tolerances(False),
    "sampled alone": tolerances(False, provable=False, stable=64),
}


def evidence(found: object, **over: object) -> Evidence:
    return Evidence(solved("inclined", **over), findings={"tolerances": found})


@pytest.mark.parametrize("name", OPENINGS)
def test_an_opening_says_what_tolerances_come_to(name: str) -> None:
    worded = opening_of(verdict_of(evidence(OPENINGS[name]))).worded()
    assert read_back("words, openings of tolerances", worded.text, name) == []
    assert len(worded.sentence.split()) <= 15
    for line in worded.text:
        assert not re.search(r" [.,;]|\.\.|,,|\bnan\b|\binf\b|{", line)


SAID = {
    "lacks_not_every_device": "not every device within tolerances",
    "lacks_tolerances_open": "tolerances not decided",
    "gain": "tolerances: for the yield",
}


@pytest.mark.parametrize("macro", SAID)
def test_a_macro_says(macro: str) -> None:
    assert Words("tolerances")(macro) == SAID[macro]


def test_every_macro_is_said_above() -> None:
    (file,) = (own for root in ROOTS if (own := root / "words" / "tolerances.j2").exists())
    named, told = set(re.findall(r"macro (\w+)\(", file.read_text(encoding="utf-8"))), set(SAID)
    for found in OPENINGS.values():
        opening = opening_of(verdict_of(evidence(found)))
        rows = (opening.sentence, *(fact.said for fact in opening.facts))
        told |= {row.macro for row in rows if isinstance(row, Said) and row.file == "tolerances"}
    assert named == told


def test_what_is_open_weighs_more_than_the_margin_and_less_than_another_motion() -> None:
    """Of the inclined capsule with a light ball the margin is small."""
    verdict = verdict_of(evidence(tolerances(False), device__ball_mass_kg=1e-5))
    assert verdict.word == "Stable, but tolerances not decided"
    assert [conclusion.weight for conclusion in verdict.conclusions] == sorted(
        conclusion.weight for conclusion in verdict.conclusions
    )
    assert verdict.conclusion.weight is Weight.NOT_EVERY_DEVICE
    (answer,) = FINDING.answers(tolerances(True), evidence(None))
    assert answer.concludes is None


@pytest.mark.parametrize(
    ("required", "status", "fact", "word"),
    [
        ({}, "caution", "caution", "Stable, but not for every device within the tolerances"),
        ({"requirements.yield_at_least_percent": 50}, "caution", "caution", "Stable, margin small"),
        ({"requirements.yield_at_least_percent": 99}, "bad", "bad", "Requirements not met"),
    ],
)
def test_tolerances_that_are_not_kept_are_not_approved(
    required: dict[str, int], status: str, fact: str, word: str
) -> None:
    over = {"tolerances": {"frequency_percent": 8, "samples": 64}, **required, "device.ball_mass_kg": 1e-5}
    verdict = analyse(load(EXAMPLES / "design-point.yaml", over)).verdict
    assert (verdict.status, verdict.word) == (status, word)
    assert next(told.status for told in verdict.answers.values() if told.question == QUESTION) == fact


def test_a_yield_is_all_only_where_that_is_proved() -> None:
    over = {"requirements.yield_at_least_percent": 100, "tolerances.frequency_percent": 1}
    loaded = load(EXAMPLES / "inclined.yaml", over)
    sampled = SimpleNamespace(stable=64, samples=64, low=0.94)
    for proved in (True, False):
        known = SimpleNamespace(proved=proved, sampled=sampled)
        (criterion,) = assess(loaded, Evidence(None, findings={"tolerances": known}))
        assert (criterion.outcome.value, criterion.passed) == (100, proved)
