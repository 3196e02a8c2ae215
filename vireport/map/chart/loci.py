"""Loci: the curves in the plane of two inputs of a device along which an event of a motion occurs.

The conditions of the motion and of the event are one fewer than the unknowns, so that a locus is a path like a family.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from math import atan, nan, prod
from typing import Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.map.chart.plane import DevicePlane
from vireport.motions.conditions import Condition
from vireport.motions.events import Event
from vireport.motions.paths import RANK, STEEPEST, Arc, Path, PathPoint
from vireport.motions.periodicity import linearised, residuals, weighted_trace
from vireport.motions.turning import Turn, turns
from vireport.physics.groups import Groups
from vireport.physics.motion import AT_ZERO, SAME_TOUCH, Motion
from vireport.physics.numbers import ARRAYS
from vireport.physics.word import Word

Floats = NDArray[np.float64]

TURNED_BACK = 1e-3
"""Difference of a motion to its own image up to which a locus of folds turns back there as that: from the image its
motions differ by a root of the distance, and the equations are singular twice."""

AMPLITUDE, DIFFERENCE = 1e-3, 1e-5
"""Amplitude of motions beside the one from which they begin, and step of derivatives: some six digits of `criticality`
are left."""

STANDSTILL = 1e-5
"""Part of a locus' direction within the plane up to which it stands still there, as at a cusp."""


FIRST_STEP, LONGEST_STEP, SHARPEST = 3e-3, 0.06, 0.25
"""Steps as along families, but longer: along most loci the trace is given, and its poles need no short steps."""


