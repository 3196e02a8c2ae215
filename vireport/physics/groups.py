"""The dimensionless groups: all that flights and impacts, hence motions and simulation, know of a device.

With n they are all of the dynamics, Eqs. (2.8)-(2.12).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import prod
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from msgspec import Struct

from vireport.physics import flight
from vireport.physics.forcing import Harmonic, Wave, wave

Number = TypeVar("Number")


class Restitutions(Struct, frozen=True):
    """The restitution coefficients of two membranes that are not alike, as numbers of any kind or arrays.

    Membranes that are alike have one number in its place: terms that vanish with the difference are then left out, for
    their time and for the rounding that they would add to every error bound.
    """

    bottom: Any
    top: Any


def by_wall(restitution: Any) -> tuple[Any, Any]:
    """The restitution at the bottom and at the top: of one number for both, or of `Restitutions`."""
    if isinstance(restitution, Restitutions):
        return restitution.bottom, restitution.top
    return restitution, restitution


def each(restitution: Any, function: Callable[[Any], Any]) -> Any:
    """What a function makes of one number for both membranes, or of each of `Restitutions`."""
    if isinstance(restitution, Restitutions):
        return Restitutions(function(restitution.bottom), function(restitution.top))
    return function(restitution)


class Groups(NamedTuple, Generic[Number]):
    """What drives a device and what its membranes do, as numbers of one kind or arrays (dimensionless).

    Attributes
    ----------
    d : array_like
        Distance between the membranes, s/x_c.
    gbar : array_like
        Gravity along the capsule over the forcing's acceleration, M g sin(beta)/F.
    restitution : array_like or Restitutions
        r of both membranes, or of each where they are not alike.
    harmonics : tuple of Harmonic
        Of the force, none of a sine.
    friction : array_like or None
        Of the ball on the capsule, mu_f M g cos(beta)/F, against the relative velocity; None of a ball without it.
    """

    d: Number
    gbar: Number
    restitution: Any
    harmonics: tuple[Harmonic, ...] = ()
    friction: Any = None

    def as_floats(self) -> Groups[float]:
        """The groups as Python's numbers, in which one motion is evaluated ten times as fast as in NumPy's."""
        return self.each(float)

    def each(self, function: Callable[[Any], Any]) -> Groups[Any]:
        """What a function makes of each number."""
        harmonics = tuple(own.each(function) for own in self.harmonics)
        friction = None if self.friction is None else function(self.friction)
        return Groups(function(self.d), function(self.gbar), each(self.restitution, function), harmonics, friction)

    @property
    def numbers(self) -> tuple[Any, ...]:
        """d, gbar, both restitutions, bottom first, the cosine and the sine of each harmonic, and friction if any."""
        parts = [part for own in self.harmonics for part in (own.cosine, own.sine)]
        rubbing = () if self.friction is None else (self.friction,)
        return self.d, self.gbar, *by_wall(self.restitution), *parts, *rubbing

    def with_numbers(self, numbers: Sequence[Any]) -> Groups[Any]:
        """The groups with other `numbers`, whether or not the membranes are alike, and harmonics of the same orders."""
        d, gbar, bottom, top, *parts = numbers
        friction = None if self.friction is None else parts.pop()
        pairs = zip(self.harmonics, parts[::2], parts[1::2], strict=True)
        harmonics = tuple(Harmonic(own.order, cosine, sine) for own, cosine, sine in pairs)
        return Groups(d, gbar, Restitutions(bottom, top), harmonics, friction)

    @property
    def same_harmonics(self) -> tuple[Harmonic, ...]:
        """The harmonics as numbers, where those of arrays are the same for all."""
        harmonics = tuple(own.each(lambda part: float(np.ravel(part)[0])) for own in self.harmonics)
        pairs = zip(harmonics, self.harmonics, strict=True)
        if not all(np.all(one.cosine == own.cosine) and np.all(one.sine == own.sine) for one, own in pairs):
            raise ValueError("devices with different harmonics are not solved together")
        return harmonics

    @property
    def alike(self) -> bool:
        """Whether the membranes are alike: a horizontal capsule is then its own mirror image."""
        return not isinstance(self.restitution, Restitutions)

    @property
    def symmetric(self) -> bool:
        """Whether without gravity the device is its own mirror image, half a forcing period later.

        The membranes are alike then, and the harmonics odd, as the sine is: they change their sign in half a period.
        """
        return self.alike and all(own.order % 2 for own in self.harmonics)

    @staticmethod
    def of(d: Any, gbar: Any, bottom: Any, top: Any) -> Groups[Any]:
        """The groups of a sine's `numbers`, whether or not the membranes are alike."""
        return Groups(d, gbar, Restitutions(bottom, top))

    def restitution_at(self, wall: int) -> Any:
        """The restitution coefficient of a membrane: 1 for the bottom one, -1 for the top one."""
        bottom, top = by_wall(self.restitution)
        return bottom if wall > 0 else top

    def after(self, wall: int, velocity: Any) -> Any:
        """The velocity just after an impact on a membrane, by the velocity just before it, Eq. (2.10)."""
        return flight.reflect(velocity, self.restitution_at(wall))

    def decay(self, walls: Iterable[int]) -> Any:
        """The root of the determinant of a motion's Jacobian: the product of r over its impacts, as in Eq. (A.3)."""
        return prod(map(self.restitution_at, walls))

    def pull(self, force: Any, way: int = 0) -> Any:
        """The relative acceleration where the force over its amplitude is this, of a sine a cosine, Eq. (2.8).

        Of a ball with friction, where Z' has the sign `way`: see `gravity`.
        """
        return flight.acceleration(force, self.gravity(way))

    def gravity(self, way: int) -> Any:
        """What stands for gbar in a flight in which Z' has the sign `way`: friction is against the relative velocity.

        Z falls on the way up, from the bottom to the top membrane.
        """
        return self.gbar if self.friction is None else self.gbar - way * self.friction

    def wave(self, phase: Any, ops: Any) -> Wave:
        """The force at a phase, in the kind of number of `ops`."""
        return wave(ops.sin(phase), ops.cos(phase), self.harmonics)
