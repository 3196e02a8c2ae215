"""The figures that come from simulation alone: which a study has, drawn and in words."""

from __future__ import annotations

from collections.abc import Iterator

from matplotlib.figure import Figure

from vireport.figures.captions import conditions
from vireport.figures.diagrams import figure_diagram
from vireport.figures.portrait_captions import (
    PORTRAIT_TITLES,
    diagram_alt,
    diagram_caption,
    portrait_alt,
    portrait_caption,
)
from vireport.figures.portraits import figure_3, figure_6
from vireport.study import Study, Task

Words = tuple[str, str, str, str]
"""Name, title, caption and alternative text of a figure."""


def simulated_figures(study: Study) -> Iterator[tuple[Words, Figure]]:
    """Draw what of a study comes from simulation alone, as its plan says."""
    check = study.crosscheck
    if check is None:
        return
    held = conditions(study, check.parameter)
    for name, draw, portraits in (
        (Task.FIGURE_3, figure_3, check.portraits),
        (Task.FIGURE_6, figure_6, check.displacements),
    ):
        if study.plan.runs(name):
            about, alt = portrait_caption(name, portraits, held), portrait_alt(name, portraits)
            yield (name, PORTRAIT_TITLES[name], about, alt), draw(portraits, held)
    name, diagram, values = Task.FIGURE_DIAGRAM, check.diagram, check.values
    if study.plan.runs(name) and diagram is not None:
        about, alt = diagram_caption(study, diagram, values), diagram_alt(study, diagram, values)
        yield (name, PORTRAIT_TITLES[name], about, alt), figure_diagram(study, diagram, values, check.d)
