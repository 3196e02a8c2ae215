"""The force that drives the capsule by its phase: a sine, and harmonics of it.

F [cos x + sum_j (A_j cos jx + B_j sin jx)] with x = omega t + phi. A flight needs the force itself and what it has done
up to a phase: its integral, which is a velocity, and the integral of that, a distance. Of a sine they are cos x, sin x
and, but for its sign, cos x again; harmonics add to each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

NEAR_CIRCLE = 1e-3
"""Distance from the unit circle of a root that counts as a phase. Too many phases do no harm where they only part a
flight into pieces; two roots that rounding moves off the circle together are where a force touches zero."""


@dataclass(frozen=True, slots=True)
class Harmonic:
    """What a harmonic adds to the force cos x: `cosine` cos(order x) + `sine` sin(order x), x the forcing phase.

    The two are shares of the force's amplitude, numbers of any kind or arrays.
    """

    order: int
    cosine: Any
    sine: Any


class Wave(NamedTuple):
    """The force at one phase, over its amplitude.

    Attributes
    ----------
    force : array_like
        cos x, and what harmonics add.
    impulse : array_like
        Its integral over the phase, sin x for a sine.
    path : array_like
        Less the integral of that, cos x for a sine.
    """

    force: Any
    impulse: Any
    path: Any


def wave(sine: Any, cosine: Any, harmonics: Sequence[Harmonic] = ()) -> Wave:
    """The force at the phase with a sine and a cosine, numbers of any kind."""
    if not harmonics:
        return Wave(cosine, sine, cosine)
    force, impulse, path = cosine, sine, cosine
    for each in harmonics:
        s, c = _multiple(sine, cosine, each.order)
        here = each.cosine * c + each.sine * s
        force = force + here
        impulse = impulse + (each.cosine * s - each.sine * c) / each.order
        path = path + here / each.order**2
    return Wave(force, impulse, path)


def force_rate(sine: Any, cosine: Any, harmonics: Sequence[Harmonic] = ()) -> Any:
    """Derivative of the force by the phase, at the phase with a sine and a cosine."""
    rate = -sine
    for each in harmonics:
        s, c = _multiple(sine, cosine, each.order)
        rate = rate + each.order * (each.sine * c - each.cosine * s)
    return rate


def _multiple(sine: Any, cosine: Any, order: int) -> tuple[Any, Any]:
    """Sine and cosine of a multiple of an angle."""
    s, c = sine, cosine
    for _ in range(order - 1):
        s, c = s * cosine + c * sine, c * cosine - s * sine
    return s, c


def unaccelerated(gbar: float, harmonics: Sequence[Harmonic]) -> list[float]:
    """The phases at which gbar and the force cancel, ascending within one period [rad], and perhaps some beside them.

    Notes
    -----
    With z = e^(ix) the sum is z^-H times a polynomial of degree 2H in z, H the highest order: at most 2H phases.
    """
    highest = max(each.order for each in harmonics)
    polynomial = np.zeros(2 * highest + 1, dtype=complex)
    polynomial[highest] = gbar
    for each in (Harmonic(1, 1.0, 0.0), *harmonics):
        polynomial[highest - each.order] += (each.cosine - 1j * each.sine) / 2
        polynomial[highest + each.order] += (each.cosine + 1j * each.sine) / 2
    roots = np.roots(polynomial)
    on_circle = roots[np.abs(np.abs(roots) - 1) < NEAR_CIRCLE]
    return sorted(np.mod(np.angle(on_circle), 2 * np.pi).tolist())
