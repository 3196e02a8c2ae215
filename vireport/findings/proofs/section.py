"""Lower bounds of what provably comes to a motion: of all impacts on the bottom membrane, of moments of switching on.

The section, time within the forcing period by velocity just before the impact, is cut into cells, which are followed
for a few impacts. A cell is proved once all its impacts come into the motion's region of attraction, to a rest from
which the ball is proved to come there, or into cells that are proved already; so what is proved spreads from the
region. Other cells are halved, the largest first. Switching on is an impact without velocity.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.findings.proofs.cells import OPEN, PROVED, Cells, Halving, generations, joined_cells
from vireport.findings.proofs.flights import (
    FIRST,
    SECOND,
    SYMBOLS,
    ImpactSets,
    after_impact,
    enclosed,
    middles,
    simulated,
)
from vireport.findings.proofs.following import flown, is_small, longer, patience
from vireport.findings.proofs.settling import settles
from vireport.findings.proofs.trap import Trap
from vireport.physics.affine import between
from vireport.physics.groups import Groups
from vireport.simulation.events import BOTTOM

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

PERIOD = 2.0
"""Of the forcing [t_c]."""

FINEST = 1024
"""Cells along either side of the section down to which they are halved."""

ACROSS = 16
"""Cells along either side of the section at first."""

RETURNS = 3
"""Impacts on the bottom membrane after which a cell is followed further only where it is near the region."""

NEAR = 10.0
"""How near, over the region's radius: there the way into it is long where disturbances die out slowly."""

AT_ONCE, MOST_HALVED = 2048, 4096
"""Cells followed in one go, and cells halved before it is looked again what is proved."""

MOST_FLIGHTS = 150_000
"""Flights of sets followed before the rest is left open: some ten seconds."""

MOMENTS, HALVINGS = 64, 6
"""Cells of moments of switching on at first, and how often one is halved."""

ROUNDS = 3
"""How often what is proved spreads from cell to cell before others are halved; until it does not, in the end."""

BESIDE = 1e-12
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
        The same of cells of moments at which the force sets in.
    share : float
        Of the section, uniform in phase and velocity, that is proved.
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
        """Number of proved cells."""
        return int(np.count_nonzero(self.halved == PROVED))

    @property
    def name(self) -> str:
        """Word and period of the motion that impacts are proved to come to."""
        return self.trap.motion.word.name


class _Ways(Struct, frozen=True, eq=False):
    """Ways that the impacts of cells take, two of a cell some of whose impacts lead to a touch and others do not.

    Every impact of a cell takes one of the cell's ways: unless that is good, it passes the boxes of the way in their
    order, as far as they are not NaN. So a cell is proved once each of its ways is good or has a box that is.

    Attributes
    ----------
    cell : ndarray of int (n,)
    good : ndarray of bool (n,)
        Whether the way ends in the region, or in a rest from which the ball comes there.
    box : ndarray (n, RETURNS, 4)
        Least and largest time, least and largest velocity at impacts on the bottom membrane; NaN where there is none.
    """

    cell: Ints
    good: Mask
    box: Floats

    def __getitem__(self, rows: Any) -> _Ways:
        return _Ways(self.cell[rows], self.good[rows], self.box[rows])


def _joined(ways: Sequence[_Ways]) -> _Ways:
    return _Ways(*(np.concatenate([getattr(part, name) for part in ways]) for name in ("cell", "good", "box")))


def _first_moments() -> Cells:
    """Cells of moments at which the force sets in, while the ball lies on the bottom membrane."""
    ends, still = PERIOD * np.arange(MOMENTS + 1) / MOMENTS, np.zeros(MOMENTS)
    return Cells(np.stack([ends[:-1], still]), np.stack([ends[1:], still]), np.zeros(MOMENTS, np.intp))


def _first_cells(fastest: float) -> Cells:
    time, velocity = np.linspace(0.0, PERIOD, ACROSS + 1), np.linspace(0.0, fastest, ACROSS + 1)
    ends = [np.meshgrid(time[part], velocity[part]) for part in (slice(-1), slice(1, None))]
    low, high = (np.stack([grid.ravel() for grid in grids]) for grids in ends)
    return Cells(low, high, np.zeros(ACROSS**2, np.intp))


