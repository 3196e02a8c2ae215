"""Reads a scenario, a YAML file and what the command line sets, into validated, frozen values in SI units.

A scenario that cannot be used is explained with every mistake in it at once, each by line and key. Nothing
here knows what is computed from it.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, is_dataclass
from pathlib import Path
from typing import Any

from pydantic_core import ValidationError

from vireport.errors import Mistake, ScenarioError, UsageError
from vireport.scenario import overrides as overriding
from vireport.scenario.blocks import (
    SWEEPABLE,
    Device,
    Excitation,
    Membrane,
    Scenario,
    Sweep,
    SweepParameter,
    validated,
)
from vireport.scenario.document import LARGEST_FILE, Document, join, read
from vireport.scenario.keys import entries
from vireport.scenario.rules import Finding, check

MOST_NAMES = 1_000  # files of a folder that are compared with the name of a missing one

__all__ = [
    "SWEEPABLE",
    "Device",
    "Excitation",
    "Loaded",
    "Membrane",
    "Scenario",
    "Sweep",
    "SweepParameter",
    "load",
    "loads",
    "to_dict",
]


@dataclass(frozen=True, slots=True)
class Loaded:
    """A scenario with where it came from.

    Attributes
    ----------
    scenario : Scenario
        The scenario as understood, defaults filled in.
    document : Document
        The file as it was read, before anything was set over it.
    given : frozenset of str
        Dotted paths of all keys and blocks that the file or an override gives; what is not in here is a
        default.
    overrides : tuple of str
        What was set over the file, as ``path=value``, in the order of setting.
    """

    scenario: Scenario
    document: Document
    given: frozenset[str]
    overrides: tuple[str, ...] = ()

    def line_of(self, path: str) -> int | None:
        """Line of a key of the file, None where the key was set over it."""
        over = [text.partition("=")[0].strip() for text in self.overrides]
        if any(path == one or path.startswith(f"{one}.") for one in over):
            return None
        return self.document.lines.get(path)

    @property
    def sha256(self) -> str:
        """SHA-256 of the file, and of a zero byte and the override for each override.

        Without overrides it is what ``sha256sum`` prints for the file.
        """
        from hashlib import sha256  # some milliseconds, which loading does without

        parts = [self.document.text, *self.overrides]
        return sha256("\0".join(parts).encode("utf-8", "surrogatepass")).hexdigest()


def load(source: str | Path, overrides: str | Sequence[str] | Mapping[str, object] = ()) -> Loaded:
    """Read a scenario from a file, or from standard input where `source` is "-".

    Parameters
    ----------
    source : str or Path
        The file.
    overrides : sequence of str, or mapping of str to object
        Values set over those of the file: ``"device.length_m=0.7"``, or ``{"device.length_m": 0.7}``. A later
        one wins; an empty value takes an optional key away.

    Raises
    ------
    UsageError
        Where there is no such file, or it cannot be opened.
    ScenarioError
        Where the scenario cannot be used.
    """
    if str(source) == "-":
        return loads(sys.stdin.buffer.read(LARGEST_FILE + 1), "<stdin>", overrides)
    try:
        with open(source, "rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise UsageError(_unreadable(Path(source), error)) from error
    return loads(data, str(source), overrides)


def loads(
    text: str | bytes, name: str = "<text>", overrides: str | Sequence[str] | Mapping[str, object] = ()
) -> Loaded:
    """Read a scenario from text or UTF-8 bytes; `name` stands for the file in messages (see `load`)."""
    document = read(text, name)
    if not isinstance(document.data, dict):
        raise ScenarioError(name, document.mistakes or [_no_block(document)])
    texts = overriding.as_texts(overrides)
    effective = overriding.apply(document, texts) if texts else document
    scenario = validate_document(effective)
    return Loaded(scenario, document, frozenset(_given(effective.data)), texts)


def to_dict(scenario: Scenario) -> dict[str, Any]:
    """Return the scenario as plain data, defaults filled in, by the names and in the order of the file.

    What is optional and absent is None. Loading the result gives an equal scenario.
    """
    return _plain(scenario)


def _plain(block: Any) -> dict[str, Any]:
    values = {entry.name: getattr(block, entry.attribute) for entry in entries(type(block))}
    return {name: _as_read(value) for name, value in values.items()}


def _as_read(value: Any) -> Any:
    return _plain(value) if is_dataclass(value) else list(value) if isinstance(value, tuple) else value


def validate_document(document: Document) -> Scenario:
    """Make a scenario of a document as it was read.

    Raises
    ------
    ScenarioError
        With every mistake in it.
    """
    data: Any = document.data
    scenario, findings = None, []
    try:
        scenario = validated(_with_membrane(data))
    except ValidationError as error:
        for found in error.errors(include_url=False, include_context=False):
            path = ""
            for step in found["loc"]:
                path = join(path, step)
            findings.append(Finding(path, found["type"], found["input"]))
    bare = {path for path, text in document.written.items() if not text and document.lines[path]}
    findings += check(data, {finding.path for finding in findings} | document.unread, bare)
    if scenario is not None and not findings and not document.mistakes:
        return scenario
    from vireport.scenario.mistakes import word

    raise ScenarioError(document.name, [*document.mistakes, *word(findings, document)])


def _with_membrane(data: dict[str, Any]) -> dict[str, Any]:
    """Fill in the default membrane where energy is evaluated: where the ball's mass is given."""
    device = data.get("device")
    if isinstance(device, dict) and device.get("ball_mass_kg") is not None and device.get("membrane") is None:
        return data | {"device": device | {"membrane": {}}}
    return data


def _given(node: Any, path: str = "") -> list[str]:
    found = []
    for key, value in node.items():
        here = join(path, key)
        if value is not None:
            found.append(here)
        if isinstance(value, dict):
            found += _given(value, here)
    return found


def _no_block(document: Document) -> Mistake:
    what = "the file is empty" if document.data is None else "the file is not a block of keys"
    message = f"{what} (a scenario starts with 'schema_version: 1'; 'vireport init' writes a complete one)"
    return Mistake(document.lines[""], "", message)


def _unreadable(path: Path, error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        from itertools import islice

        from vireport.scenario.hints import closest

        try:
            close = closest(path.name, [entry.name for entry in islice(path.parent.iterdir(), MOST_NAMES)])
        except OSError:
            return f"{path}: no such folder as {path.parent}"
        return f"{path}: no such file" + (f"; did you mean '{path.parent / close}'?" if close else "")
    if isinstance(error, IsADirectoryError):
        return f"{path}: is a folder, not a scenario file"
    if isinstance(error, PermissionError):
        return f"{path}: may not be read (permission denied)"
    return f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})"
