"""Families followed step by step: nothing that happens within a step is missed."""

from __future__ import annotations

import numpy as np
import pytest

from vireport.motions.diagram import solve
from vireport.motions.events import Event
from vireport.motions.paths import Arc, Curve, PathPoint, follow
from vireport.motions.periodicity import model_of
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.numbers import FLOATS
from vireport.scenario.parameters import Parameter


@pytest.mark.parametrize("inclination", [29.26757812, 29.25842285, 29.2580032, 29.257973, 29.25797239])
def test_a_border_that_is_crossed_and_crossed_back_within_a_step_is_seen(inclination: float) -> None:
    # Two period doublings draw together at 29.257972343 degrees: here they are 7e-3 to 2e-5 m apart.
    sweep = Sweep(Device(0.1245, 0.9, 9.8, None, 3.0, 2.0, inclination), Parameter.LENGTH, 0.5, 3.0)
    branch = solve(sweep).branches[1]
    points = [branch.family.critical_points.get(row) for row in range(len(branch.motions))]
    labelled = [p for p in points if p is not None and p.event is Event.PERIOD_DOUBLING and 1.16 < p.sweep_value < 1.18]
    assert len(labelled) == 2
    row = int(np.argmin(np.abs(branch.motions.sweep_value - 1.1)))
    low, high = sweep.coordinate_range
    motion = branch.motions.motion(row, 1)
    curve = Curve(motion.word, model_of(sweep, FLOATS), low, high, high - low)
    x = curve.vector(motion)
    x[-1] = float(branch.motions.d[row])
    way = curve.tangent(x)
    trail = follow(curve, PathPoint(curve, x, way if way[-1] > 0 else -way))
    doublings = [trail.points[k].x[-1] for k, event in trail.events if event is Event.PERIOD_DOUBLING][:2]
    # Where both are all but one, the trace determines each to the root of its rounding only.
    assert doublings == pytest.approx(sorted(p.d for p in labelled), abs=1e-9)


def arc_on(length: float) -> Arc:
    """A step along the motions of the paper's second device."""
    sweep = Sweep(Device(0.1245, 0.5, 9.8, None, 3.0, 2.0, 45.0), Parameter.LENGTH, 0.63, 0.75)
    branch = solve(sweep).branches[0]
    curve, x = branch.family.curve, branch.family.x[len(branch.family.x) // 2]
    start = PathPoint(curve, x, curve.tangent(x))
    return Arc(start, curve.neighbour(Arc(start, start), length))


@pytest.mark.parametrize("stairs", [0.0056, 0.0164, 0.11, 7.1e-6, 8.6e-9])
@pytest.mark.parametrize("zero", [0.155, 0.543, 0.944])
def test_an_event_is_located_where_the_swept_parameter_is_a_staircase(zero: float, stairs: float) -> None:
    """Where rounding keeps secants from settling, bisection finds the step at which the sign changes."""
    arc = arc_on(1e-3)
    first, last = arc.start.x[-1], arc.end.x[-1]

    def value(point: PathPoint) -> float:
        share = float((point.x[-1] - first) / (last - first))
        return (np.floor(share / stairs) + 0.5) * stairs - zero

    size, point = arc.start.path.located(arc, value)
    share = float((point.x[-1] - first) / (last - first))
    assert abs(share - zero) <= stairs
    assert 0 < size < abs(arc.length)


def test_a_gap_that_falls_behind_a_lesser_one_that_stays_is_located() -> None:
    """The least of two margins is flat up to where the other is zero: its secants point nowhere."""
    arc = arc_on(1e-3)
    first, last = arc.start.x[-1], arc.end.x[-1]

    def least(point: PathPoint) -> float:
        return min(1e-9, 0.6 - float((point.x[-1] - first) / (last - first)))

    _, point = arc.start.path.located(arc, least)
    assert (point.x[-1] - first) / (last - first) == pytest.approx(0.6, abs=2e-9)
