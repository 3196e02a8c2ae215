"""The crossing between a scenario in SI units and the dimensionless groups, in both directions.

With r and n, the groups d = s/x_c and gbar = M g sin(beta)/F are all of the dynamics. No other module mixes the two
kinds of number.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Literal

import numpy as np

from vireport.analysis.orbits import Level
from vireport.physics.decimals import DecimalOps

Number = Any
"""A float, a decimal where a point is polished, or None for a swept parameter without a design point."""

Parameter = Literal["length_m", "amplitude_n", "frequency_hz", "inclination_deg"]
PARAMETERS: tuple[Parameter, ...] = ("length_m", "amplitude_n", "frequency_hz", "inclination_deg")


NO_GRAVITY = 1e-15
"""gbar up to which gravity is lost: q - 1/2 ~ gbar could no longer be told from zero. As a value within a sweep it
counts as zero; a scenario that holds such a gbar is refused (`too_light`), for its folds would not be where they are
said to be."""

FINEST_D, FINEST_GBAR = 1e-10, 1e-12
"""Length of a capsule and range of d, and range of gbar, times (1-r)/n, below which motions are not resolved: positions
are sums of terms of size n/(1-r) in the length unit, and gbar keeps its digits next to zero."""


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

    def finest(self, of: float) -> float:
        """Least d, or least range, that rounding resolves, from `FINEST_D` or `FINEST_GBAR`."""
        return of * self.period_ratio / (1 - float(self.restitution))

    def too_short(self, parameter: Parameter, value: Any) -> str:
        """Why the length at a value cannot be told from rounding, or ""."""
        d = self.groups(parameter, value)[0]
        if d >= (finest := self.finest(FINEST_D)):
            return ""
        return (
            f"d = s/x_c = {d:.3g}: the capsule is so short against the forcing's displacement that its length is "
            f"lost in rounding (allowed: d of at least {finest:.3g}; a longer capsule, higher frequency or "
            "smaller force)"
        )

    def too_light(self, parameter: Parameter, value: Any) -> str:
        """Why gravity at a value cannot be told from rounding, or ""."""
        gbar = self.groups(parameter, value)[1]
        if gbar > 0 or self.at(parameter, value)["inclination_deg"] == 0:
            return ""
        return (
            f"gbar = M g sin(beta)/F is positive and at most {NO_GRAVITY:g}: gravity is lost in rounding against "
            "the forcing (allowed: inclination_deg: 0, a larger inclination, or a smaller force)"
        )

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
