"""A lower bound of the shocks that a stable motion survives: every smaller shock, at any moment, is proved to die out.

The plane of shocks, moment within a flight by size of the jump, is cut into cells. A cell is proved once all its shocks
are in the motion's region of attraction; others are halved, those of the smallest jumps first.
"""

from __future__ import annotations

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.findings.outcomes.shock import shocked
from vireport.findings.proofs.cells import OPEN, PROVED, Cells, Halving, generations
from vireport.findings.proofs.flights import (
    FIRST,
    SECOND,
    SYMBOLS,
    Sets,
    enclosed,
    merged,
    restitutions,
    simulated,
)
from vireport.findings.proofs.following import Goal, come_in, patience
from vireport.findings.proofs.trap import Trap, around
from vireport.physics.affine import Affine, between

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

MOMENTS = 8
"""Ranges of moments that a flight is cut into at first."""

SIZES = (0.0, 1 / 4096, 1 / 1024, 1 / 256, 1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 3 / 8, 1 / 2, 5 / 8, 3 / 4, 7 / 8, 1.0)
"""Ends of the ranges of sizes that jumps are cut into at first, over the largest."""

AT_ONCE = 2048
"""Cells looked at in one go: what they cost is hardly more than that of one."""

MOST_FLIGHTS = 250_000
"""Flights of sets followed before the rest is left open: some ten seconds."""

FINEST = 2.0**-16
"""Width in moment and in size, over the whole, down to which cells are halved."""


class Survived(Struct, frozen=True, eq=False):
    """A bound of the shocks to a motion that are proved to die out, with the cells of the proof.

    Attributes
    ----------
    trap : Trap
        The region that the motions after the shocks come into.
    largest : float
        Size up to which cells reach [y_c].
    halved : ndarray of int
        For each cell, generation by generation, the coordinate along which it was halved, 0 the moment and 1 the jump,
        or `PROVED` or `OPEN`.
    jump : float
        Size up to which every cell is proved [y_c]; 0 where none is.
    """

    trap: Trap
    largest: float
    halved: Ints
    jump: float

    @property
    def cells(self) -> int:
        """Number of cells of shocks that are proved to return."""
        return int(np.count_nonzero(self.halved == PROVED))


def _first_cells(impacts: int, largest: float) -> Cells:
    """Cells of moment and jump that cover all shocks up to a size [y_c] after each impact, the smallest jumps first."""
    share, size = np.arange(MOMENTS + 1) / MOMENTS, largest * np.array(SIZES)
    # Both signs of the jump, without size zero in the middle of a cell: the bound is the least unproved size.
    rows = [
        (share[m], share[m + 1], *((size[k], size[k + 1]) if sign > 0 else (-size[k + 1], -size[k])), impact)
        for k in range(len(SIZES) - 1)
        for impact in range(impacts)
        for sign in (1, -1)
        for m in range(MOMENTS)
    ]
    a, b, low, high, impact = np.array(rows).T
    return Cells(np.stack([a, low]), np.stack([b, high]), impact.astype(np.intp))


