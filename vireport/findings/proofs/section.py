"""Lower bounds of the shares of impacts on the bottom membrane, and of moments of switching on, that reach a motion.

The Poincaré section, time within the forcing period by velocity just before the impact, is cut into cells, which are
followed for a few impacts (`itineraries`). A cell is proved once all its impacts come into the motion's region of
attraction, to a rest from which the ball is proved to come there, or into cells that are proved already; so what is
proved spreads from the region. Other cells are halved, the largest first. Switching on is an impact without velocity.
"""

from __future__ import annotations

from functools import reduce
from operator import add

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.findings.proofs.cells import OPEN, PROVED, Cells, Halving, generations, joined_cells
from vireport.findings.proofs.following import Goal
from vireport.findings.proofs.itineraries import RETURNS, Itineraries, follow_cells
from vireport.findings.proofs.trap import Trap

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

PERIOD = 2.0
"""Of the forcing [t_c]."""

FINEST = 1024
"""Cells along either side of the section down to which they are halved."""

ACROSS = 16
"""Cells along either side of the section at first."""

AT_ONCE, MOST_HALVED = 2048, 4096
"""Cells followed in one go, and cells halved before it is looked again what is proved."""

MOST_FLIGHTS = 150_000
"""Flights of sets followed before the rest is left open: some ten seconds."""

MOMENTS, HALVINGS = 64, 6
"""Cells of moments of switching on at first, and how often one is halved."""

ROUNDS = 3
"""How often what is proved spreads from cell to cell before others are halved; until it does not, in the end."""

WIDENED = 1e-12
"""Distance [t_c, y_c] by which enclosures are widened, far beyond the rounding of the ends of cells."""


class Section(Struct, frozen=True, eq=False):
    """Impacts on the bottom membrane that are proved to come to a motion.

    Attributes
    ----------
    trap : Trap
        The region that they come into.
    fastest : float
        Velocity before the impact up to which the section reaches [y_c].
    halved : ndarray of int
        For each cell, generation by generation, the coordinate along which it was halved, 0 the time and 1 the
        velocity, or `PROVED` or `OPEN`.
    moments : ndarray of int
        The same for cells of moments at which the force sets in.
    share : float
        Share of the section, uniform in phase and velocity, that is proved.
    switch_on : float
        Share of the moments at which the force may set in that is proved.
    """

    trap: Trap
    fastest: float
    halved: Ints
    moments: Ints
    share: float
    switch_on: float

    @property
    def cells(self) -> int:
        """Number of cells of impacts that are proved to come to the motion."""
        return int(np.count_nonzero(self.halved == PROVED))

    @property
    def name(self) -> str:
        """Word and period of the motion that impacts are proved to come to."""
        return self.trap.motion.word.name


def _first_moments() -> Cells:
    """Cells of moments at which the force sets in, while the ball lies on the bottom membrane."""
    ends, still = PERIOD * np.arange(MOMENTS + 1) / MOMENTS, np.zeros(MOMENTS)
    return Cells(np.stack([ends[:-1], still]), np.stack([ends[1:], still]), np.zeros(MOMENTS, np.intp))


def _first_cells(fastest: float) -> Cells:
    """Cells that the section, up to a velocity [y_c], is cut into at first."""
    time, velocity = np.linspace(0.0, PERIOD, ACROSS + 1), np.linspace(0.0, fastest, ACROSS + 1)
    ends = [np.meshgrid(time[part], velocity[part]) for part in (slice(-1), slice(1, None))]
    low, high = (np.stack([grid.ravel() for grid in grids]) for grids in ends)
    return Cells(low, high, np.zeros(ACROSS**2, np.intp))


