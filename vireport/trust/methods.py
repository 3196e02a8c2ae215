"""What the numerical alternatives to the closed form solve: fixed points of a return map, critical points on it.

State is (phase, velocity before the bottom impact); a lap is a flight to the top and one back. Only the flight
differs from method to method: one shooting procedure finds the motion as a fixed point of the lap, and one finds the
critical point, from differences of the lap. Nothing here knows the equations of the periodic motions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, pi

import numpy as np

from vireport.errors import NumericalError
from vireport.simulation import (
    BOTTOM,
    FLIGHT,
    PHASE,
    RIDING,
    SETTLING,
    TOP,
    VELOCITY,
    WALL,
    follow_one,
)
from vireport.trust.integrators import Budget, Case, Fly, LeftMotion, Tuned
from vireport.trust.quasinewton import quasi_newton

NARROWER = 4
"""Widths of differences that are tried."""

BLOCK, MOST_IMPACTS = 64, 20_000
"""Impacts simulated between two looks at the transient, and before it is given up."""


@dataclass(frozen=True, slots=True)
class Found:
    """A motion as a method found it: phase and velocity at the bottom impact, velocity at the top, share q."""

    phase: float
    velocity: float
    velocity_top: float
    q: float


Groups = Callable[[float], tuple[float, float]]
"""d and gbar at a value of the swept parameter."""


def shoot(method: Tuned, case: Case, guess: tuple[float, float], budget: Budget) -> Found:
    """The motion as a fixed point of the lap, from a guess of phase [rad] and velocity [y_c].

    Raises
    ------
    NumericalError
        If an impact is missed, the corrections do not settle, or the budget is spent.
    """
    difference = _clipped(method.noise**0.5, 1e-7, 1e-2)
    phase, velocity = quasi_newton(
        lambda x: _lap(method.fly, case, x[0], x[1], budget), list(guess), difference, method.stop, 100 * method.noise
    )
    up, top = method.fly(case, BOTTOM, velocity, phase, budget)
    return Found(phase % (2 * pi), velocity, top, up / (2 * case.n))


def shoot_critical(
    method: Tuned,
    groups: Groups,
    case: Case,
    kind: str,
    symmetric: bool,
    guess: tuple[float, float, float],
    budget: Budget,
) -> float:
    """Value of the swept parameter at a critical point: fixed point and 1 +- tr + det = 0 together.

    Parameters
    ----------
    method : Tuned
    groups : callable
    case : Case
        For r and n.
    kind : str
        ``period_doubling``, ``fold`` or ``pitchfork``.
    symmetric : bool
        Whether the motion is symmetric: then half a lap and the mirror image stand for a lap, and the pitchfork,
        where a lap has no simple fixed point, is where half a lap doubles its period.
    guess : tuple of three floats
        Phase, velocity and value.
    budget : Budget

    Notes
    -----
    Trace and determinant are from central differences of fourth order over the lap, so the error of a lap e leaves
    some e^(4/5). A method that integrates the variational equations as well would lose less. Where the differences
    reach states that do not belong to a 1:1 motion, they are taken a quarter as wide.
    """
    near = _clipped(0.3 * method.noise**0.2, 1e-4, 3e-2)
    for narrower in range(NARROWER):
        try:
            return _critical(method, groups, case, kind, symmetric, guess, near / 4**narrower, budget)
        except LeftMotion:
            if narrower + 1 == NARROWER:
                raise
    raise AssertionError


def _critical(
    method: Tuned,
    groups: Groups,
    case: Case,
    kind: str,
    symmetric: bool,
    guess: tuple[float, float, float],
    near: float,
    budget: Budget,
) -> float:
    """`shoot_critical` with differences over `near`."""
    unit = abs(guess[2]) or 1.0
    turn = _half_lap if symmetric else _lap
    sign = 1.0 if kind in ("period_doubling", "pitchfork") else -1.0
    rough = method.noise**0.8

    def residual(x: list[float]) -> list[float]:
        d, gbar = groups(x[2] * unit)
        at = Case(float(d), float(gbar), case.r, case.n)
        closed = turn(method.fly, at, x[0], x[1], budget)
        columns = []
        for k in (0, 1):
            slope = [0.0, 0.0]
            for steps, weight in ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12)):
                y = [x[0], x[1]]
                y[k] += steps * near
                slope = [
                    s + weight * f / near for s, f in zip(slope, turn(method.fly, at, y[0], y[1], budget), strict=True)
                ]
            columns.append(slope)
        (a, c), (b, d) = columns  # of the map less the identity
        trace, determinant = a + d + 2, (a + 1) * (d + 1) - b * c
        return [*closed, 1 + sign * trace + determinant]

    difference = _clipped(method.noise**0.4, 1e-5, 1e-2)
    start = [guess[0], guess[1], guess[2] / unit]
    return quasi_newton(residual, start, difference, method.stop, 100 * rough)[2] * unit


def settle(case: Case, guess: tuple[float, float], tolerance: float, budget: Budget) -> Found:
    """The motion that the simulation settles on: followed until a lap changes it by less than the tolerance.

    Raises
    ------
    NumericalError
        If it ends on something else, or not within `MOST_IMPACTS`.
    """
    phase, velocity = guess
    model = np.array([case.d, case.gbar, case.r])
    start: tuple[float, float, float, float] = (float(BOTTOM), 0.0, velocity, phase % (2 * pi))
    for _ in range(MOST_IMPACTS // BLOCK):
        rows, summary = follow_one(model, start, BLOCK)
        budget.spend(int(summary[1]))
        walls = rows[:, WALL]
        if len(rows) <= BLOCK or (rows[:, RIDING] + rows[:, SETTLING]).any():
            raise NumericalError("the ball came to stick to a membrane")
        bottom = rows[::2]
        if (bottom[:, WALL] != BOTTOM).any() or (walls[1::2] != TOP).any():
            raise NumericalError("the impacts do not alternate: it left the 1:1 motion")
        turned = (np.diff(bottom[:, PHASE]) + pi) % (2 * pi) - pi
        change = np.maximum(np.abs(turned), np.abs(np.diff(bottom[:, VELOCITY])))
        if (change <= tolerance).any():
            k = 2 * (int(np.argmax(change <= tolerance)) + 1)
            top, end = rows[k - 1], rows[k]
            q = float(top[FLIGHT]) / (2 * case.n)
            return Found(float(end[PHASE]), float(end[VELOCITY]), float(top[VELOCITY]), q)
        start = (float(BOTTOM), 0.0, float(rows[-1, VELOCITY]), float(rows[-1, PHASE]))
    raise NumericalError(f"the transient was not over after {MOST_IMPACTS:,} impacts")


def _lap(fly: Fly, case: Case, phase: float, velocity: float, budget: Budget) -> list[float]:
    """How far a lap is from closing, in phase [rad] and velocity [y_c]."""
    up, top = fly(case, BOTTOM, velocity, phase, budget)
    down, bottom = fly(case, TOP, top, phase + pi * up, budget)
    return _finite([pi * (up + down - 2 * case.n), bottom - velocity])


def _half_lap(fly: Fly, case: Case, phase: float, velocity: float, budget: Budget) -> list[float]:
    """How far the flight to the top is from the mirror image of its start."""
    up, top = fly(case, BOTTOM, velocity, phase, budget)
    return _finite([pi * (up - case.n), -top - velocity])


def _finite(values: list[float]) -> list[float]:
    if not all(map(isfinite, values)):
        raise NumericalError("the flight overflowed")
    return values


def _clipped(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
