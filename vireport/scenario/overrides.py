"""Overrides: values set on the command line or by a script, ``path=value``, which replace those of a document.

The value is read by the same rules as the file's, so ``--set`` can neither do more nor less than the file.
Whether the result makes sense is decided by the same validation.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from copy import deepcopy
from typing import Any

from msgspec.structs import replace

from vireport.base.errors import Mistake, ScenarioError, UsageError
from vireport.scenario.document import DEEPEST, Document, read


def as_texts(overrides: str | Sequence[str] | Mapping[str, object]) -> tuple[str, ...]:
    """Overrides as texts ``path=value``; the plain values of a mapping are written as JSON, which is YAML.

    Examples
    --------
    >>> as_texts({"device.length_m": 0.7, "title": "Long one"})
    ('device.length_m=0.7', 'title="Long one"')
    """
    if isinstance(overrides, str):
        return (overrides,)
    if isinstance(overrides, Mapping):
        return tuple(f"{path}={yaml_of(value)}" for path, value in overrides.items())
    return tuple(overrides)


def yaml_of(value: object, indent: int | None = None) -> str:
    """A value of a scenario, or a mapping of its keys, as JSON, which is YAML; NumPy's numbers and arrays are allowed.

    Raises
    ------
    UsageError
        If it holds a value that a scenario cannot have.
    """
    try:
        return json.dumps(value, ensure_ascii=False, indent=indent, default=_of_numpy)
    except (TypeError, ValueError, RecursionError) as error:
        raise UsageError(f"{error} (allowed in a scenario: texts, numbers, true or false, lists, and dicts)") from error


def _of_numpy(value: object) -> object:
    # By its method, so that checking a file does not import NumPy.
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"a scenario cannot hold a value of type {type(value).__name__}")


def apply(document: Document, overrides: Iterable[str]) -> Document:
    """Return the document with each override put in its place; a later one wins.

    What an override sets stands on line 0. One that cannot be read or placed is added to the document's
    mistakes.
    """
    data: Any = deepcopy(document.data)
    lines, written = dict(document.lines), dict(document.written)
    mistakes, unread = list(document.mistakes), set(document.unread)
    for override in overrides:
        path, sign, text = override.partition("=")
        path = path.strip()
        steps = path.split(".")
        if not sign or not all(steps) or len(steps) > DEEPEST:
            mistakes.append(Mistake(0, override, "not of the form path=value (such as device.length_m=0.7)"))
            continue
        try:
            value = read(text, document.name, path)
        except ScenarioError as error:
            mistakes += [Mistake(0, mistake.path, mistake.message) for mistake in error.mistakes]
            unread.add(path)
            continue
        obstacle = _place(data, steps, value.data, lines)
        if obstacle is not None:
            message = f"'{obstacle}' is not a block of keys (nothing can be set in it; set {obstacle} as a whole)"
            mistakes.append(Mistake(0, path, message))
            continue
        for places in (lines, written) if path in lines else ():  # a block that holds any stands in the lines
            for old in [old for old in places if old == path or old.startswith(f"{path}.")]:
                del places[old]
        lines |= dict.fromkeys(value.lines, 0)
        written |= value.written
        mistakes += [Mistake(0, mistake.path, mistake.message) for mistake in value.mistakes]
        unread |= value.unread
    return replace(
        document,
        data=data,
        lines=lines,
        written=written,
        mistakes=tuple(mistakes),
        unread=frozenset(unread),
    )


def _place(data: dict[str, Any], steps: list[str], value: object, lines: dict[str, int]) -> str | None:
    """Set a value in the tree, making the blocks it needs; return the path of an obstacle, None if there is none."""
    for count, step in enumerate(steps[:-1], 1):
        place = ".".join(steps[:count])
        if data.get(step) is None:
            data[step] = {}
            lines[place] = 0
        if not isinstance(data[step], dict):
            return place
        data = data[step]
    data[steps[-1]] = value
    return None
