"""The network of loci in a plane: each is followed to its ends, and where several meet the others are followed as well.

A start is a motion at which something happens. `Network.explore` follows the locus through it; at each point of
codimension two on that, the loci of all conditions that hold there are queued as starts of their own.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from itertools import chain, combinations, pairwise
from math import prod
from typing import NamedTuple

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.map.chart.loci import Locus
from vireport.map.chart.meetings import Meeting, meeting
from vireport.map.chart.plane import DevicePlane
from vireport.motions.conditions import Condition
from vireport.motions.events import Event
from vireport.motions.paths import Arc, PathPoint, completed, follow
from vireport.motions.periodicity import weighted_trace
from vireport.motions.switching import Limits, off, touching
from vireport.physics.motion import IMAGE, SAME_TOUCH, Motion
from vireport.physics.numbers import ARRAYS
from vireport.physics.word import Word

Floats = NDArray[np.float64]

SAME_LOCUS, NEAR = 1e-6, 0.1
"""Distance, in the unknowns over their scale, up to which a motion is on a locus; and from the nearest point of the
locus, up to which that is tried."""

MEETS = 1e-6
"""Value of another event's condition, over the motion's velocities, up to which it holds at a point as well."""

AT_EDGE, SAME_POINT = 1e-6, 1e-6
"""Shares of the range: from the plane's edge, within which what happens is that of the edge, and between two points."""

SAME_MOTION = 1e-4
"""Difference of velocities and times up to which the motions of two such points are one: where no polish applies, half
of the digits are left."""


