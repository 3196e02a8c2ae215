"""From the samples of a level curve to branches of motions, with what happens on them.

A strand is cut where it leaves the sweep or an impact velocity vanishes; on what is left, the points are found at
which the ball grazes a membrane or the type of stability changes; then the motions are evaluated, with the events
polished. Of two mirror images of a horizontal capsule the one with q > 1/2 is worked out, and the other one is its
reflection.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from math import pi, remainder

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.motions.branches import Branch, family_of
from vireport.motions.conditions import Condition
from vireport.motions.events import Event
from vireport.motions.families import Mark
from vireport.motions.level_curve import COLUMNS, GRAZING, MEETING, TRACED, VALIDITY, LevelCurve, Samples
from vireport.motions.one_to_one import Motions, motions_of
from vireport.motions.orbits import Orbits
from vireport.motions.points import (
    OneToOne,
    Point,
    model_of,
    motion_of,
    one_to_one,
    place_of,
    point_of,
    solve_one_to_one,
    solved_at,
)
from vireport.motions.polish import DECIMALS, FARTHEST, in_decimals
from vireport.motions.roots import bracketed_root, golden_minimum, may_hide_zeros
from vireport.motions.stability import NODE, UNSTABLE
from vireport.physics.groups import by_wall
from vireport.physics.motion import Symmetry

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

ROUGH = 1e-9
"""Tolerance of a parameter at which an event is found before it is polished."""

BRACKET = 1e-6
"""Distance to either side of an event at which it is evaluated to bound it where the polish does not settle."""

INSET = 1e-7
"""Share of the first and of the last step by which the search for events stays inside a piece, and by which the
motions at an impact without velocity stay short of it: there the trace diverges, and the gap is not that of a motion.
"""

DIP_SECTIONS = 45
"""Golden sections that find an extremum of the trace: down to the root of rounding, where an extremum is flat."""

CROSSED = 1e-11
"""Depth beyond which the trace crosses a border rather than touches it; rounding leaves some 1e-14."""

TIED = 1e-12
"""Difference of conditions of validity up to which both fail, as where both impacts lose their velocity at once: the
end is then that of the one which fails more beyond."""

LARGEST_STEP = 1e6
"""Sum of two values of the trace, at the ends of a step, beyond which it changes sign through infinity."""

AT_SYMMETRY = 1e-6
"""|u| of an asymmetric motion of a horizontal capsule below which rounding decides the sign of tr - 1 - r^4: this goes
with u^2 there, and comes with an error of some 1e-14. Folds were told at u = 1e-9 that were rounding."""

FROM_SYMMETRY = 1e-3
"""Share of a step from the symmetric motion at which that sign is taken in its place."""

BEGINS_AT_SYMMETRY = 1e-12
"""|u| at the end of a piece below which it begins at the symmetric motion; the end is known to rounding."""

TURN_STEP = 1e-4
"""Step of w over which a turn of the sweep's coordinate is told from its going on."""

BRACKETED = "u", "phi", "d", "gbar", "velocity_bottom", "velocity_top"
"""What is known of an event that was only bracketed, by the names of `Orbits`."""

BRACKET_ROUNDING = 1e-12
"""Relative rounding of what is known of an event that was only bracketed."""


class Piece(Struct, frozen=True, eq=False):
    """A connected run of possible motions inside the sweep, with the events on it.

    Attributes
    ----------
    strand : int
    w : ndarray
        Parameters, ascending; events are among them.
    event : ndarray of int
        Of each parameter the place in `COLUMNS`, -1 for an ordinary sample.
    """

    strand: int
    w: Floats
    event: NDArray[np.int8]

    def condition_at(self, row: int) -> Condition | None:
        """The condition that holds at a row of the piece."""
        return None if self.event[row] < 0 else COLUMNS[self.event[row]]

    def with_rows(self, w: Floats, event: NDArray[np.int8]) -> Piece:
        """The piece with more parameters."""
        merged = np.concatenate([self.w, w])
        order = np.argsort(merged, kind="stable")
        return Piece(self.strand, merged[order], np.concatenate([self.event, event])[order])


