"""The ball between two compliant membranes: its return map to nearly full accuracy.

In the units of `model`, Z'' = gbar + cos(pi t + phi) - k delta^h (1 + lambda delta') at the bottom membrane, where
delta = Z - d/2 > 0, and the mirror image of the last term at the top one. The membranes move with the capsule, which
does not feel the ball; k = K x_c^h M/(m F). For each contact lambda is set from its impact velocity so that the contact
alone would have the restitution coefficient r (see `contact`).

Flights are in closed form. Contacts are integrated in units of their own duration and depth, in which they look the
same however stiff the membrane is: no stiffness is left to suffer from. What solvers make of the equation as it
stands is in `stiffness`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import acos, cos, inf, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.errors import NumericalError
from vireport.physics import Device, Membrane, contacts
from vireport.physics import flight as rigid_flight
from vireport.scenario import Parameter

Floats = NDArray[np.float64]

TOLERANCE = 1e-12
"""Relative tolerance of the contacts' integration, in units in which everything is of order 1."""

LONGEST_STEP = 0.05
"""In contact durations: no step can jump over a departure."""

LONGEST_CONTACT = 20.0
"""In durations of the contact without external force: a ball that stays longer is pressed on, and does not bounce."""

BOTTOM, TOP = 1, -1


@dataclass(frozen=True, slots=True)
class Compliant:
    """The dimensionless model.

    Attributes
    ----------
    d, gbar : float
        As in `Device.groups`.
    membrane : Membrane
        Its stiffness is k, so that with mass 1 `contact` works in dimensionless numbers; the rest is as it was.
    restitution : float
        r of a contact alone.
    period : float
        2n, the time after which the motion repeats [t_c].
    length_unit, velocity_unit, time_unit : float
        x_c [m], y_c [m/s], t_c [s].
    """

    d: float
    gbar: float
    membrane: Membrane
    restitution: float
    period: float
    length_unit: float
    velocity_unit: float
    time_unit: float


@dataclass(frozen=True, slots=True)
class Touch:
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


def compliant_model(
    device: Device, parameter: Parameter, value: float, membrane: Membrane, factor: float = 1.0
) -> Compliant:
    """The dimensionless model of a device with compliant membranes.

    Parameters
    ----------
    device : Device
    parameter, value : str, float
        One parameter, and the value it has.
    membrane : Membrane
    factor : float
        By which its stiffness K is multiplied.
    """
    at = device.at(parameter, float(value))
    d, gbar = device.groups(parameter, float(value))
    speed, time = float(device.velocity_unit(parameter, float(value))), 1 / (2 * at[Parameter.FREQUENCY])
    length, h = speed * time, membrane.exponent
    per_ball = length**h * device.capsule_mass_kg / (membrane.ball_mass_kg * at[Parameter.AMPLITUDE])
    scaled = replace(membrane, stiffness=factor * membrane.stiffness * per_ball, ball_mass_kg=1.0)
    return Compliant(float(d), float(gbar), scaled, device.restitution, 2.0 * device.period_ratio, length, speed, time)


def contact_phase(model: Compliant, wall: int, speed: float, phase: float, deepest: bool = False) -> tuple[float, ...]:
    """Integrate one contact from its touch to the departure.

    Parameters
    ----------
    model : Compliant
    wall : int
    speed : float
        |Z'| at the touch, positive [y_c].
    phase : float
        Forcing phase there [rad].
    deepest : bool
        Whether the largest deflection is wanted; it is 0 otherwise.

    Returns
    -------
    tuple of float
        Duration [t_c], speed away from the membrane at the departure [y_c], largest deflection [x_c].

    Raises
    ------
    NumericalError
        If the ball does not leave within `LONGEST_CONTACT` durations.
    """
    from scipy.integrate import DOP853, solve_ivp  # type: ignore[import-untyped]

    alone = contacts(np.array(speed), model.membrane, model.restitution)
    time, depth = float(alone.duration), float(alone.deflection)
    h, gbar = model.membrane.exponent, model.gbar
    spring = float(np.exp(np.log(model.membrane.stiffness) + (h - 1) * np.log(depth))) * time * time
    damping, pull = float(alone.damping) * depth / time, wall * time * time / depth

    def acceleration(t: float, y: float, v: float) -> float:
        push = spring * y**h * max(1 + damping * v, 0.0) if y > 0 else 0.0
        return pull * (gbar + cos(pi * time * t + phase)) - push

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
    solver = DOP853(in_time, 0.0, [0.0, speed * time / depth], most, max_step=LONGEST_STEP, **settings)
    turned = 0.0
    while solver.status == "running":
        t, (y, v) = solver.t, solver.y
        solver.step()
        if deepest and v > 0 >= solver.y[1]:
            # The end is where a function of the state vanishes: it is taken as the variable of the last step.
            turned = float(solve_ivp(in_velocity, (v, 0.0), [t, y], method="DOP853", **settings).y[1, -1])
        if solver.y[0] <= 0:
            end = solve_ivp(in_depth, (y, 0.0), [t, v], method="DOP853", **settings).y[:, -1]
            return float(end[0]) * time, -float(end[1]) * depth / time, turned * depth
    raise NumericalError("the ball stays on the membrane instead of bouncing: there is no motion of single impacts")


