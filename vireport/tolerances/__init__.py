"""Whether every device within the tolerances of its inputs works: a proof over a box, and the yield."""

from vireport.tolerances.assessment import Failure, Tolerances, assess_tolerances
from vireport.tolerances.devices import FACTOR_OF, devices_off, region_of
from vireport.tolerances.proof import prove_again

__all__ = [
    "FACTOR_OF",
    "Failure",
    "Tolerances",
    "assess_tolerances",
    "devices_off",
    "prove_again",
    "region_of",
]
