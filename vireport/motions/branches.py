"""Branches of 1:1 motions of a sweep: families in closed form, admissible or not.

A piece of the level curve becomes a branch: its motions are evaluated as rows, and the numbers of those that were
solved for in decimals are put into their rows. The mirror image of a branch is its reflection.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import pi

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.motions.events import Event
from vireport.motions.families import Family, Mark
from vireport.motions.level_curve import COLUMNS, LevelCurve
from vireport.motions.one_to_one import Motions, motions_of
from vireport.motions.paths import Curve
from vireport.motions.periodicity import model_of
from vireport.motions.points import OneToOne, SolvedPiece
from vireport.motions.stability import NODE, UNSTABLE
from vireport.motions.sweep import Sweep
from vireport.physics.energy import Voltages
from vireport.physics.groups import by_wall
from vireport.physics.motion import Symmetry
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word

BEGINS_AT_SYMMETRY = 1e-12
"""|u| at the end of a piece below which it begins at the symmetric motion; the end is exact but for rounding."""

ENDS = Event.GRAZING, Event.ZERO_VELOCITY, Event.STOP
"""Events beyond which the closed form has solutions but no motions."""


class Branch(Struct, frozen=True, eq=False):
    """A family of 1:1 motions with their numbers in closed form.

    Attributes
    ----------
    family : Family
        Its number is from 1, in the order of the results.
    symmetry : Symmetry
    mirror_of : int or None
        Number of the branch whose mirror image this is.
    motions : Motions
        The motions as rows. A critical point has the stability of its less stable side; where an impact has no
        velocity, the trace is of the motion just before.
    voltages_by_motion : Voltages or None
        None where no energy is evaluated.
    """

    family: Family
    symmetry: Symmetry
    mirror_of: int | None
    motions: Motions
    voltages_by_motion: Voltages | None = None

    def __repr__(self) -> str:
        return f"<Branch {self.number}, {self.symmetry}, {self.family.text}>"

    @property
    def number(self) -> int:
        """Number of the branch, from 1."""
        return self.family.number


def branches_of(curve: LevelCurve, solved: SolvedPiece) -> tuple[Branch, Branch | None]:
    """The branch of a piece of a level curve and, if its motions have mirror images, their branch; without numbers."""
    piece, orbit = solved.piece, solved.orbit
    u, phi = np.array(orbit.u), np.array(orbit.phi)
    for row, end in solved.ends.items():
        if end.place is not None:
            u[row], phi[row] = end.place
    for row, point in solved.points.items():
        if point.rest is None:
            u[row], phi[row] = point.closed.u, point.closed.phi_bottom
    # An asymmetric branch of a horizontal capsule begins at a symmetric motion, whose u is zero exactly.
    at_symmetry = [row for row in (0, -1) if piece.mirrored and abs(orbit.u[row]) < BEGINS_AT_SYMMETRY]
    u[at_symmetry] = 0.0
    motions = motions_of(curve.sweep, curve.plane.orbits(u, phi))
    _pin(motions, curve, solved)
    motions.stability[at_symmetry] = UNSTABLE
    marks = tuple(_marks(solved, at_symmetry))
    symmetry = Symmetry.SYMMETRIC if piece.symmetric else Symmetry.ASYMMETRIC
    branch = Branch(family_of(curve.sweep, motions, marks), symmetry, None, motions)
    if not piece.mirrored:
        return branch, None
    # The image is reflected, not solved for again; only numbers that were rounded from decimals are put in anew, as a
    # reflection in doubles would round them a second time.
    image = motions.mirrored()
    for row, end in solved.ends.items():
        if end.image_phase is not None:
            image.phi_bottom[row] = end.image_phase
    for row, point in solved.points.items():
        if point.mirror is not None:
            _pin_place(image, row, point.mirror.closed)
    return branch, Branch(family_of(curve.sweep, image, marks), symmetry, None, image)


def _pin(motions: Motions, curve: LevelCurve, solved: SolvedPiece) -> None:
    """Put the numbers of motions that were solved for in decimals into their rows, in place.

    Where an impact has no velocity, the trace stays the one at `INSET` before it.
    """
    sweep = curve.sweep
    for row, end in solved.ends.items():
        motions.sweep_value[row] = end.value
        motions.d[row], motions.gbar[row], *_ = sweep.device.groups(sweep.parameter, end.value)
        _pin_restitution(motions, curve, row, end.value)
    # What happens at a row decides what it states: on a critical point itself the less stable side counts, and a motion
    # that touches a membrane, or stops, is none.
    for row, point in solved.points.items():
        motions.sweep_value[row], motions.d[row], motions.gbar[row] = point.sweep_value, point.d, point.gbar
        _pin_restitution(motions, curve, row, point.sweep_value)
        _pin_place(motions, row, point.closed)
        if point.event is Event.STOP:
            motions.wall_gap[row], motions.admissible_mask[row] = 0.0, False
        elif point.event is not Event.GRAZING:
            motions.stability[row] = NODE if point.event is Event.NODE_FOCUS else UNSTABLE
        elif point.rest is None:
            motions.wall_gap[row], motions.admissible_mask[row] = 0.0, False
    np.minimum(motions.wall_gap, motions.d, out=motions.wall_gap)


def _pin_restitution(motions: Motions, curve: LevelCurve, row: int, value: float) -> None:
    """Put the restitution at a value of the swept parameter into a row, in place, in a sweep over a restitution."""
    if curve.level.varied is not None:
        exact = curve.level.restitution(curve.plane.r, value)
        for column, constant in zip(by_wall(motions.restitution), by_wall(exact), strict=True):
            column[row] = constant


def _pin_place(motions: Motions, row: int, closed: OneToOne) -> None:
    """Put place and velocities of a motion in closed form into a row, in place."""
    motions.q[row], motions.u[row], motions.phi_bottom[row] = 0.5 + closed.u, closed.u, closed.phi_bottom
    motions.velocity_bottom[row], motions.velocity_top[row] = closed.velocity_bottom, closed.velocity_top
    motions.phi_top[row] = closed.phi_top


def _marks(solved: SolvedPiece, at_symmetry: list[int]) -> Iterator[Mark]:
    """The events on a piece of the curve, in order; the ends `at_symmetry`, 0 or -1, are at the symmetric motion."""
    last = len(solved.piece.w) - 1
    beginnings = [row % (last + 1) for row in at_symmetry]
    for row, k in enumerate(solved.piece.event):
        event, point = COLUMNS[k].event if k >= 0 else None, solved.points.get(row)
        if event is None and row in (0, last):
            event = Event.PITCHFORK if row in beginnings else Event.CLOSED
        if event is not None:
            yield Mark(row, event if point is None or event is Event.ZERO_VELOCITY else point.event, point)


def family_of(sweep: Sweep, motions: Motions, marks: Iterable[Mark]) -> Family:
    """The family of 1:1 motions that are connected and in order, with the number 0."""
    n = sweep.device.period_ratio
    # Phases of rows jump by a turn; the times of a family are continuous.
    start = np.unwrap(motions.phi_bottom) / pi
    velocity = np.stack([motions.velocity_bottom, motions.velocity_top], axis=1)
    x = np.column_stack([velocity, start, start + 2 * n * (0.5 + motions.u), sweep.coordinate(motions)])
    trace = np.where((velocity == 0).any(axis=1), np.nan, motions.trace)
    return Family(
        number=0,
        sweep=sweep,
        curve=Curve.over_sweep(Word((1, -1), n), model_of(sweep, FLOATS), *sweep.coordinate_range),
        x=x,
        trace=trace,
        sweep_value=motions.sweep_value,
        admissible_mask=motions.admissible_mask,
        marks=tuple(marks),
    )


def admissible_families(branch: Branch) -> Iterator[Family]:
    """The admissible stretches of a branch, as families with the number 0."""
    family, last = branch.family, len(branch.motions) - 1
    ends = {mark.row for mark in family.marks if mark.event in ENDS}
    runs: list[list[int]] = []
    # Neighbouring stretches are one family unless something ends motions where they meet.
    for part in family.segments:
        if part.admissible and runs and runs[-1][-1] == part.first and part.first not in ends:
            runs[-1] += range(part.first + 1, part.last + 1)
        elif part.admissible:
            runs.append(list(range(part.first, part.last + 1)))
    closed = family.ends[0].event is Event.CLOSED
    if closed and len(runs) > 1 and runs[0][0] == 0 and runs[-1][-1] == last:
        runs[0] = [*runs.pop()[:-1], *runs[0]]
    for rows in runs:
        whole = closed and len(rows) > last
        row_of = {row: i for i, row in enumerate(rows)}
        kept = (mark for mark in family.marks if mark.row in row_of and (whole or mark.event is not Event.CLOSED))
        marks = sorted((replace(mark, row=row_of[mark.row]) for mark in kept), key=lambda mark: mark.row)
        motions = branch.motions.select(rows)
        yield replace(family_of(family.sweep, motions, marks), admissible_mask=np.ones(len(rows), dtype=bool))
