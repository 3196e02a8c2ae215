"""The force that drives the capsule by its phase: a sine, and harmonics of it.

F [cos x + sum_j (A_j cos jx + B_j sin jx)] with x = omega t + phi. A flight needs the force itself and what it has done
up to a phase: its integral, which is a velocity, and the integral of that, a distance. Of a sine they are cos x, sin x
and, but for its sign, cos x again; harmonics add to each.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import atan2, cos, degrees, hypot, isnan, pi, sin
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.physics.numbers import DecimalOps

NEAR_CIRCLE = 1e-3
"""Distance from the unit circle of a root that counts as a phase. Too many phases do no harm where they only part a
flight into pieces; two roots that rounding moves off the circle together are where a force touches zero."""


NO_HARMONIC = 1e-10
"""Size of a harmonic, over that of the largest, below which it moves no phase that is looked for."""


class Harmonic(Struct, frozen=True):
    """What a harmonic adds to the force cos x: `cosine` cos(order x) + `sine` sin(order x), x the forcing phase.

    The two are shares of the force's amplitude, numbers of any kind or arrays. Where they were made of a size [%] and a
    phase [deg], these are `given`: in other kinds of number the parts are made of them anew.
    """

    order: int
    cosine: Any
    sine: Any
    given: tuple[float, float] | None = None

    @staticmethod
    def of(order: int, percent: float, phase_deg: float) -> Harmonic:
        """The harmonic percent/100 cos(order x + phase), its parts in doubles; a quarter of a turn is exact."""
        share, quarters = percent / 100, round(phase_deg / 90)
        rest = (phase_deg - 90 * quarters) * pi / 180
        c, s = ((cos(rest), sin(rest)), (-sin(rest), cos(rest)), (-cos(rest), -sin(rest)), (sin(rest), -cos(rest)))[
            quarters % 4
        ]
        return Harmonic(order, share * c, -share * s, (percent, phase_deg))

    def exact(self, ops: Any) -> Harmonic:
        """The harmonic in a kind of number; in decimals its parts have all digits of what is given."""
        if self.given is None or not isinstance(ops, DecimalOps):
            return self.map_numbers(ops.exact)
        percent, phase = map(ops.exact, self.given)
        share = percent / 100
        return Harmonic(self.order, share * ops.sin_degrees(phase + 90), -share * ops.sin_degrees(phase))

    def map_numbers(self, function: Callable[[Any], Any]) -> Harmonic:
        """What a function makes of both parts."""
        return Harmonic(self.order, function(self.cosine), function(self.sine))

    @property
    def share(self) -> float:
        """Its amplitude over that of the sine."""
        return hypot(self.cosine, self.sine)

    @property
    def phase_deg(self) -> float:
        """Its phase in share cos(order x + phase), from 0 to 360."""
        return degrees(atan2(-self.sine, self.cosine)) % 360


SINE = Harmonic(1, 1.0, 0.0)
"""The force that a harmonic is one of: cos x."""


def with_harmonic(harmonics: Sequence[Harmonic], more: Harmonic) -> tuple[Harmonic, ...]:
    """The harmonics of a force to which one is added; of those of one order the parts are added."""
    same = [harmonic for harmonic in harmonics if harmonic.order == more.order]
    both = [Harmonic(more.order, harmonic.cosine + more.cosine, harmonic.sine + more.sine) for harmonic in same] or [
        more
    ]
    return *(harmonic for harmonic in harmonics if harmonic.order != more.order), *both


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
    for harmonic in harmonics:
        s, c = _multiple(sine, cosine, harmonic.order)
        force_of_it = harmonic.cosine * c + harmonic.sine * s
        force = force + force_of_it
        impulse = impulse + (harmonic.cosine * s - harmonic.sine * c) / harmonic.order
        path = path + force_of_it / harmonic.order**2
    return Wave(force, impulse, path)


def force_rate(sine: Any, cosine: Any, harmonics: Sequence[Harmonic] = ()) -> Any:
    """Derivative of the force by the phase, at the phase with a sine and a cosine."""
    rate = -sine
    for harmonic in harmonics:
        s, c = _multiple(sine, cosine, harmonic.order)
        rate = rate + harmonic.order * (harmonic.sine * c - harmonic.cosine * s)
    return rate


def _multiple(sine: Any, cosine: Any, order: int) -> tuple[Any, Any]:
    """Sine and cosine of a multiple of an angle."""
    s, c = sine, cosine
    for _ in range(order - 1):
        s, c = s * cosine + c * sine, c * cosine - s * sine
    return s, c


@lru_cache(64)  # where length or frequency varies, it is asked for the same force at each motion
def unaccelerated(gbar: float, harmonics: tuple[Harmonic, ...]) -> tuple[float, ...]:
    """The phases at which gbar and the force cancel, ascending [rad], at most 2H and perhaps some beside them."""
    return tuple(_zeros(gbar, (SINE, *harmonics)))


def unaccelerated_by(gbar: NDArray[np.float64], harmonics: Sequence[Harmonic]) -> NDArray[np.float64]:
    """Those phases of each gbar, a row for each; NaN where there are fewer than in others."""
    return _cancelled(gbar, (SINE, *harmonics))


def _zeros(constant: float, parts: Sequence[Harmonic]) -> list[float]:
    """The phases at which a constant and a trigonometric polynomial cancel, see `unaccelerated`."""
    return [phase for phase in _cancelled(np.array([constant]), parts)[0].tolist() if not isnan(phase)]


def _cancelled(constant: NDArray[np.float64], parts: Sequence[Harmonic]) -> NDArray[np.float64]:
    """The phases at which a trigonometric polynomial cancels each of some constants, a row for each.

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
    roots = np.linalg.eigvals(companion)
    phases = np.arctan2(roots.imag, roots.real) % (2 * pi)
    return np.sort(np.where(np.abs(np.abs(roots) - 1) < NEAR_CIRCLE, phases, np.nan), axis=1)


class Peaks(NamedTuple):
    """The largest sizes of a force and of what it has done, over those of a sine of its amplitude.

    Attributes
    ----------
    force : float
        Of the force itself.
    impulse : float
        Of its integral over the phase.
    path : float
        Half the distance between the ends of the integral of that.
    lift : float
        Of the force against gravity: gbar from which a ball never leaves the bottom.
    """

    force: float
    impulse: float
    path: float
    lift: float


def peaks(harmonics: Sequence[Harmonic]) -> Peaks:
    """The largest sizes of a force with harmonics; 1 of a sine."""
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
