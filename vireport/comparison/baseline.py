"""What changed since a baseline: results.json of an earlier run against a scenario as it is now, for pull requests.

Numbers count as the same within a relative tolerance and what their error bounds leave open. A critical point that
has another label, because there is one more before it, is the same point.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import inf
from pathlib import Path
from sys import float_info
from typing import Any

import numpy as np

from vireport.base import UsageError
from vireport.comparison.differences import differences, digits_apart, printed
from vireport.comparison.quantities import (
    Axes,
    Group,
    axes_of,
    quantities_of,
    same_setting,
    settings_of,
)
from vireport.motions import Stability
from vireport.study import SCHEMA_VERSION, Study
from vireport.text import (
    ABSENT,
    Table,
    exact,
    markdown_of,
    numbers,
    percent,
    texts,
    visible,
)

RELATIVE = 1e-6
"""Relative difference up to which a number is the same: far above rounding, far below what a device is made to."""

LARGEST = 1 << 30
"""Bytes of a baseline beyond which it is no results.json."""

LONGEST = 200
"""Characters of a text of a baseline that are shown."""

OF_ONE_RUN = ("provenance", "overrides", "left_out", "machine", "seconds")
"""Keys that are not compared value by value: where results come from, what formats leave out, and measured times."""

FEW = 5
"""Values that are named one by one."""

NEEDED = ("schema_version", "scenario", "branches", "critical_points", "stable_range", "design_point", "alerts")


@dataclass(frozen=True, slots=True)
class Change:
    """One thing that is not as it was.

    Attributes
    ----------
    group : Group
    what : str
        Which quantity.
    before, after : float, str or None
        None where there was or is none.
    unit : str
        Of the numbers, or "".
    change : float or None
        Relative to the value before, where both are numbers and that is not zero.
    """

    group: Group
    what: str
    before: float | str | None
    after: float | str | None
    unit: str = ""
    change: float | None = None

    @property
    def sides(self) -> tuple[str, str]:
        """Both sides as text, numbers with so many digits that they differ."""
        sides = (self.before, self.after)
        numbers = [value for value in sides if isinstance(value, float)]
        digits = digits_apart(numbers, self.unit or "1")
        before, after = (
            printed(value, self.unit or "1", digits) if isinstance(value, float) else value or "none" for value in sides
        )
        return before, after

    @property
    def sentence(self) -> str:
        """The change in words."""
        before, after = self.sides
        if self.before is None:
            return f"{self.what}: new, {after}."
        if self.after is None:
            return f"{self.what}: gone, was {before}."
        size = f" ({percent(self.change, signed=True)})" if self.change is not None else ""
        return f"{self.what}: {before} to {after}{size}."


def read_baseline(path: str | Path) -> dict[str, Any]:
    """Read results.json of an earlier run from a file, or from standard input where the path is "-".

    It is compared with itself, so that what it lacks is found before a scenario is solved.

    Raises
    ------
    UsageError
        Where the file is not there, or is none.
    """
    name = "standard input" if str(path) == "-" else str(path)
    try:
        if str(path) == "-":
            data = sys.stdin.buffer.read(LARGEST + 1)
        else:
            with open(path, "rb") as file:
                data = file.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise UsageError(f"{name}: too large for a results.json")
        baseline = json.loads(data)
    except OSError as error:
        raise UsageError(f"{name}: cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{name}: is no JSON ({error}); the results.json of a run is meant") from error
    check(baseline, name)
    return dict(baseline)


def check(baseline: Any, name: str) -> None:
    """Raise UsageError unless a baseline can be compared, found out on itself: what is missing may lie deep inside."""
    _require_results(baseline, name)
    _compared(baseline, baseline, RELATIVE, name)


def _require_results(baseline: Any, name: str = "baseline") -> None:
    """Raise UsageError, saying what is missing, unless this is results.json of a version that is understood."""
    if not isinstance(baseline, Mapping):
        raise UsageError(f"{name}: is no results.json (a block of keys)")
    if missing := [key for key in NEEDED if key not in baseline]:
        raise UsageError(f"{name}: is no results.json of vireport: {', '.join(missing)} missing")
    version = baseline["schema_version"]
    if version != SCHEMA_VERSION:
        shown = visible(repr(version), LONGEST)
        raise UsageError(f"{name}: schema_version {shown} is not understood (allowed: {SCHEMA_VERSION})")
    _require_finite(baseline, name)


def _require_finite(baseline: Any, name: str) -> None:
    """Raise UsageError where a number is none, or is larger than any double: nothing can be compared with it."""
    waiting = [("", baseline)]
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, Mapping):
            waiting += [(f"{path}.{key}" if path else str(key), value[key]) for key in value]
        elif isinstance(value, list | tuple):
            waiting += [(f"{path}[{k}]", entry) for k, entry in enumerate(value)]
        elif isinstance(value, int | float) and not -float_info.max <= value <= float_info.max:
            shown = visible(repr(value) if isinstance(value, float) else "an integer beyond all doubles")
            raise UsageError(f"{name}: {visible(path, LONGEST)} is {shown} (results have finite numbers only)")


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
        Where the baseline is no results.json, lacks something that is compared, or has a number that is not finite;
        and where the tolerance is none.
    """
    if not 0 <= relative < inf:
        raise UsageError(f"tolerance: got {relative} (a relative difference from 0, and finite)")
    _require_results(baseline)
    return _compared(baseline, study.to_dict(), relative)


