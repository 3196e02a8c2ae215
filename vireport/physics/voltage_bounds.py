"""Error bounds for voltages and deflections, from the error of the impact's speed and from rounding.

By (5.5) a deflection grows with the power 2/(h + 1) of the speed, by which factor its relative error exceeds that of
the speed. A voltage grows with a power that depends on the deflection, its elasticity, evaluated by a difference. If
the error of the speed is too large for that, both are evaluated at the ends of its range, with which they increase.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from vireport.physics.energy import Membrane, contact_cosine, deflection, generated_voltage
from vireport.physics.numbers import UNIT, Rounded, infinite_where_undefined

Floats = NDArray[np.float64]

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
