"""The methods that the accuracy study compares: how each finds a motion and a critical point from a guess.

Two work by formula: the closed form of the package, and the paper's own iteration. The others follow the ball: a motion
is a fixed point of the return map, a critical point one at which the trace of the linearised map has a given value, and
these methods differ in the flight only. Their Jacobians are the exact ones of the flights, (A.1) and (A.2).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import StrEnum
from functools import partial
from math import atan2, cos, isfinite, pi, sin, sqrt
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.point import design_point
from vireport.findings.accuracy.benchmark import BenchmarkProblem, SolvedMotion
from vireport.findings.accuracy.flights import (
    Budget,
    FlightMethod,
    FlightModel,
    explicit,
    integrated,
    runge_kutta,
    simulated,
)
from vireport.motions.diagram import solve
from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.orbits import Orbits, coefficients, orbits
from vireport.motions.stability import Jacobian, flight_jacobian, product_trace, return_trace
from vireport.motions.sweep import level_residual
from vireport.physics.groups import Groups, by_wall
from vireport.physics.numbers import wrapped
from vireport.simulation.events import BOTTOM, TOP, check_model, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, VELOCITY, WALL

CLOSED, WHOLE = "closed form", "whole sweep, no guess"
PRINTED, EXPLICIT = "Newton on (3.15)–(3.17)", "return map (2.11)–(2.12)"
SIMULATED_TRANSIENT, SIMULATED = "simulated transient", "simulated return map"
RK4 = "RK4, fixed steps"
SOLVERS = ("RK45", "DOP853", "Radau", "LSODA")
"""Adaptive solvers of SciPy, the first two explicit; LSODA switches between explicit and implicit formulae."""

STOPS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
"""Newton corrections at which a method without an error of its own stops; with the last only rounding is left."""

TRANSIENTS = tuple(10.0**-k for k in range(2, 14))
"""Changes in a lap below which the simulation counts as settled, the last of them rounding."""

STEPS = tuple(float(round(2 ** (k / 2))) for k in range(4, 26))
"""Steps of RK4 a forcing period, up to where rounding takes over."""

TOLERANCES = (*(x * 10.0**-k for k in range(3, 14) for x in (1.0, 0.3)),)
"""rtol = atol of solve_ivp, down to 3e-14: it takes none below 2.2e-14."""

BUDGETS = {"integrator": 60_000, "implicit": 50_000, "steps": 4_000_000, "formula": 1_000_000}
"""Evaluations that one solution may cost: a second or less of each, counted so that the end does not depend on the
machine. Those of an implicit method come with linear systems to be solved."""

COST_ORDERS = {"RK45": 5.0, "DOP853": 8.0, "Radau": 4.0}
"""Order in the step of what solve_ivp returns at an event: one more than that of the interpolant the impact is found
on (4, 7 and 3), at most that of the method. LSODA varies its order."""

FORMULA_NOISE = 1e-13
"""Residual of a formula at which a standstill of the iteration is rounding."""

GROUP_STEP = 1e-6
"""Relative step of the swept value in differences of d and gbar."""

TINY = 1e-30
"""Imaginary part that carries a derivative: its square vanishes against 1."""

BLOCK, MOST_IMPACTS = 64, 20_000
"""Impacts simulated between two looks at the transient, and before it is given up."""


class Knob(StrEnum):
    """What is set in the settings of a method."""

    NONE = ""
    STOP = "stop"
    CHANGE = "change"
    STEPS = "steps"
    RTOL = "rtol"

    @property
    def limits_accuracy(self) -> bool:
        """Whether the setting causes an error besides that of the last Newton correction."""
        return self not in (Knob.NONE, Knob.STOP)


class Method(Struct, frozen=True):
    """A method, and the settings it is tried with.

    Attributes
    ----------
    name : str
    knob : Knob
    settings : tuple of float
        From coarse to fine.
    motion : callable
        (target, setting, budget) -> `SolvedMotion`.
    critical : callable or None
        (target, setting, budget) -> value of the swept parameter; None where the method cannot find one.
    most : int
        Evaluations allowed.
    order : float or None
        Exponent of the error in the step or the tolerance, by theory.
    cost_order : float or None
        Exponent of the error in one over the evaluations, by theory.
    needs : str
        Package without which it cannot be tried, or "".
    """

    name: str
    knob: Knob
    settings: tuple[float, ...]
    motion: Callable[[BenchmarkProblem, float, Budget], SolvedMotion]
    critical: Callable[[BenchmarkProblem, float, Budget], float] | None
    most: int
    order: float | None = None
    cost_order: float | None = None
    needs: str = ""


def closed_motion(target: BenchmarkProblem, stop: float, budget: Budget) -> SolvedMotion:
    """The motion by the closed form: where the surface over (u, phase) has the d and gbar of the target.

    A symmetric motion is explicit: u = 0, and d alone is left to give the phase.
    """
    d, gbar, *_ = target.groups(target.guess.value)
    if target.symmetric:
        k = coefficients(0.0, target.r, target.n, math)
        return _motion(_surface(target, [_angle(k.d_sine, k.d_cosine, d, target.guess.phase)], budget))

    def residual(x: Floats) -> list[float]:
        at = _surface(target, x, budget)
        return [at.gbar - gbar, at.d - d]

    x = find_root(residual, [target.guess.q - 0.5, target.guess.phase], stop, FORMULA_NOISE)
    return _motion(_surface(target, x, budget))


def closed_critical(target: BenchmarkProblem, stop: float, budget: Budget) -> float:
    """Swept value at the critical point by the closed form: the sweep's level and the trace, solved together.

    On the symmetric motions u = 0 takes the place of the level, and the phase is the one unknown.
    """
    level, guess = target.sweep.level, target.guess

    def residual(x: Floats) -> list[float]:
        at = _surface(target, x, budget)
        excess = return_trace(at, target.r) - target.trace
        return [excess] if target.symmetric else [level_residual(level, at), excess]

    start = [guess.phase] if target.symmetric else [guess.q - 0.5, guess.phase]
    end = _surface(target, find_root(residual, start, stop, FORMULA_NOISE), budget)
    return float(target.sweep.value(float(target.sweep.coordinate(end))))


def _surface(target: BenchmarkProblem, x: Floats | list[float], budget: Budget) -> Orbits:
    """The motion over (u, phase), or over a phase alone where u = 0, in plain floats."""
    budget.spend(1)
    u, phase = (float(x[0]), float(x[1])) if len(x) == 2 else (0.0, float(x[0]))
    return orbits(u, phase, target.r, target.n, math)


def _angle(a: float, b: float, c: float, near: float) -> float:
    """The solution x of a sin x + b cos x = c that is nearer to an angle [rad]."""
    size = sqrt(a * a + b * b)
    if not size > 0:
        raise NumericalError("the closed form is degenerate: its level does not depend on the phase")
    middle, half = atan2(a, b), math.acos(max(-1.0, min(1.0, c / size)))
    return max((middle + half, middle - half), key=lambda angle: cos(angle - near))


def _motion(orbit: Orbits) -> SolvedMotion:
    return SolvedMotion(orbit.phi % (2 * pi), float(orbit.velocity_bottom), float(orbit.velocity_top), 0.5 + orbit.u)


def printed_motion(target: BenchmarkProblem, stop: float, budget: Budget) -> SolvedMotion:
    """The motion by Newton's method on (3.15)-(3.17), three equations in velocity, phase and q."""
    guess, (d, gbar, *_) = target.guess, target.groups(target.guess.value)

    def residual(x: Floats) -> list[float]:
        budget.spend(1)
        return _printed(x.tolist(), Groups(d, gbar, target.r), target.n)

    x = find_root(residual, [guess.velocity, guess.phase, guess.q], stop, FORMULA_NOISE)
    velocity, phase, q = x.tolist()
    return SolvedMotion(phase % (2 * pi), velocity, _velocity_top(velocity, gbar, target.r, target.n), q)


