"""The return map between compliant membranes by SciPy's DOP853: the reference of `vireport.design.compliant`.

It shares the model, the units of a contact and the search for the end of a flight, and neither integrator nor Jacobian.
"""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

import numpy as np
from msgspec import Struct
from scipy.integrate import DOP853, solve_ivp

from vireport.base.errors import NumericalError
from vireport.design.compliant.model import CompliantModel, contact_units, free_flight
from vireport.physics.forcing import wave
from vireport.simulation.events import BOTTOM, TOP

TOLERANCE = 1e-12
LONGEST_STEP = 0.05
"""Longest step in contact durations: none can jump over a departure."""
LONGEST_CONTACT = 20.0
"""Longest contact, in durations of one without external force: a ball that stays longer is pressed on."""
DIFFERENCE = 2e-3
"""Step of fourth-order differences of the return map: truncation and rounding are both near 1e-10 there."""


class Touch(Struct, frozen=True):
    """A contact from its touch: until the ball leaves, Z' then, and the largest deflection."""

    duration: float
    leaving: float
    deflection: float


class Lap(Struct, frozen=True):
    """One period from a touch of the bottom to the next: its contacts, times, and Z' at the end."""

    bottom: Touch
    top: Touch
    time: float
    velocity: float


def contact(model: CompliantModel, wall: int, velocity: float, phase: float) -> Touch:
    """Integrate one contact from its touch to the departure."""
    units = contact_units(model, wall, velocity)
    time, depth, spring, damping, pull = units.time, units.depth, units.spring, units.damping, units.pull
    h, gbar = model.membrane.exponent, model.gbar

    def acceleration(t: float, y: float, v: float) -> float:
        # The force of a membrane cannot pull.
        push = spring * y**h * max(1 + damping * v, 0.0) if y > 0 else 0.0
        now = pi * time * t + phase
        return pull * (gbar + float(wave(sin(now), cos(now), model.harmonics).force)) - push

    def in_time(t: float, state: Any) -> tuple[float, float]:
        y, v = state
        return v, acceleration(t, y, v)

    def in_depth(y: float, state: Any) -> tuple[float, float]:
        t, v = state
        return 1 / v, acceleration(t, y, v) / v

    def in_velocity(v: float, state: Any) -> tuple[float, float]:
        t, y = state
        a = acceleration(t, y, v)
        return 1 / a, v / a

    settings: dict[str, Any] = {"rtol": TOLERANCE, "atol": TOLERANCE}
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
            return Touch(float(end[0]) * time, wall * float(end[1]) * depth / time, turned * depth)
    raise NumericalError("the ball stays on the membrane instead of bouncing")


def lap(model: CompliantModel, velocity: float, phase: float) -> Lap:
    """Apply the return map of the motions with one contact on each membrane to a touch of the bottom."""
    touches, elapsed = [], 0.0
    for wall in (BOTTOM, TOP):
        touch = contact(model, wall, velocity, phase + pi * elapsed)
        touches.append(touch)
        elapsed += touch.duration
        time, reached, velocity = free_flight(model, wall, touch.leaving, phase + pi * elapsed)
        elapsed += time
        if reached == wall:
            raise NumericalError("the ball falls back on the same membrane")
    return Lap(*touches, elapsed, velocity)


def mismatch(model: CompliantModel, x: Any) -> np.ndarray:
    """Amount by which a state (velocity, phase) at the bottom fails to repeat after the period."""
    end = lap(model, float(x[0]), float(x[1]))
    return np.array([end.velocity - x[0], pi * (end.time - model.period)])


def linearised(model: CompliantModel, x: Any) -> np.ndarray:
    """Jacobian of the return map in velocity and phase, by differences of fourth order."""
    columns = []
    for k in range(2):
        step = np.zeros(2)
        step[k] = DIFFERENCE * (x[0] if k == 0 else 1.0)
        near, far = (mismatch(model, x + s * step) - mismatch(model, x - s * step) for s in (1, 2))
        columns.append((8 * near - far) / (12 * step[k]))
    return np.stack(columns, axis=1) + np.eye(2)
