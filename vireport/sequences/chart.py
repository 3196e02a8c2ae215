"""Every locus that is reached in the plane of two inputs, joined where loci meet.

Families along some sweeps across the plane give the starts; each locus is followed to its ends, and at each point of
codimension two, where loci meet or end, those through it are starts again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from decimal import Decimal, localcontext
from itertools import chain, combinations, pairwise
from math import inf, pi, prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import CriticalKind, Sweep, newton, solve
from vireport.errors import NumericalError
from vireport.physics import ARRAYS, DIGITS, FLOATS, DecimalOps, Device
from vireport.scenario import DesignInput, Parameter
from vireport.sequences.atlas import atlas
from vireport.sequences.continuation import Arc, Event, Point, completed, follow
from vireport.sequences.equations import linearised, residuals, weighted_trace
from vireport.sequences.exclusion import FINE
from vireport.sequences.families import Atlas
from vireport.sequences.loci import Condition, Locus, Plane
from vireport.sequences.motions import BESIDE, IMAGE, Motion, Sequence, turns
from vireport.sequences.switching import Limits, at_rest, off, touching

Floats = NDArray[np.float64]

CUTS, SOLVED_CUTS = 3, 16
"""Sweeps across the plane along each input, on which loci are looked for: of all motions, and of 1:1 motions, which are
in closed form."""

SAME_LOCUS, NEAR = 1e-6, 0.1
"""Distance, in the unknowns over their scale, up to which a motion is on a locus; and from the nearest point of the
locus, up to which that is tried."""

MEETS = 1e-6
"""Value of another event's condition, over the motion's velocities, up to which it holds at a point as well."""

AT_CUSP = Decimal("1e-12"), 1e-4
"""Steps along the null vector, of derivatives of the trace in decimals and in doubles."""

AT_DEGENERATE = Decimal("1e-12"), 1e-2
"""Amplitudes of doubled motions that are taken instead of derivatives by it, in decimals and in doubles."""

AT_EDGE, SAME_POINT = 1e-6, 1e-6
"""Shares of the range: from the plane's edge, within which what happens is that of the edge, and between two points."""

DEGENERATE = {
    Event.PERIOD_DOUBLING: Event.DEGENERATE_DOUBLING,
    Event.PITCHFORK: Event.DEGENERATE_PITCHFORK,
}
"""Where it changes from soft to hard."""

