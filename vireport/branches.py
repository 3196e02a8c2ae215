"""Branches of motions along a sweep: sampled as finely as a drawing shows, ending exactly where they end.

A level curve is refined by bisection in the plane that is drawn, cut where it leaves the sweep or where an impact velocity vanishes, and
the points are located at which the ball grazes a membrane or the type of stability changes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from vireport.admissibility import wall_gap
from vireport.model import Sweep
from vireport.orbits import Level, Orbits
from vireport.stability import discriminant, trace_and_determinant
from vireport.strands import Strand, bisect, evaluate, find_strands

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

FIRST_SAMPLES = 97
"""Samples of a strand before refinement; odd, so that the symmetric motion q = 1/2 is one of them."""

SMOOTHNESS = 4e-4
"""Largest distance of the curve from the drawn polyline, as a share of the axes: about a quarter of a pixel."""

LONGEST_CHORD = 0.04
"""Longest step of the polyline as a share of the axes, so that no feature of that size hides between two samples."""

PASSES = 60
"""Bisections of one first step: enough to come from 1/96 of a strand down to rounding."""

EVENTS = ("period_doubling", "node_focus", "node_focus", "fold", "grazing", "bottom_rest", "top_rest", "start", "end")
"""What can happen along a strand, in the order of the columns of `event_values`."""

ROUGH = 1e-7
"""Tolerance of a parameter at which an event is found before it is polished."""

GRAZING, VALIDITY = 4, slice(5, 9)


@dataclass(frozen=True, slots=True)
class Curve:
    """A level curve ready to be evaluated.

    Attributes
    ----------
    sweep : Sweep
    level : Level
    strands : list of Strand
    bounds : tuple of float
        Range of the sweep's coordinate that is asked for.
    """

    sweep: Sweep
    level: Level
    strands: list[Strand]
    bounds: tuple[float, float]

    @property
    def r(self) -> float:
        """Restitution coefficient."""
        return self.sweep.device.restitution

    @property
    def n(self) -> int:
        """Forcing periods per motion."""
        return self.sweep.device.period_ratio

    def at(self, which: Ints, w: Floats) -> Orbits:
        """Motions at parameters `w` of the strands `which`."""
        return evaluate(self.strands, which, w, self.level, self.r, self.n)

    def event_values(self, orbit: Orbits, with_gap: object = True) -> Floats:
        """Functions whose zeros are the `EVENTS`, one column each; the last four are positive exactly on what may be a motion.

        The gap costs most; it is NaN outside the mask `with_gap` and where there can be no motion.
        """
        r, (low, high) = self.r, self.bounds
        coordinate = self.sweep.coordinate(orbit)
        validity = [
            orbit.velocity_bottom,
            -orbit.velocity_top,
            (coordinate - low) / (high - low),
            (high - coordinate) / (high - low),
        ]
        with np.errstate(all="ignore"):
            trace = trace_and_determinant(orbit, r)[0]
        one, two = 1 + r**4, 2 * r * r
        gap = np.full(trace.shape, np.nan)
        inside = (np.min(validity, axis=0) > 0) & with_gap
        if inside.any():
            gap[inside] = wall_gap(select(orbit, inside), r, self.n)
        # Without restitution Delta = tr^2 touches zero and never falls below it: no motion is a focus.
        foci = [trace + two, trace - two] if r > 0 else [np.full(trace.shape, np.nan)] * 2
        return np.stack([trace + one, *foci, trace - one, gap, *validity], axis=-1)


def curve_of(sweep: Sweep, bounds: tuple[float, float] | None = None) -> Curve:
    """Find the level curve of a sweep, restricted to its own range or to other bounds of its coordinate."""
    level = sweep.level
    device = sweep.device
    strands = find_strands(level, device.restitution, device.period_ratio)
    return Curve(sweep, level, strands, bounds or sweep.coordinate_range)


def select(orbit: Orbits, index: object) -> Orbits:
    """The motions picked by an index or mask."""
    return Orbits(*(np.asarray(getattr(orbit, field.name))[index] for field in fields(Orbits)))  # type: ignore[index]


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Parameters along the strands, in order, and what was evaluated there.

    Attributes
    ----------
    which, w : ndarray
        Strand and parameter of each sample.
    valid : ndarray of bool
        Inside the sweep, with impact velocities of the right sign.
    validity : ndarray
        The least of the functions that decide it.
    drawn : ndarray, shape (len, columns)
        The sample in the planes that are drawn, each axis scaled to 1.
    """

    which: Ints
    w: Floats
    validity: Floats
    drawn: Floats


def sample(curve: Curve, coarseness: float = 1.0) -> Samples:
    """Sample every strand, finer wherever the drawn curve bends, jumps, or may enter the sweep unseen.

    Parameters
    ----------
    curve : Curve
    coarseness : float
        Factor on `SMOOTHNESS`, and its square root on `LONGEST_CHORD`.
    """
    smooth, longest = SMOOTHNESS * coarseness, LONGEST_CHORD * coarseness**0.5
    which = np.repeat(np.arange(len(curve.strands)), FIRST_SAMPLES)
    w = np.concatenate([np.linspace(s.start, s.end, FIRST_SAMPLES) for s in curve.strands] or [np.empty(0)])
    samples = _samples(curve, which, w)
    active = np.ones(max(len(w) - 1, 0), dtype=bool)
    for _ in range(PASSES):
        same = samples.which[1:] == samples.which[:-1]
        index = np.nonzero(active & same & _relevant(samples))[0]
        if not index.size:
            break
        middle = _samples(curve, samples.which[index], (samples.w[index] + samples.w[index + 1]) / 2)
        chord = samples.drawn[index + 1] - samples.drawn[index]
        bend = middle.drawn - samples.drawn[index] - chord / 2
        coarse = (np.linalg.norm(bend, axis=1) > smooth) | (np.linalg.norm(chord, axis=1) > longest)
        seen = (middle.validity > 0) | (samples.validity[index] > 0) | (samples.validity[index + 1] > 0)
        coarse &= np.abs(middle.w - samples.w[index]) > np.where(seen, 1e-13, 1e-9)
        active = np.zeros(len(samples.w) - 1, dtype=bool)
        active[index] = coarse
        active = np.insert(active, index + 1, coarse)
        samples = Samples(*(
            np.insert(getattr(samples, f.name), index + 1, getattr(middle, f.name), axis=0) for f in fields(Samples)
        ))
    return samples


