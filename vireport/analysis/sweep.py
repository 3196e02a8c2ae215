"""One parameter of a device that varies: the level of the surface of motions that it holds, and where a value lies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vireport.analysis.orbits import Level
from vireport.physics import (
    FINEST_D,
    FINEST_GBAR,
    Device,
    Number,
)
from vireport.scenario import Parameter


@dataclass(frozen=True, slots=True)
class Sweep:
    """One parameter of a device that varies: a level of the surface of motions, and where on it a value lies.

    Attributes
    ----------
    device : Device
    parameter : str
        The one that varies.
    start, end : float
        Range asked for, in the parameter's unit, in either order.
    """

    device: Device
    parameter: Parameter
    start: Number
    end: Number

    @property
    def level(self) -> Level:
        """What stays the same along the sweep."""
        # Of a sweep over the force, both groups are the largest, and best resolved, at its lower end.
        at = min(self.start, self.end) if self.parameter == "amplitude_n" else self.start
        d, gbar = self.device.groups(self.parameter, at)
        if self.parameter == "inclination_deg":
            return Level("d", d)
        if self.parameter == "amplitude_n" and gbar != 0:
            return Level("ratio", d / gbar)
        return Level("gbar", gbar)

    @property
    def coordinate_range(self) -> tuple[float, float]:
        """Range of the coordinate that orders the sweep (d, or gbar where the inclination varies), ascending."""
        ends = self.coordinate_of(self.start), self.coordinate_of(self.end)
        return min(ends), max(ends)

    @property
    def unresolved(self) -> str:
        """Why rounding does not resolve the sweep, or ""."""
        device, (least, most) = self.device, sorted((self.start, self.end))
        if self.parameter == "inclination_deg":
            reason = device.too_short(self.parameter, most)
        else:  # d and gbar are largest at the least force, d at the largest length and frequency
            at = self.parameter, least if self.parameter == "amplitude_n" else most
            reason = device.too_short(*at) or device.too_light(*at)
        low, high = self.coordinate_range
        over_gbar = self.parameter == "inclination_deg"
        finest = device.finest(FINEST_GBAR if over_gbar else FINEST_D)
        if not reason and high - low < finest:
            name = "gbar = M g sin(beta)/F" if over_gbar else "d = s/x_c"
            reason = (
                f"over the sweep {name} only varies from {low:.6g} to {high:.6g}, which rounding does not resolve "
                f"(allowed: a range of at least {finest:.3g})"
            )
        return reason

    def coordinate_of(self, value: Any) -> Any:
        """The coordinate at a value of the parameter."""
        d, gbar = self.device.groups(self.parameter, value)
        return gbar if self.parameter == "inclination_deg" else d

    def coordinate(self, orbit: Any) -> Any:
        """The coordinate of motions on the level."""
        return orbit.gbar if self.parameter == "inclination_deg" else orbit.d

    def value(self, d: Any, gbar: Any) -> Any:
        """The parameter at which a motion with these groups occurs; the inverse of `Device.groups` along the sweep."""
        x, mass = self.device, self.device.capsule_mass_kg
        if self.parameter == "length_m":
            return d * x.amplitude_n / (4 * mass * x.frequency_hz**2)
        if self.parameter == "amplitude_n":
            return 4 * mass * x.length_m * x.frequency_hz**2 / d
        if self.parameter == "frequency_hz":
            return np.sqrt(np.maximum(d, 0.0) * x.amplitude_n / (4 * mass * x.length_m))
        sine = gbar * x.amplitude_n / (mass * x.gravity_m_s2)
        return np.degrees(np.arctan2(sine, np.sqrt(np.maximum((1 - sine) * (1 + sine), 0.0))))
