"""Error bounds for every number of a motion, from the rounding of its formula and the conditioning.

A computed motion stands for an exact motion of the scenario nearby: each of its numbers differs from the exact one
by at most its bound. A computed motion satisfies the conditions f(x) = 0 up to a residual. By the theorem of Newton and
Kantorovich there is an exact motion within twice the least change that makes up for the residual and for the rounding
of the residual, where the conditions bend little over that distance. The conditions are evaluated in numbers
that carry their error (`Rounded`), and the least change is that of their linearisation:

- 1:1 motions have a closed form for all numbers but q and the phase, so that the sweep's level is the one condition
  left, and the least change is its residual over its gradient (`one_to_one_bounds`);
- motions of any word have two conditions for each flight, and the least change is that of the pseudo-inverse of their
  derivatives, the same for a single condition (`distance_bounds`, `family_bounds`, and `point_bounds` where nothing
  varies).

At an end of the sweep the bounds also hold for the motion at that very end, whose q and phase are correctly rounded.
At a design point, which states both groups, the exact motion is the one there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.motions.level_curve import plane_of
from vireport.motions.level_plane import SweptPlane
from vireport.motions.one_to_one import Motions
from vireport.motions.paths import Curve
from vireport.motions.periodicity import Model, residuals
from vireport.motions.stability import discriminant, lap_decay, return_trace
from vireport.motions.sweep import Held, Level, Sweep
from vireport.physics.device import GROUP_ERROR
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitution, Restitutions, by_wall, map_restitution
from vireport.physics.numbers import (
    FUNCTION,
    ROUNDED,
    UNDERFLOW,
    UNIT,
    Arithmetic,
    Rounded,
    infinite_where_undefined,
    wrapped,
)
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter

Floats = NDArray[np.float64]

CURVATURE = 2.0
"""Factor on the least change of q and phase, for the curvature of the level: the largest that the theorem allows."""

NEAR = 0.1
"""Kantorovich's beta L eta (bound of the inverse, Lipschitz constant of the derivatives, least change) up to which
there is an exact motion close by; his theorem needs 0.5."""

PHASE_ROUNDINGS = 3 * np.pi
"""Roundings of a phase from a time [rad per t_c]: of the product with pi, of pi, and of the remainder."""

PARTS = 4 * UNIT
"""Rounding of the cosine and sine coefficient of a harmonic, over its share of the force."""

STEP = 1e-3
"""Step of the gradient's difference in q, as a share of the scale (1-r)/(1+r) on which the coefficients vary."""

NO_BOUND = "diverges, or loses all its digits, where an impact has no velocity or two branches meet"
"""Reason for a bound that is missing in the results."""


