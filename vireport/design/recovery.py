"""How long a small disturbance of a stable motion takes to die out."""

from __future__ import annotations

from enum import StrEnum
from math import inf, log

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.design.solution import Solution
from vireport.motions.stability import discriminant
from vireport.physics.numbers import FUNCTION, UNIT

Floats = NDArray[np.float64]

LEFT = 0.01
"""Share of a disturbance that is left when the motion counts as recovered."""

MODULUS_ROUNDINGS = 8
"""Number of relative roundings of a modulus: of the discriminant, its root and the sum, with room."""


class NoRecovery(StrEnum):
    """Why no time of recovery is stated, in words."""

    NOT_STABLE = "there is no stable 1:1 motion at the design point"
    AT_EVENT = "within its error bound the motion is at the end of its stability, where disturbances do not die out"


class Recovery(Struct, frozen=True):
    """Time until 1 % of a small disturbance is left.

    Attributes
    ----------
    periods : float
        The time in forcing periods; not a whole number.
    seconds : float
        The time [s].
    error_bound : float
        Bound of the error of `periods`.
    """

    periods: float
    seconds: float
    error_bound: float


def largest_modulus(trace: Floats, decay: Floats | float) -> Floats:
    """Modulus of the larger multiplier, by the trace and the root of the determinant, with all digits everywhere."""
    # By the size of the trace, in which nothing cancels: the signs of both multipliers do not matter. Complex ones have
    # the decay as their modulus, and real ones have a larger one of at least that.
    size = np.abs(trace)
    return np.asarray(np.maximum((size + np.sqrt(np.maximum(discriminant(size, decay), 0.0))) / 2, decay))


def recovery_of(solution: Solution) -> Recovery | NoRecovery:
    """Time in which the slowest stable 1:1 motion at the design point recovers: `ln 100/(-ln |multiplier|)` periods.

    Periods are those of the motion, and the multiplier is the larger one: the other part of a disturbance dies out
    sooner. A disturbance that is not small may take longer, or not die out at all.
    """
    design, bounds = solution.design, solution.bounds.design
    if design is None or bounds is None or not design.motions.stable_mask.any():
        return NoRecovery.NOT_STABLE
    motions, device = design.motions.select(design.motions.stable_mask), solution.device
    trace, error = np.abs(motions.trace), bounds["trace"][design.motions.stable_mask]
    decay = np.broadcast_to(motions.decay, trace.shape)
    # The determinant is the square: its relative error is twice as large.
    share = bounds["determinant"][design.motions.stable_mask] / np.maximum(2 * decay**2, np.finfo(float).tiny) + UNIT
    slow, fast = trace + error, np.maximum(trace - error, 0)
    low, high = decay * (1 - share), decay * (1 + share)
    # At a trace the modulus is least where both multipliers are alike, and grows to both sides of that decay.
    most = np.maximum(largest_modulus(slow, low), largest_modulus(slow, high)).max()
    least = largest_modulus(fast, np.clip(fast / 2, low, high)).max()
    ratio = device.period_ratio
    longest = _periods(float(most), ratio, 1)
    if longest == inf:
        return NoRecovery.AT_EVENT
    periods = _periods(float(largest_modulus(trace, decay).max()), ratio)
    bound = max(longest - periods, periods - _periods(float(least), ratio, -1))
    return Recovery(periods, periods / float(device.frequency_hz), bound)


def _periods(modulus: float, ratio: int, side: int = 0) -> float:
    """Forcing periods until 1 % is left; inf where it does not die out.

    With `side` 1 it is the longest, with -1 the shortest, that rounding of modulus, logarithms and quotient allows.
    """
    if modulus == 0:
        return 0.0
    rate = -log(modulus)
    rate -= side * (MODULUS_ROUNDINGS * UNIT + 2 * FUNCTION * abs(rate))
    return ratio * -log(LEFT) / rate * (1 + side * 4 * FUNCTION) if rate > 0 else inf
