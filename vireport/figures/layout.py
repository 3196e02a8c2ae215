"""What all figures are built from: panels in rows and columns, a heading with legends, ticks, the axis of a sweep.

The panels are placed first; the heading is put over them, and labels are written once that is final.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import accumulate
from string import ascii_lowercase
from textwrap import fill
from typing import Any, Literal, cast

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.markers import TICKDOWN
from matplotlib.ticker import LogLocator, MaxNLocator
from matplotlib.transforms import Affine2DBase, ScaledTranslation
from msgspec import Struct

from vireport.figures.curves import Floats
from vireport.figures.labels import Label, write_labels
from vireport.figures.placing import LINE, place_panels
from vireport.figures.style import DPI, Color, Look, NotebookFigure, sheet
from vireport.figures.ticks import set_ticks
from vireport.figures.vector import PER_INCH, LayoutCanvas, text_size
from vireport.motions.sweep import Sweep
from vireport.scenario.parameters import Parameter
from vireport.text.formatting import MINUS, PREFIXES, TIMES, exact

Entry = tuple[str, Look]
"""A line of a legend: a name, and the look of its line or marker."""

EDGE, LINE_GAP = 0.07, 0.06
"""Room at the edges of a figure, and between the lines of its heading [in]."""

AXES_HEIGHT = 0.95
"""Height of the ticks and labels along the top and the bottom of a sweep's panels [in]."""

TICK_DIGITS = 12
"""Significant digits of tick labels: fewer than rounding errors leave alone."""

ROUND_STEPS = (1, 2, 5, 10)
MOST_TICKS = 8

SEVERAL_DECADES = 5.0
"""Ratio of the ends of a range from which 1, 2, 5, 10, ... are tried as ticks."""

ALONG_TOP = "along the top"
"""What the texts of the ticks along the top of a panel, and of their label, are labelled with."""

EDGE_ORDER = 1.6
"""Order of drawing of marks on the frame, which are under the curves."""

TOP_LABEL, LETTER_RISE = 13.0, 4.0
"""Height of the label of the axis along the top over the ticks there, and of a panel's letter over its frame [pt]."""

BESIDE_LABEL = 8
"""Letters that fit beside the label of the axis along the top where a panel's letter stands."""

MARGIN_X, MARGIN_Y = 0.015, 0.07
"""Room between what is drawn and the frame, as a share of the range; vertically for labels too."""

LEAST_RANGE = 1e-6
"""Range over size up to which values are the same but for rounding errors."""


_GLUE = "\0"
_TOGETHER = re.compile(r"(?<=\d) (?=\S{1,3}(?:[\s,;:.)]|$))| (?== )|(?<==) ")
"""Spaces after numbers before what may be units, and those of equations."""

HANDLE = 0.4
"""Width of the line before a name in a legend [in], for the choice of lines."""

HANDLE_RISE = 0.35
"""Height of that line over the foot of its name, over the size of type."""

NARROW = 4.5
"""Width of panels [in] below which those that are beside one another on a page stand below one another."""


def columns_of(most: int) -> int:
    """How many panels stand beside one another where there is room for some."""
    return most if sheet().across >= NARROW else 1


def blank(rows: int, columns: int = 1, **shared: Any) -> tuple[NotebookFigure, Any]:
    """A figure with an array of empty panels; `shared` are arguments of `Figure.subplots`."""
    width = sheet().width
    figure = NotebookFigure(figsize=(width, width), dpi=PER_INCH, facecolor="white")
    LayoutCanvas(figure)
    return figure, figure.subplots(rows, columns, squeeze=False, **shared)


def finished(
    figure: NotebookFigure,
    height: float,
    lines: Sequence[tuple[str, str]],
    legends: Iterable[Sequence[Entry]],
    labels: Sequence[tuple[Axes, Sequence[Label]]] = (),
    aligned: Sequence[Axes] = (),
) -> Figure:
    """Write the heading of a figure, lay the figure out and write the labels of its panels.

    Parameters
    ----------
    figure : Figure
    height : float
        Of everything under the heading [in].
    lines : sequence of (str, str)
        Lines of text and their colours; those in black say what is held, which a sheet may leave to the caption.
    legends : iterable of sequence of Entry
        Each begins a line, and has as many as it takes.
    labels : sequence of (Axes, sequence of Label)
    aligned : sequence of Axes
        Panels above one another, the labels of whose vertical axes are in one line.
    """
    room = _write_heading(figure, lines, legends)
    place_panels(figure, height, room, aligned)
    figure.stretch = lambda more: place_panels(figure, height + more, room, aligned)
    for axes, texts in labels:
        write_labels(axes, texts)
    # From here on it is a figure that whoever has it can save or draw on, as any of Matplotlib.
    FigureCanvasAgg(figure)
    figure.dpi = DPI
    return figure


