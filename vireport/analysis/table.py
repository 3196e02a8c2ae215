"""Table 1 for a scenario: on which interval each family of motions is of which type, and by which criteria."""

from __future__ import annotations

from dataclasses import dataclass

from vireport.analysis.branches import Branch
from vireport.analysis.solution import Solution

CRITERIA = {
    "stable node": "Delta > 0 and |lambda_i| < 1",
    "stable focus": "Delta < 0 and |lambda_i| < 1",
    "unstable node": "Delta > 0 and |lambda_i| > 1",
}
"""Table 1's criteria, by its words."""


@dataclass(frozen=True, slots=True)
class Row:
    """One row of Table 1.

    Attributes
    ----------
    family : str
    branch : int
        Number of the branch; mirror images share the row of the first.
    start_label, end_label : str
        Critical points at the ends of the interval, "" where it is the sweep or the branch that ends.
    criteria, stability : str
        Table 1's criteria and words.
    d_start, d_end : float
        The interval in d, ascending (at constant d, ordered along the sweep).
    sweep_start, sweep_end : float
        The swept parameter at the same two ends.
    first_row, last_row : int
        Rows of the branch at these ends.
    """

    family: str
    branch: int
    start_label: str
    end_label: str
    criteria: str
    stability: str
    d_start: float
    d_end: float
    sweep_start: float
    sweep_end: float
    first_row: int
    last_row: int


def table(solution: Solution) -> tuple[Row, ...]:
    """Rows of Table 1 for the admissible motions of a sweep, by family and branch, ascending in d.

    Source: Table 1; the paper's reference to Figure 1 in it means Figure 2.
    """
    rows = []
    for branch in solution.branches:
        if branch.mirror_of is None:
            rows += _rows(branch, constant_d=solution.curve.level.kind == "d")
    return tuple(rows)


def _rows(branch: Branch, constant_d: bool) -> list[Row]:
    motions = branch.motions
    key = motions.sweep_value if constant_d else motions.d
    rows = []
    for part in branch.segments():
        if not part.admissible:
            continue
        first, last = sorted((part.first, part.last), key=lambda row: float(key[row]))
        rows.append(
            Row(
                branch.family,
                branch.number,
                branch.event[first],
                branch.event[last],
                CRITERIA[part.stability],
                part.stability,
                float(motions.d[first]),
                float(motions.d[last]),
                float(motions.sweep_value[first]),
                float(motions.sweep_value[last]),
                first,
                last,
            )
        )
    return sorted(rows, key=lambda row: row.sweep_start if constant_d else row.d_start)
