"""Error bounds of the numbers of a solution: motions and voltages on its branches and at its design point.

By (5.5) a deflection grows with the power 2/(h + 1) of the speed, by which factor its relative error exceeds that of
the speed. A voltage grows with a power that depends on the deflection, its elasticity, evaluated by a difference. If
the error of the speed is too large for that, both are evaluated at the ends of its range, with which they increase.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.design.point import DesignPoint, around_length
from vireport.motions.branches import Branch
from vireport.motions.diagram import BifurcationDiagram
from vireport.motions.error_bounds import one_to_one_bounds
from vireport.motions.one_to_one import Motions
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.energy import (
    Dielectric,
    Membrane,
    Strikes,
    Voltages,
    contact_cosine,
    conversion,
    deflection,
    generated_voltage,
)
from vireport.physics.numbers import ROUNDED, UNIT, Rounded, infinite_where_undefined

Floats = NDArray[np.float64]

FACTORS = 16
"""Number of roundings, with room, of the constant factors of an energy, a power or a field, computed in doubles."""


class Bounds(Struct, frozen=True, eq=False):
    """Error bounds, by the names of `Motions` and `Voltages`; infinite where there is none.

    Attributes
    ----------
    branches : tuple of dict
        For each branch an array for each of its columns.
    design : dict or None
        For the motions at the design point.
    """

    branches: tuple[dict[str, Floats], ...]
    design: dict[str, Floats] | None

    __repr__ = brief


def bounds_of(
    device: Device, membrane: Membrane | None, diagram: BifurcationDiagram | None, design: DesignPoint | None
) -> Bounds:
    """Bound the errors of every motion and voltage along a sweep and at a design point."""
    sweep, branches = (diagram.sweep, diagram.branches) if diagram is not None else (None, ())
    over_sweep = tuple(_branch_bounds(membrane, sweep, branch) for branch in branches if sweep is not None)
    if design is None:
        return Bounds(over_sweep, None)
    bounds = _motion_bounds(membrane, around_length(device), design.motions, design.errors)
    if membrane is not None and design.conversion_by_motion is not None:
        bounds |= _conversion_bounds(device, membrane, design, bounds)
    return Bounds(over_sweep, bounds)


def _branch_bounds(membrane: Membrane | None, sweep: Sweep, branch: Branch) -> dict[str, Floats]:
    """Error bounds of a branch's motions; at a critical point, which may only be bracketed, at least its own bounds."""
    bounds = _motion_bounds(membrane, sweep, branch.motions, None)
    for row, critical in branch.family.critical_points.items():
        labelled = {**critical.closed.bounds, "sweep_value": critical.error_bound}
        for name in ("sweep_value", "d", "gbar", "velocity_bottom", "velocity_top"):
            bounds[name][row] = max(bounds[name][row], labelled[name])
        bounds["q"][row] = max(bounds["q"][row], labelled["u"])
        bounds["phi_bottom"][row] = max(bounds["phi_bottom"][row], labelled["phi_bottom"])
    return bounds


def _motion_bounds(
    membrane: Membrane | None, sweep: Sweep, motions: Motions, solved: tuple[Floats, Floats] | None
) -> dict[str, Floats]:
    """Error bounds of motions and their voltages; `solved` has the bounds of u and phase, where they are known."""
    bounds = one_to_one_bounds(sweep, motions, solved)
    if membrane is None:
        return bounds
    return {**bounds, **voltage_bounds(*_speeds(sweep, motions, bounds), membrane)}


def _speeds(sweep: Sweep, motions: Motions, bounds: dict[str, Floats]) -> tuple[Rounded, Rounded]:
    """Speeds of the impacts at the bottom and at the top [m/s]."""
    # The exact motion may be at another force or frequency, and so in another unit of velocity.
    value = Rounded(motions.sweep_value, bounds["sweep_value"])
    unit = sweep.device.velocity_unit(sweep.parameter, value)
    bottom = unit * Rounded(motions.velocity_bottom, bounds["velocity_bottom"])
    top = unit * Rounded(-motions.velocity_top, bounds["velocity_top"])
    return bottom, top


