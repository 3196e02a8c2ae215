"""The figures: what is drawn is what the study says, and it can be read by everyone, everywhere, the same."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
from functools import cache
from io import BytesIO
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from vireport.figures.axes import along
from vireport.figures.curves import TURN, Simulated, eigenvalue_curves, phase_curve, stretches, visible
from vireport.figures.drawing import NO_MOTION
from vireport.figures.paper_figures import BRANCH_COLORS, figure_2, figure_4, figure_7, pictures
from vireport.figures.pixels import png_of
from vireport.figures.ticks import fitting_ticks, tick_labels, ticks, uneven_ticks
from vireport.physics.energy import Voltages
from vireport.scenario.loading import load
from vireport.study.study import Study, analyse

ROOT = Path(__file__).parent.parent
FIGURES = {"figure-2": figure_2, "figure-4": figure_4, "figure-7": figure_7}

DESCENDER = 4
"""Part of a letter's box below its foot, which is empty [px]."""

SWEPT = ("device.length_m=",)

# name: (example, overrides)
CASES: dict[str, tuple[str, tuple[str, ...]]] = {
    "horizontal": ("horizontal", ()),
    "inclined": ("inclined", ()),
    "inclined-forcing": ("inclined-forcing", ()),
    "wide": ("inclined", ("sweep.from=0.01", "sweep.to=3")),
    "horizontal-wide": ("horizontal", ("sweep.from=0.01", "sweep.to=3")),
    "forcing-wide": ("inclined-forcing", ("inclination_deg=0", "sweep.from=0.5", "sweep.to=60")),
    "frequency": ("inclined", ("sweep.parameter=frequency_hz", "sweep.from=1.5", "sweep.to=3")),
    "inclination": ("inclined", ("sweep.parameter=inclination_deg", "sweep.from=0", "sweep.to=90")),
    "empty": ("inclined", ("inclination_deg=80", "sweep.from=0.02", "sweep.to=0.1", "device.length_m=0.05")),
    "narrow": ("inclined", ("sweep.from=0.6934", "sweep.to=0.69341")),
    "lively": ("inclined", ("device.restitution=0.9", "inclination_deg=10", "sweep.from=0.05", "sweep.to=2")),
    "slow": ("inclined", ("period_ratio=3", "inclination_deg=5", "sweep.from=0.26", "sweep.to=6")),
    "small": ("horizontal", (*SWEPT, "sweep.from=2.6e-7", "sweep.to=7.5e-7", "excitation.amplitude_n=3e-6")),
    "large": ("horizontal", (*SWEPT, "sweep.from=2.6e8", "sweep.to=7.5e8", "excitation.amplitude_n=3e9")),
    "next": ("inclined", ("sweep.from=0.6934", "sweep.to=0.69340001")),
}  # fmt: skip


@cache
def study_of(name: str) -> Study:
    example, overrides = CASES[name]
    return analyse(load(ROOT / "examples" / f"{example}.yaml", overrides))


@cache
def figure_of(name: str, figure: str) -> Figure:
    return FIGURES[figure](study_of(name))


def curves(axes: matplotlib.axes.Axes) -> list[Line2D]:
    """The lines of a panel that show motions: neither markers, nor ticks, guides, bounds or leaders."""
    return [line for line in axes.lines if 2.1 < line.get_zorder() < 3 and line.get_linestyle() != "None"]


def vertices(lines: list[Line2D]) -> set[tuple[float, float]]:
    return {(float(x), float(y)) for line in lines for x, y in zip(*line.get_data(), strict=True) if x == x}


def letters(axes: matplotlib.axes.Axes) -> list[str]:
    return [text.get_text() for text in axes.texts if text.get_text() not in ("design", NO_MOTION)]


def rows(study: Study, admissible: bool) -> list[tuple[int, int]]:
    """Branches and rows inside stretches, without the ends that two stretches share."""
    return [
        (branch.number - 1, row)
        for branch in study.solution.branches
        for part in branch.segments()
        if part.admissible == admissible
        for row in range(part.first + 1, part.last)
    ]


# What is drawn


