"""The bifurcation diagram of a sweep: its branches of motions, and the critical points that divide them, numbered."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vireport.analysis.branches import Branch, CriticalPoint, Draft, Event, Mark, draft, phase_at_top
from vireport.analysis.kinds import BranchEnd, CriticalKind, Family
from vireport.analysis.pieces import pieces
from vireport.analysis.sweep import Sweep
from vireport.analysis.tracing import Curve, curve_of, sample

Floats = NDArray[np.float64]

SAME_POINT = 1e-9
"""Relative difference of the swept value below which two critical points of one kind are mirror images."""


@dataclass(frozen=True, slots=True, eq=False)
class BifurcationDiagram:
    """Every 1:1 motion along a sweep.

    Attributes
    ----------
    curve : Curve
        Of the motions on their surface.
    branches : tuple of Branch
    critical_points : tuple of CriticalPoint
        Ordered by their labels' numbers: along d, along the sweep where d is constant.
    """

    curve: Curve
    branches: tuple[Branch, ...]
    critical_points: tuple[CriticalPoint, ...]

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
    samples = sample(curve)
    branches, critical_points = _label(curve, [draft(curve, piece) for piece in pieces(curve, samples)])
    return BifurcationDiagram(curve, branches, critical_points)


def _label(curve: Curve, drafts: list[Draft]) -> tuple[tuple[Branch, ...], tuple[CriticalPoint, ...]]:
    """Number branches and critical points, and join mirror images."""
    drafts.sort(
        key=lambda one: (one.branch.family is Family.ASYMMETRIC, float(one.branch.motions.q.min()) < 0.5 - 1e-9)
    )
    mirrored = _mirrors(curve, drafts)
    found: list[CriticalPoint] = []
    owner: dict[tuple[int, int], int] = {}
    for i, one in enumerate(drafts):
        for event in one.events:
            if not _near_admissible(one.branch, event.row):
                continue
            twin = next((k for k, other in enumerate(found) if _is_twin(other, event, mirrored[i])), None)
            if twin is None:
                owner[i, event.row] = len(found)
                found.append(_critical(curve, one.branch.family, event, i))
            else:
                owner[i, event.row] = twin
                found[twin] = replace(found[twin], mirror=event.point)
    labels, order = _labels(curve, found)
    points = {k: replace(found[k], label=labels[k]) for k in order}
    branches = []
    for i, one in enumerate(drafts):
        marks: list[Mark] = [None] * len(one.branch.motions)
        for event in one.events:
            marks[event.row] = points[owner[i, event.row]] if (i, event.row) in owner else event.kind
        for row in (0, -1):
            if one.branch.ends[row] is BranchEnd.PITCHFORK:
                marks[row] = next((point for point in points.values() if _meets(point, one.branch, row)), None)
        mirror = mirrored[i]
        branches.append(
            replace(one.branch, number=i + 1, mirror_of=None if mirror is None else mirror + 1, marks=tuple(marks))
        )
    return tuple(branches), tuple(points.values())


def _critical(curve: Curve, family: Family, event: Event, branch: int) -> CriticalPoint:
    top = phase_at_top(event.point, curve)
    return CriticalPoint("", event.kind, family, event.point, top, None, branch + 1, event.change)


def _labels(curve: Curve, found: list[CriticalPoint]) -> tuple[dict[int, str], list[int]]:
    """Letters and numbers along d (along the sweep where d is constant), and the order they are numbered in."""
    constant = curve.level.kind == "d"
    order = sorted(range(len(found)), key=lambda k: (0.0 if constant else found[k].point.d, found[k].point.sweep_value))
    counts: dict[str, int] = {}
    labels = {}
    for k in order:
        letter = found[k].kind.letter
        counts[letter] = counts.get(letter, 0) + 1
        labels[k] = f"{letter}{counts[letter]}"
    return labels, order


def _is_twin(other: CriticalPoint, event: Event, mirrored: int | None) -> bool:
    """Whether an event is the mirror image of a critical point that was found on the branch `mirrored`."""
    if mirrored is None or other.branch != mirrored + 1 or other.kind != event.kind or other.mirror is not None:
        return False
    value = event.point.sweep_value
    return abs(other.point.sweep_value - value) <= SAME_POINT * abs(value)


def _meets(point: CriticalPoint, branch: Branch, row: int) -> bool:
    """Whether a critical point is the pitchfork at which an asymmetric branch begins."""
    return (
        point.kind is CriticalKind.PITCHFORK
        and abs(point.point.d - float(branch.motions.d[row])) <= SAME_POINT * point.point.d
    )


def _mirrors(curve: Curve, drafts: list[Draft]) -> list[int | None]:
    """For each branch of a horizontal capsule, the earlier one whose mirror image it is."""
    result: list[int | None] = [None] * len(drafts)
    for i, one in enumerate(drafts):
        if curve.horizontal and one.branch.family is Family.ASYMMETRIC:
            earlier = (k for k in range(i) if result[k] is None and _reflected(one.branch, drafts[k].branch))
            result[i] = next(earlier, None)
    return result


def _reflected(one: Branch, two: Branch) -> bool:
    """Whether the ends of two branches are mirror images: q and 1 - q, with the impact velocities exchanged."""

    def ends(branch: Branch, sign: float) -> Floats:
        m = branch.motions
        speed = m.velocity_bottom if sign > 0 else -m.velocity_top
        rows = np.stack([m.d, sign * (m.q - 0.5), speed], axis=1)[[0, -1]]
        return np.asarray(rows[np.argsort(rows[:, 1])])

    return one.family == two.family and bool(np.allclose(ends(one, 1.0), ends(two, -1.0), rtol=0, atol=1e-6))


def _near_admissible(branch: Branch, row: int) -> bool:
    """Whether a motion or a neighbour is admissible; inside an inadmissible stretch nothing is a critical point."""
    return bool(branch.motions.admissible[max(row - 1, 0) : row + 2].any())
