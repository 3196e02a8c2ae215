"""Every motion at one design point, how far it is from where the motions change, and where stable motion ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.branches import Branch, CriticalPoint
from vireport.analysis.critical import polish, value_condition
from vireport.analysis.diagram import SAME_POINT, BifurcationDiagram, solve
from vireport.analysis.kinds import CriticalKind, Family
from vireport.analysis.motions import Motions, motions_of
from vireport.analysis.orbits import orbits
from vireport.analysis.pointwise import find_motions
from vireport.analysis.sweep import Sweep
from vireport.errors import NumericalError
from vireport.physics import Device, Voltages
from vireport.scenario import WIDEST_MARGIN, Parameter

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

ADJOINING = 1e-12
"""Relative gap between two stable ranges that is rounding."""


@dataclass(frozen=True, slots=True)
class Margin:
    """Distance from the design point to a critical point, when one parameter varies.

    Attributes
    ----------
    parameter : Parameter
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
    parameter : Parameter
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

    def holds(self, value: float) -> bool:
        """Whether a value of the parameter is in the range."""
        return self.start <= value <= self.end


@dataclass(frozen=True, slots=True, eq=False)
class DesignPoint:
    """The design point and all 1:1 motions there, admissible or not.

    Attributes
    ----------
    parameter : Parameter
        The swept one, or the length where nothing is swept.
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
        parameter = around.sweep.parameter
        at = cast(float, getattr(device, parameter))
        ends = ending_points(around, at) or ()
        margins += [_margin(parameter, at, point, point in ends) for point in around.critical_points]
        stable += [part for part in stable_ranges(around) if part.holds(at)]
    margins.sort(key=lambda margin: abs(margin.relative if margin.relative is not None else np.inf))
    return DesignPoint(chosen, value, motions, families, errors, tuple(margins), tuple(stable))


def _margin(parameter: Parameter, value: float, point: CriticalPoint, ends_stability: bool) -> Margin:
    distance = point.point.sweep_value - value
    relative = distance / value if abs(distance) < LARGEST_SHARE * value else None
    error = point.point.error_bound + float(np.spacing(abs(distance)))
    return Margin(parameter, point, distance, relative, ends_stability, error)


def _neighbourhood(device: Device) -> list[Sweep]:
    """A sweep around the design point for each parameter."""
    sweeps = []
    for parameter in Parameter:
        value = cast(float, getattr(device, parameter))
        start, end = (0.0, 90.0) if parameter is Parameter.INCLINATION else (value / REACH, value * REACH)
        sweeps.append(Sweep(device, parameter, start, end))
    return [sweep for sweep in sweeps if not sweep.unresolved]


def around_length(device: Device) -> Sweep:
    """A sweep over the length through a design point, whose motions are on its level."""
    length = cast(float, device.length_m)
    return Sweep(device, Parameter.LENGTH, length / 2, length * 2)


def _motions_at(device: Device, value: float) -> tuple[Motions, tuple[Family, ...], tuple[Floats, Floats]]:
    """All motions at a design point, their families, and the errors of u and of the phase."""
    sweep = around_length(device)
    n, level = device.period_ratio, sweep.level
    d, gbar = device.groups(Parameter.LENGTH, device.length_m)
    guesses = find_motions(np.array([d]), np.array([gbar]), device.restitution, n)
    at_length = value_condition(sweep, device.length_m)
    rows = []
    for u, phi, gap in zip(guesses.orbit.u, guesses.orbit.phi, guesses.wall_gap, strict=True):
        symmetric = level.horizontal and n % 2 == 1 and bool(u == 0)
        try:
            point = polish(sweep, float(u), float(phi), at_length, symmetric=symmetric)
        except NumericalError:
            if gap > 0:  # on a fold, to rounding: two motions in one
                rows.append((symmetric, float(u), float(np.mod(phi, 2 * np.pi)), DOUBLE_ROOT, DOUBLE_ROOT))
            continue  # else a solution that passes through a membrane, where the equations degenerate
        if point.velocity_bottom > 0 > point.velocity_top:
            rows.append((symmetric, point.u, point.phi, point.bounds["u"], point.bounds["phi"]))
    u, phi, error_u, error_phi = (np.array([row[k] for row in rows], dtype=float) for k in range(1, 5))
    motions = motions_of(sweep, level, orbits(u, phi, device.restitution, n))
    motions.sweep_value[:] = value
    motions.d[:] = d
    np.minimum(motions.wall_gap, motions.d, out=motions.wall_gap)
    order = np.lexsort((-motions.velocity_bottom, ~motions.stable))
    families = tuple(Family.SYMMETRIC if rows[i][0] else Family.ASYMMETRIC for i in order)
    return motions.select(order), families, (error_u[order], error_phi[order])


End = tuple[float, CriticalPoint | None]
"""A swept value at which something ends, and the critical point there; None where it is the sweep that ends."""


def _end(branch: Branch, row: int) -> End:
    return float(branch.motions.sweep_value[row]), branch.critical_point(row)


def _ends(branch: Branch, first: int, last: int) -> tuple[End, End]:
    """The ends of a stretch of a branch, in the order of the swept value."""
    low, high = sorted((_end(branch, first), _end(branch, last)), key=_place)
    return low, high


def _place(end: End) -> tuple[float, bool, str]:
    """Where an end is among others; at one value critical points come in the order of their labels, then the sweep."""
    value, point = end
    return value, point is None, point.label if point is not None else ""


def stable_ranges(diagram: BifurcationDiagram) -> tuple[StableInterval, ...]:
    """Ranges of the swept parameter in which there is stable admissible 1:1 motion, ascending and disjoint."""
    stretches = [
        _ends(branch, part.first, part.last) for branch in diagram.branches for part in branch.segments() if part.stable
    ]
    merged: list[tuple[End, End]] = []
    for start, end in sorted(stretches, key=lambda ends: (_place(ends[0]), _place(ends[1]))):
        if merged and start[0] <= merged[-1][1][0] * (1 + ADJOINING):
            if end[0] > merged[-1][1][0]:
                merged[-1] = merged[-1][0], end
        else:
            merged.append((start, end))
    return tuple(StableInterval(diagram.sweep.parameter, a[0], b[0], a[1], b[1]) for a, b in merged)


def ending_points(diagram: BifurcationDiagram, value: float) -> tuple[CriticalPoint, ...] | None:
    """What ends the stable range that holds a value, or one of the stable motions in it.

    Returns
    -------
    tuple of CriticalPoint, or None
        In the order of the diagram; None where there is no such range.
    """
    holding = [part for part in stable_ranges(diagram) if part.holds(value)]
    if not holding:
        return None
    ending = {point for part in holding for _, point in part.ends}
    for branch in diagram.branches:
        for first, last in branch.stable_runs():
            low, high = _ends(branch, first, last)
            if low[0] <= value <= high[0]:
                ending |= {point for _, point in (low, high) if point is not None and point.kind in OF_ONE_MOTION}
    return tuple(point for point in diagram.critical_points if point in ending)


@dataclass(frozen=True, slots=True)
class Ending:
    """A critical point at which a stable motion of the design point ends, when one parameter varies.

    Attributes
    ----------
    parameter : Parameter
    kind : CriticalKind
    label : str
        Of the scenario's own sweep; "" where it lies on another.
    value : float
        Of the parameter, in its unit.
    relative : float
        Distance from the design value, over that value; positive.
    bound : float
        Error bound of `relative`.
    """

    parameter: Parameter
    kind: CriticalKind
    label: str
    value: float
    relative: float
    bound: float


@dataclass(frozen=True, slots=True)
class Endings:
    """The endings around a design point, nearest first, and the ranges of the parameters that were looked at."""

    found: tuple[Ending, ...]
    ranges: tuple[tuple[Parameter, float, float], ...]


def endings(device: Device, diagram: BifurcationDiagram | None, reach: float) -> Endings:
    """Find where the stable motions of a design point end.

    Parameters
    ----------
    device : Device
        All four parameters given, with stable motion there.
    diagram : BifurcationDiagram or None
        Of a sweep: only its parameter is varied. Without one, each parameter is, but for an inclination of zero.
    reach : float
        Share of the design value, up and down, that must be looked at. Where the sweep does not go as far, a wider one
        is solved.

    Raises
    ------
    NumericalError
        If the stable range that holds the design point is not found.
    """
    ends: list[Ending] = []
    ranges = []
    for parameter in tuple(Parameter) if diagram is None else (diagram.sweep.parameter,):
        at = float(getattr(device, parameter))
        if at == 0:
            continue
        if diagram is not None and _reaches(diagram.sweep, at, reach):
            around = diagram
        else:
            around = solve(Sweep(device, parameter, *_range(parameter, at, WIDEST_MARGIN / 100)))
        sweep = around.sweep
        ranges.append((parameter, min(sweep.start, sweep.end), max(sweep.start, sweep.end)))
        points = ending_points(around, at)
        if points is None:
            raise NumericalError(f"no stable range of {parameter} was found around the design point {at:.9g}")
        for point in points:
            value, bound = point.point.sweep_value, point.point.error_bound
            label = _label_in(diagram, point)
            ends.append(Ending(parameter, point.kind, label, value, abs(value - at) / at, bound / at))
    return Endings(tuple(sorted(ends, key=lambda ending: ending.relative - ending.bound)), tuple(ranges))


def _label_in(diagram: BifurcationDiagram | None, point: CriticalPoint) -> str:
    """The label that a critical point has in the scenario's own sweep, "" where it is not in it."""
    value = point.point.sweep_value
    for own in diagram.critical_points if diagram is not None else ():
        if own.kind is point.kind and abs(own.point.sweep_value - value) <= SAME_POINT * abs(value):
            return own.label
    return ""


def _range(parameter: Parameter, at: float, reach: float) -> tuple[float, float]:
    """The range of a parameter around a value, as far as the parameter goes."""
    low, high = at * (1 - reach), at * (1 + reach)
    return (low, min(high, 90.0)) if parameter is Parameter.INCLINATION else (low, high)


def _reaches(sweep: Sweep, at: float, reach: float) -> bool:
    low, high = _range(sweep.parameter, at, reach)
    return bool(min(sweep.start, sweep.end) <= low and high <= max(sweep.start, sweep.end))
