"""What long contacts change, in every report: motion, ends and margin with the membranes' own stiffness."""

from vireport.compliant.descent import (
    FINEST,
    MULTIPLIER,
    Absence,
    CompliantMotion,
    Reached,
    Rigid,
    descend,
    end_to_follow,
    motion_to_follow,
    rigid_motion,
)
from vireport.compliant.model import CompliantModel, compliant_model, contact_units, free_flight
from vireport.compliant.own_stiffness import (
    LEAST_RESTITUTION,
    TOO_LOSSY,
    OwnStiffness,
    StabilityEnd,
    own_stiffness,
    own_stiffness_data,
)

__all__ = [
    "FINEST",
    "LEAST_RESTITUTION",
    "MULTIPLIER",
    "TOO_LOSSY",
    "Absence",
    "CompliantModel",
    "CompliantMotion",
    "OwnStiffness",
    "Reached",
    "Rigid",
    "StabilityEnd",
    "compliant_model",
    "contact_units",
    "descend",
    "end_to_follow",
    "free_flight",
    "motion_to_follow",
    "own_stiffness",
    "own_stiffness_data",
    "rigid_motion",
]
