"""A family of motions followed along a sweep, by pseudo-arclength, from event to event.

Steps are so short that the trace, on which all types of motion rest, changes by little; every event between two points
is bracketed and then located on the curve itself.
"""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from collections.abc import Callable
from functools import cached_property
from math import atan, copysign, inf, isfinite, nan, pi, sqrt
from operator import itemgetter
from sys import float_info
from typing import Any, Self

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.base.records import brief
from vireport.motions.conditions import Condition
from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.periodicity import Model, Variation, linearised, trace
from vireport.motions.roots import GOLDEN
from vireport.motions.stability import STABILITIES, Stability, classify
from vireport.motions.turning import Turn, slow_places, turns
from vireport.physics.groups import Groups, stated
from vireport.physics.motion import AT_ZERO, IMAGE, Motion
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word

Floats = NDArray[np.float64]

FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 1e-3, 0.05, 1e-9
"""Steps of the arclength in velocities, times and the share of the sweep."""

LAST_STEP = 1e-6
"""Arclength of the step up to which a velocity may go to zero wherever the trace is."""

AIM, LEAST, MOST = 0.8, 0.08, 2.5
"""Strain that the next step is to have, and the strains beyond which it changes no further: tenfold, or to a third."""

STEEPEST = 0.35
"""Most that a step may change arctan(tr/(1 + det)) [rad]; from one border of stability to the other it is pi/2."""

CLOSE = 1e-4
"""Step that need not be shorter because a velocity or gap is small."""

SHARPEST = 0.1
"""Most that the direction may change within a step [rad]."""

MOST_POINTS = 4000
"""Points of one family in one direction."""

MOST_IDLE_STEPS = 50
"""Steps that together must be longer than the shortest that is never refused; of 60 random devices no two were not."""

CONVERGED, ROUNDING = 1e-12, 1e-10
"""Newton correction that ends the search for a motion, and the one up to which rounding may keep it."""

LOCATED, ON_CUBIC = 1e-11, 1e-7
"""Correction, as a share of a step, that ends the search for an event on the path, and on a cubic next to it."""

MOST_SECANTS, FREE_SECANTS = 60, 7
"""More than bisections alone need in one step of four; and those that are usual, before every fourth is one."""

SQUARED = 1e-9
"""Newton correction that ends the search where the next one would be about its square."""

CORRECTIONS = 8

RANK = 1e-7
"""Singular value over the largest below which a direction is left out where families cross."""

MOST_ASIDE = 1e3
"""Length of a tangent before it is normalised, at which another curve crosses."""


PASSED = Condition(Event.PERIOD_DOUBLING), Condition(Event.NODE_FOCUS), Condition(Event.NODE_FOCUS, sign=-1)
"""What a family passes through: where the trace has a value, and the motions go on."""

MEETING = Condition(Event.FOLD)
"""Where motions meet, in a fold or a pitchfork."""

NEARBY, DOUBTFUL = 0.3, 0.5
"""Distance of the trace to a border within which it may cross it within a step and come back; and
the share of the lesser distance at the ends, below which the parabola has to come for the trace to be looked at."""

SEARCHED, SECTIONS = 0.2, 20
"""Share of the step to either side of the parabola's extremum, in which that of the trace is looked for, and the golden
sections that find it, to the root of rounding."""

TURNED_BACK = 1e-3
"""Difference of velocity [y_c] and time [t_c] up to which a motion is its own image where the swept parameter turns and
the trace does not cross its level, as it does in a fold. The equations are singular there, and the search stops 1e-6
from the image, or so: once in some thousand times 1e-5 from it, farther than `IMAGE`."""

CROSSED = 1e-11
"""Depth beyond which the trace crosses a border rather than comes to it and goes back."""


class PathPoint(Struct, frozen=True, eq=False, dict=True):
    """A motion on a path, or a guess at one.

    Attributes
    ----------
    path : Path
    x : ndarray
        Velocities, times and what varies.
    tangent : ndarray
        Direction of the path, by unknowns over their scale.
    """

    path: Path
    x: Floats
    tangent: Floats

    @cached_property
    def trace(self) -> float:
        """Trace of the motion's Jacobian, see `Path.trace`."""
        return self.path.trace(self.x)

    @cached_property
    def decay(self) -> float:
        """The root of the determinant, see `Path.decay`."""
        return self.path.decay(self.x)

    @cached_property
    def margin(self) -> float:
        """Least margin of the motion to a touch or a stop, see `Path.margins`."""
        return float(min(self.path.margins(self.x)))


