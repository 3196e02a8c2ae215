"""Motions and ends of stable motion of devices as they are built, against their raw map in 50 digits."""

from __future__ import annotations

from collections.abc import Container

import mpmath as mp
import pytest
from msgspec.structs import replace
from raw_flights import Flights

from vireport.design.point import around_length, design_point, motions_at
from vireport.motions.error_bounds import one_to_one_bounds
from vireport.motions.events import Event
from vireport.physics.device import Device
from vireport.physics.groups import Groups, SpeedLaw
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.events import BOTTOM, check_model, follow_one
from vireport.simulation.kernel import PHASE, VELOCITY


class ExactDevice(Flights):
    """The flights and impacts of a device in 50 digits, by its inputs in SI and nothing of the package."""

    def __init__(self, device: Device) -> None:
        mass, force, r = mp.mpf(device.capsule_mass_kg), mp.mpf(device.amplitude_n), device.restitution
        across = mp.radians(mp.mpf(device.inclination_deg))
        ball = mp.mpf(device.ball_mass_kg) if device.capsule is CapsuleMotion.FREE else 0
        weight, frequency = (mass + ball) * mp.mpf(device.gravity_m_s2) / force, mp.mpf(device.frequency_hz)
        if isinstance(r, SpeedLaw):
            r = replace(r, speed=mp.mpf(r.speed) * 2 * mass * frequency / force)
        groups = Groups(
            4 * mass * mp.mpf(device.length_m) * frequency**2 / force,
            weight * mp.sin(across),
            r,
            friction=mp.mpf(device.friction) * weight * mp.cos(across),
        )
        stated = ((own.order, *map(mp.mpf, own.stated)) for own in device.harmonics)
        super().__init__(groups, [(order, percent / 100, mp.radians(phase)) for order, percent, phase in stated])


def held_motions(device: Device) -> int:
    """Hold each motion of a device within its bounds to the raw map in 50 digits, and to the simulation if stable."""
    motions, _, errors = motions_at(device, Parameter.LENGTH)
    bounds = one_to_one_bounds(around_length(device), motions, errors)
    model = check_model(device.groups(Parameter.LENGTH, device.length_m))[0]
    for row in range(len(motions)):
        v0, phase = float(motions.velocity_bottom[row]), float(motions.phi_bottom[row])
        with mp.workdps(50):
            exact = ExactDevice(device)
            x = exact.nearest(motions, row)
            assert abs(x[0] - v0) <= bounds["velocity_bottom"][row] < 1e-9
            assert abs(x[1] - float(motions.velocity_top[row])) <= bounds["velocity_top"][row] < 1e-9
            assert abs(mp.pi * x[2] - mp.mpf(phase)) <= bounds["phi_bottom"][row]
            trace, determinant = exact.map_of(*x)
        assert abs(trace - motions.trace[row]) <= bounds["trace"][row] + 1e-8 * abs(motions.trace[row])
        assert float(motions.determinant[row]) == pytest.approx(float(determinant), rel=1e-8)
        if motions.stable_mask[row]:
            rows, _ = follow_one(model, (BOTTOM, 0.0, v0, phase), 20, compiled=False)
            assert rows[-1, VELOCITY] == pytest.approx(v0, abs=1e-6)
            assert rows[-1, PHASE] == pytest.approx(phase, abs=1e-6)
    return len(motions)


def held_ends(device: Device, inputs: Container[DesignInput]) -> int:
    """Hold period doublings and folds at the ends of stable motion to the raw map, to the last digits of a double.

    There tr + 1 + det = 0 and tr = 1 + det.
    """
    held = 0
    for margin in design_point(device, None).margins:
        sign = {Event.PERIOD_DOUBLING: 1, Event.FOLD: -1}.get(margin.event)
        if sign is None or margin.parameter not in inputs:
            continue
        at, motion = device.with_values({margin.parameter: margin.sweep_value}), margin.point.motion
        with mp.workdps(50):
            exact = ExactDevice(at)
            values = [mp.mpf(x) for x in (*motion.velocity, *motion.time)]
            assert max(map(abs, exact.missed(*values))) < 1e-13
            trace, determinant = exact.map_of(*values)
        slope = 1e-12 * max(1, abs(trace)) / min(abs(values[0]), abs(values[1])) ** 2
        assert abs(trace + sign * (1 + determinant)) < max(slope, 1e-9), margin.name
        held += 1
    return held
