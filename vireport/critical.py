"""Critical points to the last digit of a double: found along a branch, polished beyond double precision, and given an error bound."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext
from typing import Any

import numpy as np

from vireport import flight
from vireport.admissibility import turning_points
from vireport.errors import NumericalError
from vireport.model import Device, Sweep
from vireport.orbits import Level, Orbits, level_residual, orbits
from vireport.precise import DIGITS, DecimalOps
from vireport.stability import trace_and_determinant

POLISHED = 1e-28
"""Relative size of the last correction at which a polish is finished; a double needs 1e-17."""

MOST_STEPS = 60
"""Corrections before a polish is given up: three or four are usual, more at a nearly double zero."""

Condition = Callable[[Orbits, Any, Any, Any], list[Any]]
"""(orbit, further unknowns, r, ops) -> residuals beyond that of the level."""


@dataclass(frozen=True, slots=True)
class Point:
    """A motion singled out by a condition, polished.

    Attributes
    ----------
    u, phi : float
        q - 1/2 and phase at the bottom impact [rad], correctly rounded.
    d, gbar, velocity_bottom, velocity_top : float
        As in `Orbits`, correctly rounded.
    sweep_value : float
        In the unit of the parameter swept.
    error_bound : float
        Of `sweep_value`: the last correction, rounding, and the conversion to the swept unit.
    """

    u: float
    phi: float
    d: float
    gbar: float
    velocity_bottom: float
    velocity_top: float
    sweep_value: float
    error_bound: float


def trace_condition(target: Callable[[Any], Any]) -> Condition:
    """The trace of DP equals a function of r: a change of type, a fold, a pitchfork or a period doubling."""
    return lambda orbit, more, r, ops: [trace_and_determinant(orbit, r)[0] - target(r)]


CONDITIONS: dict[str, Condition] = {
    "period_doubling": trace_condition(lambda r: -(1 + r**4)),
    "focus_below": trace_condition(lambda r: -2 * r * r),
    "focus_above": trace_condition(lambda r: 2 * r * r),
    "fold": trace_condition(lambda r: 1 + r**4),
    "bottom_rest": lambda orbit, more, r, ops: [orbit.velocity_bottom],
    "top_rest": lambda orbit, more, r, ops: [orbit.velocity_top],
}
"""What singles out a critical point, by the names in `branches.EVENTS`."""


def grazing_condition(orbit: Orbits, r: float, n: int) -> tuple[Condition, float]:
    """The condition that the turning point nearest to a membrane touches it, and the time of that turning point in its flight."""
    best: tuple[float, bool, bool, float] | None = None
    for turn in turning_points(orbit, r, n):
        for at_start_wall, gap in ((True, turn.from_start_wall[0]), (False, turn.from_end_wall[0])):
            if best is None or abs(gap) < abs(best[0]):
                best = (float(gap), turn.upward, at_start_wall, float(turn.time[0]))
    if best is None:
        raise NumericalError("a grazing point has no turning point next to it")
    _, upward, at_start_wall, time = best

    def condition(orbit: Orbits, more: Any, r: Any, ops: Any) -> list[Any]:
        t = more[0]
        if upward:
            phase, before, sine, cosine, sign = orbit.phi, orbit.velocity_bottom, orbit.sin_phi, orbit.cos_phi, -1
        else:
            phase, before, sine, cosine, sign = None, orbit.velocity_top, orbit.sin_top, orbit.cos_top, 1
        sin_t, cos_t = ops.sin(ops.pi * t), ops.cos(ops.pi * t)
        later_sine, later_cosine = sine * cos_t + cosine * sin_t, cosine * cos_t - sine * sin_t
        after = flight.reflect(before, r)
        moved = sign * flight.displacement(t, after, sine, cosine, later_cosine, orbit.gbar, pi=ops.pi)
        return [
            flight.velocity(t, after, sine, later_sine, orbit.gbar, pi=ops.pi),
            moved if at_start_wall else moved - orbit.d,
        ]

    return condition, time


def value_condition(sweep: Sweep, value: float) -> Condition:
    """The swept parameter has a given value."""

    def condition(orbit: Orbits, more: Any, r: Any, ops: Any) -> list[Any]:
        exact = isinstance(r, Decimal)
        chosen = _decimal_sweep(sweep) if exact else sweep
        target = chosen.coordinate_of(Decimal(value) if exact else value)
        return [chosen.coordinate(orbit) - target]

    return condition


def polish(sweep: Sweep, u: float, phi: float, condition: Condition, more: tuple[float, ...] = (), symmetric: bool = False) -> Point:
    """Solve level and condition together from a guess good to a few digits, in long decimals with a Jacobian in doubles.

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
    n = sweep.device.period_ratio

    def residual(x: list[Any], r: Any, level: Level, ops: Any) -> list[Any]:
        if symmetric:
            return condition(orbits(0 * r, x[0], r, n, ops), x[1:], r, ops)
        orbit = orbits(x[0], x[1], r, n, ops)
        return [level_residual(level, orbit), *condition(orbit, x[2:], r, ops)]

    with localcontext() as context:
        context.prec = DIGITS
        exact = _decimal_sweep(sweep)
        level = exact.level
        floats, ops = sweep.level, DecimalOps()
        x = [Decimal(float(value)) for value in ((phi, *more) if symmetric else (u, phi, *more))]
        # u is stepped and measured relative to itself where its scale may be that of a tiny gbar.
        relative = 1 if not symmetric and floats.kind != "d" else 0
        size = np.inf
        for _ in range(MOST_STEPS):
            r = exact.device.restitution
            value = np.array([float(v) for v in residual(x, r, level, ops)])
            doubles = [float(v) for v in x]
            scale = np.array([abs(v) if i < relative else 1.0 for i, v in enumerate(doubles)])
            jacobian = _jacobian(lambda y: residual(y, sweep.device.restitution, floats, np), doubles, scale)
            step = np.linalg.solve(jacobian, value)
            x = [a - Decimal(float(b)) for a, b in zip(x, step, strict=True)]
            size = float(np.max(np.abs(step) / scale))
            if size < POLISHED:
                break
        else:
            raise NumericalError(f"a critical point near q = {0.5 + u:.6g}, phase {phi:.6g} did not settle (last correction {size:.1g})")
        u_phi = (Decimal(0), x[0]) if symmetric else (x[0], x[1])
        return _rounded(exact, sweep, orbits(*u_phi, exact.device.restitution, n, ops))


