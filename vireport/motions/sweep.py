"""One parameter of a device that varies, and what stays constant meanwhile: a level on the surface of motions.

`Sweep` is the parameter with its range; `Level` the condition on d and gbar that holds over the sweep; `SweptPlane` the
plane of q and phase in which that condition is a curve. Where the motions are ordered, they are ordered by the sweep's
coordinate: d, or gbar where the inclination varies, or the restitution that varies.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from functools import cached_property
from typing import Any

import numpy as np
from msgspec import Struct

from vireport.base.errors import UsageError
from vireport.base.records import brief
from vireport.motions.orbits import (
    Coefficients,
    Dynamics,
    Friction,
    Orbits,
    Rubbing,
    coefficients,
    of_order,
    orbits_of,
    rubbing,
    turned,
)
from vireport.physics.device import FINEST_D, FINEST_GBAR, Device, moved, value_in
from vireport.physics.forcing import SINE, Harmonic
from vireport.physics.groups import Groups
from vireport.physics.numbers import ARRAYS
from vireport.scenario.parameters import Parameter

NO_TOLERANCE = 0.0, 0.0
"""The tolerance of an input for which the scenario states none."""

EDGE = 0.5
"""|u| at which one of the two flights has no duration left."""

FINEST_SETTING = 1e-6
"""Width of a range, over its value, below which no device can be set to be in it, where no tolerance is stated."""

FINEST_SHARE = 0.1
"""Least width of a range over the tolerance, where one is stated: of devices that lie anywhere within it, one in 20 is
in the range."""


def settable(start: float, end: float, off: tuple[float, float] = NO_TOLERANCE) -> bool:
    """Whether a range of an input is wide enough for a device to be set into it.

    Parameters
    ----------
    start, end : float
        Of the range, in the unit of the input, in either order.
    off : tuple of float
        The tolerance of the input, in its unit and in per cent of its value, of which the larger holds; zeros where
        none is stated.
    """
    value, (fixed, percent) = max(abs(start), abs(end)), off
    finest = FINEST_SHARE * max(fixed, value * percent / 100) or FINEST_SETTING * value
    return abs(end - start) >= finest


class Held(Enum):
    """The group, or ratio of groups, that a sweep holds constant."""

    GBAR = "gbar"
    """Held in a sweep over the length or the frequency, and in any sweep of a horizontal capsule."""
    RATIO = "d/gbar"
    """Held in a sweep over the force."""
    D = "d"
    """Held in a sweep over the inclination."""
    BOTH = "d and gbar"
    """Held in a sweep over a restitution."""


class Level(Struct, frozen=True, eq=False):
    """The linear condition on (gbar, d) that holds over a sweep, hence a curve on the surface of motions.

    Attributes
    ----------
    held : Held
        The group or ratio that is constant.
    value : array_like
        Its value; where both groups are constant, that of gbar.
    friction : Friction or None
        Friction over the sweep as a function of the groups; None for a ball without friction.
    d : array_like or None
        Its value where both groups are constant, else None.
    varied : Parameter or None
        The restitution that varies where both groups are constant, else None.
    """

    held: Held
    value: Any
    friction: Friction | None = None
    d: Any = None
    varied: Parameter | None = None

    @property
    def horizontal(self) -> bool:
        """Whether gbar is zero over the whole sweep."""
        return self.held in (Held.GBAR, Held.BOTH) and bool(self.value == 0)

    @property
    def holds_d(self) -> bool:
        """Whether d is constant over the sweep."""
        return self.held in (Held.D, Held.BOTH)

    def symmetric(self, r: Any, harmonics: Sequence[Harmonic]) -> bool:
        """Whether the device and its mirror image are the same over the whole sweep.

        Parameters
        ----------
        r : array_like or Restitutions
            Of the device; one of it may vary.
        harmonics : sequence of Harmonic
            Of the force.
        """
        kept = self.varied is None or self.varied.keeps_symmetry
        return self.horizontal and kept and Groups(0.0, 0.0, r, tuple(harmonics)).symmetric

    def restitution(self, r: Any, coordinate: Any) -> Any:
        """The restitution at a value of the sweep's coordinate, from that of the device."""
        return r if self.varied is None else moved(r, self.varied, coordinate)

    def groups(self, orbit: Any) -> tuple[Any, Any]:
        """D and gbar of motions on the level, as arrays; a group that the sweep holds has its exact value."""
        # The closed form rounds the group that the sweep holds. Its value is known exactly, and what is derived from it
        # (the unit of velocity, the sweep's value) should not differ from motion to motion.
        d, gbar = np.array(orbit.d, dtype=float), np.array(orbit.gbar, dtype=float)
        if self.held is Held.D:
            d[:] = self.value
        elif self.held is not Held.RATIO:
            gbar[:] = self.value
        if self.d is not None:
            d[:] = self.d
        return d, gbar


