"""Basins on the section of impacts: which impacts on the bottom membrane lead to which motion.

A picture of a grid, and the share of the section that each motion has, by random impacts.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.base.records import brief
from vireport.base.shares import share_interval
from vireport.findings.outcomes.plane import OutcomePlane, coloured
from vireport.findings.outcomes.returning import Recogniser
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.simulation.events import BOTTOM
from vireport.simulation.kernel import TURN
from vireport.simulation.starts import start_speed

Floats = NDArray[np.float64]

IMPACTS, SEED = 4000, 20240607
"""Random impacts, of which a share of one half is known to within 1.6 %, and their seed."""


class Basins(Struct, frozen=True, eq=False):
    """Basins of attraction on the section of impacts on the bottom membrane.

    Attributes
    ----------
    plane : OutcomePlane
        With x the forcing phase [rad] and y the velocity just before the impact [y_c].
    motions : tuple of Motion
        The stable motions that were known before; their outcomes are the first.
    hits : tuple of int
        Number of random impacts, uniform in phase and velocity, that lead to each outcome.
    velocity_unit : float
        y_c [m/s].
    """

    plane: OutcomePlane
    motions: tuple[Motion, ...]
    hits: tuple[int, ...]
    velocity_unit: float

    __repr__ = brief

    @property
    def impacts(self) -> int:
        """Number of random impacts."""
        return sum(self.hits)

    @property
    def fastest_m_s(self) -> float:
        """Largest velocity before an impact [m/s]."""
        return float(self.plane.y[-1]) * self.velocity_unit

    @property
    def shares(self) -> list[tuple[str, float, float, float]]:
        """Name of each outcome that occurs, its share of the section and ends of the 95 % interval; largest first."""
        rows = [
            (of.name, *share_interval(hits, self.impacts))
            for of, hits in zip(self.plane.outcomes, self.hits, strict=True)
            if hits
        ]
        return sorted(rows, key=lambda row: -row[1])


def basins_of(
    groups: Groups[float], motions: Sequence[Motion], velocity_unit: float, points: int = 257
) -> Basins | None:
    """The basins of stable motions among impacts on the bottom membrane; None where returns to one are not resolved.

    Parameters
    ----------
    groups : Groups
        Of the device.
    motions : sequence of Motion
        Stable motions that are known; others that the impacts lead to are added.
    velocity_unit : float
        y_c [m/s].
    points : int
        Points along either axis of the picture: one more than a power of 2, at least 17.

    Notes
    -----
    The section reaches up to half as much again as the fastest impact that the forcing sustains, see `start_speed`.
    """
    try:
        recognise = Recogniser(groups, motions)
    except (NumericalError, ValueError):  # too near a critical point, or a ball that does not bounce
        return None
    fastest = max((float(np.abs(motion.velocity).max()) for motion in motions), default=0.0)
    speed = float(start_speed(groups.restitution, fastest))

    def impacts(phase: Floats, velocity: Floats) -> Floats:
        rows = np.zeros((len(phase), 4))
        rows[:, 0], rows[:, 2], rows[:, 3] = BOTTOM, velocity, phase
        return rows

    # A phase of a whole turn would be that of 0 again.
    x, y = np.linspace(0.0, TURN * (1 - 1e-12), points), np.linspace(0.0, speed, points)
    # Bands are thin and many: a quadtree would break them.
    plane = coloured(recognise, x, y, impacts, points - 1)
    # Shares are not counted in the picture's cells: these would miscount bands that are thinner than they.
    phase, velocity = np.random.default_rng(SEED).random((2, IMPACTS))
    counted = Counter(recognise(impacts(TURN * phase, speed * velocity)).tolist())
    # The random impacts may have led to motions that the grid had passed over.
    outcomes = tuple(recognise.outcomes)
    plane = OutcomePlane(plane.x, plane.y, plane.outcome, outcomes, plane.evaluated)
    return Basins(plane, tuple(motions), tuple(counted[k] for k in range(len(outcomes))), velocity_unit)
