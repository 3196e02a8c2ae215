"""From a YAML file to a validated, frozen scenario or map, or to every mistake in it."""

from vireport.scenario import blocks
from vireport.scenario.blocks import (
    UNIT_OF_SWEPT,
    WIDEST_MARGIN,
    Accuracy,
    Axis,
    Design,
    DesignPath,
    Direction,
    Distribution,
    Map,
    MapSimulation,
    Objective,
    Requirements,
    Sampling,
    Scenario,
    Simulation,
    inputs,
    to_dict,
)
from vireport.scenario.loading import Loaded, LoadedMap, load, load_any, load_map, loads, loads_map
from vireport.scenario.overrides import as_texts
from vireport.scenario.parameters import LARGEST, SMALLEST, DesignInput, Parameter, ScalarInput
from vireport.scenario.schema import init_text, schema

__all__ = [
    "LARGEST",
    "SMALLEST",
    "UNIT_OF_SWEPT",
    "WIDEST_MARGIN",
    "Accuracy",
    "Axis",
    "Design",
    "DesignInput",
    "DesignPath",
    "Direction",
    "Distribution",
    "Loaded",
    "LoadedMap",
    "Map",
    "MapSimulation",
    "Objective",
    "Parameter",
    "Requirements",
    "Sampling",
    "ScalarInput",
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