def _rounded(exact: Sweep, sweep: Sweep, orbit: Orbits) -> Point:
    value = _sweep_value(exact, sweep, orbit)
    rounded = float(value)
    # Rounding to a double is half a spacing; a whole one also covers what the polish has left.
    bound = max(abs(float(value - Decimal(rounded))), float(np.spacing(abs(rounded))))
    return Point(
        u=float(orbit.u),
        phi=float(orbit.phi % (2 * DecimalOps().pi)),
        d=float(orbit.d),
        gbar=float(orbit.gbar),
        velocity_bottom=float(orbit.velocity_bottom),
        velocity_top=float(orbit.velocity_top),
        sweep_value=rounded,
        error_bound=bound,
    )


def _sweep_value(exact: Sweep, sweep: Sweep, orbit: Orbits) -> Decimal:
    """The swept parameter in long decimals."""
    device = exact.device
    if sweep.parameter == "frequency_hz":
        return (orbit.d * device.amplitude_n / (4 * device.capsule_mass_kg * device.length_m)).sqrt()
    if sweep.parameter != "inclination_deg":
        return Decimal(exact.value(orbit.d, orbit.gbar))
    ops, degree = DecimalOps(), DecimalOps().pi / 180
    sine = orbit.gbar * device.amplitude_n / (device.capsule_mass_kg * device.gravity_m_s2)
    angle = Decimal(float(sweep.value(float(orbit.d), float(orbit.gbar))))
    for _ in range(6):
        cosine = ops.cos(angle * degree)
        if not cosine:
            break
        angle -= (ops.sin(angle * degree) - sine) / (cosine * degree)
    return angle


def _decimal_sweep(sweep: Sweep) -> Sweep:
    """The same sweep, its numbers exact."""
    device = sweep.device
    numbers = {
        name: None if (value := getattr(device, name)) is None else Decimal(value)
        for name in Device.__slots__
        if name != "period_ratio"
    }
    return Sweep(replace(device, **numbers), sweep.parameter, Decimal(sweep.start), Decimal(sweep.end))  # type: ignore[arg-type]


def _jacobian(function: Callable[[list[Any]], list[Any]], x: list[float], scale: Any) -> Any:
    """Central differences, each unknown stepped by its scale."""
    columns = []
    for i, value in enumerate(x):
        h = 1e-6 * scale[i]
        ahead, behind = list(x), list(x)
        ahead[i], behind[i] = value + h, value - h
        columns.append((np.array(function(ahead)) - np.array(function(behind))) / (2 * h))
    return np.stack(columns, axis=1)
