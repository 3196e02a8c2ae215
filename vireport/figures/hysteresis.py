"""Figure of the impacts along a slow sweep, upwards and downwards, with the jumps between motions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vireport.figures.captions import conditions, held, measured_caption, pictured
from vireport.figures.curves import DrawnCurve, joined
from vireport.figures.diagram import one_to_one_curves
from vireport.figures.labels import Label
from vireport.figures.layout import (
    AXES_HEIGHT,
    Entry,
    SweepAxis,
    blank,
    finished,
    fit_vertically,
)
from vireport.figures.measured import draw_speeds
from vireport.figures.style import (
    Color,
    Look,
    Picture,
    sheet,
    style,
)
from vireport.figures.sweeps import Drawing, drawing_of
from vireport.scenario.blocks import Direction
from vireport.simulation.following import Course, Jump
from vireport.study.checks.hysteresis import Hysteresis
from vireport.study.plan import Task
from vireport.study.study import Study
from vireport.text.formatting import rounded_text

HEIGHT = 3.8
"""Height of the panel [in]."""

POINT: Look = {"linestyle": "none", "markeredgewidth": 0.6, "markersize": 3.6}
LOOKS: dict[Direction, Look] = {
    Direction.UP: POINT | {"color": Color.BLUE, "marker": ">", "zorder": 3.2},
    Direction.DOWN: POINT | {"color": Color.VERMILION, "marker": "<", "markerfacecolor": "none", "zorder": 3.0},
}
LOOSE: Look = {"marker": ".", "markersize": 1.6, "markeredgewidth": 0}
"""What is different of a motion that is not periodic."""
JUMP: Look = {"linewidth": 0.8, "linestyle": (0, (4, 2)), "markevery": [1], "clip_on": False, "zorder": 2.2}
STABLE: Look = {"color": Color.GREY, "linewidth": 0.7, "zorder": 2.0}
BAND: Look = {"color": Color.LIGHT, "alpha": 0.4, "linewidth": 0}
"""Behind a range in which the motion depends on the direction."""


def picture(study: Study, slowly: Hysteresis, templates: Path | None = None) -> Picture:
    """The figure with its words."""
    facts = {
        "held": held(study),
        "swept": study.solution.parameter,
        "jumps": sum(len(course.jumps) for course in slowly.courses.values()),
        "loops": slowly.loops,
        "measured": measured_caption(study),
    }
    return pictured(Task.FIGURE_HYSTERESIS, facts, figure_hysteresis(study, slowly), templates)


def figure_hysteresis(study: Study, slowly: Hysteresis) -> Figure:
    """Velocities of all impacts met on the way up and on the way down, over the stable motions that are known."""
    drawing, labels, names = drawing_of(study), [], {Direction.UP: "upwards", Direction.DOWN: "downwards"}
    stable_curves = _stable(drawing)
    with style():
        figure, ((axes,),) = blank(1)
        if stable_curves:
            axes.plot(*joined(stable_curves), **STABLE)
        for loop in slowly.loops:
            axes.axvspan(*(drawing.axis.of_value(end) for end in (loop.low, loop.high)), **BAND)
        for direction, course in slowly.courses.items():
            _draw(axes, drawing.axis, course, LOOKS[direction])
        entries = draw_speeds(axes, study.measured, drawing.axis.of_value)
        axes.set_ylabel("impact velocity |Ż| [–]")
        fit_vertically([axes])
        drawing.axis.dress([axes])
        for direction, course in slowly.courses.items():
            labels += [_jump(axes, drawing.axis, jump, LOOKS[direction]) for jump in course.jumps]
        ways: list[Entry] = [(names[way], LOOKS[way] | {"markersize": 4.8}) for way in slowly.courses]
        notes: list[Entry] = [("stable motion, analytic", STABLE)] if stable_curves else []
        heading, legends = [(conditions(study), Color.BLACK)], [[*ways, *notes, *entries]]
        return finished(figure, HEIGHT + AXES_HEIGHT, heading, legends, [(axes, labels)])


def _stable(drawing: Drawing) -> list[DrawnCurve]:
    """Impact velocities of the stable motions: of all families where these were followed, else of the 1:1 motions."""
    atlas = drawing.study.atlas
    if atlas is not None:
        return [
            (drawing.axis.of(family)[first : last + 1], speed[first : last + 1])
            for family in atlas.families
            for first, last in family.stable_runs
            for speed in np.abs(family.velocity).T
        ]
    return one_to_one_curves(drawing)


def _draw(axes: Axes, axis: SweepAxis, course: Course, look: Look) -> None:
    """Draw the impacts at each value; of motions that are not periodic as dots."""
    for periodic, marks in ((True, look), (False, look | LOOSE | {"markerfacecolor": look["color"]})):
        stages = [stage for stage in course.stages if (stage.attractor.cycle is not None) is periodic]
        x = [np.full(len(stage.impacts), axis.of_value(stage.value)) for stage in stages]
        speed = [np.abs(stage.impacts[:, 2]) for stage in stages]
        if stages:
            axes.plot(np.concatenate(x), np.concatenate(speed), **marks)


def _jump(axes: Axes, axis: SweepAxis, jump: Jump, look: Look) -> Label:
    """Show where a jump is, with the direction at the top, and return the value as its label."""
    at, (low, high) = axis.of_value(jump.value), axes.get_ylim()
    axes.plot([at, at], [low, high], **(JUMP | {"color": look["color"], "marker": look["marker"], "markersize": 4.0}))
    y = np.linspace(high, low, 24)[1:-1]
    return Label(rounded_text(jump.value, jump.off), np.full(len(y), at), y, sheet().text - 1.5, look["color"])