def _compared(
    baseline: Mapping[str, Any], now: Mapping[str, Any], relative: float, name: str = "baseline"
) -> tuple[Change, ...]:
    try:
        with np.errstate(all="raise"):
            return changes(baseline, now, relative)
    except (KeyError, TypeError, AttributeError, IndexError, ValueError, ArithmeticError) as error:
        what = visible(f"{error.args[0]!r} is missing" if isinstance(error, KeyError) else str(error), LONGEST)
        raise UsageError(f"{name}: is no results.json of vireport: {what}") from error


def changes(old: Mapping[str, Any], new: Mapping[str, Any], relative: float = RELATIVE) -> tuple[Change, ...]:
    """What is not the same in two results, as data; by groups, of each what changed most first.

    Raises
    ------
    KeyError, TypeError, ValueError
        Where one lacks what results.json has.
    """
    order = list(Group)
    changed = [*_changed_numbers(old, new, relative), *_changed_statements(old, new)]
    return tuple(sorted(changed, key=lambda x: (order.index(x.group), x.what if x.group is Group.ALERT else "")))


def _changed_numbers(old: Mapping[str, Any], new: Mapping[str, Any], relative: float) -> Iterator[Change]:
    members = quantities_of({"before": _relabelled(old, new, relative), "after": new})
    axes = axes_of(members.values(), relative)
    for difference in differences(members, Axes(axes.always), relative):
        before, after = difference.values
        gone_or_new = (before is None) != (after is None) and all(entry.comparable for entry in difference.entries)
        if difference.group is not Group.DESIGN_POINT and (difference.differs or gone_or_new):
            unit = "" if difference.unit == "1" else difference.unit
            size = None if difference.group is Group.MARGIN else _relative(before, after)
            yield Change(difference.group, visible(difference.quantity, LONGEST), before, after, unit, size)


def _changed_statements(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Change]:
    before, after = dict(_statements(old)), dict(_statements(new))
    for key in dict.fromkeys([*before, *after]):
        group, what = key[0], (after.get(key) or before[key])[0]
        was, now = (statements[key][1] if key in statements else None for statements in (before, after))
        if not same_setting(was, now):
            values = _plain(was), _plain(now)
            yield Change(group, visible(what, LONGEST), *values, "", _relative(*values))


def _statements(results: Mapping[str, Any]) -> Iterator[tuple[tuple[Group, str], tuple[str, Any]]]:
    """What results say that is no quantity: by its group and key, what it is in words and its value."""
    for path, value in settings_of(results["scenario"]).items():
        yield (Group.SCENARIO, path), (path, value)
    if (design := results["design_point"]) is not None:
        rows = zip(design["family"], design["stability"], design["admissible"], strict=True)
        stable = [f"{family} {word}" for family, word, admissible in rows if admissible and Stability(word).attracts]
        what = "stable 1:1 motion at the design point"
        yield (Group.DESIGN_POINT, ""), (what, ", ".join(sorted(stable)) or "none")
    for alert in results["alerts"]:
        yield (Group.ALERT, alert["code"]), (f"{alert['code']} {alert['title']}", alert["severity"])
    for criterion in (results.get("requirements") or {}).get("criteria", ()):
        what = f"requirements.{criterion['key']}"
        yield (Group.REQUIREMENT, criterion["key"]), (what, "met" if criterion["passed"] else "not met")


def _plain(value: Any) -> float | str | None:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if isinstance(value, list | tuple):
        return visible(", ".join(map(str, value)), LONGEST)
    return None if value is None else visible(str(value), LONGEST)


def _relative(before: float | str | None, after: float | str | None) -> float | None:
    return (after - before) / abs(before) if isinstance(before, float) and isinstance(after, float) and before else None


Point = Mapping[str, Any]


