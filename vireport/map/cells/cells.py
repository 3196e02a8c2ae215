"""The cells of a map: what it computes, and which parameter values each cell has by its number alone.

A plan is all that a process needs to compute any part of a map; no cell is stored before it is computed.
"""

from __future__ import annotations

from functools import lru_cache
from threading import Lock
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.plane import Plane
from vireport.design.solution import SMALLEST_LOSS
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.physics.groups import by_wall
from vireport.scenario.blocks import Sampling
from vireport.scenario.loading import LoadedMap
from vireport.scenario.map_file import AxisBlock, MapBlock, MapSimulationBlock
from vireport.scenario.parameters import DesignInput, Named

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

DRAWING = Lock()
"""Held while Sobol points are drawn: the sequence remembers where it is, and a worker of a cluster may have threads."""

CHUNK_CELLS = 32_768
"""Cells of a chunk: some tenths of a second of work, beside which starting and storing it is little."""

CHUNK_IMPACTS = 4_000_000
"""Impacts of a chunk that is simulated: a few seconds of work."""

FROM_REST_IMPACTS, SHOCK_IMPACTS, ESCAPE_IMPACTS = 2_000, 100_000, 500_000
"""Impacts that take as long as a cell from rest, as its least shock and as its least kicks: a millisecond, some
hundredths and some tenths of a second."""


class AxisName(Named, Struct, frozen=True):
    """Name of an axis of a map that is no input of a motion."""

    quantity: str
    symbol: str
    unit: str


BALL_MASS = AxisName("ball mass", "m", "kg")


