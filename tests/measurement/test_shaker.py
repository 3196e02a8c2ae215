"""The shaker's motion as it is fitted, held against the truth behind the signal."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sounds import clock, recording, ringing, signal

from vireport.base import UsageError
from vireport.measurement import ShakerMotion, shaker_motion

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
        (acceleration(np.random.default_rng(0), 2.0, 0.0)[:4000], 2.0, r"3\.99 periods of the force \(allowed: 10"),
        (acceleration(np.random.default_rng(0), 2.0, 0.0), 300.0, "samples in a period of the force"),
        (np.cos(2 * np.pi * 50 * clock(np.zeros(80_000), RATE)), 40.0, "strongest line is at 50 Hz"),
    ],
)
def test_what_is_not_its_motion_is_refused(values: Any, expected: float, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        fitted(values, expected)
