"""What of several scenarios is compared: motions, critical points, stable ranges, margins and voltages.

A place along the sweep is given in the swept parameter where all scenarios sweep the same one, and in d where they
do not; critical points are the same where their label, kind and family are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Literal

import numpy as np

from vireport.analysis import (
    CriticalKind,
    CriticalPoint,
    Family,
    Margin,
)
from vireport.comparison.differences import SAME, SAMPLED, Difference, Entry, Member, Printed, difference, rank
from vireport.gate import SWEEP_END
from vireport.scenario import Parameter
from vireport.study import Study
from vireport.text import (
    percent,
    quantity,
    significant,
)

NO_SWEEP, NO_DESIGN, NO_MASS = "no sweep", "no design point", "device.ball_mass_kg is not given"
NO_STABLE, HELD = "no stable 1:1 motion", "the sweep holds d"

Axis = Parameter | Literal["d"]
Key = tuple[str, CriticalKind, Family]
"""Of a critical point: label, kind and family."""

Ends = tuple[tuple[float, str], tuple[float, str]]
"""Of a stable range: values, ascending, and what ends it there."""


def differences(members: Sequence[Member]) -> tuple[Difference, ...]:
    """Compare all that can be compared: what only some scenarios have first, then what changed most.

    Parameters
    ----------
    members : sequence of Member
        At least one.
    """
    found = [*_motions(members), *_critical_points(members), *_stable_ranges(members), *_margins(members)]
    return tuple(sorted([*found, *_voltages(members)], key=rank))


def axes_of(members: Sequence[Member]) -> list[Axis]:
    """In what places are compared: first that which all swept scenarios have, then what some of them share.

    d comes beside a swept parameter that all share only where it is not the same multiple of it in all of them.
    """
    sweeps = [member.study.solution.sweep for member in members if member.study.solution.sweep is not None]
    swept = [sweep.parameter for sweep in sweeps]
    if not swept:
        return []
    if len(set(swept)) > 1:
        return ["d", *(name for name in Parameter if swept.count(name) > 1)]
    if swept[0] == "inclination_deg":
        return [swept[0]]
    at = float(sweeps[0].start)
    scales = [float(sweep.device.groups(sweep.parameter, at)[0]) for sweep in sweeps]
    return [swept[0]] if max(scales) - min(scales) <= SAME * max(scales) else [swept[0], "d"]


def _symbol(axis: Axis) -> str:
    return "d" if axis == "d" else axis.symbol


def _unit(axis: Axis) -> str:
    return "1" if axis == "d" else axis.unit


def _printer(axis: Axis) -> Printed:
    return significant if axis == "d" else axis.show


def _motions(members: Sequence[Member]) -> Iterator[Difference]:
    """How many stable motions there are at the design point."""
    name = "stable 1:1 motions at the design point"
    entries = [_stable_motions(member.study) for member in members]
    yield from difference(name, "", "design point", "1", members, entries, significant, "none in")


def _stable_motions(study: Study) -> Entry:
    if study.solution.design is None:
        return Entry(None, NO_DESIGN)
    stable = study.solution.design.motions.stable
    if not stable.any():
        return Entry(None, NO_STABLE, absent=True)
    return Entry(
        float(stable.sum()), " and ".join(dict.fromkeys(np.array(study.solution.design.motions.words)[stable]))
    )


def _critical_points(members: Sequence[Member]) -> Iterator[Difference]:
    axes = axes_of(members)
    for key in sorted({_key(point) for member in members for point in _points(member.study)}):
        label, kind, family = key
        for axis in axes:
            entries = [_point_entry(member.study, key, axis, axis == axes[0]) for member in members]
            if axis == axes[0] or _known(entries) > 1:
                yield from difference(
                    f"{label}, {kind.words} of the {family} motion",
                    _symbol(axis),
                    "critical point",
                    _unit(axis),
                    members,
                    entries,
                    _printer(axis),
                    "none in the sweep of",
                )


def _known(entries: Sequence[Entry]) -> int:
    return sum(entry.value is not None for entry in entries)


def _points(study: Study) -> tuple[CriticalPoint, ...]:
    return study.solution.critical_points


def _key(point: CriticalPoint) -> Key:
    return point.label, point.kind, point.family


def _point_entry(study: Study, key: Key, axis: Axis, first: bool) -> Entry:
    if study.solution.sweep is None:
        return Entry(None, NO_SWEEP)
    if axis not in ("d", study.solution.sweep.parameter):
        return Entry(None, _sweeps(study))
    point = next((one.point for one in _points(study) if _key(one) == key), None)
    if point is None:
        return Entry(None, "none in the sweep", absent=first)
    if axis != "d":
        return Entry(point.sweep_value, bound=point.error_bound)
    note = HELD if study.solution.sweep.parameter == "inclination_deg" else ""
    relative = point.error_bound / abs(point.sweep_value) if point.sweep_value else 0.0
    # d goes with the square of a frequency, and with the first power of a length or of the inverse of a force.
    return Entry(point.d, note, bound=2 * relative * point.d)


def _sweeps(study: Study) -> str:
    return f"sweeps the {study.solution.sweep.parameter.quantity}" if study.solution.sweep else NO_SWEEP


def _stable_ranges(members: Sequence[Member]) -> Iterator[Difference]:
    axes = axes_of(members)
    for axis in axes:
        ranges = [_ranges(member.study, axis) for member in members]
        most = max((len(one) for one in ranges if one is not None), default=0)
        which, missing = (" {}", "no such stable range in") if most > 1 else ("", "no stable range in")
        for k in range(most):
            for end, word in enumerate(("from", "to")):
                pairs = zip(members, ranges, strict=True)
                entries = [_range_entry(member.study, one, k, end, axis, axis == axes[0]) for member, one in pairs]
                if axis == axes[0] or _known(entries) > 1:
                    name = f"stable range{which.format(k + 1)} {word}"
                    show = _printer(axis)
                    yield from difference(
                        name, _symbol(axis), "stable range", _unit(axis), members, entries, show, missing
                    )


def _range_entry(study: Study, ranges: list[Ends] | None, k: int, end: int, axis: Axis, first: bool) -> Entry:
    if ranges is None:
        return Entry(None, NO_SWEEP if study.solution.sweep is None else HELD if axis == "d" else _sweeps(study))
    if k < len(ranges):
        return Entry(*ranges[k][end])
    return Entry(None, "no further stable range" if ranges else NO_STABLE, absent=first)


def _ranges(study: Study, axis: Axis) -> list[Ends] | None:
    """The stable ranges along an axis, ascending; None where the sweep is not along it."""
    if study.solution.sweep is None or axis not in ("d", study.solution.sweep.parameter):
        return None
    if axis == "d" and study.solution.sweep.parameter == "inclination_deg":
        return None

    def along(value: float) -> float:
        return float(study.solution.device.groups(part.parameter, value)[0]) if axis == "d" else value

    found: list[Ends] = []
    for part in study.solution.stable_ranges:
        ends = ((along(value), point.label if point is not None else SWEEP_END) for value, point in part.ends)
        low, high = sorted(ends)
        found.append((low, high))
    return sorted(found)


def _margins(members: Sequence[Member]) -> Iterator[Difference]:
    """How far the design points are from the critical points that end their stable ranges, as shares."""
    axes = axes_of(members) or list(Parameter)
    for axis in axes:
        found = [_limits(member.study, axis) for member in members]
        for key in sorted({key for one in found for key in one}):
            pairs = zip(members, found, strict=True)
            entries = [
                Entry(one[key]) if key in one else Entry(None, _no_margin(member.study, one, axis))
                for member, one in pairs
            ]
            if axis == axes[0] or _known(entries) > 1 or all(member.study.solution.sweep is None for member in members):
                name = f"margin from the design point to {key[0]}, {key[1].words}, in {_symbol(axis)}"
                yield from difference(name, "", "margin", "%", members, entries, _percent)


def _percent(value: float, digits: int) -> str:
    return percent(value / 100, digits - 3, signed=True)


def _limits(study: Study, axis: Axis) -> dict[Key, float]:
    """Distances to the critical points that end the stable range, in per cent of the design value."""
    found: dict[Key, float] = {}
    for margin in study.solution.design.margins if study.solution.design is not None else ():
        share = _share(study, margin, axis)
        if margin.ends_stability and share is not None:
            found[margin.label, margin.kind, margin.point.family] = 100 * share
    return found


def _share(study: Study, margin: Margin, axis: Axis) -> float | None:
    if axis == margin.parameter:
        return margin.relative
    if axis != "d" or study.solution.sweep is None or margin.parameter == "inclination_deg":
        return None
    at = float(study.solution.device.groups(margin.parameter, margin.sweep_value - margin.distance)[0])
    return (float(study.solution.device.groups(margin.parameter, margin.sweep_value)[0]) - at) / at


def _no_margin(study: Study, limits: dict[Key, float], axis: Axis) -> str:
    if study.solution.design is None:
        return NO_DESIGN
    if limits:
        return "does not end the stable range"
    if study.solution.sweep is not None and axis not in ("d", study.solution.sweep.parameter):
        return _sweeps(study)
    if not study.solution.design.motions.stable.any():
        return f"{NO_STABLE} at the design point"
    return "no critical point ends the stable range"


def _voltages(members: Sequence[Member]) -> Iterator[Difference]:
    entries = [_design_voltage(member.study) for member in members]
    name, none = "U_ave of the stable motion at the design point", "no stable motion there in"
    yield from difference(name, "", "voltage", "V", members, entries, _volts, none)
    extremes: tuple[tuple[str, Callable[[Any], Any]], ...] = (("highest", np.max), ("lowest", np.min))
    for word, choose in extremes:
        entries = [_extreme_voltage(member.study, choose) for member in members]
        name, none = f"{word} U_ave over the stable range", "no stable motion in"
        yield from difference(name, "", "voltage", "V", members, entries, _volts, none, SAMPLED)


def _volts(value: float, digits: int) -> str:
    return quantity(value, "V", digits - 2)


def _design_voltage(study: Study) -> Entry:
    if study.solution.design is None:
        return Entry(None, NO_DESIGN)
    if study.solution.design.voltages is None:
        return Entry(None, NO_MASS)
    stable = study.solution.design.voltages.average_v[study.solution.design.motions.stable]
    if not len(stable):
        return Entry(None, f"{NO_STABLE} at the design point", absent=True)
    highest = float(stable.max())
    several = highest - float(stable.min()) > SAME * highest
    return Entry(highest, f"the higher of {len(stable)}" if several else "")


def _extreme_voltage(study: Study, choose: Callable[[Any], Any]) -> Entry:
    if study.solution.sweep is None:
        return Entry(None, NO_SWEEP)
    if study.solution.membrane is None:
        return Entry(None, NO_MASS)
    parts = [
        branch.voltages.average_v[part.first : part.last + 1]
        for branch in study.solution.branches
        for part in branch.segments()
        if part.stable and branch.voltages is not None
    ]
    if not parts:
        return Entry(None, f"{NO_STABLE} in the sweep", absent=True)
    return Entry(float(choose(np.concatenate(parts))))
