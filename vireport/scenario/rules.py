"""The rules between several keys of a scenario or a map file, checked on the tree as it was read.

They are not part of the validation of single values, which would check them only once every value is right, so that
mistakes would be reported in two rounds.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from collections.abc import Set as AbstractSet
from enum import Enum, auto
from typing import Any, NamedTuple, TypeVar

from vireport.base.additions import ADDITIONS
from vireport.scenario.blocks import (
    DEMANDS,
    EFFECTS,
    SIZED,
    Approach,
    AxisPath,
    CapsuleMotion,
    DesignPath,
    Direction,
    LeftOut,
    MembraneBlock,
    MotionsBlock,
    Objective,
    Sampling,
    Scenario,
    percent_key,
)
from vireport.scenario.demands import LimitKind, Need
from vireport.scenario.document import Document, is_within_any
from vireport.scenario.parameters import DRIVING, LARGEST_RESTITUTION, DesignInput, Parameter

ADDED_EFFECTS = {
    LeftOut.SECOND_HARMONIC: "a harmonic at its worst phase",
    LeftOut.FRICTION: "friction that is added",
}
"""Effects whose size is above 0, with their names in messages."""

NARROWEST_SWEEP = 1e-9
"""Relative width of a sweep up to which its ends count as one value: rounding leaves nothing in between."""

STIFFEST = 1e12
"""Largest factor on a membrane's stiffness."""

MOST_CELLS = 10**11
MOST_IN_HYPERCUBE = 2**22  # 200 MB in six dimensions, drawn in seconds

MEMBRANE = "device.membrane."

RESTITUTIONS = "restitution_bottom", "restitution_top"
"""Keys of a device that are given together, and instead of the restitution of both membranes."""

RESTITUTION_ALLOWED = "either restitution, of both membranes, or restitution_bottom and restitution_top"

HARMONICS = "excitation.harmonics"

SINE_ONLY = "accuracy", "design", "map"
"""Blocks that are available for a force without harmonics only."""

RECORD, MANY_DEVICES = "excitation.record", ("design", "map")
"""The key of a record of acceleration, and blocks that evaluate other devices than the one it is driven through."""

PROVE = "disturbances.prove"
"""The key that asks for a proof, which is available for a force without harmonics only."""

ESCAPE, KICKS = "disturbances.escape", "disturbances.jitter_m_s"
"""How long a motion lasts under kicks, and the kicks."""

FRICTION, EXPONENT, STATED = "device.friction", "device.restitution_exponent", "device.restitution_speed_m_s"


