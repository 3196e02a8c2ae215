"""Maps over two or more parameters, of any size."""

from vireport.maps.cells import MapPlan, map_plan
from vireport.maps.run import run_map

__all__ = [
    "MapPlan",
    "map_plan",
    "run_map",
]