def test_the_plan_decides_which_are_drawn() -> None:
    assert [picture.name for picture in pictures(study_of("inclined"))] == [
        "figure-2",
        "figure-4",
        "figure-7",
    ]
    path = ROOT / "examples" / "inclined.yaml"
    without_mass = load(path, ("device.ball_mass_kg=", "device.membrane="))
    assert [picture.name for picture in pictures(analyse(without_mass))] == ["figure-2", "figure-4"]
    assert pictures(analyse(load(path), ["json", "csv"])) == ()
    assert pictures(analyse(load(ROOT / "examples" / "design-point.yaml"))) == ()


def test_without_a_sweep_there_is_nothing_to_draw() -> None:
    with pytest.raises(ValueError, match="along a sweep"):
        figure_2(analyse(load(ROOT / "examples" / "design-point.yaml")))


@pytest.mark.parametrize("name", ["wide", "horizontal-wide", "lively", "frequency"])
def test_only_admissible_motions_are_drawn(name: str) -> None:
    study = study_of(name)
    velocity, _, flight = figure_of(name, "figure-2").axes
    (voltage,) = figure_of(name, "figure-7").axes
    drawn = [vertices(curves(panel)) for panel in (velocity, flight, voltage)]
    unit = 1e3  # kV
    for admissible in (True, False):
        for index, row in rows(study, admissible):
            motions, volts = study.solution.branches[index].motions, study.solution.branches[index].voltages
            x = float(motions.d[row])
            expected = (
                ((x, float(abs(motions.velocity_bottom[row]))), (x, float(abs(motions.velocity_top[row])))),
                ((x, float(motions.q[row])), (x, float(1 - motions.q[row]))),
                tuple((x, float(v[row] / unit)) for v in (volts.average_v, volts.bottom_v, volts.top_v)),
            )
            for found, wanted in zip(drawn, expected, strict=True):
                assert all((point in found) == admissible for point in wanted)


def test_there_are_inadmissible_motions_to_leave_out() -> None:
    assert all(rows(study_of(name), False) for name in ("wide", "horizontal-wide", "lively"))


@pytest.mark.parametrize("name", ["horizontal", "inclined", "wide", "lively"])
def test_stable_motions_are_solid_and_unstable_ones_broken(name: str) -> None:
    study = study_of(name)
    velocity = figure_of(name, "figure-2").axes[0]
    drawn = {
        style: vertices([c for c in curves(velocity) if (c.get_linestyle() == "-") == style]) for style in (True, False)
    }
    for part in stretches(study.solution):
        motions, row = part.branch.motions, (part.rows.start + part.rows.stop) // 2
        if row in (part.rows.start, part.rows.stop - 1):
            continue
        point = (float(motions.d[row]), float(abs(motions.velocity_bottom[row])))
        assert point in drawn[part.stable]
        assert point not in drawn[not part.stable]


@pytest.mark.parametrize("name", ["horizontal", "inclined-forcing", "wide", "slow"])
@pytest.mark.parametrize("figure", ["figure-2", "figure-4"])
def test_every_critical_point_is_lettered_once_in_each_panel(name: str, figure: str) -> None:
    study = study_of(name)
    labels = sorted(point.label for point in study.solution.critical_points)
    for k, panel in enumerate(figure_of(name, figure).axes):
        if figure == "figure-2":
            assert sorted(letters(panel)) == labels
        else:  # some are off the axes, but never those that decide stability
            kinds = {point.label: point.kind for point in study.solution.critical_points}
            assert len(set(letters(panel))) == len(letters(panel))
            off = set(labels) - set(letters(panel))
            assert {kinds[label] for label in off} <= {"grazing"}, k


@pytest.mark.parametrize("name", ["horizontal", "wide", "lively", "inclination"])
def test_markers_stand_on_their_curves(name: str) -> None:
    velocity = figure_of(name, "figure-2").axes[0]
    on_curves = vertices(curves(velocity))
    for line in velocity.lines:
        if line.get_marker() in ("o", "s", "D", "d", "^"):
            assert vertices([line]) <= on_curves


