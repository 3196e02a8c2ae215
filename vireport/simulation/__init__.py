"""The rigid-impact model simulated from event to event; knows nothing of the analytic solution."""

from vireport.simulation.attractors import Attractor, Diagram, Outcome, attractors, diagram, find_attractor
from vireport.simulation.cycles import Cycle, growth_bound
from vireport.simulation.events import (
    BOTTOM,
    TOP,
    Impact,
    InFlight,
    Start,
    check_model,
    check_start,
    follow,
    follow_one,
    start_of,
)
from vireport.simulation.kernel import FLIGHT, FREE, PHASE, REST, RIDING, RUNNING, SETTLING, TURN, VELOCITY, WALL
from vireport.simulation.starts import random_starts, start_speed
from vireport.simulation.trajectories import Portrait, Trajectory, path, portrait, simulate

__all__ = [
    "BOTTOM",
    "FLIGHT",
    "FREE",
    "PHASE",
    "REST",
    "RIDING",
    "RUNNING",
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
    "Outcome",
    "Portrait",
    "Start",
    "Trajectory",
    "attractors",
    "check_model",
    "check_start",
    "diagram",
    "find_attractor",
    "follow",
    "follow_one",
    "growth_bound",
    "path",
    "portrait",
    "random_starts",
    "simulate",
    "start_of",
    "start_speed",
]
