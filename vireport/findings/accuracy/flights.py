"""A flight from one membrane to the other, by each of the methods that the accuracy study compares.

Each takes a state just before an impact and gives the time to the impact on the other membrane and the velocity just
before it. They share the impact law and the force; none uses that a motion is periodic.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, pi, sin
from typing import Any

import numpy as np
from msgspec import Struct

from vireport.base.errors import NumericalError
from vireport.physics import flight
from vireport.physics.groups import Groups
from vireport.simulation.events import BOTTOM, check_model, follow_one
from vireport.simulation.kernel import FLIGHT, RIDING, SETTLING, VELOCITY, WALL

ROUNDING = 1e-15
"""Error of a flight in closed form."""

NEWTON_STOP = 1e-8
"""Least correction at which Newton's method with the exact Jacobian stops: the next would be its square, rounding."""

STOP_SHARE = 0.1
"""Correction at which it stops, over the root of a method's own error: what is then left is a hundredth of that."""

SCAN = 1 / 8
"""Step in which a flight in closed form is searched for its end [t_c], a sixteenth of a forcing period."""

PERIODS = 3
"""Multiples of the motion's period after which a flight that met no membrane is given up."""

SETTLED = 1e-16
"""Relative correction of an impact time below which it is found: less than the spacing of doubles."""

MOST_CORRECTIONS = 60
"""Most corrections of an impact time, of which four are usual."""

CLOSE_SCAN = 1 / 256
"""Step in which it is checked whether an impact was missed [t_c]."""


class FlightModel(Struct, frozen=True):
    """What a flight depends on: the groups of a device, and n, the forcing periods of the motion."""

    groups: Groups[float]
    n: int


class Budget(Struct):
    """Evaluations of the force (or of a formula with a sine and a cosine) spent so far, and how many there are."""

    most: int
    spent: int = 0

    def spend(self, count: int) -> None:
        """Count evaluations; NumericalError where there are no more."""
        self.spent += count
        if self.spent > self.most:
            raise NumericalError(f"budget of {self.most:,} evaluations reached")


Fly = Callable[[FlightModel, int, float, float, Budget], tuple[float, float]]
"""(model, membrane that is left, velocity before and phase at that impact, budget) -> flight time to the other
membrane and velocity before the impact there; NumericalError where the next impact seen is not on the other one."""


class FlightMethod(Struct, frozen=True):
    """A way to follow a flight, with one setting.

    Attributes
    ----------
    fly : Fly
    noise : float
        Approximate error of a flight.
    stop : float
        Newton correction after which a motion is taken as found.
    """

    fly: Fly
    noise: float
    stop: float


def _with_error(fly: Fly, noise: float) -> FlightMethod:
    """A method with an error of its own, beyond which Newton's method need not go."""
    return FlightMethod(fly, noise, max(STOP_SHARE * noise**0.5, NEWTON_STOP))


def simulated(stop: float) -> FlightMethod:
    """The flight of the event-driven simulation, which cannot miss an impact."""

    def fly(model: FlightModel, wall: int, velocity: float, phase: float, budget: Budget) -> tuple[float, float]:
        parameters = check_model(model.groups)[0]
        rows, summary = follow_one(parameters, (float(wall), 0.0, velocity, phase % (2 * pi)), 1)
        budget.spend(int(summary[1]))
        if len(rows) < 2 or rows[0, RIDING] + rows[0, SETTLING] > 0 or rows[1, WALL] != -wall:
            raise _lost(model, wall, velocity, phase)
        return float(rows[1, FLIGHT]), float(rows[1, VELOCITY])

    return FlightMethod(fly, ROUNDING, stop)


def explicit(stop: float) -> FlightMethod:
    """The flight in closed form, Eqs. (2.11) and (2.12), searched for the impact step by step."""

    def fly(model: FlightModel, wall: int, velocity: float, phase: float, budget: Budget) -> tuple[float, float]:
        d, g, *_ = model.groups
        after, s, c = model.groups.after(wall, velocity), sin(phase), cos(phase)

        def state(t: float) -> tuple[float, float]:
            x = pi * t + phase
            rate = flight.velocity(t, after, s, sin(x), g)
            return -wall * flight.displacement(t, after, s, c, cos(x), g), -wall * rate

        t = 0.0
        while True:
            t += SCAN
            risen = -wall * flight.displacement(t, after, s, c, cos(pi * t + phase), g)
            if risen >= d:
                break
            if risen <= 0 or t > PERIODS * 2 * model.n:
                raise _lost(model, wall, velocity, phase)
        t_end, count = _impact(state, t - SCAN, t, d)
        budget.spend(round(t / SCAN) + count)
        return t_end, flight.velocity(t_end, after, s, sin(pi * t_end + phase), g)

    return FlightMethod(fly, ROUNDING, stop)


