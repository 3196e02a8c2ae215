"""Scenarios, variants and earlier results side by side, by one engine."""

from vireport.comparison.baseline import diff as diff
from vireport.comparison.comparison import Comparison as Comparison
from vireport.comparison.comparison import compare as compare
from vireport.comparison.figures import compare_figure as compare_figure
