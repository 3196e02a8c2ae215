"""Charts: which motions are stable in the plane of two inputs, and the curves along which that changes."""

from vireport.charts.outputs import NAMES, chart_json, files, text
from vireport.charts.window import chart_of

__all__ = ["NAMES", "chart_json", "chart_of", "files", "text"]
