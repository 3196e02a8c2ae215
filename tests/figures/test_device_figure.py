"""The sketch of the device and the path of the ball: what is drawn is the motion at the design point."""

from __future__ import annotations

import numpy as np
import pytest
from figure_cases import ROOT, assert_readable, study_of, texts_of

from vireport.figures.device import (
    drawn_motion,
    figure_device,
    picture,
)
from vireport.scenario.loading import load
from vireport.study.study import analyse


def test_the_stable_motion_is_shown() -> None:
    words, _, _ = drawn_motion(study_of("inclined"))
    assert words == "stable node"
    assert words in picture(study_of("inclined")).caption


@pytest.mark.slow
def test_where_the_1_1_motion_is_unstable_the_stable_motion_of_other_impacts_is_shown() -> None:
    study = analyse(load(ROOT / "examples" / "hysteresis.yaml", ("simulation=",)), ["json"])
    word, other, (time, distance) = drawn_motion(study)
    assert (word, other) == ("BBT", True)
    assert [np.sum(np.abs(distance - end) < 1e-9) for end in (0, 1)] == [2 * 2, 2]
    assert time[-1] == pytest.approx(1)
    assert "of one period (the stable motion BBT)." in picture(study).caption
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