class Arc(Struct, frozen=True, eq=False, dict=True):
    """A step of a path, as the cubic that goes through the motions at both ends in the direction of the path."""

    start: PathPoint
    end: PathPoint

    @cached_property
    def length(self) -> float:
        """Arclength, negative if the end is behind the start; to the fourth order."""
        # On an arc of curvature k and length s tangents differ by 2 sin(ks/2), and the chord is 2 sin(ks/2)/k = s (1 -
        # (ks)^2/24 + ...).
        way, turned = self._way, self.end.tangent - self.start.tangent
        return copysign(sqrt(way @ way) * (1 + turned @ turned / 24), way @ self.start.tangent)

    @cached_property
    def _way(self) -> Floats:
        return (self.end.x - self.start.x) / self.start.path.scale

    @cached_property
    def _bend(self) -> tuple[Any, Any]:
        """Coefficients of the square and the cube of the arclength."""
        cubed = self.length**3
        if not cubed:  # a step below the cube root of the least double, next to restitution 0, is straight
            return 0.0, 0.0
        # Of x(s) = x0 + s t0 + s^2 a + s^3 b, with x and x' given at the end s = L: b = [L (t0 + t1) - 2 (x1 - x0)]/L^3
        # and a = (t1 - t0)/(2L) - 3 L b/2.
        both, turned = self.start.tangent + self.end.tangent, self.end.tangent - self.start.tangent
        cube = (self.length * both - 2 * self._way) / cubed
        return turned / (2 * self.length) - 1.5 * self.length * cube, cube

    @cached_property
    def middle(self) -> PathPoint:
        """Point in the middle of the cubic arc."""
        return self.at(self.length / 2)

    def guess(self, size: float) -> Floats:
        """The unknowns of the cubic at an arclength from the start."""
        square, cube = self._bend
        way: Floats = size * (self.start.tangent + size * (square + size * cube))
        return self.start.x + self.start.path.scale * way

    def at(self, size: float) -> PathPoint:
        """The cubic at an arclength from the start, its direction not normalised."""
        square, cube = self._bend
        tangent = self.start.tangent + size * (2 * square + 3 * size * cube)
        return PathPoint(self.start.path, self.guess(size), tangent)

    def crossing(self, value: Callable[[PathPoint], float]) -> tuple[float, float]:
        """Arclength at which a function is zero whose signs differ at the ends, and its slope there."""
        first, last = value(self.start), value(self.end)
        slope = (last - first) / self.length
        return _zero(lambda size: value(self.at(size)), self.length, last > 0, -first / slope, slope, ON_CUBIC)