class MapPlan(Struct, frozen=True):
    """All that determines the cells of a map and their results.

    Attributes
    ----------
    device : Device
        The inputs that are held; those that vary have arbitrary values.
    membrane : Membrane or None
        Without one no voltage is evaluated; a ball mass that varies has an arbitrary value.
    axes : tuple of Axis
    sampling : Sampling
    seed : int
        Seed of random samplings.
    cells : int
        Number of all cells.
    chunk_cells : int
        Number of cells that are computed and stored at once.
    simulate : MapSimulation or None
    from_rest, shock, escape : bool
        Whether to find what each cell comes to from rest, its least shock, and the least kicks that lead out.
    """

    device: Device
    membrane: Membrane | None
    axes: tuple[AxisBlock, ...]
    sampling: Sampling
    seed: int
    cells: int
    chunk_cells: int
    simulate: MapSimulationBlock | None
    from_rest: bool
    shock: bool
    escape: bool

    @property
    def needs_numba(self) -> bool:
        """Whether anything is computed by compiled code alone: the same digits on every machine, in bearable time."""
        return self.from_rest or self.shock or self.escape

    @property
    def chunks(self) -> int:
        """Number of chunks that the cells of the map are computed in."""
        return -(-self.cells // self.chunk_cells)

    @property
    def names(self) -> tuple[str, ...]:
        """Columns of the axes: the keys of their parameters."""
        return tuple(axis.path.rpartition(".")[2] for axis in self.axes)

    @property
    def named(self) -> tuple[Named, ...]:
        """The names of the axes for readers."""
        inputs: dict[str, Named] = {varied.value: varied for varied in DesignInput}
        return tuple(inputs.get(name, BALL_MASS) for name in self.names)

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values along the axes of a grid, the last one varying fastest."""
        return tuple(axis.size for axis in self.axes)

    @property
    def ends(self) -> tuple[tuple[float, float], ...]:
        """Smallest and largest value of each axis."""
        return tuple(map(axis_ends, self.axes))

    @property
    def plane(self) -> Plane | None:
        """The plane of the heat maps of a grid over two parameters; None for other maps."""
        if self.sampling is not Sampling.GRID or len(self.axes) != 2:
            return None
        (first, second), (low, high) = self.named, np.array(self.ends).T
        return Plane((first, second), low, high)

    def rows(self, chunk: int) -> int:
        """Cells of a chunk: all but the last are of one size."""
        return min(self.chunk_cells, self.cells - chunk * self.chunk_cells)

    def numbers(self, chunk: int) -> Ints:
        """Numbers of the cells of a chunk."""
        first = chunk * self.chunk_cells
        return np.arange(first, first + self.rows(chunk))


def map_plan(loaded: LoadedMap) -> MapPlan:
    """Derive the plan of a map from its file.

    Raises
    ------
    NumericalError
        If the restitution is outside the theory.
    """
    scenario, block = loaded.scenario, loaded.block
    device = Device.of(scenario)
    largest = max(by_wall(device.restitution))
    if 1 - largest < SMALLEST_LOSS:
        raise NumericalError(
            f"device.restitution: {largest!r} means impacts with hardly any loss, for which the "
            f"criteria of stability do not apply (allowed in a map: at most 1 - {SMALLEST_LOSS:g})"
        )
    return MapPlan(
        device=device,
        membrane=Membrane.of(scenario),
        axes=block.axes,
        sampling=block.sampling,
        seed=block.seed,
        cells=block.cells,
        chunk_cells=block.chunk_cells or _chunk_cells(block),
        simulate=block.simulate,
        from_rest=block.from_rest,
        shock=block.shock,
        escape=block.escape,
    )


def _chunk_cells(block: MapBlock) -> int:
    simulated = 0 if block.simulate is None else block.simulate.starts * block.simulate.impacts
    impacts = simulated + FROM_REST_IMPACTS * block.from_rest + SHOCK_IMPACTS * block.shock
    impacts += ESCAPE_IMPACTS * block.escape
    return max(CHUNK_IMPACTS // impacts, 1) if impacts else CHUNK_CELLS


def axis_values(axis: AxisBlock, index: Ints) -> Floats:
    """Values of an axis by their index along it; the last one is exact."""
    if axis.values:
        return np.array(axis.values)[index]
    first, last, steps = float(axis.from_ or 0.0), float(axis.to or 0.0), (axis.count or 2) - 1
    # By the share of the way instead of a running sum, so that any cell can be computed alone; the end is exact.
    return np.asarray(np.where(index == steps, last, first + (last - first) * (index / steps)))


def axis_ends(axis: AxisBlock) -> tuple[float, float]:
    """Smallest and largest value of an axis."""
    values = axis.values or (float(axis.from_ or 0.0), float(axis.to or 0.0))
    return min(values), max(values)


def cell_values(plan: MapPlan, numbers: Ints) -> list[Floats]:
    """Values along each axis at cells given by their numbers, 0 to plan.cells - 1."""
    if plan.sampling is Sampling.GRID:
        indices = np.unravel_index(numbers, plan.shape)
        return [axis_values(axis, index) for axis, index in zip(plan.axes, indices, strict=True)]
    if plan.sampling is Sampling.LIST:
        return [axis_values(axis, numbers) for axis in plan.axes]
    points = _sobol_points(plan, numbers) if plan.sampling is Sampling.SOBOL else _hypercube_points(plan, numbers)
    ends = [(float(axis.from_ or 0.0), float(axis.to or 0.0)) for axis in plan.axes]
    return [low + (high - low) * points[:, k] for k, (low, high) in enumerate(ends)]


def _sobol_points(plan: MapPlan, numbers: Ints) -> Floats:
    """Scrambled Sobol points by their numbers, shape (n, axes)."""
    parts, engine = [], _sobol_engine(len(plan.axes), plan.seed)
    with DRAWING:
        for run in np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1):
            if run[0] < engine.num_generated:
                engine.reset()
            if run[0] > engine.num_generated:
                engine.fast_forward(int(run[0]) - engine.num_generated)
            # One by itself, as SciPy warns of any number but a power of two that is drawn at first.
            parts += [engine.random(1), engine.random(len(run) - 1)]
    return np.vstack(parts)


@lru_cache(maxsize=1)
def _sobol_engine(dimensions: int, seed: int) -> Any:
    """The sequence that the points are drawn from; kept, so that chunks in their order do not begin it anew."""
    from scipy.stats import qmc  # type: ignore[import-untyped]

    return qmc.Sobol(dimensions, rng=np.random.default_rng(seed))


def _hypercube_points(plan: MapPlan, numbers: Ints) -> Floats:
    """Points of a Latin hypercube by their numbers, shape (n, axes): one in each of `cells` strata along every axis."""
    return np.asarray(_hypercube(len(plan.axes), plan.seed, plan.cells)[numbers])


@lru_cache(maxsize=1)
def _hypercube(dimensions: int, seed: int, cells: int) -> Floats:
    """The whole hypercube, which can only be drawn at once: `MOST_IN_HYPERCUBE` limits it."""
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(dimensions, rng=np.random.default_rng(seed)).random(cells))
