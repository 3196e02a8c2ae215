"""The ball between two compliant membranes: its return map to nearly full accuracy, and the motions on it.

Contacts are integrated in units of their own duration and depth, in which they look the same however stiff the membrane
is. What solvers make of the equation as it stands is in `stiff_solvers`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from math import cos, inf, pi, sin
from typing import Any

import numpy as np
from msgspec import Struct

from vireport.base import NumericalError
from vireport.checks import Floats, find_root
from vireport.compliant import CompliantModel, compliant_model, contact_units, free_flight
from vireport.physics import Device, Membrane, wave
from vireport.scenario import Parameter
from vireport.simulation import (
    BOTTOM,
    TOP,
)

TOLERANCE = 1e-12
"""Relative tolerance of the contacts' integration, in units in which everything is of order 1."""

LONGEST_STEP = 0.05
"""Longest step in contact durations: none can jump over a departure."""

LONGEST_CONTACT = 20.0
"""Longest contact, in durations of one without external force: a ball that stays longer is pressed on."""

NEARBY = 0.5
"""Relative change of an unknown beyond which another motion was found than the one asked for."""

CONVERGED, NOISE = 1e-11, 1e-11
"""Last correction of a motion or critical point, and the irregularity of the return map and of its differences."""

MOST_EVALUATIONS = 60
"""Most evaluations of the conditions before a search is given up; about ten are usual."""

FORWARD = 1e-5
"""Step of the forward differences that the iteration begins with."""

DIFFERENCE = 2e-3
"""Step of fourth-order differences of the return map, in its scaled unknowns: truncation and rounding are both near
1e-10 there."""


class LongContact(Struct, frozen=True):
    """One contact of a motion, dimensionless.

    Attributes
    ----------
    wall : int
        1 at the bottom, -1 at the top.
    velocity : float
        Z' at the touch: positive at the bottom, negative at the top.
    phase : float
        Forcing phase at the touch [rad], in [0, 2 pi).
    duration : float
        Until the ball leaves [t_c].
    leaving : float
        Z' when it leaves.
    deflection : float
        Largest [x_c].
    """

    wall: int
    velocity: float
    phase: float
    duration: float
    leaving: float
    deflection: float

    @property
    def restitution(self) -> float:
        """Speed after over speed before: r but for what gravity and the forcing do during the contact."""
        return -self.leaving / self.velocity


class Lap(Struct, frozen=True):
    """One period from a touch of the bottom to the next, by way of the top: its contacts, times and final velocity."""

    bottom: LongContact
    top: LongContact
    flight_down: float
    time: float
    velocity: float


class CompliantOrbit(Struct, frozen=True):
    """A periodic motion with one contact on each membrane.

    Attributes
    ----------
    bottom, top : LongContact
    flight_down : float
        Time from leaving the top to touching the bottom [t_c].
    residual : float
        By which the state fails to repeat.
    trace, determinant : float
        Of the linearised return map from touch to touch of the bottom.
    """

    bottom: LongContact
    top: LongContact
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
        pair = self.trace / 2 + root, self.trace / 2 - root
        return pair if abs(pair[0]) >= abs(pair[1]) else pair[::-1]

    @property
    def error_bound(self) -> float:
        """Relative error: tolerance and residual over the distance of a multiplier from 1, and room."""
        return 10 * (TOLERANCE + self.residual) / min(abs(1 - multiplier) for multiplier in self.multipliers)

    @property
    def longest_contact(self) -> float:
        """Duration of the longer contact [t_c]."""
        return max(self.bottom.duration, self.top.duration)


def contact(model: CompliantModel, wall: int, velocity: float, phase: float) -> LongContact:
    """Integrate one contact from its touch to the departure.

    Parameters
    ----------
    model : CompliantModel
    wall : int
    velocity : float
        Z' at the touch, towards the wall [y_c].
    phase : float
        Forcing phase there [rad].

    Raises
    ------
    NumericalError
        If the ball does not leave within `LONGEST_CONTACT` durations.
    """
    from scipy.integrate import DOP853, solve_ivp  # type: ignore[import-untyped]

    # So scaled the tolerances mean the same on each rung.
    units = contact_units(model, wall, velocity)
    time, depth, spring, damping, pull = units.time, units.depth, units.spring, units.damping, units.pull
    h, gbar = model.membrane.exponent, model.gbar

    def acceleration(t: float, y: float, v: float) -> float:
        # The force of a membrane cannot pull: without the cut-off the damping would hold the ball back as it leaves.
        push = spring * y**h * max(1 + damping * v, 0.0) if y > 0 else 0.0
        now = pi * time * t + phase
        force = float(wave(sin(now), cos(now), model.harmonics).force)
        return pull * (gbar + force) - push

    def in_time(t: float, state: Floats) -> tuple[float, float]:
        y, v = state
        return v, acceleration(t, y, v)

    def in_depth(y: float, state: Floats) -> tuple[float, float]:
        t, v = state
        return 1 / v, acceleration(t, y, v) / v

    def in_velocity(v: float, state: Floats) -> tuple[float, float]:
        t, y = state
        a = acceleration(t, y, v)
        return 1 / a, v / a

    settings: dict[str, Any] = {"rtol": TOLERANCE, "atol": TOLERANCE}
    # Nor can a contact last as long as the motion itself.
    most = min(LONGEST_CONTACT, model.period / time)
    solver = DOP853(in_time, 0.0, [0.0, units.speed], most, max_step=LONGEST_STEP, **settings)
    turned = 0.0
    while solver.status == "running":
        t, (y, v) = solver.t, solver.y
        solver.step()
        # Where a coordinate of the state vanishes, that coordinate is the variable of the last step.
        if v > 0 >= solver.y[1]:
            turned = float(solve_ivp(in_velocity, (v, 0.0), [t, y], method="DOP853", **settings).y[1, -1])
        if solver.y[0] <= 0:
            end = solve_ivp(in_depth, (y, 0.0), [t, v], method="DOP853", **settings).y[:, -1]
            away = wall * float(end[1]) * depth / time
            return LongContact(wall, velocity, phase % (2 * pi), float(end[0]) * time, away, turned * depth)
    raise NumericalError("the ball stays on the membrane instead of bouncing: there is no motion of single impacts")