class Path(Struct, frozen=True, eq=False):
    """Motions with one condition fewer than they have unknowns: a curve, which is followed from event to event.

    The unknowns are velocities and times of the impacts and what varies of the device.
    """

    word: Word
    first, longest, sharpest = FIRST_STEP, LONGEST_STEP, SHARPEST

    @property
    @abstractmethod
    def scale(self) -> Floats:
        """What each unknown is divided by, so that one arclength measures them all."""

    @abstractmethod
    def linearised(self, x: Floats) -> tuple[Floats, Floats]:
        """The conditions and their derivatives, by unknowns over their scale."""

    @abstractmethod
    def groups(self, x: Floats) -> Groups[float]:
        """The dimensionless groups at a motion."""

    @abstractmethod
    def motion(self, x: Floats) -> Motion:
        """The motion that an array of unknowns stands for."""

    @abstractmethod
    def trace(self, x: Floats) -> float:
        """The trace of a motion, or what else may not change much within a step; nan where there is none."""

    @abstractmethod
    def margins(self, x: Floats) -> Floats | list[float]:
        """What is positive of a motion that is admissible, and within the range."""

    @abstractmethod
    def steepness(self, arc: Arc) -> float:
        """How much what must change little within a step does, as a share of the most for no event to be missed."""

    @abstractmethod
    def end_within(self, arc: Arc) -> tuple[Event, PathPoint]:
        """Which of the margins becomes zero first within a step, and the motion there. Raises as `located`."""

    @abstractmethod
    def happenings(self, arc: Arc) -> tuple[list[tuple[PathPoint, Event | None]], bool]:
        """What happens within a step, in order, and whether the last of it ends the path. Raises as `located`."""

    def decay(self, x: Floats) -> float:
        """Product of the restitution coefficients over the impacts of a motion, the root of the determinant."""
        return float(self.groups(x).decay(self.word.walls, x[: len(self.word)].tolist()))

    def strain(self, arc: Arc) -> float:
        """How long a step is as against the longest in which nothing can be missed.

        To go to zero and come back, a velocity or gap needs a rate that changes; rates change with the direction of
        the curve and along it, at most by about eight times as much, and what is missed is an eighth of the step times
        that.
        """
        point, new, step = arc.start, arc.end, abs(arc.length)
        turned = sqrt(2 * max(1 - float(new.tangent @ point.tangent), 0.0))
        steepest = max(turned / self.sharpest, self.steepness(arc))
        # What is hidden is looked for last: the margins need the turning points of every flight.
        if steepest > 1 or step <= CLOSE or (least := min(point.margin, new.margin)) <= 0:
            return steepest
        return max(steepest, step * (turned + step) / least)

    def reach(self, point: PathPoint) -> float:
        """Longest step: as `strain` sees what is hidden, it may go with the root of the least velocity or gap."""
        return max(min(sqrt(max(point.margin, 0.0)) / 2, self.longest), CLOSE)

    def leaves(self, x: Floats, first: PathPoint) -> bool:
        """Whether nothing happens between a point from which the path begins and a motion next to it."""
        return True

    def solved(self, guess: Floats, normal: Floats) -> Floats | None:
        """The motion nearest to a guess in the plane through it with a normal; None where there is none in reach."""
        # Least squares, which also stand equations that depend on each other where families cross, take three times as
        # long as a solution by factors: 19 to 63 us against 7 to 12 us of up to six impacts.
        return (self._newton(guess, normal, False) or self._newton(guess, normal, True) or (None,))[0]

    def _newton(self, guess: Floats, normal: Floats, crossing: bool) -> tuple[Floats, Floats] | None:
        """The motion, and the direction of the path, on the side of the normal, at the last correction."""
        solve: Any = _within_rank if crossing else np.linalg.solve
        x, scale, size = guess.copy(), self.scale, len(guess)
        # The plane through the guess is the equation that is missing. Bordered by its normal the matrix is regular at
        # folds too, where that by velocities and times alone is not; a second right-hand side, (0, 1), gives the
        # direction of the path with the same factors.
        across, bordered, right, last = normal / scale, np.empty((size, size)), np.zeros((size, 2)), 1.0
        bordered[-1], right[-1, 1] = normal, 1.0
        for _ in range(CORRECTIONS):
            right[:-1, 0], bordered[:-1] = self.linearised(x)
            right[-1, 0] = across @ (x - guess)
            try:
                step, tangent = solve(bordered, right).T
            except np.linalg.LinAlgError:
                return None
            largest = float(np.abs(step).max())
            # Also true of nan.
            if not largest < last:
                break
            x, last = x - step * scale, largest
            # Where families cross the convergence is linear: the square of the correction says nothing about the next
            # one.
            if last < (CONVERGED if crossing else SQUARED):
                return x, tangent
        return (x, tangent) if last < ROUNDING else None

    def nearest(self, guess: Floats) -> Floats | None:
        """The motion nearest to a guess."""
        # Without a normal the least solution is the shortest way to the path.
        return (self._newton(guess, np.zeros(len(guess)), True) or (None,))[0]

    def point(self, x: Floats, tangent: Floats) -> PathPoint:
        """A motion with the direction of the path there, on the side of another direction."""
        return self._point(x, _within_rank(np.concatenate([self.linearised(x)[1], tangent[None]]), np.eye(len(x))[-1]))

    def _point(self, x: Floats, tangent: Floats) -> PathPoint:
        return PathPoint(self, x, tangent / sqrt(tangent @ tangent))

    def tangent(self, x: Floats) -> Floats:
        """The direction of the path, of either sign."""
        return np.asarray(np.linalg.svd(self.linearised(x)[1])[2][-1])

    def neighbour(self, arc: Arc, size: float) -> PathPoint:
        """The motion next to a point of an arc, or beyond its end.

        Raises
        ------
        NumericalError
            If the corrections do not settle.
        """
        guess = arc.guess(size)
        motion = self._newton(guess, arc.end.tangent, False)
        # Next to a crossing the bordered matrix is nearly singular: its tangent may be that of the other family.
        if motion is None or not motion[1] @ motion[1] < MOST_ASIDE**2:
            motion = self._newton(guess, arc.end.tangent, True)
        if motion is None:
            raise NumericalError(f"a family of {self.word.letters} was lost")
        return self._point(*motion)

    def located(
        self, arc: Arc, value: Callable[[PathPoint], float], tolerance: float = LOCATED
    ) -> tuple[float, PathPoint]:
        """Where, along an arc, a function is zero on the path whose signs differ at its ends. Raises as `neighbour`."""
        if value(arc.start) == value(arc.end):
            return 0.0, arc.start  # it begins there, to rounding, and what varies does not change the function
        evaluated, (guess, slope) = {}, arc.crossing(value)

        def on_path(size: float) -> float:
            evaluated[size] = self.neighbour(arc, size)
            return value(evaluated[size])

        size, _ = _zero(on_path, arc.length, value(arc.end) > 0, guess, slope, tolerance)
        return abs(size), evaluated[size]

    def at_unknown(self, arc: Arc, which: int, value: float) -> tuple[float, PathPoint]:
        """The arclength and the motion at which an unknown has a value that lies between those at the ends of an arc.

        Raises
        ------
        NumericalError
            If the corrections do not settle.
        """
        # The unknown itself is the plane in which the motion is solved for: it has the value to the last digit, without
        # the search along the path that `located` needs for a gap.
        size, slope = arc.crossing(lambda point: float(point.x[which]) - value)
        guess, normal = arc.guess(size), np.zeros(len(self.scale))
        guess[which], normal[which] = value, copysign(1, slope)
        motion = self._newton(guess, normal, False)
        if motion is None:
            raise NumericalError(f"a family of {self.word.letters} was lost")
        return abs(size), self._point(*motion)

    def admits(self, x: Floats) -> bool:
        """Whether a solution is a motion within the range."""
        return bool(min(self.margins(x)) > 0)


