"""Heat maps of a grid over two parameters, with the curves along which motions change, and captions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from msgspec import Struct
from numpy.typing import NDArray

from vireport.design.plane import Plane
from vireport.figures.captions import held_by
from vireport.figures.layout import prefix
from vireport.figures.style import HALO, LOCI, Color, Look, NotebookFigure, Picture, Pixel, style
from vireport.figures.sweeps import OUTCOMES
from vireport.map.cells.cells import Floats, MapPlan, axis_values
from vireport.map.cells.disturbed import DESTINATIONS
from vireport.map.cells.findings import MapFindings, largest_margin, pieces_of, restitution_at
from vireport.map.chart.chart import loci_over
from vireport.map.chart.plane import DevicePlane
from vireport.map.design import MapDesign
from vireport.map.figure import mark_on_plane, paper_of, plane_finished, plane_panel
from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.stability import STABILITIES, Stability
from vireport.motions.sweep import Sweep
from vireport.motions.switching import Limits
from vireport.physics.device import RESTITUTIONS
from vireport.physics.groups import Restitutions
from vireport.scenario.parameters import DRIVING, DesignInput
from vireport.text.formatting import PREFIXES
from vireport.text.templates import Words

FINEST = 1000
"""Cells along either axis that a picture shows; of more, every second, third, ... is drawn."""

NO_CELL: Look = {"facecolor": "#FFFFFF", "edgecolor": "#999999", "hatch": "////", "linewidth": 0.0}
"""Look of cells without motion: hatched, as white is a shade of the margin too."""

TYPES = {
    Stability.STABLE_NODE: ("stable node", "#0072B3"),
    Stability.STABLE_FOCUS: ("stable focus", "#7CC4EE"),
    Stability.UNSTABLE_NODE: ("only unstable", "#F3DCB0"),
}
"""Name and colour of each type, from dark to light so that they are apart in grey as well."""

SCALE_WIDTH = 1.0
"""Width of a scale of colours beside a map [in]."""

NONE_FOUND = "none found up to the impact velocity", Pixel.LIGHT
NOT_TOLD = "too near a critical point to tell", Pixel.GREY

PIXELS = 400
"""Fineness of the grid on which names of areas find their places."""

FLAT = Normalize(0.0, 2.0)
"""The scale of cells of one colour, of value 1."""

OVER_CELLS: Look = {"facecolor": Color.WHITE, "edgecolor": "none", "pad": 1.0}
"""What lies under names that may stand on cells of any colour."""

OF_CELLS: Look = {"linewidth": 7.0, "solid_capstyle": "butt"}
"""Look of cells of one colour in a legend."""

MIDDLE = 130.0
"""Brightness of a colour from which black is easier to read on it than white."""

LINE = 1.4
"""Width of a curve [pt]."""


class Raster(Struct, frozen=True, eq=False):
    """Cells of a map as they are drawn.

    Attributes
    ----------
    x, y : ndarray
        Values of the two axes.
    columns : dict of str to ndarray, shape (len(y), len(x))
        NaN where there is no value; for a column of words the place of each word in `CODES`.
    """

    x: Floats
    y: Floats
    columns: dict[str, Floats]

    @property
    def edges(self) -> tuple[Floats, Floats]:
        """Borders between cells along both axes, ascending."""
        return _edges(np.sort(self.x)), _edges(np.sort(self.y))


def picture_names(plan: MapPlan) -> tuple[str, ...]:
    """Names of the heat maps of a map."""
    optional = {"map-voltage": plan.membrane is not None, "map-from-rest": plan.from_rest, "map-shock": plan.shock}
    return ("map-stability", "map-margin", *(name for name, wanted in optional.items() if wanted))


class Area(Struct, frozen=True, eq=False):
    """The cells of a map that are filled with one colour, and its entry in the legend.

    Attributes
    ----------
    name, color : str
    cells : ndarray of bool, shape (len(y), len(x))
    """

    name: str
    color: str
    cells: NDArray[np.bool_]

    @property
    def ink(self) -> str:
        """Colour of a name on it; as its own, one that no dark page exchanges."""
        red, green, blue = (int(self.color[k : k + 2], 16) for k in (1, 3, 5))
        return Pixel.BLACK if 0.3 * red + 0.59 * green + 0.11 * blue > MIDDLE else Pixel.WHITE


class HeatMaps(Struct, frozen=True, eq=False):
    """The data that the heat maps of one map are drawn from.

    Attributes
    ----------
    plan : MapPlan
    raster : Raster
    loci : tuple of DrawnLocus
    findings : MapFindings
    design : MapDesign or None
        The design point; None if it is not on the map.
    said : Words
        Of ``templates/words/map.j2``.
    """

    plan: MapPlan
    raster: Raster
    loci: tuple[DrawnLocus, ...]
    findings: MapFindings
    design: MapDesign | None
    said: Words

    @property
    def plane(self) -> Plane:
        """The plane that is drawn: up to the outer edges of the cells."""
        (x, y), (first, second) = self.raster.edges, self.plan.named
        return Plane((first, second), np.array([x[0], y[0]]), np.array([x[-1], y[-1]]))


def map_pictures(
    plan: MapPlan, result: Path, findings: MapFindings, design: MapDesign | None = None, templates: Path | None = None
) -> tuple[Picture, ...]:
    """Draw the heat maps of a map, with captions; () where it is not over a plane.

    Parameters
    ----------
    plan : MapPlan
    result : Path
        The finished map; it is read piece by piece.
    findings : MapFindings
        Of this map.
    design : MapDesign, optional
        Marked on the heat maps.
    templates : Path, optional
        A folder whose words come before ours.
    """
    if plan.plane is None:
        return ()
    said, marked = Words("map", templates), design if design is not None and design.inside else None
    drawing = HeatMaps(plan, _raster(plan, result), loci_of(plan, plan.plane), findings, marked, said)
    words = {"plan": plan, "held": held_by(plan.device, plan.names), "findings": findings, "marked": marked}
    words |= {"curves": bool(drawing.loci), "outcomes": outcomes_of(findings)}
    with style():
        return tuple(
            Picture(
                name, said("title", name), said("caption", name, words), said("alt", name, words), DRAWN[name](drawing)
            )
            for name in picture_names(plan)
        )


def outcomes_of(findings: MapFindings) -> list[tuple[str, int]]:
    """What cells come to from rest, by the names of the legend, and how many do; the most frequent first."""
    return [(OUTCOMES[outcome][0], count) for outcome, count in findings.from_rest.most_common() if count]


def _raster(plan: MapPlan, result: Path) -> Raster:
    """Every cell of the result, or every second, third, ... along either axis."""
    shape = plan.shape
    stride = [-(-count // FINEST) for count in shape]
    indices = [np.arange(0, count, step) for count, step in zip(shape, stride, strict=True)]
    names = ["stability", "multiplier_margin", *(["u_ave_v"] if plan.membrane is not None else [])]
    names += ["least_jump_m_s", "jump_searched_to_m_s"] if plan.shock else []
    names += ["from_rest"] if plan.from_rest else []
    columns = {name: np.full((len(indices[1]), len(indices[0])), np.nan) for name in names}
    first = 0
    for piece in pieces_of(result, names):
        i, j = np.unravel_index(np.arange(first, first + len(piece["stability"])), shape)
        first += len(i)
        chosen = np.flatnonzero((i % stride[0] == 0) & (j % stride[1] == 0))
        where = j[chosen] // stride[1], i[chosen] // stride[0]
        for name in names:
            columns[name][where] = piece[name][chosen]
    x, y = (axis_values(axis, index) for axis, index in zip(plan.axes, indices, strict=True))
    return Raster(x, y, columns)


def _stability(drawing: HeatMaps) -> Figure:
    colors = ListedColormap([TYPES[stability][1] for stability in STABILITIES])
    figure, axes = _panel(drawing)
    _fill(axes, drawing.raster, drawing.raster.columns["stability"], colors, Normalize(-0.5, len(STABILITIES) - 0.5))
    return _finished(figure, axes, drawing, _types(drawing, *STABILITIES))


def _types(drawing: HeatMaps, *kinds: Stability) -> list[Area]:
    """The cells of each of some types of motion, as far as there are any."""
    code = drawing.raster.columns["stability"]
    return [Area(*TYPES[kind], code == kind.code) for kind in kinds if (code == kind.code).any()]


def _of_stable(
    drawing: HeatMaps, values: Floats, colors: str, label: str, ends: tuple[float, float] | None = None
) -> tuple[NotebookFigure, Axes]:
    """A figure with values where the motion is stable, from the least to the largest where no ends are given."""
    figure, axes = _panel(drawing, SCALE_WIDTH)
    code = drawing.raster.columns["stability"]
    unstable = code == Stability.UNSTABLE_NODE.code
    flat = ListedColormap([TYPES[Stability.UNSTABLE_NODE][1]])
    _fill(axes, drawing.raster, np.where(unstable, 1.0, np.nan), flat, FLAT)
    colored = np.where(np.isfinite(code) & ~unstable, values, np.nan)
    finite = colored[np.isfinite(colored)]
    low, high = ends or ((float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0))
    _fill(axes, drawing.raster, colored, colors, Normalize(low, high if high > low else low + 1.0))
    bar: Any = figure.colorbar(axes.images[-1], ax=axes, label=label)
    bar.solids.set_edgecolor("face")  # without it the page shines through between the strips of colour
    return figure, axes


def _margin(drawing: HeatMaps) -> Figure:
    axes_of = dict(zip(drawing.plan.names, (drawing.raster.x, drawing.raster.y[:, None]), strict=True))
    restitution = restitution_at(drawing.plan, axes_of)
    shares = drawing.raster.columns["multiplier_margin"] / largest_margin(restitution)
    determinant = "(r_bottom r_top)²" if isinstance(restitution, Restitutions) else "r⁴"
    label = f"1 − |tr|/(1 + {determinant}) [%]"
    figure, axes = _of_stable(drawing, 100 * shares, "viridis", label, (0.0, 100.0))
    return _finished(figure, axes, drawing, _types(drawing, Stability.UNSTABLE_NODE))


def _voltage(drawing: HeatMaps) -> Figure:
    volts = drawing.raster.columns["u_ave_v"]
    power = prefix([volts])
    figure, axes = _of_stable(drawing, volts / 10.0**power, "cividis", f"Uₐᵥₑ [{PREFIXES[power]}V]")
    return _finished(figure, axes, drawing, _types(drawing, Stability.UNSTABLE_NODE))


def _from_rest(drawing: HeatMaps) -> Figure:
    code = drawing.raster.columns["from_rest"]
    figure, axes = _panel(drawing)
    colors = ListedColormap([OUTCOMES[outcome][1] for outcome in DESTINATIONS])
    _fill(axes, drawing.raster, code, colors, Normalize(-0.5, len(DESTINATIONS) - 0.5))
    areas = [
        Area(OUTCOMES[outcome][0], Pixel.like(OUTCOMES[outcome][1]), code == k)
        for k, outcome in enumerate(DESTINATIONS)
        if (code == k).any()
    ]
    # A stable motion that is not reached is where a design may seem good and is not.
    note = drawing.said("missed", drawing.findings) if drawing.findings.missed else ""
    return _finished(figure, axes, drawing, areas, note)


def _shock(drawing: HeatMaps) -> Figure:
    columns = drawing.raster.columns
    jump, searched, code = columns["least_jump_m_s"], columns["jump_searched_to_m_s"], columns["stability"]
    power = prefix([jump])
    figure, axes = _of_stable(drawing, jump / 10.0**power, "viridis", f"least shock [{PREFIXES[power]}m/s]")
    stable = np.isfinite(code) & (code != Stability.UNSTABLE_NODE.code)
    flat = ((np.isnan(jump) & np.isfinite(searched), NONE_FOUND), (stable & np.isnan(searched), NOT_TOLD))
    areas = _types(drawing, Stability.UNSTABLE_NODE)
    for cells, (words, color) in flat:
        if cells.any():
            _fill(axes, drawing.raster, np.where(cells, 1.0, np.nan), ListedColormap([color]), FLAT)
            areas.append(Area(words, color, cells))
    return _finished(figure, axes, drawing, areas)


DRAWN = {
    "map-stability": _stability,
    "map-margin": _margin,
    "map-voltage": _voltage,
    "map-from-rest": _from_rest,
    "map-shock": _shock,
}


def _panel(drawing: HeatMaps, scale_width: float = 0.0) -> tuple[NotebookFigure, Axes]:
    """A figure with the axes of a map."""
    figure, axes = plane_panel(drawing.plane, scale_width)
    axes.patch.set(**NO_CELL)
    return figure, axes


def _fill(axes: Axes, raster: Raster, values: Floats, colors: str | ListedColormap, scale: Normalize) -> None:
    """Colour the cells that have a value, by its place on a scale of colours."""
    i, j = np.argsort(raster.x), np.argsort(raster.y)
    masked = np.ma.masked_invalid(values[np.ix_(j, i)])
    axes.pcolorfast(*raster.edges, masked, cmap=colors, norm=scale, zorder=0.5)


def _edges(values: Floats) -> Floats:
    """Borders between cells: half way between their values."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = (values[1:] + values[:-1]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def _finished(figure: NotebookFigure, axes: Axes, drawing: HeatMaps, types: Sequence[Area], note: str = "") -> Figure:
    """Draw the curves, white under each so that it shows on any colour, and the design point; name what there is.

    Parameters
    ----------
    figure : NotebookFigure
    axes : Axes
    drawing : HeatMaps
    types : sequence of Area
        Of cells of one colour.
    note : str
        A warning over the figure.
    """
    plane = drawing.plane
    for locus in drawing.loci:
        if locus.event is not Event.NODE_FOCUS:
            axes.plot(*locus.points.T, color=Color.WHITE, linewidth=HALO, zorder=2.0, solid_capstyle="round")
        look: Look = {"linewidth": LINE, "zorder": 2.5} | LOCI[locus.event][1]
        axes.plot(*locus.points.T, **look)
    axes.set(xlim=(plane.low[0], plane.high[0]), ylim=(plane.low[1], plane.high[1]))
    paper = paper_of(axes)
    for locus in drawing.loci:
        paper.draw(locus.points)
    entries = mark_on_plane(paper, plane, drawing.design, drawing.said, on_pixels=True, bbox=OVER_CELLS)
    for area in types:
        if not paper.name(_pixels(drawing, area.cells), area.name, every=False, color=area.ink):
            entries.append((area.name, OF_CELLS | {"color": area.color}))
    drawn = {locus.event for locus in drawing.loci}
    entries += [(of, {"linewidth": LINE} | look) for kind, (of, look) in LOCI.items() if kind in drawn]
    return plane_finished(figure, [entries], note)


