"""What a scenario may contain, for editors (JSON Schema) and for people (a commented scenario to start from).

Neither is needed to load a scenario, so nothing on that path imports this module. The wording of mistakes
reads its ranges and units from the JSON Schema, so that the two cannot say different things.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any, get_args

from vireport.scenario.blocks import SWEEPABLE, Scenario
from vireport.scenario.keys import NUMBERS, Entry, entries
from vireport.scenario.rules import ANGLES, AT_DESIGN, NEEDS, STABLE

DIALECT = "https://json-schema.org/draft/2020-12/schema"

_TYPES = {float: "number", int: "integer", str: "string", bool: "boolean", NUMBERS: "array"}
_BOUNDS = {
    "ge": "minimum",
    "gt": "exclusiveMinimum",
    "le": "maximum",
    "min_length": "minLength",
    "max_length": "maxLength",
}
_ORDER = ["title", "description", "type", "unit", "minimum", "maximum", "default", "examples", "required"]

# A membrane has no use, and so is a slip, where the ball's mass is not given.
_MEMBRANE_NEEDS_BALL = {
    "if": {
        "required": ["device"],
        "properties": {"device": {"required": ["membrane"], "properties": {"membrane": {"type": "object"}}}},
    },
    "then": {
        "properties": {"device": {"required": ["ball_mass_kg"], "properties": {"ball_mass_kg": {"type": "number"}}}}
    },
}


def schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of scenario.yaml: title, meaning, unit, range and example of every key.

    It accepts what `vireport.scenario.load` accepts. What only a program can compare is beyond it:
    that one mass or radius is smaller than the other, that a range ends elsewhere than it starts, and that one lies
    within another.
    """
    found = _whole()
    rules = [*map(_required_unless_swept, SWEEPABLE), *_sweep_ranges(found), _MEMBRANE_NEEDS_BALL, *_requirements()]
    return {"$schema": DIALECT, **found, "allOf": rules}


def _whole() -> dict[str, Any]:
    """Schema of the blocks, without what holds between several keys."""
    blocks = {block.__name__: _block(block) for block in _within(Scenario)}
    return _ordered({**_block(Scenario), "$defs": dict(sorted(blocks.items()))})


def _within(block: type[Any]) -> Iterator[type[Any]]:
    for entry in entries(block):
        if entry.is_block:
            yield entry.kind
            yield from _within(entry.kind)


def _block(block: type[Any]) -> dict[str, Any]:
    required = [entry.name for entry in entries(block) if entry.required]
    return _ordered(
        {
            "title": block.__name__,
            "description": block.__doc__,
            "type": "object",
            **({"required": required} if required else {}),
            "additionalProperties": False,
            "properties": {entry.name: _key(entry) for entry in entries(block)},
        }
    )


def _key(entry: Entry) -> dict[str, Any]:
    key = entry.key
    if entry.is_block:
        reference = {"$ref": f"#/$defs/{entry.kind.__name__}"}
        if not entry.optional:
            return {"description": key.meaning, **reference}  # its title is that of the block
        return {"title": key.title, "description": key.meaning, "anyOf": [reference, {"type": "null"}]}
    kind = _TYPES.get(entry.kind, "string")
    found: dict[str, Any] = {
        "title": key.title,
        "description": key.meaning,
        "type": [kind, "null"] if entry.optional else kind,
        **{_BOUNDS[name]: bound for name, bound in key.bounds.items()},
        "examples": [key.example],
    }
    if key.unit:
        found["unit"] = key.unit
    if entry.default is not None:
        found["default"] = list(entry.default) if isinstance(entry.default, tuple) else entry.default
    if entry.kind == NUMBERS:
        found["items"] = {"type": "number"}
        found["maxItems"] = found.pop("maxLength")
        if "minLength" in found:
            found["minItems"] = found.pop("minLength")
    if entry.kind not in _TYPES:
        found["enum"] = list(get_args(entry.kind))
    return _ordered(found)


def _ordered(node: dict[str, Any]) -> dict[str, Any]:
    """Put what a reader looks for first."""
    return {name: node[name] for name in sorted(node, key=_rank)}


def _rank(name: str) -> tuple[int, str]:
    return _ORDER.index(name) if name in _ORDER else len(_ORDER), name


def _sweeps(parameter: str) -> dict[str, Any]:
    named = {"type": "object", "required": ["parameter"], "properties": {"parameter": {"const": parameter}}}
    return {"required": ["sweep"], "properties": {"sweep": named}}


def _required_unless_swept(parameter: str) -> dict[str, Any]:
    block, _, key = SWEEPABLE[parameter].rpartition(".")
    wanted = {"required": [key], "properties": {key: {"type": "number"}}}
    return {"if": {"not": _sweeps(parameter)}, "then": {"properties": {block: wanted}} if block else wanted}


def _sweep_ranges(found: dict[str, Any]) -> list[dict[str, Any]]:
    """Give the ends of a sweep the range of the parameter that is swept."""
    rules = []
    for parameter, path in SWEEPABLE.items():
        key = _flatten(found, found)[path]
        bounds = {name: key[name] for name in ("minimum", "maximum")}
        ends = {"properties": {"from": bounds, "to": bounds}}
        rules.append({"if": _sweeps(parameter), "then": {"properties": {"sweep": ends}}})
    return rules


