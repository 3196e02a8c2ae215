"""The event search with restitutions that fall with speed: flights in 40 digits, chatter, where periods double."""

from __future__ import annotations

from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from msgspec.structs import replace
from raw_flights import Flights

from vireport.design.effects import Effect, shifts
from vireport.design.lines import Line, ends_on_curve, model_on_line, stable_ones
from vireport.design.point import design_point
from vireport.design.speed_law import Falling, falling
from vireport.findings.outcomes.deviations import lap_matrix
from vireport.motions.paths import Curve
from vireport.physics import flight
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups, Restitutions, SpeedLaw
from vireport.physics.numbers import FLOATS
from vireport.scenario.blocks import LeftOut
from vireport.scenario.parameters import Parameter
from vireport.simulation.attractors import find_attractor
from vireport.simulation.events import BOTTOM, Impact, InFlight, check_model, check_start, follow_impacts, follow_one
from vireport.simulation.kernel import FLIGHT, PHASE, REST, RIDING, SETTLING, VELOCITY, WALL
from vireport.simulation.starts import random_starts

CAPPED = (-0.1, 0.8, 300), (-0.3, 3.0, 200)
CHATTER = (-0.01, 0.8, 40), *(pytest.param(*own, marks=pytest.mark.slow) for own in CAPPED)
"""Exponent, speed at which it is stated, and hops to follow at least: short of the largest restitution, and with it."""

PARTS = (Harmonic(2, 0.1, -0.05), Harmonic(3, 0.02, 0.07))


@pytest.mark.parametrize("harmonics", [(), PARTS])
@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_each_flight_is_that_of_the_law_in_40_digits(harmonics: tuple[Harmonic, ...], compiled: bool) -> None:
    rng, hard = np.random.default_rng(5), 0
    with mp.workdps(40):
        for _ in range(3):
            law = SpeedLaw(*rng.uniform(0.3, 0.8, 2), rng.uniform(-0.4, -0.01), rng.uniform(0.2, 2))
            groups = Groups(rng.uniform(0.3, 1.0), rng.uniform(0, 0.4), law, harmonics)
            start = check_start(InFlight(0.0, rng.uniform(-1, 1), rng.uniform(0, 6)), groups.d)
            rows, _ = follow_one(check_model(groups)[0], start, 25, compiled=compiled)
            for row, after in pairwise(rows[1:]):
                if row[RIDING] + row[SETTLING] > 0:
                    continue
                before, t0, s = mp.mpf(row[VELOCITY]), mp.mpf(row[PHASE]) / mp.pi, mp.mpf(after[FLIGHT])
                wall, flights = int(row[WALL]), Flights(groups)
                speed, way = flights.flown(wall, before, t0, s)
                target = mp.mpf(groups.d) * int(after[WALL] - wall) / 2
                # Both times are rounded, so the place is off by the speed times that.
                assert abs(way - target) < 1e-14 * (1 + abs(after[VELOCITY])) * (1 + s)
                assert abs(speed - mp.mpf(after[VELOCITY])) < 1e-13 * (1 + s)
                inside = [flights.flown(wall, before, t0, s * mp.mpf(k) / 12)[1] * wall for k in range(1, 12)]
                assert max(inside) < 1e-15
                assert min(inside) > -groups.d - 1e-15
                hard += 1
    assert hard > 40


