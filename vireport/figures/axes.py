"""The look of the figures, and their axis along the sweep.

No setting of the user's has a part in the look. Texts are plain Unicode, which is set in a tenth of the time
of formulae.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
from numpy.typing import NDArray

from vireport.analysis import Sweep
from vireport.figures.ticks import fitting_ticks, uneven_ticks
from vireport.text import (
    PREFIXES,
    exact,
)

Floats = NDArray[np.float64]
Curve = tuple[Floats, Floats]

# Okabe and Ito's colours, which stay apart for colour-blind readers.
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILION, PURPLE = "#0072B2", "#D55E00", "#CC79A7"
GREY, LIGHT = "#767676", "#D8D8D8"
WARNING = "#A33A00"
"""Vermilion, dark enough for text."""

SOLID: Any = "-"
DASHED: Any = (0, (5, 2))
DASH_DOTTED: Any = (0, (5, 1.6, 1, 1.6))
DOTTED: Any = (0, (1, 1.5))
SPARSE: Any = (0, (1, 3.2))

DPI = 150

TEXT, SMALL = 8.5, 8.0
"""Sizes of type [pt]."""

LETTERS_ALONG = 84
"""How many letters of the small size fit along a panel."""

NOT_LOOKS = {"backend", "backend_fallback", "interactive", "timezone", "toolbar"}
"""Settings of matplotlib that have no part in how a figure looks."""

STYLE: dict[Any, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": TEXT,
    "axes.linewidth": 0.7,
    "axes.labelsize": TEXT,
    "text.hinting": "none",
    "lines.linewidth": 1.5,
    "lines.dash_capstyle": "butt",
    "lines.scale_dashes": False,
}


@contextmanager
def style() -> Iterator[None]:
    """The look of the figures, whatever the user has set; the user's settings are there again afterwards.

    `matplotlib.rcdefaults` would do as well, but it reads all style sheets first.
    """
    current = matplotlib.rcParams
    changed: dict[Any, Any] = {
        key: value
        for key, value in matplotlib.rcParamsDefault.items()
        if key not in NOT_LOOKS and current[key] != value
    }
    with matplotlib.rc_context(changed | STYLE):
        yield


@dataclass(frozen=True, slots=True)
class Along:
    """The axis along the sweep: d, or the inclination where d is held.

    Attributes
    ----------
    low, high : float
        Range of the sweep on it.
    label, top_label : str
    top : tuple of (float, str)
        Places and labels of the ticks along the top.
    by_value : bool
        Whether it is the swept parameter itself.
    """

    low: float
    high: float
    label: str
    top_label: str
    top: tuple[tuple[float, str], ...]
    by_value: bool

    def of(self, motions: Any) -> Floats:
        """Where motions (anything with `sweep_value` and `d`) stand."""
        return np.asarray(motions.sweep_value if self.by_value else motions.d)

    @property
    def limits(self) -> tuple[float, float]:
        """Ends of the axis: the range and a little room."""
        return widened(self.low, self.high, 0.015)


def along(sweep: Sweep, room: int = LETTERS_ALONG) -> Along:
    """The axis along a sweep, with the swept quantity (or gbar, for an inclination) along its top.

    `room` is how many letters of the small size fit along it.
    """
    swept = sweep.parameter
    name = f"{swept.quantity} {swept.symbol} [{swept.unit}]"
    start, end = sorted((float(sweep.start), float(sweep.end)))
    by_value = sweep.parameter == "inclination_deg"
    if by_value:
        low, high = start, end
        first, last = (float(v) for v in sweep.coordinate_range)
        label, top_label = name, "gravity ḡ = M g sin β / F [–]"
    else:
        low, high = (float(v) for v in sweep.coordinate_range)
        first, last = start, end
        label, top_label = "distance d = 4 M s f² / F [–]", name

    def place(values: Floats) -> Floats:
        d = sweep.coordinate_of(start)
        return np.asarray(sweep.value(d, values) if by_value else sweep.coordinate_of(values))

    if sweep.parameter == "length_m":
        values, texts = fitting_ticks(first, last, room)
    else:
        letters = 5
        for _ in range(2):
            values = uneven_ticks(first, last, place, (high - low) * (letters + 2) / room)
            texts = [exact(value) for value in values]
            letters = max(letters, *map(len, texts), 0)
    top = tuple((float(x), text) for x, text in zip(place(np.array(values)), texts, strict=True))
    return Along(low, high, label, top_label, top, by_value)


def widened(low: float, high: float, share: float) -> tuple[float, float]:
    """A range with room at both ends; one that is next to nothing becomes wide enough to be drawn."""
    least = 1e-6 * max(abs(low), abs(high)) or 1.0
    if high - low < least:
        low, high = (low + high - least) / 2, (low + high + least) / 2
    margin = share * (high - low)
    return low - margin, high + margin


def within(y: Floats, low: float, high: float) -> Floats:
    """What an axis has to hold of a curve: as far as the limits it crosses; nothing where all is beyond."""
    inside = (y >= low) & (y <= high)
    return np.clip(y, low, high) if inside.any() else y[:0]


def limits(values: list[Floats]) -> tuple[float, float] | None:
    """Limits of an axis that holds all values, with room for letters; None where there are none but NaN."""
    known = [y[~np.isnan(y)] for y in values]
    ends = [end for y in known if len(y) for end in (float(y.min()), float(y.max()))]
    return widened(min(ends), max(ends), 0.07) if ends else None


def prefix(values: list[Floats]) -> int:
    """Power of ten of the prefix that brings the largest value between 1 and 1000."""
    largest = max((float(np.abs(y).max(initial=0.0, where=~np.isnan(y))) for y in values), default=0.0)
    if largest == 0:
        return 0
    return int(np.clip(3 * np.floor(np.log10(largest) / 3), min(PREFIXES), max(PREFIXES)))
