"""Motions with one impact, on the bottom, in some forcing periods.

All of a sweep are found by a scan over the phase, and the stable ones above a table at one gbar by formulae.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import asin, ceil, floor, pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.motions.atlas.surface import Candidates, room, search_end, within
from vireport.motions.periodicity import Model
from vireport.motions.sweep import Held
from vireport.physics.groups import Groups, by_wall
from vireport.physics.motion import Motion
from vireport.physics.word import Word

Floats = NDArray[np.float64]

PARTS, HALVINGS = 256, 14
"""Parts of the range of phases, and halvings of those that may hold an end of a family: less than a millionth of a
radian around the end stays undecided."""


def one_impact(model: Model, low: float, high: float, periods: int) -> Candidates:
    """Find one motion of every family with one impact.

    Parameters
    ----------
    model : Model
        Of a capsule that is not horizontal.
    low, high : float
        Range of the coordinate.
    periods : int
        Forcing periods of the motion, k.

    Notes
    -----
    By (2.11) and (2.12) over the one flight sin(phi) = a gbar, where a = pi k (1 - r)/(1 + r). After a time t the ball
    is gbar t (2k - t)/2 + [cos(phi + pi t) - cos(phi)]/pi^2 above the bottom. Per radian of phi that changes by at most
    k^2/(2a) + 3/pi^2: a phase at which the ball is beyond a membrane by some distance excludes others around it.
    """
    word = Word((1,), periods)
    high = search_end(model, word, low, high)
    r, _ = by_wall(model.r)
    level, a = model.level, pi * periods * (1 - r) / (1 + r)

    def above(phase: Floats) -> Candidates:
        gbar = np.sin(phase) / a
        velocity, d = 2 * periods * gbar / (1 + r), room(level, high, gbar) + 0 * gbar
        excess = np.empty((0, len(d)))
        return Candidates(word, velocity[None], phase[None] / pi, gbar, d, excess, model.r)

    if level.held is Held.GBAR:
        # gbar is held: sin(phi) = a gbar leaves two phases, each of one motion for all d that leave the ball its room.
        sine = a * level.value
        return within(above(np.array([asin(sine), pi - asin(sine)] if sine < 1 else [])), level, low, high)[0]
    ratio = level.value if level.held is Held.RATIO else 0.0
    slope = (periods**2 / 2 + 1 + ratio) / a + 3 / pi**2  # of the distance from the membranes and the ends of the sweep
    side, parts = pi / PARTS, []
    centre = np.linspace(side, 2 * pi - side, PARTS) / 2

    def room_of(phase: Floats) -> Floats:
        """Distance of the ball from the membranes, or of the motion from the ends of the sweep if that is less."""
        motions = above(phase)
        coordinate = motions.coordinate(level)
        return np.minimum(motions.gap, np.minimum(coordinate - low, high - coordinate))

    for _ in range(HALVINGS):
        inside = room_of(centre)
        parts.append(np.stack([centre, inside]))
        centre, side = centre[np.abs(inside) < slope * side / 2], side / 2
        centre = np.concatenate([centre - side / 2, centre + side / 2])
    if high - low < 2 * slope * side:  # the smallest parts may pass over it: both phases in its middle are tried
        sine = a * (low + high) / 2 / (ratio or 1.0)
        middle = np.array([asin(sine), pi - asin(sine)] if sine < 1 else [])
        parts.append(np.stack([middle, room_of(middle)]))
    whole = np.concatenate(parts, axis=1)
    phase, inside = whole[:, np.argsort(whole[0])]
    runs = np.flatnonzero(np.diff(inside > 0, prepend=False, append=False)).reshape(-1, 2)
    return above(np.array([phase[i + np.argmax(inside[i:j])] for i, j in runs], dtype=float))


def stable_on_table(groups: Groups[Any]) -> Iterator[Motion]:
    """The stable motions with one impact of a ball on a table that a sine shakes, in any number of forcing periods.

    Parameters
    ----------
    groups : Groups
        With gravity; the restitution at the bottom is constant and below 1. Harmonics are left out.

    Notes
    -----
    With `a` as in `one_impact`, a motion in k periods is stable where cos(phi) is below 0, where it begins at a fold,
    and above -2 gbar (1 + r^2)/(1 + r)^2, where its period doubles (Luck and Mehta, Phys. Rev. E 48, 1993, 3988). As
    sin(phi) = a gbar, these are the numbers k between two limits.
    """
    gbar, (r, _) = float(groups.gbar), map(float, by_wall(groups.restitution))
    sine = pi * gbar * (1 - r) / (1 + r)
    least = sqrt(max(0.0, 1 - (2 * gbar * (1 + r * r) / (1 + r) ** 2) ** 2)) / sine
    for periods in range(max(ceil(least), 1), floor(1 / sine) + 1):
        velocity, phase = 2 * periods * gbar / (1 + r), pi - asin(min(periods * sine, 1.0))
        yield Motion(Word((1,), periods), np.array([velocity]), np.array([phase / pi]), 0.0)
