"""From a YAML file to a validated, frozen scenario or map, or to every mistake in it."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.scenario.blocks import (
    DEMANDS,
    LARGEST_HARMONIC,
    UNIT_OF_SWEPT,
    WIDEST_MARGIN,
    AccuracyBlock,
    Approach,
    AxisBlock,
    CapsuleMotion,
    Demand,
    DesignBlock,
    DesignPath,
    Direction,
    Distribution,
    DisturbancesBlock,
    EffectBlock,
    LeftOut,
    LimitKind,
    MapBlock,
    MapSimulationBlock,
    MembraneBlock,
    MotionsBlock,
    Need,
    Objective,
    RecordBlock,
    RequirementsBlock,
    Sampling,
    Scenario,
    SimulationBlock,
    TolerancesBlock,
    inputs,
    percent_key,
    to_dict,
    unit_of,
)
from vireport.scenario.document import LARGEST_FILE, join
from vireport.scenario.document import read as read_document
from vireport.scenario.loading import Loaded, LoadedMap, Source, load, load_any, load_map, loads, loads_map
from vireport.scenario.overrides import as_texts
from vireport.scenario.parameters import DRIVING, LARGEST, SMALLEST, DesignInput, Parameter, ScalarInput
from vireport.scenario.rules import SPECIAL, Special
from vireport.scenario.writing import as_yaml

if TYPE_CHECKING:
    from vireport.scenario.hints import for_key
    from vireport.scenario.json_schema import init_text, schema
else:
    __getattr__ = deferred(__name__, "hints", "json_schema")

__all__ = [
    "DEMANDS",
    "DRIVING",
    "LARGEST",
    "LARGEST_FILE",
    "LARGEST_HARMONIC",
    "SMALLEST",
    "SPECIAL",
    "UNIT_OF_SWEPT",
    "WIDEST_MARGIN",
    "AccuracyBlock",
    "Approach",
    "AxisBlock",
    "CapsuleMotion",
    "Demand",
    "DesignBlock",
    "DesignInput",
    "DesignPath",
    "Direction",
    "Distribution",
    "DisturbancesBlock",
    "EffectBlock",
    "LeftOut",
    "LimitKind",
    "Loaded",
    "LoadedMap",
    "MapBlock",
    "MapSimulationBlock",
    "MembraneBlock",
    "MotionsBlock",
    "Need",
    "Objective",
    "Parameter",
    "RecordBlock",
    "RequirementsBlock",
    "Sampling",
    "ScalarInput",
    "Scenario",
    "SimulationBlock",
    "Source",
    "Special",
    "TolerancesBlock",
    "as_texts",
    "as_yaml",
    "for_key",
    "init_text",
    "inputs",
    "join",
    "load",
    "load_any",
    "load_map",
    "loads",
    "loads_map",
    "percent_key",
    "read_document",
    "schema",
    "to_dict",
    "unit_of",
]
