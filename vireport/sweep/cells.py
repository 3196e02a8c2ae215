"""The cells of a map: which parameters each has, by its number alone.

A plan is all that a process needs to make any part of a map; no cell is stored before it is computed.
"""

from __future__ import annotations

import threading
import warnings
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.physics import Device, Membrane
from vireport.scenario import (
    Axis,
    MapSimulation,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class MapPlan:
    """All that determines the cells of a map and their results.

    Attributes
    ----------
    device : Device
        What is held; a parameter that varies has any value.
    membrane : Membrane or None
        Where there is none, no voltage is evaluated; a ball mass that varies has any value.
    axes : tuple of Axis
    sampling : str
        See `map_blocks.Map`.
    seed : int
    cells : int
        In all.
    chunk_cells : int
    simulate : MapSimulation or None
    """

    device: Device
    membrane: Membrane | None
    axes: tuple[Axis, ...]
    sampling: str
    seed: int
    cells: int
    chunk_cells: int
    simulate: MapSimulation | None

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.cells // self.chunk_cells)

    @property
    def names(self) -> tuple[str, ...]:
        """Columns of the axes: the keys of their parameters."""
        return tuple(axis.path.rpartition(".")[2] for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values along the axes of a grid, the last one varying fastest."""
        return tuple(len(axis.values) if axis.values else (axis.count or 0) for axis in self.axes)

    def rows(self, chunk: int) -> int:
        """Cells of a chunk: all but the last are of one size."""
        return min(self.chunk_cells, self.cells - chunk * self.chunk_cells)


def axis_values(axis: Axis, index: Ints) -> Floats:
    """Values of an axis by their number; the last one is exact."""
    if axis.values:
        return np.array(axis.values)[index]
    first, last, steps = float(axis.from_ or 0.0), float(axis.to or 0.0), (axis.count or 2) - 1
    return np.asarray(np.where(index == steps, last, first + (last - first) * (index / steps)))


def cells_of(plan: MapPlan, chunk: int) -> list[Floats]:
    """Values along the axes at the cells of a chunk."""
    first = chunk * plan.chunk_cells
    index = np.arange(first, first + plan.rows(chunk))
    if plan.sampling == "grid":
        places = np.unravel_index(index, plan.shape)
        return [axis_values(axis, place) for axis, place in zip(plan.axes, places, strict=True)]
    if plan.sampling == "list":
        return [axis_values(axis, index) for axis in plan.axes]
    points = _points(plan, first, len(index))
    ends = [(float(axis.from_ or 0.0), float(axis.to or 0.0)) for axis in plan.axes]
    return [low + (high - low) * points[:, k] for k, (low, high) in enumerate(ends)]


def _points(plan: MapPlan, first: int, count: int) -> Floats:
    """Points of the unit cube: Sobol's from any place on; of a Latin hypercube all are drawn, once in a process."""
    if plan.sampling == "latin_hypercube":
        return _hypercube(len(plan.axes), plan.cells, plan.seed)[first : first + count]
    engine = _sobol(len(plan.axes), plan.seed, first)
    with warnings.catch_warnings():
        # That a part of the sequence has no power of 2 points: the whole has.
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(engine.random(count))


_KEPT = threading.local()
"""The generator of each thread, where its last chunk ended: to step there anew takes ever longer along a map."""


def _sobol(dimensions: int, seed: int, first: int) -> Any:
    """A generator of Sobol's points that stands at the point `first`."""
    from scipy.stats import qmc  # type: ignore[import-untyped]

    key, engine = getattr(_KEPT, "engine", (None, None))
    if key != (dimensions, seed) or engine is None or engine.num_generated > first:
        engine = qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(seed))
        _KEPT.engine = ((dimensions, seed), engine)
    if first > engine.num_generated:
        engine.fast_forward(first - engine.num_generated)
    return engine


@lru_cache(maxsize=1)
def _hypercube(dimensions: int, count: int, seed: int) -> Floats:
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(count))
