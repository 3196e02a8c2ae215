"""Scenarios, variants and earlier results side by side, in one table."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.comparison.baseline import changes, diff, read_baseline, require_comparable
from vireport.comparison.comparison import Comparison, compare, left_out
from vireport.comparison.diff_outputs import changes_table, diff_json, diff_markdown, diff_text, rerun_text, unequal
from vireport.comparison.messages import listed
from vireport.comparison.outputs import (
    COMPARISON_FILES,
    COMPARISON_FOLDER,
    compare_json,
    comparison_provenance,
    folder_of,
    render_comparison,
    terminal_summary,
)
from vireport.comparison.pages import ComparisonReport
from vireport.comparison.quantities import QuantityGroup
from vireport.comparison.ranking import Merit
from vireport.comparison.table import ComparisonRow

if TYPE_CHECKING:
    from vireport.comparison.figures import compare_figure
else:
    __getattr__ = deferred(__name__, "figures")

__all__ = [
    "COMPARISON_FILES",
    "COMPARISON_FOLDER",
    "Comparison",
    "ComparisonReport",
    "ComparisonRow",
    "Merit",
    "QuantityGroup",
    "changes",
    "changes_table",
    "compare",
    "compare_figure",
    "compare_json",
    "comparison_provenance",
    "diff",
    "diff_json",
    "diff_markdown",
    "diff_text",
    "folder_of",
    "left_out",
    "listed",
    "read_baseline",
    "render_comparison",
    "require_comparable",
    "rerun_text",
    "terminal_summary",
    "unequal",
]
