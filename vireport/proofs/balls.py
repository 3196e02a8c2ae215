"""Ball arithmetic: numbers with a proven bound of their error, their gradients, and proofs that equations have a root.

A ball is a midpoint with a radius; each operation returns one that contains every possible result, roundings included
(Arb, by Johansson, IEEE Trans. Computers 66, 2017). Turns a system of equations and a guess into a box that contains
exactly one solution. The doubles of a scenario are taken as the exact numbers they are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any

from vireport.analysis import Level, Sweep
from vireport.errors import NumericalError
from vireport.physics import (
    NO_GRAVITY,
    Device,
)
from vireport.scenario import Parameter

try:
    from flint import arb, arb_mat, ctx
except ImportError as error:
    raise NumericalError(
        "proofs in ball arithmetic need the package python-flint: pip install 'vireport[certify]'"
    ) from error

RADII = ("1e-10", "1e-13", "1e-17", "1e-22", "1e-28", "1e-36", "1e-48")
"""Boxes in which a root is sought to be the only one, the widest first: the first is wide enough for a double and far
too small for another critical point, the others are for near-degenerate systems."""

NEWTON_STEPS = 40
"""Corrections of the guess before it is given up; from a double four or five are usual."""

FARTHEST = 1e-2
"""Relative correction with which Newton's method has left the guess."""

SETTLING = 1e-20
"""Relative correction below which Newton's method has settled once it no longer halves: only rounding is left."""

SHRINKAGES = 6
"""Times a proven box is contracted; after three or four it is as small as the precision allows."""

DECIMALS = 25
"""Significant digits of printed bounds."""

Ball = Any
"""A number of the type `flint.arb`."""

System = Callable[[list[Any]], list[Any]]
"""Unknowns -> residuals, as many of them; written for balls and for `Dual` numbers alike."""


class UnprovedError(Exception):
    """A proof did not succeed; the message says why in words."""


@dataclass(frozen=True, slots=True)
class Dual:
    """A ball and its gradient with respect to the unknowns: forward differentiation, rigorous like the arithmetic."""

    value: Ball
    gradient: tuple[Ball, ...]

    def __add__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            return Dual(
                self.value + other.value, tuple(a + b for a, b in zip(self.gradient, other.gradient, strict=True))
            )
        return Dual(self.value + other, self.gradient)

    __radd__ = __add__

    def __neg__(self) -> Dual:
        return Dual(-self.value, tuple(-a for a in self.gradient))

    def __sub__(self, other: Any) -> Dual:
        return Dual.__add__(self, -other)

    def __rsub__(self, other: Any) -> Dual:
        return Dual.__add__(-self, other)

    def __mul__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            pairs = zip(self.gradient, other.gradient, strict=True)
            return Dual(self.value * other.value, tuple(a * other.value + self.value * b for a, b in pairs))
        return Dual(self.value * other, tuple(a * other for a in self.gradient))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            ratio = self.value / other.value
            pairs = zip(self.gradient, other.gradient, strict=True)
            return Dual(ratio, tuple((a - ratio * b) / other.value for a, b in pairs))
        return Dual(self.value / other, tuple(a / other for a in self.gradient))

    def __rtruediv__(self, other: Any) -> Dual:
        ratio = other / self.value
        return Dual(ratio, tuple(-ratio * b / self.value for b in self.gradient))


class BallOps:
    """`sin`, `cos` and `pi` for balls and `Dual` numbers; stands where the formulae take a module."""

    @property
    def pi(self) -> Ball:
        """Pi at the current precision."""
        return arb.pi()

    def sin(self, x: Any) -> Any:
        """Sine."""
        if isinstance(x, Dual):
            slope = x.value.cos()
            return Dual(x.value.sin(), tuple(slope * a for a in x.gradient))
        return x.sin()

    def cos(self, x: Any) -> Any:
        """Cosine."""
        if isinstance(x, Dual):
            slope = -x.value.sin()
            return Dual(x.value.cos(), tuple(slope * a for a in x.gradient))
        return x.cos()


def precision(bits: int) -> Any:
    """Context in which balls are computed with so many bits."""
    return ctx.workprec(bits)


def ball(value: Any) -> Ball:
    """A double, or a decimal number as a string, as a ball; a double is exact."""
    return arb(value if isinstance(value, str) else float(value))


