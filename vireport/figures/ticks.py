"""The ticks of an axis: where they stand, what they say, and a way to draw them all at once.

Matplotlib makes three lines and two texts of every tick, which takes a third of the time of a figure. Here all marks of
an axis are the markers of one line, and one text is written again and again. It is so while a figure is drawn for a
page: whoever has the figure has its ticks as Matplotlib makes them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import TICKDOWN, TICKLEFT, TICKRIGHT, TICKUP
from matplotlib.text import Text
from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator
from msgspec import Struct

from vireport.figures.curves import Floats

ON_FRAME = 1e-6
"""Distance from the end of an axis up to which a tick is drawn [px]."""

MARKS: dict[str, dict[str, Any]] = {
    "x": {"bottom": TICKUP, "top": TICKDOWN},
    "y": {"left": TICKRIGHT, "right": TICKLEFT},
}
"""Marks that lie inside the panel, by the side where they are; the usual side of an axis comes first."""

ORDINARY = {f"{before}{side}" for sides in MARKS.values() for side in sides for before in ("", "label")}
ORDINARY |= {"gridOn", "labelsize"}
"""Settings of ticks that are drawn at once: no other may be given, such as a colour."""


class Ticks(Struct, frozen=True, eq=False):
    """The ticks of an axis that lie on the frame of its panel.

    Attributes
    ----------
    values : ndarray of shape (k,)
    places : ndarray of shape (k,)
        Distances from the beginning of the axis [px].
    texts : list of str
        Labels.
    length : float
        Of the axis [px].
    size : float
        Of the type of the labels [pt].
    pad : float
        Between the frame and the labels [pt].
    """

    values: Floats
    places: Floats
    texts: list[str]
    length: float
    size: Any
    pad: float


def set_ticks(axis: Any, values: Iterable[float], texts: Iterable[str]) -> None:
    """Give an axis ticks at some values, with labels; Matplotlib's own way makes every tick right away."""
    axis.set_major_locator(FixedLocator(list(values)))
    axis.set_major_formatter(FixedFormatter(list(texts)))


def ticks_of(axis: Any) -> Ticks:
    """The ticks of an axis, which need not have been made."""
    settings: Mapping[Any, Any] = matplotlib.rcParams
    name = axis.axis_name
    values = np.asarray(axis.get_majorticklocs(), dtype=float)
    transform, length = axis.get_transform(), float(axis.axes.bbox.size["xy".index(name)])
    start, end = transform.transform(np.array(axis.get_view_interval()))
    places = (transform.transform(values) - start) / (end - start) * length
    on_frame = (places >= -ON_FRAME) & (places <= length + ON_FRAME)
    texts = np.array(axis.get_major_formatter().format_ticks(values), dtype=object)
    size = axis.get_tick_params().get("labelsize", settings[f"{name}tick.labelsize"])
    pad = settings[f"{name}tick.major.pad"] + axis.get_tick_padding()
    return Ticks(values[on_frame], places[on_frame], texts[on_frame].tolist(), length, size, pad)


class _TicksAtOnce(Artist):
    """The ticks and the label of an axis."""

    def __init__(self, axis: Any) -> None:
        super().__init__()
        self._axis = axis
        self.set_zorder(axis.get_zorder())

    def draw(self, renderer: Any) -> None:
        """Draw them where the axis would be drawn."""
        settings: Mapping[Any, Any] = matplotlib.rcParams
        axis, params, name = self._axis, self._axis.get_tick_params(), self._axis.axis_name
        ticks, axes = ticks_of(axis), axis.axes
        look = {"markersize": settings[f"{name}tick.major.size"], "color": settings[f"{name}tick.color"]}
        look |= {"markeredgewidth": settings[f"{name}tick.major.width"], "linestyle": "none"}
        for number, (side, mark) in enumerate(MARKS[name].items()):
            if params[side] and len(ticks.values):
                across = np.full(len(ticks.values), float(number))
                data = (ticks.values, across) if name == "x" else (across, ticks.values)
                place = getattr(axes, f"get_{name}axis_transform")(which=f"tick{number + 1}")
                self._draw(Line2D(*data, marker=mark, transform=place, **look), renderer)
            if params[f"label{side}"]:
                place, va, ha = getattr(axes, f"get_{name}axis_text{number + 1}_transform")(ticks.pad)
                text = Text(size=ticks.size, va=va, ha=ha, transform=place)
                for value, label in zip(ticks.values, ticks.texts, strict=True):
                    text.set_text(label)
                    text.set_position((value, number) if name == "x" else (number, value))
                    self._draw(text, renderer)
        axis.label.draw(renderer)

    def _draw(self, artist: Artist, renderer: Any) -> None:
        artist.set_figure(self._axis.axes.figure)
        artist.draw(renderer)


def _at_once(axis: Any) -> bool:
    """Whether an axis has nothing but marks inside its panel, labels beside them and its own label."""
    if not axis.get_visible() or not axis.axes.axison or not isinstance(axis.get_minor_locator(), NullLocator):
        return False
    params, formatter = axis.get_tick_params(), axis.get_major_formatter()
    formatter.set_locs(axis.get_majorticklocs())
    return params.keys() <= ORDINARY and not params["gridOn"] and not formatter.get_offset()


@contextmanager
def ticks_at_once(figure: Figure) -> Iterator[None]:
    """Within it, the ticks of a figure are drawn at once; Matplotlib draws those of axes with other settings."""
    axes_at_once = [axis for panel in figure.axes for axis in (panel.xaxis, panel.yaxis) if _at_once(axis)]
    artists = [axis.axes.add_artist(_TicksAtOnce(axis)) for axis in axes_at_once]
    for axis in axes_at_once:
        axis.set_visible(False)
    try:
        yield
    finally:
        for axis, artist in zip(axes_at_once, artists, strict=True):
            axis.set_visible(True)
            artist.remove()