def printed_critical(target: BenchmarkProblem, stop: float, budget: Budget) -> float:
    """Swept value at the critical point, by Newton's method on (3.15)-(3.17) and the trace (4.2) together.

    On the symmetric motions, where (3.15) and (3.16) coincide, q = 1/2 takes the place of (3.16).
    """
    guess, r, n = target.guess, target.r, target.n
    r_bottom, r_top = by_wall(r)
    unit = abs(guess.value) or 1.0

    def residual(x: Floats) -> list[float]:
        budget.spend(1)
        velocity, phase, q, value = x.tolist()
        d, gbar, *_ = target.groups(value * unit)
        closed = _printed([velocity, phase, q], Groups(d, gbar, r), n)
        if target.symmetric:
            closed[1] = q - 0.5
        up, top = 2 * n * q, _velocity_top(velocity, gbar, r, n)
        at_bottom, at_top = gbar + cos(phase), gbar + cos(phase + pi * up)
        first = flight_jacobian(up, (velocity, top), (at_bottom, at_top), r_bottom)
        second = flight_jacobian(2 * n - up, (top, velocity), (at_top, at_bottom), r_top)
        return [*closed, product_trace([first, second]) - target.trace]

    x = find_root(residual, [guess.velocity, guess.phase, guess.q, guess.value / unit], stop, FORMULA_NOISE)
    return float(x[3]) * unit


