"""Records: frozen `msgspec.Struct`s, and their plain data.

Why not `dataclasses`: a run imports some hundred records, and a frozen dataclass compiles six functions of its own in
0.5 ms, a Struct none in 0.03 ms: 50 of the 800 ms that `vireport scenario.yaml --json` takes, and 30 ms in instances.
"""

from __future__ import annotations

from typing import Any

from msgspec import Struct


def plain(value: Any) -> Any:
    """Return the data of a record, with all records in it, as dicts and lists; what is no record stays as it is.

    Numbers of NumPy pass as they are, which is why `msgspec.to_builtins` is not used.
    """
    if isinstance(value, Struct):
        return {name: plain(getattr(value, name)) for name in value.__struct_fields__}
    if isinstance(value, tuple | list):
        return [plain(part) for part in value]
    if isinstance(value, dict):
        return {key: plain(part) for key, part in value.items()}
    return value
