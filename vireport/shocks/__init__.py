"""What a stable motion withstands: the least shock that leads out of it, its spread under random kicks."""

from vireport.shocks.jitter import Jitter, NoJitter, Unsettled
from vireport.shocks.manifold import ShockLine
from vireport.shocks.plane import OutcomePlane
from vireport.shocks.shock import SCAN, LeastShock
from vireport.shocks.withstood import Withstood, least_of, shocks_around, withstood_by

__all__ = [
    "SCAN",
    "Jitter",
    "LeastShock",
    "NoJitter",
    "OutcomePlane",
    "ShockLine",
    "Unsettled",
    "Withstood",
    "least_of",
    "shocks_around",
    "withstood_by",
]
