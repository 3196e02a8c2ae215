"""One contact of the ball with a compliant membrane, without any other force: closed forms.

The membrane pushes back with K delta^h (1 + lambda delta'), a spring with (5.5)'s potential and the damping of Hunt
and Crossley (1975), so that m delta'' = -K delta^h (1 + lambda delta'). With D = lambda v, v the impact velocity, and
e^s = 1 + lambda delta', the energy equation integrates to

    delta^(h+1) = (h+1) (m/K) v^2 g,    g = [Phi(ln(1+D)) - Phi(s)]/D^2,    Phi(s) = e^s - 1 - s,

and the ball leaves where Phi is the same again. That gives the restitution coefficient r for any h and any v if

    ln((1+D)/(1 - r D)) = (1 + r) D,

and a duration tau(h, r) (m/K)^(1/(h+1)) v^(-(h-1)/(h+1)). SI units or dimensionless, as the arguments are. The
forcing and gravity, which act during a contact too, are in `compliant.model`, not here.
"""

from __future__ import annotations

from functools import lru_cache
from math import asinh, exp, expm1, factorial, inf, log1p, pi

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.physics.energy import Membrane

Floats = NDArray[np.float64]

SMALLEST_RESTITUTION = 1e-3
"""Least restitution coefficient r allowed: as r falls D grows as 1/r, and the ball leaves ever more slowly. No finite
damping of this kind gives r = 0."""

SLOWEST = 1e-200
"""Least impact velocity: a contact becomes endless as it vanishes, and damping infinite."""

SERIES = 0.25
"""Argument below which differences of nearly equal terms are summed as series."""

TERMS = 24
"""Number of terms of the series for arguments below `SERIES`: 0.25^24 is far below the rounding of a double."""

STEP = 0.04
"""Step of the double-exponential quadrature, at which it has converged to rounding for all h and r allowed."""


class Law(Struct, frozen=True, eq=False):
    """The contact law of exponent h and restitution r, in dimensionless numbers.

    Attributes
    ----------
    damping : float
        D = lambda v: the damping coefficient lambda [s/m] times the impact velocity.
    duration : float
        tau: time between touch and departure over (m/K)^(1/(h+1)) v^(-(h-1)/(h+1)).
    depth_ratio : float
        Largest deflection over that of (5.5), which has no damping: at most 1.
    """

    damping: float
    duration: float
    depth_ratio: float


class Contact(Struct, frozen=True, eq=False):
    """Contacts at several impact velocities, arrays of one shape in the units of the arguments.

    Attributes
    ----------
    duration : ndarray
        Time between touch and departure [s].
    deflection : ndarray
        Largest deflection with the damping that gives r [m].
    elastic_deflection : ndarray
        Largest deflection without damping, Eq. (5.5) [m].
    damping : ndarray
        lambda [s/m].
    """

    duration: Floats
    deflection: Floats
    elastic_deflection: Floats
    damping: Floats


def contacts(speed: Floats, membrane: Membrane, restitution: float) -> Contact:
    """Evaluate contacts at given impact velocities; zero is taken as `SLOWEST`.

    Parameters
    ----------
    speed : ndarray
        Relative velocity at the impact, of either sign [m/s].
    membrane : Membrane
    restitution : float
        r, between `SMALLEST_RESTITUTION` and 1.

    Raises
    ------
    NumericalError
        If r is outside that range.
    """
    law = law_of(membrane.exponent, restitution)
    v, power = np.maximum(np.abs(speed), SLOWEST), membrane.exponent + 1
    # In logarithms: (m/K)^(1/(h+1)) over- or underflows for no membrane, but K times a ladder's factors may.
    inertia = (np.log(membrane.reduced_mass_kg) - np.log(membrane.stiffness)) / power
    duration = law.duration * np.exp(inertia - (power - 2) / power * np.log(v))
    elastic = np.exp(inertia + (np.log(power / 2) + 2 * np.log(v)) / power)
    return Contact(duration, law.depth_ratio * elastic, elastic, law.damping / v)


