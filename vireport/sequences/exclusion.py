"""Where among all flight times the motions of a sweep can be: proved by leaving out all other flight times.

The flight times of a motion with three impacts are a point of a triangle, which is divided into cells. A cell is left
out when affine arithmetic shows that none of the solutions above it is a motion of the sweep; what is left is halved.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import Held
from vireport.physics import Affine, AffineOps, between, flight
from vireport.sequences.equations import Model
from vireport.sequences.motions import Sequence
from vireport.sequences.surface import Motions, motions_above, solution, sweep_conditions

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

COARSEST, FINE, FINEST = 1 / 8, 1 / 512, 1 / 2048
"""Sides of the first cells [t_c], larger than which are hardly ever left out, of those that are looked for motions, and
of the last ones, to which only those are halved that are not near to motions known."""

MOST_CELLS = 20_000
"""Cells that are halved once more: where more are left, as above a sweep over decades, they stay as they are."""

BLOCK = 4096
"""Cells evaluated at once: their numbers stay in the processor's cache."""

HALVES = np.array([[0, 0, 1, 1], [0, 1, 0, 1]])


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Squares of pairs of flight times that may hold motions of a sweep.

    Attributes
    ----------
    motions : Motions
        Above their centres, near to those of the sweep.
    corner : ndarray (2, n)
        The lower ends of both flight times [t_c].
    side : float
        [t_c].
    """

    motions: Motions
    corner: Floats
    side: float

    def __len__(self) -> int:
        """Return their number."""
        return len(self.motions.d)

    def __getitem__(self, index: Any) -> Cells:
        """Some of them."""
        return Cells(self.motions[index], self.corner[:, index], self.side)

    @property
    def centre(self) -> Floats:
        """The flight times in the middle of each."""
        return self.corner + self.side / 2

    @property
    def share(self) -> float:
        """Of the triangle of all flight times."""
        return 2 * len(self) * (self.side / (2 * self.motions.sequence.periods)) ** 2


@dataclass(frozen=True, slots=True)
class Exclusion:
    """What the motions are that are looked for.

    Attributes
    ----------
    model : Model
    low, high : float
        Range of the coordinate.
    sequence : Sequence
        Three impacts, on both membranes.
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
        count = round(2 * self.sequence.periods / COARSEST)
        corner = COARSEST * np.indices((count, count), dtype=float).reshape(2, -1)
        cells = self._left(corner, COARSEST)
        while cells.side > FINE and len(cells) <= MOST_CELLS:
            cells = self.halved(cells)
        return cells

    def halved(self, cells: Cells) -> Cells:
        """The parts that are left of cells, each divided into four."""
        side = cells.side / 2
        return self._left((cells.corner[:, :, None] + side * HALVES[:, None, :]).reshape(2, -1), side)

    def _left(self, corner: Floats, side: float) -> Cells:
        last, walls, shortest = 2 * self.sequence.periods - corner.sum(axis=0), self.sequence.walls, self.shortest
        longest = zip((*(corner + side), last), walls, (*walls[1:], walls[0]), strict=True)
        corner = corner[:, np.all([time > (shortest if wall != other else 0) for time, wall, other in longest], axis=0)]
        parts = [corner[:, i : i + BLOCK] for i in range(0, corner.shape[1], BLOCK)]
        corner = np.concatenate([corner[:, :0], *(part[:, self._possible(part, side)] for part in parts)], axis=1)
        cells = Cells(motions_above(self.sequence, corner + side / 2, self.model.r), corner, side)
        return cells[~_beyond_walls(cells)] if side <= FINE else cells

    def _possible(self, corner: Floats, side: float) -> Mask:
        """Which cells may hold solutions of the sweep with velocities of the right signs."""
        x = solution(self.sequence, _boxes(corner, side), self.model.r, AffineOps)
        possible = np.all([(y.lower <= 0) & (y.upper >= 0) for y in sweep_conditions(x, self.model)], axis=0)
        scale = x.sine * x.sine + x.cosine * x.cosine
        coordinate = x.gbar if self.model.level.held is Held.D else x.d
        square = coordinate * coordinate
        possible &= (square - scale * (max(self.low, 0.0) ** 2)).upper >= 0
        possible &= (square - scale * (self.high * self.high)).lower <= 0
        # The sign of the factor makes d positive, and with it gbar and the velocities towards the walls.
        positive = [x.d, *(v * float(wall) for v, wall in zip(x.velocity, self.sequence.walls, strict=True))]
        if not self.model.level.horizontal:
            positive.append(x.gbar)
        above, below = zip(*((y.lower > 0, y.upper < 0) for y in positive), strict=True)
        return np.asarray(possible & ~(np.any(above, axis=0) & np.any(below, axis=0)))


def _boxes(corner: Floats, side: float) -> list[Affine]:
    return [between(low, low + side, i, len(corner)) for i, low in enumerate(corner)]


def _beyond_walls(cells: Cells) -> Mask:
    """Which cells hold no motion because the ball would pass through a membrane in each of their solutions.

    What is tried is the turning point that is farthest beyond a membrane in the solution above the centre, at the same
    share of its flight throughout the cell.
    """
    motions, turns, sequence = cells.motions, cells.motions.turns, cells.motions.sequence
    order = np.argsort(-turns.gap, kind="stable")
    farthest = np.full(len(cells), -1)
    farthest[turns.motion[order]] = order  # of the turning points of a motion the last one assigned
    beyond = np.isin(farthest, np.flatnonzero(turns.gap < 0))
    boxes = _boxes(cells.corner[:, beyond], cells.side)
    x, turning = solution(sequence, boxes, motions.r, AffineOps), farthest[beyond]
    durations = [*boxes, -(boxes[0] + boxes[1]) + 2.0 * sequence.periods]
    certain = np.zeros(len(turning), dtype=bool)
    for i, wall in enumerate(sequence.walls):
        rows = turns.after[turning] == i
        duration, time, d = durations[i][rows], x.time[i][rows], x.d[rows]
        sine, cosine, gbar = x.sine[rows], x.cosine[rows], x.gbar[rows]
        elapsed = duration * (turns.elapsed[turning[rows]] / duration.centre)
        start, turn = (_phase(sine, cosine, t) for t in (time, time + elapsed))
        covered = flight.displacement(
            elapsed, flight.reflect(x.velocity[i][rows], motions.r), start[0], start[1], turn[1], gbar
        )
        for gap in (d * ((1 - wall) / 2) - covered, d * ((1 + wall) / 2) + covered):
            certain[rows] |= ((gap.upper < 0) & (d.lower > 0)) | ((gap.lower > 0) & (d.upper < 0))
    beyond[beyond] = certain
    return beyond


def _phase(sine: Affine, cosine: Affine, t: Affine) -> tuple[Affine, Affine]:
    """Sine and cosine of the forcing phase at a time, with the solution's factor, by those at time zero."""
    s, c = AffineOps.sin(t * np.pi), AffineOps.cos(t * np.pi)
    return sine * c + cosine * s, cosine * c - sine * s
