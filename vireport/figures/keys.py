"""A legend as one artist that is laid out once: Matplotlib's packs its entries anew for each size and each drawing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import Affine2D, Bbox, ScaledTranslation

from vireport.figures.vector import PER_INCH, text_size

# Over the size of type, as in Matplotlib's legends: widths of a line and of a mark, room beside them, between rows and
# between columns, and height of their middle over the baseline.
LINE, MARK, BESIDE, ROWS, COLUMNS, MIDDLE = 2.6, 1.0, 0.8, 0.5, 1.4, 0.35


class Key(Artist):
    """Lines and marks with their names, in columns that are read line by line; one of the legends of a figure.

    Parameters
    ----------
    figure : Figure
    entries : sequence of (str, dict)
        Names, and the looks of their lines or marks.
    size : float
        Of the type [pt].
    room : float
        Width that there is [pt]: it has as many columns as fit, and at least one.
    """

    def __init__(self, figure: Figure, entries: Sequence[tuple[str, dict[str, Any]]], size: float, room: float) -> None:
        super().__init__()
        self.set_zorder(5)
        marks_only = all(look.get("linestyle") == "none" for _, look in entries)
        handle = size * (MARK if marks_only else LINE)
        self.legend_handles = [Line2D([0.0] * 3, [0.0] * 3, **{**look, "markevery": [1]}) for _, look in entries]
        self._texts = [Text(0, 0, name, va="baseline", size=size) for name, _ in entries]
        legends: list[Any] = figure.legends
        legends.append(self)
        for artist in (self, *self.get_children()):
            artist.set_figure(figure)
        boxes = [text.get_window_extent() for text in self._texts]
        widths = [handle + BESIDE * size + box.width * PER_INCH / figure.dpi for box in boxes]
        heights = [box.height * PER_INCH / figure.dpi for box in boxes]

        def columns(count: int) -> list[float]:
            return [max(widths[k::count]) + COLUMNS * size for k in range(count)]

        fitting = (k for k in range(len(entries), 1, -1) if sum(columns(k)) - COLUMNS * size <= room)
        count = next(fitting, 1)
        left = np.cumsum([0.0, *columns(count)])
        top = np.cumsum([0.0, *(max(heights[k : k + count]) + ROWS * size for k in range(0, len(entries), count))])
        self.size = float(left[-1]) - COLUMNS * size, float(top[-1]) - ROWS * size
        for k, (line, text, box) in enumerate(zip(self.legend_handles, self._texts, boxes, strict=True)):
            x, y = float(left[k % count]), -float(top[k // count])
            base = y - box.y1 * PER_INCH / figure.dpi
            if "\n" in text.get_text():  # the line is beside the middle of its name
                _, high, low = text_size("lp", text.get_fontproperties())
                base = y - (heights[k] + high - low) / 2
            line.set_data([x, x + handle / 2, x + handle], [base + MIDDLE * size] * 3)
            text.set(position=(x + handle + BESIDE * size, y), va="top")
        self.place(0.0, 1.0)

    def place(self, across: float, up: float) -> None:
        """Put its upper left corner somewhere, in shares of the width and the height of the figure."""
        figure: Any = self.figure
        corner = ScaledTranslation(across, up, figure.transFigure)
        self.set_transform(Affine2D().scale(1 / PER_INCH) + figure.dpi_scale_trans + corner)
        for artist in self.get_children():
            artist.set_transform(self.get_transform())

    def get_texts(self) -> list[Text]:
        """The names."""
        return self._texts

    def get_children(self) -> list[Artist]:
        """The lines and their names."""
        return [*self.legend_handles, *self._texts]

    def get_window_extent(self, renderer: Any = None) -> Bbox:
        """The box around it [px]."""
        width, height = self.size
        return Bbox(self.get_transform().transform([(0.0, -height), (width, 0.0)]))

    def draw(self, renderer: Any) -> None:
        """Draw the lines and their names."""
        for artist in self.get_children():
            artist.draw(renderer)