class SweptPlane(Struct, frozen=True, eq=False, dict=True):
    """The plane of q and phase with the level of a sweep: above each place there is one 1:1 motion.

    The height of a place is how far the motion there is from the level; the motions of the sweep are where it is zero.

    Attributes
    ----------
    level : Level
    r : array_like or Restitutions
        Restitution of the device, 0 <= r < 1; one of both may vary.
    n : int
        Forcing periods per motion.
    harmonics : tuple of Harmonic
        Of the force.
    """

    level: Level
    r: Any
    n: int
    harmonics: tuple[Harmonic, ...] = ()

    @cached_property
    def mirrors(self) -> bool:
        """Whether motions have mirror images: horizontal capsule, membranes that are alike, odd n, odd harmonics."""
        return self.n % 2 == 1 and self.level.symmetric(self.r, self.harmonics)

    def orbits(self, u: Any, phi: Any, ops: Any = ARRAYS) -> Orbits:
        """Evaluate the motions at places of the plane."""
        return orbits_of(self.dynamics, u, phi, ops)

    @property
    def dynamics(self) -> Dynamics:
        """What the motions depend on besides d and gbar."""
        return Dynamics(self.r, self.n, self.harmonics, self.level.friction)

    def value(self, u: Any, phi: Any, ops: Any = ARRAYS) -> Any:
        """The height above the level at places of one shape."""
        a, b, c = self.terms(coefficients(u, self.r, self.n, ops), u, ops)
        return a * ops.sin(phi) + b * ops.cos(phi) - c

    def slopes(self, u: Any, phi: Any, step: Any) -> tuple[Any, Any]:
        """Derivatives of the height by u, as a central difference over `step`, and by the phase, exact."""
        a, b, _ = self.terms(coefficients(u, self.r, self.n), u)
        by_u = (self.value(u + step, phi) - self.value(u - step, phi)) / (2 * step)
        return by_u, a * np.cos(phi) - b * np.sin(phi)

    def terms(self, k: Coefficients, u: Any, ops: Any = ARRAYS) -> tuple[Any, Any, Any]:
        """Write the level of a sine as a sin(phi) + b cos(phi) = c at each q, and return (a, b, c).

        Parameters
        ----------
        k : Coefficients
            Of the surface at the same u.
        u : array_like
            q - 1/2 [-].
        ops
            Functions of the kind of number.

        Notes
        -----
        Where motions have mirror images (`mirrors`), the factor u is divided out: its zero, u = 0, is the whole
        symmetric family, which would hide the asymmetric one that crosses it.
        """
        a, b, c = _divided_terms(u, self.r, self.n, ops) if self.mirrors else _terms(self.level, k)
        if (rubbed := _Rubbed.of(self, k, u, ops)) is None:
            return a, b, c
        return rubbed.term(a, k.gbar_sine, k.d_sine), rubbed.term(b, k.gbar_cosine, k.d_cosine), rubbed.held(c)

    def polynomial(self, u: Any, ops: Any = ARRAYS) -> Polynomial:
        """Write the level of a force with harmonics as sum_j a_j sin(j phi) + b_j cos(j phi) = c at each q.

        As in `terms`, u is divided out where motions have mirror images.
        """
        # The equations are linear in the force, so that a harmonic of order j contributes the level of a sine of j n
        # periods; c is the same for all of them, and taken once.
        divided, parts, held, rubbed = self.mirrors, [], None, None
        if self.level.friction is not None:
            rubbed = _Rubbed.of(self, coefficients(u, self.r, self.n, ops), u, ops)
        for harmonic in (SINE, *self.harmonics):
            periods = harmonic.order * self.n
            if divided:
                # T/(pi K), which goes with u, is 1/j of the sine's in the surface of a harmonic.
                a, b, c = (term / harmonic.order for term in _divided_terms(u, self.r, periods, ops))
            else:
                a, b, c = _terms(self.level, of_order(coefficients(u, self.r, periods, ops), harmonic.order))
            if rubbed is not None:
                k = of_order(coefficients(u, self.r, periods, ops), harmonic.order)
                a, b = rubbed.term(a, k.gbar_sine, k.d_sine), rubbed.term(b, k.gbar_cosine, k.d_cosine)
                c = rubbed.held(c)
            held = c if held is None else held
            parts.append((harmonic.order, *turned(a, b, harmonic)))
        return parts, held


