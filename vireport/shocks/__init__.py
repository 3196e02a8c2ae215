"""What a stable motion withstands: the least shock that leads out of it, which starts come to it, random kicks."""

from vireport.shocks.attracting import AttractingMotion, AttractingMotions, attracting_motions
from vireport.shocks.basin import Basins, basins_of
from vireport.shocks.deviations import flight_matrices, flight_times, stationary
from vireport.shocks.jitter import Jitter, NoJitter, Unsettled
from vireport.shocks.manifold import ShockLine, on_shocks, stable_manifold
from vireport.shocks.plane import OutcomePlane
from vireport.shocks.returning import core_of, endings
from vireport.shocks.shock import SCAN, LeastShock, shocked
from vireport.shocks.withstood import Withstood, least_of, shocks_around, withstood_by

__all__ = [
    "SCAN",
    "AttractingMotion",
    "AttractingMotions",
    "Basins",
    "Jitter",
    "LeastShock",
    "NoJitter",
    "OutcomePlane",
    "ShockLine",
    "Unsettled",
    "Withstood",
    "attracting_motions",
    "basins_of",
    "core_of",
    "endings",
    "flight_matrices",
    "flight_times",
    "least_of",
    "on_shocks",
    "shocked",
    "shocks_around",
    "stable_manifold",
    "stationary",
    "withstood_by",
]
