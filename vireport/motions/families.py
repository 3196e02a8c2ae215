"""Families of motions of any word, and the atlas of a sweep: families are its edges, points where they meet vertices.

A 1:1 branch in closed form and a family that was followed by steps are the same record, `Family`.
"""

from __future__ import annotations

from enum import StrEnum
from functools import cached_property
from itertools import pairwise
from math import isfinite, pi
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.motions.error_bounds import distance_bounds, family_bounds
from vireport.motions.events import Event
from vireport.motions.paths import Curve
from vireport.motions.periodicity import Model, model_of
from vireport.motions.points import Point
from vireport.motions.stability import STABILITIES, Stability, classify
from vireport.motions.sweep import Sweep, settable
from vireport.motions.switching import Limits
from vireport.physics.motion import Motion, multipliers
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word
from vireport.text.formatting import span

Floats = NDArray[np.float64]

ROUNDING = 1e-9
"""Share of the sweep up to which a value beyond the end of a family counts as that end."""

MOST_PRINTED = 150
"""Largest number of families that a page shows: as rows some three pages, as curves as many as the eye can separate.
Over a thousand, as with a restitution near 1, took ten times as long to draw and to set, and made a page of 44 MB."""


class Mark(Struct, frozen=True, eq=False):
    """An event at a row of a family, with its point if it has been solved for."""

    row: int
    event: Event
    point: Point | None = None

    __repr__ = brief


class Segment(Struct, frozen=True):
    """Rows `first` to `last` (inclusive) of a family, with no event between them."""

    first: int
    last: int
    stability: Stability
    admissible: bool

    @property
    def stable(self) -> bool:
        """Whether its solutions are motions and attract others nearby."""
        return self.admissible and self.stability.attracts


