"""Map files: a scenario with a map block, read and refused by the same rules, and in the same words, as a scenario."""

from __future__ import annotations

import hashlib
import io
import sys

import pytest

from vireport.base.errors import ScenarioError, UsageError
from vireport.scenario.blocks import AxisPath, Sampling
from vireport.scenario.loading import load_map, loads, loads_map
from vireport.scenario.parameters import DRIVING

HELD = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
"""
BLOCK = """\
map:
  axes:
    - {path: inclination_deg, from: 0, to: 90, count: 20}
    - path: device.length_m
      from: 0.2
      to: 0.9
      count: 25
"""
TEXT = HELD + BLOCK


def mistakes(text: str) -> list[tuple[int, str, str]]:
    with pytest.raises(ScenarioError) as caught:
        loads_map(text, "m.yaml")
    return [(mistake.line, mistake.path, mistake.message) for mistake in caught.value.mistakes]


def test_a_map_is_a_scenario_with_a_value_of_each_axis():
    loaded = loads_map(TEXT, "m.yaml")
    assert (loaded.name, loaded.text, loaded.sha256) == ("m.yaml", TEXT, hashlib.sha256(TEXT.encode()).hexdigest())
    assert [loaded.scenario.value_of(parameter) for parameter in DRIVING] == [0.2, 3.0, 2.0, 0.0]
    angle, length = loaded.block.axes
    assert (angle.path, angle.from_, angle.to, angle.count, angle.values) == ("inclination_deg", 0.0, 90.0, 20, None)
    assert length.path is AxisPath.LENGTH
    assert loaded.block.sampling is Sampling.GRID
    assert (loaded.block.seed, loaded.block.simulate, loaded.block.chunk_cells) == (0, None, None)


def test_what_is_set_over_a_map_is_in_its_text_and_digest():
    loaded = loads_map(TEXT, "m.yaml", ["device.restitution=0.6"])
    assert loaded.scenario.device.restitution == 0.6
    assert loaded.sha256 == hashlib.sha256(loaded.text.encode()).hexdigest() != loads_map(TEXT).sha256
    again = loads_map(loaded.text, "m.yaml")
    assert (again.scenario, again.block, again.sha256) == (loaded.scenario, loaded.block, loaded.sha256)


def test_what_varies_may_be_given_as_well_and_a_list_of_values_is_a_tuple():
    text = TEXT.replace("from: 0, to: 90, count: 20", "values: [30, 0, 60]") + "inclination_deg: 45\n"
    loaded = loads_map(text)
    assert loaded.block.axes[0].values == (30.0, 0.0, 60.0)
    assert loaded.scenario.inclination_deg == 30.0


def test_every_parameter_of_a_scenario_can_be_varied():
    others = {AxisPath.RESTITUTION, AxisPath.RESTITUTION_BOTTOM, AxisPath.RESTITUTION_TOP, AxisPath.BALL_MASS}
    assert {parameter.path for parameter in DRIVING} == {*AxisPath} - others
    for parameter in DRIVING:
        assert AxisPath(parameter.path).limits == parameter.limits


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            "from: 0.2",
            "from: 200 mm",
            (8, "map.axes.1.from", "the unit stands in the key, write 0.2 (a number from 1e-"),
        ),
        (
            "to: 0.9",
            "to: 0,9",
            (9, "map.axes.1.to", "write 0.9, with a decimal point (a number from 1e-15 to 1e15, in"),
        ),
        (
            "to: 0.9",
            "to: -1",
            (9, "map.axes.1.to", "got -1, which is not positive (a number from 1e-15 to 1e15, in m)"),
        ),
        ("to: 90", "to: 95", (6, "map.axes.0.to", "got 95, which is too large (a number from 0 to 90, in deg)")),
        ("to: 90", "to: .nan", (6, "map.axes.0.to", "not a finite number (a number from 0 to 90, in deg)")),
        ("to: 90", "to: 0", (6, "map.axes.0.to", "got 0, the same as from (a different value)")),
        (
            "count: 20",
            "count: 20.0",
            (6, "map.axes.0.count", "got 20.0; write 20 (a whole number from 2 to 100000000)"),
        ),
        ("to: 90, count: 20", "to: 90", (6, "map.axes.0", "count missing (an axis has from, to, count, or values)")),
        (
            "device.length_m",
            "length_m",
            (7, "map.axes.1.path", "got 'length_m'; did you mean 'device.length_m'? (one of"),
        ),
        ("device.length_m", "gravity_m_s2", (7, "map.axes.1.path", "which cannot be varied (one of inclination_deg,")),
        (
            "map:\n",
            "map:\n  sampling: sobel\n",
            (5, "map.sampling", "did you mean 'sobol'? (one of grid, list, latin_hy"),
        ),
        ("map:\n", "map:\n  simulate: 3\n", (5, "map.simulate", "got 3 (a block of keys: starts, impacts)")),
        (
            "map:\n",
            "sweep: {parameter: length_m, from: 1, to: 2}\nmap:\n",
            (4, "sweep", "a map has no sweep (delete it;"),
        ),
        (
            "map:\n",
            "simulation: {}\nmap:\n",
            (4, "simulation", "a map has no simulation block (delete it; map.simulate"),
        ),
        (
            "schema_version: 1",
            "schema_version: 1\ntitel: x",
            (2, "titel", "did you mean 'title'? (allowed: schema_version,"),
        ),
        ("from: 0, ", "", (6, "map.axes.0", "from missing (an axis has from, to, count, or values)")),
        ("count: 20", "count: 2.5", (6, "map.axes.0.count", "got 2.5, which is not a whole number")),
        (
            "count: 20",
            "count: 20, values: [1, 2]",
            (6, "map.axes.0.from", "an axis has either from, to and count, or values"),
        ),
        ("map:\n", "map:\n  samples: 60\n", (5, "map.samples", "a grid has as many cells as its axes say")),
        ("map:\n", "map:\n  chunks: 60\n", (5, "map.chunks", "unknown key")),
        ("map:\n", "map:\n  simulate: {starts: 0}\n", (5, "map.simulate.starts", "got 0")),
    ],
)
def test_a_mistake_is_named_by_line_and_key(old: str, new: str, expected: tuple[int, str, str]):
    assert old in TEXT
    text = TEXT.replace(old, new)
    named = mistakes(text)
    assert [expected[:2]] == [place[:2] for place in named]
    assert expected[2] in named[0][2]


@pytest.mark.parametrize(
    ("old", "new", "place", "fragment"),
    [
        ("path: inclination_deg", "path: device.length_m", "map.axes.1.path", "device.length_m is axis 0 already"),
        ("map:\n", "map:\n  sampling: sobol\n  samples: 100\n", "map.samples", "which is no power of 2"),
        (
            "map:\n",
            "map:\n  sampling: latin_hypercube\n  samples: 4194305\n",
            "map.samples",
            "got 4194305, which is too large with latin_hypercube (at most 4194304, as they are drawn at once; sobol",
        ),
        ("map:\n", "map:\n  sampling: list\n", "map.axes.0", "a list needs values"),
    ],
)
def test_a_mistake_among_others(old: str, new: str, place: str, fragment: str):
    assert fragment in {path: message for _, path, message in mistakes(TEXT.replace(old, new))}[place]


@pytest.mark.parametrize(
    ("key", "path", "fragment"),
    [
        ("cuont", "map.axes.1.cuont", "did you mean 'count'? (allowed in map.axes.1: path, from, to, count, values)"),
        ("'a.b'", "map.axes.1.'a.b'", "unknown key (allowed in map.axes.1: path, from, to, count, values)"),
    ],
)
def test_an_unknown_key_of_an_axis(key: str, path: str, fragment: str):
    named = mistakes(TEXT.replace("count: 25", f"{key}: 25"))
    assert [place[:2] for place in named] == [(7, "map.axes.1"), (10, path)]
    assert fragment in named[1][2]


def test_a_mistake_that_follows_from_another_one_is_left_out():
    assert [path for _, path, _ in mistakes(TEXT.replace("path: inclination_deg", "path: angle"))] == [
        "map.axes.0.path"
    ]
    several = "values: [1, x, 2]"
    named = mistakes(TEXT.replace("from: 0, to: 90, count: 20", several).replace("1, x, 2", "x"))
    assert [path for _, path, _ in named] == ["map.axes.0.values.0"]


def test_all_mistakes_of_scenario_and_map_are_told_at_once():
    text = TEXT.replace("0.5}", "x}").replace("to: 90", "to: 95").replace("excitation", "excitaton")
    assert [(line, path) for line, path, _ in mistakes(text)] == [
        (2, "device.restitution"),
        (3, "excitaton"),
        (6, "map.axes.0.to"),
    ]


def test_restitution_stays_below_one_where_it_varies():
    axis = BLOCK + "    - {path: device.restitution, values: [0.5, 1]}\n"
    ((line, path, message),) = mistakes(HELD + axis)
    assert (line, path) == (11, "map.axes.2.values.1")
    assert message == "got 1, which is too large (a number from 0 to 0.999999 where it is varied)"


def test_a_scenario_given_as_a_map_is_said_to_be_none():
    with pytest.raises(UsageError, match=r"x.yaml: has no map block, .*vireport map x.yaml --over INPUT,INPUT"):
        loads_map(HELD + "sweep: {parameter: length_m, from: 1, to: 2}\n", "x.yaml")


def test_a_map_given_as_a_scenario_is_said_to_be_one():
    with pytest.raises(ScenarioError, match="a file with a map is computed by 'vireport map FILE'"):
        loads(TEXT)


def test_files_are_found_as_those_of_scenarios(tmp_path, monkeypatch):
    (tmp_path / "map.yaml").write_text(TEXT)
    assert load_map(tmp_path / "map.yaml").block == loads_map(TEXT).block
    with pytest.raises(UsageError, match=r"no such file; did you mean '.*map\.yaml'\?$"):
        load_map(tmp_path / "mpa.yaml")
    with pytest.raises(UsageError, match="is a folder"):
        load_map(tmp_path)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(TEXT.encode())))
    assert load_map("-").name == "<stdin>"


@pytest.mark.parametrize("text", ["", "- 1\n", "5\n"])
def test_what_is_no_block_of_keys(text: str):
    ((line, path, message),) = mistakes(text)
    assert (line, path) == (1, "")
    assert "the file is" in message
