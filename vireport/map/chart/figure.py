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

from vireport.figures.alongside import Paper, around
from vireport.figures.captions import held_by
from vireport.figures.layout import Entry
from vireport.figures.style import FILLS, LOCI, Color, Look, Picture, sheet, style
from vireport.map.chart.chart import Chart
from vireport.map.chart.opening import design_ends
from vireport.map.chart.regions import PIXELS, Kinds, Regions, RegionSet, block, pieces
from vireport.map.chart.words import Naming, naming
from vireport.map.figure import mark_on_plane, paper_of, plane_finished, plane_panel
from vireport.motions.events import Event
from vireport.text.templates import Words

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

SMOOTH = 0.7
"""How far [pixels] the outline of a region may be from its pixels."""

NEAR = 2 / PIXELS
"""Share of a range within which a point lies on a curve."""

WIDE = 4.0
"""Width of the panel from which what is not stable has a longer name [in]."""

SHORT = 1.2
"""Length of a curve over that of its name from which it has one."""

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
    colors = iter(FILLS)
    return tuple(
        (region_set, next(colors, OTHER_SETS) if region_set.kinds else OTHER_SETS if region_set.kinds is None else None)
        for region_set in chart.regions.sets
    )


def picture(chart: Chart, templates: FilePath | None = None) -> Picture:
    """Draw the figure of a chart, with its words."""
    said = Words("chart", templates)
    named = naming(chart, templates)
    caption = said("caption", chart, bool(named.ambiguous), held_by(chart.plane.device, chart.plane.inputs))
    if not sheet().headed:  # a paper has no table of the bands
        caption = f"{caption} {said('narrow_note', chart.narrow, chart.unmeasured, chart.plane.inputs)}".rstrip()
    shares = [said("share", named.long(part.kinds, chart.limits), part.share) for part in chart.regions.sets]
    ends = [end.said.words(templates) for end in design_ends(chart, named)]
    alt = said("alt", chart.plane, shares, ends)
    return Picture("figure-chart", said("title"), caption, alt, _drawn(chart, templates))


def _drawn(chart: Chart, templates: FilePath | None) -> Figure:
    plane, named, colors, said = chart.plane, naming(chart, templates), colored(chart), Words("chart", templates)
    with style():
        figure, axes = plane_panel(plane)
        _fill(axes, chart.regions, colors)
        paper = paper_of(axes)
        _draw_curves(paper, chart)
        points = _numbered(chart)
        axes.add_artist(Line2D(*points.T, **MEETING))
        marked = mark_on_plane(paper, plane, chart.design, Words("map", templates))
        areas = _names(paper, chart, colors, named, said)
        curves = _named_curves(paper, chart)
        if sheet().headed:
            for number, point in zip(_numbers(chart), points, strict=True):
                paper.write(str(number), around(paper.inches(point), str(number)))
        unnamed = tuple((part, color) for part, color in colors if part.kinds not in areas)
        names, bands = _legend(chart, unnamed, named, said, curves)
        # In one line where there is room.
        legends = [[*names, *marked, *bands]] if sheet().headed else [[*names, *marked], bands]
        return plane_finished(figure, legends)


def _fill(axes: Axes, regions: Regions, colors: Colored) -> None:
    """Fill the regions of a chart with the colours of their motions."""
    # Beyond the frame, which cuts it, the outermost pixels go on.
    at = np.arange(-0.5, PIXELS + 1)
    for region_set, color in colors:
        if color is None:
            continue
        pixels = np.pad(regions.within(region_set), 1, mode="edge")
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


def _draw_curves(paper: Paper, chart: Chart) -> None:
    """Draw the loci of critical points as lines with names."""
    for locus, edges in zip(chart.loci, chart.regions.edges, strict=True):
        points, bounds = pieces(locus)
        for part, look, thin in ((edges, LOCI[locus.event][1] | EDGE, False), (bounds & ~edges, BAND, True)):
            for rows in _runs(part):
                paper.axes.add_artist(Line2D(*points[rows].T, **look))
                paper.draw(points[rows], thin)


