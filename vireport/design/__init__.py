"""The design point: its motions, their margins, tolerances and yield, and how strongly they hang on each input."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.design import margins
from vireport.design.distortion import Distortion
from vireport.design.effects import Effect, Shift, Shifts, Unmoved, shift_to, shifts
from vireport.design.followed import FollowedMotion, followed_motion
from vireport.design.lines import HIGHEST_RESTITUTION, along, line_of, mirrored, reach
from vireport.design.margins import Margin, margins_of
from vireport.design.point import DesignPoint, StableInterval, around_length, design_point, motions_at, stable_ranges
from vireport.design.sensitivity import contact_share, input_error, mass_elasticity, restitution_effect
from vireport.design.solution import SMALLEST_LOSS, Solution, solution_of, stable_motion

if TYPE_CHECKING:
    from vireport.design.devices import devices_off, factor_of, region_of
    from vireport.design.measured import MeasuredShare, measured_share
    from vireport.design.proof import prove_again
    from vireport.design.tolerances import Failure, Tolerances, assess_tolerances, sample_steps
else:
    __getattr__ = deferred(__name__, "devices", "measured", "proof", "tolerances")

__all__ = [
    "HIGHEST_RESTITUTION",
    "SMALLEST_LOSS",
    "DesignPoint",
    "Distortion",
    "Effect",
    "Failure",
    "FollowedMotion",
    "Margin",
    "MeasuredShare",
    "Shift",
    "Shifts",
    "Solution",
    "StableInterval",
    "Tolerances",
    "Unmoved",
    "along",
    "around_length",
    "assess_tolerances",
    "contact_share",
    "design_point",
    "devices_off",
    "factor_of",
    "followed_motion",
    "input_error",
    "line_of",
    "margins",
    "margins_of",
    "mass_elasticity",
    "measured_share",
    "mirrored",
    "motions_at",
    "prove_again",
    "reach",
    "region_of",
    "restitution_effect",
    "sample_steps",
    "shift_to",
    "shifts",
    "solution_of",
    "stable_motion",
    "stable_ranges",
]
