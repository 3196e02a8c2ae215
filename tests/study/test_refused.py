"""What knows a sine alone, no friction or constant restitutions is refused with the key's name before work begins."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from vireport import load
from vireport.base.errors import ScenarioError, UsageError
from vireport.cli.app import program
from vireport.scenario.loading import load_any


class Refused(NamedTuple):
    """A key, and what gives it: as an override, or as a part of the device or of the excitation."""

    key: str
    over: dict[str, object]
    device: str = ""
    excitation: str = ""


KEYS = [
    Refused(
        "excitation.harmonics",
        {"excitation.harmonics": [{"order": 2, "percent": 2.0, "phase_deg": 225.0}]},
        excitation=", harmonics: [{order: 2, percent: 1, phase_deg: 0}]",
    ),
    Refused("device.friction", {"device.friction": 0.05}, device=", friction: 0.1"),
    Refused(
        "device.restitution_exponent",
        {"device.restitution_exponent": -0.1, "device.restitution_speed_m_s": 2.0},
        device=", restitution_exponent: -0.1, restitution_speed_m_s: 2.0",
    ),
]


def written(given: Refused, path: Path, device: str, more: str) -> Path:
    path.write_text(
        f"schema_version: 1\ndevice: {{capsule_mass_kg: 0.1, restitution: 0.5{device}{given.device}}}\n"
        f"excitation: {{amplitude_n: 3, frequency_hz: 2{given.excitation}}}\n{more}"
    )
    return path


@pytest.mark.parametrize("given", KEYS, ids=lambda given: given.key)
def test_a_map_and_a_search_are_refused_with_the_key(given: Refused, example, tmp_path) -> None:
    with pytest.raises(ScenarioError, match=given.key):
        load(example("best-design"), given.over)
    axes = "{path: device.length_m, from: 0.5, to: 1, count: 4}, {path: inclination_deg, from: 0, to: 45, count: 3}"
    with pytest.raises(ScenarioError, match=given.key):
        load_any(written(given, tmp_path / "map.yaml", "", f"map: {{axes: [{axes}]}}\n"))


@pytest.mark.parametrize("given", KEYS, ids=lambda given: given.key)
@pytest.mark.parametrize(
    "command",
    [
        ["map", "--over", "length_m,inclination_deg"],
        ["verify"],
        ["verify", "--extremes"],
        ["run", "--certify", "--json"],
        ["optimise"],
    ],
    ids=lambda command: command[0],
)
def test_commands_refuse_it(command: list[str], given: Refused, tmp_path) -> None:
    design = "design: {vary: [{path: device.length_m, from: 0.6, to: 0.8}], maximise: margin_percent}\n"
    more = "inclination_deg: 30\n" + design * (command[0] == "optimise")
    path = written(given, tmp_path / "s.yaml", ", length_m: 0.7", more)
    with pytest.raises((UsageError, ScenarioError), match=given.key):
        program()([command[0], str(path), *command[1:]], standalone_mode=False)