@pytest.mark.parametrize("name", ["horizontal", "wide", "lively", "small", "large", "narrow", "next"])
@pytest.mark.parametrize("figure", ["figure-2", "figure-7"])
def test_the_axes_hold_the_data(name: str, figure: str) -> None:
    for panel in figure_of(name, figure).axes:
        (left, right), (low, high) = panel.get_xlim(), panel.get_ylim()
        assert all(left < x < right and low < y < high for x, y in vertices(curves(panel)))


@pytest.mark.parametrize("name", ["horizontal", "wide", "lively", "slow"])
def test_figure_4_is_cut_at_its_limits(name: str) -> None:
    panels = figure_of(name, "figure-4").axes
    for panel, bounds in zip(panels, ((0.0,), (-1.0, 0.0, 1.0)), strict=True):
        low, high = panel.get_ylim()
        assert all(low <= y <= high for _, y in vertices(curves(panel)))
        levels = [line.get_ydata()[0] for line in panel.lines if line.get_zorder() == 1.5]
        assert sorted(levels) == sorted(bounds)
        assert low < bounds[0]
        assert bounds[-1] < high


def test_figure_4_is_thicker_where_the_eigenvalues_are_complex() -> None:
    panel = figure_of("horizontal", "figure-4").axes[1]
    widths = {line.get_linewidth() for line in curves(panel)}
    thick = vertices([line for line in curves(panel) if line.get_linewidth() == max(widths)])
    r = 0.5
    assert len(widths) == 2
    assert max(abs(y) for _, y in thick) == pytest.approx(r * r)


def test_figure_4_draws_mirror_images_once() -> None:
    study = study_of("horizontal")
    numbers = {part.branch.number for part in stretches(study.solution) if part.branch.mirror_of is None}
    drawn = {line.get_color() for line in curves(figure_of("horizontal", "figure-4").axes[1])}
    assert drawn == set(BRANCH_COLORS[: len(numbers)])


@pytest.mark.parametrize("name", ["horizontal", "lively", "slow", "horizontal-wide"])
def test_phases_never_jump(name: str) -> None:
    panel = figure_of(name, "figure-2").axes[1]
    for line in curves(panel):
        y = np.asarray(line.get_ydata())
        assert np.nanmax(np.abs(np.diff(y))) < np.pi
        assert np.nanmin(y) >= 0
        assert np.nanmax(y) <= TURN


def test_a_phase_that_passes_a_full_turn_is_cut_there() -> None:
    upward = phase_curve(np.array([0.0, 1.0, 2.0]), np.array([6.0, 6.2, 0.2]))
    (x1, y1), (x2, y2) = upward
    assert (y1[-1], y2[0]) == (TURN, 0.0)
    assert x1[-1] == x2[0] == pytest.approx(1 + (TURN - 6.2) / (0.2 + TURN - 6.2))
    (x1, y1), (x2, y2) = phase_curve(np.array([0.0, 1.0]), np.array([0.1, 6.2]))
    assert (y1[-1], y2[0]) == (0.0, TURN)
    assert x1[-1] == x2[0]
    assert len(phase_curve(np.arange(3.0), np.array([0.1, 3.0, 6.0]))) == 1


def test_curves_are_cut_where_they_leave() -> None:
    x, y = np.arange(6.0), np.array([5.0, 1.0, 0.0, -3.0, 0.5, 0.5])
    parts = visible((x, y), -1.0, 2.0)
    assert [list(part[1]) for part in parts] == [[2.0, 1.0, 0.0, -1.0], [-1.0, 0.5, 0.5]]
    assert parts[0][0][0] == pytest.approx(0.75)
    assert visible((x, np.full(6, 9.0)), -1.0, 2.0) == []


@pytest.mark.parametrize("figure", list(FIGURES))
def test_an_empty_sweep_says_so_in_every_panel(figure: str) -> None:
    assert not rows(study_of("empty"), True)
    for panel in figure_of("empty", figure).axes:
        assert NO_MOTION in [text.get_text() for text in panel.texts]
        assert not curves(panel)
    assert "no admissible 1:1 motion" in pictures(study_of("empty"))[0].alt


