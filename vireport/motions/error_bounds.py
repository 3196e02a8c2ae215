"""How wrong the numbers of the results can be: a bound for each, from the rounding of its formula and the conditioning.

A row of a branch stands for an exact motion of the scenario nearby: every number of the row differs from that
motion's by at most its bound. The row's phase and q satisfy the sweep's condition up to a residual; the residual and
its own rounding, over the condition's gradient, is how far the exact motion is, and the formulae, evaluated once more
in numbers that carry their error, take that and their rounding to every other number. At an end of the sweep the
bounds also hold for the motion of that very end, of which q and phase are correctly rounded. At a design point, where
both groups are given, the exact motion is the one there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.motions.one_to_one import Motions
from vireport.motions.orbits import coefficients, orbits_above
from vireport.motions.stability import discriminant, return_trace
from vireport.motions.sweep import (
    Held,
    Level,
    Sweep,
    level_terms,
)
from vireport.physics import (
    FUNCTION,
    GROUP_ERROR,
    ROUNDED,
    UNIT,
    Membrane,
    Rounded,
    contact_cosine,
    deflection,
    generated_voltage,
    wrapped,
)
from vireport.scenario import Parameter

Floats = NDArray[np.float64]

CURVATURE = 2.0
"""Factor on the distance to the exact motion for the bend of the condition on the way."""

STEP = 1e-3
"""Step of the gradient's difference in q, as a share of the scale (1-r)/(1+r) on which the coefficients vary."""

GENTLE = 1e-5
"""Relative change of the impact velocity by which a voltage's elasticity is found; beyond it a voltage need not be
proportional to a power of the velocity any more."""

NO_BOUND = "diverges, or loses all its digits, where an impact has no velocity or two branches meet"
"""Why there is no bound."""


def motion_bounds(sweep: Sweep, motions: Motions, given: tuple[Floats, Floats] | None) -> dict[str, Floats]:
    """Bound the errors of motions, by the names of `Motions`.

    Parameters
    ----------
    sweep : Sweep
        That the motions lie on.
    motions : Motions
    given : tuple of ndarray or None
        Errors of q - 1/2 and of the phase, where the motions are those at given values of both groups rather than
        somewhere on the sweep.

    Returns
    -------
    dict of ndarray
        Infinite where there is no bound: trace, discriminant and gap where an impact has no velocity, and everything
        at a point where the condition's gradient vanishes.

    Notes
    -----
    The scenario's numbers are taken as exact, and gbar below `physics.NO_GRAVITY` as zero. Where an extremum of Z'
    vanishes to rounding, so that it is open whether the ball turns at all, the gap is that of the motion as computed.
    """
    with np.errstate(all="ignore"):
        return finite(_motion_bounds(sweep, motions, given))


def finite(bounds: dict[str, Floats]) -> dict[str, Floats]:
    """Bounds, infinite where there is none."""
    return {name: np.where(np.isfinite(bound), bound, np.inf) for name, bound in bounds.items()}


def _motion_bounds(sweep: Sweep, m: Motions, given: tuple[Floats, Floats] | None) -> dict[str, Floats]:
    r, n, held = Rounded(m.restitution), sweep.device.period_ratio, sweep.level.held
    delta_u, delta_phi = _distance(sweep.level, m, n) if given is None else given
    # Half a spacing is the rounding of a motion that was solved for beyond doubles, as at the ends of a sweep.
    delta_u, delta_phi = (np.maximum(a, np.spacing(np.abs(x))) for a, x in ((delta_u, m.u), (delta_phi, m.phi_bottom)))
    u, ops = Rounded(m.u, delta_u), ROUNDED
    orbit = orbits_above(coefficients(u, r, n, ops), u, Rounded(m.phi_bottom, delta_phi), r, n, ops)
    trace = return_trace(orbit, r)
    top = wrapped(np.arctan2(orbit.sin_top.value, orbit.cos_top.value) - m.phi_top)
    phase_top = orbit.sin_top.error + orbit.cos_top.error + np.abs(top) + 2 * FUNCTION * np.pi
    d = GROUP_ERROR * m.d if given is not None or held is Held.D else _from(orbit.d, m.d)
    gbar = GROUP_ERROR * m.gbar if given is not None or held is Held.GBAR else _from(orbit.gbar, m.gbar)
    velocity_bottom = _from(orbit.velocity_bottom, m.velocity_bottom)
    velocity_top = _from(orbit.velocity_top, m.velocity_top)
    # A turning point moves with the start of its flight: with the velocity, the phase and the acceleration there.
    period = 2 * n
    speed = m.restitution * np.maximum(m.velocity_bottom, -m.velocity_top)
    turning = (
        period * m.restitution * np.maximum(velocity_bottom, velocity_top)
        + period**2 / 2 * gbar
        + (0.3 + period / np.pi) * np.maximum(delta_phi, phase_top)
        + 8 * UNIT * (period * speed + period**2 * m.gbar + 0.3 + period / np.pi)
    )
    at_rest = (m.velocity_bottom == 0) | (m.velocity_top == 0)
    value = np.zeros(len(m)) if given is not None else value_bound(sweep, m.sweep_value, orbit.d, orbit.gbar)
    return {
        "sweep_value": value,
        "d": d,
        "gbar": gbar,
        "q": delta_u + UNIT * m.q,
        "phi_bottom": delta_phi + UNIT * m.phi_bottom,
        "phi_top": phase_top,
        "velocity_bottom": velocity_bottom,
        "velocity_top": velocity_top,
        "trace": _unless_lost(_from(trace, m.trace), m.trace),
        "determinant": 4 * UNIT * m.determinant,
        "discriminant": _unless_lost(_from(discriminant(trace, r * r), m.discriminant), m.discriminant),
        "wall_gap": np.where(at_rest, np.inf, d + np.where(m.wall_gap < m.d, turning, 0.0)),
    }


