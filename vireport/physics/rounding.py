"""Arithmetic that carries its own rounding error: each number with a bound of its distance from the exact result.

The formulae take the module that provides their functions, and any numbers that can be added and multiplied. Given
these numbers, the very lines that compute a result in doubles bound its error. The bounds are themselves computed in
doubles; each is first order in the unit roundoff and taken large enough for what is left out.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

UNIT = 1.2e-16
"""Unit roundoff 2^-53, enlarged for the terms of higher order."""

FUNCTION = 4 * UNIT
"""Relative error of a sine or cosine of the platform's library: two units in the last place."""

UNDERFLOW = 1e-307
"""Absolute error of a product that underflows."""


class Rounded:
    """Numbers with the bound of their error, of one shape or broadcast against each other.

    Parameters
    ----------
    value : array_like
    error : array_like
        Bound of the distance to the exact number; none for a double that is exact as it stands.
    """

    __array_ufunc__ = None  # arrays and numpy's scalars leave the operation to this class
    __slots__ = ("error", "value")

    def __init__(self, value: Any, error: Any = 0.0) -> None:
        self.value, self.error = value, error

    def __neg__(self) -> Rounded:
        return Rounded(-self.value, self.error)

    def __add__(self, other: Any) -> Rounded:
        b = _rounded(other)
        value = self.value + b.value
        return Rounded(value, self.error + b.error + UNIT * np.abs(value))

    def __mul__(self, other: Any) -> Rounded:
        b = _rounded(other)
        value = self.value * b.value
        error = np.abs(self.value) * b.error + (np.abs(b.value) + b.error) * self.error
        return Rounded(value, error + UNIT * np.abs(value) + UNDERFLOW)

    def __truediv__(self, other: Any) -> Rounded:
        b = _rounded(other)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            value = self.value / b.value
            room = np.abs(b.value) - b.error
            error = np.where(room > 0, (self.error + np.abs(value) * b.error) / room + UNIT * np.abs(value), np.inf)
        return Rounded(value, error + UNDERFLOW)

    def __sub__(self, other: Any) -> Rounded:
        return self + -_rounded(other)

    def __rsub__(self, other: Any) -> Rounded:
        return _rounded(other) + -self

    def __rtruediv__(self, other: Any) -> Rounded:
        return _rounded(other) / self

    __radd__ = __add__
    __rmul__ = __mul__


def _rounded(x: Any) -> Rounded:
    return x if isinstance(x, Rounded) else Rounded(x)


class RoundedOps:
    """What the formulae need beyond the four operations; stands where `numpy` or `math` stands for doubles."""

    pi = Rounded(np.pi, 1.3e-16)

    @staticmethod
    def sin(x: Rounded) -> Rounded:
        """Sine."""
        value = np.sin(x.value)
        return Rounded(value, _moved(np.cos(x.value), x.error) + FUNCTION * np.abs(value))

    @staticmethod
    def cos(x: Rounded) -> Rounded:
        """Cosine."""
        value = np.cos(x.value)
        return Rounded(value, _moved(np.sin(x.value), x.error) + FUNCTION * np.abs(value))

    @staticmethod
    def sinc(x: Rounded) -> Rounded:
        """sin(pi x)/(pi x), the slope of which is below 1.4."""
        value = np.sinc(x.value)
        return Rounded(value, 1.4 * x.error + 2 * FUNCTION * (1 + np.abs(x.value)))


def _moved(slope: Any, error: Any) -> Any:
    """How far a sine or cosine moves with its argument."""
    return np.minimum(np.abs(slope) * error + error * error / 2, 2.0)
