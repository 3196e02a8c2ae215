"""What was picked from raw signals, so that a miss is seen: a stretch, every impact in its period, how each begins."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vireport.figures.curves import Floats
from vireport.figures.layout import Entry, blank, finished, letter_of, title
from vireport.figures.style import GUIDE, Color, Look, Picture, literal, style
from vireport.measurement.flights import Indices
from vireport.measurement.picking import Heard, Picked, filtered
from vireport.measurement.recordings import HeardPlace
from vireport.measurement.shaker import ShakerMotion
from vireport.measurement.signals import Signals
from vireport.text.templates import Words

HEIGHT = 1.9
"""Of a row of panels [in]."""

PERIODS = 4
"""Of the force that the stretch is long."""

BINS = 1500
"""Places of a stretch, at each of which the least and the largest value are drawn."""

MOST_DRAWN = 60
"""Impacts that are laid over one another."""

AROUND = 0.002, 0.006
"""Periods of the force before and after the beginning of an impact."""

NAME = "figure-record"
MOTIONS = {HeardPlace.CAPSULE: "acceleration [m/s²]", HeardPlace.DISPLACEMENT: "displacement [m]"}
"""How the capsule's motion is written along an axis."""

SIGNAL: Look = {"color": Color.GREY, "linewidth": 0.6}
BOTTOM: Look = {"color": Color.BLUE, "marker": "o", "markersize": 3.0, "linestyle": "none"}
TOP: Look = {"color": Color.GREEN, "marker": "^", "markersize": 3.4, "linestyle": "none"}
WEAKEST: Look = {"color": Color.VERMILION, "linewidth": 0.8, "linestyle": (0, (3, 2))}
FITTED: Look = {"color": Color.VERMILION, "linewidth": 1.2}


def record_picture(signals: Signals, templates: Path | None = None) -> Picture:
    """Draw what was picked from raw signals, with title and caption.

    Parameters
    ----------
    signals : Signals
    templates : Path, optional
        A folder whose words come before the package's own.
    """
    words = Words("figures/record", templates)
    picked = signals.picked
    facts = {
        "impacts": len(picked.times),
        "name": Path(picked.recording.name).name,
        "channels": len(picked.heard),
        "shaker": signals.shaker,
    }
    heading, caption, alt = (words(f"figure_record_{part}", facts) for part in ("title", "caption", "alt"))
    return Picture(NAME, heading, caption, alt, figure_record(signals))


def figure_record(signals: Signals) -> Figure:
    """A stretch of each channel around the weakest impact, all impacts within their periods, beginnings, the shaker."""
    picked, shaker = signals.picked, signals.shaker
    period = 1 / picked.frequency_hz
    channels = [(heard, filtered(picked.recording, heard.channel, picked.frequency_hz)) for heard in picked.heard]
    with style():
        rows = len(channels) + 2
        figure, panels = blank(rows, 2)
        for k, (heard, signal) in enumerate(channels):
            axes = _whole_row(figure, panels, k)
            _stretch(axes, picked, heard, signal, period)
            title(axes, f"({letter_of(k)}) {literal(heard.channel.name)}, filtered")
        raster = _whole_row(figure, panels, len(channels))
        _raster(raster, picked, shaker, period)
        title(raster, f"({letter_of(len(channels))}) every impact picked: a miss is a hole")
        _beginnings(panels[-1, 0], picked, channels, period)
        title(panels[-1, 0], f"({letter_of(len(channels) + 1)}) beginnings, each over its height", 2)
        if shaker is not None:
            _shaker(panels[-1, 1], shaker)
            title(panels[-1, 1], f"({letter_of(len(channels) + 2)}) the shaker in a period", 2)
        else:
            panels[-1, 1].set_visible(False)
        legend: list[Entry] = [("bottom", BOTTOM), ("top", TOP), ("least that is picked", WEAKEST), ("fitted", FITTED)]
        return finished(figure, HEIGHT * rows, [], [legend if shaker is not None else legend[:3]])


def _whole_row(figure: Figure, panels: Any, row: int) -> Axes:
    """Replace the two panels of a row by one as wide as both."""
    grid = panels[row, 0].get_gridspec()
    for axes in panels[row]:
        axes.remove()
    return figure.add_subplot(grid[row, :])


