"""How the keys of a block are declared, read back, and validated.

A block is a frozen dataclass whose annotations say of each key what it is. Nothing here knows which blocks there are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from types import NoneType
from typing import Any, NamedTuple, get_args, get_origin

from pydantic_core import SchemaValidator

# Of pydantic only the core is used: models would cost more time to set up than it takes to solve a scenario.

NUMBERS = tuple[float, ...]
"""The type of a list of numbers."""


class Key:
    """What there is to say of a key beyond its name, type and default.

    Parameters
    ----------
    title, unit, meaning : str
        For the reader; the unit is "" where there is none, and "1" for a pure number.
    example : object
        A value it may have; None for a block.
    **bounds
        Of the value, by the words of pydantic: ge, gt, le, min_length, max_length.
    """

    __slots__ = ("bounds", "example", "meaning", "title", "unit")

    def __init__(self, title: str, unit: str, meaning: str, example: object = None, **bounds: float) -> None:
        self.title, self.unit, self.meaning = title, unit, meaning
        self.example, self.bounds = example, bounds


class Entry(NamedTuple):
    """A key of a block as it is declared above.

    Attributes
    ----------
    name : str
        In the file.
    attribute : str
        In Python: the name, and an underscore where the name is a word of Python.
    key : Key
        What it means, and its bounds.
    kind : type or Literal
        float, int, str, one of several words, or a block.
    optional : bool
        Whether it may be empty.
    required : bool
        Whether it must stand in the file.
    default : object
        None where it is required, or where there is nothing by default.
    """

    name: str
    attribute: str
    key: Key
    kind: Any
    optional: bool
    required: bool
    default: object

    @property
    def is_block(self) -> bool:
        """Whether it holds keys of its own."""
        return is_dataclass(self.kind)


def entries(block: type[Any]) -> Iterator[Entry]:
    """Every key of a block, in the order of the format."""
    for field in fields(block):
        hint, key = get_args(field.type)
        optional = NoneType in get_args(hint)
        kind = get_args(hint)[0] if optional else hint
        required = field.default is MISSING
        default = None if required else field.default
        yield Entry(field.name.removesuffix("_"), field.name, key, kind, optional, required, default)


# Every block needs it: none takes over that of the block around it.
_STRICTLY = {"strict": True, "extra_fields_behavior": "forbid", "allow_inf_nan": False}
_CORE_TYPES = {float: "float", int: "int", str: "str", bool: "bool"}


@cache
def validator(block: type[Any]) -> SchemaValidator:
    """What makes a block of a tree as it is read from a file.

    Its `validate_python` raises pydantic_core.ValidationError with all values that are wrong in themselves, and all
    keys that are unknown or missing.
    """
    return SchemaValidator(block_schema(block))


def block_schema(block: type[Any]) -> Any:
    """Schema, in the terms of pydantic's core, of a dictionary that becomes a block.

    A key that is left out is not filled in by it: the default of the class holds.
    """
    found: dict[str, Any] = {}
    for entry in entries(block):
        schema = _value_schema(entry.kind, entry.key.bounds)
        if entry.optional:
            schema = {"type": "nullable", "schema": schema}
        found[entry.attribute] = {
            "type": "typed-dict-field",
            "schema": schema,
            "required": entry.required,
            "validation_alias": entry.name,
        }
    tree = {"type": "typed-dict", "fields": found, "config": _STRICTLY}
    make = {"type": "no-info", "function": lambda values: block(**values)}
    return {"type": "function-after", "schema": tree, "function": make}


def _value_schema(kind: Any, bounds: dict[str, float]) -> Any:
    """Schema of a value: a block, a number, a text, a truth value, a list of such, or one of several words."""
    if isinstance(kind, type) and is_dataclass(kind):
        return block_schema(kind)
    if kind in _CORE_TYPES:
        return {"type": _CORE_TYPES[kind], **bounds}
    if get_origin(kind) is not tuple:
        return {"type": "literal", "expected": list(get_args(kind))}
    several = {"type": "list", "items_schema": _value_schema(get_args(kind)[0], {}), **bounds}
    return {"type": "function-after", "schema": several, "function": {"type": "no-info", "function": tuple}}
