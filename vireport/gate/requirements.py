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

from vireport.analysis.design import OF_ONE_MOTION, StableInterval, design_point, stable_ranges, stable_runs
from vireport.analysis.endings import Endings, endings
from vireport.analysis.motions import impact_velocities
from vireport.analysis.solution import Solution, solve
from vireport.errors import NumericalError
from vireport.gate.criteria import DIGITS, Criterion, Judgement, criterion, held
from vireport.physics.device import Parameter, Sweep
from vireport.physics.energy import Membrane, Voltages, voltages
from vireport.scenario.blocks import Requirements
from vireport.scenario.rules import MARGINS

if TYPE_CHECKING:
    from vireport.study.study import Study

Floats = NDArray[np.float64]
Names = tuple[str, ...]

UNITS: dict[Parameter, str] = {"length_m": "m", "amplitude_n": "N", "frequency_hz": "Hz", "inclination_deg": "deg"}

ROUNDING = 1e-12
"""Relative error up to which the end of a stable range is taken to be known where no error bound is stated."""

KINDS = {"period_doubling": "period doubling", "node_focus": "node to focus"}
"""Kinds of critical points that are written otherwise."""


def assess(study: Study) -> tuple[Criterion, ...]:
    """Hold a study against what its scenario requires; () where that is nothing."""
    asked = study.scenario.requirements
    if asked is None:
        return ()
    found = [*_ranges(study, asked), *_margins(study, asked), *_voltages(study, asked), *_crosscheck(study, asked)]
    if study.crosscheck is None or study.crosscheck.passed:
        return tuple(found)
    doubt = "the simulation does not agree with the solution"
    return tuple(one if not one.passed else replace(one, passed=False, why=doubt) for one in found)


def _ranges(study: Study, asked: Requirements) -> Iterator[Criterion]:
    if asked.stable_from is not None and asked.stable_to is not None and study.solution is not None:
        solution, ends = study.solution, (asked.stable_from, asked.stable_to)
        unit = UNITS[solution.curve.sweep.parameter]
        keys = ("stable_from", "stable_to")
        yield criterion(
            study, keys, "Stable 1:1 motion over the range", _range_limit(ends, unit), lambda: _covered(solution, ends)
        )
    if asked.inclination_from_deg is not None and asked.inclination_to_deg is not None:
        angles = (asked.inclination_from_deg, asked.inclination_to_deg)
        keys = ("inclination_from_deg", "inclination_to_deg")
        yield criterion(
            study,
            keys,
            "Stable 1:1 motion over the inclinations",
            _range_limit(angles, "deg"),
            lambda: _covered(_over_angles(study, angles), angles),
        )


def _range_limit(ends: tuple[float, float], unit: str) -> tuple[str, float, str]:
    low, high = sorted(ends)
    return f"from {low:.12g} to {high:.12g} {unit}", high - low, unit


def _over_angles(study: Study, angles: tuple[float, float]) -> Solution:
    """The motions of the design over a range of inclination: those of the scenario's sweep, if it is one of it."""
    if study.sweep is not None and study.solution is not None and study.sweep.parameter == "inclination_deg":
        given = study.sweep.start, study.sweep.end
        if min(given) <= min(angles) and max(angles) <= max(given):
            return study.solution
    return solve(Sweep(study.device, "inclination_deg", 0.0, 90.0))


def _covered(solution: Solution, ends: tuple[float, float]) -> Judgement:
    """Whether one stable range holds a range of the parameter, and ends outside of it for certain."""
    (low, high), parameter = sorted(ends), solution.curve.sweep.parameter
    unit, parts = UNITS[parameter], stable_ranges(solution)
    shared = [part for part in parts if min(part.end, high) > max(part.start, low)]
    if not shared:
        return Judgement(0.0, "nowhere", None, False, "there is no stable 1:1 motion in the range")
    best = max(shared, key=lambda part: min(part.end, high) - max(part.start, low))
    sides = list(_beyond(solution, best, low, high))
    margins = [margin for margin, _, _ in sides if margin is not None]
    broken = [f"stable motion ends at {where:.9g} {unit} ({kind})" for _, where, kind in sides if kind]
    text = ", ".join(f"{part.start:.{DIGITS}g} to {part.end:.{DIGITS}g} {unit}" for part in shared)
    share = sum(min(part.end, high) - max(part.start, low) for part in shared)
    why = "; ".join(broken) if broken else "" if margins else "stable motion ends nowhere in the range looked at"
    return Judgement(share, f"stable from {text}", min(margins, default=None), not broken, why)


def _beyond(
    solution: Solution, part: StableInterval, low: float, high: float
) -> Iterator[tuple[float | None, float, str]]:
    """For either end of a stable range: how far it is outside of `low` to `high`, where it is, what is in the way.

    At the end of what was swept nothing ends that is known of: there is no distance, and nothing in the way.
    """
    points, unit = {point.label: point for point in solution.critical_points}, UNITS[solution.curve.sweep.parameter]
    swept = solution.curve.sweep.start, solution.curve.sweep.end
    for value, label, beyond in (
        (part.start, part.start_reason, low - part.start),
        (part.end, part.end_reason, part.end - high),
    ):
        if label in points:
            bound, kind = points[label].point.error_bound, KINDS.get(points[label].kind, points[label].kind)
            yield beyond, value, "" if beyond > bound else f"{kind}, known to within {bound:.1g} {unit}"
        elif value in swept and beyond >= 0:
            yield None, value, ""
        else:
            yield beyond, value, "" if beyond > ROUNDING * abs(value) else "end of what is known"


