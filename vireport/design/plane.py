"""The plane of two inputs: what they are called, and their ranges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.scenario.parameters import Named
from vireport.text.formatting import stated_text

Floats = NDArray[np.float64]


class Plane(Struct, frozen=True, eq=False):
    """Two inputs with names and units, and the range of each.

    Attributes
    ----------
    inputs : tuple of Named
        The input along the horizontal axis first.
    low, high : ndarray (2,)
        Ends of the ranges, in the units of the inputs.
    """

    inputs: tuple[Named, Named]
    low: Floats
    high: Floats

    @property
    def widths(self) -> Floats:
        """Widths of the ranges of both inputs, shape (2,), each in its unit."""
        return self.high - self.low

    def shares(self, places: Any) -> Floats:
        """Places, shape (..., 2), as shares of the ranges."""
        return np.asarray((np.asarray(places) - self.low) / self.widths)

    def room(self, varied: Sequence[float] | Floats) -> float:
        """How far values are from the edges, as a share of the ranges; negative outside."""
        values = np.asarray(varied)
        return float((np.minimum(values - self.low, self.high - values) / self.widths).min())

    def centres(self, counts: tuple[int, int]) -> tuple[Floats, Floats]:
        """Values of both inputs in the middles of the cells, from the number of cells along each."""
        ranges = zip(self.low, self.widths, counts, strict=True)
        x, y = (low + width * ((np.arange(count) + 0.5) / count) for low, width, count in ranges)
        return x, y

    def span(self, axis: int) -> str:
        """One input with its range, in words."""
        varied = self.inputs[axis]
        return f"{varied.quantity} from {stated_text(float(self.low[axis]))} to {varied.stated(float(self.high[axis]))}"
