"""The JSON Schema says what each key may be, as the loader does; the scenario to start from shows every key."""

from __future__ import annotations

import json
from pathlib import Path
from runpy import run_path

import pytest
from bad_scenarios import BAD_SCENARIOS, GOOD
from jsonschema import Draft202012Validator
from pydantic import ValidationError

from vireport.base.errors import ScenarioError
from vireport.scenario.blocks import Scenario, keys_left_out, to_dict
from vireport.scenario.document import read
from vireport.scenario.json_schema import init_text, keys, schema
from vireport.scenario.loading import loads
from vireport.scenario.map_file import MapFile

EXAMPLES = Path(__file__).parents[2] / "examples"
SCHEMA = schema()
VALIDATOR = Draft202012Validator(SCHEMA)
SCENARIOS = [GOOD, init_text(), *(path.read_text(encoding="utf-8") for path in EXAMPLES.glob("*.yaml"))]
KEYS = {path: key for path, key in keys(Scenario).items() if path and not path.endswith("*")}
LEAVES = [path for path, key in KEYS.items() if "properties" not in key]

# What a schema cannot see of one key: how a number is written, what is no finite number, and control characters.
BEYOND = {
    *("period_ratio: 2.0", "schema_version: 1.0", "simulation: {samples: 4.0}", "simulation: {portraits: [.nan]}"),
    *("  length_m: .nan", "  to: .inf", "title: '  '", 'title: "\\e[31m"', 'title: "two\\nlines"', "title: a\u202eb"),
}


def test_committed_schema_is_the_one_in_force():
    committed = (EXAMPLES / "scenario.schema.json").read_text(encoding="utf-8")
    assert committed == json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


@pytest.mark.skipif("disturbances" not in KEYS, reason="an addition is taken out")
def test_the_tables_of_the_page_are_what_is_declared():
    tool = run_path(str(EXAMPLES.parent / "tools" / "write_keys.py"))
    text = (EXAMPLES.parent / "docs" / "scenario.md").read_text(encoding="utf-8")
    assert tool["page"](text) == text
    ramp = "| `disturbances.ramp_periods` | Forcing periods in which the amplitude of the force is ramped up"
    assert f"{ramp} when the device is switched on; 0: at once. | a number from 0 to 1000, in periods | `0` |\n" in text
    first = "| `sweep.from` | First value; it may be the larger. | a number, in the unit of the swept parameter"
    assert f"{first} | required |\n" in text


def test_schema_is_a_schema():
    Draft202012Validator.check_schema(schema())
    assert schema()["$schema"] == Draft202012Validator.META_SCHEMA["$id"]


def test_the_schema_has_one_name_for_good():
    """Editors and registries keep a schema by its `$id`; a new one belongs to a new schema_version."""
    assert schema()["$id"] == "urn:uuid:4049c3a5-c16d-53b3-9cf7-2e6fde98309b"
    version = schema()["properties"]["schema_version"]
    assert version["minimum"] == version["maximum"] == 1


@pytest.mark.parametrize("text", SCENARIOS)
def test_schema_accepts_scenarios_and_what_is_made_of_them(text):
    VALIDATOR.validate(read(text, "text").data)
    VALIDATOR.validate(to_dict(loads(text).scenario))


@pytest.mark.parametrize("case", BAD_SCENARIOS, ids=lambda case: case.name)
def test_schema_refuses_what_is_wrong_with_one_key(case):
    """What holds between several keys is left to `vireport check`."""
    try:
        document = read(case.text, "text")
    except ScenarioError:
        return  # not even a tree
    if isinstance(document.data, dict) and not {*keys_left_out(Scenario)}.isdisjoint(document.data):
        pytest.skip("an addition is taken out")
    try:
        Scenario.model_validate(document.data)
        wrong = False
    except ValidationError:
        wrong = BEYOND.isdisjoint(str(case.text).splitlines())
    assert document.mistakes or VALIDATOR.is_valid(document.data) is not wrong


@pytest.mark.parametrize("block", ["", "device", "device.membrane", "excitation", "sweep"])
def test_schema_refuses_unknown_keys(block):
    tree = read(GOOD, "text").data
    inner = tree
    for step in filter(None, block.split(".")):
        inner = inner[step]
    inner["colour"] = "red"
    assert [list(error.absolute_path) for error in VALIDATOR.iter_errors(tree)] == [block.split(".") if block else []]


@pytest.mark.parametrize("path", KEYS)
def test_every_key_is_explained(path):
    key = KEYS[path]
    assert key["title"]
    assert key["description"].endswith(".")


@pytest.mark.parametrize("path", LEAVES)
def test_every_value_has_an_example_that_is_valid(path):
    key = KEYS[path]
    for value in key["examples"]:
        Draft202012Validator({**key, "$defs": SCHEMA["$defs"]}).validate(value)
    if "number" in key["type"]:
        assert key["unit"]


UNITS = {"m": "m", "kg": "kg", "n": "N", "hz": "Hz", "deg": "deg", "v": "V", "mw": "mW", "v_m": "V/m", "m_s2": "m/s^2"}


@pytest.mark.parametrize("suffix", UNITS)
def test_unit_in_the_key_is_the_unit_in_the_schema(suffix):
    ends = {path: [end for end in UNITS if path.endswith(f"_{end}")] for path in LEAVES}
    matching = [path for path, suffixes in ends.items() if max(suffixes, key=len, default="") == suffix]
    assert matching
    assert {KEYS[path]["unit"] for path in matching} == {UNITS[suffix]}


def test_template_has_every_key_and_the_defaults():
    head, marked, block = init_text().partition("# simulation:")
    assert loads(init_text()).scenario.simulation is None  # commented out: it takes a while
    head = head.replace("\n    # ", "\n    ")  # commented out as well: no default stands for a material
    loaded = loads(head + (marked + block).replace("\n# ", "\n").removeprefix("# "))
    instead = {f"device.{key}" for key in ("restitution_bottom", "restitution_top")}  # of the restitution of both
    # A record is of one device, and the template has a block that looks for others.
    others = {"excitation.record", "design.minimise"}  # the latter stands in for design.maximise
    assert loaded.stated_keys == {path for path in KEYS if "*" not in path} - instead - others
    plain = to_dict(loaded.scenario)
    without = {path: key["default"] for path, key in KEYS.items() if key.get("default") is not None and "*" not in path}
    assert len(without) >= 52
    for path, default in without.items():
        value = plain
        for step in path.split("."):
            value = value[step]
        assert value == default


def test_template_explains_every_value():
    assert init_text().startswith("# yaml-language-server: $schema=scenario.schema.json\n")
    for row in init_text().splitlines():
        assert len(row) <= 110
        assert "#" in row or row in ("", "device:", "excitation:")


def test_keys_are_those_of_the_blocks():
    assert [path for path in KEYS if "." not in path] == [
        *(name for name in Scenario.model_fields if name not in keys_left_out(Scenario))
    ]
    assert {"map", "map.axes", "map.axes.*", "map.axes.*.values.*", "map.simulate.starts"} <= set(keys(MapFile))