def _zero(
    function: Callable[[float], float], end: float, rises: bool, start: float, slope: float, tolerance: float
) -> tuple[float, float]:
    """Where a function is zero between 0 and an end, and its slope there, by secants from a start and a slope.

    The function is positive at the end if it rises. A bisection replaces a secant that would leave the bracket, and
    some others. The tolerance of a correction is a share of the end. What is returned was evaluated.
    """
    # One bracket in Python's numbers: arrays of one number take thirty times as long, some 300 times in an atlas.
    low, high, x, new, before = 0.0, end, start, start, None
    for count in range(MOST_SECANTS):
        x = new
        value = function(x)
        low, high = (low, x) if (value > 0) == rises else (x, high)
        if before is not None and value != before[1]:
            slope = (value - before[1]) / (x - before[0])
        new, before = x - value / slope, (x, value)
        if not min(low, high) <= new <= max(low, high) or (count % 4 == 3 and count >= FREE_SECANTS):
            new = (low + high) / 2
        if abs(new - x) <= tolerance * abs(end):
            return x, slope
    # On steps of 1e-8 the swept parameter itself is rounded to more than the tolerance: the function is a staircase.
    # The least of several gaps can be flat up to where another one falls, on a step of many decades. There secants go
    # on for ever.
    while abs(high - low) > float_info.epsilon * abs(end) and (new := (low + high) / 2) not in (low, high):
        x = new
        low, high = (low, x) if (function(x) > 0) == rises else (x, high)
    return x, slope


def _within_rank(matrix: Floats, right: Floats) -> Floats:
    """Least solution of equations that nearly are too few, as they are where two families cross."""
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=RANK)[0])


