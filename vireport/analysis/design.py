"""Every motion at one design point, and how far it is from where the motions change."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.branches import Branch, CriticalPoint
from vireport.analysis.critical import polish, value_condition
from vireport.analysis.motions import Motions, motions_of
from vireport.analysis.orbits import orbits
from vireport.analysis.pointwise import find_motions
from vireport.analysis.solution import Solution, solve
from vireport.errors import NumericalError
from vireport.physics.device import PARAMETERS, Device, Parameter, Sweep

Floats = NDArray[np.float64]

REACH = 4.0
"""Factor up and down over which margins are looked for where no sweep says how far."""

OF_ONE_MOTION = ("period_doubling", "fold", "grazing")
"""Kinds at which a stable motion is lost even where another stable motion coexists with it. A pitchfork passes its
stability on, and at a change between node and focus nothing ends."""

LARGEST_SHARE = 1e100
"""Largest relative margin; beyond it the design value is as good as zero."""

DOUBLE_ROOT = 1e-7
"""Error of q and phase of a motion on a fold: the root of rounding, and room."""


@dataclass(frozen=True, slots=True)
class Margin:
    """Distance from the design point to a critical point, when one parameter varies.

    Attributes
    ----------
    parameter : str
    label, kind, family : str
        Of the critical point; the label is only unique within one parameter.
    sweep_value : float
        Where it is, in the parameter's unit.
    distance : float
        `sweep_value` less the design value.
    relative : float or None
        The distance over the design value; None where that is zero, or next to it.
    ends_stability : bool
        Whether the stable range that holds the design point, or a stable motion of the design point, ends here.
    error_bound : float
        Of `sweep_value`, and with the rounding of the difference of `distance`.
    """

    parameter: Parameter
    label: str
    kind: str
    family: str
    sweep_value: float
    distance: float
    relative: float | None
    ends_stability: bool
    error_bound: float


@dataclass(frozen=True, slots=True)
class StableInterval:
    """Range of a parameter over which stable 1:1 motion is known to exist, and what ends it on either side.

    Attributes
    ----------
    parameter : str
    start, end : float
    start_reason, end_reason : str
        Label of a critical point, or ``end of the sweep``.
    start_error, end_error : float
        Error bounds of the ends; the ends of the sweep are exact.
    """

    parameter: Parameter
    start: float
    end: float
    start_reason: str
    end_reason: str
    start_error: float
    end_error: float


@dataclass(frozen=True, slots=True, eq=False)
class DesignPoint:
    """The design point and all 1:1 motions there, admissible or not.

    Attributes
    ----------
    parameter : str
        The swept one, or ``length_m`` where nothing is swept.
    value : float
        Its value at the design point.
    motions : Motions
        Zero or more, stable ones first.
    families : tuple of str
        Of each motion.
    errors : tuple of ndarray
        Error bounds of q - 1/2 and of the phase of each motion.
    margins : tuple of Margin
        Nearest first.
    stable : tuple of StableInterval
        For each parameter varied, the stable range that holds the design point, where there is one.
    """

    parameter: Parameter
    value: float
    motions: Motions
    families: tuple[str, ...]
    errors: tuple[Floats, Floats]
    margins: tuple[Margin, ...]
    stable: tuple[StableInterval, ...]


def stable_ranges(solution: Solution) -> tuple[StableInterval, ...]:
    """Ranges of the swept parameter in which there is stable admissible 1:1 motion, ascending and disjoint."""
    found = []
    for branch in solution.branches:
        value = branch.motions.sweep_value
        for part in branch.segments():
            if part.stable:
                ends = [(float(value[row]), branch.event[row] or "end of the sweep") for row in (part.first, part.last)]
                found.append(sorted(ends))
    merged: list[list[tuple[float, str]]] = []
    for (start, why_start), (end, why_end) in sorted(found):
        if merged and start <= merged[-1][1][0] * (1 + 1e-12):
            if end > merged[-1][1][0]:
                merged[-1][1] = (end, why_end)
        else:
            merged.append([(start, why_start), (end, why_end)])
    parameter = solution.curve.sweep.parameter
    error = {point.label: point.point.error_bound for point in solution.critical_points}
    return tuple(
        StableInterval(parameter, a[0], b[0], a[1], b[1], error.get(a[1], 0.0), error.get(b[1], 0.0)) for a, b in merged
    )


def ending_labels(solution: Solution, value: float) -> set[str]:
    """What ends the stable range that holds a value, or one of the stable motions in it; empty where there is none.

    Labels of critical points, or ``end of the sweep``.
    """
    holding = [part for part in stable_ranges(solution) if part.start <= value <= part.end]
    if not holding:
        return set()
    labels = {reason for part in holding for reason in (part.start_reason, part.end_reason)}
    kinds = {point.label: point.kind for point in solution.critical_points}
    for branch in solution.branches:
        for rows in stable_runs(branch):
            (low, _), (high, _) = ends = sorted(
                (float(branch.motions.sweep_value[row]), branch.event[row]) for row in rows
            )
            if low <= value <= high:
                labels |= {label for _, label in ends if kinds.get(label) in OF_ONE_MOTION}
    return labels


def stable_runs(branch: Branch) -> list[tuple[int, int]]:
    """First and last rows of the stretches of a branch over which it is stable without a break."""
    runs: list[tuple[int, int]] = []
    for part in branch.segments():
        if part.stable and runs and runs[-1][1] == part.first:
            runs[-1] = (runs[-1][0], part.last)
        elif part.stable:
            runs.append((part.first, part.last))
    return runs


def design_point(device: Device, parameter: Parameter | None, solution: Solution | None) -> DesignPoint:
    """Find every motion at a design point.

    Parameters
    ----------
    device : Device
        All four parameters given.
    parameter : str or None
        The one that is swept.
    solution : Solution or None
        Of that sweep, for the margins. Where nothing is swept, each parameter is varied on its own.
    """
    chosen = parameter or "length_m"
    value = cast(float, getattr(device, chosen))
    motions, families, errors = _motions_at(device, value)
    solutions = [solution] if solution is not None else [solve(s) for s in _neighbourhood(device)]
    margins, stable = [], []
    for s in solutions:
        at = cast(float, getattr(device, s.curve.sweep.parameter))
        holding = [part for part in stable_ranges(s) if part.start <= at <= part.end]
        ends = ending_labels(s, at)
        margins += [_margin(device, s.curve.sweep.parameter, point, point.label in ends) for point in s.critical_points]
        stable += holding
    margins.sort(key=lambda margin: abs(margin.relative if margin.relative is not None else np.inf))
    return DesignPoint(chosen, value, motions, families, errors, tuple(margins), tuple(stable))


def _margin(device: Device, parameter: Parameter, point: CriticalPoint, ends_stability: bool) -> Margin:
    value = cast(float, getattr(device, parameter))
    distance = point.point.sweep_value - value
    relative = distance / value if abs(distance) < LARGEST_SHARE * value else None
    where, error = point.point.sweep_value, point.point.error_bound + float(np.spacing(abs(distance)))
    return Margin(parameter, point.label, point.kind, point.family, where, distance, relative, ends_stability, error)


def _neighbourhood(device: Device) -> list[Sweep]:
    """A sweep around the design point for each parameter."""
    found = []
    for parameter in PARAMETERS:
        value = cast(float, getattr(device, parameter))
        start, end = (0.0, 90.0) if parameter == "inclination_deg" else (value / REACH, value * REACH)
        found.append(Sweep(device, parameter, start, end))
    return [sweep for sweep in found if not sweep.unresolved]


def _motions_at(device: Device, value: float) -> tuple[Motions, tuple[str, ...], tuple[Floats, Floats]]:
    """All motions at a design point, their families, and the errors of u and of the phase."""
    length = cast(float, device.length_m)
    sweep = Sweep(device, "length_m", length / 2, length * 2)
    n, level = device.period_ratio, sweep.level
    d, gbar = device.groups("length_m", length)
    guesses = find_motions(np.array([d]), np.array([gbar]), device.restitution, n)
    found = []
    for u, phi, gap in zip(guesses.orbit.u, guesses.orbit.phi, guesses.wall_gap, strict=True):
        symmetric = level.horizontal and n % 2 == 1 and bool(u == 0)
        try:
            point = polish(sweep, float(u), float(phi), value_condition(sweep, length), symmetric=symmetric)
        except NumericalError:
            if gap > 0:  # on a fold, to rounding: two motions in one
                found.append((symmetric, float(u), float(np.mod(phi, 2 * np.pi)), DOUBLE_ROOT, DOUBLE_ROOT))
            continue  # else a solution that passes through a membrane, where the equations degenerate
        if point.velocity_bottom > 0 > point.velocity_top:
            found.append((symmetric, point.u, point.phi, point.bounds["u"], point.bounds["phi"]))
    u, phi, error_u, error_phi = (np.array([one[k] for one in found], dtype=float) for k in range(1, 5))
    motions = motions_of(sweep, level, orbits(u, phi, device.restitution, n))
    motions.sweep_value[:] = value
    motions.d[:] = d
    np.minimum(motions.wall_gap, motions.d, out=motions.wall_gap)
    order = np.lexsort((-motions.velocity_bottom, ~motions.stable))
    families = tuple("symmetric" if found[i][0] else "asymmetric" for i in order)
    return _reorder(motions, order), families, (error_u[order], error_phi[order])


def _reorder(motions: Motions, order: np.ndarray) -> Motions:
    names = [name for name in Motions.__slots__ if name != "restitution"]
    return replace(motions, **{name: getattr(motions, name)[order] for name in names})
