"""Every motion at one design point, and how far it is from where the motions change."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from vireport.admissibility import wall_gap
from vireport.branches import CriticalPoint
from vireport.critical import polish, value_condition
from vireport.errors import NumericalError
from vireport.model import PARAMETERS, Device, Parameter, Sweep
from vireport.motions import Motions, motions_of
from vireport.orbits import orbits
from vireport.solution import Solution, solve
from vireport.strands import bisect
from vireport.tracing import Curve, Samples, curve_of, sample, select

COARSE = 30.0
"""How much coarser than for drawing the curve is sampled where only its crossings of the design point are wanted."""

REACH = 4.0
"""Factor up and down over which margins are looked for where no sweep says how far."""


WRONG = 1e-6
"""Impact velocity of the wrong sign beyond which a guess is not worth polishing."""


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
        The distance over the design value; None where that is zero.
    ends_stability : bool
        Whether the stable range that holds the design point ends here.
    """

    parameter: Parameter
    label: str
    kind: str
    family: str
    sweep_value: float
    distance: float
    relative: float | None
    ends_stability: bool


@dataclass(frozen=True, slots=True)
class StableInterval:
    """Range of a parameter over which stable 1:1 motion is known to exist, and what ends it on either side."""

    parameter: Parameter
    start: float
    end: float
    start_reason: str
    end_reason: str


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
    margins : tuple of Margin
        Nearest first.
    stable : tuple of StableInterval
        For each parameter varied, the stable range that holds the design point, where there is one.
    """

    parameter: Parameter
    value: float
    motions: Motions
    families: tuple[str, ...]
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
    return tuple(StableInterval(parameter, a[0], b[0], a[1], b[1]) for a, b in merged)


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
    motions, families = _motions_at(device, value, solution)
    solutions = [solution] if solution is not None else [solve(s) for s in _neighbourhood(device)]
    margins, stable = [], []
    for s in solutions:
        at = cast(float, getattr(device, s.curve.sweep.parameter))
        holding = [part for part in stable_ranges(s) if part.start <= at <= part.end]
        ends = {label for part in holding for label in (part.start_reason, part.end_reason)}
        margins += [_margin(device, s.curve.sweep.parameter, point, point.label in ends) for point in s.critical_points]
        stable += holding
    margins.sort(key=lambda margin: abs(margin.relative if margin.relative is not None else np.inf))
    return DesignPoint(chosen, value, motions, families, tuple(margins), tuple(stable))


def _margin(device: Device, parameter: Parameter, point: CriticalPoint, ends_stability: bool) -> Margin:
    value = cast(float, getattr(device, parameter))
    distance = point.point.sweep_value - value
    relative = distance / value if value else None
    return Margin(
        parameter, point.label, point.kind, point.family, point.point.sweep_value, distance, relative, ends_stability
    )


def _neighbourhood(device: Device) -> list[Sweep]:
    """A sweep around the design point for each parameter."""
    found = []
    for parameter in PARAMETERS:
        value = cast(float, getattr(device, parameter))
        start, end = (0.0, 90.0) if parameter == "inclination_deg" else (value / REACH, value * REACH)
        found.append(Sweep(device, parameter, start, end))
    return found


def _motions_at(device: Device, value: float, solution: Solution | None) -> tuple[Motions, tuple[str, ...]]:
    """All motions at a design point: where the level curve of its gbar crosses its d."""
    length = cast(float, device.length_m)
    sweep = Sweep(device, "length_m", length / 2, length * 2)
    target = float(sweep.coordinate_of(length))
    curve, samples = _curve_around(sweep, target, solution)
    distance = samples.drawn[:, 0] - (target - curve.bounds[0]) / (curve.bounds[1] - curve.bounds[0])
    crossing = np.nonzero(((distance[1:] > 0) != (distance[:-1] > 0)) & (samples.which[1:] == samples.which[:-1]))[0]
    which = samples.which[crossing]
    root = bisect(lambda w: np.asarray(curve.at(which, w).d - target), samples.w[crossing], samples.w[crossing + 1])
    guess = curve.at(which, root)
    found = []
    for i, (k, u, phi) in enumerate(zip(which, guess.u, guess.phi, strict=True)):
        if guess.velocity_bottom[i] < -WRONG or guess.velocity_top[i] > WRONG:
            continue
        symmetric = curve.strands[k].symmetric
        try:
            point = polish(sweep, float(u), float(phi), value_condition(sweep, length), symmetric=symmetric)
        except NumericalError:
            if wall_gap(select(guess, slice(i, i + 1)), curve.r, curve.n)[0] > 0:
                raise
            continue  # a solution that passes through a membrane, next to q = 0 or 1 where the equations degenerate
        if point.velocity_bottom > 0 > point.velocity_top:
            found.append((symmetric, point))
    u, phi = (np.array([getattr(p, name) for _, p in found], dtype=float) for name in ("u", "phi"))
    motions = motions_of(sweep, curve.level, orbits(u, phi, curve.r, curve.n))
    motions.sweep_value[:] = value
    motions.d[:] = target
    order = np.lexsort((-motions.velocity_bottom, ~motions.stable))
    families = tuple("symmetric" if found[i][0] else "asymmetric" for i in order)
    return _reorder(motions, order), families


def _curve_around(sweep: Sweep, target: float, solution: Solution | None) -> tuple[Curve, Samples]:
    """The level curve of a gbar, sampled around one d; the sweep's own where it serves."""
    if solution is not None and solution.curve.level.kind == "gbar" and solution.curve.level.value == sweep.level.value:
        low, high = solution.curve.bounds
        if low <= target <= high:
            return solution.curve, solution.samples
    curve = curve_of(sweep)
    return curve, sample(curve, COARSE)


def _reorder(motions: Motions, order: np.ndarray) -> Motions:
    names = [name for name in Motions.__slots__ if name != "restitution"]
    return replace(motions, **{name: getattr(motions, name)[order] for name in names})
