"""Small deviations from a periodic motion: how they go from impact to impact, and how far random kicks spread them.

Turns a motion into the Jacobians of its flights in (time, velocity before the impact), which are those of the
simulation, and solves the discrete Lyapunov equations that rest on them.
"""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import NDArray

from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import FLOATS
from vireport.simulation.cycles import jacobians
from vireport.simulation.events import check_model
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, VELOCITY, WALL

Floats = NDArray[np.float64]

NO_VELOCITY = 1e-14
"""Velocity before an impact [y_c] that rounding does not tell from none."""


def is_smooth(motion: Motion) -> bool:
    """Whether the map from impact to impact has derivatives at a motion: no impact velocity is zero (grazing)."""
    return bool(np.abs(motion.velocity).min() > NO_VELOCITY)


def flight_matrices(groups: Groups[float], motion: Motion) -> Floats:
    """Derivatives of time [t_c] and velocity [y_c] of the next impact by those of each impact, (N, 2, 2).

    Parameters
    ----------
    groups : Groups
        Of the device.
    motion : Motion
        No impact may have zero velocity: the map has no derivative there.
    """
    before = np.zeros((len(motion.word), RIDING + 1))
    before[:, WALL], before[:, PHASE], before[:, VELOCITY] = motion.word.walls, motion.phase, motion.velocity
    # The flight time in a row of the simulation is that of the flight which ends there.
    before[:, FLIGHT] = np.roll(motion.durations, 1)
    by_phase = jacobians(check_model(groups)[0], before, np.roll(before, -1, axis=0))
    # A phase is pi times a time: derivatives of it are pi times as large, those with respect to it 1/pi times.
    return np.asarray(by_phase * np.array([[1.0, 1 / pi], [pi, 1.0]]))


def lap_matrix(groups: Groups[float], motion: Motion) -> Floats:
    """Derivative of the return map at a motion: of time and velocity of its first impact, over one period, (2, 2)."""
    return chained(flight_matrices(groups, motion))


def chained(matrices: Floats) -> Floats:
    """Product of a chain of matrices (N, 2, 2), the first one rightmost."""
    chain = np.eye(2)
    for matrix in matrices:
        chain = matrix @ chain
    return chain


def growth(matrix: Floats) -> float:
    """Largest modulus of the eigenvalues: for the matrix of one period it is below 1 where the motion is stable."""
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def kick_effects(groups: Groups[float], motion: Motion) -> Floats:
    """Derivatives of time [t_c] and velocity [y_c] of the next impact by the velocity just after each impact, (N, 2).

    They are the second columns of `flight_matrices` divided by -r, and are defined for r = 0 as well.
    """
    if groups.friction is not None:
        rebounds = [groups.restitution_at(wall) for wall in motion.word.walls]
        return np.asarray(flight_matrices(groups, motion)[:, :, 1] / -np.array(rebounds)[:, None])
    duration, ahead = motion.durations, np.roll(motion.velocity, -1)
    # Faster by k, the ball is farther by k times the duration when it would strike, so that it strikes earlier by that
    # distance over its velocity.
    late = -duration / ahead
    return np.stack([late, 1 + late * np.array([_pull(groups, t) for t in np.roll(motion.time, -1)])], axis=1)


def _pull(groups: Groups[float], time: float) -> float:
    """The relative acceleration at a time [t_c], without friction."""
    return float(groups.pull(groups.wave(pi * time, FLOATS).force))


def spread_by(matrices: Floats, sources: Floats) -> Floats:
    """Stationary covariance of time and velocity at each impact of a motion under independent kicks, (N, 2, 2).

    Parameters
    ----------
    matrices : ndarray (N, 2, 2)
        Of the flights, as `flight_matrices` has them; of a stable motion.
    sources : ndarray (N, 2, 2)
        Covariance that the kick just after each impact adds at the next one.
    """
    gathered = np.zeros((2, 2))
    for matrix, source in zip(matrices, sources, strict=True):
        gathered = matrix @ gathered @ matrix.T + source
    covariance = [stationary(chained(matrices), gathered)]
    for matrix, source in zip(matrices[:-1], sources[:-1], strict=True):
        covariance.append(matrix @ covariance[-1] @ matrix.T + source)
    return np.array(covariance)


def stationary(matrix: Floats, source: Floats) -> Floats:
    """The symmetric S with S = A S A' + Q, a discrete Lyapunov equation: three linear equations in its entries.

    Parameters
    ----------
    matrix : ndarray (2, 2)
        A, no two of whose eigenvalues have the product 1; S is positive where both are inside the unit circle.
    source : ndarray (2, 2)
        Q, symmetric.
    """
    (a, b), (c, d) = matrix.tolist()
    system = np.eye(3) - np.array([[a * a, 2 * a * b, b * b], [a * c, a * d + b * c, b * d], [c * c, 2 * c * d, d * d]])
    first, mixed, second = np.linalg.solve(system, [source[0, 0], source[0, 1], source[1, 1]]).tolist()
    return np.array([[first, mixed], [mixed, second]])
