"""How far a design point is, in every input, from where its stable motions end.

Each stable motion is followed along the lines on which the inputs move it (see `continuation`), and where it ends is
polished in long decimals together with the position on the line, from which the values of the inputs follow exactly.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from enum import Enum
from math import inf
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from vireport.base import NumericalError
from vireport.design.continuation import (
    BRACKET,
    IMAGINARY,
    LONGEST_STEP,
    Endpoint,
    Paths,
    follow,
)
from vireport.motions import (
    CONDITIONS,
    DECIMALS,
    POLISHED_NUMBERS,
    Change,
    Condition,
    CriticalKind,
    CriticalPoint,
    Equations,
    Motions,
    Orbits,
    PolishedMotion,
    StrandEvent,
    Symmetry,
    newton,
    orbits,
    polish_grazing,
    rounded_motion,
    singled_out,
)
from vireport.physics import (
    COMPLEX,
    DIGITS,
    FINEST_D,
    FLOATS,
    NO_GRAVITY,
    Device,
)
from vireport.scenario import DesignInput, Parameter

Floats = NDArray[np.float64]

HIGHEST_RESTITUTION = 0.99
"""Up to which margins in restitution are looked for; no pair of materials is known to have more."""

SAME_POINT = 1e-9
"""Relative difference of two values below which two critical points are one."""

LARGEST_SHARE = 1e100
"""Largest relative margin; beyond it the design value is as good as zero."""


class Line(Enum):
    """A straight line through a design point in (d, gbar, r); the value is the inputs that move a device along it.

    The position on it is 0 at the design point. Along the first two it is the relative change of d, along the others
    the change of gbar and of r. While a motion is followed, the logarithm of d stands for its relative change.
    """

    LENGTHS = DesignInput.LENGTH, DesignInput.FREQUENCY
    FORCES = DesignInput.AMPLITUDE, DesignInput.CAPSULE_MASS
    GRAVITY = (DesignInput.INCLINATION,)
    RESTITUTION = (DesignInput.RESTITUTION,)

    def direction(self, d: Any, gbar: Any) -> tuple[Any, Any, Any]:
        """Change of (d, gbar, r) with the position, at the groups of the design point."""
        growth, shift = self.rates
        d_growth, gbar_growth, r_growth = (
            g * start + s for g, start, s in zip(growth, (d, gbar, 0), shift, strict=True)
        )
        return d_growth, gbar_growth, r_growth

    @property
    def rates(self) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
        """How (d, gbar, r) change along it: as exponential functions of the position, and in proportion to it."""
        fixed = 0, 0, 0
        return {
            Line.LENGTHS: ((1, 0, 0), fixed),
            Line.FORCES: ((1, 1, 0), fixed),
            Line.GRAVITY: (fixed, (0, 1, 0)),
            Line.RESTITUTION: (fixed, (0, 0, 1)),
        }[self]

    @staticmethod
    def sense(varied: DesignInput) -> float:
        """1 where an input grows with the position on its line, -1 where it falls."""
        return -1.0 if varied is DesignInput.AMPLITUDE else 1.0

    def position(self, followed: float) -> float:
        """The position, from that by which a motion was followed."""
        return float(np.expm1(followed)) if self in (Line.LENGTHS, Line.FORCES) else followed


LINES, INPUTS = tuple(Line), tuple(DesignInput)


@dataclass(frozen=True, slots=True, eq=False)
class Margin:
    """Distance from the design point to a critical point, when one input varies.

    Attributes
    ----------
    parameter : DesignInput
    point : CriticalPoint
        Its label is that of the scenario's sweep, "" where it does not lie on it; without a sweep it is only unique
        within one input. Its branch is 0 where it is none of the sweep's critical points.
    distance : float
        The input's value there less the design value.
    relative : float or None
        The distance over the design value; None where that is zero, or next to it.
    ends_stability : bool
        Whether a stable motion of the design point ends here.
    error_bound : float
        Of the value, and with the rounding of the difference of `distance`.
    derivatives : dict
        Of the value with respect to each other input, in their units; None where it has none: at a pitchfork, where
        the border has a cusp, and at the ends of two mirror images or in two mirrored flights, which inclination parts.
    """

    parameter: DesignInput
    point: CriticalPoint
    distance: float
    relative: float | None
    ends_stability: bool
    error_bound: float
    derivatives: dict[DesignInput, float | None]

    @property
    def kind(self) -> CriticalKind:
        """Of the critical point."""
        return self.point.kind

    @property
    def label(self) -> str:
        """Of the critical point."""
        return self.point.label

    @property
    def name(self) -> str:
        """Kind and label of the critical point."""
        return f"{self.kind.words} {self.label}".rstrip()

    @property
    def sweep_value(self) -> float:
        """Where the critical point is, in the input's unit."""
        return self.point.point.sweep_value


