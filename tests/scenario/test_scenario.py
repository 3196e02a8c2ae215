"""Scenarios as they are loaded: examples, defaults, where they came from, and the way back to plain data."""

from __future__ import annotations

import io
import subprocess
import sys
from functools import reduce
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from bad_scenarios import GOOD, MINIMAL
from pydantic import ValidationError

from vireport.base.errors import ScenarioError, UsageError
from vireport.scenario.blocks import MembraneBlock, Scenario, SimulationBlock, inputs, keys_left_out, to_dict
from vireport.scenario.keys import added_keys, value_at
from vireport.scenario.loading import load, loads, with_default_blocks
from vireport.scenario.parameters import DRIVING, Parameter
from vireport.scenario.rules import ADDED_IF_FULL

EXAMPLES = Path(__file__).parents[2] / "examples"
PAPER = {
    "horizontal": (0.0, 3.0, 0.5554, ("length_m", 0.26, 0.75)),
    "inclined": (45.0, 3.0, 0.6934, ("length_m", 0.59, 0.75)),
    "inclined-forcing": (45.0, 5.31, 0.75, ("amplitude_n", 3.0, 6.0)),
    "design-point": (45.0, 3.0, 0.7, None),
}


@pytest.mark.parametrize("name", PAPER)
def test_examples(name):
    text = (EXAMPLES / f"{name}.yaml").read_text(encoding="utf-8")
    assert text.startswith("# yaml-language-server: $schema=scenario.schema.json\n")
    scenario = load(EXAMPLES / f"{name}.yaml").scenario
    sweep = scenario.sweep and (scenario.sweep.parameter, scenario.sweep.from_, scenario.sweep.to)
    values = (scenario.inclination_deg, scenario.excitation.amplitude_n, scenario.device.length_m, sweep)
    assert values == PAPER[name]
    assert (scenario.device.capsule_mass_kg, scenario.device.ball_mass_kg) == (0.1245, 0.0041)
    assert (scenario.device.restitution, scenario.excitation.frequency_hz) == (0.5, 2.0)
    assert (scenario.gravity_m_s2, scenario.period_ratio) == (9.8, 1)


def test_every_example_is_tested():
    assert {path.stem for path in EXAMPLES.glob("*.yaml")} >= set(PAPER)
    for path in EXAMPLES.glob("*.yaml"):
        load(path)


def test_defaults_are_filled_in():
    scenario = loads(MINIMAL).scenario
    assert scenario.gravity_m_s2 == 9.8
    assert scenario.period_ratio == 1
    assert scenario.title is scenario.sweep is scenario.device.ball_mass_kg is None


def test_simulation_is_absent_unless_asked_for_and_an_empty_block_is_all_defaults():
    assert loads(MINIMAL).scenario.simulation is loads(MINIMAL + "simulation:\n").scenario.simulation is None
    simulation = loads(MINIMAL + "simulation: {}\n").scenario.simulation
    assert simulation == SimulationBlock()
    assert (simulation.samples, simulation.starts, simulation.impacts, simulation.tolerance) == (41, 4, 1000, 1e-9)
    assert (simulation.diagram, simulation.portraits, simulation.displacement) == (False, (), ())


def test_lists_are_tuples_of_floats_and_lists_again_as_plain_data():
    loaded = loads(MINIMAL, overrides=["simulation.portraits=[1, 0.7]"])
    assert loaded.scenario.simulation == SimulationBlock(portraits=(1.0, 0.7))
    assert [type(value) for value in loaded.scenario.simulation.portraits] == [float, float]
    assert to_dict(loaded.scenario)["simulation"]["portraits"] == [1.0, 0.7]


def test_membrane_is_there_where_energy_is_evaluated():
    assert loads(MINIMAL).scenario.device.membrane is None
    loaded = loads(MINIMAL, overrides=["device.ball_mass_kg=0.004"])
    assert loaded.scenario.device.membrane == MembraneBlock()
    assert "device.membrane" not in loaded.stated_keys
    assert loads(MINIMAL + "sweep:\n", overrides=["device.membrane="]).scenario.device.membrane is None


def test_integers_are_numbers():
    scenario = loads(MINIMAL).scenario
    assert type(scenario.device.length_m) is type(scenario.inclination_deg) is float


@pytest.mark.parametrize("parameter", DRIVING)
def test_what_is_swept_may_be_left_out(parameter):
    path = parameter.path
    sweep = f"sweep={{parameter: {parameter}, from: 1, to: 2}}"
    given_too = loads(MINIMAL, overrides=[sweep])
    left_out = loads(MINIMAL, overrides=[sweep, f"{path}="])
    assert path in given_too.stated_keys
    assert path not in left_out.stated_keys
    with pytest.raises(ScenarioError, match=f"--set {path}: required unless it is swept, but missing"):
        loads(MINIMAL, overrides=[f"{path}="])


