"""What a part of a device refuses by its key's name before work begins, and that a part of no size changes nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from conftest import EXAMPLES

from vireport import load
from vireport.base.errors import ScenarioError, UsageError
from vireport.cli.app import program
from vireport.design.compliant.own_stiffness import own_stiffness
from vireport.findings.accuracy.workprecision import measure
from vireport.findings.certificates.proofs import certify
from vireport.findings.membranes.compliance import compliance
from vireport.findings.outcomes.outcomes import switched_on_by
from vireport.findings.outcomes.withstood import withstood_by
from vireport.findings.tolerances.proof import prove_region
from vireport.findings.tolerances.region import region_of
from vireport.map.chart.over import plane_of
from vireport.motions.atlas.families import atlas
from vireport.motions.switching import Limits
from vireport.scenario.loading import load_any
from vireport.scenario.parameters import DesignInput
from vireport.study.plan import Task, plan
from vireport.study.study import Study, analyse


class Refused(NamedTuple):
    """A key, what gives it: as an override, or as a part of the device or of the excitation; and what knows it not."""

    key: str
    over: dict[str, object]
    unknown: str
    device: str = ""
    excitation: str = ""


KEYS = [
    Refused(
        "excitation.harmonics",
        {"excitation.harmonics": [{"order": 2, "percent": 2.0, "phase_deg": 225.0}]},
        "certify proof compliance measure plane",
        excitation=", harmonics: [{order: 2, percent: 1, phase_deg: 0}]",
    ),
    Refused(
        "device.friction",
        {"device.friction": 0.05},
        "atlas certify region compliance measure stiffness plane",
        device=", friction: 0.1",
    ),
    Refused(
        "device.restitution_exponent",
        {"device.restitution_exponent": -0.1, "device.restitution_speed_m_s": 2.0, "sweep": None, "motions": None},
        "region withstood compliance measure stiffness switched",
        device=", restitution_exponent: -0.1, restitution_speed_m_s: 2.0",
    ),
]

UNLIKE = {"device.restitution": None, "device.restitution_bottom": 0.475, "device.restitution_top": 0.5}
LOOKED_FOR = load(EXAMPLES / "inclined.yaml", {"disturbances": {}}).scenario.disturbances
CALLS: dict[str, Callable[[Study], object]] = {
    "atlas": lambda study: atlas(study.solution.sweep, Limits(4, 2)),
    "certify": lambda study: certify(study.solution.diagram),
    "compliance": lambda study: compliance(study.solution, (1.0,)),
    "measure": lambda study: measure(study.solution, 1),
    "plane": lambda study: plane_of(study.scenario, "length_m,inclination_deg"),
    "proof": lambda study: prove_region(region_of(study.solution.device, {DesignInput.LENGTH: 0.01})),
    "region": lambda study: region_of(study.solution.device, {DesignInput.LENGTH: 0.01}),
    "stiffness": lambda study: own_stiffness(study.solution),
    "switched": lambda study: switched_on_by(study.solution, LOOKED_FOR),
    "withstood": lambda study: withstood_by(study.solution, True, 0.0, 0.0, None),
}


@pytest.mark.parametrize("given", KEYS, ids=lambda given: given.key)
def test_what_is_called_from_python_refuses_as_well(given: Refused, example) -> None:
    study = analyse(load(example("inclined"), given.over), (Task.JSON,))
    for name in given.unknown.split():
        with pytest.raises(UsageError, match=r"with friction|with harmonics|falls with speed"):
            CALLS[name](study)


@pytest.mark.parametrize(
    "nothing",
    [
        {"device.friction": 0.0},
        {"excitation.harmonics": [{"order": 2, "percent": 0.0, "phase_deg": 225.0}]},
        {"device.restitution_exponent": 0.0},
        {"device.restitution_exponent": 0.0, "device.restitution_speed_m_s": 2.0},
        {**UNLIKE, "device.restitution_bottom": 0.5},
    ],
)
def test_a_part_of_no_size_changes_nothing(nothing: dict[str, object], example) -> None:
    """To the last bit, but for the scenario itself."""
    plain, same = (analyse(load(example("inclined"), over), (Task.JSON,)).to_dict() for over in ({}, nothing))
    for of_input in ("scenario", "overrides"):
        del plain[of_input], same[of_input]
    assert plain == same


def test_the_symmetric_family_alone_is_left_out_of_a_run_and_why(example) -> None:
    scenario = load(example("horizontal"), {**UNLIKE, "accuracy.repeats": 1}).scenario
    why = {step.task: step.why for step in plan(scenario).left_out}
    assert why[Task.SYMMETRIC] == "the restitutions of both membranes differ: no motion is symmetric"
    of_both = {Task.BRANCHES, Task.DESIGN, Task.FROM_REST, Task.OWN_STIFFNESS, "accuracy", "compliant"}
    assert not of_both & set(why)


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
