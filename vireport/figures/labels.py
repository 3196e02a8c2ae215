"""Writes labels next to the points they belong to, clear of curves, markers, texts and each other.

Labels of points that coincide are written as one. Each label is tried at some distances around each of its points; the
place that covers least is taken. What lies where is counted on a grid of small cells, which is read from the lines and
texts of the panel. Lengths are in points.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.transforms import IdentityTransform
from msgspec import Struct, field
from msgspec.structs import replace

from vireport.figures.curves import Floats
from vireport.figures.style import Color, Look, sheet
from vireport.figures.vector import text_size

CELL = 2.5
"""Side of a cell: about the width of a curve."""

CLEARANCE, INSET = 2.0, 5.0
"""Free room around a label, and between a label and the frame, which has ticks."""

COINCIDE = 3.0
"""Distance below which markers cannot be told apart."""

REACH = (5.0, 9.0, 14.0, 21.0, 32.0, 46.0, 64.0)
"""Distances from the point to the edge of the label that are tried."""

LEADER_FROM = 13.0
"""Distance from which a line leads from the label to its point."""

LEADER: Look = {"color": Color.BLACK, "linewidth": 0.5, "zorder": 5}

DIRECTIONS = np.stack([np.cos(np.arange(24) * np.pi / 12), np.sin(np.arange(24) * np.pi / 12)], axis=1)

# How bad it is to cover a cell of a line, a marker and another label.
ON_LINE, ON_MARKER, ON_LABEL = 3.0, 8.0, 40.0
# How bad it is to stand nearer to the point of another label, to be far [1/pt], and to prefer a later point.
NEARER_TO_OTHER, FAR, LATER = 6.0, 0.04, 0.3
OFF_PANEL = 1e6


class Label(Struct, frozen=True, eq=False):
    """A text and the points in data coordinates that it may stand at, the preferred one first.

    `link` is the anchor of an HTML page that it leads to. One that is `spare` is left out where it has room nowhere on
    the panel, or only on another label.
    """

    text: str
    x: Floats
    y: Floats
    size: float = field(default_factory=lambda: sheet().text)
    color: str = Color.BLACK
    link: str | None = None
    spare: bool = False


def write_labels(axes: Axes, labels: Sequence[Label]) -> None:
    """Write each label where it covers least, in the order given; a label whose points are off the panel is left out.

    The layout of the figure must be final.
    """
    if not labels:
        return
    panel = _Panel(axes)
    visible_labels: list[tuple[Label, Floats]] = []
    for label in labels:
        inside = panel.inside(panel.points(np.column_stack([label.x, label.y]), axes.transData))
        same = (k for k, (_, places) in enumerate(visible_labels) if _coincide(inside, places))
        if (k := next(same, None)) is not None:
            before, places = visible_labels[k]
            visible_labels[k] = replace(before, text=f"{before.text}, {label.text}"), places
        elif len(inside):
            visible_labels.append((label, inside))
    for k, (label, inside) in enumerate(visible_labels):
        others = [places for _, places in (*visible_labels[:k], *visible_labels[k + 1 :])]
        _write(panel, label, inside, np.concatenate([np.empty((0, 2)), *others]))


def _coincide(points: Floats, others: Floats) -> bool:
    """Whether there is one of some points at each of others, and the other way round."""
    apart = np.hypot(*(points.T[:, :, None] - others.T[:, None]))
    return bool(apart.size) and max(apart.min(0).max(), apart.min(1).max()) < COINCIDE


class _Panel:
    """A panel, and for each of its cells how bad it is to cover it; points are taken from its lower left corner."""

    def __init__(self, axes: Axes) -> None:
        self.axes = axes
        self.scale = 72 / axes.figure.dpi
        self.size = np.array(axes.bbox.size) * self.scale
        self.cost = np.zeros((self.size[::-1] / CELL).astype(np.intp) + 2)
        for line in axes.lines:
            points = self.points(np.asarray(line.get_xydata()), line.get_transform())
            if line.get_linestyle() != "None" and len(points) > 1:
                self.cover_segments(points)
            if line.get_marker() not in ("None", None, ""):
                reach = np.arange(-line.get_markersize() / 2, line.get_markersize() / 2 + CELL, CELL)
                around = np.stack(np.meshgrid(reach, reach), axis=-1).reshape(-1, 1, 2)
                self.cover((points + around).reshape(-1, 2), ON_MARKER)
        for text in axes.texts:
            corners = self.points(text.get_window_extent().get_points(), IdentityTransform())
            if len(self.inside(corners)) == 2:
                self.take(*corners)

    def points(self, values: Floats, transform: Any) -> Floats:
        return np.asarray((transform.transform(values) - self.axes.bbox.p0) * self.scale)

    def inside(self, points: Floats) -> Floats:
        return points[((points >= 0) & (points <= self.size)).all(axis=1)]

    def cover(self, points: Floats, cost: float) -> None:
        column, row = (self.inside(points) / CELL).astype(np.intp).T
        self.cost[row, column] = np.maximum(self.cost[row, column], cost)

    def cover_segments(self, points: Floats) -> None:
        """Record lines between points, which are broken where they are NaN."""
        # As many points on each segment as the longest needs to miss no cell; those that lead far off the panel, where
        # a curve has a pole, would need millions.
        steps = np.diff(points, axis=0)
        lengths = np.hypot(*steps.T)
        longest = lengths[lengths < 2 * self.size.sum()].max(initial=CELL)
        part = np.arange(0, 1, CELL / longest)[:, None, None]
        self.cover(np.concatenate([(points[:-1] + part * steps).reshape(-1, 2), points[-1:]]), ON_LINE)

    def covered(self, low: Floats, high: Floats) -> Floats:
        """How bad it is to cover each of some rectangles."""
        # Sums from the corner on: four of them give the sum over any rectangle, for all places at once.
        total = np.pad(self.cost.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
        left, bottom, right, top = self._cells(low - CLEARANCE, high + CLEARANCE)
        off = ((low < INSET) | (high > self.size - INSET)).any(axis=1)
        inner = total[top, right] - total[bottom, right] - total[top, left] + total[bottom, left]
        return np.asarray(inner + OFF_PANEL * off)

    def crossed(self, starts: Floats, ends: Floats) -> Floats:
        """How bad it is to draw each of some leaders, which may cross curves but no labels."""
        points = starts + np.linspace(0.2, 0.8, 13)[:, None, None] * (ends - starts)
        column, row = np.moveaxis(np.clip(points, 0, self.size) / CELL, -1, 0).astype(np.intp)
        return np.asarray(ON_LABEL * (self.cost[row, column] >= ON_LABEL).any(axis=0))

    def take(self, low: Floats, high: Floats) -> None:
        left, bottom, right, top = self._cells(low, high)
        self.cost[bottom:top, left:right] += ON_LABEL

    def _cells(self, low: Floats, high: Floats) -> tuple[Any, Any, Any, Any]:
        most = np.array(self.cost.shape[::-1]) - 1
        left, bottom = np.clip(low / CELL, 0, most).astype(np.intp).T
        right, top = np.clip(high / CELL, 0, most).astype(np.intp).T + 1
        return left, bottom, right, top


def _write(panel: _Panel, label: Label, anchors: Floats, others: Floats) -> None:
    """Write one label next to one of its points, and record it; `others` are the points of other labels."""
    width, height, descent = text_size(label.text, FontProperties(size=label.size))
    half = np.array([width, height - descent]) / 2  # from the baseline up, as the text is centred below
    distance = np.array(REACH)[:, None, None] + (np.abs(DIRECTIONS) @ half)[None, :, None]
    offsets = (distance * DIRECTIONS).reshape(-1, 2)
    centres = (anchors[:, None, :] + offsets).reshape(-1, 2)
    order = np.repeat(np.arange(len(anchors)), len(offsets))
    far = np.tile(np.repeat(REACH, len(DIRECTIONS)), len(anchors))
    distances = np.hypot(*(centres - anchors[order]).T)
    to_others = np.hypot(*(centres.T[:, :, None] - others.T[:, None])).min(axis=1, initial=np.inf)
    cost = panel.covered(centres - half, centres + half) + FAR * far + LATER * order
    # A label that stands nearer to another point is read as the name of that one.
    cost += NEARER_TO_OTHER * (to_others < distances + CLEARANCE)
    # A leader only adds to the cost: it is looked at where that is less than at every place without one.
    led = far >= LEADER_FROM
    rows = np.flatnonzero(led & (cost < cost[~led].min()))
    to_own = np.hypot(*(centres[rows].T[:, :, None] - anchors.T[:, None])).min(axis=1)
    past_own = ON_LABEL * (distances[rows] > to_own + CLEARANCE)  # a leader that goes past another of its points
    cost[rows] += panel.crossed(anchors[order[rows]], centres[rows]) + past_own
    best = int(np.argmin(cost))
    if label.spare and cost[best] >= ON_LABEL:
        return
    anchor, centre = anchors[order[best]], centres[best]
    panel.take(centre - half, centre + half)
    if far[best] >= LEADER_FROM:
        to_edge = 1 - np.min(half / np.maximum(np.abs(centre - anchor), half))
        leader = np.stack([anchor, anchor + to_edge * (centre - anchor)])
        panel.cover_segments(leader)
        panel.axes.add_artist(Line2D(*(leader / panel.size).T, transform=panel.axes.transAxes, **LEADER))
    panel.axes.text(
        centre[0] / panel.size[0],
        centre[1] / panel.size[1],
        label.text,
        transform=panel.axes.transAxes,
        ha="center",
        va="center_baseline",
        size=label.size,
        color=label.color,
        zorder=6,
        url=label.link,
    )
