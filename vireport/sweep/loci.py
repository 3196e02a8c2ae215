"""Curves in the plane of two parameters along which motions change: where they double, meet or graze.

Each point of a curve is a critical point of a sweep, exact; the points of neighbouring sweeps are joined where they are
plainly the same motion. Where that is not plain the sweeps are taken closer together, and at last a gap is left: better
than a false line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import CriticalKind, CriticalPoint, Sweep, solve
from vireport.errors import NumericalError
from vireport.physics import Device
from vireport.scenario import Axis, Parameter
from vireport.sweep.cells import MapPlan

Floats = NDArray[np.float64]
Point = tuple[float, float, float, float]
"""Place along the sweep (as a share of it), u, sine and cosine of the phase."""

Column = dict[str, list[Point]]
"""Critical points of a sweep, by kind."""

SWEEPS = 161
"""Sweeps across the map at first."""

HALVINGS = 6
"""Times that two sweeps are taken closer together where a point of one is missing in the other."""

FARTHEST = 0.06
"""Distance in the sweep, in u and in half the phase's sine and cosine, up to which two points are one motion. Sweeps
next to one another are a 160th of the map apart."""

KINDS = {
    CriticalKind.PERIOD_DOUBLING: CriticalKind.PERIOD_DOUBLING,
    CriticalKind.FOLD: CriticalKind.FOLD,
    CriticalKind.PITCHFORK: CriticalKind.FOLD,
    CriticalKind.GRAZING: CriticalKind.GRAZING,
}
"""Kinds of critical points that are drawn, and as what; a pitchfork is where two folds of tilted capsules begin."""


@dataclass(frozen=True, slots=True, eq=False)
class Locus:
    """A curve in the plane of two parameters.

    Attributes
    ----------
    kind : str
        ``period_doubling``, ``fold`` or ``grazing``.
    x, y : ndarray
        Values of the first and of the second axis of the map.
    """

    kind: str
    x: Floats
    y: Floats


def loci_of(plan: MapPlan) -> tuple[Locus, ...]:
    """Every curve on a map over two parameters; none where neither of them can be swept.

    Parameters
    ----------
    plan : MapPlan
        A grid over two axes.
    """
    names = plan.names
    along = next((k for k in (1, 0) if names[k] in tuple(Parameter)), None)
    if along is None:
        return ()
    across = 1 - along
    low, high = ends(plan.axes[along])
    parameter = Parameter(names[along])

    def column(value: float) -> Column:
        sweep = Sweep(_with(plan.device, names[across], value), parameter, low, high)
        try:
            points = solve(sweep).critical_points
        except NumericalError:
            return {}
        return _column(points, low, high)

    found = []
    for kind, chains in _chains(column, *ends(plan.axes[across])).items():
        for chain in chains:
            x = np.array([value for value, _ in chain])
            y = low + (high - low) * np.array([point[0] for _, point in chain])
            found.append(Locus(kind, *((x, y) if across == 0 else (y, x))))
    return tuple(found)


def ends(axis: Axis) -> tuple[float, float]:
    """Smallest and largest value of an axis."""
    values = axis.values or (float(axis.from_ or 0.0), float(axis.to or 0.0))
    return min(values), max(values)


def _with(device: Device, name: str, value: float) -> Device:
    """The device with one more parameter held; the ball's mass has no part in its motions."""
    return device if name == "ball_mass_kg" else replace(device, **{name: value})  # type: ignore[arg-type]


def _column(points: Iterable[CriticalPoint], low: float, high: float) -> Column:
    found: Column = {}
    for critical in points:
        if critical.kind in KINDS:
            for one in (critical.point, critical.mirror):
                if one is not None:
                    share = (one.sweep_value - low) / (high - low)
                    place = (float(share), float(one.u), float(np.sin(one.phi)) / 2, float(np.cos(one.phi)) / 2)
                    found.setdefault(KINDS[critical.kind], []).append(place)
    return found


Chain = list[tuple[float, Point]]


def _chains(column: Callable[[float], Column], first: float, last: float) -> dict[str, list[Chain]]:
    """Points of sweeps between two values of the other parameter, joined to chains, by kind."""
    columns = {float(x): column(float(x)) for x in np.linspace(first, last, SWEEPS)}
    for _ in range(HALVINGS):
        places = sorted(columns)
        middles = [(a + b) / 2 for a, b in pairwise(places) if _unmatched(columns[a], columns[b])]
        columns |= {x: column(x) for x in middles}
    places = sorted(columns)
    done: dict[str, list[Chain]] = {kind: [] for kind in dict.fromkeys(KINDS.values())}
    for kind, chains in done.items():
        open_chains: list[Chain] = [[(places[0], point)] for point in columns[places[0]].get(kind, [])]
        for a, b in pairwise(places):
            here, there = columns[a].get(kind, []), columns[b].get(kind, [])
            partner = _matched(here, there)
            ending = dict(zip((chain[-1][1] for chain in open_chains), open_chains, strict=True))
            begun: list[Chain] = []
            for k, point in enumerate(there):
                back = next((i for i, j in partner.items() if j == k), None)
                chain = ending.pop(here[back], []) if back is not None else []
                begun.append([*chain, (b, point)])
            chains += ending.values()
            open_chains = begun
        chains += open_chains
    return {kind: [chain for chain in chains if len(chain) > 1] for kind, chains in done.items()}


def _unmatched(one: Column, two: Column) -> bool:
    """Whether a point of one of two neighbours has no partner in the other."""
    for kind in set(one) | set(two):
        here, there = one.get(kind, []), two.get(kind, [])
        if not len(here) == len(there) == len(_matched(here, there)):
            return True
    return False


def _matched(here: list[Point], there: list[Point]) -> dict[int, int]:
    """Points of two neighbours that are each other's nearest, and near."""
    if not here or not there:
        return {}
    distance = np.linalg.norm(np.array(here)[:, None, :] - np.array(there)[None, :, :], axis=2)
    forth, back = distance.argmin(axis=1), distance.argmin(axis=0)
    return {i: int(j) for i, j in enumerate(forth) if back[j] == i and distance[i, j] <= FARTHEST}