def _pieces(curve: LevelCurve, samples: Samples) -> list[Piece]:
    """Cut the strands into runs of possible motions and locate the events on them."""
    runs = [run for k in range(len(curve.strands)) for run in _runs(curve, samples, k)]
    if not runs:
        return []
    pieces = []
    for run, (first, last) in zip(runs, _locate_ends(curve, runs), strict=True):
        lead, tail = ([] if run.before is None else [first]), ([] if run.after is None else [last])
        inner = run.w
        for end, kind in lead:
            inner = _off_rest(curve, run.strand, inner, end, kind)
        for end, kind in tail:
            inner = _off_rest(curve, run.strand, inner[::-1], end, kind)[::-1]
        w = np.concatenate([[end for end, _ in lead], inner, [end for end, _ in tail]])
        event = [*(kind for _, kind in lead), *[-1] * len(inner), *(kind for _, kind in tail)]
        pieces.append(Piece(run.strand, w, np.array(event, dtype=np.int8)))
    kept = _originals(curve, pieces)
    return _with_inner_events(curve, _with_dips(curve, kept)) if kept else []


def _off_rest(curve: LevelCurve, strand: int, w: Floats, end: float, kind: int) -> Floats:
    """Samples from an end on, without a first one that is as good as the end, and beyond a membrane by rounding.

    So it may be where both impacts lose their velocity, and all turning points are touches.
    """
    if COLUMNS[kind].event is Event.ZERO_VELOCITY and len(w) > 1 and abs(w[0] - end) < INSET * abs(w[1] - w[0]):
        gap = curve.event_values(curve.on(strand, w[:1]))[0, GRAZING]
        return w if gap > 0 else w[1:]
    return w


def _originals(curve: LevelCurve, pieces: list[Piece]) -> list[Piece]:
    """The pieces without those that are the mirror images of others: of each pair the one with the larger q is left."""
    if not curve.horizontal:
        return pieces
    which = np.array([piece.strand for piece in pieces], dtype=np.intp)
    u = curve.at(which, np.array([(piece.w[0] + piece.w[-1]) / 2 for piece in pieces])).u
    return [p for p, place in zip(pieces, u, strict=True) if place > 0 or curve.strands[p.strand].symmetric]


class Run(Struct, frozen=True, eq=False):
    """Valid samples of a strand, and the invalid parameter on either side (None where the strand ends)."""

    strand: int
    w: Floats
    before: float | None
    after: float | None


def _runs(curve: LevelCurve, samples: Samples, k: int) -> Iterator[Run]:
    """The runs of strand k, cut where it passes through the symmetric motion."""
    strand = curve.strands[k]
    mine = samples.which == k
    w, valid = samples.w[mine], samples.validity[mine] > 0
    cuts = _symmetric_points(curve, k)
    if strand.closed and valid[0] and not valid.all():
        # Of a closed strand the parameter begins anywhere, also inside a run, which would then be two.
        turn = strand.end - strand.start
        first = int(np.argmin(valid))
        w = np.concatenate([w[first:-1], w[: first + 1] + turn])
        cuts = sorted([*cuts, *(cut + turn for cut in cuts)])
        valid = np.concatenate([valid[first:-1], valid[: first + 1]])
    edges = np.nonzero(np.diff(np.concatenate([[False], valid, [False]]).astype(np.int8)))[0]
    for a, b in zip(edges[::2], edges[1::2], strict=True):
        run, before, after = w[a:b], w[a - 1] if a else None, w[b] if b < len(w) else None
        # Of a sweep that ends next to the pitchfork the symmetric motion may be the only sample, or lie beside it.
        low, high = run[0] if before is None else before, run[-1] if after is None else after
        inner = [cut for cut in cuts if low < cut < high]
        ends = [before, *[None] * (2 * len(inner)), after]
        for i, part in enumerate(np.split(run, np.searchsorted(run, inner, side="left"))):
            lead, tail = inner[max(i - 1, 0) : i], inner[i : i + 1]
            body = part[~np.isin(part, inner)]
            yield Run(k, np.concatenate([lead, body, tail]), ends[2 * i], ends[2 * i + 1])


def _symmetric_points(curve: LevelCurve, k: int) -> list[float]:
    """Parameters at which a strand of a horizontal capsule passes through a symmetric motion of the sweep."""
    strand = curve.strands[k]
    if not curve.horizontal or strand.symmetric or not (cuts := strand.crossings()):
        return []
    values = curve.event_values(curve.on(k, np.array(cuts)), with_gap=False)[:, VALIDITY]
    return [cut for cut, valid in zip(cuts, values.min(axis=1) > 0, strict=True) if valid]


Ends = tuple[tuple[float, int], tuple[float, int]]
"""The parameter at which a run begins and ends, and the place in `COLUMNS` of what holds there."""