@pytest.mark.parametrize("parameter", DRIVING)
def test_parameters_are_where_they_are_said_to_be(parameter):
    scenario = loads(MINIMAL).scenario
    value = to_dict(scenario)
    for step in parameter.path.split("."):
        value = value[step]
    assert scenario.value_of(parameter) == value is not None


def test_parameter_of_a_scenario_is_the_one_that_is_swept_or_the_length():
    assert loads(MINIMAL).scenario.parameter is Parameter.LENGTH
    swept = loads(MINIMAL, overrides=["sweep={parameter: frequency_hz, from: 1, to: 2}"]).scenario
    assert swept.parameter is swept.sweep.parameter is Parameter.FREQUENCY


def test_inputs_are_all_values_with_title_and_unit_in_the_order_of_the_format():
    listed = {entry.path: entry for entry in inputs(loads(GOOD).scenario)}
    assert list(listed)[:4] == ["schema_version", "title", "device.capsule_mass_kg", "device.ball_mass_kg"]
    assert listed["device.length_m"][1:] == ("Length", "m", 0.7)
    assert listed["sweep.from"][1:] == ("From", "the unit of the swept parameter", 0.59)
    assert "device.membrane.exponent" in listed
    assert "device.membrane" not in listed
    assert not any(path.startswith("simulation") for path in listed)


def test_sweep_may_run_backwards():
    sweep = loads(GOOD, overrides=["sweep.from=0.75", "sweep.to=0.59"]).scenario.sweep
    assert (sweep.from_, sweep.to) == (0.75, 0.59)


def test_everything_is_frozen():
    loaded = loads(GOOD)
    with pytest.raises(ValidationError, match="frozen"):
        loaded.scenario.device.restitution = 0.6
    with pytest.raises(AttributeError):
        loaded.overrides = ()
    with pytest.raises(AttributeError):
        loaded.document.name = ""


def test_given_are_all_keys_of_file_and_overrides_but_empty_ones():
    loaded = loads(MINIMAL + "title:\nsweep: ~\n", overrides=["device.ball_mass_kg=1e-3"])
    device = {f"device.{key}" for key in ("capsule_mass_kg", "ball_mass_kg", "restitution", "length_m")}
    excitation = {"excitation", "excitation.amplitude_n", "excitation.frequency_hz"}
    assert loaded.stated_keys == {"schema_version", "device", "inclination_deg"} | device | excitation


def test_hash_is_that_of_the_file(tmp_path):
    path = tmp_path / "s.yaml"
    for text in (GOOD, "\ufeff" + GOOD.replace("\n", "\r\n")):
        path.write_bytes(text.encode())
        assert load(path).sha256 == sha256(path.read_bytes()).hexdigest()


def test_hash_depends_on_overrides_and_their_order():
    sets = [[], ["title=a"], ["title=b"], ["title=a", "title=b"], ["title=b", "title=a"]]
    assert len({loads(GOOD, overrides=overrides).sha256 for overrides in sets}) == len(sets)
    assert loads(GOOD, overrides="title=a") == loads(GOOD, overrides=["title=a"])


def test_standard_input(monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(GOOD.replace("Good", "Caf\xe9").encode()), "ascii"))
    loaded = load("-")
    assert (loaded.scenario.title, loaded.document.name) == ("Caf\xe9", "<stdin>")


