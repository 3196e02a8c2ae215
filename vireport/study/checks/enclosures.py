"""Enclosures of numbers in ball arithmetic, of their derivatives, and of the one root that equations have in a box.

A ball is a midpoint with a radius; each operation returns one that contains every possible result, roundings included
(Arb, by Johansson, IEEE Trans. Computers 66, 2017). The doubles of a scenario are taken as the exact numbers they are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from operator import methodcaller
from typing import Any

from msgspec import Struct

from vireport.base.errors import NumericalError, install_command

try:
    from flint import arb, arb_mat, arb_series, ctx
except ImportError as error:
    raise NumericalError(
        f"proofs in ball arithmetic need the package python-flint: {install_command('python-flint')}"
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
"""An `arb` of python-flint."""

System = Callable[[list[Any]], list[Any]]
"""Unknowns -> residuals; written for balls and for power series of balls alike."""


class UnprovedError(Exception):
    """A proof did not succeed; the message says why in words."""


class BallOps:
    """Functions of balls and, `sin` and `cos`, of their power series; see `vireport.physics.numbers`.

    A square root is not finite where a number in the ball has none.
    """

    sin, cos, sqrt = methodcaller("sin"), methodcaller("cos"), methodcaller("sqrt")

    @property
    def pi(self) -> Ball:
        """Pi at the current precision."""
        return arb.pi()

    @staticmethod
    def exact(x: Any) -> Ball:
        """A double as the ball of radius 0, or a ball as it is."""
        return arb(x)

    @staticmethod
    def sin_degrees(angle: Ball) -> Ball:
        """Sine of an angle in degrees."""
        return (angle / 180).sin_pi()

    @staticmethod
    def arcsin_degrees(sine: Ball) -> Ball:
        """Angle in degrees; not finite where a number in the ball is not a sine."""
        return sine.asin() * 180 / arb.pi()


def precision(bits: int) -> Any:
    """Context in which balls are computed with so many bits."""
    return ctx.workprec(bits)


def ball(value: float | str) -> Ball:
    """A double, or a decimal number as a string, as a ball; a double is exact."""
    return arb(value if isinstance(value, str) else float(value))


def dyadic(count: int, depth: int, width: int) -> Ball:
    """The ball about count/2^depth of radius 1/2^width, exact."""
    return arb((count, -depth), (1, -width))


def gradients(functions: System, box: Sequence[Ball]) -> list[list[Ball]]:
    """Derivatives of functions with respect to their arguments over a box, one list for each function.

    By power series in one argument after the other; not finite where a denominator may vanish.
    """
    columns = []
    for i in range(len(box)):
        # A series x + t to first order carries the derivative along, enclosed like the value: no difference quotient
        # could be.
        arguments = [arb_series([x, 1], prec=2) if k == i else x for k, x in enumerate(box)]
        try:
            columns.append([arb_series(value, prec=2)[1] for value in functions(arguments)])
        except ValueError:  # of a division by a series
            columns.append([arb("nan")] * len(functions(list(box))))
    return [list(row) for row in zip(*columns, strict=True)]


class Root(Struct, frozen=True):
    """An enclosure that is proved to hold one solution and no other.

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
        If the guess leads to no solution, or to one whose uniqueness is not proved.
    """
    middle = _newton(system, guess, scale)
    # The widest box first: the wider, the more is said about there being no other solution near.
    for radius in RADII:
        box = [arb(m, float(ball(radius) * size)) for m, size in zip(middle, scale, strict=True)]
        image = _krawczyk(system, box)
        if all(side.contains_interior(k) for side, k in zip(box, image, strict=True)):
            for _ in range(SHRINKAGES):
                # All solutions of a box are in its image as well, so that the intersection loses none and shrinks
                # quadratically.
                image = [side.intersection(k) for side, k in zip(image, _krawczyk(system, image), strict=True)]
            return Root(image, float(radius))
    raise UnprovedError("no box is mapped into itself: the conditions are degenerate here, or nearly so")


def _newton(system: System, guess: Sequence[float], scale: Sequence[float]) -> list[Ball]:
    """The midpoints to which Newton's method converges, to rounding."""
    x, before = [ball(value) for value in guess], 1.0
    for _ in range(NEWTON_STEPS):
        step = _inverse(gradients(system, x)) * arb_mat([[value.mid()] for value in system(x)])
        x = [(a - step[i, 0]).mid() for i, a in enumerate(x)]
        size = max(abs(float(step[i, 0].mid())) / width for i, width in enumerate(scale))
        if not size < FARTHEST:
            break
        if size == 0 or (size < SETTLING and size > before / 2):
            return x
        before = size
    raise UnprovedError("Newton's method does not settle on a solution")


def _krawczyk(system: System, box: list[Ball]) -> list[Ball]:
    middle = [side.mid() for side in box]
    inverse, wide, size = _inverse(gradients(system, middle)), arb_mat(gradients(system, box)), len(box)
    identity = arb_mat([[int(i == k) for k in range(size)] for i in range(size)])
    offset = arb_mat([[x - m] for x, m in zip(box, middle, strict=True)])
    # The derivative over the whole box meets only the half widths, the residual is taken at a point: with the
    # residual over the box no box would map into itself.
    correction = (identity - inverse * wide) * offset - inverse * arb_mat([[value] for value in system(middle)])
    return [m + correction[i, 0] for i, m in enumerate(middle)]


def _inverse(jacobian: list[list[Ball]]) -> Any:
    """An approximate inverse of the midpoint of a matrix, as exact numbers."""
    try:
        # Any matrix makes the test valid; the nearer to the inverse, the more boxes pass.
        return arb_mat(jacobian).mid().inv().mid()
    except ZeroDivisionError as error:
        raise UnprovedError("two of the conditions coincide here: the point is degenerate") from error


def bounds(value: Ball, digits: int = DECIMALS) -> tuple[str, str]:
    """Decimal numbers below and above everything in a ball, rounded outward to significant digits; it is finite."""
    low, high = _decimal(value.lower(), ROUND_FLOOR, digits), _decimal(value.upper(), ROUND_CEILING, digits)
    return low, high


def _decimal(exact: Ball, rounding: str, digits: int) -> str:
    mantissa, exponent = (int(part) for part in exact.man_exp())
    number = Fraction(mantissa) * Fraction(2) ** exponent
    rounded = Context(prec=digits, rounding=rounding).divide(Decimal(number.numerator), Decimal(number.denominator))
    return str(rounded)
