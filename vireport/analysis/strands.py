"""The level curve of a sweep, cut into strands: smooth curves with a parameter, none of them missed.

Above each q a level a sin(phi) + b cos(phi) = c has two motions where |c| < (a^2 + b^2)^(1/2), one where they meet,
none beyond. So a sweep's motions lie above the intervals of q where that holds, on an upper and a lower sheet that
join smoothly at each end that is a meeting. One parameter w runs over both: q = middle - half cos(w), upper sheet
for 0 < w < pi, lower for pi < w < 2 pi.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.orbits import Level, Orbits, coefficients, level_terms, orbits_above

Floats = NDArray[np.float64]

EDGE = 0.5
"""|u| at which one of the two flights has no duration left."""

TINIEST_FEATURE = -18
"""Decade of u down to which existence is looked for next to the symmetric line; `model.NO_GRAVITY` lies above."""


@dataclass(frozen=True, slots=True)
class Strand:
    """One smooth piece of the level curve.

    Attributes
    ----------
    low, high : float
        Ends of its interval of u = q - 1/2; equal on the symmetric line, where w is the phase itself.
    start, end : float
        Range of the parameter w [rad].
    closed : bool
        Whether the end is the start.
    """

    low: float
    high: float
    start: float
    end: float
    closed: bool

    @property
    def sheet(self) -> float:
        """The sheet of a strand that runs from edge to edge on one, 1 or -1; 0 where it runs on both."""
        if self.low != -EDGE or self.high != EDGE:
            return 0.0
        return 1.0 if self.start == 0 else -1.0

    @property
    def symmetric(self) -> bool:
        """Whether this is the symmetric line u = 0 of a horizontal capsule."""
        return self.low == self.high


def find_strands(level: Level, r: float, n: int) -> list[Strand]:
    """Every strand of a level curve over 0 < q < 1.

    Parameters
    ----------
    level : Level
        What the sweep holds.
    r : float
        Restitution coefficient, 0 <= r < 1.
    n : int
        Forcing periods per motion.
    """
    strands = []
    if level.horizontal and n % 2:
        strands.append(Strand(0.0, 0.0, -np.pi, np.pi, closed=True))
    for low, high in _existence(level, r, n):
        if low == -EDGE and high == EDGE:
            strands += [Strand(low, high, 0.0, np.pi, False), Strand(low, high, np.pi, 2 * np.pi, False)]
        elif high == EDGE:
            strands.append(Strand(low, high, -np.pi, np.pi, False))
        else:
            strands.append(Strand(low, high, 0.0, 2 * np.pi, low != -EDGE))
    return strands


@lru_cache(maxsize=64)
def reach(r: float, n: int) -> tuple[float, float]:
    """Largest d and gbar of any motion, with a little room."""
    k = coefficients(np.linspace(-EDGE, EDGE, 4096 * n + 1), r, n)
    d, gbar = np.hypot(k.d_sine, k.d_cosine), np.hypot(k.gbar_sine, k.gbar_cosine)
    return 1.001 * float(d.max()), 1.001 * float(gbar.max())


def evaluate(strands: list[Strand], which: NDArray[np.intp], w: Floats, level: Level, r: float, n: int) -> Orbits:
    """Motions at parameters `w` of the strands `which`, arrays of one shape."""
    low = np.array([s.low for s in strands])[which]
    width = np.array([s.high - s.low for s in strands])[which]
    half_angle = w / 2
    near_low = width * np.sin(half_angle) ** 2
    near_high = width * np.cos(half_angle) ** 2
    # Measured from the nearer end, so that u keeps its relative accuracy where the sheets meet.
    u = np.where(near_low <= near_high, low + near_low, low + width - near_high)
    known = coefficients(u, r, n)
    a, b, c = level_terms(level, known, u, r, n)
    norm = np.hypot(a, b)
    ratio = np.clip(c / np.where(norm == 0, 1.0, norm), -1.0, 1.0)
    # An open strand ends on one sheet, at an edge where the two do not meet: there w must not be taken modulo 2 pi.
    own = np.array([s.sheet for s in strands])[which]
    turned = np.where(np.array([s.closed for s in strands])[which], np.mod(w, 2 * np.pi), w)
    sheet = np.where(own != 0, own, np.where((turned < 0) | (turned > np.pi), -1.0, 1.0))
    phi = np.arctan2(a, b) + sheet * np.arccos(ratio)
    phi = np.where(width == 0, w, phi)
    return orbits_above(known, u, np.mod(phi, 2 * np.pi), r, n)


def _existence(level: Level, r: float, n: int) -> list[tuple[float, float]]:
    """Intervals of u in which the level has motions.

    The margin a^2 + b^2 - c^2 is sampled far below its shortest wavelength 1/(2n) and, next to u = 0 and to the
    edges, where d vanishes, in every decade down to rounding; its zeros are then bisected, and its extrema that
    come close to zero without crossing it are refined first.
    """

    def margin(u: Floats) -> Floats:
        a, b, c = level_terms(level, coefficients(u, r, n), u, r, n)
        return np.asarray(np.hypot(a, b) - np.abs(c))

    even = np.linspace(-EDGE, EDGE, 256 * n + 1)
    decades = 10.0 ** np.arange(TINIEST_FEATURE, -2, 0.25)
    near_edge = EDGE - decades[decades > 1e-12]
    grid = np.sort(np.concatenate([even, decades, -decades, near_edge, -near_edge]))
    values = margin(grid)
    grid, values = _with_extrema(grid, values, margin)
    inside = values > 0
    flips = np.nonzero(inside[1:] != inside[:-1])[0]
    roots = bisect(margin, grid[flips], grid[flips + 1])
    ends = np.concatenate([[-EDGE] if inside[0] else [], roots, [EDGE] if inside[-1] else []])
    return [(float(ends[i]), float(ends[i + 1])) for i in range(0, len(ends), 2)]


def _with_extrema(grid: Floats, values: Floats, function: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
    """Add the extrema of `values` that point towards zero, where a pair of zeros could hide between samples."""
    middle, left, right = values[1:-1], values[:-2], values[2:]
    towards = (np.abs(middle) <= np.abs(left)) & (np.abs(middle) <= np.abs(right))
    same = (middle * left > 0) & (middle * right > 0)
    # A smooth function moves less beyond an extremum of its samples than between them.
    reach = np.abs(middle) <= np.maximum(np.abs(left - middle), np.abs(right - middle))
    index = np.nonzero(towards & same & reach)[0] + 1
    if not index.size:
        return grid, values
    low, high = grid[index - 1], grid[index + 1]
    sign = np.sign(values[index])
    golden = (np.sqrt(5) - 1) / 2
    for _ in range(60):
        x1, x2 = high - golden * (high - low), low + golden * (high - low)
        nearer = sign * function(x1) < sign * function(x2)
        low, high = np.where(nearer, low, x1), np.where(nearer, x2, high)
    extra = (low + high) / 2
    grid = np.concatenate([grid, extra])
    order = np.argsort(grid, kind="stable")
    return grid[order], np.concatenate([values, function(extra)])[order]


def bisect(function: Callable[[Floats], Floats], low: Floats, high: Floats, tolerance: float = 0.0) -> Floats:
    """Zeros between `low` and `high`, where the sign of a function of an array differs, to a tolerance or the last bit.

    Bisection with secant steps (the Illinois rule) in between; the bracket is never left.
    """
    if not low.size:
        return low
    f_low, f_high = function(low), function(high)
    for iteration in range(200):
        with np.errstate(invalid="ignore", divide="ignore"):
            secant = (low * f_high - high * f_low) / (f_high - f_low)
        middle = low + (high - low) / 2
        usable = (secant > np.minimum(low, high)) & (secant < np.maximum(low, high)) & (iteration % 3 != 2)
        x = np.where(usable, secant, middle)
        f = function(x)
        replace_low = (f > 0) == (f_low > 0)
        halve = np.where(iteration % 3 == 2, 1.0, 0.5)
        f_high = np.where(replace_low, f_high * halve, f)
        f_low = np.where(replace_low, f, f_low * halve)
        high = np.where(replace_low, high, x)
        low = np.where(replace_low, x, low)
        if np.all((np.abs(high - low) <= tolerance + 4e-16 * np.abs(low)) | (f == 0)):
            break
    return np.where(f == 0, x, high)