def test_name_in_messages_is_the_path_as_given(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("s.yaml").write_text("title: 3\n")
    with pytest.raises(ScenarioError, match=r"^s\.yaml:1: "):
        load("s.yaml")


def test_missing_file_names_one_like_it(tmp_path):
    (tmp_path / "inclined.yaml").write_text(GOOD)
    with pytest.raises(UsageError, match=r"no such file; did you mean '.*inclined\.yaml'\?$") as caught:
        load(tmp_path / "inclnied.yaml")
    assert caught.value.exit_code == 2
    with pytest.raises(UsageError, match=r"no such file$"):
        load(tmp_path / "other.yaml")


@pytest.mark.parametrize(
    ("name", "fragment"),
    [("", "is a folder"), ("no/s.yaml", "no such folder as"), ("a\0b", "cannot be read")],
)
def test_what_is_no_file(tmp_path, name, fragment):
    with pytest.raises(UsageError, match=fragment):
        load(tmp_path / name)


def test_file_that_may_not_be_read(monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr("builtins.open", refuse)
    with pytest.raises(UsageError, match="permission denied"):
        load("s.yaml")


def test_plain_data_is_complete_and_in_the_order_of_the_format():
    plain = to_dict(loads(MINIMAL).scenario)
    complete: dict[str, Any] = {
        "schema_version": 1,
        "title": None,
        "device": {
            "capsule_mass_kg": 0.1,
            "ball_mass_kg": None,
            "capsule": "prescribed",
            "friction": 0.0,
            "restitution": 0.5,
            "restitution_bottom": None,
            "restitution_top": None,
            "restitution_exponent": 0.0,
            "restitution_speed_m_s": None,
            "length_m": 1.0,
            "membrane": None,
        },
        "excitation": {"amplitude_n": 3.0, "frequency_hz": 2.0, "harmonics": [], "record": None},
        "inclination_deg": 0.0,
        "gravity_m_s2": 9.8,
        "period_ratio": 1,
        "sweep": None,
        "simulation": None,
        "motions": None,
        "tolerances": None,
        "record": None,
        "measured": None,
        "requirements": None,
        "effects": None,
        "design": None,
    }
    complete |= dict.fromkeys(added_keys())
    for path in keys_left_out(Scenario):
        *parents, key = path.split(".")
        (reduce(lambda block, name: block and block.get(name), parents, complete) or {}).pop(key, None)
    assert plain == complete
    assert list(plain) == [name for name in Scenario.model_fields if name in complete]
    assert list(to_dict(loads(GOOD).scenario)["sweep"]) == ["parameter", "from", "to"]


def test_loading_imports_no_other_package_and_nothing_heavy():
    code = (
        "import sys; from vireport.scenario.loading import load; load(sys.argv[1])\n"
        "modules = [name.split('.') for name in sys.modules if name.startswith('vireport.')]\n"
        "added = {name[3] for name in modules if name[1] == 'findings' and len(name) > 3}\n"
        "packages = {name[1] for name in modules} - {'findings'}\n"
        "print(sorted(packages), added <= {'keys'}, 'numpy' in sys.modules)"
    )
    command = [sys.executable, "-c", code, str(EXAMPLES / "horizontal.yaml")]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert printed == "['base', 'scenario', 'text'] True False\n"


PLAIN = """\
schema_version: 1
device: {capsule_mass_kg: 0.1, restitution: 0.5, length_m: 0.7}
excitation: {amplitude_n: 3, frequency_hz: 2}
inclination_deg: 45
"""
SWEPT = PLAIN + "sweep: {parameter: length_m, from: 0.6, to: 0.8}\n"
FALLING = PLAIN.replace("length_m", "restitution_exponent: -0.1, restitution_speed_m_s: 5, length_m")
SECOND = SWEPT.replace("frequency_hz: 2", "frequency_hz: 2, harmonics: [{order: 2, percent: 5, phase_deg: 0}]")


def with_empty(text: str, block: str) -> object:
    """The block with its defaults; None where the scenario cannot have it."""
    try:
        return getattr(loads(text, overrides=(f"{block}={{}}",)).scenario, block)
    except ScenarioError:
        return None


def test_blocks_that_have_defaults_are_those_that_may_be_empty() -> None:
    optional = {
        key.alias or name
        for name, key in Scenario.model_fields.items()
        if name != "device" and "Block" in str(key.annotation) and not key.is_required()
    }
    assert optional > set(ADDED_IF_FULL)
    known = {*ADDED_IF_FULL, "accuracy", "record"} & optional
    assert known <= {block for block in optional if with_empty(SWEPT, block) is not None} <= known | {*added_keys()}


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        SWEPT,
        SECOND,
        FALLING,
        SWEPT.replace("length_m: 0.7", "length_m: 0.7, friction: 0.01"),
        PLAIN + "sweep: {parameter: restitution, from: 0.3, to: 0.6}\n",
        SWEPT + "disturbances: {jitter_m_s: 0.01}\nmotions: {impacts: 3}\n",
    ],
)
def test_every_block_with_defaults_is_added_where_it_may_be_and_none_is_replaced(text: str) -> None:
    before = loads(text)
    after = with_default_blocks(before)
    assert value_at(after.scenario, "accuracy") is None
    for block in ADDED_IF_FULL:
        given, added = getattr(before.scenario, block), getattr(after.scenario, block)
        assert added == (given if given is not None else with_empty(text, block))
    assert after.document == before.document
    assert loads(text, overrides=after.overrides).scenario == after.scenario
