"""The model in 40-digit arithmetic, written from the printed equations and sharing no line with the package.

Unknowns are the paper's: the velocity at the bottom impact, the phase there and the flight time to the top; the
residuals are the two maps (3.3)-(3.6) closed by periodicity. Traces are by (A.4) as printed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpmath import mp, mpf

from vireport.analysis.sweep import Sweep
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter

DIGITS = 40
PHYSICAL = {"length_m": 0, "amplitude_n": 1, "frequency_hz": 2, "inclination_deg": 3}


def groups(device: Device, parameter: str, value: mpf) -> tuple[mpf, mpf]:
    """d and gbar in exact terms of the device's doubles, Eqs. (2.5) and (2.6)."""
    x = {name: mpf(0 if (v := getattr(device, name)) is None else v) for name in Parameter}
    x[parameter] = value
    omega = 2 * mp.pi * x["frequency_hz"]
    length_unit = x["amplitude_n"] * mp.pi**2 / (mpf(device.capsule_mass_kg) * omega**2)
    weight = mpf(device.capsule_mass_kg) * mpf(device.gravity_m_s2) * mp.sin(x["inclination_deg"] * mp.pi / 180)
    return x["length_m"] / length_unit, weight / x["amplitude_n"]


def position_and_velocity(t: mpf, start: mpf, speed: mpf, phase: mpf, gbar: mpf) -> tuple[mpf, mpf]:
    """Z and Z' a time t after leaving `start` with `speed`, Eqs. (2.11) and (2.12) with (3.13)."""
    f1, f1_start = mp.sin(mp.pi * t + phase) / mp.pi, mp.sin(phase) / mp.pi
    f2, f2_start = -mp.cos(mp.pi * t + phase) / mp.pi**2, -mp.cos(phase) / mp.pi**2
    velocity = speed + gbar * t + f1 - f1_start
    return start + speed * t + gbar / 2 * t**2 + f2 - f2_start - f1_start * t, velocity


@dataclass(frozen=True)
class Case:
    """A sweep and the family of periods asked for."""

    sweep: Sweep

    def residuals(self, x: list[mpf]) -> list[mpf]:
        """Maps P1 and P2 closed after 2n: x = (velocity, phase, flight time up, swept value)."""
        velocity, phase, up, value = x[:4]
        device = self.sweep.device
        d, gbar = groups(device, self.sweep.parameter, value)
        r, down = mpf(device.restitution), 2 * device.period_ratio - up
        top, velocity_top = position_and_velocity(up, d / 2, -r * velocity, phase, gbar)
        bottom, velocity_back = position_and_velocity(down, -d / 2, -r * velocity_top, phase + mp.pi * up, gbar)
        return [top + d / 2, bottom - d / 2, velocity_back - velocity]

    def velocity_top(self, x: list[mpf]) -> mpf:
        """Velocity at the top impact, from the flight itself."""
        velocity, phase, up, value = x[:4]
        d, gbar = groups(self.sweep.device, self.sweep.parameter, value)
        return position_and_velocity(up, d / 2, -mpf(self.sweep.device.restitution) * velocity, phase, gbar)[1]

    def trace(self, x: list[mpf]) -> mpf:
        """Tr(DP) by Eq. (A.4)."""
        velocity, phase, up, value = x[:4]
        device = self.sweep.device
        _, g = groups(device, self.sweep.parameter, value)
        r, period = mpf(device.restitution), mpf(2 * device.period_ratio)
        down = period - up
        f0, f1, f2 = mp.cos(phase), mp.cos(phase + mp.pi * up), mp.cos(phase + mp.pi * period)
        s3 = velocity - g * period / (r + 1)
        s1 = up * f0 - r * velocity + g * up
        s2 = down * f1 + r * s3 + g * down
        return (
            (r + r * up * (g + f1) / s3) * (r - r * down * (g + f2) / velocity)
            + r * up * (g + f1 - (g + f2) * s2 / velocity) / s3
            - r * down * (g + f0 + (g + f1) * s1 / s3) / velocity
            - s2 * s1 / (velocity * s3)
        )

    def turning(self, x: list[mpf], upward: bool, at_bottom: bool) -> list[mpf]:
        """Velocity and distance to a wall a time x[4] after the flight began: both zero at grazing."""
        velocity, phase, up, value, t = x
        d, gbar = groups(self.sweep.device, self.sweep.parameter, value)
        r = mpf(self.sweep.device.restitution)
        if upward:
            z, v = position_and_velocity(t, d / 2, -r * velocity, phase, gbar)
        else:
            z, v = position_and_velocity(t, -d / 2, -r * self.velocity_top(x), phase + mp.pi * up, gbar)
        return [v, z - d / 2 if at_bottom else z + d / 2]


def newton(function, x: list[float], steps: int = 6) -> list[mpf]:
    """Solve function(x) = 0 from a guess; with more unknowns than equations, for the nearest solution."""
    x = [mpf(float(v)) for v in x]
    scale = [abs(v) or mpf(1) for v in x]
    for _ in range(steps):
        value = mp.matrix(function(x))
        h = mpf(10) ** (-DIGITS // 2)
        columns = []
        for i, s in enumerate(scale):
            shifted = list(x)
            shifted[i] += h * s
            columns.append((mp.matrix(function(shifted)) - value) / h)
        jacobian = mp.matrix([[column[k] for column in columns] for k in range(len(value))])
        transposed = jacobian.T
        step = transposed * mp.lu_solve(jacobian * transposed, value)
        x = [v - s * step[i] for i, (v, s) in enumerate(zip(x, scale, strict=True))]
        if mp.norm(step) < mpf(10) ** (-DIGITS // 2 - 8):
            break
    return x


def random_sweeps(count: int, seed: int) -> list[Sweep]:
    """Scenarios over the whole range of restitution and inclination and all four sweeps, some horizontal."""
    rng = np.random.default_rng(seed)
    found = []
    for i in range(count):
        parameter = tuple(Parameter)[i % 4]
        inclination = 0.0 if i % 11 == 0 else float(rng.uniform(0.5, 90.0))
        mass, frequency = float(10 ** rng.uniform(-2, 0.5)), float(10 ** rng.uniform(-0.3, 1.5))
        gbar = float(10 ** rng.uniform(-2, 0.1))
        force = mass * 9.8 * np.sin(np.radians(inclination or 30.0)) / gbar
        d = float(10 ** rng.uniform(-1.0, 0.2))
        length = d * force / (4 * mass * frequency**2)
        values = {
            "length_m": length,
            "amplitude_n": float(force),
            "frequency_hz": frequency,
            "inclination_deg": inclination,
        }
        if parameter == "inclination_deg":
            start, end = sorted(rng.uniform(0.0, 90.0, 2))
        else:
            start, end = values[parameter] * rng.uniform(0.3, 0.9), values[parameter] * rng.uniform(1.1, 3.0)
        device = Device(mass, float(rng.uniform(0.05, 0.95)), 9.8, **values)
        found.append(Sweep(device, parameter, float(start), float(end)))
    return found
