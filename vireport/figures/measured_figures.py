"""The figures of what was measured: error against run time, and solvers on stiff membranes."""

from __future__ import annotations

from collections.abc import Iterator

from matplotlib.figure import Figure

from vireport.figures import accuracy as accuracy_figure
from vireport.figures import compliant as compliant_figure
from vireport.study import Study, Task


def measured_figures(study: Study) -> Iterator[tuple[tuple[str, str, str, str], Figure]]:
    """Draw what a study has measured, as its plan says; each with its name, title, caption and alternative text."""
    work, made = study.work, study.compliance
    if study.plan.runs(Task.FIGURE_ACCURACY) and work is not None and work.quantities:
        yield accuracy_figure.words(work), accuracy_figure.figure_accuracy(work)
    if study.plan.runs(Task.FIGURE_STIFFNESS) and made is not None and made.runs:
        told = compliant_figure.NAME, compliant_figure.TITLE, compliant_figure.caption(made)
        yield (*told, compliant_figure.alt_text(made)), compliant_figure.figure_stiffness(made)
