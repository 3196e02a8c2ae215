"""Draws what comes from simulation alone: phase portraits and displacements."""

from __future__ import annotations

from collections.abc import Sequence
from string import ascii_lowercase
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vireport.figures.axes import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LETTERS_ALONG,
    LIGHT,
    SMALL,
    VERMILION,
    style,
    widened,
)
from vireport.figures.curves import Floats
from vireport.figures.diagrams import figure_diagram as figure_diagram
from vireport.figures.drawing import GUIDE, Look
from vireport.figures.panel import Panel
from vireport.figures.sheet import ACROSS, BOTTOM, LEFT, ROW, WIDTH, Entry, Page, Place, blank, wrapped
from vireport.figures.ticks import fitting_ticks
from vireport.figures.traces import (
    arrivals,
    ball,
    bottom,
    capsule,
    even_times,
    flights,
    motion_words,
    moves,
    periods,
    rebounds,
    rides,
    setting,
)

if TYPE_CHECKING:
    from vireport.simulation import Portrait

Rows = Sequence["Portrait"]
Samples = NDArray[np.intp]

LEFT_COLUMN, RIGHT_COLUMN = (LEFT, 2.4), (LEFT + 2.4 + 0.56, ACROSS - 2.4 - 0.56)
"""Left ends and widths of figure 3's panels [in]."""

TITLE, UNDER = 0.22, 0.22
"""Heights of the line over a row of panels, and of the tick labels under it [in]."""

HIGHEST = 7.2
"""A figure of many rows becomes no higher, if its panels need not be lower than `PANEL[0]` [in]."""

PANEL = 0.42, 1.75
"""Least and largest height of a panel [in]."""

TIME = "time t [forcing periods]"
NOTHING_TO_SHOW = "no motion was asked for"

MOTION: Look = {"color": BLACK, "linewidth": 1.1, "zorder": 2.5}
JUMP: Look = {"color": GREY, "linewidth": 0.8, "linestyle": (0, (3, 2)), "zorder": 2.3}
WALL: Look = {"color": LIGHT, "linewidth": 3.6, "zorder": 1.2}
BOTTOM_MEMBRANE: Look = {"color": BLUE, "linewidth": 2.8, "zorder": 2.2}
TOP_MEMBRANE: Look = {"color": BLUE, "linewidth": 1.1, "zorder": 2.2}
BALL: Look = {"color": VERMILION, "linewidth": 1.4, "zorder": 2.5}
MARK: Look = {"linestyle": "none", "zorder": 3.5, "markeredgecolor": "white", "markeredgewidth": 0.5}
BOTTOM_IMPACT: Look = MARK | {"color": BLUE, "marker": "o", "markersize": 5.5}
TOP_IMPACT: Look = MARK | {"color": GREEN, "marker": "^", "markersize": 6.0}


def figure_3(portraits: Rows, held: str = "") -> Figure:
    """Phase portraits and time series of simulated motions, as in Fig. 3: a row for each.

    Parameters
    ----------
    portraits : sequence of Portrait
    held : str
        The parameters that they share, in words.
    """
    legend: list[Entry] = [
        ("impact, bottom", BOTTOM_IMPACT),
        ("impact, top", TOP_IMPACT),
        ("rebound Ż → −r Ż", JUMP),
        ("membrane", WALL),
    ]
    with style():
        page, bottoms, high = _rows(len(portraits), held, legend)
        for k, (portrait, low) in enumerate(zip(portraits, bottoms, strict=True)):
            last = k + 1 == len(portraits)
            left, right = ((x, low, across, high) for x, across in (LEFT_COLUMN, RIGHT_COLUMN))
            _title(page, left, 2 * k, setting(portrait))
            _title(page, right, 2 * k + 1, motion_words(portrait))
            _phase_portrait(page, left, portrait, last)
            _time_series(page, right, portrait, last)
        return page.figure


def figure_6(portraits: Rows, held: str = "") -> Figure:
    """Absolute displacement of the capsule's ends and of the ball, as in Fig. 6: a panel for each motion.

    Parameters are those of `figure_3`.
    """
    legend: list[Entry] = [
        ("top X + d/2", TOP_MEMBRANE),
        ("ball x", BALL),
        ("bottom X − d/2", BOTTOM_MEMBRANE),
        ("impact, bottom", BOTTOM_IMPACT),
        ("impact, top", TOP_IMPACT),
    ]
    with style():
        page, bottoms, high = _rows(len(portraits), held, legend)
        for k, (portrait, low) in enumerate(zip(portraits, bottoms, strict=True)):
            place = (LEFT, low, ACROSS, high)
            _title(page, place, k, f"{setting(portrait)}: {motion_words(portrait)}")
            _displacement(page, place, portrait, k + 1 == len(portraits))
        return page.figure


def _rows(count: int, held: str, legend: list[Entry]) -> tuple[Page, list[float], float]:
    """An empty page for rows of panels: where the panels stand, from the top one down, and their height."""
    lines = wrapped([legend])
    head = [(held, BLACK)] if held else []
    over = ROW * (len(head) + len(lines)) + 0.06
    rest = BOTTOM + over + count * TITLE + max(count - 1, 0) * UNDER
    high = float(np.clip((HIGHEST - rest) / max(count, 1), *PANEL))
    page_height = rest + max(count, 1) * high
    page = Page(blank(page_height), page_height)
    page.heading(head, lines)
    if not count:
        page.words(WIDTH / 2, page_height / 2, NOTHING_TO_SHOW, ha="center", va="center")
    step = high + TITLE + UNDER
    return page, [BOTTOM + (count - 1 - k) * step for k in range(count)], high


