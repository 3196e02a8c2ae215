"""What to change: each value works by a run, and one halfway to it does not."""

from __future__ import annotations

import pytest
from conftest import EXAMPLES

from vireport.bench.changes import FALLS_SHORT, Change, changes
from vireport.scenario import load
from vireport.study import Study, analyse

CASES = {
    "not stable": ("device.length_m=0.6",),
    "margin": ("requirements.margin_any_percent=6",),
    "voltage": ("requirements.u_ave_at_least_v=44000",),
    "shaker": ("requirements.acceleration_at_most_g=2.3",),
    "membranes differ": (
        *("device.length_m=0.65", "device.restitution="),
        *("device.restitution_bottom=0.47", "device.restitution_top=0.5"),
    ),
}


def study_with(overrides: tuple[str, ...]) -> Study:
    return analyse(load(EXAMPLES / "inclined.yaml", ("sweep=", *overrides)), ())


@pytest.mark.parametrize("case", ["margin", *(pytest.param(x, marks=pytest.mark.slow) for x in CASES if x != "margin")])
def test_each_value_works_and_half_of_the_way_does_not(case: str) -> None:
    overrides = CASES[case]
    study = study_with(overrides)
    found = changes(study)
    assert found
    assert list(found) == sorted(found, key=lambda change: abs(change.percent))
    for change in found:
        (here,) = [
            float(study.solution.device.value_of(x)) for x in study.solution.device.inputs if x.path == change.path
        ]
        assert change.percent == pytest.approx(100 * (change.value / here - 1))
        assert _falls_short(overrides, change, change.value) is False
        assert _falls_short(overrides, change, (here + change.value) / 2) is True


def _falls_short(overrides: tuple[str, ...], change: Change, value: float) -> bool:
    return study_with((*overrides, f"{change.path}={value!r}")).verdict.conclusion in FALLS_SHORT


def test_a_design_that_works_needs_no_change() -> None:
    assert changes(study_with(())) is None


def test_without_a_design_point_nothing_can_be_changed() -> None:
    loaded = load(EXAMPLES / "inclined.yaml", ("device.length_m=", "sweep.from=0.5", "sweep.to=0.6"))
    assert changes(analyse(loaded, ())) is None


def test_where_no_single_input_helps_none_is_named() -> None:
    found = changes(study_with(("requirements.acceleration_at_most_g=1e-3", "requirements.u_ave_at_least_v=40000")))
    assert found == ()
