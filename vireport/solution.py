"""The motions of a sweep as branches with their stability and admissibility, and the critical points that divide them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vireport.branches import EVENTS, ROUGH, Curve, Piece, curve_of, pieces, sample
from vireport.critical import CONDITIONS, Point, polish
from vireport.errors import NumericalError
from vireport.grazing import polish_grazing
from vireport.model import Sweep
from vireport.orbits import Orbits, orbits
from vireport.motions import Motions, motions_of
from vireport.stability import STABILITY, trace_and_determinant

Floats = NDArray[np.float64]

LETTERS = {"node_focus": "A", "period_doubling": "B", "fold": "C", "pitchfork": "C", "grazing": "G"}
"""Letters of the critical points; the paper's A, B, C, and G for grazing, which it does not treat."""

REST_OFFSET = 1e-7
"""Share of the last step by which a branch that ends in an impact of zero velocity stops short, where its trace is still a number."""

SAME_POINT = 1e-9
"""Relative difference of the swept value below which two critical points of one kind are mirror images of one another."""


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
        for first, last in zip(marks, marks[1:], strict=False):
            inner = (first + last + 1) // 2
            if last - first == 1 and self.event[last] and not self.event[first]:
                inner = first
            found.append(
                Segment(first, last, STABILITY[self.motions.stability[inner]], bool(self.motions.admissible[inner]))
            )
        return found


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
class Solution:
    """All that a sweep's equations say: the curve, its branches and its critical points."""

    curve: Curve
    branches: tuple[Branch, ...]
    critical_points: tuple[CriticalPoint, ...]


def solve(sweep: Sweep) -> Solution:
    """Find every 1:1 motion of a sweep, with its stability, admissibility and critical points.

    Parameters
    ----------
    sweep : Sweep
        With a restitution below 1.
    """
    curve = curve_of(sweep)
    found = pieces(curve, sample(curve))
    drafts = [_draft(curve, piece) for piece in found]
    return _label(curve, drafts)


@dataclass(frozen=True, slots=True, eq=False)
class _Draft:
    """A branch before its critical points have names: `kinds[i]` is the kind at row `rows[i]`, with the polished point."""

    branch: Branch
    rows: list[int]
    kinds: list[str]
    points: list[Point]
    details: list[str]


def _draft(curve: Curve, piece: Piece) -> _Draft:
    """Evaluate a piece, with its events polished."""
    w = _short_of_rest(piece)
    which = np.full(len(w), piece.strand, dtype=np.intp)
    orbit = curve.at(which, w)
    strand = curve.strands[piece.strand]
    symmetric = strand.low == strand.high
    u, phi = np.array(orbit.u), np.array(orbit.phi)
    rows, kinds, points, details = [], [], [], []
    for row in np.nonzero(piece.event >= 0)[0]:
        event = EVENTS[piece.event[row]]
        if event in ("start", "end"):
            continue
        try:
            point = _polished(curve, piece, int(row))
        except (NumericalError, ArithmeticError):
            point = _unpolished(curve, piece, int(row))
        if not event.endswith("rest"):
            u[row], phi[row] = point.u, point.phi
        rows.append(int(row))
        kind = "grazing" if event.endswith("rest") else event
        if kind == "fold" and symmetric and not _turns(curve, piece, int(row)):
            kind = "pitchfork"
        kinds.append(kind)
        points.append(point)
        details.append(_detail(kind, event))
    if (pitchfork := _pitchfork_ends(curve, piece)) and not symmetric:
        u[pitchfork] = 0.0
    return _Draft(_branch(curve, piece, orbits(u, phi, curve.r, curve.n), rows, kinds, points), rows, kinds, points, details)


def _short_of_rest(piece: Piece) -> Floats:
    """The parameters, those at which an impact velocity vanishes moved inside by a hair."""
    w = piece.w.copy()
    for end, inner in ((0, 1), (-1, -2)):
        if piece.event[end] >= 0 and EVENTS[piece.event[end]].endswith("rest"):
            w[end] += REST_OFFSET * (w[inner] - w[end])
    return w


