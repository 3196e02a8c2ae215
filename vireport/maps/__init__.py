"""Maps over two or more parameters, of any size."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.maps.cells import MapPlan, map_plan
from vireport.maps.run import run_map

if TYPE_CHECKING:
    from vireport.maps.outputs import MAP_FILES, MapOutput
else:
    __getattr__ = deferred(__name__, "outputs")

__all__ = [
    "MAP_FILES",
    "MapOutput",
    "MapPlan",
    "map_plan",
    "run_map",
]
