"""The bifurcation diagram from simulation alone, with its caption."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vireport.figures.captions import conditions, held, pictured
from vireport.figures.curves import (
    DrawnCurve,
    Floats,
    impact_pairs,
    joined,
)
from vireport.figures.labels import Label
from vireport.figures.layout import (
    AXES_HEIGHT,
    Entry,
    blank,
    finished,
    fit_vertically,
    say,
)
from vireport.figures.portraits import short
from vireport.figures.style import (
    GUIDE,
    Color,
    Look,
    Picture,
    sheet,
    style,
)
from vireport.figures.sweeps import NO_MOTION, Drawing, drawing_of
from vireport.simulation.attractors import Outcome
from vireport.study.plan import Task
from vireport.study.study import Study

if TYPE_CHECKING:
    from vireport.simulation.attractors import Diagram

WITHOUT_IMPACTS = Outcome.REST, Outcome.HELD, Outcome.FREE
"""Ways to end of which a diagram shows nothing."""

HEIGHT = 3.5
"""Height of the panel [in]."""

MOST_WORDS = 8
"""Kinds of motion that the diagram tells apart."""

OTHER_WORDS, NOT_PERIODIC = "other", "not periodic"

POINTS: Look = {"linestyle": "none", "markeredgewidth": 0.5, "zorder": 3.0}
WORDS: tuple[Look, ...] = tuple(
    POINTS | {"color": color, "marker": marker, "markersize": size}
    for color, marker, size in (
        (Color.BLUE, "o", 3.4), (Color.VERMILION, "^", 3.8), (Color.GREEN, "s", 3.0), (Color.PURPLE, "v", 3.8),
        (Color.ORANGE, "D", 2.8), (Color.SKY, "P", 4.0), (Color.BLACK, "X", 3.8), (Color.WARNING, "*", 5.0),
    )
)  # fmt: skip
"""Looks of the words, the most frequent first."""
OTHER: Look = POINTS | {"color": Color.GREY, "marker": "p", "markersize": 3.6}
DOT: Look = POINTS | {
    "color": Color.GREY, "marker": ".", "markersize": 1.6, "markeredgewidth": 0, "markerfacecolor": Color.GREY,
}  # fmt: skip
ANALYTIC: Look = {"color": Color.BLACK, "linewidth": 0.8, "zorder": 2.4}


Group = tuple[str, NDArray[np.bool_]]
"""The name of a kind of motion, and which points of a diagram belong to it."""


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
    drawing, looks = drawing_of(study), _looks(diagram)
    analytic = one_to_one_curves(drawing)
    x, speed = (values if drawing.axis.by_value else d)[diagram.index], np.abs(diagram.velocity)
    with style():
        figure, ((axes,),) = blank(1)
        if analytic:
            axes.plot(*joined(analytic), **ANALYTIC)
        # The most frequent word last, so that it is drawn over the dots of motions that are not periodic.
        for (_, points), look in reversed(looks):
            for wall, face in ((diagram.wall > 0, look["color"]), (diagram.wall < 0, "none")):
                axes.plot(x[points & wall], speed[points & wall], **{"markerfacecolor": face} | look)
        if not len(x) and not analytic:
            say(axes, NO_MOTION)
        axes.set_ylabel("impact velocity |Ż| [–]")
        fit_vertically([axes])
        drawing.axis.dress([axes])
        labels = [(axes, _critical_points(axes, drawing))]
        legends = _legends(looks, bool(analytic))
        return finished(figure, HEIGHT + AXES_HEIGHT, [(conditions(study), Color.BLACK)], legends, labels)


def one_to_one_curves(drawing: Drawing) -> list[DrawnCurve]:
    """Impact velocities of the stable motions by the formulae."""
    ratio = drawing.study.solution.device.period_ratio
    return [
        (drawing.axis.of(part.branch.motions)[part.rows], y[part.rows])
        for part in drawing.parts
        if part.stable
        for y in impact_pairs(part.branch.motions, ratio)[0]
    ]


def _critical_points(axes: Axes, drawing: Drawing) -> list[Label]:
    """Show where the critical points are, and return their labels, to stand anywhere along that line."""
    low, high = axes.get_ylim()
    y = np.linspace(low, high, 24)[1:-1]
    labels = []
    for event in drawing.events:
        branch, row = event.places[0]
        at = float(drawing.axis.of(branch.motions)[row])
        axes.axvline(at, **GUIDE)
        label = event.point.label
        labels.append(Label(label, np.full(len(y), at), y, sheet().small, Color.GREY, link=f"#point-{label}"))
    return labels


def _legends(looks: Sequence[tuple[Group, Look]], analytic: bool) -> list[list[Entry]]:
    words: list[Entry] = [
        (name, look | {"markersize": max(1.4 * look["markersize"], 4.0)}) for (name, _), look in looks
    ]
    notes: list[Entry] = []
    if looks:
        ring = OTHER | {"marker": "o", "markersize": 4.8}
        notes += [("bottom", ring), ("top", ring | {"markerfacecolor": "white"})]
    if analytic:
        notes.append(("stable 1:1 motion, analytic", ANALYTIC))
    return [words, notes]


def _looks(diagram: Diagram) -> list[tuple[Group, Look]]:
    """The kinds of motion in a diagram, and how their points look."""
    words = iter(WORDS)
    special = {OTHER_WORDS: OTHER, NOT_PERIODIC: DOT}
    return [(group, special.get(group[0]) or next(words)) for group in groups(diagram)]


def groups(diagram: Diagram) -> list[Group]:
    """The words of a diagram, those found at most values first, the rest of them, and what is not periodic."""
    labels = list(enumerate(diagram.labels))
    words = [(short(name), diagram.label == k) for k, name in labels if not isinstance(name, Outcome)]
    words = sorted((word for word in words if word[1].any()), key=lambda word: (-len(_values(diagram, word)), word[0]))
    rest = np.logical_or.reduce([np.zeros(len(diagram.label), bool), *(points for _, points in words[MOST_WORDS:])])
    loose = np.isin(diagram.label, [k for k, name in labels if isinstance(name, Outcome)])
    others = [(OTHER_WORDS, rest), (NOT_PERIODIC, loose)]
    return words[:MOST_WORDS] + [group for group in others if group[1].any()]


def _values(diagram: Diagram, group: Group) -> NDArray[np.int64]:
    """Indices of the values of the swept parameter at which a kind of motion was found."""
    return np.unique(diagram.index[group[1]])


def picture(study: Study, diagram: Diagram, values: Floats, d: Floats, templates: Path | None = None) -> Picture:
    """The diagram with its words; a table has at how many values each motion was found."""
    ends = [(group[0], values[_values(diagram, group)]) for group in groups(diagram)] if len(diagram.index) else []
    facts = {
        "held": held(study),
        "swept": study.solution.parameter,
        "simulated": len(values),
        "groups": [
            {"word": word, "found": len(at), "low": float(at.min()), "high": float(at.max())} for word, at in ends
        ],
        "still": [label for label in diagram.labels if label in WITHOUT_IMPACTS],
    }
    return pictured(Task.FIGURE_DIAGRAM, facts, figure_diagram(study, diagram, values, d), templates)
