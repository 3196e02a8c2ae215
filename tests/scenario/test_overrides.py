"""Values set over those of a file: each where it belongs, by the same rules, mistakes under its name; its print."""

from __future__ import annotations

import pytest
from bad_scenarios import GOOD, MINIMAL

from vireport.base.errors import ScenarioError
from vireport.scenario.blocks import to_dict
from vireport.scenario.loading import loads
from vireport.scenario.parameters import DesignInput, Named
from vireport.text.formatting import ROUGHLY


def value_at(tree, path):
    for step in path.split("."):
        tree = tree[step]
    return tree


OVERRIDES = [
    ("device.restitution=0.6", "device.restitution", 0.6),
    (" inclination_deg =30", "inclination_deg", 30.0),
    ("device.membrane.bias_voltage_v=1e3", "device.membrane.bias_voltage_v", 1000.0),
    ("title='a=b: c'", "title", "a=b: c"),
    ("title=a=b", "title", "a=b"),
    ("title=", "title", None),
    ("title=yes", "title", "yes"),
    ("sweep={parameter: amplitude_n, from: 3, to: 6}", "sweep.parameter", "amplitude_n"),
    ("sweep=", "sweep", None),
    ("excitation={amplitude_n: 4, frequency_hz: 1}", "excitation.amplitude_n", 4.0),
]


@pytest.mark.parametrize(("override", "path", "value"), OVERRIDES)
def test_overrides(override, path, value):
    loaded = loads(GOOD, overrides=[override])
    assert value_at(to_dict(loaded.scenario), path) == value
    assert (path in loaded.stated_keys) is (value is not None)
    assert loaded.overrides == (override,)
    assert loaded.document == loads(GOOD).document


def test_blocks_are_made_for_overrides_as_needed():
    overrides = ["sweep.parameter=length_m", "sweep.from=0.5", "sweep.to=0.7", "device.length_m="]
    assert to_dict(loads(MINIMAL, overrides=overrides).scenario)["sweep"] == {
        "parameter": "length_m",
        "from": 0.5,
        "to": 0.7,
    }


def test_a_later_override_wins():
    loaded = loads(GOOD, overrides=["inclination_deg=wrong", "inclination_deg=10", "inclination_deg=20"])
    assert loaded.scenario.inclination_deg == 20


def test_overrides_as_a_mapping():
    loaded = loads(
        GOOD,
        overrides={
            "title": "caf\xe9: \U0001f600",
            "device.length_m": 1e-15,
            "sweep": None,
            "excitation": {"amplitude_n": 3, "frequency_hz": 2.5},
        },
    )
    assert loaded.scenario.title == "caf\xe9: \U0001f600"
    assert loaded.scenario.device.length_m == 1e-15
    assert loaded.scenario.sweep is None
    assert loads(GOOD, overrides=loaded.overrides) == loaded


BAD_OVERRIDES = [
    ("device.restitution=1.5", "device.restitution", "got 1.5, which is too large (a number from 0 to 1)"),
    ("device.restitution='0.5'", "device.restitution", "write 0.5, without quotes"),
    ("device.length_m=0,7", "device.length_m", "with a decimal point"),
    ("lenght_m=1", "lenght_m", "unknown key; did you mean 'device.length_m'?"),
    ("length_m=1", "length_m", "unknown key; did you mean 'device.length_m'?"),
    ("device.lenght_m=1", "device.lenght_m", "unknown key; did you mean 'length_m'?"),
    ("devcie.length_m=1", "devcie", "unknown key; did you mean 'device'?"),
    ("title.x=1", "title.x", "'title' is not a block of keys (nothing can be set in it; set title as a whole)"),
    ("device.length_m.x.y=1", "device.length_m.x.y", "'device.length_m' is not a block of keys"),
    ("device=", "device", "is empty (a block of keys: capsule_mass_kg"),
    ("device.restitution=[0.5", "device.restitution", "a '[' is opened here and not closed"),
    ("device.restitution=*a", "device.restitution", "aliases are not read, got *a"),
    ("device.restitution={a: 1, a: 2}", "device.restitution.a", "given twice"),
    ("device.restitution=0.5\x07", "device.restitution", "the invisible character U+0007"),
    ("sweep.points=9", "sweep.points", "unknown key (allowed in sweep: parameter, from, to)"),
    ("restitution", "restitution", "not of the form path=value (such as device.length_m=0.7)"),
    ("=1", "=1", "not of the form path=value"),
    ("device..length_m=1", "device..length_m=1", "not of the form path=value"),
    (".".join("a" * 100) + "=1", ".".join("a" * 100) + "=1", "not of the form path=value"),
]


@pytest.mark.parametrize(("override", "path", "fragment"), BAD_OVERRIDES)
def test_mistakes_in_overrides_name_the_override(override, path, fragment):
    with pytest.raises(ScenarioError) as caught:
        loads(GOOD, "s.yaml", [override])
    mistake = caught.value.mistakes[0]
    assert (mistake.line, mistake.path) == (0, path)
    assert fragment in mistake.message
    assert str(caught.value).startswith(f"--set {path}: ")


def test_mistakes_in_file_and_overrides_are_named_together():
    with pytest.raises(ScenarioError) as caught:
        loads(GOOD.replace("0.1245", "x"), "s.yaml", ["sweep.to=-1", "inclination_deg=91"])
    places = [(mistake.line, mistake.path) for mistake in caught.value.mistakes]
    assert places == [(0, "inclination_deg"), (0, "sweep.to"), (4, "device.capsule_mass_kg")]


def test_an_override_mends_a_value_of_the_file():
    assert loads(GOOD.replace(" 45", " 45°"), overrides=["inclination_deg=45"]).scenario.inclination_deg == 45


LENGTH, INCLINATION, RESTITUTION = DesignInput.LENGTH, DesignInput.INCLINATION, DesignInput.RESTITUTION


@pytest.mark.parametrize(
    ("varied", "label", "head"),
    [
        (LENGTH, "length s [m]", "length [m]"),
        (INCLINATION, "inclination β [°]", "inclination [°]"),
        (RESTITUTION, "restitution r [–]", "restitution"),
    ],
)
def test_an_axis_has_symbol_and_unit_and_a_column_the_unit(varied: Named, label: str, head: str) -> None:
    assert (varied.label, varied.head) == (label, head)


def test_a_place_is_stated_or_of_a_model() -> None:
    assert LENGTH.place(0.123456) == "s = 0.123456 m"
    assert LENGTH.place(0.123456, ROUGHLY) == "s = 0.12 m"
    assert INCLINATION.place(0.0) == "β = 0°"


@pytest.mark.parametrize(("distance", "text"), [(0.0123, "+0.012 m"), (-0.0123, "−0.012 m"), (0.0, "0 m")])
def test_a_distance_has_its_sign(distance: float, text: str) -> None:
    assert LENGTH.signed(distance, ROUGHLY) == text
