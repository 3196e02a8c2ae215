"""The acceptance table: each requirement of a scenario with its limit, the value it is held against, and the outcome.

A requirement is met only where that is certain: what an error bound leaves open, what a failed cross-check puts in
doubt and what cannot be evaluated is not met, and says why.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import (
    BifurcationDiagram,
    CriticalKind,
    Endings,
    Solution,
    StableInterval,
    Sweep,
    design_point,
    endings,
    impact_velocities,
    solve,
    stable_ranges,
)
from vireport.errors import NumericalError
from vireport.gate.criteria import DIGITS, Criterion, Judgement, LineOf, criterion, held
from vireport.physics import (
    Membrane,
    Voltages,
    voltages,
)
from vireport.scenario import MARGINS, Loaded, Parameter, Requirements

if TYPE_CHECKING:
    from vireport.trust import CrossCheck


Floats = NDArray[np.float64]
Names = tuple[str, ...]

UNITS = {parameter: "deg" if parameter is Parameter.INCLINATION else parameter.unit for parameter in Parameter}

ROUNDING = 1e-12
"""Relative error up to which the end of a stable range is taken to be known where no error bound is stated."""


def assess(loaded: Loaded, solution: Solution, crosscheck: CrossCheck | None) -> tuple[Criterion, ...]:
    """Hold results against what their scenario requires; () where that is nothing."""
    asked, line_of = loaded.scenario.requirements, loaded.line_of
    if asked is None:
        return ()
    found = [
        *_ranges(solution, asked, line_of),
        *_margins(solution, asked, line_of),
        *_voltages(solution, asked, line_of),
        *_crosscheck(crosscheck, asked, line_of),
    ]
    if crosscheck is None or crosscheck.passed:
        return tuple(found)
    doubt = "the simulation does not agree with the solution"
    return tuple(one if not one.passed else replace(one, passed=False, why=doubt) for one in found)


def _ranges(solution: Solution, asked: Requirements, line_of: LineOf) -> Iterator[Criterion]:
    diagram = solution.diagram
    if asked.stable_from is not None and asked.stable_to is not None and diagram is not None:
        ends = (asked.stable_from, asked.stable_to)
        unit = UNITS[diagram.sweep.parameter]
        keys = ("stable_from", "stable_to")
        yield criterion(
            line_of, keys, "Stable 1:1 motion over the range", _range_limit(ends, unit), lambda: _covered(diagram, ends)
        )
    if asked.inclination_from_deg is not None and asked.inclination_to_deg is not None:
        angles = (asked.inclination_from_deg, asked.inclination_to_deg)
        keys = ("inclination_from_deg", "inclination_to_deg")
        yield criterion(
            line_of,
            keys,
            "Stable 1:1 motion over the inclinations",
            _range_limit(angles, "deg"),
            lambda: _covered(_over_angles(solution, angles), angles),
        )


def _range_limit(ends: tuple[float, float], unit: str) -> tuple[str, float, str]:
    low, high = sorted(ends)
    return f"from {low:.12g} to {high:.12g} {unit}", high - low, unit


def _over_angles(solution: Solution, angles: tuple[float, float]) -> BifurcationDiagram:
    """The motions of the design over a range of inclination: those of the scenario's sweep, if it is one of it."""
    diagram = solution.diagram
    if diagram is not None and diagram.sweep.parameter is Parameter.INCLINATION:
        given = diagram.sweep.start, diagram.sweep.end
        if min(given) <= min(angles) and max(angles) <= max(given):
            return diagram
    return solve(Sweep(solution.device, Parameter.INCLINATION, 0.0, 90.0))


def _covered(diagram: BifurcationDiagram, ends: tuple[float, float]) -> Judgement:
    """Whether one stable range holds a range of the parameter, and ends outside of it for certain."""
    (low, high), parameter = sorted(ends), diagram.sweep.parameter
    unit, parts = UNITS[parameter], stable_ranges(diagram)
    shared = [part for part in parts if min(part.end, high) > max(part.start, low)]
    if not shared:
        return Judgement(0.0, "nowhere", None, False, "there is no stable 1:1 motion in the range")
    best = max(shared, key=lambda part: min(part.end, high) - max(part.start, low))
    sides = list(_beyond(diagram, best, low, high))
    margins = [margin for margin, _, _ in sides if margin is not None]
    broken = [f"stable motion ends at {where:.9g} {unit} ({kind})" for _, where, kind in sides if kind]
    text = ", ".join(f"{part.start:.{DIGITS}g} to {part.end:.{DIGITS}g} {unit}" for part in shared)
    share = sum(min(part.end, high) - max(part.start, low) for part in shared)
    why = "; ".join(broken) if broken else "" if margins else "stable motion ends nowhere in the range looked at"
    return Judgement(share, f"stable from {text}", min(margins, default=None), not broken, why)


