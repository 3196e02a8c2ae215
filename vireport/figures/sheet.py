"""A figure of stacked panels: every place on it is known before it is drawn; nothing is measured or moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vireport.figures.axes import BLACK, DPI, LETTERS_ALONG, SMALL, Along, style
from vireport.figures.lettering import Room
from vireport.figures.panel import Panel
from vireport.figures.pixels import png_of
from vireport.figures.ticks import fitting_ticks

TICK_RIGHT, TICK_UP, TICK_DOWN = 1, 2, 3
"""Markers of matplotlib."""

Entry = tuple[str, dict[str, Any]]
"""Of a legend: a name, and the look of its line or marker."""

WIDE = set("BT~")
"""Letters of the words of motions, which are wider than others."""

Place = tuple[float, float, float, float]
"""Of a panel: left, bottom, width, height [in]."""

Ticks = tuple[Sequence[float], Sequence[str]]
"""Values and labels."""

WIDTH = 6.7
"""Of a sheet [in]: the text of an A4 page."""

LEFT, RIGHT, BOTTOM, BETWEEN = 0.78, 0.14, 0.46, 0.13
"""Margins of a sheet, and the gap between its panels [in]."""

ACROSS = WIDTH - LEFT - RIGHT
"""Width of a panel [in]."""

ROW, TOP_AXIS = 0.20, 0.46
"""Height of a line of text above the panels, and of the axis along their top [in]."""


class ShownFigure(Figure):
    """A figure that a notebook shows as it would be written to a file, without pyplot."""

    def _repr_png_(self) -> bytes:
        with style():
            return png_of(self)[0]


@dataclass(frozen=True, slots=True)
class Page:
    """A figure on which every place is given in inches from the lower left corner.

    Attributes
    ----------
    figure : Figure
    height : float
        [in]
    """

    figure: Figure
    height: float

    def frame(self, place: Place, x: tuple[float, float], y: tuple[float, float], first: bool) -> Panel:
        """An empty panel with limits; its axes are bare."""
        left, bottom, across, high = place
        rectangle = (left / WIDTH, bottom / self.height, across / WIDTH, high / self.height)
        axes = self.figure.add_axes(rectangle, xlim=x, ylim=y)
        axes.xaxis.set_visible(False)
        axes.yaxis.set_visible(False)
        return Panel(axes, x, y, Room(72 * across, 72 * high), first)

    def along_bottom(self, panel: Panel, place: Place, ticks: Ticks, label: str | None) -> None:
        """Ticks along the bottom of a panel, and their labels and the axis' own unless that is None."""
        left, bottom, across, _ = place
        share = _share(ticks[0], panel.x)
        _tick_marks(panel.axes, share, [0.0] * len(share), TICK_UP)
        if label is not None:
            for part, text in zip(share, ticks[1], strict=True):
                self.words(left + part * across, bottom - 0.06, text, ha="center", va="top", size=SMALL)
            self.words(left + across / 2, bottom - 0.40, label, ha="center", va="bottom")

    def along_side(self, panel: Panel, place: Place, ticks: Ticks) -> None:
        """Ticks along the left side of a panel, with their labels."""
        left, bottom, _, height = place
        share = _share(ticks[0], panel.y)
        _tick_marks(panel.axes, [0.0] * len(share), share, TICK_RIGHT)
        for part, text in zip(share, ticks[1], strict=True):
            self.words(left - 0.06, bottom + part * height, text, ha="right", va="center_baseline", size=SMALL)

    def along_top(self, panel: Panel, place: Place, ticks: Sequence[tuple[float, str]], label: str) -> None:
        """Ticks along the top of a panel, with their labels and the axis' own."""
        left, bottom, across, height = place
        share = _share([x for x, _ in ticks], panel.x)
        _tick_marks(panel.axes, share, [1.0] * len(share), TICK_DOWN)
        for part, (_, text) in zip(share, ticks, strict=True):
            x = min(left + part * across, WIDTH - 0.32 * SMALL * len(text) / 72)
            self.words(x, bottom + height + 0.05, text, ha="center", va="bottom", size=SMALL)
        self.words(left + across / 2, bottom + height + 0.22, label, ha="center", va="bottom")

    def words(self, x: float, y: float, text: str, **look: Any) -> None:
        """Write a text."""
        self.figure.text(x / WIDTH, y / self.height, text, **look)

    def heading(self, head: Sequence[tuple[str, str]], lines: Sequence[Sequence[Entry]]) -> None:
        """Write lines of text in their colours along the top, and under them lines of a legend."""
        y = self.height - 0.04 - ROW / 2
        for text, color in head:
            self.words(LEFT, y, text, va="center", size=SMALL, color=color)
            y -= ROW
        for line in lines:
            x = LEFT
            for entry in line:
                self._entry(x, y, entry)
                x += _length(entry)
            y -= ROW

    def _entry(self, x: float, y: float, entry: Entry) -> None:
        name, look = entry
        length = _sample(entry)
        ends = [x + length / 2] if look.get("linestyle") == "none" else [x, x + length]
        self.figure.add_artist(Line2D([end / WIDTH for end in ends], [y / self.height] * len(ends), **look))
        self.words(x + length + 0.06, y, name, va="center", size=SMALL)


