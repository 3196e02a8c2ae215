"""Reads a map file: a scenario without a sweep, and the block `map` that says what varies.

A file that cannot be used is explained with every mistake in it at once, each by line and key, as for a scenario.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

from pydantic_core import ValidationError

from vireport.errors import Mistake, ScenarioError, UsageError
from vireport.scenario import hints, map_blocks
from vireport.scenario.blocks import Scenario
from vireport.scenario.document import LARGEST_FILE, Document, join, read
from vireport.scenario.loading import validate_document
from vireport.scenario.map_blocks import AxisPath, Map
from vireport.scenario.schema import keys

BLOCK = "map"

LARGEST_RESTITUTION = 1 - 1e-6
"""Beyond it the motions are not resolved, see `study.SMALLEST_LOSS`."""

NOT_IN_A_MAP = {
    "sweep": "a map has no sweep (delete it; map.axes says what varies)",
    "simulation": "a map has no simulation block (delete it; map.simulate asks for the simulation of each cell)",
}


FOLLOWS = "required unless it is swept"
"""Begins a mistake that may only follow from another one: from an axis that could not be read."""


@dataclass(frozen=True, slots=True)
class LoadedMap:
    """A map file as understood.

    Attributes
    ----------
    scenario : Scenario
        What is held; a parameter that varies and is left out of the file has its first value.
    block : Map
        What varies.
    text : str
        The file.
    name : str
        Of the file.
    """

    scenario: Scenario
    block: Map
    text: str
    name: str

    @property
    def sha256(self) -> str:
        """Of the file, as ``sha256sum`` prints it."""
        return sha256(self.text.encode("utf-8", "surrogatepass")).hexdigest()


def load_map(source: str | Path) -> LoadedMap:
    """Read a map from a file, or from standard input where `source` is "-".

    Raises
    ------
    UsageError
        Where there is no such file, or it cannot be opened.
    ScenarioError
        Where the map cannot be used.
    """
    if str(source) == "-":
        return loads_map(sys.stdin.buffer.read(LARGEST_FILE + 1), "<stdin>")
    try:
        with open(source, "rb") as file:
            return loads_map(file.read(LARGEST_FILE + 1), str(source))
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise UsageError(f"{source}: {getattr(error, 'strerror', None) or error}") from error


def loads_map(text: str | bytes, name: str = "<text>") -> LoadedMap:
    """Read a map from text or UTF-8 bytes; `name` stands for the file in messages (see `load_map`)."""
    document = read(text, name)
    data: Any = document.data
    if not isinstance(data, dict):
        raise ScenarioError(name, document.mistakes or [Mistake(1, "", "the file is not a block of keys")])
    block, mistakes = _block(document)
    held = {key: value for key, value in data.items() if key != BLOCK and key not in NOT_IN_A_MAP}
    mistakes += [
        Mistake(document.lines[key], key, message) for key, message in NOT_IN_A_MAP.items() if data.get(key) is not None
    ]
    filled, stands_for = _filled(held, block, data.get(BLOCK))
    scenario = None
    try:
        scenario = validate_document(replace(document, data=filled))
    except ScenarioError as error:
        found = [
            _moved(mistake, stands_for, document)
            for mistake in error.mistakes
            if block is not None or not mistake.message.startswith(FOLLOWS)
        ]
        mistakes += [one for one in found if (one.line, one.path) not in {(m.line, m.path) for m in mistakes}]
    if scenario is None or block is None or mistakes:
        raise ScenarioError(name, mistakes)
    return LoadedMap(scenario, block, document.text, name)


def _filled(held: dict[str, Any], block: Map | None, tree: Any) -> tuple[dict[str, Any], dict[str, str]]:
    """The scenario with the parameters that vary in it, and which axis each of them comes from.

    The largest value stands in it: of the rules between several keys, the one that a map can break is that the ball is
    lighter than the capsule.
    """
    filled = deepcopy(held)
    stands_for: dict[str, str] = {}
    axes = tree.get("axes") if isinstance(tree, dict) else None
    for k, axis in enumerate(axes if isinstance(axes, list) else []):
        path = axis.get("path") if isinstance(axis, dict) else None
        if not isinstance(path, str) or path not in AXIS_PATHS:
            continue
        known = block.axes[k] if block is not None else None
        value = keys()[path]["examples"][0] if known is None else first_value(known, path)
        parent, _, key = path.rpartition(".")
        inside = filled.setdefault(parent, {}) if parent else filled
        if isinstance(inside, dict):
            inside[key] = value
            stands_for[path] = f"{BLOCK}.axes.{k}"
    return filled, stands_for


def first_value(axis: map_blocks.Axis, path: str) -> float:
    """The value of an axis that stands in the scenario: its first, or its largest for the ball's mass."""
    values = axis.values if axis.values else tuple(end for end in (axis.from_, axis.to) if end is not None)
    return max(values) if path == "device.ball_mass_kg" else values[0]


