"""The families of motions of all impact sequences along the sweep: where they meet, and what they generate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from msgspec.structs import replace

from vireport.figures.captions import conditions, held, measured_caption, pictured, swept_range
from vireport.figures.curves import TURN, DrawnCurve, Floats, joined, settled_cycles
from vireport.figures.labels import Label
from vireport.figures.layout import (
    AXES_HEIGHT,
    Entry,
    SweepAxis,
    blank,
    finished,
    fit_vertically,
    letter_panels,
    prefix,
    sweep_axis,
)
from vireport.figures.measured import draw_speeds
from vireport.figures.style import (
    DASHED,
    Color,
    Look,
    Picture,
    sheet,
    style,
)
from vireport.figures.sweeps import CIRCLE, DESIGN_LINE, fit_angles
from vireport.motions.families import Atlas, Family
from vireport.motions.generation import generation, ladder
from vireport.motions.points import Point
from vireport.physics.energy import Membrane
from vireport.study.plan import AddedTask, Task
from vireport.study.study import Study
from vireport.text.formatting import PREFIXES

if TYPE_CHECKING:
    from vireport.simulation.cycles import SimulatedMotion

HEIGHT, RUNG_HEIGHT, IMPACTS_HEIGHT = 4.6, 2.0, 2.4
"""Heights of the atlas with its axes, and of a panel of the ladder and of figure 2 with its letter [in]."""

ON_TABLE = AddedTask("figure-table", Task.FIGURE_2.what)
"""Under this name figure 2 above a table has its words."""

WORD_COLORS = (
    *(Color.BLUE, Color.VERMILION, Color.GREEN, Color.PURPLE),
    *(Color.ORANGE, Color.SKY, Color.BLACK),
)
"""Colours of the words whose stable motions are seen, the shortest first, then again; others are grey with a marker."""

SHAPES = ("s", "^", "D", "v", "P", "X", "<", ">")
"""Markers on the curves of the words; their number differs from that of the colours, so that pairs differ longer."""

MOST_LOOKS = 14
"""Words that have a colour and a marker of their own, if their stable motions are seen."""

OTHER = "other words"
APART = 0.22
"""Share of the axis from one marker of a curve to the next."""

VISIBLE = 0.002
"""Share of the axis from which stable motions are seen: half the width of their curve."""

STABLE: Look = {"linewidth": 1.8, "zorder": 2.6}
UNSTABLE: Look = {"linewidth": 0.7, "linestyle": DASHED, "zorder": 2.4}
ON_STABLE: Look = {"linestyle": "none", "markersize": 5.0, "markeredgecolor": "white", "markeredgewidth": 0.5}
ON_UNSTABLE: Look = {
    "linestyle": "none",
    "markersize": 3.0,
    "markerfacecolor": "white",
    "markeredgewidth": 0.6,
}
VERTEX: Look = {"linestyle": "none", "marker": "o", "markersize": 2.6, "color": Color.BLACK, "zorder": 3.0}
MINOR: Look = {"markersize": 1.6, "zorder": 2.5}
SIMULATED: Look = {"linestyle": "none", "marker": "o", "markersize": 5.0, "color": Color.LIGHT, "zorder": 2.0}


def picture(study: Study, atlas: Atlas, templates: Path | None = None) -> Picture:
    """The figure with its words."""
    families = atlas.printed_families
    words = {family.word.letters for family in families if family.stable_runs}
    facts = {
        "held": held(study),
        "swept": atlas.sweep.parameter,
        "simulated": study.crosscheck is not None,
        "measured": measured_caption(study),
        "families": len(families),
        "found": len(atlas.families),
        "vertices": len(_drawn_vertices(atlas)),
        "stable": sorted(words, key=lambda word: (len(word), word)),
    }
    return pictured(Task.FIGURE_ATLAS, facts, figure_atlas(study, atlas), templates)


def _drawn_vertices(atlas: Atlas) -> list[Point]:
    """The vertices of the families that are shown."""
    numbers = {family.number for family in atlas.printed_families}
    return [vertex for vertex in atlas.vertices if not numbers.isdisjoint(vertex.families)]


def figure_atlas(study: Study, atlas: Atlas) -> Figure:
    """Velocities of all impacts of the families, stable and unstable, with their vertices; simulated ones beneath."""
    axis, families = sweep_axis(atlas.sweep), atlas.printed_families
    looks, simulated = _looks(axis, families), list(_simulated(study, axis))
    with style():
        figure, ((axes,),) = blank(1)
        for family in families:
            _draw(axes, axis, family, np.abs(family.velocity), looks)
        if simulated:
            axes.add_artist(Line2D(*(np.concatenate(column) for column in zip(*simulated, strict=True)), **SIMULATED))
        entries = draw_speeds(axes, study.measured, axis.of_value)
        labels = _vertices(axes, axis, families, _drawn_vertices(atlas))
        axes.set_ylabel("impact velocity |Ż| [–]")
        fit_vertically([axes])
        axis.dress([axes])
        notes: list[Entry] = [("families meet", VERTEX), *([("simulation", SIMULATED)] if simulated else []), *entries]
        legends = _legends(looks, families, notes)
        return finished(figure, HEIGHT, [(conditions(study), Color.BLACK)], legends, [(axes, labels)])


def impacts_picture(study: Study, atlas: Atlas, templates: Path | None = None) -> Picture:
    """Figure 2 above a table, where no motion is 1:1, with its words: of all families."""
    facts = {
        "held": held(study),
        "range": swept_range(study),
        "swept": atlas.sweep.parameter,
        "families": len(atlas.printed_families),
        "stable": [family for family in atlas.printed_families if family.settable],
        "simulated": len(_cycles(study)),
        "exactness": study.evidence.exactness,
    }
    return replace(pictured(ON_TABLE, facts, figure_impacts(study, atlas), templates), name=Task.FIGURE_2)


def figure_impacts(study: Study, atlas: Atlas) -> Figure:
    """Velocity and phase of all impacts of the families, stable and unstable, with their vertices.

    The periodic motions of a simulation are circles.
    """
    axis, families, design = sweep_axis(atlas.sweep), atlas.printed_families, study.solution.design
    looks, cycles = _looks(axis, families), _cycles(study)
    notes: list[Entry] = [("families meet", VERTEX)]
    with style():
        figure, panels = blank(2, sharex="col")
        speeds, phases = panels[:, 0]
        for family in families:
            for axes, values in ((speeds, np.abs(family.velocity)), (phases, _phases(family))):
                _draw(axes, axis, family, values, looks)
        for value, cycle in cycles:
            at = np.full(len(cycle.velocity), axis.of_value(value))
            for axes, y in ((speeds, np.abs(cycle.velocity)), (phases, cycle.phase % TURN)):
                axes.add_artist(Line2D(at, y, **CIRCLE))
        if cycles:
            notes.append(("simulated", CIRCLE))
        if design is not None and axis.low <= (at_design := axis.of_value(design.value)) <= axis.high:
            for axes in (speeds, phases):
                axes.axvline(at_design, **DESIGN_LINE)
            notes.append(("design point", DESIGN_LINE))
        labels = _vertices(speeds, axis, families, _drawn_vertices(atlas))
        for family in families:
            rows = list(family.critical_points)
            for y in _phases(family)[rows].T:
                phases.add_artist(Line2D(axis.of(family)[rows], y, **VERTEX | MINOR))
        speeds.set_ylabel("impact velocity |Ż| [–]")
        phases.set_ylabel("phase φ [rad]")
        fit_vertically([speeds])
        fit_angles(phases, 0.0)
        letter_panels(panels[:, 0], 0, axis.scales_on_top)
        axis.dress(panels[:, 0])
        head = [(conditions(study), Color.BLACK)]
        legends = _legends(looks, families, notes)
        height = 2 * IMPACTS_HEIGHT + AXES_HEIGHT
        return finished(figure, height, head, legends, [(speeds, labels)], panels[:, 0])


def _phases(family: Family) -> Floats:
    """Phase at each impact of each motion, (n, N) [rad], without jumps along the family; in its middle below a turn."""
    phases = np.pi * family.time
    middle = phases[len(phases) // 2]
    return np.asarray(phases - middle + middle % TURN)


def _cycles(study: Study) -> list[tuple[float, SimulatedMotion]]:
    """The motions without rest that the simulation came to, each with its value of the swept parameter."""
    return [(value, cycle) for value, _, cycle in settled_cycles(study) if not cycle.sticks]


def ladder_picture(study: Study, atlas: Atlas, membrane: Membrane, templates: Path | None = None) -> Picture:
    """The figure with its words."""
    facts = {
        "held": held(study),
        "swept": atlas.sweep.parameter,
        "best": next(iter(ladder(atlas.printed_families, membrane)), None),
        "families": len(atlas.printed_families),
        "found": len(atlas.families),
        "exactness": study.evidence.exactness,
    }
    return pictured(Task.FIGURE_LADDER, facts, figure_ladder(study, atlas, membrane), templates)


def figure_ladder(study: Study, atlas: Atlas, membrane: Membrane) -> Figure:
    """Mean voltage of the impacts, voltage per second and impacts per second of the families along the sweep."""
    axis, families = sweep_axis(atlas.sweep), atlas.printed_families
    looks, volts = _looks(axis, families), [generation(family, membrane) for family in families]
    power = prefix(voltage.average_v for voltage in volts)
    unit, scale = f"{PREFIXES[power]}V", 10.0**power
    rows = (
        (f"mean Uₐᵥₑ [{unit}]", [voltage.average_v / scale for voltage in volts]),
        (f"per second [{unit}/s]", [voltage.per_second_v / scale for voltage in volts]),
        ("impacts [1/s]", [voltage.impacts_per_s for voltage in volts]),
    )
    with style():
        figure, panels = blank(len(rows), sharex="col")
        for (label, values), axes in zip(rows, panels[:, 0], strict=True):
            for family, y in zip(families, values, strict=True):
                _draw(axes, axis, family, y[:, None], looks)
            axes.set_ylabel(label)
            fit_vertically([axes])
        letter_panels(panels[:, 0], 0, axis.scales_on_top)
        axis.dress(panels[:, 0])
        height = RUNG_HEIGHT * len(rows) + AXES_HEIGHT
        head = [(conditions(study), Color.BLACK)]
        return finished(figure, height, head, _legends(looks, families, []), aligned=panels[:, 0])


def _looks(axis: SweepAxis, families: Sequence[Family]) -> dict[str, Look]:
    """Colour and marker of the words, those whose stable motions are seen first, then the shortest."""
    stable = {family.word.letters for family in families if _seen(axis, family)}
    words = {family.word.letters for family in families}
    most = max(min(len(stable), MOST_LOOKS), len(SHAPES))  # so that no two grey ones have the same marker
    ordered = sorted(words, key=lambda word: (word not in stable, len(word), word))[:most]
    return {
        word: {
            "color": WORD_COLORS[k % len(WORD_COLORS)] if word in stable else Color.GREY,
            "marker": SHAPES[k % len(SHAPES)],
        }
        for k, word in enumerate(ordered)
    }


def _draw(axes: Axes, axis: SweepAxis, family: Family, values: Floats, looks: dict[str, Look]) -> None:
    """Draw quantities of a family, an array (n, curves), each stretch as stable or not and with its word's marker."""
    x, look = axis.of(family), looks.get(family.word.letters, {"color": Color.GREY})
    spans = {part: abs(x[part.last] - x[part.first]) for part in family.segments}
    for stable, of_line, of_marker in ((True, STABLE, ON_STABLE), (False, UNSTABLE, ON_UNSTABLE)):
        parts = [part for part in family.segments if part.stable == stable]
        longest = max(parts, key=lambda part: spans[part], default=None)
        for part in parts:
            rows = slice(part.first, part.last + 1)
            curves = [(x[rows], y[rows]) for y in values.T]
            axes.add_artist(Line2D(*joined(curves), **of_line, color=look["color"]))
            # A word that is seen at all has a marker somewhere, on its longest stretch if all are short.
            count = max(round(spans[part] / (axis.high - axis.low) / APART), int(part == longest))
            if "marker" in look and count:
                on = {"zorder": of_line["zorder"] + 0.1}
                axes.add_artist(Line2D(*joined([_spaced(curve, count) for curve in curves]), **look | of_marker | on))
    axes.update_datalim(np.column_stack([np.tile(x, values.shape[1]), values.T.ravel()]))