def _conversion_bounds(
    device: Device, membrane: Membrane, design: DesignPoint, bounds: dict[str, Floats]
) -> dict[str, Floats]:
    """Bound the errors of the energy conversion of a design point's motions, by the names of `Conversion`."""
    volts, dielectric = cast(Voltages, design.voltages_by_motion), cast(Dielectric, membrane.dielectric)
    gains = Rounded(volts.bottom_v, bounds["bottom_v"]), Rounded(volts.top_v, bounds["top_v"])
    speeds = _speeds(around_length(device), design.motions, bounds)
    with np.errstate(all="ignore"):
        strikes = Strikes(gains, speeds, design.motions.restitution)
        exact = conversion(strikes, membrane, dielectric, device.period_s, ROUNDED)
        numbers = {name: getattr(exact, name) for name in exact.__struct_fields__}
        return infinite_where_undefined(
            {name: x.error + FACTORS * UNIT * np.abs(x.value) for name, x in numbers.items()}
        )


GENTLE = 1e-5
"""Relative change of the impact velocity for the difference that gives a voltage's elasticity; and the relative error
up to which a voltage is taken as proportional to a power of the velocity."""


def voltage_bounds(bottom: Rounded, top: Rounded, membrane: Membrane) -> dict[str, Floats]:
    """Bound the errors of voltages and deflections, by the names of `Voltages`.

    Parameters
    ----------
    bottom, top : Rounded
        Speeds of the impacts [m/s].
    membrane : Membrane
    """
    with np.errstate(all="ignore"):
        (volts_bottom, deep_bottom), (volts_top, deep_top) = (_impact_bounds(x, membrane) for x in (bottom, top))
    bounds = {
        "bottom_v": volts_bottom,
        "top_v": volts_top,
        "average_v": (volts_bottom + volts_top) / 2 * (1 + 2 * UNIT),
        "deflection_m": np.maximum(deep_bottom, deep_top),
    }
    return infinite_where_undefined(bounds)


def _impact_bounds(speed: Rounded, membrane: Membrane) -> tuple[Floats, Floats]:
    """Bounds of the voltage [V] and of the deflection [m] of impacts."""
    power, value = membrane.exponent + 1, speed.value
    share = speed.error / value
    delta, volts = deflection(value, membrane), generated_voltage(value, membrane)
    base = abs(np.log(power * membrane.reduced_mass_kg / (2 * membrane.stiffness)))
    relative = 2 / power * (share + 4 * UNIT + 2 * UNIT * np.abs(np.log(np.where(value > 0, value, 1.0))))
    relative = relative + (base + 4) * UNIT / power + 6 * UNIT
    # Per cent of voltage for a per cent of deflection, by a difference of speeds.
    elasticity = np.abs(generated_voltage(value * (1 + GENTLE), membrane) / volts - 1) / GENTLE * power / 2
    ball, active = membrane.ball_radius_m, membrane.active_radius_m
    depth = np.maximum(delta - ball, 0.0)
    reach = np.sqrt((active - ball) * (active + ball) + depth * depth)
    # Above the ball's radius the two terms of the cosine have opposite signs, which magnifies their rounding.
    cancelled = np.where(depth > 0, (active * reach + ball * depth) / (active * reach - ball * depth), 1.0)
    stretched = 1 - (ball / active) ** 2 * contact_cosine(delta, membrane)[1]
    geometry = (30 + 20 * cancelled + 10 / stretched) * UNIT
    of_volts, of_delta = 1.1 * volts * elasticity * relative, delta * relative
    rough = ~((speed.error < GENTLE * value) & (volts > 0))
    if rough.any():
        part = Rounded(value[rough], speed.error[rough])
        of_volts[rough], of_delta[rough] = (_spread(f, part, membrane) for f in (generated_voltage, deflection))
    return of_volts + volts * geometry, of_delta


def _spread(function: Callable[[Floats, Membrane], Floats], speed: Rounded, membrane: Membrane) -> Floats:
    """Largest change of an increasing function of the speed within the error of the speed."""
    value = function(speed.value, membrane)
    fastest = function(speed.value + speed.error, membrane)
    slowest = function(np.maximum(speed.value - speed.error, 0.0), membrane)
    return np.asarray((1 + GENTLE) * np.maximum(fastest - value, value - slowest))