@pytest.mark.parametrize(("exponent", "speed", "hops"), CHATTER)
def test_hops_to_rest_take_the_time_that_they_take_one_by_one(exponent: float, speed: float, hops: int) -> None:
    """A ball that the bottom holds: after the largest restitution is reached, or before, to 3e-13."""
    groups, start = Groups(0.6, 1.3, SpeedLaw(0.5, 0.5, exponent, speed)), Impact(BOTTOM, 0.02, 1.0)
    rows, summary = follow_one(check_model(groups)[0], check_start(start, groups.d), 5000, compiled=False)
    assert int(summary[2]) == REST
    assert len(rows) > hops
    found = mp.fsum(mp.mpf(t) for t in rows[1:, FLIGHT]) + mp.mpf(rows[-1, SETTLING])
    with mp.workdps(30):
        t, before = mp.mpf(1) / mp.pi, mp.mpf(0.02)
        begun, most, flights = t, mp.mpf(flight.LARGEST_RESTITUTION), Flights(groups)
        while before > mp.mpf(10) ** -18:
            r = flights.restitution_of(1, before)
            pull = mp.mpf(1.3) + mp.cos(mp.pi * t)
            if r == most and before < 1e-9:  # what is left is a geometric series, to 1e-14
                t += 2 * r * before / pull / (1 - r)
                break
            s = 2 * r * before / pull
            for _ in range(6 if before > 1e-4 else 3):
                velocity, way = flights.flown(1, before, t, s)
                s -= way / velocity
            t, before = t + s, flights.flown(1, before, t, s)[0]
        assert abs(found - (t - begun)) < 3e-13


def test_constants_among_laws_are_what_they_are_alone_to_the_last_bit() -> None:
    law, constant = SpeedLaw(0.5, 0.6, -0.1, 0.8), Restitutions(0.5, 0.6)
    models = [check_model(Groups(0.5, 0.3, r)) for r in (law, constant)]
    starts = np.repeat(random_starts([0.5], 1.0, 1, 3)[0], 2, axis=0)
    both, _ = follow_impacts(np.concatenate(models), starts, 60, compiled=False)
    for own, model, start in zip(both, models, starts, strict=True):
        alone, _ = follow_impacts(model, start[None], 60, compiled=False)
        assert np.array_equal(own, alone[0], equal_nan=True)
    assert not np.array_equal(both[0], both[1], equal_nan=True)


def test_a_power_that_is_none_is_refused() -> None:
    for law in (SpeedLaw(0.5, 0.5, 0.1, 1.0), SpeedLaw(0.5, 0.5, -1.0, 1.0), SpeedLaw(0.5, 0.5, -0.1, 0.0)):
        with pytest.raises(ValueError, match="above -1"):
            check_model(Groups(0.5, 0.3, law))


def test_the_period_doubles_where_the_row_of_effects_says() -> None:
    """A simulation beside the end comes back after one period to one side of it, after two to the other."""
    device = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0)
    design = design_point(device, None)
    (shift,) = shifts(device, design, (Effect(LeftOut.RESTITUTION_SPEED, -0.1),)).rows
    law = falling(device, design.motions, -0.1)
    end = design.endings()[0].point.closed
    for factor, impacts in ((1.002, 2), (0.998, 4)):
        other = replace(law, frequency_hz=shift.value * factor)
        groups = other.groups(Parameter.LENGTH, other.length_m).as_floats()
        reached = find_attractor(groups, Impact(BOTTOM, end.velocity_bottom, end.phi_bottom), compiled=False)
        assert len(reached.cycle.wall) == impacts


def test_multipliers_of_a_cycle_are_those_of_the_motion() -> None:
    device = Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0)
    motions = design_point(device, None).motions
    law = falling(device, motions, -0.1)
    origin = model_on_line(Line.LENGTHS, law, FLOATS).origin
    ((motion, _),) = stable_ones(device, motions)
    curve = Curve(motion.word, Falling(origin), -0.01, 0.1, 1.0)
    *_, (_, x, _, _) = ends_on_curve(curve, motion, 1.0, False)
    start = Impact(BOTTOM, float(x[0]), float(np.pi * x[2]))
    cycle = find_attractor(origin, start, compiled=False).cycle
    assert cycle.velocity[cycle.wall > 0] == pytest.approx(x[0], rel=1e-13)
    first, second = cycle.multipliers
    assert (first + second).real == pytest.approx(curve.trace(x), abs=1e-10)
    assert (first * second).real == pytest.approx(curve.decay(x) ** 2, rel=1e-10)
    lap = lap_matrix(origin, cycle.motion(origin.d))  # by the equations, at the impacts of the simulation
    assert (np.trace(lap), np.linalg.det(lap)) == pytest.approx((first + second, first * second), rel=1e-9)
