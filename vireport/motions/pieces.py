"""Pieces of the level curve inside a sweep, with the events on them.

A strand is cut where it leaves the sweep or an impact velocity vanishes; on what is left, the parameters are located at
which the ball grazes a membrane or the type of stability changes. Of two mirror images of a horizontal capsule the
piece with q > 1/2 is kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.motions.conditions import Condition
from vireport.motions.events import Event
from vireport.motions.level_curve import COLUMNS, GRAZING, MEETING, TRACED, VALIDITY, LevelCurve, Samples
from vireport.motions.orbits import Orbits
from vireport.motions.roots import bracketed_root, golden_minimum, may_hide_zeros
from vireport.motions.turning import slowest, wall_gap

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

ROUGH = 1e-9
"""Tolerance of a parameter to which an event is located before it is polished."""

INSET = 1e-7
"""Share of the first and of the last step by which the search for events stays inside a piece, and by which the
motions at an impact without velocity stay short of it: there the trace diverges, and the gap is not that of a motion.
"""

DIP_SECTIONS = 45
"""Golden sections that find an extremum of the trace: down to the root of rounding, where an extremum is flat."""

CROSSED = 1e-11
"""Depth beyond which the trace crosses a border rather than touches it; rounding leaves some 1e-14."""

TIED = 1e-12
"""Difference of two conditions of validity up to which both fail, as where both impacts lose their velocity at once:
the end then has the condition that fails more beyond it."""

LARGEST_STEP = 1e6
"""Sum of two values of the trace, at the ends of a step, beyond which it changes sign through infinity."""

AT_SYMMETRY = 1e-6
"""|u| of an asymmetric motion of a horizontal capsule below which rounding decides the sign of tr - 1 - r^4, which goes
with u^2 there and has an error of some 1e-14. Without this limit, rounding was reported as folds at u = 1e-9."""

FROM_SYMMETRY = 1e-3
"""Share of a step from the symmetric motion at which the sign of tr - 1 - r^4 is taken instead."""


class Piece(Struct, frozen=True, eq=False):
    """A connected run of possible motions inside the sweep, with the events on it.

    Attributes
    ----------
    strand : int
        Number of the strand that it is part of.
    symmetric : bool
        Whether its motions are their own mirror images.
    mirrored : bool
        Whether they have mirror images that are other motions.
    w : ndarray
        Parameters on the strand, ascending; those of events are among them.
    event : ndarray of int
        Column of `COLUMNS` whose condition holds at each parameter; -1 at an ordinary sample.
    """

    strand: int
    symmetric: bool
    mirrored: bool
    w: Floats
    event: NDArray[np.int8]

    @property
    def conditions(self) -> dict[int, Condition]:
        """The conditions of the events on the piece, by their rows."""
        return {int(row): COLUMNS[self.event[row]] for row in np.flatnonzero(self.event >= 0)}

    def with_rows(self, w: Floats, event: NDArray[np.int8]) -> Piece:
        """The piece with further rows put in by their parameter."""
        merged = np.concatenate([self.w, w])
        order = np.argsort(merged, kind="stable")
        return replace(self, w=merged[order], event=np.concatenate([self.event, event])[order])


def pieces_of(curve: LevelCurve) -> list[Piece]:
    """Cut the strands of a curve into runs of possible motions and locate the events on them."""
    samples = curve.sampled()
    # All runs and pieces at once, strand after strand: a call on arrays of all costs little more than one on a few.
    runs = [run for k in range(len(curve.strands)) for run in _runs(curve, samples, k)]
    if not runs:
        return []
    pieces = [_piece(curve, run, ends) for run, ends in zip(runs, _located_ends(curve, runs), strict=True)]
    originals = _originals(curve, pieces)
    return _with_inner_events(curve, _with_dips(curve, originals)) if originals else []


def _piece(curve: LevelCurve, run: Run, ends: tuple[RunEnd, RunEnd]) -> Piece:
    """The piece of a run between its located ends, without the events inside."""
    first, last = ends
    inner = run.w
    if run.before is not None:
        inner = _off_rest(curve, run.strand, inner, first)
    if run.after is not None:
        inner = _off_rest(curve, run.strand, inner[::-1], last)[::-1]
    w, event = inner, np.full(len(inner), -1, dtype=np.int8)
    # Where the strand itself ends, nothing happens: the piece ends at its last sample.
    if run.before is not None:
        w, event = np.append(first.w, w), np.append(np.int8(first.column), event)
    if run.after is not None:
        w, event = np.append(w, last.w), np.append(event, np.int8(last.column))
    symmetric = curve.strands[run.strand].symmetric
    return Piece(run.strand, symmetric, curve.plane.mirrors and not symmetric, w, event)


class Run(Struct, frozen=True, eq=False):
    """Consecutive valid samples of a strand, and the invalid parameter on either side (None where the strand ends)."""

    strand: int
    w: Floats
    before: float | None
    after: float | None


def _runs(curve: LevelCurve, samples: Samples, k: int) -> Iterator[Run]:
    """Find the runs of valid samples on strand k, cut where it passes through the symmetric motion."""
    strand = curve.strands[k]
    on_strand = samples.which == k
    w, valid = samples.w[on_strand], samples.validity[on_strand] > 0
    cuts = _symmetric_points(curve, k)
    if strand.closed and valid[0] and not valid.all():
        # The parameter of a closed strand begins anywhere, even inside a run, which would then be two: it is made to
        # begin at an invalid sample.
        turn = strand.end - strand.start
        first = int(np.argmin(valid))
        w = np.concatenate([w[first:-1], w[: first + 1] + turn])
        cuts = sorted([*cuts, *(cut + turn for cut in cuts)])
        valid = np.concatenate([valid[first:-1], valid[: first + 1]])
    edges = np.nonzero(np.diff(np.concatenate([[False], valid, [False]]).astype(np.int8)))[0]
    for a, b in zip(edges[::2], edges[1::2], strict=True):
        run, before, after = w[a:b], w[a - 1] if a else None, w[b] if b < len(w) else None
        # Where the sweep ends next to a pitchfork, the symmetric motion may be the only sample of a run, or lie between
        # its last sample and the invalid one.
        low, high = run[0] if before is None else before, run[-1] if after is None else after
        inner = [cut for cut in cuts if low < cut < high]
        ends = [before, *[None] * (2 * len(inner)), after]
        for i, part in enumerate(np.split(run, np.searchsorted(run, inner, side="left"))):
            lead, tail = inner[max(i - 1, 0) : i], inner[i : i + 1]
            body = part[~np.isin(part, inner)]
            yield Run(k, np.concatenate([lead, body, tail]), ends[2 * i], ends[2 * i + 1])


def _symmetric_points(curve: LevelCurve, k: int) -> list[float]:
    """Parameters at which an asymmetric strand passes through a symmetric motion of the sweep (a pitchfork)."""
    strand = curve.strands[k]
    if not curve.plane.mirrors or strand.symmetric or not (cuts := strand.crossings()):
        return []
    values = curve.event_values(curve.at(k, np.array(cuts)))[:, VALIDITY]
    return [cut for cut, valid in zip(cuts, values.min(axis=1) > 0, strict=True) if valid]


class RunEnd(NamedTuple):
    """The parameter at which a run ends, and the column of `COLUMNS` whose condition holds there."""

    w: float
    column: int


def _located_ends(curve: LevelCurve, runs: list[Run]) -> list[tuple[RunEnd, RunEnd]]:
    """Both ends of each run, between its outermost valid samples and the invalid ones beyond them."""
    edges = [(run.strand, w, beyond) for run in runs for w, beyond in ((run.w[0], run.before), (run.w[-1], run.after))]
    which = np.array([strand for strand, _, _ in edges], dtype=np.intp)
    good = np.array([w for _, w, _ in edges])
    bad = np.array([w if beyond is None else beyond for _, w, beyond in edges])

    def conditions(w: Floats) -> Floats:
        return curve.event_values(curve.at(which, w))[:, VALIDITY]

    # The least of all conditions: whichever fails first ends the run.
    root = bracketed_root(lambda w: np.asarray(conditions(w).min(axis=1)), good, bad)
    values = conditions(root)
    # Where both velocities vanish at once, rounding decides which is the lesser: a step further on they differ.
    tied = values <= values.min(axis=1, keepdims=True) + TIED
    failing = np.where(tied, conditions(bad), np.inf).argmin(axis=1)
    ends = [RunEnd(float(w), int(k) + VALIDITY.start) for w, k in zip(root, failing, strict=True)]
    return list(zip(ends[::2], ends[1::2], strict=True))


def _off_rest(curve: LevelCurve, strand: int, w: Floats, end: RunEnd) -> Floats:
    """Samples in order from an end of a run, without the first one if rounding alone puts it beyond a membrane.

    This happens next to a motion at which both impacts lose their velocity, where all turning points are touches.
    """
    at_rest = COLUMNS[end.column].event is Event.ZERO_VELOCITY
    if at_rest and len(w) > 1 and abs(w[0] - end.w) < INSET * abs(w[1] - w[0]):
        orbit = curve.at(strand, w[:1])
        return w if _gaps(curve, orbit, curve.event_values(orbit))[0] > 0 else w[1:]
    return w


def _gaps(curve: LevelCurve, orbit: Orbits, values: Floats, wanted: NDArray[np.bool_] | bool = True) -> Floats:
    """Least distance of a turning point to a membrane, zero at grazing; with friction, the least speed onward.

    Friction changes its sign in a ball that turns within a flight, which is then on another path before it can graze:
    it is the speed that must not become zero.

    Parameters
    ----------
    curve : LevelCurve
    orbit : Orbits
    values : ndarray (len, columns)
        `LevelCurve.event_values` of these motions.
    wanted : ndarray of bool
        Motions to evaluate.

    Returns
    -------
    ndarray
        NaN for motions that are not wanted, and where there can be no motion.
    """
    gaps = np.full(len(values), np.nan)
    inside = (values[:, VALIDITY].min(axis=1) > 0) & wanted
    if inside.any():
        motions = orbit.select(inside)
        r = curve.restitution(motions)
        gaps[inside] = wall_gap(motions, r) if orbit.friction is None else slowest(motions, r)[0]
    return gaps


def _originals(curve: LevelCurve, pieces: list[Piece]) -> list[Piece]:
    """The pieces without mirror images: of two that are images of each other, the one with the larger q."""
    if not curve.plane.mirrors:
        return pieces
    # Pieces end at the symmetric motion, so that u has one sign on each: its middle tells which.
    which = np.array([piece.strand for piece in pieces], dtype=np.intp)
    u = curve.at(which, np.array([(piece.w[0] + piece.w[-1]) / 2 for piece in pieces])).u
    return [p for p, place in zip(pieces, u, strict=True) if place > 0 or p.symmetric]


class PieceSamples(NamedTuple):
    """Samples of several pieces, one piece after another: strand, number of the piece, and parameter of each."""

    which: Ints
    owner: Ints
    w: Floats


def _joined(pieces: list[Piece]) -> PieceSamples:
    """The samples of all pieces as one sequence, with the ends of each piece moved inwards by `INSET`."""

    def inside(w: Floats) -> Floats:
        moved = w.copy()
        if len(w) > 1:
            moved[0] += INSET * (w[1] - w[0])
            moved[-1] += INSET * (w[-2] - w[-1])
        return moved

    which = np.concatenate([np.full(len(p.w), p.strand) for p in pieces])
    owner = np.concatenate([np.full(len(p.w), i) for i, p in enumerate(pieces)])
    return PieceSamples(which, owner, np.concatenate([inside(p.w) for p in pieces]))


def _with_dips(curve: LevelCurve, pieces: list[Piece]) -> list[Piece]:
    """Add samples at extrema where the trace crosses a border of stability between two samples and comes back."""
    # Without this, two period doublings between which a family is unstable for less than a step are both missed; a
    # finer grid would only make that rarer.
    which, owner, w = _joined(pieces)
    value = curve.event_values(curve.at(which, w))[:, TRACED]
    with np.errstate(invalid="ignore"):
        dips = may_hide_zeros(value)
    row, event = np.nonzero(dips & (owner[2:] == owner[:-2])[:, None])
    if not row.size:
        return pieces
    row = row + 1
    sign, rows = np.sign(value[row, event]), np.arange(len(row))

    def height(x: Floats) -> Floats:
        values = curve.event_values(curve.at(which[row], x))
        return np.asarray(sign * values[rows, event])

    lowest = golden_minimum(height, w[row - 1], w[row + 1], DIP_SECTIONS)
    crossing = height(lowest) < -CROSSED
    extra = [np.array(sorted(set(lowest[crossing & (owner[row] == i)]))) for i in range(len(pieces))]
    return [p.with_rows(x, np.full(len(x), -1, dtype=np.int8)) for p, x in zip(pieces, extra, strict=True)]


def _with_inner_events(curve: LevelCurve, pieces: list[Piece]) -> list[Piece]:
    """Insert the changes of stability and the grazing points into the pieces."""
    samples = _joined(pieces)
    which, owner, w = samples
    orbit = curve.at(which, w)
    all_values = curve.event_values(orbit)
    values = all_values[:, : GRAZING + 1]
    moved = _off_symmetry(curve, samples, orbit.u, values)
    values[:, GRAZING] = _gaps(curve, orbit, all_values)
    with np.errstate(invalid="ignore"):
        crossing = (values[1:] > 0) != (values[:-1] > 0)
    crossing &= ~np.isnan(values[1:]) & ~np.isnan(values[:-1]) & (owner[1:] == owner[:-1])[:, None]
    # Through the pole at an impact without velocity the trace goes from one infinity to the other: no event.
    crossing &= np.abs(values[1:]) + np.abs(values[:-1]) < LARGEST_STEP
    row, event = np.nonzero(crossing)
    rows, grazing = np.arange(len(row)), event == GRAZING

    def event_value(w: Floats) -> Floats:
        orbit = curve.at(which[row], w)
        values = curve.event_values(orbit)
        values[:, GRAZING] = _gaps(curve, orbit, values, grazing)
        return np.asarray(values[rows, event])

    # Rough is enough: `points` solves for each of them in decimals from there. The brackets of meetings begin where
    # `_off_symmetry` took their values: elsewhere the function need not have the signs that made it a crossing.
    start, end = (np.where(event == MEETING, moved[side], w[side]) for side in (row, row + 1))
    root = bracketed_root(event_value, start, end, ROUGH, (values[row, event], values[row + 1, event]))
    owners = [owner[row] == i for i in range(len(pieces))]
    return [
        p.with_rows(root[piece_rows], event[piece_rows].astype(np.int8))
        for p, piece_rows in zip(pieces, owners, strict=True)
    ]


def _off_symmetry(curve: LevelCurve, samples: PieceSamples, u: Floats, values: Floats) -> Floats:
    """Replace, in place, values of tr - 1 - r^4 that only rounding decides next to the symmetric motion.

    An asymmetric branch touches tr = 1 + r^4 on the symmetric motion without crossing it. The value there is taken from
    a motion a little farther on the branch; NaN if that motion is still too near.

    Returns
    -------
    ndarray
        The parameters that the values belong to.
    """
    which, owner, w = samples
    moved = w.copy()
    asymmetric = np.array([not strand.symmetric for strand in curve.strands])[which]
    touching = (
        np.nonzero(asymmetric & (np.abs(u) < AT_SYMMETRY))[0] if curve.plane.mirrors else np.empty(0, dtype=np.intp)
    )
    if touching.size:
        neighbours = np.clip(touching + np.array([[-1], [1]]), 0, len(w) - 1)
        farther = np.where(owner[neighbours] == owner[touching], np.abs(u[neighbours]), -1.0).argmax(axis=0)
        moved[touching] += FROM_SYMMETRY * (w[neighbours[farther, np.arange(len(touching))]] - w[touching])
        orbit = curve.at(which[touching], moved[touching])
        near = np.abs(orbit.u) < AT_SYMMETRY
        values[touching, MEETING] = np.where(near, np.nan, curve.event_values(orbit)[:, MEETING])
    return moved