def dyadic(count: int, depth: int, width: int) -> Ball:
    """The ball about count/2^depth of radius 1/2^width, exact."""
    return arb((count, -depth), (1, -width))


def duals(x: Sequence[Ball]) -> list[Dual]:
    """The unknowns themselves, with their unit gradients."""
    return [Dual(value, tuple(arb(int(i == k)) for k in range(len(x)))) for i, value in enumerate(x)]


def groups(device: Device, parameter: Parameter, value: Any) -> tuple[Ball, Ball]:
    """The groups d = 4 M s f^2/F and gbar = M g sin(beta)/F, Eqs. (2.5) and (2.6); see `Device.groups`.

    Parameters
    ----------
    device : Device
    parameter : str
        One of `Parameter`.
    value : float or ball
        What the parameter is.

    Notes
    -----
    gbar up to `NO_GRAVITY` is taken as zero, as the model does; `neglects_gravity` says where.
    """
    x = {name: value if isinstance(value, arb) else ball(value) for name, value in device.at(parameter, value).items()}
    d = 4 * ball(device.capsule_mass_kg) * x[Parameter.LENGTH] * x[Parameter.FREQUENCY] ** 2 / x[Parameter.AMPLITUDE]
    gbar = _gravity(device, x[Parameter.INCLINATION]) / x[Parameter.AMPLITUDE]
    return d, gbar if gbar > NO_GRAVITY else arb(0)


def neglects_gravity(sweep: Sweep) -> bool:
    """Whether a sweep's capsule is taken as horizontal though it is not quite."""
    device = sweep.device
    if sweep.parameter == "inclination_deg" or groups(device, sweep.parameter, sweep.start)[1] != 0:
        return False
    return bool(_gravity(device, ball(device.inclination_deg)) != 0)


def _gravity(device: Device, angle: Ball) -> Ball:
    """M g sin(beta) [N]."""
    return ball(device.capsule_mass_kg) * ball(device.gravity_m_s2) * (angle / 180).sin_pi()


def level(sweep: Sweep) -> Level:
    """What stays the same along a sweep, as a ball; see `Sweep.level`."""
    d, gbar = groups(sweep.device, sweep.parameter, sweep.start)
    if sweep.parameter == "inclination_deg":
        return Level("d", d)
    if sweep.parameter == "amplitude_n" and gbar != 0:
        return Level("ratio", d / gbar)
    return Level("gbar", gbar)


def sweep_value(sweep: Sweep, d: Ball, gbar: Ball) -> Ball:
    """The swept parameter at which a motion with these groups occurs; the inverse of `groups`.

    Raises
    ------
    UnprovedError
        If the groups do not prove that there is such a value: at an inclination of 90 degrees, say.
    """
    device = sweep.device
    mass = ball(device.capsule_mass_kg)
    if sweep.parameter == "inclination_deg":
        sine = gbar * ball(device.amplitude_n) / (mass * ball(device.gravity_m_s2))
        found = sine.asin() * 180 / arb.pi()
    elif sweep.parameter == "length_m":
        found = d * ball(device.amplitude_n) / (4 * mass * ball(device.frequency_hz) ** 2)
    elif sweep.parameter == "amplitude_n":
        found = 4 * mass * ball(device.length_m) * ball(device.frequency_hz) ** 2 / d
    else:
        found = (d * ball(device.amplitude_n) / (4 * mass * ball(device.length_m))).sqrt()
    if not found.is_finite():
        raise UnprovedError("no value of the swept parameter is proved to give the groups of the motion")
    return found


@dataclass(frozen=True, slots=True)
class Root:
    """A proven solution.

    Attributes
    ----------
    box : list of ball
        Contains the solution.
    radius : float
        Half the width, relative to the scale of each unknown, of the wider box in which it is the only one.
    """

    box: list[Ball]
    radius: float


