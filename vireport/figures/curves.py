"""What of a study is drawn, as plain arrays: stretches of motions, critical points, curves cut to an axis.

Only admissible motions come out of here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import (
    Branch,
    CriticalPoint,
    Motions,
    Solution,
    Stability,
    Sweep,
    eigenvalues,
)
from vireport.physics import Voltages
from vireport.study import Study

Floats = NDArray[np.float64]
Curve = tuple[Floats, Floats]
Pairs = tuple[tuple[Floats, Floats], tuple[Floats, Floats], tuple[Floats, Floats]]

TURN = 2 * np.pi

ROUNDING = 1e-9
"""Distance from a full turn that is rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Simulated:
    """Motions from a simulation, to be drawn over the analytic ones; arrays of one length.

    Attributes
    ----------
    sweep_value, d : ndarray
        Where they are.
    velocity_bottom, velocity_top : ndarray
        Before the impacts, of either sign.
    phi_bottom, phi_top : ndarray
        [rad], in [0, 2 pi).
    flight_bottom, flight_top : ndarray
        Half the flight times from the bottom and from the top.
    voltages : Voltages or None
    """

    sweep_value: Floats
    d: Floats
    velocity_bottom: Floats
    velocity_top: Floats
    phi_bottom: Floats
    phi_top: Floats
    flight_bottom: Floats
    flight_top: Floats
    voltages: Voltages | None = None

    @property
    def pairs(self) -> Pairs:
        """What figure 2 shows of them."""
        return (
            (np.abs(self.velocity_bottom), np.abs(self.velocity_top)),
            (self.phi_bottom, self.phi_top),
            (self.flight_bottom, self.flight_top),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Admissible motions of one kind of stability, next to one another on a branch.

    Attributes
    ----------
    branch : Branch
    rows : slice
        Of the branch's motions. At an end there may be the grazing one, where the admissible ones end.
    stable, focus : bool
        Whether it attracts the motions nearby; whether its eigenvalues are complex.
    """

    branch: Branch
    rows: slice
    stable: bool
    focus: bool


@dataclass(frozen=True, slots=True, eq=False)
class Event:
    """A critical point where it is drawn: on its branch, and on the mirror image of that.

    Attributes
    ----------
    point : CriticalPoint
    places : tuple of (Branch, int)
        Branches and rows.
    """

    point: CriticalPoint
    places: tuple[tuple[Branch, int], ...]


def solved(study: Study) -> tuple[Solution, Sweep]:
    """The solution and the sweep of a study that has them."""
    if study.solution.sweep is None:
        raise ValueError("figures are drawn along a sweep, and this study has none")
    return study.solution, study.solution.sweep


def stretches(solution: Solution) -> list[Stretch]:
    """What of a solution is motion, unstable stretches first, so that stable ones are drawn over them."""
    found = [
        Stretch(branch, slice(part.first, part.last + 1), part.stable, part.stability is Stability.STABLE_FOCUS)
        for branch in solution.branches
        for part in branch.segments()
        if part.admissible
    ]
    return sorted(found, key=lambda stretch: stretch.stable)


def events(solution: Solution) -> list[Event]:
    """The critical points with the rows at which they stand."""
    places: dict[CriticalPoint, list[tuple[Branch, int]]] = {point: [] for point in solution.critical_points}
    for branch in solution.branches:
        for row in range(len(branch.motions)):
            if (point := branch.critical_point(row)) is not None:
                places[point].append((branch, row))
    return [Event(point, tuple(found)) for point, found in places.items() if found]


def pairs(motions: Motions, period_ratio: int) -> Pairs:
    """What figure 2 shows of motions, at the bottom and at the top.

    The magnitude of the impact velocity, the phase, and half the flight time, which is the time in periods.
    """
    q, n = motions.q, period_ratio
    return (
        (np.abs(motions.velocity_bottom), np.abs(motions.velocity_top)),
        (_on_one_side(motions.phi_bottom), _on_one_side(motions.phi_top)),
        (n * q, n * (1 - q)),
    )


def _on_one_side(phi: Floats) -> Floats:
    """The phases, those that are 0 or 2 pi but for rounding written as the motion next to them has it."""
    if len(phi) < 2:
        return phi
    beside = np.append(phi[1], phi[:-1])
    even = np.minimum(phi, TURN - phi) < ROUNDING
    return np.where(even, np.where(beside > np.pi, TURN, 0.0), phi)


def phase_curve(x: Floats, phi: Floats) -> list[Curve]:
    """A curve of phases in [0, 2 pi) in pieces, cut where the phase passes 0 so that no line jumps."""
    turns = -np.round(np.diff(phi) / TURN)
    cuts = np.nonzero(turns)[0]
    if not len(cuts):
        return [(x, phi)]
    found: list[Curve] = []
    first, start = 0, (np.empty(0), np.empty(0))
    for cut in cuts:
        leaves, enters = (TURN, 0.0) if turns[cut] > 0 else (0.0, TURN)
        step = phi[cut + 1] + turns[cut] * TURN - phi[cut]
        at = x[cut] + (x[cut + 1] - x[cut]) * ((leaves - phi[cut]) / step if step else 0.0)
        rows = slice(first, cut + 1)
        found.append((np.concatenate([start[0], x[rows], [at]]), np.concatenate([start[1], phi[rows], [leaves]])))
        first, start = int(cut) + 1, (np.array([at]), np.array([enters]))
    found.append((np.append(start[0], x[first:]), np.append(start[1], phi[first:])))
    return found


def eigenvalue_curves(stretch: Stretch, x: Floats) -> Iterator[Curve]:
    """Both eigenvalues, or their common real part where they are complex."""
    motions = stretch.branch.motions
    larger, smaller = eigenvalues(motions.trace[stretch.rows], motions.restitution)
    yield x, larger
    if not stretch.focus:
        yield x, smaller


def larger_first(values: tuple[Floats, Floats]) -> list[Floats]:
    """The eigenvalues by size: the first is the one that decides."""
    one, two = values
    swap = np.abs(two) > np.abs(one)
    return [np.where(swap, two, one), np.where(swap, one, two)]


def joined(parts: Sequence[Curve]) -> Curve:
    """Curves as one, with NaN between them."""
    x = np.concatenate([np.append(part, np.nan) for part, _ in parts])
    y = np.concatenate([np.append(part, np.nan) for _, part in parts])
    return x[:-1], y[:-1]


def visible(curve: Curve, low: float, high: float) -> list[Curve]:
    """The parts of a curve that are within limits, cut where it crosses them."""
    x, y = curve
    inside = (y >= low) & (y <= high)
    if inside.all():
        return [curve]
    found: list[Curve] = []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8)))
    for first, end in edges.reshape(-1, 2):
        before = _crossing(x, y, first, first - 1, low, high) if first else None
        after = _crossing(x, y, end - 1, end, low, high) if end < len(x) else None
        parts = [p for p in (before, (x[first:end], y[first:end]), after) if p is not None]
        found.append((np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])))
    return found


def _crossing(x: Floats, y: Floats, inner: int, outer: int, low: float, high: float) -> Curve:
    """Where the line from a row inside the limits to one outside crosses them."""
    limit = high if y[outer] > high else low
    part = (limit - y[inner]) / (y[outer] - y[inner])
    return np.array([x[inner] + part * (x[outer] - x[inner])]), np.array([limit])