def _polished(curve: Curve, piece: Piece, row: int) -> Point:
    """The event at a row of a piece, polished."""
    event, strand = EVENTS[piece.event[row]], curve.strands[piece.strand]
    orbit = curve.at(np.array([piece.strand]), piece.w[row : row + 1])
    symmetric = strand.low == strand.high
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
    return Point(
        *(float(getattr(orbit, name)[0]) for name in ("u", "phi", "d", "gbar", "velocity_bottom", "velocity_top")),
        sweep_value=float(value[0]),
        error_bound=float(np.max(np.abs(value - value[0])) + 1e-12 * abs(value[0])),
    )


def _turns(curve: Curve, piece: Piece, row: int) -> bool:
    """Whether the sweep's coordinate has an extremum at an event."""
    w = piece.w[row] + 1e-4 * np.array([-1.0, 0.0, 1.0])
    x = curve.sweep.coordinate(curve.at(np.full(3, piece.strand), w))
    return bool((x[0] - x[1]) * (x[2] - x[1]) > 0)


def _pitchfork_ends(curve: Curve, piece: Piece) -> list[int]:
    """Rows at which an asymmetric branch of a horizontal capsule begins at the symmetric motion."""
    if curve.level.kind != "gbar" or curve.level.value != 0:
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


def _branch(curve: Curve, piece: Piece, orbit: Orbits, rows: list[int], kinds: list[str], points: list[Point]) -> Branch:
    """Arrays of a branch, exact where something is known exactly."""
    sweep = curve.sweep
    motions = motions_of(sweep, curve.level, orbit)
    low_end, high_end = sorted((sweep.start, sweep.end), key=sweep.coordinate_of)
    for row in (0, -1):
        event = EVENTS[piece.event[row]] if piece.event[row] >= 0 else ""
        if event in ("start", "end"):
            motions.sweep_value[row] = end = low_end if event == "start" else high_end
            motions.d[row], motions.gbar[row] = sweep.device.groups(sweep.parameter, end)
    for row, kind, point in zip(rows, kinds, points, strict=True):
        motions.sweep_value[row] = point.sweep_value
        if kind != "grazing":
            motions.stability[row] = STABILITY.index("stable node" if kind == "node_focus" else "unstable node")
        elif EVENTS[piece.event[row]] == "grazing":
            motions.wall_gap[row], motions.admissible[row] = 0.0, False
    for row in _pitchfork_ends(curve, piece):
        motions.stability[row] = STABILITY.index("unstable node")
    strand = curve.strands[piece.strand]
    return Branch(
        number=0,
        family="symmetric" if strand.low == strand.high else "asymmetric",
        mirror_of=None,
        motions=motions,
        event=(),
        ends=(_end_word(curve, piece, 0), _end_word(curve, piece, -1)),
    )


def _end_word(curve: Curve, piece: Piece, row: int) -> str:
    if piece.event[row] >= 0:
        event = EVENTS[piece.event[row]]
        return {"start": "end of the sweep", "end": "end of the sweep"}.get(event, _detail("grazing", event))
    if (0 if row == 0 else -1) in _pitchfork_ends(curve, piece):
        return "pitchfork"
    return "closed curve"


