"""What is not the same in two results.json, quantity by quantity."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from vireport.analysis import CriticalKind
from vireport.comparison.comparison import NOT_COMPARED, flattened
from vireport.comparison.differences import SAMPLED
from vireport.scenario import Parameter
from vireport.text import (
    MOST_DIGITS,
    percent,
    significant,
)

INPUT = 1e-12
"""Relative difference up to which a value of the scenario is the same: it is read from a text, and only rounding is
forgiven."""

Group = Literal[
    "scenario", "critical point", "stable range", "design point", "margin", "voltage", "alert", "requirement"
]


@dataclass(frozen=True, slots=True)
class Change:
    """One thing that is not as it was.

    Attributes
    ----------
    group : str
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
    def sentence(self) -> str:
        """The change in words."""
        if self.before is None:
            return f"{self.what}: new, {shown(self.after, self.unit)}."
        if self.after is None:
            return f"{self.what}: gone, was {shown(self.before, self.unit)}."
        before, after = shown_apart(self.before, self.after, self.unit)
        size = f" ({percent(self.change, signed=True)})" if self.change is not None else ""
        return f"{self.what}: {before} to {after}{size}."


def shown(value: float | str | None, unit: str, digits: int = 6) -> str:
    """Print one side of a change."""
    if value is None:
        return "none"
    if isinstance(value, str):
        return value
    return f"{significant(value, digits)}{'' if unit == '°' else ' ' * bool(unit)}{unit}"


def shown_apart(before: float | str, after: float | str, unit: str) -> tuple[str, str]:
    """Print both sides of a change, numbers with so many digits that they differ."""
    for digits in range(6, MOST_DIGITS):
        one, two = shown(before, unit, digits), shown(after, unit, digits)
        if one != two:
            break
    return one, two


def changes(old: Mapping[str, Any], new: Mapping[str, Any], relative: float) -> Iterator[Change]:
    """What is not the same in two results, as data.

    Parameters
    ----------
    old, new : mapping
        As results.json has them.
    relative : float
        Relative difference up to which two numbers are the same; error bounds are added to it.

    Raises
    ------
    KeyError, TypeError
        Where one lacks what results.json has.
    """
    yield from _scenario(old["scenario"], new["scenario"])
    axis = "sweep_value" if _swept(old) == _swept(new) else "d"
    pairs = _paired(old["critical_points"], new["critical_points"], axis, relative)
    yield from _critical_points(old, new, pairs, axis, relative)
    if axis == "sweep_value":
        yield from _stable_ranges(old, new, relative)
    yield from _design_point(old["design_point"], new["design_point"])
    renamed = {str(two["label"]): str(one["label"]) for one, two in pairs}
    yield from _margins(old["design_point"], new["design_point"], relative, renamed)
    yield from _voltages(old, new, relative)
    yield from _alerts(old["alerts"], new["alerts"])
    yield from _requirements(old.get("requirements"), new.get("requirements"))


def _swept(results: Mapping[str, Any]) -> Any:
    return results["scenario"]["sweep"]["parameter"] if results["scenario"].get("sweep") else None


def _unit(results: Mapping[str, Any]) -> str:
    swept = _swept(results)
    return Parameter(swept).unit if swept in tuple(Parameter) else ""


def _scenario(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Change]:
    before, after = flattened(old), flattened(new)
    for path in dict.fromkeys([*before, *after]):
        one: Any = before.get(path)
        two: Any = after.get(path)
        if path in NOT_COMPARED or one == two:
            continue
        if _number(one) and _number(two):
            if abs(two - one) > INPUT * max(abs(one), abs(two)):
                yield Change("scenario", path, float(one), float(two), "", _relative(one, two))
        elif _text(one) != _text(two):
            yield Change("scenario", path, _text(one), _text(two))


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _text(value: Any) -> str | None:
    if value is None:
        return None
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)


def _relative(one: float, two: float) -> float | None:
    return (two - one) / abs(one) if one else None


Point = Mapping[str, Any]


