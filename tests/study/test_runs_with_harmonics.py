"""What a run does where the force has harmonics, and what refuses them before work begins."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from conftest import EXAMPLES
from msgspec.structs import replace
from pages import render_html

from vireport.base.errors import UsageError
from vireport.findings.tolerances.results import recheck
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.report.changes.quantities import ComparedScenario
from vireport.report.context import Report
from vireport.scenario.loading import load
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.study.plan import Task, plan
from vireport.study.provenance import provenance_of
from vireport.study.reading import read_results
from vireport.study.study import analyse

SECOND = {"excitation.harmonics": [{"order": 2, "percent": 2.0, "phase_deg": 225.0}]}
NOTHING = {"excitation.harmonics": [{"order": 2, "percent": 0.0, "phase_deg": 225.0}]}
NAMED = "excitation.harmonics"


@pytest.fixture(scope="module")
def distorted():
    over = SECOND | {
        "requirements": {"reached_from_rest": True, "withstands_distortion_percent": 1, "force_at_most_n": 3.1}
    }
    return analyse(load(EXAMPLES / "inclined.yaml", over), (Task.JSON, Task.HTML))


@pytest.mark.slow
def test_a_run_has_motions_margins_effects_and_what_comes_of_switching_on(distorted) -> None:
    data = json.loads(json.dumps(distorted.to_dict(), allow_nan=False))
    assert data["scenario"]["excitation"]["harmonics"] == SECOND["excitation.harmonics"]
    (point,) = [point for point in data["critical_points"] if point["kind"] == "period_doubling"]
    # Published theory has 2.6 % in frequency, which is 5.3 % in length: from 0.6295 m.
    assert point["sweep_value"] == pytest.approx(0.6627, abs=2e-4)
    design = data["design_point"]
    assert {row["order"] for row in design["distortion"]} == {2, 3}
    assert all(set(margin["derivatives_by_harmonic"]) >= {"2", "3"} for margin in design["margins"][:3])
    assert all(criterion["passed"] for criterion in data["requirements"]["criteria"])
    assert data["disturbances"]["from_rest"]["outcome"] == "reaches_1_1"
    assert data["own_stiffness"]["motion"]["stable"]
    assert {row["effect"] for row in data["effects"]["rows"]} >= {"second_harmonic", "membrane_stiffness"}
    reproduction = distorted.reproduction
    assert reproduction.same_impacts
    assert max(abs(reproduction.velocity_difference), abs(reproduction.phase_difference)) < 1e-6
    # What must drive the capsule is of the largest force.
    x = np.linspace(0, 2 * np.pi, 100_001)
    largest = 3 * np.abs(np.cos(x) + 0.02 * np.cos(2 * x + np.radians(225))).max()
    assert data["shaker"]["force_amplitude_n"] == pytest.approx(largest, rel=1e-8)


def test_the_least_further_harmonic_ends_what_is_left_of_the_margin(distorted) -> None:
    """On top of 2 % at 225 degrees: as much as is missing to the 3.85 % that end the sine's motion at 225.7."""
    least = next(row for row in distorted.solution.design.distortions if row.order == 2)
    assert least.share == pytest.approx(0.0385 - 0.02, abs=2e-4)


def test_an_even_harmonic_leaves_out_the_symmetric_family(example) -> None:
    why = {step.task: step.why for step in plan(load(example("horizontal"), SECOND).scenario).left_out}
    assert why[Task.SYMMETRIC] == "the force has an even harmonic: no motion is symmetric"
    odd = {"excitation.harmonics": [{"order": 3, "percent": 2.0, "phase_deg": 0.0}]}
    assert Task.SYMMETRIC not in {step.task for step in plan(load(example("horizontal"), odd).scenario).left_out}


def test_the_device_of_a_scenario_carries_its_harmonics(example) -> None:
    device = Device.of(load(example("inclined"), SECOND).scenario)
    assert device.harmonics == (Harmonic.of(2, 2.0, 225.0),)
    assert replace(device, harmonics=()) == Device.of(load(example("inclined")).scenario)


def test_results_with_harmonics_are_compared_and_read_again(distorted) -> None:
    """Also those of earlier versions, which have no such key."""
    data = json.loads(json.dumps(distorted.to_dict()))
    compared = ComparedScenario(read_results(data, "old.json"), False)
    assert compared.device.harmonics == distorted.solution.device.harmonics
    assert compared.d(Parameter.LENGTH, 0.7) == pytest.approx(distorted.solution.device.groups(Parameter.LENGTH, 0.7).d)
    del data["scenario"]["excitation"]["harmonics"]
    assert ComparedScenario(read_results(data, "old.json"), False).device.harmonics == ()


def test_tolerances_are_sampled_and_nothing_is_said_to_be_proved(example) -> None:
    over = SECOND | {"tolerances": {"length_percent": 1, "restitution_percent": 1, "samples": 256}}
    study = analyse(load(example("inclined"), over), (Task.JSON, Task.MARKDOWN))
    found = json.loads(json.dumps(study.to_dict(), allow_nan=False))["tolerances"]
    assert (found["answer"], found["proof"], found["boxes"], found["open_share"]) == ("undecided", None, 0, None)
    assert found["proof_not_known_of"] == NAMED
    assert (found["yield"]["stable"], found["worst"]) == (256, None)
    assert study.verdict.conclusion.name == "TOLERANCES_OPEN"
    with pytest.raises(UsageError, match="no proof over tolerances"):
        recheck(study.to_dict())
    plain = analyse(load(example("inclined"), over | NOTHING), (Task.JSON,)).to_dict()["tolerances"]
    assert (plain["answer"], plain["proof_not_known_of"]) == ("proved", None)


@pytest.mark.slow
def test_the_worst_device_has_the_mean_of_two_restitutions_that_are_off_together(example) -> None:
    """In the report as well, which has a row for each input with a tolerance."""
    over = SECOND | {
        "device.restitution": None,
        "device.restitution_bottom": 0.52,
        "device.restitution_top": 0.5,
        "tolerances": {"restitution": 0.02, "length_percent": 30, "samples": 64},
    }
    study = analyse(load(example("inclined"), over), (Task.JSON,))
    found, values = study.tolerances, study.tolerances.worst.values
    mean = (values[DesignInput.RESTITUTION_BOTTOM] + values[DesignInput.RESTITUTION_TOP]) / 2
    assert found.of_worst(DesignInput.RESTITUTION) == mean
    assert abs(mean - 0.51) == pytest.approx(0.02, rel=1e-9)
    assert found.of_worst(DesignInput.LENGTH) == values[DesignInput.LENGTH]
    page = render_html(Report(study, {}, provenance_of(study.loaded, "vireport run x.yaml")))
    (shown,) = re.findall(r"<td[^>]*>0\.49</td>\s*<td[^>]*>0\.53</td>\s*<td[^>]*>([^<]*)</td>", page.decode())
    assert float(shown) == pytest.approx(mean)
