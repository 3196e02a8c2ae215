"""Words of unlike membranes and of a force that is no sine: by raw flights in 40 digits, and the simulation."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import first
from mpmath import mp, mpf
from msgspec.structs import replace
from raw_flights import Flights

from vireport.motions.atlas.families import atlas
from vireport.motions.events import Event
from vireport.motions.families import Atlas, Claim
from vireport.motions.sweep import Sweep
from vireport.motions.switching import Limits
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Restitutions
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import attractors
from vireport.simulation.starts import random_starts
from vireport.study.checks import reference

PARTS = [(2, 5.0, 225.0), (3, 4.0, 30.0)]
"""Order, per cent and phase in degrees."""


def swept(inclination: float, low: float, high: float, restitution: float | Restitutions = 0.5) -> Sweep:
    device = Device(0.1245, restitution, 9.8, None, 3.0, 2.0, inclination)
    harmonics = tuple(Harmonic.of(*part) for part in PARTS)
    return Sweep(replace(device, harmonics=harmonics), Parameter.LENGTH, low, high)


def checked(found: Atlas, every: int = 1) -> dict[Event, int]:
    """Motions and events of families, by default of all, against raw flights: how many events there were of each."""
    counts = dict.fromkeys(Event, 0)
    harmonics = [(j, mpf(p) / 100, mpf(psi) * mp.pi / 180) for j, p, psi in PARTS]
    for family in found.families[::every]:
        walls, periods = family.word.walls, 2 * family.word.periods
        marks = {mark.row: mark for mark in family.marks}
        for row in {len(family.x) // 2, *marks}:
            if np.abs(family.velocity[row]).min() < 1e-6:
                continue
            mark = marks.get(row)
            point = mark.point if mark is not None else None
            motion = family.curve.motion(family.x[row]) if point is None else point.motion
            flights = Flights(family.model.groups(motion.coordinate).as_floats(), harmonics)
            if mark is not None and mark.event is Event.FOLD:
                continue  # two motions meet, and neither is next to the one in doubles by Newton's method
            if motion.word != family.word:
                continue
            velocity, start, trace, determinant = flights.periodic(walls, motion.velocity[0], motion.time, periods)
            assert abs(velocity - mpf(float(motion.velocity[0]))) < 1e-10
            assert abs(start - mpf(float(motion.time[0]))) < 1e-10
            assert abs(determinant - mpf(family.determinant)) < mpf(10) ** -14
            if mark is None:
                assert abs(trace - mpf(float(family.trace[row]))) < 1e-8 * (1 + abs(trace))
            elif mark.event is Event.PERIOD_DOUBLING:
                assert abs(trace + 1 + determinant) < 1e-9
                counts[mark.event] += 1
            elif mark.event is Event.NODE_FOCUS:
                assert abs(abs(trace) - 2 * mp.sqrt(determinant)) < 1e-9
                counts[mark.event] += 1
    return counts


@pytest.mark.slow
def test_motions_of_other_words_are_those_of_the_raw_flights_in_40_digits() -> None:
    found = atlas(swept(45.0, 0.62, 0.75), Limits(4, 2))
    with reference.precise():
        counts = checked(found)
    assert counts[Event.PERIOD_DOUBLING] >= 1
    assert counts[Event.NODE_FOCUS] >= 1
    assert {"BT", "BTBT"} <= {family.word.letters for family in found.families}
    assert {of.word for of in found.completeness if of.claim is Claim.COMPLETE} == {"BT", "T", "TT", "TTT", "TTTT"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("inclination", "low", "high", "restitution"),
    [(0.0, 0.2, 0.5, 0.5), (20.0, 0.5, 0.8, Restitutions(0.45, 0.55))],
)
def test_every_periodic_attractor_lies_on_a_family(inclination, low, high, restitution) -> None:
    """Of words that the simulation reaches too: they are starts of the search."""
    sweep = swept(inclination, low, high, restitution)
    values = np.linspace(low, high, 9)
    simulated = []
    for value in values:
        groups = sweep.device.groups(sweep.parameter, value).as_floats()
        (ends,) = attractors(groups, random_starts([groups.d], 1.5, 6, 3))
        simulated += [
            end.cycle.motion(float(sweep.coordinate_of(value)))
            for end in ends
            if end.cycle is not None and not end.cycle.sticks and len(end.cycle.wall) <= 4 and end.cycle.period <= 2
        ]
    assert len({motion.word.canonical().letters for motion in simulated}) > 1
    joined = atlas(sweep, Limits(4, 2))
    found = atlas(sweep, Limits(4, 2), simulated)
    assert len(found.families) >= len(joined.families)
    for motion in simulated:
        others = (other for family in found.families for other in family.at(motion.coordinate))
        assert min(motion.distance(other) for other in others) < 1e-9
    with reference.precise():
        checked(found, 3)


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
