"""The ticks of an axis: where they stand and what they say, before Matplotlib makes them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.ticker import FixedFormatter, FixedLocator
from msgspec import Struct

from vireport.figures.curves import Floats

ON_FRAME = 1e-6
"""Distance from the end of an axis up to which a tick is drawn [px]."""


class Ticks(Struct, frozen=True, eq=False):
    """The ticks of an axis that lie on the frame of its panel.

    Attributes
    ----------
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
    return Ticks(places[on_frame], texts[on_frame].tolist(), length, size, pad)
