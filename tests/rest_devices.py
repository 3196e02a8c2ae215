"""Devices that are switched on, and what each comes to from rest, for tests of several rooms."""

from __future__ import annotations

from vireport.design.from_rest import StartingDevice, Target, from_rest
from vireport.design.point import motions_at
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter

PAPER = Device(
    capsule_mass_kg=0.1245,
    restitution=0.5,
    gravity_m_s2=9.8,
    length_m=0.75,
    amplitude_n=5.31,
    frequency_hz=2.0,
    inclination_deg=45.0,
)


def found(device: Device, compiled: bool = False):
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    motions, _, _ = motions_at(device, Parameter.LENGTH)
    return from_rest(StartingDevice(groups, Target.of(motions), device.period_ratio), compiled)


def device_of(d: float, gbar: float, r: float) -> Device:
    """A device with these groups."""
    force = 9.8 * 0.1 / gbar if gbar else 3.0
    length = d * force / (4 * 0.1 * 4)
    return Device(0.1, r, 9.8, length, force, 2.0, 90.0 if gbar else 0.0)
