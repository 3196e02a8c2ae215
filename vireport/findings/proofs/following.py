"""Sets of states followed from impact to impact until they are in a region that a motion attracts."""

from __future__ import annotations

from math import ceil, log

import numpy as np
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
"""Half width in time [t_c] or velocity [y_c] from which a set is not followed any further: its parts are."""

LAPS, MOST_LAPS = 12, 400
"""Periods that sets are followed: so many and those in which deviations fade to the size of the region; and at most."""


MOST_BRANCHES = 4
"""Sets that one becomes on average, by touches, before all are given up."""


def patience(trap: Trap) -> int:
    """Impacts that sets are followed for at most, where the slowest deviation fades by a factor a period."""
    fading = log(max(trap.radius, 1e-12)) / log(trap.slowest) if trap.slowest > 0 else 0.0
    return min(LAPS + ceil(2 * fading), MOST_LAPS) * len(trap.motion.word)


def flown(groups: Groups[float], sets: Sets, guesses: Floats, compiled: bool) -> tuple[ImpactSets, Ints, Ints]:
    """Follow sets for one flight, past touches as well.

    Parameters
    ----------
    sets : Sets
        That begin flights.
    guesses : ndarray (k, 3)
        Where these end, see `next_impacts`.

    Returns
    -------
    impacts : ImpactSets
        All of them proved; of a set some of whose states touch a membrane, those of both kinds.
    parent : ndarray of int
        The sets that they are of.
    lost : ndarray of int
        Sets that are not proved to end anywhere.
    """
    exactly, count = enclosed(groups), len(sets)
    at = next_impacts(exactly, sets, guesses)
    failing = np.flatnonzero(~at.proved)
    if not failing.size:
        return at, np.arange(count), failing
    guesses = simulated_past(groups, sets[failing], guesses[failing], compiled)
    touch, past, touching = impacts_past_a_touch(exactly, sets[failing], guesses)
    ends, both = np.flatnonzero(at.proved), failing[touch]
    return joined([at[ends], past, touching]), np.concatenate([ends, both, both]), np.delete(failing, touch)


@np.errstate(all="ignore")  # what is not proved may not be finite
def come_in(
    groups: Groups[float], trap: Trap, sets: Sets, guesses: Floats, impacts: int, compiled: bool
) -> tuple[Mask, Ints, int]:
    """Which sets surely come into a region, along which coordinate to halve the others, and the flights followed.

    Parameters
    ----------
    sets : Sets
        That begin flights.
    guesses : ndarray (k, 3)
        Where these end, see `next_impacts`.
    impacts : int
        After which sets that are not in it are given up.
    """
    exactly, flights = enclosed(groups), 0
    lost, halved = np.zeros(len(sets), dtype=bool), longer(sets.time, sets.after)
    rows = np.arange(len(sets))
    for _ in range(impacts):
        flights += len(rows)
        at, parent, failing = flown(groups, sets, guesses, compiled)
        lost[rows[failing]] = True
        rows = rows[parent]
        halved[rows] = longer(at.time, at.velocity)
        lost[rows[~is_small(at)]] = True
        goes_on = np.flatnonzero(~trap.holds(at.wall, at.time, at.velocity) & ~lost[rows])
        rows = rows[goes_on]
        if not rows.size or len(rows) > MOST_BRANCHES * len(lost):
            break
        sets = after_impact(exactly, at, goes_on)
        guesses = simulated(groups, middles(groups, sets), compiled)
    lost[rows] = True
    return ~lost, halved, flights


def is_small(at: ImpactSets) -> Mask:
    """Which sets are small enough to be followed any further."""
    return np.asarray((at.time.reach < LARGEST) & (at.velocity.reach < LARGEST))


def longer(time: Affine, velocity: Affine) -> Ints:
    """The coordinate of a set along which it is longer."""
    size = np.hypot(time.linear, velocity.linear)
    return np.where(size[SECOND] > size[FIRST], SECOND, FIRST)