class FollowedLocus(Struct, frozen=True, eq=False):
    """A locus of critical points as it was followed within a plane.

    Attributes
    ----------
    path : Locus
    x : ndarray (n, 2N + 2)
        Velocities, times and inputs of its motions, in order.
    trace : ndarray (n,)
        Trace; at grazing points that of the motion without the touch.
    events : tuple of (int, Event)
        Rows at which something else happens as well; the first and last end it.
    """

    path: Locus
    x: Floats
    trace: Floats
    events: tuple[tuple[int, Event], ...]

    @property
    def event(self) -> Event:
        """Event of the critical points on the locus."""
        return self.path.condition.event

    @property
    def word(self) -> str:
        """The word of the motions without a touch."""
        return self.path.touched.canonical().letters

    @property
    def symmetric(self) -> bool | None:
        """Whether its motions are their own mirror images; None where gravity or unlike ends break the symmetry."""
        if not self.path.plane.horizontal:
            return None
        motion = self.path.motion(self.x[len(self.x) // 2])
        return motion.distance(motion.mirrored()) < IMAGE

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
        """Whether stable motion ends at each of the pieces between its points."""
        if self.event is Event.NODE_FOCUS:
            return np.zeros(len(self.x) - 1, dtype=bool)
        if self.event is not Event.GRAZING:
            return np.ones(len(self.x) - 1, dtype=bool)
        walls = self.path.touched.walls
        decay = np.array([float(self.path.plane.at(p).decay(walls)) for p in self.inputs.tolist()])
        stable = np.abs(self.trace) < 1 + decay**2 + MEETS
        return np.asarray(stable[1:] & stable[:-1])

    def holds(self, x: Floats) -> bool:
        """Whether a motion lies on it, counted from another forcing period or not."""
        count, path = len(self.path.word), self.path
        at = np.repeat(x[None], len(self.x), axis=0)
        at[:, count:-2] -= 2 * np.round((x[count] - self.x[:, count]) / 2)[:, None]
        away = (at - self.x) / path.scale
        row = int(np.argmin(np.abs(away).max(axis=1)))
        if not float(np.abs(away[row]).max()) < NEAR:
            return False
        way = path.tangent(self.x[row])
        near = path.solved(self.x[row] + path.scale * way * float(way @ away[row]), way)
        return near is not None and float(np.abs((near - at[row]) / path.scale).max()) < SAME_LOCUS


class LocusStart(NamedTuple):
    """A motion with its touches as impacts of velocity zero, values of the inputs, and what happens there."""

    motion: Motion
    inputs: Floats
    event: Event


class Network(Struct):
    """The loci that were followed in a plane, and the points of codimension two on them.

    Attributes
    ----------
    plane : DevicePlane
    limits : Limits
        Of the motions.
    only : Sequence, optional
        Impacts that motions have with or without a touch, where no others are wanted.
    """

    plane: DevicePlane
    limits: Limits
    only: Word | None
    loci: list[FollowedLocus] = field(default_factory=list)
    meetings: list[Meeting] = field(default_factory=list)
    _queue: deque[tuple[Locus, PathPoint]] = field(default_factory=deque)

    def explore(self, start: LocusStart) -> None:
        """Follow the locus through a start, and all that it is joined to."""
        motion, p, event = _distinct(start.motion).canonical(), *start[1:]
        guess, sign = np.concatenate([motion.velocity, motion.time, p]), 1
        if event is Event.NODE_FOCUS:
            weighted = weighted_trace(motion.word, guess.tolist(), self.plane.at(p.tolist()))
            sign = 1 if weighted * prod(motion.velocity) > 0 else -1
        path = Locus(motion.word, self.plane, Condition(event, motion.rests, sign))
        x = path.nearest(guess) if self._wanted(path) else None
        if x is not None and np.abs((x[-2:] - p) / self.plane.widths).max() < SAME_POINT:
            self._follow(path, path.point(x, path.tangent(x)))
        while self._queue:
            self._follow(*self._queue.popleft())

    def _wanted(self, path: Locus) -> bool:
        """Whether the motions of a locus are within the limits."""
        touched = path.touched
        if not len(touched) or (path.condition.event is Event.GRAZING and not path.condition.rests):
            return False  # at r = 0, a motion may touch its membrane in the very moment of the impact before
        wanted = self.only is None or self.only in (touched.canonical(), path.word.canonical())
        return wanted and self.limits.admit(touched)

    def _follow(self, path: Locus, first: PathPoint) -> None:
        """Follow a locus both ways from a motion, unless it is known."""
        motion = path.motion(first.x)
        waits = np.diff(motion.time, append=motion.time[0] + 2 * motion.word.periods)
        if not path.admits(first.x) or waits.min() < SAME_TOUCH or motion.rests != path.condition.rests:
            return
        if self._is_redundant(motion) or self._is_followed(path, first.x):
            return
        strand = completed(path, first, follow(path, first))
        x = np.array([point.x for point in strand.points])
        trace = np.array([point.trace for point in strand.points])
        self.loci.append(FollowedLocus(path, x, trace, tuple(strand.events)))
        for row, event in strand.events:
            self._meet(path, strand.points[row].x, event)
        if path.condition.event is Event.PERIOD_DOUBLING:
            for point in _degenerate(path, strand.points):
                self._meet(path, point.x, Event.DEGENERATE_DOUBLING)

    def _is_followed(self, path: Locus, x: Floats) -> bool:
        """Whether a motion lies on a locus that has been followed, counted from any impact or in the mirror."""
        motion = path.motion(x)
        images = [motion, motion.mirrored()] if self.plane.horizontal else [motion]
        turned = [image.rotated(i) for image in images for i in range(len(path.word))]
        return any(
            locus.holds(np.concatenate([image.velocity, image.time, x[-2:]]))
            for locus in self.loci
            for image in turned
            if locus.event is path.condition.event
            and image.word == locus.path.word
            and image.rests == locus.path.condition.rests
        )

    def _meet(self, path: Locus, x: Floats, event: Event) -> None:
        """Take up what happens on a locus: where it is a point of codimension two, start the loci through it."""
        motion, p, path_event = path.motion(x), x[-2:], path.condition.event
        if event in (Event.SWEEP_END, Event.CLOSED, Event.LOST) or self.plane.room(p) < AT_EDGE:
            return
        if path_event is Event.NODE_FOCUS and event is Event.GRAZING:
            return
        if path_event is Event.FOLD and event is Event.DEGENERATE_DOUBLING:  # which is a point of the period doublings
            doublings, guess = path.halved(x)
            y = doublings.nearest(guess) if self._wanted(doublings) else None
            if y is not None:
                self._queue.append((doublings, doublings.point(y, doublings.tangent(y))))
            return
        if event in (Event.GRAZING, Event.ZERO_VELOCITY):
            motion = touching(motion, path.turns(x))
        motion = _distinct(motion).canonical()
        if self._is_redundant(motion) or any(self._same(earlier, motion, p) for earlier in self.meetings):
            return
        self.meetings.append(meeting(self.plane, motion, p, self._both(motion, path_event, event)))
        if event is Event.DEGENERATE_DOUBLING:
            folds, y, way = path.doubled(x)
            self._leave(folds, y, [way])
        rests = motion.rests
        for removed in chain.from_iterable(combinations(rests, count) for count in range(len(rests) + 1)):
            less = motion.without_impacts(removed)
            for through in self._through(less, p):
                y = np.concatenate([less.velocity, less.time, p])
                way = self._direction(through, y)
                self._leave(through, y, [way, -way])

    def _leave(self, path: Locus, x: Floats, ways: list[Floats]) -> None:
        """Start a locus from a point of it, in each of the directions in which there are motions."""
        if self._wanted(path):
            self._queue.extend((path, first) for way in ways for _, first in off(path, x, way))

    def _both(self, motion: Motion, first: Event, other: Event) -> tuple[Event, Event]:
        """The events of a point, from that of a locus and what happens on it."""
        if Event.FOLD in (first, other) and self._symmetric(motion):
            first, other = (Event.PITCHFORK if event is Event.FOLD else event for event in (first, other))
        if first is Event.GRAZING:
            return (Event.GRAZING if other is Event.ZERO_VELOCITY else other), Event.GRAZING
        return (Event.DEGENERATE_GRAZING, Event.GRAZING) if other is Event.ZERO_VELOCITY else (first, other)

    def _same(self, meeting: Meeting, motion: Motion, p: Floats) -> bool:
        near = np.abs((np.array(meeting.inputs) - p) / self.plane.widths).max() < SAME_POINT
        return bool(near) and meeting.motion.distance(motion, mirror=self.plane.horizontal) < SAME_MOTION

    def _symmetric(self, motion: Motion) -> bool:
        return self.plane.horizontal and motion.distance(motion.mirrored()) < IMAGE

    def _is_redundant(self, motion: Motion) -> bool:
        """Whether a motion satisfies the conditions of its sequence only because another one does.

        Touches aside, it is several periods of that one, or it is symmetric and some of the touches are left out.
        """
        rests = np.flatnonzero(np.abs(motion.velocity) < IMAGE)
        fast = motion.without_impacts(rests)
        partial = bool(rests.size) and self._symmetric(fast) and not self._symmetric(motion)
        return partial or fast.primitive() is not fast

    def _direction(self, path: Locus, x: Floats) -> Floats:
        """The direction in which a locus leaves a point.

        At a pitchfork with grazing, symmetric motions satisfy the conditions of one touch as well. The asymmetric ones,
        which are looked for, leave along the locus of pitchforks.
        """
        rests, motion = path.condition.rests, path.motion(x)
        fast = motion.without_impacts(rests)
        if not rests or not self._symmetric(fast) or self._symmetric(motion):
            return path.tangent(x)
        kept = Locus(fast.word, self.plane, Condition(Event.PITCHFORK))
        tangent = kept.tangent(np.concatenate([fast.velocity, fast.time, x[-2:]]))
        both = np.linalg.svd(path.linearised(x)[1])[2][-2:]
        first, second = both[:, -2:] @ [tangent[-1], -tangent[-2]]
        return np.asarray(second * both[0] - first * both[1]) / float(np.hypot(first, second))

    def _through(self, motion: Motion, p: Floats) -> Iterator[Locus]:
        """The loci through a point: of every condition that holds for a motion with some of its touches as impacts."""
        rests, groups = motion.rests, self.plane.at(p.tolist())
        x = [*motion.velocity.tolist(), *motion.time.tolist()]
        both = len(motion.word) // 2 if self._symmetric(motion) else 0  # of a symmetric motion, touches are pairs
        pairs = {tuple(sorted({rest, (rest + both) % len(motion.word)})) for rest in rests}
        conditions = [Condition(Event.GRAZING, pair) for pair in sorted(pairs)]
        if len(rests) < 2 and len(motion.word) > len(rests):
            fold = Event.PITCHFORK if self._symmetric(motion) else Event.FOLD
            traced = [Condition(event) for event in (Event.PERIOD_DOUBLING, fold)]
            traced += [Condition(Event.NODE_FOCUS, sign=sign) for sign in (1, -1)]
            conditions += [
                condition for condition in traced if abs(condition.value(motion.word, x, groups, ARRAYS)) < MEETS
            ]
        return (Locus(motion.word, self.plane, condition) for condition in conditions)


def _distinct(motion: Motion) -> Motion:
    """A motion without impacts of velocity zero that are the same touch as another."""
    pairs, period = combinations(motion.rests, 2), 2 * motion.word.periods
    late = [(j, motion.time[j] - motion.time[i]) for i, j in pairs]
    return motion.without_impacts([j for j, wait in late if abs((wait + 1) % period - 1) < SAME_TOUCH])


def _degenerate(path: Locus, points: list[PathPoint]) -> Iterator[PathPoint]:
    """Where along a locus of period doublings these change from soft to hard."""
    values = [path.criticality(point) for point in points]
    for (point, new), ends in zip(pairwise(points), pairwise(values), strict=True):
        step, back = (float(end.tangent @ ((new.x - point.x) / path.scale)) for end in (point, new))
        # From the start of a locus tangents point both ways, and the criticality is of the side to the left of them.
        if ends[0] * ends[1] * step * back < 0:
            start = new if step * back > 0 else replace(new, tangent=-new.tangent)
            with suppress(NumericalError):
                _, at = path.located(Arc(point, start), path.criticality)
                if abs(path.criticality(at)) < min(map(abs, ends)):  # and no pole
                    yield at
