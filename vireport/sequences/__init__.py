"""Motions with any sequence of impacts: followed along a sweep, with their events, and joined where they meet."""

from vireport.sequences.atlas import atlas
from vireport.sequences.chart import Chart, chart
from vireport.sequences.continuation import Curve, Event
from vireport.sequences.data import families_data, families_of, family_rows, motion_data, motions_data
from vireport.sequences.energy import Generation, Rung, generation, ladder
from vireport.sequences.equations import Model, linearised, residuals, trace
from vireport.sequences.families import Atlas, Claim, Completeness, Family, Mark, Vertex
from vireport.sequences.loci import Condition
from vireport.sequences.meetings import Meeting
from vireport.sequences.motions import Motion, Word, motion_of_cycle, turns
from vireport.sequences.network import FollowedLocus
from vireport.sequences.plane import Line, Plane
from vireport.sequences.polish import PolishedPoint
from vireport.sequences.portraits import portrait_of
from vireport.sequences.surface import Motions, motions_above
from vireport.sequences.switching import Limits

__all__ = [
    "Atlas",
    "Chart",
    "Claim",
    "Completeness",
    "Condition",
    "Curve",
    "Event",
    "Family",
    "FollowedLocus",
    "Generation",
    "Limits",
    "Line",
    "Mark",
    "Meeting",
    "Model",
    "Motion",
    "Motions",
    "Plane",
    "PolishedPoint",
    "Rung",
    "Vertex",
    "Word",
    "atlas",
    "chart",
    "families_data",
    "families_of",
    "family_rows",
    "generation",
    "ladder",
    "linearised",
    "motion_data",
    "motion_of_cycle",
    "motions_above",
    "motions_data",
    "portrait_of",
    "residuals",
    "trace",
    "turns",
]