class Trail(Struct, frozen=True, eq=False):
    """Points along a curve, and what happens at some of them: the last one ends it."""

    points: list[PathPoint]
    events: list[tuple[int, Event]]

    def reversed(self) -> Trail:
        """The points and events in the order from the other end."""
        last = len(self.points) - 1
        return Trail(self.points[::-1], [(last - i, event) for i, event in self.events[::-1]])


def follow(path: Path, start: PathPoint, until: frozenset[Event] = frozenset()) -> Trail:
    """Follow a path from a motion, in the direction of its tangent, until something ends it, or one of some events."""
    trail, arc, step = Trail([start], []), Arc(start, start), path.first
    # At the very value of an event several families can meet in the start, or none leave it. There rounding passes for
    # motions, from step to step, and the way goes nowhere.
    steps: deque[float] = deque([inf], MOST_IDLE_STEPS)
    while len(trail.points) < MOST_POINTS and step > SHORTEST_STEP and sum(steps) > CLOSE:
        step = min(step, path.reach(arc.end))
        try:
            new = Arc(arc.end, path.neighbour(arc, arc.length + step))
            strain = path.strain(new)
            if strain <= 1:
                if _advance(path, trail, new, until):
                    return trail
                arc = new
                steps.append(abs(new.length))
        except NumericalError:
            strain = inf
        step *= AIM / min(max(strain, LEAST), MOST)
    trail.events.append((len(trail.points) - 1, Event.LOST))
    return trail


def completed(path: Path, start: PathPoint, forward: Trail) -> Trail:
    """A trail with the other way from its start in front of it."""
    if forward.events[-1][1] is Event.CLOSED:
        return forward
    back = follow(path, replace(start, tangent=-start.tangent)).reversed()
    shift = len(back.points) - 1
    events = [*back.events, *((i + shift, event) for i, event in forward.events)]
    return Trail([*back.points, *forward.points[1:]], events)


def _advance(path: Path, trail: Trail, arc: Arc, until: frozenset[Event]) -> bool:
    """Add the points of one step to a trail, and return whether it ends there.

    Raises
    ------
    NumericalError
        If what happens on the way cannot be located.
    """
    # The end is located first: what happens beyond it happens to no motion.
    end, new = path.end_within(arc) if arc.end.margin <= 0 else (None, arc.end)
    happenings, over = path.happenings(Arc(arc.start, new))
    if end is None and _closes(trail, new):
        end, new = Event.CLOSED, trail.points[0]
    for motion, event in happenings if over else [*happenings, (new, end)]:
        trail.points.append(motion)
        if event is not None:
            trail.events.append((len(trail.points) - 1, event))
            if event in until:
                return True
    return over or end is not None


def _closes(trail: Trail, new: PathPoint) -> bool:
    """Whether a curve has come back to the motion that it began with."""
    last, first = trail.points[-1], trail.points[0]
    way, back = new.x - last.x, first.x - last.x
    # The first steps are next to the beginning as well, on their way out.
    if len(trail.points) < 8 or float(last.tangent @ first.tangent) < 1 - SHARPEST**2 / 2:
        return False
    share = float(way @ back) / float(way @ way)
    return 0 <= share <= 1 and float(np.abs(back - share * way).max()) < 0.1 * float(np.abs(way).max())


