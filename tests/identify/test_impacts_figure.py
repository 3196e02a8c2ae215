"""The figures of an identification: errors of the times by membrane, or impacts where nothing fits; what was picked."""

from __future__ import annotations

from types import SimpleNamespace as Thing

import numpy as np
import pytest
from conftest import EXAMPLES
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from msgspec.structs import replace

from vireport import load
from vireport.identify import impacts_figure as impacts
from vireport.identify.impacts_figure import figure_errors, figure_phases, impacts_picture
from vireport.identify.record_figure import BOTTOM, TOP, figure_record
from vireport.measurement.flights import MeasuredImpacts
from vireport.measurement.identification import Fitted, NoFit, Unfit
from vireport.measurement.inquiry import Identification, Inquiry, inquiry_of
from vireport.measurement.misfit import Misfit
from vireport.measurement.picking import filtered
from vireport.measurement.records import Record
from vireport.measurement.screening import Screened
from vireport.measurement.signals import read_signals

COUNT, ORIGIN, ERROR = 40, 0.2, 1e-4
KEPT = np.delete(np.arange(COUNT), 7)
PANELS = ("top", -1.0), ("bottom", 1.0)
"""Of the figure, as the membranes stand."""

DRAWS = np.random.default_rng(5)
ERRORS = ERROR * DRAWS.standard_normal(len(KEPT))
RECORD = Record("taps.csv", 0.2 + 0.23 * np.arange(COUNT), np.where(np.arange(COUNT) % 3, 1.0, -1.0))


def answer(relative: np.ndarray | None = None) -> Identification:
    times = MeasuredImpacts.undoubted(RECORD.times - ORIGIN, RECORD.walls, relative)
    adjusted = Thing(errors=ERRORS, timing_error_s=ERROR)
    found = Fitted(adjusted, Screened(KEPT, np.ones(len(KEPT) - 1, dtype=bool), ()), times)
    model = Thing(device=Thing(frequency_hz=2.0))
    return Identification(Inquiry(model, (), ()), found, Misfit(1.0, 0.5, accepted=True), ORIGIN)


def drawn(figure: Figure) -> list[np.ndarray]:
    """The points of each panel; its other lines go across."""
    return [next(line.get_xydata() for line in axes.lines if line.get_marker() != "None") for axes in figure.axes]


def test_every_error_stands_at_the_time_of_its_impact_within_the_band_of_the_clock() -> None:
    figure = figure_errors(answer().fit, ORIGIN)
    for axes, points, (name, wall) in zip(figure.axes, drawn(figure), PANELS, strict=True):
        mine = RECORD.walls[KEPT] == wall
        np.testing.assert_allclose(points, np.column_stack([RECORD.times[KEPT][mine], 1e6 * ERRORS[mine]]))
        (band,) = axes.patches
        ends = band.get_patch_transform().transform(band.get_path().vertices)[:, 1]
        assert [ends.min(), ends.max()] == pytest.approx([-196, 196])
        assert {name, "95 %"} == {text.get_text() for text in axes.texts}
        assert axes.get_ylabel() == "error [µs]"
        assert axes.get_xlim()[0] < RECORD.times[0] < RECORD.times[-1] < axes.get_xlim()[1]


def test_errors_of_unequal_times_are_scaled_to_the_median_one() -> None:
    relative = np.where(np.arange(COUNT) % 2, 0.5, 2.0)
    top, _ = drawn(figure_errors(answer(relative).fit, ORIGIN))
    mine = RECORD.walls[KEPT] == -1.0
    np.testing.assert_allclose(top[:, 1], 1e6 * (ERRORS / relative[KEPT])[mine])


def test_where_nothing_fits_impacts_stand_at_their_phases(monkeypatch) -> None:
    figure = figure_phases(answer(), RECORD)
    for points, (_, wall) in zip(drawn(figure), PANELS, strict=True):
        times = RECORD.times[RECORD.walls == wall]
        np.testing.assert_allclose(points, np.column_stack([times, (times - ORIGIN) * 2.0 % 1]))
    monkeypatch.setattr(impacts, "MOST_DRAWN", 10)
    few = [points[:, 0].tolist() for points in drawn(figure_phases(answer(), RECORD))]
    assert few == [RECORD.times[RECORD.walls == wall][::4].tolist() for _, wall in PANELS]


@pytest.mark.slow
def test_it_is_told_by_what_it_shows() -> None:
    picture = impacts_picture(answer(), RECORD)
    assert picture.title == "Errors of the impact times"
    assert picture.caption.startswith("Measured less fitted times of 39 impacts. ")
    weighted = replace(RECORD, errors=np.ones(COUNT))
    assert ", scaled to the median standard error. " in impacts_picture(answer(np.ones(COUNT)), weighted).caption
    without = impacts_picture(replace(answer(), fit=NoFit(Unfit.NO_MOTION, 0.1)), RECORD)
    assert without.title == "Impacts within the period of the force"
    assert without.caption.startswith("All 40 impacts of taps.csv, as measured. ")
    assert "40 impacts" in without.alt


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
