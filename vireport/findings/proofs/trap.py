"""A region around a stable motion that the return map provably contracts, so that all states in it come to the motion.

In a suitable metric the derivative of the return map to one impact has a norm below 1 everywhere in an ellipse, and the
middle of the ellipse is mapped so near to itself that the ellipse is mapped into itself. By Banach's theorem it holds
exactly one periodic motion, to which all states come that are ever in it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.findings.outcomes.deviations import growth, lap_matrix, stationary
from vireport.findings.proofs.flights import (
    FIRST,
    SECOND,
    SYMBOLS,
    ImpactSets,
    after_impact,
    enclosed,
    exact,
    middles,
    next_impacts,
    restitutions,
    simulated,
)
from vireport.motions.stability import Jacobian, flight_jacobian, lap_jacobian
from vireport.physics.affine import AFFINE, AFFINE_ROUNDING, Affine
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

WIDEST = 0.4
"""Half width in time [t_c] and velocity [y_c] of the largest region that is tried."""

SHRUNK, STEP = 40, 0.7
"""Regions tried, each so much smaller than the one before."""

TILES = 12
"""Tiles along either side of the square about the region, in each of which derivatives are enclosed."""


class Trap(Struct, frozen=True, eq=False):
    """A trapping region: an ellipse about an impact of a periodic motion that the return map contracts into itself.

    Attributes
    ----------
    motion : Motion
        The region is about its first impact.
    metric : ndarray (2, 2)
        M, upper triangular: the region is ``|M x| <= radius``, x deviations of time [t_c] and velocity before [y_c].
    radius : float
    contraction : float
        Bound, below 1, of the norm of M DP M^-1 in it.
    off : float
        Bound of the distance of the periodic motion from the middle, in the metric.
    slowest : float
        Largest modulus of the motion's multipliers, not proved; it tells for how long sets are to be followed.
    """

    motion: Motion
    metric: Floats
    radius: float
    contraction: float
    off: float
    slowest: float

    def holds(self, wall: Any, time: Affine, velocity: Affine) -> Mask:
        """Which sets of states before impacts, (k,), lie surely in the region."""
        late, fast = self.deviations(time, velocity)
        return np.asarray((wall == self.motion.word.walls[0]) & (self.size(late, fast) <= self.radius))

    def deviations(self, time: Affine, velocity: Affine) -> tuple[Affine, Affine]:
        """Deviations of time [t_c], up to whole forcing periods, and velocity [y_c] from the motion's impact."""
        # The force has the period 2 t_c: states that differ by whole periods are the same.
        whole = 2.0 * np.round((time.centre - self.motion.time[0]) / 2)
        return time - whole - float(self.motion.time[0]), velocity - float(self.motion.velocity[0])

    def size(self, late: Affine, fast: Affine) -> Floats:
        """A bound of ``|M x|`` over each set of deviations."""
        (a, b), (_, c) = self.metric.tolist()
        first, second = a * late + b * fast, c * fast
        return np.hypot(_largest(first), _largest(second)) * (1 + AFFINE_ROUNDING)


def _largest(x: Affine) -> Floats:
    """Largest modulus of each affine number."""
    return np.maximum(np.abs(x.lower), np.abs(x.upper))


def trap_of(groups: Groups[float], motion: Motion, compiled: bool) -> Trap | None:
    """Find the largest trapping region about a motion, of those that are tried; None where none is proved.

    With S = sum over k of (A/rho)^k' (A/rho)^k = M' M, the norm of M A M^-1 is below rho, which is put halfway between
    the modulus of the larger multiplier and 1.
    """
    lap = lap_matrix(groups, motion)
    slowest = growth(lap)
    if not slowest < 1:
        return None
    metric = np.asarray(np.linalg.cholesky(stationary(2 * lap.T / (1 + slowest), np.eye(2))).T, dtype=float)
    radius = WIDEST / float(np.linalg.norm(np.linalg.inv(metric), axis=1).max())
    # Near the motion the map is nearly linear: where a proof fails, the ellipse is too large.
    for _ in range(SHRUNK):
        trap = proved_trap(groups, motion, metric, radius, compiled)
        if trap is not None:
            return trap
        radius *= STEP
    return None


