"""Table 1 for a scenario: on which interval each family of motions is of which type, and by which criteria."""

from __future__ import annotations

from dataclasses import dataclass

from vireport.analysis.branches import Branch, CriticalPoint
from vireport.analysis.diagram import BifurcationDiagram
from vireport.analysis.kinds import Family, Stability

CRITERIA = {
    Stability.STABLE_NODE: "Delta > 0 and |lambda_i| < 1",
    Stability.STABLE_FOCUS: "Delta < 0 and |lambda_i| < 1",
    Stability.UNSTABLE_NODE: "Delta > 0 and |lambda_i| > 1",
}
"""Table 1's criteria."""


@dataclass(frozen=True, slots=True)
class Row:
    """One row of Table 1.

    Attributes
    ----------
    family : Family
    branch : int
        Number of the branch; mirror images share the row of the first.
    start_point, end_point : CriticalPoint or None
        At the ends of the interval; None where it is the sweep or the branch that ends.
    stability : Stability
    d_start, d_end : float
        The interval in d, ascending (at constant d, ordered along the sweep).
    sweep_start, sweep_end : float
        The swept parameter at the same two ends.
    first_row, last_row : int
        Rows of the branch at these ends.
    """

    family: Family
    branch: int
    start_point: CriticalPoint | None
    end_point: CriticalPoint | None
    stability: Stability
    d_start: float
    d_end: float
    sweep_start: float
    sweep_end: float
    first_row: int
    last_row: int

    @property
    def criteria(self) -> str:
        """Table 1's criteria for the type."""
        return CRITERIA[self.stability]


def table(diagram: BifurcationDiagram) -> tuple[Row, ...]:
    """Rows of Table 1 for the admissible motions of a sweep, by family and branch, ascending in d.

    Source: Table 1; the paper's reference to Figure 1 in it means Figure 2.
    """
    rows = []
    for branch in diagram.branches:
        if branch.mirror_of is None:
            rows += _rows(branch, constant_d=diagram.curve.level.kind == "d")
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
                branch.critical_point(first),
                branch.critical_point(last),
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
