"""What is said of other starts: facts and sentence of an opening, random kicks, and the words of the figures."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from branches import say_every_branch
from conftest import solved
from msgspec.structs import replace
from pages import read_back

from vireport.design.from_rest import Destination, FromRest
from vireport.design.switched_on import SwitchedOn
from vireport.findings.outcomes.outcomes import Outcomes, Ramp
from vireport.findings.outcomes.windows import Edge, Window
from vireport.scenario.parameters import Parameter
from vireport.study.judging.evidence import Evidence
from vireport.study.judging.opening import opening_of
from vireport.study.judging.verdict import Status, Weight, verdict_of
from vireport.text.formatting import ROUGHLY
from vireport.text.requirements import Question

SHOCK = SimpleNamespace(tried=9000, sign=1, leads_to=SimpleNamespace(name="B~ every 3 forcing periods"))
RESTING = Edge(0.6912, FromRest(Destination.REST_CYCLE, "B~", 3, 0), accumulates=True)
LENGTH_WINDOW = Window(Parameter.LENGTH, 0.7, RESTING, Edge(0.75, None, accumulates=False))


def withstood(**given: object) -> Evidence:
    """The inclined capsule with what its motion withstands: least shock, of 0.1234 m/s at the bottom, and jitter."""
    usual = {"shock": None, "shock_unknown": "", "jump_m_s": 0.1234, "searched_to_m_s": 1.5, "after_bottom": True}
    usual |= {"delay_s": 0.0, "jitter": None, "spread": None, "jitter_unknown": "", "jitter_m_s": 0.012}
    usual |= {"jitter_restitution": 0.0, "valid_up_to_restitution": None}
    usual |= {"phase_deg": 1.234, "velocity_m_s": 0.0234, "valid_up_to_m_s": 0.00356}
    return Evidence(solved("inclined"), findings={"outcomes": Outcomes(withstood=SimpleNamespace(**usual | given))})


def switched_on(end: Destination = Destination.ONE_TO_ONE, settles: int | None = 17, **found: object) -> Evidence:
    """The inclined capsule with what it comes to when it is switched on, and what is found beside."""
    motion = {Destination.ONE_TO_ONE: ("BT", 1), Destination.REST_CYCLE: ("B~", 3)}.get(end, ("", 0))
    known = SwitchedOn(FromRest(end, *motion, settles))
    return Evidence(solved("inclined"), switched_on=known, findings={"outcomes": Outcomes(**found)})


OPENINGS = {
    "a least shock": lambda: withstood(shock=SHOCK),
    "no shock leads out": lambda: withstood(shock=SHOCK, jump_m_s=None),
    "a shock not known": lambda: withstood(shock_unknown="the motion is too near"),
    "jitter": lambda: withstood(jitter=1, spread=1),
    "too much jitter": lambda: withstood(jitter=1, jitter_unknown="the kicks are too large"),
    "not reached from rest": lambda: switched_on(
        Destination.REST_CYCLE, share=0.2247, ramp=Ramp(10, 80), window=LENGTH_WINDOW
    ),
    "no ramp helps": lambda: switched_on(Destination.CHAOTIC, None, ramp=Ramp(None, 80)),
    "a window that is narrow": lambda: switched_on(share=1.0, window=LENGTH_WINDOW),
    "nothing tried": lambda: switched_on(Destination.CHAOTIC, None),
}
"""What is said of what was found."""


@pytest.mark.parametrize("name", OPENINGS)
def test_an_opening_says_what_other_starts_come_to(name: str) -> None:
    worded = opening_of(verdict_of(OPENINGS[name]())).worded()
    assert read_back("words, openings of other starts", worded.text, name) == []


def test_what_is_reached_within_narrow_limits_only_is_a_caution() -> None:
    wide = Window(Parameter.LENGTH, 0.7, Edge(0.6, RESTING.beyond, accumulates=False), LENGTH_WINDOW.high)
    for window, status in ((wide, Status.GOOD), (LENGTH_WINDOW, Status.CAUTION)):
        verdict = verdict_of(switched_on(share=1.0, window=window))
        assert verdict.from_rest.status is status
        weights = {conclusion.word: conclusion.weight for conclusion in verdict.conclusions}
        weight = Weight.MARGIN if status is Status.CAUTION else None  # more than what the model leaves open
        assert weights.get("Stable, reached from rest within narrow limits only") is weight


def test_a_required_motion_is_held_to_be_reached_also_within_narrow_limits() -> None:
    required = SimpleNamespace(key="word", question=Question.MOTION, names_motions=True, passed=True)
    evidence = switched_on(Destination.OTHER_MOTION, share=0.0, window=LENGTH_WINDOW)
    words = [conclusion.word for conclusion in verdict_of(replace(evidence, criteria=(required,))).conclusions]
    assert "Stable, reached from rest within narrow limits only" in words
    assert "Stable, but not reached from rest" not in words


SAID: list[tuple[str, tuple[object, ...]]] = [
    ("window_narrow", ("It runs",)),
    ("window_is_narrow", (SimpleNamespace(window=LENGTH_WINDOW),)),
    ("kicks", (0.012, 0.0)),
    ("kicks", (0.012, 0.02)),
    ("kicks", (0.01234, 0.0, ROUGHLY)),
    ("kicks", (0.0, 0.02345, ROUGHLY)),
]


FIGURES: list[tuple[str, dict[str, object]]] = [
    (
        "figure_shocks_caption",
        {
            "motion": "BBT",
            "points": 257,
            "returned": 0.9972,
            "largest_m_s": 2.448,
            "least_m_s": 1.224,
            "manifold": True,
        },
    ),
    (
        "figure_shocks_caption",
        {"motion": "BT", "points": 257, "returned": 1.0, "largest_m_s": 2.448, "least_m_s": None, "manifold": False},
    ),
    ("figure_shocks_alt", {"outcomes": [("BT every forcing period", 0.75), ("aperiodic", 0.0), ("rest", 0.25)]}),
    ("figure_basin_caption", {"fastest_m_s": 13.81, "points": 257, "marked": True}),
    ("figure_basin_caption", {"fastest_m_s": 13.81, "points": 257, "marked": False}),
    ("figure_basin_alt", {"shares": [("BT every forcing period", 0.853, 0.84, 0.86), ("rest", 0.147, 0.14, 0.16)]}),
]


def test_every_branch_is_said() -> None:
    figures = ((f"figures/{macro.split('_')[1]}", macro, (x,)) for macro, x in FIGURES)
    say_every_branch(*figures, *(("disturbances", *row) for row in SAID))
