"""Which methods the accuracy study compares, each with its ladder of settings and what theory says of its order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any

import numpy as np

from vireport.analysis import Solution, design_point, solve
from vireport.errors import NumericalError
from vireport.physics import Device
from vireport.scenario import Parameter
from vireport.trust.closedform import (
    Wanted,
    closed_critical,
    closed_orbit,
    printed_critical,
    printed_orbit,
)
from vireport.trust.integrators import Budget, Case, Tuned, explicit, integrated, runge_kutta, simulated
from vireport.trust.methods import Found, settle, shoot, shoot_critical

CLOSED, WHOLE = "closed form", "whole sweep, no guess"
PRINTED, EXPLICIT = "Newton on (3.15)–(3.17)", "return map (2.11)–(2.12)"
SETTLING, SIMULATED = "simulated transient", "simulated return map"
RK4 = "RK4 with bisection"
SOLVERS = ("RK45", "DOP853", "Radau", "LSODA")
NAMES = (CLOSED, WHOLE, PRINTED, EXPLICIT, SIMULATED, SETTLING, RK4, *(f"SciPy {name}" for name in SOLVERS))
"""Of all methods, in the order of tables and legends."""

STOPS = (1e-2, 1e-4, 1e-8, 1e-15)
"""Newton corrections at which a method without an error of its own stops; the last is rounding."""

TRANSIENTS = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13)
"""Changes in a lap below which the simulation counts as settled."""

STEPS = tuple(2.0**k for k in range(2, 13))
"""Steps of RK4 a forcing period."""

TOLERANCES = tuple(10.0**-k for k in range(3, 13))
"""rtol = atol of solve_ivp."""

BUDGETS = {"integrator": 60_000, "implicit": 25_000, "steps": 4_000_000, "formula": 1_000_000}
"""Evaluations that one solution may cost: a second or less of each, counted so that the end does not depend on the
machine. Those of an implicit method come with linear systems to be solved."""

COST_ORDERS = {"RK45": 5.0, "DOP853": 8.0, "Radau": 4.0}
"""Order in the step of what solve_ivp returns at an event: one more than that of the interpolant the impact is found
on (4, 7 and 3), at most that of the method. LSODA varies its order."""


@dataclass(frozen=True, slots=True)
class Contender:
    """A method and the settings it is tried with.

    Attributes
    ----------
    name : str
        One of `NAMES`.
    knob : str
        What the settings are: ``stop``, ``change``, ``steps``, ``rtol`` or ``""`` where there is none.
    settings : tuple of float
        From coarse to fine.
    orbit, critical : callable or None
        (setting, budget) -> `Found`, or the value of the swept parameter; None where the method has no such task.
    most : int
        Evaluations allowed.
    order : float or None
        Exponent of the error in the step or the tolerance, by theory.
    cost_order : float or None
        Exponent of the error in one over the evaluations, by theory.
    """

    name: str
    knob: str
    settings: tuple[float, ...]
    orbit: Callable[[float, Budget], Found] | None
    critical: Callable[[float, Budget], float] | None
    most: int
    order: float | None = None
    cost_order: float | None = None


def contenders(
    solution: Solution, orbit: Wanted, critical: Wanted | None, label: str
) -> tuple[tuple[Contender, ...], tuple[tuple[str, str], ...]]:
    """The methods that can be tried here, and those that cannot with the reason.

    Parameters
    ----------
    solution : Solution
    orbit : Wanted
        The motion, with the guess that all begin from.
    critical : Wanted or None
    label : str
        Of the critical point.
    """
    found, absent = [_formula(CLOSED, closed_orbit, closed_critical, orbit, critical)], []
    found.append(_whole(solution, orbit, critical, label))
    found.append(_formula(PRINTED, printed_orbit, printed_critical, orbit, critical))
    found.append(_shooting(EXPLICIT, "stop", STOPS, explicit, "formula", orbit, critical))
    if find_spec("numba") is None:
        reason = "needs the package numba: pip install 'vireport[simulation]'"
        absent += [(SIMULATED, reason), (SETTLING, reason)]
    else:
        found.append(_shooting(SIMULATED, "stop", STOPS, simulated, "formula", orbit, critical))
        found.append(_settling(orbit))
    found.append(replace(_shooting(RK4, "steps", STEPS, runge_kutta, "steps", orbit, critical), order=4.0))
    for name in SOLVERS:
        try:
            tuned = integrated(name)
        except NumericalError as error:
            absent.append((f"SciPy {name}", str(error)))
            continue
        budget = "implicit" if name == "Radau" else "integrator"
        one = _shooting(f"SciPy {name}", "rtol", TOLERANCES, tuned, budget, orbit, critical)
        found.append(replace(one, order=1.0, cost_order=COST_ORDERS.get(name)))
    return tuple(found), tuple(absent)


def device_at(device: Device, parameter: Parameter, value: float) -> Device:
    """The device with one parameter at a value."""
    changed: dict[str, Any] = {parameter: value}
    return replace(device, **changed)


def _formula(name: str, orbit: Any, critical: Any, wanted: Wanted, point: Wanted | None) -> Contender:
    return Contender(
        name,
        "stop",
        STOPS,
        lambda stop, budget: orbit(wanted, stop, budget),
        None if point is None else lambda stop, budget: critical(point, stop, budget),
        BUDGETS["formula"],
    )


def _shooting(
    name: str,
    knob: str,
    settings: tuple[float, ...],
    tuned: Callable[[float], Tuned],
    budget: str,
    wanted: Wanted,
    point: Wanted | None,
) -> Contender:
    """A method that differs from the others of its kind in the flight alone."""

    def orbit(setting: float, spent: Budget) -> Found:
        return shoot(tuned(setting), _case(wanted), (wanted.guess.phase, wanted.guess.velocity), spent)

    def critical(setting: float, spent: Budget) -> float:
        assert point is not None
        guess = (point.guess.phase, point.guess.velocity, point.guess.value)
        at = _case(point)
        return shoot_critical(tuned(setting), point.groups, at, point.kind, point.symmetric, guess, spent)

    return Contender(name, knob, settings, orbit, critical if point is not None else None, BUDGETS[budget])


def _settling(wanted: Wanted) -> Contender:
    def orbit(tolerance: float, spent: Budget) -> Found:
        return settle(_case(wanted), (wanted.guess.phase, wanted.guess.velocity), tolerance, spent)

    return Contender(SETTLING, "change", TRANSIENTS, orbit, None, BUDGETS["formula"], order=1.0)


def _whole(solution: Solution, wanted: Wanted, point: Wanted | None, label: str) -> Contender:
    """Everything the package finds in the sweep, or at the design point, without a guess."""
    device = device_at(wanted.sweep.device, wanted.sweep.parameter, wanted.guess.value)
    sweep = solution.sweep

    def orbit(_: float, spent: Budget) -> Found:
        m = design_point(device, solve(sweep) if sweep is not None else None).motions
        k = int(np.argmax(np.where(m.stable, np.cos(m.phi_bottom - wanted.guess.phase), -2.0)))
        return Found(float(m.phi_bottom[k]), float(m.velocity_bottom[k]), float(m.velocity_top[k]), float(m.q[k]))

    def critical(_: float, spent: Budget) -> float:
        assert sweep is not None
        return next(c.point.sweep_value for c in solve(sweep).critical_points if c.label == label)

    return Contender(WHOLE, "", (0.0,), orbit, critical if point is not None else None, 1)


def _case(wanted: Wanted) -> Case:
    d, gbar = wanted.groups(wanted.guess.value)
    return Case(d, gbar, wanted.r, wanted.n)