def _relabelled(old: Mapping[str, Any], new: Mapping[str, Any], relative: float) -> dict[str, Any]:
    """The old results with the labels that the same critical points have in the new ones.

    A point that is gone keeps its label, unless another point has it now.
    """
    taken = [_name(point) for point in new["critical_points"]]
    clashing = [point["label"] for point in old["critical_points"] if _name(point) in taken]
    labels = {label: f"{label} of the baseline" for label in clashing}
    labels |= {point["label"]: match["label"] for point, match in _paired(old, new, relative)}

    def named(points: Sequence[Point]) -> list[Point]:
        return [{**point, "label": labels.get(point["label"], point["label"])} for point in points]

    relabelled = {**old, "critical_points": named(old["critical_points"])}
    if old["scenario"].get("sweep") and old["design_point"] is not None:
        relabelled["design_point"] = {**old["design_point"], "margins": named(old["design_point"]["margins"])}
    return relabelled


def _name(point: Point) -> tuple[str, str, str]:
    return point["label"], point["kind"], point["family"]


def _paired(old: Mapping[str, Any], new: Mapping[str, Any], relative: float) -> list[tuple[Point, Point]]:
    """Which critical point now is which of before: first those in the same place, then those of the same label."""
    swept = [(results["scenario"].get("sweep") or {}).get("parameter") for results in (old, new)]
    axis = "sweep_value" if swept[0] == swept[1] else "d"

    def bound(point: Point) -> float:
        """In d, which goes with the square of a frequency at the most, a bound counts twice in proportion."""
        value, error = float(point["sweep_value"]), float(point["error_bound"])
        return error if axis == "sweep_value" else 2 * error * abs(float(point["d"]) / value) if value else 0.0

    def same_place(point: Point, other: Point) -> bool:
        x, y = float(point[axis]), float(other[axis])
        return abs(y - x) <= relative * max(abs(x), abs(y)) + bound(point) + bound(other)

    left, right = list(old["critical_points"]), list(new["critical_points"])
    pairs: list[tuple[Point, Point]] = []
    for same in (same_place, lambda point, other: _name(point) == _name(other)):
        for point in list(left):
            alike = (other for other in right if _name(other)[1:] == _name(point)[1:])
            match = next((other for other in alike if same(point, other)), None)
            if match is not None:
                pairs.append((point, match))
                left.remove(point)
                right.remove(match)
    return pairs


def unequal(old: Any, new: Any, path: str = "") -> Iterator[str]:
    """Paths of the values of two results, as data, that are not exactly the same."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for key in dict.fromkeys([*new, *old]):
            if key not in OF_ONE_RUN:
                yield from unequal(old.get(key), new.get(key), f"{path}.{key}" if path else key)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for k, values in enumerate(zip(old, new, strict=True)):
            yield from unequal(*values, f"{path}[{k}]")
    elif old != new:
        yield path


def rerun_text(baseline: Mapping[str, Any], study: Study, name: str) -> str:
    """Whether a study gives the very results of an earlier run, or what differs; without a newline at the end.

    Raises
    ------
    UsageError
        As `diff` does.
    """
    paths = list(unequal(baseline, json.loads(json.dumps(study.to_dict()))))
    if not paths:
        return f"identical to the results in {visible(name)}"
    first = ", ".join(visible(path, LONGEST) for path in paths[:FEW]) + (", ..." if len(paths) > FEW else "")
    count = f"{len(paths)} value{'s' * (len(paths) != 1)}"
    changed = diff(baseline, study, relative=0.0)
    listed = [diff_text(changed, name)] if changed else []
    return "\n".join([f"not identical to the results in {visible(name)}: {count} ({first})", *listed])


def diff_text(changed: Sequence[Change], baseline: str = "the baseline") -> str:
    """The changes in lines of plain text, grouped; without a newline at the end."""
    lines = (f"  {change.group}: {change.sentence}" for change in changed)
    return "\n".join([_headline(changed, visible(baseline)) + (":" if changed else "."), *lines])


def changes_table(changed: Sequence[Change], baseline: str = "the baseline") -> Table:
    """The changes as a table, grouped, whose caption counts them; without rows where there are none."""
    sizes = (ABSENT if change.change is None else percent(change.change, signed=True) for change in changed)
    rows = tuple((change.group, change.what, *change.sides, size) for change, size in zip(changed, sizes, strict=True))
    columns = (*texts("Group", "What"), *numbers("Before", "Now", "Change"))
    note = f"Numbers are the same within a relative difference of {exact(RELATIVE)} and their error bounds."
    return Table(_headline(changed, baseline), columns, rows, note)


def diff_markdown(changed: Sequence[Change], baseline: str = "the baseline") -> str:
    """The changes as a Markdown table, for a comment on a pull request."""
    return markdown_of(changes_table(changed, baseline))


def _headline(changed: Sequence[Change], baseline: str) -> str:
    if not changed:
        return f"No change beyond tolerance since {baseline}"
    return f"{len(changed)} change{'s' * (len(changed) != 1)} since {baseline}"


def diff_json(changed: Sequence[Change], relative: float = RELATIVE) -> bytes:
    """The changes as JSON."""
    data = {"changed": bool(changed), "tolerance": relative, "changes": [asdict(change) for change in changed]}
    return (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()