def _title(page: Page, place: Place, number: int, text: str) -> None:
    """Letter a panel, and write what is on it."""
    letter = ascii_lowercase[number % 26] * (number // 26 + 1)
    page.words(place[0], place[1] + place[3] + 0.05, f"({letter}) {text}", va="bottom", size=SMALL)


def _panel(
    page: Page,
    place: Place,
    x: tuple[float, float],
    y: tuple[float, float],
    labels: tuple[str | None, str],
    indent: float = 0.08,
) -> Panel:
    """A panel with ticks and labels on both its axes; the label of x may be left to the panel below."""
    panel = page.frame(place, x, y, first=True)
    letters = int(LETTERS_ALONG * place[2] / ACROSS)
    page.along_bottom(panel, place, fitting_ticks(*x, letters, max(2, int(place[2] / 0.45))), labels[0] or "")
    page.along_side(panel, place, fitting_ticks(*y, LETTERS_ALONG, max(3, int(place[3] / 0.22))))
    page.words(indent, place[1] + place[3] / 2, labels[1], rotation=90, ha="left", va="center")
    return panel


def _fitting(label: str, place: Place) -> str:
    """The label of an axis along the side, without its word where the panel is too low for that."""
    return label if 0.068 * len(label) < place[3] + TITLE else label.partition(" ")[2]


def _phase_portrait(page: Page, place: Place, portrait: Portrait, last: bool) -> None:
    z, v = portrait.position, portrait.velocity
    label = "relative position Z [–]" if last else None
    x, labels = widened(-portrait.d / 2, portrait.d / 2, 0.09), (label, _fitting("velocity Ż [–]", place))
    panel = _panel(page, place, x, _speeds(portrait), labels)
    panel.upright(np.array([-portrait.d / 2, portrait.d / 2]), **WALL)
    panel.level(0.0, **GUIDE)
    if not moves(portrait):
        return
    panel.curves([(z[rows], v[rows]) for rows in flights(portrait)], **MOTION)
    panel.curves([(z[[i, i]], v[[i, i + 1]]) for i in rebounds(portrait)], **JUMP)
    rows = arrivals(portrait)
    cycle = portrait.attractor.cycle
    rows = rows[-len(cycle.wall) :] if cycle is not None and not cycle.sticks else rows
    _impacts(panel, portrait, rows, z, v)
    panel.tag("bottom", portrait.d / 2)
    panel.tag("top", -portrait.d / 2)


def _time_series(page: Page, place: Place, portrait: Portrait, last: bool) -> None:
    t, v = periods(portrait.time), portrait.velocity
    y = _speeds(portrait)
    panel = _panel(page, place, _times(portrait), y, (TIME if last else None, "Ż [–]"), indent=place[0] - 0.50)
    if not moves(portrait):
        panel.say(portrait.attractor.outcome.value)
        return
    panel.level(0.0, **GUIDE)
    panel.curves([(t[rows], v[rows]) for rows in flights(portrait)], **MOTION)
    panel.curves([(t[[i, i + 1]], np.zeros(2)) for i in rides(portrait)], **MOTION)
    panel.curves([(t[[i, i]], v[[i, i + 1]]) for i in rebounds(portrait)], **JUMP)
    _impacts(panel, portrait, arrivals(portrait), t, v)


def _displacement(page: Page, place: Place, portrait: Portrait, last: bool) -> None:
    low, high = _times(portrait)
    time = even_times(2 * low, 2 * high)
    half, centre = portrait.d / 2, capsule(portrait, time)
    y = widened(float(centre.min()) - half, float(centre.max()) + half, 0.06)
    panel = _panel(page, place, (low, high), y, (TIME if last else None, _fitting("displacement X, x [–]", place)))
    panel.curves([(periods(time), centre - half)], **BOTTOM_MEMBRANE)
    panel.curves([(periods(time), centre + half)], **TOP_MEMBRANE)
    if not moves(portrait):
        if portrait.attractor.outcome.name == "REST":
            panel.curves([(periods(time), centre - half)], **BALL)
        return
    at, x = ball(portrait)
    panel.curves([(periods(at), x)], **BALL)
    where = capsule(portrait, portrait.time) - portrait.position
    _impacts(panel, portrait, arrivals(portrait), periods(portrait.time), where)


def _impacts(panel: Panel, portrait: Portrait, rows: Samples, x: Floats, y: Floats) -> None:
    """Mark impacts, those on the two membranes apart."""
    below = bottom(portrait)[rows]
    for chosen, look in ((rows[below], BOTTOM_IMPACT), (rows[~below], TOP_IMPACT)):
        panel.marks(x[chosen], y[chosen], **look)


def _times(portrait: Portrait) -> tuple[float, float]:
    """Range of the time axis [forcing periods]."""
    end = float(periods(portrait.time[-1])) if moves(portrait) else 2.0
    return widened(0.0, end, 0.02)


def _speeds(portrait: Portrait) -> tuple[float, float]:
    """Range of the axis of velocities."""
    v = portrait.velocity if moves(portrait) else np.array([-1.0, 1.0])
    return widened(min(float(v.min()), 0.0), max(float(v.max()), 0.0), 0.09)
