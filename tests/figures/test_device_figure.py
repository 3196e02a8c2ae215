"""The sketch of the device and the path of the ball: what is drawn is the motion at the design point."""

from __future__ import annotations

import numpy as np
import pytest
from figure_cases import ROOT, assert_readable, study_of, texts_of

from vireport.figures.device import (
    figure_device,
    path,
    picture,
    shown_motion,
)
from vireport.scenario import load
from vireport.study import analyse


@pytest.mark.parametrize("name", ["horizontal", "inclined", "inclination"])
def test_the_ball_flies_from_membrane_to_membrane_and_comes_back(name: str) -> None:
    study = study_of(name)
    motions, n = study.solution.design.motions, study.solution.device.period_ratio
    row = int(np.argmax(motions.stable_mask))
    time, distance = path(motions, row, n)
    half = len(time) // 2
    assert distance[[0, half - 1, half, -1]] == pytest.approx([0, 1, 1, 0], abs=1e-12)
    assert time[[0, half - 1, half, -1]] == pytest.approx([0, n * motions.q[row], n * motions.q[row], n])
    assert ((distance > -1e-12) & (distance < 1 + 1e-12)).all()
    arriving = -motions.d[row] * np.diff(distance)[[half - 2, -1]] / (2 * np.diff(time)[[half - 2, -1]])
    assert arriving == pytest.approx([motions.velocity_top[row], motions.velocity_bottom[row]], rel=0.05)


def test_the_stable_motion_is_shown() -> None:
    words, _, _ = shown_motion(study_of("inclined"))
    assert words == "stable node"
    assert words in picture(study_of("inclined")).caption


@pytest.mark.slow
def test_where_the_1_1_motion_is_unstable_the_stable_motion_of_other_impacts_is_shown() -> None:
    study = analyse(load(ROOT / "examples" / "hysteresis.yaml", ("simulation=",)), ["json"])
    word, other, (time, distance) = shown_motion(study)
    assert (word, other) == ("BBT", True)
    assert [np.sum(np.abs(distance - end) < 1e-9) for end in (0, 1)] == [2 * 2, 2]
    assert time[-1] == pytest.approx(1)
    assert "in one period: the stable motion BBT." in picture(study).caption
    assert "it meets the top after 0." in picture(study).alt


@pytest.mark.parametrize("angle", ["0", "90"])
def test_the_sketch_has_its_values_and_can_be_read(angle: str) -> None:
    study = analyse(load(ROOT / "examples" / "inclined.yaml", (f"inclination_deg={angle}",)), ["json"])
    drawn = figure_device(study)
    assert {f"β = {angle}°", "s = 0.6934 m", "F = 3 N, f = 2 Hz", "M = 0.1245 kg, m = 4.1 g, r = 0.5"} <= set(
        texts_of(drawn)
    )
    assert_readable(drawn)


def test_without_a_design_point_there_is_the_sketch_alone() -> None:
    study = analyse(load(ROOT / "examples" / "inclined.yaml", ("device.length_m=",)), ["json"])
    (sketch,) = figure_device(study).axes
    assert "s = 0.59 to 0.75 m" in [text.get_text() for text in sketch.texts]
