"""How long a small disturbance of a stable motion takes to die out."""

from __future__ import annotations

from math import inf, log

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.design import Solution
from vireport.motions import multipliers

Floats = NDArray[np.float64]

LEFT = 0.01
"""Share of a disturbance that is left when the motion counts as recovered."""


class Recovery(Struct, frozen=True):
    """Time until 1 % of a small disturbance is left.

    Attributes
    ----------
    periods : float
        In forcing periods; not a whole number.
    seconds : float
    error_bound : float
        Of the periods.
    """

    periods: float
    seconds: float
    error_bound: float


def largest_modulus(trace: Floats, decay: Floats | float) -> Floats:
    """Modulus of the larger multiplier, by the trace and the root of the determinant."""
    modulus: Floats = np.abs(multipliers(trace, decay * decay)[:, 0])
    return modulus


def recovery_of(solution: Solution) -> Recovery | None:
    """Time in which the slowest stable 1:1 motion at the design point recovers: ln 100/(-ln |multiplier|) periods.

    Of the multipliers the larger counts: the other part of a disturbance dies out sooner. A disturbance that is not
    small may take longer, or not die out at all. None where no motion is stable.
    """
    design, bounds = solution.design, solution.bounds.design
    if design is None or bounds is None or not design.motions.stable_mask.any():
        return None
    motions, device = design.motions, solution.device
    trace, error = np.abs(motions.trace[motions.stable_mask]), bounds["trace"][motions.stable_mask]
    decay = motions.select(motions.stable_mask).decay
    # The modulus grows with that of the trace, or is the root of the determinant.
    least, found, most = (
        _periods(float(largest_modulus(size, decay).max()), device.period_ratio)
        for size in (np.maximum(trace - error, 0), trace, trace + error)
    )
    return Recovery(found, found / float(device.frequency_hz), max(most - found, found - least))


def _periods(modulus: float, ratio: int) -> float:
    """Forcing periods until 1 % is left; inf where it does not die out."""
    if modulus >= 1:
        return inf
    return ratio * log(LEFT) / log(modulus) if modulus > 0 else 0.0