class Locus(Path, frozen=True, eq=False, dict=True):
    """The motions of one word at which a condition holds, as a curve over a plane.

    The unknowns are the N velocities, the N times and the two inputs. At a pitchfork motions are symmetric: the second
    half of their impacts is the mirror image of the first.
    """

    plane: DevicePlane
    condition: Condition
    first, longest, sharpest = FIRST_STEP, LONGEST_STEP, SHARPEST

    @cached_property
    def scale(self) -> Floats:
        """The ranges of the inputs, and 1 of velocities and times."""
        return np.append(np.ones(2 * len(self.word)), self.plane.widths)

    @property
    def touched(self) -> Word:
        """The impacts without those that have no velocity."""
        kept = [i for i in range(len(self.word)) if i not in self.condition.rests]
        return Word(tuple(self.word.walls[i] for i in kept), self.word.periods)

    def groups(self, x: Floats) -> Groups[float]:
        """The groups of the device at a motion on the locus."""
        return self.plane.at(x[2 * len(self.word) :].tolist())

    def motion(self, x: Floats) -> Motion:
        """The motion of some unknowns; its coordinate is d."""
        count = len(self.word)
        return Motion(self.word, x[:count], x[count : 2 * count], float(self.groups(x).d))

    def linearised(self, x: Floats) -> tuple[Floats, Floats]:
        """The conditions of motion and event, and their derivatives by unknowns over their scale."""
        inputs = self.plane.local(x[2 * len(self.word) :].tolist())
        values, matrix = linearised(self.word, x, inputs)
        if self.condition.event is Event.PITCHFORK:
            half = len(self.word) // 2
            values[2 * half :], matrix[2 * half :] = self._mirror(x), self._mirror_slopes()
        value, gradient = self.condition.linearised(self.word, x, inputs.groups, inputs.gradients)
        return np.append(values, value), np.vstack([matrix, gradient]) * self.scale

    def residuals(self, x: Sequence[Any], plane: DevicePlane) -> list[Any]:
        """The conditions of the motion alone, in the kind of number of the plane."""
        values = residuals(self.word, x, plane, plane.ops)
        if self.condition.event is Event.PITCHFORK:
            values[len(self.word) :] = self._mirror(x)
        return values

    def _mirror(self, x: Any) -> list[Any]:
        count, half, k = len(self.word), len(self.word) // 2, self.word.periods
        velocities = [x[i] + x[i + half] for i in range(half)]
        return [*velocities, *(x[i + half] - x[i] - k for i in range(count, count + half))]

    def _mirror_slopes(self) -> Floats:
        half = len(self.word) // 2
        unit, none = np.eye(half), np.zeros((half, half))
        return np.block([[unit, unit, none, none, np.zeros((half, 2))], [none, none, -unit, unit, np.zeros((half, 2))]])

    def trace(self, x: Floats) -> float:
        """Trace at grazing points of the motion without the touch; nan elsewhere, where the condition has it."""
        if self.condition.event is not Event.GRAZING:
            return nan
        count, kept = len(self.word), [i for i in range(len(self.word)) if i not in self.condition.rests]
        unknowns = [float(x[i]) for i in (*kept, *(count + i for i in kept))]
        weight = prod(unknowns[: len(kept)])
        return weighted_trace(self.touched, unknowns, self.groups(x)) / weight if weight else nan

    def turns(self, x: Floats) -> list[Turn]:
        """The turning points of a motion, without touches that are impacts."""
        count, period = len(self.word), 2 * self.word.periods
        rests = x[[count + i for i in self.condition.rests]]
        turning = turns(self.motion(x), self.groups(x))
        return [turn for turn in turning if (np.abs((turn.time - rests + 1) % period - 1) > SAME_TOUCH).all()]

    def margins(self, x: Floats) -> Floats:
        """Numbers that are all positive for a motion within the plane.

        They are distances to the edges of the plane, velocities, gaps to the membranes and, for an impact without
        velocity, the acceleration away from its membrane.
        """
        count, p = len(self.word), x[2 * len(self.word) :]
        edges = np.concatenate([p - self.plane.low, self.plane.high - p]) / np.tile(self.plane.widths, 2)
        speed = x[:count] * self.word.walls
        for i in self.condition.rests:
            gbar = self.groups(x).gbar
            speed[i] = -self.word.walls[i] * (gbar + np.cos(np.pi * x[count + i]))
        return np.concatenate([edges, speed, [turn.gap for turn in self.turns(x)]])

    def steepness(self, arc: Arc) -> float:
        """Change of the trace at grazing points within a step, as a share of the most it may."""
        if self.condition.event is not Event.GRAZING or arc.end.margin <= 0:
            return 0.0
        return abs(atan(arc.end.trace) - atan(arc.start.trace)) / STEEPEST

    def end_within(self, arc: Arc) -> tuple[Event, PathPoint]:
        """Which of the margins becomes zero first within a step, and the motion there. Raises as `located`."""
        _, last = self.located(arc, lambda point: point.margin)
        margins, count = self.margins(last.x), len(self.word)
        edge = int(np.argmin(margins[:4]))
        if abs(margins[edge]) < AT_ZERO:
            x = last.x.copy()
            x[2 * count + edge % 2] = (self.plane.low, self.plane.high)[edge // 2][edge % 2]
            return Event.SWEEP_END, replace(last, x=x)
        stopped = (np.abs(margins[4 : 4 + count]) < AT_ZERO).any()  # beside which rounding may leave a turning point
        return (Event.ZERO_VELOCITY if stopped else Event.GRAZING), last

    def happenings(self, arc: Arc) -> tuple[list[tuple[PathPoint, Event | None]], bool]:
        """What happens within a step, in order, and whether the last of it ends the locus. Raises as `located`."""
        if self.condition.event is Event.FOLD:
            return self._standstill(arc)
        if self.condition.event is not Event.GRAZING:
            return [], False
        located: list[tuple[float, PathPoint, Event | None]] = []
        for event in (Event.PERIOD_DOUBLING, Event.FOLD, Event.DEGENERATE_GRAZING):
            value = self.coincidence(event)
            if value(arc.start) * value(arc.end) < 0:
                located.append((*self.located(arc, value), event))
        return [(motion, event) for _, motion, event in sorted(located, key=lambda row: row[0])], False

    def coincidence(self, event: Event) -> Callable[[PathPoint], float]:
        """How far a motion is from another event besides that of the locus."""
        condition, place = Condition(event, self.condition.rests), 2 * len(self.word)

        def value(point: PathPoint) -> float:
            x = point.x.tolist()
            return float(condition.value(self.word, x[:place], self.plane.at(x[place:]), ARRAYS))

        return value

    def criticality(self, point: PathPoint) -> float:
        """On which side of a locus of period doublings the doubled motions are, and how far.

        That is their distance across the locus, in shares of the ranges, over the square of their distance from the
        motion of the point, to leading order. It is zero, as the cubic coefficient of the normal form, where the
        doubling changes from soft (supercritical) to hard; NaN where an impact is too slow for the finite differences.
        """
        motion, widths = self.motion(point.x).times(2), self.plane.widths
        if np.abs(motion.velocity).min() < 10 * AMPLITUDE:
            return nan
        x, unknowns, p = np.concatenate([motion.velocity, motion.time]), 2 * len(motion.word), point.x[-2:]
        across = widths * np.array([-point.tangent[-1], point.tangent[-2]])

        def conditions(way: Floats, shift: Any = 0.0) -> tuple[Floats, Floats]:
            inputs = p + shift
            return linearised(motion.word, np.append(x + way, inputs), self.plane.local(inputs.tolist()))

        matrix = conditions(0 * x)[1]
        left, _, right = np.linalg.svd(matrix[:, :unknowns])
        against, away = left[:, -1], right[-1]

        def change(way: Floats, shift: Any = 0.0) -> Floats:
            ahead, behind = (
                conditions(step * way, step * shift)[1][:, :unknowns] for step in (DIFFERENCE, -DIFFERENCE)
            )
            return np.asarray((ahead - behind) @ away / (2 * DIFFERENCE))

        right_sides = np.stack([matrix[:, unknowns:] @ across, change(away)], axis=1)
        aside, bend = -np.linalg.lstsq(matrix[:, :unknowns], right_sides, rcond=RANK)[0].T
        ahead, behind = (conditions(step * away + step * step / 2 * bend)[0] for step in (AMPLITUDE, -AMPLITUDE))
        third = float(against @ (ahead - behind)) / (2 * AMPLITUDE**3)
        crossing = float(against @ change(aside, across))
        return -third / crossing if crossing else nan

    def doubled(self, x: Floats) -> tuple[Locus, Floats, Floats]:
        """The locus of folds that begins where period doublings change from soft to hard: its start, and direction."""
        twice = self.motion(x).times(2)
        y = np.concatenate([twice.velocity, twice.time, x[-2:]])
        folds = Locus(twice.word, self.plane, Condition(Event.FOLD))
        away = np.linalg.svd(folds.linearised(y)[1][:-1, :-2])[2][-1]
        return folds, y, np.append(away, (0.0, 0.0))

    def halved(self, x: Floats) -> tuple[Locus, Floats]:
        """Return the locus of the period doublings at which the motions of a fold begin, and a guess next to it."""
        size = len(self.word)
        word = Word(self.word.walls[: size // 2], self.word.periods // 2)
        guess = np.concatenate([x[: size // 2], x[size : size + size // 2], x[-2:]])
        return Locus(word, self.plane, Condition(Event.PERIOD_DOUBLING)), guess

    def _standstill(self, arc: Arc) -> tuple[list[tuple[PathPoint, Event | None]], bool]:
        """A cusp, where a locus of folds turns round in the plane; or where it goes back as its own image."""
        way, after = arc.start.tangent[-2:], arc.end.tangent[-2:]
        if float(way @ after) > 0:
            return [], False
        _, at = self.located(arc, lambda p: float(p.tangent[-2:] @ (way - after)))
        if not float(np.linalg.norm(at.tangent[-2:])) < STANDSTILL:
            return [], False
        motion = self.motion(at.x)
        half, odd = divmod(len(motion.word), 2)
        if not odd and motion.apart(motion.rotated(half)) < TURNED_BACK:
            return [(at, Event.DEGENERATE_DOUBLING)], True
        return [(at, Event.CUSP)], False
