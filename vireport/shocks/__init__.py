"""What a stable motion withstands: the least shock that leads out of it, its spread under random kicks."""

from vireport.shocks.deviations import flight_matrices, flight_times, stationary
from vireport.shocks.jitter import Jitter, NoJitter, Unsettled
from vireport.shocks.manifold import ShockLine
from vireport.shocks.plane import OutcomePlane
from vireport.shocks.shock import LeastShock, shocked
from vireport.shocks.withstood import Withstood, shocks_around, withstood_by

__all__ = [
    "Jitter",
    "LeastShock",
    "NoJitter",
    "OutcomePlane",
    "ShockLine",
    "Unsettled",
    "Withstood",
    "flight_matrices",
    "flight_times",
    "shocked",
    "shocks_around",
    "stationary",
    "withstood_by",
]
