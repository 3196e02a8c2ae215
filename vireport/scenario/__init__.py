"""From a YAML file to a validated, frozen scenario or map, or to every mistake in it."""

from vireport.scenario import blocks
from vireport.scenario.blocks import (
    UNIT_OF_SWEPT,
    WIDEST_MARGIN,
    Accuracy,
    Axis,
    Map,
    MapSimulation,
    Requirements,
    Sampling,
    Scenario,
    Simulation,
    inputs,
    to_dict,
)
from vireport.scenario.loading import Loaded, LoadedMap, load, load_any, load_map, loads, loads_map
from vireport.scenario.overrides import as_texts
from vireport.scenario.parameters import Parameter
from vireport.scenario.schema import init_text, schema

__all__ = [
    "UNIT_OF_SWEPT",
    "WIDEST_MARGIN",
    "Accuracy",
    "Axis",
    "Loaded",
    "LoadedMap",
    "Map",
    "MapSimulation",
    "Parameter",
    "Requirements",
    "Sampling",
    "Scenario",
    "Simulation",
    "as_texts",
    "blocks",
    "init_text",
    "inputs",
    "load",
    "load_any",
    "load_map",
    "loads",
    "loads_map",
    "schema",
    "to_dict",
]
