"""What long contacts change, in every report: motion, ends and margin with the membranes' own stiffness."""

from vireport.compliant.descent import MULTIPLIER, Finder, Rigid, descend, rigid_motion
from vireport.compliant.model import CompliantModel, compliant_model, contact_units, free_flight
from vireport.compliant.own_stiffness import OwnStiffness, StabilityEnd, own_stiffness, own_stiffness_data

__all__ = [
    "MULTIPLIER",
    "CompliantModel",
    "Finder",
    "OwnStiffness",
    "Rigid",
    "StabilityEnd",
    "compliant_model",
    "contact_units",
    "descend",
    "free_flight",
    "own_stiffness",
    "own_stiffness_data",
    "rigid_motion",
]
