"""The motion, its critical points and its voltage in 40-digit arithmetic, from the printed equations alone.

What the methods of the accuracy study are measured against. Nothing is shared with the closed form: the unknowns
are the velocity, the phase and the flight time of the two maps (3.3)-(3.6), closed after 2n by (3.1), traces are by
(A.4) as printed, voltages by (5.1)-(5.5) as printed. The numbers of the scenario are taken as the doubles they are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mpmath import mp, mpf  # type: ignore[import-untyped]

from vireport.errors import NumericalError

if TYPE_CHECKING:
    from vireport.energy import Membrane
    from vireport.model import Device

DIGITS = 40
"""Digits that are right in every number given back."""

GUARD = 15
"""Further digits that are carried, for what the conditioning next to a critical point costs."""

MOST_STEPS = 12
"""Newton's corrections; from a double four are usual."""

Number = Any
"""An `mpf`, of a package without type hints."""

Condition = Callable[[list[Number]], list[Number]]


@dataclass(frozen=True, slots=True)
class ReferenceOrbit:
    """A motion with one impact on each membrane, to 40 digits.

    Attributes
    ----------
    value : mpf
        The swept parameter, in its unit.
    velocity, velocity_top : mpf
        Just before the impacts at the bottom and at the top [y_c].
    phase : mpf
        At the bottom impact [rad], near the guess.
    q : mpf
        Share of the period from bottom to top.
    velocity_unit : mpf
        y_c [m/s].
    residual : float
        Largest residual of the equations that were solved.
    """

    value: Number
    velocity: Number
    velocity_top: Number
    phase: Number
    q: Number
    velocity_unit: Number
    residual: float


def reference_orbit(device: Device, parameter: str, value: float, guess: Sequence[float]) -> ReferenceOrbit:
    """The motion at a value of a parameter.

    Parameters
    ----------
    device : Device
    parameter : str
        Which of its parameters has the value.
    value : float
    guess : sequence of three floats
        Velocity before the bottom impact [y_c], phase there [rad] and q, to a few digits.

    Raises
    ------
    NumericalError
        If Newton's corrections do not settle.
    """
    with mp.workdps(DIGITS + GUARD):
        problem = _Problem(device, parameter)
        velocity, phase, q = guess
        start = [mpf(velocity), mpf(phase), problem.period * mpf(q)]
        held = mpf(value)
        found, residual = _newton(lambda x: problem.closure([*x, held]), start)
        return problem.orbit([*found, held], residual)


def reference_critical(device: Device, parameter: str, kind: str, guess: Sequence[float]) -> ReferenceOrbit:
    """A critical point, with the value of the parameter that it stands at.

    Parameters
    ----------
    device : Device
    parameter : str
        The one that is swept.
    kind : str
        ``period_doubling``, ``fold`` or ``pitchfork``.
    guess : sequence of four floats
        Velocity, phase and q, as in `reference_orbit`, and the value of the parameter.

    Raises
    ------
    NumericalError
        If Newton's corrections do not settle.

    Notes
    -----
    A pitchfork is a double point of the curve of motions; on the symmetric motions (q = 1/2, equal speeds) alone it
    is a simple one, and is solved for there.
    """
    with mp.workdps(DIGITS + GUARD):
        problem = _Problem(device, parameter)
        sign = -1 if kind == "period_doubling" else 1
        velocity, phase, q, value = (mpf(number) for number in guess)
        target = sign * (1 + problem.r**4)
        if kind == "pitchfork":
            half = problem.period / 2

            def symmetric(x: list[Number]) -> list[Number]:
                full = [x[0], x[1], half, x[2]]
                return [problem.closure(full)[0], problem.velocity_top(full) + x[0], problem.trace(full) - target]

            (velocity, phase, value), residual = _newton(symmetric, [velocity, phase, value])
            return problem.orbit([velocity, phase, half, value], residual)
        found, residual = _newton(
            lambda x: [*problem.closure(x), problem.trace(x) - target], [velocity, phase, problem.period * q, value]
        )
        return problem.orbit(found, residual)


def reference_voltage(speed_bottom: Number, speed_top: Number, mass: float, membrane: Membrane) -> Number:
    """U_ave of a motion with one impact on each membrane [V], Eq. (5.1).

    Parameters
    ----------
    speed_bottom, speed_top : mpf
        Relative velocities at the impacts, of either sign [m/s].
    mass : float
        Of the ball [kg].
    membrane : Membrane
    """
    with mp.workdps(DIGITS + GUARD):
        return sum(_gain(mpf(speed), mpf(mass), membrane) for speed in (speed_bottom, speed_top)) / 2


def _gain(speed: Number, mass: Number, membrane: Membrane) -> Number:
    """U_imp - Uin [V], Eqs. (5.2)-(5.5) as printed."""
    h, k, uin = mpf(membrane.exponent), mpf(membrane.stiffness), mpf(membrane.bias_voltage_v)
    rc, rb = mpf(membrane.active_radius_m), mpf(membrane.ball_radius_m)
    delta = ((h + 1) / (2 * k) * mass * speed**2) ** (1 / (h + 1))
    cosine = (-2 * rb * (delta - rb) + 2 * rc * mp.sqrt(rc**2 + delta**2 - 2 * delta * rb)) / (
        2 * (rc**2 + (delta - rb) ** 2)
    )
    area = 2 * mp.pi * rb**2 * (1 - cosine) + (mp.pi * rc**2 - mp.pi * rb**2 * (1 - cosine**2)) / cosine
    return (area / (mp.pi * rc**2)) ** 2 * uin - uin


