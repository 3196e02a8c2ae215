"""Finds places for names in a plane of curves: along a curve, beside the bar of a margin, around a point.

Names overlap nothing: of the places that are tried, the first is taken at which the name covers no curve, bar or other
name, and the fewest thin lines. All that is drawn is held as a cloud of points. Lengths are in inches of the panel.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from msgspec import Struct, field
from numpy.typing import NDArray

from vireport.figures.curves import Floats
from vireport.figures.style import PER_LETTER, sheet

DENSE = 0.03
"""Distance of the points of a cloud."""

GAP, EDGE = 0.045, 0.06
"""Free room around a name, and between it and the frame."""

CROSS = 9.0
"""Size of the mark of a design point [pt]."""

TEXT_ROOM = 0.7
"""Part of the room around a point that the name of an area may fill, so that it stays clear of the curves."""

STATIONS = 40
"""Places along a curve at which its name is tried."""

Place = tuple[float, float, float]
"""The middle of a name, and its angle [rad]."""


class Paper(Struct, eq=False):
    """A panel with what is drawn in it.

    Attributes
    ----------
    axes : Axes
        With its final limits.
    size : tuple of float
        Width and height of the panel.
    solid, thin : list of ndarray
        Points of things that no name may cover, and of things that it should not cover.
    """

    axes: Axes
    size: tuple[float, float]
    solid: list[Floats] = field(default_factory=list)
    thin: list[Floats] = field(default_factory=list)

    def inches(self, points: Any) -> Floats:
        """Places in the panel [in] of points in data coordinates."""
        low, high = np.array([self.axes.get_xlim(), self.axes.get_ylim()]).T
        return np.asarray((np.asarray(points, dtype=float) - low) / (high - low) * self.size)

    def draw(self, line: Any, thin: bool = False) -> None:
        """Add a line to what is there; NaN breaks it."""
        (self.thin if thin else self.solid).append(dense(self.inches(line)))

    def write(self, text: str, places: Iterator[Place], **look: object) -> bool:
        """Write a name at the best of some places, the preferred ones first; whether there is room for it."""
        half = half_of(text, sheet().small)
        solid, thin = (np.concatenate([np.empty((0, 2)), *clouds]) for clouds in (self.solid, self.thin))
        best: tuple[int, Place] | None = None
        for place in places:
            box = _corners(place, half + EDGE)
            if (box < 0).any() or (box > self.size).any() or covered(place, half + GAP, solid):
                continue
            least = covered(place, half, thin)
            if best is None or least < best[0]:
                best = least, place
            if not least:
                break
        if best is not None:
            self.put(text, best[1], sheet().small, **look)
        return best is not None

    def put(self, text: str, place: Place, size: float, **look: Any) -> None:
        """Write a name at a place, and add it to what is there."""
        x, y, angle = place
        self.block(place, half_of(text, size))
        self.axes.text(
            x / self.size[0], y / self.size[1], text, transform=self.axes.transAxes, rotation=float(np.degrees(angle)),
            rotation_mode="anchor", ha="center", va="center", size=size, **{"zorder": 6} | look,
        )  # fmt: skip

    def mark(
        self, at: Sequence[float], ends: Sequence[Sequence[float]], margins: Sequence[str], name: str, **look: object
    ) -> bool:
        """Write what a design point is called, and the margins beside their bars; whether the name has a place."""
        cross = self.inches(at)
        for end in ends:
            self.draw([at, end])
        self.block((float(cross[0]), float(cross[1]), 0.0), np.full(2, CROSS / 144))
        for text, end in zip(margins, ends, strict=True):
            self.write(text, near_bar(cross, self.inches(end), text), **look)
        return self.write(name, around(cross, name), **look)

    def name(self, area: NDArray[np.bool_], text: str, every: bool = True, **look: object) -> bool:
        """Write a name in the middle of the widest place of each part of an area that has room; whether one has.

        Parameters
        ----------
        area : ndarray
            Which cells of a grid over the panel belong to it: from left to right, and in each column upwards.
        text : str
        every : bool
            Whether to name all its parts, or the largest that has room alone.
        """
        from scipy.ndimage import distance_transform_edt, label  # type: ignore[import-untyped]

        big = sheet().text
        half, shape, size = half_of(text, big), np.array(area.shape), np.array(self.size)
        free, placed = area.copy(), False
        rooms = []
        for clouds in (self.solid, self.thin):
            for cloud in clouds:
                free[tuple(np.clip(cloud / size * shape, 0, shape - 1).astype(int).T)] = False
            # Distances over the half sides of the text, so that a long name takes a wide place.
            rooms.append(distance_transform_edt(np.pad(free, 1), sampling=size / shape / half)[1:-1, 1:-1])
        parts, count = label(area)
        sizes = np.bincount(parts.ravel(), minlength=count + 1)[1:]
        for k in (np.argsort(-sizes, kind="stable") + 1).tolist():
            for room in reversed(rooms):  # on a thin line only where there is no other place
                inside = np.where(parts == k, room, 0.0)
                place = np.unravel_index(int(inside.argmax()), inside.shape)
                if inside[place] * TEXT_ROOM > 1:
                    x, y = ((np.array(place) + 0.5) / shape * size).tolist()
                    self.put(text, (x, y, 0.0), big, **{"zorder": 2.2} | look)
                    placed = True
                    break
            if placed and not every:
                break
        return placed

    def block(self, place: Place, half: Floats) -> None:
        """Add a name to what is there."""
        x, y = (np.linspace(-h, h, 2 + int(2 * h / DENSE)) for h in half)
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        self.solid.append(grid @ _turn(-place[2]) + np.array(place[:2]))

    def near_curve(self, points: Any, text: str) -> Iterator[Place]:
        """Places along a curve, on either side of it, from its middle on; NaN breaks it."""
        width, height = half_of(text, sheet().small)
        length, off = 2 * width, height + 1.5 * GAP
        curve = dense(self.inches(points))
        if len(curve) < 2:
            return
        way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))])
        stations = np.linspace(0, way[-1], STATIONS + 2)[1:-1]
        for station in sorted(stations.tolist(), key=lambda pair: abs(pair - way[-1] / 2)):
            part = curve[(way >= station - length / 2) & (way <= station + length / 2)]
            if len(part) < 2 or np.hypot(*(part[-1] - part[0])) < 0.9 * length:
                continue
            dx, dy = part[-1] - part[0]
            angle = float(np.arctan2(dy, dx))
            angle += np.pi * (angle <= -np.pi / 2) - np.pi * (angle > np.pi / 2)
            normal = np.array([-np.sin(angle), np.cos(angle)])
            # Beside the chord of the curve: as far as its bow takes.
            bow = (part - part.mean(axis=0)) @ normal
            for side, reach in ((1, bow.max()), (-1, bow.min())):
                x, y = part.mean(axis=0) + normal * (reach + side * off)
                yield float(x), float(y), angle


def half_of(text: str, size: float) -> Floats:
    """Half the width and height of a name."""
    return np.array([len(text) * PER_LETTER * size, size]) / 144


def near_bar(at: Floats, end: Floats, text: str) -> Iterator[Place]:
    """Places of a horizontal name beside a level or an upright bar, near its middle."""
    half = half_of(text, sheet().small) + 1.6 * GAP
    level = abs(end[1] - at[1]) < abs(end[0] - at[0])
    for share in (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.1, 0.9, 0.0, 1.0):
        middle = at + share * (end - at)
        for side, more in ((1, 0.0), (-1, 0.0), (1, GAP), (-1, GAP)):
            x, y = middle + side * (np.array([0.0, half[1] + more]) if level else np.array([-half[0] - more, 0.0]))
            yield float(x), float(y), 0.0


def around(at: Floats, text: str) -> Iterator[Place]:
    """Places of a horizontal name around a point, the nearest first."""
    half = half_of(text, sheet().small)
    for reach in (0.12, 0.18, 0.25):
        for dx, dy in ((-1, 1), (1, -1), (-1, -1), (1, 1), (-1, 0), (1, 0), (0, 1), (0, -1)):
            x, y = at + np.array([dx, dy]) * (half + reach * (0.6 if dx and dy else 1.0))
            yield float(x), float(y), 0.0


def dense(points: Floats) -> Floats:
    """A line as points that are close together; NaN breaks it."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    counts = np.where(np.isfinite(steps), np.minimum(steps / DENSE, 1e4), 0).astype(int) + 1
    pieces = [a + (b - a) * np.arange(n)[:, None] / n for a, b, n in zip(points, points[1:], counts, strict=False)]
    points_between = np.concatenate([*pieces, points[-1:]])
    return np.asarray(points_between[np.isfinite(points_between).all(axis=1)])


def covered(place: Place, half: Floats, cloud: Floats) -> int:
    """Number of points of a cloud that a name covers."""
    away = np.abs((cloud - np.array(place[:2])) @ _turn(place[2]))
    return int((away < half).all(axis=1).sum())


def _turn(angle: float) -> Floats:
    """The matrix that turns rows of coordinates by minus an angle, into the frame of a name at that angle."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def _corners(place: Place, half: Floats) -> Floats:
    signs: Sequence[tuple[int, int]] = ((1, 1), (1, -1), (-1, 1), (-1, -1))
    return np.array(place[:2]) + (np.array(signs) * half) @ _turn(-place[2])