@dataclass(frozen=True, slots=True, eq=False)
class Margins:
    """What is known of where stable motions end.

    Attributes
    ----------
    found : tuple of Margin
        Nearest first; of the ends of two mirror images one, where they end together.
    unresolved : tuple of DesignInput
        Inputs along which rounding does not resolve a motion up to its end.
    """

    found: tuple[Margin, ...]
    unresolved: tuple[DesignInput, ...]


def margin(
    device: Device, parameter: DesignInput, point: CriticalPoint, ends: bool, derivatives: dict[DesignInput, Any]
) -> Margin:
    """Measure how far a critical point of one input is from a device's value of it."""
    value = cast(float, getattr(device, parameter))
    distance = point.point.sweep_value - value
    relative = distance / value if abs(distance) < LARGEST_SHARE * value else None
    error = point.point.error_bound + float(np.spacing(abs(distance)))
    return Margin(parameter, point, distance, relative, ends, error, derivatives)


def nearest_first(margins: Iterable[Margin]) -> list[Margin]:
    """Order margins by their relative distance, those without one last; equal ones by their inputs and values."""

    def key(one: Margin) -> tuple[float, int, float]:
        size = abs(one.relative) if one.relative is not None else inf
        return float(f"{size:.12g}"), INPUTS.index(one.parameter), one.sweep_value

    return sorted(margins, key=key)


def margins_of(
    device: Device, motions: Motions, lines: Sequence[Line] = LINES, signs: tuple[float, ...] = (-1.0, 1.0)
) -> Margins:
    """Find where the stable motions of a design point end, in every input and both directions.

    Parameters
    ----------
    device : Device
        All four parameters given.
    motions : Motions
        At the design point.
    lines : sequence of Line
        Along which they are followed.
    signs : tuple of float
        Directions of the position on them.
    """
    found: list[Margin] = []
    unresolved: list[DesignInput] = []
    for end in follow(_paths(device, motions, lines, signs)):
        line = LINES[end.source]
        if end.event is None:
            unresolved += line.value
        elif end.event not in (StrandEvent.START, StrandEvent.END):
            found += _margins_at(device, line, end)
    return Margins(tuple(nearest_first(found)), tuple(dict.fromkeys(unresolved)))


def mirrored(device: Device) -> bool:
    """Whether the motions have mirror images."""
    return bool(device.inclination_deg == 0 and device.period_ratio % 2 == 1)


def _paths(device: Device, motions: Motions, lines: Sequence[Line], signs: tuple[float, ...]) -> Paths:
    """Every stable motion on every line, in the directions in which the line goes on."""
    d, gbar = (float(group) for group in device.groups(Parameter.LENGTH, device.length_m))
    r, reflected = float(device.restitution), mirrored(device)
    rows = []
    for row in np.flatnonzero(motions.stable):
        for line in lines:
            low, high = _extent(line, device, d, gbar)
            flat = reflected and line is not Line.GRAVITY
            if flat and motions.u[row] < 0:
                continue  # the mirror image of another
            symmetric = flat and bool(motions.u[row] == 0)
            start = (motions.u[row], motions.phi_bottom[row], 0.0)
            for sign in signs:
                if (low if sign < 0 else high) != 0:
                    flags = symmetric, flat > symmetric
                    rows.append((*line.rates, low, high, sign, *flags, start, LINES.index(line), False))
    columns = [np.array(column) for column in zip(*rows, strict=True)] or [np.empty((0, 3))] * 10
    return Paths((d, gbar, r), device.period_ratio, *columns)


def reach(device: Device, varied: DesignInput) -> tuple[float, float]:
    """The values of an input between which ends of stable motion are looked for."""
    low, high = varied.limits
    if varied is DesignInput.RESTITUTION:
        high = max(HIGHEST_RESTITUTION, (1 + device.restitution) / 2)
    return low, high


