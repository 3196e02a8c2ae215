"""Charts: the loci of events in the plane of two inputs, the points where they meet, and their figure and files."""

from vireport.chart import outputs
from vireport.chart.chart import Chart, chart, with_regions
from vireport.chart.meetings import Meeting
from vireport.chart.network import FollowedLocus
from vireport.chart.over import chart_of, plane_of
from vireport.chart.plane import Plane, StraightSweep

__all__ = [
    "Chart",
    "FollowedLocus",
    "Meeting",
    "Plane",
    "StraightSweep",
    "chart",
    "chart_of",
    "outputs",
    "plane_of",
    "with_regions",
]
