"""The dimensionless groups: all that flights and impacts, hence motions and simulation, know of a device.

With n they are all of the dynamics, Eqs. (2.8)-(2.12).
"""

from __future__ import annotations

from collections.abc import Iterable
from math import prod
from typing import Any, Generic, NamedTuple, TypeVar

from vireport.physics import flight

Number = TypeVar("Number")


class Groups(NamedTuple, Generic[Number]):
    """What drives a device and what its membranes do, as numbers of one kind or arrays (dimensionless).

    Attributes
    ----------
    d : array_like
        Distance between the membranes, s/x_c.
    gbar : array_like
        Gravity along the capsule over the forcing's acceleration, M g sin(beta)/F.
    restitution : array_like
        r of both membranes. Which membrane is struck is told by the methods all the same, so that what reads these
        does not assume that they are alike.
    """

    d: Number
    gbar: Number
    restitution: Number

    def as_floats(self) -> Groups[float]:
        """The groups as Python's numbers, in which one motion is evaluated ten times as fast as in NumPy's."""
        return Groups(*map(float, self))  # type: ignore[arg-type]

    def restitution_at(self, wall: int) -> Number:
        """The restitution coefficient of a membrane: 1 for the bottom one, -1 for the top one."""
        return self.restitution

    def after(self, wall: int, velocity: Any) -> Any:
        """The velocity just after an impact on a membrane, by the velocity just before it, Eq. (2.10)."""
        return flight.reflect(velocity, self.restitution_at(wall))

    def decay(self, walls: Iterable[int]) -> Any:
        """The root of the determinant of a motion's Jacobian: the product of r over its impacts, as in Eq. (A.3)."""
        return prod(map(self.restitution_at, walls))

    def pull(self, cosine: Any) -> Any:
        """The relative acceleration where the forcing phase has this cosine, Eq. (2.8)."""
        return flight.acceleration(cosine, self.gbar)
