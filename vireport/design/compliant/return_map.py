"""The return map of the motion between compliant membranes in a few milliseconds, with exact derivatives.

Contacts take a few per cent of the period, and flights are known in closed form. A contact is integrated in four
legs whose ends are known beforehand: from the touch to a depth, by the root of the depth, in which delta^h is smooth;
to the deepest point, by the velocity; for a time; and back to the surface, by the root of the depth again. No leg needs
a search for its end, so that the map is an analytic function of the touch.

The linearised (variational) equations are integrated by the same steps: their solution is the derivative of the
numerical map, to rounding. The derivative of a quantity x by the phase of the touch is the imaginary part of the
complex number `d_x`, the derivative by the velocity its real part. Sum and product rules are linear in `d_x` with real
coefficients, so that one line of code differentiates by both.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from functools import lru_cache
from math import ceil, cos, pi, prod, sin

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.base.records import ResultsBlock
from vireport.design.compliant.model import CompliantModel, ContactUnits, contact_units
from vireport.motions.stability import flight_jacobian
from vireport.physics import flight
from vireport.physics.forcing import Harmonic, Wave, force_rate, wave
from vireport.simulation.events import BOTTOM, TOP

Floats = NDArray[np.float64]

SUBSTEPS = (2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28)
"""Numbers of steps per leg that are extrapolated from. With the first six the return map of the paper's device is right
to 5e-6, with eight to 3e-7 at 1.7 times the cost, with all to 1e-10 at five times; there rounding takes over."""

LOADED = 0.75
"""Depth at which the first leg ends, over the largest one without other forces: there the ball is slow enough
for the depth to grow little, and fast enough to divide by its velocity. With 0.5 the error is a thousand times as
large, as the next leg divides by the force."""

UNLOADED = 0.55
"""Share of the time from deepest point to departure, without other forces, after which the last leg begins."""

SETTLED = 1e-13
"""Correction of a flight time, over the period of the motion, that ends the search."""

MOST_CORRECTIONS = 30
"""Largest number of Newton steps for a flight time, or for the place where the force is cut off; four are usual."""

SWITCHED = 1e-7
"""Last correction of the place in a leg where the force of the membrane is cut off."""

MOST_SWITCHES = 4
"""How often the force of the membrane may end or begin again in a part of a leg; once is usual."""

State = tuple[float, float, complex, complex]
"""Two unknowns a and b of a leg, and their derivatives d_a and d_b by the touch."""

STAYS = "the ball stays on the membrane instead of bouncing"
"""Why a contact has no end: it is pressed onto the membrane."""


class Bounce(ResultsBlock, frozen=True):
    """A contact from its touch, dimensionless.

    Attributes
    ----------
    wall
        1 at the bottom, −1 at the top
    velocity, phase : F π/(M ω), rad
        Z' and phase of the force, in [0, 2π), at the touch
    duration : half a forcing period
        until the ball leaves
    leaving : F π/(M ω)
        Z' then
    deflection : F π²/(M ω²)
        the largest one
    """

    wall: int
    velocity: float
    phase: float
    duration: float
    leaving: float
    deflection: float

    @property
    def restitution(self) -> float:
        """Speed after over speed before: r but for what gravity and the forcing do during the contact."""
        return -self.leaving / self.velocity


class ReturnTrip(Struct, frozen=True, eq=False):
    """A period of motion between compliant membranes, from a touch of the bottom to the next one.

    Attributes
    ----------
    bottom, top : Bounce
    flights : tuple of float
        Flight times up and down [t_c].
    time : float
        Time until the next touch [t_c].
    velocity : float
        Z' at the next touch [y_c].
    jacobian : ndarray
        Derivatives of velocity [y_c] and forcing phase [rad] at the next touch by those at the first one, (2, 2).
    """

    bottom: Bounce
    top: Bounce
    flights: tuple[float, float]
    time: float
    velocity: float
    jacobian: Floats


def bounce(model: CompliantModel, wall: int, velocity: float, phase: float, columns: int) -> tuple[Bounce, Floats]:
    """Integrate a contact from its touch to the departure, with its Jacobian.

    The Jacobian has the derivatives of velocity [y_c] and forcing phase [rad] at the end by those at the touch, (2, 2).

    Invariant: where a leg ends, but for the last one, the ball is on the membrane, and each `d_x` is the derivative by
    the touch of x at the end of the leg, not at a fixed time.

    Parameters
    ----------
    model : CompliantModel
    wall : int
    velocity : float
        Z' at the touch, towards the wall [y_c].
    phase : float
        Forcing phase there [rad].
    columns : int
        How many of `SUBSTEPS` are extrapolated from.

    Raises
    ------
    NumericalError
        If the ball is pressed onto the membrane instead of bouncing, or does not strike it from within.
    """
    if not wall * velocity > 0:
        raise NumericalError("the ball must strike a membrane with a velocity towards it")
    units = contact_units(model, wall, velocity)
    contact, turning = _Contact.of(model, units), pi * units.time
    # First leg: from the touch, where d_phase = i and d_v = 1, to the depth `LOADED`.
    touch = phase, units.speed, 1j, 1 + 0j
    loaded, fast, d_loaded, d_fast = _extrapolated(_ToDepth(contact), 0.0, 1.0, touch, columns)
    # Second leg: to the deepest point. The depth that it begins at is the same for all touches: its derivative is 0.
    stopping = _ToRest(contact, fast, d_fast)
    stopped, deepest, d_stopped, d_deepest = _extrapolated(stopping, 0.0, 1.0, (loaded, LOADED, d_loaded, 0j), columns)
    # Third leg: outwards for a time. The damping, D -> 1/r, brings the ball to a terminal velocity in ever shorter a
    # time: unsplit, this leg is wrong by 2e-7 for r = 0.5, by 6 % for r = 0.2.
    span, start = UNLOADED * (1 - (stopped - phase) / turning), (deepest, 0.0, d_deepest, 0j)
    parts = ceil(1 / model.restitution_at(wall))
    while True:
        outwards = _ForATime(contact, True, stopped, d_stopped, span)
        (end, v, d_end, d_v), pushed = _moved_out(outwards, start, columns, parts)
        if end > 0:
            break
        # The other forces have pulled the ball off the membrane before: the last leg must begin on it.
        span /= 2
    # Last leg: to the surface, which makes phase and velocity there the unknowns.
    start = stopped + span * turning, v, d_stopped, d_v
    (last, v, d_last, d_v), _ = _moved_out(_ToSurface(contact, pushed, end, d_end), start, columns)
    # Back from the units of the contact, in which towards the membrane is positive on either wall.
    unit = units.depth / units.time
    jacobian = np.array([[d_v.real, wall * unit * d_v.imag], [wall * d_last.real / unit, d_last.imag]])
    duration, leaving = (last - phase) / pi, wall * v * unit
    return Bounce(wall, velocity, phase % (2 * pi), duration, leaving, deepest * units.depth), jacobian


class _Contact(Struct, frozen=True, eq=False):
    """The equation of motion in a contact, y'' = p (gbar + force) - k y^h (1 + D v), in the units of the contact.

    Attributes
    ----------
    turning : float
        Forcing phase per unit of time [rad].
    touched : float
        Velocity at the touch.
    pull, gbar, harmonics
        The factor p, positive towards the membrane, gravity and the harmonics of the force.
    spring, exponent, damping : float
        k, h and D.
    """

    turning: float
    touched: float
    pull: float
    gbar: float
    harmonics: tuple[Harmonic, ...]
    spring: float
    exponent: float
    damping: float

    @classmethod
    def of(cls, model: CompliantModel, units: ContactUnits) -> _Contact:
        """The contact of a model that has these units."""
        forces = units.pull, model.gbar, model.harmonics, units.spring, model.membrane.exponent, units.damping
        return cls(pi * units.time, units.speed, *forces)

    def acceleration(self, phase: float, y: float, v: float, pushed: bool = True) -> tuple[float, float, float, float]:
        """The acceleration, with the membrane pushing or not, and its derivatives by phase, depth and velocity."""
        if self.harmonics:
            at = sin(phase), cos(phase), self.harmonics
            a, by_phase = self.pull * (self.gbar + wave(*at).force), self.pull * force_rate(*at)
        else:
            a, by_phase = self.pull * (self.gbar + cos(phase)), -self.pull * sin(phase)
        # At the surface, which rounding may miss to either side, the derivative would divide by the depth.
        if not (pushed and y > 0):
            return a, by_phase, 0.0, 0.0
        resisting, force = 1 + self.damping * v, self.spring * y**self.exponent
        return a - force * resisting, by_phase, -self.exponent * force * resisting / y, -force * self.damping

    def d_felt(self, v: float, d_v: complex) -> complex:
        """The derivative of the velocity as the damping force feels it.

        The units, though chosen by the velocity of the touch, count as constants in derivatives. The damping D, which
        goes with the inverse of that velocity, does not: the derivative of D v is D (d_v - v/v_touch).
        """
        return d_v - v / self.touched


# Each leg has a variable w from 0 to 1 in which its end is known beforehand. Of (phase, depth y, velocity v) one is a
# function of w, and the other two are the unknowns. With T the unit of time and a the acceleration, phase' = pi T,
# y' = v and v' = a, divided by the rate of w; each line with d_ is the derivative of the line before it.


class _Leg(Struct, frozen=True, eq=False):
    """A part of a contact, which has the derivatives of its two unknowns."""

    contact: _Contact

    @abstractmethod
    def rates(self, w: float, a: float, b: float, d_a: complex, d_b: complex) -> State:
        """Derivatives of a state by w."""


class _ToDepth(_Leg, frozen=True, eq=False):
    """The leg from the touch to the depth `LOADED`, at the depth `LOADED` w^2: the unknowns are phase and v.

    In w, the root of the depth, y^h is smooth for any exponent; the ball moves inwards all the time.
    """

    def rates(self, w: float, phase: float, v: float, d_phase: complex, d_v: complex) -> State:
        if not v > 0:
            raise NumericalError(STAYS)
        contact = self.contact
        rate = 2 * LOADED * w / v
        d_rate = -rate / v * d_v
        a, by_phase, _, by_velocity = contact.acceleration(phase, LOADED * w * w, v)
        d_a = by_phase * d_phase + by_velocity * contact.d_felt(v, d_v)
        return contact.turning * rate, rate * a, contact.turning * d_rate, d_rate * a + rate * d_a


class _ToRest(_Leg, frozen=True, eq=False):
    """The leg to the deepest point, at the velocity `fast` (1 - w): the unknowns are phase and y.

    The ball is slowed all the time, so that its velocity can be the variable. The end is then w = 1 for every touch; as
    a time it would have to be searched for.
    """

    fast: float
    d_fast: complex

    def rates(self, w: float, phase: float, y: float, d_phase: complex, d_y: complex) -> State:
        contact, v, d_v = self.contact, self.fast * (1 - w), self.d_fast * (1 - w)
        a, by_phase, by_depth, by_velocity = contact.acceleration(phase, y, v)
        if not a < 0:
            raise NumericalError(STAYS)
        rate = -self.fast / a
        d_a = by_phase * d_phase + by_depth * d_y + by_velocity * contact.d_felt(v, d_v)
        d_rate = -(self.d_fast + rate * d_a) / a
        return contact.turning * rate, rate * v, contact.turning * d_rate, d_rate * v + rate * d_v


class _OutwardLeg(_Leg, frozen=True, eq=False):
    """A leg on which the ball moves out, so that the membrane may stop pushing it, as it cannot pull.

    `pushed` is whether it pushes, and v the second unknown.
    """

    pushed: bool


class _ForATime(_OutwardLeg, frozen=True, eq=False):
    """The leg from rest for a `span` of units of time, begun at the phase `stopped`: the unknowns are y and v."""

    stopped: float
    d_stopped: complex
    span: float

    def rates(self, w: float, y: float, v: float, d_y: complex, d_v: complex) -> State:
        contact, span = self.contact, self.span
        phase = self.stopped + span * contact.turning * w
        a, by_phase, by_depth, by_velocity = contact.acceleration(phase, y, v, self.pushed)
        d_a = by_phase * self.d_stopped + by_depth * d_y + by_velocity * contact.d_felt(v, d_v)
        return span * v, span * a, span * d_v, span * d_a


class _ToSurface(_OutwardLeg, frozen=True, eq=False):
    """The leg from a `depth` to the surface, at the depth `depth` (1 - w)^2: the unknowns are phase and v."""

    depth: float
    d_depth: complex

    def rates(self, w: float, phase: float, v: float, d_phase: complex, d_v: complex) -> State:
        if not v < 0:
            raise NumericalError(STAYS)
        contact, left = self.contact, 1 - w
        rate = -2 * self.depth * left / v
        d_rate = -(2 * left * self.d_depth + rate * d_v) / v
        a, by_phase, by_depth, by_velocity = contact.acceleration(phase, self.depth * left * left, v, self.pushed)
        d_a = by_phase * d_phase + by_depth * left * left * self.d_depth + by_velocity * contact.d_felt(v, d_v)
        return contact.turning * rate, rate * a, contact.turning * d_rate, d_rate * a + rate * d_a


def _moved_out(leg: _OutwardLeg, state: State, columns: int, parts: int = 1) -> tuple[State, bool]:
    """The state at the end of a leg, and whether the membrane pushes the ball there.

    It pushes while 1 + D v > 0, v being the second unknown. The acceleration has a kink there, a switching surface: it
    is integrated up to the kink and from there on, as no extrapolation converges across. The force is continuous, so
    that the derivatives need no saltation matrix.

    Parameters
    ----------
    leg : _OutwardLeg
    state : State
        State at the beginning of the leg.
    columns : int
        How many of `SUBSTEPS` are extrapolated from.
    parts : int
        Number of equal parts in which the leg is integrated.

    Raises
    ------
    NumericalError
        If the force of the membrane ends and begins too often.
    """
    for part in range(parts):
        start, end = part / parts, (part + 1) / parts
        for _ in range(MOST_SWITCHES):
            after = _extrapolated(leg, start, end - start, state, columns)
            if (1 + leg.contact.damping * after[1] > 0) == leg.pushed:
                break
            start, state = _switch(leg, (start, end), state, after, columns)
            leg = replace(leg, pushed=not leg.pushed)
        else:
            raise NumericalError("the ball leaves the membrane and meets it again before the contact ends")
        state = after
    return state, leg.pushed


def _switch(
    leg: _OutwardLeg, bracket: tuple[float, float], state: State, after: State, columns: int
) -> tuple[float, State]:
    """Place w within a bracket at which the force of the membrane ends, or begins again, and the state there.

    `state` and `after` are the states at the ends of the bracket, as if the force went on. Newton's method is kept
    within the bracket. An error of w enters the state with its square only, as the force vanishes there.
    """
    damping, (start, end) = leg.contact.damping, bracket
    low, high, w = start, end, end
    for _ in range(MOST_CORRECTIONS):
        resisting = 1 + damping * after[1]
        if (resisting > 0) == leg.pushed:
            low = w
        else:
            high = w
        slope = damping * leg.rates(w, *after)[1]
        before, w = w, w - resisting / slope if slope else high
        if not low < w < high:
            w = (low + high) / 2
        after = _extrapolated(leg, start, w - start, state, columns)
        if abs(w - before) < SWITCHED:
            break
    return w, after


def _extrapolated(leg: _Leg, start: float, length: float, state: State, columns: int) -> State:
    """The state at the end of a part of a leg, by the extrapolation of Gragg, Bulirsch and Stoer.

    The modified midpoint rule errs by even powers of the step only. The loop is written out for the four numbers of a
    state: on arrays so short it would take several times as long.

    Parameters
    ----------
    leg : _Leg
    start, length : float
        Place w at which the part begins, and its length in w.
    state : State
        State where the part begins.
    columns : int
        How many of `SUBSTEPS` are extrapolated from.
    """
    rates, (a, b, d_a, d_b) = leg.rates, state
    ra, rb, d_ra, d_rb = rates(start, a, b, d_a, d_b)
    sum_a, sum_b, sum_d_a, sum_d_b = 0.0, 0.0, 0j, 0j
    for n, weight in _weights(columns):
        step, stride = length / n, 2 * length / n
        a0, b0, d_a0, d_b0 = a, b, d_a, d_b
        a1, b1, d_a1, d_b1 = a + step * ra, b + step * rb, d_a + step * d_ra, d_b + step * d_rb
        for k in range(1, n):
            pa, pb, d_pa, d_pb = rates(start + k * step, a1, b1, d_a1, d_b1)
            a0, a1, b0, b1 = a1, a0 + stride * pa, b1, b0 + stride * pb
            d_a0, d_a1, d_b0, d_b1 = d_a1, d_a0 + stride * d_pa, d_b1, d_b0 + stride * d_pb
        pa, pb, d_pa, d_pb = rates(start + length, a1, b1, d_a1, d_b1)
        # Gragg's smoothing: the mean of a1 and of one more step of Euler's from a0, halved in the weights.
        sum_a += weight * (a0 + a1 + step * pa)
        sum_b += weight * (b0 + b1 + step * pb)
        sum_d_a += weight * (d_a0 + d_a1 + step * d_pa)
        sum_d_b += weight * (d_b0 + d_b1 + step * d_pb)
    return sum_a, sum_b, sum_d_a, sum_d_b


@lru_cache
def _weights(columns: int) -> tuple[tuple[int, float], ...]:
    """Numbers of steps, and weights of their results in the extrapolation to steps of length zero.

    They are those of Lagrange's polynomial in the square of the step, halved: a result is the mean of two states.
    """
    squares = [(n, n * n) for n in SUBSTEPS[:columns]]
    return tuple((n, prod(node / (node - other) for _, other in squares if other != node) / 2) for n, node in squares)


def crossing(
    model: CompliantModel, wall: int, leaving: float, phase: float, guess: float
) -> tuple[float, float, Floats]:
    """Fly from a membrane to the other: return time near a guess [t_c], Z' there [y_c], and Jacobian as in `bounce`.

    Whether the ball touches a membrane before is not tested here, but by `model.free_flight`.

    Parameters
    ----------
    model : CompliantModel
    wall : int
        The membrane that is left.
    leaving, phase : float
        Z' [y_c] and forcing phase [rad] at the departure.
    guess : float
        Guess of the time of flight [t_c].

    Raises
    ------
    NumericalError
        If Newton's method finds no time.
    """
    gbar, t, harmonics = model.gbar, guess, model.harmonics
    begun = _force(phase, harmonics)
    for _ in range(MOST_CORRECTIONS):
        now = _force(phase + pi * t, harmonics)
        gap = flight.displacement(t, leaving, begun.impulse, begun.path, now.path, gbar) + wall * model.d
        velocity = flight.velocity(t, leaving, begun.impulse, now.impulse, gbar)
        if velocity == 0:
            break
        correction = gap / velocity
        t -= correction
        if not abs(t) < 10 * model.period:
            break  # Newton's method has lost the flight
        if abs(correction) < SETTLED * model.period:
            now = _force(phase + pi * t, harmonics)
            velocity = flight.velocity(t, leaving, begun.impulse, now.impulse, gbar)
            pulls = flight.acceleration(begun.force, gbar), flight.acceleration(now.force, gbar)
            # With r = -1 the velocity after the impact, which flies, is the one before it.
            time_time, time_velocity, velocity_time, velocity_velocity = flight_jacobian(
                t, (leaving, velocity), pulls, -1
            )
            jacobian = [[velocity_velocity, velocity_time / pi], [pi * time_velocity, time_time]]
            return t, velocity, np.array(jacobian)
    raise NumericalError("the ball does not reach the other membrane")


def _force(phase: float, harmonics: Sequence[Harmonic]) -> Wave:
    """The force, its impulse and its path at a forcing phase [rad]."""
    return wave(sin(phase), cos(phase), harmonics)


def return_trip(
    model: CompliantModel, velocity: float, phase: float, flights: tuple[float, float], columns: int
) -> ReturnTrip:
    """Apply the return map to a touch of the bottom membrane.

    Parameters
    ----------
    model : CompliantModel
    velocity, phase : float
        Z' [y_c] and forcing phase [rad] at the touch.
    flights : tuple of float
        Guesses of the times of flight up and down [t_c].
    columns : int
        How many of `SUBSTEPS` are extrapolated from in contacts.

    Raises
    ------
    NumericalError
        If the ball stays on a membrane, or does not reach the other one.
    """
    bottom, pressed_bottom = bounce(model, BOTTOM, velocity, phase, columns)
    elapsed = bottom.duration
    up, velocity_top, rising = crossing(model, BOTTOM, bottom.leaving, phase + pi * elapsed, flights[0])
    elapsed += up
    top, pressed_top = bounce(model, TOP, velocity_top, phase + pi * elapsed, columns)
    elapsed += top.duration
    down, end, falling = crossing(model, TOP, top.leaving, phase + pi * elapsed, flights[1])
    # The chain rule: the last part of the trip is the leftmost factor.
    jacobian = falling @ pressed_top @ rising @ pressed_bottom
    return ReturnTrip(bottom, top, (up, down), elapsed + down, end, jacobian)