def test_the_design_point_is_marked() -> None:
    study = study_of("inclined")
    for panel in figure_of("inclined", "figure-2").axes:
        marks = [line for line in panel.lines if line.get_marker() == "P"]
        at = np.concatenate([line.get_xdata() for line in marks])
        np.testing.assert_allclose(at, study.solution.design.motions.d[0], rtol=1e-12)
        filled = [line for line in marks if line.get_markerfacecolor() != "white"]
        assert len(filled) == 2
    assert [text.get_text() for text in figure_of("inclined", "figure-2").axes[0].texts].count("design") == 1
    outside = analyse(load(ROOT / "examples" / "inclined.yaml", ("device.length_m=0.8",)))
    assert "design" not in [text.get_text() for text in figure_2(outside).axes[0].texts]


def test_simulated_motions_are_drawn_over() -> None:
    d = np.array([0.42, 0.45, 0.48])
    speed, phase, flight = np.full(3, 0.9), np.full(3, 0.5), np.full(3, 0.6)
    volts = Voltages(np.full(3, 4e4), np.full(3, 3e4), np.full(3, 3.5e4), np.full(3, 0.01))
    simulated = Simulated(d / 0.664, d, speed, -speed / 2, phase, phase + 3, flight, 1 - flight, volts)
    study = study_of("inclined")
    for panel in figure_2(study, simulated).axes:
        circles = [line for line in panel.lines if line.get_zorder() == 3.5]
        assert [len(line.get_xdata()) for line in circles] == [3, 3]
    (panel,) = figure_7(study, simulated).axes
    assert [line.get_marker() for line in panel.lines if line.get_zorder() == 3.5] == ["*", "o", "o"]
    assert [picture.name for picture in pictures(study, simulated)] == list(FIGURES)


# The axis along the sweep


@pytest.mark.parametrize("name", ["inclined", "inclined-forcing", "frequency", "forcing-wide", "large"])
def test_the_swept_parameter_stands_along_the_top(name: str) -> None:
    study = study_of(name)
    axis = along(study.solution.sweep)
    assert len(axis.top) >= 3
    for x, text in axis.top:
        value = float(text.replace(" × 10⁸", "e8"))
        assert study.solution.sweep.start <= value <= study.solution.sweep.end
        assert x == pytest.approx(float(study.solution.sweep.coordinate_of(value)))
    places = sorted(x for x, _ in axis.top)
    assert min(np.diff(places)) > (axis.high - axis.low) / 15
    texts = [text.get_text() for text in figure_of(name, "figure-2").texts]
    assert "distance d = 4 M s f² / F [–]" in texts
    assert {"length s [m]", "force amplitude F [N]", "frequency f [Hz]"} & set(texts)


def test_at_constant_d_the_inclination_is_the_axis() -> None:
    study = study_of("inclination")
    axis = along(study.solution.sweep)
    assert (axis.low, axis.high) == (0, 90)
    for x, text in axis.top:
        assert float(text) == pytest.approx(float(study.solution.sweep.coordinate_of(x)), abs=1e-12)
    texts = [text.get_text() for text in figure_of("inclination", "figure-4").texts]
    assert {"inclination β [°]", "gravity ḡ = M g sin β / F [–]"} <= set(texts)


