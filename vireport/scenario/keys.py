"""What keys and blocks of a scenario are declared with, by the scenario itself and by additions.

An addition with a block of its own declares it in its module `keys`, as `KEYS`: by its name, its type and its key.
"""
# Annotations are evaluated where they stand: as texts, pydantic compiled each of 200, a quarter of this import.

from collections.abc import Mapping
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter, create_model
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from vireport.base.additions import declared


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
        """The block without the keys that are not given."""
        values = ", ".join(
            f"{key}={getattr(self, key)!r}" for key in type(self).model_fields if key in self.model_fields_set
        )
        return f"{type(self).__name__}({values})"


class _WhenGiven:
    """Has a block validated by its own validator, which pydantic builds when it is first used.

    To build those of all blocks takes a hundredth of a run with --json, and most scenarios have few of them.
    """

    def __get_pydantic_core_schema__(self, block: type[Block], _: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(block.model_validate, metadata={"block": block})

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        # Within a schema of definitions the block becomes a reference; by itself it would be written out here.
        return handler(core_schema.definitions_schema(TypeAdapter(schema["metadata"]["block"]).core_schema, []))


AnyBlock = TypeVar("AnyBlock", bound=Block)

WhenGiven = Annotated[AnyBlock, _WhenGiven()]
"""A block that most scenarios are without."""


REQUIRED: Any = ...
"""Stands for the default of a key that has none."""


def key(
    default: Any,
    title: str,
    unit: str,
    meaning: str,
    *,
    example: Any = None,
    beyond: str = "",
    addition: str = "",
    **rules: Any,
) -> Any:
    """Declare a key; the unit is "" where there is none and "1" for a pure number, the example that of its default.

    What is beyond its range is refused with the reason `beyond`. Without its `addition` the key is an unknown one.
    """
    example = default if example is None and default is not REQUIRED else example
    extra = {"unit": unit, "beyond": beyond, "addition": addition}
    return Field(
        default,
        title=title,
        description=meaning,
        examples=None if example is None else [example],
        json_schema_extra={name: text for name, text in extra.items() if text} or None,
        **rules,
    )


def added_keys() -> Mapping[str, tuple[Any, Any]]:
    """The blocks that additions bring, by their names, each with its type and its key."""
    return {name: of for keys in declared("keys") for name, of in keys.items()}


def with_added_keys(block: type[AnyBlock]) -> type[AnyBlock]:
    """A block of keys with those that additions bring behind its own."""
    added: dict[str, Any] = dict(added_keys())
    return _extended(block, added) if added else block


def without_added_keys(block: type[AnyBlock]) -> type[AnyBlock]:
    """A block of keys that has none of those that additions bring to the block which it extends."""
    refused = {
        name: (None, key(None, of.title, "", f"a map has no {name} (delete it)"))
        for name, (_, of) in added_keys().items()
    }
    return _extended(block, refused) if refused else block


def _extended(block: type[AnyBlock], fields: dict[str, Any]) -> type[AnyBlock]:
    return create_model(block.__name__, __base__=block, __doc__=block.__doc__, __module__=block.__module__, **fields)


def block_of(scenario: Block, name: str, kind: type[AnyBlock]) -> AnyBlock | None:
    """The block of an addition in a scenario; None where it is not given."""
    block = getattr(scenario, name)
    assert block is None or isinstance(block, kind)
    return block