class _Problem:
    """The printed equations for a device; unknowns are x = (velocity, phase, flight time up, swept value)."""

    def __init__(self, device: Device, parameter: str) -> None:
        self.parameter = parameter
        self.values = {
            name: mpf(0 if (value := getattr(device, name)) is None else value)
            for name in ("length_m", "amplitude_n", "frequency_hz", "inclination_deg")
        }
        self.mass, self.gravity = mpf(device.capsule_mass_kg), mpf(device.gravity_m_s2)
        self.r, self.period = mpf(device.restitution), mpf(2 * device.period_ratio)

    def units(self, value: Number) -> tuple[Number, Number, Number]:
        """d, gbar and y_c, Eqs. (2.5) and (2.6)."""
        at = self.values | {self.parameter: value}
        force, omega = at["amplitude_n"], 2 * mp.pi * at["frequency_hz"]
        length_unit = force * mp.pi**2 / (self.mass * omega**2)
        gbar = self.mass * self.gravity * mp.sin(at["inclination_deg"] * mp.pi / 180) / force
        return at["length_m"] / length_unit, gbar, force * mp.pi / (self.mass * omega)

    def closure(self, x: list[Number]) -> list[Number]:
        """Maps P1 and P2, Eqs. (3.3)-(3.6), closed by (3.1): two positions and a velocity."""
        velocity, phase, up, value = x
        d, gbar, _ = self.units(value)
        down = self.period - up
        rise, velocity_top = _flight(up, -self.r * velocity, phase, gbar)
        fall, velocity_back = _flight(down, -self.r * velocity_top, phase + mp.pi * up, gbar)
        return [rise + d, fall - d, velocity_back - velocity]

    def velocity_top(self, x: list[Number]) -> Number:
        """Velocity before the top impact, Eq. (3.3)."""
        velocity, phase, up, value = x
        return _flight(up, -self.r * velocity, phase, self.units(value)[1])[1]

    def trace(self, x: list[Number]) -> Number:
        """Tr(DP), Eq. (A.4)."""
        velocity, phase, up, value = x
        g, r = self.units(value)[1], self.r
        down = self.period - up
        f0, f1, f2 = (mp.cos(phase + mp.pi * t) for t in (0, up, self.period))
        s3 = velocity - g * self.period / (r + 1)
        s1 = up * f0 - r * velocity + g * up
        s2 = down * f1 + r * s3 + g * down
        return (
            (r + r * up * (g + f1) / s3) * (r - r * down * (g + f2) / velocity)
            + r * up * (g + f1 - (g + f2) * s2 / velocity) / s3
            - r * down * (g + f0 + (g + f1) * s1 / s3) / velocity
            - s2 * s1 / (velocity * s3)
        )

    def orbit(self, x: list[Number], residual: float) -> ReferenceOrbit:
        """The unknowns as a motion."""
        velocity, phase, up, value = x
        unit = self.units(value)[2]
        return ReferenceOrbit(value, velocity, self.velocity_top(x), phase, up / self.period, unit, residual)


def _flight(t: Number, speed: Number, phase: Number, gbar: Number) -> tuple[Number, Number]:
    """Displacement and velocity a time t after an impact, Eqs. (2.12) and (2.11) with (3.13)."""
    f1, f1_start = mp.sin(mp.pi * t + phase) / mp.pi, mp.sin(phase) / mp.pi
    f2, f2_start = -mp.cos(mp.pi * t + phase) / mp.pi**2, -mp.cos(phase) / mp.pi**2
    moved = speed * t + gbar / 2 * t**2 + f2 - f2_start - f1_start * t
    return moved, speed + gbar * t + f1 - f1_start


def _newton(function: Condition, start: list[Number]) -> tuple[list[Number], float]:
    """Solve as many equations as unknowns from a guess; the unknowns and the largest residual left."""
    x, scale = start, [abs(number) or mpf(1) for number in start]
    difference, last = mpf(10) ** (-(DIGITS + GUARD) // 2), mpf(10) ** (-DIGITS - 3)
    for _ in range(MOST_STEPS):
        value = function(x)
        columns = []
        for i, size in enumerate(scale):
            shifted = [number + difference * size * (k == i) for k, number in enumerate(x)]
            columns.append([(a - b) / difference for a, b in zip(function(shifted), value, strict=True)])
        try:
            step = mp.lu_solve(mp.matrix(columns).T, mp.matrix(value))
        except ZeroDivisionError as error:
            raise NumericalError("the reference is degenerate: its equations do not depend on the motion") from error
        x = [number - size * step[i] for i, (number, size) in enumerate(zip(x, scale, strict=True))]
        if max(abs(s) for s in step) < last:
            return x, float(max(abs(number) for number in function(x)))
    raise NumericalError(f"the reference did not settle to {DIGITS} digits from the guess")


def digits(number: Number, count: int) -> str:
    """A number as text with so many digits."""
    with mp.workdps(DIGITS + GUARD):
        return str(mp.nstr(number, count))
