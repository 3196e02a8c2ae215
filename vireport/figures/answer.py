"""The figure of a report's first page: impact speeds over the sweep, where they are stable, and where that ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from msgspec.structs import replace

from vireport.figures.captions import pictured
from vireport.figures.curves import Floats, Stretch, stretches, swept_solution
from vireport.figures.layout import blank, finished, fit_vertically, round_ticks
from vireport.figures.style import Color, Look, Picture, sheet, style
from vireport.figures.sweeps import ALIKE, BOTTOM, EVENT_LINE, TOP, of_stability
from vireport.figures.ticks import set_ticks
from vireport.motions.one_to_one import impact_velocities
from vireport.motions.points import Point
from vireport.study.plan import Task
from vireport.study.study import Study
from vireport.text.formatting import percent

HEIGHT, HIGHER = 2.9, 2.8
"""Height of the panel with its ticks and labels, and how much higher it is on the first page of a PDF [in]."""

STABLE_AREA: Look = {"color": Color.FILL_C, "alpha": 0.35, "linewidth": 0, "zorder": 0.5}
DESIGN_LINE: Look = {"color": Color.BLACK, "linewidth": 1.1, "zorder": 2.0}
END_LINE: Look = EVENT_LINE | {"color": Color.GREY, "linewidth": 0.9, "linestyle": (0, (1, 1.5))}

SIDES = ("bottom", BOTTOM), ("top", TOP | {"linewidth": 2.0})

ALIKE_WITHIN = 1e-3
"""Relative difference of the speeds at both membranes up to which one curve stands for both."""

ROOM_AT = 0.12
"""Height of the arrow that shows the room of the design point, over that of the panel."""

BEHIND: dict[str, object] = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.8}
"""What stands under a text that may lie on a curve."""

ARROW_FROM = 0.04
"""Share of the panel's width from which the room is drawn: a shorter arrow would be its heads alone."""

NAMED_FROM = 0.12
"""Share of the panel's width from which the room is written over its arrow."""

MOST_ENDS = 4
"""Ends of stable motion that are named; with more, none would be read."""


def picture(study: Study, templates: Path | None = None) -> Picture | None:
    """The figure of impact speeds with its caption; None where no motion lies in the sweep."""
    drawn_stretches = stretches(study.solution)
    if not drawn_stretches:
        return None
    ends = _ends(study)
    words = {
        "swept": study.solution.parameter,
        "ranges": study.verdict.inequalities,
        "ends": [(point, place) for _, point, place in ends],
        "speeds": [_extent(study, side) for side in (0, 1)],
        "exactness": study.evidence.exactness,
    }
    first = pictured(Task.FIGURE_ANSWER, words, figure_answer(study), templates)
    return replace(first, on_paper=HIGHER) if study.plan.runs(Task.PDF) else first


def figure_answer(study: Study) -> Figure:
    """Draw the impact speeds at either membrane over the sweep, with lines labelled where they end."""
    solution, sweep = swept_solution(study)
    low, high = sorted((float(sweep.start), float(sweep.end)))
    swept = sweep.parameter
    with style():
        figure, panels = blank(1)
        axes: Axes = panels[0, 0]
        for stable in solution.settable_ranges:
            axes.axvspan(stable.start, stable.end, **STABLE_AREA)
        for part in stretches(solution):
            x, speeds = _speeds(study, part)
            alike = np.allclose(*speeds, rtol=ALIKE_WITHIN)
            for (_, look), y in zip(SIDES, speeds, strict=True):
                axes.plot(x, y, **of_stability(look | (ALIKE if alike else {}), part.stable))
        for x, speeds in _rightmost(study):
            _name(axes, x, speeds)
        axes.set_xlim(low, high)
        axes.set_xlabel(swept.label)
        axes.set_ylabel("impact speed [m/s]")
        fit_vertically([axes])
        axes.set_ylim(0.0, axes.get_ylim()[1])
        set_ticks(axes.xaxis, *round_ticks(low, high, sheet().across))
        for value, point, place in _ends(study)[:MOST_ENDS]:
            axes.axvline(value, **END_LINE)
            _write_at_line(axes, study, value, f"{point.label} {place}".strip(), of_design=False)
        _design(axes, study)
        return finished(figure, HEIGHT, [], [])


def _speeds(study: Study, part: Stretch) -> tuple[Floats, tuple[Floats, Floats]]:
    """Values of the swept parameter on a stretch, and the impact speeds at the bottom and at the top [m/s]."""
    solution, motions = study.solution, part.branch.motions.select(part.rows)
    bottom, top = impact_velocities(solution.device, solution.parameter, motions)
    return np.asarray(motions.sweep_value), (np.abs(bottom), np.abs(top))