class Special(NamedTuple):
    """A key of a device that, where it is not 0, excludes other blocks.

    Attributes
    ----------
    key : str
        Path of the key.
    plain : str
        The case in which the blocks are available, in words such as "without friction".
    blocks : tuple of str
        Blocks that are available in that case only.
    """

    key: str
    plain: str
    blocks: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name of the key within its block, `device`."""
        return self.key.rpartition(".")[2]

    @property
    def alone(self) -> str:
        """Message where the key stands beside a block that it excludes."""
        return f"it is available {self.plain} only, and {self.key} is given (leave one of them out)"


SPECIAL = (
    Special(FRICTION, "without friction", ("motions", "measured", "tolerances", *SINE_ONLY)),
    Special(
        EXPONENT,
        "for a constant restitution",
        ("sweep", "motions", "disturbances", "measured", "tolerances", *SINE_ONLY),
    ),
)
"""Keys of a device that exclude blocks."""

NOT_BOUNCING = {
    "motions": "along a sweep of a restitution only 1:1 motions are computed",
    "accuracy": "it is available for constant membranes only",
}
"""Blocks that a sweep of a restitution does not have, and why."""

ADDED_IF_FULL = (*(("disturbances",) if "outcomes" in ADDITIONS else ()), "motions", "simulation")
"""Blocks that `--full` adds: each of their keys has a default. `accuracy` has only defaults too, but takes ten times as
long as all of these; `vireport verify` measures it."""


def barred_blocks(scenario: Scenario) -> frozenset[str]:
    """The blocks that a scenario cannot have because of its force, its ball or its sweep."""
    blocks = {name for special in SPECIAL if getattr(scenario.device, special.name) for name in special.blocks}
    if scenario.excitation.distorted:
        blocks.update(SINE_ONLY)
    if scenario.sweep is not None and scenario.parameter.bounces:
        blocks.update(NOT_BOUNCING)
    return frozenset(blocks)


PLAIN_REQUIREMENTS = "word", "words", "inclination_from_deg", "inclination_to_deg"
"""Requirements that are judged only where no `SPECIAL` key is given."""

OF_WORDS = PLAIN_REQUIREMENTS[:2]
"""Requirements that concern motions with other sequences of impacts."""

MOST_STATED = 0.99
"""Upper limit of a restitution that falls with speed as stated: for slow impacts it would be 1 and more."""

_RESTITUTION_PATHS = tuple(f"device.{name}" for name in ("restitution", *RESTITUTIONS))

NEAREST_RESTITUTIONS = 1e-9
"""Difference of two restitutions below which motions next to the pitchfork of equal ones are not resolved."""

InputPath = TypeVar("InputPath", AxisPath, DesignPath)

LARGER = {DesignPath.BALL_MASS: DesignPath.CAPSULE_MASS, DesignPath.BALL_RADIUS: DesignPath.ACTIVE_RADIUS}
"""The input that each of these inputs must be below."""

DIELECTRIC = "thickness_m", "relative_permittivity", "breakdown_field_v_m"
"""Keys of a membrane that are given together."""

RANGES = tuple(keys for demand, keys in DEMANDS.items() if demand.kind is LimitKind.RANGE)
"""Requirements that are the two ends of a range."""

OF_SWEPT = tuple(key for demand, keys in DEMANDS.items() if keys in RANGES and demand.over is None for key in keys)
"""The ends of ranges of the swept parameter."""

SWITCHES = tuple(key for demand, keys in DEMANDS.items() if demand.kind is LimitKind.AGREEMENT for key in keys)
"""Requirements that are there or not, and never required unless given."""


def needing(need: Need) -> list[str]:
    """The keys of requirements that need a given key."""
    return [key for demand, keys in DEMANDS.items() if need in demand.needs for key in keys]


def judged_at_design(swept: Parameter) -> list[str]:
    """The keys of requirements that need the design value of a parameter that is swept."""
    demands = (demand for demand in DEMANDS if demand.at_design and demand.over is not swept)
    return [key for demand in demands for key in DEMANDS[demand]]


class Kind(Enum):
    """The kinds of mistakes in a key."""

    MISSING = auto()
    UNKNOWN = auto()
    VALUE = auto()
    """A value of the wrong type or out of the range of its key, or of the parameter that it is a value of."""
    RULE = auto()
    """The key does not fit other keys: the value of the finding is the message."""


class Finding(NamedTuple):
    """A mistake at the path of a key: its kind, and the value of the key or, for a rule, the message."""

    path: str
    kind: Kind
    value: object = None


def inconsistencies(document: Document, wrong: AbstractSet[str], model: type[Scenario]) -> list[Finding]:
    """Find keys of a scenario or a map file that do not fit together.

    Parameters
    ----------
    document : Document
        The document, whose tree is a block.
    wrong : set of str
        Paths that are wrong in themselves: they are not compared with anything.
    model : type
        `Scenario` or `MapFile`.
    """
    tree = _Tree(document, wrong)
    specific = (
        (_required_in_map, _axes, _cells)
        if "map" in model.model_fields
        else (_required, _sweep, _simulation, _tolerances, _starts, _measured, _effects, _escape, _design)
    )
    rules = (
        *specific,
        _harmonics,
        _recorded,
        _special,
        _friction,
        _falling,
        _restitutions,
        _masses,
        _radii,
        _dielectric,
        _accuracy,
        _requirements,
    )
    return [finding for rule in rules for finding in rule(tree)]


def swept(document: Document) -> Parameter | None:
    """The parameter that is swept, the length where there is no sweep; None where that cannot be known."""
    data: Any = document.data
    sweep = data.get("sweep")
    if sweep is None:
        return None if "sweep" in document.unread else Parameter.LENGTH
    named = sweep.get("parameter") if isinstance(sweep, dict) else None
    return next((parameter for parameter in Parameter if parameter == named), None)


def rows_of(data: Any, block: str, key: str) -> list[Any]:
    """The rows of a list in a block, as they were read; empty if there is no such list."""
    rows = data[block].get(key) if isinstance(data.get(block), dict) else None
    return rows if isinstance(rows, list) else []


AXES, VARIED = ("map", "axes"), ("design", "vary")
"""The lists of a file whose rows give the range of an input."""


def path_of(row: object, paths: type[InputPath]) -> InputPath | None:
    """The input that an axis of a map, or a row of `design.vary`, varies; None where that cannot be known."""
    named = row.get("path") if isinstance(row, dict) else None
    return next((path for path in paths if path == named), None)


def is_number(value: Any) -> bool:
    """Whether a value as it was read is a number, and finite."""
    return type(value) in (int, float) and math.isfinite(value)


def _rule(path: str, message: str) -> Finding:
    return Finding(path, Kind.RULE, message)


class _Tree:
    def __init__(self, document: Document, wrong: AbstractSet[str]) -> None:
        self.data: object = document.data
        self.wrong, self.swept = wrong, swept(document)
        # Paths in the file with nothing behind their colon; what an override empties is on no line.
        self.bare = {path for path, text in document.written.items() if not text and document.lines[path]}

    def at(self, path: str) -> Any:
        node: object = self.data
        for step in path.split("."):
            node = node.get(step) if isinstance(node, dict) else None
        return node

    def absent(self, path: str) -> bool:
        """Whether a key is not given, and not for a mistake in it or in a block around it."""
        return self.at(path) is None and not is_within_any(path, self.wrong)

    @property
    def no_design(self) -> bool:
        """Whether the swept parameter has no value beside the sweep; a restitution always has one."""
        return self.swept is not None and not self.swept.bounces and self.absent(self.swept.path)

    def number(self, path: str) -> float | None:
        value = self.at(path)
        return None if path in self.wrong or type(value) not in (int, float) else float(value)


def _required(tree: _Tree) -> Iterator[Finding]:
    if tree.at("map") is not None:
        return  # a file with a map has them among its axes; that it is one is said
    if tree.swept is not None:  # else it is not known which one is swept, so neither is which ones are required
        yield from _missing(tree, {tree.swept.path} if tree.at("sweep") is not None else set())


def _required_in_map(tree: _Tree) -> Iterator[Finding]:
    varied = [path_of(axis, AxisPath) for axis in rows_of(tree.data, *AXES)]
    slips = None in varied or len(set(varied)) < len(varied) or not tree.wrong.isdisjoint(("map", "map.axes"))
    if varied and not slips:  # else it is not known what varies, so neither is what is required
        yield from _missing(tree, set(varied))


def _missing(tree: _Tree, varied: Collection[str | None]) -> Iterator[Finding]:
    for path in [parameter.path for parameter in DRIVING if parameter.path not in varied]:
        block = path.rpartition(".")[0]
        if tree.at(path) is None and (not block or isinstance(tree.at(block), dict)):
            yield Finding(path, Kind.MISSING)


def _restitutions(tree: _Tree) -> Iterator[Finding]:
    """There is one restitution of both membranes, or one of each."""
    both, *of_walls = (f"device.{name}" for name in ("restitution", *RESTITUTIONS))
    stated = [path for path in of_walls if not tree.absent(path)]
    if not isinstance(tree.at("device"), dict):
        return
    if not stated and tree.absent(both):
        yield Finding(both, Kind.MISSING)
    for path in stated:
        if not tree.absent(both):
            yield _rule(path, f"restitution is given as well ({RESTITUTION_ALLOWED})")
        elif len(stated) == 1:
            missing = next(name for name in RESTITUTIONS if not path.endswith(name))
            yield _rule(path, f"{missing} is not given ({RESTITUTION_ALLOWED})")
    bottom, top = map(tree.number, of_walls)
    if bottom is not None and top is not None and 0 < abs(bottom - top) < NEAREST_RESTITUTIONS:
        allowed = f"equal ones, or {NEAREST_RESTITUTIONS:g} apart at least"
        yield _rule(of_walls[1], f"got {top!r}, which is {bottom!r} at the bottom but for rounding ({allowed})")


def _harmonics(tree: _Tree) -> Iterator[Finding]:
    """Each order stands once, and blocks that are available for a sine only do not stand beside harmonics."""
    rows = rows_of(tree.data, "excitation", "harmonics")
    orders = [row.get("order") if isinstance(row, dict) else None for row in rows]
    for k, order in enumerate(orders):
        if type(order) is int and order in orders[:k]:
            yield _rule(f"excitation.harmonics.{k}.order", f"order {order} is given already (each order once)")
    if any(isinstance(row, dict) and is_number(row.get("percent")) and row["percent"] > 0 for row in rows):
        alone = f"it is available for a sine force only, and {HARMONICS} is given (leave one of them out)"
        for path in SINE_ONLY:
            if not tree.absent(path) or path in tree.bare:
                yield _rule(path, alone)
        if tree.at(PROVE) is True:
            yield _rule(PROVE, alone)


def _recorded(tree: _Tree) -> Iterator[Finding]:
    """A record is driven through one device, whose capsule is prescribed and whose ball has no friction."""
    if tree.at(RECORD) is None:
        return
    for path in MANY_DEVICES:
        if not tree.absent(path) or path in tree.bare:
            yield _rule(path, f"{RECORD} is of one device (leave one of them out)")
    if tree.at("device.capsule") == CapsuleMotion.FREE:
        yield _rule(RECORD, "the acceleration of a free capsule is not that of its force (prescribed, or no record)")
    if tree.number(FRICTION):
        yield _rule(RECORD, f"a record is not driven through a device with friction (none, without {FRICTION})")


def _special(tree: _Tree) -> Iterator[Finding]:
    """Blocks that exclude friction, or a restitution that falls with speed, do not stand beside it."""
    for special in SPECIAL:
        if not tree.number(special.key):
            continue
        for path in special.blocks:
            if not tree.absent(path) or path in tree.bare:
                yield _rule(path, special.alone)
        for path in (PROVE, ESCAPE):
            if "disturbances" not in special.blocks and tree.at(path) is True:
                yield _rule(path, special.alone)
        for key in PLAIN_REQUIREMENTS:
            if tree.at(f"requirements.{key}") not in (None, False):
                yield _rule(f"requirements.{key}", special.alone)


def _friction(tree: _Tree) -> Iterator[Finding]:
    """With friction no restitution is zero, and the inclination is not swept."""
    if not (tree.number(FRICTION) or 0.0) > 0:
        return
    if tree.at("sweep") is not None and tree.swept is Parameter.INCLINATION:
        reason = "along a sweep of the inclination, with which friction changes, motions are not computed"
        yield _rule("sweep.parameter", f"{reason} (another parameter, or no {FRICTION})")
    for path in _RESTITUTION_PATHS:
        if tree.number(path) == 0:
            yield _rule(path, f"got 0: a ball that does not bounce is computed without friction only (no {FRICTION})")


def _falling(tree: _Tree) -> Iterator[Finding]:
    """A restitution that falls with speed is stated at a speed, above 0 and below `MOST_STATED`."""
    stated = not tree.absent(STATED) and STATED not in tree.wrong
    if stated and tree.absent(EXPONENT):
        yield _rule(STATED, f"the restitution does not depend on the speed (give {EXPONENT}, or leave this out)")
    exponent = tree.number(EXPONENT)
    if not exponent:
        return
    if tree.absent(STATED):
        yield _rule(EXPONENT, f"the speed is not given at which the restitution is as stated (give {STATED})")
    for path in _RESTITUTION_PATHS:
        value = tree.number(path)
        if value is not None and not 0 < value < MOST_STATED:
            allowed = f"above 0 and below {MOST_STATED}, or no {EXPONENT}"
            yield _rule(path, f"got {value:.12g}, which cannot fall with speed ({allowed})")
    if tree.number(FRICTION):
        yield _rule(FRICTION, f"got {tree.number(FRICTION):g}, which cannot be combined with {EXPONENT} (give one)")
    rows = tree.at("effects")
    for k, row in enumerate(rows if isinstance(rows, list) else []):
        if isinstance(row, dict) and row.get("effect") == LeftOut.RESTITUTION_SPEED:
            yield _rule(
                f"effects.{k}.effect", f"the restitution falls with speed already, by {EXPONENT} (leave it out)"
            )


def _masses(tree: _Tree) -> Iterator[Finding]:
    if isinstance(tree.at("device.membrane"), dict) and tree.at("device.ball_mass_kg") is None:
        needs = "ball_mass_kg is required where energy is evaluated (give it in device, or delete this block)"
        yield _rule("device.membrane", needs)
    if tree.at("device.capsule") == CapsuleMotion.FREE and tree.absent("device.ball_mass_kg"):
        needs = "a free capsule recoils from the ball, whose mass is not given (give ball_mass_kg, or prescribed)"
        yield _rule("device.capsule", needs)


def _radii(tree: _Tree) -> Iterator[Finding]:
    ball, active = "device.membrane.ball_radius_m", "device.membrane.active_radius_m"
    if not isinstance(tree.at("device.membrane"), dict):
        return
    sizes = [
        default_of(path) if tree.at(path) is None and path not in tree.wrong else tree.number(path)
        for path in (ball, active)
    ]
    small, large = sizes
    if small is None or large is None or small < large:
        return
    if tree.at(ball) is None:
        yield _rule(active, f"got {large:.12g}, which is too small (above ball_radius_m, {small:.12g} by default)")
    else:
        yield _rule(ball, f"got {small:.12g}, which is too large (below active_radius_m, {large:.12g})")


def _dielectric(tree: _Tree) -> Iterator[Finding]:
    stated = [key for key in DIELECTRIC if tree.at(f"device.membrane.{key}") is not None]
    missing = [key for key in DIELECTRIC if tree.absent(f"device.membrane.{key}")]
    if stated and missing:
        lacking = f"{' and '.join(missing)} not given (all of {', '.join(DIELECTRIC)}, or none)"
        yield _rule(f"device.membrane.{stated[0]}", lacking)


def _sweep(tree: _Tree) -> Iterator[Finding]:
    yield from _out_of_range(tree, [("sweep.from", tree.at("sweep.from")), ("sweep.to", tree.at("sweep.to"))])
    if tree.at("sweep") is not None and tree.swept is not None and tree.swept.bounces:
        yield from _bouncing_sweep(tree)
    first, last = tree.number("sweep.from"), tree.number("sweep.to")
    if first is not None and last is not None and abs(last - first) <= NARROWEST_SWEEP * max(abs(first), abs(last)):
        yield _rule("sweep.to", f"got {last:.12g}, the same as sweep.from to nine digits (a different value)")


def _bouncing_sweep(tree: _Tree) -> Iterator[Finding]:
    """A sweep over a restitution is one of 1:1 motions; that of both membranes keeps their difference."""
    for path, reason in NOT_BOUNCING.items():
        if not tree.absent(path) or path in tree.bare:
            yield _rule(path, f"{reason} (leave this out, or sweep something else)")
    for key in OF_WORDS:
        if tree.at(f"requirements.{key}") not in (None, False):
            yield _rule(f"requirements.{key}", f"{NOT_BOUNCING['motions']} (leave this out, or sweep something else)")
    ends = [(path, value) for path in ("sweep.from", "sweep.to") if (value := tree.number(path)) is not None]
    if (tree.number(FRICTION) or 0.0) > 0:
        for path, value in ends:
            if value == 0:
                yield _rule(
                    path, f"got 0: a ball that does not bounce is computed without friction only (no {FRICTION})"
                )
    bottom, top = (tree.number(f"device.{name}") for name in RESTITUTIONS)
    if tree.swept is Parameter.RESTITUTION and bottom is not None and top is not None:
        half = abs(bottom - top) / 2
        for path, value in ends:
            if 0 <= value <= 1 and not half <= value <= LARGEST_RESTITUTION - half:
                allowed = f"from {half:.12g} to {LARGEST_RESTITUTION - half:.12g}"
                yield _rule(path, f"got {value:.12g}, a mean at which that of one membrane is out of range ({allowed})")


def _simulation(tree: _Tree) -> Iterator[Finding]:
    if tree.at("simulation.diagram") is True and tree.absent("sweep"):
        yield _rule("simulation.diagram", "a bifurcation diagram needs a sweep (add one, or set it to false)")
    ways = (Direction.UP, Direction.DOWN, Direction.BOTH)
    if tree.at("simulation.follow") in ways and tree.absent("sweep"):
        yield _rule("simulation.follow", "there is no sweep to go through (add one, or leave this out)")
    for path in ("simulation.portraits", "simulation.displacement"):
        yield from _out_of_range(tree, _elements(path, tree.at(path)))


def _elements(path: str, values: object) -> list[tuple[str, Any]]:
    return [(f"{path}.{i}", value) for i, value in enumerate(values)] if isinstance(values, list) else []


def _out_of_range(tree: _Tree, values: list[tuple[str, Any]]) -> Iterator[Finding]:
    """Values of the swept parameter that it cannot have."""
    if tree.swept is None:
        return
    low, high = tree.swept.limits
    for path, value in values:
        if path not in tree.wrong and type(value) in (int, float) and not low <= value <= high:
            yield Finding(path, Kind.VALUE, value)


def _tolerances(tree: _Tree) -> Iterator[Finding]:
    """At least one tolerance is given, none in per cent of 0, and every value within it is allowed."""
    block = tree.at("tolerances")
    for varied in DesignInput if isinstance(block, dict) else ():
        value = tree.number(varied.path)
        for key in (varied.value, percent_key(varied)):
            path, off = f"tolerances.{key}", tree.number(f"tolerances.{key}")
            if off is None or value is None:
                continue
            if key != varied and value == 0:
                yield _rule(path, f"a percentage of {varied}: 0 is nothing (give {varied} here)")
            width = off if key == varied else value * off / 100
            room = min(value - varied.limits[0], varied.limits[1] - value)
            if width > room and varied is not DesignInput.INCLINATION:
                yield _rule(path, f"takes {varied} {width:.12g} off {value:.12g} (at most {max(room, 0.0):.12g})")
    others = {"distribution", "samples"}
    any_stated = isinstance(block, dict) and any(block[key] is not None for key in block.keys() - others)
    if "tolerances" in tree.bare or (isinstance(block, dict) and not any_stated):
        yield _rule("tolerances", "it has no tolerance (give one, such as length_percent, or delete it)")
    yield from _power_of_two("tolerances.samples", tree.at("tolerances.samples"))


def _starts(tree: _Tree) -> Iterator[Finding]:
    """A motion that a family is to start from lies on the sweep, and within the limits of what is followed."""
    rows = tree.at("motions.starts")
    usual = MotionsBlock()
    impacts, periods = tree.number("motions.impacts") or usual.impacts, tree.number("motions.periods") or usual.periods
    for k, row in enumerate(rows if isinstance(rows, list) else []):
        path = f"motions.starts.{k}"
        if not isinstance(row, dict):
            continue
        if tree.absent("sweep"):
            yield _rule(path, "there is no sweep that a family could be followed along (add one, or leave this out)")
        valid: dict[str, Any] = {key: value for key, value in row.items() if f"{path}.{key}" not in tree.wrong}
        word, periods_of_start, value = (valid.get(key) for key in ("word", "periods", "value"))
        if isinstance(word, str) and len(word) > impacts:
            more = f"has {len(word)} impacts, and motions.impacts is {impacts:g}"
            yield _rule(f"{path}.word", f"{more} (not more than that)")
        if periods_of_start is not None and is_number(periods_of_start) and periods_of_start > periods:
            yield _rule(
                f"{path}.periods", f"got {periods_of_start}, and motions.periods is {periods:g} (not more than that)"
            )
        yield from _off_the_sweep(tree, f"{path}.value", value)


def _off_the_sweep(tree: _Tree, path: str, value: Any) -> Iterator[Finding]:
    """A value of the swept parameter, as it was read, that is outside the sweep."""
    ends = sorted(end for key in ("from", "to") if (end := tree.number(f"sweep.{key}")) is not None)
    if is_number(value) and len(ends) == 2 and not ends[0] <= value <= ends[1]:
        yield _rule(path, f"got {value:.12g}, outside the sweep (from {ends[0]:.12g} to {ends[1]:.12g})")


def _measured(tree: _Tree) -> Iterator[Finding]:
    """A record is of a value within the sweep, if there is one; and a time that is not given has no error."""
    rows = tree.at("measured")
    for k, row in enumerate(rows if isinstance(rows, list) else []):
        path = f"measured.{k}"
        if not isinstance(row, dict):
            continue
        for key in ("value", "direction"):
            if row.get(key) not in (None, Approach.NONE) and tree.absent("sweep"):
                yield _rule(f"{path}.{key}", "there is no sweep to which it could belong (add one, or leave this out)")
        value = row.get("value") if f"{path}.value" not in tree.wrong else None
        yield from _off_the_sweep(tree, f"{path}.value", value)
        if row.get("force_maximum_error_s") is not None and row.get("force_maximum_s") is None:
            yield _rule(f"{path}.force_maximum_error_s", "the time itself is not given (force_maximum_s, or no error)")


def _power_of_two(path: str, samples: object) -> Iterator[Finding]:
    if type(samples) is int and samples > 0 and samples & (samples - 1):
        near = 2 ** round(math.log2(samples))
        yield _rule(path, f"got {samples}, which is no power of 2; Sobol's points need one (such as {near})")


def _effects(tree: _Tree) -> Iterator[Finding]:
    """Each effect has the size that it needs, and leaves a restitution below 1."""
    rows = tree.at("effects")
    for k, row in enumerate(rows if isinstance(rows, list) else []):
        path, named = f"effects.{k}", row.get("effect") if isinstance(row, dict) else None
        effect = next((effect for effect in LeftOut if effect == named), None)
        if effect is None or f"{path}.percent" in tree.wrong:
            continue
        size, exponent = row.get("percent"), row.get("exponent")
        if exponent is not None and effect is not LeftOut.RESTITUTION_SPEED:
            yield _rule(f"{path}.exponent", f"{effect} has no exponent (leave it out)")
        if row.get("speed_m_s") is not None and effect is not LeftOut.RESTITUTION_SPEED:
            yield _rule(f"{path}.speed_m_s", f"{effect} has no speed (leave it out)")
        if effect is LeftOut.RESTITUTION_SPEED:
            if size is not None:
                yield _rule(f"{path}.percent", f"{effect} has no per cent, but an exponent (give that)")
            if exponent is None and f"{path}.exponent" not in tree.wrong:
                yield _rule(path, f"{effect} needs an exponent (exponent, below 0)")
        elif effect not in EFFECTS:
            yield _rule(
                f"{path}.effect", f"{effect} is always considered where it matters (one of {', '.join(EFFECTS)})"
            )
        elif effect not in SIZED:
            if size is not None:
                yield _rule(f"{path}.percent", f"{effect} has no size (leave it out)")
            if tree.absent("device.ball_mass_kg"):
                yield _rule(
                    f"{path}.effect", "needs device.ball_mass_kg, which is not given (give it, or leave it out)"
                )
        elif not is_number(size) or not size:
            yield _rule(f"{path}.percent" if size == 0 else path, f"{effect} needs a size (percent, and not 0)")
        elif effect in ADDED_EFFECTS:
            if size < 0:
                yield _rule(f"{path}.percent", f"got {size:g}, of {ADDED_EFFECTS[effect]} (above 0)")
        else:
            restitution = tree.number("device.restitution")
            value = tree.number(f"device.{effect}") if restitution is None else restitution
            if value == 0:
                yield _rule(f"{path}.percent", f"a percentage of {effect}: 0 is nothing (leave it out)")
            if value is not None and value * (1 + size / 100) >= 1:
                yield _rule(f"{path}.percent", f"makes {effect} {value * (1 + size / 100):.12g} (below 1)")
    if rows is not None and tree.swept is not None and tree.at("sweep") is not None and tree.no_design:
        yield _rule("effects", f"the design point is not given (give {tree.swept.path}, or delete them)")


def _requirements(tree: _Tree) -> Iterator[Finding]:
    """Mistakes in requirements: each must be something that the scenario can decide."""
    block = tree.at("requirements")
    if "requirements" in tree.bare or (isinstance(block, dict) and all(value is None for value in block.values())):
        yield _rule("requirements", "nothing is required in it (give one of its keys, or delete it)")
    if not isinstance(block, dict):
        return
    stated = {key: f"requirements.{key}" for key, value in block.items() if value is not None}
    for need in Need:
        for key in needing(need):
            if key in stated and all(tree.absent(path) for path in need.paths):
                either = " or ".join(need.paths)
                yield _rule(stated[key], f"{need.why} {either}, which is not given (give it, or leave this out)")
    for key in SWITCHES:
        if block.get(key) is False:
            yield _rule(stated[key], "got false, which requires nothing (true, or leave it out)")
    yield from _at_design(tree, stated)
    yield from _ranges(tree, stated)


def _at_design(tree: _Tree, stated: dict[str, str]) -> Iterator[Finding]:
    """Where a parameter is swept, its design value is given if something is required of the design point."""
    if tree.swept is None or tree.at("sweep") is None:
        return
    for key in judged_at_design(tree.swept):
        if key in stated and tree.no_design:
            yield _rule(
                stated[key],
                f"the design point at which it is judged is not given (give {tree.swept.path}, or leave this out)",
            )


def _escape(tree: _Tree) -> Iterator[Finding]:
    """Motions end under kicks where there are some."""
    if tree.at(ESCAPE) is True and tree.absent(KICKS):
        yield _rule(ESCAPE, f"{KICKS} is not given (give it, or leave this out)")


def _design(tree: _Tree) -> Iterator[Finding]:
    """A best design varies each input once, within its limits, and by a quantity that the scenario evaluates."""
    rows = rows_of(tree.data, *VARIED)
    paths = [path_of(row, DesignPath) for row in rows]
    for k, (row, path) in enumerate(zip(rows, paths, strict=True)):
        place = f"design.vary.{k}"
        if path is None or not isinstance(row, dict):
            continue
        if path in paths[:k]:
            yield _rule(f"{place}.path", f"{path} is varied already (each input once)")
        if path.startswith(MEMBRANE) and tree.absent("device.ball_mass_kg"):
            yield _rule(f"{place}.path", "membranes are evaluated where device.ball_mass_kg is given (give it)")
        elif tree.absent(path) and default_of(path) is None:
            yield _rule(f"{place}.path", f"{path} is not given (give the value that the design has now)")
        yield from _axis_limits(row, place, path)
        if is_number(row.get("from")) and row["from"] == row.get("to"):
            yield _rule(f"{place}.to", f"got {row['to']:.12g}, the same as from (a different value)")
    yield from _design_sizes(tree, {path: (f"design.vary.{k}", rows[k]) for k, path in enumerate(paths)})
    if rows and tree.swept is not None and tree.no_design:
        yield _rule("design", f"the design point is not given (give {tree.swept.path}, or delete this block)")
    yield from _objective(tree, paths)


def _objective(tree: _Tree, paths: list[DesignPath | None]) -> Iterator[Finding]:
    """Exactly one quantity is maximised or minimised: an input that varies, or a result that is evaluated."""
    if tree.absent("design"):
        return
    stated = [key for key in ("maximise", "minimise") if not tree.absent(f"design.{key}")]
    if len(stated) != 1:
        fault = "is missing" if not stated else "stands beside minimise"
        yield _rule("design.maximise" if stated else "design", f"maximise {fault} (give either maximise or minimise)")
        return
    (key,) = stated
    name = tree.at(f"design.{key}")
    objective = next((allowed for allowed in Objective if allowed == name), None)
    if objective is None:
        return
    if objective.path is not None and objective.path not in paths:
        yield _rule(f"design.{key}", f"{objective} does not vary (add {objective.path} to design.vary)")
    elif objective is Objective.MARGIN and key == "minimise":
        yield _rule(f"design.{key}", "a margin is no number to make small (maximise it, or require one)")
    elif objective.needs is not None and tree.absent(objective.needs):
        yield _rule(f"design.{key}", f"{objective} needs {objective.needs}, which is not given (give it, or another)")


def _design_sizes(tree: _Tree, rows: dict[DesignPath | None, tuple[str, object]]) -> Iterator[Finding]:
    """The ball of every design is lighter than its capsule, and smaller than the membrane; `rows` are what varies."""
    for smaller, larger in LARGER.items():
        most, least = (_ends_of(tree, path, *rows.get(path, ("", None))) for path in (smaller, larger))
        if rows.keys().isdisjoint((smaller, larger)) or not (most and least):
            continue
        (high_at, high), (low_at, low) = max(most, key=lambda end: end[1]), min(least, key=lambda end: end[1])
        if high >= low and smaller in rows:
            yield _rule(high_at, f"got {high:.12g}, which is too large (below {larger.rpartition('.')[2]}, {low:.12g})")
        elif high >= low:
            yield _rule(low_at, f"got {low:.12g}, which is too small (above {smaller.rpartition('.')[2]}, {high:.12g})")


def _ends_of(tree: _Tree, path: DesignPath, place: str, row: Any) -> list[tuple[str, float]]:
    """The paths and values of the ends of an input's range; for an input that does not vary, of its value."""
    if row is not None:
        return [(f"{place}.{end}", row[end]) for end in ("from", "to") if is_number(row.get(end))]
    value = default_of(path) if tree.at(path) is None else tree.number(path)
    return [] if value is None else [(path, value)]


