"""Figures 2, 4 and 7: what a study finds along its sweep, for one scenario or for several beside one another.

Only motions are drawn: what is not admissible is neither a line nor a point here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain, cycle
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vireport.analysis import Branch, CriticalKind, DesignPoint, eigenvalues
from vireport.figures import curves
from vireport.figures.captions import LAMBDA_LIMIT, OUTSIDE, conditions
from vireport.figures.curves import TURN, Curve, Event, Floats, Simulated, Stretch
from vireport.figures.labels import Label
from vireport.figures.layout import (
    ACROSS,
    LETTER,
    Entry,
    SweepAxis,
    blank,
    finished,
    fit_vertically,
    letter_panels,
    prefix,
    say,
    sweep_axis,
)
from vireport.figures.style import DASH_DOTTED, DASHED, DOTTED, GUIDE, Color, Look, style
from vireport.physics import Voltages
from vireport.study import Study, Task
from vireport.text import PREFIXES, capital

# Width tells the two impacts apart where colour does not, and where one curve lies on the other.
BOTTOM: Look = {"color": Color.BLUE, "linewidth": 2.8}
TOP: Look = {"color": Color.GREEN, "linewidth": 1.2}
STABLE: Look = {"linestyle": "-", "zorder": 2.5}
UNSTABLE: Look = {"linestyle": DASH_DOTTED, "zorder": 2.2}

AVERAGE: Look = {"color": Color.VERMILION, "linewidth": 3.8, "linestyle": "-"}
BOTTOM_VOLTAGE: Look = {"color": Color.BLUE, "linewidth": 1.3, "linestyle": "-"}
TOP_VOLTAGE: Look = {"color": Color.BLUE, "linewidth": 1.3, "linestyle": DASHED}
UNSTABLE_VOLTAGE: Look = {"linestyle": DOTTED, "zorder": 2.2}
UNSTABLE_TOP_VOLTAGE: Look = {"linestyle": (0, (1, 3.2)), "zorder": 2.2}

BOUND: Look = {"color": Color.VERMILION, "linewidth": 0.8, "linestyle": (0, (8, 2, 1, 2)), "zorder": 1.5}
DESIGN_LINE: Look = {"color": Color.GREY, "linewidth": 0.9, "linestyle": (0, (2, 2)), "zorder": 1.4}
MARK: Look = {"linestyle": "none", "color": Color.BLACK, "markersize": 5.0, "markeredgewidth": 0.5, "zorder": 4.0}
DESIGN: Look = MARK | {"marker": "P", "markersize": 8.5, "zorder": 3.8}
"""Larger than the markers of critical points, and under them."""
POINT: Look = MARK | {"markeredgecolor": "white"}
MARKERS: dict[CriticalKind, Look] = {
    CriticalKind.NODE_FOCUS: {"marker": "o"},
    CriticalKind.PERIOD_DOUBLING: {"marker": "s"},
    CriticalKind.FOLD: {"marker": "d", "markersize": 6.5},
    CriticalKind.PITCHFORK: {"marker": "D"},
    CriticalKind.GRAZING: {"marker": "^", "markersize": 6.0},
}
CIRCLE: Look = MARK | {
    "marker": "o", "markersize": 4.5, "markerfacecolor": "none", "markeredgewidth": 0.8, "zorder": 3.5,
}  # fmt: skip
STAR: Look = CIRCLE | {"marker": "*", "markersize": 8.5, "markerfacecolor": "white", "color": Color.WARNING}

FULL_SIZE_UP_TO = 60
"""Simulated values along a sweep up to which their markers have their full size."""

BRANCH_COLORS = (Color.BLUE, Color.PURPLE, Color.BLACK, Color.SKY, Color.GREEN, Color.ORANGE)
"""The first three are also apart in grey."""

THIN, THICK = 1.5, 3.4
"""Widths of curves in figure 4 [pt]; thick where the eigenvalues are complex."""

NO_MOTION = "no admissible 1:1 motion in this sweep"

HEIGHTS = {Task.FIGURE_2: 2.02, Task.FIGURE_4: 2.45, Task.FIGURE_7: 3.25}
"""Of the panels with the letter over them [in]."""

AXES_HEIGHT = 0.95
"""Of the ticks and labels along the top and the bottom [in]."""

BOLD = 1.05
"""Width of bold letters over that of others."""

EVERYTHING = (-np.inf, np.inf)


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """A study with what is drawn of it along its sweep; `branches` names those of figure 4, by their number."""

    study: Study
    axis: SweepAxis
    parts: list[Stretch]
    events: list[Event]
    simulated: Simulated | None
    branches: dict[int, str]

    @property
    def design_at(self) -> float | None:
        """Where the design point stands along the sweep; None where there is none within it."""
        design = self.study.solution.design
        at = self.axis.of_value(design.value) if design is not None else np.nan
        return at if self.parts and self.axis.low <= at <= self.axis.high else None


def drawing_of(study: Study, simulated: Simulated | None = None) -> Drawing:
    """Prepare a study for its figures; a ValueError says that it has no sweep."""
    solution, sweep = curves.swept_solution(study)
    parts = curves.stretches(solution)
    branches = {
        branch.number: f"branch {branch.number}, {branch.family}"
        for branch in solution.branches
        if branch.mirror_of is None and any(part.branch is branch for part in parts)
    }
    return Drawing(study, sweep_axis(sweep), parts, curves.events(solution), simulated, branches)


def figure_2(study: Study, simulated: Simulated | None = None) -> Figure:
    """Impact velocity, phase and half the flight time along the sweep, as in Fig. 2; with simulated motions, if any."""
    return sweep_figure(Task.FIGURE_2, [drawing_of(study, simulated)])


def figure_4(study: Study) -> Figure:
    """The discriminant, and the eigenvalues or their real parts, along the sweep, as in Fig. 4."""
    return sweep_figure(Task.FIGURE_4, [drawing_of(study)])


def figure_7(study: Study, simulated: Simulated | None = None) -> Figure:
    """The voltages at the impacts and their average along the sweep, as in Fig. 7; with simulated ones, if any."""
    return sweep_figure(Task.FIGURE_7, [drawing_of(study, simulated)])


def sweep_figure(
    figure: Task,
    drawings: Sequence[Drawing],
    titles: Sequence[str] = (),
    remarks: Sequence[str] = (),
    lines: Sequence[tuple[str, str]] | None = None,
) -> Figure:
    """Draw figure 2, 4 or 7 of one study, or of several as columns whose rows share their vertical axes.

    Parameters
    ----------
    figure : Task
        Figure 2, 4 or 7.
    drawings : sequence of Drawing
    titles, remarks : sequence of str
        Over each column, the remark under the title.
    lines : sequence of (str, str), optional
        Texts over all of them, with their colours; by default what the one study holds along its sweep.
    """
    if figure == Task.FIGURE_4:
        drawings = [replace(x, parts=[part for part in x.parts if not part.branch.mirror_of]) for x in drawings]
    with style():
        rows, legends = {Task.FIGURE_2: _rows_2, Task.FIGURE_4: _rows_4, Task.FIGURE_7: _rows_7}[figure](drawings)
        page, panels = blank(len(rows), len(drawings), sharex="col", sharey="row")
        labels = [
            (axes, _draw(axes, row, drawing))
            for row, axes_of_row in zip(rows, panels, strict=True)
            for axes, drawing in zip(axes_of_row, drawings, strict=True)
        ]
        for row, axes_of_row in zip(rows, panels, strict=True):
            axes_of_row[0].set_ylabel(row.label)
            if not row.phases:
                fit_vertically(axes_of_row)
        letters = int(ACROSS / len(drawings) / LETTER)
        for k, drawing in enumerate(drawings):
            if titles:
                panels[0, k].set_title(fill(titles[k], int(letters / BOLD)), weight="bold")
            if panels.size > 1:
                letter_panels(panels[:, k], k * len(rows))
            drawing.axis.dress(panels[:, k], len(drawings), fill(remarks[k], letters) if remarks else "")
        page.align_ylabels(panels[:, 0])
        height = HEIGHTS[figure] * len(rows) + AXES_HEIGHT
        head = _head(figure, drawings[0].study) if lines is None else lines
        return finished(page, height, head, [*legends, _point_legend(drawings)], labels)


def _head(figure: Task, study: Study) -> list[tuple[str, str]]:
    note = figure == Task.FIGURE_7 and not study.solution.within_membrane
    return [(conditions(study), Color.BLACK)] + ([(capital(OUTSIDE), Color.WARNING)] if note else [])


@dataclass(frozen=True, slots=True)
class _Row:
    """One quantity along the sweep.

    Attributes
    ----------
    label : str
        Word, symbol and unit.
    values : callable
        Of the motions of a branch or of the design point: an array for each of its curves.
    look : callable
        Of a curve on a stretch.
    design : tuple of str
        Colours of the design point's markers, one for each curve.
    simulated : callable
        The points of a simulation, and how they look.
    limits : tuple of float
        Range beyond which nothing needs to be seen.
    bounds : tuple of float
        Values at which a line is drawn across.
    phases : bool
        Whether the axis is that of an angle.
    """

    label: str
    values: Callable[[Drawing, Branch | DesignPoint], Sequence[Floats]]
    look: Callable[[Drawing, Stretch, int], Look]
    design: tuple[str, ...]
    simulated: Callable[[Simulated], Iterable[tuple[Floats, Look]]] = lambda simulated: ()
    limits: tuple[float, float] = EVERYTHING
    bounds: tuple[float, ...] = ()
    phases: bool = False


def _draw(axes: Axes, row: _Row, drawing: Drawing) -> list[Label]:
    """Draw a row of a study, and return the labels of its critical points."""
    for bound in row.bounds:
        axes.axhline(bound, **BOUND)
    if row.phases:
        axes.set_ylim(-0.03 * TURN, 1.03 * TURN)
        axes.set_yticks(np.arange(5) * TURN / 4, ["0", "π/2", "π", "3π/2", "2π"])
    if not drawing.parts:
        say(axes, NO_MOTION)
    _draw_curves(axes, row, drawing)
    if drawing.simulated:
        scale = _marker_scale(drawing.simulated)
        for y, look in row.simulated(drawing.simulated):
            smaller = {key: look[key] * scale for key in ("markersize", "markeredgewidth")}
            _plot(axes, [(drawing.axis.of(drawing.simulated), y)], look | smaller)
    _mark_design(axes, row, drawing)
    return _mark_critical_points(axes, row, drawing)


def _draw_curves(axes: Axes, row: _Row, drawing: Drawing) -> None:
    """Draw the curves of all stretches, those of one look as one line."""
    by_look: dict[tuple[object, ...], tuple[list[Curve], Look]] = {}
    for part in drawing.parts:
        x = drawing.axis.of(part.branch.motions)[part.rows]
        for k, values in enumerate(row.values(drawing, part.branch)):
            y, look = values[part.rows], row.look(drawing, part, k)
            pieces = curves.phase_curve(x, y) if row.phases else [(x, y)]
            by_look.setdefault(tuple(look.items()), ([], look))[0].extend(pieces)
    for pieces, look in by_look.values():
        _plot(axes, pieces, look, row.limits)


def _plot(axes: Axes, parts: Sequence[Curve], look: Look, limits: tuple[float, float] = EVERYTHING) -> None:
    """Draw curves as one line, broken between them; the axis has to hold only what of them is within the limits."""
    axes.add_artist(Line2D(*curves.joined(parts), **look))
    low, high = limits
    for x, y in parts:
        if ((y >= low) & (y <= high)).any():
            axes.update_datalim(np.column_stack([x, np.clip(y, low, high)]))


def _marker_scale(simulated: Simulated) -> float:
    """Size of simulated points, smaller where they are many so that the curve beneath is seen."""
    count = max(len(np.unique(simulated.sweep_value)), 1)
    return float(np.clip((FULL_SIZE_UP_TO / count) ** 0.5, 0.4, 1.0))


def _mark_design(axes: Axes, row: _Row, drawing: Drawing) -> None:
    """Mark the design point and the values of its motions; open where they are unstable."""
    design, at = drawing.study.solution.design, drawing.design_at
    if design is None or at is None:
        return
    axes.axvline(at, **DESIGN_LINE)
    motions = design.motions
    for values, color in zip(row.values(drawing, design), row.design, strict=True):
        for chosen, face in ((motions.admissible & ~motions.stable, "white"), (motions.stable, color)):
            points = np.full(int(chosen.sum()), at), values[chosen]
            _plot(axes, [points], DESIGN | {"markerfacecolor": face}, row.limits)


def _mark_critical_points(axes: Axes, row: _Row, drawing: Drawing) -> list[Label]:
    """Mark the critical points on all curves of a panel; each gets one label, at the largest value if there is room."""
    labels: list[Label] = []
    by_kind: dict[CriticalKind, list[Curve]] = {}
    for event in drawing.events:
        values = np.array([[y[i] for y in row.values(drawing, branch)] for branch, i in event.places])
        places = np.array([drawing.axis.of(branch.motions)[i] for branch, i in event.places])
        x, y = np.repeat(places, values.shape[1]), values.ravel()
        by_kind.setdefault(event.point.kind, []).append((x, y))
        largest_first = np.argsort(-np.abs(y), kind="stable")
        labels.append(Label(event.point.label, x[largest_first], y[largest_first]))
    guides = [(np.full(2, at), np.array([0.0, 1.0])) for at in sorted({float(x) for label in labels for x in label.x})]
    if guides:
        axes.add_artist(Line2D(*curves.joined(guides), transform=axes.get_xaxis_transform(), **GUIDE))
    for kind, points in by_kind.items():
        _plot(axes, points, POINT | MARKERS[kind], row.limits)
    return labels


Rows = tuple[list[_Row], list[list[Entry]]]
"""The rows of a figure from the top one down, and its legends, each of which begins a line."""


def _rows_2(drawings: Sequence[Drawing]) -> Rows:
    def row(k: int, label: str, phases: bool) -> _Row:
        return _Row(
            label,
            lambda x, branch: curves.impact_pairs(branch.motions, x.study.solution.device.period_ratio)[k],
            lambda x, part, side: (BOTTOM, TOP)[side] | (STABLE if part.stable else UNSTABLE),
            (Color.BLUE, Color.GREEN),
            lambda simulated: ((y, CIRCLE) for y in simulated.pairs[k]),
            phases=phases,
        )

    legend: list[Entry] = [("impact k−1, bottom", BOTTOM), ("impact k, top", TOP), *_stability_legend(drawings)]
    if any(drawing.simulated for drawing in drawings):
        legend.append(("simulation", CIRCLE))
    rows = [
        row(0, "impact velocity |Ż| [–]", phases=False),
        row(1, "phase φ [rad]", phases=True),
        row(2, "flight time Δt/2 [periods]", phases=False),
    ]
    return rows, [legend]


def _rows_4(drawings: Sequence[Drawing]) -> Rows:
    names = dict.fromkeys(chain.from_iterable(drawing.branches.values() for drawing in drawings))
    colors = dict(zip(names, cycle(BRANCH_COLORS), strict=False))
    highest = max((LAMBDA_LIMIT - x.study.solution.device.restitution**4 / LAMBDA_LIMIT) ** 2 for x in drawings)

    def look(drawing: Drawing, part: Stretch, width: float) -> Look:
        color = colors[drawing.branches[part.branch.number]]
        return {"color": color, "linewidth": width, **(STABLE if part.stable else UNSTABLE)}

    discriminant = _Row(
        "discriminant Δ [–]",
        lambda x, branch: [branch.motions.discriminant],
        lambda x, part, k: look(x, part, THIN),
        (Color.GREY,),
        limits=(-np.inf, highest),
        bounds=(0.0,),
    )
    eigenvalue = _Row(
        "eigenvalues λ₁, λ₂ or Re λ [–]",
        lambda x, branch: eigenvalues(branch.motions.trace, branch.motions.restitution),
        lambda x, part, k: look(x, part, THICK if part.focus else THIN),
        (Color.GREY, Color.GREY),
        limits=(-LAMBDA_LIMIT, LAMBDA_LIMIT),
        bounds=(-1.0, 0.0, 1.0),
    )
    branches: list[Entry] = [(name, {"color": color, "linewidth": THIN}) for name, color in colors.items()]
    legend = _stability_legend(drawings)
    if any(part.focus for drawing in drawings for part in drawing.parts):
        legend.append(("Re λ", {"color": Color.GREY, "linewidth": THICK}))
    return [discriminant, eigenvalue], [branches, legend]


def _rows_7(drawings: Sequence[Drawing]) -> Rows:
    seen = [y[part.rows] for x in drawings for part in x.parts for y in curves.voltage_curves(part.branch.voltages)]
    overlays = [x.simulated.voltages for x in drawings if x.simulated and x.simulated.voltages]
    power = prefix(chain(seen, *map(curves.voltage_curves, overlays)))
    looks = AVERAGE, BOTTOM_VOLTAGE, TOP_VOLTAGE
    unstable = UNSTABLE_VOLTAGE, UNSTABLE_VOLTAGE, UNSTABLE_TOP_VOLTAGE

    def scaled(voltages: Voltages | None) -> list[Floats]:
        return [y / 10.0**power for y in curves.voltage_curves(voltages)]

    row = _Row(
        f"generated voltage U [{PREFIXES[power]}V]",
        lambda x, branch: scaled(branch.voltages),
        lambda x, part, k: looks[k] | ({"zorder": STABLE["zorder"]} if part.stable else unstable[k]),
        (Color.VERMILION, Color.BLUE, Color.BLUE),
        lambda simulated: zip(scaled(simulated.voltages), (STAR, CIRCLE, CIRCLE), strict=False),
    )
    names = "Uₐᵥₑ", "Uᵢₘₚ − Uᵢₙ, bottom", "Uᵢₘₚ − Uᵢₙ, top"
    legend: list[Entry] = list(zip(names, looks, strict=True))
    if any(not part.stable for drawing in drawings for part in drawing.parts):
        legend.append(("unstable", UNSTABLE_VOLTAGE | {"color": Color.GREY, "linewidth": 1.6}))
    if overlays:
        legend += [("simulated Uₐᵥₑ", STAR), ("simulated", CIRCLE)]
    return [row], [legend]


def _stability_legend(drawings: Sequence[Drawing]) -> list[Entry]:
    occurring = {part.stable for drawing in drawings for part in drawing.parts}
    styles = (("stable", True, STABLE), ("unstable", False, UNSTABLE))
    return [(name, {"color": Color.GREY, "linewidth": THIN} | look) for name, kind, look in styles if kind in occurring]


def _point_legend(drawings: Sequence[Drawing]) -> list[Entry]:
    """The kinds of critical points that occur, and the design point."""
    kinds = {event.point.kind for drawing in drawings for event in drawing.events}
    points = [(f"{kind.letter} {kind.words}", POINT | MARKERS[kind]) for kind in kinds]
    points.sort(key=lambda entry: entry[0])
    if any(drawing.design_at is not None for drawing in drawings):
        points.append(("design point", DESIGN | {"markerfacecolor": "white"}))
    return points
