"""The 1:1 motions of a device in closed form: their branches, critical points, margins and error bounds."""

from vireport.analysis.admissibility import turning_points
from vireport.analysis.branches import Branch, CriticalPoint
from vireport.analysis.critical import CONDITIONS, Condition, Point, polish, value_condition
from vireport.analysis.design import DesignPoint, Margin, StableInterval, design_point, stable_ranges, stable_runs
from vireport.analysis.diagram import BifurcationDiagram, solve
from vireport.analysis.endings import Endings, endings
from vireport.analysis.grazing import touch
from vireport.analysis.kinds import STABILITIES, Change, CriticalKind, Family, Stability, StrandEvent
from vireport.analysis.motions import Motions, impact_velocities, motions_of
from vireport.analysis.orbits import Level, Orbits, coefficients, level_residual, level_terms, orbits
from vireport.analysis.pointwise import find_motions
from vireport.analysis.sensitivity import contact_share, input_error, mass_elasticity, restitution_effect
from vireport.analysis.solution import SMALLEST_LOSS, Solution, solution_of
from vireport.analysis.stability import UNSTABLE, classify, eigenvalues, flight_jacobian, trace_and_determinant
from vireport.analysis.sweep import Sweep
from vireport.analysis.table import Row
from vireport.analysis.tracing import sample, select
from vireport.analysis.uncertainty import NO_BOUND, shown

__all__ = [
    "CONDITIONS",
    "NO_BOUND",
    "SMALLEST_LOSS",
    "STABILITIES",
    "UNSTABLE",
    "BifurcationDiagram",
    "Branch",
    "Change",
    "Condition",
    "CriticalKind",
    "CriticalPoint",
    "DesignPoint",
    "Endings",
    "Family",
    "Level",
    "Margin",
    "Motions",
    "Orbits",
    "Point",
    "Row",
    "Solution",
    "Stability",
    "StableInterval",
    "StrandEvent",
    "Sweep",
    "classify",
    "coefficients",
    "contact_share",
    "design_point",
    "eigenvalues",
    "endings",
    "find_motions",
    "flight_jacobian",
    "impact_velocities",
    "input_error",
    "level_residual",
    "level_terms",
    "mass_elasticity",
    "motions_of",
    "orbits",
    "polish",
    "restitution_effect",
    "sample",
    "select",
    "shown",
    "solution_of",
    "solve",
    "stable_ranges",
    "stable_runs",
    "touch",
    "trace_and_determinant",
    "turning_points",
    "value_condition",
]
