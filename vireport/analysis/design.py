"""Every motion at one design point, and how far it is from where the motions change."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.branches import Branch, CriticalPoint
from vireport.analysis.critical import polish, value_condition
from vireport.analysis.diagram import BifurcationDiagram, solve
from vireport.analysis.kinds import CriticalKind, Family
from vireport.analysis.motions import Motions, motions_of
from vireport.analysis.orbits import orbits
from vireport.analysis.pointwise import find_motions
from vireport.analysis.sweep import Sweep
from vireport.errors import NumericalError
from vireport.physics import Device, Voltages
from vireport.scenario import Parameter

Floats = NDArray[np.float64]

REACH = 4.0
"""Factor up and down over which margins are looked for where no sweep says how far."""

OF_ONE_MOTION = (CriticalKind.PERIOD_DOUBLING, CriticalKind.FOLD, CriticalKind.GRAZING)
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
    point : CriticalPoint
        Its label is only unique within one parameter.
    distance : float
        Its swept value less the design value.
    relative : float or None
        The distance over the design value; None where that is zero, or next to it.
    ends_stability : bool
        Whether the stable range that holds the design point, or a stable motion of the design point, ends here.
    error_bound : float
        Of the swept value, and with the rounding of the difference of `distance`.
    """

    parameter: Parameter
    point: CriticalPoint
    distance: float
    relative: float | None
    ends_stability: bool
    error_bound: float

    @property
    def kind(self) -> CriticalKind:
        """Of the critical point."""
        return self.point.kind

    @property
    def label(self) -> str:
        """Of the critical point."""
        return self.point.label

    @property
    def sweep_value(self) -> float:
        """Where the critical point is, in the parameter's unit."""
        return self.point.point.sweep_value


