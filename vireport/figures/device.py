"""The device as its scenario has it, and the path of the ball over one period at the design point, with their words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle
from matplotlib.transforms import Affine2D
from msgspec.structs import replace

from vireport.figures.captions import friction_of, harmonics_of, held, pictured, restitutions_of
from vireport.figures.curves import DrawnCurve
from vireport.figures.layout import (
    Entry,
    blank,
    columns_of,
    finished,
    fit_vertically,
    round_ticks,
)
from vireport.figures.portraits import (
    AT_WALL,
    BALL,
    BOTTOM_IMPACT,
    BOTTOM_MEMBRANE,
    TIME,
    TOP_IMPACT,
    TOP_MEMBRANE,
    periods,
)
from vireport.figures.style import (
    GUIDE,
    Color,
    Look,
    Picture,
    sheet,
    style,
)
from vireport.figures.ticks import set_ticks
from vireport.motions.atlas.portraits import portrait_of
from vireport.motions.one_to_one import ball_path
from vireport.motions.periodicity import model_of
from vireport.physics.numbers import ARRAYS
from vireport.scenario.parameters import Parameter
from vireport.study.plan import Task
from vireport.study.study import Study
from vireport.text.formatting import exact

HEIGHT, HIGHER = 2.9, 2.1
"""Height of the panels with their ticks and labels, and how much higher they are on the first page of a PDF [in]."""

WIDTH = 2.9
"""Width of the path of the ball, for the choice of ticks [in]."""

# Lengths in the sketch over that of the capsule, along it and across it.
HALF, ENDS, NAMES, BALL_AT, BALL_RADIUS = 0.11, 0.68, 1.2, 0.12, 0.055
DIMENSION, FORCE, RISE, HIGHEST = 0.21, 0.43, 0.08, 0.6
GROUND, RADIUS = 0.75, 0.4

WALL: Look = {"color": Color.BLACK, "linewidth": 1.4}
ARROW = {"arrowstyle": "<->", "color": Color.BLACK, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}


def picture(study: Study, templates: Path | None = None) -> Picture:
    """The figure with its words."""
    motion = drawn_motion(study)
    facts = {"dimensions": list(dict.fromkeys([*held(study), *_masses(study)])), "motion": "", "other": False}
    if motion is not None:
        words, other, (time, distance) = motion
        shares = dict.fromkeys(float(f"{at / time[-1]:.3g}") for at in time[distance > 1 - AT_WALL])
        facts |= {"motion": words, "other": other, "at_top": list(shares)}
    drawn = pictured(Task.FIGURE_DEVICE, facts, figure_device(study), templates)
    first = study.plan.runs(Task.PDF) and study.solution.sweep is None
    return replace(drawn, on_paper=HIGHER) if first else drawn


def figure_device(study: Study) -> Figure:
    """The sketch of the device, and beside it the path of the ball if there is a motion at the design point."""
    motion = drawn_motion(study)
    parts = 1 if motion is None else 2
    columns = columns_of(parts)
    rows = parts // columns
    with style():
        figure, panels = blank(rows, columns)
        _sketch(panels[0, 0], study)
        legend: list[Entry] = []
        if motion is not None:
            _path(panels[-1, -1], study, motion[2])
            legend = [("impact, bottom", BOTTOM_IMPACT), ("impact, top", TOP_IMPACT), ("ball", BALL)]
        return finished(figure, HEIGHT * rows, [(", ".join(_masses(study)), Color.BLACK)], [legend])


def drawn_motion(study: Study) -> tuple[str, bool, DrawnCurve] | None:
    """The motion at the design point that is shown: its type or word, whether it is no 1:1 motion, and its path.

    It is a stable 1:1 motion if there is one, else a stable motion with other impacts, else an unstable 1:1 motion.
    """
    design, atlas = study.solution.design, study.atlas
    if design is None:
        return None
    motions = design.motions
    stable = motions.admissible_mask & motions.stable_mask
    if atlas is not None and not stable.any() and (others := atlas.stable_at(design.value)):
        _, motion = others[0]
        portrait = portrait_of(model_of(atlas.sweep, ARRAYS), motion, "")
        word = motion.word.letters
        return word, True, (periods(portrait.time), 0.5 - portrait.position / portrait.d)
    row = motions.drawn_row
    if row is None:
        return None
    whole = ball_path(study.solution.device, design.parameter, motions, row)
    return motions.words[row], False, (whole.time, whole.distance)


def _masses(study: Study) -> list[str]:
    device, membrane = study.solution.device, study.solution.membrane
    ball = [f"m = {exact(membrane.ball_mass_kg, 3)} g"] if membrane is not None else []
    free = ["capsule free"] if device.recoils else []
    return [
        f"M = {exact(device.capsule_mass_kg)} kg",
        *ball,
        *free,
        *restitutions_of(device),
        *harmonics_of(device),
        *friction_of(device),
    ]


def _value(study: Study, parameter: Parameter) -> str:
    """An input with its value at the design point, or with its range where it is swept and has none."""
    value, sweep = getattr(study.solution.device, parameter), study.solution.sweep
    if value is not None:
        return parameter.place(value)
    if sweep is None:
        return parameter.symbol
    return f"{parameter.symbol} = {exact(sweep.start)} to {parameter.with_unit(exact(sweep.end))}"


def _sketch(axes: Axes, study: Study) -> None:
    """Draw the capsule at its angle; lengths are over that of the capsule, its centre is the origin."""
    device, sweep = study.solution.device, study.solution.sweep
    angle = device.inclination_deg
    if angle is None:
        angle = (float(sweep.start) + float(sweep.end)) / 2 if sweep is not None else 0.0
    turned: Any = Affine2D().rotate_deg(angle) + axes.transData
    text: Look = {"ha": "center", "va": "center", "size": sheet().small}

    def write(x: float, y: float, words: str, rotation: float, color: str = Color.BLACK) -> None:
        axes.text(x, y, words, transform=turned, rotation=rotation, rotation_mode="anchor", color=color, **text)

    def arrow(y: float, half: float) -> None:
        axes.annotate("", (-half, y), (half, y), xycoords=turned, textcoords=turned, arrowprops=ARROW)

    for y in (-HALF, HALF):
        axes.plot([-0.5, 0.5], [y, y], transform=turned, **WALL)
    for x, look, name in ((-0.5, BOTTOM_MEMBRANE, "bottom"), (0.5, TOP_MEMBRANE, "top")):
        axes.plot([x, x], [-HALF, HALF], transform=turned, **look)
        axes.plot([x, x], [HALF, DIMENSION], transform=turned, **GUIDE)
        write(x * NAMES, 0.0, name, angle - 90, look["color"])
    ball = BALL_AT, BALL_RADIUS - HALF
    axes.add_patch(Circle(ball, BALL_RADIUS, facecolor=Color.GREY, edgecolor=Color.BLACK, transform=turned))
    arrow(DIMENSION, 0.5)
    write(0.0, DIMENSION + RISE, _value(study, Parameter.LENGTH), angle)
    arrow(FORCE, 0.25)
    force = f"{_value(study, Parameter.AMPLITUDE)}, {_value(study, Parameter.FREQUENCY)}"
    write(0.0, FORCE + RISE, force, angle)
    left, foot = Affine2D().rotate_deg(angle).transform((-0.5, -HALF))
    if angle > 0:
        axes.plot([left, left + GROUND], [foot, foot], color=Color.GREY, linewidth=0.8)
        axes.add_patch(Arc((left, foot), 2 * RADIUS, 2 * RADIUS, theta1=0, theta2=angle, linewidth=0.8))
    axes.text(left + GROUND / 2, foot - RISE, _value(study, Parameter.INCLINATION), **text)
    corners = [(x, y) for x in (-ENDS, ENDS) for y in (-HALF, HIGHEST)]
    frame = np.vstack([Affine2D().rotate_deg(angle).transform(corners), (left + GROUND, foot - 2 * RISE)])
    axes.set_xlim(frame[:, 0].min(), frame[:, 0].max())
    axes.set_ylim(frame[:, 1].min(), frame[:, 1].max())
    axes.set_aspect("equal")
    axes.set_axis_off()


def _path(axes: Axes, study: Study, motion: DrawnCurve) -> None:
    """Draw the distance of the ball from the bottom membrane over one period."""
    length = float(study.solution.device.length_m)  # of a design point, which has all inputs
    time, distance = motion
    axes.axhline(0.0, **BOTTOM_MEMBRANE)
    axes.axhline(length, **TOP_MEMBRANE)
    axes.plot(time, length * distance, **BALL)
    for impacts, look in ((distance < AT_WALL, BOTTOM_IMPACT), (distance > 1 - AT_WALL, TOP_IMPACT)):
        axes.plot(time[impacts], length * distance[impacts], **look)
    axes.set_xlim(-0.03 * time[-1], 1.03 * time[-1])
    set_ticks(axes.xaxis, *round_ticks(0.0, float(time[-1]), WIDTH))
    axes.set_xlabel(TIME)
    axes.set_ylabel("ball from the bottom membrane [m]")
    fit_vertically([axes])
