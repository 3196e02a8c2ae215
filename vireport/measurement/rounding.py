"""Times that are rounded to multiples of a step: the step, and the times with independent errors added.

Rounding errors of a periodic motion repeat with it. A fit would take most of them for no errors and the others for
false impacts, and its tests would see another motion in the rest. So independent normal errors are added whose mean
over all repetitions is as large as a single rounding error: then errors average as a fit expects.
"""

from __future__ import annotations

from itertools import takewhile
from math import sqrt

import numpy as np
from msgspec import Struct

from vireport.measurement.flights import Array

WHOLE = 0.02
"""Share of a step by which times may miss its multiples: they are printed with some digits. By chance not ten random
times do."""

PARTS, MOST_TRIED = 24, 200
"""Steps in a difference of two flights that are next to each other in size, and how many of these are tried."""

FEWEST = 20
"""Impacts from which on a step is looked for."""

DISTINCT = 8
"""Flights of which none equals another: of fewer some multiples of some step are near by chance."""

LONGEST_WORD = 24
"""Impacts after which a motion may repeat itself."""

SEED = 0
"""Equal records give equal times."""


class Rounding(Struct, frozen=True):
    """The rounding of a record's times to multiples of a step.

    Attributes
    ----------
    step_s : float
        The step [s].
    repeated : float
        How often the longest part of the record that repeats itself, to the step, is repeated.
    """

    step_s: float
    repeated: float

    @property
    def error_s(self) -> float:
        """Standard deviation of the rounding [s]."""
        return self.step_s / sqrt(12)

    def independent(self, times: Array) -> Array:
        """Times [s] with independent errors added, whose mean over repetitions is as large as a rounding error."""
        added = sqrt(self.repeated) * self.error_s
        return times + added * np.random.default_rng(SEED).standard_normal(len(times))


def rounding_of(times: Array) -> Rounding | None:
    """Find the step to multiples of which times [s] were rounded; None where no step is evident."""
    if len(times) < FEWEST:
        return None
    flights = np.diff(times)
    # The differences of flights next to each other in size are small multiples of the step, if there is one.
    apart = np.diff(np.sort(np.concatenate([[0.0], flights])))
    resolution = 8 * float(np.spacing(np.abs(times).max()))
    apart = apart[apart > resolution]
    # The coarsest step is the one: digits that are printed are a finer one.
    some = np.sort(apart)[:: max(1, len(apart) // MOST_TRIED)]
    for step in np.sort((some[:, None] / np.arange(1, PARTS + 1)).ravel())[::-1].tolist():
        if step < resolution / WHOLE:
            break
        refined = _refined(times - times[0], flights, step)
        if refined is not None and len(np.unique(np.round(flights / refined))) >= DISTINCT:
            return Rounding(refined, _repeated(flights, refined))
    return None


def _refined(since: Array, flights: Array, step: float) -> float | None:
    """A step refined by all flights and then by all times; None where these are not its multiples."""
    for values in (np.sort(flights), np.sort(since)):
        # The error of a step counts once for each of a value: short values are whole first, and refine it.
        for count in _doubled(len(values)):
            some = values[:count]
            whole = np.round(some / step)
            if not whole.any() or np.abs(some - whole * step).max() > WHOLE * step:
                return None
            step = float(some @ whole / (whole @ whole))
    return step


def _doubled(count: int) -> list[int]:
    """Powers of two below a number, and that number."""
    return [*takewhile(lambda size: size < count, (2**k for k in range(1, 64))), count]


def _repeated(flights: Array, step: float) -> float:
    """How often the longest part of some flights is repeated to the step."""
    whole = np.round(flights / step)
    most = 1.0
    for length in range(1, LONGEST_WORD + 1):
        same = whole[length:] == whole[:-length]
        ends = np.flatnonzero(np.concatenate([[True], ~same, [True]]))
        most = max(most, 1 + float(np.diff(ends).max() - 1) / length)
    return most
