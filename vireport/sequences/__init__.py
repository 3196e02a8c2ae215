"""Motions with any sequence of impacts: followed along a sweep, with their events, and joined where they meet."""

from vireport.sequences.atlas import atlas
from vireport.sequences.continuation import Curve, Event
from vireport.sequences.data import families_data, motions_data
from vireport.sequences.energy import Generation, generation
from vireport.sequences.equations import Model, linearised, residuals, trace
from vireport.sequences.families import Atlas, Claim, Completeness, Family, Mark, Vertex
from vireport.sequences.motions import Motion, Sequence, motion_of_cycle, turns
from vireport.sequences.polish import PolishedPoint
from vireport.sequences.surface import Motions, motions_above
from vireport.sequences.switching import Limits

__all__ = [
    "Atlas",
    "Claim",
    "Completeness",
    "Curve",
    "Event",
    "Family",
    "Generation",
    "Limits",
    "Mark",
    "Model",
    "Motion",
    "Motions",
    "PolishedPoint",
    "Sequence",
    "Vertex",
    "atlas",
    "families_data",
    "generation",
    "linearised",
    "motion_of_cycle",
    "motions_above",
    "motions_data",
    "residuals",
    "trace",
    "turns",
]