def _beyond(
    diagram: BifurcationDiagram, part: StableInterval, low: float, high: float
) -> Iterator[tuple[float | None, float, str]]:
    """For either end of a stable range: how far it is outside of `low` to `high`, where it is, what is in the way.

    At the end of what was swept nothing ends that is known of: there is no distance, and nothing in the way.
    """
    unit = UNITS[diagram.sweep.parameter]
    swept = diagram.sweep.start, diagram.sweep.end
    for (value, point), beyond in zip(part.ends, (low - part.start, part.end - high), strict=True):
        if point is not None:
            bound = point.point.error_bound
            yield beyond, value, "" if beyond > bound else f"{point.kind.words}, known to within {bound:.1g} {unit}"
        elif value in swept and beyond >= 0:
            yield None, value, ""
        else:
            yield beyond, value, "" if beyond > ROUNDING * abs(value) else "end of what is known"


def _margins(solution: Solution, asked: Requirements, line_of: LineOf) -> Iterator[Criterion]:
    reach = max(getattr(asked, key) or 0.0 for key in MARGINS) / 100

    @cache
    def near() -> Endings:
        _stable(solution)
        return endings(solution.device, solution.diagram, reach)

    for key, (title, kinds) in _MARGIN_KINDS.items():
        limit = getattr(asked, key)
        if limit is not None:
            judge = partial(_margin, near, kinds, limit)
            yield criterion(line_of, (key,), title, (f"at least {limit:.12g} %", limit, "%"), judge)


_MARGIN_KINDS = {
    "margin_period_doubling_percent": ("Margin to period doubling", (CriticalKind.PERIOD_DOUBLING,)),
    "margin_grazing_percent": ("Margin to grazing", (CriticalKind.GRAZING,)),
    "margin_any_percent": ("Margin to the end of stable motion", tuple(CriticalKind)),
}


def _margin(near: Callable[[], Endings], kinds: tuple[CriticalKind, ...], limit: float) -> Judgement:
    """Distance of the nearest ending of some kinds; none is met, for what was looked at goes beyond the limit."""
    around = near()
    nearest = next((ending for ending in around.found if ending.kind in kinds), None)
    if nearest is None:
        ranges = "; ".join(f"{name} from {low:.6g} to {high:.6g}" for name, low, high in around.ranges)
        return Judgement(None, "none in the range looked at", None, True, f"looked at: {ranges}")
    label = f" {nearest.label}" if nearest.label else ""
    why = f"{nearest.kind.words}{label} at {nearest.parameter} = {nearest.value:.9g}"
    return held(100 * nearest.relative, limit, "%", True, why, 100 * nearest.bound)


def _stable(solution: Solution) -> NDArray[np.bool_]:
    """Which motions at the design point are stable; some are."""
    if solution.design is None or not solution.design.motions.stable.any():
        raise NumericalError("there is no stable 1:1 motion at the design point")
    return solution.design.motions.stable


def _voltages(solution: Solution, asked: Requirements, line_of: LineOf) -> Iterator[Criterion]:
    volts = solution.design.voltages if solution.design is not None else None

    def at_design(pick: Callable[[Voltages], Floats], limit: float, unit: str, least: bool, of: Names) -> Judgement:
        stable, bounds = _stable(solution), cast(dict[str, Floats], solution.bounds.design)
        values = pick(cast(Voltages, volts))[stable]
        which = f"the {'least' if least else 'largest'} of {len(values)} stable motions" if len(values) > 1 else ""
        bound = sum(float(bounds[name][stable].max()) for name in of)
        return held(float(values.min() if least else values.max()), limit, unit, least, which, bound)

    limit = asked.u_ave_at_least_v
    if limit is not None:
        judge = partial(at_design, lambda x: x.average_v, limit, "V", True, ("average_v",))
        yield criterion(line_of, ("u_ave_at_least_v",), "U_ave", (f"at least {limit:.12g} V", limit, "V"), judge)
    limit = asked.u_ave_difference_at_most_v
    if limit is not None:
        judge = partial(_spread, solution, asked, limit)
        key, title = "u_ave_difference_at_most_v", "Difference of U_ave over the stable range"
        yield criterion(line_of, (key,), title, (f"at most {limit:.12g} V", limit, "V"), judge)
    limit = asked.u_bottom_top_difference_at_most_v
    if limit is not None:
        judge = partial(at_design, lambda x: np.abs(x.bottom_v - x.top_v), limit, "V", False, ("bottom_v", "top_v"))
        key, title = "u_bottom_top_difference_at_most_v", "Difference of voltage between the ends"
        yield criterion(line_of, (key,), title, (f"at most {limit:.12g} V", limit, "V"), judge)
    limit = asked.deflection_at_most_m
    if limit is not None:
        judge = partial(at_design, lambda x: x.deflection_m, limit, "m", False, ("deflection_m",))
        key = "deflection_at_most_m"
        yield criterion(line_of, (key,), "Deflection", (f"at most {limit:.12g} m", limit, "m"), judge)


