"""Maps over two or more parameters, of any size, and charts of the plane of two inputs."""

from vireport.sweep import charts
from vireport.sweep.plane import chart_of
from vireport.sweep.run import run_map, terminal_progress

__all__ = [
    "chart_of",
    "charts",
    "run_map",
    "terminal_progress",
]
