"""What the device does when it is switched on, bumped and shaken: from rest, after a shock, with jitter."""

from vireport.disturbances.behaviour import Disturbances, Ramp, disturbances_of
from vireport.disturbances.from_rest import Destination, FromRest
from vireport.disturbances.jitter import Jitter, NoJitter, Unsettled, jitter
from vireport.disturbances.manifold import on_shocks, stable_manifold
from vireport.disturbances.plane import section_plane, shock_plane
from vireport.disturbances.recovery import Recovery
from vireport.disturbances.shock import QUICK, LeastShock, least_shock
from vireport.disturbances.windows import Edge, Window

__all__ = [
    "QUICK",
    "Destination",
    "Disturbances",
    "Edge",
    "FromRest",
    "Jitter",
    "LeastShock",
    "NoJitter",
    "Ramp",
    "Recovery",
    "Unsettled",
    "Window",
    "disturbances_of",
    "jitter",
    "least_shock",
    "on_shocks",
    "section_plane",
    "shock_plane",
    "stable_manifold",
]
