"""The penalty equation over one period in one go, by the solvers an engineer would take off the shelf.

Nothing is split at the contacts: the solver meets the membranes as it goes. Each run starts and ends on the accurate
periodic motion of `compliant`, so that its error is known. A solver that gives up, overflows or passes a membrane
by is a result like any other.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import partial
from math import cos, hypot, inf, isfinite, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.physics import damping_number, flight
from vireport.trust.compliant import Compliant
from vireport.trust.compliant_orbits import CompliantOrbit
from vireport.trust.timing import timed_in_turns

ADAPTIVE = ("RK45", "DOP853", "Radau", "BDF", "LSODA", "Radau + J")
"""Adaptive solvers of scipy, the first two explicit; the last is given the Jacobian, which the others estimate by
differences where they need one."""

EXPLICIT = ("RK4", "RK45", "DOP853")
"""Solvers that are explicit throughout; LSODA switches between explicit and implicit formulae."""

RTOLS = (1e-4, 1e-7, 1e-10)
"""Relative tolerances of the adaptive solvers; the absolute one is the same, of quantities of order 1."""

FIXED = "RK4"
"""The classical fourth-order method with fixed steps."""

STEPS = (300, 3_000, 30_000)
"""Its steps per period: the coarsest takes a few per contact with a membrane as soft as the paper's."""

MOST_EVALUATIONS = 50_000
"""After which an adaptive run is broken off: five times what any of them needs where it works."""

WRONG = 1e-2
"""Error from which a run that reached the end has not followed the motion: the rigid model would be as good."""

Floats = NDArray[np.float64]

Right = Callable[[float, float, float], float]


class Outcome(Enum):
    """How a run ended."""

    SOLVED = "solved"
    WRONG = "reached the end of the period, but somewhere else"
    MISSED = "passed a membrane by without noticing it"
    STEP = "step size fell below rounding"
    OVERFLOW = "overflow"
    BUDGET = f"more than {MOST_EVALUATIONS} evaluations"


End = tuple[Outcome, float | None, int, int]
"""How a run ended, its error, its steps and its evaluations, as in `SolverRun`."""


@dataclass(frozen=True, slots=True)
class SolverRun:
    """One solver with one setting on one membrane.

    Attributes
    ----------
    solver : str
    setting : float
        Relative tolerance, or the number of steps of the fixed-step method.
    factor : float
        By which K is multiplied.
    outcome : Outcome
    error : float or None
        Distance of (Z, Z') from the motion at the end of the period, dimensionless; None where the end was not reached.
    steps, evaluations : int
        Taken until the end or the failure; rejected steps count as evaluations only.
    seconds : float
        Median run time.
    """

    solver: str
    setting: float
    factor: float
    outcome: Outcome
    error: float | None
    steps: int
    evaluations: int
    seconds: float

    @property
    def explicit(self) -> bool:
        """Whether the method is explicit throughout."""
        return self.solver in EXPLICIT


@dataclass(frozen=True, slots=True)
class Problem:
    """The equation over one period, from the middle of the flight down to the bottom membrane."""

    model: Compliant
    phase: float
    position: float
    velocity: float
    damping: tuple[float, float]


class _Exhausted(Exception):
    """The evaluations are used up."""


@dataclass(slots=True)
class _Tally:
    """What the right-hand side has seen."""

    evaluations: int = 0
    bottom: bool = False
    top: bool = False


def problem(model: Compliant, orbit: CompliantOrbit) -> Problem:
    """Start on a motion in mid-flight; lambda of either membrane is that of the motion's own touch."""
    top, half = orbit.top, orbit.flight_down / 2
    leaves = top.phase + pi * top.duration
    phase = leaves + pi * half
    z = -model.d / 2 + flight.displacement(half, top.leaving, sin(leaves), cos(leaves), cos(phase), model.gbar)
    v = flight.velocity(half, top.leaving, sin(leaves), sin(phase), model.gbar)
    damping = damping_number(model.restitution)
    return Problem(model, phase, float(z), float(v), (damping / orbit.bottom.velocity, -damping / orbit.top.velocity))


def acceleration(case: Problem, tally: _Tally) -> Right:
    """Z'' as a function of t, Z and Z'; infinite where the force overflows."""
    model, phase = case.model, case.phase
    half, gbar, k, h = model.d / 2, model.gbar, model.membrane.stiffness, model.membrane.exponent
    bottom, top = case.damping

    def right(t: float, z: float, v: float) -> float:
        tally.evaluations += 1
        a = gbar + cos(pi * t + phase)
        try:
            if z > half:
                tally.bottom = True
                a -= k * (z - half) ** h * max(1 + bottom * v, 0.0)
            elif z < -half:
                tally.top = True
                a += k * (-half - z) ** h * max(1 - top * v, 0.0)
        except OverflowError:
            return -inf if z > 0 else inf
        return a

    return right


