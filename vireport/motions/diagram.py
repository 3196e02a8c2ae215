"""The bifurcation diagram of a sweep: branches of 1:1 motions, the critical points that divide them, and Table 1.

`solve` finds the diagram of a sweep; it is where everything on 1:1 motions of a sweep begins.
"""

from __future__ import annotations

from msgspec import Struct
from msgspec.structs import replace

from vireport.base.records import brief
from vireport.motions.branches import Branch, branches_of
from vireport.motions.events import Event
from vireport.motions.families import Mark
from vireport.motions.level_curve import LevelCurve, curve_of
from vireport.motions.pieces import pieces_of
from vireport.motions.points import Point, solved_on
from vireport.motions.stability import Stability
from vireport.motions.sweep import Sweep
from vireport.physics.motion import Motion, Symmetry

SAME_POINT = 1e-9
"""Relative difference of the coordinate below which an asymmetric branch begins at a pitchfork."""

SAME_SHARE = 1e-9
"""q - 1/2 down to which a branch counts as one with q > 1/2: it begins at q = 1/2, the symmetric motion."""


class BifurcationDiagram(Struct, frozen=True, eq=False):
    """Every 1:1 motion of a sweep.

    Attributes
    ----------
    curve : LevelCurve
        Level curve of the motions on their surface.
    branches : tuple of Branch
        Mirror images last.
    critical_points : tuple of Point
        In the order of the numbers in their labels: by d, or by the swept parameter where d is constant.
    """

    curve: LevelCurve
    branches: tuple[Branch, ...]
    critical_points: tuple[Point, ...]

    __repr__ = brief

    @property
    def sweep(self) -> Sweep:
        """The sweep of the motions."""
        return self.curve.sweep


def solve(sweep: Sweep) -> BifurcationDiagram:
    """Find every 1:1 motion of a sweep, with its stability, admissibility and critical points.

    Parameters
    ----------
    sweep : Sweep
        With a restitution below 1.
    """
    curve = curve_of(sweep)
    solved = [solved_on(curve, piece) for piece in pieces_of(curve)]
    branches, critical_points = _numbered(curve, [branches_of(curve, piece) for piece in solved])
    return BifurcationDiagram(curve, branches, critical_points)


def _numbered(
    curve: LevelCurve, pairs: list[tuple[Branch, Branch | None]]
) -> tuple[tuple[Branch, ...], tuple[Point, ...]]:
    """Number the branches, mirror images last, and label the critical points.

    Parameters
    ----------
    curve : LevelCurve
    pairs : list of (Branch, Branch or None)
        Branches, with their mirror images.
    """
    pairs = sorted(pairs, key=lambda pair: _order(pair[0]))
    critical = [
        replace(mark.point, families=(number,))
        for number, (branch, _) in enumerate(pairs, 1)
        for mark in branch.family.marks
        if mark.point is not None and _near_admissible(branch, mark.row)
    ]
    # Labels follow d, so that they stay the same whichever way the sweep goes.
    labels, order = _labels(curve, critical)
    points = [replace(critical[k], label=labels[k]) for k in order]
    # By the motion, which is the same object in a point before and after it is labelled.
    critical_points = {point.motion: point for point in points}
    images = [(image, number) for number, (_, image) in enumerate(pairs, 1) if image is not None]
    branches = []
    for number, (branch, mirror_of) in enumerate([*((branch, None) for branch, _ in pairs), *images], 1):
        marks = tuple(_labelled(mark, branch, critical_points) for mark in branch.family.marks)
        family = replace(branch.family, number=number, marks=marks)
        branches.append(replace(branch, family=family, mirror_of=mirror_of))
    return tuple(branches), tuple(points)


def _labelled(mark: Mark, branch: Branch, critical_points: dict[Motion, Point]) -> Mark:
    """A mark of a branch with its labelled critical point in place of the one without a label."""
    if mark.point is not None:
        return replace(mark, point=critical_points.get(mark.point.motion, mark.point))
    # An asymmetric branch begins at a pitchfork of the symmetric one, whose point is the only one that was solved for.
    if mark.event is Event.PITCHFORK:
        return replace(
            mark, point=next((point for point in critical_points.values() if _meets(point, branch, mark.row)), None)
        )
    return mark


def _order(branch: Branch) -> tuple[bool, bool]:
    """Key by which branches are ordered: symmetric ones first, then those with q > 1/2."""
    return branch.symmetry is Symmetry.ASYMMETRIC, float(branch.motions.q.min()) < 0.5 - SAME_SHARE


def _labels(curve: LevelCurve, critical: list[Point]) -> tuple[dict[int, str], list[int]]:
    """The labels of critical points by their place in the list, and the places in the order of the numbers.

    A label is the letter of the event and a number that ascends with d, or with the swept parameter where d is
    constant.
    """
    constant = curve.level.holds_d
    order = sorted(range(len(critical)), key=lambda k: (0.0 if constant else critical[k].d, critical[k].sweep_value))
    counts: dict[str, int] = {}
    labels = {}
    for k in order:
        letter = critical[k].event.letter
        counts[letter] = counts.get(letter, 0) + 1
        labels[k] = f"{letter}{counts[letter]}"
    return labels, order


def _meets(point: Point, branch: Branch, row: int) -> bool:
    """Whether a critical point is the pitchfork at which a row of an asymmetric branch is."""
    coordinate = point.motion.coordinate
    apart = abs(coordinate - float(branch.family.x[row, -1]))
    return point.event is Event.PITCHFORK and apart <= SAME_POINT * coordinate


def _near_admissible(branch: Branch, row: int) -> bool:
    """Whether the motion of a row or a neighbour is admissible: other events are of solutions that are no motions."""
    return bool(branch.motions.admissible_mask[max(row - 1, 0) : row + 2].any())


class TableRow(Struct, frozen=True, eq=False):
    """A row of Table 1: an interval of a branch with one type of motion.

    Attributes
    ----------
    symmetry : Symmetry
    branch : int
        Number of the branch; its mirror image has no row.
    start_point, end_point : Point or None
        Critical points at the ends of the interval; None where the sweep or the branch ends.
    stability : Stability
    d_start, d_end : float
        The interval in d, ascending (where d is constant, in the order of the swept parameter).
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
    """Rows of Table 1 for the admissible motions of a branch, ascending in d, or in the swept parameter."""
    motions, points = branch.motions, branch.family.critical_points
    key = motions.sweep_value if constant_d else motions.d
    rows = []
    for part in branch.family.segments:
        if not part.admissible:
            continue
        # A branch may be followed against the sweep: Table 1 states its intervals ascending.
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
