"""Figure 2 of a ball on a table is of all families: those with one impact are where print has them."""

from __future__ import annotations

import re
from math import pi

import numpy as np
import pytest
from conftest import study
from figure_cases import assert_readable, curves, labels, texts_of
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vireport.figures.atlas import STABLE, figure_impacts
from vireport.figures.curves import TURN
from vireport.figures.pictures import pictures
from vireport.figures.sweeps import CIRCLE
from vireport.study.study import Study

R, G, SCALE = 0.5, 9.81, 4 * 0.5 * 10**2
"""Restitution and gravity of the example, and d times the force there."""

LIVELY = "device.restitution=0.15", "sweep.from=20", "sweep.to=29"
"""A sweep in which a ball comes from rest to motions of one and two impacts."""


def table(*over: str) -> Study:
    """The example, as far as no other motion than that with one impact is stable."""
    return study("bouncing-ball", *(over or ("sweep.from=10", "sweep.to=14", "excitation.amplitude_n=12")))


def drawn(ball: Study) -> tuple[Figure, Axes, Axes]:
    assert ball.atlas is not None
    figure = figure_impacts(ball, ball.atlas)
    return figure, *figure.axes[:2]


def speed(gbar: np.ndarray, r: float) -> np.ndarray:
    """Before the impact of the motion with one in a period [y_c]: the fall of a period, 2 gbar, is 1 + r times it."""
    return 2 * gbar / (1 + r)


def sine(gbar: np.ndarray, r: float) -> np.ndarray:
    """Of the phase at that impact, Luck and Mehta (1993)."""
    return pi * gbar * (1 - r) / (1 + r)


@pytest.mark.slow
def test_curves_of_one_impact_are_at_its_speed_and_phase() -> None:
    figure, *panels = drawn(table())
    for axes, expected in zip(panels, (speed, lambda gbar, r: pi - np.arcsin(sine(gbar, r))), strict=True):
        stable = [line for line in curves(axes) if line.get_linewidth() == STABLE["linewidth"]]
        assert stable
        for d, value in (line.get_data() for line in stable):
            gbar = G * np.asarray(d) / SCALE
            assert np.asarray(value) == pytest.approx(expected(np.minimum(gbar, 3 / pi), R), abs=1e-7)
    speeds, phases = panels
    assert "C1" in labels(speeds)
    assert labels(phases) == []
    assert {"design point", "stable", "unstable", "phase φ [rad]"} <= set(texts_of(figure))
    for axes in panels:
        (design,) = (line for line in axes.lines if len(line.get_xdata()) == 2 and np.ptp(line.get_xdata()) == 0)
        assert design.get_xdata()[0] == pytest.approx(SCALE / 12)
    assert_readable(figure)


@pytest.mark.slow
def test_circles_are_what_a_ball_from_rest_comes_to() -> None:
    ball = table(*LIVELY)
    _, speeds, phases = drawn(ball)
    circles = [
        [line.get_data() for line in axes.lines if line.get_markersize() == CIRCLE["markersize"]]
        for axes in (speeds, phases)
    ]
    single = [k for k, (d, _) in enumerate(circles[0]) if len(d) == 1]
    assert len(single) > 3
    for k in single:
        (d, at_speed), (_, at_phase) = (panel[k] for panel in circles)
        gbar = G * np.asarray(d) / SCALE
        assert np.asarray(at_speed) == pytest.approx(speed(gbar, 0.15), rel=1e-6)
        assert np.sin(at_phase) == pytest.approx(sine(gbar, 0.15), abs=1e-6)
        assert np.cos(at_phase) < 0
    assert all(0 <= value < TURN for _, phase in circles[1] for value in phase)
    assert "simulated" in texts_of(drawn(ball)[0])
    (second,) = (picture for picture in pictures(ball) if picture.name == "figure-2")
    assert "; circles: periodic motions that the simulation found." in second.caption
    assert re.search(r"Circles: \d+ simulated motions\.", second.alt)


@pytest.mark.slow
def test_what_is_of_1_1_motions_alone_is_left_out() -> None:
    ball = table()
    reasons = {task: ball.plan.reason(task) for task in ("critical", "figure-answer", "figure-4", "figure-2")}
    nothing = "on a table no motion is 1:1"
    assert reasons == {"critical": nothing, "figure-answer": nothing, "figure-4": nothing, "figure-2": None}
    (second,) = (picture for picture in pictures(ball) if picture.name == "figure-2")
    assert "figure-4" not in {picture.name for picture in pictures(ball)}
    assert second.title == "Impact velocity and phase"
    caption, alt = (text.replace("\u00a0", " ") for text in (second.caption, second.alt))
    assert caption.startswith(
        "Velocity |Ż| in units of F/(2 M f) and phase φ of the force at every impact of the admissible motions, by "
        "their words. s = 0.5 m, f = 10 Hz, β = 90°, M = 1 kg, r = 0.5; F from 10 N to 14 N."
    )
    assert alt == (
        "Two line charts over F from 10 N to 14 N. Families of motions: 1. Stable: B every forcing period for F from "
        "10.3 N to 14 N."
    )


def test_along_a_restitution_no_family_is_known_and_nothing_is_drawn() -> None:
    ball = study(
        "bouncing-ball", "excitation.amplitude_n=12", "sweep.parameter=restitution", "sweep.from=0.4", "sweep.to=0.6"
    )
    assert ball.plan.reason("figure-2") == "on a table no motion is 1:1"
    assert not {"figure-answer", "figure-2", "figure-4"} & {picture.name for picture in pictures(ball)}


@pytest.mark.slow
def test_no_curve_of_phases_is_torn() -> None:
    """Some go through 0 along the sweep of the example."""
    _, _, phases = drawn(study("bouncing-ball"))
    values = [np.asarray(line.get_ydata()) for line in curves(phases)]
    assert min(np.nanmin(y) for y in values) < 0
    assert max(np.nanmax(np.abs(np.diff(y)), initial=0.0) for y in values) < 1
