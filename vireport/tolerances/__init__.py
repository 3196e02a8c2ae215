"""Whether every device within the tolerances of its inputs works: a proof over a box, and the yield."""

from vireport.tolerances.assessment import Answer, Failure, Tolerances, Yield, assess_tolerances
from vireport.tolerances.devices import FACTOR_OF, Region, devices_off, region_of, stable_motions
from vireport.tolerances.proof import Leaf, Proof, prove_again, prove_region

__all__ = [
    "FACTOR_OF",
    "Answer",
    "Failure",
    "Leaf",
    "Proof",
    "Region",
    "Tolerances",
    "Yield",
    "assess_tolerances",
    "devices_off",
    "prove_again",
    "prove_region",
    "region_of",
    "stable_motions",
]
