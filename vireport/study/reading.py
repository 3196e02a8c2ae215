"""Reads results as records: whatever is not of its type is a mistake with its path, as in a scenario."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from operator import attrgetter
from sys import float_info
from typing import Any, TypeVar

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import MOST_MISTAKES, UsageError
from vireport.scenario.parameters import DRIVING
from vireport.study.result_records import SCHEMA_VERSION, BranchData, DesignData, Results, ScenarioKeys
from vireport.text.foreign import visible

LONGEST_TEXT = 200
"""Characters of a text of a file that are shown."""

REQUIRED_KEYS = (
    *("schema_version", "scenario", "branches", "critical_points"),
    *("stable_range", "design_point", "alerts"),
)

Mistakes = Iterator[tuple[str, str]]
"""Mistakes in data: the path of each, and what is wrong there."""

Record = TypeVar("Record", bound=Struct)


class ResultsError(UsageError):
    """Results that cannot be read, with the first mistakes in them.

    Parameters
    ----------
    name : str
        Name of the file.
    mistakes : iterable of (str, str)
        At least one: its path, and what is wrong there.
    """

    def __init__(self, name: str, mistakes: Iterable[tuple[str, str]]) -> None:
        first = [
            f"{name}: {visible(path, LONGEST_TEXT)}: {what}" if path else f"{name}: {what}"
            for path, what in islice(mistakes, MOST_MISTAKES + 1)
        ]
        more = [f"{name}: and more (mend these first)"] if len(first) > MOST_MISTAKES else []
        super().__init__(*first[:MOST_MISTAKES], *more)


def read_results(data: object, name: str) -> Results:
    """Read the content of a results.json as records; keys that no record declares are blocks of additions, or newer.

    Parameters
    ----------
    data : object
        As `json.load` gives it.
    name : str
        Of the file, for messages.

    Raises
    ------
    UsageError
        Where it is none, is of another version, or has mistakes.
    """
    if not isinstance(data, Mapping):
        raise UsageError(f"{name}: is no results.json (a block of keys)")
    if missing := [key for key in REQUIRED_KEYS if key not in data]:
        raise UsageError(f"{name}: is no results.json of vireport: {', '.join(missing)} missing")
    version = data["schema_version"]
    if version != SCHEMA_VERSION:
        text = visible(repr(version), LONGEST_TEXT)
        raise UsageError(f"{name}: schema_version {text} is not understood (allowed: {SCHEMA_VERSION})")
    _require_finite(data, name)
    keys = read_record(data["scenario"], ScenarioKeys, name, "scenario")
    blocks = {key: block for key, block in data.items() if key not in Results.__struct_encode_fields__}
    results = replace(read_record(data, Results, name), added=blocks)
    if incomplete := [*_not_stated(keys), *_incomplete(results, keys.device.ball_mass_kg is not None)]:
        raise ResultsError(name, incomplete)
    return results


def read_record(data: object, kind: type[Record], name: str, path: str = "") -> Record:
    """Read plain data of an earlier run as a record.

    Parameters
    ----------
    data : object
    kind : type
        Of the record.
    name : str
        Of the file, for messages.
    path : str
        Of the data in the file.

    Raises
    ------
    ResultsError
        With every mistake in the data.
    """
    try:
        return msgspec.convert(data, kind)
    except msgspec.ValidationError as error:
        # What msgspec says is of the first mistake alone, and in words for programmers.
        mistakes = list(islice(_mistakes(data, msgspec.inspect.type_info(kind), path), MOST_MISTAKES + 1))
        raise ResultsError(name, mistakes or [(path, visible(str(error), LONGEST_TEXT))]) from None


def _mistakes(value: object, kind: msgspec.inspect.Type, path: str) -> Mistakes:
    """Whatever is not of its type."""
    match kind:
        case msgspec.inspect.UnionType():
            if _has_form(value, kind):
                yield from _mistakes(value, next(one for one in kind.types if _has_form(value, one)), path)
                return
        case msgspec.inspect.StructType() if isinstance(value, Mapping):
            for field in kind.fields:
                within = f"{path}.{field.encode_name}" if path else field.encode_name
                if field.encode_name in value:
                    yield from _mistakes(value[field.encode_name], field.type, within)
                elif field.required:
                    yield within, "is missing"
            return
        case msgspec.inspect.DictType() if isinstance(value, Mapping):
            for key, part in value.items():
                yield from _mistakes(part, kind.value_type, f"{path}.{key}")
            return
        case msgspec.inspect.ListType() if isinstance(value, list | tuple):
            for k, part in enumerate(value):
                yield from _mistakes(part, kind.item_type, f"{path}[{k}]")
            return
        case msgspec.inspect.EnumType() if isinstance(value, str):
            if value not in [member.value for member in kind.cls]:
                yield path, f"expected {_expected(kind)}, got {visible(repr(str(value)), LONGEST_TEXT)}"
            return
    if not _has_form(value, kind):
        yield path, f"expected {_expected(kind)}, got {_described(value)}"


FLOAT = msgspec.inspect.FloatType()


def _has_form(value: Any, kind: msgspec.inspect.Type) -> bool:
    """Whether a value is of the form of a type, whatever is within it."""
    match kind:
        case msgspec.inspect.AnyType():
            return True
        case msgspec.inspect.UnionType():
            return any(_has_form(value, one) for one in kind.types)
        case msgspec.inspect.NoneType():
            return value is None
        case msgspec.inspect.BoolType():
            return isinstance(value, bool)
        case msgspec.inspect.IntType():
            return _has_form(value, FLOAT) and (isinstance(value, int) or value.is_integer())
        case msgspec.inspect.FloatType():
            return isinstance(value, int | float) and not isinstance(value, bool)
        case msgspec.inspect.StrType() | msgspec.inspect.EnumType():
            return isinstance(value, str)
        case msgspec.inspect.ListType():
            return isinstance(value, list | tuple)
        case _:
            return isinstance(value, Mapping)


def _expected(kind: msgspec.inspect.Type) -> str:
    """What a type is, in words."""
    match kind:
        case msgspec.inspect.UnionType():
            # Null last, as the rest says what is meant.
            members = sorted(kind.types, key=lambda one: isinstance(one, msgspec.inspect.NoneType))
            return " or ".join(_expected(one) for one in members)
        case msgspec.inspect.EnumType():
            return f"one of {', '.join(str(member.value) for member in kind.cls)}"
        case _:
            return EXPECTED.get(type(kind), "a block of keys")


EXPECTED: Mapping[type, str] = {
    msgspec.inspect.NoneType: "null",
    msgspec.inspect.BoolType: "true or false",
    msgspec.inspect.IntType: "a whole number",
    msgspec.inspect.FloatType: "a number",
    msgspec.inspect.StrType: "a text",
    msgspec.inspect.ListType: "a list",
}
"""Types in words; all others are blocks of keys."""


def _described(value: object) -> str:
    """What a value of a file is, in words."""
    match value:
        case None:
            return "null"
        case bool():
            return str(value).lower()
        case int() | float():
            return f"the number {visible(repr(value), LONGEST_TEXT)}"
        case str():
            return "a text"
        case list() | tuple():
            return "a list"
        case _:
            return "a block of keys"


def _not_stated(keys: ScenarioKeys) -> Mistakes:
    """Inputs that are neither stated nor swept."""
    for varied in DRIVING:
        if attrgetter(varied.path)(keys) is None and (keys.sweep is None or keys.sweep.parameter is not varied):
            yield f"scenario.{varied.path}", "is missing"


def _incomplete(results: Results, evaluated: bool) -> Mistakes:
    """Arrays of motions that have not as many values as the others; voltages that are missing though evaluated."""
    blocks: list[tuple[str, BranchData | DesignData]] = [
        (f"branches[{k}]", branch) for k, branch in enumerate(results.branches)
    ]
    if results.design_point is not None:
        blocks.append(("design_point", results.design_point))
    for path, block in blocks:
        count = len(block.stability)
        if evaluated and not isinstance(block.u_ave_v, list):
            yield f"{path}.u_ave_v", "is missing"
        columns = {name: getattr(block, name) for name in block.columns}
        columns |= {f"error_bounds.{name}": column for name, column in block.error_bounds.items()}
        for name, column in columns.items():
            # Null, or missing, is a column that an earlier version, or a run without a ball mass, does not have.
            if isinstance(column, list) and column and len(column) != count:
                yield f"{path}.{name}", f"{len(column)} values, where stability has {count}"


def _require_finite(data: object, name: str) -> None:
    """Raise UsageError where a number is none, or is larger than any double: nothing can be compared with it."""
    waiting = [("", data)]  # a list, as a file may be nested deeper than Python calls
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, Mapping):
            waiting += [(f"{path}.{key}" if path else str(key), value[key]) for key in value]
        elif isinstance(value, list | tuple):
            waiting += [(f"{path}[{k}]", entry) for k, entry in enumerate(value)]
        elif isinstance(value, int | float) and not -float_info.max <= value <= float_info.max:
            text = visible(repr(value) if isinstance(value, float) else "an integer beyond all doubles")
            raise UsageError(f"{name}: {visible(path, LONGEST_TEXT)} is {text} (results have finite numbers only)")