def _named_curves(paper: Paper, chart: Chart) -> set[Event]:
    """Write the name of each locus that parts regions along it, of the longest first; the events that have one.

    A curve without a clear place has none: others of its look have.
    """
    candidates: list[tuple[float, str, Floats, Event]] = []
    for locus, edges in zip(chart.loci, chart.regions.edges, strict=True):
        points = pieces(locus)[0]
        for rows in _runs(edges):
            length = float(np.hypot(*np.diff(paper.inches(points[rows]), axis=0).T).sum())
            candidates.append((length, f"{locus.event.words} of {locus.word}", points[rows], locus.event))
    named_words: set[str] = set()
    events: set[Event] = set()
    for length, text, points, event in sorted(candidates, key=lambda candidate: -candidate[0]):
        if text in named_words or length < SHORT * len(text) * sheet().letter:
            continue
        color = Color.WARNING if event is Event.FOLD else Color.BLACK
        if paper.write(text, paper.near_curve(points, text), color=color):
            named_words.add(text)
            events.add(event)
    return events


def _runs(part: Mask) -> Iterator[slice]:
    """The points of each run of pieces that are in a part."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], part, [False]])))
    for first, after in zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True):
        yield slice(first, after + 1)


def _names(paper: Paper, chart: Chart, colors: Colored, named: Naming, said: Words) -> set[Kinds | None]:
    """Write what is stable in each part of the plane that has room; what has a name."""
    regions = chart.regions
    parted = np.ones((PIXELS, PIXELS), dtype=bool)
    for locus, edges in zip(chart.loci, regions.edges, strict=True):
        block(parted, regions.plane.shares(pieces(locus)[0]), edges)
    nothing = said("nothing") if paper.size[0] > WIDE else named.short(())
    return {
        region_set.kinds
        for region_set, _ in colors
        if paper.name(
            regions.within(region_set) & parted,
            nothing if region_set.kinds == () else named.short(region_set.kinds),
            weight="bold" if region_set.kinds else "normal",
        )
    }


def _numbers(chart: Chart) -> list[int]:
    """The numbers in the table of the points where curves meet on which regions end."""
    on = [pieces(locus)[0][:-1][edges] for locus, edges in zip(chart.loci, chart.regions.edges, strict=True)]
    ends = np.concatenate([np.empty((0, 2)), *on])
    return [
        number
        for number, point in enumerate(chart.meetings, 1)
        if len(ends) and (np.abs((ends - point.inputs) / chart.plane.widths) < NEAR).all(axis=1).any()
    ]


def _numbered(chart: Chart) -> Floats:
    return np.array([chart.meetings[number - 1].inputs for number in _numbers(chart)]).reshape(-1, 2)


def _legend(
    chart: Chart, unnamed: Colored, named: Naming, said: Words, events: set[Event]
) -> tuple[list[Entry], list[Entry]]:
    """What colours, curves and marks mean but for areas and events with a name in the figure, and the thin lines."""
    entries: list[Entry] = [
        (named.long(region_set.kinds, chart.limits), AREA | {"markerfacecolor": color or Color.WHITE})
        for region_set, color in unnamed
        if color != OTHER_SETS
    ]
    if any(color == OTHER_SETS for _, color in unnamed):
        entries.append(
            (said("others_in_table" if sheet().headed else "others"), AREA | {"markerfacecolor": OTHER_SETS})
        )
    bounds = [pieces(locus)[1] for locus in chart.loci]
    drawn = {locus.event for locus, edge in zip(chart.loci, chart.regions.edges, strict=True) if edge.any()}
    entries += [(name, EDGE | look) for kind, (name, look) in LOCI.items() if kind in drawn and kind not in events]
    if _numbers(chart):
        entries.append((said("meeting_in_table" if sheet().headed else "meeting"), MEETING))
    words = list(dict.fromkeys([*(band.word for band in chart.narrow), *chart.unmeasured]))
    hidden = any((ending & ~edge).any() for ending, edge in zip(bounds, chart.regions.edges, strict=True))
    return entries, [(said("band", words) if words else said("band_alike"), BAND)] if hidden else []
