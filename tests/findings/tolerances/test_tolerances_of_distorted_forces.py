"""Tolerances where the force has harmonics: the yield is right, a failing device is found, and nothing is proved."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import EXAMPLES
from exact_device import ExactDevice
from mpmath import mp
from msgspec.structs import replace

from vireport import load
from vireport.base.errors import UsageError
from vireport.design.devices import devices_off, stable_motions
from vireport.design.point import design_point, motions_at
from vireport.findings.tolerances.proof import prove_region
from vireport.findings.tolerances.region import region_of
from vireport.findings.tolerances.tolerances import Answer, assess_tolerances, sample_steps
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions
from vireport.scenario.blocks import Distribution
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.events import BOTTOM, check_model, follow_one
from vireport.simulation.kernel import PHASE, VELOCITY

UNIFORM = Distribution.UNIFORM
FORCE = Harmonic.of(2, 2.0, 225.0), Harmonic.of(3, 1.0, 40.0)
WIDTHS = {
    DesignInput.LENGTH: 0.014,
    DesignInput.FREQUENCY: 0.02,
    DesignInput.RESTITUTION_BOTTOM: 0.02,
    DesignInput.RESTITUTION_TOP: 0.02,
}


def design(*harmonics: Harmonic) -> Device:
    return replace(Device.of(load(EXAMPLES / "design-point.yaml").scenario), harmonics=harmonics)


def one_of(devices: Device, row: int) -> Device:
    """One of many devices."""
    values = {varied: float(np.broadcast_to(devices.value_of(varied), 16)[row]) for varied in devices.inputs}
    r = devices.restitution
    return replace(design(*devices.harmonics).with_values(values), restitution=Restitutions(r.bottom[row], r.top[row]))


def test_harmonics_that_are_next_to_nothing_change_nothing() -> None:
    widths = {DesignInput.LENGTH: 0.084, DesignInput.RESTITUTION_BOTTOM: 0.02}
    plain, other = (
        assess_tolerances(design(*harmonics), widths, None, UNIFORM, 512)
        for harmonics in ((), (Harmonic(2, 1e-12, -1e-12),))
    )
    assert plain.sampled == other.sampled
    assert plain.sampled.stable < 512
    assert plain.worst.values == pytest.approx(other.worst.values, rel=1e-12)
    assert plain.worst.share == pytest.approx(other.worst.share, abs=1e-9)
    for name, percentiles in plain.ranges.items():
        assert other.ranges[name] == pytest.approx(percentiles, rel=1e-9)


@pytest.mark.slow
def test_the_worst_device_is_found_on_either_side_of_the_end_of_stable_motion() -> None:
    """The end is known to the last digit of a double."""
    device = design(*FORCE)
    (end,) = [x for x in design_point(device, None).endings() if x.parameter is DesignInput.LENGTH and x.distance < 0]
    within, beyond, far = (
        assess_tolerances(device, {DesignInput.LENGTH: -end.distance * factor}, None, UNIFORM, 256)
        for factor in (1 - 1e-9, 1 + 1e-6, 1.25)
    )
    assert (within.answer, within.worst, within.sampled.stable) == (Answer.UNDECIDED, None, 256)
    assert (beyond.answer, beyond.proof) == (Answer.REFUTED, None)
    assert beyond.worst.share == pytest.approx(1 - 1e-6, abs=1e-7)
    assert not beyond.provable
    # Of uniform lengths from 1.25 times the distance below to as much above, a tenth fails.
    assert far.sampled.stable == pytest.approx(0.9 * 256, abs=1)
    assert far.sampled.low < 0.9 < far.sampled.high
    with pytest.raises(UsageError, match="of a force with harmonics a proof over tolerances is not known"):
        prove_region(region_of(device, {DesignInput.LENGTH: 0.01}))


def test_a_failing_device_between_the_ends_is_found_though_these_work() -> None:
    """A window of lengths without stable motion lies between the design and the shorter end."""
    device = replace(
        design(Harmonic.of(2, 0.1, 90.0)), restitution=0.532, amplitude_n=5.012, inclination_deg=16.094, length_m=0.6
    )
    found = assess_tolerances(device, {DesignInput.LENGTH: 0.12}, None, UNIFORM, 256)
    ends = devices_off(device, {DesignInput.LENGTH: 0.12}, np.array([[-1.0, 0.0, 1.0]]))
    assert set(stable_motions(ends)[0]) == {0, 1, 2}
    assert found.answer is Answer.REFUTED
    worst = device.with_values(found.worst.values)
    assert not motions_at(worst, Parameter.LENGTH)[0].stable_mask.any()
    assert 0.5 < found.sampled.stable / 256 < 0.95
    # Stable motion ends first there: farther on all of the window lies.
    ends = (x.distance for x in design_point(device, None).endings() if x.parameter is DesignInput.LENGTH)
    end = max(x for x in ends if x < 0)
    assert found.worst.share * (found.worst.values[DesignInput.LENGTH] - 0.6) == pytest.approx(end, rel=1e-6)


def test_random_devices_are_those_of_40_digits() -> None:
    """Their motion and its trace, by the raw flights of each device for itself."""
    device = design(*FORCE)
    devices = devices_off(device, WIDTHS, sample_steps(len(WIDTHS), UNIFORM, 16))
    cell, orbit = stable_motions(devices)
    for row in (0, 7, 15):
        (k,) = np.flatnonzero(cell == row)
        one = one_of(devices, row)
        with mp.workdps(40):
            exact = ExactDevice(one)
            t0, up = float(orbit.phi[k]) / np.pi, 1 + 2 * float(orbit.u[k])
            guess = float(orbit.velocity_bottom[k]), float(orbit.velocity_top[k]), t0, t0 + up
            x = mp.findroot(exact.missed, guess, tol=1e-30)
            assert max(abs(a - b) for a, b in zip(x, guess, strict=True)) < 1e-12
            trace, determinant = exact.map_of(*x)
        assert abs(trace) < 1 + determinant  # both multipliers are within the unit circle
        stable = motions_at(one, Parameter.LENGTH)[0]
        assert float(trace) == pytest.approx(float(stable.trace[stable.stable_mask][0]), rel=1e-9)


@pytest.mark.slow
def test_random_devices_are_judged_as_each_is_by_itself() -> None:
    """Some of them with stable motion, others without."""
    device = design(*FORCE)
    widths = {varied: 3 * width for varied, width in WIDTHS.items()}
    devices = devices_off(device, widths, sample_steps(len(widths), UNIFORM, 16))
    cell, _ = stable_motions(devices)
    judged = [bool(motions_at(one_of(devices, row), Parameter.LENGTH)[0].stable_mask.any()) for row in range(16)]
    assert judged == [row in cell for row in range(16)]
    assert 2 < sum(judged) < 16


@pytest.mark.slow
def test_the_simulation_stays_on_the_motions_of_random_devices() -> None:
    device = design(*FORCE)
    devices = devices_off(device, {x: width / 3 for x, width in WIDTHS.items()}, sample_steps(4, UNIFORM, 16))
    cell, orbit = stable_motions(devices)
    cell, which = np.unique(cell, return_index=True)
    assert len(cell) == 16
    for row, k in zip(cell.tolist(), which.tolist(), strict=True):
        groups = one_of(devices, row).groups(Parameter.LENGTH, one_of(devices, row).length_m)
        speed, phase = float(orbit.velocity_bottom[k]), float(np.mod(orbit.phi[k], 2 * np.pi))
        start = (BOTTOM, 0.0, speed * (1 + 1e-5), phase)
        rows, _ = follow_one(check_model(groups)[0], start, 200, compiled=False)
        off = np.angle(np.exp(1j * (rows[-1, PHASE] - phase)))
        assert np.hypot(rows[-1, VELOCITY] / speed - 1, off) < 1e-6


def test_devices_with_other_harmonics_are_not_solved_together() -> None:
    with pytest.raises(ValueError, match="different harmonics"):
        Groups(np.ones(2), np.ones(2), 0.5, (Harmonic(2, np.array([0.1, 0.2]), 0.0),)).same_harmonics  # noqa: B018
