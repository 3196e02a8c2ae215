"""How high a ball comes above a vibrating table: no simulated ball comes higher, and some come nearly as high."""

from __future__ import annotations

from math import inf, pi, sqrt

import numpy as np
import pytest
from msgspec.structs import replace

from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions, SpeedLaw
from vireport.physics.reach import is_table, reach
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import BOTTOM, TOP, check_model, follow_impacts
from vireport.simulation.kernel import WALL
from vireport.simulation.starts import random_starts

HARMONICS = (Harmonic.of(2, 30.0, 40.0), Harmonic.of(3, 20.0, 200.0))


@pytest.mark.parametrize("seed", range(6))
def test_a_top_out_of_reach_is_struck_by_no_ball_in_the_long_run(seed):
    rng = np.random.default_rng(seed)
    bottom, top, gbar = rng.uniform(0.1, 0.8), rng.uniform(0.0, 0.9), rng.uniform(0.05, 1.0)
    groups = Groups(1.0, gbar, Restitutions(bottom, top), HARMONICS if seed % 2 else ())
    least = reach(groups)
    d = 1.001 * least
    # Thrice as fast as what reaches the top, so that every start strikes it before it comes down.
    starts = random_starts(d, 3 * sqrt(2 * gbar * d), 10, seed)[0]
    model = np.repeat(check_model(groups._replace(d=d)), len(starts), axis=0)
    rows, _ = follow_impacts(model, starts, 300, compiled=False)
    assert (rows[:, :, WALL] == TOP).any()
    last = rows[:, 100:, WALL]
    assert set(last[np.isfinite(last)].tolist()) <= {BOTTOM}


@pytest.mark.parametrize("restitution", [0.15, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("periods", [1, 2, 5])
def test_it_is_at_most_a_few_times_as_high_as_a_ball_comes(restitution, periods):
    # The motion with one impact in n periods begins at Gamma = n pi (1 - r)/(1 + r), Luck and Mehta (1993), where the
    # table strikes the ball at its largest speed.
    gbar = (1 + restitution) / (periods * pi * (1 - restitution))
    height = gbar * periods**2 / 2
    assert 1 < reach(Groups(1.0, gbar, restitution)) / height < 3


@pytest.mark.parametrize(("bottom", "top"), [(0.5, 0.5), (0.2, 0.8), (0.8, 0.2)])
def test_it_is_the_height_of_bounces_that_gain_all_that_they_can(bottom, top):
    # Of a sine: impulse and path are 1. What the fall from the top adds is the most for any speed at the top.
    gbar, speed, travel = 0.3, 1 / pi, 1 / pi**2
    strikes = np.linspace(0.0, 10.0, 100_001)
    added = ((top * strikes + (1 + 2 * top) * speed) ** 2 - strikes**2).max() + 8 * gbar * travel
    leaves = speed
    for _ in range(200):
        leaves = bottom * sqrt(leaves**2 + added) + (1 + bottom) * speed
    assert reach(Groups(1.0, gbar, Restitutions(bottom, top))) == pytest.approx(leaves**2 / (2 * gbar) + 2 * travel)


def test_of_a_ball_that_nothing_draws_down_it_is_not_known():
    assert reach(Groups(1.0, 0.0, 0.5)) == inf
    assert reach(Groups(1.0, 0.5, Restitutions(0.5, 1.0))) == inf
    assert reach(Groups(1.0, 0.5, Restitutions(1.0, 0.5))) == inf
    assert reach(Groups(1.0, 0.5, 0.5, friction=0.1)) == inf
    assert reach(Groups(1.0, 0.5, SpeedLaw(0.5, 0.5, -0.1, 1.0))) == inf


@pytest.mark.parametrize(
    ("parameter", "easier"),
    [
        (Parameter.LENGTH, 2.0),
        (Parameter.AMPLITUDE, 0.5),
        (Parameter.FREQUENCY, 2.0),
        (Parameter.INCLINATION, 1.5),
        (Parameter.RESTITUTION, 0.5),
    ],
)
def test_along_a_sweep_the_end_counts_at_which_the_ball_comes_higher(parameter, easier):
    device = Device(1.0, 0.5, 9.81, 1.0, 12.0, 10.0, 60.0)
    shortest = reach(device.groups(Parameter.LENGTH, 1.0)) / device.groups(Parameter.LENGTH, 1.0).d
    longer, shorter = (device.with_values({Parameter.LENGTH: share * shortest}) for share in (1.001, 0.999))
    value = longer.value_of(parameter)
    assert is_table(longer, parameter, (value, easier * value))
    nearest = shorter.value_of(parameter)
    assert not is_table(shorter, parameter, (nearest, easier * nearest))
    between = (value * easier**share for share in (0.25, 0.5, 0.75))
    assert all(is_table(longer, parameter, (inside,)) for inside in between)


def test_the_design_point_counts_besides_the_ends_of_a_sweep() -> None:
    device = Device(1.0, 0.5, 9.81, 0.01, 12.0, 10.0, 90.0)
    assert not is_table(device, Parameter.LENGTH, (0.5, 1.0))
    table = device.with_values({Parameter.LENGTH: 0.7})
    assert is_table(table, Parameter.LENGTH, (0.5, 1.0))
    assert not is_table(table, Parameter.LENGTH, (0.01, 1.0))


def test_a_device_that_states_the_mass_of_its_ball_is_no_table() -> None:
    device = Device(1.0, 0.5, 9.81, 0.7, 10.0, 10.0, 90.0)
    assert is_table(device, Parameter.LENGTH)
    assert not is_table(replace(device, ball_mass_kg=0.004), Parameter.LENGTH)