def _velocity_top(v: float, gbar: float, r: Any, n: int) -> float:
    """Velocity at the top from that at the bottom [y_c], (3.8): by the momentum over a period."""
    bottom, top = by_wall(r)
    return float(2 * n * gbar / (1 + top) - (1 + bottom) / (1 + top) * v)


def _printed(motion: Sequence[float], groups: Groups[float], n: int) -> list[float]:
    """Residuals of (3.15), of (3.16) freed of its arcsine, and of (3.17), at t0 = 0, for a velocity, phase and q.

    They are as printed but for 1 + r of the top membrane, by which (3.8) has the velocity there.
    """
    (v, phase, q), (d, gbar), (r, top) = motion, groups[:2], by_wall(groups.restitution)
    period, share = 2 * n, (1 + r) / (1 + top)
    up, down, angle = period * q, period * (1 - q), 2 * pi * n * q
    s = sin(phase)
    return [
        (r - share) * v - (sin(angle + phase) - s) / pi + gbar * (period / (1 + top) - up),
        s - pi / 2 * gbar * (up - down) + pi / period * v * (r * up - down),
        (pi * (v * (r - share) - period * gbar * (q - 1 / (1 + top)))) ** 2
        + (pi * pi * (period * q * (1 - q) * (1 + r) * v + 2 * n * n * gbar * q * (q - 1) - d)) ** 2
        - 2
        + 2 * cos(angle),
    ]


FlightWith = Callable[[float], FlightMethod]
"""setting -> the flight with that setting."""


def shoot(flight_with: FlightWith, target: BenchmarkProblem, setting: float, budget: Budget) -> SolvedMotion:
    """The motion as a fixed point of the return map, by Newton's method with the exact Jacobian.

    Raises
    ------
    NumericalError
        If an impact is missed, the corrections do not settle, or the budget is spent.
    """
    method, model, guess = flight_with(setting), target.model(target.guess.value), target.guess
    period, gbar, (r_bottom, r_top) = 2 * model.n, model.groups.gbar, by_wall(target.r)

    def lap(x: Floats) -> tuple[list[float], list[list[float]]]:
        phase, velocity = x.tolist()
        up, top = method.fly(model, BOTTOM, velocity, phase, budget)
        down, end = method.fly(model, TOP, top, phase + pi * up, budget)
        residual = _finite([pi * (up + down - period), end - velocity])
        at = [gbar + cos(phase + pi * t) for t in (0.0, up, up + down)]
        a11, a12, a21, a22 = flight_jacobian(up, (velocity, top), (at[0], at[1]), r_bottom)
        b11, b12, b21, b22 = flight_jacobian(down, (top, end), (at[1], at[2]), r_top)
        return residual, [
            [b11 * a11 + b12 * a21 - 1, pi * (b11 * a12 + b12 * a22)],
            [(b21 * a11 + b22 * a21) / pi, b21 * a12 + b22 * a22 - 1],
        ]

    phase, velocity = find_root(lap, [guess.phase, guess.velocity], method.stop, method.noise, jacobian=True).tolist()
    up, top = method.fly(model, BOTTOM, velocity, phase, budget)
    return SolvedMotion(phase % (2 * pi), velocity, top, up / period)