def _spread(solution: Solution, asked: Requirements, limit: float) -> Judgement:
    """Largest less least U_ave of the stable motions over the range that is required, or over all stable ranges."""
    diagram = cast(BifurcationDiagram, solution.diagram)
    low, high, found = -np.inf, np.inf, [np.empty(0)]
    if asked.stable_from is not None and asked.stable_to is not None:
        low, high = sorted((asked.stable_from, asked.stable_to))
        if not _covered(diagram, (low, high)).passed:
            raise NumericalError("there is no stable 1:1 motion over all of the range that is required")
        found += [_u_ave_at(solution, value) for value in (low, high)]
    bound = 0.0
    for branch, bounds in zip(diagram.branches, solution.bounds.branches, strict=True):
        volts = cast(Voltages, branch.voltages)
        for first, last in branch.stable_runs():
            rows = slice(first, last + 1)
            value, u_ave = with_peaks(branch.motions.sweep_value[rows], volts.average_v[rows])
            found.append(u_ave[(value >= low) & (value <= high)])
            # A summit between samples is off by less than it stands above them.
            summit = max(
                float(u_ave.max() - volts.average_v[rows].max()), float(volts.average_v[rows].min() - u_ave.min())
            )
            bound = max(bound, summit + float(bounds["average_v"][rows].max()))
    all_of_them = np.concatenate(found)
    if not all_of_them.size:
        raise NumericalError("there is no stable 1:1 motion in the sweep")
    least, most = float(all_of_them.min()), float(all_of_them.max())
    return held(most - least, limit, "V", False, f"U_ave from {least:.6g} to {most:.6g} V", 2 * bound)


def _u_ave_at(solution: Solution, value: float) -> Floats:
    """U_ave of the stable motions at a value of the swept parameter."""
    given: dict[str, Any] = {solution.parameter: value}
    device = replace(solution.device, **given)
    motions = design_point(device, solution.diagram).motions
    velocities = impact_velocities(device, solution.parameter, motions)
    found = voltages(*velocities, cast(Membrane, solution.membrane))
    return found.average_v[motions.stable]


def with_peaks(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Add to the samples of a smooth curve the summits of the parabolas through three of them, where they have one."""
    moved = np.concatenate([[True], np.diff(x) != 0])
    x, y = x[moved], y[moved]
    if len(x) < 3:
        return x, y
    step, slope = np.diff(x), np.diff(y) / np.diff(x)
    top = np.nonzero(np.sign(slope[1:]) * np.sign(slope[:-1]) < 0)[0]
    before, after = step[top], step[top + 1]
    tangent = (slope[top] * after + slope[top + 1] * before) / (before + after)
    curvature = 2 * (slope[top + 1] - slope[top]) / (before + after)
    middle_x, middle_y = x[top + 1], y[top + 1]
    return (
        np.concatenate([x, middle_x - tangent / curvature]),
        np.concatenate([y, middle_y - tangent * tangent / (2 * curvature)]),
    )


def _crosscheck(check: CrossCheck | None, asked: Requirements, line_of: LineOf) -> Iterator[Criterion]:
    if not asked.crosscheck_passed or check is None:
        return

    def judge() -> Judgement:
        difference = max(check.velocity_difference, check.phase_difference)
        again = f"{check.orbits - len(check.misses)} of {check.orbits} stable orbits found again"
        if not check.orbits:
            return Judgement(None, again, None, False, "there was no stable orbit to compare")
        text = f"largest difference {difference:.2g}"
        return Judgement(difference, text, check.tolerance - difference, check.passed, again)

    limit = f"every stable orbit found again to {check.tolerance:.12g}"
    yield criterion(line_of, ("crosscheck_passed",), "Simulation agrees", (limit, check.tolerance, ""), judge)
