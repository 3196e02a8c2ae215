"""Means along a record and their 95 % intervals, from the means of its parts (batch means)."""

from __future__ import annotations

from enum import StrEnum
from math import sqrt

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CONFIDENCE = 0.95
MOST_PARTS, FEWEST_PARTS = 30, 10
"""Into which a record is cut: of fewer the spread says little, and more only make each shorter."""

LEAST_PERIODS = 10
"""In a part, which must be far longer than the motion remembers."""

ALIKE = 2.33
"""Standard deviations by which the correlation of neighbouring parts may exceed 0: by chance in one case of 100."""


class NoInterval(StrEnum):
    """Why a mean has no interval."""

    SHORT = "short"
    DRIFTS = "drifts"


class Mean(Struct, frozen=True):
    """A mean along a record, with its 95 % interval.

    Attributes
    ----------
    value : float
    low, high : float or None
        Ends of the 95 % interval; None where there is none.
    why : NoInterval or None
        Why there is no interval.
    """

    value: float
    low: float | None = None
    high: float | None = None
    why: NoInterval | None = None


def parts_of(periods: int) -> int:
    """Number of parts into which some periods are cut; fewer than `FEWEST_PARTS` give no interval."""
    return min(MOST_PARTS, periods // LEAST_PERIODS)


def batched(sums: Floats, sizes: Floats) -> Mean:
    """The mean of a quantity from its sums over the parts of a record, with its 95 % interval.

    Parameters
    ----------
    sums : ndarray, shape (parts,)
        Sum of the quantity over each part.
    sizes : ndarray, shape (parts,)
        What the mean is over: the time of each part, or its number of impacts.

    Notes
    -----
    Batch means (Law, Simulation Modeling and Analysis, 9.5.3) and not a bootstrap of blocks: a part is far longer than
    the few periods that the motion remembers, so that the parts are practically independent, and their spread gives the
    variance without a length of blocks to be chosen. Independence is tested by the correlation of each part with the
    next; where the test fails, no interval is given. With the ratio R = S/N of the sums the deviation of a part is
    s - R n.
    """
    ratio = float(sums.sum() / sizes.sum())
    count = len(sums)
    if count < FEWEST_PARTS:
        return Mean(ratio, why=NoInterval.SHORT)
    off = sums - ratio * sizes
    square = float(off @ off)
    # A motion that repeats itself to rounding has no spread; the correlation of rounding would look like a drift.
    if square <= (1e-9 * ratio) ** 2 * float(sizes @ sizes):
        return Mean(ratio, ratio, ratio)
    if float(off[1:] @ off[:-1]) / square > ALIKE / sqrt(count):
        return Mean(ratio, why=NoInterval.DRIFTS)
    from scipy.special import stdtrit  # type: ignore[import-untyped]

    # Student's t: the spread is itself estimated, by some ten to thirty parts.
    error = sqrt(square / (count * (count - 1))) / float(sizes.mean())
    half = float(stdtrit(count - 1, (1 + CONFIDENCE) / 2)) * error
    return Mean(ratio, ratio - half, ratio + half)