class Family(Struct, frozen=True, eq=False, dict=True):
    """Connected motions of one word, ordered along their curve.

    Attributes
    ----------
    number : int
        From 1; 0 before it is numbered.
    sweep : Sweep
    curve : Curve
        The motions of its word over the sweep.
    x : ndarray (n, 2N + 1)
        Velocities [y_c], times [t_c] and coordinate of each motion.
    trace : ndarray (n,)
        Trace of the return map; nan where a velocity is zero.
    sweep_value : ndarray (n,)
        The swept parameter, in its unit.
    admissible_mask : ndarray (n,)
        Whether the ball stays between the membranes: some solutions of a closed form are no motions.
    marks : tuple of Mark
        Events, in order; the first and the last end the family.
    """

    number: int
    sweep: Sweep
    curve: Curve
    x: Floats
    trace: Floats
    sweep_value: Floats
    admissible_mask: NDArray[np.bool_]
    marks: tuple[Mark, ...]

    def __repr__(self) -> str:
        return f"<Family {self.number} of {self.text}>"

    @property
    def text(self) -> str:
        """A line of text: word, number of motions, range of the swept parameter and where in it they are stable."""
        swept = self.sweep.parameter
        low, high = float(self.sweep_value.min()), float(self.sweep_value.max())
        stable = "; ".join(span(*part) for part in self.stable_ranges)
        stability = f"stable for {swept.with_unit(stable)}" if stable else "nowhere stable"
        return f"{self.name}: {len(self.x)} motions, {swept.symbol} = {swept.with_unit(span(low, high))}, {stability}"

    @property
    def word(self) -> Word:
        """The impacts of one period."""
        return self.curve.word

    @property
    def model(self) -> Model:
        """The groups along the sweep of the family."""
        return model_of(self.sweep, FLOATS)

    def stability(self, trace: float, coordinate: float) -> Stability:
        """Type of a motion with a trace, at a value of the coordinate."""
        return STABILITIES[int(classify(trace, self.model.decay(self.word.walls, coordinate)))]

    @property
    def name(self) -> str:
        """The word of its motions and their period, such as BBT every forcing period."""
        return self.word.name

    @property
    def ends(self) -> tuple[Mark, Mark]:
        """The events at which it begins and ends; the same one twice for a closed curve."""
        first, last = self.marks[0], self.marks[-1]
        return last if first.row else first, last

    @property
    def velocity(self) -> Floats:
        """Velocity before each impact of each motion, (n, N) [y_c]."""
        return self.x[:, : len(self.word)]

    @property
    def phase(self) -> Floats:
        """Forcing phase at each impact of each motion, (n, N) [rad], in [0, 2 pi)."""
        return np.mod(pi * self.time, 2 * pi)

    @property
    def time(self) -> Floats:
        """Time of each impact of each motion, (n, N) [t_c], from a beginning of the forcing period on."""
        return self.x[:, len(self.word) : -1]

    @property
    def d(self) -> Floats:
        """Distance between the membranes, of each motion."""
        return np.broadcast_to(self.model.groups(self.x[:, -1])[0], len(self.x))

    @cached_property
    def critical_points(self) -> dict[int, Point]:
        """The labelled points on the family, by their rows."""
        return {mark.row: mark.point for mark in self.marks if mark.point is not None and mark.point.label}

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        """The stretches of the family between events, each of one type."""
        rows = sorted({0, len(self.x) - 1, *(mark.row for mark in self.marks)})
        return tuple(self._segment(first, last) for first, last in pairwise(rows))

    def _segment(self, first: int, last: int) -> Segment:
        """The stretch between two rows, with the type and admissibility of a motion in its middle."""
        # Events are at its ends: only a motion between them has the type of the stretch. If no row is between them, it
        # is solved for.
        inner, ends = (first + last) // 2, [first, last]
        if inner != first:
            stability = self.stability(float(self.trace[inner]), float(self.x[inner, -1]))
            return Segment(first, last, stability, bool(self.admissible_mask[inner]))
        trace, admissible = float(self.trace[ends].mean()), bool(self.admissible_mask[ends].all())
        middle = float(self.x[ends, -1].mean())
        x = self.curve.at(self.x[ends].mean(axis=0), middle)
        if x is not None:
            trace, admissible = self.curve.trace(x), admissible or self.curve.admits(x)
        return Segment(first, last, self.stability(trace, middle), admissible)

    @property
    def stable_mask(self) -> NDArray[np.bool_]:
        """Whether each motion lies on a stable stretch."""
        stable = np.zeros(len(self.x), dtype=bool)
        for part in self.segments:
            stable[part.first : part.last + 1] |= part.stable
        return stable

    @cached_property
    def stable_runs(self) -> list[tuple[int, int]]:
        """First and last rows of the stretches over which the family is stable without a break."""
        runs: list[tuple[int, int]] = []
        for part in self.segments:
            if part.stable and runs and runs[-1][1] == part.first:
                runs[-1] = runs[-1][0], part.last
            elif part.stable:
                runs.append((part.first, part.last))
        return runs

    @property
    def stable_ranges(self) -> list[tuple[float, float]]:
        """Least and largest value of the swept parameter on each of `stable_runs`."""
        parts = (self.sweep_value[first : last + 1] for first, last in self.stable_runs)
        return [(float(part.min()), float(part.max())) for part in parts]

    @property
    def settable(self) -> bool:
        """Whether the family has stable motions over a range wide enough for a device to be set into it."""
        return any(settable(*part, self.sweep.off) for part in self.stable_ranges)

    def settable_at(self, value: float) -> bool:
        """Whether a stable range around a value of the swept parameter is wide enough; True if none is around it."""
        # A value may lie just outside the samples of a stable range: that is no reason to leave a motion out.
        around = [part for part in self.stable_ranges if part[0] <= value <= part[1]]
        return not around or any(settable(*part, self.sweep.off) for part in around)

    @property
    def determinant(self) -> Any:
        """Determinant of the return map, product of r^2 over the impacts: a number, or an array over the motions."""
        return self.model.determinant(self.word.walls, self.x[:, -1])

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Both multipliers of each motion, (n, 2), the one of larger modulus first; nan where a velocity is zero."""
        return multipliers(self.trace, self.determinant)

    @cached_property
    def error_bound(self) -> Floats:
        """Bounds of the distance from each row of `x` to an exact motion, (n, 2N + 1); inf where there is none.

        Where families cross, the exact motion is the point that was solved for in decimals.
        """
        # Where families cross the derivatives are singular, and Kantorovich's theorem gives no distance.
        bounds = distance_bounds(self.curve, self.model, self.x)
        for row, point in ((mark.row, mark.point) for mark in self.marks if mark.point is not None):
            laps, others = divmod(len(self.word), len(point.motion.word))
            if not np.isfinite(bounds[row]).all() and isfinite(point.error_bound) and not others:
                motion, exact = self.curve.motion(self.x[row]), point.motion.times(laps)
                away = motion.distance(exact, mirror=self.model.horizontal)
                bounds[row] = max(away, abs(motion.coordinate - exact.coordinate)) + np.spacing(self.x[row]).max()
        return bounds

    @cached_property
    def error_bounds(self) -> dict[str, Floats]:
        """Error bounds of `sweep_value` [its unit], `velocity` [y_c] and `phase` [rad]; inf for none."""
        return family_bounds(self.sweep, self.model, self.x, self.error_bound, self.sweep_value)

    def at(self, coordinate: float) -> list[Motion]:
        """Solve for the family's motions at a value of the coordinate."""
        # A family may turn back in the swept parameter and pass a value several times: each crossing is one motion.
        c, motions = self.x[:, -1], []
        nearest = float(np.clip(coordinate, c.min(), c.max()))
        if abs(coordinate - nearest) < ROUNDING * (self.curve.high - self.curve.low):
            coordinate = nearest
        before, after = c[:-1] - coordinate, c[1:] - coordinate
        # A row that is there belongs to the step after it, the last one to that before it: so it counts once.
        crossing = (before * after < 0) | (before == 0)
        crossing[-1:] |= after[-1:] == 0
        for i in np.flatnonzero(crossing):
            step = c[i + 1] - c[i]
            share = (coordinate - c[i]) / step if step else 0.5
            x = self.curve.at(self.x[i] + share * (self.x[i + 1] - self.x[i]), coordinate)
            if x is not None:
                motions.append(self.curve.motion(x))
        return motions


