"""The figure of a chart: regions filled by what is stable there, the loci between them, and the design point.

Fills are outlines of the pixels of regions, smoothed by less than the width of the curves that are drawn over them.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from vireport.chart.chart import Chart
from vireport.chart.design import ChartMargin
from vireport.chart.regions import PIXELS, RegionSet, block, pieces, pixel
from vireport.chart.words import Naming, naming, words_given
from vireport.figures.captions import held_by
from vireport.figures.labels import Label
from vireport.figures.layout import Entry, blank, finished, round_ticks
from vireport.figures.planes import DESIGN, mark_design
from vireport.figures.style import FILLS, LOCI, PER_LETTER, Color, Look, Picture, sheet, style
from vireport.motions.events import Event
from vireport.text.formatting import MINUS
from vireport.wording.templates import Words

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

HEIGHT = 5.0
"""Height of the panel with its axes, at the width of a report's figures [in]."""

SMOOTH = 0.7
"""How far [pixels] the outline of a region may be from its pixels."""

TEXT_ROOM = 0.7
"""Part of the room around a point that the name of a region may fill, so that it stays clear of the curves."""

NAMED_FROM = 5.0
"""Width of the panel from which curves have names: on a narrower one they would lie on other curves [in]."""

CLEAR = 4.0
"""Heights of its letters by which all other curves are away where the name of a curve stands."""

STATIONS = 24
"""Places along a curve at which its name is tried, where it is as long as that."""

OTHER_SETS = Color.LIGHT
"""Fill of what is stable in regions beyond the colours that there are, and where rounding does not resolve motions."""

EDGE: Look = {"linewidth": 1.4, "zorder": 2.5}
"""Look of curves on whose two sides what is stable differs."""

BAND: Look = {"color": Color.GREY, "linewidth": 0.5, "zorder": 1.9}
"""Look of curves on which a stable motion ends, but which bound a band too narrow to be seen."""

MEETING: Look = {"linestyle": "none", "marker": "o", "markersize": 3.0, "color": Color.BLACK, "zorder": 3.0}

AREA: Look = {
    "linestyle": "none", "marker": "s", "markersize": 7.5, "markeredgecolor": Color.GREY, "markeredgewidth": 0.5,
}  # fmt: skip
"""Look of a fill in the legend."""


Colored = tuple[tuple[RegionSet, str | None], ...]
"""Sets of regions with their colours; None is that of the paper."""


def colored(chart: Chart) -> Colored:
    """The sets of regions of a chart with their colours."""
    colors, sets = iter(FILLS), chart.regions.sets if chart.regions is not None else ()
    return tuple(
        (own, next(colors, OTHER_SETS) if own.kinds else OTHER_SETS if own.kinds is None else None) for own in sets
    )


def picture(chart: Chart, templates: FilePath | None = None) -> Picture:
    """Draw the figure of a chart, with its words."""
    said = Words("chart", templates)
    named = naming(chart, templates)
    given = words_given(chart, named)
    caption = said("caption", given) if sheet().headed else f"{said('caption', given)} {_note(chart, said)}".rstrip()
    return Picture("figure-chart", said("title"), caption, said("alt", given), _drawn(chart, templates))


def _note(chart: Chart, said: Words) -> str:
    return said("narrow_note", chart.narrow, chart.unmeasured, chart.plane.inputs)


def _drawn(chart: Chart, templates: FilePath | None) -> Figure:
    plane, named, shown = chart.plane, naming(chart, templates), colored(chart)
    with style():
        figure, ((axes,),) = blank(1)
        axes.set(xlim=(plane.low[0], plane.high[0]), ylim=(plane.low[1], plane.high[1]))
        width, height = sheet().across, HEIGHT * min(1.0, sheet().width / 5)
        for axis, k, room in ((axes.xaxis, 0, width), (axes.yaxis, 1, height)):
            varied = plane.inputs[k]
            axis.set_ticks(*round_ticks(float(plane.low[k]), float(plane.high[k]), room))
            axis.set_label_text(f"{varied.quantity} {varied.symbol} [{varied.unit or '–'}]")
        _fill(axes, chart, shown)
        labels = list(_curves(axes, chart, (width, height)))
        # The design point comes first: what is written on it has the best of the places.
        labels = [*_design(axes, chart), *labels]
        _names(axes, chart, shown, named, (width, height))
        points = np.array([point.inputs for point in chart.meetings]).reshape(-1, 2)
        axes.add_artist(Line2D(*points.T, **MEETING))
        said = Words("chart", templates)
        note = _note(chart, said)
        lines = [(", ".join(held_by(plane.device, plane.inputs)), Color.BLACK)]
        # In the column of a paper there is no table that numbers could refer to, and its caption has the note.
        if sheet().headed:
            labels += [Label(str(n), point[:1], point[1:], sheet().small) for n, point in enumerate(points, 1)]
            lines += [(note, Color.GREY)] if note else []
        return finished(figure, height, lines, list(_legends(chart, shown, named, said)), [(axes, labels)])


