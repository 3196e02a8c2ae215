"""Times that are rounded to a step: it is recognised, and taken for what it is, the error of the times."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import EXAMPLES, first
from scipy.special import stdtrit
from synthetic import device_of, truth

from vireport import load
from vireport.measurement.flights import Unknown
from vireport.measurement.identification import Fitted
from vireport.measurement.inquiry import answered, inquiry_of
from vireport.measurement.records import Record
from vireport.measurement.rounding import rounding_of
from vireport.simulation.events import Impact

EACH = Unknown.RESTITUTION_BOTTOM, Unknown.RESTITUTION_TOP


def irregular(seed: int = 1) -> np.ndarray:
    return np.cumsum(np.random.default_rng(seed).uniform(0.2, 0.4, 150))


@pytest.mark.parametrize("step", [1e-3, 1 / 3000, 2e-3, 1 / 1024])
@pytest.mark.parametrize("digits", [6, 9, 15])
def test_the_step_is_told_from_times_that_are_printed(step: float, digits: int) -> None:
    times = np.round(np.round(irregular() / step) * step + 0.1234567, digits)
    assert rounding_of(times).step_s == pytest.approx(step, rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_times_without_a_step_have_none(seed: int) -> None:
    times = irregular(seed)
    assert rounding_of(times) is None
    assert rounding_of(times[:10]) is None
    rounded = np.round(times, 3)
    rounded[100] += 3e-4
    found = rounding_of(rounded)  # nothing above that of the one time that is no multiple
    assert found is None or found.step_s < 4e-4


def test_few_flights_that_repeat_tell_no_step() -> None:
    assert rounding_of(np.cumsum(np.tile([0.5635, 0.4365], 40))) is None


def test_repetitions_are_counted() -> None:
    flights = np.concatenate([np.random.default_rng(0).integers(300, 600, 30), np.tile([600, 400], 40)])
    assert rounding_of(1e-3 * np.cumsum(flights)).repeated == pytest.approx(40, abs=1)
    assert rounding_of(1e-3 * np.cumsum(flights[:30])).repeated < 3


def rounded(step: float, length: float, **over: float):
    """What a record says of a device whose times are rounded to a step, and what is true."""
    device = device_of("inclined", device__length_m=length, **over)
    own = truth(device, 150, 0, Impact(1, 1.0, 0.3))
    times = np.round(own.times / step) * step
    given = {path.replace("__", "."): value for path, value in over.items()} | {"device.length_m": length}
    inquiry = inquiry_of(load(EXAMPLES / "inclined.yaml", given | {"device.restitution": 0.6}).scenario, [], False)
    return answered(inquiry, Record("rounded", times, own.walls), False)


CASES = [(1 / 3000, 0.7), (5e-4, 0.66), (1 / 3000, 0.3), (1e-4, 0.42), (1e-3, 0.72)]


@pytest.mark.parametrize("case", first(0, CASES))
def test_rounded_times_give_intervals_that_hold(case: tuple[float, float]) -> None:
    """Of a motion that settles to one that is repeated to the step, and of chaos."""
    step, length = case
    answer = rounded(step, length)
    assert isinstance(answer.fit, Fitted)
    assert answer.misfit.accepted
    assert (len(answer.fit.false), len(answer.fit.gaps)) == (0, 0)
    assert answer.rounding.step_s == pytest.approx(step)
    assert answer.timing_error_s == pytest.approx(step / np.sqrt(12), rel=0.6)
    own = answer.fit.adjusted
    for x in EACH:
        assert abs(own.model.value_of(x) - 0.5) < stdtrit(own.freedom, 0.999) * own.deviation_of(x)


@pytest.mark.slow
def test_times_with_larger_errors_are_not_changed() -> None:
    device = device_of("inclined", device__length_m=0.42)
    own = truth(device, 150, 0, Impact(1, 1.0, 0.3))
    times = own.times + 1e-4 * np.random.default_rng(3).standard_normal(len(own.times))
    inquiry = inquiry_of(load(EXAMPLES / "inclined.yaml", {"device.length_m": 0.42}).scenario, [], False)
    fine = np.round(times / 1e-5) * 1e-5
    assert rounding_of(fine).step_s == pytest.approx(1e-5)
    assert answered(inquiry, Record("fine", fine, own.walls), False).rounding is None
