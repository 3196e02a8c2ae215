"""What the numbers of results.json are by definition, from its scenario and its dimensionless motions alone.

Nothing here is imported from the package: a wrong factor, unit or column there is not repeated here.
"""

from __future__ import annotations

from functools import cache
from math import pi, sin, sqrt
from typing import Any

from msgspec import Struct
from msgspec.structs import replace
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

STANDARD_GRAVITY = 9.80665
VACUUM_PERMITTIVITY = 8.8541878188e-12
SYMBOLS = {
    "length_m": ("length", "s", "m"),
    "amplitude_n": ("force amplitude", "F", "N"),
    "capsule_mass_kg": ("capsule mass", "M", "kg"),
    "frequency_hz": ("frequency", "f", "Hz"),
    "inclination_deg": ("inclination", "β", "°"),
    "restitution": ("restitution", "r", ""),
    "restitution_bottom": ("restitution at the bottom", "rbottom", ""),
    "restitution_top": ("restitution at the top", "rtop", ""),
}
"""Quantity, symbol and unit of what a sweep or a margin can be in; pages are read without their subscripts."""

SWEPT = "length_m", "amplitude_n", "frequency_hz", "inclination_deg"


class Device(Struct, frozen=True):
    """The inputs of a scenario."""

    capsule_mass_kg: float
    restitution: float  # the mean of both
    amplitude_n: float | None
    frequency_hz: float | None
    length_m: float | None
    inclination_deg: float | None
    gravity_m_s2: float
    period_ratio: int
    ball_mass_kg: float | None
    membrane: dict[str, Any]
    restitution_bottom: float
    restitution_top: float
    free: bool = False  # the capsule recoils

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
        """The weight that is held up, that of the ball too where it is not the shaker's motion that holds it."""
        return (self.capsule_mass_kg + self.recoiling_kg) * self.along_capsule / self.amplitude_n

    @property
    def along_capsule(self) -> float:
        return self.gravity_m_s2 * sin(pi / 180 * self.inclination_deg)

    @property
    def recoiling_kg(self) -> float:
        """Mass that a capsule recoils from."""
        return self.ball_mass_kg if self.free else 0.0

    @property
    def acceleration(self) -> float:
        """Of the capsule while the ball flies: the force, and the part of the support that is the ball's."""
        return (self.amplitude_n + self.recoiling_kg * self.along_capsule) / self.capsule_mass_kg

    @property
    def stroke(self) -> float:
        """Twice the amplitude F / (M omega^2); with a free one, of the centre of mass, and the ball on either side."""
        moved = 2 * self.amplitude_n / (2 * pi * self.frequency_hz) ** 2
        ball = self.recoiling_kg * self.length_m if self.free else 0.0
        return (moved + ball) / (self.capsule_mass_kg + self.recoiling_kg)

    @property
    def reduced_kg(self) -> float:
        """Mass of the relative motion: 1/m + 1/M of a free capsule."""
        return 1 / (1 / self.ball_mass_kg + (1 / self.capsule_mass_kg if self.free else 0.0))

    @property
    def period_s(self) -> float:
        """Of a 1:1 motion: n forcing periods."""
        return self.period_ratio / self.frequency_hz

    def deflection(self, speed: float) -> float:
        """(5.5)."""
        h, stiffness = self.membrane["exponent"], self.membrane["stiffness"]
        return float(((h + 1) / (2 * stiffness) * self.reduced_kg * speed**2) ** (1 / (h + 1)))

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

    def lost(self, bottom: float, top: float) -> float:
        """Kinetic energy that impacts at the bottom and at the top lose."""
        shares = (1 - self.restitution_bottom**2) * bottom**2 + (1 - self.restitution_top**2) * top**2
        return self.reduced_kg * shares / 2

    @property
    def determinant(self) -> float:
        """Of the Jacobian of a 1:1 motion: each impact takes its restitution twice, from a velocity and a time."""
        return (self.restitution_bottom * self.restitution_top) ** 2


@cache
def contact_time(exponent: float, restitution: float) -> float:
    """Duration of a contact m x'' = -K x^h (1 + D x'/v) that gives a restitution, over (m/K)^(1/(h+1)) v^((1-h)/(1+h)).

    Integrated numerically, with D by shooting.
    """

    def left(damping: float) -> tuple[float, float]:
        """Speed at which the ball leaves, over that at which it comes, and when."""

        def gone(_: float, y: Any) -> float:
            return y[0] if y[1] < 0 else 1.0

        gone.terminal = True  # type: ignore[attr-defined]
        flight = solve_ivp(
            lambda _, y: [y[1], -max(y[0], 0.0) ** exponent * (1 + damping * y[1])],
            (0, 1e4), [0.0, 1.0], events=gone, rtol=1e-9, atol=1e-12,
        )  # fmt: skip
        return -flight.y[1][-1], float(flight.t[-1])

    damping = brentq(lambda x: left(x)[0] - restitution, 0.0, 1 / restitution)
    return left(damping)[1]


def device_of(scenario: dict[str, Any]) -> Device:
    """The device of the scenario in results.json."""
    given, force, both = scenario["device"], scenario["excitation"], scenario["device"]["restitution"]
    bottom, top = (both if both is not None else given[f"restitution_{end}"] for end in ("bottom", "top"))
    return Device(
        given["capsule_mass_kg"], (bottom + top) / 2, force["amplitude_n"], force["frequency_hz"],
        given["length_m"], scenario["inclination_deg"], scenario["gravity_m_s2"], scenario["period_ratio"],
        given["ball_mass_kg"], given["membrane"], bottom, top, given["capsule"] == "free",
    )  # fmt: skip


def mean(values: Any) -> float:
    return float(sum(values) / len(values))
