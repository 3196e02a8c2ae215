"""Every zero of G, the function whose zeros are 1:1 motions, for many design points at once.

A change of sign between two samples of `phase_forms.Grid` is a zero; two or three zeros between two samples show in
the slopes there.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.phase_forms import STEP, Points

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

BLOCK_VALUES = 60_000
"""Samples of G that are held at once: they stay in the processor's cache."""

DOUBTFUL = 1e-2
"""Share of the larger end value that an extremum between two samples must keep to be no pair of zeros. A cubic
through values and slopes of two samples is wrong by less than a tenth of it."""

LAST_STEP = 2e-16
"""Step of a root search, as a share of u, at which it ends."""

FLAT = 1e-9
"""Step of the search for an extremum, as a share of u, at which it ends: half the digits of u give all of G there."""

MOST_STEPS = 80
"""More than the search for a root needs with bisections alone in three steps of four."""

CUBIC_STEPS = 7
"""Newton steps on the cubic: what they leave open is left to the exact function."""


@dataclass(frozen=True, slots=True, eq=False)
class Brackets:
    """Intervals of u, with the values and slopes of G at their ends; arrays of one length.

    Attributes
    ----------
    which : ndarray of int
        Of the design points.
    low, high, value_low, value_high, slope_low, slope_high : ndarray
    """

    which: Ints
    low: Floats
    high: Floats
    value_low: Floats
    value_high: Floats
    slope_low: Floats
    slope_high: Floats

    def pick(self, index: Mask) -> Brackets:
        """Those chosen by an index or mask."""
        return Brackets(*(getattr(self, field.name)[index] for field in fields(Brackets)))

    @property
    def cubic(self) -> tuple[Floats, Floats, Floats]:
        """Coefficients of x, x^2 and x^3 of the cubic through values and slopes, x being the share of the interval."""
        rise, width = self.value_high - self.value_low, self.high - self.low
        one, two = self.slope_low * width, self.slope_high * width
        return one, 3 * rise - 2 * one - two, one + two - 2 * rise


def _joined(parts: list[Brackets]) -> Brackets:
    return Brackets(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Brackets)))


def zeros(points: Points) -> tuple[Ints, Floats, Floats]:
    """All zeros of G: the design point that each belongs to, u, and the phase at the bottom impact."""
    return _polished(points, _brackets(points))


