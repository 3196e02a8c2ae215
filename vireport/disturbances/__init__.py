"""What the device does when it is switched on, bumped and shaken: from rest, after a shock, with jitter."""

from vireport.disturbances.behaviour import Disturbances, Ramp, disturbances_of
from vireport.disturbances.from_rest import Destination, FromRest
from vireport.disturbances.recovery import Recovery
from vireport.disturbances.windows import Edge, Window

__all__ = [
    "Destination",
    "Disturbances",
    "Edge",
    "FromRest",
    "Ramp",
    "Recovery",
    "Window",
    "disturbances_of",
]
