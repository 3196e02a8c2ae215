"""The ticks of an axis with their labels and its name, as one artist.

Of each tick Matplotlib makes five artists, and lays every text out again for each size that it needs: with its axes,
figures take nearly twice as long. What is drawn is the same, of the same locators, formatters and names.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.ticker import FixedFormatter, FixedLocator
from matplotlib.transforms import Bbox, IdentityTransform

WITHIN = 1e-9
"""By how much a tick may be beyond the end of its axis, over the range of that."""

OFFSET_PAD = 3.0
"""Between the frame and the power of ten that all labels of an axis share [pt]."""


class Scale(Artist):
    """What Matplotlib would draw of an axis, which is hidden from it: ticks that point inwards, labels and name."""

    axes: Axes

    def __init__(self, axis: Any) -> None:
        super().__init__()
        self.axis = axis
        self.along = 0 if axis.axis_name == "x" else 1
        self.aligned: Sequence[Scale] = (self,)
        own = f"{axis.axis_name}tick"
        settings: Any = matplotlib.rcParams
        self.marks = [(settings[f"{own}.{kind}.size"], settings[f"{own}.{kind}.width"]) for kind in ("major", "minor")]
        self.pad, self.color = settings[f"{own}.major.pad"], settings[f"{own}.color"]
        self._known: dict[float, tuple[float, float]] = {}
        placed: dict[str, Any] = {"ha": "right", "va": "center_baseline"} if self.along else {"ha": "center"}
        self.text = Text(size=settings[f"{own}.labelsize"], color=self.color, transform=IdentityTransform(), **placed)
        self.set_zorder(axis.get_zorder())
        self.set_clip_on(False)
        axis.set_visible(False)
        axis.axes.add_artist(self)
        self.text.set_figure(axis.axes.figure)

    def _on(self, side: str) -> bool:
        return bool(self.axis.get_tick_params().get(side, False))

    @property
    def _far(self) -> bool:
        """Whether it is along the top."""
        return not self.along and self._on("top")

    def _edge(self) -> tuple[float, int]:
        """Where the frame is, and which way is outwards [px]."""
        box = self.axes.bbox
        return (box.y1, 1) if self._far else (float(box.p0[1 - self.along]), -1)

    def _places(self, values: Sequence[float]) -> list[float | None]:
        """Where values are along the axis [px]; None off it."""
        low, high = sorted(self.axis.get_view_interval())
        margin = WITHIN * (high - low)
        points = np.full((len(values), 2), max(low, 0.0) or high)
        points[:, self.along] = values
        places: Any = self.axes.transData.transform(points)[:, self.along] if len(values) else []
        return [
            float(at) if low - margin <= value <= high + margin else None
            for at, value in zip(places, values, strict=True)
        ]

    def _labels(self) -> list[tuple[float, str]]:
        """The places of labels, and their texts."""
        side = "top" if self._far else "left" if self.along else "bottom"
        if not self.axis.get_tick_params().get(f"label{side}", not self._far):
            return []
        values = self.axis.get_majorticklocs()
        texts = self.axis.get_major_formatter().format_ticks(values)
        places = self._places(values)
        return [(at, text) for at, text in zip(places, texts, strict=True) if at is not None and text]

    def _lines(self, renderer: Any) -> tuple[float, float]:
        """How far a line of the labels reaches over its baseline and under it [px]."""
        dpi = float(self.figure.dpi)
        if dpi not in self._known:
            self.text.set(text="0", position=(0, 0), va="baseline")
            box = self.text.get_window_extent(renderer)
            self.text.set(va="center_baseline" if self.along else "bottom" if self._far else "top")
            self._known[dpi] = box.y1, -box.y0
        return self._known[dpi]

    def _size(self, text: str, renderer: Any) -> tuple[float, float]:
        """Width and height of a label [px]."""
        if "$" in text:
            self.text.set_text(text)
            box = self.text.get_window_extent(renderer)
            return box.width, box.height
        width, _, _ = renderer.get_text_width_height_descent(text, self.text.get_fontproperties(), False)
        return width, sum(self._lines(renderer))

    def _depth(self, renderer: Any) -> float:
        """How far the labels reach out of the frame [px]."""
        labels = [text for _, text in self._labels()]
        if not self.along:  # of one line all are equally high
            labels = [text for text in labels if "$" in text] or labels[:1]
        sizes = (self._size(text, renderer)[1 - self.along] for text in labels)
        return max((renderer.points_to_pixels(self.pad) + size for size in sizes), default=0.0)

    def _named(self, renderer: Any) -> list[Text]:
        """The name, and the power of ten that all labels share, where they belong; without those that are empty."""
        name, power, points = self.axis.label, self.axis.offsetText, renderer.points_to_pixels
        power.set_text(self.axis.get_major_formatter().get_offset() if self._labels() else "")
        if name.get_text() or power.get_text():
            edge, out = self._edge()
            depth = max(scale._depth(renderer) for scale in self.aligned)
            away = edge + out * (depth + points(self.axis.labelpad))
            name.set_position((away, name.get_position()[1]) if self.along else (name.get_position()[0], away))
            beside = self.axes.bbox.y1 + points(OFFSET_PAD) if self.along else edge + out * (depth + points(OFFSET_PAD))
            power.set_position((power.get_position()[0], beside))
        return [text for text in (name, power) if text.get_text()]

    def get_window_extent(self, renderer: Any = None) -> Bbox:
        """The box around the labels and the name, which may be longer than the frame."""
        if not self.axes.axison:
            return Bbox.null()
        canvas: Any = self.axes.figure.canvas
        renderer = renderer or canvas.get_renderer()
        boxes = [text.get_window_extent(renderer) for text in self._named(renderer)]
        name = self.axis.label.get_text()
        if boxes and name:  # a name that is too long makes no room for itself
            middle = (boxes[0].p0 + boxes[0].p1) / 2
            low, high = boxes[0].p0, boxes[0].p1
            low[self.along] = high[self.along] = middle[self.along]
            boxes[0] = Bbox([low, high])
        boxes += [box for _, box in self.boxes(renderer)]
        return Bbox.union(boxes) if boxes else Bbox.null()

    def boxes(self, renderer: Any) -> list[tuple[str, Bbox]]:
        """The labels of the ticks, and the boxes that they fill [px]."""
        edge, out = self._edge()
        start, (over, under) = edge + out * renderer.points_to_pixels(self.pad), self._lines(renderer)
        found = []
        for at, text in self._labels():
            width, height = self._size(text, renderer)
            across = sorted([start, start + out * (width if self.along else height)])
            reach = [at - over / 2 - under, at + over / 2] if self.along else [at - width / 2, at + width / 2]
            box = Bbox(np.transpose([across, reach] if self.along else [reach, across]))
            if "$" in text:
                self.text.set(text=text, position=(start, at) if self.along else (at, start))
                box = self.text.get_window_extent(renderer)
            found.append((text, box))
        return found

    def draw(self, renderer: Any) -> None:
        """Draw the ticks, their labels and the name."""
        if not self.axes.axison:
            return
        edge, out = self._edge()
        if self._on("top" if self._far else "left" if self.along else "bottom"):
            for values, (length, width) in zip(
                (self.axis.get_majorticklocs(), self.axis.get_minorticklocs()), self.marks, strict=True
            ):
                self._draw_marks(renderer, self._places(values), (edge, edge - out * length), width)
        self._draw_labels(renderer, edge + out * renderer.points_to_pixels(self.pad))
        for text in self._named(renderer):
            text.draw(renderer)

    def _draw_marks(
        self, renderer: Any, places: Iterable[float | None], ends: tuple[float, float], width: float
    ) -> None:
        start, end = ends[0], ends[0] + renderer.points_to_pixels(ends[1] - ends[0])
        lines = [[(at, start), (at, end)] for at in places if at is not None]
        if not lines:
            return
        vertices = np.array(lines).reshape(-1, 2)[:, :: -1 if self.along else 1]
        gc = renderer.new_gc()
        gc.set_linewidth(renderer.points_to_pixels(width))
        gc.set_foreground(self.color)
        renderer.draw_path(gc, Path(vertices, [Path.MOVETO, Path.LINETO] * len(lines)), IdentityTransform())
        gc.restore()

    def _draw_labels(self, renderer: Any, away: float) -> None:
        labels = self._labels()
        if not labels:
            return
        over, under = self._lines(renderer)
        gc, font = renderer.new_gc(), self.text.get_fontproperties()
        gc.set_foreground(self.color)
        height = renderer.get_canvas_width_height()[1]
        for at, text in labels:
            x, y = (away, at) if self.along else (at, away)
            self.text.set(text=text, position=(x, y))
            if "$" in text:
                self.text.draw(renderer)
                continue
            width, _ = self._size(text, renderer)
            left = x - width if self.along else x - width / 2
            base = y - over / 2 if self.along else y + under if self._far else y - over
            renderer.draw_text(gc, left, height - base if renderer.flipy() else base, text, font, 0.0, False, self.text)
        gc.restore()


def scaled(axes: Axes) -> tuple[Scale, Scale]:
    """Have the axes of a panel drawn this way."""
    return Scale(axes.xaxis), Scale(axes.yaxis)


def put_ticks(axis: Axis, values: Iterable[float], texts: Iterable[str]) -> None:
    """Place the ticks of an axis; `Axis.set_ticks` would make them at once."""
    axis.set_major_locator(FixedLocator(list(values)))
    axis.set_major_formatter(FixedFormatter(list(texts)))


def align_names(panels: Iterable[Axes]) -> None:
    """Let the names of vertical axes stand above one another."""
    scales = [artist for axes in panels for artist in axes.get_children() if isinstance(artist, Scale) and artist.along]
    for scale in scales:
        scale.aligned = scales
