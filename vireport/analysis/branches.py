"""Branches of motions and the critical points on them, made from the pieces of a curve."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.critical import CONDITIONS, Point, polish, with_top
from vireport.analysis.grazing import polish_grazing
from vireport.analysis.kinds import STABILITIES, BranchEnd, Change, CriticalKind, Family, Stability, StrandEvent
from vireport.analysis.motions import Motions, motions_of
from vireport.analysis.orbits import Orbits, orbits
from vireport.analysis.pieces import HAIR, ROUGH, Piece
from vireport.analysis.stability import NODE, UNSTABLE
from vireport.analysis.tracing import Curve
from vireport.errors import NumericalError
from vireport.physics import Voltages

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class CriticalPoint:
    """Where the type of motion changes.

    Attributes
    ----------
    label : str
        Letter and number, numbered along d (along the sweep where d is constant).
    kind : CriticalKind
    family : Family
    point : Point
        The motion, with the error bound of its sweep value.
    phi_top : float
        Phase at the top impact [rad].
    mirror : Point or None
        The mirror image of the motion, where the capsule is horizontal.
    branch : int
        Number of the branch it lies on (of the first of two mirror images).
    change : Change
        What happens there.
    """

    label: str
    kind: CriticalKind
    family: Family
    point: Point
    phi_top: float
    mirror: Point | None
    branch: int
    change: Change


@dataclass(frozen=True, slots=True)
class Segment:
    """Rows `first` to `last` (inclusive) of a branch, between which nothing changes."""

    first: int
    last: int
    stability: Stability
    admissible: bool

    @property
    def stable(self) -> bool:
        """Whether this stretch attracts motions nearby and is a motion at all."""
        return self.admissible and self.stability.attracts


Mark = CriticalPoint | CriticalKind | None
"""What a row of a branch is: a critical point, only its kind where no motion nearby is admissible, or nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """Motions of one family, connected and ordered along their curve.

    Attributes
    ----------
    number : int
        From 1, in the order of the results.
    family : Family
    mirror_of : int or None
        Number of the branch whose mirror image this is.
    motions : Motions
        On a critical point itself, the type of stability is the less stable side's.
    marks : tuple of Mark
        For each motion the critical point it is.
    ends : tuple of BranchEnd
        Why the branch begins and ends.
    voltages : Voltages or None
        None where no energy is evaluated.
    """

    number: int
    family: Family
    mirror_of: int | None
    motions: Motions
    marks: tuple[Mark, ...]
    ends: tuple[BranchEnd, BranchEnd]
    voltages: Voltages | None = None

    def critical_point(self, row: int) -> CriticalPoint | None:
        """The critical point that a row is."""
        mark = self.marks[row]
        return mark if isinstance(mark, CriticalPoint) else None

    @property
    def labels(self) -> list[str]:
        """For each motion the label of the critical point it is, its kind in brackets, or ""."""
        return [mark.label if isinstance(mark, CriticalPoint) else f"({mark})" if mark else "" for mark in self.marks]

    def segments(self) -> list[Segment]:
        """Stretches between critical points, each of one stability and either admissible or not."""
        places = [i for i, mark in enumerate(self.marks) if mark or i in (0, len(self.marks) - 1)]
        found = []
        for first, last in pairwise(places):
            inner = (first + last + 1) // 2
            if last - first == 1 and self.marks[last] and not self.marks[first]:
                inner = first
            stability = STABILITIES[self.motions.stability[inner]]
            found.append(Segment(first, last, stability, bool(self.motions.admissible[inner])))
        return found