@dataclass(frozen=True, slots=True)
class StableInterval:
    """Range of a parameter over which stable 1:1 motion is known to exist, and what ends it on either side.

    Attributes
    ----------
    parameter : str
    start, end : float
    start_point, end_point : CriticalPoint or None
        None where it is the sweep that ends.
    """

    parameter: Parameter
    start: float
    end: float
    start_point: CriticalPoint | None
    end_point: CriticalPoint | None

    @property
    def ends(self) -> tuple[tuple[float, CriticalPoint | None], tuple[float, CriticalPoint | None]]:
        """Both ends, each with the critical point there."""
        return (self.start, self.start_point), (self.end, self.end_point)


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
    families : tuple of Family
        Of each motion.
    errors : tuple of ndarray
        Error bounds of q - 1/2 and of the phase of each motion.
    margins : tuple of Margin
        Nearest first.
    stable : tuple of StableInterval
        For each parameter varied, the stable range that holds the design point, where there is one.
    voltages : Voltages or None
        Of the motions; None where no energy is evaluated.
    """

    parameter: Parameter
    value: float
    motions: Motions
    families: tuple[Family, ...]
    errors: tuple[Floats, Floats]
    margins: tuple[Margin, ...]
    stable: tuple[StableInterval, ...]
    voltages: Voltages | None = None


def stable_ranges(diagram: BifurcationDiagram) -> tuple[StableInterval, ...]:
    """Ranges of the swept parameter in which there is stable admissible 1:1 motion, ascending and disjoint."""
    found = []
    for branch in diagram.branches:
        for part in branch.segments():
            if part.stable:
                found.append(sorted((_end(branch, row) for row in (part.first, part.last)), key=_place))
    merged: list[list[End]] = []
    for start, end in sorted(found, key=lambda ends: (_place(ends[0]), _place(ends[1]))):
        if merged and start[0] <= merged[-1][1][0] * (1 + 1e-12):
            if end[0] > merged[-1][1][0]:
                merged[-1][1] = end
        else:
            merged.append([start, end])
    return tuple(StableInterval(diagram.sweep.parameter, a[0], b[0], a[1], b[1]) for a, b in merged)


End = tuple[float, CriticalPoint | None]
"""A swept value at which something ends, and the critical point there."""


def _end(branch: Branch, row: int) -> End:
    return float(branch.motions.sweep_value[row]), branch.critical_point(row)


def _place(end: End) -> tuple[float, str]:
    value, point = end
    return value, point.label if point is not None else "end of the sweep"


def ending_points(diagram: BifurcationDiagram, value: float) -> tuple[CriticalPoint, ...] | None:
    """What ends the stable range that holds a value, or one of the stable motions in it.

    Returns
    -------
    tuple of CriticalPoint, or None
        In the order of the diagram; None where there is no such range.
    """
    holding = [part for part in stable_ranges(diagram) if part.start <= value <= part.end]
    if not holding:
        return None
    found = {point for part in holding for _, point in part.ends}
    for branch in diagram.branches:
        for rows in stable_runs(branch):
            low, high = sorted((_end(branch, row) for row in rows), key=_place)
            if low[0] <= value <= high[0]:
                found |= {point for _, point in (low, high) if point is not None and point.kind in OF_ONE_MOTION}
    return tuple(point for point in diagram.critical_points if point in found)


def stable_runs(branch: Branch) -> list[tuple[int, int]]:
    """First and last rows of the stretches of a branch over which it is stable without a break."""
    runs: list[tuple[int, int]] = []
    for part in branch.segments():
        if part.stable and runs and runs[-1][1] == part.first:
            runs[-1] = (runs[-1][0], part.last)
        elif part.stable:
            runs.append((part.first, part.last))
    return runs


def design_point(device: Device, diagram: BifurcationDiagram | None) -> DesignPoint:
    """Find every motion at a design point.

    Parameters
    ----------
    device : Device
        All four parameters given.
    diagram : BifurcationDiagram or None
        Of a sweep through it, for the margins. Where nothing is swept, each parameter is varied on its own.
    """
    chosen = diagram.sweep.parameter if diagram is not None else Parameter.LENGTH
    value = cast(float, getattr(device, chosen))
    motions, families, errors = _motions_at(device, value)
    diagrams = [diagram] if diagram is not None else [solve(sweep) for sweep in _neighbourhood(device)]
    margins, stable = [], []
    for around in diagrams:
        at = cast(float, getattr(device, around.sweep.parameter))
        ends = ending_points(around, at) or ()
        margins += [_margin(device, around.sweep.parameter, point, point in ends) for point in around.critical_points]
        stable += [part for part in stable_ranges(around) if part.start <= at <= part.end]
    margins.sort(key=lambda margin: abs(margin.relative if margin.relative is not None else np.inf))
    return DesignPoint(chosen, value, motions, families, errors, tuple(margins), tuple(stable))


def _margin(device: Device, parameter: Parameter, point: CriticalPoint, ends_stability: bool) -> Margin:
    value = cast(float, getattr(device, parameter))
    distance = point.point.sweep_value - value
    relative = distance / value if abs(distance) < LARGEST_SHARE * value else None
    error = point.point.error_bound + float(np.spacing(abs(distance)))
    return Margin(parameter, point, distance, relative, ends_stability, error)


def _neighbourhood(device: Device) -> list[Sweep]:
    """A sweep around the design point for each parameter."""
    found = []
    for parameter in Parameter:
        value = cast(float, getattr(device, parameter))
        start, end = (0.0, 90.0) if parameter is Parameter.INCLINATION else (value / REACH, value * REACH)
        found.append(Sweep(device, parameter, start, end))
    return [sweep for sweep in found if not sweep.unresolved]


def _motions_at(device: Device, value: float) -> tuple[Motions, tuple[Family, ...], tuple[Floats, Floats]]:
    """All motions at a design point, their families, and the errors of u and of the phase."""
    length = cast(float, device.length_m)
    sweep = Sweep(device, Parameter.LENGTH, length / 2, length * 2)
    n, level = device.period_ratio, sweep.level
    d, gbar = device.groups(Parameter.LENGTH, length)
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
    families = tuple(Family.SYMMETRIC if found[i][0] else Family.ASYMMETRIC for i in order)
    return _reorder(motions, order), families, (error_u[order], error_phi[order])


def _reorder(motions: Motions, order: np.ndarray) -> Motions:
    names = [name for name in Motions.__slots__ if name != "restitution"]
    return replace(motions, **{name: getattr(motions, name)[order] for name in names})
