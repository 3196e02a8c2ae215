"""Roots and extrema of functions of one variable, for arrays of brackets at once and for one.

Every root has a bracket that is never left, so that none is lost and none comes twice. Which search when:

- `bracketed_root`: only values are known; to the last bit.
- `newton_root`: the derivative costs next to nothing.
- `secant_root`: a good guess and slope are known, as of a cubic through values and slopes (`cubic_root`).
- `path_root`: one bracket in Python's numbers, where an evaluation solves for a motion.
- `golden_minimum`, `golden_section`: extrema. `may_hide_zeros` says where one may hide two zeros.
"""

from __future__ import annotations

from collections.abc import Callable
from sys import float_info
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

ADJACENT = 4e-16
"""Width of a bracket, relative to its newest end, at which only one or two doubles are left in it."""

MOST_HALVINGS = 200
"""Steps of `bracketed_root`, more than any search takes."""

TINY = np.finfo(float).tiny
"""Divisor in the place of zero."""

MOST_NEWTON_STEPS = 60
"""Steps of `newton_root`, more than bisection needs to exhaust a double; Newton's steps end it after four to seven."""

MANY = 1000
"""Number of brackets from which it pays to leave out those that are settled."""

MOST_SECANT_STEPS = 80
"""Steps of `secant_root`: a bisection in every fourth step exhausts the digits that a start leaves."""

FREE_STEPS = 8
"""Secant steps, of which four are usual, before every fourth step is a bisection."""

MOST_PATH_SECANTS, FREE_PATH_SECANTS = 60, 7
"""Secant steps of `path_root`, and those before every fourth step is a bisection."""

CUBIC_STEPS = 7
"""Newton steps of `cubic_root`, whose zero only has to be a good start."""

GOLDEN = (5**0.5 - 1) / 2
"""Share by which a golden section narrows a bracket."""


def bracketed_root(
    function: Callable[[Floats], Floats],
    low: Floats,
    high: Floats,
    tolerance: float = 0.0,
    values: tuple[Floats, Floats] | None = None,
) -> Floats:
    """Zeros of a function between `low` and `high`, where its signs differ, by inverse quadratics and bisections.

    Chandrupatla's rule: the inverse quadratic through the last three values where that is sure to be monotone within
    the bracket, else the middle. A step that would come nearer to an end than the tolerance goes as far as that, beyond
    the zero, so that the bracket closes from both sides.

    Parameters
    ----------
    function : callable
        Takes the arguments of all brackets and returns the values.
    low, high : ndarray
        Ends of the brackets, in either order.
    tolerance : float
        Width of the last bracket; 0 for the last bit.
    values : tuple of ndarray, optional
        Of the function at both ends, where the caller has them.

    Returns
    -------
    ndarray
        Zeros, or else the ends of the last brackets on the side of `high`.
    """
    if not low.size:
        return low
    f_low, f_high = values or (function(low), function(high))
    # The newest argument, the other end of the bracket, and the argument that was left behind. The signs at `new` and
    # `other` always differ: the zero stays between them.
    (new, f_new), (other, f_other), part = (low, f_low), (high, f_high), np.full(low.shape, 0.5)
    for _ in range(MOST_HALVINGS):
        x = new + part * (other - new)
        f = function(x)
        same = (f > 0) == (f_new > 0)
        left, f_left = np.where(same, new, other), np.where(same, f_new, f_other)
        other, f_other = np.where(same, other, new), np.where(same, f_other, f_new)
        new, f_new, width = x, f, other - x
        closest = (tolerance + ADJACENT * np.abs(x)) / np.maximum(np.abs(width), TINY)
        settled = (closest >= 1) | (f == 0)
        if settled.all():
            break
        with np.errstate(all="ignore"):
            xi, phi = (new - other) / (left - other), (f_new - f_other) / (f_left - f_other)
            quadratic = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
            across = f_new / (f_other - f_new) * f_left / (f_other - f_left)
            beyond = (left - new) / width * f_new / (f_left - f_new) * f_other / (f_left - f_other)
            part = np.where(quadratic, across + beyond, 0.5)
        nearest = np.minimum(closest / 2, 0.5)
        part = np.where(settled, 0.0, np.clip(part, nearest, 1 - nearest))
    return np.where((f_new == 0) | ((f_new > 0) == (f_high > 0)), new, other)


