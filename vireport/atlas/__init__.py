"""Every family of motions along a sweep: looked for among all flight times, followed, and joined where they meet."""

from typing import TYPE_CHECKING

from vireport.atlas.cycles import motion_of_cycle, portrait_of
from vireport.base import deferred

if TYPE_CHECKING:
    from vireport.atlas.exclusion import FINE
    from vireport.atlas.families import LOOKED_FOR, atlas
    from vireport.atlas.given import motions_of
    from vireport.atlas.surface import candidates_above
else:
    __getattr__ = deferred(__name__, "surface", "exclusion", "families", "given")

__all__ = [
    "FINE",
    "LOOKED_FOR",
    "atlas",
    "candidates_above",
    "motion_of_cycle",
    "motions_of",
    "portrait_of",
]
