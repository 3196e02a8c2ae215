"""Closed-form flight of the ball between two impacts, and the impact law.

It turns a state just after an impact into the state any time later. Everything here is dimensionless
(length x_c, velocity y_c, time t_c = pi/omega), and knows nothing of periodic motions: the analytic
solution and the simulation both stand on it, and share nothing else.

The functions take the sines and cosines they need instead of phases, so that a caller who already has them
(arrays of motions, a simulation that carries them from impact to impact) does not pay for them twice. Where the force
has harmonics, its `Wave` has what stands in their places: the force and the path for a cosine, the impulse for a sine.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
from msgspec import Struct

from vireport.physics.numbers import Arithmetic

LARGEST_RESTITUTION = 0.99
"""Upper limit of a restitution that falls with speed: for a slow impact its law would give 1 and more."""


def acceleration(cosine: Arithmetic, gbar: Arithmetic) -> Any:
    """Relative acceleration Z'' = gbar + cos(phase), with the forcing cos(pi t + phi).

    Parameters
    ----------
    cosine : array_like
        Cosine of the forcing phase [-].
    gbar : array_like
        Gravity along the capsule over the forcing's acceleration, M g sin(beta)/F [-].

    Source: Eq. (2.8).
    """
    return gbar + cosine


def velocity(
    elapsed: Arithmetic,
    velocity_after: Arithmetic,
    sine_start: Arithmetic,
    sine: Arithmetic,
    gbar: Arithmetic,
    pi: Arithmetic = pi,
) -> Any:
    """Relative velocity Z' a time `elapsed` after an impact.

    Z'(t) = Z'+ + gbar t + [sin(phase) - sin(phase_start)]/pi.

    Parameters
    ----------
    elapsed : array_like
        Time since the impact [t_c].
    velocity_after : array_like
        Velocity just after it, Z'+ [y_c].
    sine_start, sine : array_like
        Sines of the forcing phase at the impact and now [-].
    gbar : array_like
        As in `acceleration` [-].

    Source: Eq. (2.11) with F1 of (3.13).
    """
    return velocity_after + gbar * elapsed + (sine - sine_start) / pi


def displacement(
    elapsed: Arithmetic,
    velocity_after: Arithmetic,
    sine_start: Arithmetic,
    cosine_start: Arithmetic,
    cosine: Arithmetic,
    gbar: Arithmetic,
    pi: Arithmetic = pi,
) -> Any:
    """Relative displacement Z - Z_start a time `elapsed` after an impact.

    Z - Z_start = Z'+ t + gbar t^2/2 - [cos(phase) - cos(phase_start)]/pi^2 - sin(phase_start) t/pi.

    Parameters are those of `velocity`, and the cosines of the forcing phase at the impact and now. Returned in [x_c].

    Source: Eq. (2.12) with F1 and F2 of (3.13).
    """
    drift = velocity_after + gbar * elapsed / 2 - sine_start / pi
    return drift * elapsed - (cosine - cosine_start) / (pi * pi)


def reflect(velocity_before: Arithmetic, restitution: Any) -> Any:
    """Velocity just after an impact, Z'+ = -r Z'-.

    Source: Eq. (2.10).
    """
    return -restitution * velocity_before


def restitution_at_speed(stated: Any, share: Any, exponent: Any) -> tuple[Any, Any]:
    """The restitution of an impact by the law r = stated * share^exponent, and the slope `d|Z'+|/d|Z'-|`.

    Parameters
    ----------
    stated : array_like
        r at the speed for which it is stated [-].
    share : array_like
        Speed just before the impact over that speed [-].
    exponent : array_like
        -1 < exponent <= 0 [-].

    Notes
    -----
    The velocity after the impact, `r |Z'-|`, grows with share^(1 + exponent): its slope is
    `r + |Z'-| dr/d|Z'-| = (1 + exponent) r`. Where the law exceeds `LARGEST_RESTITUTION`
    the restitution is that, and so is the slope.
    """
    # At speed 0, and for velocities of no impact that a solver tries, the power is infinite or no real number. The
    # largest restitution stands there, as wherever the law exceeds it: so the velocity after is continuous. Both
    # branches do the same: numbers of other kinds (decimals, numbers with errors) have no `np.where`.
    if isinstance(share, np.ndarray):
        with np.errstate(all="ignore"):
            r = stated * share**exponent
            capped = ~((np.real(share) > 0) & (np.real(r) < LARGEST_RESTITUTION))
        return np.where(capped, LARGEST_RESTITUTION, r), np.where(capped, LARGEST_RESTITUTION, (1 + exponent) * r)
    if share.real > 0:
        r = stated * share**exponent
        if r.real < LARGEST_RESTITUTION:
            return r, (1 + exponent) * r
    most = type(share)(LARGEST_RESTITUTION)
    return most, most


class Flight(Struct, frozen=True, eq=False):
    """A flight from one impact to the next, as numbers or arrays of one shape (dimensionless).

    Attributes
    ----------
    direction : int
        Sign of a velocity away from the membrane left: -1 from the bottom, 1 from the top.
    velocity : array_like
        Z' just after the impact that it begins with.
    sine, cosine : array_like
        Of the forcing phase at that impact.
    duration : array_like
        Flight time [t_c].
    gbar, d : array_like
        Gravity, and the distance between the membranes.
    """

    direction: int
    velocity: Any
    sine: Any
    cosine: Any
    duration: Any
    gbar: Any
    d: Any

    def select(self, index: Any) -> Flight:
        """The flights picked by an index or mask, of arrays of one shape."""
        return Flight(self.direction, *(getattr(self, name)[index] for name in FLIGHT_NUMBERS))

    def speed(self, t: Arithmetic, sine: Arithmetic, pi: Arithmetic = pi) -> Any:
        """Velocity away from the membrane left, a time t after the impact, where the phase has this sine."""
        return self.direction * velocity(t, self.velocity, self.sine, sine, self.gbar, pi=pi)

    def covered(self, t: Arithmetic, cosine: Arithmetic, pi: Arithmetic = pi) -> Any:
        """Distance from the membrane left, a time t after the impact, where the phase has this cosine."""
        return self.direction * displacement(t, self.velocity, self.sine, self.cosine, cosine, self.gbar, pi=pi)

    def pressing(self, cosine: Arithmetic) -> Any:
        """Acceleration away from the membrane left, where the phase has this cosine."""
        return self.direction * acceleration(cosine, self.gbar)

    def jerk(self, sine: Arithmetic, pi: Arithmetic = pi) -> Any:
        """Rate of the acceleration away from the membrane left, where the phase has this sine."""
        return -self.direction * pi * sine

    def turned(self, sine: Arithmetic, cosine: Arithmetic) -> tuple[Any, Any]:
        """Sine and cosine of the phase at the impact plus an angle, from sine and cosine of the angle."""
        return self.sine * cosine + self.cosine * sine, self.cosine * cosine - self.sine * sine


FLIGHT_NUMBERS = tuple(name for name in Flight.__struct_fields__ if name != "direction")
"""Names of the fields of `Flight` that are numbers or arrays."""
