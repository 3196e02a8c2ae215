"""Words of a device whose membranes are not alike: what a simulation reaches lies on a family, and none is mirrored."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import first

from vireport.motions.atlas.families import atlas
from vireport.motions.sweep import Sweep
from vireport.motions.switching import Limits
from vireport.physics.device import Device
from vireport.physics.groups import Restitutions
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import attractors
from vireport.simulation.starts import random_starts


@pytest.mark.parametrize(("inclination", "low", "high"), first(1, [(45.0, 0.85, 1.0), (0.0, 0.2, 0.5)], unpacked=True))
def test_cycles_of_the_simulation_lie_on_families(inclination: float, low: float, high: float) -> None:
    device = Device(0.1245, Restitutions(0.45, 0.55), 9.8, None, 3.0, 2.0, inclination)
    found = atlas(Sweep(device, Parameter.LENGTH, low, high), Limits(3, 1))
    seen = 0
    for value in np.linspace(low, high, 9)[1:-1]:
        groups = device.groups(Parameter.LENGTH, value).as_floats()
        (ends,) = attractors(groups, random_starts([groups.d], 1.5, 4, 3))
        stable = [motion for _, motion in found.stable_at(value)]
        for end in ends:
            if end.cycle is None or end.cycle.sticks or end.period > 1 or len(end.word) > 3:
                continue
            own = [motion for motion in stable if motion.word.canonical().letters == end.word]
            gaps = [np.abs(np.sort(motion.velocity) - np.sort(end.cycle.velocity)).max() for motion in own]
            assert min(gaps) < 1e-7, (value, end.word)
            seen += 1
    assert seen > 2
    if not inclination:  # what strikes the top twice is no mirror image of what strikes the bottom twice
        assert {family.word.canonical().letters for family in found.families} >= {"BBT", "BTT"}
    for family in found.families:
        walls = family.word.walls
        product = 0.45 ** walls.count(1) * 0.55 ** walls.count(-1)
        assert family.determinant == pytest.approx(product**2, rel=1e-14)