def lap(model: CompliantModel, velocity: float, phase: float) -> Lap:
    """Apply the return map of the motions with one contact on each membrane to a touch of the bottom.

    Raises
    ------
    NumericalError
        If the contacts come in another order.
    """
    if not 0 < velocity < inf:
        raise NumericalError("the ball must strike the bottom membrane with a velocity towards it")
    touches, elapsed, time = [], 0.0, 0.0
    for wall in (BOTTOM, TOP):
        touch = contact(model, wall, velocity, phase + pi * elapsed)
        touches.append(touch)
        elapsed += touch.duration
        time, reached, velocity = free_flight(model, wall, touch.leaving, phase + pi * elapsed)
        elapsed += time
        if reached == wall:
            raise NumericalError("the ball falls back on the same membrane: not a motion with one impact on each")
    return Lap(touches[0], touches[1], time, elapsed, velocity)


def mismatch(model: CompliantModel, x: Floats) -> Floats:
    """Amount by which a state (velocity, phase) at the bottom fails to repeat after the period: zero on a motion."""
    end = lap(model, float(x[0]), float(x[1]))
    return np.array([end.velocity - x[0], pi * (end.time - model.period)])


def linearised(model: CompliantModel, x: Floats) -> Floats:
    """Jacobian of the return map in velocity and phase, by differences of fourth order."""
    columns = []
    for k in range(2):
        step = np.zeros(2)
        step[k] = DIFFERENCE * (x[0] if k == 0 else 1.0)
        near, far = (mismatch(model, x + s * step) - mismatch(model, x - s * step) for s in (1, 2))
        columns.append((8 * near - far) / (12 * step[k]))
    return np.asarray(np.stack(columns, axis=1) + np.eye(2))


def find_orbit(model: CompliantModel, guess: Sequence[float] | Floats) -> CompliantOrbit:
    """Find the periodic motion near a guess of velocity and phase at the bottom; NumericalError if there is none."""
    x = _solved(partial(mismatch, model), np.asarray(guess, dtype=float))
    closed, matrix = lap(model, float(x[0]), float(x[1])), linearised(model, x)
    residual = max(abs(closed.velocity - float(x[0])), abs(pi * (closed.time - model.period)))
    trace, determinant = float(np.trace(matrix)), float(np.linalg.det(matrix))
    return CompliantOrbit(closed.bottom, closed.top, closed.flight_down, residual, trace, determinant)


def find_critical(
    device: Device,
    parameter: Parameter,
    membrane: Membrane,
    factor: float,
    guess: Sequence[float] | Floats,
    multiplier: float,
) -> Floats:
    """Find where a multiplier of the compliant motion is -1 (period doubling) or 1 (fold).

    1 + tr + det = 0 or 1 - tr + det = 0, with the condition of periodicity; det is not r^4 here.

    Parameters
    ----------
    device, parameter, membrane, factor
        As in `compliant_model`; `parameter` is the one that varies.
    guess : sequence of three floats
        Velocity, phase at the bottom and value of the parameter, which are returned for the critical point.
    multiplier : float
        -1 or 1.

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


def _solved(conditions: Callable[[Floats], Floats], guess: Floats) -> Floats:
    """Where a small system vanishes, near a guess; NumericalError if there is no such place."""
    # Relative to the guess, but for a phase that happens to be near zero.
    scale = np.maximum(np.abs(guess), 0.1)
    x = scale * find_root(
        lambda x: conditions(scale * x), guess / scale, CONVERGED, NOISE, difference=FORWARD, most=MOST_EVALUATIONS
    )
    # A root far away is a motion of another family, which must not pass for the one that is followed.
    if not np.all(np.abs(x - guess) < NEARBY * scale):
        raise NumericalError("the iteration on the return map leads to no motion nearby")
    return np.asarray(x)
