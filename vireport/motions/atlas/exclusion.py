"""Cells of flight times that may hold motions of a sweep, by proof that all other flight times have none.

The flight times of a motion with three impacts are a point of a triangle, which is divided into cells; those of a
motion with two on the same membrane are a point of a line, with four of a tetrahedron. A cell is left out when affine
arithmetic proves that no solution at its flight times is a motion of the sweep; the other cells are halved.
"""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.motions.atlas.surface import (
    Candidates,
    FlightTimes,
    HomogeneousSolution,
    candidates_above,
    into_range,
    onto_sweep,
    room,
    search_end,
    solution,
    sweep_conditions,
    within,
)
from vireport.motions.periodicity import Model
from vireport.motions.sweep import Held
from vireport.physics import flight
from vireport.physics.affine import AFFINE, Affine, between
from vireport.physics.groups import Restitutions, by_wall
from vireport.physics.word import Word

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

COARSEST, FINE, FINEST = 1 / 8, 1 / 512, 1 / 2048
"""Sides of cells of two flight times [t_c]: of the first cells (larger ones are hardly ever left out), of the cells in
which motions are looked for, and of the smallest, to which cells not near to motions of a family are halved."""

COARSEST_CUBE, FINE_CUBE = 1 / 6, 1 / 96
"""Sides of the first cells of three flight times, and of the cells in which motions are looked for [t_c]."""

FEW = 60
"""Number of cells up to which sides are divided into four, not two: a step costs as much as a thousand cells."""

WALLS = 1 / 20
"""Largest side [t_c] of cells that are tested for a ball that passes through a membrane: larger ones hardly ever show
it."""

NEAR_TURN = 1e-3
"""Newton step [t_c] at which a turning point is near enough: any point of a flight may prove that the ball leaves."""

MOST_CELLS = 20_000
"""Largest number of cells that are divided once more: where more are left, as for a sweep over decades, they stay."""

REACH = 4
"""Distance from the centre of a cell up to which a motion is looked for, in sides of the cell."""

BLOCK = 4096
"""Number of cells evaluated at once: their data stay in the processor's cache."""


def fine_side(word: Word) -> float:
    """Side of the cells of flight times in which motions of a word are looked for [t_c]."""
    return FINE_CUBE if len(word) == 4 else FINE


class FlightTimeCells(Struct, frozen=True, eq=False):
    """Cells of one size in the space of flight times but the last: intervals, squares or cubes.

    Attributes
    ----------
    word : Word
    corner : ndarray (N - 1, n)
        The lower ends of all flight times but the last [t_c].
    side : float
        [t_c].
    """

    word: Word
    corner: Floats
    side: float

    def __len__(self) -> int:
        """Return the number of cells."""
        return len(self.corner[0])

    def __getitem__(self, index: Any) -> FlightTimeCells:
        """The cells picked by an index or mask."""
        return FlightTimeCells(self.word, self.corner[:, index], self.side)

    @property
    def centre(self) -> Floats:
        """Flight times at the centres, (N - 1, n) [t_c]."""
        return self.corner + self.side / 2

    def no_larger_than(self, side: float) -> bool:
        """Whether cells are squares of at most a side [t_c], intervals of a quarter of it, or cubes of four times it.

        An interval is a larger share of a line than a square of a plane, and a cube a smaller share of space.
        """
        return self.side <= side * 4.0 ** (len(self.corner) - 2)

    def divided(self) -> FlightTimeCells:
        """Smaller cells that cover the cells: every side is halved, or quartered for few cells."""
        sides, count = len(self.corner), 4 if len(self) <= FEW else 2
        side, parts = self.side / count, np.indices((count,) * sides).reshape(sides, 1, -1)
        return FlightTimeCells(self.word, (self.corner[:, :, None] + side * parts).reshape(sides, -1), side)

    @property
    def share(self) -> float:
        """Share of the cells in the volume of all flight times [-], every motion counted from one impact."""
        sides = len(self.corner)
        part = (self.side / (2 * self.word.periods)) ** sides * factorial(sides)
        return float(len(self) * part * len(self.word.firsts(self.word)))