def _from(exact: Rounded, stored: Floats) -> Floats:
    """Bound of a stored number: the error of its recomputation, and how far the two are apart."""
    return np.asarray(exact.error + np.abs(exact.value - stored))


def _unless_lost(bound: Floats, stored: Floats) -> Floats:
    """No bound where it would be larger than a number that diverges there."""
    return np.where(bound > np.maximum(np.abs(stored), 1.0), np.inf, bound)


def _distance(level: Level, m: Motions, n: int) -> tuple[Floats, Floats]:
    """How far, in q and in phase, the exact motion is from each row."""
    ops, r, u = ROUNDED, Rounded(m.restitution), Rounded(m.u)
    known = level if level.horizontal else Level(level.held, Rounded(level.value, 2 * GROUP_ERROR * abs(level.value)))
    sine, cosine = ops.sin(Rounded(m.phi_bottom)), ops.cos(Rounded(m.phi_bottom))
    a, b, c = level_terms(known, coefficients(u, r, n, ops), u, r, n, ops)
    residual = a * sine + b * cosine - c
    h = STEP * (1 - m.restitution) / (1 + m.restitution)

    def at(x: Floats) -> Any:
        a, b, c = level_terms(level, coefficients(x, m.restitution, n), x, m.restitution, n)
        return a * sine.value + b * cosine.value - c

    slope_u = (at(m.u + h) - at(m.u - h)) / (2 * h)
    slope_phi = a.value * cosine.value - b.value * sine.value
    reach = CURVATURE * (np.abs(residual.value) + residual.error) / (slope_u**2 + slope_phi**2)
    # On the symmetric line of a horizontal capsule u = 0 is exact, and any phase is that of a motion.
    free = level.horizontal & (m.u == 0)
    delta_u, delta_phi = (np.where(free, 0.0, reach * np.abs(slope)) for slope in (slope_u, slope_phi))
    return delta_u, delta_phi


def value_bound(sweep: Sweep, stored: Floats, d: Any, gbar: Any) -> Floats:
    """Bound the error of the swept value of motions, from those of their groups.

    Parameters
    ----------
    sweep : Sweep
    stored : ndarray
        Its values as they are given.
    d, gbar : Rounded
        Of the motions.
    """
    x = gbar if sweep.parameter is Parameter.INCLINATION else d
    away = np.abs(np.asarray(sweep.value(d.value, gbar.value)) - stored)
    if sweep.parameter is Parameter.INCLINATION:
        error = x.error + GROUP_ERROR * np.abs(x.value)
        ends = [np.asarray(sweep.value(d.value, x.value + sign * error)) for sign in (-1, 1)]
        moved = np.maximum(*(np.abs(end - stored) for end in ends))
        return np.asarray(moved + away + 2 * FUNCTION * stored)
    share = x.error / np.abs(x.value) * (0.5 if sweep.parameter is Parameter.FREQUENCY else 1.0)
    return np.asarray((share + GROUP_ERROR) * stored + away)


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
    return finite(bounds)


def _impact_bounds(speed: Rounded, membrane: Membrane) -> tuple[Floats, Floats]:
    """Bounds of the voltage and of the deflection of impacts."""
    power, value = membrane.exponent + 1, speed.value
    share = speed.error / value
    delta, volts = deflection(value, membrane), generated_voltage(value, membrane)
    base = abs(np.log(power * membrane.ball_mass_kg / (2 * membrane.stiffness)))
    relative = 2 / power * (share + 4 * UNIT + 2 * UNIT * np.abs(np.log(np.where(value > 0, value, 1.0))))
    relative = relative + (base + 4) * UNIT / power + 6 * UNIT
    elasticity = np.abs(generated_voltage(value * (1 + GENTLE), membrane) / volts - 1) / GENTLE * power / 2
    ball, active = membrane.ball_radius_m, membrane.active_radius_m
    depth = np.maximum(delta - ball, 0.0)
    reach = np.sqrt((active - ball) * (active + ball) + depth * depth)
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
    """How far what rises with the speed can be from what it is at `speed.value`."""
    here = function(speed.value, membrane)
    fastest = function(speed.value + speed.error, membrane)
    slowest = function(np.maximum(speed.value - speed.error, 0.0), membrane)
    return np.asarray((1 + GENTLE) * np.maximum(fastest - here, here - slowest))


def undecided(motions: Motions, bounds: dict[str, Floats]) -> NDArray[np.bool_]:
    """Whether rounding leaves it open if the ball stays between the membranes: a gap of at most its bound."""
    return np.asarray(np.abs(motions.wall_gap) <= bounds["wall_gap"])


def rounded_up(bounds: Floats) -> list[list[float | None]]:
    """Rows of bounds as they are written: rounded up to two digits, None where there is none."""
    usable = np.isfinite(bounds) & (bounds > 0)
    safe = np.where(usable, bounds, 1.0)
    power = 1 - np.floor(np.log10(safe))
    # A quotient by an exact power of ten is the double nearest to the two digits, and is written as such.
    up = np.where(power > 0, 10.0 ** np.clip(power, 0, 300), 1.0)
    down = np.where(power < 0, 10.0 ** np.clip(-power, 0, 300), 1.0)
    rounded = np.ceil(safe * up / down * (1 + 1e-12)) / up * down
    written = np.where(usable & (safe > 1e-290), rounded, bounds)
    if np.isfinite(written).all():
        return list(written.tolist())
    return [[x if x < np.inf else None for x in row] for row in written.tolist()]
