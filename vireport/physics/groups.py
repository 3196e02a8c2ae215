"""The dimensionless groups of a device, on which flights and impacts depend, Eqs. (2.8)-(2.12).

`Groups` has d, gbar, the restitution (one number, `Restitutions` for two, `SpeedLaw` where it falls with speed), the
harmonics of the force, and friction. Together with n, the forcing periods per motion, they determine the dynamics.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from decimal import Decimal
from math import pi, prod
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from msgspec import Struct

from vireport.physics import flight
from vireport.physics.forcing import Harmonic, Wave, wave
from vireport.physics.numbers import Arithmetic, Functions

Number = TypeVar("Number")


class Restitutions(Struct, frozen=True):
    """The restitution coefficients of two membranes that are not alike, as numbers of any kind or arrays.

    Membranes that are alike have a single number instead: terms that vanish with the difference are then left out, for
    their time and for the rounding that they would add to every error bound.

    Attributes
    ----------
    bottom, top : array_like
        r of each membrane [-].
    slope : float
        -(dZ'+/dZ'-)/r: the whole number 1 for constant restitutions, 1 + exponent for restitutions that a `SpeedLaw`
        gives at impacts.
    """

    bottom: Any
    top: Any
    slope: Any = 1

    @property
    def slopes(self) -> tuple[Any, Any]:
        """-dZ'+/dZ'- at the bottom and at the top: for constant restitutions `bottom` and `top` themselves."""
        # Not as products with 1, which add a rounding to numbers that carry their error.
        if type(self.slope) is int:
            return self.bottom, self.top
        return self.slope * self.bottom, self.slope * self.top


Restitution = Arithmetic | Restitutions
"""The restitution coefficient of both membranes where they are alike, or one of each."""


class SpeedLaw(Struct, frozen=True):
    """Restitution coefficients that fall with the speed of the impact, `r (|Z'-|/speed)^exponent` for each membrane.

    It is no number: code for constant restitutions fails with it instead of taking them for constant.

    Attributes
    ----------
    bottom, top : array_like
        r of each membrane at `speed` [-].
    exponent : array_like
        -1 < exponent <= 0 [-].
    speed : array_like
        Speed at which `bottom` and `top` are stated: [m/s] in a device, [y_c] in groups.
    """

    bottom: Any
    top: Any
    exponent: Any
    speed: Any

    def map_numbers(self, function: Callable[[Any], Any]) -> SpeedLaw:
        """Apply a function to all four numbers."""
        return SpeedLaw(function(self.bottom), function(self.top), function(self.exponent), function(self.speed))

    def at(self, wall: int, velocity: Arithmetic) -> tuple[Any, Any]:
        """The restitution of an impact on a membrane with a velocity, and -dZ'+/dZ'-; see `restitution_at_speed`."""
        stated = self.bottom if wall > 0 else self.top
        return flight.restitution_at_speed(stated, wall * velocity / self.speed, self.exponent)


def stated(restitution: Restitution | SpeedLaw) -> tuple[Any, Any]:
    """The restitution at the bottom and at the top; for a law, at the speed at which it is stated."""
    return (restitution.bottom, restitution.top) if isinstance(restitution, SpeedLaw) else by_wall(restitution)


def by_wall(restitution: Restitution) -> tuple[Any, Any]:
    """The restitution at the bottom and at the top, from one number for both or from `Restitutions`.

    One number comes back twice as the same object, by which callers know that the membranes are alike.
    """
    if isinstance(restitution, Restitutions):
        return restitution.bottom, restitution.top
    return restitution, restitution


def map_restitution(restitution: Restitution | SpeedLaw, function: Callable[[Any], Any]) -> Any:
    """Apply a function to the numbers of a restitution: one, those of `Restitutions`, or those of a `SpeedLaw`."""
    if isinstance(restitution, Restitutions):
        return Restitutions(function(restitution.bottom), function(restitution.top), restitution.slope)
    if isinstance(restitution, SpeedLaw):
        return restitution.map_numbers(function)
    return function(restitution)


class Groups(NamedTuple, Generic[Number]):
    """The dimensionless groups of a device, as numbers of one kind or arrays.

    Attributes
    ----------
    d : array_like
        Distance between the membranes, s/x_c.
    gbar : array_like
        Gravity along the capsule over the forcing's acceleration, M g sin(beta)/F.
    restitution : array_like, Restitutions or SpeedLaw
        r of both membranes, or of each where they are not alike; or its law where it falls with speed.
    harmonics : tuple of Harmonic
        Harmonics of the force; empty for a sine.
    friction : array_like or None
        Of the ball on the capsule, mu_f M g cos(beta)/F, against the relative velocity; None without friction.
    """

    d: Number
    gbar: Number
    restitution: Any
    harmonics: tuple[Harmonic, ...] = ()
    friction: Any = None

    def as_floats(self) -> Groups[float]:
        """The groups as Python's numbers, in which one motion is evaluated ten times as fast as in NumPy's."""
        return self.map_numbers(float)

    def map_numbers(self, function: Callable[[Any], Any]) -> Groups[Any]:
        """Apply a function to all numbers."""
        harmonics = tuple(harmonic.map_numbers(function) for harmonic in self.harmonics)
        friction = None if self.friction is None else function(self.friction)
        return Groups(
            function(self.d), function(self.gbar), map_restitution(self.restitution, function), harmonics, friction
        )

    @property
    def numbers(self) -> tuple[Any, ...]:
        """d, gbar, the restitutions at bottom and top, cosine and sine of each harmonic, exponent and speed, friction.

        Exponent and speed are there for a `SpeedLaw` only, friction for a ball with friction only.
        `with_numbers` is the inverse.
        """
        parts = [part for harmonic in self.harmonics for part in (harmonic.cosine, harmonic.sine)]
        law = self.law
        more = () if law is None else (law.exponent, law.speed)
        rubbing = () if self.friction is None else (self.friction,)
        return self.d, self.gbar, *stated(self.restitution), *parts, *more, *rubbing

    def with_numbers(self, numbers: Sequence[Any]) -> Groups[Any]:
        """The groups with other `numbers` and harmonics of the same orders; the restitutions are `Restitutions`."""
        d, gbar, bottom, top, *parts = numbers
        friction = None if self.friction is None else parts.pop()
        # In the order of `numbers`, from the end: how many harmonics there are is known only then.
        if self.law is not None:
            *parts, exponent, speed = parts
        pairs = zip(self.harmonics, parts[::2], parts[1::2], strict=True)
        harmonics = tuple(Harmonic(harmonic.order, cosine, sine) for harmonic, cosine, sine in pairs)
        if self.law is not None:
            return Groups(d, gbar, SpeedLaw(bottom, top, exponent, speed), harmonics, friction)
        return Groups(d, gbar, Restitutions(bottom, top), harmonics, friction)

    @property
    def law(self) -> SpeedLaw | None:
        """The law of restitutions that fall with speed; None where they are constant."""
        return self.restitution if isinstance(self.restitution, SpeedLaw) else None

    @property
    def same_harmonics(self) -> tuple[Harmonic, ...]:
        """The harmonics as numbers, from arrays over devices that all have the same ones.

        Raises
        ------
        ValueError
            If they differ.
        """
        harmonics = tuple(harmonic.map_numbers(lambda part: float(np.ravel(part)[0])) for harmonic in self.harmonics)
        for first, harmonic in zip(harmonics, self.harmonics, strict=True):
            if not (np.all(first.cosine == harmonic.cosine) and np.all(first.sine == harmonic.sine)):
                raise ValueError("devices with different harmonics are not solved together")
        return harmonics

    @property
    def alike(self) -> bool:
        """Whether the membranes are alike: a horizontal capsule is then its own mirror image."""
        law = self.law
        return not isinstance(self.restitution, Restitutions) if law is None else bool(law.bottom == law.top)

    @property
    def symmetric(self) -> bool:
        """Whether without gravity the device would be its own mirror image, half a forcing period later.

        It is if the membranes are alike and all harmonics odd: like the sine, these change their sign in half a period.
        """
        return self.alike and all(harmonic.order % 2 for harmonic in self.harmonics)

    @property
    def horizontal(self) -> bool:
        """Whether motions have mirror images: no gravity along the capsule, and a `symmetric` device."""
        return bool(self.gbar == 0) and self.symmetric

    @staticmethod
    def of(d: Arithmetic, gbar: Arithmetic, bottom: Arithmetic, top: Arithmetic) -> Groups[Any]:
        """The groups for a force that is a sine, with `Restitutions` even if the membranes are alike."""
        return Groups(d, gbar, Restitutions(bottom, top))

    def restitution_at(self, wall: int) -> Any:
        """The constant restitution coefficient of a membrane, 1 for the bottom one, -1 for the top one.

        Raises
        ------
        TypeError
            If it falls with speed.
        """
        if self.law is not None:
            raise TypeError("a restitution that falls with speed is not known without the speed")
        bottom, top = by_wall(self.restitution)
        return bottom if wall > 0 else top

    def after(self, wall: int, velocity: Arithmetic) -> Any:
        """The velocity just after an impact on a membrane, from the velocity just before it, Eq. (2.10) [y_c]."""
        return flight.reflect(velocity, self.rebound(wall, velocity)[0])

    def rebound(self, wall: int, velocity: Arithmetic) -> tuple[Any, Any]:
        """The restitution of an impact on a membrane with a velocity, and -dZ'+/dZ'-, which is the same if constant."""
        r = self.restitution
        if isinstance(r, SpeedLaw):
            return r.at(wall, velocity)
        if isinstance(r, Restitutions):
            r = r.bottom if wall > 0 else r.top
        return r, r

    def decay(self, walls: Sequence[int], velocity: Sequence[Any] = ()) -> Any:
        """The root of the determinant of a motion's return map: the product of r over its impacts, as in Eq. (A.3).

        Parameters
        ----------
        walls : sequence of int
            Membranes of the impacts.
        velocity : sequence
            Just before the impacts [y_c]; needed where restitutions fall with speed: the product is then of
            (r s)^(1/2), s the second number of `rebound`.
        """
        law = self.law
        if law is not None:
            impacts = (law.at(wall, v) for wall, v in zip(walls, velocity, strict=True))
            determinant = prod(r * slope for r, slope in impacts)
            return determinant ** (Decimal("0.5") if isinstance(determinant, Decimal) else 0.5)
        bottom, top = by_wall(self.restitution)
        return prod(bottom if wall > 0 else top for wall in walls)

    def pull(self, force: Arithmetic, way: int = 0) -> Any:
        """The relative acceleration Z'', Eq. (2.8).

        Parameters
        ----------
        force : array_like
            Over its amplitude: `Wave.force`, for a sine the cosine of the phase [-].
        way : int
            Sign of Z', for a ball with friction; see `gravity`.
        """
        return flight.acceleration(force, self.gravity(way))

    def gravity(self, way: Arithmetic) -> Any:
        """Gravity and friction along the capsule in a flight in which Z' has the sign `way` [-].

        Friction is against the relative velocity. Z falls from the bottom to the top membrane: `way` is -1 upwards.
        """
        return self.gbar if self.friction is None else self.gbar - way * self.friction

    def flown(
        self, elapsed: Arithmetic, after: Arithmetic, begun: Wave, now: Wave, way: Arithmetic = 0, pi: Arithmetic = pi
    ) -> tuple[Any, Any]:
        """Z less its value at the membrane left [x_c], and the velocity Z' [y_c], a time after an impact.

        Parameters
        ----------
        elapsed : array_like
            Time since the impact [t_c].
        after : array_like
            Velocity just after it [y_c].
        begun, now : Wave
            The force at the impact and at the end of that time.
        way : array_like
            Sign of Z', for a ball with friction; see `gravity`.
        pi : number
            In the kind of number.

        Source: Eqs. (2.11) and (2.12).
        """
        gravity = self.gravity(way)
        covered = flight.displacement(elapsed, after, begun.impulse, begun.path, now.path, gravity, pi)
        return covered, flight.velocity(elapsed, after, begun.impulse, now.impulse, gravity, pi)

    def wave(self, phase: Arithmetic, ops: Functions) -> Wave:
        """The force at a phase, in the kind of number of `ops`."""
        return wave(ops.sin(phase), ops.cos(phase), self.harmonics)
