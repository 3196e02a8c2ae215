"""Kinds of numbers in which the formulae are evaluated, and the functions of each kind.

A formula takes its numbers and, as `ops`, an object with `pi`, `sin` and `cos` for their kind; the conversion to and
from SI units in `device` takes `exact` (a double as such a number), `sqrt`, `sin_degrees` and `arcsin_degrees` too.
Three kinds are here: doubles, decimals as long as a critical point needs them, and doubles that carry a bound of their
rounding error. Affine numbers are in `affine`; balls (midpoint and radius) are in `study.checks.enclosures`, because
they need a package.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import Decimal, getcontext
from functools import lru_cache
from operator import methodcaller
from types import ModuleType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DIGITS = 45
"""Digits of decimals: cancellation next to a horizontal capsule may take twenty of them."""

IMAGINARY_STEP = 1e-30
"""Imaginary step at which an analytic function gives its derivative to the last digit: its square is below rounding."""

UNIT = 1.2e-16
"""Unit roundoff 2^-53, enlarged for the terms of higher order."""

FUNCTION = 4 * UNIT
"""Relative error of a sine or cosine of NumPy's: two units in the last place; measured is half a unit."""

UNDERFLOW = 1e-307
"""Absolute error of a product that underflows."""

DEGREE = math.pi / 180
"""One degree [rad]."""

ARCSINE_STEPS = 6
"""Newton steps from a double to `DIGITS`, of which two or three are needed: next to 90 degrees each gains less."""


class Arithmetic(Protocol):
    """A number of any kind, or an array of such numbers, for formulae that add, multiply and divide."""

    def __neg__(self) -> Any: ...
    def __add__(self, other: Any, /) -> Any: ...
    def __radd__(self, other: Any, /) -> Any: ...
    def __sub__(self, other: Any, /) -> Any: ...
    def __rsub__(self, other: Any, /) -> Any: ...
    def __mul__(self, other: Any, /) -> Any: ...
    def __rmul__(self, other: Any, /) -> Any: ...
    def __truediv__(self, other: Any, /) -> Any: ...
    def __rtruediv__(self, other: Any, /) -> Any: ...


class Functions(Protocol):
    """Functions that every kind of number has: pi, sine and cosine."""

    @property
    def pi(self) -> Any:
        """Pi."""

    @property
    def sin(self) -> Callable[[Any], Any]:
        """Sine."""

    @property
    def cos(self) -> Callable[[Any], Any]:
        """Cosine."""


class ExactFunctions(Functions, Protocol):
    """Functions of kinds of numbers that hold any double, which the conversion from and to SI units needs."""

    def exact(self, x: Any) -> Any:
        """A double as such a number."""

    @property
    def sqrt(self) -> Callable[[Any], Any]:
        """Square root."""

    def sin_degrees(self, angle: Any) -> Any:
        """Sine of an angle in degrees."""

    def arcsin_degrees(self, sine: Any) -> Any:
        """Angle of a sine [deg]."""


class ContinuousFunctions(Functions, Protocol):
    """Functions of kinds of numbers that are evaluated on arrays: doubles, and numbers that enclose them."""

    @property
    def sinc(self) -> Callable[[Any], Any]:
        """sin(pi x)/(pi x)."""

    def maximum(self, x: Any, y: Any) -> Any:
        """The larger of two."""

    def distance(self, x: Any, y: Any) -> Any:
        """The size of the difference of two."""