class _Covered:
    """The union of proved cells, as the integral of its indicator function over a grid of the section.

    Attributes
    ----------
    scale : ndarray (2, 1)
        Nodes of the grid per unit of time and of velocity.
    sums : ndarray of int (2 FINEST + 1, FINEST + 1)
        Numbers of proved squares of the grid before a time and below a velocity, over two periods.
    """

    def __init__(self, cells: Cells, fastest: float) -> None:
        self.scale = FINEST / np.array([PERIOD, fastest])[:, None]
        low, high = (np.rint(end * self.scale).astype(np.intp) for end in (cells.low, cells.high))
        # The indicator function is the double sum of its steps at the corners of cells.
        steps = np.zeros((FINEST + 1, FINEST + 1), dtype=np.int32)
        for a, b, sign in ((low[0], low[1], 1), (high[0], low[1], -1), (low[0], high[1], -1), (high[0], high[1], 1)):
            np.add.at(steps, (a, b), sign)
        covered = steps.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0
        # Two periods, so that what lasts over the end of one is in one piece.
        self.sums = np.zeros((2 * FINEST + 1, FINEST + 1), dtype=np.int32)
        self.sums[1:, 1:] = np.concatenate([covered, covered]).cumsum(axis=0, dtype=np.int32).cumsum(axis=1)

    def holds(self, box: Floats) -> Mask:
        """Which boxes of impacts (n, 4) are surely covered by proved cells."""
        # An enclosure longer than half a period does not determine the phase.
        defined = np.isfinite(box).all(axis=1) & (box[:, 1] - box[:, 0] < PERIOD / 2)
        box = np.where(defined[:, None], box, 0.0)
        low, high = box[:, ::2].T - WIDENED, box[:, 1::2].T + WIDENED
        whole = PERIOD * np.floor(low[0] / PERIOD)
        # Boxes begin in the first of two periods: what extends beyond its end is in the second one.
        low[0], high[0] = low[0] - whole, high[0] - whole
        (a, c), (b, d) = (f(x * self.scale).astype(np.intp) for f, x in ((np.floor, low), (np.ceil, high)))
        # An enclosure may reach beyond 0; no impact on the bottom has such a velocity.
        c = np.maximum(c, 0)
        inside = defined & (a >= 0) & (b <= 2 * FINEST) & (c < d) & (d <= FINEST)
        a, b, c, d = (np.where(inside, index, 0) for index in (a, b, c, d))
        # Squares of the grid within the box that are proved, from the sums at its corners: all of them must be.
        covered = self.sums[b, d] - self.sums[a, d] - self.sums[b, c] + self.sums[a, c]
        return np.asarray(inside & (covered == (b - a) * (d - c)))


def _spread(cells: Cells, rows: Mask, itineraries: Itineraries, fastest: float, rounds: int | None = None) -> Mask:
    """Which of some cells are proved: those with itineraries that all arrive, or return to cells that are proved.

    Parameters
    ----------
    cells : Cells
    rows : ndarray of bool
        The cells that may be proved; the others have been halved.
    known : Itineraries
        Itineraries of all cells.
    fastest : float
        Velocity up to which the section reaches [y_c].
    rounds : int, optional
        How often the proved part is extended; by default until nothing more is proved.
    """
    itineraries = itineraries[rows[itineraries.cell]]
    proved, before = np.zeros(len(cells), dtype=bool), -1
    arrives = itineraries.arrives
    for _ in range(len(cells) + 1 if rounds is None else rounds):
        proved[:] = rows
        proved[itineraries.cell[~arrives]] = False
        count = np.count_nonzero(proved)
        if count == before:
            break
        before, region = int(count), _Covered(cells[proved], fastest)
        # One box is enough: every state of the itinerary passes it, and comes to the motion from there.
        arrives[~arrives] = np.any([region.holds(itineraries.box[~arrives, k]) for k in range(RETURNS)], axis=0)
    return proved


def _follow_cells(goal: Goal, cells: Cells) -> tuple[Itineraries, Ints, int]:
    """`itineraries` of any number of cells, `AT_ONCE` at a time."""
    itineraries, longer_sides, used = [Itineraries.begun(0)], [np.zeros(0, np.intp)], 0
    for begin in range(0, len(cells), AT_ONCE):
        of_part, longest, flights = follow_cells(goal, cells[begin : begin + AT_ONCE])
        itineraries.append(of_part.of_cells_from(begin))
        longer_sides.append(longest)
        used += flights
    return reduce(add, itineraries), np.concatenate(longer_sides), used


