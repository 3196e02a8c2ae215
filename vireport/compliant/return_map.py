"""The return map of the compliant motion in a millisecond, with exact derivatives: for reports.

Contacts take a few per cent of the period, and flights are known in closed form. A contact is integrated in four
legs whose ends are known beforehand: from the touch to a depth, by the root of the depth, in which delta^h is smooth;
to the deepest point, by the velocity; for a time; and back to the surface, by the root of the depth again. No leg needs
a search for its end, so that the map is an analytic function of the touch, and a complex step gives its derivatives.
`membranes.compliant_motion` integrates in time with steps that adapt, by another method, and is the check of it.
"""

from __future__ import annotations

from cmath import cos as complex_cos
from cmath import sin as complex_sin
from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, pi

import numpy as np
from numpy.typing import NDArray

from vireport.base import NumericalError
from vireport.compliant.model import CompliantModel
from vireport.physics import contacts, flight, law_of
from vireport.simulation import BOTTOM, TOP

Floats = NDArray[np.float64]

SUBSTEPS = (2, 4, 6, 8, 10, 12, 14, 16)
"""Numbers of steps per leg that are extrapolated from. With all of them the return map of the paper's device is right
to 4e-7, with the first six to 5e-6, at six tenths of the cost."""

LOADED = 0.75
"""Depth at which the first leg ends, over the largest of a contact without other forces: there the ball is slow enough
for the depth to grow little, and fast enough to divide by its velocity. With 0.5 the error is a thousand times as
large, as the next leg divides by the force."""

UNLOADED = 0.55
"""Share of the time from the deepest point to the end, without other forces, after which the last leg begins."""

IMAGINARY = 1e-30
"""Complex step: nothing is subtracted, so that it may be far below rounding."""

SETTLED = 1e-13
"""Last relative correction of a flight time."""

MOST_CORRECTIONS = 30
"""Newton's steps for a flight time; about four are usual."""

Number = complex
"""A real number with, in its imaginary part, a derivative times `IMAGINARY`."""

Rates = Callable[[float, Number, Number], tuple[Number, Number]]
"""Derivatives of two unknowns as functions of the variable of a leg and of them."""


@dataclass(frozen=True, slots=True)
class Touch:
    """A contact from its touch, dimensionless: how long, the velocity Z' afterwards, and the largest deflection."""

    duration: Number
    leaving: Number
    deflection: Number


@dataclass(frozen=True, slots=True)
class Turn:
    """One period from a touch of the bottom to the next.

    Attributes
    ----------
    bottom, top : Touch
    phase_top, velocity_top : complex
        Forcing phase [rad] and Z' at the touch of the top.
    flights : tuple of float
        Flight times up and down [t_c].
    time : complex
        Until the next touch [t_c].
    velocity : complex
        Z' there.
    """

    bottom: Touch
    top: Touch
    phase_top: Number
    velocity_top: Number
    flights: tuple[float, float]
    time: Number
    velocity: Number


def touch(model: CompliantModel, wall: int, velocity: Number, phase: Number, columns: int) -> Touch:
    """Integrate a contact, as `membranes.compliant_motion.contact` does.

    Raises
    ------
    NumericalError
        If the ball is pressed onto the membrane instead of bouncing.
    """
    speed = wall * velocity
    if not speed.real > 0:
        raise NumericalError("the ball must strike a membrane with a velocity towards it")
    h, gbar = model.membrane.exponent, model.gbar
    alone = contacts(np.array(speed.real), model.membrane, model.restitution)
    time, depth = float(alone.duration), float(alone.deflection)
    # Units as in `membranes.compliant_motion.contact`, in which all stiffnesses look alike.
    spring = float(np.exp(np.log(model.membrane.stiffness) + (h - 1) * np.log(depth))) * time * time
    damping = law_of(h, model.restitution).damping / speed * depth / time
    pull, turning = wall * time * time / depth, pi * time

    def acceleration(t: Number, y: Number, v: Number) -> Number:
        resisting = 1 + damping * v
        push = spring * y**h * resisting if y.real > 0 and resisting.real > 0 else 0.0
        return pull * (gbar + complex_cos(turning * t + phase)) - push

    def in_depth(v: Number, speed_sign: int) -> Number:
        if not speed_sign * v.real > 0:
            raise NumericalError("the ball stays on the membrane instead of bouncing")
        return v

    def loading(w: float, t: Number, v: Number) -> tuple[Number, Number]:
        rate = 2 * LOADED * w / in_depth(v, 1)
        return rate, rate * acceleration(t, LOADED * w * w, v)

    def stopping(w: float, t: Number, y: Number) -> tuple[Number, Number]:
        a = acceleration(t, y, fast * (1 - w))
        if not a.real < 0:
            raise NumericalError("the ball stays on the membrane instead of bouncing")
        return -fast / a, -fast * fast * (1 - w) / a

    def turning_back(w: float, y: Number, v: Number) -> tuple[Number, Number]:
        return span * v, span * acceleration(stopped + span * w, y, v)

    t, fast = _integrated(loading, 0j, speed * time / depth, columns)
    stopped, deepest = _integrated(stopping, t, LOADED + 0j, columns)
    span = UNLOADED * (1 - stopped.real)
    # The damping, D -> 1/r, brings the ball to a velocity of its own in ever shorter a time: unsplit, this leg is wrong
    # by 2e-7 for r = 0.5, by 6 % for r = 0.2.
    end, v = _integrated(turning_back, deepest, 0j, columns, ceil(1 / model.restitution))

    def unloading(w: float, t: Number, v: Number) -> tuple[Number, Number]:
        left = 1 - w
        rate = -2 * end * left / in_depth(v, -1)
        return rate, rate * acceleration(t, end * left * left, v)

    t, v = _integrated(unloading, stopped + span, v, columns)
    return Touch(t * time, wall * v * depth / time, deepest * depth)