def _divided_terms(u: Any, r: Any, n: int, ops: Any) -> tuple[Any, Any, Any]:
    """The terms a, b, c of a horizontal capsule with mirror images, divided by u T/(pi K)."""
    p = (1 + r) * u - (1 - r) / 2
    a = 2 * ops.pi * n * ops.sinc(n * u) * ops.sin(ops.pi * n * u) * p - 2 * (1 + r)
    return a, -2 * ops.pi * n * ops.sinc(2 * n * u) * p, 0 * u


def _terms(level: Level, k: Coefficients) -> tuple[Any, Any, Any]:
    """The terms a, b, c of the level without friction, from the coefficients of gbar and d."""
    zero = 0 * k.determinant
    if level.held is Held.GBAR:
        return k.gbar_sine, k.gbar_cosine, zero + level.value
    if level.held is Held.RATIO:
        return k.d_sine - level.value * k.gbar_sine, k.d_cosine - level.value * k.gbar_cosine, zero
    return k.d_sine, k.d_cosine, zero + level.value


class _Rubbed(Struct, frozen=True, eq=False):
    """Terms that friction adds to the level at each q.

    Notes
    -----
    With G, D of `rubbing` and g, h what gbar and d are without friction, f = c + a gbar + b d has gbar = g + f G and
    d = h + f D. A sweep over length or frequency holds gbar, of a constant f: g = gbar - f G. One over the force holds
    d/gbar = L, with f = a gbar: times 1 - a G, which takes the pole of f, it is h - L g + a (D g - G h) = 0. Of a
    horizontal capsule it holds gbar = 0 with f = b d: times 1 - b D, it is g + b (G h - D g) = 0.
    """

    level: Level
    friction: Friction
    rubbing: Rubbing
    share: Any
    """G, divided as g is."""

    @staticmethod
    def of(plane: SweptPlane, k: Coefficients, u: Any, ops: Any) -> _Rubbed | None:
        """The terms of a level with friction; None without. `k` are the coefficients of the sine at u."""
        level, r, n = plane.level, plane.r, plane.n
        if level.friction is None:
            return None
        terms = rubbing(k, u, r, n)
        # `_divided_terms` divides by u T/(pi K); so divided, G is this constant where both membranes have one r.
        share = 2 * n * ops.pi * (1 + r * r) / (1 + r) if plane.mirrors else terms.gbar
        return _Rubbed(level, level.friction, terms, share)

    def term(self, a: Any, gbar: Any, d: Any) -> Any:
        """The coefficient a of the sine (or cosine) with friction, from that of the level, of gbar and of d without."""
        if self.level.held is Held.RATIO:
            return a + self.friction.by_gbar * (self.rubbing.d * gbar - self.rubbing.gbar * d)
        if type(self.friction.by_d) is int:
            return a
        return a + self.friction.by_d * (self.share * d - self.rubbing.d * a)

    def held(self, c: Any) -> Any:
        """The right-hand side c of the level with friction, from that without."""
        return c - self.friction.constant * self.share


Polynomial = tuple[list[tuple[int, Any, Any]], Any]
"""The level above one q as a trigonometric polynomial in the phase: (order, a, b) of each term, and the value c."""


def level_value(polynomial: Polynomial, phi: Any, ops: Any = ARRAYS) -> Any:
    """Height of a phase above the level: sum_j a_j sin(j phi) + b_j cos(j phi) - c."""
    parts, held = polynomial
    return sum((a * ops.sin(j * phi) + b * ops.cos(j * phi) for j, a, b in parts), -held)


def level_slope(polynomial: Polynomial, phi: Any) -> Any:
    """Derivative of `level_value` by the phase."""
    parts, _ = polynomial
    return sum(j * (a * ARRAYS.cos(j * phi) - b * ARRAYS.sin(j * phi)) for j, a, b in parts)


def level_residual(level: Level, orbit: Orbits) -> Any:
    """Difference of a motion from the level of one group: gbar, d - ratio gbar, or d less the value held."""
    if level.held is Held.GBAR:
        return orbit.gbar - level.value
    if level.held is Held.RATIO:
        return orbit.d - level.value * orbit.gbar
    return orbit.d - level.value


