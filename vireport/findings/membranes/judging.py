"""What is held against the rigid model by the motion with compliant membranes."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.findings.membranes.compliance import Compliance
from vireport.text.alerts import Sentence


def moved_or_lost(comparison: Compliance) -> Iterator[Sentence]:
    """What the membranes' own stiffness moves farther than is fair to use, or else what of the rigid model it ends."""
    shifts = [
        Sentence("margins", {"name": criterion.name, "margins": abs(criterion.shift)})
        if compared.of_margin
        else Sentence("percent", {"name": criterion.name, "percent": 100 * criterion.shift})
        for compared in comparison.quantities
        if (criterion := compared.criterion) is not None and criterion.grade.contradicts
    ]
    if shifts:
        yield Sentence("moves", {"shifts": shifts})
        return
    rung, critical = comparison.unscaled, comparison.critical
    if critical is not None and rung is not None and rung.orbit is not None and rung.orbit.stable:
        yield Sentence("point_lost", {"label": critical.label})
    else:
        yield Sentence("motion_lost")
