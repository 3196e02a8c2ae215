"""The wording of mistakes: the fault, the value that was given, and what is allowed.

Ranges, units and keys come from the JSON Schema, which comes from the declarations of the keys.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from vireport.base.errors import MOST_MISTAKES, Mistake
from vireport.scenario import hints
from vireport.scenario.blocks import UNIT_OF_SWEPT, DesignPath, Scenario, is_printable
from vireport.scenario.document import Document, is_within_any
from vireport.scenario.json_schema import keys
from vireport.scenario.parameters import DRIVING
from vireport.scenario.rules import (
    AXES,
    VARIED,
    Finding,
    Kind,
    path_of,
    rows_of,
    swept,
)
from vireport.text.foreign import visible

_LONGEST_VALUE = 60  # characters of a value that are shown
_LONGEST_LIST = 200  # characters of the names of keys that are shown

Schema = dict[str, Any]


def worded(findings: Iterable[Finding], document: Document, model: type[Scenario]) -> tuple[list[Mistake], int]:
    """Turn findings into mistakes with their lines, the first ones of the file, and count the others.

    The first finding on a path stands for all. Findings below a path that could not be read are left out, as they
    follow from that mistake, and so are missing keys for which an unknown one stands.
    """
    wording, first = _Wording(document, keys(model)), dict[str, Finding]()
    for finding in findings:
        if not is_within_any(finding.path, document.unread):
            first.setdefault(finding.path, finding)
    misspelt = wording.misspelt(first.values())
    relevant = [item for item in first.values() if item.kind is not Kind.MISSING or item.path not in misspelt]
    lines = {item.path: document.line_of(item.path) for item in relevant}
    reported = sorted(relevant, key=lambda item: lines[item.path])[:MOST_MISTAKES]
    mistakes = [Mistake(lines[item.path], item.path, wording.message(item)) for item in reported]
    return mistakes, len(relevant) - len(reported)


def misspelt(findings: Iterable[Finding], document: Document, model: type[Scenario]) -> set[str]:
    """Paths of the keys that unknown ones probably stand for: that these are missing follows from that mistake."""
    if not any(finding.kind is Kind.UNKNOWN for finding in findings):
        return set()
    return _Wording(document, keys(model)).misspelt(findings)


class _Wording:
    """The wording for one document, by the keys that it may have."""

    def __init__(self, document: Document, keys: dict[str, Schema]) -> None:
        self.document, self.keys = document, keys
        self.units = {name: str(node.get("unit", "")) for name, node in keys.items() if name and name[-1] != "*"}

    def message(self, finding: Finding) -> str:
        path, value = finding.path, finding.value
        if finding.kind is Kind.RULE:
            return str(value)
        if finding.kind is Kind.UNKNOWN:
            return self.unknown(path, value)
        key, ruling = self.keys[_pattern(path)], self.ruling(path)
        if key.get("type") == "null":
            return str(key["description"])
        limits = allowed(ruling)
        if finding.kind is Kind.MISSING:
            unless = " unless it is swept" if path in {parameter.path for parameter in DRIVING} else ""
            gone = "empty" if path in self.document.written else "missing"
            return f"required{unless}, but {gone} ({limits})"
        if value is None:
            return f"is empty ({limits})"
        written = self.document.written.get(path)
        return f"got {_as_written(value, written)}{_wrong(path, value, written or '', ruling)} ({limits})"

    def unknown(self, path: str, value: object) -> str:
        block, key = self.place(path)
        nodes = self.keys[_pattern(block)]["properties"]
        names = _names(name for name, node in nodes.items() if node.get("type") != "null")
        meant = hints.for_key(_pattern(block), key, value, self.units)
        return f"unknown key{meant} (allowed{f' in {block}' if block else ''}: {names})"

    def meant(self, path: str, value: object) -> str:
        """Path of the key that an unknown one probably stands for; "" where there is no telling."""
        block, key = self.place(path)
        target, _ = hints.key_meant(_pattern(block), key, value, self.units)
        return target

    def misspelt(self, findings: Iterable[Finding]) -> set[str]:
        """Paths of the keys that the first unknown ones probably stand for."""
        unknown = [finding for finding in findings if finding.kind is Kind.UNKNOWN][:MOST_MISTAKES]
        return {self.meant(finding.path, finding.value) for finding in unknown} - {""}

    def place(self, path: str) -> tuple[str, str]:
        """The path of the block that an unknown key stands in, and the key."""
        block = path
        while block and (block == path or _pattern(block) not in self.keys):
            block = block.rpartition(".")[0]
        return block, path.removeprefix(f"{block}.") if block else path

    def ruling(self, path: str) -> Schema:
        """Schema that a value must meet: of its key, or of the parameter that it is a value of."""
        key = self.keys[_pattern(path)]
        if key.get("unit") == UNIT_OF_SWEPT and "array" not in _kinds(key):
            parameter = swept(self.document)
            if parameter is None:
                return key
            # A device may have a restitution of 1, which no sweep comes to.
            least, most = parameter.limits
            schema = self.keys[parameter.path]
            return schema | {"minimum": least, "maximum": most} if parameter.bounces else schema
        steps = path.split(".")
        place = tuple(steps[:2])
        if place in (AXES, VARIED) and steps[3:4] in (["from"], ["to"], ["values"]) and "array" not in _kinds(key):
            varied = path_of(rows_of(self.document.data, steps[0], steps[1])[int(steps[2])], DesignPath)
            return key if varied is None else self.keys[varied.value]
        return key


def _pattern(path: str) -> str:
    """Path with a star for the number of each element of a list."""
    return ".".join("*" if step.isdigit() else step for step in path.split("."))


def _wrong(path: str, value: object, written: str, key: Schema) -> str:
    """The fault of a value in words, as it follows "got ...": by its type first, then by its size."""
    kinds = _kinds(key)
    if "object" in kinds:
        return ""
    if "array" in kinds:
        plural = "s" * (isinstance(value, list) and len(value) != 1)
        return f" of {len(value)} value{plural}" if isinstance(value, list) else ", where a list belongs"
    if isinstance(value, dict | list):
        return ", where one value belongs"
    if "boolean" in kinds:
        return ", which is not true or false"
    if "enum" in key:
        return _wrong_choice(path, str(value), _choices(key))
    if isinstance(value, str):
        if "pattern" in key:
            return (
                ", which is no word of at most {maxLength} letters B and T".format(**key) if "maxLength" in key else ""
            )
        if "string" in kinds and len(value) <= key["maxLength"] and not is_printable(value):
            return ", which has characters that cannot be printed" if value.strip() else ", which is empty"
        if "string" in kinds:
            return f", which has {len(value)} characters"
        quoted = written[:1] in ("'", '"')
        return f", which is text{hints.for_number(value, quoted, key.get('unit', ''))}"
    if "integer" in kinds and "string" in kinds:
        return ", which is no column"
    if "string" in kinds:
        return ", which is not text; put it in quotes"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ", which is not a number"
    return _wrong_number(path, value, key)


def _choice_text(choice: str) -> str:
    """A word that a key may be; a single mark in quotes, as it would be lost between the commas of a list."""
    return choice if len(choice) > 1 or choice.isalnum() else repr(choice)


def _choices(key: Schema) -> list[str]:
    """The words that a key may be, without the null of a key that may be left out."""
    return [str(word) for word in key["enum"] if word is not None]


def _wrong_choice(path: str, value: str, choices: list[str]) -> str:
    last = {choice.rpartition(".")[2]: choice for choice in choices}
    close = hints.closest(value.rpartition(".")[2], last)
    if close:
        return f"; did you mean '{last[close]}'?"
    inputs = {name for name in keys(Scenario) if name.rpartition(".")[2] == value.rpartition(".")[2]}
    if not inputs:
        return ""
    if not path.startswith("sweep"):
        return ", which cannot be varied"
    return ", which cannot be swept"


def _wrong_number(path: str, value: float, key: Schema) -> str:
    if not math.isfinite(value):
        return ", which is not a finite number"
    if isinstance(value, float) and "integer" in _kinds(key):
        return f"; write {value:.0f}" if value == int(value) else ", which is not a whole number"
    if path == "schema_version":
        return ", a version that is not known to this program"
    low, above = key.get("minimum", -math.inf), key.get("exclusiveMinimum", -math.inf)
    if value <= 0 < max(low, above):
        return ", which is not positive"
    if value < low or value <= above:
        return ", which is too small"
    if key.get("maximum") == 1 and 2 <= value <= 100 and key.get("unit") == "1":
        return f", which is too large; if it is {value:g} %, write {value / 100:.2f}"
    return f", which is too large: {key['beyond']}" if "beyond" in key else ", which is too large"


def _names(keys: Iterable[str]) -> str:
    names = ", ".join(keys)
    return names if len(names) <= _LONGEST_LIST else f"{names[:_LONGEST_LIST].rpartition(', ')[0]}, ..."


def allowed(key: Schema) -> str:
    """The type, range and unit that a key may have by its JSON Schema, in words."""
    kinds = _kinds(key)
    unit = f", in {key['unit']}" if key.get("unit", "1") != "1" else ""
    if "object" in kinds:
        return f"a block of keys: {_names(key['properties'])}"
    if "enum" in key:
        return f"one of {', '.join(map(_choice_text, _choices(key)))}"
    if "array" in kinds and "$ref" in key["items"]:
        least = f"{key['minItems']} to" if "minItems" in key else "at most"
        return f"a list of {least} {key['maxItems']} blocks of keys"
    if "array" in kinds:
        least, most = key.get("minItems", 0), key["maxItems"]
        what = f"numbers{unit}"
        if "pattern" in key["items"]:
            what = f"names: {key['items']['description']}" if "description" in key["items"] else "words"
        return f"a list of {f'{least} to' if least else 'at most'} {most} {what}"
    if "boolean" in kinds:
        return "true or false"
    if "pattern" in key and "maxLength" not in key:
        return str(key["description"])
    if "pattern" in key:
        return f"1 to {key['maxLength']} impacts in order, B on the bottom and T on the top"
    if "string" in kinds:
        number = ", or a whole number from 1" if "integer" in kinds else ""
        return f"printable text on one line, 1 to {key['maxLength']} characters{number}"
    if key.get("minimum") is not None and key["minimum"] == key.get("maximum"):
        return f"always {key['minimum']}"
    noun = "a whole number" if "integer" in kinds else "a number"
    if "exclusiveMinimum" in key:
        return f"{noun} above {_short(key['exclusiveMinimum'])}, at most {_short(key['maximum'])}{unit}"
    if "minimum" in key:
        return f"{noun} from {_short(key['minimum'])} to {_short(key['maximum'])}{unit}"
    return f"{noun}{unit}"


def _kinds(key: Schema) -> list[str]:
    kind = key.get("type", "object")
    return kind if isinstance(kind, list) else [kind]


def _short(number: float) -> str:
    return str(number) if isinstance(number, int) else f"{number:g}".replace("e+", "e")


def _as_written(value: object, written: str | None) -> str:
    """Render a value as it was written, on one line and not too long."""
    if isinstance(value, dict):
        return "a block of keys"
    if isinstance(value, list):
        return "a list"
    text = visible(str(value) if written is None else written, _LONGEST_VALUE)
    return f"'{text}'" if isinstance(value, str) and text[:1] not in ("'", '"') else text