def _stretch(axes: Axes, picked: Picked, heard: Heard, signal: Floats, period: float) -> None:
    """A few periods around the weakest impact of a channel, as drawn by its least and largest values."""
    recording = picked.recording
    weakest = float(heard.times[int(np.argmin(np.abs(heard.sizes)))])
    start = float(np.clip(weakest - PERIODS * period / 2, recording.start_s, recording.end_s - PERIODS * period))
    end = start + PERIODS * period
    for stretch in recording.stretches:
        first = max(int(recording.row_of(stretch, start)), stretch.first)
        last = min(int(recording.row_of(stretch, end)), stretch.last)
        if last - first < 2:
            continue
        rows = drawn_rows(signal, np.arange(first, last))
        axes.plot(recording.times_of(stretch, rows), signal[rows], **SIGNAL)
    for side in (-1, 1):
        axes.axhline(side * heard.least, **WEAKEST)
    for wall, look in ((1.0, BOTTOM), (-1.0, TOP)):
        mine = (picked.walls == wall) & (picked.times >= start) & (picked.times <= end)
        from_here = np.isin(picked.times, heard.times) & mine
        sizes = heard.sizes[np.searchsorted(heard.times, picked.times[from_here])]
        axes.plot(picked.times[from_here], sizes, **look)
    axes.set_xlim(start, end)
    axes.set_xlabel("time [s]")


def drawn_rows(values: Floats, rows: Indices) -> Indices:
    """Of many rows those of the least and the largest value at each of `BINS` places, so that no peak is missed."""
    if len(rows) <= 2 * BINS:
        return rows
    parts = np.array_split(rows, BINS)
    return np.array([k for part in parts for k in sorted((part[values[part].argmin()], part[values[part].argmax()]))])


def _raster(axes: Axes, picked: Picked, shaker: ShakerMotion | None, period: float) -> None:
    """Time within the period against time: what repeats itself makes lines, with a hole where an impact was missed."""
    zero = shaker.maximum_s if shaker is not None else picked.recording.start_s
    within = (picked.times - zero) / period % 1
    for wall, look in ((1.0, BOTTOM), (-1.0, TOP)):
        axes.plot(picked.times[picked.walls == wall], within[picked.walls == wall], **look | {"markersize": 2.0})
    axes.set(ylim=(0, 1), xlim=(picked.recording.start_s, picked.recording.end_s))
    axes.set(xlabel="time [s]", ylabel="phase [periods]")


def _beginnings(axes: Axes, picked: Picked, channels: list[tuple[Heard, Floats]], period: float) -> None:
    """Impacts over one another, from where each began."""
    recording = picked.recording
    before, after = (max(3, int(share * period / recording.step_s)) for share in AROUND)
    for (heard, signal), color in zip(channels, (Color.BLUE, Color.GREEN), strict=False):
        for k in range(0, len(heard.times), max(1, len(heard.times) // MOST_DRAWN)):
            stretch = max((x for x in recording.stretches if x.start_s <= heard.times[k]), key=lambda x: x.first)
            at = recording.row_of(stretch, float(heard.times[k]))
            rows = np.arange(max(int(at) - before, stretch.first), min(int(at) + after, stretch.last))
            look: dict[str, Any] = {"color": color, "linewidth": 0.4, "alpha": 0.5}
            axes.plot(1e3 * (rows - at) * recording.step_s, signal[rows] / abs(heard.sizes[k]), **look)
    axes.axvline(0.0, **GUIDE)
    axes.set(ylim=(-1.6, 1.6), xlabel="time from the beginning [ms]", ylabel="share of the first peak")


def _shaker(axes: Axes, shaker: ShakerMotion) -> None:
    """Means of the capsule's acceleration or displacement over the force's period, with what is fitted."""
    every = max(1, len(shaker.phases) // 2000)
    axes.plot(
        shaker.phases[::every] / (2 * np.pi),
        shaker.means[::every],
        **SIGNAL | {"linestyle": "none", "marker": ".", "markersize": 1.5},
    )
    order = np.argsort(shaker.phases)
    order = order[:: max(1, len(order) // 400)]
    axes.plot(shaker.phases[order] / (2 * np.pi), shaker.fitted[order], **FITTED)
    axes.set(xlim=(0, 1), xlabel="phase [periods]", ylabel=MOTIONS[shaker.channel.place])
    low, high = shaker.fitted.min(), shaker.fitted.max()
    axes.set_ylim(low - 0.2 * (high - low), high + 0.2 * (high - low))