def _spaced(curve: DrawnCurve, count: int) -> DrawnCurve:
    """Points on a curve between two events, where it does not turn back, at even distances along the axis."""
    x, y = (part if curve[0][-1] > curve[0][0] else part[::-1] for part in curve)
    at = x[0] + (np.arange(count) + 0.5) / count * (x[-1] - x[0])
    return at, np.interp(at, x, y)


def _seen(axis: SweepAxis, family: Family) -> list[tuple[int, int]]:
    """The stable runs of a family that are wide enough to be seen."""
    x = axis.of(family)
    least = VISIBLE * (axis.high - axis.low)
    return [run for run in family.stable_runs if np.ptp(x[run[0] : run[1] + 1]) >= least]


def _vertices(axes: Axes, axis: SweepAxis, families: Sequence[Family], vertices: Sequence[Point]) -> list[Label]:
    """Mark the vertices, and return the labels of those on stable motions that are seen."""
    marked = ((mark, run) for family in families for run in _seen(axis, family) for mark in family.marks)
    lettered = {mark.point.label for mark, (first, last) in marked if mark.point and first <= mark.row <= last}
    labels = []
    for vertex in vertices:
        speed = np.sort(np.abs(vertex.motion.velocity))[::-1]
        at = np.full(len(speed), float(axis.of(vertex)))
        on_stable = vertex.label in lettered
        axes.add_artist(Line2D(at, speed, **VERTEX | ({} if on_stable else MINOR)))
        if on_stable:
            labels.append(Label(vertex.label, at, speed, sheet().text - 1))
    return labels


def _simulated(study: Study, axis: SweepAxis) -> Iterator[DrawnCurve]:
    """Impact velocities of the periodic motions found by simulation."""
    check = study.crosscheck
    for value, ends in zip(check.values, check.ends, strict=True) if check is not None else ():
        for cycle in {id(end.cycle): end.cycle for end in ends if end.cycle is not None}.values():
            yield np.full(len(cycle.velocity), axis.of_value(float(value))), np.abs(cycle.velocity)


def _legends(looks: dict[str, Look], families: Sequence[Family], notes: list[Entry]) -> list[list[Entry]]:
    words: list[Entry] = [
        (word, ON_STABLE | look | {"linestyle": "-", "linewidth": 1.8}) for word, look in looks.items()
    ]
    if len({family.word.letters for family in families}) > len(looks):
        words.append((OTHER, UNSTABLE | {"color": Color.GREY, "linestyle": "-"}))
    grey = {"color": Color.GREY}
    return [words, [("stable", STABLE | grey), ("unstable", UNSTABLE | grey), *notes]]
