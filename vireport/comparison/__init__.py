"""Scenarios, variants and earlier results side by side, by one engine."""

from vireport.comparison import baseline, outputs
from vireport.comparison.baseline import diff
from vireport.comparison.comparison import Comparison, compare
from vireport.comparison.outputs import comparison_provenance

__all__ = [
    "Comparison",
    "baseline",
    "compare",
    "comparison_provenance",
    "diff",
    "outputs",
]
