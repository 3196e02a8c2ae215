"""Signals filtered, resampled and searched for peaks by NumPy alone: `scipy.signal` takes most of a second to load."""

from __future__ import annotations

from functools import lru_cache
from math import pi, sqrt, tan

import numpy as np

from vireport.measurement.flights import Array, Indices

BLOCK = 256
"""Samples that are filtered by one product of matrices."""

LOBES, KAISER = 10, 5.0
"""Zeros of the sine over its argument to either side that a resampling filter has, and the shape of its window."""


def high_pass(signal: Array, cut: float) -> Array:
    """A signal that was zero before it begins, through a Butterworth high-pass of second order.

    Parameters
    ----------
    signal : array (n,)
    cut : float
        Frequency at which half of the power passes, over the sampling rate.
    """
    k = tan(pi * cut)  # of the bilinear transform, which moves no such frequency
    gain = 1 / (1 + sqrt(2) * k + k**2)
    back = np.array([2 * (k**2 - 1) * gain, (1 - sqrt(2) * k + k**2) * gain])
    driven = gain * np.convolve(signal, (1.0, -2.0, 1.0))[: len(signal)]
    # y[n] = driven[n] - back[0] y[n-1] - back[1] y[n-2]: by blocks, what they are driven by and what was before them.
    response = np.zeros(BLOCK + 1)
    response[1] = 1.0
    for n in range(2, BLOCK + 1):
        response[n] = -back[0] * response[n - 1] - back[1] * response[n - 2]
    before = np.stack([-back[0] * response[1:] - back[1] * response[:-1], -back[1] * response[1:]])
    lags = np.arange(BLOCK) - np.arange(BLOCK)[:, None]
    filtered = np.pad(driven, (0, -len(driven) % BLOCK)).reshape(-1, BLOCK) @ np.where(
        lags < 0, 0.0, response[lags + 1]
    )
    last = np.zeros(2)
    for block in filtered:
        block += last @ before
        last = block[:-3:-1]
    return filtered.ravel()[: len(signal)]


def averaged(signal: Array, count: int) -> Array:
    """The mean of so many samples around every one; beyond its ends the signal goes on as its mirror image."""
    before = count // 2
    return np.convolve(np.pad(signal, (before, count - 1 - before), "symmetric"), np.full(count, 1 / count), "valid")


def resampled(signal: Array, factor: int) -> Array:
    """A signal at so many times its rate, as one that has nothing beyond half of it.

    Beyond its ends it is taken to go on along the straight line through both.
    """
    count, beyond = len(signal), np.arange(1, LOBES + 1)
    slope = (signal[-1] - signal[0]) / (count - 1)
    longer = np.concatenate([signal[0] - slope * beyond[::-1], signal, signal[-1] + slope * beyond])
    between = np.zeros(len(longer) * factor)
    between[::factor] = longer
    return np.convolve(between, _interpolating(factor))[2 * LOBES * factor :][: count * factor]


@lru_cache(64)
def _interpolating(factor: int) -> Array:
    """The sine over its argument in a Kaiser window, which leaves a constant as it is."""
    half = LOBES * factor
    weights = np.sinc(np.arange(-half, half + 1) / factor) * np.kaiser(2 * half + 1, KAISER)
    return np.asarray(factor * weights / weights.sum())


def peaks_of(signal: Array) -> Indices:
    """Where a signal is higher than before and after; of several equal samples the middle one."""
    steps = np.sign(np.diff(signal))
    turns = np.flatnonzero(steps)
    tops = np.flatnonzero((steps[turns][:-1] > 0) & (steps[turns][1:] < 0))
    return np.asarray((turns[tops] + 1 + turns[tops + 1]) // 2)
