"""The equation with compliant membranes over one period, by common solvers of SciPy and one with fixed steps.

Nothing is split at the contacts: a solver is not told where the membranes are. Each run of a ladder of solvers and
settings starts on the accurate motion and should end there, so that its error is known. A solver that gives up,
overflows or steps over a membrane is a result like any other.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from enum import StrEnum
from functools import partial
from math import cos, hypot, inf, isfinite, pi, sin

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.records import ResultsBlock
from vireport.base.timing import timed_in_turns
from vireport.design.compliant.descent import CompliantMotion
from vireport.design.compliant.model import CompliantModel
from vireport.physics import flight
from vireport.physics.contact import damping_number
from vireport.simulation.events import BOTTOM, TOP

FIXED = "RK4"
"""The classical fourth-order method with fixed steps."""

ADAPTIVE = "RK45", "DOP853", "Radau", "LSODA"
"""Those of SciPy: two explicit ones, an implicit one, and one that switches between both kinds of formulae."""

RTOLS = (1e-4, 1e-7, 1e-10)
"""Relative tolerances of the adaptive solvers; the absolute one is the same, of quantities of order 1."""

STEPS = (300, 3_000, 30_000)
"""Steps per period of RK4: the coarsest takes a few per contact with a membrane as soft as the paper's."""

LADDER = (*((FIXED, float(steps)) for steps in STEPS), *((name, rtol) for name in ADAPTIVE for rtol in RTOLS))
"""Solvers with their settings."""

MOST_EVALUATIONS = 50_000
"""After which an adaptive run is broken off: five times what any of them needs where it works."""

WRONG = 1e-2
"""Error from which a run that reached the end has not followed the motion: the rigid model would be as good."""

Force = Callable[[float, float, float], float]
"""The acceleration Z'' as a function of time [t_c], Z and Z'."""


class RunOutcome(StrEnum):
    """The ways in which the run of a solver ends."""

    SOLVED = "solved"
    WRONG = "reached the end of the period, but somewhere else"
    MISSED = "passed a membrane by without noticing it"
    STEP = "step size fell below rounding"
    OVERFLOW = "overflow"
    BUDGET = f"more than {MOST_EVALUATIONS} evaluations"


class SolverRun(ResultsBlock, frozen=True):
    """One solver with one setting on one membrane.

    Attributes
    ----------
    solver, setting
        its name, and the relative tolerance, or the number of steps of the fixed-step method
    factor : 1
        by which K is multiplied
    outcome
        `solved`, or in words what went wrong
    error : 1
        distance of (Z, Z') from the motion at the end of the period, dimensionless; null where the end was not reached
    steps, evaluations
        taken until the end or the failure; rejected steps count as evaluations only
    seconds : s
        median run time
    """

    solver: str
    setting: float
    factor: float
    outcome: RunOutcome
    error: float | None
    steps: int
    evaluations: int
    seconds: float


class Period(Struct, frozen=True):
    """The equation over one period of a motion, from the middle of the flight down to the bottom membrane.

    Attributes
    ----------
    model : CompliantModel
    phase, position, velocity : float
        State at the start, and by periodicity at the end: forcing phase [rad], position [x_c] and velocity [y_c].
    damping : tuple of float
        lambda of the bottom and of the top membrane, for the impact velocities of the motion.
    """

    model: CompliantModel
    phase: float
    position: float
    velocity: float
    damping: tuple[float, float]


class Calls(Struct):
    """Evaluations of the force by a solver so far, and whether either membrane was pressed in one of them."""

    evaluations: int = 0
    bottom: bool = False
    top: bool = False


class _ExhaustedError(Exception):
    """Raised in the force when the allowed evaluations are used up."""


def period_of(model: CompliantModel, orbit: CompliantMotion) -> Period:
    """The equation over one period of a motion, beginning in the middle of the flight down."""
    # In mid-flight nothing is stiff and the state is known in closed form: every solver starts exactly on the motion,
    # and all of the error at the end is due to the solver.
    left, half = orbit.top, orbit.flight_down / 2
    leaves = left.phase + pi * left.duration
    phase = leaves + pi * half
    z = -model.d / 2 + flight.displacement(half, left.leaving, sin(leaves), cos(leaves), cos(phase), model.gbar)
    v = flight.velocity(half, left.leaving, sin(leaves), sin(phase), model.gbar)
    # Damping depends on the impact velocity. That of the motion is kept: a run that has left it is wrong anyway.
    bottom, top = (damping_number(model.restitution_at(wall)) for wall in (BOTTOM, TOP))
    return Period(model, phase, float(z), float(v), (bottom / orbit.bottom.velocity, -top / orbit.top.velocity))