def shoot_critical(flight_with: FlightWith, target: BenchmarkProblem, setting: float, budget: Budget) -> float:
    """Value of the swept parameter where a fixed point of the return map has the trace of a critical point.

    Newton's method in phase, velocity and value with the exact Jacobian, also of the trace. On symmetric motions half a
    lap and the mirror image stand for a lap: at a pitchfork, where a lap has no simple fixed point, half a lap doubles
    its period.
    """
    method, guess = flight_with(setting), target.guess
    unit = abs(guess.value) or 1.0
    conditions_of = _half_lap if target.symmetric else _lap

    def conditions(x: Floats) -> tuple[list[float], Floats]:
        phase, velocity, value = float(x[0]), float(x[1]), float(x[2]) * unit
        below, above = (np.array(target.groups(value + sign * GROUP_STEP * unit)[:2]) for sign in (-1, 1))
        rates = np.zeros((4, 3))  # of the state, in the three unknowns
        rates[0, 0] = rates[1, 1] = 1.0
        rates[2:, 2] = (above - below) / (2 * GROUP_STEP)
        state = np.array([[phase], [velocity], *([group] for group in target.groups(value)[:2])]) + 1j * TINY * rates
        values = conditions_of(method, target, state, budget)
        return _finite(values.real[:, 0].tolist()), values.imag / TINY

    start = [guess.phase, guess.velocity, guess.value / unit]
    return float(find_root(conditions, start, method.stop, method.noise, jacobian=True)[2]) * unit


Complexes = NDArray[np.complex128]
"""Numbers whose imaginary parts, `TINY` times over, are derivatives; a column for each unknown."""


def _lap(method: FlightMethod, target: BenchmarkProblem, state: Complexes, budget: Budget) -> Complexes:
    """By how much a period fails to close, in phase [rad] and velocity [y_c], and its trace misses the target's."""
    up, top, first = _carried(method, target, BOTTOM, state, budget)
    down, end, second = _carried(method, target, TOP, top, budget)
    return np.array([pi * (up + down - 2 * target.n), end[1] - state[1], product_trace([first, second]) - target.trace])


def _half_lap(method: FlightMethod, target: BenchmarkProblem, state: Complexes, budget: Budget) -> Complexes:
    """By how much the flight to the top misses the mirror image of the start, and its trace that of the target.

    Followed by the mirror it is a map H with the determinant r^2, whose square is the return map: at a pitchfork, where
    mirror images part, H has the multiplier -1, at a fold 1.
    """
    up, top, (a11, _, _, a22) = _carried(method, target, BOTTOM, state, budget)
    trace = TRACE_LEVELS[Event.PERIOD_DOUBLING if target.kind is Event.PITCHFORK else Event.FOLD](target.r)
    return np.array([pi * (up - target.n), -top[1] - state[1], a11 - a22 - trace])


