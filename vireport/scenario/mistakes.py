"""The wording of mistakes: what is wrong, with the value that was given, and what is allowed.

Imported only once there is a mistake. Ranges, units and keys come from the JSON Schema, which comes from the
definitions of the keys.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from vireport.errors import Mistake
from vireport.scenario import hints
from vireport.scenario.blocks import SWEEPABLE
from vireport.scenario.document import Document
from vireport.scenario.rules import Finding
from vireport.scenario.schema import keys

_LONGEST_VALUE = 60  # characters of a value that are shown
_LONGEST_LIST = 200  # characters of the names of keys that are shown


def word(findings: Iterable[Finding], document: Document) -> list[Mistake]:
    """Turn findings into mistakes with their lines; the first finding on a path stands for all.

    What is wrong below a path that could not be read is left out: it follows from that mistake.
    """
    worded: dict[str, Mistake] = {}
    for finding in findings:
        path = finding.path
        if path not in worded and not any(is_within(path, hidden) for hidden in document.unread):
            worded[path] = Mistake(_line(path, document), path, _message(finding, document))
    return list(worded.values())


def is_within(path: str, block: str) -> bool:
    """Whether a path is that of a block, or of something in it."""
    return path == block or path.startswith(f"{block}.") or not block


def _line(path: str, document: Document) -> int:
    """Line of a key, or of the innermost block that would hold it."""
    while path not in document.lines and path:
        path = path.rpartition(".")[0]
    return document.lines[path]


def _message(finding: Finding, document: Document) -> str:
    path, kind, value = finding.path, finding.kind, finding.value
    if kind == "rule":
        return str(value)
    if kind == "extra_forbidden":
        units = {name: str(key.get("unit", "")) for name, key in keys().items() if name}
        block = path.rpartition(".")[0] if path.rpartition(".")[0] in keys() else ""
        return f"unknown key{hints.for_key(path, value, units)} ({_allowed_keys(block)})"
    limits = allowed(_ruler(path, document))
    if kind == "missing":
        unless = " unless it is swept" if path in SWEEPABLE.values() else ""
        return f"required{unless}, but {'empty' if path in document.written else 'missing'} ({limits})"
    if value is None:
        return f"is empty ({limits})"
    return f"got {_shown(value, document.written.get(path))}{_wrong(path, value, document)} ({limits})"


def _ruler(path: str, document: Document) -> str:
    """Path of the key whose range holds: for values of what is swept, that of the parameter that is swept."""
    data: Any = document.data
    ruled = ("sweep.from", "sweep.to", "requirements.stable_from", "requirements.stable_to")
    if path not in ruled and not _is_element(path):
        return path
    sweep = data.get("sweep")
    parameter = sweep.get("parameter") if isinstance(sweep, dict) else None
    if sweep is None and "sweep" not in document.unread:
        parameter = "length_m"
    return SWEEPABLE.get(parameter, path) if isinstance(parameter, str) else path


def _is_element(path: str) -> bool:
    return path.rpartition(".")[2].isdigit()


def _key(path: str) -> dict[str, Any]:
    """What the JSON Schema says of a key, or of an element of a list."""
    if path in keys() or not _is_element(path):
        return keys()[path]
    elements: dict[str, Any] = keys()[path.rpartition(".")[0]]["items"]
    return elements


def _wrong(path: str, value: object, document: Document) -> str:
    """What is wrong with a value, as it follows "got ...": by its type first, then by its size."""
    key = _key(_ruler(path, document))
    kinds = _kinds(key)
    if "object" in kinds:
        return ""
    if "array" in kinds:
        return f" of {len(value)} values" if isinstance(value, list) else ", where a list belongs"
    if isinstance(value, dict | list):
        return ", where one value belongs"
    if "boolean" in kinds:
        return ", which is not true or false"
    if "enum" in key:
        return _wrong_choice(str(value).rpartition(".")[2], key["enum"])
    if isinstance(value, str):
        if "string" in kinds:
            return f", which has {len(value)} characters" if value else ", which is empty"
        quoted = document.written.get(path, "")[:1] in ("'", '"')
        return f", which is text{hints.for_number(value, quoted, key.get('unit', ''))}"
    if "string" in kinds:
        return ", which is not text; put it in quotes"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ", which is not a number"
    return _wrong_number(path, value, key)


def _wrong_choice(value: str, choices: list[str]) -> str:
    close = hints.closest(value, choices)
    if close:
        return f"; did you mean '{close}'?"
    return ", which cannot be swept" if any(path.rpartition(".")[2] == value for path in keys()) else ""


def _wrong_number(path: str, value: float, key: dict[str, Any]) -> str:
    if not math.isfinite(value):
        return ", which is not a finite number"
    if isinstance(value, float) and "integer" in _kinds(key):
        return f"; write {value:.0f}" if value == int(value) else ", which is not a whole number"
    if path == "schema_version":
        return ", a version that is not known here"
    if value <= 0 < key.get("minimum", key.get("exclusiveMinimum", 0)):
        return ", which is not positive"
    too_small = value < key.get("minimum", -math.inf) or value <= key.get("exclusiveMinimum", -math.inf)
    return ", which is too small" if too_small else ", which is too large"


def allowed(path: str) -> str:
    """What a key may be: its type, range and unit, in words."""
    key = _key(path)
    kinds = _kinds(key)
    if "object" in kinds:
        return f"a block of keys: {', '.join(key['properties'])}"
    if "enum" in key:
        return f"one of {', '.join(key['enum'])}"
    if "array" in kinds:
        return f"a list of at most {key['maxItems']} numbers, in the unit of the swept parameter"
    if "boolean" in kinds:
        return "true or false"
    if "string" in kinds:
        return f"text on one line, 1 to {key['maxLength']} characters"
    if key.get("minimum") is not None and key["minimum"] == key.get("maximum"):
        return f"always {key['minimum']}"
    noun = "a whole number" if "integer" in kinds else "a number"
    unit = f", in {key['unit']}" if key.get("unit", "1") != "1" else ""
    if "exclusiveMinimum" in key:
        return f"{noun} above {_short(key['exclusiveMinimum'])}, at most {_short(key['maximum'])}{unit}"
    if "minimum" in key:
        return f"{noun} from {_short(key['minimum'])} to {_short(key['maximum'])}{unit}"
    return f"{noun}{unit}"


def _allowed_keys(block: str) -> str:
    names = ", ".join(keys()[block]["properties"])
    if len(names) > _LONGEST_LIST:
        names = f"{names[:_LONGEST_LIST].rpartition(', ')[0]}, ..."
    return f"allowed{f' in {block}' if block else ''}: {names}"


def _kinds(key: dict[str, Any]) -> set[str]:
    kind = key.get("type", "object")
    return set(kind) if isinstance(kind, list) else {kind}


def _short(number: float) -> str:
    return f"{number:g}".replace("e+", "e")


def _shown(value: object, written: str | None) -> str:
    """Render a value as it was written, on one line and not too long."""
    if isinstance(value, dict):
        return "a block of keys"
    if isinstance(value, list):
        return "a list"
    text = str(value) if written is None else written
    if len(text) > _LONGEST_VALUE:
        text = f"{text[: _LONGEST_VALUE - 3]}..."
    if not text.isprintable():
        return repr(text)
    return f"'{text}'" if isinstance(value, str) and text[:1] not in ("'", '"') else text