def acceleration(period: Period, calls: Calls) -> Force:
    """Z'' as a function of t, Z and Z'; infinite where the force overflows."""
    model, phase = period.model, period.phase
    half, gbar, k, h = model.d / 2, model.gbar, model.membrane.stiffness, model.membrane.exponent
    bottom, top = period.damping

    def force(t: float, z: float, v: float) -> float:
        calls.evaluations += 1
        a = gbar + cos(pi * t + phase)
        try:
            if z > half:
                # An adaptive solver may step over a whole contact without noticing: then it never evaluated a force
                # there.
                calls.bottom = True
                a -= k * (z - half) ** h * max(1 + bottom * v, 0.0)
            elif z < -half:
                calls.top = True
                a += k * (-half - z) ** h * max(1 - top * v, 0.0)
        except OverflowError:
            # A float raised to a power raises an error where NumPy gives inf; solvers expect the latter.
            return -inf if z > 0 else inf
        return a

    return force


def run_ladder(period: Period, factor: float, repeats: int) -> tuple[SolverRun, ...]:
    """Run every solver with every setting, and time them in turns.

    Parameters
    ----------
    period : Period
    factor : float
        By which K is multiplied.
    repeats : int
        Samples of each run's time; fewer for long runs.
    """
    runs: dict[tuple[str, float], SolverRun] = {}

    def call(solver: str, setting: float) -> None:
        runs[solver, setting] = run_once(period, factor, solver, setting)

    # In turns, so that a temporarily slow machine slows all of them down.
    times = timed_in_turns([partial(call, *rung) for rung in LADDER], repeats)
    return tuple(replace(runs[rung], seconds=spread.median) for rung, spread in zip(LADDER, times, strict=True))


def run_once(period: Period, factor: float, solver: str, setting: float) -> SolverRun:
    """Run one solver over the period, and judge how it went; without its time."""
    calls = Calls()
    force = acceleration(period, calls)
    if solver == FIXED:
        outcome, end, steps = _fixed(period, force, int(setting))
    else:
        outcome, end, steps = _adaptive(period, force, calls, solver, setting)
    error = None
    if outcome is RunOutcome.SOLVED:
        # The motion repeats itself: it ends where it began.
        distance = hypot(end[0] - period.position, end[1] - period.velocity)
        if not isfinite(distance):
            outcome = RunOutcome.OVERFLOW
        else:
            error = distance
            # A run that touched no membrane has solved another problem, however near its end is.
            touched = calls.bottom and calls.top
            outcome = RunOutcome.MISSED if not touched else RunOutcome.WRONG if distance >= WRONG else RunOutcome.SOLVED
    return SolverRun(solver, setting, factor, outcome, error, steps, calls.evaluations, 0.0)


RunEnd = tuple[RunOutcome, tuple[float, float], int]
"""`SOLVED` where the end was reached, the state there, and the steps taken."""

NOWHERE = (inf, inf)


def _adaptive(period: Period, force: Force, calls: Calls, solver: str, rtol: float) -> RunEnd:
    from scipy.integrate import solve_ivp  # type: ignore[import-untyped]

    def system(t: float, state: NDArray[np.float64]) -> tuple[float, float]:
        if calls.evaluations >= MOST_EVALUATIONS:
            # SciPy knows no limit of evaluations, and an explicit solver takes ever more of them as the membrane
            # stiffens.
            raise _ExhaustedError
        z, v = state.tolist()
        return v, force(t, z, v)

    start, span = [period.position, period.velocity], (0.0, period.model.period)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            # Warnings of solvers on overflow or too small steps are not shown: they become the outcome.
            warnings.simplefilter("ignore")
            # No events: a solver that is told where the membranes are would solve another problem.
            run = solve_ivp(system, span, start, method=solver, rtol=rtol, atol=rtol)
    except _ExhaustedError:
        return RunOutcome.BUDGET, NOWHERE, 0
    except (ValueError, OverflowError, np.linalg.LinAlgError):  # infinities in a matrix
        return RunOutcome.OVERFLOW, NOWHERE, 0
    steps = len(run.t) - 1
    if run.status != 0:
        return (RunOutcome.STEP if np.isfinite(run.y).all() else RunOutcome.OVERFLOW), NOWHERE, steps
    z, v = run.y[:, -1].tolist()
    return RunOutcome.SOLVED, (z, v), steps


def _fixed(period: Period, force: Force, steps: int) -> RunEnd:
    # By hand: SciPy has no method with fixed steps.
    dt, z, v = period.model.period / steps, period.position, period.velocity
    for n in range(steps):
        t, middle = n * dt, (n + 0.5) * dt
        a1 = force(t, z, v)
        v2 = v + dt / 2 * a1
        a2 = force(middle, z + dt / 2 * v, v2)
        v3 = v + dt / 2 * a2
        a3 = force(middle, z + dt / 2 * v2, v3)
        v4 = v + dt * a3
        a4 = force(t + dt, z + dt * v3, v4)
        z += dt / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        if not (isfinite(z) and isfinite(v)):
            return RunOutcome.OVERFLOW, NOWHERE, n + 1
    return RunOutcome.SOLVED, (z, v), steps