def _fill(axes: Axes, chart: Chart, shown: Colored) -> None:
    """Colour the regions."""
    regions = chart.regions
    if regions is None:
        return
    # Beyond the frame, which cuts it, the outermost pixels go on.
    at = np.arange(-0.5, PIXELS + 1)
    for own, color in shown:
        if color is None:
            continue
        pixels = np.pad(regions.within(own), 1, mode="edge")
        outlines = axes.contourf(at, at, pixels.T.astype(float), levels=[0.5, 1.5])
        loops = [loop for path in outlines.get_paths() for loop in path.to_polygons(closed_only=False)]
        outlines.remove()
        smooth = [_smoothed(np.asarray(loop)) for loop in loops]
        if smooth:
            path = Path.make_compound_path(*smooth)
            path.vertices = regions.plane.low + regions.plane.widths * np.asarray(path.vertices) / PIXELS
            axes.add_patch(PathPatch(path, facecolor=color, edgecolor="none", linewidth=0.0, zorder=0.5))


def _smoothed(loop: Floats) -> Path:
    """A closed outline with as few points as it takes."""
    path = Path(loop)
    path.simplify_threshold = SMOOTH
    kept = path.cleaned(simplify=True)
    points = np.asarray(kept.vertices)[np.asarray(kept.codes) != Path.STOP]
    codes = [Path.MOVETO, *[Path.LINETO] * (len(points) - 1), Path.CLOSEPOLY]
    return Path(np.concatenate([points, points[:1]]), codes)


def _curves(axes: Axes, chart: Chart, size: tuple[float, float]) -> Iterator[Label]:
    """Draw the loci, and give the names of those that part regions, longest first.

    A curve has its name where no other is so near that it could be taken for that one's, and none without such a place.
    """
    named: list[tuple[float, Label]] = []
    parts = [(*pieces(locus), edges) for locus, edges in zip(chart.loci, _edges(chart), strict=True)]
    drawn = [_inches(chart, points[1:][bounds | edges], size) for points, bounds, edges in parts]
    apart = CLEAR * sheet().small / 72
    for number, (locus, (points, bounds, edges)) in enumerate(zip(chart.loci, parts, strict=True)):
        for part, look in ((edges, LOCI[locus.event][1] | EDGE), (bounds & ~edges, BAND)):
            for rows in _runs(part):
                axes.add_artist(Line2D(*points[rows].T, **look))
        length = float(np.hypot(*np.diff(_inches(chart, points, size), axis=0).T)[edges].sum())
        text = f"{locus.event.words} of {locus.word}"
        if size[0] > NAMED_FROM and length > len(text) * sheet().letter:
            places = (points[1:] + points[:-1])[edges] / 2
            places = places[np.linspace(0, len(places) - 1, STATIONS + 2).astype(int)[1:-1]]
            others = np.concatenate([np.empty((0, 2)), *drawn[:number], *drawn[number + 1 :]])
            away = np.hypot(*(_inches(chart, places, size)[:, None] - others).T).min(axis=0, initial=np.inf)
            places = places[away > apart]
            if not len(places):
                continue
            # From the middle on: an end of a curve is where others are.
            order = np.argsort(np.abs(np.arange(len(places)) - len(places) / 2), kind="stable")
            color = Color.WARNING if locus.event is Event.FOLD else Color.BLACK
            named.append((length, Label(text, places[order, 0], places[order, 1], sheet().small, color)))
    yield from (label for _, label in sorted(named, key=lambda each: -each[0]))


def _edges(chart: Chart) -> list[Mask]:
    """Of each locus the pieces on whose two sides what is stable differs, as far as regions are known."""
    return [pieces(locus)[1] for locus in chart.loci] if chart.regions is None else list(chart.regions.edges)


def _inches(chart: Chart, points: Floats, size: tuple[float, float]) -> Floats:
    """Places on the paper [in] of points of the plane."""
    return np.asarray(size) * (points - chart.plane.low) / chart.plane.widths