def test_round_ticks() -> None:
    assert ticks(0.26, 0.75, 8) == [0.3, 0.4, 0.5, 0.6, 0.7]
    assert ticks(-0.07, 1.0, 6) == [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
    assert tick_labels([0.0, 0.5, 1.0]) == ["0", "0.5", "1.0"]
    assert tick_labels([-0.25, 0.0]) == ["−0.25", "0"]
    assert tick_labels([1e-7, 2e-7]) == ["1 × 10⁻⁷", "2 × 10⁻⁷"]
    assert tick_labels([3e8, 3.5e8]) == ["3 × 10⁸", "3.5 × 10⁸"]
    values, texts = fitting_ticks(0.4604176, 0.46042424, 60)
    assert len(set(texts)) == len(texts) >= 3
    assert [float(text) for text in texts] == pytest.approx(values, rel=1e-12)
    assert sum(map(len, texts)) < 60


def test_uneven_ticks_are_round_and_apart() -> None:
    def place(value: np.ndarray) -> np.ndarray:
        return 1.494 / value

    assert uneven_ticks(3.0, 6.0, place, 0.02) == [3, 3.5, 4, 4.5, 5, 5.5, 6]
    found = uneven_ticks(0.5, 60.0, place, 0.2)
    assert {0.5, 1, 2, 5} <= set(found)
    assert np.abs(np.diff(place(np.array(found)))).min() >= 0.2


# How it looks


@pytest.mark.parametrize(
    "name", ["horizontal", "inclined", "inclined-forcing", "frequency", "inclination", "narrow", "large"]
)
@pytest.mark.parametrize("figure", list(FIGURES))
def test_texts_are_on_the_sheet_and_clear_of_one_another(name: str, figure: str) -> None:
    drawn = figure_of(name, figure)
    drawn.canvas.draw()
    renderer = drawn.canvas.get_renderer()
    boxes = [text.get_window_extent(renderer) for text in drawn.texts if text.get_text()]
    width, height = drawn.canvas.get_width_height()
    assert all(box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height for box in boxes)
    panels = [axes.get_window_extent(renderer) for axes in drawn.axes]
    for i, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[i + 1 :]), drawn.texts[i].get_text()
        assert not any(box.overlaps(panel) for panel in panels)
    for axes, panel in zip(drawn.axes, panels, strict=True):
        marks = [text.get_window_extent(renderer) for text in axes.texts]
        assert all(not a.overlaps(b) for i, a in enumerate(marks) for b in marks[i + 1 :])
        inner = panel.padded(DESCENDER)
        assert all(inner.contains(m.x0, m.y0) and inner.contains(m.x1, m.y1) for m in marks)


def test_letters_keep_clear_of_the_curves() -> None:
    for figure in ("figure-2", "figure-4"):
        drawn = figure_of("horizontal", figure)
        renderer = drawn.canvas.get_renderer()
        for panel in drawn.axes:
            for text in panel.texts:
                box = text.get_window_extent(renderer).padded(-2)
                for line in curves(panel):
                    points = panel.transData.transform(np.column_stack(line.get_data()))
                    inside = box.count_contains(points[np.isfinite(points).all(axis=1)])
                    assert inside == 0, text.get_text()


def test_the_two_impacts_differ_by_more_than_colour() -> None:
    lines = curves(figure_of("inclined", "figure-2").axes[0])
    by_color = {
        color: {line.get_linewidth() for line in lines if line.get_color() == color}
        for color in {line.get_color() for line in lines}
    }
    thin, thick = sorted(by_color.values(), key=max)
    assert len(by_color) == 2
    assert min(thick) > 2 * max(thin)
    volts = curves(figure_of("inclined", "figure-7").axes[0])
    looks = {(line.get_linewidth(), str(line.get_linestyle()), line._unscaled_dash_pattern) for line in volts}
    assert len(looks) == len(volts) == 6


def test_the_first_branches_are_apart_in_grey() -> None:
    grey = [float(np.dot(to_rgb(color), (0.299, 0.587, 0.114))) for color in BRANCH_COLORS[:3]]
    assert min(abs(a - b) for i, a in enumerate(grey) for b in grey[i + 1 :]) > 0.2


def test_voltages_outside_the_geometry_are_said_to_be() -> None:
    study = study_of("inclined")
    assert any(alert.code == "VR010" for alert in study.alerts)
    note = "Outside the membrane's geometry: ranking only"
    assert note in [text.get_text() for text in figure_of("inclined", "figure-7").texts]
    soft = analyse(load(ROOT / "examples" / "inclined.yaml", ("device.ball_mass_kg=1e-7",)))
    assert not any(alert.code == "VR010" for alert in soft.alerts)
    assert note not in [text.get_text() for text in figure_7(soft).texts]


def test_voltages_have_a_fitting_prefix() -> None:
    def label(mass: str) -> str:
        study = analyse(load(ROOT / "examples" / "inclined.yaml", (f"device.ball_mass_kg={mass}",)))
        return next(text.get_text() for text in figure_7(study).texts if "generated" in text.get_text())

    assert label("0.0041") == "generated voltage U [kV]"
    assert label("1e-7") in ("generated voltage U [V]", "generated voltage U [mV]")


