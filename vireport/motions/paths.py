"""Continuation of families of motions of any word, by pseudo-arclength, from event to event.

Motions are points of a space of 2N + 1 unknowns (velocities and times of N impacts, and what varies), in which 2N
conditions leave a curve. A `Path` is such a curve, whatever varies; a `Curve` is the motions of one word along a sweep
or another line through the inputs. Steps are so short that the trace, which decides the type of a motion, changes by
little; every event between two points is bracketed and then located on the curve itself.

Read `follow` (the loop over steps), then `Path.neighbour` (one step), `Path.strain` (its length) and `Curve.happenings`
(its events).
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
from vireport.motions.roots import Crossing, golden_section, path_root
from vireport.motions.stability import STABILITIES, Stability, classify
from vireport.motions.turning import Turn, slow_places, turns
from vireport.physics.groups import Groups, stated
from vireport.physics.motion import AT_ZERO, IMAGE, Motion
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word

Floats = NDArray[np.float64]

FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 1e-3, 0.05, 1e-9
"""First, longest and shortest step of the arclength in velocities [y_c], times [t_c] and the share of the sweep."""

LAST_STEP = 1e-6
"""Arclength of the step up to which a velocity may go to zero wherever the trace is."""

AIM, LEAST, MOST = 0.8, 0.08, 2.5
"""Strain that the next step should have, and the least and largest strain that count: a step becomes at most ten times
as long as the last one, and at least a third as long."""

STEEPEST = 0.35
"""Largest change of arctan(tr/(1 + det)) in a step [rad]; from one border of stability to the other it is pi/2."""

CLOSE = 1e-4
"""Step that need not be shorter because a velocity or gap is small."""

SHARPEST = 0.1
"""Largest change of the direction within a step [rad]."""

MOST_POINTS = 4000
"""Largest number of points of one family in one direction."""

MOST_IDLE_STEPS = 50
"""Number of steps in a row that together must be longer than `CLOSE`, or the path goes nowhere; on 60 random devices
any two in a row were."""

CONVERGED, ROUNDING = 1e-12, 1e-10
"""Newton correction that ends the search for a motion, and the one that is accepted where rounding prevents that."""

LOCATED, ON_CUBIC = 1e-11, 1e-7
"""Correction, as a share of a step, that ends the search for an event on the path, and on a cubic next to it."""

SQUARED = 1e-9
"""Newton correction that ends the search where the next one would be about its square."""

CORRECTIONS = 8
"""Largest number of Newton corrections of a guess."""

RANK = 1e-7
"""Singular value, over the largest, that counts as zero where families cross."""

MOST_ASIDE = 1e3
"""Length of a tangent before it is normalised, at which another curve crosses."""


PASSED = Condition(Event.PERIOD_DOUBLING), Condition(Event.NODE_FOCUS), Condition(Event.NODE_FOCUS, sign=-1)
"""Conditions on the trace at which motions of a family continue beyond the event."""

MEETING = Condition(Event.FOLD)
"""The condition at which motions meet, in a fold or a pitchfork."""

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
"""Depth beyond which the trace crosses a border rather than touches it."""


class PathPoint(Struct, frozen=True, eq=False, dict=True):
    """A motion on a path, or a guess at one, with the direction of the path.

    Attributes
    ----------
    path : Path
    x : ndarray
        Velocities, times and what varies.
    tangent : ndarray
        Direction of the path, in unknowns over their scale.
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
    """A step of a path as a cubic: through the motions at both ends, with the directions of the path there."""

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
        """The chord from start to end, in unknowns over their scale."""
        return (self.end.x - self.start.x) / self.start.path.scale

    @cached_property
    def _bend(self) -> tuple[Any, Any]:
        """Coefficients of the square and of the cube of the arclength in the cubic."""
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

    def crossing(self, value: Callable[[PathPoint], float]) -> Crossing:
        """Arclength at which a function on the cubic is zero, whose signs differ at the ends."""
        first, last = value(self.start), value(self.end)
        slope = (last - first) / self.length
        guess = Crossing(-first / slope, slope)
        return path_root(lambda size: value(self.at(size)), self.length, last > 0, guess, ON_CUBIC)


