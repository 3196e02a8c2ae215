"""Draws the bifurcation diagram that comes from simulation alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from vireport.figures.axes import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION, WARNING, limits, style
from vireport.figures.captions import conditions
from vireport.figures.curves import Curve, Floats, Stretch, pairs
from vireport.figures.drawing import GUIDE, NO_MOTION, Drawing, Look
from vireport.figures.panel import Panel
from vireport.figures.sheet import Entry, sheet
from vireport.figures.traces import MOST_WORDS, Group, irregular, periodic_groups
from vireport.study import Study

if TYPE_CHECKING:
    from vireport.simulation import Diagram

WORDS: tuple[Look, ...] = tuple(
    {"color": color, "marker": marker, "markersize": size}
    for color, marker, size in (
        (BLUE, "o", 3.4), (VERMILION, "^", 3.8), (GREEN, "s", 3.0), (PURPLE, "v", 3.8),
        (ORANGE, "D", 2.8), (SKY, "P", 4.0), (BLACK, "X", 3.8), (WARNING, "*", 5.0),
    )
)  # fmt: skip
"""Looks of the words in the diagram, the most frequent first."""
OTHER: Look = {"color": GREY, "marker": "p", "markersize": 3.6}
POINTS: Look = {"linestyle": "none", "markeredgewidth": 0.5, "zorder": 3.0}
DOT: Look = {"linestyle": "none", "color": GREY, "marker": ".", "markersize": 1.6, "markeredgewidth": 0, "zorder": 2.8}
ANALYTIC: Look = {"color": BLACK, "linewidth": 0.8, "zorder": 2.4}


def figure_diagram(study: Study, diagram: Diagram, values: Floats, d: Floats) -> Figure:
    """Velocities of all impacts of the motions found by simulation, over the stable analytic branches.

    Parameters
    ----------
    study : Study
        With a sweep.
    diagram : Diagram
    values, d : ndarray
        Of the swept parameter and of d, to which the diagram's index refers.
    """
    with style():
        drawing = Drawing(study)
        words, other = periodic_groups(diagram, MOST_WORDS)
        looks = list(zip(words, WORDS[: len(words)], strict=True)) + ([(other, OTHER)] if other else [])
        loose = irregular(diagram)
        page = sheet(drawing.along, 1, 3.5, [(conditions(study), BLACK)], _diagram_legend(drawing, looks, loose))
        x, speed = (values if drawing.along.by_value else d)[diagram.index], np.abs(diagram.velocity)

        def curve(part: Stretch) -> list[Curve]:
            both = pairs(part.branch.motions, study.solution.device.period_ratio)[0]
            return [(drawing.x(part), y[part.rows]) for y in both]

        seen = [y for part in drawing.parts if part.stable for _, y in curve(part)]
        panel = page.panel("impact velocity |Ż| [–]", limits([speed, *seen]))
        drawing.curves(panel, curve, True, ANALYTIC)
        panel.marks(x[loose.points], speed[loose.points], **DOT)
        for group, look in looks[::-1]:
            for wall, face in ((diagram.wall > 0, look["color"]), (diagram.wall < 0, "none")):
                points = group.points & wall
                panel.marks(x[points], speed[points], markerfacecolor=face, **look | POINTS)
        _critical(drawing, panel)
        if not len(x) and not seen:
            panel.say(NO_MOTION)
        return page.figure


def _diagram_legend(drawing: Drawing, looks: Sequence[tuple[Group, Look]], loose: Group) -> list[list[Entry]]:
    entries: list[Entry] = [
        (group.name, look | POINTS | {"markersize": 1.4 * look["markersize"]}) for group, look in looks
    ]
    if loose.points.any():
        entries.append((loose.name, DOT | {"markersize": 4.0}))
    notes: list[Entry] = []
    if looks:
        ring = OTHER | POINTS | {"marker": "o", "markersize": 4.8}
        notes += [("bottom", ring), ("top", ring | {"markerfacecolor": "white"})]
    if any(part.stable for part in drawing.parts):
        notes.append(("stable 1:1 motion, analytic", ANALYTIC))
    return [entries, notes]


def _critical(drawing: Drawing, panel: Panel) -> None:
    """Show where the critical points are."""
    for event in drawing.events:
        branch, row = event.places[0]
        at = float(drawing.along.of(branch.motions)[row])
        panel.upright(np.array([at]), **GUIDE)
        panel.tag(event.point.label, at)
