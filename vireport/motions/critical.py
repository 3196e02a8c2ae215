"""Motions singled out by a condition, to the last digit of a double: critical points and their error bounds.

Solved in decimals beyond double precision together with the level of the sweep. Two of the conditions are those of
grazing, where a turning point of the ball comes to touch a membrane and a branch of motions ends.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cache, lru_cache
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.base import NumericalError
from vireport.motions.admissibility import touches
from vireport.motions.kinds import StrandEvent
from vireport.motions.orbits import Orbits, orbits
from vireport.motions.stability import focus_border, return_trace, stability_border
from vireport.motions.sweep import (
    Held,
    Level,
    Sweep,
    level_residual,
)
from vireport.physics import DIGITS, FLOATS, DecimalOps

DECIMALS = DecimalOps()
"""Numbers in which points are polished, always with `DIGITS` digits."""

POLISHED = 1e-28
"""Relative size of a correction that a polish need not make any more; a double needs 1e-17."""

STEP = 1e-6
"""Step of central differences in doubles: the cube root of their rounding, at which the difference is best."""

FINE_STEP = Decimal("1e-18")
"""Step of differences in decimals: far below any scale of a motion, far above their rounding."""

FARTHEST = 1e-3
"""Distance in q, phase or time at which a polish has left its point, for another or for none."""

QUICK_STEPS = 8
"""Corrections with a Jacobian in doubles, of which three or four are usual, before it is taken in decimals too."""

STEADY = 1e-9
"""Correction below which a Jacobian is not taken again: it would change by less than its differences are good for."""

MOST_STEPS = 60
"""Corrections before a polish is given up."""

SHORT = 1e-3
"""Time since the impact, below which a touch is a ball that comes back before it has left. It is found from its
expansion, for in doubles the distance covered is lost against the length of the capsule."""

Condition = Callable[[Orbits, Any, Any, Any], list[Any]]
"""(orbit, further unknowns, r, ops) -> residuals beyond that of the level."""

Equations = Callable[[list[Any]], list[Any]]
"""Unknowns -> residuals, as many of them."""


@dataclass(frozen=True, slots=True)
class PolishedMotion:
    """A motion singled out by a condition.

    Attributes
    ----------
    u, phi : float
        q - 1/2 and phase at the bottom impact [rad], correctly rounded.
    phi_top : float
        Phase at the top impact [rad], computed in doubles from these.
    d, gbar, velocity_bottom, velocity_top : float
        As in `Orbits`, correctly rounded.
    sweep_value : float
        In the unit of the parameter swept.
    error_bound : float
        Of `sweep_value`: the last correction, rounding, and the conversion to the swept unit.
    bounds : dict
        Error bounds of the others, by their names.
    """

    u: float
    phi: float
    phi_top: float
    d: float
    gbar: float
    velocity_bottom: float
    velocity_top: float
    sweep_value: float
    error_bound: float
    bounds: dict[str, float]


POLISHED_NUMBERS = ("u", "phi", "d", "gbar", "velocity_bottom", "velocity_top")
"""What is solved for of a motion."""


def trace_condition(target: Callable[[Any], Any]) -> Condition:
    """The trace of DP equals a function of r: a change of type, a fold, a pitchfork or a period doubling."""
    return lambda orbit, more, r, ops: [return_trace(orbit, r) - target(r)]


CONDITIONS: dict[StrandEvent, Condition] = {
    StrandEvent.DOUBLING: trace_condition(lambda r: -stability_border(r)),
    StrandEvent.FOCUS_BELOW: trace_condition(lambda r: -focus_border(r)),
    StrandEvent.FOCUS_ABOVE: trace_condition(focus_border),
    StrandEvent.MEETING: trace_condition(stability_border),
    StrandEvent.BOTTOM_REST: lambda orbit, more, r, ops: [orbit.velocity_bottom],
    StrandEvent.TOP_REST: lambda orbit, more, r, ops: [orbit.velocity_top],
}
"""What singles out a critical point; for grazing see `touch_condition`."""


def value_condition(sweep: Sweep, value: float) -> Condition:
    """The swept parameter has a given value."""
    target = cache(lambda ops: sweep.coordinate_of(value, ops))
    return lambda orbit, more, r, ops: [sweep.coordinate(orbit) - target(ops)]


def touch_condition(upward: bool, at_start: bool) -> Condition:
    """At rest, and on the wall left or on the one to arrive at, a time `more[0]` after the flight began."""

    def condition(orbit: Orbits, more: Any, r: Any, ops: Any) -> list[Any]:
        t, way = more[0], orbit.flights(r)[0 if upward else 1]
        sine, cosine = way.turned(ops.sin(ops.pi * t), ops.cos(ops.pi * t))
        covered = way.covered(t, cosine, ops)
        return [way.speed(t, sine, ops), covered / t if at_start else covered - orbit.d]

    return condition


def pressing_condition(upward: bool, acceleration: float) -> Condition:
    """The ball leaves the wall at the start of a flight with this acceleration towards that wall."""

    def condition(orbit: Orbits, more: Any, r: Any, ops: Any) -> list[Any]:
        way = orbit.flights(r)[0 if upward else 1]
        return [-way.pressing(way.cosine) - ops.exact(acceleration)]

    return condition


def orbit_at(sweep: Sweep, x: Sequence[Any], symmetric: bool, ops: Any) -> Orbits:
    """The motion of some unknowns: q - 1/2 and phase, or the phase alone of a symmetric motion; others may follow."""
    r, n = ops.exact(sweep.device.restitution), sweep.device.period_ratio
    return orbits(0 * r, x[0], r, n, ops) if symmetric else orbits(x[0], x[1], r, n, ops)


def equations(sweep: Sweep, condition: Condition, symmetric: bool, ops: Any) -> Equations:
    """What the unknowns of `orbit_at`, and those of the condition behind them, have to fulfil: level and condition.

    Among the symmetric motions of a horizontal capsule, u = 0 takes the place of the level.
    """
    r, level, own = ops.exact(sweep.device.restitution), _level(sweep, ops), 1 if symmetric else 2

    def residuals(x: list[Any]) -> list[Any]:
        orbit = orbit_at(sweep, x, symmetric, ops)
        held = [] if symmetric else [level_residual(level, orbit)]
        return [*held, *condition(orbit, x[own:], r, ops)]

    return residuals


@lru_cache(maxsize=4)
def _level(sweep: Sweep, ops: Any) -> Level:
    """The level of a sweep, on which many points are polished."""
    return sweep.level_in(ops)


def polish(
    sweep: Sweep, u: float, phi: float, condition: Condition, more: tuple[float, ...] = (), symmetric: bool = False
) -> PolishedMotion:
    """Solve level and condition together in long decimals, from a guess good to a few digits.

    Parameters
    ----------
    sweep : Sweep
    u, phi : float
        The guess.
    condition : Condition
    more : tuple of float
        Guesses of further unknowns of the condition.
    symmetric : bool
        Whether the point lies on the symmetric line of a horizontal capsule, where u = 0 takes the place of the level.

    Raises
    ------
    NumericalError
        If the corrections do not settle.
    """
    guess = (phi, *more) if symmetric else (u, phi, *more)
    with localcontext() as context:
        context.prec = DIGITS
        x = _solved(sweep, guess, condition, symmetric)
        device, orbit = sweep.device, orbit_at(sweep, x, symmetric, DECIMALS)
        value, horizontal = sweep.value(orbit.d, orbit.gbar, DECIMALS), _level(sweep, FLOATS).horizontal
        return rounded_motion(orbit, value, float(device.restitution), device.period_ratio, horizontal)


def place_at(sweep: Sweep, value: float, u: float, phi: float, symmetric: bool, reach: float) -> tuple[float, float]:
    """Place of the motion at a value of the swept parameter: q - 1/2 and phase, correctly rounded.

    Parameters are those of `polish`, and how far from the guess the motion may be. Raises as `polish`.
    """
    with localcontext() as context:
        context.prec = DIGITS
        guess = (phi,) if symmetric else (u, phi)
        x = _solved(sweep, guess, value_condition(sweep, value), symmetric, max(reach, FARTHEST))
        return (0.0 if symmetric else float(x[0])), float(x[-1] % (2 * DECIMALS.pi))


def _solved(
    sweep: Sweep, guess: Sequence[float], condition: Condition, symmetric: bool, reach: float = FARTHEST
) -> list[Decimal]:
    """Unknowns of `orbit_at` and those of the condition, solved for in decimals."""
    exact, double = (equations(sweep, condition, symmetric, numbers) for numbers in (DECIMALS, FLOATS))
    # u and the time since an impact are stepped and measured relative to themselves: their scale may be a tiny
    # gbar's or r's.
    relative = {len(guess) - 1} if len(guess) > (1 if symmetric else 2) else set()
    relative |= {0} if not symmetric and sweep.level.held is not Held.D else set()
    return newton(exact, double, [Decimal(float(value)) for value in guess], relative, reach)


def newton(
    exact: Equations, double: Equations, guess: list[Decimal], relative: set[int], reach: float = FARTHEST
) -> list[Decimal]:
    """Solve equations in decimals, with the Jacobian in doubles as long as that leads on.

    Unknowns are stepped, and corrections measured, relative to the size of those in `relative`.

    Raises
    ------
    NumericalError
        If the corrections do not settle, or lead farther than `reach` from the guess.
    """
    place = f"the motion near {', '.join(f'{float(value):.6g}' for value in guess)}"
    x, size = guess, 1.0
    for count in range(MOST_STEPS):
        value = exact(x)
        if size > STEADY:
            scale = [abs(v) if i in relative and v else Decimal(1) for i, v in enumerate(x)]
            if count < QUICK_STEPS:
                inverse = _inverse(_differences(double, [float(v) for v in x], [float(v) for v in scale], STEP))
            else:
                inverse = _inverse(_differences(exact, x, scale, FINE_STEP))
        correction = [Decimal(float(b)) for b in inverse @ np.array([float(v) for v in value])]
        x = [a - b * s for a, b, s in zip(x, correction, scale, strict=True)]
        before, size = size, max(abs(float(b)) for b in correction)
        # Both of one Jacobian, the next correction will be smaller than this by as much as this than the one before.
        if size < POLISHED or (before < STEADY and size * size < POLISHED * before):
            return x
        if max(abs(float(a - b)) for a, b in zip(x, guess, strict=True)) > reach:
            raise NumericalError(f"{place} was lost (correction {size:.1g})")
    raise NumericalError(f"{place} did not settle (last correction {size:.1g})")


def _differences(function: Equations, x: list[Any], scale: list[Any], step: Any) -> list[list[float]]:
    """Columns of the Jacobian by central differences, each unknown stepped by its scale and divided by it."""
    columns = []
    for i, size in enumerate(scale):
        ahead, behind = list(x), list(x)
        ahead[i], behind[i] = x[i] + step * size, x[i] - step * size
        columns.append([float((a - b) / (2 * step)) for a, b in zip(function(ahead), function(behind), strict=True)])
    return columns


def _inverse(columns: list[list[float]]) -> NDArray[np.float64]:
    """Inverse of a Jacobian, whose rows are first brought to one size."""
    matrix = np.array(columns).T
    size = np.max(np.abs(matrix), axis=1)
    if np.all(np.isfinite(matrix)) and size.all():
        try:
            with np.errstate(over="ignore"):  # a condition within the subnormal numbers
                inverse = np.asarray(np.linalg.inv(matrix / size[:, None]) / size)
        except np.linalg.LinAlgError as error:
            raise NumericalError("a critical point is degenerate: two of its conditions coincide") from error
        if np.all(np.isfinite(inverse)):
            return inverse
    raise NumericalError("a critical point is degenerate: its conditions do not depend on the motion")


def rounded_motion(orbit: Orbits, exact_value: Any, r: float, n: int, horizontal: bool) -> PolishedMotion:
    """Round a motion in decimals, and the value of what is varied, to doubles; gbar is zero where it is horizontal."""
    value = float(exact_value)
    numbers = {name: float(getattr(orbit, name)) for name in POLISHED_NUMBERS}
    numbers["phi"] = float(orbit.phi % (2 * DECIMALS.pi))
    if horizontal:
        numbers["gbar"] = 0.0
    # Rounding to a double is half a spacing; a whole one also covers what the polish has left.
    bounds = {name: float(np.spacing(abs(x))) for name, x in numbers.items()}
    error = max(abs(float(exact_value - Decimal(value))), float(np.spacing(abs(value))))
    return singled_out(r, n, numbers, bounds, value, error)


def singled_out(
    r: float, n: int, numbers: dict[str, float], bounds: dict[str, float], value: float, error: float
) -> PolishedMotion:
    """Complete the `POLISHED_NUMBERS` of a motion, with their bounds, by the phase at the top."""
    orbit = orbits(numbers["u"], numbers["phi"], r, n)
    phi_top = float(np.mod(np.arctan2(orbit.sin_top, orbit.cos_top), 2 * np.pi))
    rounding = (10 + 10 * n) * float(np.finfo(float).eps)
    top = {"phi_top": bounds["phi"] + 2 * np.pi * n * bounds["u"] + rounding}
    return PolishedMotion(**numbers, phi_top=phi_top, sweep_value=value, error_bound=error, bounds={**bounds, **top})


Polish = Callable[[float, float, Condition, tuple[float, ...]], Any]
"""(u, phi, condition, guesses of its further unknowns) -> the motion that was polished, with its `u` and `phi`."""


def polish_grazing(orbit: Orbits, r: float, n: int, polished: Polish) -> Any:
    """Polish a grazing point.

    Parameters
    ----------
    orbit : Orbits
        The motion as far as it is known (arrays of length one).
    r : float
        Restitution coefficient, as far as it is known.
    n : int
        Forcing periods per motion.
    polished : callable
        Solves the grazing point's condition together with those of the curve that it lies on.

    Raises
    ------
    NumericalError
        If it does not settle.
    """
    u, phi = float(orbit.u[0]), float(orbit.phi[0])
    nearest = next(iter(touches(orbit, r, n)), None)
    if nearest is not None and not (nearest.time < SHORT and nearest.at_start):
        condition = touch_condition(nearest.upward, nearest.at_start)
        return polished(u, phi, condition, (nearest.time,))
    # A ball that touches again shortly after the impact, where v t = a t^2/2 + j t^3/6 and v = a t + j t^2/2 give the
    # acceleration a = (-8 j v/3)^(1/2) towards the wall, and t = -3 a/(2 j).
    flights = orbit.flights(r)
    pressed = [float(abs(way.pressing(way.cosine)[0])) for way in flights]
    upward = nearest.upward if nearest is not None else pressed[0] < pressed[1]
    way = flights[0 if upward else 1]
    jerk = -float(way.jerk(way.sine)[0])
    acceleration = sqrt(max(-8 * jerk * abs(float(way.velocity[0])) / 3, 0.0))
    point = polished(u, phi, pressing_condition(upward, acceleration), ())
    if acceleration == 0:  # for r = 0 the ball starts at rest, and touches where the membrane begins to hold it
        return point
    condition = touch_condition(upward, at_start=True)
    return polished(point.u, point.phi, condition, (-1.5 * acceleration / jerk,))