def panel_size(axes: Axes, height: float) -> tuple[float, float]:
    """Width and height [in] that a panel will have in a figure whose everything under the heading is `height` high."""
    figure: Any = axes.figure
    place_panels(figure, height)
    place = axes.get_position()
    return float(place.width * sheet().width), float(place.height * height)


def folded(text: str, letters: int) -> str:
    """A text in lines of so many letters, where no number is parted from its unit, nor an equation from its sign."""
    return fill(_TOGETHER.sub(_GLUE, text), letters).replace(_GLUE, " ")


def _filled(text: str) -> str:
    """A line of text in as many lines as it takes."""
    return folded(text, sheet().letters(sheet().width - 2 * EDGE))


def _write_heading(figure: Figure, lines: Sequence[tuple[str, str]], legends: Iterable[Sequence[Entry]]) -> float:
    """Write lines and legends from the upper left corner down, where they stay as the figure becomes higher.

    Returns their height [in].
    """
    size, top = sheet().small, LINE_GAP
    font = FontProperties(size=size)
    place = figure.dpi_scale_trans + ScaledTranslation(0, 1, cast(Affine2DBase, figure.transFigure))

    def write(x: float, y: float, text: str, color: str, va: Literal["top", "baseline"]) -> float:
        written = figure.text(x, y, text, color=color, size=size, va=va, transform=place)
        return float(written.get_window_extent().height) / PER_INCH

    for text, color in lines:
        if sheet().headed or color != Color.BLACK:
            top += write(EDGE, -top, _filled(text), color, "top") + LINE_GAP
    for entries in filter(None, legends):
        handle, pad = (size * width / PER_INCH for width in _handle(entries))
        for row in _legend_rows(entries):
            sizes = [text_size(text, font) for text in (LINE, *(name.splitlines()[0] for _, (name, _) in row))]
            foot = -top - max(height - descent for _, height, descent in sizes) / PER_INCH
            heights = []
            for x, (name, look) in row:
                ends, level = EDGE + x + handle * np.array([0.0, 0.5, 1.0]), foot + HANDLE_RISE * size / PER_INCH
                # A marker stands in the middle of its line.
                once = look | {"markevery": [1]}
                figure.add_artist(Line2D(ends, [level] * 3, label=name, transform=place, **once))
                if "\n" in name:
                    heights.append(write(ends[-1] + pad, -top, name, Color.BLACK, "top"))
                else:
                    heights.append(write(ends[-1] + pad, foot, name, Color.BLACK, "baseline"))
            top += max(heights) + LINE_GAP
    return top


def _legend_rows(entries: Sequence[Entry]) -> list[list[tuple[float, Entry]]]:
    """The rows of a legend, read one after the other: each entry with the place where it begins [in].

    They have as many columns as fit, or are filled one by one where that takes fewer. An entry that is too long for a
    row has several lines.
    """
    room, font = sheet().width - 2 * EDGE, FontProperties(size=sheet().small)
    before = sheet().small * sum(_handle(entries)) / PER_INCH
    gap = sheet().small * matplotlib.rcParams["legend.columnspacing"] / PER_INCH
    widths = [before + text_size(name, font)[0] / PER_INCH for name, _ in entries]
    if max(widths) > room:
        letters = sheet().letters(room - HANDLE)
        return [[(0.0, (folded(name, letters), look))] for name, look in entries]
    filled = list[list[int]]()
    for k, width in enumerate(widths):
        if not filled or sum(widths[i] + gap for i in filled[-1]) + width > room:
            filled.append([])
        filled[-1].append(k)

    def starts(widths: Sequence[float]) -> list[float]:
        return list(accumulate((width + gap for width in widths), initial=0.0))

    for columns in range(len(entries), 0, -1):
        across = starts([max(widths[k::columns]) for k in range(columns)])
        if across[-1] - gap <= room:
            break
    if len(entries) > columns * len(filled):
        rows = [(row, starts([widths[k] for k in row])) for row in filled]
    else:
        rows = [(list(range(len(entries))[k : k + columns]), across) for k in range(0, len(entries), columns)]
    return [[(x, entries[k]) for k, x in zip(row, places, strict=False)] for row, places in rows]


def _handle(entries: Sequence[Entry]) -> tuple[float, float]:
    """Width of the line or the marker before a name, and of the gap between them, over the size of type."""
    settings: Mapping[Any, Any] = matplotlib.rcParams
    only_marks = all(look.get("linestyle") == "none" for _, look in entries)
    return 1.0 if only_marks else settings["legend.handlelength"], settings["legend.handletextpad"]