def _brackets(points: Points) -> Brackets:
    """Every interval of u with one zero of G in it."""
    grid = points.grid
    crossing: list[Brackets] = []
    dipping: list[Brackets] = []
    beside: list[Brackets] = []
    size = max(BLOCK_VALUES // len(grid.u), 1)
    for first in range(0, len(points.d), size):
        part = slice(first, first + size)
        values, slopes = points.on_grid(part)
        crosses, dips, turns = _pattern(values[:, :-1], values[:, 1:], slopes[:, :-1], slopes[:, 1:])
        near = np.zeros_like(crosses)
        near[:, 1:] |= crosses[:, :-1]
        near[:, :-1] |= crosses[:, 1:]
        near &= ~(crosses | turns)
        for where, found in ((crosses, crossing), (dips, dipping), (near, beside)):
            k, i = np.divmod(np.flatnonzero(where), where.shape[1])
            ends = (values[k, i], values[k, i + 1], slopes[k, i], slopes[k, i + 1])
            found.append(Brackets(k + first, grid.u[i], grid.u[i + 1], *ends))
    plain, halves = _unfolded(points, _joined(crossing), _joined(beside))
    crosses, dips, _ = _pattern(halves.value_low, halves.value_high, halves.slope_low, halves.slope_high)
    cut = _split(points, _joined([*dipping, halves.pick(dips)]))
    return _joined([plain, halves.pick(crosses), *cut])


def _pattern(low: Floats, high: Floats, slope_low: Floats, slope_high: Floats) -> tuple[Mask, Mask, Mask]:
    """Where G changes sign; where it has one sign and an extremum that points towards zero; where its slope turns."""
    positive, rising = high > 0, slope_high > 0
    crosses = positive != (low > 0)
    turns = rising != (slope_low > 0)
    return crosses, turns & (rising == positive) & ~crosses, turns


def _unfolded(points: Points, crossing: Brackets, beside: Brackets) -> tuple[Brackets, Brackets]:
    """Find intervals in which G turns twice, as it does next to a cusp of its zeros, and halve them in between.

    Returns
    -------
    Brackets
        The crossings that do not.
    Brackets
        Both halves of those that do, of `crossing` and of the neighbours `beside`, where three zeros are close.
    """
    both = _joined([crossing, beside])
    one, bend, twist = both.cubic
    x = -bend / np.where(twist == 0, 1.0, 3 * twist)
    between = one + bend * x
    waves = (x > 0) & (x < 1) & (between * one < 0) & (between * both.slope_high < 0)
    b, u = both.pick(waves), (both.low + x * (both.high - both.low))[waves]
    f = points.value(b.which, u + 1j * STEP)[0]
    value, slope = f.real, f.imag / STEP
    halves = [
        replace(b, high=u, value_high=value, slope_high=slope),
        replace(b, low=u, value_low=value, slope_low=slope),
    ]
    return crossing.pick(~waves[: len(crossing.which)]), _joined(halves)


def _split(points: Points, b: Brackets) -> list[Brackets]:
    """Cut intervals at the extremum of G, where it has another sign there."""
    one, bend, twist = b.cubic
    two = one + 2 * bend + 3 * twist
    root = np.sqrt(np.maximum(bend * bend - 3 * twist * one, 0.0))
    bottom = bend + np.where(two > one, root, -root)
    x = np.clip(-one / np.where(bottom == 0, 1.0, bottom), 0.0, 1.0)
    value = b.value_low + x * (one + x * (bend + x * twist))
    near = np.sign(b.value_low) * value < DOUBTFUL * np.maximum(np.abs(b.value_low), np.abs(b.value_high))
    b, u = b.pick(near), (b.low + x * (b.high - b.low))[near]
    u = _extremum(points, b, u)
    value = points.value(b.which, u)[0]
    across = (value > 0) != (b.value_low > 0)
    b, u, value = b.pick(across), u[across], value[across]
    flat = np.zeros_like(u)
    return [
        replace(b, high=u, value_high=value, slope_high=flat),
        replace(b, low=u, value_low=value, slope_low=flat),
    ]


def _extremum(points: Points, b: Brackets, u: Floats) -> Floats:
    """Zero of the slope of G in each interval, from a first guess: secant steps kept inside a bracket."""
    result = u.copy()
    index = np.arange(len(u))
    which, low, high, f_low, f_high = b.which, b.low, b.high, b.slope_low, b.slope_high
    for step in range(MOST_STEPS):
        if not index.size:
            break
        f = points.value(which, u + 1j * STEP)[0].imag / STEP
        lower = (f > 0) == (f_low > 0)
        f_low, f_high = np.where(lower, f, f_low / 2), np.where(lower, f_high / 2, f)
        low, high = np.where(lower, u, low), np.where(lower, high, u)
        span = f_high - f_low
        secant = low - f_low * (high - low) / np.where(span == 0, 1.0, span)
        inside = (secant > low) & (secant < high) & (step % 4 != 3)
        new = np.where(f == 0, u, np.where(inside, secant, (low + high) / 2))
        result[index] = new
        go = np.abs(new - u) > FLAT * np.abs(new)
        index, which, u = index[go], which[go], new[go]
        low, high, f_low, f_high = low[go], high[go], f_low[go], f_high[go]
    return result


def _polished(points: Points, b: Brackets) -> tuple[Ints, Floats, Floats]:
    """Design point, u and phase of the zero of G in each interval, to the last digit that G has."""
    share, slope = _cubic_zero(b)
    u, f_before, before = b.low + share * (b.high - b.low), b.value_low, b.low
    found, phi, index = u.copy(), np.zeros_like(u), np.arange(len(u))
    which, low, high, rising = b.which, b.low, b.high, b.value_high > 0
    for step in range(MOST_STEPS):
        if not index.size:
            break
        f, sine, cosine, delta = points.value(which, u)
        if step:  # the first step takes the slope of the cubic, the others that of the chord
            moved, change = u - before, f - f_before
            fit = (moved != 0) & (change != 0)
            slope = np.where(fit, change / np.where(fit, moved, 1.0), slope)
        upper = (f > 0) == rising
        low, high = np.where(upper, low, u), np.where(upper, u, high)
        new = u - f / np.where(slope == 0, 1.0, slope)
        usable = (new >= low) & (new <= high) & (slope != 0) & (step < 8 or step % 4 != 3)
        new = np.where(usable, new, (low + high) / 2)
        sign = np.where(delta < 0, -1.0, 1.0)
        found[index], phi[index] = u, np.arctan2(sign * sine, sign * cosine)
        go = (np.abs(new - u) > LAST_STEP * np.abs(u)) & (f != 0)
        index, which, before, f_before, u = index[go], which[go], u[go], f[go], new[go]
        low, high, slope, rising = low[go], high[go], slope[go], rising[go]
    return b.which, found, phi


def _cubic_zero(b: Brackets) -> tuple[Floats, Floats]:
    """Share of each interval at which its cubic vanishes, and the slope there, per unit of u."""
    one, bend, twist = b.cubic
    rise = b.value_high - b.value_low
    low, high, rising = np.zeros_like(rise), np.ones_like(rise), rise > 0
    x, slope = -b.value_low / np.where(rise == 0, 1.0, rise), rise
    for _ in range(CUBIC_STEPS):
        f = b.value_low + x * (one + x * (bend + x * twist))
        slope = one + x * (2 * bend + x * (3 * twist))
        upper = (f > 0) == rising
        low, high = np.where(upper, low, x), np.where(upper, x, high)
        new = x - f / np.where(slope == 0, 1.0, slope)
        x = np.where((new > low) & (new < high), new, (low + high) / 2)
    return x, slope / (b.high - b.low)
