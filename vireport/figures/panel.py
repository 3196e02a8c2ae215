"""One panel of a sheet: what is drawn on it, and the texts that find their own place there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from vireport.figures.axes import BLACK, GREY, TEXT
from vireport.figures.curves import Curve, Floats, joined
from vireport.figures.lettering import Room

LETTER_WIDTH = 0.66
"""Mean width of a letter over the size of type, on the wide side."""


@dataclass(frozen=True, slots=True)
class Panel:
    """One panel of a sheet, its limits, and the room that is left on it.

    Attributes
    ----------
    axes : Axes
    x, y : tuple of float
        Limits.
    room : Room
    first : bool
        Whether it is the top one.
    """

    axes: Axes
    x: tuple[float, float]
    y: tuple[float, float]
    room: Room
    first: bool

    def curves(self, parts: Sequence[Curve], **look: Any) -> None:
        """Draw curves of one look as one line, broken between them; nothing where there are none."""
        if not parts:
            return
        x, y = joined(parts)
        self.axes.add_artist(Line2D(x, y, **look))
        self.room.draw(*self.points(x, y))

    def marks(self, x: Floats, y: Floats, **look: Any) -> None:
        """Draw single points, those that are on the panel."""
        inside = (y >= self.y[0]) & (y <= self.y[1])
        if inside.any():
            self.axes.add_artist(Line2D(x[inside], y[inside], **look))
            self.room.draw(*self.points(np.repeat(x[inside], 2), np.repeat(y[inside], 2)), weight=8.0)

    def level(self, y: float, **look: Any) -> None:
        """Draw a horizontal line across the panel."""
        self.curves([(np.array(self.x), np.array([y, y]))], **look)

    def upright(self, x: Floats, **look: Any) -> None:
        """Draw vertical lines from bottom to top."""
        ends = np.array([self.y[0], self.y[1], np.nan])
        self.axes.add_artist(Line2D(np.repeat(x, 3), np.tile(ends, len(x)), **look))

    def letters(self, texts: Sequence[tuple[str, Floats, Floats]]) -> None:
        """Write labels, each next to one of the points it belongs to, the first that leaves it room."""
        inside = [(text, (y >= self.y[0]) & (y <= self.y[1]), x, y) for text, x, y in texts]
        shown = [(text, np.stack(self.points(x[at], y[at]), axis=1)) for text, at, x, y in inside if at.any()]
        for k, (text, anchors) in enumerate(shown):
            others = [points for other, (_, points) in enumerate(shown) if other != k]
            apart = np.concatenate([*others, np.empty((0, 2))])
            centre, leader = self.room.beside(anchors, apart, LETTER_WIDTH * TEXT * len(text), 0.8 * TEXT)
            if leader is not None:
                self.axes.add_artist(Line2D(*self.data(leader), color=BLACK, linewidth=0.5))
            self._write(text, centre, size=TEXT)

    def tag(self, text: str, x: float) -> None:
        """Write a small text beside a vertical line."""
        centre = self.room.along(
            self.points(np.array([x]), np.array([self.y[0]]))[0][0], LETTER_WIDTH * 7 * len(text), 6.0
        )
        self._write(text, centre, size=7, color=GREY)

    def say(self, text: str) -> None:
        """Write a sentence in the middle of an empty panel."""
        centre = np.array([self.room.width, self.room.height]) / 2
        self._write(text, centre, size=TEXT + 1, color=BLACK)

    def points(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """From data to points (1/72 inch) on the panel."""
        return (
            (x - self.x[0]) * (self.room.width / (self.x[1] - self.x[0])),
            (y - self.y[0]) * (self.room.height / (self.y[1] - self.y[0])),
        )

    def data(self, points: Floats) -> tuple[Floats, Floats]:
        """From rows of points on the panel to data."""
        return (
            self.x[0] + points[:, 0] * ((self.x[1] - self.x[0]) / self.room.width),
            self.y[0] + points[:, 1] * ((self.y[1] - self.y[0]) / self.room.height),
        )

    def _write(self, text: str, centre: Floats, **look: Any) -> None:
        x, y = centre / [self.room.width, self.room.height]
        self.axes.text(x, y, text, transform=self.axes.transAxes, ha="center", va="center_baseline", zorder=6, **look)
