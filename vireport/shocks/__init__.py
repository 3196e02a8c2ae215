"""What a stable motion withstands: the least shock that leads out of it, its spread under random kicks."""

from vireport.shocks.jitter import Jitter, NoJitter, Unsettled, jitter
from vireport.shocks.manifold import on_shocks, stable_manifold
from vireport.shocks.plane import section_plane, shock_plane
from vireport.shocks.shock import QUICK, LeastShock, least_shock
from vireport.shocks.withstood import Withstood, withstood_by

__all__ = [
    "QUICK",
    "Jitter",
    "LeastShock",
    "NoJitter",
    "Unsettled",
    "Withstood",
    "jitter",
    "least_shock",
    "on_shocks",
    "section_plane",
    "shock_plane",
    "stable_manifold",
    "withstood_by",
]
