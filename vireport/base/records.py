"""Records: frozen `msgspec.Struct`s, and their plain data.

Why not `dataclasses`: a run imports some hundred records, and a frozen dataclass compiles six functions of its own in
0.5 ms, a Struct none in 0.03 ms: 50 of the 800 ms that `vireport scenario.yaml --json` takes, and 30 ms in instances.
"""

from __future__ import annotations

from enum import Enum
from typing import Any

from msgspec import UNSET, Struct

LONGEST_TEXT = 40
"""Characters of a text within a record that its one line shows."""


SCALARS = frozenset({float, int, str, bool, type(None)})
"""Types of values that hold no records: lists of results have thousands of them."""


def keyed(record: Struct) -> dict[str, Any]:
    """The values of a record by their names in files; a key that is unset is absent."""
    values = zip(record.__struct_encode_fields__, record.__struct_fields__, strict=True)
    return {key: value for key, name in values if (value := getattr(record, name)) is not UNSET}


def plain(value: object) -> Any:
    """Return the data of a record, with all records in it, as dicts and lists; what is no record stays as it is.

    Numbers of NumPy pass as they are, which is why `msgspec.to_builtins` is not used.
    """
    if isinstance(value, Struct):
        return {key: plain(part) for key, part in keyed(value).items()}
    if isinstance(value, tuple | list):
        return [part if type(part) in SCALARS else plain(part) for part in value]
    if isinstance(value, dict):
        return {key: plain(part) for key, part in value.items()}
    return value


def brief(record: Struct) -> str:
    """A record as one line for a console: what is None or empty is left out, arrays are told by their shape.

    It is the `__repr__` of records that hold arrays or other records, of which Struct's own would fill the screen.
    """
    values = {name: getattr(record, name) for name in record.__struct_fields__}
    fields = (f"{name}={_value_text(value)}" for name, value in values.items() if not _is_nothing(value))
    return f"{type(record).__name__}({', '.join(fields)})"


def _is_nothing(value: object) -> bool:
    return value is None or (isinstance(value, str | tuple | list | dict) and not value)


def _value_text(value: object) -> str:
    """A value within the line of a record; of a record within it the name alone."""
    if isinstance(value, Struct):
        return f"{type(value).__name__}(...)"
    if hasattr(value, "dtype") and hasattr(value, "shape") and value.shape:
        return f"{value.dtype}[{', '.join(map(str, value.shape))}]"
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, str):
        return repr(value if len(value) <= LONGEST_TEXT else f"{value[:LONGEST_TEXT]}...")
    if isinstance(value, tuple | list | dict):
        return f"{type(value).__name__}[{len(value)}]"
    if isinstance(value, float):
        return f"{value:.6g}"
    return repr(value)


class ResultsBlock(Struct, frozen=True, kw_only=True, eq=False, rename={"from_": "from", "yield_": "yield"}):
    """A block of keys of results.json, or of another file of results."""

    __repr__ = brief