def one_to_one_bounds(sweep: Sweep, motions: Motions, solved: tuple[Floats, Floats] | None) -> dict[str, Floats]:
    """Bound the errors of 1:1 motions, by the names of `Motions`.

    Parameters
    ----------
    sweep : Sweep
        Of the motions.
    motions : Motions
    solved : tuple of ndarray or None
        Errors of q - 1/2 and of the phase [rad] of motions that were solved for at exact values of both groups; None
        for motions of which only the sweep's level is exact.

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
        return infinite_where_undefined(_one_to_one_bounds(sweep, motions, solved))


def _one_to_one_bounds(sweep: Sweep, m: Motions, solved: tuple[Floats, Floats] | None) -> dict[str, Floats]:
    """The bounds of `one_to_one_bounds`, NaN or infinite where there are none."""
    r, n, held = _enclosed_restitution(m.restitution), sweep.device.period_ratio, sweep.level.held
    delta_u, delta_phi = _place_bounds(sweep, m) if solved is None else solved
    # Half a spacing is the rounding of a motion that was solved for beyond doubles, as at the ends of a sweep.
    delta_u, delta_phi = (np.maximum(a, np.spacing(np.abs(x))) for a, x in ((delta_u, m.u), (delta_phi, m.phi_bottom)))
    u, ops = Rounded(m.u, delta_u), ROUNDED
    strength, phi = _strength(sweep.device.harmonics), Rounded(m.phi_bottom, delta_phi)
    plane = _enclosed(plane_of(sweep))
    orbit = replace(plane, r=r).orbits(u, phi, ops) if plane.level.varied is None else plane.orbits(u, phi, ops)
    r = r if orbit.restitution is None else orbit.restitution
    trace = return_trace(orbit, r)
    top = wrapped(np.arctan2(orbit.sin_top.value, orbit.cos_top.value) - m.phi_top)
    phase_top = orbit.sin_top.error + orbit.cos_top.error + np.abs(top) + 2 * FUNCTION * np.pi
    holds_gbar = held in (Held.GBAR, Held.BOTH)
    d = GROUP_ERROR * m.d if solved is not None or sweep.level.holds_d else _from(orbit.d, m.d)
    gbar = GROUP_ERROR * m.gbar if solved is not None or holds_gbar else _from(orbit.gbar, m.gbar)
    velocity_bottom = _from(orbit.velocity_bottom, m.velocity_bottom)
    velocity_top = _from(orbit.velocity_top, m.velocity_top)
    # The gap has no closed form: its error is bounded by how far a turning point moves with the start of its flight,
    # with the velocity, the phase and the acceleration there over at most a period.
    period = 2 * n
    most = np.maximum(*by_wall(m.restitution))
    speed = most * np.maximum(m.velocity_bottom, -m.velocity_top)
    turning = (
        period * most * np.maximum(velocity_bottom, velocity_top)
        + period**2 / 2 * gbar
        + strength * (0.3 + period / np.pi) * np.maximum(delta_phi, phase_top)
        + 8 * UNIT * (period * speed + period**2 * m.gbar + strength * (0.3 + period / np.pi))
    )
    if orbit.friction is not None:
        turning = turning + period**2 / 2 * orbit.friction.error + 8 * UNIT * period**2 * orbit.friction.value
    at_rest = (m.velocity_bottom == 0) | (m.velocity_top == 0)
    value = (
        np.zeros(len(m)) if solved is not None else sweep_value_bounds(sweep, m.sweep_value, sweep.coordinate(orbit))
    )
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
        "determinant": _determinant_bounds(plane.level, r, m),
        "discriminant": _unless_lost(_from(discriminant(trace, lap_decay(r)), m.discriminant), m.discriminant),
        "wall_gap": np.where(at_rest, np.inf, d + np.where(m.wall_gap < m.d, turning, 0.0)),
    }


def _determinant_bounds(level: Level, r: Restitution, m: Motions) -> Floats:
    """Bounds of det DP: its rounding and, where r is not exactly that of the scenario, the error of r."""
    rounding = 4 * UNIT * m.determinant
    # A fourth power underflows where the restitution itself is far from it.
    lost = np.where((m.determinant < np.finfo(float).tiny) & (np.asarray(m.decay) > 0), UNDERFLOW, 0.0)
    law = isinstance(m.restitution, Restitutions) and type(m.restitution.slope) is not int
    if level.varied is None and not law:
        return np.asarray(rounding + lost)
    decay = lap_decay(r)
    return np.asarray(rounding + lost + (decay * decay).error)


def _from(exact: Rounded, stored: Floats) -> Floats:
    """Bounds of stored numbers: the errors of their recomputation plus the differences from it."""
    return np.asarray(exact.error + np.abs(exact.value - stored))


def _unless_lost(bound: Floats, stored: Floats) -> Floats:
    """Bounds, infinite where they exceed the number itself (or 1): it has no digit, as next to its pole."""
    return np.where(bound > np.maximum(np.abs(stored), 1.0), np.inf, bound)


def _enclosed_restitution(restitution: Restitution) -> Any:
    """Restitutions with their errors: none for those of the scenario, a rounding for those that follow from a law."""
    if not isinstance(restitution, Restitutions) or type(restitution.slope) is int:
        return map_restitution(restitution, Rounded)
    bottom, top, slope = (Rounded(r, UNIT * r) for r in (restitution.bottom, restitution.top, restitution.slope))
    return Restitutions(bottom, top, slope)


def _enclosed_harmonics(harmonics: Sequence[Harmonic]) -> tuple[Harmonic, ...]:
    """Harmonics with the errors of their coefficients."""
    return tuple(
        Harmonic(
            harmonic.order,
            Rounded(harmonic.cosine, PARTS * harmonic.share),
            Rounded(harmonic.sine, PARTS * harmonic.share),
        )
        for harmonic in harmonics
    )


def _strength(harmonics: Sequence[Harmonic]) -> float:
    """An upper bound of the rate of the force over that of a sine."""
    return 1 + sum(harmonic.order * harmonic.share for harmonic in harmonics)


def _place_bounds(sweep: Sweep, m: Motions) -> tuple[Floats, Floats]:
    """Bounds of the distances in q and in phase from 1:1 motions to exact motions on the level."""
    plane, u, phi = plane_of(sweep), m.u, m.phi_bottom
    if plane.level.varied is None:
        plane = replace(plane, r=m.restitution)  # differs from motion to motion where it falls with speed
    most = max(by_wall(plane.r))
    slope_u, slope_phi = plane.slopes(u, phi, STEP * (1 - most) / (1 + most))
    residual = _enclosed(plane).value(Rounded(u), Rounded(phi), ROUNDED)
    # The least change of (q, phase) to make up for a residual rho is rho grad/|grad|^2.
    reach = CURVATURE * _largest(residual) / (slope_u**2 + slope_phi**2)
    # On the symmetric line of a horizontal capsule u = 0 is exact, and any phase is that of a motion.
    free = plane.level.symmetric(plane.r, plane.harmonics) & (u == 0)
    delta_u, delta_phi = (np.where(free, 0.0, reach * np.abs(slope)) for slope in (slope_u, slope_phi))
    return delta_u, delta_phi


def _enclosed(plane: SweptPlane) -> SweptPlane:
    """A plane in numbers that carry the errors of the groups and of the coefficients of harmonics."""
    level, harmonics = _enclosed_level(plane.level), _enclosed_harmonics(plane.harmonics)
    return replace(plane, level=level, r=map_restitution(plane.r, Rounded), harmonics=harmonics)


def _enclosed_level(level: Level) -> Level:
    """A level with the errors of the groups that it holds; gbar = 0 is exact."""
    friction = None if level.friction is None else level.friction.map_numbers(_of_groups)
    value = level.value if level.horizontal else _of_groups(level.value)
    return replace(level, value=value, friction=friction, d=None if level.d is None else _of_groups(level.d))


def _of_groups(value: Any) -> Rounded:
    """A group, or the quotient of both groups, with the error of both."""
    return Rounded(value, 2 * GROUP_ERROR * abs(value))


def _largest(residual: Rounded) -> Floats:
    """Largest sizes of residuals within their errors."""
    return np.asarray(np.abs(residual.value) + residual.error)


def distance_bounds(curve: Curve, model: Model, x: Floats) -> Floats:
    """Bound the distance from motions of any word to exact ones next to them.

    Parameters
    ----------
    curve : Curve
        Of the motions.
    model : Model
        Groups over the sweep.
    x : ndarray (n, 2N + 1)
        Velocities [y_c], times [t_c] and coordinate of each motion.

    Returns
    -------
    ndarray (n, 2N + 1)
        Bounds for all these numbers, to a motion of the scenario as stated; infinite where families cross.
    """
    word = curve.word
    enclosed = replace(
        model,
        level=_enclosed_level(model.level),
        r=map_restitution(model.r, Rounded),
        harmonics=_enclosed_harmonics(model.harmonics),
    )
    conditions = residuals(word, [Rounded(column) for column in x.T], enclosed, ROUNDED)
    _, gbar, *_ = model.groups(np.abs(x[:, -1]))
    bounds = _distances(
        word, np.stack([curve.linearised(row)[1] for row in x]), conditions, gbar, _strength(model.harmonics)
    )
    bounds[:, -1] *= curve.width
    return bounds


def _distances(word: Word, matrices: Floats, conditions: list[Rounded], gbar: Arithmetic, strength: float) -> Floats:
    """Bound the distance to exact motions, by the derivatives and the residuals of the conditions.

    Parameters
    ----------
    word : Word
    matrices : ndarray (n, 2N, m)
        Derivatives of the conditions by the unknowns of each motion.
    conditions : list of Rounded
        The 2N residuals, arrays over the motions.
    gbar : array_like
    strength : float
        See `_strength`.

    Returns
    -------
    ndarray (n, m)
    """
    most = np.stack([_largest(residual) for residual in conditions], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        # By singular values: the least of them is needed for Kantorovich's beta as well, and a product of the matrix
        # with its transpose would square its condition.
        u, sizes, v = np.linalg.svd(matrices, full_matrices=False)
        # A bound has no sign: the sizes of the pseudo-inverse's entries, times the largest residuals.
        change = np.abs(np.einsum("nki,nk,njk->nij", v, 1 / sizes, u)) @ most[..., None]
        # Second derivatives of a flight: of its phases, pi, over at most the period, and of its accelerations.
        bend = 2 * np.pi * (1 + 2 * word.periods) * (1 + strength + gbar) * np.sqrt(2 * len(word))
        eta = np.linalg.norm(change, axis=1)[:, 0]
        near = bend * eta / sizes[:, -1]
        # Kantorovich's distance is eta (1 - sqrt(1 - 2h))/h = eta (1 + h/2 + ...), h = beta L eta: 2h is room enough.
        bounds = change[..., 0] + (2 * near * eta)[:, None]
    return np.where((near < NEAR)[:, None], bounds, np.inf)


class _Fixed(Struct, frozen=True):
    """The groups of a device in which nothing varies, as a `Grouped`."""

    groups: Groups[Any]

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """The groups, whatever `varied`."""
        return self.groups


def point_bounds(curve: Curve, x: Floats) -> tuple[Floats, Floats]:
    """Bound the errors of a motion of any word at a design point, for which the scenario states all inputs.

    Parameters
    ----------
    curve : Curve
        A path that the motion lies on.
    x : ndarray (2N + 1,)
        Its velocities [y_c], times [t_c] and coordinate.

    Returns
    -------
    velocity, time : ndarray (N,)
        Bounds for the motion's impacts [y_c, t_c]; infinite where motions meet.
    """
    groups = curve.model.at((float(x[-1]),))
    enclosed = _Fixed(groups.map_numbers(lambda number: Rounded(number, GROUP_ERROR * abs(number))))
    conditions = residuals(curve.word, [Rounded(np.array([entry])) for entry in x[:-1]], enclosed, ROUNDED)
    matrices, strength = curve.linearised(x)[1][None, :, :-1], _strength(groups.harmonics)
    (bounds,) = _distances(curve.word, matrices, conditions, groups.gbar, strength)
    count = len(curve.word)
    return bounds[:count], bounds[count:]


def family_bounds(sweep: Sweep, model: Model, x: Floats, distance: Floats, sweep_value: Floats) -> dict[str, Floats]:
    """Bound the errors of swept value, velocities and phases of a family's motions.

    Parameters
    ----------
    sweep : Sweep
    model : Model
        Groups over the sweep.
    x : ndarray (n, 2N + 1)
        Velocities, times and coordinate of each motion.
    distance : ndarray (n, 2N + 1)
        Bounds of the distance to the exact motion, see `distance_bounds`.
    sweep_value : ndarray (n,)
        The swept parameter of each motion, as it is stated.

    Returns
    -------
    dict of ndarray
        Of `sweep_value` [its unit], `velocity` [y_c] and `phase` [rad].
    """
    count = x.shape[1] // 2
    groups = model.groups(Rounded(x[:, -1], distance[:, -1]))
    d, gbar = (group if isinstance(group, Rounded) else _of_groups(group) for group in groups[:2])
    phase = np.pi * distance[:, count:-1] + PHASE_ROUNDINGS * UNIT * np.abs(x[:, count:-1])
    coordinate = Rounded(x[:, -1], distance[:, -1])
    if not sweep.parameter.bounces:
        coordinate = gbar if sweep.parameter is Parameter.INCLINATION else d
    value = sweep_value_bounds(sweep, sweep_value, coordinate)
    return {"sweep_value": value, "velocity": distance[:, :count], "phase": phase}


def sweep_value_bounds(sweep: Sweep, stored: Floats, group: Rounded) -> Floats:
    """Bound the error of the swept value of motions, from that of their coordinate.

    Parameters
    ----------
    sweep : Sweep
    stored : ndarray
        The swept values as in the results.
    group : Rounded
        The coordinate of the motions: d, gbar or a restitution.
    """
    away = np.abs(np.asarray(sweep.value(group.value)) - stored)
    if sweep.parameter.bounces:
        return np.asarray(group.error + away)
    if sweep.parameter is Parameter.INCLINATION:
        error = group.error + GROUP_ERROR * np.abs(group.value)
        ends = [np.asarray(sweep.value(group.value + sign * error)) for sign in (-1, 1)]
        moved = np.maximum(*(np.abs(end - stored) for end in ends))
        return np.asarray(moved + away + 2 * FUNCTION * stored)
    share = group.error / np.abs(group.value) * (0.5 if sweep.parameter is Parameter.FREQUENCY else 1.0)
    return np.asarray((share + GROUP_ERROR) * stored + away)


def undecided(motions: Motions, bounds: dict[str, Floats]) -> NDArray[np.bool_]:
    """Whether rounding leaves open if the ball stays between the membranes: the gap's size is within its bound."""
    return np.asarray(np.abs(motions.wall_gap) <= bounds["wall_gap"])


def rounded_up(bounds: Floats) -> list[list[float | None]]:
    """Rows of bounds for results.json: rounded up to two digits, None for an infinite one."""
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
    return [[bound if bound < np.inf else None for bound in row] for row in written.tolist()]
