"""The plane of q and phase in which the level of a sweep is a curve: the height of each place above the level.

In a `SweptPlane`, for a force that is a sine, the level has two phases above each q, in closed form; in a
`ContourPlane`, for a force with harmonics, `contour` follows the level.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

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
from vireport.motions.sweep import Held, Level
from vireport.physics.forcing import SINE, Harmonic
from vireport.physics.numbers import ARRAYS, IMAGINARY_STEP, Arithmetic, ContinuousFunctions, Functions

Floats = NDArray[np.float64]

EDGE = 0.5
"""|u| at which the duration of one of the two flights is zero."""


class SweptPlane(Struct, frozen=True, eq=False, dict=True):
    """The plane of q and phase with the level of a sweep: above each place there is one 1:1 motion.

    The height of a place is how far the motion there is from the level; the motions of the sweep are where it is zero.

    Attributes
    ----------
    level : Level
    r : array_like or Restitutions
        Restitution of the device, 0 <= r < 1; it may be the one that varies.
    n : int
        Forcing periods per motion.
    harmonics : tuple of Harmonic
        Harmonics of the force.
    """

    level: Level
    r: Any
    n: int
    harmonics: tuple[Harmonic, ...] = ()

    @cached_property
    def mirrors(self) -> bool:
        """Whether motions have mirror images: horizontal capsule, membranes that are alike, odd n, odd harmonics."""
        return self.n % 2 == 1 and self.level.symmetric(self.r, self.harmonics)

    def orbits(self, u: Arithmetic, phi: Arithmetic, ops: ContinuousFunctions = ARRAYS) -> Orbits:
        """Evaluate the motions at places of the plane."""
        return orbits_of(self.dynamics, u, phi, ops)

    @property
    def dynamics(self) -> Dynamics:
        """Restitution, period, harmonics and friction, on which the motions depend besides d and gbar."""
        return Dynamics(self.r, self.n, self.harmonics, self.level.friction)

    def value(self, u: Arithmetic, phi: Arithmetic, ops: ContinuousFunctions = ARRAYS) -> Any:
        """The height above the level at places of one shape."""
        a, b, c = self.terms(coefficients(u, self.r, self.n, ops), u, ops)
        return a * ops.sin(phi) + b * ops.cos(phi) - c

    def slopes(self, u: Arithmetic, phi: Any, step: Arithmetic) -> tuple[Any, Any]:
        """Derivatives of the height by u, as a central difference over `step`, and by the phase, exact."""
        a, b, _ = self.terms(coefficients(u, self.r, self.n), u)
        by_u = (self.value(u + step, phi) - self.value(u - step, phi)) / (2 * step)
        return by_u, a * np.cos(phi) - b * np.sin(phi)

    def terms(self, k: Coefficients, u: Arithmetic, ops: ContinuousFunctions = ARRAYS) -> tuple[Any, Any, Any]:
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

    def polynomial(self, u: Arithmetic, ops: ContinuousFunctions = ARRAYS) -> Polynomial:
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


def _divided_terms(u: Arithmetic, r: Any, n: int, ops: ContinuousFunctions) -> tuple[Any, Any, Any]:
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
    """The terms a, b, c of the level at each q, completed by friction.

    Notes
    -----
    With G, D of `rubbing` and g, h what gbar and d are without friction, f = c + a gbar + b d has gbar = g + f G and
    d = h + f D. A sweep over length or frequency holds gbar and f: g = gbar - f G. A sweep over the force holds
    d/gbar = L, with f = a gbar: times 1 - a G, which removes the pole of f, h - L g + a (D g - G h) = 0. With a
    horizontal capsule it holds gbar = 0, with f = b d: times 1 - b D, g + b (G h - D g) = 0.
    """

    level: Level
    friction: Friction
    rubbing: Rubbing
    share: Any
    """G, divided by the same factor as g."""

    @staticmethod
    def of(plane: SweptPlane, k: Coefficients, u: Arithmetic, ops: Functions) -> _Rubbed | None:
        """The terms of a level with friction, from the coefficients `k` of the sine at u; None without friction."""
        level, r, n = plane.level, plane.r, plane.n
        if level.friction is None:
            return None
        terms = rubbing(k, u, r, n)
        # `_divided_terms` divides by u T/(pi K); so divided, G is this constant where both membranes have one r.
        share = 2 * n * ops.pi * (1 + r * r) / (1 + r) if plane.mirrors else terms.gbar
        return _Rubbed(level, level.friction, terms, share)

    def term(self, a: Arithmetic, gbar: Arithmetic, d: Arithmetic) -> Any:
        """The coefficient of the sine or cosine with friction, from the level's `a` and those of gbar and d without."""
        if self.level.held is Held.RATIO:
            return a + self.friction.by_gbar * (self.rubbing.d * gbar - self.rubbing.gbar * d)
        if type(self.friction.by_d) is int:
            return a
        return a + self.friction.by_d * (self.share * d - self.rubbing.d * a)

    def held(self, c: Arithmetic) -> Any:
        """The right-hand side c of the level with friction, from the one without."""
        return c - self.friction.constant * self.share


