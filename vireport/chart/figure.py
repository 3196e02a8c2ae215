"""The figure of a chart: its loci, the words that are stable between them, and the points where loci meet."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from vireport.chart.chart import Chart
from vireport.chart.network import FollowedLocus
from vireport.figures import (
    DOTTED,
    HALO,
    LOCI,
    Color,
    Entry,
    Label,
    Look,
    Picture,
    blank,
    finished,
    round_ticks,
    style,
)
from vireport.motions import Event

Floats = NDArray[np.float64]

HEIGHT, ACROSS = 5.4, 5.75
"""Height of the panel with its axes, and its width for the choice of ticks [in]."""

PIXELS = 240
"""Side of the raster, along either axis, on which regions are told apart."""

ROOM, LETTERS, APART = 7.0, 5, 2.0
"""Distance [pixels] to the nearest curve that a region's label of so many letters needs; and the one that a place needs
to be within its region for certain, as pixels do not part curves that are next to each other."""

BETWEEN: Look = {"linewidth": 0.5, "alpha": 0.6}
"""Look of curves where no stable motion ends."""

MEETING: Look = {"linestyle": "none", "marker": "o", "markersize": 3.2, "color": Color.BLACK, "zorder": 3.0}


def picture(chart: Chart, caption: str) -> Picture:
    """Draw the figure of a chart under a caption."""
    plane = chart.plane
    with style():
        figure, ((axes,),) = blank(1)
        axes.set(xlim=(plane.low[0], plane.high[0]), ylim=(plane.low[1], plane.high[1]))
        for locus in chart.loci:
            _draw(axes, locus)
        for x, y, words in _regions(chart):
            box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
            axes.text(x, y, words, ha="center", va="center", size="small", color=Color.BLUE, bbox=box, zorder=2.8)
        points = np.array([point.inputs for point in chart.meetings]).reshape(-1, 2)
        axes.add_artist(Line2D(*points.T, **MEETING))
        labels = [Label(str(number), point[:1], point[1:], 6.5) for number, point in enumerate(points, 1)]
        for axis, k in ((axes.xaxis, 0), (axes.yaxis, 1)):
            varied = plane.inputs[k]
            axis.set_ticks(*round_ticks(float(plane.low[k]), float(plane.high[k]), (ACROSS, HEIGHT)[k]))
            axis.set_label_text(f"{varied.quantity} {varied.symbol} [{varied.unit or '–'}]")
        lines = [("blue: words of the stable motions (B bottom, T top); – where none was found", Color.BLUE)]
        drawn = finished(figure, HEIGHT, lines, [_legend(chart)], [(axes, labels)])
    return Picture("figure-chart", "Chart", caption, caption, drawn)


def _draw(axes: Axes, locus: FollowedLocus) -> None:
    """A locus, strong where stable motion ends on it."""
    p, strong = _pieces(locus)
    look = LOCI[locus.event][1]
    breaks = [0, *(np.flatnonzero(np.diff(strong)) + 1).tolist(), len(strong)]
    for first, last in pairwise(breaks):
        rows = p[first : last + 1]
        if strong[first]:
            axes.add_artist(Line2D(*rows.T, color="white", linewidth=HALO, zorder=2.0))
            axes.add_artist(Line2D(*rows.T, linewidth=1.3, zorder=2.5, **look))
        else:
            axes.add_artist(Line2D(*rows.T, zorder=1.8, **look | BETWEEN))


def _legend(chart: Chart) -> list[Entry]:
    drawn = {locus.event for locus in chart.loci}
    entries: list[Entry] = [(name, {"linewidth": 1.3} | look) for kind, (name, look) in LOCI.items() if kind in drawn]
    faint: list[Entry] = [("of unstable motions", {"color": Color.PURPLE, "linestyle": DOTTED} | BETWEEN)]
    marks: list[Entry] = [("points of the table", MEETING)]
    unstable = any(locus.event is Event.GRAZING and not locus.bounds_stability.all() for locus in chart.loci)
    return entries + faint * unstable + marks * bool(chart.meetings)


def _regions(chart: Chart) -> Iterator[tuple[float, float, str]]:
    """Where there is most room in each region that a sweep crosses, and the words that are stable there."""
    from scipy.ndimage import distance_transform_edt, label  # type: ignore[import-untyped]

    free = np.ones((PIXELS, PIXELS), dtype=bool)
    for locus in chart.loci:
        p, strong = _pieces(locus)
        share = (p - chart.plane.low) / chart.plane.widths
        for first, last in zip(share[:-1][strong], share[1:][strong], strict=True):
            i, j = _pixels(np.linspace(first, last, int(2 * PIXELS * np.abs(last - first).max()) + 2)).T
            free[i, j] = False
    regions, _ = label(free)
    room = distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1]
    labelled = set()
    for line, low, high, words in ((cut.line, *part) for cut in chart.cuts for part in cut.stable):
        share = (np.insert([line.other], line.varied, (low + high) / 2) - chart.plane.low) / chart.plane.widths
        at, text = tuple(_pixels(share)), ", ".join(words) or "–"
        own = np.where(regions == regions[at], room, 0.0)
        if room[at] > APART and regions[at] not in labelled and own.max() > ROOM * max(1, len(text) / LETTERS):
            labelled.add(regions[at])
            place = (np.array(np.unravel_index(own.argmax(), own.shape)) + 0.5) / PIXELS
            yield *(chart.plane.low + place * chart.plane.widths), text


def _pieces(locus: FollowedLocus) -> tuple[Floats, NDArray[np.bool_]]:
    """A locus as drawn, and whether stable motion ends on each of its pieces."""
    p = locus.drawn()
    return p, np.repeat(locus.bounds_stability, (len(p) - 1) // (len(locus.x) - 1))


def _pixels(share: Floats) -> NDArray[np.intp]:
    return np.clip((share * PIXELS).astype(np.intp), 0, PIXELS - 1)
