"""Itineraries of cells of impacts: where they return to the bottom membrane, and whether they arrive at a motion.

Some states of a cell may touch a membrane that others miss. From such a touch on the cell has two itineraries, so that
a cell has as many as there are ways for its states to go.

Infinitely many ever lower hops may be proved to end in rest (chatter). Each hop is bounded by the least and the largest
acceleration that presses the ball onto the membrane. Where all hops together end before this acceleration vanishes, the
ball rests until its release, which happens in one state.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.findings.proofs.cells import Cells
from vireport.findings.proofs.flights import (
    FIRST,
    SECOND,
    SYMBOLS,
    ImpactSets,
    Sets,
    after_impact,
    enclosed,
    restitutions,
)
from vireport.findings.proofs.following import Goal, flown, is_small, longer, patience
from vireport.physics.affine import AFFINE_ROUNDING, between
from vireport.physics.groups import Groups
from vireport.simulation.events import BOTTOM

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

RETURNS = 3
"""Impacts on the bottom membrane after which a cell is followed further only where it is near the region."""

NEAR = 10.0
"""How near, over the region's radius: there the way into it is long where disturbances die out slowly."""


class Itineraries(Struct, frozen=True, eq=False):
    """Successive returns to the bottom membrane that the states of cells take, n itineraries in all.

    Invariant: every state of a cell takes one of the cell's itineraries. It returns to the bottom membrane first in box
    0 of that, then in box 1, and so on through its `returns` boxes; and if the itinerary `arrives`, it comes to the
    motion. So a cell is proved once each of its itineraries arrives, or has a box all of which is proved.

    Attributes
    ----------
    cell : ndarray of int (n,)
        Number of the cell.
    arrives : ndarray of bool (n,)
        Whether it ends in the region, or in a rest from which the ball is proved to come there.
    returns : ndarray of int (n,)
        Number of its boxes, at most `RETURNS`.
    box : ndarray (n, RETURNS, 4)
        Least and largest time [t_c], least and largest velocity before the impact [y_c] at each return; NaN from box
        `returns` on.
    """

    cell: Ints
    arrives: Mask
    returns: Ints
    box: Floats

    @classmethod
    def begun(cls, count: int) -> Itineraries:
        """One itinerary for each of some cells, in which nothing has happened yet."""
        empty = np.full((count, RETURNS, 4), np.nan)
        return cls(np.arange(count), np.zeros(count, dtype=bool), np.zeros(count, np.intp), empty)

    def __getitem__(self, rows: Any) -> Itineraries:
        return Itineraries(*(getattr(self, name)[rows] for name in self.__struct_fields__))

    def __len__(self) -> int:
        return len(self.cell)

    def __add__(self, other: Itineraries) -> Itineraries:
        columns = ((getattr(self, name), getattr(other, name)) for name in self.__struct_fields__)
        return Itineraries(*map(np.concatenate, columns))

    def of_cells_from(self, first: int) -> Itineraries:
        """The itineraries with cells numbered from `first` on instead of from 0."""
        return replace(self, cell=self.cell + first)

    def with_arrivals(self, rows: Ints) -> Itineraries:
        """The itineraries with some marked as arrived."""
        arrives = self.arrives.copy()
        arrives[rows] = True
        return replace(self, arrives=arrives)

    def with_returns(self, rows: Ints, impacts: ImpactSets) -> Itineraries:
        """The itineraries with one more return for some, each named once: sets of impacts on the bottom membrane."""
        # Advanced indexing would count a row that is named twice only once.
        returns, box = self.returns.copy(), self.box.copy()
        time, velocity = impacts.time, impacts.velocity
        box[rows, returns[rows]] = np.stack([time.lower, time.upper, velocity.lower, velocity.upper], axis=1)
        returns[rows] += 1
        return replace(self, returns=returns, box=box)


