"""The cells of a map: what it computes, and which parameter values each cell has by its number alone.

A plan is all that a process needs to compute any part of a map; no cell is stored before it is computed.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base import NumericalError
from vireport.design import SMALLEST_LOSS
from vireport.physics import Device, Membrane, by_wall
from vireport.scenario import (
    AxisBlock,
    DesignInput,
    LoadedMap,
    MapBlock,
    MapSimulationBlock,
    Sampling,
)
from vireport.text import significant

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
RandomBits = NDArray[np.uint64]

CHUNK_CELLS = 32_768
"""Cells of a chunk: some tenths of a second of work, beside which starting and storing it is little."""

CHUNK_IMPACTS = 4_000_000
"""Impacts of a chunk that is simulated: a few seconds of work."""

FROM_REST_IMPACTS, SHOCK_IMPACTS = 2_000, 100_000
"""Impacts that take as long as a cell from rest, and as its least shock: a millisecond, and some hundredths of a
second."""

SOBOL_BITS = 30
"""Binary digits of a Sobol point, SciPy's default: enough for 2^30 points, the most a map file can ask for."""

ROUNDS = 8
"""Rounds of the permutation of a Latin hypercube; four suffice for large halves, small ones need more."""


class AxisName(NamedTuple):
    """What an axis of a map is called: its quantity, the symbol and the unit of that; "" is no unit."""

    quantity: str
    symbol: str
    unit: str

    @property
    def label(self) -> str:
        """The name with its symbol and unit, of an axis of a figure."""
        return f"{self.quantity} {self.symbol} [{self.unit or '–'}]"

    @property
    def head(self) -> str:
        """The name with its unit, of a column of a table."""
        return f"{self.quantity} [{self.unit}]" if self.unit else self.quantity

    def show(self, value: float, digits: int = 6) -> str:
        """Print a value with its unit."""
        number = significant(value, digits)
        return f"{number}°" if self.unit == "°" else f"{number} {self.unit}".rstrip()


BALL_MASS = AxisName("ball mass", "m", "kg")


class MapPlan(Struct, frozen=True):
    """All that determines the cells of a map and their results.

    Attributes
    ----------
    device : Device
        What is held; a parameter that varies has any value.
    membrane : Membrane or None
        Where there is none, no voltage is evaluated; a ball mass that varies has any value.
    axes : tuple of Axis
    sampling : Sampling
    seed : int
        Of the last two.
    cells : int
        In all.
    chunk_cells : int
        Cells that are computed and stored at once.
    simulate : MapSimulation or None
    from_rest, shock : bool
        Whether to tell what each cell comes to from rest, and its least shock.
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

    @property
    def needs_numba(self) -> bool:
        """Whether anything is computed by compiled code alone: the same digits on every machine, in bearable time."""
        return self.from_rest or self.shock

    @property
    def chunks(self) -> int:
        """Number of chunks that the cells of the map are computed in."""
        return -(-self.cells // self.chunk_cells)

    @property
    def names(self) -> tuple[str, ...]:
        """Columns of the axes: the keys of their parameters."""
        return tuple(axis.path.rpartition(".")[2] for axis in self.axes)

    @property
    def named(self) -> tuple[AxisName, ...]:
        """What the axes are called."""
        known = {each.value: AxisName(each.quantity, each.symbol, each.unit) for each in DesignInput}
        return tuple(known.get(name, BALL_MASS) for name in self.names)

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values along the axes of a grid, the last one varying fastest."""
        return tuple(axis.size for axis in self.axes)

    @property
    def ends(self) -> tuple[tuple[float, float], ...]:
        """Smallest and largest value of each axis."""
        return tuple(map(axis_ends, self.axes))

    @property
    def is_plane(self) -> bool:
        """Whether it is a grid over two parameters, of which there are heat maps."""
        return self.sampling is Sampling.GRID and len(self.axes) == 2

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
    )