@dataclass(frozen=True, slots=True)
class Sheet(Page):
    """A figure of panels above one another on one axis, with lines of text over them.

    Attributes
    ----------
    along : Along
    places : tuple of (float, float)
        Bottom and height of each panel [in], from the top one down.
    panels : list of Panel
        Those there are so far.
    """

    along: Along
    places: tuple[tuple[float, float], ...]
    panels: list[Panel] = field(default_factory=list)

    def panel(
        self,
        label: str,
        limits: tuple[float, float] | None,
        y_ticks: Ticks | None = None,
    ) -> Panel:
        """Add the next panel.

        Parameters
        ----------
        label : str
            Word, symbol and unit.
        limits : tuple of float or None
            None where there is nothing to show; the axis then has no ticks.
        y_ticks : tuple of sequences, optional
            Values and labels; by default at round numbers.
        """
        y = limits or (0.0, 1.0)
        number = len(self.panels)
        bottom, height = self.places[number]
        place = (LEFT, bottom, ACROSS, height)
        panel = self.frame(place, self.along.limits, y, number == 0)
        self.panels.append(panel)
        ticks = fitting_ticks(self.along.low, self.along.high, LETTERS_ALONG)
        self.along_bottom(panel, place, ticks, self.along.label if number + 1 == len(self.places) else None)
        if number == 0:
            self.along_top(panel, place, self.along.top, self.along.top_label)
        if limits:
            self.along_side(panel, place, y_ticks or fitting_ticks(*y, LETTERS_ALONG, 6))
        self.words(0.08, bottom + height / 2, label, rotation=90, ha="left", va="center")
        if len(self.places) > 1:
            self.words(0.05, bottom + height, f"({'abc'[number]})", ha="left", va="center")
        return panel


def sheet(
    axis: Along,
    panels: int,
    panel_height: float,
    head: Sequence[tuple[str, str]],
    legend: Sequence[Sequence[Entry]],
) -> Sheet:
    """An empty sheet: lines of text, a legend that is wrapped to its width, and room for panels.

    Parameters
    ----------
    axis : Along
    panels : int
    panel_height : float
        [in]
    head : sequence of (str, str)
        Lines of text and their colours.
    legend : sequence of sequences of (str, dict)
        Each begins a line.
    """
    lines = wrapped(legend)
    over = ROW * (len(head) + len(lines)) + 0.06 + TOP_AXIS
    height = BOTTOM + panels * panel_height + (panels - 1) * BETWEEN + over
    places = tuple((BOTTOM + (panels - 1 - k) * (panel_height + BETWEEN), panel_height) for k in range(panels))
    made = Sheet(blank(height), height, axis, places)
    made.heading(head, lines)
    return made


def blank(height: float) -> Figure:
    """An empty figure of the common width [in]."""
    figure = ShownFigure(figsize=(WIDTH, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def _tick_marks(axes: Axes, x: Sequence[float], y: Sequence[float], marker: Any) -> None:
    """Draw the ticks of a side as one line; matplotlib makes five artists of each, which take their time."""
    look: dict[str, Any] = {
        "linestyle": "none",
        "markersize": 3.5,
        "markeredgewidth": 0.7,
        "color": BLACK,
        "clip_on": False,
    }
    axes.add_artist(Line2D(x, y, marker=marker, transform=axes.transAxes, **look))


def _share(values: Sequence[float], limits: tuple[float, float]) -> list[float]:
    """Where values stand between limits, from 0 to 1."""
    low, high = limits
    return [(value - low) / (high - low) for value in values]


def wrapped(legend: Sequence[Sequence[Entry]]) -> list[list[Entry]]:
    """The entries in lines that fit the sheet; each group begins one."""
    lines: list[list[Entry]] = []
    for group in legend:
        room = 0.0
        for entry in group:
            if room < _length(entry):
                lines.append([])
                room = WIDTH - LEFT
            lines[-1].append(entry)
            room -= _length(entry)
    return lines


def _sample(entry: Entry) -> float:
    return 0.11 if entry[1].get("linestyle") == "none" else 0.34


def _length(entry: Entry) -> float:
    letter = 0.74 if set(entry[0]) <= WIDE else 0.54
    return _sample(entry) + 0.06 + letter * SMALL * len(entry[0]) / 72 + 0.14
