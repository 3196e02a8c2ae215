"""Stable motions of a design whose restitution falls with speed, followed from those with a constant one.

The exponent of the law grows from nothing. Of the constant restitutions all motions are known; with the law, those that
come from them. A motion that only the law has is not looked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.design.lines import Followed, Line, along, carried, mirrored
from vireport.motions import Motions
from vireport.physics import FLOATS, Device, Groups, Restitutions, SpeedLaw, flight, stated
from vireport.scenario import Parameter

Floats = NDArray[np.float64]

BEHIND = 0.01
"""Exponent on the other side of zero: room for a curve that begins with none."""


class Falling(Struct, frozen=True, eq=False):
    """A device whose restitution falls ever faster with speed, see `motions.Curve`: what varies is minus the exponent.

    Attributes
    ----------
    origin : Groups
        With the law.
    """

    origin: Groups[Any]

    @property
    def horizontal(self) -> bool:
        """Whether motions have mirror images."""
        return self.origin.horizontal

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """The groups at minus an exponent."""
        law: SpeedLaw = self.origin.restitution
        return self.origin._replace(restitution=replace(law, exponent=-varied[0]))

    def slopes(self, varied: Sequence[Any]) -> Floats:
        """The derivatives of `Groups.numbers` by minus the exponent: (6, 1), of harmonics and friction zeros more."""
        slopes = np.zeros((len(self.origin.numbers), 1))
        slopes[-2 if self.origin.friction is None else -3] = -1.0
        return slopes


def constant(device: Device) -> Device:
    """The device with the restitutions that the law of another states at its speed."""
    bottom, top = stated(device.restitution)
    return replace(device, restitution=bottom if bottom == top else Restitutions(bottom, top))


def with_law(device: Device, stable: Sequence[Followed]) -> list[Followed]:
    """Those stable motions of a device's `constant` restitutions that are left where its law holds.

    Parameters
    ----------
    device : Device
        All inputs given, its restitution a `SpeedLaw`.
    stable : sequence of Followed
        With constant restitutions.
    """
    model = Falling(along(Line.LENGTHS, device, FLOATS).origin)
    most = -float(device.restitution.exponent)
    return carried(model, -BEHIND, most, stable, device.period_ratio, mirrored(device))


def falling(device: Device, motions: Motions, exponent: float, speed_m_s: float | None = None) -> Device | None:
    """The device with restitutions that fall with the speed of the impact, as its own at one speed.

    Parameters
    ----------
    device : Device
        All inputs given, its restitutions constant.
    motions : Motions
        Of the design point; the first stable one counts.
    exponent : float
        Of the law, for both membranes alike.
    speed_m_s : float, optional
        At which the restitutions are the device's; the mean of both impacts of its own motion by default.

    Returns
    -------
    Device or None
        None where a restitution is zero, which has no law, or as large as the largest that a law gives, or where
        nothing is stable.

    Notes
    -----
    One speed for both: membranes that are alike stay alike, and the bottom, which is struck faster, rebounds less.
    """
    rows, bottom_top = np.flatnonzero(motions.stable), stated(device.restitution)
    if not rows.size or min(bottom_top) == 0 or max(bottom_top) >= flight.LARGEST_RESTITUTION:
        return None
    if speed_m_s is None:
        row = int(rows[0])
        mean = (abs(float(motions.velocity_bottom[row])) + abs(float(motions.velocity_top[row]))) / 2
        speed_m_s = mean * float(device.velocity_unit(Parameter.LENGTH, device.length_m))
    return replace(device, restitution=SpeedLaw(*bottom_top, exponent, speed_m_s))