def _label(curve: Curve, drafts: list[_Draft]) -> Solution:
    """Number branches and critical points, and join mirror images."""
    drafts.sort(key=lambda draft: (draft.branch.family == "asymmetric", float(draft.branch.motions.q.min()) < 0.5 - 1e-9))
    mirrored = _mirrors(curve, drafts)
    seen: list[tuple[str, str, Point, Point | None, int, str]] = []
    owner: dict[tuple[int, int], int] = {}
    for i, draft in enumerate(drafts):
        for row, kind, point, detail in zip(draft.rows, draft.kinds, draft.points, draft.details, strict=True):
            if not _near_admissible(draft.branch, row):
                continue
            twin = next((k for k, s in enumerate(seen) if mirrored[i] is not None and s[4] == mirrored[i] and _same(s, kind, point)), None)
            if twin is None:
                owner[i, row] = len(seen)
                seen.append((kind, draft.branch.family, point, None, i, detail))
            else:
                owner[i, row] = twin
                seen[twin] = (*seen[twin][:3], point, *seen[twin][4:])
    order = sorted(range(len(seen)), key=lambda k: (seen[k][2].d if curve.level.kind != "d" else 0.0, seen[k][2].sweep_value))
    counts: dict[str, int] = {}
    labels: dict[int, str] = {}
    for k in order:
        letter = LETTERS[seen[k][0]]
        counts[letter] = counts.get(letter, 0) + 1
        labels[k] = f"{letter}{counts[letter]}"
    branches = []
    for i, draft in enumerate(drafts):
        event = [""] * len(draft.branch.motions)
        for row, kind in zip(draft.rows, draft.kinds, strict=True):
            event[row] = labels[owner[i, row]] if (i, row) in owner else f"({kind})"
        for row in (0, -1):
            if draft.branch.ends[row] == "pitchfork":
                event[row] = next((labels[k] for k in order if _meets(seen[k], draft.branch, row)), "")
        twin_branch = mirrored[i]
        branches.append(
            replace(draft.branch, number=i + 1, mirror_of=None if twin_branch is None else twin_branch + 1, event=tuple(event))
        )
    critical = tuple(_critical(curve, labels[k], seen[k]) for k in order)
    return Solution(curve, tuple(branches), critical)


def _critical(curve: Curve, label: str, seen: tuple[str, str, Point, Point | None, int, str]) -> CriticalPoint:
    kind, family, point, mirror, branch, detail = seen
    orbit = orbits(point.u, point.phi, curve.r, curve.n)
    phi_top = float(np.mod(np.arctan2(orbit.sin_top, orbit.cos_top), 2 * np.pi))
    return CriticalPoint(label, kind, family, point, phi_top, mirror, branch + 1, detail)


def _same(seen: tuple[str, str, Point, Point | None, int, str], kind: str, point: Point) -> bool:
    close = abs(seen[2].sweep_value - point.sweep_value) <= SAME_POINT * abs(point.sweep_value)
    return seen[0] == kind and seen[3] is None and close


def _meets(seen: tuple[str, str, Point, Point | None, int, str], branch: Branch, row: int) -> bool:
    """Whether a critical point is the pitchfork at which an asymmetric branch begins."""
    return seen[0] == "pitchfork" and abs(seen[2].d - float(branch.motions.d[row])) <= SAME_POINT * seen[2].d


def _mirrors(curve: Curve, drafts: list[_Draft]) -> list[int | None]:
    """For each branch of a horizontal capsule, the earlier one whose mirror image it is."""
    result: list[int | None] = [None] * len(drafts)
    if curve.level.kind != "gbar" or curve.level.value != 0:
        return result
    for i, draft in enumerate(drafts):
        mine = draft.branch
        if mine.family == "symmetric":
            continue
        for k in range(i):
            other = drafts[k].branch
            if result[k] is None and other.family == mine.family and _reflected(mine, other):
                result[i] = k
                break
    return result


def _reflected(one: Branch, two: Branch) -> bool:
    """Whether the ends of two branches are mirror images: q and 1 - q, with the impact velocities exchanged."""

    def ends(branch: Branch, sign: float) -> Floats:
        m = branch.motions
        speed = m.velocity_bottom if sign > 0 else -m.velocity_top
        rows = np.stack([m.d, sign * (m.q - 0.5), speed], axis=1)[[0, -1]]
        return np.asarray(rows[np.argsort(rows[:, 1])])

    return bool(np.allclose(ends(one, 1.0), ends(two, -1.0), rtol=0, atol=1e-6))


def _near_admissible(branch: Branch, row: int) -> bool:
    """Whether a motion or one of its neighbours is admissible: points inside an inadmissible stretch are not critical points of motions."""
    return bool(branch.motions.admissible[max(row - 1, 0) : row + 2].any())