SAME_MOTION = 1e-4
"""Difference of velocities and times up to which the motions of two such points are one: where no polish applies, half
of the digits are left."""

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class FollowedLocus:
    """A locus within a plane.

    Attributes
    ----------
    path : Locus
    x : ndarray (n, 2N + 2)
        Velocities, times and inputs of its motions, in order.
    trace : ndarray (n,)
        At grazing points, of the motion without the touch.
    events : tuple of (int, Event)
        Rows at which something else happens as well; the first and last end it.
    """

    path: Locus
    x: Floats
    trace: Floats
    events: tuple[tuple[int, Event], ...]

    @property
    def event(self) -> Event:
        """What happens on it."""
        return self.path.condition.event

    @property
    def word(self) -> str:
        """The motion's, without a touch."""
        return self.path.touched.canonical().word

    @property
    def inputs(self) -> Floats:
        """The two inputs along it, (n, 2)."""
        return self.x[:, -2:]

    def drawn(self, parts: int = 6) -> Floats:
        """The inputs along it, each piece between two points divided, by a spline over the arclength."""
        from scipy.interpolate import CubicSpline  # type: ignore[import-untyped]

        lengths = np.linalg.norm(np.diff(self.x / self.path.scale, axis=0), axis=1)
        kept = np.append(True, lengths > 0)
        at = np.append(0.0, np.cumsum(lengths))
        fine = np.append(np.linspace(at[:-1], at[1:], parts, endpoint=False, axis=1).ravel(), at[-1])
        return np.asarray(CubicSpline(at[kept], self.inputs[kept])(fine)) if kept.sum() > 1 else self.inputs

    @property
    def bounds_stability(self) -> NDArray[np.bool_]:
        """Of the pieces between its points, whether stable motion ends there."""
        if self.event is Event.NODE_FOCUS:
            return np.zeros(len(self.x) - 1, dtype=bool)
        if self.event is not Event.GRAZING:
            return np.ones(len(self.x) - 1, dtype=bool)
        r = np.array([float(self.path.plane.at(p)[2]) for p in self.inputs.tolist()])
        stable = np.abs(self.trace) < 1 + r ** (2 * len(self.path.touched)) + MEETS
        return np.asarray(stable[1:] & stable[:-1])

    def at(self, held: int, value: float) -> list[Floats]:
        """Where it crosses a value of one of the inputs: the unknowns of its motions there."""
        size = self.x.shape[1]
        place, found = size - 2 + held, []
        p = self.x[:, place]
        for i in np.flatnonzero((p[:-1] - value) * (p[1:] - value) <= 0):
            step = p[i + 1] - p[i]
            guess = self.x[i] + (((value - p[i]) / step) if step else 0.5) * (self.x[i + 1] - self.x[i])
            guess[place] = value
            x = self.path.solved(guess, np.eye(size)[place])
            if x is not None:
                found.append(x)
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """A point of codimension two, where loci meet, end or touch.

    Attributes
    ----------
    events : tuple of Event
        Both that happen there, the second one `GRAZING` where a membrane is touched.
    motion : Motion
        With its touches as impacts of velocity zero.
    inputs, error_bound : tuple of float
        Values of the two inputs, in their units; what bounds their errors is inf where it is not known.
    """

    events: tuple[Event, Event]
    motion: Motion
    inputs: tuple[float, float]
    error_bound: tuple[float, float]

    @property
    def word(self) -> str:
        """The motion's, without touches."""
        return self.motion.without_impacts(at_rest(self.motion)).sequence.canonical().word