@lru_cache(maxsize=64)
def law_of(exponent: float, restitution: float) -> Law:
    """The contact law for an exponent h > 0 and a restitution coefficient r.

    Raises
    ------
    NumericalError
        If r is not between `SMALLEST_RESTITUTION` and 1, or h is not positive.
    """
    h, r = exponent, restitution
    if not SMALLEST_RESTITUTION <= r <= 1:
        raise NumericalError(
            f"restitution {r!r}: a contact with Hunt-Crossley damping has one between {SMALLEST_RESTITUTION:g} and 1; "
            "towards 0 the damping grows as 1/r and the ball leaves the membrane ever more slowly"
        )
    if not 0 < h < inf:
        raise NumericalError(f"exponent {h!r} of the membrane's force: it must be positive")
    damping, w = _damping(r)
    top = log1p(damping) / damping if damping else 1.0
    bottom = w / damping if damping else 1.0
    nodes, weights = _rule(h)
    # The integrand is singular at touch and departure, where g vanishes. It is integrated from both towards the deepest
    # point, over the distance y from the end in s/D: so g keeps its digits, and the double-exponential rule converges.
    # Time is an integral of 1/delta^h, and delta^h is g^(h/(h+1)) but for constants, see the head of the module.
    fall = -h / (h + 1)
    approach = weights * top * (top * nodes * _loading(damping, top * nodes)) ** fall
    retreat = weights * bottom * (bottom * nodes * _unloading(damping, r, w, bottom * nodes)) ** fall
    scale = (h + 1) ** fall
    duration = float(scale * approach.sum()) + float(scale * retreat.sum())
    return Law(damping, duration, depth_ratio=(2 * _stored(damping)) ** (1 / (h + 1)))


def damping_number(restitution: float) -> float:
    """D = lambda v that gives a restitution coefficient, the root of ln((1+D)/(1-rD)) = (1+r) D.

    It is the same for every exponent. D -> 3(1-r)/2 as r -> 1, and D -> 1/r as r -> 0.

    Raises
    ------
    NumericalError
        If r is not between `SMALLEST_RESTITUTION` and 1.
    """
    return law_of(1.0, restitution).damping


def _damping(r: float) -> tuple[float, float]:
    """Solve for D = lambda v; return D and w = -ln(1 - r D), which keeps the digits of a small 1 - r D.

    With L(x) = [x - ln(1+x)]/x^2 the condition reads L(D) = r^2 L(-r D), whose difference rises with D from
    -(1-r^2)/2 to infinity at D = 1/r: one root, in 0 < w < (1+r)/r.
    """
    if r == 1:
        return 0.0, 0.0

    # ln((1+d)/(1-rd)) - (1+r)d in powers of d, over d^2: its first terms cancel, and leave no digits for small d.
    k = np.arange(3, TERMS + 3)
    rising = (r**k - (-1.0) ** k) / k

    def excess(w: float) -> float:
        d = -expm1(-w) / r
        if d < SERIES:
            return float(np.sum(rising * d ** (k - 2.0))) - (1 - r) * (1 + r) / 2
        return log1p(d) + w - (1 + r) * d

    # Bisection to the last bit: it runs once for each r, so that its speed does not matter.
    low, high = 0.0, (1 + r) / r
    for _ in range(200):
        middle = (low + high) / 2
        if middle in (low, high):
            break
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    return -expm1(-high) / r, high


def _loading(d: float, y: Floats) -> Floats:
    """g/y during loading, at y = [ln(1+D) - s]/D after the touch."""
    z = -d * y
    return np.asarray(_first(z) - y * _second(z))


def _unloading(d: float, r: float, w: float, y: Floats) -> Floats:
    """g/y during unloading, at y = (s + w)/D before the departure; e^-w = 1 - r D."""
    z = d * y
    small = z < SERIES
    rest = y * exp(-w) * _second(np.where(small, z, 0.0))
    z = np.where(small, 1.0, z)
    far = (np.exp(z - w) - exp(-w) * (1 + z)) / z / max(d, SERIES)
    # Where z is not small, D is not: z is at most w, which is about D for small D.
    return np.asarray(r - np.where(small, rest, far))


def _first(z: Floats) -> Floats:
    """(e^z - 1)/z, with its limit 1 at z = 0."""
    safe = np.where(z == 0, 1.0, z)
    return np.where(z == 0, 1.0, np.expm1(safe) / safe)


def _second(z: Floats) -> Floats:
    """(e^z - 1 - z)/z^2, by its series for small z."""
    small = np.abs(z) < SERIES
    series = np.polyval([1 / factorial(k + 2) for k in range(TERMS // 2, -1, -1)], np.where(small, z, 0.0))
    safe = np.where(small, 1.0, z)
    return np.where(small, series, (np.expm1(safe) - safe) / safe**2)


def _stored(d: float) -> float:
    """Energy in the membrane at the largest deflection over m v^2, [D - ln(1+D)]/D^2; 1/2 without damping."""
    if d < SERIES:
        return float(sum((-d) ** k / (k + 2) for k in range(TERMS)))
    return (d - log1p(d)) / d**2


def _rule(h: float) -> tuple[Floats, Floats]:
    """Nodes in (0, 1) and weights of the double-exponential rule, for integrands like x^(-h/(h+1)) next to 0."""
    reach = asinh(min(39 * (h + 1), 690.0) / pi)
    t = np.arange(-reach, reach + STEP, STEP)
    # Beyond 690 the exponential overflows; nodes there are 1 to the last bit.
    up = np.exp(np.minimum(pi * np.sinh(t), 690.0))
    nodes = up / (1 + up)
    return nodes, STEP * pi * np.cosh(t) * nodes / (1 + up)
