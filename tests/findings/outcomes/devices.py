"""Devices of the paper's kind, with their 1:1 motions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vireport.design.point import motions_at
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.scenario.parameters import Parameter


class Case(NamedTuple):
    """Groups, stable and unstable admissible 1:1 motions, and the unit of velocity [m/s]."""

    groups: Groups[float]
    stable: list[Motion]
    unstable: list[Motion]
    unit: float


def case(
    force: float = 3.6,
    length: float = 0.75,
    inclination: float = 45.0,
    r: float = 0.5,
    scale: float = 1.0,
    harmonics: tuple[Harmonic, ...] = (),
) -> Case:
    """A device of the paper by its groups; with `scale` one of as many times its mass and force in other units."""
    return of(Device(0.1245 * scale, r, 9.8, length, force * scale, 2.0, inclination, harmonics=harmonics))


DISTORTED = Harmonic.of(2, 3.0, 225.0), Harmonic.of(3, 5.0, 30.0)
"""Harmonics of a force, an even and an odd one."""


def of(device: Device) -> Case:
    """What a device has."""
    at = Parameter.LENGTH, device.length_m
    found, _, _ = motions_at(device, Parameter.LENGTH)
    rows = [found.motion(row, device.period_ratio) for row in range(len(found))]
    return Case(
        device.groups(*at).as_floats(),
        [rows[i] for i in np.flatnonzero(found.stable_mask)],
        [rows[i] for i in np.flatnonzero(found.admissible_mask & ~found.stable_mask)],
        float(device.velocity_unit(*at)),
    )