def _carried(
    method: FlightMethod, target: BenchmarkProblem, wall: int, state: Complexes, budget: Budget
) -> tuple[Complexes, Complexes, Jacobian]:
    """A flight that carries derivatives along: its duration, the state before the next impact, and its Jacobian.

    The state is phase, velocity, d and gbar. Derivatives by d and gbar follow from (2.12), as Z moves by -wall d in the
    flight; (A.1) and (A.2) give the others.
    """
    phase, velocity, d, gbar = state
    groups = Groups(float(d.real[0]), float(gbar.real[0]), target.r)
    model, r = FlightModel(groups, target.n), groups.restitution_at(wall)
    start = float(velocity.real[0]), float(phase.real[0])
    time, end = method.fly(model, wall, *start, budget)
    pull_start, pull_end = (groups.gbar + cos(start[1] + pi * t) for t in (0.0, time))
    a11, a12, a21, a22 = flight_jacobian(time, (start[0], end), (pull_start, pull_end), r)
    by_groups = -(wall * d.imag + time * time / 2 * gbar.imag) / end
    later = a11 * phase.imag / pi + a12 * velocity.imag + by_groups
    faster = a21 * phase.imag / pi + a22 * velocity.imag + pull_end * by_groups + time * gbar.imag
    duration = time + 1j * (later - phase.imag / pi)
    after = np.array([phase + pi * duration, end + 1j * faster, d, gbar])
    pulls = gbar + np.cos(phase), gbar + np.cos(after[0])
    return duration, after, flight_jacobian(duration, (velocity, after[1]), pulls, r)


def _finite(values: list[float]) -> list[float]:
    if not all(map(isfinite, values)):
        raise NumericalError("the flight overflowed")
    return values


