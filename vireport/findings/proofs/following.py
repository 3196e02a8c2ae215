"""Sets of states followed from impact to impact until they are in a region that a motion attracts."""

from __future__ import annotations

from collections.abc import Collection
from math import ceil, log

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.findings.proofs.flights import (
    FIRST,
    SECOND,
    ImpactSets,
    Sets,
    after_impact,
    enclosed,
    impacts_past_a_touch,
    joined,
    middles,
    next_impacts,
    simulated,
    simulated_past,
)
from vireport.findings.proofs.trap import Trap
from vireport.physics.affine import Affine
from vireport.physics.groups import Groups

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

LARGEST = 0.25
"""Half width in time [t_c] or velocity [y_c] from which a set is given up: halves of its cell are followed instead."""

LAPS, MOST_LAPS = 12, 400
"""Periods that sets are followed: so many and those in which deviations fade to the size of the region; and at most."""


MOST_BRANCHES = 4
"""Sets that one becomes on average, by touches, before all are given up."""


class Goal(Struct, frozen=True, eq=False):
    """The region about a motion of a device that states are to be proved to come to.

    Attributes
    ----------
    groups : Groups
        Of the device, as computed in doubles.
    trap : Trap
        The region.
    rests : collection of int
        The membranes, 1 bottom and -1 top, from which a released ball is proved to come into the region.
    compiled : bool
        Whether to compile the simulation, which gives guesses, if numba is installed.
    """

    groups: Groups[float]
    trap: Trap
    rests: Collection[int] = ()
    compiled: bool = True


def patience(trap: Trap) -> int:
    """Most impacts for which sets are followed: until the slowest deviation has decayed to the size of a region."""
    fading = log(max(trap.radius, 1e-12)) / log(trap.slowest) if trap.slowest > 0 else 0.0
    return min(LAPS + ceil(2 * fading), MOST_LAPS) * len(trap.motion.word)


def flown(goal: Goal, sets: Sets, guesses: Floats | None = None) -> tuple[ImpactSets, Ints, Ints]:
    """Follow sets for one flight, past touches as well.

    Parameters
    ----------
    goal : Goal
        With the device.
    sets : Sets
        States that begin k flights.
    guesses : ndarray (k, 3), optional
        Ends of the flights of the middles, see `next_impacts`; simulated by default, which needs sets at impacts.

    Returns
    -------
    impacts : ImpactSets
        All of them proved; for a set of which only some states touch a membrane, those of both kinds.
    parent : ndarray of int
        Index of the set from which each of the impacts comes.
    lost : ndarray of int
        Indices of sets whose flights are not proved to end anywhere.
    """
    groups, exactly, count = goal.groups, enclosed(goal.groups), len(sets)
    if guesses is None:
        guesses = simulated(groups, middles(groups, sets), goal.compiled)
    impacts = next_impacts(exactly, sets, guesses)
    failing = np.flatnonzero(~impacts.proved)
    if not failing.size:
        return impacts, np.arange(count), failing
    guesses = simulated_past(groups, sets[failing], guesses[failing], goal.compiled)
    # A failing set may graze: some states touch the membrane, others pass it, and both kinds go on as separate sets.
    touch, past, touching = impacts_past_a_touch(exactly, sets[failing], guesses)
    ends, both = np.flatnonzero(impacts.proved), failing[touch]
    return joined([impacts[ends], past, touching]), np.concatenate([ends, both, both]), np.delete(failing, touch)


@np.errstate(all="ignore")  # what is not proved may not be finite
def come_in(goal: Goal, sets: Sets, guesses: Floats | None, most: int) -> tuple[Mask, Ints, int]:
    """Which sets surely come into a region, along which coordinate to halve the others, and the flights followed.

    Once a part of a set is lost, the rest is not followed; `follow_cells` keeps returns of cells that do not arrive.

    Parameters
    ----------
    goal : Goal
        With the region; balls that come to rest are not followed.
    sets : Sets
        States that begin k flights.
    guesses : ndarray (k, 3) or None
        As of `flown`.
    most : int
        Impacts after which sets that are not in the region are given up.
    """
    exactly, flights = enclosed(goal.groups), 0
    lost, halved = np.zeros(len(sets), dtype=bool), longer(sets.time, sets.after)
    # Set k in flight is a part of set `rows[k]`, which has several parts where states touch a membrane others miss.
    rows = np.arange(len(sets))
    for _ in range(most):
        flights += len(rows)
        impacts, parent, failing = flown(goal, sets, guesses)
        lost[rows[failing]] = True
        rows, guesses = rows[parent], None
        halved[rows] = longer(impacts.time, impacts.velocity)
        lost[rows[~is_small(impacts)]] = True
        # A set is proved only by all its parts: once one is lost, the others are not followed.
        outside = ~goal.trap.holds(impacts.wall, impacts.time, impacts.velocity)
        goes_on = np.flatnonzero(outside & ~lost[rows])
        rows = rows[goes_on]
        if not rows.size or len(rows) > MOST_BRANCHES * len(lost):
            break
        sets = after_impact(exactly, impacts, goes_on)
    lost[rows] = True
    return ~lost, halved, flights


def is_small(impacts: ImpactSets) -> Mask:
    """Which sets are small enough to be followed further."""
    return np.asarray((impacts.time.reach < LARGEST) & (impacts.velocity.reach < LARGEST))


def longer(time: Affine, velocity: Affine) -> Ints:
    """The coordinate of a cell, `FIRST` or `SECOND`, along which its image is longer, and it should be halved."""
    size = np.hypot(time.linear, velocity.linear)
    return np.where(size[SECOND] > size[FIRST], SECOND, FIRST)
