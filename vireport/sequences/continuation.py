"""A family of motions followed along a sweep, by pseudo-arclength, from event to event.

Steps are so short that the trace, on which all types of motion rest, changes by little; every event between two points
is bracketed and then found on the curve itself.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from math import atan, nan, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import STABILITIES, Stability, classify, secant_root
from vireport.errors import NumericalError
from vireport.sequences.equations import Model, linearised, trace
from vireport.sequences.motions import IMAGE, Motion, Sequence

Floats = NDArray[np.float64]

FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 1e-3, 0.05, 1e-9
"""Of the arclength in velocities, times and the share of the sweep."""

LAST_STEP = 1e-6
"""The same, up to which a velocity may go to zero wherever the trace is."""

GROWTH, BEND = 3.0, 0.8
"""Of a step from one that succeeded, at most, and the share of the largest angle that the last curvature may give."""

STEEPEST = 0.35
"""Most that a step may change arctan(tr/(1 + det)) [rad]; from one border of stability to the other it is pi/2."""

CLOSE = 1e-4
"""Step that need not be shorter because a velocity or gap is small."""

STRAIGHTEST = 0.995
"""Least cosine of the angle between the directions at both ends of a step."""

MOST_POINTS = 4000
"""Points of one family in one direction."""

CONVERGED, ROUNDING = 1e-12, 1e-10
"""Newton correction at which a motion is found, and the one up to which rounding may keep it."""

LOCATED = 1e-11
"""Correction of a step, as a share of it, at which an event is found."""

SQUARED = 1e-11
"""Newton correction at which a motion is found where the next one would be about its square."""

CORRECTIONS = 8

RANK = 1e-7
"""Singular value over the largest below which a direction is left out where families cross."""

MOST_ASIDE = 1e3
"""Length of a tangent before it is normalised, at which another curve crosses."""

AT_ZERO = 1e-9
"""Velocity or gap that is zero where an event says that one is: far above rounding, far below any that differ."""


class Event(StrEnum):
    """What happens at a point of a family.

    From grazing on these end it; a period doubling or a pitchfork does where the family turns back as its own image.
    The last three are points of loci: where folds and period doublings of the motion with the impact begin at a grazing
    point; where loci of folds have a cusp, or meet that of the period doubling at which their motions begin.
    """

    PERIOD_DOUBLING = "period_doubling"
    FOLD = "fold"
    PITCHFORK = "pitchfork"
    NODE_FOCUS = "node_focus"
    GRAZING = "grazing"
    ZERO_VELOCITY = "zero_velocity"
    SWEEP_END = "sweep_end"
    CLOSED = "closed_curve"
    LOST = "not_followed"
    DEGENERATE_GRAZING = "degenerate_grazing"
    CUSP = "cusp"
    DEGENERATE_DOUBLING = "degenerate_period_doubling"


class Point(NamedTuple):
    """A motion on a curve: velocities, times and coordinate, direction of the curve, trace, and least of `margins`.

    The curvature is that of the curve up to the motion, as far as it is known.
    """

    x: Floats
    tangent: Floats
    trace: float
    margin: float
    curvature: Any = 0.0


class Path(ABC):
    """Motions with one condition fewer than they have unknowns: a curve, which is followed from event to event.

    The unknowns are velocities and times of the impacts and what varies of the device.
    """

    __slots__ = ()
    sequence: Sequence
    first, longest, straightest = FIRST_STEP, LONGEST_STEP, STRAIGHTEST

    @property
    @abstractmethod
    def scale(self) -> Floats:
        """What each unknown is measured by."""

    @abstractmethod
    def linearised(self, x: Floats) -> tuple[Floats, Floats]:
        """The conditions and their derivatives, by unknowns over their scale."""

    @abstractmethod
    def motion(self, x: Floats) -> Motion:
        """The motion of some unknowns."""

    @abstractmethod
    def trace(self, x: Floats) -> float:
        """The trace of a motion, or what else may not change much within a step; nan where there is none."""

    @abstractmethod
    def margins(self, x: Floats) -> Floats:
        """What is positive of a motion that is admissible, and within the range."""

    @abstractmethod
    def gentle(self, point: Point, new: Point, step: float) -> bool:
        """Whether a step was short enough for no event to be missed in it."""

    @abstractmethod
    def ended(self, last: Point) -> tuple[Event, Point]:
        """Which of the margins it is that has become zero, and the motion with what it is known to be there."""

    @abstractmethod
    def happenings(self, point: Point, new: Point, size: float) -> tuple[list[tuple[Point, Event | None]], bool]:
        """What happens within a step, in order, and whether the last of it ends the path. Raises as `located`."""

    def short(self, point: Point, new: Point, step: float) -> bool:
        """Whether a step was short enough for nothing to be missed in it.

        To go to zero and come back, a velocity or gap needs a rate that changes; rates change with the direction of
        the curve and along it, at most by about eight times as much, and what is missed is an eighth of the step times
        that.
        """
        hidden = step * (float(np.linalg.norm(new.tangent - point.tangent)) + step)
        seen = step <= CLOSE or new.margin <= 0 or min(point.margin, new.margin) > hidden
        return seen and float(new.tangent @ point.tangent) > self.straightest and self.gentle(point, new, step)

    def reach(self, point: Point) -> float:
        """Longest step: as `short` sees what is hidden, it may go with the root of the least velocity or gap."""
        bend = BEND * sqrt(2 * (1 - self.straightest))
        straight = bend / max(float(np.linalg.norm(point.curvature)), bend)
        return max(min(sqrt(max(point.margin, 0.0)) / 2, straight), CLOSE)

    def leaves(self, x: Floats, first: Point) -> bool:
        """Whether nothing happens between a point from which the path begins and a motion next to it."""
        return True

    def solved(self, guess: Floats, normal: Floats) -> Floats | None:
        """The motion nearest to a guess in the plane through it with a normal; None where there is none in reach."""
        return (self._newton(guess, normal, False) or self._newton(guess, normal, True) or (None,))[0]

    def _newton(self, guess: Floats, normal: Floats, crossing: bool) -> tuple[Floats, Floats] | None:
        """The motion, and the direction of the path, on the side of the normal, at the last correction."""
        solve: Any = _within_rank if crossing else np.linalg.solve
        x, scale, right = guess.copy(), self.scale, np.zeros((len(guess), 2))
        right[-1, 1] = 1.0
        for _ in range(CORRECTIONS):
            right[:-1, 0], matrix = self.linearised(x)
            right[-1, 0] = normal @ ((x - guess) / scale)
            try:
                step, along = solve(np.concatenate([matrix, normal[None]]), right).T
            except np.linalg.LinAlgError:
                return None
            size = float(np.abs(step).max())
            if not size < 1:
                return None
            x -= step * scale
            if size < (CONVERGED if crossing else SQUARED):
                return x, along
        return (x, along) if size < ROUNDING else None

    def nearest(self, guess: Floats) -> Floats | None:
        """The motion nearest to a guess."""
        return (self._newton(guess, np.zeros(len(guess)), True) or (None,))[0]

    def point(self, x: Floats, along: Floats) -> Point:
        """A motion with the direction of the path there, on the side of another direction."""
        return self._point(x, _within_rank(np.concatenate([self.linearised(x)[1], along[None]]), np.eye(len(x))[-1]))

    def _point(self, x: Floats, along: Floats) -> Point:
        return Point(x, along / sqrt(along @ along), self.trace(x), float(self.margins(x).min()))

    def tangent(self, x: Floats) -> Floats:
        """The direction of the path, of either sign."""
        return np.asarray(np.linalg.svd(self.linearised(x)[1])[2][-1])

    def ahead(self, point: Point, step: float) -> Point:
        """The motion a step further along the path.

        Raises
        ------
        NumericalError
            If none is found.
        """
        guess = point.x + step * self.scale * (point.tangent + step / 2 * point.curvature)
        found = self._newton(guess, point.tangent, False)
        if found is None or not found[1] @ found[1] < MOST_ASIDE**2:
            found = self._newton(guess, point.tangent, True)
        if found is None:
            raise NumericalError(f"a family of {self.sequence.word} was lost")
        new = self._point(*found)
        return new._replace(curvature=_curvature(new, point, step))

    def located(self, point: Point, new: Point, step: float, value: Callable[[Point], float]) -> tuple[float, Point]:
        """Where, within a step to a new point, a function is zero whose signs differ at its ends. Raises as `ahead`."""
        point, known = point._replace(curvature=_curvature(point, new, -step)), {}
        first, last = value(point), value(new)
        slope = (last - first) / step

        def values(sizes: Floats, _: Any) -> Floats:
            size = float(sizes[0])
            known[size] = self.ahead(point, size)
            return np.array([value(known[size])])

        bracket, chord = (np.zeros(1), np.full(1, step)), (np.full(1, slope), np.zeros(1), np.full(1, first))
        start, rising = np.full(1, -first / slope), np.full(1, last > first)
        size = float(secant_root(values, bracket, start, rising, chord, LOCATED)[0])
        return size, known[size]

    def admits(self, x: Floats) -> bool:
        """Whether a solution is a motion within the range."""
        return bool((self.margins(x) > 0).all())


def _curvature(at: Point, other: Point, step: float) -> Floats:
    """How the direction changes per arclength towards a point a step away, across the curve."""
    change = (at.tangent - other.tangent) / step
    return np.asarray(change - (change @ at.tangent) * at.tangent)


def _within_rank(matrix: Floats, right: Floats) -> Floats:
    """Least solution of equations that nearly are too few, as they are where two families cross."""
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=RANK)[0])


@dataclass(frozen=True, slots=True, eq=False)
class Strand:
    """Points along a curve, and what happens at some of them: the last one ends it."""

    points: list[Point]
    events: list[tuple[int, Event]]

    def reversed(self) -> Strand:
        """The same, followed the other way."""
        last = len(self.points) - 1
        return Strand(self.points[::-1], [(last - i, event) for i, event in self.events[::-1]])


def follow(path: Path, start: Point) -> Strand:
    """Follow a path from a motion, in the direction of its tangent, until something ends it."""
    strand, step = Strand([start], []), path.first
    while len(strand.points) < MOST_POINTS and step > SHORTEST_STEP:
        step = min(step, path.reach(strand.points[-1]))
        try:
            if _advance(path, strand, step):
                return strand
        except NumericalError:
            step /= 2
        else:
            step = min(step * GROWTH, path.longest)
    strand.events.append((len(strand.points) - 1, Event.LOST))
    return strand


def completed(path: Path, start: Point, forward: Strand) -> Strand:
    """A strand with the other way from its start in front of it."""
    if forward.events[-1][1] is Event.CLOSED:
        return forward
    back = follow(path, start._replace(tangent=-start.tangent)).reversed()
    shift = len(back.points) - 1
    events = [*back.events, *((i + shift, event) for i, event in forward.events)]
    return Strand([*back.points, *forward.points[1:]], events)


def _advance(path: Path, strand: Strand, step: float) -> bool:
    """Add the points of one step to a strand, and return whether it ends there.

    Raises
    ------
    NumericalError
        If the step was too long.
    """
    point, end = strand.points[-1], None
    new = path.ahead(point, step)
    if not path.short(point, new, step):
        raise NumericalError("the curve bends too much within a step")
    if new.margin <= 0:
        step, new = path.located(point, new, step, lambda p: p.margin)
        end, new = path.ended(new)
    happenings, over = path.happenings(point, new, step)
    if end is None and _closes(strand, new):
        end, new = Event.CLOSED, strand.points[0]
    for motion, event in happenings if over else [*happenings, (new, end)]:
        strand.points.append(motion)
        if event is not None:
            strand.events.append((len(strand.points) - 1, event))
    return over or end is not None


def _closes(strand: Strand, new: Point) -> bool:
    """Whether a curve has come back to the motion that it began with."""
    last, first = strand.points[-1], strand.points[0]
    way, back = new.x - last.x, first.x - last.x
    if len(strand.points) < 8 or float(last.tangent @ first.tangent) < STRAIGHTEST:
        return False
    along = float(way @ back) / float(way @ way)
    return 0 <= along <= 1 and float(np.abs(back - along * way).max()) < 0.1 * float(np.abs(way).max())


@dataclass(frozen=True, slots=True, eq=False)
class Curve(Path):
    """The motions of one sequence as a curve, between two values of the coordinate.

    Attributes
    ----------
    sequence : Sequence
    model : Model
    low, high : float
        Range of the coordinate.
    """

    sequence: Sequence
    model: Model
    low: float
    high: float

    @property
    def scale(self) -> Floats:
        """The sweep's range, and 1 of velocities and times."""
        return np.append(np.ones(2 * len(self.sequence)), self.high - self.low)

    @property
    def borders(self) -> tuple[float, float]:
        """|tr| at which a multiplier has modulus 1, 1 + r^(2N), and at which Delta = 0, 2 r^N."""
        decay = self.model.r ** len(self.sequence)
        return 1 + decay * decay, 2 * decay

    def vector(self, motion: Motion) -> Floats:
        """The unknowns of a motion."""
        return np.concatenate([motion.velocity, motion.time, [motion.coordinate]])

    def motion(self, x: Floats) -> Motion:
        """The motion of some unknowns."""
        count = len(self.sequence)
        return Motion(self.sequence, x[:count], x[count:-1], float(x[-1]))

    def linearised(self, x: Floats) -> tuple[Floats, Floats]:
        """The conditions and their derivatives, the last by the share of the sweep."""
        values, matrix = linearised(self.sequence, x, self.model)
        matrix[:, -1] *= self.high - self.low
        return values, matrix

    def at(self, guess: Floats, coordinate: float) -> Floats | None:
        """The motion at a value of the coordinate next to a guess."""
        x = guess.copy()
        x[-1] = coordinate
        return self.solved(x, np.eye(len(x))[-1])

    def trace(self, x: Floats) -> float:
        """The trace of a motion; nan where a velocity is zero."""
        return float(trace(self.sequence, x.tolist(), self.model)) if np.all(x[: len(self.sequence)] != 0) else nan

    def stability(self, trace: float) -> Stability:
        """Type of a motion with this trace."""
        return STABILITIES[int(classify(trace, self.model.r ** (len(self.sequence) / 2)))]

    def margins(self, x: Floats) -> Floats:
        """What is positive of a motion within the sweep: both distances to its ends, velocities, gaps to the walls."""
        motion = self.motion(x)
        ends = np.array([x[-1] - self.low, self.high - x[-1]]) / (self.high - self.low)
        gaps = [turn.gap for turn in self.model.turns(motion)]
        return np.concatenate([ends, motion.velocity * motion.sequence.walls, gaps])

    def gentle(self, point: Point, new: Point, step: float) -> bool:
        """Whether a step was short enough for no event to be missed in it.

        Where a velocity goes through zero the trace has a pole: the step must be near it, or the last step short.
        """
        if (self.motion(new.x).velocity * self.sequence.walls <= 0).any():
            return step < LAST_STEP or self._near_pole(point)
        return abs(atan(new.trace / self.borders[0]) - atan(point.trace / self.borders[0])) < STEEPEST

    def _near_pole(self, point: Point) -> bool:
        """Whether the trace is so large that nothing happens between the point and an impact of velocity zero."""
        return pi / 2 - abs(atan(point.trace / self.borders[0])) < STEEPEST

    def leaves(self, x: Floats, first: Point) -> bool:
        """Whether nothing happens between a point from which the curve begins and a motion next to it."""
        return not (x[: len(self.sequence)] == 0).any() or self._near_pole(first)

    def ended(self, last: Point) -> tuple[Event, Point]:
        """Which of the margins it is that has become zero, and the motion with what it is known to be there."""
        margins = self.margins(last.x)
        if (np.abs(margins[2 : 2 + len(self.sequence)]) < AT_ZERO).any():
            return Event.ZERO_VELOCITY, last._replace(trace=nan)
        which = int(np.argmin(margins))
        if which >= 2:
            return Event.GRAZING, last
        x = self.at(last.x, (self.low, self.high)[which])
        return Event.SWEEP_END, last if x is None else last._replace(x=x)

    def happenings(self, point: Point, new: Point, size: float) -> tuple[list[tuple[Point, Event | None]], bool]:
        """What happens within a step, in order, and whether the last of it ends the family. Raises as `_located`."""
        border, focus = self.borders
        found: list[tuple[float, Point, Event | None]] = []

        def pass_through(value: Callable[[Point], float]) -> bool:
            return value(point) * value(new) < 0

        for event, level in (
            (Event.PERIOD_DOUBLING, -border), (Event.NODE_FOCUS, focus), (Event.NODE_FOCUS, -focus),
        ):  # fmt: skip
            if pass_through(_above(level)):
                found.append((*self.located(point, new, size, _above(level)), event))
        over, meets = False, pass_through(_above(border))
        if pass_through(_along):
            where = self.located(point, new, size, _along)
            image = None if meets else _turned_back(self, where[1].x)
            over = image is not None
            found = [one for one in found if not over or one[0] < where[0]]
            if meets or over:
                found.append((*where, image or Event.FOLD))
        elif meets:
            where = self.located(point, new, size, _above(border))
            if _is_symmetric(self, where[1].x):
                found.append((*where, Event.PITCHFORK))
        return [(motion, event) for _, motion, event in sorted(found, key=lambda one: one[0])], over


def _above(level: float) -> Callable[[Point], float]:
    """How far the trace of a motion is above a level."""
    return lambda point: point.trace - level


def _along(point: Point) -> float:
    """How fast the swept parameter changes along the curve."""
    return float(point.tangent[-1])


def _is_symmetric(curve: Curve, x: Floats) -> bool:
    """Whether a motion of a horizontal capsule is its own mirror image."""
    motion = curve.motion(x)
    return curve.model.level.horizontal and motion.distance(motion.mirrored()) < IMAGE


def _turned_back(curve: Curve, x: Floats) -> Event | None:
    """What a family turns back from as its own image: two periods of another motion, or a symmetric one."""
    motion = curve.motion(x)
    if 2 * len(motion.primitive().sequence) == len(motion.sequence):
        return Event.PERIOD_DOUBLING
    return Event.PITCHFORK if _is_symmetric(curve, x) else None
