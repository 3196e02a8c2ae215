"""The rigid-impact model simulated from event to event; knows nothing of the analytic solution."""

from vireport.simulation.attractors import Attractor, Diagram, attractors, diagram, find_attractor
from vireport.simulation.cycles import Cycle, growth_bound
from vireport.simulation.events import (
    BOTTOM,
    FLIGHT,
    FREE,
    PHASE,
    REST,
    RIDING,
    SETTLING,
    TOP,
    TURN,
    VELOCITY,
    WALL,
    Impact,
    InFlight,
    check_model,
    check_start,
    follow,
    follow_one,
)
from vireport.simulation.portraits import Portrait, portrait

__all__ = [
    "BOTTOM",
    "FLIGHT",
    "FREE",
    "PHASE",
    "REST",
    "RIDING",
    "SETTLING",
    "TOP",
    "TURN",
    "VELOCITY",
    "WALL",
    "Attractor",
    "Cycle",
    "Diagram",
    "Impact",
    "InFlight",
    "Portrait",
    "attractors",
    "check_model",
    "check_start",
    "diagram",
    "find_attractor",
    "follow",
    "follow_one",
    "growth_bound",
    "portrait",
]
