"""Affine arithmetic on arrays: numbers that stay within proven bounds and remember what they depend on.

A number is c + sum_i l_i s_i + e with symbols s_i between -1 and 1, which all numbers share, and |e| <= radius. Where
quantities depend on the same inputs, the linear parts cancel as they should: an enclosure exceeds the range by terms of
second order in the width of the box, and an enclosure by interval arithmetic by terms of first order (de Figueiredo and
Stolfi, Numerical Algorithms 37, 2004). Every operation works on thousands of boxes at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.physics.numbers import Arithmetic, MethodOps

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

AFFINE_ROUNDING = 2.0**-48
"""Share of the size of its terms by which an operation's radius grows: 32 times the unit roundoff. No operation here
has more than twenty roundings in a row, and NumPy's sines and cosines are good to two units in the last place."""

NEAR_ZERO = 0.01
"""Argument up to which the derivative of sinc is summed as a series: beyond, its error is below 100 unit roundoffs."""

UNDERFLOW = 1e-290
"""Added to every radius, for products that underflow."""


class Affine:
    """A number in affine arithmetic, for each of k boxes.

    Parameters
    ----------
    centre : ndarray, shape (k,)
    linear : ndarray, shape (symbols, k)
        Coefficients of the symbols.
    radius : ndarray, shape (k,)
        Bound of the remainder, roundings included; infinite or NaN where an operation was not defined.
    spread : ndarray, shape (k,), optional
        Sum of the sizes of the coefficients, where the caller has it.
    """

    __slots__ = ("centre", "linear", "radius", "spread")
    __array_ufunc__ = None  # so that NumPy's numbers leave operations to this class

    def __init__(self, centre: Floats, linear: Floats, radius: Floats, spread: Floats | None = None) -> None:
        self.centre, self.linear, self.radius = centre, linear, radius
        self.spread: Floats = np.abs(linear).sum(axis=0) if spread is None else spread

    @property
    def reach(self) -> Floats:
        """Largest distance from the centre."""
        return np.asarray(self.spread + self.radius)

    @property
    def lower(self) -> Floats:
        """A lower bound of the number."""
        return np.asarray(self.centre - self.reach - AFFINE_ROUNDING * (np.abs(self.centre) + self.reach))

    @property
    def upper(self) -> Floats:
        """An upper bound of the number."""
        return np.asarray(self.centre + self.reach + AFFINE_ROUNDING * (np.abs(self.centre) + self.reach))

    def __getitem__(self, index: Any) -> Affine:
        """The numbers of some of the boxes."""
        rows = np.arange(len(self.centre))[index]
        return Affine(self.centre[rows], self.linear.take(rows, axis=1), self.radius[rows], self.spread[rows])

    def __neg__(self) -> Affine:
        return Affine(-self.centre, -self.linear, self.radius, self.spread)

    def __add__(self, other: Affine | float | Floats) -> Affine:
        if isinstance(other, Affine):
            return _rounded(self.centre + other.centre, self.linear + other.linear, self.radius + other.radius)
        return _rounded(self.centre + other, self.linear, self.radius)

    def __sub__(self, other: Affine | float | Floats) -> Affine:
        return self + -other

    def __rsub__(self, other: float | Floats) -> Affine:
        return -self + other

    def __mul__(self, other: Affine | float | Floats) -> Affine:
        if not isinstance(other, Affine):
            return _rounded(self.centre * other, self.linear * other, self.radius * np.abs(other))
        a, b = np.abs(self.centre) + self.spread, np.abs(other.centre) + other.spread
        # s_i^2 is between 0 and 1: its middle, 1/2, is added to the centre, and only the other half to the radius.
        squares = self.linear * other.linear / 2
        return _rounded(
            self.centre * other.centre + squares.sum(axis=0),
            self.centre * other.linear + other.centre * self.linear,
            self.spread * other.spread
            - np.abs(squares).sum(axis=0)
            + a * other.radius
            + (b + other.radius) * self.radius,
            a * b,
        )

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other: Affine | float | Floats) -> Affine:
        return self * (other if isinstance(other, Affine) else _exact(other)).inverse()

    def __rtruediv__(self, other: float) -> Affine:
        return self.inverse() * other

    def __pow__(self, power: int) -> Affine:
        # By squares: `__mul__` uses that the squares of symbols are not negative.
        half = self ** (power // 2) if power > 1 else None
        return self if half is None else half * half if power % 2 == 0 else half * half * self

    def inverse(self) -> Affine:
        """The reciprocal, 1/x = 1/c - delta/c^2 + delta^2/(c^2 x), the last term of which has the sign of c."""
        # The last term is between 0 and delta^2/[c^2 (|c| - reach)]: half of that is added to the centre, and half to
        # the radius. Where zero is among the numbers there is no bound.
        size, reach = np.abs(self.centre), self.reach * (1 + AFFINE_ROUNDING)
        slope = -1 / (self.centre * self.centre)
        rest = np.where(size > reach, -slope * reach * reach / (2 * (size - reach)), np.inf)
        return _rounded(
            1 / self.centre + np.sign(self.centre) * rest,
            slope * self.linear,
            -slope * self.radius + rest,
            1 / size,
        )

    def sin(self) -> Affine:
        """Sine of affine numbers [rad]."""
        return self._wave(np.sin(self.centre), np.cos(self.centre))

    def cos(self) -> Affine:
        """Cosine of affine numbers [rad]."""
        return self._wave(np.cos(self.centre), -np.sin(self.centre))

    def sinc(self) -> Affine:
        """sin(pi x)/(pi x), to first order, with the bound pi^2/3 of the second derivative."""
        reach, value, c = self.reach, np.sinc(self.centre), self.centre
        # [cos(pi c) - sinc(c)]/c loses its digits next to c = 0, where the series -pi^2 c/3 [1 - (pi c)^2/10 ...] does
        # not.
        square, far = (np.pi * c) ** 2, np.where(np.abs(c) > NEAR_ZERO, c, 1.0)
        series = -(np.pi**2) * c / 3 * (1 - square / 10 * (1 - square / 28))
        slope = np.where(np.abs(c) > NEAR_ZERO, (np.cos(np.pi * c) - value) / far, series)
        rest = np.pi**2 / 6 * reach * reach
        return _rounded(value, slope * self.linear, np.abs(slope) * self.radius + rest, 1 + reach / NEAR_ZERO)

    def _wave(self, value: Floats, slope: Floats) -> Affine:
        """Sine or cosine, to second order in the distance from the centre, with the bound 1/6 of the third."""
        # sin(c + delta) = v + s delta - v delta^2/2 + ..., with delta^2 between 0 and reach^2: v reach^2/4 less for the
        # centre and as much for the radius, to which reach^3/6 of the third order is added.
        reach = self.reach
        square = reach * reach / 4
        rest = np.abs(value) * square + reach * square * (2 / 3)
        return _rounded(value - value * square, slope * self.linear, np.abs(slope) * self.radius + rest, 1 + reach)


def _rounded(centre: Floats, linear: Floats, radius: Floats, size: Arithmetic = 0.0) -> Affine:
    """An affine number, its radius enlarged by the roundings of terms as large as itself, or as `size`."""
    spread = np.abs(linear).sum(axis=0)
    terms = np.abs(centre) + spread + radius + size
    return Affine(centre, linear, radius + AFFINE_ROUNDING * terms + UNDERFLOW, spread)


def _exact(value: float | Floats) -> Affine:
    """A double, or an array of them, as an affine number without an error."""
    centre = np.atleast_1d(np.asarray(value, dtype=float))
    return Affine(centre, np.zeros((1, 1)), np.zeros(1))


def between(low: Floats, high: Floats, symbol: int, symbols: int) -> Affine:
    """Affine numbers that enclose the intervals from `low` to `high`, each by the same one symbol.

    Parameters
    ----------
    low, high : ndarray (k,)
    symbol, symbols : int
        Index of the symbol, and how many symbols there are.
    """
    linear = np.zeros((symbols, len(low)))
    linear[symbol] = (high - low) / 2
    return _rounded((low + high) / 2, linear, np.zeros(len(low)), np.abs(low) + np.abs(high))


AFFINE = MethodOps(Affine(np.full(1, np.pi), np.zeros((1, 1)), np.full(1, 1.3e-16)))
"""Functions of affine numbers, see `vireport.physics.numbers`."""
