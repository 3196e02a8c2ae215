"""Sine and cosine of decimal numbers of any length, so that a critical point can be polished beyond double precision.

The standard library's decimal arithmetic is compiled and already loaded; a package for this would take longer to
import than the work takes to do.
"""

from __future__ import annotations

from decimal import Decimal, getcontext
from functools import lru_cache

DIGITS = 45
"""Working precision of a polish: cancellation next to a horizontal capsule may take twenty of them."""


@lru_cache(maxsize=4)
def _pi(digits: int) -> Decimal:
    """Pi by Machin's formula, 16 arctan(1/5) - 4 arctan(1/239), in integers."""
    unit: int = 10 ** (digits + 10)

    def arctan_inverse(k: int) -> int:
        term = total = unit // k
        square, i, sign = k * k, 1, 1
        while term:
            term //= square
            i += 2
            sign = -sign
            total += sign * (term // i)
        return total

    return Decimal(4 * (4 * arctan_inverse(5) - arctan_inverse(239))).scaleb(-(digits + 10))


class DecimalOps:
    """`sin`, `cos` and `pi` for decimals at the current precision; stands where the formulae take a module."""

    @property
    def pi(self) -> Decimal:
        """Pi, a few digits beyond the current precision."""
        return _pi(getcontext().prec)

    def sin(self, x: Decimal) -> Decimal:
        """Sine, by the quadrant and a Taylor series."""
        return self._quadrant(x, 0)

    def cos(self, x: Decimal) -> Decimal:
        """Cosine, likewise."""
        return self._quadrant(x, 1)

    def _quadrant(self, x: Decimal, shift: int) -> Decimal:
        quarter = self.pi / 2
        turns = int((x / quarter).to_integral_value())
        rest = x - turns * quarter
        quadrant = (turns + shift) % 4
        series = _cosine_series(rest) if quadrant % 2 else _sine_series(rest)
        return -series if quadrant >= 2 else series


def _sine_series(x: Decimal) -> Decimal:
    return _series(x, x * x, 2)


def _cosine_series(x: Decimal) -> Decimal:
    return _series(Decimal(1), x * x, 1)


def _series(term: Decimal, square: Decimal, k: int) -> Decimal:
    """Sum of the alternating series whose next term is -term x^2/(k (k+1))."""
    total = term
    while True:
        term = -term * square / (k * (k + 1))
        if total + term == total:
            return total
        total += term
        k += 2
