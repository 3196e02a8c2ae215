"""From a YAML file to a validated, frozen scenario, or to every mistake in it."""

from vireport.scenario import blocks, loading
from vireport.scenario.blocks import SWEEPABLE, WIDEST_MARGIN, Accuracy, Requirements, Scenario, Simulation
from vireport.scenario.keys import entries
from vireport.scenario.loading import Loaded, load, loads, to_dict
from vireport.scenario.map_blocks import Axis, Map, MapSimulation
from vireport.scenario.map_scenario import LoadedMap, load_map
from vireport.scenario.overrides import as_texts
from vireport.scenario.parameters import Parameter
from vireport.scenario.rules import MARGINS
from vireport.scenario.schema import init_text, schema

__all__ = [
    "MARGINS",
    "SWEEPABLE",
    "WIDEST_MARGIN",
    "Accuracy",
    "Axis",
    "Loaded",
    "LoadedMap",
    "Map",
    "MapSimulation",
    "Parameter",
    "Requirements",
    "Scenario",
    "Simulation",
    "as_texts",
    "blocks",
    "entries",
    "init_text",
    "load",
    "load_map",
    "loading",
    "loads",
    "schema",
    "to_dict",
]
