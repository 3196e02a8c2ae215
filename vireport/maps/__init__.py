"""Maps over two or more parameters, of any size."""

from vireport.maps.run import run_map, terminal_progress

__all__ = [
    "run_map",
    "terminal_progress",
]
