"""The blocks of a map file beyond those of a scenario; a run, which has no map, does not build them."""
# Annotations are evaluated where they stand, as in the blocks of a scenario.

from math import prod

from vireport.scenario.blocks import AxisPath, Sampling, Scenario
from vireport.scenario.keys import REQUIRED, Block, key, without_added_keys

FEWEST_AXES, MOST_AXES = 2, 6
MOST_VALUES = 4_000  # of an axis; a file has at most 5,000 values
LARGEST_CHUNK = 1_000_000


class AxisBlock(Block):
    """One parameter that is varied: from one value to another in even steps, or at the values of a list."""

    path: AxisPath = key(REQUIRED, "Path", "", "The parameter.", example="inclination_deg", strict=False)
    from_: float | None = key(None, "From", "", "First value, in the parameter's unit.", example=0.0, alias="from")
    to: float | None = key(None, "To", "", "Last value, in the parameter's unit.", example=90.0)
    count: int | None = key(None, "Count", "1", "Number of values, on a grid.", example=80, ge=2, le=100_000_000)
    values: tuple[float, ...] | None = key(
        None,
        "Values",
        "",
        "The values themselves.",
        example=[0.0, 45.0],
        min_length=1,
        max_length=MOST_VALUES,
        strict=False,
    )

    @property
    def size(self) -> int:
        """Number of values on a grid."""
        return len(self.values) if self.values else (self.count or 0)


class MapSimulationBlock(Block):
    """The simulation at each cell: where its motion ends from a number of starting states."""

    starts: int = key(16, "Starts", "1", "Random starts, each cell its own, the same in every run.", ge=1, le=1024)
    impacts: int = key(1000, "Impacts", "1", "Impacts from each; slow transients go on longer.", ge=100, le=100_000)


class MapBlock(Block):
    """What a map varies, and how its cells are chosen."""

    axes: tuple[AxisBlock, ...] = key(
        REQUIRED,
        "Axes",
        "",
        "The parameters that are varied.",
        strict=False,
        min_length=FEWEST_AXES,
        max_length=MOST_AXES,
    )
    sampling: Sampling = key(
        Sampling.GRID,
        "Sampling",
        "",
        "Every combination of the values (grid), the first values of all axes, then the second ones, and so on (list), "
        "or points between from and to (latin_hypercube, sobol).",
        strict=False,
    )
    samples: int | None = key(
        None,
        "Samples",
        "1",
        "Number of points for latin_hypercube, at most 4194304, and for sobol, a power of 2.",
        example=4096,
        ge=1,
        le=2**30,
    )
    seed: int = key(0, "Seed", "", "Seed of the points of latin_hypercube and sobol.", ge=0, le=2**32 - 1)
    simulate: MapSimulationBlock | None = key(
        None, "Simulation", "", "The simulation of each cell. Left out, nothing is simulated."
    )
    from_rest: bool = key(
        False, "From rest", "", "Whether to say what each cell comes to when it is switched on from rest."
    )
    shock: bool = key(
        False,
        "Shock",
        "",
        "Whether to look for the least shock that leads out of the stable motion of each cell.",
        addition="outcomes",
    )
    escape: bool = key(
        False,
        "Escape",
        "",
        "Whether to look for the least kicks that lead out of the stable motion of each cell.",
        addition="escape",
    )
    chunk_cells: int | None = key(
        None, "Chunk", "1", "Cells that are computed and stored at once.", example=32768, ge=1, le=LARGEST_CHUNK
    )

    @property
    def cells(self) -> int:
        """Number of cells that the map has."""
        if self.sampling is Sampling.GRID:
            return prod(axis.size for axis in self.axes)
        return len(self.axes[0].values or ()) if self.sampling is Sampling.LIST else self.samples or 0


@without_added_keys
class MapFile(Scenario):
    """A scenario without a sweep, with what varies instead."""

    sweep: None = key(None, "Sweep", "", "a map has no sweep (delete it; map.axes says what varies)")
    simulation: None = key(
        None,
        "Simulation",
        "",
        "a map has no simulation block (delete it; map.simulate asks for the simulation of each cell)",
    )
    tolerances: None = key(None, "Tolerances", "", "a map has no tolerances (delete them)")
    measured: None = key(None, "Measured", "", "a map has no records of impacts (delete them)")
    effects: None = key(None, "Effects", "", "a map has no effects (delete them)")
    map: MapBlock = key(REQUIRED, "Map", "", "What varies, and how its cells are chosen.")