def _requirements() -> Iterator[dict[str, Any]]:
    """What is required must be something that the scenario can decide."""
    null = {"type": "null"}
    for needed, (names, _) in NEEDS.items():
        yield {"if": {"not": _given(needed)}, "then": _of_requirements(dict.fromkeys(names, null))}
    for parameter, path in SWEEPABLE.items():
        names = AT_DESIGN if parameter == "inclination_deg" else (*AT_DESIGN, *ANGLES)
        unknown = {"allOf": [_sweeps(parameter), {"not": _given(path)}]}
        yield {"if": unknown, "then": _of_requirements(dict.fromkeys(names, null))}
    for ends in (STABLE, ANGLES):
        both = {"allOf": [_given(f"requirements.{end}") for end in ends]}
        yield {"if": both, "else": _of_requirements(dict.fromkeys(ends, null))}
    something = {"anyOf": [null, {"not": {"additionalProperties": null}}]}
    yield {"properties": {"requirements": something}}
    yield _of_requirements({"crosscheck_passed": {"not": {"const": False}}})


def _of_requirements(properties: dict[str, Any]) -> dict[str, Any]:
    return {"properties": {"requirements": {"properties": properties}}}


def _given(path: str) -> dict[str, Any]:
    """A tree in which there is something at a path."""
    name, _, rest = path.partition(".")
    inner = _given(rest) if rest else {"not": {"type": "null"}}
    return {"type": "object", "required": [name], "properties": {name: inner}}


@cache
def keys() -> dict[str, dict[str, Any]]:
    """Map the dotted path of every key, blocks included, to its part of the JSON Schema; "" is the whole."""
    whole = schema()
    return {"": whole, **_flatten(whole, whole)}


def _flatten(node: dict[str, Any], whole: dict[str, Any], path: str = "") -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for name, key in node.get("properties", {}).items():
        here = f"{path}.{name}" if path else name
        reference = next((part["$ref"] for part in [key, *key.get("anyOf", [])] if "$ref" in part), None)
        block = whole["$defs"][reference.rpartition("/")[2]] if reference else {}
        found[here] = {**block, **key}
        found.update(_flatten(block, whole, here))
    return found


def init_text() -> str:
    """Return a complete, valid scenario with every key, its unit, its meaning and its default."""
    return TEMPLATE


TEMPLATE = """\
# yaml-language-server: $schema=scenario.schema.json
# The line above gives completion and checks in editors, after `vireport schema > scenario.schema.json`.
#
# Every number is in the unit its key ends in, and is written without it, as 0.7 or 7e-1.
# A key marked "optional" may be left out; a default is the value that stands here.

schema_version: 1                # version of this format
title: Inclined harvester        # optional: one line for the head of the report

device:
  capsule_mass_kg: 0.1245        # M, mass of the capsule
  ball_mass_kg: 0.0041           # optional: m, mass of the ball; without it, no energy is evaluated
  restitution: 0.5               # r, coefficient of restitution, 0 to 1
  length_m: 0.70                 # s, distance between the membranes; where swept, optional: the design point
  membrane:                      # optional: data for voltage and energy; needs ball_mass_kg
    stiffness: 4.0847e5          # K in the restoring force K delta^h, in N/m^h
    exponent: 2.6                # h in the restoring force K delta^h
    active_radius_m: 6.3e-3      # Rc, radius of the membrane's active area
    ball_radius_m: 5.0e-3        # rb, radius of the ball, below active_radius_m
    bias_voltage_v: 2000.0       # Uin, voltage on the undeformed membrane

excitation:
  amplitude_n: 3.0               # F, amplitude of the force on the capsule; where swept, optional
  frequency_hz: 2.0              # omega/(2 pi), frequency of that force; where swept, optional

inclination_deg: 45.0            # beta, from the horizontal, 0 to 90; where swept, optional
gravity_m_s2: 9.8                # optional: g
period_ratio: 1                  # optional: n, forcing periods that one period of the motion takes, 1 to 20

sweep:                           # optional: without it, the design point alone is evaluated
  parameter: length_m            # one of length_m, amplitude_n, frequency_hz, inclination_deg
  from: 0.59                     # first value, in the unit of the parameter
  to: 0.75                       # last value; it may be the smaller of the two

# Without the marks in front of it, the simulation is run beside the solution; it needs the package numba.
# simulation:                    # optional: without it, nothing is simulated
#   samples: 41                    # values of the swept parameter, 2 to 2001
#   starts: 4                      # starting states at each of them, 1 to 64
#   impacts: 1000                  # impacts from each start, 100 to 100000
#   tolerance: 1e-9                # largest difference up to which simulation and solution agree
#   diagram: false                 # whether to draw a bifurcation diagram from simulation alone
#   portraits: []                  # values of the swept parameter for figure 3, at most 8
#   displacement: []               # values of the swept parameter for figure 6, at most 8

# accuracy:                      # optional: error against run time; without it, not measured
#   repeats: 5                     # runs of each method, of which the median time counts, 1 to 100
#   compliant_membrane: true       # whether to solve the motion with the membrane's own stiffness too
#   ladder: [1, 1e2, 1e4, 1e6, 1e8] # factors on that stiffness, from 1 to 1e12, ascending

# requirements:                  # optional: what the design must meet; the exit code is 1 where it does not
#   stable_from: 0.65              # there must be stable motion over this range of the swept parameter
#   stable_to: 0.75                # its other end
#   inclination_from_deg: 40       # there must be stable motion of the design over this range of inclination
#   inclination_to_deg: 50         # its other end
#   margin_period_doubling_percent: 5 # from the design point to a period doubling that ends stability
#   margin_grazing_percent: 5      # the same, to a grazing point
#   margin_any_percent: 5          # the same, to any critical point that ends stability
#   u_ave_at_least_v: 1000         # U_ave at the design point
#   u_ave_difference_at_most_v: 9000 # of U_ave over the range above, or else over all of the stable range
#   u_bottom_top_difference_at_most_v: 30000 # of one end's voltage less the other's, at the design point
#   deflection_at_most_m: 0.02     # of the membranes, at the design point
#   crosscheck_passed: true        # needs the simulation
"""
