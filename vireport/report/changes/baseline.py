"""What changed since a baseline: results.json of an earlier run against a scenario as it is now, for pull requests.

Numbers count as the same within a relative tolerance and what their error bounds leave open. A critical point that
has another label, because there is one more before it, is the same point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from msgspec.structs import replace

from vireport.base.errors import UsageError
from vireport.report.changes.quantities import QuantityGroup, bound_in_d, compared_scenarios, scenario_keys
from vireport.report.changes.sentences import since_baseline
from vireport.report.changes.table import Axes, ComparisonRow, axes_of, comparison_rows
from vireport.study.earlier import read_earlier
from vireport.study.reading import LONGEST_TEXT, read_results
from vireport.study.result_records import CriticalPointData, MarginData, Results
from vireport.study.study import Study, require_study
from vireport.text.foreign import visible
from vireport.text.said import Said

RELATIVE = 1e-6
"""Relative difference up to which a number is the same: far above rounding, far below what a device is made to."""

PointData = CriticalPointData | MarginData
"""A critical point, or the margin to one."""

Place = TypeVar("Place", CriticalPointData, MarginData)


def read_baseline(path: str | Path) -> dict[str, Any]:
    """Read the results of an earlier run from its results.json or its report, or from standard input ("-").

    They are compared with themselves, so that what is wrong with them is known before a scenario is solved.

    Raises
    ------
    UsageError
        Where the file is not there, or is none.
    """
    earlier = read_earlier(str(path))
    require_comparable(earlier.results, earlier.file)
    return dict(earlier.results)


def require_comparable(baseline: object, name: str) -> None:
    """Raise UsageError unless a baseline can be compared: with itself, as its numbers may overflow in a formula."""
    results = read_results(baseline, name)
    _changed_rows(results, results, RELATIVE, name)


def diff(
    baseline: Mapping[str, object], study: Study | Mapping[str, object], relative: float = RELATIVE
) -> tuple[ComparisonRow, ...]:
    """List what has changed since the results of an earlier run, beyond a tolerance.

    Parameters
    ----------
    baseline : mapping
        Content of the results.json of an earlier run.
    study : Study or mapping
        Study of the present scenario, or content of another results.json.
    relative : float
        Relative difference up to which two numbers count as equal [1]; their error bounds are added to it.

    Returns
    -------
    tuple of ComparisonRow
        The changes, each with `quantity`, `before`, `after`, `change` and `sentence`.

    Raises
    ------
    UsageError
        Where the baseline is no results.json, lacks something that is compared, or has a number that is not finite;
        and for a tolerance that is no positive number.
    """
    if not 0 <= relative < inf:
        raise UsageError(f"tolerance: got {relative} (a relative difference from 0, and finite)")
    if not isinstance(study, Mapping):
        require_study(study)
    now = read_results(study, "results") if isinstance(study, Mapping) else study.results()
    return _changed_rows(read_results(baseline, "baseline"), now, relative, "baseline")


def _changed_rows(baseline: Results, now: Results, relative: float, name: str) -> tuple[ComparisonRow, ...]:
    try:
        # Where a damaged baseline overflows, NumPy would warn, go on with inf or nan, and compare these as numbers.
        with np.errstate(all="raise"):
            return changes(baseline, now, relative)
    except (ArithmeticError, ValueError) as error:
        raise UsageError(f"{name}: is no results.json of vireport: {visible(str(error), LONGEST_TEXT)}") from error


def changes(old: Results, new: Results, relative: float = RELATIVE) -> tuple[ComparisonRow, ...]:
    """Compare two results: what is not the same, by groups, of each what changed most first."""
    scenarios = compared_scenarios({"before": _relabelled(old, new, relative), "after": new})
    always = Axes(axes_of(scenarios.values(), relative).always)
    return tuple(_since_baseline(row) for row in comparison_rows(scenarios, always, relative) if _has_changed(row))


def _has_changed(row: ComparisonRow) -> bool:
    """Tell whether a row has changed; of the stable motions at the design point their names say so, not their count."""
    if row.group is QuantityGroup.DESIGN_POINT and not row.is_statement:
        return False
    new_or_gone = (row.before is None) != (row.after is None)
    return row.differs or (new_or_gone and all(cell.comparable for cell in row.cells))


def _since_baseline(row: ComparisonRow) -> ComparisonRow:
    """Give a row its change relative to the value before and its sentence, with texts of the baseline as inert text."""
    cells = tuple(replace(cell, value=_plain(cell.value)) for cell in row.cells)
    before, after = (cell.value for cell in cells)
    numbers = isinstance(before, float) and isinstance(after, float)
    change = (after - before) / abs(before) if numbers and before and row.group is not QuantityGroup.MARGIN else None
    name = _visible(row.name)
    said = since_baseline(name, (before, after), row.unit, change, row.group.exactness)
    return replace(row, name=name, cells=cells, change=change, differs=True, said=said)


def _visible(name: object) -> Any:
    """A name with the texts of a baseline as inert text."""
    if isinstance(name, Said):
        return replace(name, values=tuple(map(_visible, name.values)))
    return visible(name, LONGEST_TEXT) if isinstance(name, str) else name


def _plain(value: object) -> float | str | None:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if isinstance(value, list | tuple):
        return visible(", ".join(map(str, value)), LONGEST_TEXT)
    return None if value is None else visible(str(value), LONGEST_TEXT)


def _relabelled(old: Results, new: Results, relative: float) -> Results:
    """Give the critical points of old results the labels that the same points have in the new ones.

    A point that is gone keeps its label, unless another point has it now.
    """
    taken = [_name(point) for point in new.critical_points]
    clashing = [point.label for point in old.critical_points if _name(point) in taken]
    labels: dict[str, object] = {label: Said("of_baseline", (label,), "quantities") for label in clashing}
    labels |= {point.label: match.label for point, match in _paired(old, new, relative)}

    def named(points: Sequence[Place]) -> list[Place]:
        return [replace(point, label=labels.get(point.label, point.label)) for point in points]

    relabelled = replace(old, critical_points=named(old.critical_points))
    if scenario_keys(old).sweep is not None and old.design_point is not None:
        design = replace(old.design_point, margins=named(old.design_point.margins))
        relabelled = replace(relabelled, design_point=design)
    return relabelled


def _name(point: PointData) -> tuple[str, str, str]:
    return point.label, point.kind, point.family


def _paired(old: Results, new: Results, relative: float) -> list[tuple[CriticalPointData, CriticalPointData]]:
    """Pair critical points of before and now: first those in the same place, then those of the same label.

    One more point before them shifts the labels of all that follow, so that a label alone pairs the wrong ones.
    """
    sweeps = [scenario_keys(results).sweep for results in (old, new)]
    before, now = (None if sweep is None else sweep.parameter for sweep in sweeps)

    def place(point: CriticalPointData) -> tuple[float, float]:
        """Where a point is, with its error bound."""
        value, bound = point.sweep_value, point.error_bound
        return (value, bound) if before == now else (point.d, bound_in_d(point.d, value, bound))

    def same_place(point: CriticalPointData, other: CriticalPointData) -> bool:
        (x, bound), (y, other_bound) = place(point), place(other)
        return abs(y - x) <= relative * max(abs(x), abs(y)) + bound + other_bound

    left, right = list(old.critical_points), list(new.critical_points)
    pairs: list[tuple[CriticalPointData, CriticalPointData]] = []
    for same in (same_place, lambda point, other: _name(point) == _name(other)):
        for point in list(left):
            alike = (other for other in right if _name(other)[1:] == _name(point)[1:])
            match = next((other for other in alike if same(point, other)), None)
            if match is not None:
                pairs.append((point, match))
                left.remove(point)
                right.remove(match)
    return pairs
