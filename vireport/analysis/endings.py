"""Where stable motion ends around a design point: the critical points that margins are measured to."""

from __future__ import annotations

from dataclasses import dataclass

from vireport.analysis.branches import CriticalPoint
from vireport.analysis.design import ending_points
from vireport.analysis.diagram import SAME_POINT, BifurcationDiagram, solve
from vireport.analysis.kinds import CriticalKind
from vireport.analysis.sweep import Sweep
from vireport.errors import NumericalError
from vireport.physics import Device
from vireport.scenario import WIDEST_MARGIN, Parameter


@dataclass(frozen=True, slots=True)
class Ending:
    """A critical point at which a stable motion of the design point ends, when one parameter varies.

    Attributes
    ----------
    parameter : str
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
    parameters = tuple(Parameter) if diagram is None else (diagram.sweep.parameter,)
    found: list[Ending] = []
    ranges = []
    for parameter in parameters:
        at = float(getattr(device, parameter))
        if at == 0:
            continue
        own = diagram is not None and _reaches(diagram.sweep, at, reach)
        around = diagram if own and diagram else solve(Sweep(device, parameter, *_range(parameter, at)))
        sweep = around.sweep
        ranges.append((parameter, min(sweep.start, sweep.end), max(sweep.start, sweep.end)))
        points = ending_points(around, at)
        if points is None:
            raise NumericalError(f"no stable range of {parameter} was found around the design point {at:.9g}")
        for point in points:
            value, bound = point.point.sweep_value, point.point.error_bound
            label = _label_of(point, diagram)
            found.append(Ending(parameter, point.kind, label, value, abs(value - at) / at, bound / at))
    return Endings(tuple(sorted(found, key=lambda ending: ending.relative - ending.bound)), tuple(ranges))


def _label_of(point: CriticalPoint, diagram: BifurcationDiagram | None) -> str:
    """The label that a critical point has in the scenario's own sweep, "" where it is not in it."""
    value = point.point.sweep_value
    for one in diagram.critical_points if diagram is not None else ():
        if one.kind is point.kind and abs(one.point.sweep_value - value) <= SAME_POINT * abs(value):
            return one.label
    return ""


def _range(parameter: Parameter, at: float, reach: float = WIDEST_MARGIN / 100) -> tuple[float, float]:
    """The range of a parameter around a value, as far as the parameter goes."""
    low, high = at * (1 - reach), at * (1 + reach)
    return (low, min(high, 90.0)) if parameter is Parameter.INCLINATION else (low, high)


def _reaches(sweep: Sweep, at: float, reach: float) -> bool:
    low, high = _range(sweep.parameter, at, reach)
    return bool(min(sweep.start, sweep.end) <= low and high <= max(sweep.start, sweep.end))