def _extent(line: Line, device: Device, d: float, gbar: float) -> tuple[float, float]:
    """How far motions are followed: until the length is lost in rounding, 0 and 90 degrees, the limits of r."""
    if line is Line.GRAVITY:
        upright = device.capsule_mass_kg * device.gravity_m_s2 / device.amplitude_n
        return (-gbar, upright - gbar if device.inclination_deg != 90 else 0.0) if upright > NO_GRAVITY else (0.0, 0.0)
    if line is Line.RESTITUTION:
        least, most = reach(device, DesignInput.RESTITUTION)
        return least - device.restitution, most - device.restitution
    return float(np.log(device.finest(FINEST_D) / d)), inf


def value_at(device: Device, varied: DesignInput, position: Any, groups: tuple[Any, Any], ops: Any) -> Any:
    """The value of an input that moves a device from its design point to a position on the input's line."""
    value, grown = ops.exact(getattr(device, varied)), 1 + position
    match varied:
        case DesignInput.FREQUENCY:
            return value * ops.sqrt(grown)
        case DesignInput.AMPLITUDE:
            return value / grown
        case DesignInput.INCLINATION:
            return device.value(Parameter.INCLINATION, groups[0], groups[1] + position, ops)
        case DesignInput.RESTITUTION:
            return value + position
        case _:
            return value * grown


@dataclass(frozen=True, slots=True, eq=False)
class LinePoint:
    """A motion on a line that a condition singles out, in decimals: its unknowns, and the motion itself.

    `more` are the condition's further unknowns.
    """

    condition: Condition
    u: Decimal
    phi: Decimal
    position: Decimal
    more: tuple[Decimal, ...]
    orbit: Orbits


def _equations(device: Device, line: Line, condition: Condition, symmetric: bool, ops: Any) -> Equations:
    """What the unknowns (u,) phi, position and those of the condition have to fulfil on a line."""
    d, gbar = device.groups(Parameter.LENGTH, device.length_m, ops)
    along_d, along_gbar, along_r = line.direction(d, gbar)
    restitution, n = ops.exact(device.restitution), device.period_ratio

    def residuals(x: list[Any]) -> list[Any]:
        u, phi, position, *more = [0 * x[0], *x] if symmetric else x
        r = restitution + position * along_r
        orbit = orbits(u, phi, r, n, ops)
        held = [] if symmetric else [orbit.gbar - gbar - position * along_gbar]
        return [orbit.d - d - position * along_d, *held, *condition(orbit, more, r, ops)]

    return residuals


def _polished(device: Device, line: Line, end: Endpoint) -> LinePoint:
    """Solve for the end of a motion on a line; to be called at the precision that is wanted."""
    r = float(device.restitution) + (end.x[2] if line is Line.RESTITUTION else 0.0)
    symmetric, n = end.symmetric, device.period_ratio

    def polished(u: Any, phi: Any, condition: Condition, more: tuple[float, ...]) -> LinePoint:
        guess = [Decimal(v) for v in (*(() if symmetric else (u,)), phi, line.position(float(end.x[2])), *more)]
        exact, double = (_equations(device, line, condition, symmetric, kind) for kind in (DECIMALS, FLOATS))
        relative = {len(guess) - 1} if more else set()
        relative |= {0} if not symmetric and line is not Line.GRAVITY else set()
        x = newton(exact, double, guess, relative)
        u, phi, position, *times = [Decimal(0), *x] if symmetric else x
        known = DECIMALS.exact(device.restitution) + (position if line is Line.RESTITUTION else 0)
        return LinePoint(condition, u, phi, position, tuple(times), orbits(u, phi, known, n, DECIMALS))

    u, phi, _ = map(float, end.x)
    if end.event is StrandEvent.GRAZING:
        near = orbits(np.array([u]), np.array([phi]), r, n)
        return cast(LinePoint, polish_grazing(near, r, n, polished))
    return polished(u, phi, CONDITIONS[cast(StrandEvent, end.event)], ())