class DoubleOps:
    """Functions of doubles: with `numpy` of arrays, with `math` of single numbers, at a tenth of the time.

    Parameters
    ----------
    module : module
        `numpy`, `math` or `cmath`.
    """

    def __init__(self, module: ModuleType) -> None:
        self.pi, self.sin, self.cos, self.exp = module.pi, module.sin, module.cos, module.exp

    @staticmethod
    def exact(x: Any) -> Any:
        """The double itself."""
        return x

    @staticmethod
    def sinc(x: Any) -> Any:
        """sin(pi x)/(pi x)."""
        return np.sinc(x)

    @staticmethod
    def maximum(x: Any, y: Any) -> Any:
        """The larger of two."""
        return np.maximum(x, y)

    @staticmethod
    def distance(x: Any, y: Any) -> Any:
        """The size of the difference of two."""
        return magnitude(x - y)

    @staticmethod
    def sqrt(x: Any) -> Any:
        """Square root; of a negative number 0."""
        return np.sqrt(np.maximum(x, 0.0))

    @staticmethod
    def sin_degrees(angle: Any) -> Any:
        """Sine of 0 to 90 degrees, exact at both ends and with full relative accuracy next to them."""
        angle = np.asarray(angle)
        sine = np.where(angle.real <= 45, np.sin(angle * DEGREE), np.cos((90 - angle) * DEGREE))
        return sine[()]

    @staticmethod
    def arcsin_degrees(sine: Any) -> Any:
        """Angle of a sine [deg]; 90 for a sine that rounding has taken beyond 1."""
        return np.degrees(np.arctan2(sine, np.sqrt(np.maximum((1 - sine) * (1 + sine), 0.0))))


def magnitude(x: Any) -> Any:
    """The absolute value of real numbers; an imaginary step, as a derivative, changes its sign with the number."""
    x = np.asarray(x)
    return np.where(x.real < 0, -x, x)


def wrapped(angle: Any) -> Any:
    """An angle, number or array, less whole turns, in [-pi, pi) [rad]."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


ARRAYS, FLOATS = DoubleOps(np), DoubleOps(math)
"""Functions of arrays of doubles, complex ones among them for derivatives, and of single doubles."""


class DecimalOps:
    """Functions of decimals, at the precision of the current context.

    The standard library's arithmetic is compiled and already loaded; a package for this would take longer to import
    than the work takes to do.
    """

    @property
    def pi(self) -> Decimal:
        """Pi, a few digits beyond the current precision."""
        return _pi(getcontext().prec)

    @staticmethod
    def exact(x: Any) -> Decimal:
        """The exact value of a double."""
        return Decimal(x)

    def sin(self, x: Decimal) -> Decimal:
        """Sine, by a Taylor series about the nearest quarter turn."""
        return _sine_and_cosine(x, getcontext().prec)[0]

    def cos(self, x: Decimal) -> Decimal:
        """Cosine, by the sine of the distance from the nearest quarter turn."""
        return _sine_and_cosine(x, getcontext().prec)[1]

    @staticmethod
    def exp(x: Decimal) -> Decimal:
        """Exponential function."""
        return x.exp()

    @staticmethod
    def sqrt(x: Decimal) -> Decimal:
        """Square root."""
        return x.sqrt()

    def sin_degrees(self, angle: Decimal) -> Decimal:
        """Sine of an angle in degrees."""
        return self.sin(angle * self.pi / 180)

    def arcsin_degrees(self, sine: Decimal) -> Decimal:
        """Angle of a sine [deg], by Newton's method from the angle in doubles."""
        degree, angle = self.pi / 180, Decimal(float(ARRAYS.arcsin_degrees(float(sine))))
        for _ in range(ARCSINE_STEPS):
            cosine = self.cos(angle * degree)
            if not cosine:
                break
            angle -= (self.sin(angle * degree) - sine) / (cosine * degree)
        return angle


@lru_cache(maxsize=32)  # the conditions of a motion and a further equation need the sines of the same phases
def _sine_and_cosine(x: Decimal, digits: int) -> tuple[Decimal, Decimal]:
    """Sine and cosine of a decimal [rad], by its distance from the nearest quarter turn."""
    quarter = _pi(digits) / 2
    turns = int((x / quarter).to_integral_value())
    rest = x - turns * quarter
    sine = _sine(rest, digits)
    # At most an eighth of a turn from the axis the cosine is above 0.7: its root loses no digits, and costs a tenth of
    # a second series.
    cosine = (1 - sine * sine).sqrt()
    return ((sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine))[turns % 4]


def _sine(x: Decimal, digits: int) -> Decimal:
    """The sine of an angle of at most an eighth of a turn [rad], by its Taylor series."""
    square, total = x * x, Decimal(0)
    for coefficient in _sine_coefficients(digits):
        total = total * square + coefficient
    return x * total


