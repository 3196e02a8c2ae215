"""What changed since a baseline: results.json of an earlier run against a scenario as it is now, for pull requests.

Numbers count as the same within a relative tolerance and what their error bounds leave open. A critical point that
has another number, because there is one more before it, is the same point.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from vireport.comparison.changes import Change, changes, shown, shown_apart
from vireport.errors import UsageError
from vireport.study import SCHEMA_VERSION, Study
from vireport.text import (
    ABSENT,
    percent,
)

__all__ = ["Change", "check_baseline", "diff", "diff_json", "diff_markdown", "diff_text", "read_baseline"]

RELATIVE = 1e-6
"""Relative difference up to which a number is the same: far above rounding, far below what a device is made to."""

LARGEST = 1 << 30
"""Bytes of a baseline beyond which it is no results.json."""

NEEDED = ("schema_version", "scenario", "branches", "critical_points", "stable_range", "design_point", "alerts")


def read_baseline(path: str | Path) -> dict[str, Any]:
    """Read results.json of an earlier run.

    Raises
    ------
    UsageError
        Where the file is not there, or is none.
    """
    try:
        with open(path, "rb") as file:
            data = file.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise UsageError(f"{path}: too large for a results.json")
        baseline = json.loads(data)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{path}: is no JSON ({error}); a baseline is the results.json of an earlier run") from error
    check_baseline(baseline, str(path))
    return dict(baseline)


def check_baseline(baseline: Any, name: str = "baseline") -> None:
    """Raise UsageError, saying what is missing, unless this is results.json of a version that is understood."""
    if not isinstance(baseline, Mapping):
        raise UsageError(f"{name}: is no results.json (a block of keys)")
    if missing := [key for key in NEEDED if key not in baseline]:
        raise UsageError(f"{name}: is no results.json of vireport: {', '.join(missing)} missing")
    version = baseline["schema_version"]
    if version != SCHEMA_VERSION:
        raise UsageError(f"{name}: schema_version {version!r} is not understood (allowed: {SCHEMA_VERSION})")


def diff(baseline: Mapping[str, Any], study: Study, relative: float = RELATIVE) -> tuple[Change, ...]:
    """What changed beyond tolerance since a baseline.

    Parameters
    ----------
    baseline : mapping
        results.json of an earlier run, as data.
    study : Study
        Of the scenario as it is now.
    relative : float
        Relative difference up to which two numbers are the same; error bounds are added to it.

    Raises
    ------
    UsageError
        Where the baseline is no results.json, or lacks something that is compared.
    """
    check_baseline(baseline)
    now = study.to_dict()
    try:
        return tuple(changes(baseline, now, relative))
    except (KeyError, TypeError, AttributeError, IndexError, ValueError) as error:
        what = f"{error.args[0]!r} is missing" if isinstance(error, KeyError) else str(error)
        raise UsageError(f"baseline: is no results.json of vireport: {what}") from error


def diff_text(found: Sequence[Change], baseline: str = "the baseline") -> str:
    """The changes in lines of plain text, grouped; without a newline at the end."""
    if not found:
        return f"No change beyond tolerance since {baseline}."
    lines = [f"{len(found)} change{'s' * (len(found) != 1)} since {baseline}:"]
    lines += [f"  {change.group}: {change.sentence}" for change in found]
    return "\n".join(lines)


def diff_markdown(found: Sequence[Change], baseline: str = "the baseline") -> str:
    """The changes as a Markdown table, for a comment on a pull request."""
    if not found:
        return f"No change beyond tolerance since {_cell(baseline)}.\n"
    lines = [
        f"**{len(found)} change{'s' * (len(found) != 1)} since {_cell(baseline)}**",
        "",
        "| | what | before | now | change |",
        "|---|---|---:|---:|---:|",
    ]
    for change in found:
        before, after = shown(change.before, change.unit), shown(change.after, change.unit)
        if change.before is not None and change.after is not None:
            before, after = shown_apart(change.before, change.after, change.unit)
        size = percent(change.change, signed=True) if change.change is not None else ABSENT
        lines.append(f"| {' | '.join(map(_cell, (change.group, change.what, before, after, size)))} |")
    return "\n".join(lines) + "\n"


def diff_json(found: Sequence[Change], relative: float = RELATIVE) -> bytes:
    """The changes as JSON."""
    data = {"changed": bool(found), "tolerance": relative, "changes": [asdict(change) for change in found]}
    return (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()


def _cell(text: str) -> str:
    """A text that is no markup of Markdown."""
    for mark in "\\`*_|<>[]":
        text = text.replace(mark, f"\\{mark}")
    return " ".join(text.split())
