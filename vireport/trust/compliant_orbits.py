"""Periodic motions and critical points of the ball between compliant membranes, on the return map of `compliant`.

Newton's iteration from a guess nearby, the rigid motion or one on stiffer membranes; multipliers by differences.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import count
from math import pi

import numpy as np
from numpy.typing import NDArray

from vireport.errors import NumericalError
from vireport.physics import Device, Membrane
from vireport.scenario import Parameter
from vireport.trust.compliant import Compliant, Touch, compliant_model, lap
from vireport.trust.quasinewton import quasi_newton

Floats = NDArray[np.float64]

NEARBY = 0.5
"""Relative change of an unknown beyond which another motion was found than the one asked for."""

CONVERGED, NOISE = 1e-11, 1e-9
"""Last correction of a motion or critical point, and the residual below which a standstill is the rounding of the
return map and of its differences."""

MOST_TRIES = 40
"""Evaluations after which the search is given up; about ten are usual."""

FORWARD = 1e-5
"""Step of the forward differences that the iteration begins with."""

DIFFERENCE = 2e-3
"""Step of fourth-order differences of the return map, in its scaled unknowns: truncation and rounding are both near
1e-10 there."""


@dataclass(frozen=True, slots=True)
class CompliantOrbit:
    """A periodic motion with one contact on each membrane.

    Attributes
    ----------
    bottom, top : Touch
    flight_down : float
        Time from leaving the top to touching the bottom [t_c].
    residual : float
        By which the state fails to repeat.
    trace, determinant : float
        Of the linearised return map from touch to touch of the bottom.
    """

    bottom: Touch
    top: Touch
    flight_down: float
    residual: float
    trace: float
    determinant: float

    @property
    def stable(self) -> bool:
        """Whether both multipliers are inside the unit circle."""
        return abs(self.trace) < 1 + self.determinant and self.determinant < 1

    @property
    def multipliers(self) -> tuple[complex, complex]:
        """Eigenvalues of the linearised return map, the larger first."""
        root = complex(self.trace**2 / 4 - self.determinant) ** 0.5
        one, two = self.trace / 2 + root, self.trace / 2 - root
        return (one, two) if abs(one) >= abs(two) else (two, one)


def mismatch(model: Compliant, x: Floats) -> Floats:
    """By how much a state (velocity, phase) at the bottom fails to repeat after the period: zero on a motion."""
    made = lap(model, float(x[0]), float(x[1]))
    return np.array([made.velocity - x[0], pi * (made.time - model.period)])


def linearised(model: Compliant, x: Floats) -> Floats:
    """Jacobian of the return map in velocity and phase, by differences of fourth order."""
    columns = []
    for k in range(2):
        step = np.zeros(2)
        step[k] = DIFFERENCE * (x[0] if k == 0 else 1.0)
        one, two = (mismatch(model, x + s * step) - mismatch(model, x - s * step) for s in (1, 2))
        columns.append((8 * one - two) / (12 * step[k]))
    return np.asarray(np.stack(columns, axis=1) + np.eye(2))


def find_orbit(model: Compliant, guess: Floats) -> CompliantOrbit:
    """Find the periodic motion near a guess as a fixed point of the return map.

    Parameters
    ----------
    model : Compliant
    guess : ndarray of shape (2,)
        Velocity and phase at the touch of the bottom, those of the rigid motion, say.

    Raises
    ------
    NumericalError
        If there is none near.
    """
    x = _solved(partial(mismatch, model), np.asarray(guess, dtype=float))
    made, matrix = lap(model, float(x[0]), float(x[1]), deepest=True), linearised(model, x)
    residual = float(np.abs(mismatch(model, x)).max())
    return CompliantOrbit(
        made.bottom, made.top, made.flight_down, residual, float(np.trace(matrix)), float(np.linalg.det(matrix))
    )


def _solved(function: Callable[[Floats], Floats], guess: Floats) -> Floats:
    """Where a small system vanishes, near a guess; NumericalError if there is no such place."""
    scale, tries = np.maximum(np.abs(guess), 0.1), count()

    def residual(u: list[float]) -> list[float]:
        if next(tries) >= MOST_TRIES:
            raise NumericalError("the iteration on the return map does not settle")
        return [float(value) for value in function(scale * np.array(u))]

    x = scale * np.array(quasi_newton(residual, (guess / scale).tolist(), FORWARD, CONVERGED, NOISE))
    if not np.all(np.abs(x - guess) < NEARBY * scale):
        raise NumericalError("the iteration on the return map leads to no motion nearby")
    return np.asarray(x)


def find_critical(
    device: Device,
    parameter: Parameter,
    membrane: Membrane,
    factor: float,
    guess: Floats,
    multiplier: float,
) -> Floats:
    """Find where a multiplier of the compliant motion is -1 (period doubling) or 1 (fold).

    1 + tr + det = 0 or 1 - tr + det = 0, with the condition of periodicity; det is not r^4 here.

    Parameters
    ----------
    device, parameter, membrane, factor
        As in `compliant_model`; `parameter` is the one that varies.
    guess : ndarray of shape (3,)
        Velocity, phase at the bottom and value of the parameter.
    multiplier : float
        -1 or 1.

    Returns
    -------
    ndarray of shape (3,)
        The same three at the critical point.

    Raises
    ------
    NumericalError
        If none is found near.
    """

    def conditions(x: Floats) -> Floats:
        model = compliant_model(device, parameter, float(x[2]), membrane, factor)
        shifted = linearised(model, x[:2]) - multiplier * np.eye(2)
        return np.append(mismatch(model, x[:2]), np.linalg.det(shifted))

    return _solved(conditions, np.asarray(guess, dtype=float))