def _critical_points(
    old: Mapping[str, Any], new: Mapping[str, Any], pairs: Sequence[tuple[Point, Point]], axis: str, relative: float
) -> Iterator[Change]:
    """Points that moved, vanished and appeared."""
    unit = _unit(new) if axis == "sweep_value" else ""
    for one, two in pairs:
        x, y = float(one[axis]), float(two[axis])
        if abs(y - x) > _allowed(one, two, axis, relative):
            yield Change("critical point", _name(two, axis, new), x, y, unit, _relative(x, y))
    for one in old["critical_points"]:
        if not any(one is first for first, _ in pairs):
            yield Change("critical point", _name(one, axis, old), float(one[axis]), None, unit)
    for two in new["critical_points"]:
        if not any(two is second for _, second in pairs):
            yield Change("critical point", _name(two, axis, new), None, float(two[axis]), unit)


def _paired(before: Sequence[Point], after: Sequence[Point], axis: str, relative: float) -> list[tuple[Point, Point]]:
    """Which point now is which of before: first those in the same place, then those of the same label."""

    def same_place(one: Point, two: Point) -> bool:
        return abs(float(two[axis]) - float(one[axis])) <= _allowed(one, two, axis, relative)

    def same_label(one: Point, two: Point) -> bool:
        return bool(one["label"] == two["label"])

    left, right = list(before), list(after)
    pairs: list[tuple[Point, Point]] = []
    for same in (same_place, same_label):
        for one in list(left):
            alike = (two for two in right if (one["kind"], one["family"]) == (two["kind"], two["family"]))
            two = next((two for two in alike if same(one, two)), None)
            if two is not None:
                pairs.append((one, two))
                left = [other for other in left if other is not one]
                right = [other for other in right if other is not two]
    return pairs


def _allowed(one: Point, two: Point, axis: str, relative: float) -> float:
    """How far two positions may be apart and be the same: the tolerance, and both error bounds.

    In d, which goes with the square of a frequency at the most, a bound is taken twice in proportion.
    """
    bounds = 0.0
    for point in (one, two):
        value = float(point["sweep_value"])
        scale = 1.0 if axis == "sweep_value" else 2 * abs(float(point["d"]) / value) if value else 0.0
        bounds += scale * float(point["error_bound"])
    return relative * max(abs(float(one[axis])), abs(float(two[axis]))) + bounds


def _name(point: Point, axis: str, results: Mapping[str, Any]) -> str:
    swept = _swept(results)
    symbol = Parameter(swept).symbol if axis == "sweep_value" and swept in tuple(Parameter) else "d"
    kind = _kind_words(point["kind"])
    return f"{point['label']}, {kind} of the {point['family']} motion, {symbol}"


def _stable_ranges(old: Mapping[str, Any], new: Mapping[str, Any], relative: float) -> Iterator[Change]:
    before, after, unit = old["stable_range"], new["stable_range"], _unit(new)
    if len(before) != len(after):
        yield Change("stable range", "stable ranges", _ranges(before, unit), _ranges(after, unit))
        return
    for k, (one, two) in enumerate(zip(before, after, strict=True), 1):
        which = f"stable range {k}" if len(before) > 1 else "stable range"
        for end in ("from", "to"):
            x, y = float(one[end]), float(two[end])
            bounds = sum(part.get(f"{end}_error_bound") or 0.0 for part in (one, two))
            if abs(y - x) > relative * max(abs(x), abs(y)) + bounds:
                yield Change("stable range", f"{which} {end}", x, y, unit, _relative(x, y))


def _ranges(parts: Sequence[Mapping[str, Any]], unit: str) -> str | None:
    return "; ".join(f"{shown(part['from'], '')} to {shown(part['to'], unit)}" for part in parts) or None


def _design_point(old: Mapping[str, Any] | None, new: Mapping[str, Any] | None) -> Iterator[Change]:
    what = "stable 1:1 motion at the design point"
    before, after = (None if one is None else _stable_words(one) for one in (old, new))
    if before != after:
        yield Change("design point", what, before, after)


def _stable_words(design: Mapping[str, Any]) -> str:
    rows = zip(design["family"], design["stability"], design["admissible"], strict=True)
    words = sorted(f"{family} {word}" for family, word, admissible in rows if admissible and word.startswith("stable"))
    return ", ".join(words) or "none"