class _Fronts(Struct, frozen=True, eq=False):
    """The latest impacts of itineraries that are still followed.

    Invariant: no itinerary has two fronts, and those without have ended: they arrive, or are given up. Every state of a
    cell is in the front of the itinerary that it takes, if there is one.

    Attributes
    ----------
    itinerary : ndarray of int (k,)
    impacts : ImpactSets
        Of k sets.
    """

    itinerary: Ints
    impacts: ImpactSets

    def __getitem__(self, rows: Any) -> _Fronts:
        return _Fronts(self.itinerary[rows], self.impacts[rows])


@np.errstate(all="ignore")  # what is not proved may not be finite
def follow_cells(goal: Goal, cells: Cells) -> tuple[Itineraries, Ints, int]:
    """Follow cells of impacts on the bottom membrane until they arrive, or are given up.

    Given up are enclosures that are too large or not near the region after `RETURNS` returns, and sets whose flights
    are not proved to end anywhere; their itineraries stay as they are, and prove nothing.

    Parameters
    ----------
    goal : Goal
    cells : Cells
        Of times [t_c] and velocities before the impact [y_c].

    Returns
    -------
    itineraries : Itineraries
        First one for each cell in order, then those that branch off at touches.
    halved : ndarray of int (cells,)
        The coordinate along which each cell should be halved, if it has to be.
    flights : int
        Flights of sets that were followed.
    """
    count, flights = len(cells), 0
    time, velocity = (between(cells.low[k], cells.high[k], symbol, SYMBOLS) for k, symbol in ((0, FIRST), (1, SECOND)))
    itineraries, halved = Itineraries.begun(count), longer(time, velocity)
    struck = ImpactSets(np.ones(count, dtype=bool), np.full(count, BOTTOM), time, velocity, time)
    fronts = _Fronts(np.arange(count), struck)
    # In turn, arrivals are marked and all others are followed for one flight.
    for _ in range(patience(goal.trap)):
        itineraries, departing, sets = _departing(goal, itineraries, fronts)
        if not departing.size:
            break
        flights += len(departing)
        itineraries, fronts = _landed(goal, itineraries, departing, sets)
        halved[itineraries.cell[fronts.itinerary]] = longer(fronts.impacts.time, fronts.impacts.velocity)
        fronts = fronts[is_small(fronts.impacts)]
    return itineraries, halved, flights


def _departing(goal: Goal, itineraries: Itineraries, fronts: _Fronts) -> tuple[Itineraries, Ints, Sets]:
    """Itineraries with arrivals marked, the numbers of those that go on, and the sets that begin their flights."""
    trap, exactly, impacts = goal.trap, enclosed(goal.groups), fronts.impacts
    inside = trap.holds(impacts.wall, impacts.time, impacts.velocity)
    itineraries = itineraries.with_arrivals(fronts.itinerary[inside])
    # Impacts on the top are not compared with the region, which is about one on the bottom, and always go on.
    deviation = trap.size(*trap.deviations(impacts.time, impacts.velocity))
    near = (impacts.wall != BOTTOM) | (deviation < NEAR * trap.radius)
    goes_on = np.flatnonzero(~inside & ((itineraries.returns[fronts.itinerary] < RETURNS) | near))
    itinerary, sets = fronts.itinerary[goes_on], after_impact(exactly, impacts, goes_on)
    # A resting ball is released in one state of each membrane, wherever it came from: its future is known.
    resting = settles(exactly, sets)
    itineraries = itineraries.with_arrivals(itinerary[resting & np.isin(sets.wall, list(goal.rests))])
    moving = np.flatnonzero(~resting)
    return itineraries, itinerary[moving], sets[moving]


