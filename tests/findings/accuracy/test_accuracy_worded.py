"""What is said of error against run time: in its tables, and of its figure."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from branches import branches_taken

from vireport.motions.events import Event
from vireport.scenario.parameters import Parameter
from vireport.text.templates import Words

B1 = SimpleNamespace(label="B1", event=Event.PERIOD_DOUBLING)
LENGTH = Parameter.LENGTH
ERRORS = {
    "panels": [("a", "error of the phase φ [rad]"), ("b", "relative error of |Ż| [–]")],
    "smallest": "10⁻¹⁷",
    "accuracy": "10⁻⁶",
    "methods": [
        ("RK4", [("the motion", "2 ms", 1e-9), ("B1", "", 1e-4)]),
        ("closed form", [("the motion", "1 µs", 1e-15)]),
    ],
}
FIGURES = [
    (
        "figure_accuracy_caption",
        ERRORS,
        "(a) error of the phase φ [rad], (b) relative error of |Ż| [–]; down and to the left is better.",
    ),
    (
        "figure_accuracy_alt",
        ERRORS,
        "2 line charts of error over run time, both logarithmic. RK4: the motion 2 ms to 10⁻⁶, least error 1 × 10⁻⁹; "
        "B1 not "
        "to 10⁻⁶, least error 0.0001. closed form: the motion 1 µs to 10⁻⁶, least error 1 × 10⁻¹⁵.",
    ),
]
SAID: list[tuple[str, tuple[object, ...], str]] = [
    ("gain", (), "accuracy: for error against run time"),
    ("task", ("orbit", None), "the motion"),
    ("task", ("critical", B1), "B1 (period doubling)"),
    ("task", ("critical", None), "the critical point"),
    ("busy", (0.3456,), "The machine was busy: half of the repeats of a run are spread over 35 % of their"),
    ("short_task", ("orbit", None), "motion"),
    ("short_task", ("critical", B1), "B1"),
    ("short_task", ("critical", None), "critical point"),
    ("quantity", ("voltage", None, None), "U_ave [V]"),
    ("quantity", ("critical", B1, LENGTH), "B1, s [m]"),
    ("runs", ("the motion", ["phase"]), "Evaluations | Error, phase"),
    ("times", ("the motion", ["10⁻⁶"]), "Method | to 10⁻⁶ | Least error"),
    ("fastest", (["motion"], ["10⁻⁶"]), "Method | motion to 10⁻⁶"),
    ("fitted_over", ("10", "100", 5), "10 to 100 (5 runs)"),
    ("failures", (0, 5), "none"),
    ("failures", (2, 5), "2 of 5"),
    ("settings", ("10", "10"), "10"),
    ("settings", ("10", "30"), "10 to 30"),
    ("not_tried", (), "not tried"),
    ("not_tried", ("needs numba",), "not tried: needs numba"),
]


@pytest.mark.parametrize(("macro", "x", "part"), FIGURES)
def test_the_figure_is_worded(macro: str, x: dict[str, object], part: str) -> None:
    say = Words("figures/accuracy")
    assert part in say(macro, x)
    assert say("figure_accuracy_title")


@pytest.mark.parametrize(("macro", "given", "part"), SAID)
def test_the_tables_are_worded(macro: str, given: tuple[object, ...], part: str) -> None:
    assert part in Words("accuracy")(macro, *given)


def test_every_branch_of_the_words_is_said_above() -> None:
    with branches_taken() as taken:
        for macro, x, _ in FIGURES:
            Words("figures/accuracy")(macro, x)
        for macro, given, _ in SAID:
            Words("accuracy")(macro, *given)
        branches, told = taken()
    assert {branch.partition(":")[0] for branch in branches} == {"words/accuracy.j2", "words/figures/accuracy.j2"}
    assert branches - told == set()
