"""The crossing between a scenario in SI units and the dimensionless groups, in both directions.

With r and n, the groups d = s/x_c and gbar = M g sin(beta)/F are all of the dynamics. No other module mixes the two
kinds of number.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Literal

import numpy as np

from vireport.orbits import Level
from vireport.precise import DecimalOps

Number = Any
"""A float, a decimal where a point is polished, or None for a swept parameter without a design point."""

Parameter = Literal["length_m", "amplitude_n", "frequency_hz", "inclination_deg"]
PARAMETERS: tuple[Parameter, ...] = ("length_m", "amplitude_n", "frequency_hz", "inclination_deg")


NO_GRAVITY = 1e-15
"""gbar up to which a capsule is taken as horizontal: no number of a motion then differs in any digit of a double, and
q - 1/2 ~ gbar could no longer be told from zero."""


@dataclass(frozen=True, slots=True)
class Device:
    """The harvester and its excitation in SI units; one of the four that can be swept may be None.

    Attributes
    ----------
    capsule_mass_kg, restitution, gravity_m_s2 : float
        M, r, g.
    length_m, amplitude_n, frequency_hz, inclination_deg : float or None
        s, F, omega/2 pi, beta.
    period_ratio : int
        n, forcing periods per motion, Eq. (3.14).
    """

    capsule_mass_kg: Number
    restitution: Number
    gravity_m_s2: Number
    length_m: Number
    amplitude_n: Number
    frequency_hz: Number
    inclination_deg: Number
    period_ratio: int = 1

    def at(self, parameter: Parameter, value: Any) -> dict[Parameter, Any]:
        """The four parameters that can be swept, with one of them (an array, say) replaced."""
        return {name: value if name == parameter else getattr(self, name) for name in PARAMETERS}

    def groups(self, parameter: Parameter, value: Any) -> tuple[Any, Any]:
        """The groups d = 4 M s f^2/F and gbar = M g sin(beta)/F where `parameter` has `value`, Eqs. (2.5), (2.6)."""
        x = self.at(parameter, value)
        mass, force = self.capsule_mass_kg, x["amplitude_n"]
        d = 4 * mass * x["length_m"] * x["frequency_hz"] ** 2 / force
        angle = x["inclination_deg"]
        exact = isinstance(angle, Decimal)
        sine = DecimalOps().sin(angle * DecimalOps().pi / 180) if exact else sine_of_degrees(angle)
        gbar = mass * self.gravity_m_s2 * sine / force
        return d, gbar * (gbar > NO_GRAVITY)

    def velocity_unit(self, parameter: Parameter, value: Any) -> Any:
        """y_c = F/(2 M f) [m/s], Eq. (2.5)."""
        x = self.at(parameter, value)
        return x["amplitude_n"] / (2 * self.capsule_mass_kg * x["frequency_hz"])


def sine_of_degrees(angle: Any) -> Any:
    """Sin of an angle in degrees, exact at 0 and 90, and with full relative accuracy near both."""
    angle = np.asarray(angle, dtype=float)
    sine = np.where(angle <= 45, np.sin(np.radians(angle)), np.cos(np.radians(90 - angle)))
    return sine[()]


@dataclass(frozen=True, slots=True)
class Sweep:
    """One parameter of a device that varies: a level of the surface of motions, and where on it a value lies.

    Attributes
    ----------
    device : Device
    parameter : str
        One of `PARAMETERS`.
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
        d, gbar = self.device.groups(self.parameter, self.start)
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