class MotionFlights:
    """Enclosures of the flights of a periodic motion itself, from which shocks knock the ball.

    Attributes
    ----------
    goal : Goal
        The region about the motion.
    times, after, durations : list of Affine (1,)
        Of each impact: its time [t_c], the velocity just after it [y_c] and the time until the next one [t_c].
    """

    @np.errstate(all="ignore")
    def __init__(self, goal: Goal) -> None:
        self.goal, trap = goal, goal.trap
        exactly, motion = enclosed(goal.groups), trap.motion
        # The motion is not quite in the middle of its region: a disk about the middle, in the metric, contains it.
        inaccuracy = np.linalg.norm(np.linalg.inv(trap.metric), axis=1) * trap.off * (1 + 1e-9)
        time, velocity = (
            Affine(np.array([float(x)]), np.zeros((SYMBOLS, 1)), np.array([radius]))
            for x, radius in zip((motion.time[0], motion.velocity[0]), inaccuracy, strict=True)
        )
        self.times: list[Affine] = []
        self.after: list[Affine] = []
        self.durations: list[Affine] = []
        for before, end in around(goal.groups, motion, time, velocity, goal.compiled):
            self.times.append(before.time)
            self.after.append(before.velocity * -restitutions(exactly, before.wall))
            self.durations.append(end.duration)

    @np.errstate(all="ignore")
    def prove(self, cells: Cells) -> tuple[Mask, Ints, int]:
        """Which cells of shocks are proved to die out.

        Parameters
        ----------
        cells : Cells
            In the moment, as a share of the flight after the cell's impact, and the jump of the velocity [y_c].

        Returns
        -------
        proved : ndarray of bool
        halved : ndarray of int
            The coordinate along which to halve each of the others.
        flights : int
            Flights of sets that were followed.
        """
        proved, halved, flights = np.zeros(len(cells.impact), dtype=bool), np.zeros(len(cells.impact), dtype=np.intp), 0
        goal, most = self.goal, patience(self.goal.trap)
        for impact in np.unique(cells.impact).tolist():
            rows = np.flatnonzero(cells.impact == impact)
            after_impact = cells[rows]
            # The simulation of the middle of each cell is only a guess of where to look.
            middle = (after_impact.low + after_impact.high) / 2
            delay = middle[0] * self.durations[impact].centre[0]
            start = shocked(goal.groups, goal.trap.motion, impact, delay, middle[1])
            guesses = simulated(goal.groups, start, goal.compiled)
            proved[rows], halved[rows], taken = come_in(goal, self._sets(after_impact, impact), guesses, most)
            flights += taken
        return proved, halved, flights

    def _sets(self, cells: Cells, impact: int) -> Sets:
        """Sets of states just after shocks: as if the ball had left with its new velocity, from elsewhere."""
        rows, wall = np.zeros(len(cells.impact), dtype=np.intp), self.goal.trap.motion.word.walls[impact]
        share, jump = (between(cells.low[k], cells.high[k], symbol, SYMBOLS) for k, symbol in ((0, FIRST), (1, SECOND)))
        # A jump at a time s adds jump (t - s) to the flight: that of a ball that left with the velocity plus the jump,
        # from a place shifted by -jump s.
        since = share * self.durations[impact][rows]
        time, after = merged(self.times[impact][rows], self.after[impact][rows] + jump)
        return Sets(np.full(len(rows), wall), time, after, jump * since * float(wall), since)


def survived(goal: Goal, largest: float) -> Survived:
    """Prove as large a bound of the shocks that die out as the effort allows.

    Parameters
    ----------
    goal : Goal
        The region about the motion that is knocked.
    largest : float
        Size up to which the bound is sought [y_c].
    """
    period, trap = MotionFlights(goal), goal.trap
    halving, used, bound = Halving(_first_cells(len(trap.motion.word), largest)), 0, largest
    pending = np.arange(len(halving.cells))
    # The bound is raised from below: the smallest jumps come first, as one that fails ends the proof.
    while pending.size and used < MOST_FLIGHTS:
        smallest = halving.cells.smallest[pending]
        order = np.argsort(smallest, kind="stable")
        order = order[smallest[order] < bound]
        now, pending = pending[order[:AT_ONCE]], pending[order[AT_ONCE:]]
        if not now.size:
            break
        cells = halving.cells[now]
        proved, halved, flights = period.prove(cells)
        used += flights
        halving.code[now[proved]] = PROVED
        # A cell too small to be halved bounds what can be proved: larger jumps are not looked at any more.
        width = (cells.high - cells.low) / [[1.0], [largest]]
        fine = ~proved & (width[halved, np.arange(len(now))] <= FINEST)
        bound = min(bound, cells.smallest[fine].min(initial=bound))
        # Halves wait for their turn, by size: those of large jumps may never be examined.
        split = np.flatnonzero(~proved & ~fine)
        pending = np.concatenate([pending, halving.halve(now[split], halved[split])])
    return Survived(trap, largest, halving.codes, _bound(halving.cells[halving.code == OPEN], largest))


def _bound(left: Cells, largest: float) -> float:
    """The size of shocks up to which no cell is left unproved."""
    return float(left.smallest.min(initial=largest))


def survived_again(goal: Goal, largest: float, halved: Ints) -> float:
    """Go through the cells of a proof once more; the size of shocks up to which all are proved [y_c].

    That the cells cover the plane follows from how it is halved; nothing else is believed.

    Parameters
    ----------
    goal : Goal
    largest : float
        Size up to which cells reach [y_c].
    halved : ndarray of int
        As in `Survived`: what is claimed.

    Raises
    ------
    ValueError
        If there are not as many cells as it takes.
    """
    period, bound = MotionFlights(goal), largest
    for cells, code in generations(_first_cells(len(goal.trap.motion.word), largest), halved):
        holds, _, _ = period.prove(cells[code == PROVED])
        # Cells that are claimed and not proved again count as open ones.
        missing = code < 0
        missing[np.flatnonzero(code == PROVED)[holds]] = False
        bound = min(bound, _bound(cells[missing], largest))
    return bound
