"""Places the panels of a figure by the room that ticks, labels, titles and texts take around them: nothing is drawn.

Lengths are in points, of which a figure that is laid out has one to a pixel. The panels are one grid, with the same gap
between all its rows and between all its columns. Room around a frame is in the order of `SIDES`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.gridspec import SubplotSpec
from matplotlib.text import Text
from matplotlib.ticker import AutoLocator, FixedLocator
from matplotlib.transforms import Bbox, ScaledTranslation
from msgspec import Struct

from vireport.figures.curves import Floats
from vireport.figures.ticks import ticks_of
from vireport.figures.vector import PER_INCH, LayoutCanvas, text_size

EDGE, ROW_GAP, COLUMN_GAP = 3.6, 4.3, 7.2
"""Free room around all panels, and between what is around those of two rows and of two columns."""

BEFORE = {"left": 0.12, "right": 0.95, "bottom": 0.15, "top": 0.9, "wspace": 0.2, "hspace": 0.2}
"""Margins and gaps with which panels are measured, so that a figure that is placed twice is placed alike."""

FACTOR_GAP = 3.0
"""Gap between the labels of the ticks and a factor that all of them have."""

LINE = "lp"
"""What is as high as a line of text."""

DIGITS = 6
"""Decimals of what is measured."""

SIDES = "left", "bottom", "right", "top"
LEFT, BOTTOM, RIGHT, TOP = range(4)
OUTWARDS = np.array([-1.0, -1.0, 1.0, 1.0])
"""Directions of the sides along their axis."""

AT_LABEL = {"left": (0.0, 0.5), "bottom": (0.5, 0.0), "right": (1.0, 0.5), "top": (0.5, 1.0)}
"""Where the label of an axis is on the frame of its panel, by its side, as shares of width and height."""


class Surroundings(Struct, frozen=True, eq=False):
    """The room that ticks, labels and titles take around the frame of a panel.

    Attributes
    ----------
    room : ndarray of shape (4,)
    labels : dict of Axis to float
        How far the label of each axis is from the frame.
    over_texts : float
        Height of the texts over the frame, over which a title stands.
    """

    room: Floats
    labels: dict[Axis, float]
    over_texts: float


def place_panels(figure: Figure, height: float, heading: float = 0.0, aligned: Collection[Axes] = ()) -> None:
    """Place the panels of a figure under its heading, and the labels of their axes beside the ticks.

    Parameters
    ----------
    figure : Figure
    height, heading : float
        Of the panels with what is around them, and of the heading [in].
    aligned : collection of Axes
        Panels above one another, the labels of whose vertical axes are in one line.
    """
    canvas, dpi = figure.canvas, figure.dpi
    LayoutCanvas(figure)
    figure.dpi = PER_INCH
    figure.set_figheight(height + heading)
    figure.subplots_adjust(**BEFORE)
    panels = [panel for panel in figure.axes if panel.get_visible()]
    around = {panel: _surroundings(panel) for panel in panels}
    figure.subplots_adjust(**_margins(figure, around, PER_INCH * heading))
    if chosen := [axis for panel in panels for axis in _by_size(panel)]:
        # Chosen by the size that panels have now, they stay: drawn with other settings, there might be others.
        for axis in chosen:
            axis.set_major_locator(FixedLocator(axis.get_majorticklocs().tolist()))
        around = {panel: _surroundings(panel) for panel in panels}
        figure.subplots_adjust(**_margins(figure, around, PER_INCH * heading))
    farthest = max((around[panel].labels.get(panel.yaxis, 0.0) for panel in aligned), default=0.0)
    for panel, surroundings in around.items():
        if surroundings.over_texts:
            panel.title.set_y(1 + surroundings.over_texts / panel.bbox.height)
        if panel.get_axes_locator() is not None:
            continue  # its place is found as it is drawn: the bar of a heat map
        for axis, distance in surroundings.labels.items():
            apart = farthest if panel in aligned and axis is panel.yaxis else distance
            place = AT_LABEL[str(axis.get_label_position())]
            right, up = (apart * (2 * share - 1) / PER_INCH for share in place)
            shift = ScaledTranslation(right, up, figure.dpi_scale_trans)
            # Without fixed places every drawing measures all ticks to find those of the labels.
            axis.set_label_coords(*place, transform=panel.transAxes + shift)
    figure.dpi = dpi
    figure.set_canvas(canvas)


def _by_size(panel: Axes) -> list[Axis]:
    """The axes of a panel whose ticks Matplotlib chooses by its size."""
    if not panel.axison or panel.get_axes_locator() is not None:
        return []
    return [axis for axis in (panel.xaxis, panel.yaxis) if isinstance(axis.get_major_locator(), AutoLocator)]


def _surroundings(panel: Axes) -> Surroundings:
    """Measure what is around a panel, whose size need not be final."""
    locator: Any = panel.get_axes_locator()
    panel.apply_aspect(None if locator is None else locator(panel, None))
    room, labels = np.zeros(4), dict[Axis, float]()
    if panel.axison:
        room = np.maximum(_beside_axis(panel.xaxis, labels), _beside_axis(panel.yaxis, labels))
    beyond = [OUTWARDS * (np.array(text.get_window_extent().extents) - panel.bbox.extents) for text in panel.texts]
    room = np.max([room, *beyond], axis=0)
    over_texts = max([0.0, *(float(sides[TOP]) for sides in beyond)])
    for place in ("left", "center", "right"):
        if title := panel.get_title(loc=place):
            over = over_texts + matplotlib.rcParams["axes.titlepad"]
            room[TOP] = max(room[TOP], over + _over_baseline(panel, title, matplotlib.rcParams["axes.titlesize"]))
    # What is measured depends on where it stands, in its last digits.
    return Surroundings(room.round(DIGITS), labels, over_texts)


def _beside_axis(axis: Any, labels: dict[Axis, float]) -> Floats:
    """Measure ticks and label of an axis, and note how far its label is from the frame."""
    room, params, name = np.zeros(4), axis.get_tick_params(), axis.axis_name
    direction, (lower, upper) = (0, (LEFT, RIGHT)) if name == "x" else (1, (BOTTOM, TOP))
    sides = [side for side in range(4) if side not in (lower, upper) and params.get(f"label{SIDES[side]}")]
    ticks = ticks_of(axis) if sides else None
    if ticks is not None and len(axis.get_majorticklocs()):
        font = FontProperties(size=ticks.size)
        line = text_size(LINE, font)[1]
        for at, text in zip(ticks.places, ticks.texts, strict=True):
            if text:
                size = text_size(text, font)[0], line
                beyond = size[direction] / 2 - np.array([at, ticks.length - at])
                room[[lower, upper]] = np.maximum(room[[lower, upper]], beyond)
                room[sides] = np.maximum(room[sides], ticks.pad + size[1 - direction])
        if axis.get_major_formatter().get_offset():
            room[TOP if name == "y" else sides] += FACTOR_GAP + line
    room = room.round(DIGITS)
    if axis.get_label_text():
        side = SIDES.index(str(axis.get_label_position()))
        labels[axis] = float(room[side] + axis.labelpad)
        room[side] = labels[axis] + axis.label.get_window_extent().size[1 - direction]
    return room


def _over_baseline(panel: Axes, text: str, size: float) -> float:
    """Height of a text over the baseline of its last line."""
    lines = Text(0, 0, text, size=size, va="baseline")
    lines.set_figure(panel.figure)
    return float(lines.get_window_extent().y1)


def _margins(figure: Figure, around: Mapping[Axes, Surroundings], heading: float) -> dict[str, float]:
    """Margins of the grid under a heading and gaps between its panels, as `Figure.subplots_adjust` takes them.

    None are given where the figure is too small for what is around its panels.
    """
    # A panel and the bar beside it share a place of the grid.
    places: dict[SubplotSpec, list[Axes]] = {}
    for panel in around:
        if (spec := panel.get_subplotspec()) is not None:
            places.setdefault(spec.get_topmost_subplotspec(), []).append(panel)
    rows, columns, *_ = next(iter(places)).get_geometry()
    gaps, between = np.zeros((rows, columns + 1)), np.zeros((rows + 1, columns))
    for spec, panels in places.items():
        inner = Bbox.union([panel.get_position(original=True) for panel in panels]).transformed(figure.transFigure)
        outer = [OUTWARDS * panel.bbox.extents + around[panel].room for panel in panels]
        room = np.max(outer, axis=0) - OUTWARDS * inner.extents
        across, down = slice(spec.colspan.start, spec.colspan.stop), slice(spec.rowspan.start, spec.rowspan.stop)
        gaps[down, across.start] += room[LEFT]
        gaps[down, across.stop] += room[RIGHT]
        between[down.start, across] += room[TOP]
        between[down.stop, across] += room[BOTTOM]
    width, height = figure.bbox.size
    left, right = (max(gaps[:, end].max(), 0.0) + EDGE for end in (0, -1))
    top, bottom = (max(between[end].max(), 0.0) + EDGE for end in (0, -1))
    top += heading
    column_gap = gaps[:, 1:-1].max(initial=0.0) + COLUMN_GAP
    row_gap = between[1:-1].max(initial=0.0) + ROW_GAP
    panel_width = (width - left - right - column_gap * (columns - 1)) / columns
    panel_height = (height - top - bottom - row_gap * (rows - 1)) / rows
    if min(panel_width, panel_height) <= 0:
        return {}
    return {
        "left": left / width,
        "right": 1 - right / width,
        "bottom": bottom / height,
        "top": 1 - top / height,
        "wspace": column_gap / panel_width,
        "hspace": row_gap / panel_height,
    }
