"""Charts of a ball on a table: the curves of the motion with one impact are those in print."""

from __future__ import annotations

from math import hypot, pi

import numpy as np
import pytest
from conftest import EXAMPLES

from vireport import load
from vireport.map.chart.chart import Chart, loci_over
from vireport.map.chart.opening import chart_opening
from vireport.map.chart.over import chart_of, plane_of
from vireport.map.chart.regions import stable_motions
from vireport.map.chart.words import naming
from vireport.motions.events import Event
from vireport.motions.switching import Limits

OVER = "amplitude_n=9.5..18,restitution=0.4..0.6"
GRAVITY = 9.81


def onset(restitution: float) -> float:
    """Gamma where the motion with one impact a period begins, Luck and Mehta (1993)."""
    return pi * (1 - restitution) / (1 + restitution)


def doubling(restitution: float) -> float:
    """Gamma where its period doubles."""
    return hypot(onset(restitution), 2 * (1 + restitution**2) / (1 + restitution) ** 2)


def test_curves_that_end_the_motion_with_one_impact_are_those_in_print() -> None:
    drawn = loci_over(plane_of(load(EXAMPLES / "bouncing-ball.yaml").scenario, OVER), Limits(1, 1))
    ending = {locus.event: locus.inputs for locus in drawn.loci if locus.bounds_stability.any()}
    assert ending.keys() == {Event.FOLD, Event.PERIOD_DOUBLING}
    for event, of in ((Event.FOLD, onset), (Event.PERIOD_DOUBLING, doubling)):
        force, restitution = ending[event].T
        assert len(force) > 10
        assert np.ptp(restitution) > 0.12
        assert force == pytest.approx([GRAVITY * of(r) for r in restitution], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "status", "sentence"),
    [
        (12.0, "good", "The ball can bounce on the bottom, B every forcing period; from rest it "),
        (10.0, "caution", "No motion of the ball on the bottom is known to be stable; from rest it "),
    ],
)
def test_it_opens_with_what_a_run_says_of_the_table(force: float, status: str, sentence: str) -> None:
    given = [f"excitation.amplitude_n={force}", "motions.impacts=1", "motions.periods=1"]
    chart: Chart = chart_of(load(EXAMPLES / "bouncing-ball.yaml", given), OVER, lambda what: None)
    opening = chart_opening(chart, naming(chart)).worded()
    assert opening.status == status
    assert opening.sentence.startswith(sentence)


@pytest.mark.parametrize(
    ("force", "words"),
    [(12.0, {("B", 1)}), (14.7, {("B", 1), ("BB", 1)}), (15.1, {("BB", 2)}), (16.0, {("BB", 2)}), (17.0, set())],
)
def test_motions_on_the_bottom_alone_are_found_at_a_point(force: float, words: set[tuple[str, int]]) -> None:
    """Those that the families of the example have there."""
    plane = plane_of(load(EXAMPLES / "bouncing-ball.yaml").scenario, OVER)
    stable = stable_motions(plane, (force, 0.5), Limits(2, 2))
    assert stable is not None
    assert {(each.word.letters, each.word.periods) for each in stable} == words


def test_one_impact_is_found_at_every_point_with_a_high_restitution() -> None:
    """The phase hardly changes there over the short sweep on which motions are looked for."""
    table = load(EXAMPLES / "bouncing-ball.yaml", ["device.length_m=3"]).scenario
    plane, restitution = plane_of(table, "amplitude_n=4..12,restitution=0.8..0.95"), 0.9
    for share in np.linspace(0.3, 0.95, 14):
        gamma = onset(restitution) + share * (doubling(restitution) - onset(restitution))
        stable = stable_motions(plane, (GRAVITY * gamma, restitution), Limits(1, 1))
        assert stable is not None
        assert "B" in {each.word.letters for each in stable}