def _margins(
    old: Mapping[str, Any] | None, new: Mapping[str, Any] | None, relative: float, renamed: Mapping[str, str]
) -> Iterator[Change]:
    """Distances from the design point to what ends its stable range, in per cent."""
    if old is None or new is None:
        return
    swept = len({margin["parameter"] for one in (old, new) for margin in one["margins"]}) == 1
    before = {_margin_key(one, {}): one for one in old["margins"] if one["ends_stability"]}
    after = {_margin_key(one, renamed if swept else {}): one for one in new["margins"] if one["ends_stability"]}
    for key in dict.fromkeys([*before, *after]):
        one, two = before.get(key), after.get(key)
        shown = two or one
        if shown is None:
            continue
        kind = _kind_words(shown["kind"])
        what = f"margin to {shown['label']}, {kind}, in {Parameter(shown['parameter']).symbol}"
        x, y = _percent(one), _percent(two)
        if x is None and y is None:
            continue
        ratios = [_ratio(margin) for margin in (one, two) if margin is not None]
        if x is not None and y is not None and abs(y - x) <= 200 * relative * max(ratios):
            continue
        yield Change("margin", what, x, y, "%", None)


def _percent(margin: Mapping[str, Any] | None) -> float | None:
    return None if margin is None or margin["relative"] is None else 100 * float(margin["relative"])


def _ratio(margin: Mapping[str, Any]) -> float:
    """The critical value over the design value, of which a margin is what differs from 1."""
    return abs(float(margin["sweep_value"]) / (float(margin["sweep_value"]) - float(margin["distance"])))


def _margin_key(margin: Mapping[str, Any], renamed: Mapping[str, str]) -> tuple[str, str, str, str]:
    label = renamed.get(margin["label"], margin["label"])
    return margin["parameter"], label, margin["kind"], margin["family"]


def _voltages(old: Mapping[str, Any], new: Mapping[str, Any], relative: float) -> Iterator[Change]:
    for what, of in (
        ("U_ave of the stable motion at the design point", _design_voltage),
        ("highest U_ave over the stable range", lambda results: _extreme(results, max)),
        ("lowest U_ave over the stable range", lambda results: _extreme(results, min)),
    ):
        x, y = of(old), of(new)
        if x is None and y is None:
            continue
        if x is None or y is None:
            yield Change("voltage", what, x, y, "V")
        elif abs(y - x) > max(relative, SAMPLED) * max(abs(x), abs(y)):
            yield Change("voltage", what, x, y, "V", _relative(x, y))


def _design_voltage(results: Mapping[str, Any]) -> float | None:
    design = results["design_point"]
    if design is None or "u_ave_v" not in design:
        return None
    rows = zip(design["u_ave_v"], design["stability"], design["admissible"], strict=True)
    return max((float(u) for u, word, admissible in rows if admissible and word.startswith("stable")), default=None)


def _extreme(results: Mapping[str, Any], choose: Callable[[list[float]], float]) -> float | None:
    """An extreme of U_ave over stable motions, and over the critical points beside them."""
    found: list[float] = []
    for branch in results["branches"]:
        if "u_ave_v" not in branch:
            return None
        rows = zip(branch["stability"], branch["admissible"], strict=True)
        stable = [bool(admissible) and word.startswith("stable") for word, admissible in rows]
        for k, (u, label) in enumerate(zip(branch["u_ave_v"], branch["critical_point"], strict=True)):
            if stable[k] or (label and any(stable[max(k - 1, 0) : k + 2])):
                found.append(float(u))
    return choose(found) if found else None


def _alerts(old: Sequence[Mapping[str, Any]], new: Sequence[Mapping[str, Any]]) -> Iterator[Change]:
    before, after = ({alert["code"]: alert for alert in alerts} for alerts in (old, new))
    for code in sorted({*before, *after}):
        one, two = before.get(code), after.get(code)
        if one is None and two is not None:
            yield Change("alert", f"{code} {two['title']}", None, two["severity"])
        elif two is None and one is not None:
            yield Change("alert", f"{code} {one['title']}", one["severity"], None)


def _requirements(old: Mapping[str, Any] | None, new: Mapping[str, Any] | None) -> Iterator[Change]:
    before, after = ({one["key"]: one for one in (block or {}).get("criteria", ())} for block in (old, new))
    for key in dict.fromkeys([*before, *after]):
        one, two = (None if found is None else _met(found) for found in (before.get(key), after.get(key)))
        if one != two:
            yield Change("requirement", f"requirements.{key}", one, two)


def _met(criterion: Mapping[str, Any]) -> str:
    return "met" if criterion["passed"] else "not met"


def _kind_words(kind: str) -> str:
    """Name of a kind for the reader; of a kind that a later version may have, its key."""
    return CriticalKind(kind).words if kind in tuple(CriticalKind) else kind