def _locate_ends(curve: LevelCurve, runs: list[Run]) -> list[Ends]:
    """Locate the ends of runs of admissible motions, and the condition that fails at each."""
    edges = [(run.strand, w, beyond) for run in runs for w, beyond in ((run.w[0], run.before), (run.w[-1], run.after))]
    which = np.array([strand for strand, _, _ in edges], dtype=np.intp)
    good = np.array([w for _, w, _ in edges])
    bad = np.array([w if beyond is None else beyond for _, w, beyond in edges])

    def conditions(w: Floats) -> Floats:
        return curve.event_values(curve.at(which, w), with_gap=False)[:, VALIDITY]

    root = bracketed_root(lambda w: np.asarray(conditions(w).min(axis=1)), good, bad)
    values = conditions(root)
    # Where both velocities vanish at once, rounding decides which is the lesser: a step further on they differ.
    tied = values <= values.min(axis=1, keepdims=True) + TIED
    failing = np.where(tied, conditions(bad), np.inf).argmin(axis=1)
    ends = [(float(w), int(k) + VALIDITY.start) for w, k in zip(root, failing, strict=True)]
    return list(zip(ends[::2], ends[1::2], strict=True))


def _joined(pieces: list[Piece]) -> tuple[Ints, Ints, Floats]:
    """Strand, piece and parameter of every sample of some pieces, their ends moved inwards by `INSET`."""

    def inside(w: Floats) -> Floats:
        moved = w.copy()
        if len(w) > 1:
            moved[0] += INSET * (w[1] - w[0])
            moved[-1] += INSET * (w[-2] - w[-1])
        return moved

    which = np.concatenate([np.full(len(p.w), p.strand) for p in pieces])
    owner = np.concatenate([np.full(len(p.w), i) for i, p in enumerate(pieces)])
    return which, owner, np.concatenate([inside(p.w) for p in pieces])


def _with_dips(curve: LevelCurve, pieces: list[Piece]) -> list[Piece]:
    """Add to the pieces the extrema at which the trace crosses a border between two samples and comes back."""
    which, owner, w = _joined(pieces)
    value = curve.event_values(curve.at(which, w), with_gap=False)[:, TRACED]
    with np.errstate(invalid="ignore"):
        dips = may_hide_zeros(value)
    row, event = np.nonzero(dips & (owner[2:] == owner[:-2])[:, None])
    if not row.size:
        return pieces
    row = row + 1
    sign, rows = np.sign(value[row, event]), np.arange(len(row))

    def height(x: Floats) -> Floats:
        values = curve.event_values(curve.at(which[row], x), with_gap=False)
        return np.asarray(sign * values[rows, event])

    lowest = golden_minimum(height, w[row - 1], w[row + 1], DIP_SECTIONS)
    crossing = height(lowest) < -CROSSED
    extra = [np.array(sorted(set(lowest[crossing & (owner[row] == i)]))) for i in range(len(pieces))]
    return [p.with_rows(x, np.full(len(x), -1, dtype=np.int8)) for p, x in zip(pieces, extra, strict=True)]


def _with_inner_events(curve: LevelCurve, pieces: list[Piece]) -> list[Piece]:
    """Insert the changes of stability and the grazing points into the pieces."""
    which, owner, w = _joined(pieces)
    orbit = curve.at(which, w)
    values = curve.event_values(orbit)[:, : GRAZING + 1]
    moved = _off_symmetry(curve, which, owner, w, orbit.u, values)
    with np.errstate(invalid="ignore"):
        crossing = (values[1:] > 0) != (values[:-1] > 0)
    crossing &= ~np.isnan(values[1:]) & ~np.isnan(values[:-1]) & (owner[1:] == owner[:-1])[:, None]
    # Through the pole at an impact without velocity the trace goes from one infinity to the other: no event.
    crossing &= np.abs(values[1:]) + np.abs(values[:-1]) < LARGEST_STEP
    row, event = np.nonzero(crossing)
    rows, grazing = np.arange(len(row)), event == GRAZING

    def event_value(w: Floats) -> Floats:
        return np.asarray(curve.event_values(curve.at(which[row], w), grazing)[rows, event])

    # Rough is enough: each of them is solved for in decimals from there.
    start, end = (np.where(event == MEETING, moved[side], w[side]) for side in (row, row + 1))
    root = bracketed_root(event_value, start, end, ROUGH, (values[row, event], values[row + 1, event]))
    owners = [owner[row] == i for i in range(len(pieces))]
    return [
        p.with_rows(root[piece_rows], event[piece_rows].astype(np.int8))
        for p, piece_rows in zip(pieces, owners, strict=True)
    ]


