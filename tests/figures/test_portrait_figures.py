"""The figures that come from simulation alone: what is drawn is the simulated motion, and it can be read."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from conftest import first
from figure_cases import PAPER, ROOT, assert_readable, motion, of_look, simulated_study, texts_of
from matplotlib.colors import to_rgb
from PIL import Image

from vireport.figures.captions import alt_text
from vireport.figures.curves import PairedImpacts, simulated_points, stretches
from vireport.figures.diagram import WORDS, figure_diagram, groups
from vireport.figures.diagram import picture as diagram_picture
from vireport.figures.pictures import pictures
from vireport.figures.portraits import (
    BALL,
    BOTTOM_IMPACT,
    BOTTOM_MEMBRANE,
    MOTION,
    REBOUND,
    TOP_IMPACT,
    TOP_MEMBRANE,
    arrivals,
    ball,
    capsule,
    figure_3,
    figure_6,
    portrait_facts,
    rides,
    short,
)
from vireport.figures.sweeps import figure_2, figure_7
from vireport.figures.vector import png
from vireport.simulation.attractors import Diagram, Outcome
from vireport.study.plan import Task


@pytest.mark.parametrize("name", list(PAPER))
def test_the_portraits_are_the_papers(name: str) -> None:
    *_, word, period = PAPER[name]
    assert (motion(name).attractor.word, motion(name).attractor.period) == (word, period)


@pytest.mark.parametrize("name", list(PAPER))
def test_the_curve_stays_between_the_walls_and_ends_there(name: str) -> None:
    shown = motion(name)
    left, right = figure_3([shown]).axes
    (z_v,) = of_look(left, MOTION)
    (t_v,) = of_look(right, MOTION)
    z = z_v[~np.isnan(z_v[:, 0]), 0]
    assert np.abs(z).max() == pytest.approx(shown.d / 2, rel=1e-9)
    assert z[0] == pytest.approx(shown.d / 2, rel=1e-9)  # from an impact on the bottom
    for points in (z_v, t_v):
        pieces = np.split(points, np.flatnonzero(np.isnan(points[:, 0])))
        assert len(pieces) == 2 * len(shown.attractor.cycle.wall)
    np.testing.assert_array_equal(t_v[:, 1], z_v[:, 1])
    low, high = left.get_ylim()
    assert low < np.nanmin(z_v[:, 1]) < np.nanmax(z_v[:, 1]) < high


@pytest.mark.parametrize("name", list(PAPER))
def test_impacts_are_those_of_the_cycle(name: str) -> None:
    shown = motion(name)
    cycle = shown.attractor.cycle
    left, right = figure_3([shown]).axes
    (panel,) = figure_6([shown]).axes
    for look, wall in ((BOTTOM_IMPACT, 1), (TOP_IMPACT, -1)):
        expected = np.sort(cycle.velocity[cycle.wall == wall])
        (marks,) = of_look(left, look)
        np.testing.assert_allclose(np.sort(marks[:, 1]), expected, atol=1e-9)
        np.testing.assert_allclose(marks[:, 0], wall * shown.d / 2, rtol=1e-12)
        (marks,) = of_look(right, look)
        np.testing.assert_allclose(np.sort(marks[:, 1]), np.sort(np.tile(expected, 2)), atol=1e-9)
        (marks,) = of_look(panel, look)
        end = capsule(shown, 2 * marks[:, 0]) - wall * shown.d / 2
        np.testing.assert_allclose(marks[:, 1], end, atol=1e-12)


@pytest.mark.parametrize("name", [*PAPER, "sticking"])
def test_a_free_capsule_recoils_as_the_force_moves_the_centre_of_mass(name: str) -> None:
    shown, mu = motion(name), 0.3
    (panel,) = figure_6([shown], mass_ratio=mu).axes
    (path,), (low,), (high,) = (of_look(panel, look) for look in (BALL, BOTTOM_MEMBRANE, TOP_MEMBRANE))
    centre = np.interp(path[:, 0], low[:, 0], (low[:, 1] + high[:, 1]) / 2)
    by_force = capsule(shown, 2 * path[:, 0])
    np.testing.assert_allclose(centre + mu * path[:, 1], by_force, atol=2e-4)
    assert np.abs(centre - by_force).max() > 0.01
    for look, wall in ((BOTTOM_IMPACT, -1), (TOP_IMPACT, 1)):
        (marks,) = of_look(panel, look)
        end = np.interp(marks[:, 0], low[:, 0], (low[:, 1] + high[:, 1]) / 2) + wall * shown.d / 2
        np.testing.assert_allclose(marks[:, 1], end, atol=1e-12)


@pytest.mark.parametrize("name", list(PAPER))
def test_rebounds_lose_the_right_part(name: str) -> None:
    left, right = figure_3([motion(name)]).axes
    for panel in (left, right):
        (points,) = of_look(panel, REBOUND)
        before, after = points[::3, 1], points[1::3, 1]
        np.testing.assert_allclose(after, -0.5 * before, atol=1e-12)
        np.testing.assert_array_equal(points[::3, 0], points[1::3, 0])


@pytest.mark.parametrize("name", first(2, [*PAPER, "chaotic", "sticking"]))
def test_the_ball_stays_in_the_capsule(name: str) -> None:
    shown = motion(name)
    (panel,) = figure_6([shown]).axes
    (path,) = of_look(panel, BALL)
    centre = capsule(shown, 2 * path[:, 0])
    assert np.abs(path[:, 1] - centre).max() <= shown.d / 2 * (1 + 1e-9)
    (low,), (high,) = of_look(panel, BOTTOM_MEMBRANE), of_look(panel, TOP_MEMBRANE)
    np.testing.assert_allclose(high[:, 1] - low[:, 1], shown.d)
    np.testing.assert_allclose((high[:, 1] + low[:, 1]) / 2, capsule(shown, 2 * low[:, 0]), atol=1e-15)


def test_the_capsule_is_accelerated_by_the_force_alone_and_does_not_drift() -> None:
    shown, step = motion("doubled"), 1e-3
    time = np.arange(0, 4, step)
    x = capsule(shown, time)
    np.testing.assert_allclose(np.diff(x, 2) / step**2, np.cos(np.pi * time[1:-1] + shown.phase), atol=1e-5)
    assert abs(x[:2000].mean()) < 1e-12


def test_without_gravity_the_ball_flies_straight() -> None:
    time, x = ball(motion("horizontal"))
    first = slice(0, int(arrivals(motion("horizontal"))[0]) + 1)
    speed = np.diff(x[first]) / np.diff(time[first])
    np.testing.assert_allclose(speed, speed[0], rtol=1e-9)


@pytest.mark.slow
def test_what_is_not_periodic_is_drawn_and_named() -> None:
    chaotic, rest = motion("chaotic"), motion("rest")
    assert chaotic.attractor.cycle is None
    assert rest.attractor.cycle is None
    for draw, panels in ((figure_3, 4), (figure_6, 2)):
        drawn = draw([chaotic, rest])
        assert len(drawn.axes) == panels
        assert any("not periodic" in text for text in texts_of(drawn))
        assert any(rest.attractor.outcome.value in text for text in texts_of(drawn))
        marks = of_look(drawn.axes[panels // 2 - 1], BOTTOM_IMPACT) + of_look(drawn.axes[panels // 2 - 1], TOP_IMPACT)
        assert sum(map(len, marks)) == len(arrivals(chaotic)) > 3
    told = alt_text(Task.FIGURE_3, portrait_facts(Task.FIGURE_3, [chaotic, rest], []))
    assert "Lyapunov exponent" in told
    assert not re.search(r"\b(nan|inf|None)\b|None", told)


def test_a_ball_at_rest_lies_on_the_bottom() -> None:
    (panel,) = figure_6([motion("rest")]).axes
    (path,), (low,) = of_look(panel, BALL), of_look(panel, BOTTOM_MEMBRANE)
    np.testing.assert_array_equal(path, low)


def test_a_ride_on_the_membrane_is_part_of_the_curve() -> None:
    shown = motion("sticking")
    assert shown.attractor.cycle.sticks
    assert len(rides(shown))
    time, x = ball(shown)
    assert np.diff(time).max() < 0.05
    assert np.abs(np.diff(x)).max() < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("count", first(1, [4, 1, 2, 8]))
@pytest.mark.parametrize("draw", [figure_3, figure_6])
def test_many_motions_fit_a_page(draw, count: int) -> None:
    shown = [motion(name) for name in (*PAPER, "chaotic", "rest", "sticking", "doubled")][:count]
    drawn = draw(shown, "f = 2 Hz, M = 0.1245 kg, r = 0.5")
    assert drawn.get_figheight() < 8.2
    titles = "\n".join(axes.get_title(loc="left") for axes in drawn.axes)
    assert "".join(re.findall(r"^\((\w)\)", titles, re.MULTILINE)) == "abcdefghijklmnop"[: len(drawn.axes)]
    assert_readable(drawn)


@pytest.mark.slow
def test_every_word_is_in_the_diagrams_legend() -> None:
    check = simulated_study().crosscheck
    drawn = figure_diagram(simulated_study(), check.diagram, check.values, check.groups.d)
    assert {"BT", "BTBT"} <= {label for label in check.diagram.labels if label in texts_of(drawn)}
    (panel,) = drawn.axes
    points = sum(len(line.get_xdata()) for line in panel.lines if line.get_zorder() == 3.0)
    assert points == len(check.diagram.index)
    drawn_at = np.concatenate([line.get_ydata() for line in panel.lines if line.get_zorder() == 3.0])
    assert panel.get_ylim()[0] < drawn_at.min() < drawn_at.max() < panel.get_ylim()[1]


def diagram_of(labels: list[str | Outcome], repeats: int = 3) -> Diagram:
    count = repeats * len(labels)
    label = np.tile(np.arange(len(labels)), repeats)
    wall = np.where(np.arange(count) % 2, -1, 1).astype(np.int8)
    return Diagram(np.arange(count) % 31, wall, np.zeros(count), np.linspace(0.1, 1, count), label, tuple(labels))


@pytest.mark.slow
def test_many_words_are_named_up_to_eight() -> None:
    study = simulated_study()
    check = study.crosscheck
    words = ["B" * k + "T" for k in range(1, 13)]
    outcomes = diagram_of([*words, Outcome.APERIODIC])
    drawn = figure_diagram(study, outcomes, check.values, check.groups.d)
    assert "other" in texts_of(drawn)
    assert "not periodic" in texts_of(drawn)
    assert len(set(texts_of(drawn)) & set(words)) == len(WORDS) == 8
    assert [name for name, _ in groups(outcomes)][8:] == ["other", "not periodic"]
    assert sum(points.sum() for _, points in groups(outcomes)) == len(outcomes.index)


def test_only_a_ball_that_rests_or_flies_is_said_to_have_no_impacts() -> None:
    check = simulated_study().crosscheck
    outcomes = diagram_of(["BT", *Outcome])
    told = diagram_picture(simulated_study(), outcomes, check.values, check.groups.d).alt
    still = ", or ".join((Outcome.REST, Outcome.HELD, Outcome.FREE))
    still = f"; from some starts the ball ends {still}, which has no impacts."
    assert told.endswith(still)


def test_an_empty_diagram_is_drawn() -> None:
    study = simulated_study()
    none = np.empty(0, dtype=np.int64)
    empty = Diagram(none, none.astype(np.int8), np.empty(0), np.empty(0), none, ())
    drawn = figure_diagram(study, empty, study.crosscheck.values, study.crosscheck.groups.d)
    assert len(drawn.axes) == 1


def test_words_differ_by_shape_and_the_first_in_grey_too() -> None:
    assert len({look["marker"] for look in WORDS}) == len({look["color"] for look in WORDS}) == len(WORDS)
    grey = [float(np.dot(to_rgb(look["color"]), (0.299, 0.587, 0.114))) for look in WORDS[:2]]
    assert abs(grey[0] - grey[1]) > 0.05
    assert BOTTOM_IMPACT["marker"] != TOP_IMPACT["marker"]


def test_long_words_are_shortened() -> None:
    assert short("BBT") == "BBT"
    assert short("BT" * 8) == "(BT)×8"
    assert len(short("B" * 40 + "T")) < 24


@pytest.mark.slow
def test_the_plan_decides_and_the_words_tell_the_numbers() -> None:
    study = simulated_study()
    drawn = {picture.name: picture for picture in pictures(study, simulated_points(study))}
    names = "2", "3", "4", "6", "7", "answer", "device", "diagram", "margins"
    assert list(drawn) == [f"figure-{name}" for name in names]
    for name in ("figure-3", "figure-6"):
        for part in ("F = 5.87 N, d = 0.255", "BTBT, every 2 forcing periods", "r = 0.5"):
            assert part in drawn[name].caption
        for part in ("0.715", "residual"):
            assert part in drawn[name].alt
        assert "F = 5 N" not in drawn[name].caption
    assert "BT at 2" in drawn["figure-diagram"].alt
    assert "31 values" in drawn["figure-diagram"].caption
    for picture in drawn.values():
        assert Image.open(BytesIO(picture.png)).size == tuple(map(int, picture.figure.bbox.size))
        assert picture.title
        assert len(re.findall(r"\.(?= |$)", picture.caption)) <= 2
        assert picture.caption.endswith(".")
        assert picture.alt.endswith(".")
        assert not re.search(r"\b(nan|inf|None)\b", picture.caption + picture.alt)
    count = sum(int((~np.isnan(v)).sum()) for v in simulated_points(study).pairs()[0])
    assert f"circles: {count} impacts" in drawn["figure-2"].caption
    assert f"{count} impacts" in drawn["figure-7"].alt
    assert "imulation" not in drawn["figure-4"].caption
    without = {picture.name: picture for picture in pictures(study)}
    assert "imulation" not in without["figure-2"].caption + without["figure-7"].alt


def test_impacts_without_a_partner_are_drawn_without_warnings() -> None:
    study = simulated_study()
    points = simulated_points(study)
    alone = np.array([[0.5], [np.nan]])
    pairs = (np.append(pair, alone, axis=1) for pair in (points.velocity, points.phase, points.flight))
    (speed, *_) = figure_2(
        study, PairedImpacts(np.append(points.sweep_value, 4.98), np.append(points.d, 0.3), *pairs)
    ).axes
    circles = [line for line in speed.lines if line.get_zorder() == 3.5]
    bottom, top = (int(np.isfinite(line.get_ydata()).sum()) for line in circles)
    assert bottom == top + 1
    assert np.isfinite(speed.get_ylim()).all()
    assert np.isfinite(figure_7(study, points).axes[0].get_ylim()).all()


@pytest.mark.slow
def test_the_analytic_branch_lies_beneath_the_diagram() -> None:
    study = simulated_study()
    check = study.crosscheck
    (panel,) = figure_diagram(study, check.diagram, check.values, check.groups.d).axes
    lines = [line for line in panel.lines if line.get_zorder() == 2.4]
    rows = sum(part.rows.stop - part.rows.start for part in stretches(study.solution) if part.stable)
    assert sum(np.isfinite(line.get_xdata()).sum() for line in lines) == 2 * rows


SCRIPT = """
import hashlib
from figure_cases import PAPER, motion
from vireport.figures.vector import png
from vireport.figures.portraits import figure_3, figure_6
for draw in (figure_3, figure_6):
    print(hashlib.sha256(png(draw([motion(name) for name in PAPER]))).hexdigest())
"""


@pytest.mark.slow
def test_the_bytes_are_the_same_whatever_the_user_has_set(tmp_path: Path) -> None:
    here = [hashlib.sha256(png(draw([motion(name) for name in PAPER]))).hexdigest() for draw in (figure_3, figure_6)]
    (tmp_path / "matplotlibrc").write_text(
        "font.size: 25\nlines.linewidth: 9\naxes.facecolor: red\ntext.color: green\n"
    )
    paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    environment = os.environ | {"MATPLOTLIBRC": str(tmp_path), "PYTHONPATH": paths, "PYTHONHASHSEED": "7"}
    run = subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True)
    assert run.stdout.split() == here
