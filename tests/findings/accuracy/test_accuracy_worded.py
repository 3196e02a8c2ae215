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
SAID: list[tuple[str, tuple[object, ...]]] = [
    ("task", ("orbit", None)),
    ("task", ("critical", B1)),
    ("task", ("critical", None)),
    ("busy", (0.3456,)),
    ("short_task", ("orbit", None)),
    ("short_task", ("critical", B1)),
    ("short_task", ("critical", None)),
    ("quantity", ("voltage", None, None)),
    ("quantity", ("critical", B1, LENGTH)),
    ("runs", ("the motion", ["phase"])),
    ("times", ("the motion", ["10⁻⁶"])),
    ("fastest", (["motion"], ["10⁻⁶"])),
    ("fitted_over", ("10", "100", 5)),
    ("failures", (0, 5)),
    ("failures", (2, 5)),
    ("settings", ("10", "10")),
    ("settings", ("10", "30")),
    ("not_tried", ("needs numba",)),
]


def test_every_branch_of_the_words_is_said() -> None:
    figures = (("figures/accuracy", macro, (ERRORS,)) for macro in ("figure_accuracy_caption", "figure_accuracy_alt"))
    say_every_branch(*figures, *(("accuracy", *row) for row in SAID))
