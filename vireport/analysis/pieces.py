"""Runs of possible motions along the strands, ending exactly where they end, with what happens on them.

A strand is cut where it leaves the sweep or an impact velocity vanishes; on what is left, the points are found at
which the ball grazes a membrane or the type of stability changes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.kinds import StrandEvent
from vireport.analysis.strands import Strand, bisect
from vireport.analysis.tracing import VALIDITY, Curve, Floats, Ints, Samples

ROUGH = 1e-7
"""Tolerance of a parameter at which an event is found before it is polished."""


HAIR = 1e-7
"""Share of the first and of the last step by which the search for events stays inside a run."""


GOLDEN, DIP_STEPS = (5**0.5 - 1) / 2, 45
"""Share by which a golden section narrows, and how often: down to the root of rounding, where an extremum is flat."""

TOUCH = 1e-11
"""Depth beyond which the trace crosses a border rather than touches it; rounding leaves some 1e-14."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A connected run of possible motions inside the sweep, with the events on it.

    Attributes
    ----------
    strand : int
    w : ndarray
        Parameters, ascending; events are among them.
    event : ndarray of int
        A `StrandEvent` for each parameter, -1 for an ordinary sample.
    """

    strand: int
    w: Floats
    event: NDArray[np.int8]


def pieces(curve: Curve, samples: Samples) -> list[Piece]:
    """Cut the strands into runs of possible motions and locate the events on them."""
    runs = [run for k in range(len(curve.strands)) for run in _runs(curve, samples, k)]
    if not runs:
        return []
    ends = _locate_ends(curve, runs)
    found = []
    for (strand, w, before, after), (first, last) in zip(runs, ends, strict=True):
        if before is not None:
            w = np.concatenate([[first[0]], w])
        if after is not None:
            w = np.concatenate([w, [last[0]]])
        event = np.full(len(w), -1, dtype=np.int8)
        event[0], event[-1] = first[1] if before is not None else -1, last[1] if after is not None else -1
        found.append(Piece(strand, w, event))
    return _with_inner_events(curve, found)


Run = tuple[int, Floats, "float | None", "float | None"]


def _runs(curve: Curve, samples: Samples, k: int) -> Iterator[Run]:
    """Runs of valid samples of strand k, with the invalid parameter on either side (None where the strand ends)."""
    strand = curve.strands[k]
    mine = samples.which == k
    w, valid = samples.w[mine], samples.validity[mine] > 0
    if strand.closed and valid[0] and not valid.all():
        turn = strand.end - strand.start
        first = int(np.argmin(valid))
        w = np.concatenate([w[first:-1], w[: first + 1] + turn])
        valid = np.concatenate([valid[first:-1], valid[: first + 1]])
    edges = np.nonzero(np.diff(np.concatenate([[False], valid, [False]]).astype(np.int8)))[0]
    cuts = _symmetric_points(curve, strand)
    for a, b in zip(edges[::2], edges[1::2], strict=True):
        before = w[a - 1] if a else None
        after = w[b] if b < len(w) else None
        run = w[a:b]
        inner = [c for c in cuts if run[0] < c < run[-1]]
        parts = np.split(run, np.searchsorted(run, inner, side="left"))
        for i, part in enumerate(parts):
            lead = [] if i == 0 else [inner[i - 1]]
            tail = [] if i == len(parts) - 1 else [inner[i]]
            body = part[np.all(part[:, None] != np.array(inner), axis=1)]  # np.isin would import numpy.ma
            yield (
                k,
                np.concatenate([lead, body, tail]),
                before if i == 0 else None,
                after if i == len(parts) - 1 else None,
            )


def _symmetric_points(curve: Curve, strand: Strand) -> list[float]:
    """Parameters at which an asymmetric strand of a horizontal capsule passes through the symmetric motion."""
    if not curve.horizontal or strand.symmetric:
        return []
    middle = 2 * np.arcsin(np.sqrt(-strand.low / (strand.high - strand.low)))
    return [w for w in (-middle, middle, 2 * np.pi - middle) if strand.start < w < strand.end]


def _locate_ends(curve: Curve, runs: list[Run]) -> list[list[tuple[float, int]]]:
    """Where each run ends: the parameter and which condition fails there."""
    which, inside, outside = [], [], []
    for strand, w, before, after in runs:
        for edge, beyond in ((w[0], before), (w[-1], after)):
            which.append(strand)
            inside.append(edge)
            outside.append(edge if beyond is None else beyond)
    index = np.array(which, dtype=np.intp)
    good, bad = np.array(inside), np.array(outside)
    values = curve.event_values(curve.at(index, bad), with_gap=False)[:, VALIDITY]
    kind = values.argmin(axis=1)
    for _ in range(4):  # the nearest failing condition may be another than the one failing at the far sample
        root = _roots(curve, index, good, bad, kind + StrandEvent.BOTTOM_REST)
        values = curve.event_values(curve.at(index, root), with_gap=False)[:, VALIDITY]
        worse = values.argmin(axis=1)
        wrong = (values.min(axis=1) < -1e-12) & (worse != kind)
        if not wrong.any():
            break
        bad, kind = np.where(wrong, root, bad), np.where(wrong, worse, kind)
    return [
        [
            (float(root[i]), int(kind[i]) + StrandEvent.BOTTOM_REST),
            (float(root[i + 1]), int(kind[i + 1]) + StrandEvent.BOTTOM_REST),
        ]
        for i in range(0, len(root), 2)
    ]


def _roots(curve: Curve, which: Ints, low: Floats, high: Floats, kind: Ints, tolerance: float = 0.0) -> Floats:
    """Parameters between `low` and `high` at which the event of each row happens."""
    rows, grazing = np.arange(len(which)), kind == StrandEvent.GRAZING

    def function(w: Floats) -> Floats:
        return np.asarray(curve.event_values(curve.at(which, w), grazing)[rows, kind])

    return bisect(function, low, high, tolerance)


def _inside(w: Floats) -> Floats:
    """The parameters, the ends moved in by a hair: on the end itself the gap to a membrane is not that of a motion."""
    moved = w.copy()
    if len(w) > 1:
        moved[0] += HAIR * (w[1] - w[0])
        moved[-1] += HAIR * (w[-2] - w[-1])
    return moved


def _joined(found: list[Piece]) -> tuple[Ints, Ints, Floats]:
    """Strand, piece and parameter of every sample of some pieces."""
    which = np.concatenate([np.full(len(p.w), p.strand) for p in found])
    owner = np.concatenate([np.full(len(p.w), i) for i, p in enumerate(found)])
    return which, owner, np.concatenate([_inside(p.w) for p in found])


def _with_dips(curve: Curve, found: list[Piece]) -> list[Piece]:
    """Add to the pieces the extrema at which the trace crosses a border between two samples and comes back.

    They stand where a sample is nearest to the border of all around, and nearer than the step is high.
    """
    which, owner, w = _joined(found)
    value = curve.event_values(curve.at(which, w), with_gap=False)[:, : StrandEvent.GRAZING]
    left, middle, right = np.abs(value[:-2]), np.abs(value[1:-1]), np.abs(value[2:])
    with np.errstate(invalid="ignore"):
        one_side = (value[:-2] * value[1:-1] > 0) & (value[1:-1] * value[2:] > 0)
        dip = one_side & (middle <= left) & (middle <= right) & (middle <= np.maximum(left - middle, right - middle))
    row, kind = np.nonzero(dip & (owner[2:] == owner[:-2])[:, None])
    if not row.size:
        return found
    row = row + 1
    sign = np.sign(value[row, kind])

    def height(x: Floats) -> Floats:
        values = curve.event_values(curve.at(which[row], x), with_gap=False)
        return np.asarray(sign * values[np.arange(len(row)), kind])

    low, high = w[row - 1], w[row + 1]
    for _ in range(DIP_STEPS):
        x1, x2 = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        nearer = height(x1) < height(x2)
        low, high = np.where(nearer, low, x1), np.where(nearer, x2, high)
    lowest = (low + high) / 2
    crossing = height(lowest) < -TOUCH
    result = []
    for i, piece in enumerate(found):
        extra = np.array(sorted(set(lowest[crossing & (owner[row] == i)])))
        order = np.argsort(np.concatenate([piece.w, extra]), kind="stable")
        event = np.concatenate([piece.event, np.full(len(extra), -1, dtype=np.int8)])
        result.append(Piece(piece.strand, np.concatenate([piece.w, extra])[order], event[order]))
    return result


def _with_inner_events(curve: Curve, found: list[Piece]) -> list[Piece]:
    """Insert the changes of stability and the grazing points into the pieces."""
    found = _with_dips(curve, found)
    which, owner, w = _joined(found)
    orbit = curve.at(which, w)
    values = curve.event_values(orbit)[:, : StrandEvent.GRAZING + 1]
    # On the symmetric motion an asymmetric branch touches tr = 1 + r^4 without crossing: rounding there is no event.
    asymmetric = np.array([not strand.symmetric for strand in curve.strands])[which]
    touching = asymmetric & (np.abs(orbit.u) < 1e-9) & curve.horizontal
    values[touching, 3] = np.nan
    with np.errstate(invalid="ignore"):
        crossing = (values[1:] > 0) != (values[:-1] > 0)
    crossing &= ~np.isnan(values[1:]) & ~np.isnan(values[:-1]) & (owner[1:] == owner[:-1])[:, None]
    crossing &= np.abs(values[1:]) + np.abs(values[:-1]) < 1e6
    row, kind = np.nonzero(crossing)
    root = _roots(curve, which[row], w[row], w[row + 1], kind, ROUGH) if row.size else np.empty(0)
    result = []
    for i, piece in enumerate(found):
        mine = owner[row] == i
        all_w = np.concatenate([piece.w, root[mine]])
        all_events = np.concatenate([piece.event, kind[mine].astype(np.int8)])
        order = np.argsort(all_w, kind="stable")
        result.append(Piece(piece.strand, all_w[order], all_events[order]))
    return result