def settle(target: BenchmarkProblem, tolerance: float, budget: Budget) -> SolvedMotion:
    """The motion that the simulation settles on: followed until a period changes it by less than the tolerance.

    Newton's method, which makes attractors exact elsewhere, is not used, so that only the error of following counts.

    Raises
    ------
    NumericalError
        If the simulation settles on something else, or not within `MOST_IMPACTS`.
    """
    model = target.model(target.guess.value)
    parameters = check_model(model.groups)[0]
    start = float(BOTTOM), 0.0, target.guess.velocity, target.guess.phase % (2 * pi)
    for _ in range(MOST_IMPACTS // BLOCK):
        rows, summary = follow_one(parameters, start, BLOCK)
        budget.spend(int(summary[1]))
        if len(rows) <= BLOCK or (rows[:, RIDING] + rows[:, SETTLING]).any():
            raise NumericalError("the ball came to stick to a membrane")
        bottom, walls = rows[::2], rows[:, WALL]
        if (walls[::2] != BOTTOM).any() or (walls[1::2] != TOP).any():
            raise NumericalError("the impacts do not alternate: it left the 1:1 motion")
        moved = np.diff(bottom[:, [PHASE, VELOCITY]], axis=0)
        settled = np.maximum(np.abs(wrapped(moved[:, 0])), np.abs(moved[:, 1])) <= tolerance
        if settled.any():
            top, end = rows[2 * int(np.argmax(settled)) + 1 :][:2]
            q = float(top[FLIGHT]) / (2 * model.n)
            return SolvedMotion(float(end[PHASE]), float(end[VELOCITY]), float(top[VELOCITY]), q)
        start = float(BOTTOM), 0.0, float(rows[-1, VELOCITY]), float(rows[-1, PHASE])
    raise NumericalError(f"the transient was not over after {MOST_IMPACTS:,} impacts")


def whole_motion(target: BenchmarkProblem, _: float, budget: Budget) -> SolvedMotion:
    """The motion among all that the package finds in the sweep and at the design point, without a guess."""
    device = target.sweep.device.with_values({target.sweep.parameter: target.guess.value})
    motions = design_point(device, solve(target.sweep) if target.swept else None).motions
    k = int(np.argmax(np.where(motions.stable_mask, np.cos(motions.phi_bottom - target.guess.phase), -2.0)))
    numbers = (motions.phi_bottom[k], motions.velocity_bottom[k], motions.velocity_top[k], motions.q[k])
    return SolvedMotion(*map(float, numbers))


def whole_critical(target: BenchmarkProblem, _: float, budget: Budget) -> float:
    """The critical point among all that the package finds in the sweep, without a guess."""
    points = [point for point in solve(target.sweep).critical_points if point.event is target.kind]
    return min((p.sweep_value for p in points), key=lambda value: abs(value - target.guess.value))


def _shooting(
    name: str, knob: Knob, settings: tuple[float, ...], flight_with: FlightWith, budget: str, **more: Any
) -> Method:
    """A shooting method; shooting methods differ in the flight alone."""
    motion, critical = partial(shoot, flight_with), partial(shoot_critical, flight_with)
    return Method(name, knob, settings, motion, critical, BUDGETS[budget], **more)


FORMULA = BUDGETS["formula"]

METHODS = (
    Method(CLOSED, Knob.STOP, STOPS, closed_motion, closed_critical, FORMULA),
    Method(WHOLE, Knob.NONE, (0.0,), whole_motion, whole_critical, FORMULA),
    Method(PRINTED, Knob.STOP, STOPS, printed_motion, printed_critical, FORMULA),
    _shooting(EXPLICIT, Knob.STOP, STOPS, explicit, "formula"),
    _shooting(SIMULATED, Knob.STOP, STOPS, simulated, "formula", needs="numba"),
    Method(SIMULATED_TRANSIENT, Knob.CHANGE, TRANSIENTS, settle, None, FORMULA, order=1.0, needs="numba"),
    _shooting(RK4, Knob.STEPS, STEPS, runge_kutta, "steps", order=4.0),
    *(
        _shooting(
            f"SciPy {solver}",
            Knob.RTOL,
            TOLERANCES,
            partial(integrated, solver),
            "implicit" if solver == "Radau" else "integrator",
            order=1.0,
            cost_order=COST_ORDERS.get(solver),
        )
        for solver in SOLVERS
    ),
)
"""All methods, in the order of tables and legends."""

METHOD_NAMES = tuple(method.name for method in METHODS)


Floats = NDArray[np.float64]

ROUGHLY = 100.0
"""Residual, over the irregularity of the equations, at which a standstill of the iteration is that irregularity."""

MOST_EVALUATIONS = 100
"""Before a search is given up; five to fifteen are usual."""


def find_root(
    equations: Callable[[Floats], Any],
    guess: Sequence[float] | Floats,
    stop: float,
    noise: float,
    jacobian: bool = False,
) -> Floats:
    """Solve equations(x) = 0 near a guess.

    With a Jacobian, by Newton's steps kept within a trust region (Levenberg and Marquardt); without, by Powell's hybrid
    method with one Jacobian from forward differences and Broyden's updates.

    Parameters
    ----------
    equations : callable
        Array of unknowns, all of the order of one, to as many residuals; with `jacobian`, to residuals and Jacobian.
    guess : sequence of float
    stop : float
        Relative correction after which the next x is the solution.
    noise : float
        Irregular part of the residuals, below which no correction gets smaller.
    jacobian : bool
        Whether the equations give their Jacobian too.

    Raises
    ------
    NumericalError
        If the corrections do not settle where the equations hold.
    """
    from scipy.optimize import root  # type: ignore[import-untyped]

    if jacobian:
        # No test but that of the correction: the sum of squares may go on falling.
        options = {"xtol": stop, "ftol": 0.0, "maxiter": MOST_EVALUATIONS}
        result = root(equations, guess, jac=True, method="lm", options=options)
    else:
        result = root(equations, guess, method="hybr", options={"xtol": stop, "maxfev": MOST_EVALUATIONS})
    residual = float(np.max(np.abs(result.fun)))
    if not residual <= max(ROUGHLY * noise, stop if result.success else 0.0):
        raise NumericalError(f"Newton's method did not settle: residual {residual:.1g} after {result.nfev} evaluations")
    return np.asarray(result.x, dtype=float)
