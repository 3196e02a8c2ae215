"""What a scenario may contain, for editors (JSON Schema) and for people (a commented scenario to start from).

The wording of mistakes reads its ranges and units from the JSON Schema, so that the two cannot say different things.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from functools import cache
from inspect import cleandoc
from math import isfinite
from pathlib import Path
from types import NoneType
from typing import Any

from vireport.base.additions import ADDITIONS
from vireport.scenario.blocks import Scenario
from vireport.scenario.declared import REQUIRED, Block, Key

DIALECT = "https://json-schema.org/draft/2020-12/schema"

IDENTIFIER = "urn:uuid:4049c3a5-c16d-53b3-9cf7-2e6fde98309b"
"""Names the schema of schema_version 1, wherever it lies; another version has another one. It is no address, as nobody
could promise that one goes on answering.
"""

TYPES = {float: "number", int: "integer", bool: "boolean", NoneType: "null"}
"""Names of the types of values in JSON Schema."""

# What a reader looks for first.
_ORDER = ["title", "description", "type", "unit", "minimum", "maximum", "default", "examples", "required"]


def schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of scenario.yaml: title, meaning, unit, type, range and example of every key.

    It refuses what is wrong with one key alone. What holds between several keys, such as that the ball is lighter than
    the capsule, `vireport check` says, with the line of each mistake.
    """
    return {"$schema": DIALECT, "$id": IDENTIFIER, **_declared(Scenario)}


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
    """Schema of a file by the declarations of its keys, with those of all blocks in it."""
    blocks = dict[str, type[Block]]()
    _gather(model, blocks)
    return _sorted({**_block(model), "$defs": {name: _block(blocks[name]) for name in sorted(blocks)}})


def _known(block: type[Block]) -> dict[str, Key]:
    """The keys of a block by their names in a file, without those of additions that are taken out."""
    keys = block.keys.items()
    return {key.alias or name: key for name, key in keys if key.addition in ("", *ADDITIONS)}


def _gather(block: type[Block], blocks: dict[str, type[Block]]) -> None:
    """Add the blocks within a block, by their names."""
    for key in _known(block).values():
        if issubclass(inner := key.type.kind, Block) and inner.__name__ not in blocks:
            blocks[inner.__name__] = inner
            _gather(inner, blocks)


def _block(block: type[Block]) -> dict[str, Any]:
    """Schema of a block; its title is what editors show."""
    keys = _known(block)
    node: dict[str, Any] = {
        "title": block.__name__.removesuffix("Block"),
        "description": cleandoc(block.__doc__ or ""),
        "type": "object",
        "required": [name for name, key in keys.items() if key.default is REQUIRED],
        "additionalProperties": False,
        "properties": {name: _key(key) for name, key in keys.items()},
    }
    return _sorted({name: part for name, part in node.items() if part != []})


def _key(key: Key) -> dict[str, Any]:
    """Schema of a key, null being one more type or choice where it may be left out."""
    kind, values = key.type, _values(key)
    node: dict[str, Any] = {"items": _sorted(values), "type": "array"} if kind.many else values
    if kind.optional and "$ref" in node:
        node = {"anyOf": [node, {"type": "null"}]}
    elif kind.optional:
        node["type"] = [node["type"], "null"]
        if "enum" in node:
            node["enum"] = [*node["enum"], None]
    told = {"title": key.title, "description": key.meaning, "unit": key.unit, "beyond": key.beyond}
    limits = {"minItems": key.min_length, "maxItems": key.max_length}
    node |= {name: part for name, part in (told | limits).items() if part not in ("", None)}
    if key.default is not REQUIRED and key.default is not None:
        node["default"] = list(key.default) if kind.many else key.default
    if key.examples:
        node["examples"] = [list(example) if kind.many else example for example in key.examples]
    return _sorted(node)


def _values(key: Key) -> dict[str, Any]:
    """Schema of a value of a key, or of the elements of a list."""
    kind, text = key.type.kind, key.type.text
    if issubclass(kind, Block):
        return {"$ref": f"#/$defs/{kind.__name__}"}
    if issubclass(kind, Enum):
        return {"type": "string", "enum": [member.value for member in kind]}
    if kind is str:
        held = {"maxLength": text.longest, "pattern": text.pattern, "description": text.meaning}
        return {"type": "string"} | ({} if text.pattern else {"minLength": 1}) | {k: v for k, v in held.items() if v}
    limits = {"minimum": key.ge, "exclusiveMinimum": key.gt, "maximum": key.le}
    return {"type": TYPES[kind]} | {name: limit for name, limit in limits.items() if isfinite(limit)}


def _sorted(node: dict[str, Any]) -> dict[str, Any]:
    """A schema in the order that a reader looks for its parts."""
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