def jacobian(case: Problem) -> Callable[[float, np.ndarray], Floats]:
    """Derivative of (Z', Z'') in (Z, Z'), as scipy's solvers take it."""
    model, (bottom, top) = case.model, case.damping
    half, k, h = model.d / 2, model.membrane.stiffness, model.membrane.exponent

    def matrix(_: float, state: np.ndarray) -> Floats:
        z, v = state.tolist()
        depth, factor, inward = (z - half, bottom, v) if z > 0 else (-half - z, top, -v)
        rate = np.array([[0.0, 1.0], [0.0, 0.0]])
        if depth > 0 and 1 + factor * inward > 0:
            rate[1] = -k * h * depth ** (h - 1) * (1 + factor * inward), -k * depth**h * factor
        return rate

    return matrix


def runs(case: Problem, factor: float, repeats: int) -> tuple[SolverRun, ...]:
    """SolverRun every solver with every setting, and time them in turns.

    Parameters
    ----------
    case : Problem
    factor : float
        By which K is multiplied in it.
    repeats : int
        Samples of each run's time; fewer of long ones.
    """
    settings = [(FIXED, float(steps)) for steps in STEPS] + [(name, rtol) for name in ADAPTIVE for rtol in RTOLS]
    ended: dict[tuple[str, float], End] = {}

    def call(name: str, setting: float) -> None:
        ended[name, setting] = once(case, name, setting)

    times = timed_in_turns([partial(call, *setting) for setting in settings], repeats)
    return tuple(_run(*s, factor, ended[s], spread.median) for s, spread in zip(settings, times, strict=True))


def _run(solver: str, setting: float, factor: float, end: End, seconds: float) -> SolverRun:
    outcome, error, steps, evaluations = end
    return SolverRun(solver, setting, factor, outcome, error, steps, evaluations, seconds)


def once(case: Problem, solver: str, setting: float) -> End:
    """SolverRun one solver over the period, and tell how it went."""
    return _fixed(case, int(setting)) if solver == FIXED else _adaptive(case, solver, setting)


def _adaptive(case: Problem, solver: str, rtol: float) -> End:
    from scipy.integrate import solve_ivp  # type: ignore[import-untyped]

    tally = _Tally()
    right = acceleration(case, tally)

    def system(t: float, state: np.ndarray) -> tuple[float, float]:
        if tally.evaluations >= MOST_EVALUATIONS:
            raise _Exhausted
        z, v = state.tolist()
        return v, right(t, z, v)

    start, (method, _, given) = [case.position, case.velocity], solver.partition(" + ")
    settings: dict[str, Any] = {"rtol": rtol, "atol": rtol} | ({"jac": jacobian(case)} if given else {})
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            made = solve_ivp(system, (0.0, case.model.period), start, method=method, **settings)
    except _Exhausted:
        return Outcome.BUDGET, None, 0, tally.evaluations
    except (ValueError, OverflowError, np.linalg.LinAlgError):  # infinities in a matrix
        return Outcome.OVERFLOW, None, 0, tally.evaluations
    steps = len(made.t) - 1
    if made.status != 0:
        finite = bool(np.isfinite(made.y).all())
        return (Outcome.STEP if finite else Outcome.OVERFLOW), None, steps, tally.evaluations
    z, v = made.y[:, -1].tolist()
    return *judged(case, z, v, tally), steps, tally.evaluations


def _fixed(case: Problem, steps: int) -> End:
    tally = _Tally()
    f = acceleration(case, tally)
    dt, z, v = case.model.period / steps, case.position, case.velocity
    for n in range(steps):
        t, middle = n * dt, (n + 0.5) * dt
        a1 = f(t, z, v)
        v2 = v + dt / 2 * a1
        a2 = f(middle, z + dt / 2 * v, v2)
        v3 = v + dt / 2 * a2
        a3 = f(middle, z + dt / 2 * v2, v3)
        v4 = v + dt * a3
        a4 = f(t + dt, z + dt * v3, v4)
        z += dt / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        if not (isfinite(z) and isfinite(v)):
            return Outcome.OVERFLOW, None, n + 1, tally.evaluations
    return *judged(case, z, v, tally), steps, tally.evaluations


def judged(case: Problem, z: float, v: float, tally: _Tally) -> tuple[Outcome, float | None]:
    """How a run that reached the end is to be called, and its error."""
    error = hypot(z - case.position, v - case.velocity)
    if not isfinite(error):
        return Outcome.OVERFLOW, None
    if not (tally.bottom and tally.top):
        return Outcome.MISSED, error
    return (Outcome.SOLVED if error < WRONG else Outcome.WRONG), error
