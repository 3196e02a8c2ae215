"""The families of motions of all impact sequences along the sweep, with the points where they meet."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from vireport.figures.captions import conditions
from vireport.figures.curves import Curve, joined
from vireport.figures.labels import Label
from vireport.figures.layout import Entry, SweepAxis, blank, finished, fit_vertically, sweep_axis
from vireport.figures.style import DASHED, TEXT, Color, Look, Picture, style
from vireport.sequences import Atlas, Family
from vireport.study import Study, Task

TITLE = "Motions of all impact sequences"

HEIGHT = 4.6
"""Of the panel with its axes [in]."""

COLORS = (
    *(Color.BLUE, Color.VERMILION, Color.GREEN, Color.PURPLE),
    *(Color.ORANGE, Color.SKY, Color.BLACK, Color.WARNING),
)
"""Of the words, the shortest first; other words are grey."""

OTHER = "other words"
STABLE: Look = {"linewidth": 1.8, "zorder": 2.6}
UNSTABLE: Look = {"linewidth": 0.8, "linestyle": DASHED, "zorder": 2.4}
VERTEX: Look = {"linestyle": "none", "marker": "o", "markersize": 2.6, "color": Color.BLACK, "zorder": 3.0}
SIMULATED: Look = {"linestyle": "none", "marker": "o", "markersize": 5.0, "color": Color.LIGHT, "zorder": 2.0}


def picture(study: Study, atlas: Atlas) -> Picture:
    """Velocities of all impacts of the families, stable and unstable, with their vertices; simulated ones beneath."""
    axis, colors = sweep_axis(atlas.sweep), _colors(atlas)
    simulated = list(_simulated(study, axis))
    with style():
        figure, ((axes,),) = blank(1)
        for family in atlas.families:
            _draw(axes, axis, family, colors.get(family.sequence.word, Color.GREY))
        if simulated:
            axes.add_artist(Line2D(*(np.concatenate(column) for column in zip(*simulated, strict=True)), **SIMULATED))
        labels = _vertices(axes, axis, atlas)
        axes.set_ylabel("impact velocity |Ż| [–]")
        fit_vertically([axes])
        axis.dress([axes])
        drawn = finished(
            figure, HEIGHT, [(conditions(study), Color.BLACK)], _legends(colors, atlas, simulated), [(axes, labels)]
        )
    held = f"{conditions(study)}."
    return Picture(Task.FIGURE_ATLAS, TITLE, f"{_caption(study, atlas)} {held}", _alt(atlas), drawn)


def _colors(atlas: Atlas) -> dict[str, str]:
    """Colours of the words that have one: those with stable motions first, then the shortest."""
    stable = {family.sequence.word for family in atlas.families if family.stable_runs}
    words = {family.sequence.word for family in atlas.families}
    return dict(zip(sorted(words, key=lambda word: (word not in stable, len(word), word)), COLORS, strict=False))


def _draw(axes: Axes, axis: SweepAxis, family: Family, color: str) -> None:
    """Draw every impact of a family, each stretch as stable or not."""
    x, speed = axis.of(family), np.abs(family.velocity)
    for first, last, kind in family.segments:
        rows = slice(first, last + 1)
        look = (STABLE if kind.attracts else UNSTABLE) | {"color": color}
        axes.add_artist(Line2D(*joined([(x[rows], y[rows]) for y in speed.T]), **look))
    axes.update_datalim(np.column_stack([np.tile(x, speed.shape[1]), speed.T.ravel()]))


def _vertices(axes: Axes, axis: SweepAxis, atlas: Atlas) -> list[Label]:
    """Mark the vertices, and return their labels, at the fastest impact if there is room."""
    labels = []
    for vertex in atlas.vertices:
        speed = np.sort(np.abs(vertex.point.motion.velocity))[::-1]
        at = np.full(len(speed), float(axis.of(vertex.point)))
        axes.add_artist(Line2D(at, speed, **VERTEX))
        labels.append(Label(vertex.label, at, speed, TEXT - 2))
    return labels


def _simulated(study: Study, axis: SweepAxis) -> Iterator[Curve]:
    """Impact velocities of the periodic motions found by simulation."""
    check = study.crosscheck
    for value, ends in zip(check.values, check.found, strict=True) if check is not None else ():
        for cycle in {id(end.cycle): end.cycle for end in ends if end.cycle is not None}.values():
            yield np.full(len(cycle.velocity), axis.of_value(float(value))), np.abs(cycle.velocity)


def _legends(colors: dict[str, str], atlas: Atlas, simulated: list[Curve]) -> list[list[Entry]]:
    words: list[Entry] = [(word, {"color": color, "linewidth": 1.8}) for word, color in colors.items()]
    if len({family.sequence.word for family in atlas.families}) > len(colors):
        words.append((OTHER, {"color": Color.GREY, "linewidth": 1.8}))
    grey = {"color": Color.GREY}
    notes: list[Entry] = [("stable", STABLE | grey), ("unstable", UNSTABLE | grey), ("families meet", VERTEX)]
    return [words, notes + ([("simulation", SIMULATED)] if simulated else [])]


def _caption(study: Study, atlas: Atlas) -> str:
    simulated = " Light discs: periodic motions that the simulation found." if study.crosscheck is not None else ""
    return (
        "Velocity |Ż| of every impact of the admissible motions, by the word of their impacts on the bottom (B) and on "
        f"the top (T). {_counts(atlas)} Letters: B, period doubling; C, fold or pitchfork; G, grazing, where an "
        f"impact without velocity comes or goes.{simulated}"
    )


def _alt(atlas: Atlas) -> str:
    return f"Line chart of impact velocities over the {atlas.sweep.parameter.quantity}. {_counts(atlas)}"


def _counts(atlas: Atlas) -> str:
    stable = sorted(
        {family.sequence.word for family in atlas.families if family.stable_runs}, key=lambda w: (len(w), w)
    )
    words = f"stable motions are {', '.join(stable)}" if stable else "none is stable"
    return f"{len(atlas.families)} families that meet at {len(atlas.vertices)} points; {words}."
