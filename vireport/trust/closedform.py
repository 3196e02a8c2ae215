"""A motion and a critical point by formula from a guess: the closed form, and the paper's own iteration.

Velocity, d and gbar of a motion are explicit in u = q - 1/2 and the phase, so that a motion of given (d, gbar), and a
critical point of a sweep, are two equations in those two unknowns. The paper iterates on its equations (3.15)-(3.17) in
three. Both are solved by the same procedure as the methods that integrate a flight.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, cos, pi, sin, sqrt

from vireport.analysis import (
    Held,
    Orbits,
    Sweep,
    coefficients,
    flight_jacobian,
    level_residual,
    orbits,
    return_trace,
)
from vireport.errors import NumericalError
from vireport.trust.integrators import Budget
from vireport.trust.methods import Found, Groups
from vireport.trust.quasinewton import quasi_newton

DIFFERENCE = 1e-7
"""Step of forward differences of formulae that are right to rounding."""

ROUNDING = 1e-13
"""Residual at which a standstill of the iteration is rounding."""


@dataclass(frozen=True, slots=True)
class Guess:
    """Where every method begins.

    Attributes
    ----------
    phase, velocity : float
        At the bottom impact [rad], [y_c].
    q : float
    value : float
        The swept parameter (of a motion: as asked for; of a critical point: a guess).
    """

    phase: float
    velocity: float
    q: float
    value: float


@dataclass(frozen=True, slots=True)
class Wanted:
    """A motion or a critical point to be found along a sweep.

    Attributes
    ----------
    sweep : Sweep
    kind : str
        ``orbit``, or the kind of a critical point.
    symmetric : bool
        Whether it is a symmetric motion of a horizontal capsule.
    guess : Guess
    """

    sweep: Sweep
    kind: str
    symmetric: bool
    guess: Guess

    @property
    def r(self) -> float:
        """Restitution."""
        return float(self.sweep.device.restitution)

    @property
    def n(self) -> int:
        """Forcing periods of the motion."""
        return self.sweep.device.period_ratio

    @property
    def trace(self) -> float:
        """Trace of DP at the critical point: a multiplier of -1 or of +1."""
        return (-1.0 if self.kind == "period_doubling" else 1.0) * (1 + self.r**4)

    @property
    def groups(self) -> Groups:
        """D and gbar at a value of the swept parameter."""
        device, parameter = self.sweep.device, self.sweep.parameter
        return lambda value: tuple(map(float, device.groups(parameter, value)))  # type: ignore[return-value]


def closed_orbit(wanted: Wanted, stop: float, budget: Budget) -> Found:
    """The motion at the value of the guess: where the surface over (u, phase) has the d and gbar asked for.

    A symmetric motion is explicit: u = 0, and d alone is left to give the phase.
    """
    r, n = wanted.r, wanted.n
    d, gbar = wanted.groups(wanted.guess.value)
    orbit = _surface(wanted, budget)
    if wanted.symmetric:
        k = coefficients(0.0, r, n, math)
        return _found(orbit([0.0, _angle(k.d_sine, k.d_cosine, d, wanted.guess.phase)]))

    def residual(x: list[float]) -> list[float]:
        at = orbit(x)
        return [at.gbar - gbar, at.d - d]

    start = [wanted.guess.q - 0.5, wanted.guess.phase]
    return _found(orbit(quasi_newton(residual, start, DIFFERENCE, stop, ROUNDING)))


def closed_critical(wanted: Wanted, stop: float, budget: Budget) -> float:
    """Value of the swept parameter at the critical point: the surface on the sweep's level, and the trace, together.

    On the symmetric motions u = 0 takes the place of the level, and the phase is the one unknown.
    """
    r, level, orbit = wanted.r, wanted.sweep.level, _surface(wanted, budget)

    def symmetric(x: list[float]) -> list[float]:
        return [return_trace(orbit([0.0, x[0]]), r) - wanted.trace]

    def residual(x: list[float]) -> list[float]:
        at = orbit(x)
        return [level_residual(level, at), return_trace(at, r) - wanted.trace]

    if wanted.symmetric:
        found = [0.0, *quasi_newton(symmetric, [wanted.guess.phase], DIFFERENCE, stop, ROUNDING)]
    else:
        start = [wanted.guess.q - 0.5, wanted.guess.phase]
        found = quasi_newton(residual, start, DIFFERENCE, stop, ROUNDING)
    end = orbit(found)
    d = level.value if level.held is Held.D else float(end.d)
    gbar = level.value if level.held is Held.GBAR else float(end.gbar)
    return float(wanted.sweep.value(d, gbar))


def _surface(wanted: Wanted, budget: Budget) -> Callable[[list[float]], Orbits]:
    """The motion over (u, phase), in plain floats."""
    r, n = wanted.r, wanted.n

    def orbit(x: list[float]) -> Orbits:
        budget.spend(1)
        return orbits(x[0], x[1], r, n, math)

    return orbit


def printed_orbit(wanted: Wanted, stop: float, budget: Budget) -> Found:
    """The motion by Newton's method on (3.15)-(3.17), three equations in velocity, phase and q."""
    g = wanted.guess
    d, gbar = wanted.groups(g.value)

    def residual(x: list[float]) -> list[float]:
        budget.spend(1)
        return _printed(x[0], x[1], x[2], d, gbar, wanted)

    velocity, phase, q = quasi_newton(residual, [g.velocity, g.phase, g.q], DIFFERENCE, stop, ROUNDING)
    return Found(phase % (2 * pi), velocity, 2 * wanted.n * gbar / (1 + wanted.r) - velocity, q)