def _samples(curve: Curve, which: Ints, w: Floats) -> Samples:
    orbit = curve.at(which, w)
    events = curve.event_values(orbit, with_gap=False)
    r, trace = curve.r, events[:, 0] - (1 + curve.r**4)
    low, high = curve.bounds
    speed = 1 + (1 + r) / (1 - r) / np.pi
    with np.errstate(all="ignore"):
        root = np.sqrt(np.abs(np.clip(discriminant(trace, r), -4.0, 4.0)))
        # The trace passes through infinity where an impact velocity vanishes; faded out there, the eigenvalues stay continuous.
        fade = np.clip(-100 * orbit.velocity_bottom * orbit.velocity_top, -1.0, 1.0) / 3
        drawn = np.stack(
            [
                (curve.sweep.coordinate(orbit) - low) / (high - low),
                orbit.velocity_bottom / speed,
                orbit.velocity_top / speed,
                orbit.cos_phi / (2 * np.pi),
                orbit.sin_phi / (2 * np.pi),
                orbit.u,
                fade * np.clip((trace + root) / 2, -1.5, 1.5),
                fade * np.clip((trace - root) / 2, -1.5, 1.5),
            ],
            axis=-1,
        )
    return Samples(which, w, events[:, VALIDITY].min(axis=1), np.nan_to_num(drawn))


def _relevant(samples: Samples) -> NDArray[np.bool_]:
    """Steps that touch a valid sample, or whose neighbourhood's least validity peaks so that it may rise above zero in between."""
    v = samples.validity
    touches = (v[1:] > 0) | (v[:-1] > 0)
    inner = v[1:-1]
    rise = 2 * inner - np.minimum(v[:-2], v[2:])  # the peak, if it stands as far above as the lower neighbour below
    hopeful = (inner < 0) & (inner >= v[:-2]) & (inner >= v[2:]) & (rise > 0)
    touches[:-1] |= hopeful
    touches[1:] |= hopeful
    return np.asarray(touches)


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A connected run of possible motions inside the sweep, with the events on it.

    Attributes
    ----------
    strand : int
    w : ndarray
        Parameters, ascending; events are among them.
    event : ndarray of int
        Index into `EVENTS` for each parameter, -1 for an ordinary sample.
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
    """Runs of valid samples of strand k, each with the invalid parameter on either side (None where the strand itself ends)."""
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
            body = part[~np.isin(part, inner)]
            yield (
                k,
                np.concatenate([lead, body, tail]),
                before if i == 0 else None,
                after if i == len(parts) - 1 else None,
            )


def _symmetric_points(curve: Curve, strand: Strand) -> list[float]:
    """Parameters at which an asymmetric strand of a horizontal capsule passes through the symmetric motion: its two halves are mirror images."""
    if curve.level.kind != "gbar" or curve.level.value != 0 or curve.n % 2 == 0 or strand.low == strand.high:
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
        root = _roots(curve, index, good, bad, kind + VALIDITY.start)
        values = curve.event_values(curve.at(index, root), with_gap=False)[:, VALIDITY]
        worse = values.argmin(axis=1)
        wrong = (values.min(axis=1) < -1e-12) & (worse != kind)
        if not wrong.any():
            break
        bad, kind = np.where(wrong, root, bad), np.where(wrong, worse, kind)
    return [
        [(float(root[i]), int(kind[i]) + VALIDITY.start), (float(root[i + 1]), int(kind[i + 1]) + VALIDITY.start)]
        for i in range(0, len(root), 2)
    ]


def _roots(curve: Curve, which: Ints, low: Floats, high: Floats, kind: Ints, tolerance: float = 0.0) -> Floats:
    """Parameters between `low` and `high` at which the event of each row happens."""
    rows, grazing = np.arange(len(which)), kind == GRAZING

    def function(w: Floats) -> Floats:
        return np.asarray(curve.event_values(curve.at(which, w), grazing)[rows, kind])

    return bisect(function, low, high, tolerance)


def _with_inner_events(curve: Curve, found: list[Piece]) -> list[Piece]:
    """Insert the changes of stability and the grazing points into the pieces."""
    which = np.concatenate([np.full(len(p.w), p.strand) for p in found])
    owner = np.concatenate([np.full(len(p.w), i) for i, p in enumerate(found)])
    w = np.concatenate([p.w for p in found])
    orbit = curve.at(which, w)
    values = curve.event_values(orbit)[:, : GRAZING + 1]
    ends = np.concatenate([_end_mask(p) for p in found])
    values[ends & np.isnan(values[:, GRAZING]), GRAZING] = np.nan
    # On the symmetric motion an asymmetric branch touches tr = 1 + r^4 without crossing: rounding there is no event.
    touching = (curve.level.kind == "gbar") & (curve.level.value == 0) & (np.abs(orbit.u) < 1e-9)
    touching &= np.array([curve.strands[k].low < curve.strands[k].high for k in which])
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


def _end_mask(piece: Piece) -> NDArray[np.bool_]:
    mask = np.zeros(len(piece.w), dtype=bool)
    mask[[0, -1]] = True
    return mask
