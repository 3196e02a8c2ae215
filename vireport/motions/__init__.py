"""Periodic motions of any word: what they are, what happens to them, and those with two impacts in closed form."""

from vireport.motions.branches import Branch, admissible_families
from vireport.motions.conditions import Condition
from vireport.motions.critical import motion_at, motion_of, place_at, solve_one_to_one
from vireport.motions.diagram import BifurcationDiagram, TableRow, solve, table
from vireport.motions.error_bounds import NO_BOUND, one_to_one_bounds, rounded_up, undecided
from vireport.motions.events import CRITICAL, TRACE_LEVELS, Event
from vireport.motions.families import Atlas, Claim, Completeness, Family, Mark
from vireport.motions.generation import Rung, generation, impact_rate, ladder
from vireport.motions.level_curve import sample
from vireport.motions.motion import AT_ZERO, BESIDE, IMAGE, SAME, Motion, Symmetry
from vireport.motions.one_to_one import Motions, impact_velocities, motions_of
from vireport.motions.orbits import Orbits, coefficients, orbits
from vireport.motions.paths import RANK, STEEPEST, Arc, Curve, Path, PathPoint, Trail, completed, follow
from vireport.motions.periodicity import Model, linearised, residuals, trace, weighted_trace
from vireport.motions.points import OneToOne, Point, model_of, one_to_one, point_of, polished
from vireport.motions.pointwise import PointwiseMotions, differentiated_motions, find_motions
from vireport.motions.polish import DECIMALS, FARTHEST, Solved, in_decimals, newton
from vireport.motions.stability import (
    STABILITIES,
    UNSTABLE,
    Jacobian,
    Stability,
    classify,
    eigenvalues,
    flight_jacobian,
    multipliers,
    product_trace,
    return_trace,
)
from vireport.motions.sweep import Held, Level, Sweep, level_residual
from vireport.motions.switching import Beginning, Limits, neighbours, off, touching
from vireport.motions.turning import SMALLEST_STEP, Turn, Turns, flight_turns, touches, turning_points, turns, wall_gap

__all__ = [
    "AT_ZERO",
    "BESIDE",
    "CRITICAL",
    "DECIMALS",
    "FARTHEST",
    "IMAGE",
    "NO_BOUND",
    "RANK",
    "SAME",
    "SMALLEST_STEP",
    "STABILITIES",
    "STEEPEST",
    "TRACE_LEVELS",
    "UNSTABLE",
    "Arc",
    "Atlas",
    "Beginning",
    "BifurcationDiagram",
    "Branch",
    "Claim",
    "Completeness",
    "Condition",
    "Curve",
    "Event",
    "Family",
    "Held",
    "Jacobian",
    "Level",
    "Limits",
    "Mark",
    "Model",
    "Motion",
    "Motions",
    "OneToOne",
    "Orbits",
    "Path",
    "PathPoint",
    "Point",
    "PointwiseMotions",
    "Rung",
    "Solved",
    "Stability",
    "Sweep",
    "Symmetry",
    "TableRow",
    "Trail",
    "Turn",
    "Turns",
    "admissible_families",
    "classify",
    "coefficients",
    "completed",
    "differentiated_motions",
    "eigenvalues",
    "find_motions",
    "flight_jacobian",
    "flight_turns",
    "follow",
    "generation",
    "impact_rate",
    "impact_velocities",
    "in_decimals",
    "ladder",
    "level_residual",
    "linearised",
    "model_of",
    "motion_at",
    "motion_of",
    "motions_of",
    "multipliers",
    "neighbours",
    "newton",
    "off",
    "one_to_one",
    "one_to_one_bounds",
    "orbits",
    "place_at",
    "point_of",
    "polished",
    "product_trace",
    "residuals",
    "return_trace",
    "rounded_up",
    "sample",
    "solve",
    "solve_one_to_one",
    "table",
    "touches",
    "touching",
    "trace",
    "turning_points",
    "turns",
    "undecided",
    "wall_gap",
    "weighted_trace",
]