def default_of(path: str) -> float | None:
    """The default of a key of the membrane; None for other keys."""
    return getattr(MembraneBlock(), path.removeprefix(MEMBRANE)) if path.startswith(MEMBRANE) else None


def _ranges(tree: _Tree, stated: dict[str, str]) -> Iterator[Finding]:
    """Ranges that are required have two ends, and lie within the sweep."""
    for first, last in RANGES:
        if (first in stated) != (last in stated):
            given_end, missing = (first, last) if first in stated else (last, first)
            yield _rule(stated[given_end], f"{missing} is not given (both ends of a range, or neither)")
        elif first in stated and tree.at(stated[first]) == tree.at(stated[last]):
            yield _rule(stated[last], f"got the same value as {first}, which makes no range (a different one)")
    start, end = tree.number("sweep.from"), tree.number("sweep.to")
    if start is None or end is None:
        return
    low, high = sorted((start, end))
    for path in (stated[key] for key in OF_SWEPT if key in stated):
        value = tree.number(path)
        if value is not None and not low <= value <= high:
            allowed = f"a number from {low:.12g} to {high:.12g}"
            yield _rule(path, f"got {value:.12g}, which is outside the sweep ({allowed})")


def _accuracy(tree: _Tree) -> Iterator[Finding]:
    before = 0.0
    for path, factor in _elements("accuracy.ladder", tree.at("accuracy.ladder")):
        if path in tree.wrong or type(factor) not in (int, float):
            return
        if not 1 <= factor <= STIFFEST or factor <= before:
            allowed = f"numbers from 1 to {STIFFEST:g}, each above the one before"
            yield _rule(path, f"got {factor:.12g}, which is out of range or order ({allowed})")
            return
        before = float(factor)


