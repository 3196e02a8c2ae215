"""Devices whose restitution falls with speed: motions and ends of stable motion against the raw map in 40 digits."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from conftest import first
from exact_device import held_ends, held_motions
from msgspec.structs import replace
from raw_flights import Flights

from vireport.base.errors import NumericalError
from vireport.design.effects import Effect, shifts
from vireport.design.from_rest import StartingDevice, Target, from_rest
from vireport.design.lines import Line
from vireport.design.margins import margins_of
from vireport.design.point import design_point, motions_at
from vireport.design.speed_law import constant, motions_under_law
from vireport.motions.events import Event
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Restitutions, SpeedLaw
from vireport.physics.motion import Symmetry
from vireport.scenario.blocks import CapsuleMotion, LeftOut
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import BOTTOM, Impact, check_model, follow_one
from vireport.simulation.kernel import VELOCITY

PAPER = Device(0.1245, SpeedLaw(0.5, 0.5, -0.1, 2.0), 9.8, 0.6934, 3.0, 2.0, 45.0)
LEVEL = replace(PAPER, length_m=0.5554, inclination_deg=0.0)
FREE = {"capsule": CapsuleMotion.FREE, "ball_mass_kg": 0.0041}
PARTS = (Harmonic.of(2, 3.0, 200.0), Harmonic.of(3, 2.0, 10.0))


def random_device(rng: np.random.Generator, **more: object) -> Device:
    bottom, top = rng.uniform(0.2, 0.8, 2).tolist()
    law = SpeedLaw(bottom, bottom if rng.random() < 0.4 else top, rng.uniform(-0.3, -0.01), rng.uniform(0.5, 6.0))
    angle = 0.0 if rng.random() < 0.3 else rng.uniform(1, 60)
    return replace(Device(0.1245, law, 9.8, rng.uniform(0.3, 1.2), 3.0, 2.0, angle), **more)


KINDS = {"alone": {}, "harmonics": {"harmonics": PARTS}, "free": FREE, "both": FREE | {"harmonics": PARTS}}


@pytest.mark.parametrize("kind", first(2, KINDS))
def test_motions_are_those_of_the_raw_map(kind: str) -> None:
    rng = np.random.default_rng(25)
    assert sum(held_motions(random_device(rng, **KINDS[kind])) for _ in range(3)) >= 3


@pytest.mark.parametrize("count", [2, pytest.param(8, marks=pytest.mark.slow)])
def test_ends_of_stable_motion_are_those_of_the_raw_map(count: int) -> None:
    rng, held = np.random.default_rng(3), 0
    while held < count:
        held += held_ends(random_device(rng, inclination_deg=45.0), (DesignInput.FREQUENCY, DesignInput.CAPSULE_MASS))


@pytest.mark.parametrize("device", first(1, [PAPER, LEVEL]), ids=["inclined", "level"])
def test_derivatives_are_those_of_the_ends_of_other_devices(device: Device) -> None:
    """Of the mass, the force and the frequency, too, with which the speed changes at which restitutions are stated."""
    kinds = (Event.PITCHFORK,) if device is LEVEL else (Event.PERIOD_DOUBLING,)
    end = next(margin for margin in design_point(device, None).margins if margin.event in kinds)
    assert end.parameter is DesignInput.FREQUENCY
    for varied in (DesignInput.CAPSULE_MASS, DesignInput.AMPLITUDE, DesignInput.RESTITUTION):
        values, step = [], 1e-5 * device.value_of(varied)
        for sign in (-1, 1):
            other = device.with_values({varied: device.value_of(varied) + sign * step})
            found = margins_of(other, motions_at(other, Parameter.LENGTH)[0], [Line.FREQUENCIES], (-1.0,)).margins
            values.append(next(margin.sweep_value for margin in found if margin.event is end.event))
        assert end.derivatives[varied] == pytest.approx((values[1] - values[0]) / (2 * step), rel=1e-6), varied


def test_the_end_is_where_the_table_of_effects_has_it() -> None:
    plain = replace(PAPER, restitution=0.5)
    (row,) = shifts(plain, design_point(plain, None), [Effect(LeftOut.RESTITUTION_SPEED, -0.1, 2.0)]).rows
    end = design_point(PAPER, None).endings()[0]
    assert row.event is end.event
    assert row.value == pytest.approx(end.sweep_value, rel=1e-12)


def test_the_period_of_a_simulated_ball_doubles_where_the_margin_says() -> None:
    end = design_point(PAPER, None).endings()[0]
    for share, doubled in ((1 + 1e-3, False), (1 - 1e-3, True)):
        device = PAPER.with_values({end.parameter: end.sweep_value * share})
        model = check_model(device.groups(Parameter.LENGTH, device.length_m))[0]
        point = end.point.closed
        start = (BOTTOM, 0.0, point.velocity_bottom * 1.001, point.phi_bottom)
        rows, _ = follow_one(model, start, 4000, compiled=False)
        bottom = rows[rows[:, 0] == BOTTOM][-8:, VELOCITY]
        assert bool(abs(bottom[-1] - bottom[-2]) > 1e-3) is doubled
        assert abs(bottom[-1] - bottom[-3]) < 1e-3


@pytest.mark.parametrize("count", [3, pytest.param(50, marks=pytest.mark.slow)])
def test_random_starts_find_no_motion_that_is_not_listed(count: int) -> None:
    """But for those with an impact at the largest restitution, where the law bends: these are counted as lost."""
    rng, found = np.random.default_rng(1), 0
    for _ in range(count):
        device = random_device(rng)
        motions, *_ = motions_at(device, Parameter.LENGTH)
        groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
        law, flights = groups.restitution, Flights(groups, ops=np)
        for x in flights.from_anywhere(rng, 40):
            if flights.gap(*x) <= 0:
                continue
            v0, v1, t0, _ = x
            if max(law.at(1, v0)[0], law.at(-1, v1)[0]) >= 0.99:
                assert motions_under_law(device, motions_at(constant(device), Parameter.LENGTH)[0]).lost
                continue
            turned = np.abs((np.pi * t0 - motions.phi_bottom + np.pi) % (2 * np.pi) - np.pi)
            away = np.maximum(np.abs(motions.velocity_bottom - v0), np.abs(motions.velocity_top - v1))
            assert np.maximum(turned, away).min(initial=np.inf) < 1e-6, (device, v0, v1)
            found += 1
    assert found > 20 * count


def test_motions_part_at_a_pitchfork_on_the_way_to_the_law() -> None:
    """Symmetric for a constant restitution, asymmetric and stable with the law: each with its mirror image."""
    device = replace(LEVEL, length_m=0.4, restitution=SpeedLaw(0.5, 0.5, -0.2, 6.0))
    plain, *_ = motions_at(constant(device), Parameter.LENGTH)
    assert plain.stable_mask.any()
    motions, families, _ = motions_at(device, Parameter.LENGTH)
    assert not plain.u.any()
    first, second = (k for k, family in enumerate(families) if family is Symmetry.ASYMMETRIC)
    assert motions.stable_mask.tolist() == [True, True, False, False]
    assert motions.u[first] == pytest.approx(-motions.u[second], rel=1e-12)
    assert motions.velocity_bottom[first] == pytest.approx(-motions.velocity_top[second], rel=1e-12)


def test_a_law_that_takes_a_stable_motion_to_the_largest_restitution_is_refused() -> None:
    device = replace(PAPER, restitution=SpeedLaw(0.5, 0.5, -0.5, 50.0))
    with pytest.raises(NumericalError, match=r"device\.restitution_exponent: got -0\.5, with which the restitution"):
        design_point(device, None)


def test_without_motions_there_are_none() -> None:
    """Of a capsule so long that the ball never comes across."""
    device = replace(PAPER, length_m=5.0)
    found = motions_under_law(device, motions_at(constant(device), Parameter.LENGTH)[0])
    assert found.motions == ()
    assert found.lost == 0


def test_the_motion_from_rest_is_there_though_nothing_leads_to_it() -> None:
    """None of the constant restitution is followed: the motion, and with it the one that it meets at a fold."""
    (told,) = motions_under_law(PAPER, motions_at(constant(PAPER), Parameter.LENGTH)[0].select([])).motions
    motions, *_ = motions_at(PAPER, Parameter.LENGTH)
    assert float(told.x[0]) == pytest.approx(motions.velocity_bottom[motions.stable_mask][0], rel=1e-14)


SLOW_IMPACTS = replace(LEVEL, capsule_mass_kg=0.3, frequency_hz=3.0)
"""The unit of velocity is 5/3 m/s."""

BECOME_MOTIONS = {
    "a_symmetric_one": replace(SLOW_IMPACTS, length_m=0.0539, restitution=SpeedLaw(0.2956, 0.2956, -0.284, 1.653)),
    "only_with_the_law": replace(SLOW_IMPACTS, length_m=0.1324, restitution=SpeedLaw(0.1296, 0.1296, -0.2476, 4.07)),
}


@pytest.mark.parametrize("device", BECOME_MOTIONS.values(), ids=BECOME_MOTIONS)
def test_stable_motions_of_a_law_that_no_motion_of_a_constant_one_leads_to(device: Device) -> None:
    """What they come from passes through a membrane, or there is nothing that they come from."""
    assert not motions_at(constant(device), Parameter.LENGTH)[0].stable_mask.any()
    motions, *_ = motions_at(device, Parameter.LENGTH)
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    cycle = find_attractor(groups, Impact(BOTTOM, 0.0, pi / 2)).cycle
    assert cycle is not None
    assert cycle.word == "BT"
    bottom = int(np.argmax(cycle.wall))
    off = np.abs(motions.velocity_bottom - cycle.velocity[bottom]) + np.abs(motions.phi_bottom - cycle.phase[bottom])
    assert off[motions.stable_mask].min() < 1e-8


@pytest.mark.slow
def test_what_is_reached_from_rest_is_listed() -> None:
    """Of devices with low and high restitutions, stated at speeds much below and above those of the impacts."""
    rng, reached = np.random.default_rng(12), 0
    while reached < 40:
        r, span = rng.uniform(0.1, 0.8), np.exp(rng.uniform(np.log(0.03), np.log(0.6)))
        law = SpeedLaw(r, r if rng.random() < 0.6 else r * rng.uniform(0.8, 1.1), -rng.uniform(0.05, 0.3), 0.0)
        law = replace(law, speed=rng.uniform(0.3, 5.0))
        parts = () if rng.random() < 0.8 else PARTS
        angle = 0.0 if rng.random() < 0.5 else rng.uniform(0.5, 30)
        device = replace(SLOW_IMPACTS, restitution=law, length_m=span * 1.11, inclination_deg=angle, harmonics=parts)
        try:
            motions, *_ = motions_at(device, Parameter.LENGTH)
        except NumericalError:  # with an impact at the largest restitution
            continue
        end = from_rest(
            StartingDevice(device.groups(Parameter.LENGTH, device.length_m).as_floats(), Target.of(motions))
        )
        reached += end.is_one_to_one
        if end.is_one_to_one:
            assert end.cycle is None, device  # come near to one that is listed


def test_restitutions_of_a_law_have_a_slope_and_constant_ones_none() -> None:
    assert Restitutions(0.4, 0.6).slopes == (0.4, 0.6)
    assert Restitutions(0.4, 0.6, 0.9).slopes == pytest.approx((0.36, 0.54), rel=1e-15)
    motions, *_ = motions_at(PAPER, Parameter.LENGTH)
    law = PAPER.groups(Parameter.LENGTH, PAPER.length_m).as_floats().restitution
    for row in range(len(motions)):
        own = motions.select([row])
        r = law.at(1, own.velocity_bottom[0])[0], law.at(-1, own.velocity_top[0])[0]
        assert (own.restitution.bottom[0], own.restitution.top[0]) == pytest.approx(r, rel=1e-13)
        assert own.decay[0] == pytest.approx(0.9 * r[0] * r[1], rel=1e-13)
