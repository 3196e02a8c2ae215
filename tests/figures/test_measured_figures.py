"""Measured impacts in figures: where the curves are, within their error bars, in the units of the figures."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from conftest import EXAMPLES

from vireport import load
from vireport.base.shares import NORMAL_95
from vireport.design.solution import solution_of
from vireport.figures.curves import TURN
from vireport.figures.measured import WAYS, bars, draw, flight, impact_marks, legend, phase, speed
from vireport.figures.portraits import AT_END, arrivals, measured_times
from vireport.figures.sweeps import drawing_of, figure_2, figure_4
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.scenario.blocks import Approach
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import BOTTOM, Impact
from vireport.simulation.trajectories import portrait
from vireport.study.measured import measured_of
from vireport.study.plan import plan
from vireport.study.study import Study, sweep_of

KNOWN = {"device.restitution": None, "device.restitution_bottom": 0.52, "device.restitution_top": 0.47}
SWEEP = {"parameter": "length_m", "from": 0.6, "to": 0.75}
RECORD = [{"impacts": "measured-impacts.csv", "force_maximum_s": 0.0}]


@cache
def study() -> Study:
    """The example with a record whose restitutions are known, and a sweep: what its figures need, and no more."""
    loaded = load(EXAMPLES / "measured.yaml", KNOWN | {"sweep": SWEEP, "measured": RECORD})
    solution = solution_of(
        Device.of(loaded.scenario), Membrane.of(loaded.scenario), sweep_of(loaded.scenario), True, None
    )
    return Study(loaded, plan(loaded.scenario), solution, measured=measured_of(loaded))


def stable_at(value: float):
    branch = next(branch for branch in study().solution.branches if branch.motions.stable_mask.any())
    motions = branch.motions
    order = np.argsort(motions.sweep_value)
    return lambda y: float(np.interp(value, motions.sweep_value[order], y[order]))


def test_points_of_figure_2_are_on_the_branch_within_their_bars():
    at, motions = stable_at(0.72), next(b.motions for b in study().solution.branches if b.motions.stable_mask.any())
    curves = (
        (speed, (np.abs(motions.velocity_bottom), np.abs(motions.velocity_top))),
        (lambda own: phase(own, 0.0), (motions.phi_bottom % TURN, motions.phi_top % TURN)),
        (flight, (motions.q, 1 - motions.q)),
    )
    for value, (bottom, top) in curves:
        marks = list(impact_marks(study().measured, value, ("b", "t")))
        assert [mark.color for mark in marks] == ["b", "t"]
        for mark, curve in zip(marks, (bottom, top), strict=True):
            (y,), (low,), (high,) = mark.y, mark.low, mark.high
            # Twice a bar, as six of them may not all hold the truth; a curve between two samples adds its bend.
            assert abs(y - at(curve)) < (high - low) + 1e-5
            assert (high - low) < 1e-3


def drawn_marks(axes):
    """The points of measured motions in a panel."""
    look = WAYS[Approach.NONE][1]
    return [x for x in axes.lines if x.get_marker() == look["marker"] and x.get_markersize() == 3.8]


def test_figures_2_and_4_draw_the_points_and_name_them():
    for figure, count in ((figure_2(study()), 6), (figure_4(study()), 3)):
        drawn = [line for axes in figure.axes for line in drawn_marks(axes)]
        assert len(drawn) == count
        place = drawing_of(study()).axis.of_value(0.72)
        assert {float(x) for line in drawn for x in line.get_xdata()} == {place}
        assert "measured" in {line.get_label() for line in figure.artists}


def test_eigenvalues_are_those_of_the_branch():
    panels = [[float(y) for line in drawn_marks(axes) for y in line.get_ydata()] for axes in figure_4(study()).axes]
    delta, values = [points for points in panels if points]
    design = study().solution.design.motions
    row = int(np.flatnonzero(design.stable_mask)[0])
    assert delta == [pytest.approx(design.discriminant[row], abs=0.01)]
    assert sum(values) == pytest.approx(design.trace[row], abs=0.01)


def test_directions_are_told_apart_and_what_does_not_repeat_is_dots():
    from matplotlib.figure import Figure

    known = measured_of(load(EXAMPLES / "measured-sweep.yaml"))
    axes = Figure().add_subplot()
    draw(axes, impact_marks(known[3:5], speed, ("k", "k")), lambda value: value)
    assert {name for name, _ in legend(known)} == {"measured, upwards", "measured, downwards"}
    up, down = (WAYS[way][1]["marker"] for way in (Approach.UP, Approach.DOWN))
    assert up != down
    draw(axes, impact_marks(known[6:7], speed, ("k", "k")), lambda value: value)
    assert {line.get_marker() for line in axes.lines} >= {up, down}


def test_bars_are_of_95_per_cent():
    from matplotlib.figure import Figure

    shown = study().measured[0].drawn_impacts
    for k, mark in enumerate(impact_marks(study().measured, speed, ("b", "t"))):
        assert mark.high - mark.low == pytest.approx(2 * NORMAL_95 * shown.errors[0][k : k + 1])
    axes = Figure().add_subplot()
    one = np.ones(1)
    bars(axes, one, one, 0.1 * one, {"color": "k", "marker": "o"})
    upright = axes.lines[0]
    assert upright.get_ydata().tolist() == pytest.approx([1 - 0.1 * NORMAL_95, 1 + 0.1 * NORMAL_95])
    bars(axes, one, one, 0.1 * one, {"color": "k", "marker": "o"}, across=True)
    assert axes.lines[2].get_xdata().tolist() == pytest.approx([1 - 0.1 * NORMAL_95, 1 + 0.1 * NORMAL_95])


def test_measured_impacts_stand_at_those_of_a_portrait():
    device = study().solution.device
    groups = device.groups(Parameter.LENGTH, 0.72).as_floats()
    motion = portrait(groups, [Impact(BOTTOM, 1.0, 0.3)])
    own = study().measured[0].drawn_impacts
    t, places = measured_times(motion, own)
    at = arrivals(motion)
    for time, place in zip(t, places, strict=True):
        if AT_END < time < motion.time[-1] - AT_END:
            near = at[np.argmin(np.abs(motion.time[at] - time))]
            assert time == pytest.approx(motion.time[near], abs=1e-3)
            assert own.values[0][place] == pytest.approx(motion.velocity[near], abs=1e-3)
    assert len(t) >= 4
