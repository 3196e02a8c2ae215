"""What to change: each value works by a run, and one halfway to it does not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES
from msgspec.structs import replace

from vireport.bench.changes import Change, changes, may_work, rounded_away, works
from vireport.findings.outcomes.shock import LeastShock
from vireport.findings.outcomes.withstood import least_of
from vireport.scenario.loading import load
from vireport.scenario.parameters import DesignInput
from vireport.study.study import Study, analyse

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


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
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


def _meets(overrides: tuple[str, ...]) -> bool:
    other = study_with(overrides)
    return bool(other.solution.design.motions.stable_mask.any()) and all(line.passed for line in other.criteria)


def _falls_short(overrides: tuple[str, ...], change: Change, value: float) -> bool:
    return study_with((*overrides, f"{change.path}={value!r}")).verdict.fails


def test_a_value_is_rounded_away_from_the_design() -> None:
    rounded = [rounded_away(value, 0.6) for value in (0.6612345, 0.5512345, 0.6613, 0.0)]
    assert rounded == [0.6613, 0.5512, 0.6613, 0.0]


def test_a_run_tells_whether_a_value_works() -> None:
    study = study_with(("device.length_m=0.6",))
    assert not works(study, DesignInput.LENGTH, 0.62)
    assert works(study, DesignInput.LENGTH, 0.64)
    assert not works(study, DesignInput.LENGTH, -1.0)


@pytest.mark.parametrize(
    "overrides",
    [
        ("requirements.u_ave_at_least_v=44000",),
        ("requirements.deflection_at_most_m=0.019",),
        ("requirements.acceleration_at_most_g=2.3",),
        ("device.length_m=0.6",),
    ],
)
def test_arrays_tell_what_a_run_tells_of_motion_and_requirements(overrides: tuple[str, ...]) -> None:
    study, told = study_with(overrides), set()
    for varied in (DesignInput.LENGTH, DesignInput.AMPLITUDE):
        here = float(study.solution.device.value_of(varied))
        values = here * np.array([0.8, 0.95, 1.05, 1.2])
        kept = may_work(study, varied, values)
        assert kept.tolist() == [_meets((*overrides, f"{varied.path}={float(value)!r}")) for value in values]
        told |= set(kept.tolist())
    assert told == {False, True}


FALLING = "device.restitution_exponent=-0.05", "device.restitution_speed_m_s=5", "device.length_m=0.6"
UNLIKE = "device.restitution=", "device.restitution_bottom=0.5", "device.restitution_top=0.52"


@pytest.mark.slow
@pytest.mark.parametrize("over", [FALLING, (*UNLIKE, *FALLING)])
def test_of_a_restitution_that_falls_with_speed_the_nearest_motion_is_where_a_run_has_one(over) -> None:
    study = study_with(over)
    here = study.solution.device.length_m
    values = here * 2.0 ** (np.arange(1, 201) / 200)
    kept = np.flatnonzero(may_work(study, DesignInput.LENGTH, values))
    there = [_meets((*over, f"device.length_m={float(values[row])!r}")) for row in (kept[0] - 1, kept[0])]
    assert there == [False, True]
    assert len(kept) < 6
    assert not may_work(study, DesignInput.LENGTH, values[: kept[0]]).any()


@pytest.mark.slow
def test_what_to_change_is_found_of_a_restitution_that_falls_with_speed() -> None:
    """No change of up to 5 % helps; a fourth more of the frequency, a third more of the length or less angle do."""
    over = "device.restitution_exponent=-0.1", "device.restitution_speed_m_s=3", "device.length_m=0.5"
    found = changes(study_with(over))
    assert [change.path.rpartition(".")[2] for change in found] == ["frequency_hz", "length_m", "inclination_deg"]
    for change in found:
        assert _falls_short(over, change, change.value) is False
        assert 5 < abs(change.percent) < 40


@pytest.mark.slow
def test_shocks_are_searched_for_only_where_nothing_else_refuses_a_value(monkeypatch: pytest.MonkeyPatch) -> None:
    """At 2.9 N U_ave is 42.2 kV, too low whatever shocks do; at 3.1 N it is 43.5 kV, and the shock decides."""
    searches: list[float] = []
    jumps: list[float | None] = [None]

    def searched(*inputs: Any) -> LeastShock:
        searches.append(inputs[2])
        return replace(least_of(*inputs), jump=jumps[-1])

    monkeypatch.setattr("vireport.findings.outcomes.withstood.least_of", searched)
    overrides = "disturbances={}", "requirements.u_ave_at_least_v=43000", "requirements.survives_shock_m_s=0.1"
    study = study_with(overrides)
    for jump, survived in ((None, True), (1e-3, False)):
        searches.clear()
        jumps.append(jump)
        assert not works(study, DesignInput.AMPLITUDE, 2.9)
        assert not searches
        assert works(study, DesignInput.AMPLITUDE, 3.1) is survived
        assert len(searches) == 1


@pytest.mark.slow
def test_a_value_works_from_which_only_a_ramp_reaches_the_motion() -> None:
    """At 3.6 N the ball comes to 1:1 motion from all moments by a ramp of 20 periods, and not at once."""
    for periods, reached in ((0, False), (20, True)):
        loaded = load(EXAMPLES / "inclined-forcing.yaml", ("sweep=", f"disturbances={{ramp_periods: {periods}}}"))
        assert works(analyse(loaded, ()), DesignInput.AMPLITUDE, 3.6) is reached


def test_the_nearest_values_are_enough_where_enough_of_them_may_work(monkeypatch: pytest.MonkeyPatch) -> None:
    study = study_with(("requirements.u_ave_at_least_v=43000",))
    values = 3.03 * 1.05 ** (np.arange(1, 201) / 200)
    some = values[may_work(study, DesignInput.AMPLITUDE, values)]
    monkeypatch.setattr("vireport.bench.changes.FIRST_PART", len(values))
    every = values[may_work(study, DesignInput.AMPLITUDE, values)]
    assert 16 <= len(some) < len(every)
    assert (every[: len(some)] == some).all()


def test_of_no_values_with_harmonics_none_may_work() -> None:
    study = study_with(("device.length_m=0.6", "excitation.harmonics=[{order: 2, percent: 2, phase_deg: 10}]"))
    assert may_work(study, DesignInput.LENGTH, np.zeros(0)).tolist() == []


def test_a_design_that_works_needs_no_change() -> None:
    assert changes(study_with(())) is None


def test_without_a_design_point_nothing_can_be_changed() -> None:
    loaded = load(EXAMPLES / "inclined.yaml", ("device.length_m=", "sweep.from=0.5", "sweep.to=0.6"))
    assert changes(analyse(loaded, ())) is None


def test_where_no_single_input_helps_none_is_named() -> None:
    found = changes(study_with(("requirements.acceleration_at_most_g=1e-3", "requirements.u_ave_at_least_v=40000")))
    assert found == ()
