"""Round numbers for axes, and their labels."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vireport.text import (
    MINUS,
    significant,
)

Floats = NDArray[np.float64]

PLAIN = (1e-3, 1e5)
"""Sizes of the largest between which labels are written without a power of ten."""

MOST_DIGITS = 15
"""Significant digits that a double always holds."""


def ticks(low: float, high: float, most: int) -> list[float]:
    """Multiples of a round step in a range, at most `most` of them and as many as that allows.

    Parameters
    ----------
    low, high : float
        The range, ascending.
    most : int
        At least 2.
    """
    rough = (high - low) / most
    decade = math.floor(math.log10(rough))
    for step, exponent in ((m, decade + k) for k in (0, 1) for m in (1, 2, 5)):
        found = _multiples(low, high, step, exponent)
        if len(found) <= most:
            return found
    return found[:: math.ceil(len(found) / most)]


def fitting_ticks(low: float, high: float, letters: int, most: int = 8) -> tuple[list[float], list[str]]:
    """The most ticks of a range whose labels fit beside one another, and their labels.

    Parameters
    ----------
    low, high : float
        The range, ascending.
    letters : int
        How many fit along the axis.
    most : int
    """
    for count in range(most, 1, -1):
        values = ticks(low, high, count)
        texts = tick_labels(values)
        if sum(len(text) + 2 for text in texts) <= letters:
            break
    return values, texts


def uneven_ticks(low: float, high: float, place: Callable[[Floats], Floats], room: float) -> list[float]:
    """Round numbers in a range for an axis that is not linear: finer where it is stretched.

    The roundest come first. Between two of them, the multiples of a finer step are taken all or none.

    Parameters
    ----------
    low, high : float
        The range, ascending.
    place : callable
        From values to places; monotone.
    room : float
        Least distance of two places.
    """

    def fit(values: list[float]) -> bool:
        return bool((np.abs(np.diff(place(np.array(sorted(values))))) >= room).all())

    taken: list[float] = []
    decade = math.floor(math.log10(high - low))
    for value in [
        *_decades(low, high),
        *(v for step in (5, 2, 1) for v in _multiples(low, high, step, decade)),
    ]:
        if value not in taken and fit([*taken, value]):
            taken.append(value)
    for exponent, step in ((decade - k, m) for k in (1, 2) for m in (5, 2, 1)):
        multiples = _multiples(low, high, step, exponent)
        edges = [-math.inf, *sorted(taken), math.inf]
        for left, right in pairwise(edges):
            inner = [value for value in multiples if left < value < right]
            ends = [end for end in (left, right) if math.isfinite(end)]
            if inner and all(end in multiples for end in ends) and fit([*ends, *inner]):
                taken += inner
    return sorted(taken)


def tick_labels(values: Sequence[float]) -> list[str]:
    """The labels of ticks: as many digits as set them apart, and the same number of decimals for all."""
    if not values:
        return []
    size = max(abs(value) for value in values)
    if size == 0 or PLAIN[0] <= size < PLAIN[1]:
        decimals = next(
            (k for k in range(MOST_DIGITS) if _told_apart(f"{value:.{k}f}" for value in values) and _close(values, k)),
            MOST_DIGITS,
        )
        return [f"{value:.{decimals}f}".replace("-", MINUS) if value else "0" for value in values]
    digits = next((k for k in range(1, MOST_DIGITS) if _faithful(values, k)), MOST_DIGITS)
    return [significant(value, digits) for value in values]


def _decades(low: float, high: float) -> list[float]:
    """Of a range above zero, the numbers with one digit that is 1, 2 or 5."""
    if low <= 0:
        return []
    exponents = range(math.floor(math.log10(low)), math.floor(math.log10(high)) + 1)
    return [value for k in exponents for m in (1, 2, 5) if low <= (value := float(f"{m}e{k}")) <= high]


def _multiples(low: float, high: float, step: int, exponent: int) -> list[float]:
    """Multiples of step times a power of ten, rounded to where they were meant."""
    size = step * 10.0**exponent
    first, last = math.ceil(low / size - 1e-9), math.floor(high / size + 1e-9)
    if last - first > 1000:
        return []
    return [float(f"{k * step}e{exponent}") for k in range(first, last + 1)]


def _told_apart(texts: Iterable[str]) -> bool:
    listed = list(texts)
    return len(set(listed)) == len(listed)


def _close(values: Sequence[float], decimals: int) -> bool:
    gap = min((b - a for a, b in pairwise(values)), default=abs(values[0]))
    return all(abs(round(value, decimals) - value) <= 1e-3 * gap for value in values)


def _faithful(values: Sequence[float], digits: int) -> bool:
    gap = min((b - a for a, b in pairwise(values)), default=abs(values[0]))
    return all(abs(float(f"{value:.{digits - 1}e}") - value) <= 1e-3 * gap for value in values)