@np.errstate(all="ignore")  # what is not proved may not be finite
def _ways(
    groups: Groups[float], trap: Trap, cells: Cells, rests: Collection[int], compiled: bool
) -> tuple[_Ways, Ints, int]:
    """Where cells go, along which coordinate to halve them, and how many flights that took.

    The k-th set that is followed holds what is left of the way `way[k]`, with `struck[k]` of its boxes filled. A way
    whose set is given up stays as it is, and is not good: nothing is proved by what is not followed.
    """
    exactly, count, flights = enclosed(groups), len(cells), 0
    time, velocity = (between(cells.low[k], cells.high[k], symbol, SYMBOLS) for k, symbol in ((0, FIRST), (1, SECOND)))
    at = ImpactSets(np.ones(count, dtype=bool), np.full(count, BOTTOM), time, velocity, time)
    ways = _Ways(np.arange(count), np.zeros(count, dtype=bool), np.full((count, RETURNS, 4), np.nan))
    way, struck, halved = np.arange(count), np.zeros(count, np.intp), longer(time, velocity)
    for _ in range(patience(trap)):
        inside = trap.holds(at.wall, at.time, at.velocity)
        ways.good[way[inside]] = True
        near = (at.wall != BOTTOM) | (trap.size(*trap.deviations(at.time, at.velocity)) < NEAR * trap.radius)
        goes_on = np.flatnonzero(~inside & ((struck < RETURNS) | near))
        way, struck, sets = way[goes_on], struck[goes_on], after_impact(exactly, at, goes_on)
        resting = settles(exactly, sets)
        ways.good[way[resting & np.isin(sets.wall, list(rests))]] = True
        moving = np.flatnonzero(~resting)
        way, struck, sets = way[moving], struck[moving], sets[moving]
        if not way.size:
            break
        flights += len(way)
        at, parent, _ = flown(groups, sets, simulated(groups, middles(groups, sets), compiled), compiled)
        way, struck = way[parent], struck[parent]
        # A set that comes twice has states that touch and others that do not: these go a way of their own from here.
        _, first = np.unique(parent, return_index=True)
        second = np.setdiff1d(np.arange(len(parent)), first)
        begun = ways[way[second]]
        way[second] = len(ways.cell) + np.arange(len(second))
        ways = _joined([ways, begun])
        halved[ways.cell[way]] = longer(at.time, at.velocity)
        bottom = (at.wall == BOTTOM) & (struck < RETURNS)
        ends = np.stack([at.time.lower, at.time.upper, at.velocity.lower, at.velocity.upper], axis=1)
        ways.box[way[bottom], struck[bottom]] = ends[bottom]
        small = np.flatnonzero(is_small(at))
        at, way, struck = at[small], way[small], (struck + bottom)[small]
    return ways, halved, flights


class _Covered:
    """The part of the section that is known to come to the region, as sums over a grid."""

    def __init__(self, cells: Cells, fastest: float) -> None:
        self.scale = FINEST / np.array([PERIOD, fastest])[:, None]
        low, high = (np.rint(end * self.scale).astype(np.intp) for end in (cells.low, cells.high))
        steps = np.zeros((FINEST + 1, FINEST + 1), dtype=np.int32)
        for a, b, sign in ((low[0], low[1], 1), (high[0], low[1], -1), (low[0], high[1], -1), (high[0], high[1], 1)):
            np.add.at(steps, (a, b), sign)
        covered = steps.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0
        # Two periods, so that what lasts over the end of one is in one piece.
        self.sums = np.zeros((2 * FINEST + 1, FINEST + 1), dtype=np.int32)
        self.sums[1:, 1:] = np.concatenate([covered, covered]).cumsum(axis=0, dtype=np.int32).cumsum(axis=1)

    def holds(self, box: Floats) -> Mask:
        """Which boxes of impacts (n, 4) are surely covered by proved cells."""
        defined = np.isfinite(box).all(axis=1) & (box[:, 1] - box[:, 0] < PERIOD / 2)
        box = np.where(defined[:, None], box, 0.0)
        low, high = box[:, ::2].T - BESIDE, box[:, 1::2].T + BESIDE
        whole = PERIOD * np.floor(low[0] / PERIOD)
        low[0], high[0] = low[0] - whole, high[0] - whole
        (a, c), (b, d) = (f(x * self.scale).astype(np.intp) for f, x in ((np.floor, low), (np.ceil, high)))
        # An enclosure may reach beyond 0; no impact on the bottom has such a velocity.
        c = np.maximum(c, 0)
        inside = defined & (a >= 0) & (b <= 2 * FINEST) & (c < d) & (d <= FINEST)
        a, b, c, d = (np.where(inside, index, 0) for index in (a, b, c, d))
        covered = self.sums[b, d] - self.sums[a, d] - self.sums[b, c] + self.sums[a, c]
        return np.asarray(inside & (covered == (b - a) * (d - c)))


def _spread(cells: Cells, rows: Mask, ways: _Ways, fastest: float, rounds: int | None = None) -> Mask:
    """Which of some cells come to the region, by ways into it and by boxes in cells of which that is known."""
    ways = ways[rows[ways.cell]]
    proved, before = np.zeros(len(cells), dtype=bool), -1
    good = ways.good
    for _ in range(len(cells) + 1 if rounds is None else rounds):
        proved[:] = rows
        proved[ways.cell[~good]] = False
        count = np.count_nonzero(proved)
        if count == before:
            break
        before, region = int(count), _Covered(cells[proved], fastest)
        good[~good] = np.any([region.holds(ways.box[~good, k]) for k in range(RETURNS)], axis=0)
    return proved


