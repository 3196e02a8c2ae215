"""What a scenario may contain, for editors (JSON Schema) and for people (a commented scenario to start from).

The wording of mistakes reads its ranges and units from the JSON Schema, so that the two cannot say different things.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from vireport.scenario.blocks import Approach, CapsuleMotion, LeftOut, Need, Scenario, percent_key
from vireport.scenario.parameters import DRIVING, DesignInput, Parameter
from vireport.scenario.rules import (
    DIELECTRIC,
    EXPONENT,
    FRICTION,
    MOST_STATED,
    OF_WORDS,
    PLAIN_REQUIREMENTS,
    RANGES,
    RESTITUTIONS,
    SINE_ONLY,
    SPECIAL,
    STATED,
    SWITCHES,
    Special,
    judged_at_design,
    needing,
)

DIALECT = "https://json-schema.org/draft/2020-12/schema"

IDENTIFIER = "urn:uuid:4049c3a5-c16d-53b3-9cf7-2e6fde98309b"
"""Names the schema of schema_version 1, wherever it lies; another version has another one. It is no address, as nobody
could promise that one goes on answering.
"""

# What a reader looks for first.
_ORDER = ["title", "description", "type", "unit", "minimum", "maximum", "default", "examples", "required"]


def _needs_ball(key: str, given: dict[str, Any]) -> dict[str, Any]:
    """That the ball's mass is given where a key of the device is so."""
    return {
        "if": {
            "required": ["device"],
            "properties": {"device": {"required": [key], "properties": {key: given}}},
        },
        "then": {
            "properties": {"device": {"required": ["ball_mass_kg"], "properties": {"ball_mass_kg": {"type": "number"}}}}
        },
    }


# A membrane has no use, and so is a slip, where the ball's mass is not given; a free capsule recoils from it.
_NEED_BALL = _needs_ball("membrane", {"type": "object"}), _needs_ball("capsule", {"const": CapsuleMotion.FREE.value})


# One restitution of both membranes, or one of each.
_RESTITUTIONS = {
    "properties": {
        "device": {
            "oneOf": [
                {
                    "required": [*given],
                    "properties": {
                        **{key: {"type": "number"} for key in given},
                        **{key: {"type": "null"} for key in left_out},
                    },
                }
                for given, left_out in ((("restitution",), RESTITUTIONS), (RESTITUTIONS, ("restitution",)))
            ]
        }
    }
}


# What only knows a force that is a sine is not asked for beside harmonics.
_SINE_ONLY = {
    "if": {
        "required": ["excitation"],
        "properties": {
            "excitation": {
                "type": "object",
                "required": ["harmonics"],
                "properties": {
                    "harmonics": {
                        "type": "array",
                        "contains": {
                            "type": "object",
                            "required": ["percent"],
                            "properties": {"percent": {"type": "number", "exclusiveMinimum": 0}},
                        },
                    }
                },
            }
        },
    },
    "then": {
        "properties": {
            **{block: {"type": "null"} for block in SINE_ONLY if block in Scenario.model_fields},
            "disturbances": {"properties": {"prove": {"not": {"const": True}}}},
        }
    },
}


_BOUNCES = "restitution", *RESTITUTIONS


def _own_key(path: str) -> str:
    return path.rpartition(".")[2]


def _of_special(special: Special, **more: Any) -> dict[str, Any]:
    """That what does not know a key of the ball is not asked for where that is not 0, and further properties."""
    key = special.name
    given = {"type": "number", "not": {"const": 0}}
    return {
        "if": {
            "required": ["device"],
            "properties": {"device": {"type": "object", "required": [key], "properties": {key: given}}},
        },
        "then": {
            "properties": {
                **{block: {"type": "null"} for block in special.blocks if block in Scenario.model_fields},
                "requirements": {"properties": {key: {"enum": [None, False]} for key in PLAIN_REQUIREMENTS}},
                **more,
            }
        },
    }


# A ball with friction bounces, at one inclination; a restitution that falls is stated at a speed, of a ball without it.
_MORE_OF_SPECIAL: dict[str, dict[str, Any]] = {
    FRICTION: {
        "sweep": {"properties": {"parameter": {"not": {"const": Parameter.INCLINATION.value}}}},
        "device": {"properties": {name: {"not": {"const": 0}} for name in _BOUNCES}},
    },
    EXPONENT: {
        "device": {
            "required": [_own_key(STATED)],
            "properties": {
                _own_key(STATED): {"type": "number"},
                _own_key(FRICTION): {"maximum": 0},
                **{name: {"exclusiveMinimum": 0, "exclusiveMaximum": MOST_STATED} for name in _BOUNCES},
            },
        },
        "effects": {
            "items": {"properties": {"effect": {"not": {"const": LeftOut.RESTITUTION_SPEED.value}}}},
        },
    },
}

