"""A flight from one membrane to the other, by each of the ways that the accuracy study compares.

Every one of them takes a state just before an impact and gives the time to the impact on the other membrane and the
velocity there. They share the impact law and the force; none knows anything of periodic motions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin
from typing import Any

import numpy as np

from vireport.errors import NumericalError
from vireport.physics import flight
from vireport.simulation import (
    BOTTOM,
    FLIGHT,
    RIDING,
    SETTLING,
    VELOCITY,
    WALL,
    follow_one,
)

ROUNDING = 1e-15
"""Error of a lap in closed form."""

SCAN = 1 / 8
"""Step in which a flight in closed form is searched for its end [t_c], a sixteenth of a forcing period."""

PERIODS = 3
"""Multiples of the motion's period after which a flight that met no membrane is given up."""

BISECTED = 1e-16
"""Length of the bracket, over the step, at which bisection of an impact ends: some fifty halvings."""

ROOT_STEPS = 60
"""Corrections of an impact time in closed form, of which four are usual."""

CLOSE_SCAN = 1 / 256
"""Step in which it is checked whether an impact was missed [t_c]."""


@dataclass(frozen=True, slots=True)
class Case:
    """What a lap depends on.

    Attributes
    ----------
    d, gbar, r : float
    n : int
        Forcing periods of the motion.
    """

    d: float
    gbar: float
    r: float
    n: int


@dataclass(slots=True)
class Budget:
    """Evaluations of the forces (or of a formula with a sine and a cosine) spent so far, and how many there are."""

    most: int
    spent: int = 0

    def spend(self, count: int) -> None:
        """Count evaluations; NumericalError where there are no more."""
        self.spent += count
        if self.spent > self.most:
            raise NumericalError(f"budget of {self.most:,} evaluations reached")


class LeftMotion(NumericalError):
    """The ball does return to the membrane it left, from the state that was tried: no method could go on from it."""


Fly = Callable[[Case, int, float, float, Budget], tuple[float, float]]
"""(case, membrane that is left, velocity before and phase at that impact, budget) -> flight time to the other
membrane and velocity before the impact there; NumericalError where the next impact seen is not on the other one,
`LeftMotion` where it truly is not."""


@dataclass(frozen=True, slots=True)
class Tuned:
    """A flight with one setting.

    Attributes
    ----------
    fly : Fly
    noise : float
        Size of what is irregular in a lap, from which the steps of differences follow.
    stop : float
        Newton correction after which the motion is taken as found.
    """

    fly: Fly
    noise: float
    stop: float


def simulated(stop: float) -> Tuned:
    """The flight of our event-driven simulation, which cannot miss an impact."""

    def fly(case: Case, wall: int, velocity: float, phase: float, budget: Budget) -> tuple[float, float]:
        model = np.array([case.d, case.gbar, case.r])
        rows, summary = follow_one(model, (float(wall), 0.0, velocity, phase % (2 * pi)), 1)
        budget.spend(int(summary[1]))
        if len(rows) < 2 or rows[0, RIDING] + rows[0, SETTLING] > 0 or rows[1, WALL] != -wall:
            raise _astray(case, wall, velocity, phase)
        return float(rows[1, FLIGHT]), float(rows[1, VELOCITY])

    return Tuned(fly, ROUNDING, stop)


def explicit(stop: float) -> Tuned:
    """The flight in closed form, Eqs. (2.11) and (2.12): a scan for the impact, then Newton within its bracket."""

    def fly(case: Case, wall: int, velocity: float, phase: float, budget: Budget) -> tuple[float, float]:
        after, s, c, g = flight.reflect(velocity, case.r), sin(phase), cos(phase), case.gbar
        t, count = 0.0, 0
        while True:
            t, count = t + SCAN, count + 1
            risen = -wall * flight.displacement(t, after, s, c, cos(pi * t + phase), g)
            if risen >= case.d:
                break
            if risen <= 0 or t > PERIODS * 2 * case.n:
                raise _astray(case, wall, velocity, phase)
        low, high = t - SCAN, t
        for _ in range(ROOT_STEPS):
            x, count = pi * t + phase, count + 1
            beyond = -wall * flight.displacement(t, after, s, c, cos(x), g) - case.d
            low, high = (t, high) if beyond < 0 else (low, t)
            correction = beyond / (-wall * flight.velocity(t, after, s, sin(x), g))
            nearer = t - correction
            if not low <= nearer <= high:
                nearer = 0.5 * (low + high)
            if abs(nearer - t) <= ROUNDING * 0.1 * t or high - low <= ROUNDING * t:
                break
            t = nearer
        budget.spend(count)
        return nearer, flight.velocity(nearer, after, s, sin(pi * nearer + phase), g)

    return Tuned(fly, ROUNDING, stop)