@dataclass(frozen=True, slots=True)
class Event:
    """A critical point on a branch before it has a name: at which row, of what kind, and the polished motion."""

    row: int
    kind: CriticalKind
    point: Point
    change: Change


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A branch before it and its critical points are numbered."""

    branch: Branch
    events: tuple[Event, ...]


def draft(curve: Curve, piece: Piece) -> Draft:
    """Evaluate a piece, with its events polished."""
    w = _short_of_rest(piece)
    orbit = curve.at(np.full(len(w), piece.strand), w)
    u, phi = np.array(orbit.u), np.array(orbit.phi)
    events = [_event(curve, piece, int(row)) for row in np.nonzero(piece.event >= 0)[0] if not _is_end(piece, int(row))]
    for event in events:
        if not _at_rest(piece, event.row):
            u[event.row], phi[event.row] = event.point.u, event.point.phi
    for row in _pitchfork_ends(curve, piece):
        u[row] = 0.0
    return Draft(_branch(curve, piece, orbits(u, phi, curve.r, curve.n), events), tuple(events))


def _happening(piece: Piece, row: int) -> StrandEvent | None:
    """What happens at a row of a piece."""
    return None if piece.event[row] < 0 else StrandEvent(piece.event[row])


def _is_end(piece: Piece, row: int) -> bool:
    return _happening(piece, row) in (StrandEvent.START, StrandEvent.END)


def _at_rest(piece: Piece, row: int) -> bool:
    """Whether an impact velocity vanishes at a row."""
    return _happening(piece, row) in (StrandEvent.BOTTOM_REST, StrandEvent.TOP_REST)


def _event(curve: Curve, piece: Piece, row: int) -> Event:
    try:
        point = _polished(curve, piece, row)
    except (NumericalError, ArithmeticError):
        point = _unpolished(curve, piece, row)
    event = StrandEvent(piece.event[row])
    # Zero by the condition, not what the polish or the bracket leaves of it.
    if event is StrandEvent.BOTTOM_REST:
        point = replace(point, velocity_bottom=0.0, bounds={**point.bounds, "velocity_bottom": 0.0})
    elif event is StrandEvent.TOP_REST:
        point = replace(point, velocity_top=0.0, bounds={**point.bounds, "velocity_top": 0.0})
    elif event is StrandEvent.MEETING and curve.strands[piece.strand].symmetric and not _turns(curve, piece, row):
        return Event(row, CriticalKind.PITCHFORK, point, Change.HANDOVER)
    return Event(row, event.kind, point, event.change)


def _short_of_rest(piece: Piece) -> Floats:
    """The parameters, those at which an impact velocity vanishes moved inside by a hair."""
    w = piece.w.copy()
    for end, inner in ((0, 1), (-1, -2)):
        if _at_rest(piece, end):
            w[end] += HAIR * (w[inner] - w[end])
    return w


def _polished(curve: Curve, piece: Piece, row: int) -> Point:
    """The event at a row of a piece, polished."""
    event, symmetric = StrandEvent(piece.event[row]), curve.strands[piece.strand].symmetric
    orbit = curve.at(np.array([piece.strand]), piece.w[row : row + 1])
    if event is StrandEvent.GRAZING:
        return polish_grazing(curve.sweep, orbit, symmetric)
    return polish(curve.sweep, float(orbit.u[0]), float(orbit.phi[0]), CONDITIONS[event], symmetric=symmetric)


def _unpolished(curve: Curve, piece: Piece, row: int) -> Point:
    """The event as it was bracketed, where the polish does not settle: its bound is what the bracket leaves open."""
    w = piece.w[row] + 10 * ROUGH * np.array([0.0, -1.0, 1.0])
    orbit = curve.at(np.full(3, piece.strand), w)
    value = np.asarray(curve.sweep.value(orbit.d, orbit.gbar), dtype=float)
    names = ("u", "phi", "d", "gbar", "velocity_bottom", "velocity_top")
    values = {name: np.asarray(getattr(orbit, name), dtype=float) for name in names}
    return Point(
        **{name: float(x[0]) for name, x in values.items()},
        sweep_value=float(value[0]),
        error_bound=_spread(value),
        bounds=with_top({name: _spread(x) for name, x in values.items()}, curve.n),
    )


def _spread(values: Floats) -> float:
    """How far the first of some values may be from what the others enclose, rounding included."""
    return float(np.max(np.abs(values - values[0])) + 1e-12 * abs(values[0]))


def _turns(curve: Curve, piece: Piece, row: int) -> bool:
    """Whether the sweep's coordinate has an extremum at an event."""
    w = piece.w[row] + 1e-4 * np.array([-1.0, 0.0, 1.0])
    x = curve.sweep.coordinate(curve.at(np.full(3, piece.strand), w))
    return bool((x[0] - x[1]) * (x[2] - x[1]) > 0)


