"""Figures 2, 4 and 7: what a study finds along its sweep, for one scenario or for several beside one another.

Only motions are drawn: what is not admissible is neither a line nor a point here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from msgspec import Struct
from msgspec.structs import replace

from vireport.design.from_rest import Destination
from vireport.design.outcomes_from_rest import OutcomeRange
from vireport.design.point import DesignPoint
from vireport.figures import curves, measured
from vireport.figures.captions import LAMBDA_LIMIT
from vireport.figures.curves import (
    CUT_DISTANCE,
    TURN,
    Doubled,
    DrawnCurve,
    DrawnPoint,
    Floats,
    PairedImpacts,
    Stretch,
)
from vireport.figures.labels import Label
from vireport.figures.layout import (
    AXES_HEIGHT,
    Entry,
    SweepAxis,
    blank,
    finished,
    fit_vertically,
    folded,
    letter_of,
    letter_panels,
    prefix,
    say,
    sweep_axis,
)
from vireport.figures.style import (
    DASH_DOTTED,
    DOTTED,
    Color,
    Look,
    Sheet,
    drawn_for,
    sheet,
    style,
)
from vireport.figures.ticks import set_ticks
from vireport.motions.branches import Branch
from vireport.motions.events import Event
from vireport.motions.stability import determinant_of, eigenvalues
from vireport.physics.energy import Voltages
from vireport.study.plan import Task
from vireport.study.study import Study
from vireport.text.formatting import MINUS, PREFIXES

if TYPE_CHECKING:
    from vireport.study.measured import MeasuredAt

# Width tells the two impacts apart where colour does not, and where one curve lies on the other.
BOTTOM: Look = {"color": Color.BLUE, "linewidth": 2.8}
TOP: Look = {"color": Color.GREEN, "linewidth": 1.2}
ALIKE: Look = {"color": Color.BLACK, "linewidth": 2.0}
"""One curve for both impacts, whose colours would mix to one that no legend has."""
STABLE_LOOK: Look = {"linestyle": "-", "zorder": 2.5}
UNSTABLE_LOOK: Look = {"linestyle": DASH_DOTTED, "zorder": 2.2, "alpha": 0.7}
UNSTABLE_WIDTH = 0.5
"""Of curves of unstable motions, over that of stable ones: as thick, their dashes would run together."""

AVERAGE: Look = {"color": Color.VERMILION, "linewidth": 2.0}

VISIBLE = 1e-3
"""Difference of two curves below which they are drawn as one, over the largest of their values."""

EVENT_LINE: Look = {"color": Color.LIGHT, "linewidth": 0.6, "zorder": 1.1}
BOUND: Look = {"color": Color.GREY, "linewidth": 1.0, "linestyle": DOTTED, "zorder": 1.5}
DESIGN_LINE: Look = {"color": Color.GREY, "linewidth": 0.9, "linestyle": (0, (2, 2)), "zorder": 1.4}
MARK: Look = {"linestyle": "none", "color": Color.BLACK, "markersize": 5.0, "markeredgewidth": 0.5, "zorder": 4.0}
DESIGN: Look = MARK | {"marker": "P", "markersize": 8.5, "zorder": 3.8}
"""Larger than the markers of critical points, and under them."""
POINT: Look = MARK | {"markeredgecolor": "white"}
MARKERS: dict[Event, Look] = {
    Event.NODE_FOCUS: {"marker": "o"},
    Event.PERIOD_DOUBLING: {"marker": "s"},
    Event.FOLD: {"marker": "d", "markersize": 6.5},
    Event.PITCHFORK: {"marker": "D"},
    Event.GRAZING: {"marker": "^", "markersize": 6.0},
    Event.STOP: {"marker": "v", "markersize": 6.0},
}
CIRCLE: Look = MARK | {
    "marker": "o", "markersize": 4.5, "markerfacecolor": "none", "markeredgewidth": 0.8, "zorder": 3.5,
}  # fmt: skip
LEAVES: Look = {
    "linestyle": "none",
    "markersize": 5.0,
    "markerfacecolor": "white",
    "markeredgewidth": 1.0,
    "zorder": 3.4,
}
INSIDE = 0.03
"""Distance of the marks of curves that leave a panel from its edge, as a share of its height."""

FULL_SIZE_UP_TO = 60
"""Simulated values along a sweep up to which their markers have their full size."""

THIN, THICK = 1.5, 3.4
"""Widths of curves in figure 4 [pt]; thick where the eigenvalues are complex."""

DOUBLED = 0.9
"""Width of the curves of motions that come of period doublings [pt]."""

STRIP = 0.12
"""Height of the panel of outcomes from rest under those of figure 2, over theirs."""

NAMED_AT = 24
"""Places along a stretch at which the name of its branch may stand."""

OUTCOMES: dict[Destination, tuple[str, str]] = {
    Destination.ONE_TO_ONE: ("1:1", Color.SKY),
    Destination.OTHER_MOTION: ("another motion", Color.ORANGE),
    Destination.REST_CYCLE: ("rest cycle", Color.PURPLE),
    Destination.CHAOTIC: ("chaotic", Color.BLACK),
    Destination.AT_REST: ("at rest", Color.GREY),
    Destination.UNDECIDED: ("not decided", Color.LIGHT),
}
"""What the ball comes to that the device is switched on with: its name in the legend, and the colour of the strip."""

DESIGN_ENTRY: Entry = ("design point", DESIGN | {"markerfacecolor": "white"})

NO_MOTION = "no admissible 1:1 motion in this sweep"

HEIGHTS = {Task.FIGURE_2: 1.18, Task.FIGURE_4: 1.27, Task.FIGURE_7: 2.3}
"""Heights of the panels with the letter over them, for `ROOM_FOR` critical points [in]."""

PANELS = {Task.FIGURE_2: 3, Task.FIGURE_4: 2, Task.FIGURE_7: 1}
"""Panels of a study in each figure, one above the other."""

ROOM_FOR = 15
"""Critical points whose labels a panel has room for; with more it is higher in proportion."""

BOLD = 1.05
"""Width of bold letters over that of others."""

EVERYTHING = (-np.inf, np.inf)


class Drawing(Struct, frozen=True, eq=False):
    """A study with what is drawn of it along its sweep; `branches` names those of figure 4, by their number."""

    study: Study
    axis: SweepAxis
    parts: list[Stretch]
    events: list[DrawnPoint]
    doubled: list[Doubled]
    simulated: PairedImpacts | None
    branches: dict[int, str]

    @property
    def design_at(self) -> float | None:
        """Where the design point stands along the sweep; None where there is none within it."""
        design = self.study.solution.design
        at = self.axis.of_value(design.value) if design is not None else np.nan
        return at if self.parts and self.axis.low <= at <= self.axis.high else None


def of_stability(look: Look, stable: bool) -> Look:
    """The look of a curve where the motions are stable, or are not: then it is thin and pale."""
    return look | STABLE_LOOK if stable else look | UNSTABLE_LOOK | {"linewidth": UNSTABLE_WIDTH * look["linewidth"]}


def panel_letters(figure: Task, column: int) -> str:
    """The letters of the panels of a column, such as (d)–(f): columns are lettered one after the other."""
    first, last = (letter_of(column * PANELS[figure] + row) for row in (0, PANELS[figure] - 1))
    return f"({first})" if first == last else f"({first})–({last})"


def drawing_of(study: Study, simulated: PairedImpacts | None = None) -> Drawing:
    """Prepare a study for its figures; a ValueError says that it has no sweep."""
    solution, sweep = curves.swept_solution(study)
    parts = curves.stretches(solution)
    branches = {
        branch.number: f"{branch.symmetry} {branch.number}"
        for branch in solution.branches
        if branch.mirror_of is None and any(part.branch is branch for part in parts)
    }
    events, doubled = curves.events(solution), curves.doubled(study)
    return Drawing(study, sweep_axis(sweep), parts, events, doubled, simulated, branches)


Settings = Mapping[str, Any]


def figure_2(
    study: Study,
    simulated: PairedImpacts | None = None,
    *,
    width_mm: float | None = None,
    style: Settings | None = None,
) -> Figure:
    """Draw impact velocity, phase and half the flight time along the sweep, as in Fig. 2 of the paper.

    Parameters
    ----------
    study : Study
    simulated : PairedImpacts, optional
        Motions from a simulation, drawn over the analytic ones.
    width_mm : float, optional
        Width of a column of a paper [mm], 60 to 250; constant inputs are then left to the caption.
    style : mapping, optional
        Settings of Matplotlib, such as ``{"font.family": "Times New Roman", "font.size": 8}``.

    Raises
    ------
    ValueError
        If the study has no sweep.
    UsageError
        For another width, and where it is no study.
    """
    with drawn_for(Sheet.of(width_mm, style)):
        return sweep_figure(Task.FIGURE_2, [drawing_of(study, simulated)])


def figure_4(study: Study, *, width_mm: float | None = None, style: Settings | None = None) -> Figure:
    """Draw discriminant and eigenvalues along the sweep, as in Fig. 4 of the paper.

    Where the eigenvalues are complex, their common real part is drawn. Parameters and errors are those of `figure_2`.
    """
    with drawn_for(Sheet.of(width_mm, style)):
        return sweep_figure(Task.FIGURE_4, [drawing_of(study)])


def figure_7(
    study: Study,
    simulated: PairedImpacts | None = None,
    *,
    width_mm: float | None = None,
    style: Settings | None = None,
) -> Figure:
    """Draw the voltages [kV] of both impacts and their mean along the sweep, as in Fig. 7 of the paper.

    Parameters and errors are those of `figure_2`.
    """
    with drawn_for(Sheet.of(width_mm, style)):
        return sweep_figure(Task.FIGURE_7, [drawing_of(study, simulated)])


def sweep_figure(
    figure: Task,
    drawings: Sequence[Drawing],
    titles: Sequence[str] = (),
    remarks: Sequence[str] = (),
    lines: Sequence[tuple[str, str]] = (),
) -> Figure:
    """Draw figure 2, 4 or 7 of one study, or of several as columns whose rows share their vertical axes.

    Parameters
    ----------
    figure : Task
        Figure 2, 4 or 7.
    drawings : sequence of Drawing
    titles, remarks : sequence of str
        Over each column, the remark under the title.
    lines : sequence of (str, str)
        Texts over all of them, with their colours.
    """
    # A mirror image has the same multipliers: its curve would lie on that of the motion.
    if figure == Task.FIGURE_4:
        drawings = [
            replace(drawing, parts=[part for part in drawing.parts if not part.branch.mirror_of])
            for drawing in drawings
        ]
    with style():
        rows, legends = _rows(figure, drawings)
        heights = [1.0] * len(rows)
        if figure == Task.FIGURE_2 and any(map(_outcomes, drawings)):
            heights.append(STRIP)
        page, panels = blank(
            len(heights), len(drawings), sharex="col", sharey="row", gridspec_kw={"height_ratios": heights}
        )
        labels = [
            (
                axes,
                _draw(axes, row, drawing, _named(rows, row, drawing), linked=not titles)
                + _branch_labels(rows, row, drawing),
            )
            for row, axes_of_row in zip(rows, panels, strict=False)
            for axes, drawing in zip(axes_of_row, drawings, strict=True)
        ]
        if len(heights) > len(rows):
            panels[-1, 0].set_ylabel("from rest", rotation=0, ha="right", va="center")
            for axes, drawing in zip(panels[-1], drawings, strict=True):
                _draw_outcomes(axes, drawing)
        for row, axes_of_row in zip(rows, panels, strict=False):
            axes_of_row[0].set_ylabel(row.label)
            if row.cut is None:
                fit_vertically(axes_of_row)
            else:
                fit_angles(axes_of_row[0], row.cut)
            if row.limits != EVERYTHING:
                for axes, drawing in zip(axes_of_row, drawings, strict=True):
                    _mark_leaving(axes, row, drawing)
        letters = sheet().letters(sheet().across / len(drawings))
        for k, drawing in enumerate(drawings):
            if titles:
                panels[0, k].set_title(folded(titles[k], int(letters / BOLD)), weight="bold")
            if panels.size > 1:
                letter_panels(panels[: len(rows), k], k * len(rows), drawing.axis.scales_on_top)
            drawing.axis.dress(panels[:, k], len(drawings), folded(remarks[k], letters) if remarks else "")
        crowded = max(len(drawing.events) for drawing in drawings) / ROOM_FOR
        height = HEIGHTS[figure] * sum(heights) * max(1.0, crowded) + AXES_HEIGHT
        # Of one study the caption says what the letters of critical points mean.
        points = point_legend(drawings)
        legends[0] += points if titles else [entry for entry in points if entry is DESIGN_ENTRY]
        return finished(page, height, lines, legends, labels, panels[: len(rows), 0])


class _Row(Struct, frozen=True):
    """One quantity along the sweep.

    Attributes
    ----------
    label : str
        Word, symbol and unit.
    values : callable
        Maps the motions of a branch or of the design point to an array for each of its curves.
    look : callable
        Maps a curve on a stretch to its look where it is stable.
    colors : tuple of str
        Colours of the design point's markers and of the motions that come of period doublings, one for each curve.
    paired : callable
        As `values`, of motions of any word and of the points of a simulation.
    limits : tuple of float
        Range beyond which nothing needs to be seen.
    bounds : tuple of float
        Values at which a line is drawn across.
    cut : float, optional
        Where the axis begins, if it is that of an angle [rad].
    sides : tuple of int, optional
        Which curves are of the bottom and of the top impact, where both may be one.
    marks_of : callable
        What is drawn of measured motions.
    branches : bool
        Whether the names of branches are written along their curves.
    """

    label: str
    values: Callable[[Drawing, Branch | DesignPoint], Sequence[Floats]]
    look: Callable[[Drawing, Stretch, int], Look]
    colors: tuple[str, ...]
    paired: Callable[[PairedImpacts], Iterable[Floats]] = lambda impacts: ()
    limits: tuple[float, float] = EVERYTHING
    bounds: tuple[float, ...] = ()
    cut: float | None = None
    sides: tuple[int, int] | None = None
    marks_of: Callable[[Sequence[MeasuredAt]], Iterable[measured.Marks]] = lambda records: ()
    branches: bool = False


def _draw(axes: Axes, row: _Row, drawing: Drawing, named: Sequence[DrawnPoint], linked: bool) -> list[Label]:
    """Draw a row of a study, and return the labels of the critical points that are `named` in it.

    Each is `linked` to a row of the report.
    """
    for bound in row.bounds:
        axes.axhline(bound, **BOUND)
    if not drawing.parts:
        say(axes, NO_MOTION)
    _draw_curves(axes, row, drawing)
    for part in drawing.doubled:
        look = of_stability({"linewidth": DOUBLED}, part.stable)
        x = np.split(drawing.axis.of(part.impacts), part.pairs)
        for values, color in zip(row.paired(part.impacts), row.colors, strict=False):
            pieces = [y if row.cut is None else curves.phase_curve(y) for y in np.split(values, part.pairs)]
            _plot(axes, list(zip(x, pieces, strict=True)), look | {"color": color})
    if drawing.simulated:
        scale = _marker_scale(drawing.simulated)
        look = CIRCLE | {key: CIRCLE[key] * scale for key in ("markersize", "markeredgewidth")}
        for y in row.paired(drawing.simulated):
            _plot(axes, [(drawing.axis.of(drawing.simulated), y)], look)
    _mark_design(axes, row, drawing)
    if drawing.study.measured:
        measured.draw(axes, row.marks_of(drawing.study.measured), drawing.axis.of_value, row.limits)
    return _mark_critical_points(axes, row, drawing, named, linked)


def _branch_curves(row: _Row, drawing: Drawing) -> dict[str, DrawnCurve]:
    """The longest curve of each branch that a panel shows, by the name of the branch."""
    low, high = row.limits
    curves_by_name: dict[str, list[DrawnCurve]] = {}
    for part in drawing.parts:
        x = drawing.axis.of(part.branch.motions)[part.rows]
        for values in row.values(drawing, part.branch):
            y = values[part.rows]
            inside = (low <= y) & (y <= high)
            if inside.any():
                curves_by_name.setdefault(drawing.branches[part.branch.number], []).append((x[inside], y[inside]))
    return {name: max(drawn, key=lambda curve: np.ptp(curve[0])) for name, drawn in curves_by_name.items()}


def _branch_labels(rows: Sequence[_Row], row: _Row, drawing: Drawing) -> list[Label]:
    """The names of the branches, where there are several, in the first row from the top that shows them."""
    if not row.branches or len(drawing.branches) < 2:
        return []
    above = {name for other in rows[: rows.index(row)] for name in _branch_curves(other, drawing)}
    labelled = ((name, curve) for name, curve in _branch_curves(row, drawing).items() if name not in above)
    some = ((name, x, y, max(len(x) // NAMED_AT, 1)) for name, (x, y) in labelled)
    return [
        Label(name, x[::step], y[::step], size=sheet().small, color=Color.GREY, spare=True) for name, x, y, step in some
    ]


def _named(rows: Sequence[_Row], row: _Row, drawing: Drawing) -> list[DrawnPoint]:
    """The critical points whose labels are in a row, which is the first from the top that shows them."""

    def is_in(row: _Row, event: DrawnPoint) -> bool:
        low, high = row.limits
        return any(low <= y[i] <= high for branch, i in event.places for y in row.values(drawing, branch))

    return [event for event in drawing.events if next((x for x in rows if is_in(x, event)), None) is row]


def fit_angles(axes: Axes, cut: float) -> None:
    """Let a panel hold a full turn from where the phases are cut, with ticks at quarters of it."""
    low, high = min(cut, axes.dataLim.y0), max(cut + TURN, axes.dataLim.y1)
    axes.set_ylim(low - 0.03 * TURN, high + 0.03 * TURN)
    quarters = np.arange(np.ceil(4 * (low - CUT_DISTANCE) / TURN), np.floor(4 * (high + CUT_DISTANCE) / TURN) + 1)
    set_ticks(axes.yaxis, quarters * TURN / 4, [_quarters(int(k)) for k in quarters])


def _quarters(count: int) -> str:
    """A number of quarter turns in units of pi, such as 3π/2."""
    if count == 0:
        return "0"
    number, half = (abs(count), "/2") if count % 2 else (abs(count) // 2, "")
    return f"{MINUS if count < 0 else ''}{number if number > 1 else ''}π{half}"


def _leaves(row: _Row, drawing: Drawing) -> bool:
    """Whether a curve is beyond what a panel has to hold."""
    low, high = row.limits
    sizes = [y[part.rows] for part in drawing.parts for y in row.values(drawing, part.branch)]
    return any(bool(((y < low) | (y > high)).any()) for y in sizes)


def _mark_leaving(axes: Axes, row: _Row, drawing: Drawing) -> None:
    """Mark at the edge of a panel where a curve leaves it, or that it is beyond."""
    low, high = axes.get_ylim()
    for part in drawing.parts:
        x = drawing.axis.of(part.branch.motions)[part.rows]
        for k, values in enumerate(row.values(drawing, part.branch)):
            # Near a pole a value is so large that the crossing, between two samples, would be at the inner one.
            y = np.clip(values[part.rows], 2 * low - high, 2 * high - low)
            for edge, beyond, at, marker in (
                (low, y < low, INSIDE, "v"),
                (high, y > high, 1 - INSIDE, "^"),
            ):
                i = np.flatnonzero(beyond[1:] != beyond[:-1])
                places = x[i] + (edge - y[i]) / (y[i + 1] - y[i]) * (x[i + 1] - x[i])
                if beyond.all():
                    places = x[[len(x) // 2]]
                look = LEAVES | {"marker": marker, "color": row.look(drawing, part, k)["color"]}
                if len(places):
                    axes.add_artist(
                        Line2D(places, np.full(len(places), at), transform=axes.get_xaxis_transform(), **look)
                    )


def _curves(row: _Row, drawing: Drawing, part: Stretch) -> list[tuple[Floats, Look]]:
    """The curves of a stretch, with their looks where it is stable; those that coincide are one, and of its look."""
    values = [y[part.rows] for y in row.values(drawing, part.branch)]
    looks = [row.look(drawing, part, k) for k in range(len(values))]
    if row.sides is not None and values:
        bottom, top = row.sides
        if _coincide(values[bottom], values[top]):
            return [(values[bottom], ALIKE)]  # and so is their mean
        if _mirrored(drawing, part.branch):
            looks[bottom] = looks[top] = ALIKE
    return list(zip(values, looks, strict=True))


def _coincide(one: Floats, other: Floats) -> bool:
    return bool((np.abs(one - other) <= VISIBLE * np.abs(one).max(initial=0.0)).all())


def _mirrored(drawing: Drawing, branch: Branch) -> bool:
    """Whether a mirror image of a branch is drawn, whose curve of the bottom is that of the top here."""
    return any(branch.number == x.branch.mirror_of or branch.mirror_of == x.branch.number for x in drawing.parts)


def _alike(row: _Row, drawings: Iterable[Drawing]) -> set[bool]:
    """Whether there are curves of both impacts in one, and curves of either."""
    return {look == ALIKE for drawing in drawings for part in drawing.parts for _, look in _curves(row, drawing, part)}


def _draw_curves(axes: Axes, row: _Row, drawing: Drawing) -> None:
    """Draw the curves of all stretches, those of one look as one line."""
    # Each line is a path with its own style in the file, and a branch may have many stretches.
    by_look: dict[tuple[object, ...], tuple[list[DrawnCurve], Look]] = {}
    for part in drawing.parts:
        x = drawing.axis.of(part.branch.motions)[part.rows]
        for y, base in _curves(row, drawing, part):
            look = of_stability(base, part.stable)
            piece = x, y if row.cut is None else curves.phase_curve(y)
            by_look.setdefault(tuple(look.items()), ([], look))[0].append(piece)
    for pieces, look in by_look.values():
        _plot(axes, pieces, look, row.limits)


def _plot(axes: Axes, parts: Sequence[DrawnCurve], look: Look, limits: tuple[float, float] = EVERYTHING) -> None:
    """Draw curves as one line, broken between them; the axis has to hold only what of them is within the limits."""
    # Not `plot`, for which the axis would have to hold the whole curve.
    axes.add_artist(Line2D(*curves.joined(parts), **look))
    low, high = limits
    for x, y in parts:
        if ((y >= low) & (y <= high)).any():
            axes.update_datalim(np.column_stack([x, np.clip(y, low, high)]))


def _across(axes: Axes, places: Sequence[float], look: Look) -> None:
    """Draw upright lines across a panel, all as one; `Axes.axvline` takes ten times as long for each."""
    x, y = np.repeat(places, 3), np.tile([0.0, 1.0, np.nan], len(places))
    axes.add_artist(Line2D(x, y, transform=axes.get_xaxis_transform(), **look))


def _marker_scale(simulated: PairedImpacts) -> float:
    """Size of simulated points, smaller where they are many so that the curve beneath is seen."""
    count = max(len(np.unique(simulated.sweep_value)), 1)
    return float(np.clip((FULL_SIZE_UP_TO / count) ** 0.5, 0.4, 1.0))


def _outcomes(drawing: Drawing) -> tuple[OutcomeRange, ...]:
    """The outcomes from rest along the sweep, where they were looked for."""
    switched_on = drawing.study.switched_on
    return switched_on.over_sweep if switched_on is not None else ()


def _draw_outcomes(axes: Axes, drawing: Drawing) -> None:
    """Fill a panel with what switching on leads to."""
    set_ticks(axes.yaxis, [], [])
    for stretch in _outcomes(drawing):
        ends = drawing.axis.of_value(stretch.start), drawing.axis.of_value(stretch.end)
        axes.axvspan(*ends, facecolor=OUTCOMES[stretch.outcome.destination][1], linewidth=0, zorder=1.2)


def _mark_design(axes: Axes, row: _Row, drawing: Drawing) -> None:
    """Mark the design point and the values of its stable motions; where it has none, of the unstable ones, open."""
    design, at = drawing.study.solution.design, drawing.design_at
    if design is None or at is None:
        return
    _across(axes, [at], DESIGN_LINE)
    motions = design.motions
    stable = bool(motions.stable_mask.any())
    chosen = motions.stable_mask if stable else motions.admissible_mask
    curves_of = [y[chosen] for y in row.values(drawing, design)]
    colored = list(zip(curves_of, row.colors, strict=True))
    if row.sides is not None and _coincide(*(curves_of[side] for side in row.sides)):
        colored = [(curves_of[row.sides[0]], ALIKE["color"])]
    for y, color in colored:
        look = DESIGN | {"markerfacecolor": color if stable else "white"}
        _plot(axes, [(np.full(len(y), at), y)], look, row.limits)


def _mark_critical_points(
    axes: Axes, row: _Row, drawing: Drawing, named: Sequence[DrawnPoint], linked: bool
) -> list[Label]:
    """Mark the critical points on all curves of a panel; those `named` in it get a label, the others a line.

    The label is at the largest value if there is room.
    """
    labels: list[Label] = []
    by_kind: dict[Event, list[DrawnCurve]] = {}
    crossed: list[float] = []
    for event in drawing.events:
        values = np.array([[y[i] for y in row.values(drawing, branch)] for branch, i in event.places])
        places = np.array([drawing.axis.of(branch.motions)[i] for branch, i in event.places])
        x, y = np.repeat(places, values.shape[1]), values.ravel()
        by_kind.setdefault(event.point.event, []).append((x, y))
        if event not in named:
            crossed.append(drawing.axis.of_value(event.point.sweep_value))
            continue
        largest_first = np.argsort(-np.abs(y), kind="stable")
        link = f"#point-{event.point.label}" if linked else None
        labels.append(Label(event.point.label, x[largest_first], y[largest_first], link=link))
    _across(axes, crossed, EVENT_LINE)
    for kind, points in by_kind.items():
        _plot(axes, points, POINT | MARKERS[kind], row.limits)
    return labels


FigureRows = tuple[list[_Row], list[list[Entry]]]
"""The rows of a figure from the top one down, and its legends, each of which begins a line."""


def _rows(figure: Task, drawings: Sequence[Drawing]) -> FigureRows:
    return {Task.FIGURE_2: _rows_2, Task.FIGURE_4: _rows_4, Task.FIGURE_7: _rows_7}[figure](drawings)


def _rows_2(drawings: Sequence[Drawing]) -> FigureRows:
    cut = curves.phase_cut(part for drawing in drawings for part in drawing.parts)

    def marks(k: int, records: Sequence[MeasuredAt]) -> Iterable[measured.Marks]:
        of_row = (measured.speed, lambda record: measured.phase(record, cut), measured.flight)[k]
        return measured.impact_marks(records, of_row, (Color.BLUE, Color.GREEN))

    def row(k: int, label: str, phases: bool = False) -> _Row:
        return _Row(
            label,
            lambda drawing, branch: curves.impact_pairs(
                branch.motions, drawing.study.solution.device.period_ratio, cut
            )[k],
            lambda drawing, part, side: (BOTTOM, TOP)[side],
            (Color.BLUE, Color.GREEN),
            lambda impacts: impacts.pairs(cut)[k],
            cut=cut if phases else None,
            sides=None if phases else (0, 1),
            marks_of=lambda records: marks(k, records),
        )

    rows = [
        row(0, "impact velocity |Ż| [–]"),
        row(1, "phase φ [rad]", phases=True),
        row(2, "flight time Δt/2 [periods]"),
    ]
    legend: list[Entry] = [("bottom", BOTTOM), ("top", TOP)]
    if any(True in _alike(row, drawings) for row in rows):
        legend.append(("both", ALIKE))
    legend += stability_legend(drawings) + _doubled_legend(drawings)
    if any(drawing.simulated for drawing in drawings):
        legend.append(("simulated", CIRCLE))
    legend += _measured_legend(drawings)
    occurring = {stretch.outcome.destination for drawing in drawings for stretch in _outcomes(drawing)}
    strip: list[Entry] = [
        (name, {"color": color, "linewidth": 5.0})
        for destination, (name, color) in OUTCOMES.items()
        if destination in occurring
    ]
    return rows, [legend, strip]


def _rows_4(drawings: Sequence[Drawing]) -> FigureRows:
    sizes = [part.branch.motions.discriminant[part.rows] for drawing in drawings for part in drawing.parts]
    least = min((float(size.min()) for size in sizes), default=0.0)
    # The discriminant is (λ₁ - λ₂)², and λ₁ λ₂ the determinant: its axis ends where that of the eigenvalues does.
    determinants = [determinant_of(drawing.study.solution.device.restitution) for drawing in drawings]
    determinants += [float(part.branch.motions.determinant.min()) for drawing in drawings for part in drawing.parts]
    highest = max((LAMBDA_LIMIT - determinant / LAMBDA_LIMIT) ** 2 for determinant in determinants)

    discriminant = _Row(
        "discriminant Δ [–]",
        lambda x, branch: [branch.motions.discriminant],
        lambda x, part, k: ALIKE | {"linewidth": THIN},
        (ALIKE["color"],),
        limits=(-np.inf, highest) if least < highest else EVERYTHING,
        bounds=(0.0,),
        marks_of=measured.discriminant_marks,
        branches=True,
    )
    eigenvalue = _Row(
        "eigenvalues λ [–]",
        lambda x, branch: eigenvalues(branch.motions.trace, branch.motions.decay),
        lambda x, part, k: ALIKE | {"linewidth": THICK if part.focus else THIN},
        (ALIKE["color"], ALIKE["color"]),
        limits=(-LAMBDA_LIMIT, LAMBDA_LIMIT),
        bounds=(-1.0, 1.0),
        marks_of=measured.eigenvalue_marks,
        branches=True,
    )
    legend = stability_legend(drawings)
    if any(part.focus for drawing in drawings for part in drawing.parts):
        legend.append(("Re λ", {"color": Color.GREY, "linewidth": THICK}))
    legend.append(("Δ = 0, λ = ±1", BOUND))
    if any(_leaves(row, drawing) for row in (discriminant, eigenvalue) for drawing in drawings):
        legend.append(("off the scale", LEAVES | {"marker": "^", "color": Color.GREY}))
    legend += _measured_legend(drawings, one_to_one=True)
    return [discriminant, eigenvalue], [legend]


def _measured_legend(drawings: Sequence[Drawing], one_to_one: bool = False) -> list[Entry]:
    """What was measured, or the 1:1 motions of it."""
    records = [at for drawing in drawings for at in drawing.study.measured if at.multipliers or not one_to_one]
    return measured.legend(records)


def _rows_7(drawings: Sequence[Drawing]) -> FigureRows:
    seen = [
        y[part.rows]
        for drawing in drawings
        for part in drawing.parts
        for y in curves.voltage_curves(part.branch.voltages_by_motion)
    ]
    overlays = [drawing.simulated.voltages for drawing in drawings if drawing.simulated and drawing.simulated.voltages]
    power = prefix(chain(seen, *map(curves.voltage_curves, overlays)))
    looks = AVERAGE, BOTTOM, TOP

    def scaled(voltages: Voltages | None) -> list[Floats]:
        return [y / 10.0**power for y in curves.voltage_curves(voltages)]

    row = _Row(
        f"generated voltage U [{PREFIXES[power]}V]",
        lambda drawing, branch: scaled(branch.voltages_by_motion),
        lambda drawing, part, k: looks[k],
        (Color.VERMILION, Color.BLUE, Color.GREEN),
        lambda impacts: scaled(impacts.voltages),
        sides=(1, 2),
    )
    alike = _alike(row, drawings)
    names = "Uₐᵥₑ", "bottom", "top"
    legend: list[Entry] = list(zip(names, looks, strict=True)) if alike != {True} else []
    if True in alike:
        legend.append(("both, and Uₐᵥₑ", ALIKE))
    legend += stability_legend(drawings) + _doubled_legend(drawings)
    if overlays:
        legend.append(("simulated", CIRCLE))
    return [row], [legend]


def stability_legend(drawings: Sequence[Drawing]) -> list[Entry]:
    """The lines of stable and of unstable motions, as far as they occur."""
    occurring = {part.stable for drawing in drawings for part in drawing.parts}
    look: Look = {"color": Color.GREY, "linewidth": THIN}
    kinds = (("stable", True), ("unstable", False))
    return [(name, of_stability(look, stable)) for name, stable in kinds if stable in occurring]


def _doubled_legend(drawings: Sequence[Drawing]) -> list[Entry]:
    if not any(drawing.doubled for drawing in drawings):
        return []
    return [("period-doubled", {"color": Color.GREY, "linewidth": DOUBLED})]


def point_legend(drawings: Sequence[Drawing]) -> list[Entry]:
    """The kinds of critical points that occur, and the design point."""
    kinds = {event.point.event for drawing in drawings for event in drawing.events}
    points = [(f"{kind.letter} {kind.words}", POINT | MARKERS[kind]) for kind in kinds]
    points.sort(key=lambda entry: entry[0])
    if any(drawing.design_at is not None for drawing in drawings):
        points.append(DESIGN_ENTRY)
    return points
