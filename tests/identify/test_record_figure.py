"""The picture of what was picked from raw signals: every impact where it was, by its time and its phase."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import EXAMPLES
from matplotlib.colors import to_hex

from vireport import load
from vireport.identify.record_figure import BOTTOM, TOP, figure_record
from vireport.measurement.inquiry import inquiry_of
from vireport.measurement.picking import filtered
from vireport.measurement.signals import read_signals

LOOKS = {1.0: BOTTOM, -1.0: TOP}


def test_every_impact_stands_at_its_time_phase_and_height() -> None:
    signals = read_signals(
        str(EXAMPLES / "records/prototype.wav"), inquiry_of(load(EXAMPLES / "measured.yaml").scenario, [], False)
    )
    own, shaker = signals.picked, signals.shaker
    stretch, beginnings, acceleration, raster = figure_record(signals).axes[-4:]
    stretch, raster, beginnings, acceleration = sorted(
        (stretch, raster, beginnings, acceleration), key=lambda axes: axes.get_title(loc="left")
    )
    for wall, look in LOOKS.items():
        (line,) = [line for line in raster.lines if to_hex(line.get_color()).upper() == look["color"]]
        mine = own.walls == wall
        phases = (own.times[mine] - shaker.maximum_s) * own.frequency_hz % 1
        np.testing.assert_allclose(line.get_xydata(), np.column_stack([own.times[mine], phases]), atol=1e-12)
    (heard,) = own.heard
    signal = filtered(own.recording, heard.channel, own.frequency_hz)
    levels = [line.get_ydata()[0] for line in stretch.lines if len(set(line.get_ydata())) == 1]
    assert sorted(levels)[:: len(levels) - 1] == pytest.approx([-heard.least, heard.least])
    low, high = stretch.get_xlim()
    assert high - low == pytest.approx(4 / own.frequency_hz)
    drawn = stretch.lines[0].get_xydata()
    rows = np.round(drawn[:, 0] / own.recording.step_s).astype(int)
    np.testing.assert_allclose(drawn[:, 1], signal[rows])
    for line in beginnings.lines[:-1]:
        after = line.get_xydata()[line.get_xdata() > 0]
        assert 0.5 < np.abs(after[:, 1]).max() < 2.0
    assert acceleration.get_ylabel() == "acceleration [m/s²]"
    fitted = acceleration.lines[1].get_xydata()
    expected = shaker.amplitude * np.cos(2 * np.pi * fitted[:, 0])
    np.testing.assert_allclose(fitted[:, 1], expected, atol=0.02)
