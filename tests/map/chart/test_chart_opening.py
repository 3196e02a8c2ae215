"""What a chart opens with: the choice of sentence, facts and status, by what is known of the design point."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES

from vireport import analyse, load
from vireport.map.chart.chart import Chart
from vireport.map.chart.design import ChartedDesign, ChartMargin
from vireport.map.chart.opening import chart_opening, design_ends
from vireport.map.chart.over import plane_of
from vireport.map.chart.plane import DevicePlane
from vireport.map.chart.regions import PIXELS, ChartRegion, Regions, StableMotion
from vireport.map.chart.words import naming
from vireport.motions.events import Event
from vireport.motions.switching import Limits
from vireport.physics.motion import Motion
from vireport.physics.word import Word
from vireport.study.judging.opening import WordedOpening
from vireport.study.study import Study

UP = ChartMargin(0, Event.PERIOD_DOUBLING, 51.6, 6.6, 1e-9, False, None)
DOWN = ChartMargin(1, Event.PITCHFORK, 0.629, -0.0639, None, True, None)


@cache
def plane() -> DevicePlane:
    return plane_of(load(EXAMPLES / "inclined.yaml").scenario, "inclination_deg=0..90,length_m=0.3..1")


@cache
def run() -> Study:
    return analyse(load(EXAMPLES / "inclined.yaml", ["sweep="]))


def stable(*words: str) -> tuple[StableMotion, ...]:
    motions = (Motion(Word.of(word), np.ones(len(word)), np.arange(len(word)), 0.4) for word in words)
    return tuple(StableMotion(motion, 0.0, 0.1, False) for motion in motions)


def charted(design: ChartedDesign | None) -> Chart:
    """A chart of one region, with a design point."""
    region = ChartRegion((45.0, 0.6), 1.0, stable("BT"))
    regions = Regions(plane(), (region,), np.zeros((PIXELS, PIXELS), dtype=np.intp), ())
    return Chart(plane(), Limits(4, 2), (), (), (), regions, design)


def opened(motions: tuple[StableMotion, ...] | None, *margins: ChartMargin, **known: Any) -> WordedOpening:
    chart = charted(ChartedDesign(inputs=(45.0, 0.6929), motions=motions, margins=margins, **known))
    return chart_opening(chart, naming(chart)).worded()


def test_without_a_design_point_it_says_what_is_stable_where() -> None:
    chart = charted(None)
    opening = chart_opening(chart, naming(chart)).worded()
    assert (opening.status, opening.word) == ("neutral", "No design point in the chart")
    assert [text for _, text in opening.facts] == ["BT (1:1): 100 % of the chart."]


@pytest.mark.parametrize(
    ("motions", "status", "word", "sentence"),
    [
        (None, "caution", "Not resolved", "Rounding hides what is stable at the design point."),
        ((), "bad", "Not stable", "It does not run: no motion of up to 4 impacts is stable."),
        (stable("BBT"), "caution", "Stable, but not 1:1", "It runs, but not as a 1:1 motion: BBT is stable."),
        (
            stable("BT"),
            "caution",
            "Stable, not judged",
            "BT is stable; a run of the design point ends without results.",
        ),
    ],
)
def test_where_no_run_of_a_1_1_motion_judges_it(motions, status: str, word: str, sentence: str) -> None:
    opening = opened(motions)
    assert (opening.status, opening.word, opening.sentence) == (status, word, sentence)


def test_a_stable_1_1_motion_is_judged_by_its_run_alone() -> None:
    opening, judged = opened(stable("BT"), UP, DOWN, study=run()), run().opening.worded()
    assert (opening.status, opening.word, opening.sentence) == (judged.status, judged.word, judged.sentence)
    assert opening.tiles == judged.tiles


def test_ends_are_said_with_their_side_and_what_happens_there() -> None:
    chart = charted(ChartedDesign(inputs=(45.0, 0.6929), motions=stable("BT"), margins=(UP, DOWN)))
    assert [(end.status, end.said.words()) for end in design_ends(chart, naming(chart))] == [
        ("neutral", "In inclination BT is stable up to 51.6° (+15 %): period doubling."),
        ("neutral", "In length BT is stable down to 0.629 m (−9.2 %): another motion takes over."),
    ]
    near = ChartMargin(0, Event.FOLD, 0.5, 0.5, None, False, None)
    chart = charted(ChartedDesign(inputs=(0.0, 0.6929), motions=stable("BT"), margins=(near,)))
    assert [end.said.words() for end in design_ends(chart, naming(chart))] == [
        "In inclination BT is stable up to 0.5° (+0.5°): fold.",
        "No end of BT was found in length.",
    ]


def test_an_end_within_two_per_cent_is_a_caution() -> None:
    margins = [ChartMargin(1, Event.FOLD, 1 + share, share, None, False, None) for share in (0.0199, -0.0201)]
    for margin, status in zip(margins, ("caution", "neutral"), strict=True):
        chart = charted(ChartedDesign(inputs=(45.0, 1.0), motions=stable("BT"), margins=(margin,)))
        assert [end.status for end in design_ends(chart, naming(chart))] == ["neutral", status]
