"""Where among all flight times the motions of a sweep can be: proved by leaving out all other flight times.

The flight times of a motion with three impacts are a point of a triangle, which is divided into cells; that of one with
two on the same membrane is a point of a line. A cell is left out when affine arithmetic shows that none of the
solutions above it is a motion of the sweep; what is left is halved.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import factorial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import Held
from vireport.physics import Affine, AffineOps, between, flight
from vireport.sequences.equations import Model
from vireport.sequences.motions import Sequence
from vireport.sequences.surface import (
    Motions,
    Solution,
    motions_above,
    onto_sweep,
    room,
    solution,
    sweep_conditions,
    within,
)

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

COARSEST, FINE, FINEST = 1 / 8, 1 / 512, 1 / 2048
"""Sides of the first cells [t_c], larger than which are hardly ever left out, of those that are looked for motions, and
of the last ones in a plane, to which only those are halved that are not near to motions known."""

FEW = 60
"""Cells up to which sides are divided into four, not two: a step costs as much as a thousand cells."""

MOST_CELLS = 20_000
"""Cells that are divided once more: where more are left, as above a sweep over decades, they stay as they are."""

REACH = 4
"""Sides of a cell over which a motion is looked for from its centre."""

BLOCK = 4096
"""Cells evaluated at once: their numbers stay in the processor's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Squares of pairs of flight times, or intervals of one, that may hold motions of a sweep.

    Attributes
    ----------
    sequence : Sequence
    corner : ndarray (N - 1, n)
        The lower ends of all flight times but the last [t_c].
    side : float
        [t_c].
    """

    sequence: Sequence
    corner: Floats
    side: float

    def __len__(self) -> int:
        """Return their number."""
        return self.corner.shape[1]

    def __getitem__(self, index: Any) -> Cells:
        """Some of them."""
        return Cells(self.sequence, self.corner[:, index], self.side)

    @property
    def centre(self) -> Floats:
        """The flight times in the middle of each."""
        return self.corner + self.side / 2

    def no_larger_than(self, side: float) -> bool:
        """Whether they are squares of at most this side, or intervals, a larger share of a line, of a quarter of it."""
        return self.side <= (side if len(self.corner) > 1 else side / 4)

    @property
    def share(self) -> float:
        """Of all flight times, each motion counted from one impact."""
        sides = len(self.corner)
        part = (self.side / (2 * self.sequence.periods)) ** sides * factorial(sides)
        return float(len(self) * part * (1 + len(self.sequence.symmetries)))


@dataclass(frozen=True, slots=True)
class Exclusion:
    """What the motions are that are looked for.

    Attributes
    ----------
    model : Model
    low, high : float
        Range of the coordinate.
    sequence : Sequence
        Three impacts, not all on the top, or two on the bottom.
    """

    model: Model
    low: float
    high: float
    sequence: Sequence

    @property
    def shortest(self) -> float:
        """Time below which no flight can cross [t_c].

        No impact is faster than by (2.11) with the decay r, and no flight gains more than 1 + gbar in a unit of time.
        """
        d, gbar = self.model.groups(max(self.low, 0.0))[0], self.model.groups(self.high)[1]
        speed = (2 * self.sequence.periods * gbar + 2 / np.pi) / (1 - self.model.r)
        start = self.model.r * speed
        return float(2 * d / (start + np.sqrt(start * start + 2 * d * (1 + gbar))))

    def cells(self) -> Cells:
        """The cells that are left of all flight times."""
        sides = len(self.sequence) - 1
        side = COARSEST if sides > 1 else FINE
        count = round(2 * self.sequence.periods / side)
        cells = self._left(side * np.indices((count,) * sides, dtype=float).reshape(sides, -1), side)
        while cells.side > FINE and len(cells) <= MOST_CELLS:
            cells = self.divided(cells)
        return cells

    def divided(self, cells: Cells) -> Cells:
        """The parts that are left of cells, each divided along each side."""
        sides, count = len(cells.corner), 4 if len(cells) <= FEW else 2
        side, parts = cells.side / count, np.indices((count,) * sides).reshape(sides, 1, -1)
        return self._left((cells.corner[:, :, None] + side * parts).reshape(sides, -1), side)

    def motions(self, cells: Cells) -> tuple[Motions, Floats]:
        """The motions of the sweep next to the centres of cells, with all their flight times but the last."""
        level = self.model.level
        start = self._above(cells.corner, cells.side)
        found, flights = onto_sweep(start, cells.centre, level, REACH * cells.side)
        found, rows = within(self._placed(found), level, self.low, self.high)
        return found, flights[:, rows]

    def _above(self, corner: Floats, side: float) -> Motions:
        return self._placed(motions_above(self.sequence, corner + side / 2, self.model.r))

    def _placed(self, motions: Motions) -> Motions:
        if not self.sequence.one_sided:
            return motions
        return replace(motions, d=room(self.model.level, self.high, motions.gbar) + 0 * motions.gbar)

    def _left(self, corner: Floats, side: float) -> Cells:
        last, walls, shortest = 2 * self.sequence.periods - corner.sum(axis=0), self.sequence.walls, self.shortest
        longest, ends = (*(corner + side), last), zip(walls, (*walls[1:], walls[0]), strict=True)
        least = [shortest if wall != other else 0 for wall, other in ends]
        possible = [time > limit for time, limit in zip(longest, least, strict=True)]
        possible += [longest[i] >= corner[0] for i in self.sequence.symmetries]  # counted from before the shortest
        corner = corner[:, np.all(possible, axis=0)]
        parts = [self._possible(corner[:, i : i + BLOCK], side) for i in range(0, corner.shape[1], BLOCK)]
        return Cells(self.sequence, np.concatenate([corner[:, :0], *parts], axis=1), side)

    def _possible(self, corner: Floats, side: float) -> Floats:
        """The cells that may hold motions of the sweep."""
        x = solution(self.sequence, _boxes(corner, side), self.model.r, AffineOps)
        rows = np.flatnonzero(self._solved(x))
        if side <= FINE:
            rows = rows[~self._beyond_walls(corner[:, rows], side, x, rows)]
        return corner[:, rows]

    def _solved(self, x: Solution) -> Mask:
        """Which may be solutions of the sweep with velocities of the right signs."""
        possible = np.all([(y.lower <= 0) & (y.upper >= 0) for y in sweep_conditions(x, self.model)], axis=0)
        scale = x.sine * x.sine + x.cosine * x.cosine
        coordinate = x.gbar if self.model.level.held is Held.D else self._d(x)
        square = coordinate * coordinate
        possible &= (square - scale * (max(self.low, 0.0) ** 2)).upper >= 0
        possible &= (square - scale * (self.high * self.high)).lower <= 0
        # The sign of the factor makes d positive, and with it gbar and the velocities towards the walls.
        positive = [x.positive, *(v * float(wall) for v, wall in zip(x.velocity, self.sequence.walls, strict=True))]
        if not self.model.level.horizontal:
            positive.append(x.gbar)
        above, below = zip(*((y.lower > 0, y.upper < 0) for y in positive), strict=True)
        return np.asarray(possible & ~(np.any(above, axis=0) & np.any(below, axis=0)))

    def _d(self, x: Solution) -> Any:
        """The d of solutions with their factor; where one membrane is struck and d is held, not less than it."""
        if x.d is not None:
            return x.d
        # sqrt(y) is at most (y/n + n)/2, whatever n is.
        square = x.sine * x.sine + x.cosine * x.cosine
        norm = np.copysign(np.sqrt(square.centre), x.gbar.centre)
        return room(self.model.level, self.high, x.gbar, (square * (1 / norm) + norm) * 0.5)

    def _beyond_walls(self, corner: Floats, side: float, x: Solution, cells: NDArray[np.intp]) -> Mask:
        """Which cells hold no motion because the ball would pass through a membrane in each of their solutions.

        What is tried is the turning point that is farthest beyond a membrane in the solution above the centre, at the
        same share of its flight throughout the cell.
        """
        turns = self._above(corner, side).turns
        order = np.argsort(-turns.gap, kind="stable")
        farthest = np.full(len(cells), -1)
        farthest[turns.motion[order]] = order  # of the turning points of a motion the last one assigned
        tried = np.flatnonzero(np.isin(farthest, np.flatnonzero(turns.gap < 0)))
        beyond, d_of = np.zeros(len(cells), dtype=bool), self._d(x)
        for i, wall in enumerate(self.sequence.walls):
            rows = tried[turns.after[farthest[tried]] == i]
            boxes, turning, at = _boxes(corner[:, rows], side), farthest[rows], cells[rows]
            duration = [*boxes, -sum(boxes[1:], boxes[0]) + 2.0 * self.sequence.periods][i]
            sine, cosine, gbar, factor, d, time = (
                y[at] for y in (x.sine, x.cosine, x.gbar, x.positive, d_of, x.time[i])
            )
            elapsed = duration * (turns.elapsed[turning] / duration.centre)
            start, turn = (_phase(sine, cosine, t) for t in (time, time + elapsed))
            covered = flight.displacement(
                elapsed, flight.reflect(x.velocity[i][at], self.model.r), start[0], start[1], turn[1], gbar
            )
            for gap in (d * ((1 - wall) / 2) - covered, d * ((1 + wall) / 2) + covered):
                beyond[rows] |= ((gap.upper < 0) & (factor.lower > 0)) | ((gap.lower > 0) & (factor.upper < 0))
        return beyond


def _boxes(corner: Floats, side: float) -> list[Affine]:
    return [between(low, low + side, i, len(corner)) for i, low in enumerate(corner)]


def _phase(sine: Affine, cosine: Affine, t: Affine) -> tuple[Affine, Affine]:
    """Sine and cosine of the forcing phase at a time, with the solution's factor, by those at time zero."""
    s, c = AffineOps.sin(t * np.pi), AffineOps.cos(t * np.pi)
    return sine * c + cosine * s, cosine * c - sine * s
