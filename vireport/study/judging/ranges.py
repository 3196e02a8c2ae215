"""Requirements over a range of an input: stable motion throughout, and how much U_ave changes along it.

A run follows the motions along the range and locates the ends of stability; for many designs at once only some values
are tried, which refutes most of those that fail.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

import numpy as np
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.point import StableInterval, motions_at, stable_ranges
from vireport.design.solution import Solution
from vireport.motions.diagram import BifurcationDiagram, solve
from vireport.motions.one_to_one import impact_velocities
from vireport.motions.sweep import Sweep
from vireport.physics.energy import Membrane, Voltages, voltages
from vireport.scenario.blocks import RequirementsBlock
from vireport.scenario.demands import LimitKind
from vireport.scenario.parameters import Parameter
from vireport.study.judging.designs import Designs, at_each_value, may_be_stable, steps_between
from vireport.study.judging.evidence import Evidence, Judgement, Limit, held_against
from vireport.text.formatting import apart, span
from vireport.text.patterns import Phrase
from vireport.text.requirements import Remark

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

ROUNDING = 1e-12
"""Relative error up to which the end of a stable range is taken to be known where no error bound is stated."""

SURE = 1 + 1e-6
"""Factor on a limit of a difference beyond which it surely is exceeded: next to a fold half the digits are left."""


def unit_of_swept(parameter: Parameter) -> str:
    """The unit of a swept parameter as limits have it."""
    return "deg" if parameter is Parameter.INCLINATION else parameter.unit


def _swept(results: Evidence) -> BifurcationDiagram:
    if results.solution.diagram is None:
        raise NumericalError(Remark.NO_SWEEP.said())
    return results.solution.diagram


def stable_over_range(results: Evidence, limit: Limit) -> Judgement:
    """Whether motion is stable over a range of the swept parameter."""
    return _covered(_swept(results), limit)


def may_be_stable_over_range(designs: Designs, limit: Limit) -> Mask:
    """Whether designs may have stable motion over a range of the swept parameter."""
    low, high = limit.numbers
    return may_be_stable(designs, designs.scenario.parameter, low, high)


def may_be_stable_over_inclinations(designs: Designs, limit: Limit) -> Mask:
    """Whether designs may have stable motion over a range of inclination."""
    low, high = limit.numbers
    return may_be_stable(designs, Parameter.INCLINATION, low, high)


def stable_over_inclinations(results: Evidence, limit: Limit) -> Judgement:
    """Whether motion is stable over a range of inclination.

    Judged by the scenario's sweep if that covers the range of inclination, else by a separate one.
    """
    diagram, (low, high) = results.solution.diagram, limit.numbers
    if diagram is not None and diagram.sweep.parameter is Parameter.INCLINATION:
        start, end = sorted((diagram.sweep.start, diagram.sweep.end))
        if start <= low and high <= end:
            return _covered(diagram, limit)
    return _covered(solve(Sweep(results.solution.device, Parameter.INCLINATION, 0.0, 90.0)), limit)


def _covered(diagram: BifurcationDiagram, limit: Limit) -> Judgement:
    """Whether one stable range holds a range of the parameter, and ends outside of it for certain."""
    (low, high), unit = limit.numbers, limit.unit
    shared = [part for part in stable_ranges(diagram) if min(part.end, high) > max(part.start, low)]
    if not shared:
        return Judgement(0.0, Remark.STABLE_NOWHERE.said(), None, False, Remark.NOT_IN_RANGE.said())
    widest = max(shared, key=lambda part: min(part.end, high) - max(part.start, low))
    sides = list(_beyond(diagram, widest, low, high))
    margins = [margin for margin, _, _ in sides if margin is not None]
    broken = [
        Remark.ENDS_AT.said(value=apart((end, low, high))[0], unit=unit, event=event)
        for _, end, event in sides
        if event is not None
    ]
    ranges = ", ".join(f"{span(part.start, part.end)} {unit}" for part in shared)
    width = sum(min(part.end, high) - max(part.start, low) for part in shared)
    nowhere = "" if margins else Remark.ENDS_NOWHERE.said()
    why = Remark.TOGETHER.said(remarks=broken) if broken else nowhere
    return Judgement(width, Remark.RANGES.said(ranges=ranges), min(margins, default=None), not broken, why)


def _beyond(
    diagram: BifurcationDiagram, part: StableInterval, low: float, high: float
) -> Iterator[tuple[float | None, float, Phrase | None]]:
    """For each end of a stable range: how far it is outside of `low` to `high`, its value, and why it falls short.

    Where the range reaches the end of the sweep, its true end is not known: the distance is None.
    """
    swept = diagram.sweep.start, diagram.sweep.end
    for (value, point), beyond in zip(part.ends, (low - part.start, part.end - high), strict=True):
        if point is not None:
            bound = point.error_bound
            unit = unit_of_swept(diagram.sweep.parameter)
            event = Remark.EVENT.said(event=point.event.words, error=bound, unit=unit)
            yield beyond, value, None if beyond > bound else event
        elif value in swept and beyond >= 0:
            yield None, value, None
        else:
            yield beyond, value, None if beyond > ROUNDING * abs(value) else Remark.END_OF_KNOWN.said()


def u_ave_difference(results: Evidence, limit: Limit) -> Judgement:
    """Largest less least U_ave of the stable motions over the range that is required, or over all stable ranges."""
    solution, required, diagram = results.solution, results.required, _swept(results)
    low, high, samples = -np.inf, np.inf, [np.empty(0)]
    if (ends := _range(required)) is not None:
        low, high = ends
        if not _covered(diagram, Limit(LimitKind.RANGE, (low, high), "")).passed:
            raise NumericalError(Remark.NOT_OVER_RANGE.said())
        samples += [_u_ave_at(solution, value) for value in (low, high)]
    bound = 0.0
    for branch, bounds in zip(diagram.branches, solution.bounds.branches, strict=True):
        volts = cast(Voltages, branch.voltages_by_motion)
        for first, last in branch.family.stable_runs:
            rows = slice(first, last + 1)
            sampled = volts.average_v[rows]
            value, u_ave = with_peaks(branch.motions.sweep_value[rows], sampled)
            samples.append(u_ave[(value >= low) & (value <= high)])
            # The error of an extremum between samples is less than its height above them.
            summit = max(float(u_ave.max() - sampled.max()), float(sampled.min() - u_ave.min()))
            bound = max(bound, summit + float(bounds["average_v"][rows].max()))
    u_ave = np.concatenate(samples)
    if not u_ave.size:
        raise NumericalError(Remark.NOT_IN_SWEEP.said())
    least, most = float(u_ave.min()), float(u_ave.max())
    return held_against(most - least, limit, Remark.U_AVE.said(range=span(least, most)), 2 * bound)


def _range(required: RequirementsBlock | None) -> tuple[float, float] | None:
    """The range of the swept parameter over which there must be stable motion, ascending."""
    if required is None or required.stable_from is None or required.stable_to is None:
        return None
    return min(required.stable_from, required.stable_to), max(required.stable_from, required.stable_to)


def may_change_little(designs: Designs, limit: Limit) -> Mask:
    """Whether U_ave of designs may differ by no more over the range that is required, or else over the sweep."""
    required, sweep = designs.scenario.requirements, designs.scenario.sweep
    if required is None or sweep is None:
        return np.ones(designs.count, dtype=bool)
    ends = _range(required) or (sweep.from_, sweep.to)
    least, most = np.full(designs.count, np.inf), np.full(designs.count, -np.inf)
    for values in steps_between(*sorted(ends)):
        rows = np.flatnonzero(~(most - least > SURE * limit.value))
        at = at_each_value(designs.select(rows), sweep.parameter, values)
        of_motion = np.tile(rows, len(values))[at.cell]
        np.minimum.at(least, of_motion, at.impacts.average_v)
        np.maximum.at(most, of_motion, at.impacts.average_v)
    return np.asarray(~(most - least > SURE * limit.value))


def _u_ave_at(solution: Solution, value: float) -> Floats:
    """U_ave of the stable motions at a value of the swept parameter."""
    device = solution.device.with_values({solution.parameter: value})
    motions, _, _ = motions_at(device, solution.parameter)
    velocities = impact_velocities(device, solution.parameter, motions)
    return voltages(*velocities, cast(Membrane, solution.membrane)).average_v[motions.stable_mask]


def with_peaks(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Add to samples of a smooth curve the extrema of parabolas through three neighbours, where these have one."""
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
