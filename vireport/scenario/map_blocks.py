"""The `map` block of a map file: which keys it has, what they mean, and the range of each.

A map file is a scenario without a sweep, and this block. Nothing here reads a file.
"""

# Without `from __future__ import annotations`: the annotations below are read, so they must not be text.

from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, NamedTuple, get_args

from vireport.scenario.keys import Key, entries, validator

AxisPath = Literal[
    "inclination_deg",
    "device.length_m",
    "excitation.amplitude_n",
    "excitation.frequency_hz",
    "device.restitution",
    "device.ball_mass_kg",
]
"""What a map can vary."""

Sampling = Literal["grid", "list", "latin_hypercube", "sobol"]

FEWEST_AXES, MOST_AXES = 2, 6
MOST_VALUES = 4_000  # a file has at most 5,000 values
MOST_CELLS = 10**11
LARGEST_CHUNK = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """One parameter that is varied: from one value to another in even steps, or at the values of a list."""

    path: Annotated[AxisPath, Key("Path", "", "The parameter.", "inclination_deg")]
    from_: Annotated[float | None, Key("From", "", "First value, in the parameter's unit.", 0.0)] = None
    to: Annotated[float | None, Key("To", "", "Last value, in the parameter's unit.", 90.0)] = None
    count: Annotated[int | None, Key("Count", "1", "Number of values, on a grid.", 80, ge=2, le=100_000_000)] = None
    values: Annotated[
        tuple[float, ...] | None,
        Key("Values", "", "The values themselves.", [0.0, 45.0], min_length=1, max_length=MOST_VALUES),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MapSimulation:
    """The simulation at each cell: where its motion ends from a number of starting states."""

    starts: Annotated[int, Key("Starts", "1", "Starting states, the same at every cell.", 16, ge=1, le=1024)] = 16
    impacts: Annotated[
        int, Key("Impacts", "1", "Impacts from each; slow transients go on longer.", 1000, ge=100, le=100_000)
    ] = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Map:
    """What a map varies, and how its cells are chosen."""

    axes: Annotated[
        tuple[Axis, ...],
        Key("Axes", "", "The parameters that are varied.", min_length=FEWEST_AXES, max_length=MOST_AXES),
    ]
    sampling: Annotated[
        Sampling,
        Key(
            "Sampling",
            "",
            "Every combination of the values (grid), the values side by side (list), or points between from and to.",
            "grid",
        ),
    ] = "grid"
    samples: Annotated[
        int | None, Key("Samples", "1", "Number of points, where they are not a grid.", 4096, ge=1, le=2**30)
    ] = None
    seed: Annotated[int, Key("Seed", "", "Of the points, where they are not a grid.", 0, ge=0, le=2**32 - 1)] = 0
    simulate: Annotated[MapSimulation | None, Key("Simulation", "", "Left out, nothing is simulated.")] = None
    chunk_cells: Annotated[
        int | None, Key("Chunk", "1", "Cells that are computed and stored at once.", 32768, ge=1, le=LARGEST_CHUNK)
    ] = None


class Allowed(NamedTuple):
    """What a key of the block may be, in words, and its kind: a block, list, number, whole number or choice."""

    kind: str
    words: str
    keys: tuple[str, ...] = ()


def validated(tree: object) -> Map:
    """Make a map block of a tree as it is read from a file.

    Raises
    ------
    pydantic_core.ValidationError
        With all values that are wrong in themselves, and all keys that are unknown or missing.
    """
    block: Map = validator(Map).validate_python(tree)
    return block


@cache
def allowed() -> dict[str, Allowed]:
    """What every key may be, by its path below `map`, elements of a list as ``*``; "" is the block itself."""
    return {"": _block(Map), **_below(Map, "")}


def _below(block: type[Any], path: str) -> dict[str, Allowed]:
    found: dict[str, Allowed] = {}
    for entry in entries(block):
        here = f"{path}.{entry.name}" if path else entry.name
        elements = [one for one in get_args(entry.kind) if one is not Ellipsis]
        if entry.is_block:
            found |= {here: _block(entry.kind), **_below(entry.kind, here)}
        elif elements == [Axis]:
            found[here] = Allowed("list", f"a list of {FEWEST_AXES} to {MOST_AXES} axes, each a block of keys")
            found |= {f"{here}.*": _block(Axis), **_below(Axis, f"{here}.*")}
        elif elements == [float]:
            found[here] = Allowed("list", f"a list of at most {MOST_VALUES} numbers")
            found[f"{here}.*"] = Allowed("number", "a number")
        elif elements:
            found[here] = Allowed("choice", f"one of {', '.join(elements)}", tuple(elements))
        elif entry.kind is int:
            bounds = entry.key.bounds
            found[here] = Allowed("whole number", f"a whole number from {bounds['ge']} to {bounds['le']}")
        else:
            found[here] = Allowed("number", "a number, in the unit of the parameter")
    return found


def _block(block: type[Any]) -> Allowed:
    names = tuple(entry.name for entry in entries(block))
    return Allowed("block", f"a block of keys: {', '.join(names)}", names)