def _runs(part: Mask) -> Iterator[slice]:
    """The points of each run of pieces that are in a part."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], part, [False]])))
    for first, after in zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True):
        yield slice(first, after + 1)


def _names(axes: Axes, chart: Chart, shown: Colored, named: Naming, size: tuple[float, float]) -> None:
    """Write what is stable in the middle of the widest place of each part of the plane that has room."""
    from scipy.ndimage import distance_transform_edt, label  # type: ignore[import-untyped]

    regions = chart.regions
    if regions is None:
        return
    free = np.ones((PIXELS, PIXELS), dtype=bool)
    for locus, edges in zip(chart.loci, regions.edges, strict=True):
        block(free, regions.plane.shares(pieces(locus)[0]), edges)
    design = chart.design
    if design is not None:  # whose bars no name shall lie on
        at = np.array(design.inputs)
        for margin in design.margins:
            end = at.copy()
            end[margin.varied] = margin.value
            first, last = regions.plane.shares([at, end])
            free[tuple(pixel(np.linspace(first, last, 2 * PIXELS)).T)] = False
        free[tuple(pixel(regions.plane.shares(at)))] = False
    inch = np.array(size) / PIXELS
    for own, color in shown:
        text, big, pixels = named.short(own.kinds), sheet().text, regions.within(own) & free
        half = np.array([len(text) * PER_LETTER * big, big]) / 72 / 2
        parts, count = label(pixels)
        # Distances over the half sides of the text, so that a long name takes a wide place.
        room = distance_transform_edt(np.pad(pixels, 1), sampling=inch / half)[1:-1, 1:-1]
        sizes = np.bincount(parts.ravel(), minlength=count + 1)[1:]
        for k in (np.argsort(-sizes, kind="stable") + 1).tolist():
            inside = np.where(parts == k, room, 0.0)
            place = np.unravel_index(int(inside.argmax()), inside.shape)
            x, y = (regions.plane.low + regions.plane.widths * (np.array(place) + 0.5) / PIXELS).tolist()
            if inside[place] * TEXT_ROOM > 1:
                box = {"facecolor": color or Color.WHITE, "edgecolor": "none", "pad": 1.0}
                axes.text(x, y, text, ha="center", va="center", size=big, weight="bold", bbox=box, zorder=2.2)


def _design(axes: Axes, chart: Chart) -> Iterator[Label]:
    """Draw the design point with its margins, and give what is written on them."""
    design = chart.design
    if design is None:
        return
    at = np.array(design.inputs)
    ends = mark_design(axes, design.inputs, ((margin.varied, margin.value) for margin in design.margins))
    if sheet().headed:  # in a column the legend says it
        yield Label("design point", at[:1], at[1:], sheet().small)
    for margin, end in zip(design.margins, ends, strict=True):
        x, y = (at + (np.array(end) - at) * np.array([[0.5], [0.7], [0.3]])).T
        yield Label(margin_text(chart, margin), x, y, sheet().small)


def margin_text(chart: Chart, margin: ChartMargin) -> str:
    """A margin with its sign and unit."""
    size = chart.plane.inputs[margin.varied].show(abs(margin.distance))
    return f"{'+' if margin.distance > 0 else MINUS}{size}"


def _legends(chart: Chart, shown: Colored, named: Naming, said: Words) -> Iterator[list[Entry]]:
    """What colours, curves and marks mean, each that is drawn and no other."""
    areas: list[tuple[RegionSet, Entry]] = [
        (own, (named.long(own.kinds, chart.limits), AREA | {"markerfacecolor": color or Color.WHITE}))
        for own, color in shown
        if color != OTHER_SETS
    ]
    yield [entry for own, entry in areas if own.kinds]
    others: list[Entry] = [(said("others", sheet().headed), AREA | {"markerfacecolor": OTHER_SETS})]
    yield [entry for own, entry in areas if not own.kinds] + others * any(color == OTHER_SETS for _, color in shown)
    bounds, edges = [pieces(locus)[1] for locus in chart.loci], _edges(chart)
    drawn = {locus.event for locus, own in zip(chart.loci, edges, strict=True) if own.any()}
    yield [(name, EDGE | look) for kind, (name, look) in LOCI.items() if kind in drawn]
    pairs = list(zip(bounds, edges, strict=True))
    thin: list[Entry] = [(said("band"), BAND)] if any((own & ~edge).any() for own, edge in pairs) else []
    thin += [(said("meeting", sheet().headed), MEETING)] if chart.meetings else []
    thin += [(said("design_margins"), DESIGN | {"markersize": 6.0})] if chart.design is not None else []
    yield thin