def _margins(study: Study, asked: Requirements) -> Iterator[Criterion]:
    reach = max(getattr(asked, key) or 0.0 for key in MARGINS) / 100

    @cache
    def near() -> Endings:
        _stable(study)
        return endings(study.device, study.solution, reach)

    for key, (title, kinds) in _MARGIN_KINDS.items():
        limit = getattr(asked, key)
        if limit is not None:
            judge = partial(_margin, near, kinds, limit)
            yield criterion(study, (key,), title, (f"at least {limit:.12g} %", limit, "%"), judge)


_MARGIN_KINDS = {
    "margin_period_doubling_percent": ("Margin to period doubling", ("period_doubling",)),
    "margin_grazing_percent": ("Margin to grazing", ("grazing",)),
    "margin_any_percent": ("Margin to the end of stable motion", (*OF_ONE_MOTION, "pitchfork", "node_focus")),
}


def _margin(near: Callable[[], Endings], kinds: tuple[str, ...], limit: float) -> Judgement:
    """Distance of the nearest ending of some kinds; none is met, for what was looked at goes beyond the limit."""
    around = near()
    nearest = next((ending for ending in around.found if ending.kind in kinds), None)
    if nearest is None:
        ranges = "; ".join(f"{name} from {low:.6g} to {high:.6g}" for name, low, high in around.ranges)
        return Judgement(None, "none in the range looked at", None, True, f"looked at: {ranges}")
    label = f" {nearest.label}" if nearest.label else ""
    why = f"{KINDS.get(nearest.kind, nearest.kind)}{label} at {nearest.parameter} = {nearest.value:.9g}"
    return held(100 * nearest.relative, limit, "%", True, why, 100 * nearest.bound)


def _stable(study: Study) -> NDArray[np.bool_]:
    """Which motions at the design point are stable; some are."""
    if study.design is None or not study.design.motions.stable.any():
        raise NumericalError("there is no stable 1:1 motion at the design point")
    return study.design.motions.stable


def _voltages(study: Study, asked: Requirements) -> Iterator[Criterion]:
    volts = study.design_voltages

    def at_design(pick: Callable[[Voltages], Floats], limit: float, unit: str, least: bool, of: Names) -> Judgement:
        stable, bounds = _stable(study), cast(dict[str, Floats], study.bounds.design)
        values = pick(cast(Voltages, volts))[stable]
        which = f"the {'least' if least else 'largest'} of {len(values)} stable motions" if len(values) > 1 else ""
        bound = sum(float(bounds[name][stable].max()) for name in of)
        return held(float(values.min() if least else values.max()), limit, unit, least, which, bound)

    limit = asked.u_ave_at_least_v
    if limit is not None:
        judge = partial(at_design, lambda x: x.average_v, limit, "V", True, ("average_v",))
        yield criterion(study, ("u_ave_at_least_v",), "U_ave", (f"at least {limit:.12g} V", limit, "V"), judge)
    limit = asked.u_ave_difference_at_most_v
    if limit is not None:
        judge = partial(_spread, study, asked, limit)
        key, title = "u_ave_difference_at_most_v", "Difference of U_ave over the stable range"
        yield criterion(study, (key,), title, (f"at most {limit:.12g} V", limit, "V"), judge)
    limit = asked.u_bottom_top_difference_at_most_v
    if limit is not None:
        judge = partial(at_design, lambda x: np.abs(x.bottom_v - x.top_v), limit, "V", False, ("bottom_v", "top_v"))
        key, title = "u_bottom_top_difference_at_most_v", "Difference of voltage between the ends"
        yield criterion(study, (key,), title, (f"at most {limit:.12g} V", limit, "V"), judge)
    limit = asked.deflection_at_most_m
    if limit is not None:
        judge = partial(at_design, lambda x: x.deflection_m, limit, "m", False, ("deflection_m",))
        key = "deflection_at_most_m"
        yield criterion(study, (key,), "Deflection", (f"at most {limit:.12g} m", limit, "m"), judge)


def _spread(study: Study, asked: Requirements, limit: float) -> Judgement:
    """Largest less least U_ave of the stable motions over the range that is required, or over all stable ranges."""
    solution = cast(Solution, study.solution)
    low, high, found = -np.inf, np.inf, [np.empty(0)]
    if asked.stable_from is not None and asked.stable_to is not None:
        low, high = sorted((asked.stable_from, asked.stable_to))
        if not _covered(solution, (low, high)).passed:
            raise NumericalError("there is no stable 1:1 motion over all of the range that is required")
        found += [_u_ave_at(study, value) for value in (low, high)]
    bound = 0.0
    for branch, volts, bounds in zip(solution.branches, study.voltages, study.bounds.branches, strict=True):
        for first, last in stable_runs(branch):
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


def _u_ave_at(study: Study, value: float) -> Floats:
    """U_ave of the stable motions at a value of the swept parameter."""
    sweep = cast(Sweep, study.sweep)
    given: dict[str, Any] = {sweep.parameter: value}
    device = replace(study.device, **given)
    motions = design_point(device, sweep.parameter, study.solution).motions
    mass, membrane = cast(float, study.scenario.device.ball_mass_kg), cast(Membrane, study.membrane)
    found = voltages(*impact_velocities(device, sweep.parameter, motions), mass, membrane)
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


def _crosscheck(study: Study, asked: Requirements) -> Iterator[Criterion]:
    check = study.crosscheck
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
    yield criterion(study, ("crosscheck_passed",), "Simulation agrees", (limit, check.tolerance, ""), judge)
