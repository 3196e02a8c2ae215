"""Figures 2, 4 and 7: what is drawn is what the study says, and it can be read by everyone, everywhere, the same."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
from functools import cache
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from conftest import sentences
from figure_cases import (
    FIGURES,
    ROOT,
    cases,
    curves,
    figure_of,
    labels,
    pictures_of,
    rows,
    study_of,
    texts_of,
    vertices,
)
from matplotlib.colors import to_rgb
from matplotlib.path import Path as MplPath
from msgspec.structs import replace
from PIL import Image
from scipy.spatial import KDTree

from vireport.design.from_rest import Destination, FromRest
from vireport.design.outcomes_from_rest import OutcomeRange
from vireport.design.switched_on import SwitchedOn
from vireport.figures.curves import (
    TURN,
    PairedImpacts,
    phase_curve,
    phase_cut,
    simulated_points,
    stretches,
)
from vireport.figures.labels import LEADER
from vireport.figures.layout import ALONG_TOP
from vireport.figures.pictures import pictures
from vireport.figures.style import figure_css
from vireport.figures.sweeps import (
    ALIKE,
    BOTTOM,
    EVENT_LINE,
    LEAVES,
    NO_MOTION,
    OUTCOMES,
    TOP,
    figure_2,
    figure_7,
)
from vireport.physics.energy import Voltages
from vireport.scenario.loading import load
from vireport.scenario.parameters import Parameter
from vireport.study.study import Study, analyse

# What is drawn


@pytest.mark.slow
def test_a_strip_has_the_outcomes_from_rest_where_they_are() -> None:
    """Of a force sweep, along which d falls as the force grows."""
    study, ends = study_of("inclined-forcing"), (3.0, 3.6, 4.0, 6.0)
    outcomes = (Destination.ONE_TO_ONE, Destination.REST_CYCLE, Destination.CHAOTIC)
    along = tuple(
        OutcomeRange(start, end, FromRest(destination))
        for start, end, destination in zip(ends, ends[1:], outcomes, strict=False)
    )
    study = replace(study, switched_on=SwitchedOn(None, over_sweep=along))
    figure, device = figure_2(study), study.solution.device
    *panels, below = figure.axes
    assert not any(panel.patches for panel in panels)
    strip = below.patches
    for patch, part in zip(strip, along, strict=True):
        assert to_rgb(patch.get_facecolor()[:3]) == to_rgb(OUTCOMES[part.outcome.destination][1])
        d = [float(device.groups(Parameter.AMPLITUDE, value).d) for value in (part.end, part.start)]
        assert sorted((patch.get_x(), patch.get_x() + patch.get_width())) == pytest.approx(d, rel=1e-12)
    assert below.get_ylabel() == "from rest"
    assert {name for name, _ in OUTCOMES.values()} & set(texts_of(figure)) == {"1:1", "rest cycle", "chaotic"}
    drawn = next(picture for picture in pictures(study) if picture.name == "figure-2")
    assert "1:1 motion on 20 % of the sweep" in drawn.caption
    assert "1:1 motion on 20 % of the sweep" in drawn.alt
    # Without a block there is none.
    plain = next(picture for picture in pictures_of("inclined-forcing") if picture.name == "figure-2")
    assert "strip: " not in plain.caption
    assert len(figure_of("inclined-forcing", "figure-2").axes) == 3


@pytest.mark.slow
def test_the_plan_decides_which_are_drawn() -> None:
    assert [picture.name for picture in pictures_of("inclined")] == [
        "figure-2",
        "figure-4",
        "figure-7",
        "figure-answer",
        "figure-device",
        "figure-margins",
    ]
    path = ROOT / "examples" / "inclined.yaml"
    without_mass = load(path, ("device.ball_mass_kg=", "device.membrane="))
    drawn = [picture.name for picture in pictures(analyse(without_mass))]
    assert drawn == ["figure-2", "figure-4", "figure-answer", "figure-device", "figure-margins"]
    assert pictures(analyse(load(path), ["json", "csv"])) == ()
    alone = pictures(analyse(load(ROOT / "examples" / "design-point.yaml")))
    assert [picture.name for picture in alone] == ["figure-device", "figure-margins"]


def test_without_a_sweep_there_is_nothing_to_draw() -> None:
    with pytest.raises(ValueError, match="along a sweep"):
        figure_2(analyse(load(ROOT / "examples" / "design-point.yaml")))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["wide", "horizontal-wide", "lively", "frequency"])
def test_only_admissible_motions_are_drawn(name: str) -> None:
    study = study_of(name)
    velocity, _, flight = figure_of(name, "figure-2").axes[:3]
    (voltage,) = figure_of(name, "figure-7").axes
    # Where bottom and top are alike one curve stands for both, which differ by rounding.
    drawn = [KDTree(sorted(vertices(curves(panel)))) for panel in (velocity, flight, voltage)]
    unit = 1e3  # kV
    for admissible in (True, False):
        for index, row in rows(study, admissible):
            motions, volts = study.solution.branches[index].motions, study.solution.branches[index].voltages_by_motion
            x = float(motions.d[row])
            expected = (
                ((x, float(abs(motions.velocity_bottom[row]))), (x, float(abs(motions.velocity_top[row])))),
                ((x, float(motions.q[row])), (x, float(1 - motions.q[row]))),
                tuple((x, float(v[row] / unit)) for v in (volts.average_v, volts.bottom_v, volts.top_v)),
            )
            for actual, wanted in zip(drawn, expected, strict=True):
                assert ((actual.query(wanted)[0] < 1e-12) == admissible).all()


@pytest.mark.slow
def test_there_are_inadmissible_motions_to_leave_out() -> None:
    assert all(rows(study_of(name), False) for name in ("wide", "horizontal-wide", "lively"))


@pytest.mark.parametrize("name", cases("horizontal", "inclined-forcing", "wide", "slow"))
@pytest.mark.parametrize("figure", ["figure-2", "figure-4"])
def test_every_critical_point_is_lettered_once(name: str, figure: str) -> None:
    kinds = {point.label: point.event for point in study_of(name).solution.critical_points}
    top, *others = (labels(panel) for panel in figure_of(name, figure).axes)
    lettered = top + [label for panel in others for label in panel]
    assert len(set(lettered)) == len(lettered)
    if figure == "figure-2":
        assert sorted(top) == sorted(kinds)
    else:  # some are off the axes, but never those that decide stability
        assert {kinds[label] for label in set(kinds) - set(lettered)} <= {"grazing"}


@pytest.mark.parametrize("name", cases("horizontal", "wide", "slow"))
def test_a_line_leads_from_a_letter_through_the_panels_without_it(name: str) -> None:
    solution = study_of(name).solution
    top, *others = figure_of(name, "figure-2").axes[:3]
    places = sorted(float(solution.sweep.coordinate_of(point.sweep_value)) for point in solution.critical_points)
    for panel, expected in ((top, []), *((panel, places) for panel in others)):
        across = [line for line in panel.lines if line.get_zorder() == EVENT_LINE["zorder"]]
        lines = {float(x) for line in across for x in line.get_xdata()}
        assert sorted(lines) == pytest.approx(expected)


@pytest.mark.parametrize("name", cases("horizontal", "wide", "lively", "inclination"))
def test_markers_stand_on_their_curves(name: str) -> None:
    velocity = figure_of(name, "figure-2").axes[0]
    on_curves = vertices(curves(velocity))
    for line in velocity.lines:
        if line.get_marker() in ("o", "s", "D", "d", "^"):
            assert vertices([line]) <= on_curves


@pytest.mark.parametrize("name", cases("horizontal", "wide", "lively", "small", "large", "narrow", "next"))
@pytest.mark.parametrize("figure", ["figure-2", "figure-7"])
def test_the_axes_hold_the_data(name: str, figure: str) -> None:
    for panel in figure_of(name, figure).axes:
        (left, right), (low, high) = panel.get_xlim(), panel.get_ylim()
        assert all(left < x < right and low < y < high for x, y in vertices(curves(panel)))


@pytest.mark.parametrize("name", cases("horizontal", "wide", "lively", "slow"))
def test_figure_4_shows_its_bounds_and_not_how_unstable_a_motion_is(name: str) -> None:
    panels = figure_of(name, "figure-4").axes
    for panel, bounds, most in zip(panels, ((0.0,), (-1.0, 1.0)), (3.0, 2.0), strict=True):
        low, high = panel.get_ylim()
        assert {line.get_ydata()[0] for line in panel.lines if line.get_zorder() == 1.5} == set(bounds)
        assert low < bounds[0] <= bounds[-1] < high < most
    assert low > -2


def test_figure_4_is_thicker_where_the_eigenvalues_are_complex() -> None:
    stable = [line for line in curves(figure_of("horizontal", "figure-4").axes[1]) if line.get_linestyle() == "-"]
    widths = {line.get_linewidth() for line in stable}
    thick = vertices([line for line in stable if line.get_linewidth() == max(widths)])
    r = 0.5
    assert len(widths) == 2
    assert max(abs(y) for _, y in thick) == pytest.approx(r * r)


def test_figure_4_draws_mirror_images_once() -> None:
    study = study_of("horizontal")
    numbers = {part.branch.number for part in stretches(study.solution) if part.branch.mirror_of is None}
    named = [text for text in texts_of(figure_of("horizontal", "figure-4")) if "symmetric " in text]
    assert sorted(int(name.split()[-1]) for name in named) == sorted(numbers)


@pytest.mark.parametrize("name", cases("horizontal", "lively", "slow", "horizontal-wide"))
def test_phases_never_jump(name: str) -> None:
    panel = figure_of(name, "figure-2").axes[1]
    for line in curves(panel):
        y = np.asarray(line.get_ydata())
        assert np.nanmax(np.abs(np.diff(y))) < np.pi
    low, high = panel.get_ylim()
    assert 1.05 * TURN < high - low < 1.3 * TURN
    study = study_of(name)
    drawn = sorted(vertices(curves(panel)))
    for index, row in rows(study, True):
        motions = study.solution.branches[index].motions
        for phi in (motions.phi_bottom[row], motions.phi_top[row]):
            away = [(y - phi + np.pi) % TURN - np.pi for x, y in drawn if x == motions.d[row]]
            assert np.abs(away).min() < 1e-9


def test_a_phase_that_passes_a_full_turn_goes_on_from_its_middle() -> None:
    np.testing.assert_allclose(phase_curve(np.array([6.0, 6.2, 0.2])), [6.0, 6.2, 0.2 + TURN])
    np.testing.assert_allclose(phase_curve(np.array([0.1, 6.2])), [0.1 + TURN, 6.2])


def test_phases_are_cut_at_zero_unless_a_curve_passes_it() -> None:
    assert phase_cut(stretches(study_of("inclined").solution)) == pytest.approx(0.0, abs=1e-8)
    assert phase_cut(stretches(study_of("inclined-forcing").solution)) == pytest.approx(0.0, abs=1e-8)
    parts = stretches(study_of("horizontal").solution)
    cut = phase_cut(parts)
    assert -0.6 < cut < -0.4
    for part in parts:
        for phi in (part.branch.motions.phi_bottom[part.rows], part.branch.motions.phi_top[part.rows]):
            assert np.abs(np.diff((phi - cut) % TURN)).max() < np.pi


def test_curves_that_leave_figure_4_are_marked_at_its_edge() -> None:
    for panel in figure_of("horizontal", "figure-4").axes:
        _, high = panel.get_ylim()
        marks = [line for line in panel.lines if line.get_zorder() == LEAVES["zorder"]]
        marked = {line.get_color() for line in marks}
        leaving = {line.get_color() for line in curves(panel) if np.nanmax(line.get_ydata()) > high}
        assert marked == leaving == {ALIKE["color"]}
        for line in marks:
            (at,), (top,) = line.get_data()
            assert line.get_marker() == "^"
            assert top > 0.9
            steps = [c for c in curves(panel) if c.get_color() == line.get_color()]
            inside = [y < high for c in steps for x, y in zip(*c.get_data(), strict=True) if abs(x - at) < 0.02]
            assert not all(inside)


def test_one_colour_means_one_thing_along_a_sweep() -> None:
    velocity, voltage = figure_of("inclined", "figure-2").axes[0], figure_of("inclined", "figure-7").axes[0]
    impacts = {line.get_color() for line in curves(velocity)}
    assert impacts < {line.get_color() for line in curves(voltage)}
    for name in ("inclined", "horizontal"):  # of both impacts, as where their curves are one
        for panel in figure_of(name, "figure-4").axes:
            assert {line.get_color() for line in curves(panel)} == {ALIKE["color"]}


@pytest.mark.parametrize(
    "name", cases("horizontal", "inclined", "inclined-forcing", "wide", "lively", "slow", "inclination", "large")
)
@pytest.mark.parametrize("figure", list(FIGURES))
def test_no_label_lies_on_a_line_a_tick_or_a_marker(name: str, figure: str) -> None:
    for panel in figure_of(name, figure).axes:
        for text in panel.texts:
            if text.get_text() not in labels(panel):
                continue
            box = text.get_window_extent().padded(-2)
            frame = panel.bbox.padded(-3.5 * panel.figure.dpi / 72)
            assert frame.contains(*box.p0)
            assert frame.contains(*box.p1)
            for line in panel.lines:
                if line.get_zorder() != LEADER["zorder"]:
                    path = line.get_transform().transform(line.get_xydata())
                    pieces = np.split(path, np.flatnonzero(np.isnan(path).any(axis=1)))
                    drawn = [piece[~np.isnan(piece).any(axis=1)] for piece in pieces]
                    for piece in drawn:
                        if line.get_linestyle() != "None" and len(piece) > 1:
                            assert not MplPath(piece).intersects_bbox(box, filled=False), text
                        else:
                            assert not box.count_contains(piece), text


@pytest.mark.slow
@pytest.mark.parametrize("figure", list(FIGURES))
def test_an_empty_sweep_says_so_in_every_panel(figure: str) -> None:
    assert not rows(study_of("empty"), True)
    for panel in figure_of("empty", figure).axes:
        assert NO_MOTION in [text.get_text() for text in panel.texts]
        assert not curves(panel)
    assert "no admissible 1:1 motion" in pictures_of("empty")[0].alt


@pytest.mark.slow
def test_the_design_point_is_marked() -> None:
    study = study_of("inclined")
    for panel in figure_of("inclined", "figure-2").axes[:3]:
        marks = [line for line in panel.lines if line.get_marker() == "P"]
        at = np.concatenate([line.get_xdata() for line in marks])
        np.testing.assert_allclose(at, study.solution.design.motions.d[0], rtol=1e-12)
        # Of its two motions the stable one alone, at the bottom and at the top.
        assert [line.get_markerfacecolor() != "white" for line in marks] == [True, True]
        assert [len(line.get_xdata()) for line in marks] == [1, 1]
    assert texts_of(figure_of("inclined", "figure-2")).count("design point") == 1
    short = analyse(load(ROOT / "examples" / "inclined.yaml", ("device.length_m=0.6",)))
    marks = [line for line in figure_2(short).axes[0].lines if line.get_marker() == "P"]
    assert marks
    assert {line.get_markerfacecolor() for line in marks} == {"white"}
    outside = analyse(load(ROOT / "examples" / "inclined.yaml", ("device.length_m=0.8",)))
    assert "design point" not in texts_of(figure_2(outside))


def test_the_design_point_never_hides_a_critical_point() -> None:
    for panel in figure_of("inclined-forcing", "figure-2").axes[:3]:
        order = {line.get_marker(): line.get_zorder() for line in panel.lines}
        assert order["P"] < min(order["s"], order["^"])


@pytest.mark.slow
def test_simulated_motions_are_drawn_over() -> None:
    d = np.array([0.42, 0.45, 0.48])
    velocity, phase, flight = (np.outer(pair, np.ones(3)) for pair in ((0.9, -0.45), (0.5, 3.5), (0.6, 0.4)))
    volts = Voltages(np.full(3, 4e4), np.full(3, 3e4), np.full(3, 3.5e4), np.full(3, 0.01))
    simulated = PairedImpacts(d / 0.664, d, velocity, phase, flight, volts)
    study = study_of("inclined")
    for panel in figure_2(study, simulated).axes:
        circles = [line for line in panel.lines if line.get_zorder() == 3.5]
        assert [len(line.get_xdata()) for line in circles] == [3, 3]
    (panel,) = figure_7(study, simulated).axes
    assert [line.get_marker() for line in panel.lines if line.get_zorder() == 3.5] == ["o", "o", "o"]
    names = [picture.name for picture in pictures(study, simulated)]
    assert names == [*FIGURES, "figure-answer", "figure-device", "figure-margins"]


# The axis along the sweep


def top_axis(name: str, figure: str = "figure-2") -> tuple[str, list[float], list[str]]:
    """Label, places and texts of the axis along the top."""
    axes = figure_of(name, figure).axes[0]
    *ticks, label = (text for text in axes.texts if text.get_label() == ALONG_TOP)
    return label.get_text(), [text.get_position()[0] for text in ticks], [text.get_text() for text in ticks]


@pytest.mark.parametrize("name", cases("inclined", "inclined-forcing", "frequency", "forcing-wide", "large"))
def test_the_swept_parameter_stands_along_the_top(name: str) -> None:
    sweep = study_of(name).solution.sweep
    label, places, texts = top_axis(name)
    assert label in ("length s [m]", "force amplitude F [N]", "frequency f [Hz]")
    assert figure_of(name, "figure-2").axes[-1].get_xlabel() == "distance d = 4 M s f² / F [–]"
    assert len(places) >= 3
    for x, text in zip(places, texts, strict=True):
        value = float(text.replace(" × 10⁸", "e8"))
        assert sweep.start <= value <= sweep.end
        assert x == pytest.approx(float(sweep.coordinate_of(value)))
    low, high = sweep.coordinate_range
    assert min(np.diff(sorted(places))) > (high - low) / 20


def test_at_constant_d_the_inclination_is_the_axis() -> None:
    sweep = study_of("inclination").solution.sweep
    label, places, texts = top_axis("inclination", "figure-4")
    for x, text in zip(places, texts, strict=True):
        assert float(text) == pytest.approx(float(sweep.coordinate_of(x)), abs=1e-12)
    bottom = figure_of("inclination", "figure-4").axes[-1]
    assert (bottom.get_xlabel(), label) == ("inclination β [°]", "gravity ḡ = M g sin β / F [–]")
    assert bottom.get_xlim() == pytest.approx((-1.35, 91.35))


# How it looks


def test_the_two_impacts_differ_by_more_than_colour() -> None:
    lines = curves(figure_of("inclined", "figure-2").axes[0])
    for style in {line.get_linestyle() for line in lines}:
        widths = {line.get_color(): line.get_linewidth() for line in lines if line.get_linestyle() == style}
        thin, thick = sorted(widths.values())
        assert thick > 2 * thin
    volts = curves(figure_of("inclined", "figure-7").axes[0])
    looks = {(line.get_linewidth(), str(line.get_linestyle())) for line in volts}
    assert len(looks) == len(volts) == 6


def test_where_both_impacts_coincide_one_line_says_so() -> None:
    velocity, phase, flight = figure_of("horizontal", "figure-2").axes[:3]
    assert "both" in texts_of(velocity.figure)
    assert {line.get_color() for line in curves(velocity) + curves(flight)} == {ALIKE["color"]}
    assert {line.get_color() for line in curves(phase)} == {BOTTOM["color"], TOP["color"]}
    assert {line.get_color() for line in curves(figure_of("horizontal", "figure-7").axes[0])} == {ALIKE["color"]}
    assert not [text for text in texts_of(figure_of("horizontal", "figure-7")) if text.endswith("top")]
    for figure in ("figure-2", "figure-7"):
        assert ALIKE["color"] not in {line.get_color() for line in curves(figure_of("inclined", figure).axes[0])}


@pytest.mark.parametrize("figure", list(FIGURES))
def test_unstable_motions_are_thin_and_pale(figure: str) -> None:
    for panel in figure_of("inclined", figure).axes[:3]:
        stable, unstable = ([x for x in curves(panel) if (x.get_linestyle() == "-") == kind] for kind in (True, False))
        assert stable
        assert {line.get_alpha() for line in stable} == {None}
        for line in unstable:
            alike = [x.get_linewidth() for x in stable if x.get_color() == line.get_color()]
            assert line.get_linewidth() < min(alike, default=np.inf)
            assert line.get_alpha() < 1


@cache
def light_ball() -> Study:
    return analyse(load(ROOT / "examples" / "inclined.yaml", ("device.ball_mass_kg=1e-7",)))


def test_voltages_have_a_fitting_prefix() -> None:
    (heavy,) = figure_of("inclined", "figure-7").axes
    (light,) = figure_7(light_ball()).axes
    assert heavy.get_ylabel() == "generated voltage U [kV]"
    assert light.get_ylabel() in ("generated voltage U [V]", "generated voltage U [mV]")


# Captions


@pytest.mark.parametrize("name", cases("horizontal", "inclination", "empty", "slow", "small"))
def test_pictures_are_whole(name: str) -> None:
    for picture in pictures_of(name):
        image = Image.open(BytesIO(picture.png))
        assert (image.format, image.size) == ("PNG", tuple(map(int, picture.figure.bbox.size)))
        assert image.info["Software"].startswith("vireport ")
        assert image.info["dpi"] == pytest.approx((150, 150), abs=0.02)
        assert image.convert("RGB").getpixel((0, 0)) == (255, 255, 255)
        assert picture.title
        assert picture.caption.endswith(".")
        assert sentences(picture.caption) <= 2
        assert picture.alt.endswith(".")
        assert not re.search(r"\b(nan|inf|None)\b", picture.caption + picture.alt)


def test_captions_say_what_is_drawn_in_two_sentences() -> None:
    two, four, seven, *_, margins = pictures_of("inclined")
    assert "period doubling B1 at f = 1.91 Hz" in margins.caption
    assert "inclination 0.3" in margins.alt
    for picture in (two, four, seven):
        assert sentences(picture.caption) == 2
        assert ("as in Figure 2" in picture.caption) == (picture is not two)
        assert "Stable 1:1 motion for 0.629 m < s ≤ 0.75 m." in picture.alt
        assert "B1" in picture.alt
    assert "F = 3 N, f = 2 Hz, β = 45°, M = 0.1245 kg, r = 0.5; s from 0.59 m to 0.75 m" in two.caption
    assert "F/(2 M f) = 6.02 m/s; B: period doubling" in two.caption
    assert "A: node to focus, B: period doubling, C: pitchfork, G: grazing" in pictures_of("horizontal")[0].caption
    assert "|λ| reaches 87.1" in four.caption
    assert "m = 4.1 g" in seven.caption
    assert "mirror" not in two.caption
    assert "mirror image" in pictures_of("horizontal")[0].caption


@pytest.mark.slow
def test_captions_of_motions_and_of_a_slow_sweep_have_two_sentences() -> None:
    quick = ("simulation.samples=3", "simulation.starts=1", "motions.impacts=3", "motions.periods=1", "sweep.to=0.24")
    drawn = pictures(analyse(load(ROOT / "examples/hysteresis.yaml", (*quick, "motions.portraits=[BBT]"))))
    assert {f"figure-{name}" for name in ("atlas", "ladder", "portraits", "hysteresis")} <= {x.name for x in drawn}
    for picture in drawn:
        assert 1 <= sentences(picture.caption) <= 2, picture.name


# As vectors


@pytest.mark.slow
def test_as_vectors_texts_are_texts_and_identifiers_are_unique_on_a_page() -> None:
    drawn = pictures_of("horizontal")
    elements = [ElementTree.fromstring(picture.inline) for picture in drawn]
    identifiers = [node.get("id") for root in elements for node in root.iter() if node.get("id")]
    assert len(identifiers) == len(set(identifiers)) > 0
    for picture, root in zip(drawn, elements, strict=True):
        assert root.get("aria-label") == picture.alt
        ours = {node.get("id") for node in root.iter()}
        references = re.findall(r'(?:href="|url\()#([^")]*)', picture.inline)
        assert {name for name in references if not name.startswith("point-")} <= ours
        texts = {text for node in root.iter() if node.tag.endswith("}text") for text in node.itertext()}
        assert {text for text in texts_of(picture.figure) if "\n" not in text} <= texts
        whole = ElementTree.fromstring(picture.svg)
        assert not any(node.tag.endswith("}a") for node in whole.iter())
        assert whole.get("width") == f"{picture.figure.bbox.width * 72 / 150:g}pt"


def test_on_a_page_every_colour_is_one_of_the_pages() -> None:
    declared = set(re.findall(r"(--figure-\w+):", figure_css()))
    for picture in pictures_of("horizontal"):
        assert not re.search(r"#[0-9a-fA-F]{6}\b", picture.inline)
        assert set(re.findall(r"var\((--figure-\w+)\)", picture.inline)) <= declared


# The same everywhere


SCRIPT = """
import hashlib, sys
from vireport import analyse, load, pictures
for picture in pictures(analyse(load(sys.argv[1]))):
    print(hashlib.sha256(picture.png + picture.svg + picture.inline.encode()).hexdigest())
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


