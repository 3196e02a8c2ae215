"""What the device does when it is switched on: its outcome from rest, where that changes, and how fast it recovers."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.disturbances.behaviour import Disturbances, Ramp, disturbances_of
from vireport.disturbances.from_rest import Destination, FromRest
from vireport.disturbances.recovery import NoRecovery, Recovery

if TYPE_CHECKING:
    from vireport.disturbances.met import Met, met_along
    from vireport.disturbances.windows import Edge, OutcomeRange, Window, outcomes_of
else:
    __getattr__ = deferred(__name__, "met", "windows")

__all__ = [
    "Destination",
    "Disturbances",
    "Edge",
    "FromRest",
    "Met",
    "NoRecovery",
    "OutcomeRange",
    "Ramp",
    "Recovery",
    "Window",
    "disturbances_of",
    "met_along",
    "outcomes_of",
]
