"""The section on compliant membranes: whether the rigid model is good enough, and how solvers cope with stiff ones."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.report.pages import Block, Subheading, content
from vireport.trust import Compliance, comparison_with_rigid, solvers_on_stiff_membranes


def compliant(found: Compliance) -> Iterator[Block]:
    """Blocks of the section."""
    yield from content(comparison_with_rigid(found))
    if found.runs:
        yield Subheading("Solvers on the stiff equation")
        yield from content(solvers_on_stiff_membranes(found))