class Exclusion(Struct, frozen=True):
    """The search for motions of some words by excluding cells of flight times.

    Attributes
    ----------
    model : Model
    low, high : float
        Range of the coordinate.
    words : tuple of Word
        The same impacts in different numbers of periods, which are evaluated together: three impacts, not all on the
        top, or two or four on the bottom.
    """

    model: Model
    low: float
    high: float
    words: tuple[Word, ...]

    def shortest(self, period: float) -> float:
        """Time below which no flight of a motion can cross [t_c].

        By (2.11) the speeds of impacts are bounded, with the larger r of both membranes, and no flight gains more than
        1 + gbar in a unit of time.
        """
        d, gbar = self.model.groups(max(self.low, 0.0))[0], self.model.groups(self.high)[1]
        # Let v be the speed of the fastest impact. By (2.11) it is at most r v plus what a flight gains, period gbar +
        # 2/pi. A ball that starts with r v and gains 1 + gbar in a unit of time crosses d in a time t with r v t +
        # (1 + gbar) t^2/2 = d, solved for t so that nothing cancels.
        r = max(by_wall(self.model.r))
        speed = (period * gbar + 2 / np.pi) / (1 - r)
        start = r * speed
        return float(2 * d / (start + np.sqrt(start * start + 2 * d * (1 + gbar))))

    def cells(self) -> list[FlightTimeCells]:
        """The cells that are left of all flight times, down to `fine_side`."""
        sides, finest = len(self.words[0]) - 1, []
        side, fine = {1: FINE, 2: COARSEST, 3: COARSEST_CUBE}[sides], fine_side(self.words[0])
        counts = [round(2 * word.periods / side) for word in self.words]
        grids = [side * np.indices((count,) * sides, dtype=float).reshape(sides, -1) for count in counts]
        parts = [FlightTimeCells(*both, side) for both in zip(self.words, grids, strict=True)]
        while parts:
            parts = self.left(parts)
            finest += [part for part in parts if part.side <= fine or len(part) > MOST_CELLS]
            parts = [part.divided() for part in parts if part.side > fine and len(part) <= MOST_CELLS]
        return finest

    def left(self, cells: list[FlightTimeCells]) -> list[FlightTimeCells]:
        """The cells that are not excluded, for each word."""
        cells = [self._ordered(part) for part in cells]
        corner, counts = np.concatenate([part.corner for part in cells], axis=1), [len(part) for part in cells]
        period = np.repeat([2.0 * part.word.periods for part in cells], counts)
        side = np.repeat([part.side for part in cells], counts)
        blocks = [slice(i, i + BLOCK) for i in range(0, max(len(period), 1), BLOCK)]
        possible = np.concatenate([self._possible(corner[:, i], period[i], side[i]) for i in blocks])
        masks = np.split(possible, np.cumsum(counts)[:-1])
        return [part[mask] for part, mask in zip(cells, masks, strict=True)]

    def motions(self, cells: FlightTimeCells) -> tuple[Candidates, Floats]:
        """Solve for the motions next to the centres of cells; return them with all their flight times but the last."""
        word, model, farthest = cells.word, self.model, REACH * cells.side
        motions, flights = onto_sweep(word, cells.centre, model, farthest)
        # Where gbar is held motions on one membrane are at all d above the ball's reach: one in the range is chosen.
        if not (word.one_sided and model.level.held is Held.GBAR):
            flights = into_range(self._placed(motions), flights, model, farthest, (self.low, self.high))
            motions = candidates_above(word, flights, model.r)
        motions, rows = within(self._placed(motions), model.level, self.low, self._end(motions.word))
        return motions, flights[:, rows]

    def _end(self, word: Word) -> float:
        """Upper end of the coordinate in which motions of a word are looked for."""
        return search_end(self.model, word, self.low, self.high)

    def _placed(self, motions: Candidates) -> Candidates:
        """The candidates with a d chosen where they strike one membrane only."""
        if not motions.word.one_sided:
            return motions
        return replace(motions, d=room(self.model.level, self._end(motions.word), motions.gbar) + 0 * motions.gbar)

    def _ordered(self, cells: FlightTimeCells) -> FlightTimeCells:
        """The cells in which all flights can be long enough to cross, and motions are counted from one impact."""
        word, corner = cells.word, cells.corner
        period, walls = 2.0 * word.periods, word.walls
        # By plain numbers, at no cost: what they leave out need not be evaluated in affine arithmetic.
        shortest, ends = self.shortest(period), zip(walls, (*walls[1:], walls[0]), strict=True)
        longest = (*(corner + cells.side), period - corner.sum(axis=0))
        least = (*corner, longest[-1] - len(corner) * cells.side)
        possible = []
        for (wall, other), low, high in zip(ends, least, longest, strict=True):
            possible.append(high > (shortest if wall != other else 0))
            if wall == other == 1:
                possible.append(~self._beyond_top(low, high))
        if word.one_sided:  # whose motions are counted so that the second flight is the longest
            possible += [longest[1] >= time for time in least]
        return cells[np.all(possible, axis=0)]

    def _beyond_top(self, least: Floats, longest: Floats) -> Mask:
        """Whether every flight from the bottom back to it that takes between two times would pass through the top.

        Notes
        -----
        After half of its time t the ball is at least gbar t^2/8 - [1 - cos(pi t/2)]/pi^2 above the bottom, by (2.12).
        """
        forced = np.minimum(1 - np.cos(np.pi * least / 2) + np.pi / 2 * (longest - least), 2) / np.pi**2
        ends = (self.model.groups(end) for end in (max(self.low, 0.0), self.high))
        beyond = [gbar * np.maximum(least, 0) ** 2 / 8 - d > forced for d, gbar, *_ in ends]
        return np.asarray(np.all(beyond, axis=0))

    def _possible(self, corner: Floats, period: Floats, side: Floats) -> Mask:
        """Whether each cell may hold motions of the sweep, by affine arithmetic.

        Parameters
        ----------
        corner : ndarray (N - 1, n)
            Lower ends of the flight times of each cell [t_c].
        period, side : ndarray (n,)
            Period of the motions in each cell, and side of the cell [t_c].
        """
        word, rows = self.words[0], np.arange(len(period))
        x = solution(word, FlightTimes(_boxes(corner, side), period), self.model.r, AFFINE)
        rows, x = self._solved(rows, x)
        if word.one_sided and len(corner) > 1:
            # Next to flight times at which two of the conditions on one membrane are dependent, two others are not.
            # Without them 7e-6 and 1e-5 of all flight times of three and four such impacts stay undecided in an
            # inclined capsule over 2 periods, with them none.
            solved, _ = self._solved(np.arange(len(rows)), x.by_others())
            rows, x = rows[solved], x.at(solved)
        possible, small = np.zeros(len(period), dtype=bool), np.flatnonzero(side[rows] <= WALLS)
        possible[rows] = True
        if small.size:
            rows = rows[small]
            possible[rows] = ~self._beyond_walls(corner[:, rows], period[rows], side[rows], x.at(small))
        return possible

    def _solved(self, rows: NDArray[np.intp], x: HomogeneousSolution) -> tuple[NDArray[np.intp], HomogeneousSolution]:
        """The solutions that may belong to the sweep and strike the membranes from within, and their cells' numbers."""
        zeros = [(y.lower <= 0) & (y.upper >= 0) for y in sweep_conditions(x, self.model)]
        if zeros:
            zero = np.flatnonzero(np.logical_and.reduce(zeros))
            rows, x = rows[zero], x.at(zero)
        # The factor of a solution has the size of (sine, cosine). Squares are compared instead of quotients: nothing is
        # divided by numbers that may be zero somewhere in the cell.
        scale = x.sine * x.sine + x.cosine * x.cosine
        coordinate = x.gbar if self.model.level.held is Held.D else self._d(x)
        square = coordinate * coordinate
        possible = (square - scale * (max(self.low, 0.0) ** 2)).upper >= 0
        possible &= (square - scale * (self.high * self.high)).lower <= 0
        # The sign of the factor makes d positive, and with it gbar and the velocities towards the walls.
        positive = [x.positive, *(v * float(wall) for v, wall in zip(x.velocity, self.words[0].walls, strict=True))]
        if not self.model.level.horizontal:
            positive.append(x.gbar)
        above, below = [y.lower > 0 for y in positive], [y.upper < 0 for y in positive]
        possible &= ~(np.any(above, axis=0) & np.any(below, axis=0))
        left = np.flatnonzero(possible)
        return rows[left], x.at(left)

    def _d(self, x: HomogeneousSolution) -> Any:
        """The d of solutions times their factor; where one membrane is struck, an upper bound of the d chosen."""
        if x.d is not None:
            return x.d
        # sqrt(y) is at most (y/n + n)/2, whatever n is.
        square = x.sine * x.sine + x.cosine * x.cosine
        norm = np.copysign(np.sqrt(square.centre), x.gbar.centre)
        return room(self.model.level, self.high, x.gbar, (square * (1 / norm) + norm) * 0.5)

    def _beyond_walls(self, corner: Floats, period: Floats, side: Floats, x: HomogeneousSolution) -> Mask:
        """Whether it is proved for each cell that in all its solutions the ball would pass through a membrane.

        The proof is tried at one time: when the solution at the centre turns farthest beyond a membrane, at the same
        share of that flight throughout the cell.
        """
        # Any time of a flight at which the ball is beyond a wall proves that there is no motion. The turning point of
        # the centre is only a good guess at one: it need not be exact, nor a turning point elsewhere in the cell.
        r, walls = self.model.r, np.array(self.words[0].walls)
        above = self._placed(candidates_above(self.words[0], corner + side / 2, r, period))
        turns = list(above.turns(period, NEAR_TURN))
        index, elapsed, gap = (
            np.concatenate([np.empty(0, kind), *(getattr(part, name) for _, part in turns)])
            for name, kind in (("index", np.intp), ("time", float), ("gap", float))
        )
        order = np.argsort(-gap, kind="stable")
        farthest = np.full(len(period), -1)
        farthest[index[order]] = order  # of the turning points of a motion the last one assigned
        rows = np.flatnonzero(np.isin(farthest, np.flatnonzero(gap < 0)))
        boxes, x, turning = _boxes(corner[:, rows], side[rows]), x.at(rows), farthest[rows]
        after = np.repeat([i for i, _ in turns], [len(part.index) for _, part in turns])[turning]
        durations = [*boxes, period[rows] - sum(boxes[1:], boxes[0])]
        duration, time, velocity = (_chosen(after, numbers) for numbers in (durations, x.time, x.velocity))
        flown = duration * (elapsed[turning] / duration.centre)
        start, turn = (_phase(x.sine, x.cosine, t) for t in (time, time + flown))
        if isinstance(r, Restitutions):
            r = np.where(walls[after] > 0, r.bottom, r.top)
        covered = flight.displacement(flown, flight.reflect(velocity, r), start[0], start[1], turn[1], x.gbar)
        wall, d, factor = walls[after], self._d(x), x.positive
        beyond = np.zeros(len(period), dtype=bool)
        for gap in (d * ((1 - wall) / 2) - covered, d * ((1 + wall) / 2) + covered):
            beyond[rows] |= ((gap.upper < 0) & (factor.lower > 0)) | ((gap.lower > 0) & (factor.upper < 0))
        return beyond


def _boxes(corner: Floats, side: Floats) -> list[Affine]:
    """The flight times of cells as affine numbers, with a symbol for each side."""
    return [between(low, low + side, i, len(corner)) for i, low in enumerate(corner)]


def _phase(sine: Affine, cosine: Affine, t: Affine) -> tuple[Affine, Affine]:
    """Sine and cosine of the forcing phase at a time t, from those at time zero, both times the solution's factor."""
    s, c = AFFINE.sin(t * np.pi), AFFINE.cos(t * np.pi)
    return sine * c + cosine * s, cosine * c - sine * s


def _chosen(which: NDArray[np.intp], numbers: list[Affine]) -> Affine:
    """The number with the index `which` for each box."""
    return Affine(
        np.choose(which, [y.centre for y in numbers]),
        np.choose(which, [y.linear for y in numbers]),
        np.choose(which, [y.radius for y in numbers]),
        np.choose(which, [y.spread for y in numbers]),
    )