@pytest.mark.slow
def test_the_bytes_are_the_same_in_every_process_whatever_the_user_has_set(tmp_path: Path) -> None:
    before = dict(matplotlib.rcParams)
    path = ROOT / "examples" / "inclined.yaml"
    first = [picture.png + picture.svg + picture.inline.encode() for picture in pictures_of("inclined")]
    redrawn = pictures(study_of("inclined"))
    other_order = [(picture.inline.encode(), picture.svg, picture.png) for picture in redrawn]
    assert first == [png + svg + inline for inline, svg, png in other_order]
    here = [hashlib.sha256(bytes_of).hexdigest() for bytes_of in first]
    assert dict(matplotlib.rcParams) == before
    (tmp_path / "matplotlibrc").write_text(RC)
    environment = os.environ | {"MATPLOTLIBRC": str(tmp_path), "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": "7"}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(path)], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == here


@pytest.mark.slow
def test_beyond_the_period_doubling_simulated_motions_lie_on_curves(example) -> None:
    changes = ["sweep.from=5.3", "simulation.samples=4", "simulation.starts=2", "simulation.diagram=false"]
    study = analyse(load(example("simulated"), [*changes, "motions.impacts=4", "motions.periods=2"]))
    simulated = simulated_points(study)
    drawn = {picture.name: picture for picture in pictures(study, simulated)}
    assert "period doublings (BTBT)" in drawn["figure-2"].caption
    checked = 0
    for name in ("figure-2", "figure-7"):
        for axes in drawn[name].figure.axes[: 3 if name == "figure-2" else 1]:
            thin = [line for line in axes.lines if line.get_linewidth() == 0.9 and line.get_linestyle() == "-"]
            circles = [line for line in axes.lines if line.get_zorder() == 3.5]
            assert len(thin) % len(circles) == 0 < len(thin)
            # Both are in the same order: the average of figure 7, then the bottom and the top.
            for k, points in enumerate(circles):
                between = np.linspace(0, 1, 9)[:, None, None]
                curves = [line.get_xydata() for line in thin[k :: len(circles)]]
                x, y = np.concatenate([(xy[:-1] + between * np.diff(xy, axis=0)).reshape(-1, 2) for xy in curves]).T
                for at, value in zip(*points.get_data(), strict=True):
                    if at < np.nanmax(x) and not np.isnan(value):
                        near = np.hypot((x - at) / np.ptp(x[~np.isnan(x)]), (y - value) / value)
                        assert np.nanmin(near) < 0.02
            checked += len(thin)
    assert checked >= 16
