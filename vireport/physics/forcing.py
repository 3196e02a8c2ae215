"""The force that drives the capsule, a sine and its harmonics, as a function of the forcing phase.

F [cos x + sum_j (A_j cos jx + B_j sin jx)] with x = omega t + phi. A flight needs the force itself, its integral over
the phase, which is a velocity, and the integral of that, a distance. For a sine they are cos x, sin x and, but for its
sign, cos x again; harmonics add to all three (`Wave`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import atan2, cos, degrees, hypot, isnan, pi, sin
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.physics.numbers import Arithmetic, DecimalOps, ExactFunctions

NEAR_CIRCLE = 1e-3
"""Distance from the unit circle up to which a root counts as a phase. Too many phases do no harm, as they only divide
flights into more pieces; where a force touches zero, rounding moves two roots off the circle together."""

NO_HARMONIC = 1e-10
"""Size of a harmonic, over that of the largest, below which its effect on phases of zero force is neglected."""


class Harmonic(Struct, frozen=True):
    """A harmonic of the force, `cosine` cos(order x) + `sine` sin(order x), x the forcing phase.

    Attributes
    ----------
    order : int
    cosine, sine : array_like
        Coefficients over the amplitude of the force, in any kind of number.
    stated : (float, float) or None
        Size [%] and phase [deg] from which they were computed: in decimals they are computed anew.
    """

    order: int
    cosine: Any
    sine: Any
    stated: tuple[float, float] | None = None

    @staticmethod
    def of(order: int, percent: float, phase_deg: float) -> Harmonic:
        """The harmonic percent/100 cos(order x + phase), in doubles; a phase of quarter turns is exact."""
        share, quarters = percent / 100, round(phase_deg / 90)
        rest = (phase_deg - 90 * quarters) * pi / 180
        # By quarter turns apart: pi/2 is no double, and cos(90 deg) would be 6e-17.
        c, s = ((cos(rest), sin(rest)), (-sin(rest), cos(rest)), (-cos(rest), -sin(rest)), (sin(rest), -cos(rest)))[
            quarters % 4
        ]
        return Harmonic(order, share * c, -share * s, (percent, phase_deg))

    def exact(self, ops: ExactFunctions) -> Harmonic:
        """The harmonic in a kind of number; in decimals with all digits of the size and phase stated."""
        if self.stated is None or not isinstance(ops, DecimalOps):
            return self.map_numbers(ops.exact)
        percent, phase = map(ops.exact, self.stated)
        share = percent / 100
        return Harmonic(self.order, share * ops.sin_degrees(phase + 90), -share * ops.sin_degrees(phase))

    def map_numbers(self, function: Callable[[Any], Any]) -> Harmonic:
        """Apply a function to both coefficients."""
        return Harmonic(self.order, function(self.cosine), function(self.sine))

    @property
    def share(self) -> float:
        """Amplitude of the harmonic over that of the sine [-]."""
        return hypot(self.cosine, self.sine)

    @property
    def phase_deg(self) -> float:
        """Phase of the harmonic in `share` cos(order x + phase) [deg], from 0 to 360."""
        return degrees(atan2(-self.sine, self.cosine)) % 360


SINE = Harmonic(1, 1.0, 0.0)
"""The force without harmonics, cos x, as if it were a harmonic of order 1."""


def with_harmonic(harmonics: Sequence[Harmonic], more: Harmonic) -> tuple[Harmonic, ...]:
    """The harmonics of a force and one more; coefficients of the same order are added."""
    others = tuple(harmonic for harmonic in harmonics if harmonic.order != more.order)
    same = tuple(harmonic for harmonic in harmonics if harmonic.order == more.order)
    if not same:
        return *others, more
    return *others, *(Harmonic(more.order, part.cosine + more.cosine, part.sine + more.sine) for part in same)


class Wave(NamedTuple):
    """The force at one phase and its two integrals over the phase, over the amplitude of the force.

    Attributes
    ----------
    force : array_like
        cos x, and what harmonics add.
    impulse : array_like
        Its integral over the phase, sin x for a sine.
    path : array_like
        Minus the integral of the impulse, cos x for a sine.
    """

    force: Any
    impulse: Any
    path: Any


def wave(sine: Arithmetic, cosine: Arithmetic, harmonics: Sequence[Harmonic] = ()) -> Wave:
    """The force at a phase, from sine and cosine of the phase, numbers of any kind."""
    if not harmonics:
        return Wave(cosine, sine, cosine)
    force, impulse, path = cosine, sine, cosine
    for harmonic in harmonics:
        s, c = _multiple(sine, cosine, harmonic.order)
        force_of_it = harmonic.cosine * c + harmonic.sine * s
        force = force + force_of_it
        impulse = impulse + (harmonic.cosine * s - harmonic.sine * c) / harmonic.order
        path = path + force_of_it / harmonic.order**2
    return Wave(force, impulse, path)


def force_rate(sine: Arithmetic, cosine: Arithmetic, harmonics: Sequence[Harmonic] = ()) -> Any:
    """Derivative of the force by the phase, from sine and cosine of the phase."""
    rate = -sine
    for harmonic in harmonics:
        s, c = _multiple(sine, cosine, harmonic.order)
        rate = rate + harmonic.order * (harmonic.sine * c - harmonic.cosine * s)
    return rate


def _multiple(sine: Arithmetic, cosine: Arithmetic, order: int) -> tuple[Any, Any]:
    """Sine and cosine of `order` times an angle, from those of the angle."""
    # By the addition theorem, not by functions of the multiple angle: the caller has sine and cosine already, and in
    # this form decimals and numbers that carry errors need no further functions.
    s, c = sine, cosine
    for _ in range(order - 1):
        s, c = s * cosine + c * sine, c * cosine - s * sine
    return s, c


@lru_cache(64)  # where length or frequency varies, gbar is the same for all motions
def unaccelerated(gbar: float, harmonics: tuple[Harmonic, ...]) -> tuple[float, ...]:
    """The phases at which gbar and the force cancel, so that Z'' = 0, ascending [rad].

    At most 2H, H the highest order; a phase at which they nearly cancel may be among them.
    """
    return tuple(_zeros(gbar, (SINE, *harmonics)))


def unaccelerated_by(gbar: NDArray[np.float64], harmonics: Sequence[Harmonic]) -> NDArray[np.float64]:
    """The phases of `unaccelerated` for arrays of gbar, a row for each; NaN in rows that have fewer than others."""
    return _cancelled(gbar, (SINE, *harmonics))


def _zeros(constant: float, parts: Sequence[Harmonic]) -> list[float]:
    """The phases at which a constant and a trigonometric polynomial cancel, see `unaccelerated`."""
    return [phase for phase in _cancelled(np.array([constant]), parts)[0].tolist() if not isnan(phase)]


def _cancelled(constant: NDArray[np.float64], parts: Sequence[Harmonic]) -> NDArray[np.float64]:
    """The phases at which constants and a trigonometric polynomial cancel, a row for each constant, NaN for none.

    Notes
    -----
    With z = e^(ix) the sum is z^-H times a polynomial of degree 2H in z, H the highest order: at most 2H phases.
    """
    # The companion matrix is divided by the coefficient of the highest order: of one that is next to nothing rounding
    # would leave no root on the circle, and phases at which turns are bracketed do not need it.
    least = NO_HARMONIC * max((part.share for part in parts), default=0.0)
    highest = max((part.order for part in parts if part.share > least), default=0)
    polynomial = np.zeros((len(constant), 2 * highest + 1), dtype=complex)
    polynomial[:, highest] = constant
    for part in parts:
        if part.order <= highest:
            polynomial[:, highest - part.order] += complex(part.cosine, -part.sine) / 2
            polynomial[:, highest + part.order] += complex(part.cosine, part.sine) / 2
    # Of numpy.roots, which builds this matrix too, the rest took longer than the eigenvalues.
    companion = np.zeros((len(constant), 2 * highest, 2 * highest), dtype=complex)
    companion[:] = np.eye(2 * highest, k=-1)
    companion[:, :1] = -polynomial[:, None, 1:] / polynomial[:, None, :1]
    # Roots on the unit circle are phases, the others come in pairs 1/conj(z) that are none.
    roots = np.linalg.eigvals(companion)
    phases = np.arctan2(roots.imag, roots.real) % (2 * pi)
    return np.sort(np.where(np.abs(np.abs(roots) - 1) < NEAR_CIRCLE, phases, np.nan), axis=1)


class Peaks(NamedTuple):
    """Largest values of a force and its integrals over a period, over those of a sine of its amplitude.

    Attributes
    ----------
    force : float
        Largest size of the force.
    impulse : float
        Largest size of its integral over the phase.
    path : float
        Half the range of the integral of the impulse.
    lift : float
        Largest force against gravity: where gbar is larger, a ball at rest never leaves the bottom.
    """

    force: float
    impulse: float
    path: float
    lift: float


def peaks(harmonics: Sequence[Harmonic]) -> Peaks:
    """Largest values of a force with harmonics and of its integrals; all 1 for a sine."""
    if not harmonics:
        return Peaks(1.0, 1.0, 1.0, 1.0)
    parts = (SINE, *harmonics)
    # Each is largest where the next is zero: the force where its rate is, the impulse where the force is, the path
    # where the impulse is.
    rate = [Harmonic(part.order, part.order * part.sine, -part.order * part.cosine) for part in parts]
    impulse = [Harmonic(part.order, -part.sine / part.order, part.cosine / part.order) for part in parts]
    force, pushed, gone = (
        [wave(sin(x), cos(x), harmonics) for x in _zeros(0.0, zeroed)] for zeroed in (rate, parts, impulse)
    )
    paths = [harmonic.path for harmonic in gone]
    return Peaks(
        force=max(abs(harmonic.force) for harmonic in force),
        impulse=max(abs(harmonic.impulse) for harmonic in pushed),
        path=(max(paths) - min(paths)) / 2,
        lift=max(-harmonic.force for harmonic in force),
    )