def _pitchfork_ends(curve: Curve, piece: Piece) -> list[int]:
    """Rows at which an asymmetric branch of a horizontal capsule begins at the symmetric motion."""
    if not curve.horizontal or curve.strands[piece.strand].symmetric:
        return []
    u = curve.at(np.full(2, piece.strand), piece.w[[0, -1]]).u
    return [row for row, value in zip((0, -1), u, strict=True) if abs(value) < 1e-12]


def _branch(curve: Curve, piece: Piece, orbit: Orbits, events: list[Event]) -> Branch:
    """Arrays of a branch, exact where something is known exactly."""
    sweep = curve.sweep
    motions = motions_of(sweep, curve.level, orbit)
    low_end, high_end = sorted((sweep.start, sweep.end), key=sweep.coordinate_of)
    for row in (0, -1):
        if piece.event[row] >= 0 and _is_end(piece, row):
            motions.sweep_value[row] = end = low_end if _happening(piece, row) is StrandEvent.START else high_end
            motions.d[row], motions.gbar[row] = sweep.device.groups(sweep.parameter, end)
    for event in events:
        _pin(motions, event.row, event.point, curve)
        if event.kind is not CriticalKind.GRAZING:
            motions.stability[event.row] = NODE if event.kind is CriticalKind.NODE_FOCUS else UNSTABLE
        elif not event.change.at_rest:
            motions.wall_gap[event.row], motions.admissible[event.row] = 0.0, False
    for row in _pitchfork_ends(curve, piece):
        motions.stability[row] = UNSTABLE
    np.minimum(motions.wall_gap, motions.d, out=motions.wall_gap)
    return Branch(
        number=0,
        family=Family.SYMMETRIC if curve.strands[piece.strand].symmetric else Family.ASYMMETRIC,
        mirror_of=None,
        motions=motions,
        marks=(),
        ends=(_why_ends(curve, piece, 0), _why_ends(curve, piece, -1)),
    )


def _pin(motions: Motions, row: int, point: Point, curve: Curve) -> None:
    """Put the polished numbers of a critical point in its row.

    Where an impact has no velocity, the trace stays that of a hair before it.
    """
    motions.sweep_value[row], motions.d[row], motions.gbar[row] = point.sweep_value, point.d, point.gbar
    motions.q[row], motions.u[row], motions.phi_bottom[row] = 0.5 + point.u, point.u, point.phi
    motions.velocity_bottom[row], motions.velocity_top[row] = point.velocity_bottom, point.velocity_top
    motions.phi_top[row] = phase_at_top(point, curve)


def phase_at_top(point: Point, curve: Curve) -> float:
    """Forcing phase at the top impact of a polished motion [rad]."""
    orbit = orbits(point.u, point.phi, curve.r, curve.n)
    return float(np.mod(np.arctan2(orbit.sin_top, orbit.cos_top), 2 * np.pi))


def _why_ends(curve: Curve, piece: Piece, row: int) -> BranchEnd:
    match _happening(piece, row):
        case None:
            return BranchEnd.PITCHFORK if row in _pitchfork_ends(curve, piece) else BranchEnd.CLOSED
        case StrandEvent.BOTTOM_REST:
            return BranchEnd.BOTTOM_REST
        case StrandEvent.TOP_REST:
            return BranchEnd.TOP_REST
        case _:
            return BranchEnd.SWEEP