class Curve(Path, frozen=True, eq=False, dict=True):
    """The motions of one word as a curve, between two values of what varies.

    Attributes
    ----------
    word : Word
    model : Variation
        How the groups depend on what varies.
    low, high : float
        Range of what varies, the coordinate.
    width : float
        What the coordinate is measured by: the range of a sweep, or as much of it as has motions on both membranes.
    passed : tuple of Condition
        What is looked for that motions pass through.
    """

    model: Variation
    low: float
    high: float
    width: float
    passed: tuple[Condition, ...] = PASSED

    __repr__ = brief

    @classmethod
    def along_sweep(cls, word: Word, model: Model, low: float, high: float) -> Self:
        """The motions of one word along a range of the coordinate."""
        # Of a sweep over six decades of frequency d has twelve, and all motions on both membranes are in one or two of
        # them: measured by the whole range, a step of 1e-9 went past them, and events were placed anywhere.
        return cls(word, model, low, high, min(high - low, model.reach(word.periods)))

    @cached_property
    def scale(self) -> Floats:
        """The width of the coordinate, and 1 of velocities and times."""
        return np.append(np.ones(2 * len(self.word)), self.width)

    def groups(self, x: Floats) -> Groups[float]:
        """The dimensionless groups at a motion."""
        return self.model.at((float(x[-1]),))

    def vector(self, motion: Motion) -> Floats:
        """The unknowns of a motion, as one array."""
        return np.concatenate([motion.velocity, motion.time, [motion.coordinate]])

    def motion(self, x: Floats) -> Motion:
        """The motion that an array of unknowns stands for."""
        count = len(self.word)
        return Motion(self.word, x[:count], x[count:-1], float(x[-1]))

    def turns(self, x: Floats) -> list[Turn]:
        """The turning points of a motion."""
        return list(turns(self.motion(x), self.groups(x)))

    def linearised(self, x: Floats) -> tuple[Floats, Floats]:
        """The conditions and their derivatives, the last by the coordinate over its width."""
        values, matrix = linearised(self.word, x, self.model)
        if self.width != 1.0:
            matrix[:, -1] *= self.width
        return values, matrix

    def at(self, guess: Floats, coordinate: float) -> Floats | None:
        """The motion at a value of the coordinate next to a guess."""
        x = guess.copy()
        x[-1] = coordinate
        return self.solved(x, np.eye(len(x))[-1])

    def trace(self, x: Floats) -> float:
        """The trace of a motion; nan where a velocity is zero."""
        row = x.tolist()
        # The trace has the product of the velocities as its denominator, see `weighted_trace`.
        touches = any(abs(velocity) < AT_ZERO for velocity in row[: len(self.word)])
        return nan if touches else float(trace(self.word, row, self.model))

    def stability(self, x: Floats) -> Stability:
        """Table 1's type of a motion."""
        return STABILITIES[int(classify(self.trace(x), self.decay(x)))]

    def margins(self, x: Floats) -> list[float]:
        """What is positive of a motion within the sweep: both distances to its ends, velocities, gaps to the walls."""
        # In the units of the arclength, so that a margin and a step can be compared, see `strain`.
        share, groups = (float(x[-1]) - self.low) / self.width, self.groups(x)
        rest = (self.high - self.low) / self.width - share
        if groups.friction is not None:
            # Friction moves a ball that stops otherwise: it is on another way before it can come to a wall.
            row, count = x.tolist(), len(self.word)
            places = slow_places(self.word, row[:count], row[count : 2 * count], groups)
            return [share, rest, *self._speeds(x), *(place.speed for place in places)]
        gaps = (turn.gap for turn in turns(self.motion(x), groups))
        return [share, rest, *self._speeds(x), *self._leaving(x, groups), *gaps]

    def _leaving(self, x: Floats, groups: Groups[float]) -> list[float]:
        """How fast a ball without restitution leaves its impacts: by the acceleration there, away from the membrane.

        Where that presses it to the membrane it rests, which is no motion of the word. The distance by which the
        solution then passes through the membrane would not tell: it grows with the cube of the acceleration.
        """
        if all(r > 0 for r in stated(groups.restitution)):
            return []
        phases, count = x.tolist()[len(self.word) : -1], len(self.word)
        waves = [groups.wave(pi * t, FLOATS) for t in phases[:count]]
        return [
            -wall * float(groups.pull(at.force))
            for wall, at in zip(self.word.walls, waves, strict=True)
            if stated(groups.restitution)[0 if wall > 0 else 1] == 0
        ]

    def _speeds(self, x: Floats) -> list[float]:
        """Velocities before the impacts, towards their walls: positive of a motion."""
        return [v * wall for v, wall in zip(x.tolist(), self.word.walls, strict=False)]

    def _straight(self, x: Floats) -> bool:
        """Whether the curve is a straight line, on which nothing but the room changes, far beyond all other motions."""
        wide = self.high - self.low > self.width
        return wide and self.word.one_sided and not self.model.slopes((float(x[-1]),))[1:].any()

    def reach(self, point: PathPoint) -> float:
        """Longest step; along a straight line any."""
        return inf if self._straight(point.x) else super().reach(point)

    def strain(self, arc: Arc) -> float:
        """How long a step is as against the longest in which nothing can be missed: on a straight line, nothing can."""
        return 0.0 if self._straight(arc.end.x) else super().strain(arc)

    def steepness(self, arc: Arc) -> float:
        """How much the trace changes within a step, as a share of the most for no event to be missed.

        Where a velocity goes through zero the trace has a pole: the step must be near it, or the last step short.
        """
        if min(self._speeds(arc.end.x)) < AT_ZERO:
            return 0.0 if arc.length < LAST_STEP or self._near_pole(arc.start) else inf
        return abs(self._angle(arc.end) - self._angle(arc.start)) / STEEPEST

    def _angle(self, point: PathPoint) -> float:
        """What stands for the trace: its size at the borders of stability is pi/4, at a pole pi/2."""
        # The trace goes to infinity where a velocity vanishes; its angle is bounded and smooth up to there.
        return atan(point.trace / TRACE_LEVELS[Event.FOLD](point.decay))

    def _near_pole(self, point: PathPoint) -> bool:
        """Whether the trace is so large that nothing happens between the point and an impact of velocity zero."""
        return pi / 2 - abs(self._angle(point)) < STEEPEST

    def leaves(self, x: Floats, first: PathPoint) -> bool:
        """Whether nothing happens between a point from which the curve begins and a motion next to it."""
        return not (x[: len(self.word)] == 0).any() or self._near_pole(first)

    def end_within(self, arc: Arc) -> tuple[Event, PathPoint]:
        """Which of the margins becomes zero first within a step, and the motion there. Raises as `located`."""
        ends = ((-1, self.low, 1), (-1, self.high, -1))
        bounds = [*ends, *((i, 0.0, wall) for i, wall in enumerate(self.word.walls))]
        x = arc.end.x.tolist()
        # The first of the crossings counts: beyond it the other unknowns are those of no motion.
        passed = [self.at_unknown(arc, i, value) for i, value, side in bounds if side * (x[i] - value) <= 0]
        if passed:
            first = min(passed, key=itemgetter(0))[1]
            if first.margin > -AT_ZERO:
                touches = min(map(abs, self._speeds(first.x))) < AT_ZERO
                return Event.ZERO_VELOCITY if touches else Event.SWEEP_END, first
        if self.groups(arc.end.x).friction is not None:
            return Event.STOP, self.located(arc, lambda point: point.margin)[1]
        if not self._straight(arc.end.x):
            return Event.GRAZING, self.located(arc, lambda point: point.margin)[1]
        # Of many decades, the least of all margins is flat, as small as a velocity, up to where a gap falls: only those
        # that fall say where.
        falling = np.flatnonzero(np.asarray(self.margins(arc.end.x)) <= 0)

        def least(point: PathPoint) -> float:
            return float(np.asarray(self.margins(point.x))[falling].min())

        # To the last digit: what is nothing to so long a step may be much to a gap.
        return Event.GRAZING, self.located(arc, least, float_info.epsilon)[1]

    def happenings(self, arc: Arc) -> tuple[list[tuple[PathPoint, Event | None]], bool]:
        """What happens within a step, in order, and whether the last of it ends the family. Raises as `located`."""
        beyond = self._beyond_a_border(arc)
        if beyond is not None:
            first, over = self.happenings(Arc(arc.start, beyond))
            second, ends = ([], True) if over else self.happenings(Arc(beyond, arc.end))
            return [*first, *second], ends
        events: list[tuple[float, PathPoint, Event | None]] = []

        def pass_through(value: Callable[[PathPoint], float]) -> bool:
            return value(arc.start) * value(arc.end) < 0

        for condition in self._passed(arc):
            if pass_through(self._excess(condition)):
                events.append((*self.located(arc, self._excess(condition)), condition.event))
        # A multiplier is 1 where the curve turns in what varies, and where another curve crosses it: at both the
        # derivatives by velocities and times are singular. Which of them it is, the direction of the curve tells.
        meeting = self._excess(MEETING)
        over, meets = False, pass_through(meeting)
        # The swept parameter turns: a fold, where the trace crosses its level too. Where it does not, the trace has
        # only touched it, as that of a family which goes back as its own image does.
        if pass_through(_along):
            where = self.located(arc, meeting if meets else _along)
            image = None if meets else _turned_back(self, where[1].x)
            over = image is not None
            events = [event for event in events if not over or event[0] < where[0]]
            if meets or over:
                events.append((*where, image or Event.FOLD))
        # The trace crosses and the parameter does not turn: two asymmetric families leave the symmetric one here.
        elif meets:
            where = self.located(arc, meeting)
            if _is_symmetric(self, where[1].x):
                events.append((*where, Event.PITCHFORK))
        return [(motion, event) for _, motion, event in sorted(events, key=itemgetter(0))], over

    def _passed(self, arc: Arc) -> tuple[Condition, ...]:
        """What is looked for within a step: without restitution one multiplier is zero, and no type of node changes."""
        if arc.start.decay:
            return self.passed
        return tuple(condition for condition in self.passed if condition.event is not Event.NODE_FOCUS)

    def _excess(self, condition: Condition) -> Callable[[PathPoint], float]:
        """How far the trace of a motion is above that of a condition."""
        return lambda point: float(condition.excess(point.trace, point.decay))

    def _beyond_a_border(self, arc: Arc) -> PathPoint | None:
        """A motion within a step at which the trace has crossed a border to which it comes back, if there is one.

        It is looked for where the parabola through both ends and the middle of the step comes near a border: the trace
        turns little within a step.
        """
        for condition in (*self._passed(arc), MEETING):
            excess = self._excess(condition)
            start, end = excess(arc.start), excess(arc.end)
            near = min(abs(start), abs(end)) < NEARBY * max(1.0, abs(condition.trace(0.0, arc.start.decay)))
            if not (start * end > 0 and near and isfinite(start + end)):
                continue
            # The parabola f(s) = start + s (slope - bend) + s^2 bend through f(0), f(1/2) and f(1), of which bend = 2
            # [f(0) + f(1) - 2 f(1/2)] follows, has its extremum at s = 1/2 - slope/(2 bend).
            slope, bend = end - start, 2 * (start + end - 2 * excess(arc.middle))
            share = 0.5 - slope / (2 * bend) if bend else 0.0
            lowest = start + share * (slope - bend) + share * share * bend
            if not 0 < share < 1 or lowest * copysign(1, start) > DOUBTFUL * min(abs(start), abs(end)):
                continue
            deepest = self._deepest(arc, condition, copysign(1, start), share)
            # Asymmetric motions touch the border in the symmetric one between them, where rounding may say anything.
            touches = _is_symmetric(self, deepest.x) and not _is_symmetric(self, arc.start.x)
            if copysign(1, start) * excess(deepest) < -CROSSED and not touches:
                return deepest
        return None

    def _deepest(self, arc: Arc, condition: Condition, side: float, share: float) -> PathPoint:
        """The motion around a share of a step at which the trace, on one side of a border, is nearest to it."""
        excess = self._excess(condition)
        low, high = (share - SEARCHED) * arc.length, (share + SEARCHED) * arc.length
        first, second = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        values = [side * excess(self.neighbour(arc, size)) for size in (first, second)]
        for _ in range(SECTIONS):
            # The golden section keeps one of the two in the part that is left, where it is the other one.
            if values[0] < values[1]:
                high, second = second, first
                first = high - GOLDEN * (high - low)
                values = [side * excess(self.neighbour(arc, first)), values[0]]
            else:
                low, first = first, second
                second = low + GOLDEN * (high - low)
                values = [values[1], side * excess(self.neighbour(arc, second))]
        return self.neighbour(arc, (low + high) / 2)


def _along(point: PathPoint) -> float:
    """How fast the swept parameter changes along the curve."""
    return float(point.tangent[-1])


def _is_symmetric(curve: Curve, x: Floats, within: float = IMAGE) -> bool:
    """Whether a motion of a horizontal capsule is its own mirror image."""
    motion = curve.motion(x)
    return curve.model.horizontal and motion.distance(motion.mirrored()) < within


def _turned_back(curve: Curve, x: Floats) -> Event | None:
    """The event where a family goes back as its image, at two periods of another motion or a symmetric one; or None."""
    motion = curve.motion(x)
    if 2 * len(motion.primitive().word) == len(motion.word):
        return Event.PERIOD_DOUBLING
    return Event.PITCHFORK if _is_symmetric(curve, x, TURNED_BACK) else None
