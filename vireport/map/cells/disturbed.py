"""What the device of each cell does when it is switched on, and what leads out of its stable motion: shocks, kicks."""

from __future__ import annotations

from collections.abc import Iterator
from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np

from vireport.base.errors import NumericalError
from vireport.design.from_rest import Destination
from vireport.design.outcomes_from_rest import outcomes_of
from vireport.map.cells.cells import Floats
from vireport.motions.pointwise import PointwiseMotions
from vireport.physics.groups import Groups

if TYPE_CHECKING:
    from vireport.findings.outcomes.shock import MotionsByStability

DESTINATIONS = tuple(Destination)


def from_rest_columns(groups: Groups[Floats], motions: PointwiseMotions, ratio: int) -> dict[str, object]:
    """What each cell comes to when switched on at once, by compiled code; None where there is no word or period."""
    outcomes = tuple(outcomes_of(groups, motions, ratio, compiled=True))
    return {
        "from_rest": np.array([DESTINATIONS.index(outcome.destination) for outcome in outcomes], dtype=np.int8),
        "from_rest_word": [outcome.word or None for outcome in outcomes],
        "from_rest_periods": [outcome.periods or None for outcome in outcomes],
        "settles_after_periods": [outcome.settles_after for outcome in outcomes],
    }


def shock_columns(
    groups: Groups[Floats], motions: PointwiseMotions, ratio: int, unit: Floats | float
) -> dict[str, Floats]:
    """The least shock that leads out of the stable motions of each cell, and the largest that was tried [m/s].

    Both are NaN without a stable motion, or with one too near a critical point for its returns to be told; the least
    shock alone is NaN where none that was tried leads out.

    Parameters
    ----------
    groups : Groups
        Arrays of one length.
    motions : PointwiseMotions
        Of these cells.
    ratio : int
        Forcing periods of a 1:1 motion.
    unit : array_like
        y_c of the cells [m/s].
    """
    from vireport.findings.outcomes.shock import SCAN
    from vireport.findings.outcomes.withstood import least_of

    jump, searched = np.full(len(groups.d), np.nan), np.full(len(groups.d), np.nan)
    for cell, cell_groups, neighbours in _stable_cells(groups, motions, ratio):
        try:
            least = least_of(cell_groups, neighbours, effort=SCAN)
        except (NumericalError, ValueError):  # too near a critical point, or a ball that does not bounce
            continue
        searched[cell] = least.searched_to
        jump[cell] = np.nan if least.jump is None else least.jump
    return {"least_jump_m_s": jump * unit, "jump_searched_to_m_s": searched * unit}


def escape_columns(
    groups: Groups[Floats], motions: PointwiseMotions, ratio: int, unit: Floats | float
) -> dict[str, Floats]:
    """Q [m2/s2] of the law for small kicks, ln T = a + Q/sigma^2: the least of the stable motions of each cell.

    NaN where there is no stable motion, or one too near a critical point for its returns to be told, and where no kicks
    that lead out are found. Parameters are those of `shock_columns`.
    """
    from vireport.findings.escape.escape import exponent_of

    exponent = np.full(len(groups.d), np.nan)
    for cell, cell_groups, neighbours in _stable_cells(groups, motions, ratio):
        try:
            exponents = [exponent_of(cell_groups, motion, neighbours) for motion in neighbours.stable]
        except (NumericalError, ValueError):  # too near a critical point, or a ball that does not bounce
            continue
        exponent[cell] = min((each for each in exponents if each is not None), default=np.nan)
    return {"escape_q_m2_s2": exponent * unit**2}


def _stable_cells(
    groups: Groups[Floats], motions: PointwiseMotions, ratio: int
) -> Iterator[tuple[int, Groups[float], MotionsByStability]]:
    """The cells with a stable motion: their numbers, groups and motions."""
    from vireport.findings.outcomes.shock import MotionsByStability

    stable, admissible = motions.stable(groups.restitution), motions.admissible
    for cell in np.unique(motions.cell[stable]).tolist():
        in_cell = motions.cell == cell
        attracting, others = (
            [motions.motion(int(row), ratio) for row in np.flatnonzero(in_cell & rows)]
            for rows in (stable, admissible & ~stable)
        )
        yield cell, groups.map_numbers(itemgetter(cell)).as_floats(), MotionsByStability(attracting, others)