def prove(system: System, guess: Sequence[float], scale: Sequence[float]) -> Root:
    """Prove that a system has exactly one solution near a guess, by Krawczyk's test, at the current precision.

    With m the middle of a box X and Y about the inverse of the Jacobian J there, the operator
    K(X) = m - Y f(m) + (1 - Y J(X)) (X - m) maps all solutions in X into K(X); if K(X) lies in the interior of X,
    there is exactly one, and J is regular on X.

    Parameters
    ----------
    system : callable
    guess : sequence of float
        Good to the digits of a double.
    scale : sequence of float
        Of each unknown: what the widths of the boxes are relative to.

    Raises
    ------
    UnprovedError
        If the guess leads to no solution, or none that can be told to be single.
    """
    middle = _newton(system, guess, scale)
    for radius in RADII:
        box = [arb(m, float(ball(radius) * size)) for m, size in zip(middle, scale, strict=True)]
        image = _krawczyk(system, box)
        if all(x.contains_interior(k) for x, k in zip(box, image, strict=True)):
            for _ in range(SHRINKAGES):
                image = [x.intersection(k) for x, k in zip(image, _krawczyk(system, image), strict=True)]
            return Root(image, float(radius))
    raise UnprovedError("no box is mapped into itself: the conditions are degenerate here, or nearly so")


def _newton(system: System, guess: Sequence[float], scale: Sequence[float]) -> list[Ball]:
    """The midpoints to which Newton's method leads, as far as rounding lets it go."""
    x, before = [ball(value) for value in guess], 1.0
    for _ in range(NEWTON_STEPS):
        value, jacobian = _linearised(system, x)
        step = _inverse(jacobian) * arb_mat([[v.mid()] for v in value])
        x = [(a - step[i, 0]).mid() for i, a in enumerate(x)]
        size = max(abs(float(step[i, 0].mid())) / one for i, one in enumerate(scale))
        if not size < FARTHEST:
            break
        if size == 0 or (size < SETTLING and size > before / 2):
            return x
        before = size
    raise UnprovedError("Newton's method does not settle on a solution")


def _krawczyk(system: System, box: list[Ball]) -> list[Ball]:
    middle = [x.mid() for x in box]
    value, jacobian = _linearised(system, middle)
    inverse = _inverse(jacobian)
    _, wide = _linearised(system, box)
    size = len(box)
    identity = arb_mat([[int(i == k) for k in range(size)] for i in range(size)])
    offset = arb_mat([[x - m] for x, m in zip(box, middle, strict=True)])
    correction = (identity - inverse * wide) * offset - inverse * arb_mat([[v] for v in value])
    return [m + correction[i, 0] for i, m in enumerate(middle)]


def _linearised(system: System, x: Sequence[Ball]) -> tuple[list[Ball], Any]:
    """Residuals and Jacobian over a box."""
    found = system(duals(x))
    return [f.value for f in found], arb_mat([list(f.gradient) for f in found])


def _inverse(jacobian: Any) -> Any:
    """About the inverse of the middle of a matrix, as exact numbers."""
    try:
        return jacobian.mid().inv().mid()
    except ZeroDivisionError as error:
        raise UnprovedError("two of the conditions coincide here: the point is degenerate") from error


def bounds(value: Ball, digits: int = DECIMALS) -> tuple[str, str]:
    """Decimal numbers below and above everything in a ball, rounded outward.

    Parameters
    ----------
    value : ball
        Finite.
    digits : int
        Significant digits of the larger one.
    """
    low, high = _fraction(value.lower()), _fraction(value.upper())
    largest = max(abs(low), abs(high))
    if not largest:
        return "0", "0"
    unit = Fraction(10) ** (_exponent(largest) - digits + 1)
    down, up = low // unit, -(-high // unit)
    while down == up and down % 10 == 0:
        down, up, unit = down // 10, up // 10, 10 * unit
    return _decimal(down, unit), _decimal(up, unit)


def _fraction(exact: Ball) -> Fraction:
    mantissa, exponent = (int(part) for part in exact.man_exp())
    return Fraction(mantissa) * Fraction(2) ** exponent


def _exponent(number: Fraction) -> int:
    """Power of ten of the first digit of a positive number."""
    power = len(str(number.numerator)) - len(str(number.denominator))
    return power if number >= Fraction(10) ** power else power - 1


def _decimal(count: int, unit: Fraction) -> str:
    """A count of a power of ten, as a decimal number."""
    power = _exponent(unit)
    return str(Decimal((int(count < 0), tuple(int(c) for c in str(abs(count))), power)))