def _off_symmetry(curve: LevelCurve, which: Ints, owner: Ints, w: Floats, u: Floats, values: Floats) -> Floats:
    """Put the values of meetings that rounding decides in order; returns the parameters that they belong to.

    On the symmetric motion an asymmetric branch touches tr = 1 + r^4 without crossing. Next to it the value is that a
    little farther on, or none if that is still too near.
    """
    moved = w.copy()
    asymmetric = np.array([not strand.symmetric for strand in curve.strands])[which]
    touching = np.nonzero(asymmetric & (np.abs(u) < AT_SYMMETRY))[0] if curve.horizontal else np.empty(0, dtype=np.intp)
    if touching.size:
        neighbours = np.clip(touching + np.array([[-1], [1]]), 0, len(w) - 1)
        farther = np.where(owner[neighbours] == owner[touching], np.abs(u[neighbours]), -1.0).argmax(axis=0)
        moved[touching] += FROM_SYMMETRY * (w[neighbours[farther, np.arange(len(touching))]] - w[touching])
        orbit = curve.at(which[touching], moved[touching])
        near = np.abs(orbit.u) < AT_SYMMETRY
        values[touching, MEETING] = np.where(near, np.nan, curve.event_values(orbit, with_gap=False)[:, MEETING])
    return moved


def branches_of(curve: LevelCurve, samples: Samples) -> list[tuple[Branch, Branch | None]]:
    """The branches of a curve with the critical points on them, neither of them numbered yet.

    Each comes with its mirror image, where it has another one than itself.
    """
    return [_branches(curve, piece) for piece in _pieces(curve, samples)]


def _branches(curve: LevelCurve, piece: Piece) -> tuple[Branch, Branch | None]:
    conditions = {int(row): COLUMNS[piece.event[row]] for row in np.nonzero(piece.event >= 0)[0]}
    orbit = curve.on(piece.strand, piece.w)
    points = {
        row: _point(curve, piece, row, condition, orbit)
        for row, condition in conditions.items()
        if condition.event is not Event.SWEEP_END
    }
    # At the very impact without velocity the trace is infinite and the ball rests at a membrane: the row states what
    # holds just before, and `_pin` what is exact.
    if at_rest := [row for row, condition in conditions.items() if condition.event is Event.ZERO_VELOCITY]:
        w, inner = piece.w.copy(), [1 if row == 0 else row - 1 for row in at_rest]
        w[at_rest] += INSET * (piece.w[inner] - piece.w[at_rest])
        orbit = curve.on(piece.strand, w)
    u, phi = np.array(orbit.u), np.array(orbit.phi)
    ends = _sweep_ends(curve, piece)
    of_images = _polish_ends(curve, piece, ends, u, phi)
    for row, point in points.items():
        if point.rest is None:
            u[row], phi[row] = point.closed.u, point.closed.phi_bottom
    at_symmetry = _symmetric_ends(curve, piece, orbit)
    u[at_symmetry] = 0.0
    motions = motions_of(curve.sweep, curve.level, curve.through(u, phi))
    _pin(motions, curve, ends, points, at_symmetry)
    marks = tuple(_marks(piece, points, at_symmetry))

    def branch(rows: Motions) -> Branch:
        return Branch(family_of(curve.sweep, rows, marks), _symmetry(curve, piece), None, rows)

    if not _mirrored(curve, piece):
        return branch(motions), None
    image = motions.mirrored()
    for row, phase in of_images.items():
        image.phi_bottom[row] = phase
    for row, point in points.items():
        if point.mirror is not None:
            _pin_place(image, row, point.mirror.closed)
    return branch(motions), branch(image)


def _mirrored(curve: LevelCurve, piece: Piece) -> bool:
    """Whether the motions of a piece have mirror images other than themselves."""
    return curve.horizontal and not curve.strands[piece.strand].symmetric


def _marks(piece: Piece, points: dict[int, Point], at_symmetry: list[int]) -> Iterator[Mark]:
    """The events on a piece of the curve, in order."""
    last = len(piece.w) - 1
    beginnings = [row % (last + 1) for row in at_symmetry]
    for row, k in enumerate(piece.event):
        event, point = COLUMNS[k].event if k >= 0 else None, points.get(row)
        if event is None and row in (0, last):
            event = Event.PITCHFORK if row in beginnings else Event.CLOSED
        if event is not None:
            yield Mark(row, event if point is None or event is Event.ZERO_VELOCITY else point.event, point)


