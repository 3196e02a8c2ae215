"""Critical points to the last digit of a double: polished beyond double precision, and given an error bound."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext
from functools import cache
from typing import Any

import numpy as np

from vireport.analysis.kinds import StrandEvent
from vireport.analysis.orbits import Level, Orbits, level_residual, orbits
from vireport.analysis.stability import trace_and_determinant
from vireport.analysis.sweep import Sweep
from vireport.errors import NumericalError
from vireport.physics import (
    DIGITS,
    DecimalOps,
    Device,
)

POLISHED = 1e-28
"""Relative size of the last correction at which a polish is finished; a double needs 1e-17."""

FINE_STEP = Decimal("1e-18")
"""Step of differences in decimals: far below any scale of a motion, far above their rounding."""

FARTHEST = 1e-3
"""Distance in q, phase or time at which a polish has left its point, for another or for none."""

QUICK_STEPS = 8
"""Corrections with a Jacobian in doubles, of which three or four are usual, before it is taken in decimals too."""

MOST_STEPS = 60
"""Corrections before a polish is given up."""

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
    bounds : dict
        Error bounds of the others, by their names, and of the phase at the top, `phi_top`.
    """

    u: float
    phi: float
    d: float
    gbar: float
    velocity_bottom: float
    velocity_top: float
    sweep_value: float
    error_bound: float
    bounds: dict[str, float]


def trace_condition(target: Callable[[Any], Any]) -> Condition:
    """The trace of DP equals a function of r: a change of type, a fold, a pitchfork or a period doubling."""
    return lambda orbit, more, r, ops: [trace_and_determinant(orbit, r)[0] - target(r)]


CONDITIONS: dict[StrandEvent, Condition] = {
    StrandEvent.DOUBLING: trace_condition(lambda r: -(1 + r**4)),
    StrandEvent.FOCUS_BELOW: trace_condition(lambda r: -2 * r * r),
    StrandEvent.FOCUS_ABOVE: trace_condition(lambda r: 2 * r * r),
    StrandEvent.MEETING: trace_condition(lambda r: 1 + r**4),
    StrandEvent.BOTTOM_REST: lambda orbit, more, r, ops: [orbit.velocity_bottom],
    StrandEvent.TOP_REST: lambda orbit, more, r, ops: [orbit.velocity_top],
}
"""What singles out a critical point; that of grazing is in `grazing`."""


def value_condition(sweep: Sweep, value: float) -> Condition:
    """The swept parameter has a given value."""

    @cache
    def target(exact: bool) -> Any:
        return _decimal_sweep(sweep).coordinate_of(Decimal(value)) if exact else sweep.coordinate_of(value)

    def condition(orbit: Orbits, more: Any, r: Any, ops: Any) -> list[Any]:
        return [sweep.coordinate(orbit) - target(isinstance(r, Decimal))]

    return condition


def polish(
    sweep: Sweep, u: float, phi: float, condition: Condition, more: tuple[float, ...] = (), symmetric: bool = False
) -> Point:
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
    n = sweep.device.period_ratio

    def residual(x: list[Any], r: Any, level: Level, ops: Any) -> list[Any]:
        if symmetric:
            return condition(orbits(0 * r, x[0], r, n, ops), x[1:], r, ops)
        orbit = orbits(x[0], x[1], r, n, ops)
        return [level_residual(level, orbit), *condition(orbit, x[2:], r, ops)]

    with localcontext() as context:
        context.prec = DIGITS
        exact = _decimal_sweep(sweep)
        level, floats, ops = exact.level, sweep.level, DecimalOps()
        x = [Decimal(float(value)) for value in ((phi, *more) if symmetric else (u, phi, *more))]
        # u and the time since an impact are stepped and measured relative to themselves: their scale may be a tiny
        # gbar's or r's.
        relative = {len(x) - 1} if more else set()
        relative |= {0} if not symmetric and floats.kind != "d" else set()
        guess, size = x, np.inf
        for count in range(MOST_STEPS):
            value = residual(x, exact.device.restitution, level, ops)
            scale = [abs(v) if i in relative and v else Decimal(1) for i, v in enumerate(x)]
            if count < QUICK_STEPS:
                columns = _differences(
                    lambda y: residual(y, sweep.device.restitution, floats, math),
                    [float(v) for v in x],
                    [float(v) for v in scale],
                    1e-6,
                )
            else:
                columns = _differences(lambda y: residual(y, exact.device.restitution, level, ops), x, scale, FINE_STEP)
            step = _solve(columns, value)
            x = [a - b * s for a, b, s in zip(x, step, scale, strict=True)]
            size = max(abs(float(b)) for b in step)
            if size < POLISHED:
                break
            if max(abs(float(a - b)) for a, b in zip(x, guess, strict=True)) > FARTHEST:
                raise NumericalError(
                    f"a critical point near q = {0.5 + u:.6g}, phase {phi:.6g} was lost (correction {size:.1g})"
                )
        else:
            raise NumericalError(
                f"a critical point near q = {0.5 + u:.6g}, phase {phi:.6g} did not settle (last correction {size:.1g})"
            )
        u_phi = (Decimal(0), x[0]) if symmetric else (x[0], x[1])
        return _rounded(exact, sweep, orbits(*u_phi, exact.device.restitution, n, ops))