def newton_root(
    function: Callable[[Floats, Ints], tuple[Floats, Floats]],
    low: Floats,
    high: Floats,
    start: Floats,
    rising: NDArray[np.bool_],
    tolerance: float,
) -> Floats:
    """Zeros between `low` and `high` by Newton's method, with a bisection where a step would leave the bracket.

    Parameters
    ----------
    function : callable
        Takes arguments and the numbers of the brackets they belong to, and returns values and derivatives.
    low, high : ndarray
        Lower and upper ends of the brackets.
    start : ndarray
        Guesses; where one is not inside its bracket the search begins in the middle.
    rising : ndarray of bool
        Whether the function is positive at the upper end.
    tolerance : float
        Newton step with which a search ends, relative to the zero or to 1.
    """
    x = root = np.where((start > low) & (start < high), start, (low + high) / 2)
    active, ended = np.arange(len(x)), np.zeros(len(x), dtype=bool)
    for _ in range(MOST_NEWTON_STEPS):
        value, slope = function(x, active)
        upper = (value > 0) == rising
        low, high = np.where(upper, low, x), np.where(upper, x, high)
        sloping = slope != 0
        step = value / np.where(sloping, slope, 1.0)
        settled = (np.abs(step) <= tolerance * np.maximum(np.abs(x), 1.0)) & sloping
        new = x - step
        inside = (new > low) & (new < high) & sloping
        # A search that has ended stays where it is, or its last digits would depend on which others are made with it.
        x = np.where(ended, x, np.where(inside, new, np.where(settled, x, (low + high) / 2)))
        ended = ended | settled
        if ended.all():
            break
        # To copy what is left costs as much as a step: only where that halves the work, and the arrays are long.
        if x.size > MANY and 2 * np.count_nonzero(ended) > x.size:
            root[active] = x
            active, x, low, high, rising = (array[~ended] for array in (active, x, low, high, rising))
            ended = np.zeros(len(x), dtype=bool)
    root[active] = x
    return root


class Guesses(NamedTuple):
    """Where searches for zeros begin, as arrays over the brackets.

    Attributes
    ----------
    low, high : ndarray
        Ends of each bracket.
    value_low : ndarray
        The function at the lower end.
    rising : ndarray of bool
        Whether it is positive at the upper end.
    start, slope : ndarray
        A guess at the zero inside the bracket, and at the slope there.
    """

    low: Floats
    high: Floats
    value_low: Floats
    rising: NDArray[np.bool_]
    start: Floats
    slope: Floats


def secant_root(function: Callable[[Floats, Ints], Floats], guesses: Guesses, tolerance: float) -> Floats:
    """Zeros from guesses, by secant steps and by bisections where one would leave the bracket; many at once.

    Parameters
    ----------
    function : callable
        Takes arguments and the numbers of the brackets they belong to. A root is the last argument that it was called
        with for its bracket, so that the caller may keep what else it computes.
    guesses : Guesses
    tolerance : float
        Step at which a search ends, relative to the zero.
    """
    low, high, f_before, rising, x, slope = guesses
    before = low
    root, active = x.copy(), np.arange(len(x))
    for step in range(MOST_SECANT_STEPS):
        if not active.size:
            break
        f = function(x, active)
        # The first slope is that of the guess; from then on it is that of the last two values.
        if step:
            moved, risen = x - before, f - f_before
            fit = (moved != 0) & (risen != 0)
            slope = np.where(fit, risen / np.where(fit, moved, 1.0), slope)
        upper = (f > 0) == rising
        low, high = np.where(upper, low, x), np.where(upper, x, high)
        new = x - f / np.where(slope == 0, 1.0, slope)
        usable = (new >= low) & (new <= high) & (slope != 0) & (step < FREE_STEPS or step % 4 != 3)
        new = np.where(usable, new, (low + high) / 2)
        root[active] = x
        go = (np.abs(new - x) > tolerance * np.abs(x)) & (f != 0)
        active, before, f_before, x = active[go], x[go], f[go], new[go]
        low, high, slope, rising = low[go], high[go], slope[go], rising[go]
    return root


class Crossing(NamedTuple):
    """A zero of a function, or a guess at one, and the slope of the function there."""

    at: float
    slope: float


