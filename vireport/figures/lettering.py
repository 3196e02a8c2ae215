"""Finds room for letters next to the points they belong to, clear of the curves and of each other.

Works on one panel in points (1/72 inch), on a grid of cells that counts what is drawn where.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CELL = 2.5
"""Side of a cell [pt]; the width of a stroke."""

GAP = 2.0
"""Room kept free around a text [pt]."""

FRAME = 0.5
"""Room kept free towards the frame of the panel [pt]."""

REACH = (5.0, 9.0, 14.0, 21.0, 32.0)
"""Distances from the point to the edge of the text that are tried [pt]."""

LEADER = 13.0
"""Distance from which a line leads from the text to its point [pt]."""

MISTAKEN = 6.0
"""How bad it is to stand nearer to the point of another text, in cells of a curve."""

TEXT_WEIGHT = 40.0
"""How much worse it is to cover a text than a curve."""


class Room:
    """What is drawn on a panel, and where there is room for a text.

    Parameters
    ----------
    width, height : float
        Of the panel [pt].
    """

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self._shape = int(height / CELL) + 2, int(width / CELL) + 2
        self._weight = np.zeros(self._shape)
        angle = np.arange(12) * (np.pi / 6)
        self._direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def draw(self, x: Floats, y: Floats, weight: float = 1.0) -> None:
        """Record curves [pt], broken where they are NaN; `weight` is how bad it is to cover them."""
        ahead = np.hypot(np.diff(x), np.diff(y))
        short = ahead[ahead < 4 * self.width]
        count = int(np.clip(np.ceil(short.max() / CELL), 1, 40)) if len(short) else 1
        part = np.arange(count) / count
        x = np.append((x[:-1, None] + part * np.diff(x)[:, None]).ravel(), x[-1:])
        y = np.append((y[:-1, None] + part * np.diff(y)[:, None]).ravel(), y[-1:])
        inside = (x >= 0) & (x <= self.width) & (y >= 0) & (y <= self.height)
        row, column = (y[inside] / CELL).astype(np.intp), (x[inside] / CELL).astype(np.intp)
        self._weight[row, column] = np.maximum(self._weight[row, column], weight)

    def beside(self, anchors: Floats, others: Floats, width: float, height: float) -> tuple[Floats, Floats | None]:
        """Place a text next to one of its points, and record it.

        Parameters
        ----------
        anchors : ndarray of shape (k, 2)
            The points it may stand at [pt], preferred first.
        others : ndarray of shape (k, 2)
            Points that it must not seem to belong to.
        width, height : float
            Of the text [pt].

        Returns
        -------
        ndarray
            Centre of the text.
        ndarray or None
            Ends of the line from its point to it, where it stands far off.
        """
        half = np.array([width, height]) / 2
        distance = np.array(REACH)[:, None, None] + (np.abs(self._direction) @ half)[None, :, None]
        offset = (distance * self._direction).reshape(-1, 2)
        centre = (anchors[:, None, :] + offset).reshape(-1, 2)
        far = np.tile(np.repeat(REACH, len(self._direction)), len(anchors))
        order = np.repeat(np.arange(len(anchors)), len(offset))
        own = np.hypot(*(centre - anchors[order]).T)
        mistaken = (np.hypot(*(centre.T[:, :, None] - others.T[:, None])) < own[:, None] + GAP).any(axis=1)
        best = int(np.argmin(self._cost(centre, half) + 0.06 * far + 0.3 * order + MISTAKEN * mistaken))
        self._take(centre[best], half)
        if far[best] < LEADER:
            return centre[best], None
        start = anchors[order[best]]
        way = centre[best] - start
        return centre[best], np.stack([start, start + way * (1 - np.min(half / np.maximum(np.abs(way), 1e-9)))])

    def along(self, x: float, width: float, height: float) -> Floats:
        """Place a text beside a vertical line at `x`, as low as there is room, and return its centre."""
        half = np.array([width, height]) / 2
        y = np.arange(half[1] + GAP, self.height - half[1] - GAP, CELL)
        centre = np.concatenate(
            [np.stack([np.full(len(y), x + side * (half[0] + GAP + 1)), y], axis=1) for side in (1, -1)]
        )
        best = int(np.argmin(self._cost(centre, half) + 0.001 * np.arange(len(centre))))
        self._take(centre[best], half)
        return np.asarray(centre[best])

    def _cost(self, centre: Floats, half: Floats) -> Floats:
        low, high = centre - half - GAP, centre + half + GAP
        inset = GAP - FRAME
        outside = (low < -inset).any(axis=1) | (high > [self.width + inset, self.height + inset]).any(axis=1)
        total = np.zeros((self._shape[0] + 1, self._shape[1] + 1))
        self._weight.cumsum(0).cumsum(1, out=total[1:, 1:])
        most = [self._shape[1] - 1, self._shape[0] - 1]
        left, bottom = np.clip(low / CELL, 0, most).astype(np.intp).T
        right, top = np.clip(high / CELL, 0, most).astype(np.intp).T + 1
        covered = total[top, right] - total[bottom, right] - total[top, left] + total[bottom, left]
        return np.asarray(covered + 1e6 * outside)

    def _take(self, centre: Floats, half: Floats) -> None:
        most = [self._shape[1] - 1, self._shape[0] - 1]
        (left, bottom), (right, top) = np.clip([(centre - half) / CELL, (centre + half) / CELL], 0, most).astype(
            np.intp
        )
        self._weight[bottom : top + 1, left : right + 1] += TEXT_WEIGHT
