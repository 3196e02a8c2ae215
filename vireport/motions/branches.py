"""1:1 motions along a sweep: families whose motions are known in closed form, admissible or not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import pi

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.motions.events import Event
from vireport.motions.families import Family, Mark
from vireport.motions.one_to_one import Motions
from vireport.motions.paths import Curve
from vireport.motions.points import model_of
from vireport.motions.sweep import Sweep
from vireport.physics.energy import Voltages
from vireport.physics.motion import Symmetry
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word

ENDS = Event.GRAZING, Event.ZERO_VELOCITY, Event.STOP
"""What motions do not go on beyond, though the closed form does."""


class Branch(Struct, frozen=True, eq=False):
    """A family of 1:1 motions, with what the closed form says of each of them.

    Attributes
    ----------
    family : Family
        Its number is from 1, in the order of the results.
    symmetry : Symmetry
    mirror_of : int or None
        Number of the branch whose mirror image this is.
    motions : Motions
        Its rows. On a critical point itself, the type of stability is the less stable side's; where an impact has no
        velocity, the trace is that just before.
    voltages_by_motion : Voltages or None
        None where no energy is evaluated.
    """

    family: Family
    symmetry: Symmetry
    mirror_of: int | None
    motions: Motions
    voltages_by_motion: Voltages | None = None

    def __repr__(self) -> str:
        return f"<Branch {self.number}, {self.symmetry}, {self.family.shown}>"

    @property
    def number(self) -> int:
        """Number of the branch, which its family has."""
        return self.family.number


def family_of(sweep: Sweep, motions: Motions, marks: Iterable[Mark]) -> Family:
    """The family that rows of 1:1 motions make, which are connected and in order; its number is 0."""
    n = sweep.device.period_ratio
    start = np.unwrap(motions.phi_bottom) / pi
    velocity = np.stack([motions.velocity_bottom, motions.velocity_top], axis=1)
    x = np.column_stack([velocity, start, start + 2 * n * (0.5 + motions.u), sweep.coordinate(motions)])
    trace = np.where((velocity == 0).any(axis=1), np.nan, motions.trace)
    low, high = sweep.coordinate_range
    curve = Curve.along_sweep(Word((1, -1), n), model_of(sweep, FLOATS), low, high)
    return Family(0, sweep, curve, x, trace, motions.sweep_value, motions.admissible_mask, tuple(marks))


def admissible_families(branch: Branch) -> Iterator[Family]:
    """The stretches of a branch that are motions, as families of their own, not numbered."""
    family, last = branch.family, len(branch.motions) - 1
    ends = {mark.row for mark in family.marks if mark.event in ENDS}
    runs: list[list[int]] = []
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
