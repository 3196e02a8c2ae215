"""What the device does when it is switched on, bumped and shaken: from rest, after a shock, with jitter."""

from vireport.disturbances.jitter import Jitter, NoJitter, Unsettled, jitter
from vireport.disturbances.manifold import on_shocks, stable_manifold
from vireport.disturbances.plane import section_plane, shock_plane
from vireport.disturbances.shock import QUICK, LeastShock, least_shock

__all__ = [
    "QUICK",
    "Jitter",
    "LeastShock",
    "NoJitter",
    "Unsettled",
    "jitter",
    "least_shock",
    "on_shocks",
    "section_plane",
    "shock_plane",
    "stable_manifold",
]