def printed_critical(wanted: Wanted, stop: float, budget: Budget) -> float:
    """The critical point by Newton's method on (3.15)-(3.17) and the trace (4.2), with the swept value unknown.

    On the symmetric motions, where (3.15) and (3.16) coincide, q = 1/2 takes the place of (3.16).
    """
    g, groups, r, n = wanted.guess, wanted.groups, wanted.r, wanted.n
    unit = abs(g.value) or 1.0

    def residual(x: list[float]) -> list[float]:
        budget.spend(1)
        velocity, phase, q, value = x
        d, gbar = groups(value * unit)
        three = _printed(velocity, phase, q, d, gbar, wanted)
        if wanted.symmetric:
            three[1] = q - 0.5
        up, top = 2 * n * q, 2 * n * gbar / (1 + r) - velocity
        first, second = gbar + cos(phase), gbar + cos(phase + pi * up)
        a11, a12, a21, a22 = flight_jacobian(up, velocity, top, first, second, r)
        b11, b12, b21, b22 = flight_jacobian(2 * n - up, top, velocity, second, first, r)
        return [*three, b11 * a11 + b12 * a21 + b21 * a12 + b22 * a22 - wanted.trace]

    return quasi_newton(residual, [g.velocity, g.phase, g.q, g.value / unit], DIFFERENCE, stop, ROUNDING)[3] * unit


def _printed(v: float, phase: float, q: float, d: float, gbar: float, wanted: Wanted) -> list[float]:
    """Residuals of (3.15), of (3.16) freed of its arcsine, and of (3.17), at t0 = 0."""
    r, n = wanted.r, wanted.n
    period = 2 * n
    up, down, angle = period * q, period * (1 - q), 2 * pi * n * q
    s = sin(phase)
    return [
        (r - 1) * v - (sin(angle + phase) - s) / pi + gbar * (period / (1 + r) - up),
        s - pi / 2 * gbar * (up - down) + pi / period * v * (r * up - down),
        (pi * (v * (r - 1) - period * gbar * (q - 1 / (1 + r)))) ** 2
        + (pi * pi * (period * q * (1 - q) * (1 + r) * v + 2 * n * n * gbar * q * (q - 1) - d)) ** 2
        - 2
        + 2 * cos(angle),
    ]


def _angle(a: float, b: float, c: float, near: float) -> float:
    """The angle with a sin + b cos = c that is nearer to a given one."""
    size = sqrt(a * a + b * b)
    if not size > 0:
        raise NumericalError("the closed form is degenerate: its level does not depend on the phase")
    ratio = c / size
    middle, half = atan2(a, b), math.acos(max(-1.0, min(1.0, ratio)))
    return max((middle + half, middle - half), key=lambda angle: cos(angle - near))


def _found(orbit: Orbits) -> Found:
    return Found(orbit.phi % (2 * pi), float(orbit.velocity_bottom), float(orbit.velocity_top), 0.5 + orbit.u)
