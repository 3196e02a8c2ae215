"""Measured impacts drawn over computed ones: points with error bars, with different marks for upwards and downwards."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from msgspec import Struct

from vireport.base.shares import NORMAL_95
from vireport.figures.curves import TURN, Floats, joined
from vireport.figures.layout import Entry
from vireport.figures.style import Color, Look
from vireport.motions.stability import eigenvalues
from vireport.scenario.blocks import Approach

if TYPE_CHECKING:
    from vireport.study.measured import DrawnImpacts, MeasuredAt

POINT: Look = {"linestyle": "none", "markersize": 4.6, "markeredgewidth": 0.9, "zorder": 4.2}
WAYS: dict[Approach, tuple[str, Look]] = {
    Approach.NONE: ("measured", POINT | {"marker": "D", "markersize": 3.8, "markerfacecolor": "white"}),
    Approach.UP: ("measured, upwards", POINT | {"marker": ">"}),
    Approach.DOWN: ("measured, downwards", POINT | {"marker": "<", "markerfacecolor": "white"}),
}
"""Name and look of what was measured, by the direction in which the swept parameter came to its value."""

LOOSE: Look = {"marker": ".", "markersize": 1.8, "markeredgewidth": 0, "zorder": 3.1}
"""What is different of impacts that do not repeat themselves."""

BARS: Look = {"linewidth": 0.9, "zorder": 4.1}

MOST_LOOSE = 100
"""Impacts that do not repeat themselves which are drawn of one value, the last ones."""


class Marks(Struct, frozen=True, eq=False):
    """Points of one value of the swept parameter on a panel, with the ends of their error bars, and a colour."""

    at: MeasuredAt
    color: str
    y: Floats
    low: Floats
    high: Floats
    repeats: bool


def impact_marks(
    records: Sequence[MeasuredAt], value: Callable[[DrawnImpacts], tuple[Floats, Floats]], colors: tuple[str, str]
) -> Iterator[Marks]:
    """What a panel shows of measured impacts, by a quantity with its standard errors; colours of bottom and top."""
    for at in records:
        if (impacts := at.drawn_impacts) is None:
            continue
        y, error = value(impacts)
        for wall, color in zip((1, -1), colors, strict=True):
            rows = np.flatnonzero((impacts.walls == wall) & np.isfinite(y))
            if not impacts.repeats:
                rows = rows[-MOST_LOOSE:]
            bar = NORMAL_95 * error[rows]
            yield Marks(at, color, y[rows], y[rows] - bar, y[rows] + bar, impacts.repeats)


def speed(impacts: DrawnImpacts) -> tuple[Floats, Floats]:
    """Magnitude of the velocity before the impacts [y_c], with standard errors."""
    return np.abs(impacts.values[0]), impacts.errors[0]


def phase(impacts: DrawnImpacts, cut: float) -> tuple[Floats, Floats]:
    """Phase of the impacts from `cut` on [rad], with standard errors."""
    return cut + (impacts.values[2] - cut) % TURN, impacts.errors[2]


def flight(impacts: DrawnImpacts) -> tuple[Floats, Floats]:
    """Half the time to the next impact, with standard errors."""
    return impacts.values[3] / 2, impacts.errors[3] / 2


def discriminant_marks(records: Sequence[MeasuredAt]) -> Iterator[Marks]:
    """The discriminant of measured 1:1 motions."""
    for at in records:
        if (multipliers := at.multipliers) is not None:
            value, bar = np.array([multipliers.discriminant]), NORMAL_95 * multipliers.discriminant_error
            yield Marks(at, Color.VERMILION, value, value - bar, value + bar, repeats=True)


def eigenvalue_marks(records: Sequence[MeasuredAt]) -> Iterator[Marks]:
    """The eigenvalues of measured 1:1 motions, or their real parts; bars between those of the ends of the trace's."""
    for at in records:
        if (multipliers := at.multipliers) is not None:
            traces = multipliers.trace + NORMAL_95 * multipliers.trace_error * np.array([0.0, -1.0, 1.0])
            for values in eigenvalues(traces, multipliers.decay):
                low, high = values.min(keepdims=True), values.max(keepdims=True)
                yield Marks(at, Color.VERMILION, values[:1], low, high, repeats=True)


def draw(
    axes: Axes,
    marks: Iterable[Marks],
    place: Callable[[float], float],
    limits: tuple[float, float] = (-np.inf, np.inf),
) -> None:
    """Draw points with their error bars on a panel.

    Parameters
    ----------
    axes : Axes
    marks : iterable of Marks
    place : callable
        From values of the swept parameter to places along the axis.
    limits : tuple of float
        Beyond which nothing needs to be seen.
    """
    for mark in marks:
        x = np.full(len(mark.y), place(mark.at.value))
        look = WAYS[mark.at.direction][1] | {"color": mark.color}
        if mark.repeats:
            bars = [(np.array([at, at]), np.array(ends)) for at, *ends in zip(x, mark.low, mark.high, strict=True)]
            if bars:
                axes.add_artist(Line2D(*joined(bars), **BARS, color=mark.color))
        else:
            look |= LOOSE | {"markerfacecolor": mark.color}
        axes.add_artist(Line2D(x, mark.y, **look))
        seen = (mark.y >= limits[0]) & (mark.y <= limits[1])
        if seen.any():
            axes.update_datalim(np.column_stack([x[seen], mark.y[seen]]))


def draw_speeds(axes: Axes, records: Sequence[MeasuredAt], place: Callable[[float], float]) -> list[Entry]:
    """Draw the speeds of measured impacts, see `draw`; give their entries in the legend."""
    draw(axes, impact_marks(records, speed, (Color.BLACK, Color.BLACK)), place)
    return legend(records)


def bars(axes: Axes, x: Floats, y: Floats, error: Floats | None, look: Look, across: bool = False) -> None:
    """Draw points of one look with 95 % error bars of their standard errors, across or upright, or without."""
    if error is not None:
        width, height = (NORMAL_95 * error, 0.0 * error) if across else (0.0 * error, NORMAL_95 * error)
        ends = zip(x - width, x + width, y - height, y + height, strict=True)
        drawn = [(np.array([left, right]), np.array([low, high])) for left, right, low, high in ends]
        axes.add_artist(Line2D(*joined(drawn), **BARS, color=look["color"]))
    axes.plot(x, y, **look)


def legend(records: Iterable[MeasuredAt]) -> list[Entry]:
    """The directions that occur, and whether something does not repeat itself."""
    drawable = [at for at in records if at.measured is not None]
    ways = {at.direction for at in drawable if at.motion is not None}
    entries: list[Entry] = [(name, look | {"color": Color.BLACK}) for way, (name, look) in WAYS.items() if way in ways]
    if any(at.motion is None for at in drawable):
        loose = POINT | LOOSE | {"color": Color.BLACK, "markersize": 4.0}
        entries.append(("measured, does not repeat", loose))
    return entries
