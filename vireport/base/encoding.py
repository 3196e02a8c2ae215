"""JSON of whatever the program has found out: the one place where results become JSON.

JSON has no infinity and no NaN: what is not finite is null. Records and NumPy's numbers and arrays are written as the
plain data that they hold.
"""

from __future__ import annotations

import json
from enum import Enum
from math import isfinite

import msgspec
from msgspec import Struct

from vireport.base.records import keyed


def json_text(value: object, indent: int | None = None, ascii_only: bool = True) -> str:
    """Write data as JSON; floats read back exactly, and those that are not finite are null.

    Parameters
    ----------
    value : object
        Dicts, lists, texts, numbers, records, and numbers and arrays of NumPy.
    indent : int, optional
        Spaces for each level; everything on one line by default.
    ascii_only : bool
        Whether letters beyond ASCII are escaped.

    Examples
    --------
    >>> json_text({"bound": float("inf"), "value": 0.5})
    '{"bound": null, "value": 0.5}'
    """

    def written(data: object) -> str:
        return json.dumps(data, allow_nan=False, default=_held, ensure_ascii=ascii_only, indent=indent)

    try:
        return written(value)
    except ValueError:  # a number is not finite: a second pass, which nearly all results do without
        return written(_finite(value))


def json_answer(value: object) -> bytes:
    """Write data as `json_text` does, as UTF-8 without spaces, in a tenth of the time: a hand waits for it."""
    return msgspec.json.encode(value, enc_hook=_held)


def _held(value: object) -> object:
    """Plain data of what JSON does not know: a record, an enumeration's member, a number or array of NumPy."""
    if isinstance(value, Struct):
        return keyed(value)
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, str):  # a name that carries more than its letters
        return str(value)
    # Asked of the value, as the check of a file takes no NumPy.
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"JSON cannot hold a value of type {type(value).__name__}")


def _finite(value: object) -> object:
    """The same data with None for each number that is not finite."""
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(part) for part in value]
    if value is None or isinstance(value, str | int):
        return value
    return _finite(_held(value))
