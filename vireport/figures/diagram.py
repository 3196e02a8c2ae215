"""The bifurcation diagram that comes from simulation alone, with its words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vireport.figures.captions import conditions
from vireport.figures.curves import Curve, Floats, impact_pairs, joined
from vireport.figures.labels import Label
from vireport.figures.layout import Entry, blank, finished, fit_vertically, say
from vireport.figures.portraits import short
from vireport.figures.style import GUIDE, TEXT, Color, Look, style
from vireport.figures.sweeps import AXES_HEIGHT, NO_MOTION, Drawing, drawing_of
from vireport.study import Study
from vireport.text import significant

if TYPE_CHECKING:
    from vireport.simulation import Diagram

TITLE = "Bifurcation diagram by simulation"

HEIGHT = 3.5
"""Of the panel [in]."""

MOST_WORDS = 8
"""Kinds of motion that the diagram tells apart."""

WORDS: tuple[Look, ...] = tuple(
    {"color": color, "marker": marker, "markersize": size}
    for color, marker, size in (
        (Color.BLUE, "o", 3.4), (Color.VERMILION, "^", 3.8), (Color.GREEN, "s", 3.0), (Color.PURPLE, "v", 3.8),
        (Color.ORANGE, "D", 2.8), (Color.SKY, "P", 4.0), (Color.BLACK, "X", 3.8), (Color.WARNING, "*", 5.0),
    )
)  # fmt: skip
"""Looks of the words, the most frequent first."""
OTHER: Look = {"color": Color.GREY, "marker": "p", "markersize": 3.6}
POINTS: Look = {"linestyle": "none", "markeredgewidth": 0.5, "zorder": 3.0}
DOT: Look = {
    "linestyle": "none",
    "color": Color.GREY,
    "marker": ".",
    "markersize": 1.6,
    "markeredgewidth": 0,
    "zorder": 2.8,
}
ANALYTIC: Look = {"color": Color.BLACK, "linewidth": 0.8, "zorder": 2.4}


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Points of a diagram that belong to one kind of motion.

    Attributes
    ----------
    name : str
    points : ndarray of bool
        Which of the diagram's.
    values : ndarray of int
        Values of the swept parameter at which it was found.
    """

    name: str
    points: NDArray[np.bool_]
    values: NDArray[np.int64]


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
    drawing = drawing_of(study)
    words, other = periodic_groups(diagram, MOST_WORDS)
    looks = list(zip(words, WORDS, strict=False)) + ([(other, OTHER)] if other else [])
    loose = irregular(diagram)
    analytic = _analytic(drawing)
    with style():
        figure, ((axes,),) = blank(1)
        if analytic:
            axes.plot(*joined(analytic), **ANALYTIC)
        x, speed = (values if drawing.axis.by_value else d)[diagram.index], np.abs(diagram.velocity)
        axes.plot(x[loose.points], speed[loose.points], **DOT)
        for group, look in looks[::-1]:
            for wall, face in ((diagram.wall > 0, look["color"]), (diagram.wall < 0, "none")):
                points = group.points & wall
                axes.plot(x[points], speed[points], markerfacecolor=face, **look | POINTS)
        if not len(x) and not analytic:
            say(axes, NO_MOTION)
        axes.set_ylabel("impact velocity |Ż| [–]")
        fit_vertically([axes])
        drawing.axis.dress([axes])
        legends = _legends(looks, loose, bool(analytic))
        labels = [(axes, _critical_points(axes, drawing))]
        return finished(figure, HEIGHT + AXES_HEIGHT, [(conditions(study), Color.BLACK)], legends, labels)


def _analytic(drawing: Drawing) -> list[Curve]:
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
        labels.append(Label(event.point.label, np.full(len(y), at), y, TEXT - 1.5, Color.GREY))
    return labels


def _legends(looks: list[tuple[Group, Look]], loose: Group, analytic: bool) -> list[list[Entry]]:
    words: list[Entry] = [
        (group.name, look | POINTS | {"markersize": 1.4 * look["markersize"]}) for group, look in looks
    ]
    if loose.points.any():
        words.append((loose.name, DOT | {"markersize": 4.0}))
    notes: list[Entry] = []
    if looks:
        ring = OTHER | POINTS | {"marker": "o", "markersize": 4.8}
        notes += [("bottom", ring), ("top", ring | {"markerfacecolor": "white"})]
    if analytic:
        notes.append(("stable 1:1 motion, analytic", ANALYTIC))
    return [words, notes]


def periodic_groups(diagram: Diagram, most: int) -> tuple[list[Group], Group | None]:
    """The words of a diagram, those found at most values first, and what is left over beyond `most`."""
    words = [_group(diagram, short(name), [k]) for k, name in enumerate(diagram.labels) if is_word(name)]
    words = sorted((group for group in words if len(group.values)), key=lambda group: (-len(group.values), group.name))
    if len(words) <= most:
        return words, None
    points = np.logical_or.reduce([group.points for group in words[most:]])
    return words[:most], Group("other", points, np.unique(diagram.index[points]))


def irregular(diagram: Diagram) -> Group:
    """The points of motions that are not periodic."""
    return _group(diagram, "not periodic", [k for k, name in enumerate(diagram.labels) if not is_word(name)])


def is_word(label: str) -> bool:
    """Whether a label of a diagram is a word of impacts."""
    return bool(label) and set(label) <= set("BT~")


def _group(diagram: Diagram, name: str, labels: Iterable[int]) -> Group:
    points = np.isin(diagram.label, list(labels))
    return Group(name, points, np.unique(diagram.index[points]))


def diagram_caption(study: Study, diagram: Diagram, values: Floats) -> str:
    """The caption of the diagram: what is drawn, and at how many values each motion was found."""
    about = (
        "Velocity |Ż| of every impact of the motions that the simulation ends on, by the word of the motion: B and T "
        "are the impacts of a period on the bottom and on the top, ~ chatter that ends in sticking. Filled: bottom; "
        "open: top. Thin lines: the stable 1:1 motion by the formulae."
    )
    level = ["Where both impacts are equally fast, filled markers cover open ones."]
    return " ".join(
        [about, *(level if study.solution.horizontal else []), f"{conditions(study)}.", *_found(study, diagram, values)]
    )


def diagram_alt(study: Study, diagram: Diagram, values: Floats) -> str:
    """A description of the diagram for those who do not see it."""
    swept = study.solution.sweep.parameter.quantity if study.solution.sweep else "swept parameter"
    return " ".join(
        [f"Scatter chart of impact velocities over the {swept}, by simulation.", *_found(study, diagram, values)]
    )


def _found(study: Study, diagram: Diagram, values: Floats) -> Iterator[str]:
    """At how many values each motion was found, and where."""
    words, other = periodic_groups(diagram, MOST_WORDS)
    groups = [group for group in (*words, *([other] if other else []), irregular(diagram)) if len(group.values)]
    if not groups:
        yield "No motion was found that has impacts."
        return
    where = "; ".join(_where(study, group, values) for group in groups)
    yield f"Motions at {len(values)} value{'s' * (len(values) != 1)}: {where}."
    others = [label for label in diagram.labels if not is_word(label) and "periodic" not in label]
    if others:
        yield f"From some starts the ball ends {', or '.join(others)}, which has no impacts."


def _where(study: Study, group: Group, values: Floats) -> str:
    swept = study.solution.parameter
    low, high = (significant(float(end), 4) for end in (values[group.values].min(), values[group.values].max()))
    span = swept.with_unit(high) if low == high else f"{low} to {swept.with_unit(high)}"
    return f"{group.name} at {len(group.values)} ({swept.symbol} = {span})"
