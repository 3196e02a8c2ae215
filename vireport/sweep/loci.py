"""Curves in the plane of two parameters along which motions change: where they double, meet or graze.

Each point of a curve is a critical point of a sweep, exact; the points of neighbouring sweeps are joined where they are
clearly the same motion. Where that is not clear the sweeps are taken closer together, and finally a gap is left rather
than a false line drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vireport.analysis import CriticalKind, CriticalPoint, Sweep, solve
from vireport.errors import NumericalError
from vireport.physics import Device
from vireport.scenario import Parameter
from vireport.sweep.cells import Floats, MapPlan, axis_ends

Point = tuple[float, float, float, float]
"""Place along the sweep (as a share of it), u, sine and cosine of the phase."""

Column = dict[CriticalKind, list[Point]]
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
    kind : CriticalKind
        Period doubling, fold or grazing.
    x, y : ndarray
        Values of the first and of the second axis of the map.
    """

    kind: CriticalKind
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
    low, high = axis_ends(plan.axes[along])
    parameter = Parameter(names[along])

    def column(value: float) -> Column:
        sweep = Sweep(_with(plan.device, names[across], value), parameter, low, high)
        try:
            points = solve(sweep).critical_points
        except NumericalError:
            return {}
        return _column(points, low, high)

    loci = []
    for kind, chains in _chains(column, *axis_ends(plan.axes[across])).items():
        for chain in chains:
            x = np.array([value for value, _ in chain])
            y = low + (high - low) * np.array([point[0] for _, point in chain])
            loci.append(Locus(kind, *((x, y) if across == 0 else (y, x))))
    return tuple(loci)


def _with(device: Device, name: str, value: float) -> Device:
    """The device with one more parameter held; the ball's mass has no part in its motions."""
    return device if name == "ball_mass_kg" else replace(device, **{name: value})  # type: ignore[arg-type]


def _column(critical_points: Iterable[CriticalPoint], low: float, high: float) -> Column:
    """Points of a sweep from low to high by kind, mirror images among them."""
    column: Column = {}
    for critical in critical_points:
        if critical.kind in KINDS:
            for orbit in (critical.point, critical.mirror):
                if orbit is not None:
                    share = (orbit.sweep_value - low) / (high - low)
                    point = (float(share), float(orbit.u), float(np.sin(orbit.phi)) / 2, float(np.cos(orbit.phi)) / 2)
                    column.setdefault(KINDS[critical.kind], []).append(point)
    return column


Chain = list[tuple[float, Point]]
"""Points of neighbouring sweeps that are one motion, each with the value of the other parameter."""


def _chains(column: Callable[[float], Column], first: float, last: float) -> dict[CriticalKind, list[Chain]]:
    """Points of sweeps between two values of the other parameter, joined to chains, by kind."""
    columns = {float(x): column(float(x)) for x in np.linspace(first, last, SWEEPS)}
    for _ in range(HALVINGS):
        middles = [(a + b) / 2 for a, b in pairwise(sorted(columns)) if not _all_matched(columns[a], columns[b])]
        columns |= {x: column(x) for x in middles}
    return {kind: _joined(columns, kind) for kind in dict.fromkeys(KINDS.values())}


def _joined(columns: dict[float, Column], kind: CriticalKind) -> list[Chain]:
    """Chains of at least two points of a kind."""
    values = sorted(columns)
    finished: list[Chain] = []
    growing: list[Chain] = [[(values[0], point)] for point in columns[values[0]].get(kind, [])]
    for a, b in pairwise(values):
        points = columns[b].get(kind, [])
        partner = {j: i for i, j in _matched(columns[a].get(kind, []), points).items()}
        finished += [chain for i, chain in enumerate(growing) if i not in partner.values()]
        growing = [[*(growing[partner[j]] if j in partner else []), (b, point)] for j, point in enumerate(points)]
    return [chain for chain in [*finished, *growing] if len(chain) > 1]


def _all_matched(left: Column, right: Column) -> bool:
    """Whether each point of either of two neighbours has a partner in the other."""
    for kind in left.keys() | right.keys():
        points, others = left.get(kind, []), right.get(kind, [])
        if not len(points) == len(others) == len(_matched(points, others)):
            return False
    return True


def _matched(points: list[Point], others: list[Point]) -> dict[int, int]:
    """Points of two neighbours, by their indices, that are each other's nearest, and near."""
    if not points or not others:
        return {}
    distance = np.linalg.norm(np.array(points)[:, None, :] - np.array(others)[None, :, :], axis=2)
    nearest, back = distance.argmin(axis=1), distance.argmin(axis=0)
    return {i: int(j) for i, j in enumerate(nearest) if back[j] == i and distance[i, j] <= FARTHEST}