def proved_section(goal: Goal, fastest: float) -> Section:
    """Prove as large shares of the section and of the moments of switching on as the effort allows.

    Parameters
    ----------
    goal : Goal
    fastest : float
        Velocity before the impact up to which the section reaches [y_c].
    """
    halving, used, first = Halving(_first_cells(fastest)), 0, 0
    itineraries, longer_sides = Itineraries.begun(0), np.zeros(0, np.intp)
    # The proved part spreads from the region through cells that return to proved ones; the largest of the others are
    # halved, until all are as fine as the grid or the effort is used up.
    while True:
        of_new, longest, flights = _follow_cells(goal, halving.cells[first:])
        itineraries = itineraries + of_new.of_cells_from(first)
        longer_sides, used = np.concatenate([longer_sides, longest]), used + flights
        first, last = len(halving.cells), used >= MOST_FLIGHTS
        proved = _spread(halving.cells, halving.code < 0, itineraries, fastest, None if last else ROUNDS)
        halving.code[proved] = PROVED
        left = np.flatnonzero(halving.code == OPEN)
        sides = (halving.cells.high - halving.cells.low)[:, left] * FINEST / [[PERIOD], [fastest]]
        # Along the side on which its image grew longest, unless it is as short as a square of the grid there.
        widest = np.where(
            sides[longer_sides[left], np.arange(len(left))] > 1.5, longer_sides[left], 1 - longer_sides[left]
        )
        large = sides.max(axis=0) > 1.5
        if last or not large.any():
            break
        left, widest = left[large], widest[large]
        order = np.argsort(-halving.cells.area[left], kind="stable")[:MOST_HALVED]
        halving.halve(left[order], widest[order])
    cells = halving.cells[halving.code == PROVED]
    moments, switch_on = _switched_on(goal, _Covered(cells, fastest))
    return Section(goal.trap, fastest, halving.codes, moments, _share(cells, fastest), switch_on)


def _switched_on(goal: Goal, region: _Covered) -> tuple[Ints, float]:
    """The cells of moments of switching on, and the share of all moments that is proved."""
    halving, first = Halving(_first_moments()), 0
    # Moments have no width in velocity: they are halved in time alone.
    for turn in range(HALVINGS + 1):
        new = np.arange(first, len(halving.cells))
        proved = _arrives(goal, halving.cells[new], region)
        first, halving.code[new[proved]] = len(halving.cells), PROVED
        if turn < HALVINGS:
            halving.halve(new[~proved], np.zeros(np.count_nonzero(~proved), np.intp))
    return halving.codes, _share_of_moments(halving.cells[halving.code == PROVED])


def _arrives(goal: Goal, cells: Cells, region: _Covered) -> Mask:
    """Which cells are proved, by arrival at the motion or by returns to the proved part of the section."""
    proved = np.ones(len(cells), dtype=bool)
    if len(cells):
        itineraries, _, _ = _follow_cells(goal, cells)
        arrives = itineraries.arrives | np.any([region.holds(itineraries.box[:, k]) for k in range(RETURNS)], axis=0)
        proved[itineraries.cell[~arrives]] = False
    return proved


def _share(proved: Cells, fastest: float) -> float:
    """Share of the section that cells fill, rounded down."""
    # Fewer than a million areas, each rounded a few times.
    return float(proved.area.sum() / (PERIOD * fastest) * (1 - 1e-12))


def _share_of_moments(proved: Cells) -> float:
    """Share of the forcing period that cells fill: exact, as its parts are."""
    return float((proved.high[0] - proved.low[0]).sum() / PERIOD)


def section_again(goal: Goal, fastest: float, halved: Ints, moments: Ints) -> tuple[float, float]:
    """Go through the cells of a proof once more; the shares of the section and of moments that are proved.

    That the cells are parts of the section follows from how it is halved; nothing else is believed.

    Parameters
    ----------
    goal : Goal
    fastest : float
        Velocity before the impact up to which the section reaches [y_c].
    halved, moments : ndarray of int
        As in `Section`: what is claimed.

    Raises
    ------
    ValueError
        If there are not as many cells as it takes.
    """
    cells = joined_cells([cells[code == PROVED] for cells, code in generations(_first_cells(fastest), halved)])
    # Nothing is halved again: of the claimed cells, those count that can be proved from one another.
    if len(cells):
        itineraries, _, _ = _follow_cells(goal, cells)
        cells = cells[_spread(cells, np.ones(len(cells), dtype=bool), itineraries, fastest)]
    region, switched_on = _Covered(cells, fastest), list[Cells]()
    for parts, code in generations(_first_moments(), moments):
        if (code > 0).any():
            raise ValueError("moments of switching on have one coordinate")
        claimed = parts[code == PROVED]
        switched_on.append(claimed[_arrives(goal, claimed, region)])
    return _share(cells, fastest), _share_of_moments(joined_cells(switched_on))
