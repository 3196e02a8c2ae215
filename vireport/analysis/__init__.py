"""The 1:1 motions of a device in closed form: their branches, critical points, margins and error bounds."""

from vireport.analysis.admissibility import touches
from vireport.analysis.branches import Branch, CriticalPoint
from vireport.analysis.critical import (
    CONDITIONS,
    Condition,
    PolishedMotion,
    equations,
    newton,
    orbit_at,
    polish,
    pressing_condition,
    touch_condition,
    value_condition,
)
from vireport.analysis.design import (
    DesignPoint,
    StableInterval,
    around_length,
    design_point,
    motions_at,
    stable_ranges,
)
from vireport.analysis.diagram import BifurcationDiagram, TableRow, solve
from vireport.analysis.error_bounds import NO_BOUND, rounded_up, undecided, value_bound
from vireport.analysis.kinds import Change, CriticalKind, StrandEvent, Symmetry
from vireport.analysis.level_curve import sample
from vireport.analysis.margins import HIGHEST_RESTITUTION, Margin
from vireport.analysis.motions import Motions, impact_velocities, motions_of
from vireport.analysis.orbits import Flight, Orbits, coefficients, orbits
from vireport.analysis.pointwise import PointwiseMotions, differentiated_motions, find_motions
from vireport.analysis.roots import newton_root
from vireport.analysis.sensitivity import contact_share, input_error, mass_elasticity, restitution_effect
from vireport.analysis.solution import SMALLEST_LOSS, Solution, solution_of
from vireport.analysis.stability import (
    STABILITIES,
    UNSTABLE,
    Jacobian,
    Stability,
    classify,
    eigenvalues,
    flight_jacobian,
    product_trace,
    return_trace,
)
from vireport.analysis.sweep import Held, Level, Sweep, level_residual

__all__ = [
    "CONDITIONS",
    "HIGHEST_RESTITUTION",
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
    "Flight",
    "Held",
    "Jacobian",
    "Level",
    "Margin",
    "Motions",
    "Orbits",
    "PointwiseMotions",
    "PolishedMotion",
    "Solution",
    "Stability",
    "StableInterval",
    "StrandEvent",
    "Sweep",
    "Symmetry",
    "TableRow",
    "around_length",
    "classify",
    "coefficients",
    "contact_share",
    "design_point",
    "differentiated_motions",
    "eigenvalues",
    "equations",
    "find_motions",
    "flight_jacobian",
    "impact_velocities",
    "input_error",
    "level_residual",
    "mass_elasticity",
    "motions_at",
    "motions_of",
    "newton",
    "newton_root",
    "orbit_at",
    "orbits",
    "polish",
    "pressing_condition",
    "product_trace",
    "restitution_effect",
    "return_trace",
    "rounded_up",
    "sample",
    "solution_of",
    "solve",
    "stable_ranges",
    "touch_condition",
    "touches",
    "undecided",
    "value_bound",
    "value_condition",
]
