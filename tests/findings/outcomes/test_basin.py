"""Basins on the section of impacts: each point is what the simulation makes of that impact."""

from __future__ import annotations

import numpy as np
import pytest
from devices import case

from vireport.findings.outcomes.basin import basins_of
from vireport.findings.outcomes.returning import Recogniser
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import Outcome, find_attractor
from vireport.simulation.events import BOTTOM, Impact, start_of


def test_points_and_shares_are_those_of_impacts_followed_one_by_one() -> None:
    device = case(3.6)
    found = basins_of(device.groups, device.stable, device.unit, 33)
    plane, rng = found.plane, np.random.default_rng(3)
    assert {of.outcome for of in plane.outcomes} == {Outcome.PERIODIC, Outcome.STICKING}
    for row, column in rng.integers(0, 33, (30, 2)).tolist():
        start = Impact(BOTTOM, float(plane.y[row]), float(plane.x[column]))
        assert find_attractor(device.groups, start).name == plane.outcomes[plane.outcome[row, column]].name
    shares = {name: (low, high) for name, _, low, high in found.shares}
    assert found.impacts == sum(found.hits) == 4000
    low, high = shares["BT every forcing period"]
    assert low < 0.853 < high
    assert high - low < 0.03
    assert plane.share(0) == pytest.approx(0.853, abs=0.03)
    # The motion's own impact lies in its basin.
    motion = device.stable[0]
    at = np.argmin(np.abs(plane.y - motion.velocity[0])), np.argmin(np.abs(plane.x - motion.phase[0]))
    assert plane.outcome[at] == 0


def test_where_no_motion_is_known_all_that_is_met_is_learnt() -> None:
    device = Device(3.155, 0.46, 9.8, 0.0446, 3.0, 2.0, 54.8)
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    recognise = Recogniser(groups, (), compiled=False)
    rows = np.array([(BOTTOM, 0.0, velocity, phase) for velocity in (0.2, 1.0) for phase in (0.3, 3.0)])
    found = recognise(rows)
    alone = [find_attractor(groups, start_of(row), 100_000, compiled=False).outcome for row in rows]
    assert [recognise.outcomes[k].outcome for k in found] == alone
