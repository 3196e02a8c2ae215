"""Distortion of the force that a design withstands: the least harmonic, at its worst phase, that ends stable motion.

A harmonic p cos(order x + psi) of the force cos x is a vector of length p in the plane of its cosine and sine. Stable
motion is followed from the origin of that plane along rays; where it ends is a border in the plane, nearly straight
where p is small. At the nearest point of a border its normal points away from the origin: rays are turned along
normals until they reach it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, copysign, cos, degrees, hypot, pi, sin
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.design.lines import (
    Followed,
    Line,
    LineCurve,
    continued,
    ends_on_curve,
    mirrored,
    model_on_line,
    stable_ones,
)
from vireport.design.margins import HARMONICS, Margin, end_motion, normal_of, resting, solved_end
from vireport.motions.events import Event
from vireport.motions.one_to_one import Motions
from vireport.motions.paths import Curve
from vireport.motions.polish import in_decimals
from vireport.motions.switching import touching
from vireport.motions.turning import turns
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.forcing import with_harmonic as added
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import FLOATS, DecimalOps, DoubleOps
from vireport.scenario.blocks import LARGEST_HARMONIC
from vireport.scenario.parameters import Parameter

Floats = NDArray[np.float64]

ORDERS = tuple(harmonic.order for harmonic in HARMONICS)
"""Orders of the harmonics that are tried."""

LARGEST = LARGEST_HARMONIC / 100
"""Amplitude of a harmonic, as a share of the force, up to which rays are followed."""

RAYS, BEYOND = 6, 1.25
"""Number of rays all round, and the length to which they are followed over the least share found before: a straight
border is crossed by one of them before 1/cos(30 degrees) = 1.155 times its distance."""

SEARCHED = LARGEST / BEYOND
"""Share of the force up to which no end is overlooked where no ray has come to one."""

SAME_WAY = 0.05
"""Angle [rad] between the nearest points of two borders below which they are one border, of which the nearer point
counts."""

TURNED = 1e-5
"""Angle [rad] between a ray and the normal of the border at its end below which the end is the nearest point: its
distance is then wrong by about the square."""

STILL = -0.1
"""Derivative of the angle from ray to normal by the phase of the ray, above which secants diverge at a bent border."""


class Distortion(Struct, frozen=True):
    """The least harmonic of one order that ends stable motion, added to those of the force.

    Attributes
    ----------
    order : int
    share : float or None
        Its amplitude over that of the force, at the worst phase; None where none up to `SEARCHED` ends stable motion.
    phase_deg : float
        The worst phase [deg], in F [cos x + share cos(order x + phase)], x = omega t + phi.
    event : Event or None
        The event at which stable motion ends.
    error_bound : float or None
        Bound of the error of the share, with the error of the phase; None where it was located in doubles only.
    searched_to : float
        Share up to which rays all round would have come to an end.
    """

    order: int
    share: float | None
    phase_deg: float
    event: Event | None
    error_bound: float | None
    searched_to: float = SEARCHED


class Ray(Struct, frozen=True, eq=False):
    """A device whose force has a harmonic of growing amplitude and fixed phase: a `Variation` of its groups.

    Attributes
    ----------
    origin : Groups
        Groups of the device.
    order : int
    cosine, sine : object
        Coefficients of the harmonic at a share of 1, in a kind of number.
    """

    origin: Groups[Any]
    order: int
    cosine: Any
    sine: Any

    @staticmethod
    def of(device: Device, order: int, phase: float, ops: DoubleOps | DecimalOps) -> Ray:
        """The ray of one phase, in a kind of number; the phase is that of the nearest double."""
        origin = model_on_line(Line.LENGTHS, device, ops).origin
        return Ray(origin, order, ops.exact(cos(phase)), -ops.exact(sin(phase)))

    @property
    def horizontal(self) -> bool:
        """Whether motions have mirror images."""
        return self.at((1.0,)).horizontal

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """Groups of the device with a share of the harmonic."""
        (share,) = varied
        grown = Harmonic(self.order, share * self.cosine, share * self.sine)
        # It is the last of the harmonics, whether or not the force has this order already.
        return self.origin._replace(harmonics=added(self.origin.harmonics, grown))

    def slopes(self, varied: Sequence[Any]) -> Floats:
        """The derivatives of `Groups.numbers` by the share, shape (6, 1) where the force was a sine."""
        grown = self.at((0.0,))
        before = 4 + 2 * len(grown.harmonics) - 2
        after = len(grown.numbers) - before - 2
        return np.array([*[[0.0]] * before, [self.cosine], [self.sine], *[[0.0]] * after])


class _End(Struct, frozen=True, eq=False):
    """The end of a stable motion on a ray of growing harmonics.

    Attributes
    ----------
    border : _Border
    phase : float
        Phase of the ray [rad].
    event : Event
    x : ndarray
        Velocities [y_c] and times [t_c] of the impacts, and the share.
    symmetric : bool
        Whether the motion there is symmetric.
    turn : float
        The angle from the ray to the normal of the border [rad]; 0 where it has none.
    """

    border: _Border
    phase: float
    event: Event
    x: Floats
    symmetric: bool
    turn: float

    @property
    def share(self) -> float:
        """Share of the harmonic in the force, at the end."""
        return float(self.x[-1])


def distortions(device: Device, motions: Motions, nearest: Margin | None = None) -> tuple[Distortion, ...]:
    """The least harmonic of each of `ORDERS` that ends a stable motion of a design point.

    Parameters
    ----------
    device : Device
        With all inputs.
    motions : Motions
        At the design point.
    nearest : Margin, optional
        Margin to an end of stable motion: the harmonic that brings this end to the design point is tried first.
    """
    flat = mirrored(device)
    followed = [candidate for candidate in stable_ones(device, motions) if not flat or candidate.u >= 0]
    return tuple(
        _least(order, [_Border(device, motion, flat and u == 0, order) for motion, u in followed], nearest)
        for order in ORDERS
        if followed
    )


def with_harmonic(device: Device, stable: Sequence[Followed], harmonic: Harmonic) -> list[Followed]:
    """Continue the stable motions of a device while a harmonic of its force grows, and keep those that stay stable.

    Parameters
    ----------
    device : Device
        With all inputs.
    stable : sequence of Followed
        Stable motions of the device.
    harmonic : Harmonic
        The harmonic that is added to the force.
    """
    share, phase = hypot(harmonic.cosine, harmonic.sine), atan2(-harmonic.sine, harmonic.cosine)
    flat = mirrored(replace(device, harmonics=added(device.harmonics, harmonic)))
    ray = Ray.of(device, harmonic.order, phase, FLOATS)
    return continued(ray, (-LARGEST, share), stable, device.period_ratio, flat)


class Rubbed(Struct, frozen=True, eq=False):
    """A device whose friction varies, a `Variation` of its groups by the change of friction.

    Attributes
    ----------
    origin : Groups
        Groups of the device, with its friction.
    sense : float
        1 where friction grows, -1 where it falls.
    """

    origin: Groups[float]
    sense: float

    @property
    def horizontal(self) -> bool:
        """Whether motions have mirror images."""
        return self.origin.horizontal

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """The groups where friction has changed by the only entry of `varied`."""
        return self.origin._replace(friction=self.origin.friction + varied[0] * self.sense)

    def slopes(self, varied: Sequence[Any]) -> Floats:
        """The derivatives of `Groups.numbers`, of which friction is the last."""
        others = len(self.origin.numbers) - 1
        return np.array([*[[0.0]] * others, [self.sense]])


def with_friction(device: Device, stable: Sequence[Followed], friction: float) -> list[Followed]:
    """Continue the stable motions of a device to another coefficient of friction, and keep those that stay stable.

    Parameters
    ----------
    device : Device
        With all inputs.
    stable : sequence of Followed
        Stable motions of the device.
    friction : float
        The other coefficient.
    """
    plain, rubbing = (
        case.groups(Parameter.LENGTH, case.length_m).as_floats()
        for case in (device, replace(device, friction=friction))
    )
    origin = plain if plain.friction is not None else plain._replace(friction=0.0)
    change = rubbing.friction - origin.friction
    model = Rubbed(origin, copysign(1.0, change))

    def moves_on(motion: Motion) -> bool:
        """Whether the ball does not stop in flight with vanishing friction."""
        curve = Curve(motion.word, model, -1.0, 1.0, 1.0)
        return min(curve.margins(curve.vector(replace(motion, coordinate=0.0)))) > 0

    moving = [stable_motion for stable_motion in stable if moves_on(stable_motion.motion)]
    return continued(model, (-1.0, abs(change)), moving, device.period_ratio, mirrored(device))


def _least(order: int, borders: list[_Border], nearest: Margin | None) -> Distortion:
    """The end of stable motion that needs the least distortion, over all stable motions."""
    way = _towards(nearest, order)
    best: _End | None = None
    for border in borders:
        best = border.nearest(way, best)
    if best is None:
        return Distortion(order, None, 0.0, None, None)
    share, error_bound = best.border.solved(best)
    kind = Event.GRAZING if best.event is Event.ZERO_VELOCITY else best.event
    return Distortion(order, share, degrees(best.phase) % 360, kind, error_bound)


def _towards(margin: Margin | None, order: int) -> float:
    """Phase [rad] at which a harmonic brings an end of stable motion nearest to the design point, to first order."""
    if margin is None or (slopes := margin.by_harmonics.get(order)) is None:
        return 0.0
    cosine, sine = (-slope * margin.distance for slope in slopes)
    return atan2(-sine, cosine)


class _Border(Struct, frozen=True, eq=False):
    """The curve on which a stable motion of a device ends, in the plane of cosine and sine of a harmonic."""

    device: Device
    motion: Motion
    symmetric: bool
    order: int

    def nearest(self, towards: float, best: _End | None) -> _End | None:
        """The nearest of the ends on this border, along rays all round from a phase [rad], and of the `best` so far."""
        # An even harmonic and its opposite are mirror images, and so are the motions, whose distances are the same.
        for k in range(RAYS // 2 if mirrored(self.device) and self.order % 2 == 0 else RAYS):
            way = towards + 2 * pi * k / RAYS
            end = self.end(way, min(BEYOND * best.share, LARGEST) if best is not None else LARGEST)
            if end is not None and not _is_farther(end, best):
                end = self.turned(end)
                best = end if best is None or end.share < best.share else best
        return best

    def turned(self, end: _End) -> _End:
        """The nearest point of a border, from one of its points by secants of the angle from ray to normal."""
        step = end.turn
        while abs(step) > TURNED:
            onward = self.end(end.phase + step, end.share)
            if onward is None or onward.share == end.share:
                step /= 2  # too far: a border that is bent comes nearer before it goes off
                continue
            turned = (onward.turn - end.turn) / step
            step = -onward.turn / turned if turned < STILL else onward.turn
            end = onward
        return end

    def end(self, way: float, limit: float) -> _End | None:
        """The end of stable motion on the ray of a phase [rad], up to a share of the force; None without one."""
        curve = LineCurve(self.motion.word, self._ray(way, FLOATS), -LARGEST, limit, 1.0)
        for event, x, symmetric, taken_over in ends_on_curve(
            curve, self.motion, 1.0, self.symmetric and self.order % 2 == 1
        ):
            if event not in (Event.SWEEP_END, Event.LOST) and not taken_over:
                return _End(self, way, event, x, symmetric, self._turn(way, event, x, symmetric))
        return None

    def _ray(self, way: float, ops: DoubleOps | DecimalOps) -> Ray:
        """The ray of a phase [rad], in a kind of number."""
        return Ray.of(self.device, self.order, way, ops)

    def _turn(self, way: float, event: Event, x: Floats, symmetric: bool) -> float:
        """Angle [rad] from a ray to the normal of the border at the end of the ray; 0 where there is no normal."""
        motion, groups = end_motion(self.device.period_ratio, x), self._ray(way, FLOATS).at(x[-1:].tolist())
        rests = resting(event, x, symmetric)
        if event is Event.GRAZING:
            motion = touching(motion, turns(motion, groups))
            rests = motion.rests
        grown = len(groups.harmonics) - 1
        cosine, sine = normal_of(motion, groups, event, rests, ())[4 + 2 * grown : 6 + 2 * grown]
        # Of a harmonic p cos(jx + psi) cosine and sine are p cos(psi) and -p sin(psi). The normal may point to either
        # side: its angle to the ray is the smaller one.
        return (atan2(-sine, cosine) - way + pi / 2) % pi - pi / 2 if np.isfinite([cosine, sine]).all() else 0.0

    def solved(self, end: _End) -> tuple[float, float | None]:
        """Share of the force at an end, in decimals, and its error bound; in doubles and None where that fails."""
        # Only here: on the way to the nearest end doubles do, and decimals took two thirds of the time.
        with in_decimals():
            try:
                solved, *_ = solved_end(
                    lambda ops: self._ray(end.phase, ops),
                    self.device.period_ratio,
                    end.event,
                    end.x,
                    end.symmetric,
                )
            except (NumericalError, ArithmeticError):
                return end.share, None
            share = float(solved.x[-1])
        # The nearest point of a straight border is nearer by the factor cos(turn), which is at least 1 - turn^2/2.
        return share, float(np.spacing(share)) + share * end.turn * end.turn


def _is_farther(end: _End, best: _End | None) -> bool:
    """Whether an end need not be refined: farther than the best end, on the same border or on one that is farther."""
    if best is None or end.share <= best.share:
        return False
    apart = abs((end.phase + end.turn - best.phase + pi) % (2 * pi) - pi)
    return apart < SAME_WAY or end.share * cos(end.turn) > best.share