def _margins_at(device: Device, line: Line, end: Endpoint) -> list[Margin]:
    """The margins that the end of a motion on a line is in the line's inputs."""
    event = cast(StrandEvent, end.event)
    kind, change = (CriticalKind.PITCHFORK, Change.HANDOVER) if end.pitchfork else (event.kind, event.change)
    family = Symmetry.SYMMETRIC if end.symmetric else Symmetry.ASYMMETRIC
    flat = line is not Line.GRAVITY and bool(device.inclination_deg == 0)
    found = []
    with localcontext() as context:
        context.prec = DIGITS
        groups = device.groups(Parameter.LENGTH, device.length_m, DECIMALS)
        try:
            point = _polished(device, line, end)
        except (NumericalError, ArithmeticError):
            point = None
        normal = None if point is None else _normal(device, line, point, end)
        for varied in line.value:
            if point is None:
                motion = _bracketed(device, line, varied, end)
            else:
                value = value_at(device, varied, point.position, groups, DECIMALS)
                r = float(value) if line is Line.RESTITUTION else float(device.restitution)
                motion = rounded_motion(point.orbit, value, r, device.period_ratio, flat)
            critical = CriticalPoint("", kind, family, motion, None, 0, change)
            derivatives = _derivatives(device, varied, motion, normal)
            if mirrored(device) and line is not Line.GRAVITY:
                # Tilted to either side, a fold of symmetric motions moves alike; other ends come in pairs that part.
                derivatives[DesignInput.INCLINATION] = 0.0 if end.symmetric and kind is CriticalKind.FOLD else None
            found.append(margin(device, varied, critical, True, derivatives))
    return found


def _bracketed(device: Device, line: Line, varied: DesignInput, end: Endpoint) -> PolishedMotion:
    """The end of a motion as it was bracketed, where the polish does not settle."""
    u, phi, followed = map(float, end.x)
    position = line.position(followed)
    d, gbar = device.groups(Parameter.LENGTH, device.length_m)
    r = float(device.restitution) + (position if line is Line.RESTITUTION else 0.0)
    orbit = orbits(u, phi, r, device.period_ratio)
    numbers = {name: float(getattr(orbit, name)) for name in POLISHED_NUMBERS}
    open_ = BRACKET * LONGEST_STEP * (1 + abs(position))
    bounds = {name: open_ * (1 + abs(x)) for name, x in numbers.items()}
    value, *ends = (
        float(value_at(device, varied, position + step, (d, gbar), FLOATS)) for step in (0.0, -open_, open_)
    )
    return singled_out(r, device.period_ratio, numbers, bounds, value, max(abs(other - value) for other in ends))


def _normal(device: Device, line: Line, point: LinePoint, end: Endpoint) -> Floats:
    """Normal, in (d, gbar, r), of the surface on which motions end in this way; NaN where it has none.

    The conditions R(y; d, gbar, r) = 0 of such a motion, y its unknowns, are one more than the unknowns. The vector w
    that w R_y = 0 gives w R_(d, gbar, r), which is orthogonal to every change that leaves the conditions fulfilled: the
    implicit function theorem. The derivatives are exact, by imaginary steps.
    """
    if end.pitchfork:
        return np.full(3, np.nan)
    r = float(device.restitution) + (float(point.position) if line is Line.RESTITUTION else 0.0)
    at = [float(point.u), float(point.phi), *map(float, point.more), r]

    def conditions(x: list[complex]) -> list[complex]:
        orbit = orbits(x[0], x[1], x[-1], device.period_ratio, COMPLEX)
        return [orbit.d, orbit.gbar, *point.condition(orbit, x[2:-1], x[-1], COMPLEX)]

    columns = [
        [v.imag / IMAGINARY for v in conditions([complex(v, IMAGINARY * (i == k)) for i, v in enumerate(at)])]
        for k in range(len(at))
    ]
    gradients = np.array(columns).T
    if not np.isfinite(gradients).all():
        return np.full(3, np.nan)
    scale = np.max(np.abs(gradients), axis=1, keepdims=True)
    own = gradients / np.where(scale == 0, 1.0, scale)
    weight = np.linalg.svd(own[:, :-1])[0][:, -1] / np.where(scale == 0, 1.0, scale)[:, 0]
    return np.array([-weight[0], -weight[1], float(weight @ gradients[:, -1])])


def _derivatives(
    device: Device, varied: DesignInput, motion: PolishedMotion, normal: Floats | None
) -> dict[DesignInput, float | None]:
    """Derivatives of the value of an input at which motion ends, with respect to the others."""
    if normal is None:
        return {other: None for other in DesignInput if other is not varied}
    at = device.with_values({varied: motion.sweep_value})
    slopes = {name: float(normal @ np.array(at.slopes(name, motion.d, motion.gbar))) for name in DesignInput}
    own = slopes.pop(varied)
    derivatives = {name: -slope / own if own else inf for name, slope in slopes.items()}
    return {
        name: derivatives[name] if np.isfinite(derivatives[name]) else None
        for name in DesignInput
        if name is not varied
    }