def _symmetry(curve: LevelCurve, piece: Piece) -> Symmetry:
    return Symmetry.SYMMETRIC if curve.strands[piece.strand].symmetric else Symmetry.ASYMMETRIC


def _sweep_ends(curve: LevelCurve, piece: Piece) -> dict[int, float]:
    """Of the rows, 0 and -1, at which an end of the sweep cuts a piece, the swept value there."""
    cut = {row: at for row in (0, -1) if (at := piece.condition_at(row)) is not None and at.event is Event.SWEEP_END}
    if not cut:
        return {}
    sweep = curve.sweep
    requested = sorted((sweep.coordinate_of(end), end) for end in (sweep.start, sweep.end))
    # Where the curve stops before the end of the sweep, it is not this that cuts the piece.
    sides = {row: int(condition.sign > 0) for row, condition in cut.items()}
    return {row: requested[side][1] for row, side in sides.items() if curve.bounds[side] == requested[side][0]}


def _polish_ends(curve: LevelCurve, piece: Piece, ends: dict[int, float], u: Floats, phi: Floats) -> dict[int, float]:
    """Put the motions of the very ends of the sweep into the rows where they cut a piece; the phases of their images.

    Along the strand the end is only as well known as the parameter fixes the sweep's coordinate; next to a horizontal
    capsule that is to a few digits. On a fold the row stays as it is: the polish does not settle there.
    """
    symmetric, of_images = curve.strands[piece.strand].symmetric, {}
    for row, value in ends.items():
        # Next to a fold the phase goes with the root of the coordinate: the end may be farther than `FARTHEST`, but not
        # farther than the next sample.
        reach = abs(remainder(phi[row] - phi[1 if row == 0 else -2], 2 * pi))
        with suppress(NumericalError, ArithmeticError), in_decimals():
            orbit = curve.through(u[[row]], phi[[row]])
            solved = solved_at(curve.sweep, value, orbit, symmetric, max(reach, FARTHEST))
            u[row], phi[row] = place_of(solved)
            if _mirrored(curve, piece):
                of_images[row] = place_of(solved.mirrored(1))[1]
    return of_images


def _point(curve: LevelCurve, piece: Piece, row: int, condition: Condition, orbit: Orbits) -> Point:
    """The critical point at a row of a piece, whose motions are `orbit`; with its mirror image where it has one."""
    symmetric = curve.strands[piece.strand].symmetric
    event = Event.GRAZING if condition.event is Event.ZERO_VELOCITY else condition.event
    if condition.event is Event.GRAZING and curve.level.friction is not None:
        event, condition = Event.STOP, Condition(Event.STOP)
    if event is Event.FOLD and symmetric and not _turns(curve, piece, row):
        event = Event.PITCHFORK
    # Without gravity along the capsule an impact loses its velocity together with the other, by momentum (3.8).
    rests = (0, 1) if curve.level.horizontal and condition.rests else condition.rests
    try:
        return _polished(curve, piece, event, condition, rests, orbit.select([row]))
    except (NumericalError, ArithmeticError):
        return _bracketed(curve, piece, row, event, rests)


def _polished(
    curve: LevelCurve, piece: Piece, event: Event, condition: Condition, rests: tuple[int, ...], orbit: Orbits
) -> Point:
    """An event of a piece, polished; `orbit` is the motion as far as it is known (arrays of length one)."""
    sweep, coordinate = curve.sweep, float(curve.sweep.coordinate(orbit)[0])
    symmetric = curve.strands[piece.strand].symmetric
    with in_decimals():
        motion = motion_of(orbit, curve.n, coordinate)
        solved, touches = solve_one_to_one(lambda ops: model_of(sweep, ops), motion, condition, symmetric)
        value, at_rest = sweep.value(solved.x[-1], DECIMALS), (*rests, *touches)
        point = point_of(solved, event, value, at_rest, touches)
        if not _mirrored(curve, piece):
            return point
        # Its bottom impact is the image of the top one.
        top = next(i for i, wall in enumerate(solved.word.walls) if wall == -1 and i not in touches)
        resting, touching = (tuple((i - top) % len(solved.word) for i in impacts) for impacts in (at_rest, touches))
        return replace(point, mirror=point_of(solved.mirrored(top), event, value, resting, touching))