def _axes(tree: _Tree) -> Iterator[Finding]:
    """Each axis of a map has the keys that it needs, and no two vary the same input."""
    sampling = _sampling(tree)
    first_axis: dict[AxisPath, int] = {}
    for k, axis in enumerate(rows_of(tree.data, *AXES)):
        path_of_axis, path = f"map.axes.{k}", path_of(axis, AxisPath)
        if not isinstance(axis, dict):
            continue
        if path is not None and first_axis.setdefault(path, k) != k:
            yield _rule(f"{path_of_axis}.path", f"{path} is axis {first_axis[path]} already (each parameter once)")
        yield from _axis_keys(axis, path_of_axis, sampling)
        if path is not None:
            yield from _axis_limits(axis, path_of_axis, path)
        if is_number(axis.get("from")) and axis["from"] == axis.get("to"):
            yield _rule(f"{path_of_axis}.to", f"got {axis['to']:.12g}, the same as from (a different value)")


def _axis_keys(axis: dict[str, object], path: str, sampling: object) -> Iterator[Finding]:
    """Which keys an axis has depends on how the cells are chosen."""
    ends = {key: axis.get(key) for key in ("from", "to", "count")}
    drawn = sampling in (Sampling.LATIN_HYPERCUBE, Sampling.SOBOL)
    wanted = ("from", "to") if drawn else ("from", "to", "count")
    if axis.get("values") is not None:
        if drawn:
            yield _rule(f"{path}.values", f"{sampling} takes points between from and to (give these instead of a list)")
        extra = [key for key, value in ends.items() if value is not None]
        if extra:
            yield _rule(f"{path}.{extra[0]}", "an axis has either from, to and count, or values (delete one of them)")
    elif sampling == Sampling.LIST:
        yield _rule(path, "a list needs values (a list of numbers, as many as every other axis has)")
    else:
        missing = [key for key in wanted if ends[key] is None]
        if missing:
            alone = "" if drawn else ", or values"
            yield _rule(path, f"{', '.join(missing)} missing (an axis has {', '.join(wanted)}{alone})")
        if drawn and ends["count"] is not None:
            yield _rule(f"{path}.count", f"with {sampling} map.samples says how many points there are (delete it)")


