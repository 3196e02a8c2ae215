"""Hops that surely end in rest: of a set of states just after impacts, infinitely many ever lower ones, and the ride.

Each hop is bounded by the least and the largest of the acceleration that presses the ball onto the membrane, so that
all of them together end before that vanishes. Then the ball lies there until its release, which is one state.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.findings.proofs.flights import Sets, restitutions
from vireport.physics.affine import AFFINE_ROUNDING
from vireport.physics.groups import Groups

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

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
        Those that begin elsewhere than at an impact do not.

    Notes
    -----
    Let A be the pressing acceleration, y the distance and v the velocity after an impact. While A rises y'^2/(2 A) + y
    does not grow, and while it falls y'^2/2 + A y does not. So while A > 0 no velocity at the membrane exceeds k v,
    with k^2 the largest A over that at the beginning, if A has one maximum, as that of a sine has. A hop that leaves
    with u takes 2 u/min A at most, and the next one leaves with r times as much: all take 2 k v/[(1 - r) min A], and
    none is higher than (k v)^2/(2 min A). Where that time is over before A vanishes, the ball rests by then.
    """
    # After a shock the ball is off the membrane: only sets that begin at an impact are judged.
    begins = (sets.since.reach == 0) & (sets.since.centre == 0) & (sets.offset.reach == 0) & (sets.offset.centre == 0)
    speed = np.maximum(np.abs(sets.after.lower), np.abs(sets.after.upper))[:, None]
    first, last = sets.time.lower[:, None], sets.time.upper[:, None] + WINDOWS
    side, lower, upper = sets.wall[:, None], float(groups.gbar.lower[0]), float(groups.gbar.upper[0])
    pull = np.where(side > 0, lower, -upper), np.where(side > 0, upper, -lower)
    at_first, at_last = side * np.cos(pi * first), side * np.cos(pi * last)
    # The force presses most at multiples of the period, for the top half of it later; least half a period after that.
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