def _bracketed(curve: LevelCurve, piece: Piece, row: int, event: Event, rests: tuple[int, ...]) -> Point:
    """The event as it was bracketed, where the polish does not settle: its bound is what the bracket leaves open."""
    orbit = curve.on(piece.strand, piece.w[row] + BRACKET * np.array([0.0, -1.0, 1.0]))
    point = _between(curve, orbit, event, rests)
    if not _mirrored(curve, piece):
        return point
    image = curve.through(-orbit.u, np.arctan2(orbit.sin_top, orbit.cos_top) + np.pi)
    return replace(point, mirror=_between(curve, image, event, rests))  # without gravity along it both rest, or none


def _between(curve: LevelCurve, orbit: Orbits, event: Event, rests: tuple[int, ...]) -> Point:
    """An event by the motion where it was found and those on either side of it."""
    sweep = curve.sweep

    def spread(values: Floats) -> float:
        return float(np.max(np.abs(values - values[0])) + BRACKET_ROUNDING * abs(values[0]))

    value = np.asarray(sweep.value(sweep.coordinate(orbit)), dtype=float)
    columns = {"phi_bottom" if name == "phi" else name: np.asarray(getattr(orbit, name)) for name in BRACKETED}
    numbers, bounds = {k: float(x[0]) for k, x in columns.items()}, {k: spread(x) for k, x in columns.items()}
    for name in (("velocity_bottom", "velocity_top")[rest] for rest in rests):
        numbers[name] = bounds[name] = 0.0  # by the condition, not what the bracket leaves of it
    motion = motion_of(orbit.select([0]), curve.n, float(sweep.coordinate(orbit)[0]))
    closed = one_to_one(curve.n, numbers, bounds)
    return Point(event, motion, numbers["d"], numbers["gbar"], float(value[0]), spread(value), closed)


def _turns(curve: LevelCurve, piece: Piece, row: int) -> bool:
    """Whether the sweep's coordinate has an extremum at an event."""
    x = curve.sweep.coordinate(curve.on(piece.strand, piece.w[row] + TURN_STEP * np.array([-1.0, 0.0, 1.0])))
    return bool((x[0] - x[1]) * (x[2] - x[1]) > 0)


def _symmetric_ends(curve: LevelCurve, piece: Piece, orbit: Orbits) -> list[int]:
    """Rows, 0 or -1, at which an asymmetric branch of a horizontal capsule begins at the symmetric motion."""
    if not _mirrored(curve, piece):
        return []
    return [row for row in (0, -1) if abs(orbit.u[row]) < BEGINS_AT_SYMMETRY]


def _pin(
    motions: Motions, curve: LevelCurve, ends: dict[int, float], points: dict[int, Point], at_symmetry: list[int]
) -> None:
    """Put into the rows of a branch what is known exactly there.

    Where an impact has no velocity, the trace stays that of `INSET` before it.
    """
    sweep = curve.sweep
    for row, end in ends.items():
        motions.sweep_value[row] = end
        motions.d[row], motions.gbar[row], *_ = sweep.device.groups(sweep.parameter, end)
        _pin_restitution(motions, curve, row, end)
    for row, point in points.items():
        motions.sweep_value[row], motions.d[row], motions.gbar[row] = point.sweep_value, point.d, point.gbar
        _pin_restitution(motions, curve, row, point.sweep_value)
        _pin_place(motions, row, point.closed)
        if point.event is Event.STOP:
            motions.wall_gap[row], motions.admissible_mask[row] = 0.0, False
        elif point.event is not Event.GRAZING:
            motions.stability[row] = NODE if point.event is Event.NODE_FOCUS else UNSTABLE
        elif point.rest is None:
            motions.wall_gap[row], motions.admissible_mask[row] = 0.0, False
    motions.stability[at_symmetry] = UNSTABLE
    np.minimum(motions.wall_gap, motions.d, out=motions.wall_gap)


def _pin_place(motions: Motions, row: int, closed: OneToOne) -> None:
    """Put a motion of the closed form into a row."""
    motions.q[row], motions.u[row], motions.phi_bottom[row] = 0.5 + closed.u, closed.u, closed.phi_bottom
    motions.velocity_bottom[row], motions.velocity_top[row] = closed.velocity_bottom, closed.velocity_top
    motions.phi_top[row] = closed.phi_top


def _pin_restitution(motions: Motions, curve: LevelCurve, row: int, value: float) -> None:
    """Put the restitution of a value of the swept parameter into a row, where motions have their own."""
    if curve.level.varied is not None:
        exact = curve.level.restitution(curve.r, value)
        for column, constant in zip(by_wall(motions.restitution), by_wall(exact), strict=True):
            column[row] = constant
