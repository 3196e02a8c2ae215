"""Filters, resampling and peaks against SciPy, which takes as long to load as they to work."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, find_peaks, resample_poly, sosfilt

from vireport.measurement.filters import BLOCK, averaged, high_pass, peaks_of, resampled


@pytest.mark.parametrize("count", [1, 2, 3, BLOCK - 1, BLOCK, BLOCK + 1, 5000])
@pytest.mark.parametrize("cut", [1e-4, 1e-3, 0.1])
def test_a_high_pass_is_that_of_butterworth(count: int, cut: float) -> None:
    signal = np.random.default_rng(count).normal(size=count).cumsum()
    expected = sosfilt(butter(2, 2 * cut, "highpass", output="sos"), signal)
    assert high_pass(signal, cut) == pytest.approx(expected, rel=0, abs=1e-10 * np.abs(signal).max())


@pytest.mark.parametrize("count", [2, 11, 60])
@pytest.mark.parametrize("factor", [2, 3, 16])
def test_between_samples_a_signal_is_what_a_filter_of_its_band_gives(count: int, factor: int) -> None:
    signal = np.random.default_rng(factor).normal(size=count).cumsum()
    expected = resample_poly(signal, factor, 1, padtype="line")
    assert resampled(signal, factor) == pytest.approx(expected, rel=0, abs=1e-13 * np.abs(signal).max())


@pytest.mark.parametrize("count", [2, 5, 400])
@pytest.mark.parametrize("over", [1, 2, 3, 8])
def test_an_average_is_of_samples_to_both_sides(count: int, over: int) -> None:
    signal = np.random.default_rng(over).normal(size=count).cumsum()
    expected = uniform_filter1d(signal, over)
    assert averaged(signal, over) == pytest.approx(expected, rel=0, abs=1e-12 * np.abs(signal).max())


def test_of_equal_samples_the_middle_one_is_the_peak() -> None:
    rng = np.random.default_rng(3)
    for count in range(1, 60):
        signal = rng.integers(0, 4, count).astype(float)
        assert peaks_of(signal).tolist() == find_peaks(signal)[0].tolist()
