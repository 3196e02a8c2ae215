"""The scalar function of q whose zeros are the 1:1 motions of a design point.

Given q, the equations (3.9)-(3.11) are linear in the velocity, sin(phi) and cos(phi). Cramer's rule gives the latter
two as (gbar a + d b)/Delta with functions a, b and Delta of q alone, and a motion is a zero of the scalar function
G(u) = |gbar a + d b|^2 - Delta^2, u = q - 1/2. The functions are entire for every restitution, unlike the coefficients
of the surface in `orbits`, which have poles next to the real line; so one grid of u, made once, serves all design
points.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

SAMPLES = 96
"""Regular samples of G for each forcing period of the motion; its shortest wavelength has half of them."""

PER_DECADE = 8
"""Samples of each decade of |u| next to the symmetric motion: G varies there with the logarithm of u."""

STEP = 1e-30
"""Imaginary step that gives the derivative of an analytic function to the last digit."""


@dataclass(frozen=True, slots=True, eq=False)
class Forms:
    """The functions of u in sin(phi) = (gbar sine_gbar + d sine_d)/delta, and likewise for the cosine.

    Attributes
    ----------
    sine_gbar, sine_d, cosine_gbar, cosine_d : array_like
    delta : array_like
    """

    sine_gbar: Any
    sine_d: Any
    cosine_gbar: Any
    cosine_d: Any
    delta: Any


def forms(u: Any, r: Any, n: int, divided: bool = False) -> Forms:
    """Solve (3.9)-(3.11) for the phase at given q = 1/2 + u, gbar and d.

    Parameters
    ----------
    u : array_like
        q - 1/2; complex where a derivative is wanted.
    r : array_like
        Restitution coefficient, 0 <= r < 1.
    n : int
        Forcing periods per motion.
    divided : bool
        For a horizontal capsule and odd n: all but the coefficients of gbar are divided by u, whose zero is the
        symmetric family.

    Notes
    -----
    With p = (1+r) u - (1-r)/2 and m = Tu Td/(2T), subtracting multiples of the rows leaves
    Delta = 2 (1+r) [m sin(a)/pi - u (cos(a) - 1)/pi^2]. Everything that vanishes with u does so without cancellation.
    """
    pi, period = np.pi, 2 * n
    half = pi * n * u
    sin_half, cos_half = np.sin(half), np.cos(half)
    over_u = pi * n * np.sinc(n * u) if divided else sin_half
    versine, sin_theta = 2 * sin_half * over_u, 2 * over_u * cos_half
    one = np.ones_like(u) if divided else u
    p = (1 + r) * u - (1 - r) / 2
    reach = period * (1 - 4 * u * u) / 8
    if n % 2:
        sin_a, cosine_d = -sin_theta, versine * p - 2 * (1 + r) * one
        delta = 2 * (1 + r) * (one * (2 * cos_half * cos_half) / (pi * pi) + reach * sin_a / pi)
        cos_a_less_one = -2 * cos_half * cos_half
    else:
        sin_a, cosine_d = sin_theta, -versine * p - (1 - r)
        delta = 2 * (1 + r) * (u * versine / (pi * pi) + reach * sin_a / pi)
        cos_a_less_one = -versine
    sine_d = -p * sin_a
    if divided:
        nothing = np.zeros_like(u)
        return Forms(nothing, sine_d, nothing, cosine_d, delta)
    kappa = (1 + r) * u * u + (1 - r) * (1 - r) / (4 * (1 + r))
    sine_gbar = period * (pi * u * delta - p * (cos_a_less_one * (p / (1 + r) - 2 * u) / pi + sin_a * reach))
    inner = 2 * (1 + r) * u + cos_a_less_one * ((1 + r) * u + (1 - r) / 2)
    return Forms(sine_gbar, sine_d, -period * (reach * inner + sin_a * kappa / pi), cosine_d, delta)


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Samples of u on which no zero of G is missed.

    Attributes
    ----------
    u : ndarray
        Ascending samples of q - 1/2.
    n : int
        Forcing periods per motion.
    divided : bool
        Whether the symmetric family is divided out, see `forms`.
    """

    u: Floats
    n: int
    divided: bool