# A speed at which a restitution is stated that does not depend on it is a slip.
_STATED_ALONE = {
    "if": {
        "required": ["device"],
        "properties": {
            "device": {"required": [_own_key(STATED)], "properties": {_own_key(STATED): {"type": "number"}}}
        },
    },
    "then": {
        "properties": {
            "device": {"required": [_own_key(EXPONENT)], "properties": {_own_key(EXPONENT): {"type": "number"}}}
        }
    },
}


def _of_records(item: dict[str, Any]) -> dict[str, Any]:
    return {"properties": {"measured": {"items": item}}}


# A value is of a sweep, and an error of a time that is given.
_RECORDS = (
    {
        "if": {"not": {"required": ["sweep"], "properties": {"sweep": {"type": "object"}}}},
        "then": _of_records({"properties": {"value": {"type": "null"}, "direction": {"const": Approach.NONE.value}}}),
    },
    _of_records(
        {
            "if": {"required": ["force_maximum_error_s"], "properties": {"force_maximum_error_s": {"type": "number"}}},
            "then": {"required": ["force_maximum_s"], "properties": {"force_maximum_s": {"type": "number"}}},
        }
    ),
)


_SOME_TOLERANCE = {
    "properties": {
        "tolerances": {
            "anyOf": [
                {"type": "null"},
                *(
                    {"required": [key], "properties": {key: {"type": "number"}}}
                    for varied in DesignInput
                    for key in (varied.value, percent_key(varied))
                ),
            ]
        }
    }
}


def _sweeps(parameter: Parameter) -> dict[str, Any]:
    named = {"type": "object", "required": ["parameter"], "properties": {"parameter": {"const": parameter.value}}}
    return {"required": ["sweep"], "properties": {"sweep": named}}


# Along a sweep over a restitution only 1:1 motions are known, and of a ball with friction only those that bounce.
_BOUNCING = {
    "if": {"anyOf": [_sweeps(parameter) for parameter in Parameter if parameter.bounces]},
    "then": {
        "properties": {
            "motions": {"type": "null"},
            "accuracy": {"type": "null"},
            "requirements": {"properties": {key: {"enum": [None, False]} for key in OF_WORDS}},
        },
        "if": {
            "required": ["device"],
            "properties": {
                "device": {
                    "type": "object",
                    "required": [_own_key(FRICTION)],
                    "properties": {_own_key(FRICTION): {"exclusiveMinimum": 0}},
                }
            },
        },
        "then": {"properties": {"sweep": {"properties": {end: {"not": {"const": 0}} for end in ("from", "to")}}}},
    },
}


def schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of scenario.yaml: title, meaning, unit, range and example of every key.

    It accepts what `vireport.scenario.load` accepts. What only a program can compare is beyond it:
    that one mass or radius is smaller than the other, that a range ends elsewhere than it starts, that one lies within
    another, and that no harmonic is given twice.
    """
    rules = [
        *map(_required_unless_swept, DRIVING),
        *map(_limits_of_sweep, Parameter),
        _RESTITUTIONS,
        _SINE_ONLY,
        *(_of_special(special, **_MORE_OF_SPECIAL[special.key]) for special in SPECIAL),
        _STATED_ALONE,
        _BOUNCING,
        *_NEED_BALL,
        _all_or_none("device.membrane", DIELECTRIC),
        _SOME_TOLERANCE,
        *_RECORDS,
        *_requirements(),
    ]
    return {"$schema": DIALECT, "$id": IDENTIFIER, **_declared(Scenario), "allOf": rules}


@cache
def keys(model: type[Scenario]) -> dict[str, dict[str, Any]]:
    """Map the path of every key of a file to its part of the JSON Schema.

    Blocks are included, "" is the whole, and ``*`` stands for the number of a list's element.
    """
    whole = _declared(model)
    return {"": whole, **dict(_flat(whole, whole["$defs"]))}


def init_text() -> str:
    """Return a complete, valid scenario with every key, its unit, its meaning and its default."""
    return Path(__file__).with_name("template.yaml").read_text(encoding="utf-8")


def _declared(model: type[Scenario]) -> dict[str, Any]:
    """Schema of the keys as they are declared, without what holds between several of them."""
    whole = model.model_json_schema()
    words = {name: node for name, node in whole["$defs"].items() if "enum" in node}
    whole["$defs"] = {name: node for name, node in whole["$defs"].items() if name not in words}
    return _plain(whole, words)


def _plain(node: dict[str, Any], words: dict[str, Any]) -> dict[str, Any]:
    """A schema as a person would write it: a choice of words where it belongs, and null as one more type."""
    node = {name: value for name, value in node.items() if name != "default" or value is not None}
    for name in {"properties", "$defs"} & set(node):
        node[name] = {key: _plain(value, words) for key, value in node[name].items()}
    choice = words.get(node.get("$ref", "").rpartition("/")[2])
    if choice:
        node = {**node, "type": choice["type"], "enum": choice["enum"]}
        del node["$ref"]
    kinds = node.get("anyOf", [])
    if kinds and "type" in kinds[0]:
        node = {**kinds[0], **node, "type": [kind["type"] for kind in kinds]}
        del node["anyOf"]
    return {name: node[name] for name in sorted(node, key=_rank)}


def _rank(name: str) -> tuple[int, str]:
    return _ORDER.index(name) if name in _ORDER else len(_ORDER), name


def _flat(node: dict[str, Any], blocks: dict[str, Any], path: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    inner = [(f"{path}.{name}" if path else name, key) for name, key in node.get("properties", {}).items()]
    if "items" in node:
        unit = {"unit": node["unit"]} if "unit" in node else {}
        inner.append((f"{path}.*", {**node["items"], **unit}))
    for here, key in inner:
        reference = next((part["$ref"] for part in [key, *key.get("anyOf", [])] if "$ref" in part), "")
        whole = {**blocks.get(reference.rpartition("/")[2], {}), **key}
        yield here, whole
        yield from _flat(whole, blocks, here)


def _required_unless_swept(parameter: Parameter) -> dict[str, Any]:
    block, _, key = parameter.path.rpartition(".")
    wanted = {"required": [key], "properties": {key: {"type": "number"}}}
    return {"if": {"not": _sweeps(parameter)}, "then": {"properties": {block: wanted}} if block else wanted}


def _limits_of_sweep(parameter: Parameter) -> dict[str, Any]:
    low, high = parameter.limits
    ends = {end: {"minimum": low, "maximum": high} for end in ("from", "to")}
    return {"if": _sweeps(parameter), "then": {"properties": {"sweep": {"properties": ends}}}}


def _requirements() -> Iterator[dict[str, Any]]:
    """What is required must be something that the scenario can decide."""
    null = {"type": "null"}
    for need in Need:
        given = [_given(path) for path in need.paths]
        missing = {"not": {"anyOf": given} if len(given) > 1 else given[0]}
        yield {"if": missing, "then": _of_requirements(dict.fromkeys(needing(need), null))}
    for parameter in DRIVING:
        unknown = {"allOf": [_sweeps(parameter), {"not": _given(parameter.path)}]}
        yield {"if": unknown, "then": _of_requirements(dict.fromkeys(judged_at_design(parameter), null))}
    for ends in RANGES:
        yield _all_or_none("requirements", ends)
    something = {"anyOf": [null, {"not": {"additionalProperties": null}}]}
    yield {"properties": {"requirements": something}}
    yield _of_requirements({key: {"not": {"const": False}} for key in SWITCHES})


def _all_or_none(block: str, names: tuple[str, ...]) -> dict[str, Any]:
    """Keys of a block that are given together."""
    none: dict[str, Any] = {"properties": {name: {"type": "null"} for name in names}}
    for step in reversed(block.split(".")):
        none = {"properties": {step: none}}
    return {"if": {"allOf": [_given(f"{block}.{name}") for name in names]}, "else": none}


def _of_requirements(properties: dict[str, Any]) -> dict[str, Any]:
    return {"properties": {"requirements": {"properties": properties}}}


def _given(path: str) -> dict[str, Any]:
    """A tree in which there is something at a path."""
    name, _, rest = path.partition(".")
    inner = _given(rest) if rest else {"not": {"type": "null"}}
    return {"type": "object", "required": [name], "properties": {name: inner}}