class Sweep(Struct, frozen=True):
    """A range of one parameter of a device, all other parameters constant.

    Attributes
    ----------
    device : Device
        Its value of the parameter is not used.
    parameter : Parameter
        The one that varies.
    start, end : float
        Range that is swept, in the parameter's unit, in either order.
    off : tuple of float
        The tolerance of the parameter, in its unit and in per cent; zeros where none is stated.
    """

    device: Device
    parameter: Parameter
    start: float
    end: float
    off: tuple[float, float] = NO_TOLERANCE

    __repr__ = brief

    @property
    def level(self) -> Level:
        """The level of the surface of motions that the sweep holds."""
        level = self.level_in(ARRAYS)
        friction = None if level.friction is None else level.friction.map_numbers(float)
        return Level(
            level.held, float(level.value), friction, level.d if level.d is None else float(level.d), level.varied
        )

    def level_in(self, ops: Any) -> Level:
        """The level of the sweep in a kind of number.

        Raises
        ------
        UsageError
            If the inclination varies and the ball has friction: then no combination of the groups is constant.
        """
        # Over the force both groups are largest, and best resolved, at its lower end.
        at = min(self.start, self.end) if self.parameter is Parameter.AMPLITUDE else self.start
        d, gbar, *_, rubbed = self.device.groups(self.parameter, at, ops)
        if self.parameter.bounces:
            return Level(Held.BOTH, gbar, None if rubbed is None else Friction(rubbed), d, self.parameter)
        if self.parameter is Parameter.INCLINATION:
            if rubbed is not None:
                raise UsageError("of a ball with friction motions along a sweep of the inclination are not known")
            return Level(Held.D, d)
        # Both groups go with 1/F, so that the force leaves their ratio; in a horizontal capsule gbar = 0, and that is
        # what it leaves.
        if self.parameter is Parameter.AMPLITUDE and gbar != 0:
            return Level(Held.RATIO, d / gbar, None if rubbed is None else Friction(0, rubbed / gbar))
        friction = None
        if rubbed is not None:
            friction = Friction(0, 0, rubbed / d) if self.parameter is Parameter.AMPLITUDE else Friction(rubbed)
        return Level(Held.GBAR, gbar, friction)

    def driven(self, what: str) -> Sweep:
        """The sweep itself, if its membranes stay as they are.

        Parameters
        ----------
        what : str
            What requires that, for the message.

        Raises
        ------
        UsageError
            If it is one over a restitution.
        """
        if self.parameter.bounces:
            allowed = "allowed: length_m, amplitude_n, frequency_hz or inclination_deg"
            raise UsageError(f"along a sweep of {self.parameter} {what} is not known ({allowed})")
        return self

    @property
    def coordinate_range(self) -> tuple[float, float]:
        """Range of the coordinate that orders the sweep, see `coordinate_of`, ascending."""
        ends = self.coordinate_of(self.start), self.coordinate_of(self.end)
        return min(ends), max(ends)

    @property
    def unresolved(self) -> str:
        """Reason why double precision does not resolve the sweep, as a sentence; "" if it does."""
        device, (least, most) = self.device, sorted((self.start, self.end))
        if self.parameter.bounces:
            return device.with_values({self.parameter: most}).unresolved
        over_gbar = self.parameter is Parameter.INCLINATION
        if over_gbar:
            reason = device.too_short(self.parameter, most)
        else:  # d and gbar are largest at the least force, d at the largest length and frequency
            at = self.parameter, least if self.parameter is Parameter.AMPLITUDE else most
            reason = device.too_short(*at) or device.too_light(*at)
        low, high = self.coordinate_range
        finest = device.finest(FINEST_GBAR if over_gbar else FINEST_D)
        if not reason and high - low < finest:
            name = f"gbar = {device.weighed} g sin(beta)/F" if over_gbar else "d = s/x_c"
            reason = (
                f"over the sweep {name} only varies from {low:.6g} to {high:.6g}, which rounding does not resolve "
                f"(allowed: a range of at least {finest:.3g})"
            )
        return reason

    def coordinate_of(self, value: Any, ops: Any = ARRAYS) -> Any:
        """The coordinate at a value of the parameter: d, gbar where the inclination varies, or a restitution itself."""
        if self.parameter.bounces:
            return ops.exact(value)
        d, gbar, *_ = self.device.groups(self.parameter, value, ops)
        return gbar if self.parameter is Parameter.INCLINATION else d

    def coordinate(self, orbit: Any) -> Any:
        """The coordinate of motions on the level."""
        if self.parameter.bounces:
            return value_in(orbit.restitution, self.parameter)
        return orbit.gbar if self.parameter is Parameter.INCLINATION else orbit.d

    def value(self, coordinate: Any, ops: Any = ARRAYS) -> Any:
        """The parameter at a value of the coordinate; see `Device.value`."""
        if self.parameter.bounces:
            return coordinate
        return self.device.value(self.parameter, coordinate, coordinate, ops)
