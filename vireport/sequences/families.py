"""Families of motions and the points where they meet: the edges and the vertices of an atlas."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from itertools import pairwise
from math import pi

import numpy as np
from numpy.typing import NDArray

from vireport.analysis import STABILITIES, Stability, Sweep, classify
from vireport.sequences.continuation import Curve, Event
from vireport.sequences.motions import Motion, Sequence
from vireport.sequences.polish import PolishedPoint
from vireport.sequences.switching import Limits

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Vertex:
    """Where families begin, end or meet.

    Attributes
    ----------
    label : str
        Letter of its kind and number, numbered along the sweep.
    event : Event
        `GRAZING` where an impact of one of the families has velocity zero.
    point : PolishedPoint
        The motion there, with the touches of a membrane as impacts of velocity zero.
    families : tuple of int
        Numbers of the families, in ascending order.
    """

    label: str
    event: Event
    point: PolishedPoint
    families: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Mark:
    """What happens at a row of a family; the vertex where it is one, and the motion there where it is singled out."""

    row: int
    event: Event
    vertex: Vertex | None
    point: PolishedPoint | None


@dataclass(frozen=True, eq=False)
class Family:
    """Connected motions of one sequence of impacts, ordered along their curve.

    Attributes
    ----------
    number : int
        From 1.
    sweep : Sweep
    curve : Curve
    x : ndarray (n, 2N + 1)
        Velocities, times and coordinate of each motion.
    trace : ndarray (n,)
        Of the product of the flights' Jacobians; nan where a velocity is zero.
    sweep_value : ndarray (n,)
        The swept parameter, in its unit.
    marks : tuple of Mark
        In order.
    """

    number: int
    sweep: Sweep
    curve: Curve
    x: Floats
    trace: Floats
    sweep_value: Floats
    marks: tuple[Mark, ...]

    @property
    def sequence(self) -> Sequence:
        """The impacts of one period."""
        return self.curve.sequence

    @property
    def ends(self) -> tuple[Mark, Mark]:
        """What it begins and ends with; twice the same on a closed curve."""
        first, last = self.marks[0], self.marks[-1]
        return last if first.row else first, last

    @property
    def velocity(self) -> Floats:
        """Before each impact of each motion, (n, N) [y_c]."""
        return self.x[:, : len(self.sequence)]

    @property
    def phase(self) -> Floats:
        """At each impact of each motion, (n, N) [rad], in [0, 2 pi)."""
        return np.mod(pi * self.x[:, len(self.sequence) : -1], 2 * pi)

    @property
    def d(self) -> Floats:
        """Distance between the membranes, of each motion."""
        return np.broadcast_to(self.curve.model.groups(self.x[:, -1])[0], len(self.x))

    @cached_property
    def segments(self) -> tuple[tuple[int, int, Stability], ...]:
        """First and last row of each stretch between events, with the type of its motions."""
        rows = sorted({0, len(self.x) - 1, *(mark.row for mark in self.marks)})
        return tuple((first, last, self._type(first, last)) for first, last in pairwise(rows))

    def _type(self, first: int, last: int) -> Stability:
        """Type of the motions between two rows: that of one in the middle, solved for where no row is."""
        inner = (first + last) // 2
        trace = float(self.trace[inner])
        if inner == first:
            ends = self.x[[first, last]]
            x = self.curve.at(ends.mean(axis=0), float(ends[:, -1].mean()))
            trace = float(self.trace[[first, last]].mean()) if x is None else self.curve.trace(x)
        return STABILITIES[int(classify(trace, self.curve.model.r ** (len(self.sequence) / 2)))]

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether each motion lies on a stable stretch."""
        stable = np.zeros(len(self.x), dtype=bool)
        for first, last, kind in self.segments:
            stable[first : last + 1] |= kind.attracts
        return stable

    @property
    def stable_runs(self) -> list[tuple[int, int]]:
        """First and last rows of the stretches over which it is stable without a break."""
        runs: list[tuple[int, int]] = []
        for first, last, kind in self.segments:
            if kind.attracts and runs and runs[-1][1] == first:
                runs[-1] = runs[-1][0], last
            elif kind.attracts:
                runs.append((first, last))
        return runs

    @property
    def stable_ranges(self) -> list[tuple[float, float]]:
        """Least and largest value of the swept parameter on each of these."""
        parts = (self.sweep_value[first : last + 1] for first, last in self.stable_runs)
        return [(float(part.min()), float(part.max())) for part in parts]

    @property
    def determinant(self) -> float:
        """Of the product of the flights' Jacobians, r^(2N)."""
        return float(self.curve.model.r ** (2 * len(self.sequence)))

    def at(self, coordinate: float) -> list[Motion]:
        """Its motions at a value of the coordinate that orders the sweep."""
        c = self.x[:, -1]
        found = []
        for i in np.flatnonzero((c[:-1] - coordinate) * (c[1:] - coordinate) <= 0):
            step = c[i + 1] - c[i]
            share = (coordinate - c[i]) / step if step else 0.5
            x = self.curve.at(self.x[i] + share * (self.x[i + 1] - self.x[i]), coordinate)
            if x is not None:
                found.append(self.curve.motion(x))
        return found


class Claim(StrEnum):
    """What is claimed of the families of a word."""

    COMPLETE = "complete"
    """All are found, but for those closer to a found one than the resolution, and in flight times not decided."""
    SEARCHED = "searched"
    """All are looked for; those that are smaller than the resolution can be missed."""
    FOLLOWED = "followed"
    """Those are found that join others, or that a simulation found."""


@dataclass(frozen=True, slots=True)
class Completeness:
    """How completely the families of a word are found.

    Attributes
    ----------
    word : str
    claim : Claim
    resolution : float or None
        Distance in flight times, as a share of a forcing period.
    undecided : float or None
        Share of all flight times that is not decided, the largest over the numbers of forcing periods.
    """

    word: str
    claim: Claim
    resolution: float | None = None
    undecided: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Atlas:
    """The families of motions along a sweep, and where they meet.

    Attributes
    ----------
    sweep : Sweep
    limits : Limits
    families : tuple of Family
        By number of impacts, word, periods and range.
    vertices : tuple of Vertex
        Along the sweep.
    completeness : tuple of Completeness
        Of each word that is looked for; all others are `Claim.FOLLOWED`.
    """

    sweep: Sweep
    limits: Limits
    families: tuple[Family, ...]
    vertices: tuple[Vertex, ...]
    completeness: tuple[Completeness, ...]

    def at(self, value: float) -> list[tuple[Family, Motion]]:
        """Every motion at a value of the swept parameter, with its family."""
        coordinate = float(self.sweep.coordinate_of(value))
        return [(family, motion) for family in self.families for motion in family.at(coordinate)]