def _pixels(drawing: HeatMaps, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Some cells, of shape (len(y), len(x)), on a grid over the panel: from left to right, and upwards in a column."""
    raster, place = drawing.raster, []
    middles = drawing.plane.centres((PIXELS, PIXELS))
    for values, edges, at in zip((raster.x, raster.y), raster.edges, middles, strict=True):
        cell = np.clip(np.searchsorted(edges, at) - 1, 0, len(values) - 1)
        place.append(np.argsort(values)[cell])
    return np.asarray(cells[np.ix_(place[1], place[0])].T)


class DrawnLocus(Struct, frozen=True, eq=False):
    """A curve in the plane of a map's two axes, (n, 2), and what happens on it."""

    event: Event
    points: Floats


def loci_of(plan: MapPlan, plane: Plane) -> tuple[DrawnLocus, ...]:
    """Every curve on a map over two parameters, of a grid.

    The ball's mass has no part in the motions: over it, curves are straight.
    """
    low, high = plane.low, plane.high
    at = {name: value for name, value in zip(plan.names, low.tolist(), strict=True) if name != "ball_mass_kg"}
    device = plan.device.with_values(at)
    first, second = plane.inputs
    if isinstance(first, DesignInput) and isinstance(second, DesignInput):
        if DesignInput.RESTITUTION in plane.inputs and first in RESTITUTIONS and second in RESTITUTIONS:
            return ()  # the inputs overlap: a restitution of both is no place beside that of one
        drawn = loci_over(DevicePlane((first, second), low, high, device), Limits(2, device.period_ratio), cuts=0)
        return tuple(DrawnLocus(locus.event, locus.drawn()) for locus in drawn.loci)
    k = int(isinstance(first, DesignInput))
    parameter = next((varied for varied in DRIVING if varied.value == plan.names[1 - k]), None)
    if parameter is None:
        return ()
    sweep = Sweep(device, parameter, float(low[1 - k]), float(high[1 - k]))
    values = ((point.event, point.sweep_value) for point in solve(sweep).critical_points)
    lines = ((event, np.insert(np.full((2, 1), value), k, (low[k], high[k]), axis=1)) for event, value in values)
    return tuple(DrawnLocus(event, points) for event, points in lines)
