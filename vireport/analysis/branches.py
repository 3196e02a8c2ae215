"""Branches of motions and the critical points on them, made from the pieces of a curve."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.critical import CONDITIONS, Point, polish, with_top
from vireport.analysis.grazing import polish_grazing
from vireport.analysis.motions import Motions, motions_of
from vireport.analysis.orbits import Orbits, orbits
from vireport.analysis.pieces import HAIR, ROUGH, Piece
from vireport.analysis.stability import STABILITY, trace_and_determinant
from vireport.analysis.tracing import EVENTS, Curve
from vireport.errors import NumericalError

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Segment:
    """Rows `first` to `last` (inclusive) of a branch, between which nothing changes."""

    first: int
    last: int
    stability: str
    admissible: bool

    @property
    def stable(self) -> bool:
        """Whether this stretch attracts motions nearby and is a motion at all."""
        return self.admissible and self.stability.startswith("stable")


@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """Motions of one family, connected and ordered along their curve.

    Attributes
    ----------
    number : int
        From 1, in the order of the results.
    family : str
        ``symmetric`` or ``asymmetric``.
    mirror_of : int or None
        Number of the branch whose mirror image this is.
    motions : Motions
        On a critical point itself, the type of stability is the less stable side's.
    event : tuple of str
        For each motion the label of the critical point it is, or "".
    ends : tuple of str
        Why the branch begins and ends.
    """

    number: int
    family: str
    mirror_of: int | None
    motions: Motions
    event: tuple[str, ...]
    ends: tuple[str, str]

    def segments(self) -> list[Segment]:
        """Stretches between critical points, each of one stability and either admissible or not."""
        marks = [i for i, label in enumerate(self.event) if label or i in (0, len(self.event) - 1)]
        found = []
        for first, last in pairwise(marks):
            inner = (first + last + 1) // 2
            if last - first == 1 and self.event[last] and not self.event[first]:
                inner = first
            found.append(
                Segment(first, last, STABILITY[self.motions.stability[inner]], bool(self.motions.admissible[inner]))
            )
        return found


@dataclass(frozen=True, slots=True)
class CriticalPoint:
    """Where the type of motion changes.

    Attributes
    ----------
    label : str
        Letter and number, numbered along d (along the sweep where d is constant).
    kind : str
        ``period_doubling``, ``fold``, ``pitchfork``, ``node_focus`` or ``grazing``.
    family : str
        ``symmetric`` or ``asymmetric``.
    point : Point
        The motion, with the error bound of its sweep value.
    phi_top : float
        Phase at the top impact [rad].
    mirror : Point or None
        The mirror image of the motion, where the capsule is horizontal.
    branch : int
        Number of the branch it lies on (of the first of two mirror images).
    detail : str
        What happens there, in words.
    """

    label: str
    kind: str
    family: str
    point: Point
    phi_top: float
    mirror: Point | None
    branch: int
    detail: str


@dataclass(frozen=True, slots=True)
class Event:
    """A critical point on a branch before it has a name: at which row, of what kind, and the polished motion."""

    row: int
    kind: str
    point: Point
    detail: str


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


def _is_end(piece: Piece, row: int) -> bool:
    return EVENTS[piece.event[row]] in ("start", "end")


def _at_rest(piece: Piece, row: int) -> bool:
    """Whether an impact velocity vanishes at a row."""
    return bool(piece.event[row] >= 0 and EVENTS[piece.event[row]].endswith("rest"))


def _event(curve: Curve, piece: Piece, row: int) -> Event:
    try:
        point = _polished(curve, piece, row)
    except (NumericalError, ArithmeticError):
        point = _unpolished(curve, piece, row)
    name = EVENTS[piece.event[row]]
    if _at_rest(piece, row):
        kind, velocity = "grazing", "velocity_" + name.removesuffix("_rest")
        # Zero by the condition, not what the polish or the bracket leaves of it.
        point = replace(point, **{velocity: 0.0}, bounds={**point.bounds, velocity: 0.0})
    else:
        kind = name
    if kind == "fold" and curve.strands[piece.strand].symmetric and not _turns(curve, piece, row):
        kind = "pitchfork"
    return Event(row, kind, point, _detail(kind, name))


def _short_of_rest(piece: Piece) -> Floats:
    """The parameters, those at which an impact velocity vanishes moved inside by a hair."""
    w = piece.w.copy()
    for end, inner in ((0, 1), (-1, -2)):
        if _at_rest(piece, end):
            w[end] += HAIR * (w[inner] - w[end])
    return w


def _polished(curve: Curve, piece: Piece, row: int) -> Point:
    """The event at a row of a piece, polished."""
    event, symmetric = EVENTS[piece.event[row]], curve.strands[piece.strand].symmetric
    orbit = curve.at(np.array([piece.strand]), piece.w[row : row + 1])
    if event == "grazing":
        return polish_grazing(curve.sweep, orbit, symmetric)
    if event == "node_focus":
        event = "focus_below" if trace_and_determinant(orbit, curve.r)[0][0] < 0 else "focus_above"
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


def _detail(kind: str, event: str) -> str:
    if event == "bottom_rest":
        return "the impact at the bottom loses its velocity"
    if event == "top_rest":
        return "the impact at the top loses its velocity"
    return {
        "grazing": "a turning point of the ball touches a membrane",
        "period_doubling": "lambda = -1",
        "fold": "lambda = 1, two motions meet",
        "pitchfork": "lambda = 1, the symmetric motion passes its stability to two asymmetric ones",
        "node_focus": "Delta = 0, the type changes between node and focus",
    }[kind]


def _branch(curve: Curve, piece: Piece, orbit: Orbits, events: list[Event]) -> Branch:
    """Arrays of a branch, exact where something is known exactly."""
    sweep = curve.sweep
    motions = motions_of(sweep, curve.level, orbit)
    low_end, high_end = sorted((sweep.start, sweep.end), key=sweep.coordinate_of)
    for row in (0, -1):
        if piece.event[row] >= 0 and _is_end(piece, row):
            motions.sweep_value[row] = end = low_end if EVENTS[piece.event[row]] == "start" else high_end
            motions.d[row], motions.gbar[row] = sweep.device.groups(sweep.parameter, end)
    node, unstable = STABILITY.index("stable node"), STABILITY.index("unstable node")
    for event in events:
        _pin(motions, event.row, event.point, curve)
        if event.kind != "grazing":
            motions.stability[event.row] = node if event.kind == "node_focus" else unstable
        elif not _at_rest(piece, event.row):
            motions.wall_gap[event.row], motions.admissible[event.row] = 0.0, False
    for row in _pitchfork_ends(curve, piece):
        motions.stability[row] = unstable
    np.minimum(motions.wall_gap, motions.d, out=motions.wall_gap)
    return Branch(
        number=0,
        family="symmetric" if curve.strands[piece.strand].symmetric else "asymmetric",
        mirror_of=None,
        motions=motions,
        event=(),
        ends=(_end_word(curve, piece, 0), _end_word(curve, piece, -1)),
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


def _end_word(curve: Curve, piece: Piece, row: int) -> str:
    if piece.event[row] >= 0:
        return "end of the sweep" if _is_end(piece, row) else _detail("grazing", EVENTS[piece.event[row]])
    return "pitchfork" if row in _pitchfork_ends(curve, piece) else "closed curve"
