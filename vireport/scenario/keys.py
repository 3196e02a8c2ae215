"""How keys and blocks of a scenario are declared, by the scenario itself and by additions.

An addition declares its keys in its module `keys`, as `KEYS`: the type and the key of each by its path, for a block of
the addition and for keys that it adds to blocks of the scenario.
"""
# Annotations are evaluated where they stand: as texts, pydantic compiled each of 200, a quarter of this import.

from collections.abc import Mapping
from types import NoneType
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter, create_model
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from vireport.base.additions import declared
from vireport.scenario.parameters import LARGEST, SMALLEST


class Block(BaseModel):
    """A block of keys: frozen, without keys that are not declared, and without conversion of types."""

    model_config = ConfigDict(
        frozen=True,
        strict=True,
        extra="forbid",
        allow_inf_nan=False,
        defer_build=True,
        model_title_generator=lambda block: block.__name__.removesuffix("Block"),  # editors show the title
    )

    def __repr__(self) -> str:
        """The block with the keys that are given."""
        values = ", ".join(
            f"{key}={getattr(self, key)!r}" for key in type(self).model_fields if key in self.model_fields_set
        )
        return f"{type(self).__name__}({values})"


class _WhenGiven:
    """Has a block validated by its own validator, which pydantic builds when it is first used.

    Building the validators of all blocks takes a hundredth of a run with --json, and most scenarios have few blocks.
    """

    def __get_pydantic_core_schema__(self, block: type[Block], _: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(block.model_validate, metadata={"block": block})

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        # Within a schema of definitions the block becomes a reference; by itself it would be written out here.
        return handler(core_schema.definitions_schema(TypeAdapter(schema["metadata"]["block"]).core_schema, []))


AnyBlock = TypeVar("AnyBlock", bound=Block)

WhenGiven = Annotated[AnyBlock, _WhenGiven()]
"""A block that most scenarios do not have, validated as `_WhenGiven` says."""


REQUIRED: object = ...
"""In place of a default: the key must be given."""


def key(
    default: object,
    title: str,
    unit: str,
    meaning: str,
    *,
    example: object = None,
    beyond: str = "",
    addition: str = "",
    behind: str = "",
    in_map: str = "",
    **rules: Any,
) -> Any:
    """Declare a key of a scenario.

    Parameters
    ----------
    default : object
        `REQUIRED` where there is none; it is the example as well where no `example` is given.
    title, unit, meaning : str
        Texts for the reader. The unit is "" where there is none, and "1" for a pure number.
    beyond : str
        Why a value beyond the range is refused.
    addition : str
        Name of the addition without which the key is unknown; "" for a key of the scenario itself.
    behind : str
        For an addition's key in a block of the scenario, the key that it stands behind.
    in_map : str
        For an addition's block, why a map refuses it; "" where a map may have it.
    **rules
        Rules of pydantic, such as `ge`.
    """
    example = default if example is None and default is not REQUIRED else example
    extra = {"unit": unit, "beyond": beyond, "addition": addition, "behind": behind, "in_map": in_map}
    return Field(
        default,
        title=title,
        description=meaning,
        examples=None if example is None else [example],
        json_schema_extra={name: text for name, text in extra.items() if text} or None,
        **rules,
    )


def positive(default: object, title: str, unit: str, meaning: str, **declared: Any) -> Any:
    """Declare a key whose value is a number from `SMALLEST` to `LARGEST`; see `key`."""
    return key(default, title, unit, meaning, ge=SMALLEST, le=LARGEST, **declared)


def added_keys(within: str = "") -> Mapping[str, tuple[object, Any]]:
    """The keys that additions bring to a block of a scenario, by their names, each with its type and its key.

    Without `within` they are whole blocks.
    """
    paths = {path: of for keys in declared("keys") for path, of in keys.items()}
    return {name: of for path, of in paths.items() for block, _, name in [path.rpartition(".")] if block == within}


def with_added_keys(block: type[AnyBlock], within: str = "") -> type[AnyBlock]:
    """A block of keys with those that additions bring to it behind its own; `within` is its path in a scenario."""
    added = dict(added_keys(within))
    return _extended(block, added) if added else block


def without_added_keys(block: type[AnyBlock]) -> type[AnyBlock]:
    """A block of keys that refuses the blocks of additions which a map cannot have."""
    reasons = {name: (of.title, declared_with(of, "in_map")) for name, (_, of) in added_keys().items()}
    refused = {name: (NoneType, key(None, title, "", reason)) for name, (title, reason) in reasons.items() if reason}
    return _extended(block, refused) if refused else block


def names_in_order(block: type[Block]) -> list[str]:
    """The names of the keys of a block, those of additions behind the key that they name."""
    names = list(block.model_fields)
    for name, of in block.model_fields.items():
        if behind := declared_with(of, "behind"):
            names.remove(name)
            names.insert(names.index(behind) + 1, name)
    return names


def declared_with(of: FieldInfo, name: str) -> str:
    """A text in the declaration of a key beyond pydantic's own, such as its unit; "" where there is none."""
    extra = of.json_schema_extra
    return str(extra.get(name, "")) if isinstance(extra, dict) else ""


def _extended(block: type[AnyBlock], fields: dict[str, Any]) -> type[AnyBlock]:
    return create_model(block.__name__, __base__=block, __doc__=block.__doc__, __module__=block.__module__, **fields)


def value_at(scenario: Block, path: str) -> Any:
    """The value of a key of a scenario by its path; None where it or its block is not given, or not known."""
    value: object = scenario
    for name in path.split("."):
        value = getattr(value, name, None)
    return value


def block_of(scenario: Block, name: str, kind: type[AnyBlock]) -> AnyBlock | None:
    """The block of an addition in a scenario; None where it is not given."""
    block = getattr(scenario, name)
    assert block is None or isinstance(block, kind)
    return block