# Captions


@pytest.mark.parametrize("name", list(CASES))
def test_pictures_are_whole(name: str) -> None:
    for picture in pictures(study_of(name)):
        image = Image.open(BytesIO(picture.png))
        assert (image.format, image.size) == ("PNG", (picture.width, picture.height))
        assert "Software" not in image.info
        assert image.convert("RGB").getpixel((0, 0)) == (255, 255, 255)
        assert len(picture.png) < 100_000
        assert picture.title
        assert picture.caption.endswith(".")
        assert picture.alt.endswith(".")
        assert not re.search(r"\b(nan|inf|None)\b", picture.caption + picture.alt)


def test_few_colours_are_enough() -> None:
    drawn = figure_of("horizontal", "figure-2")
    data, *size = png_of(drawn)
    full = np.asarray(drawn.canvas.buffer_rgba())[:, :, :3].astype(int)
    few = np.asarray(Image.open(BytesIO(data)).convert("RGB")).astype(int)
    white = (full == 255).all(axis=2)
    assert (few[white] == 255).all()
    off = np.abs(few - full).max(axis=2)[~white]
    assert off.mean() < 3
    assert (off > 24).mean() < 0.002
    assert size == [few.shape[1], few.shape[0]]


def test_captions_tell_the_numbers() -> None:
    two, four, seven = pictures(study_of("inclined"))
    for picture in (two, four, seven):
        assert "F = 3 N, f = 2 Hz, β = 45°" in picture.caption
        assert "s from 0.59 m to 0.75 m" in picture.caption
        assert "Stable 1:1 motion for 0.629457 m < s ≤ 0.75 m." in picture.caption
        assert "B1" in picture.alt
    assert "B1 period doubling (d = 0.417960, s = 0.629457 m)" in two.caption
    assert "design point s = 0.6934 m" in two.caption
    assert "branch 1 (asymmetric) reaches |λ| =" in four.caption
    assert "U_ave = 42.84 kV" in seven.caption
    assert "mirror" not in two.caption
    assert "mirror image" in pictures(study_of("horizontal"))[0].caption


# The same everywhere


SCRIPT = """
import hashlib, sys
from vireport.figures.paper_figures import pictures
from vireport.figures.pixels import png_of
from vireport.scenario.loading import load
from vireport.study.study import analyse
for picture in pictures(analyse(load(sys.argv[1]))):
    print(hashlib.sha256(picture.png).hexdigest())
assert "matplotlib.pyplot" not in sys.modules
"""

RC = """
font.size: 25
font.family: serif
lines.linewidth: 9
lines.scale_dashes: True
axes.facecolor: red
axes.grid: True
figure.dpi: 40
savefig.dpi: 40
path.sketch: 5, 100, 2
text.color: green
text.hinting: force_autohint
"""


def test_the_bytes_are_the_same_in_every_process_whatever_the_user_has_set(tmp_path: Path) -> None:
    before = dict(matplotlib.rcParams)
    path = ROOT / "examples" / "inclined.yaml"
    here = [hashlib.sha256(picture.png).hexdigest() for picture in pictures(study_of("inclined"))]
    again = [hashlib.sha256(picture.png).hexdigest() for picture in pictures(study_of("inclined"))]
    assert here == again
    assert dict(matplotlib.rcParams) == before
    (tmp_path / "matplotlibrc").write_text(RC)
    environment = os.environ | {"MATPLOTLIBRC": str(tmp_path), "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": "7"}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(path)], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == here


def test_eigenvalue_curves_are_the_eigenvalues() -> None:
    for part in stretches(study_of("horizontal").solution):
        motions = part.branch.motions
        drawn = [y for _, y in eigenvalue_curves(part, motions.d[part.rows])]
        assert len(drawn) == (1 if part.focus else 2)
        if not part.focus:
            inner = slice(part.rows.start + 1, part.rows.stop - 1)
            np.testing.assert_allclose(drawn[0][1:-1] + drawn[1][1:-1], motions.trace[inner], rtol=1e-9, atol=1e-12)
