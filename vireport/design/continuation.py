"""Motions followed from a design point along straight lines in (d, gbar, r), up to where each stops being stable.

Length and frequency move a device along a line of constant gbar, the force and the capsule's mass along a ray from the
origin, inclination and restitution along gbar and r. On a line, motions are a smooth curve in (q, phase, position on
the line). It is followed in steps along its tangent, each corrected by Newton's method with the derivatives of the
closed form, all lines and both directions side by side. The tangent is the vector product of the two conditions'
gradients: it turns gently along one curve, and is reversed on another that comes near it, so that no step is accepted
that has left its curve.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.motions import (
    CriticalKind,
    Held,
    Level,
    Orbits,
    StrandEvent,
    bracketed_root,
    coefficients,
    level_terms,
    may_hide_zeros,
    orbits,
    orbits_above,
    return_trace,
    stability_border,
    wall_gap,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

IMAGINARY = 1e-30
"""Imaginary step that gives the derivative of an analytic function to the last digit."""

IMAGINARY_STEPS = 1j * IMAGINARY * np.eye(3)[:, None, :]
"""One along each coordinate of a point."""

FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.02, 0.08, 1e-15
"""Steps along the curve, in units of q, of radians and of the position on a line: no feature of a motion is known that
hides in the longest; where the shortest does not do, rounding does not resolve the curve."""

GENTLE_TURN = 0.98
"""Cosine of the largest angle between tangents at the ends of a step."""

STRAIGHT = 0.998
"""The same, up to which the next step is longer."""

SETTLED = 1e-2
"""Second Newton correction, as a share of the step, up to which the point is on the curve: the next would be at
rounding."""

MOST_STEPS = 1000
"""Steps after which a motion is given up; forty are usual."""

BRACKET = 1e-5
"""Share of a step within which an event is located; what follows polishes it."""

DIP_SAMPLES = 9
"""Points of a step, and then around the lowest of them, at which an extremum is looked for."""

MOST_EVENTS = 4
"""Events of one step that are located until the first of them is."""

CORRECTIONS = 2
"""Newton corrections that take the middle of a step onto the curve."""

AT_SYMMETRY = 1e-4
"""|u| below which an asymmetric motion that comes to the symmetric family touches the border of stability, and does not
cross it."""

EVENTS = (
    StrandEvent.DOUBLING,
    StrandEvent.MEETING,
    StrandEvent.GRAZING,
    StrandEvent.BOTTOM_REST,
    StrandEvent.TOP_REST,
    StrandEvent.START,
    StrandEvent.END,
    CriticalKind.PITCHFORK,
)
"""What the columns of `_health` stand for: START and END are those of the line, and at a pitchfork an asymmetric motion
becomes its own mirror image."""

GAP = EVENTS.index(StrandEvent.GRAZING)
"""Column of the smallest distance to a membrane, which costs most."""


@dataclass(frozen=True, slots=True, eq=False)
class Paths:
    """Curves to be followed, side by side; arrays of one length but for the start of the lines.

    Attributes
    ----------
    origin : tuple of float
        d, gbar and r of the design point.
    n : int
        Forcing periods per motion.
    growth, shift : ndarray, shape (count, 3)
        How d, gbar and r change with the position t on the line of each: the start times exp(growth t), plus shift t.
    low, high : ndarray
        Positions at which the lines end; the design point has the position 0.
    sign : ndarray
        Whether the position shall grow or fall at the beginning, 1 or -1.
    symmetric : ndarray of bool
        Motions of a horizontal capsule that are their own mirror images, on a line without gravity.
    divided : ndarray of bool
        Others on such a line: the symmetric family is divided out of their equations.
    x : ndarray, shape (count, 3)
        Where each begins: u = q - 1/2, phase, position.
    source : ndarray of int
        What the caller knows each by.
    handed_over : ndarray of bool
        Whether each begins at a pitchfork, whose two families touch the border of stability there.
    """

    origin: tuple[float, float, float]
    n: int
    growth: Floats
    shift: Floats
    low: Floats
    high: Floats
    sign: Floats
    symmetric: Mask
    divided: Mask
    x: Floats
    source: Ints
    handed_over: Mask

    def select(self, index: Any) -> Paths:
        """Those picked by an index or mask."""
        return replace(self, **{name: getattr(self, name)[index] for name in COLUMNS})

    def motions(self, x: Any) -> tuple[Orbits, Any]:
        """The motions at points (..., count, 3), and their restitution."""
        r = self.origin[2] + x[..., 2] * self.shift[:, 2]
        return orbits(x[..., 0], x[..., 1], r, self.n), r

    def conditions(self, x: Any) -> tuple[Any, Any]:
        """The two conditions that hold on the curves, at points (..., count, 3)."""
        u, phi, position = x[..., 0], x[..., 1], x[..., 2]
        groups = np.array(self.origin) * np.exp(position[..., None] * self.growth) + position[..., None] * self.shift
        d, gbar, r = (groups[..., k] for k in range(3))
        k = coefficients(u, r, self.n)
        orbit = orbits_above(k, u, phi, r, self.n)
        second = np.where(self.symmetric, u, orbit.gbar - gbar)
        if self.divided.any():
            a, b, _ = level_terms(Level(Held.GBAR, 0.0), k, u, r, self.n)
            second = np.where(self.divided, a * orbit.sin_phi + b * orbit.cos_phi, second)
        return orbit.d - d, second

    def linearised(self, x: Floats) -> list[tuple[Floats, Floats]]:
        """Each of the conditions at points (count, 3): its values (count, 1) and its gradients (count, 3)."""
        conditions = self.conditions(x + IMAGINARY_STEPS)
        return [(of[0].real[:, None], of.imag.T / IMAGINARY) for of in conditions]


COLUMNS = tuple(field.name for field in fields(Paths) if field.name not in ("origin", "n"))
"""What `Paths` has of each path."""


@dataclass(frozen=True, slots=True, eq=False)
class Endpoint:
    """Where a followed motion stops being a stable one.

    Attributes
    ----------
    source : int
        Of the path.
    event : StrandEvent or None
        START or END where the line ends first; None where rounding does not resolve the curve any farther.
    x : ndarray
        u, phase and position.
    symmetric : bool
        Whether the motion is its own mirror image.
    pitchfork : bool
        Whether a symmetric motion ends where asymmetric ones meet it, rather than in a fold.
    """

    source: int
    event: StrandEvent | None
    x: Floats
    symmetric: bool
    pitchfork: bool = False


def follow(paths: Paths) -> list[Endpoint]:
    """Follow stable motions until each stops being stable or admissible, or its line ends.

    A motion of a horizontal capsule that meets a pitchfork goes on as the motion that takes over its stability.
    """
    ends: list[Endpoint] = []
    with np.errstate(all="ignore"):  # a step that leaves the range of doubles is not accepted
        while len(paths.source):
            found, onward = _ends(paths)
            ends += found
            paths = _joined(onward) if onward else paths.select(slice(0))
    return ends


def _ends(paths: Paths) -> tuple[list[Endpoint], list[Paths]]:
    """Where the motions on some paths end, and the paths on which others go on beyond a pitchfork."""
    ends, onward = [], []
    for k, (event, x, slopes) in enumerate(_events(paths, _traced(paths))):
        symmetric, source = bool(paths.symmetric[k]), int(paths.source[k])
        if event is StrandEvent.MEETING and paths.handed_over[k] and x[2] == paths.x[k, 2]:
            ends.append(Endpoint(source, event, x, True, pitchfork=True))  # no motion takes over its stability
        elif event is CriticalKind.PITCHFORK:
            onward.append(_handed_over(paths.select([k]), x, symmetric=True))
        elif symmetric and event is StrandEvent.MEETING and slopes[0] * slopes[1] > 0:
            onward.append(_handed_over(paths.select([k]), x, symmetric=False))
        else:
            ends.append(Endpoint(source, event, x, symmetric))
    return ends, onward


def _handed_over(path: Paths, x: Floats, symmetric: bool) -> Paths:
    """The path on which a motion goes on beyond a pitchfork."""
    start = np.array([[0.0, x[1], x[2]]])
    own = np.array([symmetric])
    return replace(path, x=start, symmetric=own, divided=~own, handed_over=np.array([True]))


def _joined(parts: list[Paths]) -> Paths:
    columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS}
    return replace(parts[0], **columns)


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """Points on a curve, in order (shape (points, 3)), and the tangent at each."""

    x: Floats
    tangent: Floats


def _cross(a: Floats, b: Floats) -> Floats:
    """Vector products of arrays of shape (count, 3)."""
    (a0, a1, a2), (b0, b1, b2) = a.T, b.T
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=1)


def _size(vectors: Floats) -> Floats:
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))


def _corrected(paths: Paths, x: Floats, normal: Floats) -> tuple[Floats, Floats, Floats]:
    """One Newton correction across `normal`.

    Returns
    -------
    ndarray, shape (count, 3)
        The new points.
    ndarray
        Size of the corrections; infinite where the conditions do not determine one.
    ndarray, shape (count, 3)
        Unit tangents at `x` of the curves on which the conditions keep their values.
    """
    (f, a), (g, b) = paths.linearised(x)
    along = _cross(a, b)
    volume = np.einsum("ij,ij->i", along, normal)  # determinant of both gradients and the normal
    usable = np.abs(volume) > 0
    step = _cross(f * b - g * a, normal) / np.where(usable, volume, 1.0)[:, None]  # by Cramer's rule
    length = _size(along)
    return x - step, np.where(usable, _size(step), np.inf), along / np.where(length == 0, 1.0, length)[:, None]


def _traced(paths: Paths) -> list[Trace]:
    """Points along the curves, each up to a step beyond the first in which a motion is not known to be stable."""
    x, count = paths.x.copy(), len(paths.source)
    tangent = _corrected(paths, x, x)[2]
    # Where an asymmetric motion leaves the symmetric one, its position does not change at first, and u takes its part.
    growing = np.where(paths.handed_over & paths.divided, tangent[:, 0], paths.sign * tangent[:, 2])
    orientation = np.where(growing < 0, -1.0, 1.0)[:, None]
    tangent *= orientation
    step, beyond = np.full(count, FIRST_STEP), np.zeros(count, dtype=int)
    points, tangents = [[start] for start in paths.x], [[start] for start in tangent.copy()]
    active = np.arange(count)
    for _ in range(MOST_STEPS):
        if not active.size:
            break
        part, t, h = paths.select(active), tangent[active], step[active]
        y, first, _ = _corrected(part, x[active] + h[:, None] * t, t)
        y, second, new = _corrected(part, y, t)
        new *= orientation[active]
        along = np.einsum("ij,ij->i", new, t)
        good = (second <= SETTLED * h) & (first <= h) & (along > GENTLE_TURN) & np.isfinite(y).all(axis=1)
        moved, y, new = active[good], y[good], new[good]
        x[moved], tangent[moved] = y, new
        for k, point, direction in zip(moved, y, new, strict=True):
            points[k].append(point)
            tangents[k].append(direction)
        failing = _health(part.select(good), y, with_gap=False).min(axis=1) <= 0
        beyond[moved] += failing | (beyond[moved] > 0)
        longer = moved[along[good] > STRAIGHT]
        step[active[~good]] /= 2
        step[longer] = np.minimum(step[longer] * 1.6, LONGEST_STEP)
        active = active[(beyond[active] < 2) & (step[active] > SHORTEST_STEP)]
    return [Trace(np.array(points[k]), np.array(tangents[k])) for k in range(count)]


def _health(paths: Paths, x: Floats, with_gap: bool) -> Floats:
    """Functions that are positive on stable motions, by the columns of `EVENTS`, at points (count, 3)."""
    orbit, r = paths.motions(x)
    with np.errstate(all="ignore"):
        trace = np.asarray(return_trace(orbit, r))
        border = stability_border(r)
        scale = 1 + np.abs(trace)  # finite where an impact velocity vanishes and the trace diverges
        doubling, meeting = (border + trace) / scale, (border - trace) / scale
    valid = (orbit.velocity_bottom > 0) & (orbit.velocity_top < 0)
    gap = np.ones(len(x))
    if with_gap and valid.any():
        gap[valid] = wall_gap(orbit.select(valid), r[valid], paths.n)
    start = np.sign(paths.x[:, 0])
    mirrored = paths.divided & ~paths.handed_over
    mirror = np.where(mirrored, start * x[:, 0], 1.0)
    meeting = np.where(mirrored & (np.abs(x[:, 0]) < AT_SYMMETRY), 1.0, meeting)
    start_of_line = np.where(paths.sign < 0, x[:, 2] - paths.low, 1.0)
    end_of_line = np.where(paths.sign > 0, paths.high - x[:, 2], 1.0)
    rest = (orbit.velocity_bottom, -orbit.velocity_top, start_of_line, end_of_line)
    values = np.array([np.where(valid, doubling, 1.0), np.where(valid, meeting, 1.0), gap, *rest, mirror]).T
    return np.where(np.isnan(values), 1.0, values)


def _events(paths: Paths, traces: list[Trace]) -> list[tuple[Any, Floats, tuple[float, float]]]:
    """What ends each path, of `EVENTS`, or None; where; and the slopes of the position around it."""
    owner = np.concatenate([np.full(len(trace.x), k) for k, trace in enumerate(traces)])
    x = np.concatenate([trace.x for trace in traces])
    values = _health(paths.select(owner), x, with_gap=True)
    steps, ended, gaps = [], [], []
    for k, trace in enumerate(traces):
        own = values[owner == k]
        if paths.handed_over[k]:  # both families touch the border at the pitchfork itself
            own[0] = 1.0
            turned_back = len(own) > 1 and (trace.x[1, 2] - trace.x[0, 2]) * paths.sign[k] <= 0
            if turned_back and paths.divided[k]:
                own[1, EVENTS.index(StrandEvent.MEETING)] = -1.0
        bad = np.flatnonzero(own.min(axis=1) <= 0)
        last = int(bad[0]) if bad.size else len(own) - 1
        steps.append((max(last - 1, 0), last))
        ended.append(bool(bad.size))
        gaps.append(bool(own[last, GAP] <= 0))
    share = np.ones(len(traces))
    for k, row, at in _dips(paths, traces, values, owner, steps):
        steps[k], share[k], ended[k], gaps[k] = (row, row + 1), at, True, True
    low = np.array([trace.x[a] for trace, (a, _) in zip(traces, steps, strict=True)])
    high = np.array([trace.x[b] for trace, (_, b) in zip(traces, steps, strict=True)])
    where, failing = _located(paths, low, high, share, np.array(gaps))
    found = []
    for k, (a, b) in enumerate(steps):
        event = EVENTS[failing[k]]
        slopes = float(traces[k].tangent[a][2]), float(traces[k].tangent[b][2])
        at_pitchfork = bool(paths.handed_over[k]) and a == 0 and event is StrandEvent.MEETING
        found.append((event if ended[k] else None, paths.x[k] if at_pitchfork else where[k], slopes))
    return found


def _dips(
    paths: Paths, traces: list[Trace], values: Floats, owner: Ints, steps: list[tuple[int, int]]
) -> list[tuple[int, int, float]]:
    """Steps before those given within which a function of `_health` falls below zero and comes back: path, step, share.

    Looked for where a function comes near zero, twice on an ever finer grid.
    """
    rows = []
    for k, (_, last) in enumerate(steps):
        own = values[owner == k][: last + 1, : GAP + 1]
        if len(own) > 2:
            rows += [(k, int(row) + side) for row in np.flatnonzero(may_hide_zeros(own).any(axis=1)) for side in (0, 1)]
    if not rows:
        return []
    part = paths.select(np.repeat([k for k, _ in rows], DIP_SAMPLES))
    low, high = (np.repeat([traces[k].x[row + end] for k, row in rows], DIP_SAMPLES, axis=0) for end in (0, 1))
    middle, width = np.full(len(rows), 0.5), 0.5
    for _ in range(2):
        share = np.clip(middle[:, None] + width * np.linspace(-1, 1, DIP_SAMPLES), 0.0, 1.0)
        x = _between(part, low, high, share.ravel())
        height = _health(part, x, with_gap=True).min(axis=1).reshape(share.shape)
        middle, width = share[np.arange(len(rows)), height.argmin(axis=1)], 2 * width / (DIP_SAMPLES - 1)
    found: dict[int, tuple[int, int, float]] = {}
    for (k, row), share_of, value in zip(rows, middle, height.min(axis=1), strict=True):
        if value < 0 and k not in found:
            found[k] = k, row, float(share_of)
    return list(found.values())


def _located(paths: Paths, low: Floats, high: Floats, bound: Floats, with_gap: Mask) -> tuple[Floats, Ints]:
    """Where on the steps from `low` to `high` a function of `_health` first falls to zero, and which one."""
    rows, gaps = np.arange(len(low)), bool(with_gap.any())
    start = np.where(paths.handed_over & (low == paths.x).all(axis=1), BRACKET, 0.0)
    at_start = _health(paths, _between(paths, low, high, start), gaps)
    at_bound = _health(paths, _between(paths, low, high, bound), gaps)
    for _ in range(MOST_EVENTS):
        falling = (at_start > 0) & (at_bound <= 0)
        share = np.where(falling, at_start / (at_start - at_bound), np.inf)
        column = np.where(falling.any(axis=1), share.argmin(axis=1), at_bound.argmin(axis=1))

        def value(share: Floats, column: Ints = column) -> Floats:
            at = _between(paths, low, high, share)
            return np.asarray(_health(paths, at, gaps and bool((column == GAP).any()))[rows, column])

        root = bracketed_root(value, start, bound, BRACKET, (at_start[rows, column], at_bound[rows, column]))
        x = _between(paths, low, high, root)
        at_root = _health(paths, x, gaps)
        others = at_root.copy()
        others[rows, column] = 1.0
        earlier = (others.min(axis=1) < 0) & (root < bound)
        if not earlier.any():
            break
        bound, at_bound = np.where(earlier, root, bound), np.where(earlier[:, None], at_root, at_bound)
    return x, column


def _between(paths: Paths, low: Floats, high: Floats, share: Floats) -> Floats:
    """Points of the curves at a share of steps."""
    chord = high - low
    x = low + share[:, None] * chord
    for _ in range(CORRECTIONS):
        x = _corrected(paths, x, chord)[0]
    return x