def _integrated(rates: Rates, a: Number, b: Number, columns: int, parts: int = 1) -> tuple[Number, Number]:
    """Two unknowns over a leg of length 1, in equal parts: the midpoint rule, extrapolated to steps of no length."""
    for part in range(parts):
        a, b = _extrapolated(rates, part / parts, 1 / parts, a, b, columns)
    return a, b


def _extrapolated(
    rates: Rates, start: float, length: float, a: Number, b: Number, columns: int
) -> tuple[Number, Number]:
    """One part of a leg, by Gragg's method: the modified midpoint rule errs by even powers of the step only."""
    table: list[tuple[Number, Number]] = []
    for n in SUBSTEPS[:columns]:
        step = length / n
        ra, rb = rates(start, a, b)
        a0, b0, a1, b1 = a, b, a + step * ra, b + step * rb
        for k in range(1, n):
            ra, rb = rates(start + k * step, a1, b1)
            a0, b0, a1, b1 = a1, b1, a0 + 2 * step * ra, b0 + 2 * step * rb
        ra, rb = rates(start + length, a1, b1)
        row = [((a0 + a1 + step * ra) / 2, (b0 + b1 + step * rb) / 2)]
        for k, (coarser_a, coarser_b) in enumerate(table):
            ratio = (n / SUBSTEPS[len(table) - 1 - k]) ** 2 - 1
            last_a, last_b = row[-1]
            row.append((last_a + (last_a - coarser_a) / ratio, last_b + (last_b - coarser_b) / ratio))
        table = row
    return table[-1]


def crossing(model: CompliantModel, wall: int, leaving: Number, phase: Number, guess: float) -> tuple[Number, Number]:
    """Fly from a membrane to the other one: time near a guess [t_c], and Z' there.

    Whether the ball touches a membrane before is not looked at: `model.free_flight` does.

    Raises
    ------
    NumericalError
        If Newton's method finds no time.
    """
    sine, cosine = complex_sin(phase), complex_cos(phase)
    t: Number = guess
    for _ in range(MOST_CORRECTIONS):
        now = phase + pi * t
        gap = flight.displacement(t, leaving, sine, cosine, complex_cos(now), model.gbar) + wall * model.d
        velocity = flight.velocity(t, leaving, sine, complex_sin(now), model.gbar)
        if velocity == 0:
            break
        correction = gap / velocity
        t -= correction
        if not abs(t) < 10 * model.period:
            break
        # The imaginary part, a derivative, is right one step after the real part is.
        if abs(correction.real) < SETTLED * model.period:
            now = phase + pi * t
            return t, flight.velocity(t, leaving, sine, complex_sin(now), model.gbar)
    raise NumericalError("the ball does not reach the other membrane")


def turn(model: CompliantModel, velocity: Number, phase: Number, flights: tuple[float, float], columns: int) -> Turn:
    """Apply the return map to a touch of the bottom; the flights take about the times given."""
    bottom = touch(model, BOTTOM, velocity, phase, columns)
    elapsed = bottom.duration
    up, velocity_top = crossing(model, BOTTOM, bottom.leaving, phase + pi * elapsed, flights[0])
    elapsed += up
    phase_top = phase + pi * elapsed
    top = touch(model, TOP, velocity_top, phase_top, columns)
    elapsed += top.duration
    down, end = crossing(model, TOP, top.leaving, phase + pi * elapsed, flights[1])
    return Turn(bottom, top, phase_top, velocity_top, (up.real, down.real), elapsed + down, end)


def repeated(
    model: CompliantModel, velocity: float, phase: float, flights: tuple[float, float], columns: int
) -> tuple[Floats, Floats, Turn]:
    """Mismatch of velocity and phase [rad] after a period, Jacobian of the return map, and the turn itself."""
    by_velocity = turn(model, complex(velocity, IMAGINARY), complex(phase, 0.0), flights, columns)
    by_phase = turn(model, complex(velocity, 0.0), complex(phase, IMAGINARY), flights, columns)
    mismatch = np.array([by_velocity.velocity.real - velocity, pi * (by_velocity.time.real - model.period)])
    derivatives = [
        (way.velocity.imag / IMAGINARY, pi * way.time.imag / IMAGINARY + own)
        for way, own in ((by_velocity, 0.0), (by_phase, 1.0))
    ]
    return mismatch, np.array(derivatives).T, by_velocity