@lru_cache(maxsize=4)
def _sine_coefficients(digits: int) -> tuple[Decimal, ...]:
    """Taylor coefficients of sin(x)/x in powers of x^2, the highest first."""
    coefficients = [Decimal(1)]
    # Until a term is below the last digit; the argument is at most pi/4, so that the series is as short as possible.
    while coefficients[-1].adjusted() > -digits - 1:
        k = 2 * len(coefficients)
        coefficients.append(-coefficients[-1] / (k * (k + 1)))
    return tuple(reversed(coefficients))


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


class Rounded:
    """Doubles with a bound of their distance from the exact result, of one shape or broadcast against each other.

    The lines that compute a result in doubles bound its error when they are given these numbers. The bounds are
    computed in doubles too; each is of first order in the unit roundoff, and large enough for the higher orders.

    Parameters
    ----------
    value : array_like
    error : array_like
        Bound of the distance to the exact number; 0 for a double that is exact.
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

    def __pow__(self, exponent: Any) -> Rounded:
        b = _rounded(exponent)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            value = self.value**b.value
            # x^p moves by the factor exp(p d(ln x) + ln(x) dp), and ln x at most by -ln(1 - error/x).
            moved = -np.log1p(-self.error / self.value) * (np.abs(b.value) + b.error)
            change = np.expm1(moved + np.abs(np.log(self.value)) * b.error)
            error = np.where(self.value > self.error, np.abs(value) * (change + FUNCTION), np.inf)
        return Rounded(value, error + UNDERFLOW)

    @property
    def real(self) -> Any:
        """The doubles without their error, for decisions that depend on the number."""
        return self.value

    def sin(self) -> Rounded:
        """Sine."""
        value = np.sin(self.value)
        return Rounded(value, _moved(np.cos(self.value), self.error) + FUNCTION * np.abs(value))

    def cos(self) -> Rounded:
        """Cosine."""
        value = np.cos(self.value)
        return Rounded(value, _moved(np.sin(self.value), self.error) + FUNCTION * np.abs(value))

    def sinc(self) -> Rounded:
        """sin(pi x)/(pi x), the slope of which is below 1.4."""
        return Rounded(np.sinc(self.value), 1.4 * self.error + 2 * FUNCTION * (1 + np.abs(self.value)))

    def maximum(self, other: Rounded) -> Rounded:
        """The larger of two, which no error moves by more than the larger error."""
        return Rounded(np.maximum(self.value, other.value), np.maximum(self.error, other.error))

    def distance(self, other: Rounded) -> Rounded:
        """The absolute difference, which has no rounding where one number is at most twice the other (Sterbenz)."""
        away = np.abs(self.value - other.value)
        exact = away <= np.minimum(np.abs(self.value), np.abs(other.value))
        return Rounded(away, self.error + other.error + np.where(exact, 0.0, UNIT * away))


def infinite_where_undefined(bounds: dict[str, Floats]) -> dict[str, Floats]:
    """Error bounds with infinity in the place of nan, which their arithmetic leaves where no error is bounded."""
    return {name: np.where(np.isfinite(bound), bound, np.inf) for name, bound in bounds.items()}


def _rounded(x: Any) -> Rounded:
    """A number as `Rounded`; a double is exact."""
    return x if isinstance(x, Rounded) else Rounded(x)


def _moved(slope: Any, error: Any) -> Any:
    """Bound of the change of a sine or cosine with its argument, by its slope and the error of the argument."""
    return np.minimum(np.abs(slope) * error + error * error / 2, 2.0)


class MethodOps:
    """Functions of a kind of number that has them as methods, such as `Rounded`.

    Parameters
    ----------
    pi : object
        In the kind of number.
    """

    sin, cos, sinc = methodcaller("sin"), methodcaller("cos"), methodcaller("sinc")

    def __init__(self, pi: Any) -> None:
        self.pi = pi

    @staticmethod
    def maximum(x: Any, y: Any) -> Any:
        """The larger of two."""
        return x.maximum(y)

    @staticmethod
    def distance(x: Any, y: Any) -> Any:
        """The size of the difference of two."""
        return x.distance(y)


ROUNDED = MethodOps(Rounded(np.pi, 1.3e-16))
"""Functions of doubles that carry their error."""
