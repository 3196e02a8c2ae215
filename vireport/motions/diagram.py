"""The bifurcation diagram of a sweep: its branches of motions, the critical points that divide them, and Table 1."""

from __future__ import annotations

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base import brief
from vireport.motions.branches import Branch
from vireport.motions.events import Event
from vireport.motions.families import Mark
from vireport.motions.level_curve import LevelCurve, curve_of, sample
from vireport.motions.motion import Symmetry
from vireport.motions.points import Point
from vireport.motions.stability import Stability
from vireport.motions.sweep import Sweep
from vireport.motions.tracing import branches_of

Floats = NDArray[np.float64]

SAME_POINT = 1e-9
"""Relative difference of the swept value below which two critical points of one kind are mirror images."""

SAME_SHARE = 1e-9
"""Difference from q = 1/2 below which a branch begins at the symmetric motion."""

SAME_ENDS = 1e-6
"""Difference of the coordinate, q and impact velocity up to which two branches are mirror images: both end within
rounding."""


class BifurcationDiagram(Struct, frozen=True, eq=False):
    """Every 1:1 motion along a sweep.

    Attributes
    ----------
    curve : LevelCurve
        Of the motions on their surface.
    branches : tuple of Branch
    critical_points : tuple of Point
        Ordered by their labels' numbers: along d, along the sweep where d is constant.
    """

    curve: LevelCurve
    branches: tuple[Branch, ...]
    critical_points: tuple[Point, ...]

    __repr__ = brief

    @property
    def sweep(self) -> Sweep:
        """What is varied."""
        return self.curve.sweep


def solve(sweep: Sweep) -> BifurcationDiagram:
    """Find every 1:1 motion of a sweep, with its stability, admissibility and critical points.

    Parameters
    ----------
    sweep : Sweep
        With a restitution below 1.
    """
    curve = curve_of(sweep)
    branches, critical_points = _numbered(curve, branches_of(curve, sample(curve)))
    return BifurcationDiagram(curve, branches, critical_points)


def _numbered(curve: LevelCurve, unordered: list[Branch]) -> tuple[tuple[Branch, ...], tuple[Point, ...]]:
    """Number branches and critical points, and join mirror images."""
    ordered = sorted(unordered, key=_order)
    mirrored = _mirrors(curve, ordered)
    critical: list[Point] = []
    owner: dict[Point, int] = {}
    for i, branch in enumerate(ordered):
        for mark in branch.family.marks:
            point = mark.point
            if point is None or not _near_admissible(branch, mark.row):
                continue
            twin = next((k for k, other in enumerate(critical) if _is_twin(other, point, mirrored[i])), None)
            if twin is None:
                owner[point] = len(critical)
                critical.append(replace(point, families=(i + 1,)))
            else:
                owner[point] = twin
                critical[twin] = replace(critical[twin], mirror=point)
    labels, order = _labels(curve, critical)
    points = {k: replace(critical[k], label=labels[k]) for k in order}
    known = {point: points[k] for point, k in owner.items()}
    branches = []
    for i, (branch, mirror) in enumerate(zip(ordered, mirrored, strict=True)):
        marks = tuple(_labelled(mark, branch, known) for mark in branch.family.marks)
        family = replace(branch.family, number=i + 1, marks=marks)
        branches.append(replace(branch, family=family, mirror_of=None if mirror is None else mirror + 1))
    return tuple(branches), tuple(points.values())


def _labelled(mark: Mark, branch: Branch, known: dict[Point, Point]) -> Mark:
    """A mark with the critical point that its point is; an asymmetric branch begins at one of the symmetric one."""
    if mark.point is not None:
        return replace(mark, point=known.get(mark.point, mark.point))
    if mark.event is Event.PITCHFORK:
        return replace(mark, point=next((point for point in known.values() if _meets(point, branch, mark.row)), None))
    return mark


def _order(branch: Branch) -> tuple[bool, bool]:
    """Symmetric branches first, and of two mirror images the one with the larger q."""
    return branch.symmetry is Symmetry.ASYMMETRIC, float(branch.motions.q.min()) < 0.5 - SAME_SHARE


def _labels(curve: LevelCurve, critical: list[Point]) -> tuple[dict[int, str], list[int]]:
    """Letters and numbers along d (along the sweep where d is constant), and the order they are numbered in."""
    constant = curve.level.holds_d
    order = sorted(range(len(critical)), key=lambda k: (0.0 if constant else critical[k].d, critical[k].sweep_value))
    counts: dict[str, int] = {}
    labels = {}
    for k in order:
        letter = critical[k].event.letter
        counts[letter] = counts.get(letter, 0) + 1
        labels[k] = f"{letter}{counts[letter]}"
    return labels, order


