"""Roots and extrema of functions of one variable, for arrays of brackets at once.

Every root here has a bracket that is never left, so that none is lost and none is found twice.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

ADJACENT = 4e-16
"""Width of a bracket, relative to its lower end, at which no double but one or two is left in it."""

MOST_HALVINGS = 200
"""More than bisection alone in one step of three needs to exhaust a double."""

MOST_NEWTON_STEPS = 60
"""More than bisection needs to exhaust a double; Newton's steps end the search after four to seven."""

MANY = 1000
"""Brackets from which it pays to leave out those that are settled."""

MOST_SECANT_STEPS = 80
"""More than bisections alone need in one step of four to exhaust the digits that are left to a start."""

FREE_STEPS = 8
"""Secant steps, of which four are usual, before every fourth step is a bisection."""

CUBIC_STEPS = 7
"""Newton steps on a cubic, whose zero only has to be a good start."""

GOLDEN = (5**0.5 - 1) / 2
"""Share by which a golden section narrows a bracket."""


def bracketed_root(
    function: Callable[[Floats], Floats],
    low: Floats,
    high: Floats,
    tolerance: float = 0.0,
    values: tuple[Floats, Floats] | None = None,
) -> Floats:
    """Zeros of a function between `low` and `high`, where its signs differ, by secant steps and bisections.

    The Illinois rule, with every third step a bisection.

    Parameters
    ----------
    function : callable
        Takes the arguments of all brackets and returns the values.
    low, high : ndarray
        Ends of the brackets, in either order.
    tolerance : float
        Width of the last bracket; 0 for the last bit.
    values : tuple of ndarray, optional
        Of the function at both ends, where they are known.
    """
    if not low.size:
        return low
    f_low, f_high = values or (function(low), function(high))
    for iteration in range(MOST_HALVINGS):
        bisecting = iteration % 3 == 2
        with np.errstate(invalid="ignore", divide="ignore"):
            secant = (low * f_high - high * f_low) / (f_high - f_low)
        usable = (secant > np.minimum(low, high)) & (secant < np.maximum(low, high)) & (not bisecting)
        x = np.where(usable, secant, low + (high - low) / 2)
        f = function(x)
        replace_low = (f > 0) == (f_low > 0)
        # An end that stays is given half its value: false position alone would keep it for good where the function is
        # convex, and creep up to the root from the other side.
        weight = 1.0 if bisecting else 0.5
        f_high = np.where(replace_low, f_high * weight, f)
        f_low = np.where(replace_low, f, f_low * weight)
        high = np.where(replace_low, high, x)
        low = np.where(replace_low, x, low)
        if np.all((np.abs(high - low) <= tolerance + ADJACENT * np.abs(low)) | (f == 0)):
            break
    return np.where(f == 0, x, high)


def newton_root(
    function: Callable[[Floats, Ints], tuple[Floats, Floats]],
    low: Floats,
    high: Floats,
    rising: NDArray[np.bool_],
    tolerance: float,
) -> Floats:
    """Zeros between `low` and `high` by Newton's method, with a bisection where a step would leave the bracket.

    Parameters
    ----------
    function : callable
        Takes arguments and the indices of the brackets they belong to, and returns values and derivatives.
    low, high : ndarray
        Lower and upper ends of the brackets.
    rising : ndarray of bool
        Whether the function is positive at the upper end.
    tolerance : float
        Newton step at which a search ends, relative to the zero or to 1.
    """
    x = root = (low + high) / 2
    active = np.arange(len(x))
    for _ in range(MOST_NEWTON_STEPS):
        value, slope = function(x, active)
        upper = (value > 0) == rising
        low, high = np.where(upper, low, x), np.where(upper, x, high)
        sloping = slope != 0
        step = value / np.where(sloping, slope, 1.0)
        settled = (np.abs(step) <= tolerance * np.maximum(np.abs(x), 1.0)) & sloping
        if settled.all():
            break
        new = x - step
        inside = (new > low) & (new < high) & sloping
        x = np.where(settled, x, np.where(inside, new, (low + high) / 2))
        # To copy what is left costs as much as a step: only where that halves the work, and the arrays are long.
        if x.size > MANY and 2 * np.count_nonzero(settled) > x.size:
            root[active] = x
            active, x, low, high, rising = (array[~settled] for array in (active, x, low, high, rising))
    root[active] = x
    return root


def secant_root(
    function: Callable[[Floats, Ints], Floats],
    bracket: tuple[Floats, Floats],
    start: Floats,
    rising: NDArray[np.bool_],
    chord: tuple[Floats, Floats, Floats],
    tolerance: float,
) -> Floats:
    """Zeros from a guess, by secant steps and by bisections where one would leave the bracket; many at once.

    Parameters
    ----------
    function : callable
        Takes arguments and the indices of the brackets they belong to. A root is the last argument that it was called
        with for its bracket.
    bracket : tuple of ndarray
        Lower and upper ends.
    start : ndarray
        Inside the bracket, where the search begins.
    rising : ndarray of bool
        Whether the function is positive at the upper end.
    chord : tuple of ndarray
        Slope with which the first step is made, and another argument with its value.
    tolerance : float
        Step at which a search ends, relative to the zero.
    """
    (low, high), x, (slope, before, f_before) = bracket, start, chord
    root, active = x.copy(), np.arange(len(x))
    for step in range(MOST_SECANT_STEPS):
        if not active.size:
            break
        f = function(x, active)
        # The first slope is the caller's, of a cubic or chord; from then on it is that of the last two values.
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


def cubic_root(value: Floats, rise: Floats, cubic: tuple[Floats, Floats, Floats]) -> tuple[Floats, Floats]:
    """About the zero between 0 and 1 of a cubic whose signs differ there, and the slope near it, by Newton's method.

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
    """Arguments between `low` and `high` at which a function has its minima, by so many golden sections."""
    for _ in range(steps):
        # Both values anew in each step, where one could be kept: which one differs from bracket to bracket.
        x1, x2 = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        nearer = function(x1) < function(x2)
        low, high = np.where(nearer, low, x1), np.where(nearer, x2, high)
    return (low + high) / 2


def may_hide_zeros(values: Floats) -> NDArray[np.bool_]:
    """Whether at the samples `values[1:-1]` of a smooth function it may reach zero and come back between two samples.

    So where a sample is the nearest to zero of three of one sign, and nearer than the larger step to it is high: a
    smooth function moves less beyond an extremum of its samples than between them.
    """
    left, middle, right = values[:-2], values[1:-1], values[2:]
    one_side = (left * middle > 0) & (middle * right > 0)
    left, middle, right = np.abs(left), np.abs(middle), np.abs(right)
    nearest = (middle <= left) & (middle <= right)
    return np.asarray(one_side & nearest & (middle <= np.maximum(left - middle, right - middle)))
