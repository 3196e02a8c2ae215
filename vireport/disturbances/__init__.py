"""What the device does when it is switched on, bumped and shaken: from rest, after a shock, with jitter."""

from vireport.disturbances.jitter import Jitter, NoJitter, Unsettled, jitter

__all__ = ["Jitter", "NoJitter", "Unsettled", "jitter"]
