"""The shaker's motion as it is fitted, held against the truth behind the signal."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sounds import clock, recording, ringing, signal

from vireport import load
from vireport.base.errors import UsageError
from vireport.measurement.shaker import ShakerDoubt, ShakerFinding, ShakerMotion, shaker_findings, shaker_motion
from vireport.physics.device import Device

RATE, SECONDS, AMPLITUDE = 2000.0, 40.0, 24.1
HARMONICS = ((2, 3.0, 57.0), (3, 1.0, 229.0))


def acceleration(rng: np.random.Generator, frequency: float, phase: float) -> Any:
    x = 2 * np.pi * frequency * np.arange(int(RATE * SECONDS)) / RATE + phase
    return AMPLITUDE * (
        np.cos(x) + sum(percent / 100 * np.cos(order * x + np.radians(at)) for order, percent, at in HARMONICS)
    )


def fitted(values: Any, expected: float = 2.0) -> ShakerMotion:
    own = recording(RATE, acceleration_m_s2=values)
    return shaker_motion(own, own.channels[0], expected)


def turned(degrees: float) -> float:
    return (degrees + 180) % 360 - 180


def deviations(rng: np.random.Generator, coloured: bool) -> list[float]:
    """Errors of all that is fitted over their standard errors."""
    frequency, phase = 2 + rng.uniform(-0.05, 0.05), rng.uniform(0, 2 * np.pi)
    values = acceleration(rng, frequency, phase)
    noise = rng.standard_normal(len(values))
    if coloured:
        from scipy.signal import lfilter

        noise = lfilter([0.1], [1, -0.9], 3 * noise)
    times = np.sort(rng.uniform(1, SECONDS - 1, 150))
    struck = signal(times, rng.uniform(-200, 200, 150), SECONDS, lambda t: ringing(t, 400.0, 3e-3), RATE)
    found = fitted(values + 0.5 * noise + struck + 6.9)
    at = turned(np.degrees(2 * np.pi * frequency * found.maximum_s + phase))
    row = [
        (found.amplitude - AMPLITUDE) / found.amplitude_error,
        (found.frequency_hz - frequency) / found.frequency_error_hz,
        np.radians(at) / found.phase_error,
    ]
    for (_, percent, phase_deg), own in zip(HARMONICS, found.harmonics, strict=False):
        row += [(own.percent - percent) / own.percent_error, turned(own.phase_deg - phase_deg) / own.phase_error_deg]
    assert [own.order for own in found.harmonics if own.significant] == [2, 3]
    return row


def test_a_displacement_tells_the_acceleration_of_which_it_is_the_integral() -> None:
    frequency, phase = 2.017, 1.9
    omega = 2 * np.pi * frequency
    x = omega * np.arange(int(RATE * SECONDS)) / RATE + phase
    orders = ((1, 100.0, 0.0), *HARMONICS)
    path = sum(
        -percent / 100 * np.cos(order * x + np.radians(at)) / (order * omega) ** 2 for order, percent, at in orders
    )
    noise = 1e-6 * np.random.default_rng(5).standard_normal(len(x))
    placed = recording(RATE, displacement_m=AMPLITUDE * path + noise + 0.013)
    found = shaker_motion(placed, placed.channels[0], 2.0)
    assert found.amplitude == pytest.approx(AMPLITUDE, abs=5 * found.amplitude_error)
    assert 0 < found.amplitude_error < 1e-4 * AMPLITUDE
    assert turned(np.degrees(omega * found.maximum_s + phase)) == pytest.approx(
        0, abs=np.degrees(5 * found.phase_error)
    )
    for (order, percent, at), harmonic in zip(HARMONICS, found.harmonics, strict=False):
        assert harmonic.order == order
        assert harmonic.percent == pytest.approx(percent, abs=5 * harmonic.percent_error)
        assert 0 < harmonic.percent_error < 0.01 * percent
        assert turned(harmonic.phase_deg - at) == pytest.approx(0, abs=5 * harmonic.phase_error_deg)
    assert found.offset == 0.0
    assert list(shaker_findings(placed, found, scenario_device())) == []


def test_it_is_what_it_was_within_its_errors() -> None:
    assert np.abs(deviations(np.random.default_rng(3), coloured=True)).max() < 4


@pytest.mark.slow
@pytest.mark.parametrize("coloured", [True, False])
def test_errors_are_as_large_as_they_are_said_to_be(coloured: bool) -> None:
    rng = np.random.default_rng(1)
    off = np.array([deviations(rng, coloured) for _ in range(8)])
    # 56 numbers: their share within 95 % scatters by 2.9 %.
    assert np.mean(np.abs(off) < 1.96) > 0.88
    assert 0.8 < np.sqrt(np.mean(off**2)) < 1.25


def test_without_noise_it_is_exact() -> None:
    found = fitted(acceleration(np.random.default_rng(2), 2.0123, 1.0))
    assert found.amplitude == pytest.approx(AMPLITUDE, rel=1e-9)
    assert found.frequency_hz == pytest.approx(2.0123, rel=1e-11)
    for (_, percent, phase), own in zip(HARMONICS, found.harmonics, strict=False):
        assert own.percent == pytest.approx(percent, rel=1e-7)
        assert turned(own.phase_deg - phase) == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize(
    ("values", "expected", "message"),
    [
        (acceleration(np.random.default_rng(0), 2.5, 0.0), 2.0, r"strongest line is at 2\.498 Hz"),
        (acceleration(np.random.default_rng(0), 2.0, 0.0)[:100], 2e-5, r"0 periods of the force \(allowed: 10"),
        (acceleration(np.random.default_rng(0), 2.0, 0.0)[:4000], 2.0, r"3\.99 periods of the force \(allowed: 10"),
        (acceleration(np.random.default_rng(0), 2.0, 0.0), 300.0, "samples in a period of the force"),
        (np.cos(2 * np.pi * 50 * clock(np.zeros(80_000), RATE)), 40.0, "strongest line is at 50 Hz"),
    ],
)
def test_what_is_not_its_motion_is_refused(values: Any, expected: float, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        fitted(values, expected)


def scenario_device(**over: float) -> Device:
    """A device with the amplitude of the records, tilted so that gravity shows in a constant acceleration."""
    known = {"capsule_mass_kg": 0.1245, "length_m": 0.7, "inclination_deg": 45.0, "frequency_hz": 2.0}
    blocks = {"schema_version": 1, "device": {"restitution": 0.5}, "excitation": {"amplitude_n": AMPLITUDE * 0.1245}}
    for key, value in (known | over).items():
        place = blocks if key == "inclination_deg" else blocks["excitation" if key in OF_FORCE else "device"]
        place[key] = value
    return Device.of(load(blocks).scenario)


OF_FORCE = "frequency_hz", "amplitude_n", "harmonics"
ALONG = 9.8 * np.sqrt(0.5)


def doubts(values: Any, device: Device) -> list[ShakerFinding]:
    own = recording(RATE, acceleration_m_s2=values)
    return list(shaker_findings(own, shaker_motion(own, own.channels[0], 2.0), device))


def shaken_sine(noise: float = 0.02) -> Any:
    rng = np.random.default_rng(5)
    values = acceleration(rng, 2.0, 0.7)
    return values + noise * rng.standard_normal(len(values))


@pytest.mark.parametrize("factor", [9.81, 1 / 9.81, 1000.0, 1e-3])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_record_in_another_unit_fits_with_its_factor(factor: float, sign: int) -> None:
    (found,) = doubts((shaken_sine() + sign * ALONG) / factor, scenario_device())
    assert (found.doubt, found.value) == (ShakerDoubt.FACTOR, sign * factor)
    assert found.recorded == pytest.approx(AMPLITUDE / factor, rel=1e-3)
    assert found.stated == pytest.approx(AMPLITUDE)


@pytest.mark.parametrize(("newton", "doubted"), [(1.2, False), (0.8, False), (2.0, True), (0.4, True)])
def test_a_force_that_is_another_is_told_with_its_ratio(newton: float, doubted: bool) -> None:
    found = doubts(shaken_sine(), scenario_device(amplitude_n=newton * AMPLITUDE * 0.1245))
    assert [own.doubt for own in found] == [ShakerDoubt.FORCE] * doubted
    assert all(own.value == pytest.approx(newton, rel=1e-3) for own in found)


def test_a_reversed_axis_shows_in_the_even_harmonics_that_the_scenario_says() -> None:
    device = scenario_device(harmonics=[{"order": n, "percent": p, "phase_deg": at} for n, p, at in HARMONICS])
    assert doubts(shaken_sine(), device) == []
    (found,) = doubts(-shaken_sine(), device)
    assert (found.doubt, found.value) == (ShakerDoubt.REVERSED, -1.0)


def test_single_samples_far_from_all_others_are_told_with_their_times() -> None:
    values, own = shaken_sine(), scenario_device()
    assert doubts(values, own) == []
    rows = [12_345, 40_000]
    values[rows] += [3.0, -2.5]  # a tenth of the amplitude is 2.4
    found = doubts(values, own)
    assert [row.doubt for row in found] == [ShakerDoubt.LONE] * 2
    assert [row.at_s for row in found] == pytest.approx([row / RATE for row in rows])
    assert [row.recorded for row in found] == pytest.approx(values[rows])
    assert [row.value for row in found] == pytest.approx([3.0, 2.5], abs=0.1)
    assert all(0.05 < row.stated < 0.2 for row in found)  # the largest of 80,000 normal samples is at 4.5 deviations


def test_impacts_on_the_capsule_are_no_single_samples() -> None:
    rng = np.random.default_rng(7)
    times = np.sort(rng.uniform(1, SECONDS - 1, 150))
    struck = signal(times, rng.uniform(-200, 200, 150), SECONDS, lambda t: ringing(t, 400.0, 3e-3), RATE)
    assert doubts(shaken_sine() + struck, scenario_device()) == []


@pytest.mark.parametrize("step", [0.0, 0.01, 0.5, 2.0])
def test_clipping_is_told_from_coarse_steps(step: float) -> None:
    values, own = shaken_sine(noise=0.0), scenario_device()
    coarse = np.round(values / step) * step if step else values
    assert doubts(coarse, own) == []
    if step > 1:
        return  # so coarse that the crest of a sine is as flat as what cuts it off
    cut = np.clip(coarse, -0.8 * AMPLITUDE, 0.9 * AMPLITUDE)
    (found,) = doubts(cut, own)
    assert found.doubt is ShakerDoubt.CLIPPED
    assert found.value == pytest.approx(np.mean((cut == cut.max()) | (cut == cut.min())))