class _Task(Struct, frozen=True, eq=False):
    """A proof about the section of one device: its groups, the region to be reached, and the rests that lead there."""

    groups: Groups[float]
    trap: Trap
    fastest: float
    rests: Collection[int]
    compiled: bool

    def ways(self, cells: Cells) -> tuple[_Ways, Ints, int]:
        """Where cells go, along which coordinate to halve them, and how many flights that took."""
        ways, longer_sides, used = list[_Ways](), [np.zeros(0, np.intp)], 0
        for begin in range(0, len(cells), AT_ONCE):
            more, longest, flights = _ways(
                self.groups, self.trap, cells[begin : begin + AT_ONCE], self.rests, self.compiled
            )
            ways.append(_Ways(more.cell + begin, more.good, more.box))
            longer_sides.append(longest)
            used += flights
        return _joined(ways), np.concatenate(longer_sides), used


def proved_section(
    groups: Groups[float], trap: Trap, fastest: float, rests: Collection[int], compiled: bool
) -> Section:
    """Prove as large shares as the effort allows.

    Parameters
    ----------
    groups : Groups
        Of the device, as computed in doubles.
    trap : Trap
    fastest : float
        Velocity before the impact up to which the section reaches [y_c].
    rests : collection of int
        The membranes from which a ball that they release is proved to come into the region.
    compiled : bool
        Whether to compile the simulation, where numba is there.
    """
    task = _Task(groups, trap, fastest, rests, compiled)
    halving, used, first = Halving(_first_cells(fastest)), 0, 0
    ways, longer_sides = list[_Ways](), np.zeros(0, np.intp)
    while True:
        more, longest, flights = task.ways(halving.cells[first:])
        ways.append(_Ways(more.cell + first, more.good, more.box))
        longer_sides, used = np.concatenate([longer_sides, longest]), used + flights
        first, last = len(halving.cells), used >= MOST_FLIGHTS
        proved = _spread(halving.cells, halving.code < 0, _joined(ways), fastest, None if last else ROUNDS)
        halving.code[proved] = PROVED
        left = np.flatnonzero(halving.code == OPEN)
        sides = (halving.cells.high - halving.cells.low)[:, left] * FINEST / [[PERIOD], [fastest]]
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
    moments, switch_on = _switched_on(task, _Covered(cells, fastest))
    return Section(trap, fastest, halving.codes, moments, _share(cells, fastest), switch_on)


def _switched_on(task: _Task, region: _Covered) -> tuple[Ints, float]:
    """The cells of moments of switching on, and the share of all moments that is proved."""
    halving, first = Halving(_first_moments()), 0
    for turn in range(HALVINGS + 1):
        new = np.arange(first, len(halving.cells))
        proved = _arrives(task, halving.cells[new], region)
        first, halving.code[new[proved]] = len(halving.cells), PROVED
        if turn < HALVINGS:
            halving.halve(new[~proved], np.zeros(np.count_nonzero(~proved), np.intp))
    return halving.codes, _share_of_moments(halving.cells[halving.code == PROVED])


def _arrives(task: _Task, cells: Cells, region: _Covered) -> Mask:
    """Which cells come to the region, as they are or by way of what is known."""
    proved = np.ones(len(cells), dtype=bool)
    if len(cells):
        ways, _, _ = task.ways(cells)
        good = ways.good | np.any([region.holds(ways.box[:, k]) for k in range(RETURNS)], axis=0)
        proved[ways.cell[~good]] = False
    return proved


def _share(proved: Cells, fastest: float) -> float:
    """Share of the section, rounded down."""
    return float(proved.area.sum() / (PERIOD * fastest) * (1 - 1e-12))


def _share_of_moments(proved: Cells) -> float:
    """Share of the forcing period: exact, as its parts are."""
    return float((proved.high[0] - proved.low[0]).sum() / PERIOD)


def section_again(
    groups: Groups[float], trap: Trap, fastest: float, rests: Collection[int], halved: Ints, moments: Ints
) -> tuple[float, float]:
    """Go through the cells of a proof once more; the shares of the section and of moments that are proved.

    That the cells are parts of the section follows from how it is halved; nothing else is believed.

    Raises
    ------
    ValueError
        If there are not as many cells as it takes.
    """
    task = _Task(groups, trap, fastest, rests, compiled=False)
    cells = joined_cells([cells[code == PROVED] for cells, code in generations(_first_cells(fastest), halved)])
    if len(cells):
        ways, _, _ = task.ways(cells)
        cells = cells[_spread(cells, np.ones(len(cells), dtype=bool), ways, fastest)]
    region, switched_on = _Covered(cells, fastest), list[Cells]()
    for parts, code in generations(_first_moments(), moments):
        if (code > 0).any():
            raise ValueError("moments of switching on have one coordinate")
        claimed = parts[code == PROVED]
        switched_on.append(claimed[_arrives(task, claimed, region)])
    return _share(cells, fastest), _share_of_moments(joined_cells(switched_on))
