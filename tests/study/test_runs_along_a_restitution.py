"""What a run has along a sweep of a restitution."""

from __future__ import annotations

import numpy as np
import pytest

from vireport.base.errors import UsageError
from vireport.figures.sweeps import figure_2
from vireport.findings.certificates.proofs import certify
from vireport.scenario.loading import loads
from vireport.scenario.parameters import Parameter
from vireport.study.plan import Task
from vireport.study.study import Study, analyse

TEXT = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5, length_m: 0.7}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
inclination_deg: 45.0
sweep: {parameter: restitution_bottom, from: 0.3, to: 0.8}
simulation: {samples: 5, starts: 1}
"""


@pytest.fixture(scope="module")
def study() -> Study:
    return analyse(loads(TEXT, "text"), (Task.JSON,))


def test_a_critical_point_of_the_sweep_is_the_margin_along_it(study: Study) -> None:
    design, (first, *_) = study.solution.design, study.solution.critical_points
    along = [margin for margin in design.margins if margin.parameter == Parameter.RESTITUTION_BOTTOM]
    assert [margin.point.label for margin in along].count(first.label) == 1
    (own,) = (margin for margin in along if margin.point.label == first.label)
    assert own.ends_stability
    assert own.sweep_value == pytest.approx(first.sweep_value, rel=1e-14)
    # The 5 % of restitution that doubles the period of a device that is a little shorter are nearly enough here.
    assert first.sweep_value == pytest.approx(0.46291282861384)


def test_every_motion_has_its_own_determinant_and_the_simulation_agrees(study: Study) -> None:
    data = study.to_dict()
    for branch in data["branches"]:
        r = np.array(branch["sweep_value"])
        np.testing.assert_allclose(branch["determinant"], (0.5 * r) ** 2, rtol=1e-14)
        np.testing.assert_allclose(branch["d"], branch["d"][0], rtol=1e-15)
        assert max(branch["error_bounds"]["sweep_value"]) < 1e-12
    assert data["simulation"]["passed"]
    assert data["simulation"]["orbits_checked"] > 1
    assert set(data["design_point"]["sweep_value"]) == {0.5}
    (part,) = data["stable_range"]
    assert part["to_beyond_sweep"]["sweep_value"] == pytest.approx(0.97108453099971)


def test_figures_are_drawn_over_the_restitution(study: Study) -> None:
    axes = figure_2(study).axes[-1]
    assert axes.get_xlabel() == "restitution at the bottom r_bottom [–]"
    low, high = axes.get_xlim()
    assert 0.29 - 0.01 < low < 0.3 < 0.8 < high < 0.82


def test_a_proof_is_refused_by_name(study: Study) -> None:
    with pytest.raises(UsageError, match="along a sweep of restitution_bottom a proof of critical points is not known"):
        certify(study.solution.diagram)


def test_the_mean_of_unlike_membranes_keeps_their_difference() -> None:
    text = TEXT.replace("restitution: 0.5", "restitution_bottom: 0.45, restitution_top: 0.55")
    study = analyse(
        loads(text.replace("parameter: restitution_bottom", "parameter: restitution"), "text"), (Task.JSON,)
    )
    data = study.to_dict()
    assert data["design_point"]["sweep_value"][0] == pytest.approx(0.5)
    for branch in data["branches"]:
        mean = np.array(branch["sweep_value"])
        np.testing.assert_allclose(branch["determinant"], (mean**2 - 0.05**2) ** 2, rtol=1e-13)
    assert data["simulation"]["passed"]