def flight(model: Compliant, wall: int, leaving: float, phase: float) -> tuple[float, int, float]:
    """Fly from a membrane to the first touch of either one, found for certain.

    Z is monotone between the zeros of Z', and Z' between those of Z'', which are known.

    Parameters
    ----------
    model : Compliant
    wall : int
        That is left.
    leaving : float
        Z' there, away from the wall [y_c].
    phase : float
        Forcing phase there [rad].

    Returns
    -------
    tuple of float, int, float
        Time of flight [t_c], the wall that is touched, and Z' there.

    Raises
    ------
    NumericalError
        If no membrane is touched within two periods of the motion.
    """
    from scipy.optimize import brentq  # type: ignore[import-untyped]

    start, sine, cosine, gbar = wall * model.d / 2, sin(phase), cos(phase), model.gbar

    def speed(t: float) -> float:
        return float(rigid_flight.velocity(t, leaving, sine, sin(pi * t + phase), gbar))

    def beyond(t: float, side: int) -> float:
        z = start + float(rigid_flight.displacement(t, leaving, sine, cosine, cos(pi * t + phase), gbar))
        return side * z - model.d / 2

    for a, b in pairwise(_monotone(speed, phase, gbar, 2 * model.period)):
        side = BOTTOM if speed((a + b) / 2) > 0 else TOP
        if beyond(b, side) > 0:
            # Already beyond at a: it left so slowly that it is pressed back at once.
            at_once = beyond(a, side) >= 0
            t = a if at_once else float(brentq(beyond, a, b, args=(side,), xtol=1e-15, rtol=1e-15, maxiter=200))
            return t, side, speed(t)
    raise NumericalError("no membrane is touched within two periods")


def _monotone(speed: Any, phase: float, gbar: float, end: float) -> Iterator[float]:
    """Ascending times from 0 between which the displacement is monotone."""
    from scipy.optimize import brentq

    bends = [0.0, end]
    if gbar < 1:
        angle = acos(-gbar)
        turns = range(int(end / 2) + 3)
        times = [((side * angle - phase) / pi) % 2 + 2 * k for side in (1, -1) for k in turns]
        bends = sorted({0.0, end, *(t for t in times if 0 < t < end)})
    yield 0.0
    for a, b in pairwise(bends):
        if speed(a) * speed(b) < 0:
            yield float(brentq(speed, a, b, xtol=1e-15, rtol=1e-15, maxiter=200))
        yield b


@dataclass(frozen=True, slots=True)
class Lap:
    """From one touch of the bottom to the next, by way of the top."""

    bottom: Touch
    top: Touch
    flight_down: float
    time: float
    velocity: float


def lap(model: Compliant, speed: float, phase: float, deepest: bool = False) -> Lap:
    """Apply the return map of the motions with one contact on each membrane.

    Parameters
    ----------
    model : Compliant
    speed, phase : float
        Velocity and forcing phase at a touch of the bottom [y_c], [rad].
    deepest : bool
        Whether the deflections are wanted.

    Raises
    ------
    NumericalError
        If the contacts come in another order.
    """
    if not 0 < speed < inf:
        raise NumericalError("the ball must strike the bottom membrane with a velocity towards it")
    touches, elapsed, v, down = [], 0.0, speed, 0.0
    for wall in (BOTTOM, TOP):
        at = phase + pi * elapsed
        duration, away, depth = contact_phase(model, wall, wall * v, at, deepest)
        touches.append(Touch(wall, v, at % (2 * pi), duration, -wall * away, depth))
        elapsed += duration
        down, reached, v = flight(model, wall, -wall * away, phase + pi * elapsed)
        elapsed += down
        if reached == wall:
            raise NumericalError("the ball falls back on the same membrane: not a motion with one impact on each")
    return Lap(touches[0], touches[1], down, elapsed, v)