def _chunk_cells(block: MapBlock) -> int:
    simulated = 0 if block.simulate is None else block.simulate.starts * block.simulate.impacts
    impacts = simulated + FROM_REST_IMPACTS * block.from_rest + SHOCK_IMPACTS * block.shock
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
    """Scrambled Sobol points by their numbers, shape (n, axes), bit for bit those that SciPy generates in sequence.

    Point i is the first point, XORed with the direction of each bit that is set in the Gray code of i.
    """
    first, directions = _sobol_directions(len(plan.axes), plan.seed, (plan.cells - 1).bit_length())
    # SciPy draws points in sequence only; a chunk in the middle of a map would need all before it.
    gray = numbers ^ (numbers >> 1)
    points = np.repeat(first[None], len(numbers), axis=0)
    for bit, direction in enumerate(directions):
        points ^= direction * ((gray >> bit) & 1)[:, None]
    return np.asarray(points * 2.0**-SOBOL_BITS, dtype=np.float64)


@lru_cache(maxsize=1)
def _sobol_directions(dimensions: int, seed: int, bits: int) -> tuple[Ints, list[Ints]]:
    """The first Sobol point and the directions of its bits, as integers of `SOBOL_BITS` digits.

    The Gray code of 2^k - 1 has bit k - 1 alone, so that this point differs from the first one by that direction.
    """
    from scipy.stats import qmc  # type: ignore[import-untyped]

    engine = qmc.Sobol(dimensions, scramble=True, bits=SOBOL_BITS, rng=np.random.default_rng(seed))

    def point(number: int) -> Ints:
        if number > engine.num_generated:
            engine.fast_forward(number - engine.num_generated)
        return np.asarray(engine.random(1)[0] * 2.0**SOBOL_BITS, dtype=np.int64)

    first = point(0)
    return first, [first ^ point(2**k - 1) for k in range(1, bits + 1)]


def _hypercube_points(plan: MapPlan, numbers: Ints) -> Floats:
    """Points of a Latin hypercube by their numbers, shape (n, axes): one in each of `cells` strata along every axis.

    Which stratum has which point is a permutation of its own for each axis, computed for any number alone, so that
    no sample is held in memory; where in its stratum the point lies is a hash of the number.
    """
    keys: RandomBits = np.random.SeedSequence(plan.seed).generate_state((ROUNDS + 1) * len(plan.axes), np.uint64)  # type: ignore[assignment]
    columns = []
    for own in keys.reshape(len(plan.axes), ROUNDS + 1):
        # The upper 53 bits make a double in [0, 1); all 64 would round to 1 for some.
        within = (_mixed(numbers.astype(np.uint64) ^ own[0]) >> np.uint64(11)) * 2.0**-53
        columns.append((_permuted(numbers, plan.cells, own[1:]) + within) / plan.cells)
    return np.column_stack(columns)


def _permuted(numbers: Ints, count: int, keys: RandomBits) -> RandomBits:
    """Images of numbers below `count` under a keyed pseudo-random permutation of all of them.

    A Feistel network permutes the numbers of an even number of bits; what leaves the range is permuted again until it
    is back in it (cycle walking: Black and Rogaway, CT-RSA 2002).
    """
    half = np.uint64(max(-(-(count - 1).bit_length() // 2), 1))
    mask = (np.uint64(1) << half) - np.uint64(1)
    images = numbers.astype(np.uint64)
    walking = np.arange(len(images))
    while len(walking):
        left, right = images[walking] >> half, images[walking] & mask
        for key in keys:
            left, right = right, left ^ (_mixed(right ^ key) & mask)
        images[walking] = (left << half) | right
        # The network permutes all numbers of its bits, fewer than four times `count`: on average a walk ends within
        # four steps.
        walking = walking[images[walking] >= count]
    return images


def _mixed(words: RandomBits) -> RandomBits:
    """Hash of 64 bits: the output function of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014)."""
    words = (words ^ (words >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    words = (words ^ (words >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return words ^ (words >> np.uint64(31))