def _moved(mistake: Mistake, stands_for: dict[str, str], document: Document) -> Mistake:
    """A mistake in a value that an axis gives, put where the axis is."""
    path = stands_for.get(mistake.path)
    return mistake if path is None else Mistake(_line(path, document), path, mistake.message)


AXIS_PATHS = AxisPath.__args__  # type: ignore[attr-defined]


def _block(document: Document) -> tuple[Map | None, list[Mistake]]:
    """The block `map`, or None and what is wrong with it."""
    data: Any = document.data
    tree = data.get(BLOCK)
    if BLOCK in document.unread:
        return None, []
    if tree is None:
        needs = "with axes: what varies, and from where to where (in a scenario without it: vireport run)"
        return None, [Mistake(_line(BLOCK, document), BLOCK, f"required, but missing (a block {needs})")]
    mistakes: dict[str, Mistake] = {}
    block = None
    try:
        block = map_blocks.validated(tree)
    except ValidationError as error:
        for found in error.errors(include_url=False, include_context=False):
            path = BLOCK
            for step in found["loc"]:
                path = join(path, step)
            wording = _wording(path, found["type"], found["input"], document)
            mistakes.setdefault(path, Mistake(_line(path, document), path, wording))
    if isinstance(tree, dict):
        for path, message in _rules(tree):
            if path not in mistakes and not any(path.startswith(f"{wrong}.") for wrong in mistakes):
                mistakes[path] = Mistake(_line(path, document), path, message)
    return (None if mistakes else block), list(mistakes.values())


def _line(path: str, document: Document) -> int:
    while path not in document.lines and path:
        path = path.rpartition(".")[0]
    return document.lines[path]


def _wording(path: str, kind: str, value: object, document: Document) -> str:
    steps = ["*" if step.isdigit() else step for step in path.split(".")[1:]]
    if kind == "extra_forbidden":
        block = map_blocks.allowed()[".".join(steps[:-1])]
        close = hints.closest(steps[-1], list(block.keys))
        meant = f"; did you mean '{close}'?" if close else ""
        return f"unknown key{meant} (allowed: {', '.join(block.keys)})"
    limits = map_blocks.allowed()[".".join(steps)]
    if kind == "missing":
        return f"required, but missing ({limits.words})"
    if value is None:
        return f"is empty ({limits.words})"
    shown = document.written.get(path) or ("a list" if isinstance(value, list) else "a block of keys")
    wrong = ""
    if isinstance(value, list) and limits.kind == "list":
        shown = f"a list of {len(value)}"
    elif limits.kind == "choice":
        close = hints.closest(str(value).rpartition(".")[2], [key.rpartition(".")[2] for key in limits.keys])
        full = next((key for key in limits.keys if key.rpartition(".")[2] == close), None)
        wrong = f"; did you mean '{full}'?" if full else ""
    elif isinstance(value, str):
        wrong = ", which is text"
    elif isinstance(value, float) and limits.kind == "whole number":
        wrong = ", which is not a whole number"
    return f"got {shown}{wrong} ({limits.words})"


