"""How the nearest end of stable motion moves with the other inputs: a tornado chart and its words."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from vireport.design.margins import Margin
from vireport.figures.captions import pictured
from vireport.figures.layout import blank, finished, folded
from vireport.figures.style import (
    GUIDE,
    Color,
    Picture,
    sheet,
    style,
)
from vireport.figures.ticks import set_ticks
from vireport.scenario.parameters import DesignInput
from vireport.study.plan import Task
from vireport.study.study import Study

BESIDE_NAMES = 0.6
"""Share of a panel's width that the names of inputs leave to the bars."""

BAR_HEIGHT, ROOM = 0.18, 0.72
"""Heights of each bar with its gap, and of the axis with its label [in]."""


def figure_margins(end: Margin, shifts: list[tuple[DesignInput, float]]) -> Figure:
    """Bars of how far an end of stable motion moves if each other input grows by 1 %, the longest at the top."""
    height = ROOM + BAR_HEIGHT * len(shifts)
    with style():
        figure, panels = blank(1)
        axes = panels[0, 0]
        axes.barh(range(len(shifts)), [shift for _, shift in shifts], height=0.7, color=Color.GREY)
        set_ticks(axes.yaxis, range(len(shifts)), [name.quantity for name, _ in shifts])
        axes.invert_yaxis()
        axes.axvline(0.0, **GUIDE)
        shift = f"shift of the {end.event.words} in {end.parameter.symbol} [% of its value]"
        axes.set_xlabel(folded(shift, sheet().letters(BESIDE_NAMES * sheet().across)))
        return finished(figure, height, [], [])


def picture(study: Study, templates: Path | None = None) -> Picture | None:
    """The figure with its words; None where stable motion ends nowhere, or nothing moves its end."""
    design = study.solution.design
    end = design.nearest if design is not None else None
    shifts = _shifts(study, end) if end is not None else []
    if end is None or not shifts:
        return None
    words = {"end": end, "shifts": shifts, "exactness": study.evidence.exactness}
    return pictured(Task.FIGURE_MARGINS, words, figure_margins(end, shifts), templates)


def _shifts(study: Study, end: Margin) -> list[tuple[DesignInput, float]]:
    """Relative change of the value at which motion ends over that of each other input, largest first."""
    shifts = [
        (name, derivative * float(study.solution.device.value_of(name)) / end.sweep_value)
        for name, derivative in end.derivatives.items()
        if derivative
    ]
    return sorted(((name, x) for name, x in shifts if x), key=lambda shift: -abs(shift[1]))
