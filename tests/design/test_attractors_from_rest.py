"""The circles of figures 2 and 7: what a ball from rest comes to along a sweep, beside the analytic motions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vireport import analyse, load
from vireport.design.attractors_from_rest import VALUES, attractors_from_rest
from vireport.design.from_rest import Destination
from vireport.design.outcomes_from_rest import outcomes_at
from vireport.design.point import motions_at
from vireport.figures.captions import shown_along
from vireport.figures.curves import simulated_points
from vireport.physics.device import Device
from vireport.scenario.parameters import DesignInput
from vireport.study.plan import Task
from vireport.study.study import sweep_of
from vireport.text.templates import Words

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def sweep(name: str, *changes: str):
    return sweep_of(load(EXAMPLES / f"{name}.yaml", changes).scenario)


@pytest.mark.parametrize(("name", "found"), [("inclined", 16), ("horizontal", 19), ("inclined-forcing", 14)])
def test_what_a_ball_from_rest_comes_to_is_the_stable_motion(name: str, found: int) -> None:
    along, checked = sweep(name), 0
    for met in attractors_from_rest(along):
        if not met.end.reached:
            continue
        cycle = met.motion
        assert cycle is not None
        device = Device.of(load(EXAMPLES / f"{name}.yaml").scenario)
        device = device.with_values({DesignInput(along.parameter): met.value})
        motions = motions_at(device, along.parameter)[0]
        stable = motions.select(motions.stable_mask)
        bottom, top = cycle.wall > 0, cycle.wall < 0
        apart = np.abs(stable.velocity_bottom - cycle.velocity[bottom])
        apart += np.abs(stable.velocity_top - cycle.velocity[top])
        apart += np.abs(np.exp(1j * stable.phi_bottom) - np.exp(1j * cycle.phase[bottom]))
        assert apart.min() < 1e-9
        assert met.d == pytest.approx(stable.d[0], rel=1e-14)
        checked += 1
    assert checked >= found


def test_beyond_the_period_doubling_it_comes_to_the_doubled_motion() -> None:
    words = {met.motion and met.motion.word for met in attractors_from_rest(sweep("inclined")) if met.value < 0.628}
    assert words == {"BTBT", None}  # of which one is not settled after some 500 impacts


def test_no_motion_is_met_where_the_ball_stays_at_rest_or_goes_on_irregularly() -> None:
    resting = attractors_from_rest(
        sweep("inclined-forcing", "sweep.from=0.5", "sweep.to=0.8", "excitation.amplitude_n=0.6")
    )
    assert {met.end.destination for met in resting} == {Destination.AT_REST}
    chaotic = sweep("inclined-forcing", "excitation.amplitude_n=6.9375", "sweep.from=6.937", "sweep.to=6.938")
    ends = [met.end for met in attractors_from_rest(chaotic)]
    assert sum(end.decided for end in ends) < VALUES / 2
    assert not [met for met in resting if met.motion is not None]


@pytest.mark.parametrize("name", ["inclined", "horizontal", "inclined-forcing"])
def test_a_short_look_tells_what_following_to_the_end_tells(name: str) -> None:
    along, device = sweep(name), Device.of(load(EXAMPLES / f"{name}.yaml").scenario)
    values = np.array([met.value for met in attractors_from_rest(along)])
    ends = outcomes_at(device, DesignInput(along.parameter), values, compiled=False)
    for met, end in zip(attractors_from_rest(along), ends, strict=True):
        if met.end.decided:
            assert met.end.kind == end.kind
    assert sum(met.end.decided for met in attractors_from_rest(along)) > VALUES - 2


def test_circles_are_said_to_be_of_a_ball_from_rest_where_no_simulation_is_asked_for() -> None:
    study = analyse(load(EXAMPLES / "inclined.yaml"), ("png",))
    shown = shown_along(study, Task.FIGURE_2, simulated_points(study))
    caption = Words("figures/sweep")("figure_2_caption", shown)
    values = sum(met.motion is not None and met.motion.word == "BT" for met in study.attractors_from_rest)
    assert f"impacts of periodic motions that a ball from rest comes to at {values} values" in caption
    asked = analyse(load(EXAMPLES / "inclined.yaml", ("simulation.samples=3", "simulation.starts=1")), ("png",))
    assert asked.attractors_from_rest == ()
    caption = Words("figures/sweep")("figure_2_caption", shown_along(asked, Task.FIGURE_2, simulated_points(asked)))
    assert "impacts of periodic motions at 2 values" in caption


def test_without_figures_nothing_is_simulated_for_them() -> None:
    assert analyse(load(EXAMPLES / "inclined.yaml"), ("json",)).attractors_from_rest == ()