def runge_kutta(steps: float) -> FlightMethod:
    """The flight by the classical Runge-Kutta method of order four with some equal steps in a forcing period.

    The last step is shortened until it ends at the impact; one that passes through a membrane and back again is not
    noticed.
    """
    h = 2.0 / steps

    def fly(model: FlightModel, wall: int, velocity: float, phase: float, budget: Budget) -> tuple[float, float]:
        d, g, *_ = model.groups

        def step(t: float, z: float, v: float, h: float) -> tuple[float, float]:
            kz1, kv1 = v, -wall * (g + cos(pi * t + phase))
            kz2, kv2 = v + h / 2 * kv1, -wall * (g + cos(pi * (t + h / 2) + phase))
            kz3, kv3 = v + h / 2 * kv2, -wall * (g + cos(pi * (t + h / 2) + phase))
            kz4, kv4 = v + h * kv3, -wall * (g + cos(pi * (t + h) + phase))
            return z + h / 6 * (kz1 + 2 * kz2 + 2 * kz3 + kz4), v + h / 6 * (kv1 + 2 * kv2 + 2 * kv3 + kv4)

        # Distance from the membrane that is left, and its rate: from 0 to d.
        t, z, v = 0.0, 0.0, -wall * model.groups.after(wall, velocity)
        for k in range(int(PERIODS * model.n * steps) + 1):
            t = k * h
            end = step(t, z, v, h)
            if not 0 < end[0] < d:
                break
            z, v = end
        budget.spend(4 * (k + 1))
        if end[0] < d:
            raise _lost(model, wall, velocity, phase)
        t_end, count = _impact(lambda later: step(t, z, v, later - t), t, t + h, d)
        budget.spend(4 * count)
        return t_end, -wall * step(t, z, v, t_end - t)[1]

    return _with_error(fly, max(h**4, 10 * ROUNDING))


def _impact(state: Callable[[float], tuple[float, float]], low: float, high: float, d: float) -> tuple[float, int]:
    """Time [t_c] at which the distance reaches d, by Newton's method in a bracket, and the number of evaluations."""
    t, count = high, 0
    while True:
        (distance, rate), count = state(t), count + 1
        low, high = (t, high) if distance < d else (low, t)
        corrected = t - (distance - d) / rate
        if not low <= corrected <= high:
            corrected = 0.5 * (low + high)
        if abs(corrected - t) <= SETTLED * t or high - low <= ROUNDING * t or count == MOST_CORRECTIONS:
            return corrected, count
        t = corrected


def integrated(name: str, tolerance: float) -> FlightMethod:
    """The flight by a solver of `scipy.integrate.solve_ivp`, a terminal event at each membrane, rtol = atol.

    Radau is given the Jacobian of the force, which is constant.
    """
    options = {"jac": np.array([[0.0, 1.0], [0.0, 0.0]])} if name == "Radau" else {}

    def fly(model: FlightModel, wall: int, velocity: float, phase: float, budget: Budget) -> tuple[float, float]:
        from scipy.integrate import solve_ivp  # type: ignore[import-untyped]

        d, g, *_ = model.groups

        def rate(t: float, y: Any) -> tuple[float, float]:
            return y[1], -wall * (g + cos(pi * t + phase))

        def arrived(t: float, y: Any) -> float:
            return float(y[0] - d)

        def returned(t: float, y: Any) -> float:
            return float(y[0])

        for event, direction in ((arrived, 1), (returned, -1)):
            event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
        run = solve_ivp(
            rate,
            (0.0, PERIODS * 2 * model.n),
            [0.0, -wall * model.groups.after(wall, velocity)],
            method=name,
            events=(arrived, returned),
            rtol=tolerance,
            atol=tolerance,
            **options,
        )
        budget.spend(int(run.nfev))
        if run.status < 0:
            raise NumericalError(f"solve_ivp: {run.message}")
        if not len(run.t_events[0]):
            raise _lost(model, wall, velocity, phase)
        return float(run.t_events[0][0]), -wall * float(run.y_events[0][0][1])

    return _with_error(fly, tolerance)


def _lost(model: FlightModel, wall: int, velocity: float, phase: float) -> NumericalError:
    """The error of a method that saw no impact on the other membrane, which tells whether there is one nevertheless."""
    d, gbar, *_ = model.groups
    after, s, c, t = model.groups.after(wall, velocity), sin(phase), cos(phase), 0.0
    left, other = ("bottom", "top") if wall == BOTTOM else ("top", "bottom")
    while t < PERIODS * 2 * model.n:
        t += CLOSE_SCAN
        risen = -wall * flight.displacement(t, after, s, c, cos(pi * t + phase), gbar)
        if risen >= d:
            return NumericalError(f"missed the impact at the {other}, and went on through the membrane")
        if risen <= 0:
            break
    return NumericalError(f"left the 1:1 motion: the ball returns to the {left} from a state that was tried")
