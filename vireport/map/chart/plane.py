"""The plane of two inputs of a device, and straight sweeps across it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.design.plane import Plane
from vireport.motions.sweep import Sweep
from vireport.physics.device import RESTITUTIONS, Device
from vireport.physics.groups import Groups
from vireport.physics.numbers import ARRAYS, ExactFunctions
from vireport.scenario.parameters import DesignInput, Parameter

Floats = NDArray[np.float64]


class LocalGroups(Struct, frozen=True, eq=False):
    """The groups at a point of a plane, with their derivatives by the inputs, (4, 2)."""

    groups: Groups[Any]
    gradients: Floats

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """The groups at the point, whatever the inputs: it takes the place of a plane for a single point."""
        return self.groups

    def slopes(self, varied: Sequence[Any]) -> Floats:
        """The derivatives of `Groups.numbers` by the inputs, shape (4, 2)."""
        return self.gradients


class DevicePlane(Plane, frozen=True, eq=False):
    """The plane of two inputs of a device; all else is held.

    Attributes
    ----------
    device : Device
        With any value of the two inputs.
    ops
        Functions of the kind of number that groups are computed in.
    """

    inputs: tuple[DesignInput, DesignInput]
    device: Device
    ops: ExactFunctions = ARRAYS

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """The groups at values of the inputs; a capsule tilted the other way has negative gbar."""
        device = self.device_at([abs(value) for value in varied])
        groups = device.groups(Parameter.LENGTH, device.length_m, self.ops)
        if self.ops is ARRAYS:  # as Python's numbers, with which arithmetic is several times as fast as with NumPy's
            groups = groups.as_floats()
        return groups._replace(gbar=self._side(varied) * groups.gbar)

    def local(self, varied: Sequence[float]) -> LocalGroups:
        """Return the groups of a device with their derivatives by the inputs."""
        groups, device = self.at(varied), self.device_at(varied)
        return LocalGroups(
            groups, np.array([device.slopes(varied_input, groups.d, groups.gbar) for varied_input in self.inputs]).T
        )

    def _side(self, varied: Sequence[Any]) -> int:
        """Sign of gravity along the capsule: -1 at an inclination below 0."""
        tilted = zip(self.inputs, varied, strict=True)
        return -1 if any(varied_input is DesignInput.INCLINATION and value < 0 for varied_input, value in tilted) else 1

    def device_at(self, varied: Sequence[Any]) -> Device:
        """The device with these values of the inputs."""
        changed: dict[str, object] = dict(zip(self.inputs, varied, strict=True))
        return self.device.with_values(changed)

    @property
    def swept(self) -> bool:
        """Whether there are sweeps across it, along one of its inputs at least."""
        return any(is_swept(varied, self.device.recoils) for varied in self.inputs)

    @property
    def horizontal(self) -> bool:
        """Whether motions have mirror images in all of the plane: no gravity along the capsule, and equal ends."""
        breaking = DesignInput.INCLINATION, *RESTITUTIONS[1:]
        symmetric = self.device.alike and bool(self.device.inclination_deg == 0)
        return symmetric and not any(varied in breaking for varied in self.inputs)


class StraightSweep(Struct, frozen=True, eq=False):
    """A straight sweep across a plane, or a line along an input of which there are none.

    Attributes
    ----------
    plane : DevicePlane
    varied : int
        Which of the inputs varies.
    other : float
        Value of the other one.
    """

    plane: DevicePlane
    varied: int
    other: float

    @property
    def quantity(self) -> str:
        """The quantity that varies, for the reader."""
        return self.plane.inputs[self.varied].quantity

    @property
    def sweep(self) -> Sweep:
        """The line as a sweep of a scenario.

        Along the capsule's mass the groups change as against the force's amplitude, which is swept instead.
        """
        k, plane = self.varied, self.plane
        device = plane.device_at(self._inputs(low := float(plane.low[k])).tolist())
        if plane.inputs[k] is not DesignInput.CAPSULE_MASS:
            return Sweep(device, Parameter(plane.inputs[k].value), low, float(plane.high[k]))
        device = replace(device, capsule_mass_kg=plane.device.capsule_mass_kg)
        least, most = (_mass(device, float(end[k])) for end in (plane.high, plane.low))
        return Sweep(device, Parameter.AMPLITUDE, least, most)

    def inputs(self, swept: float) -> Floats:
        """The inputs at a value of the sweep."""
        if self.plane.inputs[self.varied] is DesignInput.CAPSULE_MASS:
            swept = _mass(self.sweep.device, swept)
        return self._inputs(swept)

    def swept(self, value: float) -> float:
        """The value of the sweep at a value of the input."""
        # Mass and amplitude are exchanged by one formula, either way.
        return _mass(self.sweep.device, value) if self.plane.inputs[self.varied] is DesignInput.CAPSULE_MASS else value

    def _inputs(self, value: float) -> Floats:
        return np.insert([self.other], self.varied, value)


Stable = tuple[tuple[float, float, tuple[str, ...]], ...]
"""Stretches of a line: their ends, and the words of the motions that are stable between them."""


class Cut(Struct, frozen=True, eq=False):
    """A sweep across the plane, and what is stable along it."""

    line: StraightSweep
    stable: Stable


def straight_sweeps(plane: DevicePlane, count: int) -> Iterator[StraightSweep]:
    """Sweeps across a plane, as many along each input that can be swept, at equal distances.

    Where neither can be, they are lines along both.
    """
    for k in (1, 0):
        if is_swept(plane.inputs[k], plane.device.recoils) or not plane.swept:
            yield from (StraightSweep(plane, k, other) for other in plane.centres((count, count))[1 - k].tolist())


def is_swept(varied: DesignInput, recoils: bool) -> bool:
    """Whether there are sweeps along an input: none along a restitution, nor along the mass of a free capsule.

    Of a capsule that recoils neither gbar nor d/gbar is held where its mass varies.
    """
    return varied not in RESTITUTIONS and not (recoils and varied is DesignInput.CAPSULE_MASS)


def _mass(device: Device, amplitude: float) -> float:
    """The capsule's mass that moves as the device's does under another amplitude of the force, or the other way."""
    return float(device.capsule_mass_kg * device.amplitude_n / amplitude)
