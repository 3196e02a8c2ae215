"""The rigid-impact model simulated from event to event; knows nothing of the analytic solution."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.simulation.attractors import Attractor, Diagram, Outcome, attractors, diagram, find_attractor, motion_name
from vireport.simulation.cycles import Cycle, approached, chain_growth, growth_bound, jacobians, rest_cycle
from vireport.simulation.events import (
    BOTTOM,
    TOP,
    Impact,
    InFlight,
    as_start,
    check_model,
    check_start,
    follow_impacts,
    follow_one,
    start_of,
)
from vireport.simulation.kernel import (
    CREEPING,
    FLIGHT,
    FREE,
    HELD,
    PHASE,
    REST,
    RIDING,
    RUNNING,
    SETTLING,
    TURN,
    VELOCITY,
    WALL,
)
from vireport.simulation.release import Press, presses
from vireport.simulation.starts import even_starts, random_starts, start_speed

if TYPE_CHECKING:
    from vireport.simulation.following import CLOSE, RESOLUTION, Conditions, Course, Jump, Stage, course
    from vireport.simulation.stops import moved_on
    from vireport.simulation.trajectories import Portrait, path, portrait
else:
    __getattr__ = deferred(__name__, "stops", "trajectories", "following")

__all__ = [
    "BOTTOM",
    "CLOSE",
    "CREEPING",
    "FLIGHT",
    "FREE",
    "HELD",
    "PHASE",
    "RESOLUTION",
    "REST",
    "RIDING",
    "RUNNING",
    "SETTLING",
    "TOP",
    "TURN",
    "VELOCITY",
    "WALL",
    "Attractor",
    "Conditions",
    "Course",
    "Cycle",
    "Diagram",
    "Impact",
    "InFlight",
    "Jump",
    "Outcome",
    "Portrait",
    "Press",
    "Stage",
    "approached",
    "as_start",
    "attractors",
    "chain_growth",
    "check_model",
    "check_start",
    "course",
    "diagram",
    "even_starts",
    "find_attractor",
    "follow_impacts",
    "follow_one",
    "growth_bound",
    "jacobians",
    "motion_name",
    "moved_on",
    "path",
    "portrait",
    "presses",
    "random_starts",
    "rest_cycle",
    "start_of",
    "start_speed",
]
