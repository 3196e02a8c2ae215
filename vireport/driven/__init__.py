"""A recorded motion of the shaker driven through the device: what it does, beside the periodic motion predicted."""

from vireport.driven.driven import Driven, driven_by
from vireport.driven.means import NoInterval, batched

__all__ = ["Driven", "NoInterval", "batched", "driven_by"]