def _rounded(exact: Sweep, sweep: Sweep, orbit: Orbits) -> Point:
    value = _sweep_value(exact, sweep, orbit)
    rounded = float(value)
    motion = {
        "u": float(orbit.u),
        "phi": float(orbit.phi % (2 * DecimalOps().pi)),
        "d": float(orbit.d),
        "gbar": 0.0 if sweep.level.horizontal else float(orbit.gbar),
        "velocity_bottom": float(orbit.velocity_bottom),
        "velocity_top": float(orbit.velocity_top),
    }
    # Rounding to a double is half a spacing; a whole one also covers what the polish has left.
    return Point(
        **motion,
        sweep_value=rounded,
        error_bound=max(abs(float(value - Decimal(rounded))), float(np.spacing(abs(rounded)))),
        bounds=with_top({name: float(np.spacing(abs(x))) for name, x in motion.items()}, sweep.device.period_ratio),
    )


def with_top(bounds: dict[str, float], n: int) -> dict[str, float]:
    """Add the bound of the phase at the top, which is computed in doubles from u and the phase at the bottom."""
    rounding = (10 + 10 * n) * float(np.finfo(float).eps)
    return {**bounds, "phi_top": bounds["phi"] + 2 * np.pi * n * bounds["u"] + rounding}


def _sweep_value(exact: Sweep, sweep: Sweep, orbit: Orbits) -> Decimal:
    """The swept parameter in long decimals."""
    device = exact.device
    if sweep.parameter == "frequency_hz":
        return Decimal(orbit.d * device.amplitude_n / (4 * device.capsule_mass_kg * device.length_m)).sqrt()
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


def _differences(
    function: Callable[[list[Any]], list[Any]], x: list[Any], scale: list[Any], step: Any
) -> list[list[float]]:
    """Columns of the Jacobian by central differences, each unknown stepped by its scale and divided by it."""
    columns = []
    for i, size in enumerate(scale):
        ahead, behind = list(x), list(x)
        ahead[i], behind[i] = x[i] + step * size, x[i] - step * size
        columns.append([float((a - b) / (2 * step)) for a, b in zip(function(ahead), function(behind), strict=True)])
    return columns


def _solve(columns: list[list[float]], value: list[Decimal]) -> list[Decimal]:
    """One Newton correction; the rows are first brought to one size."""
    matrix = np.array(columns).T
    size = np.max(np.abs(matrix), axis=1)
    if not np.all(np.isfinite(matrix)) or not size.all():
        raise NumericalError("a critical point is degenerate: its conditions do not depend on the motion")
    right = [float(v) / s for v, s in zip(value, size, strict=True)]
    try:
        return [Decimal(float(b)) for b in np.linalg.solve(matrix / size[:, None], right)]
    except np.linalg.LinAlgError as error:
        raise NumericalError("a critical point is degenerate: two of its conditions coincide") from error