def _axis_limits(axis: dict[str, object], axis_place: str, path: AxisPath | DesignPath) -> Iterator[Finding]:
    low, high = path.limits
    ends = [(f"{axis_place}.{end}", axis.get(end)) for end in ("from", "to")]
    for place, value in [*ends, *_elements(f"{axis_place}.values", axis.get("values"))]:
        restitutions = AxisPath.RESTITUTION, AxisPath.RESTITUTION_BOTTOM, AxisPath.RESTITUTION_TOP
        if path in restitutions and is_number(value) and high < value <= 1:
            limits = f"a number from {low:g} to {high:.12g} where it is varied"
            yield _rule(place, f"got {value:.12g}, which is too large ({limits})")
        elif is_number(value) and not low <= value <= high:
            yield Finding(place, Kind.VALUE, value)


def _sampling(tree: _Tree) -> object:
    """How the cells are chosen, as it was read."""
    block = tree.at("map")
    return block.get("sampling", Sampling.GRID) if isinstance(block, dict) else None


def _cells(tree: _Tree) -> Iterator[Finding]:
    """The number of cells follows from the axes, or is given."""
    sampling, samples = _sampling(tree), tree.at("map.samples")
    axes = [axis for axis in rows_of(tree.data, *AXES) if isinstance(axis, dict)]
    lengths = [len(axis["values"]) if isinstance(axis.get("values"), list) else axis.get("count") for axis in axes]
    if sampling in (Sampling.GRID, Sampling.LIST):
        if samples is not None:
            yield _rule("map.samples", f"a {sampling} has as many cells as its axes say (delete it)")
    elif sampling in (Sampling.LATIN_HYPERCUBE, Sampling.SOBOL) and samples is None:
        yield _rule("map.samples", f"required with {sampling}, but missing (a whole number)")
    if sampling == Sampling.LIST:
        several = {len(axis["values"]) for axis in axes if isinstance(axis.get("values"), list)}
        if len(several) > 1:
            counts = ", ".join(map(str, sorted(several)))
            yield _rule("map.axes", f"the axes of a list have {counts} values (as many each)")
    if sampling == Sampling.SOBOL:
        yield from _power_of_two("map.samples", samples)
    if sampling == Sampling.LATIN_HYPERCUBE and type(samples) is int and samples > MOST_IN_HYPERCUBE:
        most = f"at most {MOST_IN_HYPERCUBE}, as they are drawn at once; {Sampling.SOBOL} takes more"
        yield _rule("map.samples", f"got {samples}, which is too large with {sampling} ({most})")
    if sampling == Sampling.GRID:
        cells = math.prod(count for count in lengths if isinstance(count, int) and count > 0)
        if cells > MOST_CELLS:
            yield _rule("map.axes", f"{cells:.3g} cells (at most {MOST_CELLS:.3g})")