def path_root(
    function: Callable[[float], float], end: float, rises: bool, guess: Crossing, tolerance: float
) -> Crossing:
    """The zero of a function between 0 and `end`, by secants from a guess, for one bracket in Python's numbers.

    A bisection replaces a secant that would leave the bracket, and some others.

    Parameters
    ----------
    function : callable
    end : float
        The other end of the bracket, of either sign.
    rises : bool
        Whether the function is positive at the end, and not positive at 0.
    guess : Crossing
    tolerance : float
        Correction that ends the search, as a share of `end`.

    Returns
    -------
    Crossing
        At an argument for which the function has been evaluated.
    """
    # One bracket in Python's numbers: arrays of one number take thirty times as long, some 300 times in an atlas.
    low, high, (new, slope) = 0.0, end, guess
    x, before = new, None
    for count in range(MOST_PATH_SECANTS):
        x = new
        value = function(x)
        low, high = (low, x) if (value > 0) == rises else (x, high)
        if before is not None and value != before[1]:
            slope = (value - before[1]) / (x - before[0])
        new, before = x - value / slope, (x, value)
        if not min(low, high) <= new <= max(low, high) or (count % 4 == 3 and count >= FREE_PATH_SECANTS):
            new = (low + high) / 2
        if abs(new - x) <= tolerance * abs(end):
            return Crossing(x, slope)
    # On steps of 1e-8 the swept parameter itself is rounded to more than the tolerance: the function is a staircase.
    # The least of several gaps can be flat up to where another one falls, on a step of many decades. There secants go
    # on for ever.
    while abs(high - low) > float_info.epsilon * abs(end) and (new := (low + high) / 2) not in (low, high):
        x = new
        low, high = (low, x) if (function(x) > 0) == rises else (x, high)
    return Crossing(x, slope)


def cubic_root(value: Floats, rise: Floats, cubic: tuple[Floats, Floats, Floats]) -> tuple[Floats, Floats]:
    """Approximate zero between 0 and 1 of a cubic whose signs differ there, and the slope near it, by Newton's method.

    Parameters
    ----------
    value, rise : ndarray
        Of the cubic: its value at 0, and how much more it is at 1.
    cubic : tuple of ndarray
        Its coefficients of x, x^2 and x^3.
    """
    c1, c2, c3 = cubic
    low, high, rising = np.zeros_like(rise), np.ones_like(rise), rise > 0
    x, slope = -value / np.where(rise == 0, 1.0, rise), rise
    for _ in range(CUBIC_STEPS):
        f = value + x * (c1 + x * (c2 + x * c3))
        slope = c1 + x * (2 * c2 + x * (3 * c3))
        upper = (f > 0) == rising
        low, high = np.where(upper, low, x), np.where(upper, x, high)
        new = x - f / np.where(slope == 0, 1.0, slope)
        # A zero that is hit exactly is left again for the middle of the bracket; the caller's search finds it.
        x = np.where((new > low) & (new < high), new, (low + high) / 2)
    return x, slope


def golden_minimum(function: Callable[[Floats], Floats], low: Floats, high: Floats, steps: int) -> Floats:
    """Arguments between `low` and `high` at which a function has minima, by golden sections; many brackets at once."""
    for _ in range(steps):
        # Both values anew in each step, where one could be kept: which one differs from bracket to bracket.
        x1, x2 = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        nearer = function(x1) < function(x2)
        low, high = np.where(nearer, low, x1), np.where(nearer, x2, high)
    return (low + high) / 2


def golden_section(function: Callable[[float], float], low: float, high: float, steps: int) -> float:
    """The argument between `low` and `high` at which a function has its minimum, for one bracket."""
    first, second = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_first, at_second = function(first), function(second)
    for _ in range(steps):
        # The golden section keeps one of the two in the part that is left, where it is the other one.
        if at_first < at_second:
            high, second, at_second = second, first, at_first
            first = high - GOLDEN * (high - low)
            at_first = function(first)
        else:
            low, first, at_first = first, second, at_second
            second = low + GOLDEN * (high - low)
            at_second = function(second)
    return (low + high) / 2


def may_hide_zeros(values: Floats) -> NDArray[np.bool_]:
    """Whether a smooth function may reach zero and come back between samples, next to each of `values[1:-1]`.

    It may where of three samples of one sign the middle one is nearest to zero, and its size is below the larger of the
    two steps to its neighbours: a smooth function moves less beyond an extremum of its samples than between them.

    Parameters
    ----------
    values : ndarray (n, ...)
        Samples in order.

    Returns
    -------
    ndarray of bool (n - 2, ...)
    """
    left, middle, right = values[:-2], values[1:-1], values[2:]
    one_side = (left * middle > 0) & (middle * right > 0)
    left, middle, right = np.abs(left), np.abs(middle), np.abs(right)
    nearest = (middle <= left) & (middle <= right)
    return np.asarray(one_side & nearest & (middle <= np.maximum(left - middle, right - middle)))