Polynomial = tuple[list[tuple[int, Any, Any]], Any]
"""The level above one q as a trigonometric polynomial in the phase: (order, a, b) of each term, and the value c."""


def level_value(polynomial: Polynomial, phi: Arithmetic, ops: Functions = ARRAYS) -> Any:
    """Height of a phase above the level: sum_j a_j sin(j phi) + b_j cos(j phi) - c."""
    parts, held = polynomial
    return sum((a * ops.sin(j * phi) + b * ops.cos(j * phi) for j, a, b in parts), -held)


def level_slope(polynomial: Polynomial, phi: Arithmetic) -> Any:
    """Derivative of `level_value` by the phase."""
    parts, _ = polynomial
    return sum(j * (a * ARRAYS.cos(j * phi) - b * ARRAYS.sin(j * phi)) for j, a, b in parts)


class ContourPlane(SweptPlane, frozen=True, eq=False):
    """The plane of q and phase for a force with harmonics, whose level `contour` follows; `Bounces` is one, too."""

    @property
    def order(self) -> int:
        """Highest order of the phase in the level."""
        return max((harmonic.order for harmonic in self.harmonics), default=1)

    @property
    def sharp(self) -> bool:
        """Whether the level may have features of any size next to q = 1/2, as for a nearly horizontal capsule."""
        return True

    @property
    def unresolved(self) -> str:
        """Message for the user of a sweep whose level cannot be followed."""
        return (
            "the motions of this force with harmonics are not resolved next to the largest gravity at which there are "
            "any (change excitation.harmonics or inclination_deg by a per mille)"
        )

    def within(self, u: Floats, phi: Floats) -> tuple[Floats, float]:
        """A function on the level that is positive where motions are, and the value below which none are near.

        1 everywhere, where motions may be on all parts of the level.
        """
        return np.ones(len(u)), 0.0

    def value(self, u: Arithmetic, phi: Arithmetic, ops: ContinuousFunctions = ARRAYS) -> Any:
        """The height above the level at places of one shape."""
        return level_value(self.polynomial(u, ops), phi, ops)

    def slopes(self, u: Arithmetic, phi: Arithmetic, step: Arithmetic) -> tuple[Any, Any]:
        """Derivatives of the height by u, as a central difference over step/`order`, and by the phase, exact."""
        # The steps are those of a sine; a harmonic of order j varies j times as fast with u.
        step = step / self.order
        by_u = (self.value(u + step, phi) - self.value(u - step, phi)) / (2 * step)
        return by_u, self.gradient(u, phi)[2]

    def on_grid(self, u: Floats, phi: Floats) -> Floats:
        """The height above the level at all pairs of a u and a phase, shape (len(u), len(phi))."""
        parts, held = self.polynomial(u)
        waves = ((a[:, None] * np.sin(j * phi) + b[:, None] * np.cos(j * phi)) for j, a, b in parts)
        return np.asarray(sum(waves, -np.asarray(held)[:, None]))

    def gradient(self, u: Arithmetic, phi: Arithmetic) -> tuple[Floats, Floats, Floats]:
        """The height and its derivatives by u and by the phase."""
        polynomial = self.polynomial(u + 1j * IMAGINARY_STEP)
        value = level_value(polynomial, phi)
        return value.real, value.imag / IMAGINARY_STEP, np.real(level_slope(polynomial, phi))