@np.errstate(all="ignore")
def proved_trap(groups: Groups[float], motion: Motion, metric: Floats, radius: float, compiled: bool) -> Trap | None:
    """Prove that the return map contracts an ellipse into itself; None where the proof fails.

    The derivative of the return map is enclosed over each of the tiles that cover the ellipse; its norm in the metric
    bounds by how much it contracts, and the distance by which it misses the middle whether it maps it into itself.

    Parameters
    ----------
    groups : Groups
        Of the device, as computed in doubles.
    motion : Motion
        About whose first impact the ellipse is.
    metric : ndarray (2, 2)
        Upper triangular, see `Trap`.
    radius : float
    compiled : bool
        Whether to compile the simulation, which says where flights end, where numba is there.
    """
    inverse = np.asarray(np.linalg.inv(metric), dtype=float)
    off = _missed(groups, motion, metric, compiled)
    if off is None:
        return None
    edge = np.linspace(-1.0, 1.0, TILES + 1)
    middle, half = (edge[1:] + edge[:-1]) / 2, radius / TILES
    first, second = (grid.ravel() * radius for grid in np.meshgrid(middle, middle))
    # Only those tiles of the square that the ellipse, a disk in the metric, reaches into.
    nearest = np.hypot(np.maximum(np.abs(first) - half, 0), np.maximum(np.abs(second) - half, 0))
    first, second = (coordinate[nearest <= radius] for coordinate in (first, second))
    # Slightly larger, so that roundings leave no gap between tiles.
    half *= 1 + 1e-6
    time, velocity = _tiles(motion, inverse, first, second, half)
    derivative = lap_derivative(groups, motion, time, velocity, compiled)
    if derivative is None:
        return None
    contraction = norm_bound(metric, derivative)
    # |P(x) - c| <= |P(c) - c| + L |x - c|, and the motion is within |P(c) - c|/(1 - L) of c.
    if not (contraction < 1 and off + contraction * radius <= radius * (1 - AFFINE_ROUNDING)):
        return None
    aside, slowest = off / (1 - contraction) * (1 + 1e-12), growth(lap_matrix(groups, motion))
    return Trap(motion, metric, radius, contraction, aside, slowest)


def _tiles(motion: Motion, inverse: Floats, first: Floats, second: Floats, half: float) -> tuple[Affine, Affine]:
    """Tiles, squares in the metric about (first, second) with a half width, as sets of time and velocity."""
    numbers = []
    for at, row in zip((motion.time[0], motion.velocity[0]), inverse.tolist(), strict=True):
        linear = np.zeros((SYMBOLS, len(first)))
        linear[FIRST], linear[SECOND] = row[0] * half, row[1] * half
        numbers.append(Affine(float(at) + row[0] * first + row[1] * second, linear, np.zeros(len(first))))
    return numbers[0], numbers[1]


def _missed(groups: Groups[float], motion: Motion, metric: Floats, compiled: bool) -> float | None:
    """Bound of the distance, in the metric, from a motion's first impact to its image; None where it is not proved."""
    # The motion in doubles is not quite periodic, and need not be: the proof uses only that it nearly is.
    trap = Trap(motion, metric, 0.0, 0.0, 0.0, 0.0)
    time, velocity = (exact(np.array([float(value)])) for value in (motion.time[0], motion.velocity[0]))
    for _, impacts in around(groups, motion, time, velocity, compiled):
        if not impacts.proved.all():
            return None
    return float(trap.size(*trap.deviations(impacts.time, impacts.velocity))[0])


def around(groups: Groups[float], motion: Motion, time: Affine, velocity: Affine, compiled: bool) -> Any:
    """Follow sets of states through one period of a motion, impact by impact.

    Parameters
    ----------
    groups : Groups
        Of the device, as computed in doubles.
    motion : Motion
    time, velocity : Affine (k,)
        Of the sets, before the motion's first impact [t_c, y_c].
    compiled : bool
        As of `proved_trap`.

    Yields
    ------
    before, impacts : ImpactSets
        At both ends of each flight; not proved where a state leaves the motion's word.
    """
    walls, exactly = motion.word.walls, enclosed(groups)
    count = len(time.centre)
    at = ImpactSets(np.ones(count, dtype=bool), np.full(count, walls[0]), time, velocity, time)
    for wall in (*walls[1:], walls[0]):
        sets = after_impact(exactly, at, slice(None))
        before, at = at, next_impacts(exactly, sets, simulated(groups, middles(groups, sets), compiled))
        at.proved[at.wall != wall] = False
        yield before, at


def lap_derivative(
    groups: Groups[float], motion: Motion, time: Affine, velocity: Affine, compiled: bool
) -> Jacobian | None:
    """Enclosures of the derivative of the return map over sets, its entries row by row; None if one is not proved."""
    exactly, flights = enclosed(groups), list[Jacobian]()
    for before, at in around(groups, motion, time, velocity, compiled):
        if not at.proved.all():
            return None
        start, end = (exactly.pull(AFFINE.cos(AFFINE.pi * impacts.time)) for impacts in (before, at))
        r = restitutions(groups, before.wall)
        flights.append(flight_jacobian(at.duration, (before.velocity, at.velocity), (start, end), r))
    return lap_jacobian(flights)


def norm_bound(metric: Floats, derivative: Any) -> float:
    """Bound of the spectral norm of M J M^-1 for all matrices J in all enclosures, which are entries row by row."""
    (p, q), (_, s) = metric.tolist()
    a, b, c, d = derivative
    # The inverse of an upper triangular matrix is [[1/p, -q/(p s)], [0, 1/s]].
    top, bottom = (p * a + q * c, p * b + q * d), (s * c, s * d)
    entries = [entry for left, right in (top, bottom) for entry in (left / p, right / s - left * (q / (p * s)))]
    centre = np.stack([entry.centre for entry in entries], axis=1).reshape(-1, 2, 2)
    spread = np.stack([entry.reach for entry in entries], axis=1)
    # The norm of a sum is at most the sum of norms, and the spectral norm at most Frobenius's.
    norms = np.linalg.norm(centre, 2, axis=(1, 2)) + np.linalg.norm(spread, axis=1)
    return float(norms.max() * (1 + 1e-12) + 1e-13)