def letter_of(number: int) -> str:
    """The letter of a panel: a to z, then aa, bb, ..."""
    return ascii_lowercase[number % 26] * (number // 26 + 1)


def title(axes: Axes, text: str, columns: int = 1) -> None:
    """Write a line over a panel, one of some columns, in as many lines as it takes."""
    axes.set_title(folded(text, sheet().letters(sheet().across / columns)), loc="left")


def letter_panels(panels: Sequence[Axes], first: int, below_axis: bool = True) -> None:
    """Letter panels above one another from the letter numbered `first`, beside the label of an axis on top if any."""
    for k, axes in enumerate(panels):
        rise = LETTER_RISE if k or not below_axis else LETTER_RISE + TOP_LABEL
        offset = ScaledTranslation(0, rise / 72, axes.figure.dpi_scale_trans)
        axes.text(0, 1, f"({letter_of(first + k)})", transform=axes.transAxes + offset, size=sheet().small)


def write_along_top(axes: Axes, places: Sequence[float] | Floats, texts: Sequence[str], label: str) -> None:
    """Give a panel ticks along the top with their labels, and a label over them.

    They are marks and texts of the panel: an axis of Matplotlib takes as long as a panel.
    """
    settings: Mapping[Any, Any] = matplotlib.rcParams
    look: Look = {"marker": TICKDOWN, "linestyle": "none", "color": Color.BLACK}
    look |= {"markersize": settings["xtick.major.size"], "markeredgewidth": settings["xtick.major.width"]}
    marks = Line2D(places, np.ones(len(texts)), **look)
    marks.set(transform=axes.get_xaxis_transform(), zorder=EDGE_ORDER)
    axes.add_artist(marks)
    pad, rise = settings["xtick.major.pad"], settings["axes.labelpad"]
    above, va, ha = axes.get_xaxis_text2_transform(pad)
    for place, text in zip(places, texts, strict=True):
        axes.text(place, 1, text, transform=above, va=va, ha=ha, size=sheet().small, label=ALONG_TOP)
    if texts:
        rise += pad + text_size(LINE, FontProperties(size=sheet().small))[1]
    over = axes.transAxes + ScaledTranslation(0, rise / PER_INCH, axes.figure.dpi_scale_trans)
    axes.text(0.5, 1, label, transform=over, ha="center", va="bottom", label=ALONG_TOP)


def say(axes: Axes, text: str) -> None:
    """Write a sentence in the middle of a panel that shows nothing else."""
    box = {"facecolor": "white", "edgecolor": "none"}
    said = folded(text, sheet().letters(0.8 * sheet().across))
    axes.text(0.5, 0.5, said, transform=axes.transAxes, ha="center", va="center", size=sheet().text + 1, bbox=box)


def widened(low: float, high: float, share: float) -> tuple[float, float]:
    """A range with room at both ends; one that is next to nothing becomes wide enough to be drawn."""
    least = LEAST_RANGE * max(abs(low), abs(high)) or 1.0
    if high - low < least:
        low, high = (low + high - least) / 2, (low + high + least) / 2
    margin = share * (high - low)
    return low - margin, high + margin


def fit_vertically(panels: Sequence[Axes], ticks: int = 6) -> None:
    """Let panels that share a vertical axis hold all that is drawn on them; where that is nothing, without ticks."""
    low = min(float(axes.dataLim.y0) for axes in panels)
    high = max(float(axes.dataLim.y1) for axes in panels)
    if low <= high:
        panels[0].set_ylim(*widened(low, high, MARGIN_Y))
        # A number of ticks that does not depend on the height, which the layout has still to find.
        panels[0].yaxis.set_major_locator(MaxNLocator(ticks, steps=ROUND_STEPS))
    else:
        panels[0].set_ylim(0.0, 1.0)
        set_ticks(panels[0].yaxis, [], [])


def prefix(values: Iterable[Floats]) -> int:
    """Power of ten of the prefix that brings the largest value between 1 and 1000."""
    largest = max((float(np.abs(y).max(initial=0.0, where=~np.isnan(y))) for y in values), default=0.0)
    if largest == 0:
        return 0
    return int(np.clip(3 * np.floor(np.log10(largest) / 3), min(PREFIXES), max(PREFIXES)))


def round_ticks(
    low: float, high: float, width: float, place: Callable[[Floats], Floats] | None = None
) -> tuple[list[float], list[str]]:
    """Round numbers in a range, as many as there is room for, and their labels.

    Parameters
    ----------
    low, high : float
        The range, ascending.
    width : float
        Of the axis [in].
    place : callable, optional
        From values to shares of the width, where the axis is not linear.
    """

    def fit(values: Sequence[float], texts: Sequence[str]) -> bool:
        x = np.array(values)
        places = np.sort(place(x) if place else (x - low) / (high - low))
        return bool((np.diff(places) * width >= (max(map(len, texts), default=0) + 2) * sheet().letter).all())

    choices = []
    for count in range(MOST_TICKS, 0, -1):
        values = _within(MaxNLocator(count, steps=ROUND_STEPS).tick_values(low, high), low, high)
        if fit(values, texts := tick_labels(values)):
            choices.append((values, texts))
            break
    else:  # the locator sets two ticks at least, however near
        while len(values) > 1 and not fit(values, tick_labels(values)):
            values = values[::2]
        choices.append((values, tick_labels(values)))
    # Where the axis crowds one end of the range, even steps leave the other end without ticks.
    if place and high > SEVERAL_DECADES * low > 0:
        values = []
        for value in _within(LogLocator(subs=(1, 2, 5)).tick_values(low, high), low, high):
            if fit([*values, value], [exact(value)]):
                values.append(value)
        choices.append((values, [exact(value) for value in values]))
    return max(choices, key=lambda choice: len(choice[0]), default=([], []))


def _within(values: Iterable[float], low: float, high: float) -> list[float]:
    rounded = (float(f"{value:.{TICK_DIGITS}g}") for value in values)
    return [value for value in rounded if low <= value <= high]


def tick_labels(values: Sequence[float]) -> list[str]:
    """Labels of ticks at even steps, all with the same number of decimals."""
    texts = [exact(value) for value in values]
    if any(TIMES in text for text in texts):
        return texts
    decimals = max((len(text.partition(".")[2]) for text in texts), default=0)
    return [f"{value:.{decimals}f}".replace("-", MINUS) if value else "0" for value in values]


class SweepAxis(Struct, frozen=True):
    """The axis along a sweep from `low` to `high`: d, or the inclination where that varies and d is held."""

    sweep: Sweep
    low: float
    high: float

    @property
    def by_value(self) -> bool:
        """Whether the axis is that of the swept parameter itself."""
        return not self.sweep.parameter.moves_d

    def of(self, motions: Any) -> Floats:
        """Where motions (anything with `sweep_value` and `d`) stand."""
        return np.asarray(motions.sweep_value if self.by_value else motions.d)

    def of_value(self, value: float) -> float:
        """Where a value of the swept parameter stands."""
        return value if self.by_value else float(self.sweep.coordinate_of(value))

    @property
    def scales_on_top(self) -> bool:
        """Whether the axis has a second scale above; along a restitution neither d nor gbar varies."""
        return not self.sweep.parameter.bounces

    def dress(self, panels: Sequence[Axes], columns: int = 1, above: str = "") -> None:
        """Give a column of panels its limits, ticks and labels: d below it and the swept parameter above.

        Where d is held it is the swept parameter below, and gbar above if it varies.

        Parameters
        ----------
        panels : sequence of Axes
            From the top one down; they share this axis.
        columns : int
            How many are beside one another.
        above : str
            A line over the axis along the top.
        """
        swept, width = self.sweep.parameter, sheet().across / columns
        group, formula = ("gravity ḡ", "M g sin β / F") if self.by_value else ("distance d", "4 M s f² / F")
        label = swept.label
        if columns == 1:
            group = f"{group} = {formula}"
        else:
            label = label.replace(swept.quantity, swept.quantity.partition(" ")[0])
            if len(label) + BESIDE_LABEL > sheet().letters(width):
                label = label.partition(" ")[2]
        names = f"{group} [–]", label
        below, over = reversed(names) if self.by_value else names
        margin = MARGIN_X * (self.high - self.low)
        panels[-1].set_xlim(self.low - margin, self.high + margin)
        set_ticks(panels[-1].xaxis, *round_ticks(self.low, self.high, width))
        panels[-1].set_xlabel(below)
        if self.scales_on_top:
            write_along_top(panels[0], *self._along_top(width), f"{above}\n{over}" if above else over)
        else:
            write_along_top(panels[0], [], [], above)

    def _along_top(self, width: float) -> tuple[Floats, list[str]]:
        """Places and labels of the ticks of the swept parameter, or of gbar where the inclination varies."""
        sweep = self.sweep
        start, end = sorted((float(sweep.start), float(sweep.end)))
        if self.by_value:
            start, end = (float(gbar) for gbar in sweep.coordinate_range)

        def place(values: Floats) -> Floats:
            return np.asarray(sweep.value(values) if self.by_value else sweep.coordinate_of(values))

        def share(values: Floats) -> Floats:
            return (place(values) - self.low) / (self.high - self.low)

        linear = sweep.parameter is Parameter.LENGTH
        values, texts = round_ticks(start, end, width, None if linear else share)
        return place(np.array(values)), texts


def sweep_axis(sweep: Sweep) -> SweepAxis:
    """The axis of figures along a sweep: its parameter or, where that moves d, d."""
    low, high = sorted((float(sweep.start), float(sweep.end)))
    if sweep.parameter.moves_d:
        low, high = (float(d) for d in sweep.coordinate_range)
    return SweepAxis(sweep, low, high)
