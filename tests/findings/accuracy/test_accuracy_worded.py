"""What is said of error against run time: in its tables, and of its figure."""

from __future__ import annotations

from types import SimpleNamespace

from branches import say_every_branch

from vireport.motions.events import Event
from vireport.scenario.parameters import Parameter

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


def test_every_branch_of_the_words_is_said() -> None:
    figures = (("figures/accuracy", macro, (x,), part) for macro, x, part in FIGURES)
    title = "figures/accuracy", "figure_accuracy_title", (), " "
    say_every_branch(title, *figures, *(("accuracy", *row) for row in SAID))