def grid_of(n: int, smallest: float | None) -> Grid:
    """Choose the samples.

    Parameters
    ----------
    n : int
        Forcing periods per motion.
    smallest : float or None
        Of |u| at which a zero can be expected next to u = 0; None for a horizontal capsule with odd n, where the
        symmetric family is divided out and nothing else happens there.
    """
    even = np.linspace(-0.5, 0.5, 2 * (SAMPLES * n // 2) + 1)
    spacing = float(even[1] - even[0])
    near_edge = 0.5 - spacing * 10.0 ** np.arange(-4, 0, 0.5)
    first = np.floor(np.log10(spacing if smallest is None else smallest))
    decades = 10.0 ** np.arange(first, np.log10(PER_DECADE * spacing), 1 / PER_DECADE)
    u = np.sort(np.concatenate([even, decades, -decades, near_edge, -near_edge]))
    # Not np.unique, which imports numpy.ma: longer than all else that a design point takes.
    return Grid(u[np.append(True, u[1:] > u[:-1])], n, smallest is None)


@dataclass(frozen=True, slots=True, eq=False)
class Tables:
    """G = gbar^2 A + gbar d B + d^2 C - D on a grid, for one restitution.

    Attributes
    ----------
    values, slopes : ndarray, shape (4, len(grid.u))
        A, B, C, D and their derivatives.
    """

    values: Floats
    slopes: Floats


def tables_of(grid: Grid, r: float) -> Tables:
    """Tabulate what all design points of one restitution share."""
    f = forms(grid.u + 1j * STEP, r, grid.n, grid.divided)
    cross = 2 * (f.sine_gbar * f.sine_d + f.cosine_gbar * f.cosine_d)
    squares = [f.sine_gbar**2 + f.cosine_gbar**2, cross, f.sine_d**2 + f.cosine_d**2, f.delta**2]
    terms = np.stack(squares)
    return Tables(terms.real.copy(), terms.imag / STEP)


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Design points on one grid.

    Attributes
    ----------
    grid : Grid
    d, gbar, r : ndarray
        Of each.
    tables : Tables or None
        Where they have one restitution.
    """

    grid: Grid
    d: Floats
    gbar: Floats
    r: Floats
    tables: Tables | None = None

    def on_grid(self, part: slice) -> tuple[Floats, Floats]:
        """G and its slope on the whole grid, of some of the points."""
        d, gbar = self.d[part], self.gbar[part]
        if self.tables is None:
            f = _squared(forms(self.grid.u + 1j * STEP, self.r[part, None], self.grid.n, self.grid.divided), d, gbar)
            return f.real, f.imag / STEP
        # Not by a matrix product: its last bits may depend on the number of threads, and the results with them.
        factors = np.stack([gbar * gbar, gbar * d, d * d, np.full(len(d), -1.0)])
        values: Floats = np.einsum("ki,kj->ij", factors, self.tables.values)
        slopes: Floats = np.einsum("ki,kj->ij", factors, self.tables.slopes)
        return values, slopes

    def value(self, which: Ints, u: Any) -> tuple[Any, Any, Any, Any]:
        """G, the two numerators and the denominator, at one u for each of the points `which`."""
        f = forms(u, self.r[which], self.grid.n, self.grid.divided)
        d, gbar = self.d[which], self.gbar[which]
        sine, cosine = d * f.sine_d, d * f.cosine_d
        if not self.grid.divided:
            sine, cosine = gbar * f.sine_gbar + sine, gbar * f.cosine_gbar + cosine
        return sine * sine + cosine * cosine - f.delta * f.delta, sine, cosine, f.delta


def _squared(f: Forms, d: Floats, gbar: Floats) -> Any:
    sine = gbar[:, None] * f.sine_gbar + d[:, None] * f.sine_d
    cosine = gbar[:, None] * f.cosine_gbar + d[:, None] * f.cosine_d
    return sine * sine + cosine * cosine - f.delta * f.delta