@dataclass(frozen=True, slots=True)
class Cut:
    """A sweep across the plane: which input varies, the value of the other, and the stable words between breaks."""

    varied: int
    other: float
    stable: tuple[tuple[float, float, tuple[str, ...]], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """Loci in a plane, the points where they meet, and what is stable along some sweeps across it."""

    plane: Plane
    limits: Limits
    loci: tuple[FollowedLocus, ...]
    meetings: tuple[Meeting, ...]
    cuts: tuple[Cut, ...]

    @property
    def not_followed(self) -> int:
        """Ends of loci, off the edges of the plane, beyond which nothing was found."""
        lost = [one.inputs[row] for one in self.loci for row, event in one.events if event is Event.LOST]
        return sum(self.plane.room(p) > AT_EDGE for p in lost)


def chart(plane: Plane, limits: Limits, progress: Progress = lambda what: None, cuts: int = CUTS) -> Chart:
    """Find the loci of the events of motions in a plane, and the points of codimension two.

    Parameters
    ----------
    plane : Plane
    limits : Limits
        Of the motions.
    progress : callable
        Called with what is done next.
    cuts : int
        Sweeps along each input on which motions of any sequence are looked for; none where only 1:1 motions are wanted.
    """
    search, crossed = _Search(plane, limits, None if cuts else _one_to_one(plane)), []
    for k, other in _cuts(plane, SOLVED_CUTS):
        progress(f"1:1 motions along the {plane.inputs[k].quantity}")
        for start in _one_to_one_events(plane, k, other):
            search.explore(*start)
    for k, other in _cuts(plane, cuts):
        progress(f"motions along the {plane.inputs[k].quantity}, {plane.inputs[1 - k].show(other)}")
        sweep = cut_sweep(plane, k, other)
        if not sweep.unresolved:
            families = atlas(sweep, limits, finest=FINE)
            crossed.append(Cut(k, other, _stable(families, plane, k, other)))
            for start in _events(families, plane, k, other):
                progress(f"loci of {start[0].sequence.word}")
                search.explore(*start)
    return Chart(plane, limits, tuple(search.loci), tuple(search.meetings), tuple(crossed))


Start = tuple[Motion, Floats, Event]
"""A motion with its touches as impacts of velocity zero, values of the inputs, and what happens there."""


def _one_to_one(plane: Plane) -> Sequence:
    return Sequence((1, -1), plane.device.period_ratio)


def _one_to_one_events(plane: Plane, k: int, other: float) -> Iterator[Start]:
    """The critical points of the 1:1 motions on a sweep across a plane."""
    sweep, sequence = cut_sweep(plane, k, other), _one_to_one(plane)
    try:
        points = [] if sweep.unresolved else solve(sweep).critical_points
    except NumericalError:
        points = []
    for critical in points:
        at = critical.point
        time = at.phi / pi + np.array([0.0, 2 * sequence.periods * (at.u + 0.5)])
        motion = Motion(sequence, np.array([at.velocity_bottom, at.velocity_top]), time, at.d)
        if critical.kind is CriticalKind.GRAZING:
            motion = touching(motion, turns(motion, at.d, at.gbar, float(sweep.device.restitution)))
        yield motion, _place(plane, k, at.sweep_value, other), Event(critical.kind)


def _cuts(plane: Plane, count: int) -> Iterator[tuple[int, float]]:
    """Which input varies, and the value of the other one."""
    for k in (1, 0):
        if plane.inputs[k] is not DesignInput.RESTITUTION:
            shares = (np.arange(count) + 0.5) / count
            for value in plane.low[1 - k] + plane.widths[1 - k] * shares:
                yield k, float(value)


def cut_sweep(plane: Plane, k: int, other: float) -> Sweep:
    """The sweep over one input at a value of the other.

    Along the capsule's mass the groups change as against the force's amplitude, which is swept instead.
    """
    ends = float(plane.low[k]), float(plane.high[k])
    device = plane.device_at([ends[0], other] if k == 0 else [other, ends[0]])
    if plane.inputs[k] is not DesignInput.CAPSULE_MASS:
        return Sweep(device, Parameter(plane.inputs[k].value), *ends)
    device = replace(device, capsule_mass_kg=plane.device.capsule_mass_kg)
    return Sweep(device, Parameter.AMPLITUDE, _mass(device, ends[1]), _mass(device, ends[0]))


def _mass(device: Device, amplitude: float) -> float:
    """The capsule's mass that moves as the device's does under another amplitude of the force, or the other way."""
    return float(device.capsule_mass_kg * device.amplitude_n / amplitude)


def _place(plane: Plane, k: int, swept: float, other: float) -> Floats:
    """Values of the inputs on a sweep across a plane."""
    if plane.inputs[k] is DesignInput.CAPSULE_MASS:
        amplitude = other if plane.inputs[1 - k] is DesignInput.AMPLITUDE else plane.device.amplitude_n
        swept = _mass(replace(plane.device, amplitude_n=amplitude), swept)
    return np.array([swept, other] if k == 0 else [other, swept])


def _events(families: Atlas, plane: Plane, k: int, other: float) -> Iterator[Start]:
    """The points on a sweep across a plane where families meet, or motions change between node and focus."""
    points = [(vertex.point, vertex.event) for vertex in families.vertices]
    marks = chain.from_iterable(family.marks for family in families.families)
    points += [(mark.point, mark.event) for mark in marks if mark.point and mark.event is Event.NODE_FOCUS]
    for point, event in points:
        yield point.motion, _place(plane, k, point.sweep_value, other), event


def _stable(families: Atlas, plane: Plane, k: int, other: float) -> tuple[tuple[float, float, tuple[str, ...]], ...]:
    """Between the ends of stable ranges, the words of the motions that are stable."""

    def place(pair: tuple[float, float]) -> list[float]:
        return sorted(float(_place(plane, k, value, other)[k]) for value in pair)

    ranges = [(place(pair), family.sequence.word) for family in families.families for pair in family.stable_ranges]
    ends = place((families.sweep.start, families.sweep.end))
    found = []
    for low, high in pairwise(sorted({*ends, *chain.from_iterable(pair for pair, _ in ranges)})):
        words = {word for (first, last), word in ranges if first < (low + high) / 2 < last}
        found.append((low, high, tuple(sorted(words, key=lambda word: (len(word), word)))))
    return tuple(found)


@dataclass(slots=True)
class _Search:
    plane: Plane
    limits: Limits
    only: Sequence | None
    loci: list[FollowedLocus] = field(default_factory=list)
    meetings: list[Meeting] = field(default_factory=list)
    queue: deque[tuple[Locus, Point]] = field(default_factory=deque)

    def explore(self, motion: Motion, p: Floats, event: Event) -> None:
        """Follow the locus of an event at a motion and values of the inputs, and all that it is joined to."""
        motion = _distinct(motion).canonical()
        guess, sign = np.concatenate([motion.velocity, motion.time, p]), 1
        if event is Event.NODE_FOCUS:
            weighted = weighted_trace(motion.sequence, guess.tolist(), self.plane.at(p.tolist()))
            sign = 1 if weighted * prod(motion.velocity) > 0 else -1
        path = Locus(motion.sequence, self.plane, Condition(event, at_rest(motion), sign))
        x = path.nearest(guess) if self._wanted(path) else None
        if x is not None and np.abs((x[-2:] - p) / self.plane.widths).max() < SAME_POINT:
            self._follow(path, path.point(x, path.tangent(x)))
        while self.queue:
            self._follow(*self.queue.popleft())

    def _wanted(self, path: Locus) -> bool:
        """Whether the motions of a locus are within the limits."""
        touched = path.touched
        if not len(touched) or (path.condition.event is Event.GRAZING and not path.condition.rests):
            return False  # at r = 0, a motion may touch its membrane in the very moment of the impact before
        wanted = self.only is None or self.only in (touched.canonical(), path.sequence.canonical())
        return wanted and self.limits.admit(touched)

    def _follow(self, path: Locus, first: Point) -> None:
        """Follow a locus both ways from a motion, unless it is known."""
        motion = path.motion(first.x)
        waits = np.diff(motion.time, append=motion.time[0] + 2 * motion.sequence.periods)
        if not path.admits(first.x) or waits.min() < BESIDE or _is_multiple(motion) or self._known(path, first.x):
            return
        strand = completed(path, first, follow(path, first))
        x = np.array([point.x for point in strand.points])
        trace = np.array([point.trace for point in strand.points])
        self.loci.append(FollowedLocus(path, x, trace, tuple(strand.events)))
        for row, event in strand.events:
            self._meet(path, strand.points[row].x, event)
        if path.condition.event in DEGENERATE:
            for point in _degenerate(path, strand.points):
                self._meet(path, point.x, DEGENERATE[path.condition.event])

    def _known(self, path: Locus, x: Floats) -> bool:
        """Whether a motion lies on a locus that has been followed, counted from any impact or in the mirror."""
        motion = path.motion(x)
        images = [motion, motion.mirrored()] if self.plane.horizontal else [motion]
        turned = [image.rotated(i) for image in images for i in range(len(path.sequence))]
        return any(
            _on(locus, np.concatenate([one.velocity, one.time, x[-2:]]))
            for locus in self.loci
            for one in turned
            if locus.event is path.condition.event
            and one.sequence == locus.path.sequence
            and at_rest(one) == locus.path.condition.rests
        )

    def _meet(self, path: Locus, x: Floats, event: Event) -> None:
        """Take up a point of codimension two, and start the loci through it."""
        of_type = path.condition.event is Event.NODE_FOCUS
        if event in (Event.SWEEP_END, Event.CLOSED, Event.LOST) or (of_type and event is Event.GRAZING):
            return
        motion, p = path.motion(x), x[-2:]
        if self.plane.room(p) < AT_EDGE:
            return
        if path.condition.event is Event.FOLD and event in DEGENERATE.values():
            locus, guess = path.origin(x, event is Event.DEGENERATE_DOUBLING)
            y = locus.nearest(guess) if self._wanted(locus) else None
            if y is not None:
                self.queue.append((locus, locus.point(y, locus.tangent(y))))
            return
        if event in (Event.GRAZING, Event.ZERO_VELOCITY):
            motion = touching(motion, path.turns(x))
        motion = _distinct(motion).canonical()
        twice = at_rest(motion) and _is_multiple(motion)  # a point of the other motion, known to half of the digits
        if twice or any(self._same(meeting, motion, p) for meeting in self.meetings):
            return
        events = _both(path.condition.event, event)
        if events[0] is Event.FOLD and self._symmetric(motion):
            events = Event.PITCHFORK, events[1]
        self.meetings.append(_polished(self.plane, motion, p, events))
        if event in DEGENERATE.values():
            folds, y, way = path.folds(x)
            self.queue.extend((folds, first) for _, first in off(folds, y, way) if self._wanted(folds))
        rests = at_rest(motion)
        for removed in chain.from_iterable(combinations(rests, count) for count in range(len(rests) + 1)):
            own = motion.without_impacts(removed)
            y = np.concatenate([own.velocity, own.time, p])
            for through in self._through(own, p):
                way = through.tangent(y)
                self.queue.extend((through, first) for side in (way, -way) for _, first in off(through, y, side))

    def _same(self, meeting: Meeting, motion: Motion, p: Floats) -> bool:
        near = np.abs((np.array(meeting.inputs) - p) / self.plane.widths).max() < SAME_POINT
        return bool(near) and meeting.motion.distance(motion, mirror=self.plane.horizontal) < SAME_MOTION

    def _symmetric(self, motion: Motion) -> bool:
        return self.plane.horizontal and motion.distance(motion.mirrored()) < IMAGE

    def _through(self, motion: Motion, p: Floats) -> Iterator[Locus]:
        """The loci through a point: of every condition that holds for a motion with some of its touches as impacts."""
        rests, groups = at_rest(motion), self.plane.at(p.tolist())
        x = [*motion.velocity.tolist(), *motion.time.tolist()]
        found = [Condition(Event.GRAZING, (rest,)) for rest in rests]
        if len(rests) < 2 and len(motion.sequence) > len(rests):
            fold = Event.PITCHFORK if self._symmetric(motion) else Event.FOLD
            traced = [Condition(event) for event in (Event.PERIOD_DOUBLING, fold)]
            traced += [Condition(Event.NODE_FOCUS, sign=sign) for sign in (1, -1)]
            found += [one for one in traced if abs(one.value(motion.sequence, x, groups, ARRAYS)) < MEETS]
        loci = (Locus(motion.sequence, self.plane, condition) for condition in found)
        return (path for path in loci if self._wanted(path))


def _distinct(motion: Motion) -> Motion:
    """A motion without impacts of velocity zero that are the same touch as another."""
    rests, period = at_rest(motion), 2 * motion.sequence.periods
    late = [(motion.time[j] - motion.time[i]) % period for i, j in zip(rests, (*rests[1:], *rests[:1]), strict=True)]
    return motion.without_impacts([j for j, wait in zip(rests[1:], late, strict=False) if wait < BESIDE])


def _degenerate(path: Locus, points: list[Point]) -> Iterator[Point]:
    """Where along a locus of period doublings or pitchforks these change from soft to hard."""
    values = [path.criticality(point) for point in points]
    for (point, new), ends in zip(pairwise(points), pairwise(values), strict=True):
        step, back = (float(one.tangent @ ((new.x - point.x) / path.scale)) for one in (point, new))
        # From the start of a locus tangents point both ways, and the criticality is of the side to the left of them.
        if ends[0] * ends[1] * step * back < 0:
            there = new if step * back > 0 else replace(new, tangent=-new.tangent)
            with suppress(NumericalError):
                _, at = path.located(Arc(point, there), path.criticality)
                if abs(path.criticality(at)) < min(map(abs, ends)):  # and no pole
                    yield at


def _is_multiple(motion: Motion) -> bool:
    """Whether a motion is several periods of another one, its touches aside."""
    fast = motion.without_impacts(np.flatnonzero(np.abs(motion.velocity) < IMAGE))
    return fast.primitive() is not fast


def _on(locus: FollowedLocus, x: Floats) -> bool:
    """Whether a motion lies on a locus, whose period of the forcing may be another one."""
    count, path = len(locus.path.sequence), locus.path
    times = x[count] - locus.x[:, count]
    at = np.repeat(x[None], len(locus.x), axis=0)
    at[:, count:-2] -= 2 * np.round(times / 2)[:, None]
    away = (at - locus.x) / path.scale
    row = int(np.argmin(np.abs(away).max(axis=1)))
    if not float(np.abs(away[row]).max()) < NEAR:
        return False
    way = path.tangent(locus.x[row])
    near = path.solved(locus.x[row] + path.scale * way * float(way @ away[row]), way)
    return near is not None and float(np.abs((near - at[row]) / path.scale).max()) < SAME_LOCUS


def _both(own: Event, other: Event) -> tuple[Event, Event]:
    """The events of a point, from that of a locus and what happens on it."""
    if own is Event.GRAZING:
        return (Event.GRAZING if other is Event.ZERO_VELOCITY else other), Event.GRAZING
    if other is Event.ZERO_VELOCITY:
        return Event.DEGENERATE_GRAZING, Event.GRAZING
    return (own, other)


def _polished(plane: Plane, motion: Motion, p: Floats, events: tuple[Event, Event]) -> Meeting:
    """Solve for a point in decimals, with the conditions of the motion and of both events; else as it is."""
    size, doubled = 2 * len(motion.sequence), events[1] is Event.DEGENERATE_DOUBLING
    guess = [*motion.velocity.tolist(), *motion.time.tolist(), *p.tolist()]
    if doubled:
        _, _, both = Locus(motion.sequence, plane, Condition(events[0])).folds(np.array(guess))
        way = np.concatenate(np.split(both[:-2], 4)[::2])  # of the first period
        way /= np.linalg.norm(way)
        guess += [*way.tolist(), *[0.0] * (2 * size)]
    elif events[1] is Event.CUSP:
        way = np.linalg.svd(linearised(motion.sequence, np.array(guess), plane.here(p.tolist()))[1][:, :size])[2][-1]
        guess += way.tolist()

    def equations(ops: Any) -> Callable[[list[Any]], list[Any]]:
        own = replace(plane, ops=ops)
        if doubled:
            return lambda x: _at_degenerate(own, motion.sequence, x, way)
        if events[1] is Event.CUSP:
            return lambda x: _at_cusp(own, motion.sequence, x, way)
        return lambda x: _at_grazing(own, motion, x, events[0])

    reach = [inf] * doubled  # changes with the amplitude may have any size
    with localcontext() as context:
        context.prec = DIGITS * (2 if doubled else 1)
        ops = DecimalOps()
        try:
            if events[1] is Event.DEGENERATE_PITCHFORK:
                raise NumericalError("half of the digits are left")
            x = newton(equations(ops), equations(FLOATS), [Decimal(value) for value in guess], {size, size + 1}, *reach)
        except NumericalError:
            return Meeting(events, motion, (float(p[0]), float(p[1])), (inf, inf))
        value = [float(number) for number in x]
        errors = [max(abs(float(x[i] - Decimal(value[i]))), float(np.spacing(abs(value[i])))) for i in (size, size + 1)]
    rounded = np.array(value[:size])
    rounded[list(at_rest(motion))] = 0.0
    exact = replace(motion, velocity=rounded[: size // 2], time=rounded[size // 2 :])
    return Meeting(events, exact, (value[size], value[size + 1]), (errors[0], errors[1]))


def _at_grazing(plane: Plane, motion: Motion, x: list[Any], event: Event) -> list[Any]:
    """The conditions where a membrane is touched, and touched again or another event happens."""
    rests, own = at_rest(motion), 2 * len(motion.sequence)
    # Of a symmetric motion the touches of the second half are those of the first.
    free = rests[: len(rests) // 2] if event is Event.PITCHFORK else rests
    conditions = [Condition(Event.GRAZING, (rest,)) for rest in free]
    if event is not Event.GRAZING:
        conditions.append(Condition(event, rests))
    values = (one.value(motion.sequence, x[:own], plane.at(x[own:]), plane.ops) for one in conditions)
    return [*Locus(motion.sequence, plane, Condition(event)).residuals(x, plane), *values]


def _at_cusp(plane: Plane, sequence: Sequence, x: list[Any], normal: Floats) -> list[Any]:
    """The conditions of a motion and of its null vector, along which the trace does not change, by differences."""
    size, exact = 2 * len(sequence), plane.ops.exact
    at, way, p = x[:size], x[size + 2 :], x[size : size + 2]
    step = exact(AT_CUSP[plane.ops is FLOATS])
    ends = [[*(value + sign * step * v for value, v in zip(at, way, strict=True)), *p] for sign in (1, -1)]
    groups, fold = plane.at(p), Condition(Event.FOLD)
    ahead, behind = (
        [*residuals(sequence, end, plane, plane.ops), fold.value(sequence, end[:size], groups, plane.ops)]
        for end in ends
    )
    changes = [(a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)]
    length = sum(exact(float(n)) * v for n, v in zip(normal, way, strict=True)) - 1
    return [*residuals(sequence, [*at, *p], plane, plane.ops), *changes, length]


def _at_degenerate(plane: Plane, sequence: Sequence, x: list[Any], normal: Floats) -> list[Any]:
    """The conditions of motions that begin at a period doubling, with two amplitudes for the same inputs.

    The unknowns are mean and difference of the two periods of such a motion for an amplitude of zero, the difference
    over the amplitude, and how both change with its square. The conditions are even functions of the amplitude.
    """
    size, count = 2 * len(sequence), len(sequence)
    p, mean, away = x[size : size + 2], x[:size], x[size + 2 : 2 * size + 2]
    mean_change, away_change = x[2 * size + 2 : 3 * size + 2], x[3 * size + 2 :]
    twice = Sequence(2 * sequence.walls, 2 * sequence.periods)
    amplitude = plane.ops.exact(AT_DEGENERATE[plane.ops is FLOATS])

    def conditions(e: Any) -> list[Any]:
        centre = [m + e * e * a for m, a in zip(mean, mean_change, strict=True)]
        off = [e * (n + e * e * b) for n, b in zip(away, away_change, strict=True)]
        first, second = ([c + sign * o for c, o in zip(centre, off, strict=True)] for sign in (1, -1))
        later = [t + 2 * sequence.periods for t in second[count:]]
        values = residuals(twice, [*first[:count], *second[:count], *first[count:], *later, *p], plane, plane.ops)
        pairs = list(zip(values[:size], values[size:], strict=True))
        return [*((a + b) / 2 for a, b in pairs), *((a - b) / (2 * e) for a, b in pairs)]

    once, again = conditions(amplitude), conditions(2 * amplitude)
    lengths = (
        sum(plane.ops.exact(float(n)) * v for n, v in zip(normal, one, strict=True)) for one in (away, away_change)
    )
    changes = ((b - a) / amplitude**2 for a, b in zip(once, again, strict=True))
    return [*once, *changes, next(lengths) - 1, next(lengths)]