class Claim(StrEnum):
    """Evidence for the completeness of the families of one word."""

    COMPLETE = "complete"
    """No family is missing but those nearer to a listed one than the resolution, and in undecided flight times."""
    SEARCHED = "searched"
    """All families were looked for; those smaller than the resolution can be missed."""
    FOLLOWED = "followed"
    """Only families that join others, or that a simulation came to, are listed."""


class Completeness(Struct, frozen=True):
    """Completeness of the families of one word.

    Attributes
    ----------
    word : str
    claim : Claim
    resolution : float or None
        Distance in flight times, in forcing periods.
    undecided : float or None
        Share of all flight times for which the search is undecided, the largest over the numbers of forcing periods.
    """

    word: str
    claim: Claim
    resolution: float | None = None
    undecided: float | None = None


class Atlas(Struct, frozen=True, eq=False):
    """The families of motions along a sweep, and where they meet.

    Attributes
    ----------
    sweep : Sweep
    limits : Limits
    families : tuple of Family
        By number of impacts, word, periods and range.
    vertices : tuple of Point
        In the order of the sweep.
    completeness : tuple of Completeness
        Completeness of each word that is searched for; for all others it is `Claim.FOLLOWED`.
    followed : int
        Impacts up to which every family that joins another is followed: those of `limits`, or fewer if the families are
        too many.
    """

    sweep: Sweep
    limits: Limits
    families: tuple[Family, ...]
    vertices: tuple[Point, ...]
    completeness: tuple[Completeness, ...]
    followed: int

    __repr__ = brief

    @property
    def printed_families(self) -> tuple[Family, ...]:
        """The families on pages, at most `MOST_PRINTED`, in order of their numbers.

        Chosen first are those with stable motions that a device can be set to, then those of the shortest words.
        """
        first = sorted(self.families, key=lambda family: not family.settable)
        return tuple(sorted(first[:MOST_PRINTED], key=lambda family: family.number))

    def at(self, value: float) -> list[tuple[Family, Motion]]:
        """Every motion at a value of the swept parameter, with its family."""
        coordinate = float(self.sweep.coordinate_of(value))
        return [(family, motion) for family in self.families for motion in family.at(coordinate)]

    def named(self, name: str) -> tuple[float, Motion] | None:
        """The swept value and motion of a vertex, by its label, or of a word; None if there is none.

        For a word it is the motion in the middle of its widest stable stretch or, if none is stable, of its widest
        family.
        """
        for vertex in self.vertices:
            if vertex.label == name:
                return vertex.sweep_value, vertex.motion
        word = Word.of(name, 1).canonical().letters if set(name) <= {"B", "T"} else name
        families = [family for family in self.families if family.word.canonical().letters == word]
        stable = [(family, *run) for family in families for run in family.stable_runs]
        pieces = stable or [(family, 0, len(family.x) - 1) for family in families]
        parts = [(family, first, family.sweep_value[first : last + 1]) for family, first, last in pieces]
        if not parts:
            return None
        family, first, values = max(parts, key=lambda part: float(np.ptp(part[2])))
        row = first + int(np.argmin(np.abs(values - (values.min() + values.max()) / 2)))
        return float(family.sweep_value[row]), family.curve.motion(family.x[row])

    def doubled(self, periods: int) -> list[Family]:
        """The families of a cascade of period doublings from the 1:1 motions in some forcing periods, in its order."""
        cascade = [family for family in self.families if family.word == Word((1, -1), periods)]
        count = len(cascade)
        for parent in cascade:  # the list grows on the way by the families that come of its members
            for vertex in self.vertices:
                if vertex.event is Event.PERIOD_DOUBLING and parent.number in vertex.families:
                    families = (self.families[number - 1] for number in vertex.families)
                    twice = (family for family in families if len(family.word) == 2 * len(parent.word))
                    cascade += [family for family in twice if family not in cascade]
        return cascade[count:]

    def stable_at(self, value: float) -> list[tuple[Family, Motion]]:
        """Every stable motion at a value of the swept parameter, with its family."""

        def attracts(family: Family, motion: Motion) -> bool:
            return family.stability(family.curve.trace(family.curve.vector(motion)), motion.coordinate).attracts

        return [pair for pair in self.at(value) if attracts(*pair)]
