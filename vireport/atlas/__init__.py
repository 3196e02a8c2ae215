"""Every family of motions along a sweep: looked for among all flight times, followed, and joined where they meet."""

from vireport.atlas.atlas import LOOKED_FOR, atlas
from vireport.atlas.cycles import motion_of_cycle, portrait_of
from vireport.atlas.exclusion import FINE
from vireport.atlas.given import motions_of
from vireport.atlas.surface import candidates_above

__all__ = [
    "FINE",
    "LOOKED_FOR",
    "atlas",
    "candidates_above",
    "motion_of_cycle",
    "motions_of",
    "portrait_of",
]
