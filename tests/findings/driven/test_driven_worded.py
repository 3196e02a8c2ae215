"""What is said of a recorded motion of the shaker: of its figure, and where the record may be wrong."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from branches import branches_taken
from conftest import solved

from vireport.findings.driven.finding import FINDING
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.verdict import Weight, verdict_of
from vireport.text.templates import Words

FIGURES = [
    (
        "figure_driven_caption",
        {"impacts": 1080, "every": 1, "share": 0.9875, "predicted": True},
        "99 % of the periods have one impact on each membrane. Lines: the speeds of the periodic motion under that "
        "sine.",
    ),
    (
        "figure_driven_caption",
        {"impacts": 20001, "every": 3, "share": 0.5, "predicted": False},
        "50 % of the periods have one impact on each membrane. Of 20001 impacts one in 3 is drawn.",
    ),
    ("figure_driven_alt", {"impacts": 1080}, "of the relative speed and of the phase of 1080 impacts on the bottom"),
]


@pytest.mark.parametrize(("macro", "x", "part"), FIGURES)
def test_the_figure_is_worded(macro: str, x: dict[str, object], part: str) -> None:
    say = Words("figures/driven")
    assert part in say(macro, x)
    assert say("figure_driven_title")


def test_every_branch_of_the_figure_is_said_above() -> None:
    with branches_taken() as taken:
        for macro, x, _ in FIGURES:
            Words("figures/driven")(macro, x)
        branches, told = taken()
    assert branches
    assert branches - told == set()


SAID = {
    "record_doubtful": (("It runs",), "It runs; the record of the shaker is doubtful."),
    "lacks_record_doubtful": ((), "doubtful record of the shaker"),
}


@pytest.mark.parametrize("macro", SAID)
def test_a_doubtful_record_is_worded(macro: str) -> None:
    given, text = SAID[macro]
    assert Words("driven")(macro, *given) == text


@pytest.mark.parametrize("doubts", [(), ("reversed",)])
def test_a_doubtful_record_is_the_last_of_what_is_held_against_a_device(doubts: tuple[str, ...]) -> None:
    found = SimpleNamespace(doubts=doubts)
    evidence = Evidence(solved("inclined"), findings={"driven": found})
    answers, said = list(FINDING.answers(found, evidence)), verdict_of(evidence).conclusions
    assert bool(answers) is bool(doubts)
    assert ("Stable, but the record of the shaker is doubtful" in [own.word for own in said]) is bool(doubts)
    assert max(own.weight for own in said) <= Weight.DIGITS or not doubts
