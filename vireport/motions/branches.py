"""Branches of motions along a sweep, and the critical points on them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from vireport.motions.conditions import Condition
from vireport.motions.events import Event
from vireport.motions.motion import Symmetry
from vireport.motions.one_to_one import Motions
from vireport.motions.points import Point
from vireport.motions.stability import STABILITIES, Stability
from vireport.physics import Voltages


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """Rows `first` to `last` (inclusive) of a branch, between which nothing changes."""

    first: int
    last: int
    stability: Stability
    admissible: bool

    @property
    def stable(self) -> bool:
        """Whether this stretch attracts motions nearby and is a motion at all."""
        return self.admissible and self.stability.attracts


RowMark = Point | Event | None
"""What a row of a branch is: a critical point, only its event where no motion nearby is admissible, or nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """Motions of one family, connected and ordered along their curve.

    Attributes
    ----------
    number : int
        From 1, in the order of the results.
    symmetry : Symmetry
    mirror_of : int or None
        Number of the branch whose mirror image this is.
    motions : Motions
        On a critical point itself, the type of stability is the less stable side's.
    marks : tuple of RowMark
        For each motion the critical point it is.
    ends : tuple of Condition
        What the branch begins and ends with.
    voltages : Voltages or None
        None where no energy is evaluated.
    """

    number: int
    symmetry: Symmetry
    mirror_of: int | None
    motions: Motions
    marks: tuple[RowMark, ...]
    ends: tuple[Condition, Condition]
    voltages: Voltages | None = None

    def critical_point(self, row: int) -> Point | None:
        """The critical point that a row is."""
        mark = self.marks[row]
        return mark if isinstance(mark, Point) else None

    @property
    def labels(self) -> list[str]:
        """For each motion the label of the critical point it is, its kind in brackets, or ""."""
        return [mark.label if isinstance(mark, Point) else f"({mark})" if mark else "" for mark in self.marks]

    def segments(self) -> list[Segment]:
        """Stretches between critical points, each of one stability and either admissible or not."""
        places = [i for i, mark in enumerate(self.marks) if mark or i in (0, len(self.marks) - 1)]
        segments = []
        for first, last in pairwise(places):
            inner = (first + last + 1) // 2
            if last - first == 1 and self.marks[last] and not self.marks[first]:
                inner = first
            stability = STABILITIES[self.motions.stability[inner]]
            segments.append(Segment(first, last, stability, bool(self.motions.admissible[inner])))
        return segments

    def stable_runs(self) -> list[tuple[int, int]]:
        """First and last rows of the stretches over which it is stable without a break."""
        runs: list[tuple[int, int]] = []
        for part in self.segments():
            if part.stable and runs and runs[-1][1] == part.first:
                runs[-1] = (runs[-1][0], part.last)
            elif part.stable:
                runs.append((part.first, part.last))
        return runs