class Path(Struct, frozen=True, eq=False):
    """A curve of motions: the solutions of conditions that are one fewer than the unknowns.

    The unknowns are velocities and times of the impacts [y_c, t_c] and the inputs that vary. Each kind of path defines
    what varies and which events occur; `follow` follows all of them.

    Attributes
    ----------
    word : Word
    first, longest : float
        First and longest step of the arclength.
    sharpest : float
        Largest change of the direction within a step [rad].
    settled : float
        Newton correction that ends the search for the motion at the end of a step.
    resolved : float
        Correction, as a share of a step, that ends the search for an event within it.
    """

    word: Word
    first, longest, sharpest = FIRST_STEP, LONGEST_STEP, SHARPEST
    settled, resolved = SQUARED, LOCATED

    @property
    @abstractmethod
    def scale(self) -> Floats:
        """The divisors of the unknowns, so that one arclength measures them all."""

    @abstractmethod
    def linearised(self, x: Floats) -> tuple[Floats, Floats]:
        """The conditions, (m,), and their derivatives by the unknowns over their scale, (m, m + 1)."""

    @abstractmethod
    def groups(self, x: Floats) -> Groups[float]:
        """The dimensionless groups at a motion."""

    @abstractmethod
    def motion(self, x: Floats) -> Motion:
        """The motion that an array of unknowns stands for."""

    @abstractmethod
    def trace(self, x: Floats) -> float:
        """The trace of a motion; nan where a velocity is zero."""

    @abstractmethod
    def margins(self, x: Floats) -> Floats | list[float]:
        """Numbers that are all positive if and only if a solution is an admissible motion within the range."""

    @abstractmethod
    def steepness(self, arc: Arc) -> float:
        """Change within a step of the function that locates events, over the largest at which none can be missed."""

    @abstractmethod
    def end_within(self, arc: Arc) -> tuple[Event, PathPoint]:
        """The event at which the first of the margins becomes zero within a step, and the motion there.

        Raises
        ------
        NumericalError
            As `located`.
        """

    @abstractmethod
    def happenings(self, arc: Arc) -> tuple[list[tuple[PathPoint, Event | None]], bool]:
        """The events within a step, in order, and whether the last of them ends the path.

        Raises
        ------
        NumericalError
            As `located`.
        """

    def decay(self, x: Floats) -> float:
        """Product of the restitution coefficients over the impacts of a motion, the root of the determinant."""
        return float(self.groups(x).decay(self.word.walls, x[: len(self.word)].tolist()))

    def strain(self, arc: Arc) -> float:
        """Length of a step over the longest one in which no event can be missed; a step is accepted up to 1.

        Notes
        -----
        To go to zero and come back within a step, a velocity or gap needs a rate that changes. Rates change with the
        direction of the curve and along it, at most by about eight times as much, and the dip between the ends of the
        step is an eighth of the step times that change.
        """
        point, new, step = arc.start, arc.end, abs(arc.length)
        turned = sqrt(2 * max(1 - float(new.tangent @ point.tangent), 0.0))
        steepest = max(turned / self.sharpest, self.steepness(arc))
        # The margins come last and only if they can matter: they need the turning points of every flight.
        if steepest > 1 or step <= CLOSE or (least := min(point.margin, new.margin)) <= 0:
            return steepest
        return max(steepest, step * (turned + step) / least)

    def reach(self, point: PathPoint) -> float:
        """Longest step from a point: by `strain` it grows with the root of the least velocity or gap."""
        return max(min(sqrt(max(point.margin, 0.0)) / 2, self.longest), CLOSE)

    def leaves(self, x: Floats, first: PathPoint) -> bool:
        """Whether no event can be between the unknowns `x` at which a path begins and its first motion."""
        return True

    def solved(self, guess: Floats, normal: Floats) -> Floats | None:
        """The motion nearest to a guess in the plane through it with this normal; None if corrections do not settle."""
        # Least squares, which also stand equations that depend on each other where families cross, take three times as
        # long as a solution by factors: 19 to 63 us against 7 to 12 us of up to six impacts.
        return (self._newton(guess, normal, False) or self._newton(guess, normal, True) or (None,))[0]

    def _newton(
        self, guess: Floats, normal: Floats, crossing: bool, settled: float = SQUARED
    ) -> tuple[Floats, Floats] | None:
        """Solve for the motion in the plane through a guess with a normal, and the direction of the path there.

        Parameters
        ----------
        guess, normal : ndarray
            The normal is in unknowns over their scale. Zero stands for no plane: the least correction is then the
            shortest way to the path.
        crossing : bool
            Whether the equations may depend on each other, as where two families cross.
        settled : float
            Correction that ends the search where they do not.

        Returns
        -------
        motion, tangent : ndarray
            The tangent, not normalised, on the side of the normal, at the last correction but one. None if the
            corrections do not settle.
        """
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
            if last < (CONVERGED if crossing else settled):
                return x, tangent
        return (x, tangent) if last < ROUNDING else None

    def nearest(self, guess: Floats) -> Floats | None:
        """The motion of the path nearest to a guess; None if corrections do not settle."""
        # Without a normal the least solution is the shortest way to the path.
        return (self._newton(guess, np.zeros(len(guess)), True) or (None,))[0]

    def point(self, x: Floats, tangent: Floats) -> PathPoint:
        """The point at a motion, with the direction of the path on the side of a given direction."""
        return self._point(x, _within_rank(np.concatenate([self.linearised(x)[1], tangent[None]]), np.eye(len(x))[-1]))

    def _point(self, x: Floats, tangent: Floats) -> PathPoint:
        """The point at a motion, with a direction that is normalised."""
        return PathPoint(self, x, tangent / sqrt(tangent @ tangent))

    def tangent(self, x: Floats) -> Floats:
        """The direction of the path, of either sign."""
        return np.asarray(np.linalg.svd(self.linearised(x)[1])[2][-1])

    def neighbour(self, arc: Arc, size: float, settled: float = SQUARED) -> PathPoint:
        """The motion next to the cubic of an arc, at an arclength from its start that may be beyond its end.

        Raises
        ------
        NumericalError
            If the corrections do not settle.
        """
        guess = arc.guess(size)
        motion = self._newton(guess, arc.end.tangent, False, settled)
        # Next to a crossing the bordered matrix is nearly singular: its tangent may be that of the other family.
        if motion is None or not motion[1] @ motion[1] < MOST_ASIDE**2:
            motion = self._newton(guess, arc.end.tangent, True)
        if motion is None:
            raise NumericalError(f"a family of {self.word.letters} was lost")
        return self._point(*motion)

    def located(
        self, arc: Arc, value: Callable[[PathPoint], float], tolerance: float | None = None
    ) -> tuple[float, PathPoint]:
        """Locate the motion at which a function is zero within a step, at whose ends its signs differ.

        Parameters
        ----------
        arc : Arc
        value : callable
        tolerance : float, optional
            Correction, as a share of the step, that ends the search; by default `resolved`.

        Returns
        -------
        float
            Arclength from the start.
        PathPoint

        Raises
        ------
        NumericalError
            As `neighbour`.
        """
        if value(arc.start) == value(arc.end):
            return 0.0, arc.start  # zero at the start, to rounding, and constant over the step
        evaluated, guess = {}, arc.crossing(value)

        def on_path(size: float) -> float:
            evaluated[size] = self.neighbour(arc, size)
            return value(evaluated[size])

        size, _ = path_root(on_path, arc.length, value(arc.end) > 0, guess, tolerance or self.resolved)
        return abs(size), evaluated[size]

    def at_unknown(self, arc: Arc, which: int, value: float) -> tuple[float, PathPoint]:
        """Locate the motion at which one unknown has a given value, between those at the ends of a step.

        Parameters
        ----------
        arc : Arc
        which : int
            Number of the unknown.
        value : float

        Returns
        -------
        float
            Arclength from the start.
        PathPoint

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


def _within_rank(matrix: Floats, right: Floats) -> Floats:
    """The least solution of equations that may nearly depend on each other, as where two families cross."""
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=RANK)[0])


class Trail(Struct, frozen=True, eq=False):
    """A path as it was followed: its points in order, and (number of the point, event); the last event ends it."""

    points: list[PathPoint]
    events: list[tuple[int, Event]]

    def reversed(self) -> Trail:
        """The trail in the opposite order."""
        last = len(self.points) - 1
        return Trail(self.points[::-1], [(last - i, event) for i, event in self.events[::-1]])


def follow(path: Path, start: PathPoint, until: frozenset[Event] = frozenset()) -> Trail:
    """Follow a path from a motion in the direction of its tangent, until an event ends it.

    Parameters
    ----------
    path : Path
    start : PathPoint
    until : frozenset of Event
        Events that end the search as well.

    Returns
    -------
    Trail
        Its last event is `Event.LOST` if the steps would become too short, too many, or the corrections do not settle.
    """
    # The predictor is the cubic of the last step, extrapolated, whose error is of the fourth order in the step; that of
    # the tangent would be of the second. The corrector works in the plane across it, so that folds are nothing special.
    trail, arc, step = Trail([start], []), Arc(start, start), path.first
    # At the very value of an event several families can meet in the start, or none leave it. There rounding passes for
    # motions, from step to step, and the path goes nowhere.
    steps: deque[float] = deque([inf], MOST_IDLE_STEPS)
    while len(trail.points) < MOST_POINTS and step > SHORTEST_STEP and sum(steps) > CLOSE:
        step = min(step, path.reach(arc.end))
        try:
            new = Arc(arc.end, path.neighbour(arc, arc.length + step, path.settled))
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
    """A trail completed by the part of the path behind its start, unless it came back to the start itself."""
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
    # The end is located first: events beyond it belong to no motion.
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
    """Whether the step to a new point passes the motion that the trail began with."""
    last, first = trail.points[-1], trail.points[0]
    way, back = new.x - last.x, first.x - last.x
    # The first steps of a trail are near its beginning as well.
    if len(trail.points) < 8 or float(last.tangent @ first.tangent) < 1 - SHARPEST**2 / 2:
        return False
    length = float(way @ way)
    if not length:  # where rounding swallows a step, nothing is passed
        return False
    share = float(way @ back) / length
    return 0 <= share <= 1 and float(np.abs(back - share * way).max()) < 0.1 * float(np.abs(way).max())


class Curve(Path, frozen=True, eq=False, dict=True):
    """The motions of one word as a path, between two values of the number that varies, the coordinate.

    Attributes
    ----------
    word : Word
    model : Variation
        How the groups depend on the coordinate.
    low, high : float
        Range of the coordinate.
    width : float
        Scale of the coordinate in the arclength: its range, or the part of it that has motions on both membranes.
    passed : tuple of Condition
        Conditions looked for at which motions continue beyond the event.
    """

    model: Variation
    low: float
    high: float
    width: float
    passed: tuple[Condition, ...] = PASSED

    __repr__ = brief

    @classmethod
    def over_sweep(cls, word: Word, model: Model, low: float, high: float) -> Self:
        """The curve of the motions of one word over a range of the sweep's coordinate."""
        # In a sweep over six decades of frequency d has twelve, and all motions on both membranes are in one or two of
        # them: measured by the whole range, a step of 1e-9 went past them, and events were placed anywhere.
        return cls(word, model, low, high, min(high - low, model.reach(word.periods)))

    @cached_property
    def scale(self) -> Floats:
        """1 for velocities and times, and the width for the coordinate, (2N + 1,)."""
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
        """The motion next to a guess at a value of the coordinate; None if corrections do not settle."""
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
        """Distances to both ends of the range, velocities towards the walls, and gaps to these: positive for a motion.

        With friction, the speeds onward in the flights in the place of the gaps.
        """
        # In the units of the arclength, so that a margin and a step can be compared, see `strain`.
        share, groups = (float(x[-1]) - self.low) / self.width, self.groups(x)
        rest = (self.high - self.low) / self.width - share
        if groups.friction is not None:
            # A ball that stopped in flight would have its friction reversed: it leaves the path of the equations before
            # it can come to a wall.
            row, count = x.tolist(), len(self.word)
            places = slow_places(self.word, row[:count], row[count : 2 * count], groups)
            return [share, rest, *self._speeds(x), *(place.speed for place in places)]
        gaps = (turn.gap for turn in turns(self.motion(x), groups))
        return [share, rest, *self._speeds(x), *self._leaving(x, groups), *gaps]

    def _leaving(self, x: Floats, groups: Groups[float]) -> list[float]:
        """Accelerations away from the membrane at the impacts whose restitution is zero.

        If one is negative the ball rests on the membrane, which is no motion of the word. The gap would not show that:
        the distance by which the solution passes through the membrane grows with the cube of the acceleration.
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
        """Velocities before the impacts, towards their walls: positive for a motion."""
        return [v * wall for v, wall in zip(x.tolist(), self.word.walls, strict=False)]

    def _straight(self, x: Floats) -> bool:
        """Whether the curve is a straight line at x: one membrane alone is struck, and only d changes."""
        wide = self.high - self.low > self.width
        return wide and self.word.one_sided and not self.model.slopes((float(x[-1]),))[1:].any()

    def reach(self, point: PathPoint) -> float:
        """Longest step from a point; infinite on a straight line."""
        return inf if self._straight(point.x) else super().reach(point)

    def strain(self, arc: Arc) -> float:
        """Length of a step over the longest in which no event can be missed; 0 on a straight line."""
        return 0.0 if self._straight(arc.end.x) else super().strain(arc)

    def steepness(self, arc: Arc) -> float:
        """Change of the trace's angle within a step, over the most at which no event can be missed.

        Where a velocity goes through zero the trace has a pole: infinite unless the step begins near the pole, or is
        so short that it may be the last.
        """
        if min(self._speeds(arc.end.x)) < AT_ZERO:
            return 0.0 if arc.length < LAST_STEP or self._near_pole(arc.start) else inf
        return abs(self._angle(arc.end) - self._angle(arc.start)) / STEEPEST

    def _angle(self, point: PathPoint) -> float:
        """arctan(tr/(1 + det)) [rad]: +-pi/4 at the borders of stability, +-pi/2 at a pole of the trace."""
        # The trace goes to infinity where a velocity vanishes; its angle is bounded and smooth up to that motion.
        return atan(point.trace / TRACE_LEVELS[Event.FOLD](point.decay))

    def _near_pole(self, point: PathPoint) -> bool:
        """Whether the trace is so large that no event is between the point and an impact of velocity zero."""
        return pi / 2 - abs(self._angle(point)) < STEEPEST

    def leaves(self, x: Floats, first: PathPoint) -> bool:
        """Whether no event can be between the unknowns `x` at which the curve begins and its first motion."""
        return not (x[: len(self.word)] == 0).any() or self._near_pole(first)

    def end_within(self, arc: Arc) -> tuple[Event, PathPoint]:
        """The event at which the first of the margins becomes zero within a step, and the motion there.

        Raises
        ------
        NumericalError
            As `located`.
        """
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
        # Over many decades the least of all margins is flat, as small as a velocity, up to where a gap falls: the zero
        # is looked for in those margins alone that are zero or less at the end.
        falling = np.flatnonzero(np.asarray(self.margins(arc.end.x)) <= 0)

        def least(point: PathPoint) -> float:
            return float(np.asarray(self.margins(point.x))[falling].min())

        # To the last digit: a share of so long a step that is negligible may be much for a gap.
        return Event.GRAZING, self.located(arc, least, float_info.epsilon)[1]

    def happenings(self, arc: Arc) -> tuple[list[tuple[PathPoint, Event | None]], bool]:
        """The events within a step, in order, and whether the last of them ends the family.

        Raises
        ------
        NumericalError
            As `located`.
        """
        beyond = self._beyond_a_border(arc)
        if beyond is not None:
            first, over = self.happenings(Arc(arc.start, beyond))
            second, ends = ([], True) if over else self.happenings(Arc(beyond, arc.end))
            return [*first, *second], ends
        events: list[tuple[float, PathPoint, Event | None]] = []

        def changes_sign(value: Callable[[PathPoint], float]) -> bool:
            return value(arc.start) * value(arc.end) < 0

        for condition in self._passed(arc):
            if changes_sign(self._excess(condition)):
                events.append((*self.located(arc, self._excess(condition)), condition.event))
        # A multiplier is 1 where the curve turns in what varies, and where another curve crosses it: at both the
        # derivatives by velocities and times are singular. Which of them it is, the direction of the curve tells.
        meeting = self._excess(MEETING)
        over, meets = False, changes_sign(meeting)
        # The swept parameter turns: a fold, where the trace crosses its level too. Where it does not, the trace has
        # only touched it, as that of a family which goes back as its own image does.
        if changes_sign(_sweep_rate):
            size, turning = self.located(arc, meeting if meets else _sweep_rate)
            image = None if meets else _turned_back(self, turning.x)
            over = image is not None
            events = [event for event in events if not over or event[0] < size]
            events.append((size, turning, image or Event.FOLD))
        # The trace crosses and the parameter does not turn: two asymmetric families leave the symmetric one.
        elif meets:
            size, fork = self.located(arc, meeting)
            if _is_symmetric(self, fork.x):
                events.append((size, fork, Event.PITCHFORK))
        return [(motion, event) for _, motion, event in sorted(events, key=itemgetter(0))], over

    def _passed(self, arc: Arc) -> tuple[Condition, ...]:
        """Conditions looked for within a step: not node and focus if r = 0, where one multiplier is always zero."""
        if arc.start.decay:
            return self.passed
        return tuple(condition for condition in self.passed if condition.event is not Event.NODE_FOCUS)

    def _excess(self, condition: Condition) -> Callable[[PathPoint], float]:
        """The function of a motion that is its trace less the trace at a condition."""
        return lambda point: float(condition.excess(point.trace, point.decay))

    def _beyond_a_border(self, arc: Arc) -> PathPoint | None:
        """A motion within a step at which the trace is beyond a border that it crosses twice; None if there is none.

        It is looked for where the parabola through both ends and the middle of the step comes near a border: within a
        step the trace bends little.
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
            # Asymmetric motions touch the border at the symmetric motion between them, where the sign is rounding.
            touches = _is_symmetric(self, deepest.x) and not _is_symmetric(self, arc.start.x)
            if copysign(1, start) * excess(deepest) < -CROSSED and not touches:
                return deepest
        return None

    def _deepest(self, arc: Arc, condition: Condition, side: float, share: float) -> PathPoint:
        """The motion near a share of a step whose trace is nearest to a border, or farthest beyond it.

        Parameters
        ----------
        arc : Arc
        condition : Condition
            The condition whose trace is the border.
        side : float
            Side of the border on which the ends of the step are, 1 or -1.
        share : float
        """
        excess = self._excess(condition)
        low, high = (share - SEARCHED) * arc.length, (share + SEARCHED) * arc.length
        size = golden_section(lambda size: side * excess(self.neighbour(arc, size)), low, high, SECTIONS)
        return self.neighbour(arc, size)


def _sweep_rate(point: PathPoint) -> float:
    """Derivative of the coordinate by the arclength."""
    return float(point.tangent[-1])


def _is_symmetric(curve: Curve, x: Floats, within: float = IMAGE) -> bool:
    """Whether a motion of a horizontal capsule is its own mirror image."""
    motion = curve.motion(x)
    return curve.model.horizontal and motion.distance(motion.mirrored()) < within


def _turned_back(curve: Curve, x: Floats) -> Event | None:
    """The event at which a family turns back as its own image, a period doubling or pitchfork of others; else None."""
    motion = curve.motion(x)
    if 2 * len(motion.primitive().word) == len(motion.word):
        return Event.PERIOD_DOUBLING
    return Event.PITCHFORK if _is_symmetric(curve, x, TURNED_BACK) else None
