"""Motions and ends of stable motion of devices as they are built, against their raw map in 50 digits."""

from __future__ import annotations

from collections.abc import Container

import mpmath as mp
import numpy as np
import pytest
from raw_flights import Flights

from vireport.design.point import around_length, design_point, motions_at
from vireport.motions.error_bounds import one_to_one_bounds
from vireport.motions.events import Event
from vireport.physics.device import Device
from vireport.physics.groups import Restitutions
from vireport.scenario.blocks import CapsuleMotion
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.simulation.events import BOTTOM, check_model, follow_one
from vireport.simulation.kernel import PHASE, VELOCITY


class ExactDevice(Flights):
    """The flights and impacts of a device in 50 digits, by its inputs in SI and nothing of the package."""

    def __init__(self, device: Device) -> None:
        mass, force = mp.mpf(device.capsule_mass_kg), mp.mpf(device.amplitude_n)
        across = mp.radians(mp.mpf(device.inclination_deg))
        ball = mp.mpf(device.ball_mass_kg) if device.capsule is CapsuleMotion.FREE else 0
        self.d = 4 * mass * mp.mpf(device.length_m) * mp.mpf(device.frequency_hz) ** 2 / force
        weight = (mass + ball) * mp.mpf(device.gravity_m_s2) / force
        self.gbar, self.friction = weight * mp.sin(across), mp.mpf(device.friction) * weight * mp.cos(across)
        self.unit = force / (2 * mass * mp.mpf(device.frequency_hz))
        self.restitution = device.restitution
        given = ((own.order, *own.stated) for own in device.harmonics)
        self.parts = [
            (1, mp.mpf(1), mp.mpf(0)),
            *((order, mp.mpf(percent) / 100, mp.radians(mp.mpf(phase))) for order, percent, phase in given),
        ]

    def restitution_of(self, wall, velocity):
        r = self.restitution
        if isinstance(r, float):
            return mp.mpf(r)
        stated = mp.mpf(r.bottom if wall > 0 else r.top)
        if isinstance(r, Restitutions):
            return stated
        return stated * (wall * velocity * self.unit / mp.mpf(r.speed)) ** mp.mpf(r.exponent)

    def map_of(self, v0, t0, t1):
        """Trace and determinant of the return map, by differences of the flights."""
        return self.multipliers((1, -1), v0, t0, (t1, t0 + 2))


def held_motions(device: Device) -> int:
    """Hold each motion of a device within its bounds to the raw map in 50 digits, and to the simulation if stable."""
    motions, _, errors = motions_at(device, Parameter.LENGTH)
    bounds = one_to_one_bounds(around_length(device), motions, errors)
    model = check_model(device.groups(Parameter.LENGTH, device.length_m))[0]
    for row in range(len(motions)):
        v0, v1 = float(motions.velocity_bottom[row]), float(motions.velocity_top[row])
        t0 = float(motions.phi_bottom[row]) / np.pi
        with mp.workdps(50):
            exact = ExactDevice(device)
            x = mp.findroot(exact.missed, (v0, v1, t0, t0 + 1 + 2 * float(motions.u[row])), tol=1e-30)
            assert abs(x[0] - v0) <= bounds["velocity_bottom"][row] < 1e-9
            assert abs(x[1] - v1) <= bounds["velocity_top"][row] < 1e-9
            assert abs(mp.pi * x[2] - mp.mpf(float(motions.phi_bottom[row]))) <= bounds["phi_bottom"][row]
            trace, determinant = exact.map_of(x[0], x[2], x[3])
        assert abs(trace - motions.trace[row]) <= bounds["trace"][row] + 1e-8 * abs(motions.trace[row])
        assert float(motions.determinant[row]) == pytest.approx(float(determinant), rel=1e-8)
        if motions.stable_mask[row]:
            rows, _ = follow_one(model, (BOTTOM, 0.0, v0, np.pi * t0), 20, compiled=False)
            assert rows[-1, VELOCITY] == pytest.approx(v0, abs=1e-6)
            assert rows[-1, PHASE] == pytest.approx(np.pi * t0, abs=1e-6)
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
            values = (*motion.velocity, *motion.time)
            assert max(map(abs, exact.missed(*map(mp.mpf, values)))) < 1e-13
            trace, determinant = exact.map_of(*(mp.mpf(values[k]) for k in (0, 2, 3)))
        slope = 1e-12 * max(1, abs(trace)) / min(abs(values[0]), abs(values[1])) ** 2
        assert abs(trace + sign * (1 + determinant)) < max(slope, 1e-9), margin.name
        held += 1
    return held
