"""The keys of a scenario for editors (JSON Schema) and for people (a commented scenario to start from).

The wording of mistakes reads its ranges and units from the JSON Schema, so that the two cannot say different things.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from vireport.base.additions import ADDITIONS
from vireport.base.encoding import json_text
from vireport.scenario.blocks import Scenario
from vireport.scenario.keys import added_keys

DIALECT = "https://json-schema.org/draft/2020-12/schema"

IDENTIFIER = "urn:uuid:4049c3a5-c16d-53b3-9cf7-2e6fde98309b"
"""Name of the schema of schema_version 1, wherever it lies; another version has another name. It is no address, as
nobody could promise that an address goes on answering.
"""

OF_ADDITIONS = "addition", "behind", "in_map"
"""Names in the declarations of additions' keys that no reader needs."""

REQUIREMENTS = re.compile(r"^# requirements:.*\n(?:#   .*\n)+", re.MULTILINE)
"""The block of requirements in a complete scenario, commented out."""

# What a reader looks for first.
_ORDER = ["title", "description", "type", "unit", "minimum", "maximum", "default", "examples", "required"]


def schema() -> dict[str, object]:
    """JSON Schema (draft 2020-12) of scenario.yaml: title, meaning, unit, type, range and example of every key.

    It refuses mistakes in single keys. Rules between several keys, such as that the ball is lighter than the capsule,
    are checked by `vireport check`, with the line of each mistake.
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
    text = Path(__file__).with_name("template.yaml").read_text(encoding="utf-8")
    declared = keys(Scenario)
    text = REQUIREMENTS.sub(lambda block: block[0] + _commented("requirements", declared, block[0]), text)
    added = [name for name in added_keys() if f"\n# {name}:" not in text]
    return "".join((text, *(f"\n{_row(f'# {name}:', declared[name])}{_commented(name, declared)}" for name in added)))


def _commented(block: str, declared: dict[str, dict[str, Any]], stated: str = "") -> str:
    """Lines of the keys of a block that are not stated, commented out, as they are optional."""
    inner = ((path.removeprefix(f"{block}."), key) for path, key in declared.items() if path.startswith(f"{block}."))
    rows = [(f"#   {name}: ", key) for name, key in inner if "*" not in name]
    return "".join(_row(row + json_text(key["examples"][0]), key) for row, key in rows if row not in stated)


def _row(rule: str, key: dict[str, Any]) -> str:
    """A line of a complete scenario, with the title of its key and its unit as a comment."""
    return f"{rule:<32} # {key['title']}{', ' + key['unit'] if 'unit' in key else ''}\n"


def _declared(model: type[Scenario]) -> dict[str, Any]:
    """Schema of the keys as they are declared, without the rules between several keys."""
    whole = model.model_json_schema()
    words = {name: node for name, node in whole["$defs"].items() if "enum" in node}
    whole["$defs"] = {name: node for name, node in whole["$defs"].items() if name not in words}
    return _plain(whole, words)


def _plain(node: dict[str, Any], words: dict[str, object]) -> dict[str, object]:
    """A schema as a person would write it: choices of words in place of references, and null as one more type."""
    node = {name: value for name, value in node.items() if name != "default" or value is not None}
    for name in OF_ADDITIONS:
        node.pop(name, None)
    for name in {"properties", "$defs"} & set(node):
        properties = {key: value for key, value in node[name].items() if value.get("addition") in (None, *ADDITIONS)}
        node[name] = {key: _plain(value, words) for key, value in properties.items()}
    node = _spelled(node, words)
    kinds = [_spelled(kind, words) for kind in node.get("anyOf", [])]
    if kinds and "type" in kinds[0]:
        if "enum" in kinds[0]:
            kinds[0] = kinds[0] | {"enum": [*kinds[0]["enum"], None]}
        node = {**kinds[0], **node, "type": [kind["type"] for kind in kinds]}
        del node["anyOf"]
    return {name: node[name] for name in sorted(node, key=_rank)}


def _spelled(node: dict[str, Any], words: dict[str, Any]) -> dict[str, Any]:
    """A schema with the words of a choice in place of a reference to them."""
    choice = words.get(node.get("$ref", "").rpartition("/")[2])
    if choice is None:
        return node
    return {name: value for name, value in node.items() if name != "$ref"} | {
        "type": choice["type"],
        "enum": choice["enum"],
    }


def _rank(name: str) -> tuple[int, str]:
    return _ORDER.index(name) if name in _ORDER else len(_ORDER), name


def _flat(node: dict[str, Any], blocks: dict[str, Any], path: str = "") -> Iterator[tuple[str, dict[str, object]]]:
    inner = [(f"{path}.{name}" if path else name, key) for name, key in node.get("properties", {}).items()]
    if "items" in node:
        unit = {"unit": node["unit"]} if "unit" in node else {}
        inner.append((f"{path}.*", {**node["items"], **unit}))
    for inner_path, key in inner:
        reference = next((part["$ref"] for part in [key, *key.get("anyOf", [])] if "$ref" in part), "")
        whole = {**blocks.get(reference.rpartition("/")[2], {}), **key}
        yield inner_path, whole
        yield from _flat(whole, blocks, inner_path)
