"""What the numbers of results.json are by definition, from its scenario and its dimensionless motions alone.

Nothing here is imported from the package: a wrong factor, unit or column there is not repeated here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi, sin, sqrt
from typing import Any

STANDARD_GRAVITY = 9.80665
VACUUM_PERMITTIVITY = 8.8541878188e-12
SYMBOLS = {
    "length_m": ("length", "s", "m"),
    "amplitude_n": ("force amplitude", "F", "N"),
    "capsule_mass_kg": ("capsule mass", "M", "kg"),
    "frequency_hz": ("frequency", "f", "Hz"),
    "inclination_deg": ("inclination", "β", "°"),
    "restitution": ("restitution", "r", ""),
}
"""Quantity, symbol and unit of what a sweep or a margin can be in."""


@dataclass(frozen=True)
class Device:
    """The inputs of a scenario."""

    capsule_mass_kg: float
    restitution: float
    amplitude_n: float | None
    frequency_hz: float | None
    length_m: float | None
    inclination_deg: float | None
    gravity_m_s2: float
    period_ratio: int
    ball_mass_kg: float | None
    membrane: dict[str, Any]

    def at(self, parameter: str, value: float) -> Device:
        """The device with another value of an input."""
        return replace(self, **{parameter: value})

    @property
    def length_unit(self) -> float:
        """x_c of (2.5), with omega = 2 pi f: F / (4 M f^2)."""
        return self.amplitude_n / (4 * self.capsule_mass_kg * self.frequency_hz**2)

    @property
    def velocity_unit(self) -> float:
        """y_c of (2.5): F / (2 M f)."""
        return self.amplitude_n / (2 * self.capsule_mass_kg * self.frequency_hz)

    @property
    def d(self) -> float:
        return self.length_m / self.length_unit

    @property
    def gbar(self) -> float:
        return self.capsule_mass_kg * self.gravity_m_s2 * sin(pi / 180 * self.inclination_deg) / self.amplitude_n

    @property
    def acceleration(self) -> float:
        return self.amplitude_n / self.capsule_mass_kg

    @property
    def stroke(self) -> float:
        """Twice the amplitude F / (M omega^2)."""
        return 2 * self.acceleration / (2 * pi * self.frequency_hz) ** 2

    @property
    def period_s(self) -> float:
        """Of a 1:1 motion: n forcing periods."""
        return self.period_ratio / self.frequency_hz

    def deflection(self, speed: float) -> float:
        """(5.5)."""
        h, stiffness = self.membrane["exponent"], self.membrane["stiffness"]
        return float(((h + 1) / (2 * stiffness) * self.ball_mass_kg * speed**2) ** (1 / (h + 1)))

    def gain(self, speed: float) -> float:
        """U_imp - U_in of (5.2) to (5.4)."""
        rb, rc, bias = (self.membrane[key] for key in ("ball_radius_m", "active_radius_m", "bias_voltage_v"))
        x = self.deflection(speed)
        cosine = (-rb * (x - rb) + rc * sqrt(rc**2 + x**2 - 2 * x * rb)) / (rc**2 + (x - rb) ** 2)
        area = 2 * pi * rb**2 * (1 - cosine) + (pi * rc**2 - pi * rb**2 * (1 - cosine**2)) / cosine
        return float((area / (pi * rc**2)) ** 2 * bias - bias)

    def energy(self, speed: float) -> float:
        """Electrical energy of an impact at constant charge: C0 U_imp (U_imp - U_in) / 2."""
        of, bias, gain = self.membrane, self.membrane["bias_voltage_v"], self.gain(speed)
        area = pi * of["active_radius_m"] ** 2
        capacitance = VACUUM_PERMITTIVITY * of["relative_permittivity"] * area / of["thickness_m"]
        return float(capacitance * (gain + bias) * gain / 2)

    def lost(self, speed: float) -> float:
        """Kinetic energy that an impact loses."""
        return self.ball_mass_kg * (1 - self.restitution**2) * speed**2 / 2


def device_of(scenario: dict[str, Any]) -> Device:
    """The device of the scenario in results.json."""
    given, force = scenario["device"], scenario["excitation"]
    return Device(
        given["capsule_mass_kg"], given["restitution"], force["amplitude_n"], force["frequency_hz"],
        given["length_m"], scenario["inclination_deg"], scenario["gravity_m_s2"], scenario["period_ratio"],
        given["ball_mass_kg"], given["membrane"],
    )  # fmt: skip


def mean(values: Any) -> float:
    return float(sum(values) / len(values))