def _rightmost(study: Study) -> list[tuple[Floats, tuple[Floats, Floats]]]:
    """The stretch whose curves are named: the last one of the branch that reaches farthest to the right, if stable."""
    parts = [(float(np.max(_speeds(study, part)[0])), part) for part in stretches(study.solution)]
    chosen = [(end, part) for end, part in parts if part.stable] or parts
    if not chosen:
        return []
    branch = max(chosen, key=lambda pair: pair[0])[1].branch
    last = max((pair for pair in parts if pair[1].branch is branch), key=lambda pair: pair[0])[1]
    return [_speeds(study, last)]


def _extent(study: Study, side: int) -> tuple[float, float]:
    """Least and largest speed of the stable motions at one membrane, or of all where none is stable [m/s]."""
    parts = stretches(study.solution)
    chosen = [part for part in parts if part.stable] or parts
    speeds = np.concatenate([_speeds(study, part)[1][side] for part in chosen])
    return float(speeds.min()), float(speeds.max())


def _ends(study: Study) -> list[tuple[float, Point, str]]:
    """Where stable motion ends in the sweep: the value, the critical point, and the value as text."""
    swept, verdict = study.solution.parameter, study.verdict
    return [(value, point, swept.show(value, verdict.exactness)) for value, point in verdict.ends_of_ranges]


def _name(axes: Axes, x: Floats, speeds: tuple[Floats, Floats]) -> None:
    """Name the two curves of a stretch where they end on the right."""
    k = int(np.argmax(x))
    alike = np.allclose(*speeds, rtol=ALIKE_WITHIN)
    named = [("bottom, top", ALIKE)] if alike else list(SIDES)
    for (name, look), y in zip(named, speeds, strict=False):
        axes.annotate(
            name, (x[k], y[k]), xytext=(5, 0), textcoords="offset points", va="center", color=look["color"],
            annotation_clip=False,
        )  # fmt: skip


def _write_at_line(axes: Axes, study: Study, value: float, text: str, of_design: bool) -> None:
    """Write a text beside the vertical line of the design point or of an end of stable motion, where there is room.

    That of an end stands outside stable motion and at the top, that of the design point inside and at the bottom: so
    they do not meet where the lines are close.
    """
    low, high = axes.get_xlim()
    share = (value - low) / (high - low)
    needed = (len(text) + 1) * sheet().letter / sheet().across
    stable_right = any(part.start <= value < part.end for part in study.solution.settable_ranges)
    left = stable_right != of_design
    if needed > (share if left else 1 - share):
        left = share > 1 - share
    axes.annotate(
        text,
        (value, 0.03 if of_design else 0.97),
        xycoords=axes.get_xaxis_transform(),
        xytext=(-4 if left else 4, 0),
        textcoords="offset points",
        ha="right" if left else "left",
        va="bottom" if of_design else "top",
        color=Color.BLACK if of_design else Color.GREY,
        bbox=BEHIND,
        zorder=4.5,
    )


def _design(axes: Axes, study: Study) -> None:
    """The design point as a line, and the room from it to the nearest end along the sweep."""
    design, swept = study.solution.design, study.solution.parameter
    low, high = axes.get_xlim()
    if design is None or not low <= design.value <= high:
        return
    axes.axvline(design.value, **DESIGN_LINE)
    _write_at_line(axes, study, design.value, f"design {swept.stated(design.value)}", of_design=True)
    around = [part for part in study.solution.settable_ranges if part.holds(design.value)]
    ends = [value for part in around for value, point in part.ends if point is not None]
    if not ends or not design.value:
        return
    nearest = min(ends, key=lambda value: abs(value - design.value))
    if abs(nearest - design.value) < ARROW_FROM * (high - low):
        return
    room = percent(abs(nearest / design.value - 1))
    transform = axes.get_xaxis_transform()
    arrow = {"arrowstyle": "<->", "color": Color.BLACK, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
    axes.annotate(
        "", (nearest, ROOM_AT), (design.value, ROOM_AT), xycoords=transform, textcoords=transform, arrowprops=arrow
    )
    if abs(nearest - design.value) > NAMED_FROM * (high - low):
        middle = (nearest + design.value) / 2
        axes.text(
            middle,
            ROOM_AT + 0.02,
            f"{room} of room",
            transform=transform,
            ha="center",
            va="bottom",
            size=sheet().small,
            bbox=BEHIND,
        )