def _landed(goal: Goal, itineraries: Itineraries, departing: Ints, sets: Sets) -> tuple[Itineraries, _Fronts]:
    """Itineraries and their fronts after one flight each; where a set is not proved to land, its itinerary ends."""
    impacts, parent, _ = flown(goal, sets)
    itinerary = departing[parent]
    # A set lands twice if some of its states touch a membrane that others miss: the latter part from the former.
    _, first = np.unique(parent, return_index=True)
    second = np.setdiff1d(np.arange(len(parent)), first)
    parting = itineraries[itinerary[second]]
    itinerary[second] = len(itineraries) + np.arange(len(second))
    itineraries = itineraries + parting
    returning = (impacts.wall == BOTTOM) & (itineraries.returns[itinerary] < RETURNS)
    itineraries = itineraries.with_returns(itinerary[returning], impacts[returning])
    return itineraries, _Fronts(itinerary, impacts)


WINDOWS = np.geomspace(1e-3, 1.5, 24)
"""Times [t_c] after an impact within which rest is looked for."""

SLACK = 1e-9
"""Share by which bounds are widened, far beyond their roundings."""


@np.errstate(all="ignore")  # what is not defined is not settled
def settles(groups: Groups[Any], sets: Sets) -> Mask:
    """Which sets surely come to rest on the membrane that they have just struck, before it releases the ball.

    Parameters
    ----------
    groups : Groups of Affine
        Of the device, see `enclosed`.
    sets : Sets
        A set that does not begin at an impact is never said to settle.

    Notes
    -----
    Let A be the pressing acceleration, y the distance and v the velocity after an impact. While A rises y'^2/(2 A) + y
    does not grow, and while it falls y'^2/2 + A y does not. So while A > 0 no velocity at the membrane exceeds k v,
    with k^2 the largest A over that at the beginning, if A has one maximum, as that of a sine has. A hop that leaves
    with u takes 2 u/min A at most, and the bound of u falls by r from hop to hop: all take 2 k v/[(1 - r) min A], and
    none is higher than (k v)^2/(2 min A). Where that time is over before A vanishes, the ball rests by then.
    """
    # After a shock the ball is off the membrane: only sets that begin at an impact are judged.
    begins = (sets.since.reach == 0) & (sets.since.centre == 0) & (sets.offset.reach == 0) & (sets.offset.centre == 0)
    speed = np.maximum(np.abs(sets.after.lower), np.abs(sets.after.upper))[:, None]
    first, last = sets.time.lower[:, None], sets.time.upper[:, None] + WINDOWS
    side, lower, upper = sets.wall[:, None], float(groups.gbar.lower[0]), float(groups.gbar.upper[0])
    pull = np.where(side > 0, lower, -upper), np.where(side > 0, upper, -lower)
    at_first, at_last = side * np.cos(pi * first), side * np.cos(pi * last)
    # The force presses most at multiples of the period, on the top half a period later; least another half later.
    crest = np.where(side > 0, 0.0, 1.0)
    crests = np.floor((last - crest) / 2) >= np.ceil((first - crest) / 2)
    troughs = np.floor((last - crest - 1) / 2) >= np.ceil((first - crest - 1) / 2)
    least = np.where(troughs, -np.inf, np.minimum(at_first, at_last)) + pull[0] - SLACK
    most = np.where(crests, 1.0, np.maximum(at_first, at_last)) + pull[1] + SLACK
    # The least A at the beginning of any state is at an end of their range: with a trough in it `least` is -inf.
    ends = sets.time.upper[:, None]
    begin = np.minimum(at_first, side * np.cos(pi * ends)) + pull[0] - SLACK
    fastest = speed * np.sqrt(most / begin) * (1 + SLACK)
    r = restitutions(groups, sets.wall)[:, None]
    taken = 2 * fastest / ((1 - r) * least) * (1 + SLACK)
    distance = float(groups.d.lower[0])
    rests = (least > 0) & (begin > 0) & (taken <= WINDOWS * (1 - SLACK)) & (r < 1 - AFFINE_ROUNDING)
    rests &= fastest**2 < 2 * least * distance * (1 - SLACK)
    return np.asarray(begins & rests.any(axis=1))
