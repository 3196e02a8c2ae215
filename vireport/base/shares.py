"""The interval of a share that was counted in random trials."""

from __future__ import annotations

from math import sqrt

NORMAL_95 = 1.959963984540054
"""Quantile of the normal distribution for a two-sided interval of 95 %."""


def wilson(hits: int, trials: int) -> tuple[float, float, float]:
    """Share of hits, and the ends of its 95 % confidence interval, by Wilson's score."""
    share, z2 = hits / trials, NORMAL_95**2
    centre = (share + z2 / (2 * trials)) / (1 + z2 / trials)
    half = NORMAL_95 * sqrt(share * (1 - share) / trials + z2 / (4 * trials**2)) / (1 + z2 / trials)
    return share, max(centre - half, 0.0) if hits else 0.0, min(centre + half, 1.0) if hits < trials else 1.0