def _is_twin(other: Point, point: Point, mirrored: int | None) -> bool:
    """Whether a critical point is the mirror image of another that was found on the branch `mirrored`."""
    if mirrored is None or other.families != (mirrored + 1,) or other.event != point.event or other.mirror is not None:
        return False
    value = point.sweep_value
    return abs(other.sweep_value - value) <= SAME_POINT * abs(value)


def _meets(point: Point, branch: Branch, row: int) -> bool:
    """Whether a critical point is the pitchfork at which an asymmetric branch begins."""
    coordinate = point.motion.coordinate
    apart = abs(coordinate - float(branch.family.x[row, -1]))
    return point.event is Event.PITCHFORK and apart <= SAME_POINT * coordinate


def _mirrors(curve: LevelCurve, ordered: list[Branch]) -> list[int | None]:
    """For each branch of a horizontal capsule, the earlier one whose mirror image it is."""
    mirrors: list[int | None] = [None] * len(ordered)
    for i, branch in enumerate(ordered):
        if curve.horizontal and branch.symmetry is Symmetry.ASYMMETRIC:
            earlier = (k for k in range(i) if mirrors[k] is None and _reflected(branch, ordered[k]))
            mirrors[i] = next(earlier, None)
    return mirrors


def _reflected(first: Branch, second: Branch) -> bool:
    """Whether the ends of two branches are mirror images: q and 1 - q, with the impact velocities exchanged."""

    def ends(branch: Branch, sign: float) -> Floats:
        m = branch.motions
        speed = m.velocity_bottom if sign > 0 else -m.velocity_top
        rows = np.stack([branch.family.x[:, -1], sign * (m.q - 0.5), speed], axis=1)[[0, -1]]
        return np.asarray(rows[np.argsort(rows[:, 1])])

    return first.symmetry == second.symmetry and bool(
        np.allclose(ends(first, 1.0), ends(second, -1.0), rtol=0, atol=SAME_ENDS)
    )


def _near_admissible(branch: Branch, row: int) -> bool:
    """Whether a motion or a neighbour is admissible; inside an inadmissible stretch nothing is a critical point."""
    return bool(branch.motions.admissible_mask[max(row - 1, 0) : row + 2].any())


class TableRow(Struct, frozen=True, eq=False):
    """One row of Table 1.

    Attributes
    ----------
    symmetry : Symmetry
    branch : int
        Number of the branch; mirror images share the row of the first.
    start_point, end_point : Point or None
        At the ends of the interval; None where it is the sweep or the branch that ends.
    stability : Stability
    d_start, d_end : float
        The interval in d, ascending (at constant d, ordered along the sweep).
    sweep_start, sweep_end : float
        The swept parameter at the same two ends.
    first_row, last_row : int
        Rows of the branch at these ends.
    """

    symmetry: Symmetry
    branch: int
    start_point: Point | None
    end_point: Point | None
    stability: Stability
    d_start: float
    d_end: float
    sweep_start: float
    sweep_end: float
    first_row: int
    last_row: int

    __repr__ = brief

    @property
    def criteria(self) -> str:
        """Table 1's criteria for the type."""
        return self.stability.criteria


def table(diagram: BifurcationDiagram) -> tuple[TableRow, ...]:
    """Rows of Table 1 for the admissible motions of a sweep, by family and branch, ascending in d.

    Source: Table 1; the paper's reference to Figure 1 in it means Figure 2.
    """
    constant_d = diagram.curve.level.holds_d
    originals = (branch for branch in diagram.branches if branch.mirror_of is None)
    return tuple(row for branch in originals for row in _table_rows(branch, constant_d))


def _table_rows(branch: Branch, constant_d: bool) -> list[TableRow]:
    motions, points = branch.motions, branch.family.critical_points
    key = motions.sweep_value if constant_d else motions.d
    rows = []
    for part in branch.family.segments:
        if not part.admissible:
            continue
        first, last = sorted((part.first, part.last), key=lambda row: float(key[row]))
        rows.append(
            TableRow(
                symmetry=branch.symmetry,
                branch=branch.number,
                start_point=points.get(first),
                end_point=points.get(last),
                stability=part.stability,
                d_start=float(motions.d[first]),
                d_end=float(motions.d[last]),
                sweep_start=float(motions.sweep_value[first]),
                sweep_end=float(motions.sweep_value[last]),
                first_row=first,
                last_row=last,
            )
        )
    return sorted(rows, key=lambda row: row.sweep_start if constant_d else row.d_start)