def runge_kutta(steps: float) -> Tuned:
    """The classical method of order four with so many equal steps a forcing period, the impact by bisection.

    A step that ends beyond a membrane is halved until the impact is found, as in most scripts; one that passes
    through a membrane and back again is not noticed.
    """
    h = 2.0 / steps

    def fly(case: Case, wall: int, velocity: float, phase: float, budget: Budget) -> tuple[float, float]:
        g = case.gbar

        def step(t: float, z: float, v: float, h: float) -> tuple[float, float]:
            kz1, kv1 = v, -wall * (g + cos(pi * t + phase))
            kz2, kv2 = v + h / 2 * kv1, -wall * (g + cos(pi * (t + h / 2) + phase))
            kz3, kv3 = v + h / 2 * kv2, -wall * (g + cos(pi * (t + h / 2) + phase))
            kz4, kv4 = v + h * kv3, -wall * (g + cos(pi * (t + h) + phase))
            return z + h / 6 * (kz1 + 2 * kz2 + 2 * kz3 + kz4), v + h / 6 * (kv1 + 2 * kv2 + 2 * kv3 + kv4)

        # Distance from the membrane that is left, and its rate: from 0 to d.
        z, v, count = 0.0, -wall * flight.reflect(velocity, case.r), 0
        most = int(PERIODS * case.n * steps) + 1
        for k in range(most):
            ahead, faster = step(k * h, z, v, h)
            if not 0 < ahead < case.d:
                count = k + 1
                break
            z, v = ahead, faster
        else:
            raise _astray(case, wall, velocity, phase)
        low, high = 0.0, h
        side = ahead >= case.d
        while high - low > BISECTED * h and low < 0.5 * (low + high) < high:
            middle = 0.5 * (low + high)
            ahead, _ = step(k * h, z, v, middle)
            count += 1
            inside = ahead < case.d if side else ahead > 0
            low, high = (middle, high) if inside else (low, middle)
        budget.spend(4 * (count + 1))
        if not side:
            raise _astray(case, wall, velocity, phase)
        return k * h + high, -wall * step(k * h, z, v, high)[1]

    return Tuned(fly, 10 * ROUNDING, max(1e-3 * h**4, 10 * ROUNDING))


def integrated(name: str) -> Callable[[float], Tuned]:
    """The flight by `scipy.integrate.solve_ivp` with a terminal event at each membrane; the setting is rtol = atol.

    Raises
    ------
    NumericalError
        If scipy is not installed.
    """
    try:
        from scipy.integrate import solve_ivp  # type: ignore[import-untyped]
    except ImportError as error:
        raise NumericalError("solve_ivp needs the package scipy: pip install 'vireport[accuracy]'") from error

    def tuned(tolerance: float) -> Tuned:
        def fly(case: Case, wall: int, velocity: float, phase: float, budget: Budget) -> tuple[float, float]:
            g, d = case.gbar, case.d

            def rate(t: float, y: Any) -> tuple[float, float]:
                return y[1], -wall * (g + cos(pi * t + phase))

            def reached(t: float, y: Any) -> float:
                return float(y[0] - d)

            def returned(t: float, y: Any) -> float:
                return float(y[0])

            for event, direction in ((reached, 1), (returned, -1)):
                event.terminal, event.direction = True, direction  # type: ignore[attr-defined]
            state = [0.0, -wall * flight.reflect(velocity, case.r)]
            run = solve_ivp(
                rate,
                (0.0, PERIODS * 2 * case.n),
                state,
                method=name,
                events=(reached, returned),
                rtol=tolerance,
                atol=tolerance,
            )
            budget.spend(int(run.nfev))
            if run.status < 0:
                raise NumericalError(f"solve_ivp: {run.message}")
            if not len(run.t_events[0]):
                raise _astray(case, wall, velocity, phase)
            return float(run.t_events[0][0]), -wall * float(run.y_events[0][0][1])

        return Tuned(fly, tolerance, max(0.1 * tolerance, 10 * ROUNDING))

    return tuned


def _astray(case: Case, wall: int, velocity: float, phase: float) -> NumericalError:
    """Whether the next impact, which a method did not see at the other membrane, is there nevertheless."""
    after, s, c, t = flight.reflect(velocity, case.r), sin(phase), cos(phase), 0.0
    here, there = ("bottom", "top") if wall == BOTTOM else ("top", "bottom")
    while t < PERIODS * 2 * case.n:
        t += CLOSE_SCAN
        risen = -wall * flight.displacement(t, after, s, c, cos(pi * t + phase), case.gbar)
        if risen >= case.d:
            return NumericalError(f"missed the impact at the {there}, and went on through the membrane")
        if risen <= 0:
            break
    return LeftMotion(f"left the 1:1 motion: the ball returns to the {here} from a state that was tried")