def _rules(tree: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What must hold between several keys, on the tree as it was read: path and message."""
    sampling = tree.get("sampling", "grid")
    axes = tree.get("axes")
    axes = [axis for axis in axes if isinstance(axis, dict)] if isinstance(axes, list) else []
    seen: dict[object, int] = {}
    for k, axis in enumerate(axes):
        here = f"{BLOCK}.axes.{k}"
        path = axis.get("path")
        if isinstance(path, str) and seen.setdefault(path, k) != k:
            yield f"{here}.path", f"{path} is axis {seen[path]} already (each parameter once)"
        yield from _axis_rules(axis, here, sampling)
    yield from _sampling_rules(tree, axes, sampling)


def _axis_rules(axis: dict[str, Any], here: str, sampling: object) -> Iterator[tuple[str, str]]:
    ends, values = {key: axis.get(key) for key in ("from", "to", "count")}, axis.get("values")
    wanted = ("from", "to") if sampling in ("latin_hypercube", "sobol") else ("from", "to", "count")
    if values is not None:
        if sampling in ("latin_hypercube", "sobol"):
            yield f"{here}.values", f"{sampling} takes points between from and to (give these instead of a list)"
        extra = [key for key, value in ends.items() if value is not None]
        if extra:
            yield f"{here}.{extra[0]}", "an axis has either from, to and count, or values (delete one of them)"
    elif sampling == "list":
        yield f"{here}", "a list needs values (a list of numbers, as many as every other axis has)"
    else:
        missing = [key for key in wanted if ends[key] is None]
        if missing:
            alone = "" if "count" not in wanted else ", or values"
            yield here, f"{', '.join(missing)} missing (an axis has {', '.join(wanted)}{alone})"
        if "count" not in wanted and ends["count"] is not None:
            yield f"{here}.count", f"with {sampling} map.samples says how many points there are (delete it)"
    path = axis.get("path")
    if isinstance(path, str) and path in AXIS_PATHS:
        for name, value in [("from", ends["from"]), ("to", ends["to"]), *_elements(values)]:
            if message := _out_of_range(path, value):
                yield f"{here}.{name}", message
    if _is_number(ends["from"]) and ends["from"] == ends["to"]:
        yield f"{here}.to", f"got {ends['to']:.12g}, the same as from (a different value)"


def _elements(values: object) -> list[tuple[str, object]]:
    return [(f"values.{i}", value) for i, value in enumerate(values)] if isinstance(values, list) else []


def _is_number(value: object) -> bool:
    return type(value) in (int, float) and math.isfinite(value)  # type: ignore[arg-type]


def _out_of_range(path: str, value: Any) -> str:
    """What is wrong with a value of a parameter, or nothing; what is no number is found elsewhere."""
    if not _is_number(value):
        return ""
    key = keys()[path]
    low, high = key["minimum"], key["maximum"]
    if path == "device.restitution":
        high = LARGEST_RESTITUTION
    if low <= value <= high:
        return ""
    unit = f", in {key['unit']}" if key.get("unit", "1") != "1" else ""
    size = "small" if value < low else "large"
    limits = f"{low:g} to {high:.12g}".replace("e+", "e")
    return f"got {value:.12g}, which is too {size} (a number from {limits}{unit})"


def _sampling_rules(tree: dict[str, Any], axes: list[dict[str, Any]], sampling: object) -> Iterator[tuple[str, str]]:
    samples = tree.get("samples")
    if sampling in ("grid", "list"):
        if samples is not None:
            yield f"{BLOCK}.samples", f"a {sampling} has as many cells as its axes say (delete it)"
        lengths = {len(axis["values"]) for axis in axes if isinstance(axis.get("values"), list)}
        if sampling == "list" and len(lengths) > 1:
            counts = ", ".join(map(str, sorted(lengths)))
            yield f"{BLOCK}.axes", f"the axes of a list have {counts} values (as many each)"
    elif sampling in ("latin_hypercube", "sobol") and samples is None:
        yield f"{BLOCK}.samples", f"required with {sampling}, but missing (a whole number)"
    if sampling == "sobol" and type(samples) is int and samples > 0 and samples & (samples - 1):
        near = 2 ** round(math.log2(samples))
        yield f"{BLOCK}.samples", f"got {samples}, which is no power of 2; Sobol's points need one (such as {near})"
    if sampling == "grid":
        each = [len(axis["values"]) if isinstance(axis.get("values"), list) else axis.get("count") for axis in axes]
        cells = math.prod(count for count in each if isinstance(count, int) and count > 0)
        if cells > map_blocks.MOST_CELLS:
            yield f"{BLOCK}.axes", f"{cells:.3g} cells (at most {map_blocks.MOST_CELLS:.3g})"
