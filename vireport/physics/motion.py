"""Periodic motions of any word: what they are, and when two are the same.

A motion is known by its impacts. Times are in t_c, half a forcing period, with the forcing phase pi t.
"""

from __future__ import annotations

from enum import StrEnum
from math import inf, pi
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.physics.word import Word

Floats = NDArray[np.float64]

SAME = 1e-7
"""Difference of velocity [y_c] and time [t_c] up to which two motions are one: between the error of a solution
(1e-12) and the distance of different motions at one value of the swept parameter."""

AT_ZERO = 1e-9
"""Velocity or gap that is zero where an event says that one is: far above rounding, far below any that differ."""

BESIDE = 1e-3
"""Time [t_c] from an impact without velocity within which a turning point is the same touch: its distance grows with
the square of the time, and is zero up to 1e-9 at 1e-4 or less."""

IMAGE = 1e-5
"""Difference of velocity [y_c] and time [t_c] up to which a motion is its own image, where a family turns back as that:
there the equations are singular, and half the digits of `SAME` are left."""


class Symmetry(StrEnum):
    """Whether a motion is its own mirror image, as some of a horizontal capsule are."""

    SYMMETRIC = "symmetric"
    ASYMMETRIC = "asymmetric"


class Motion(Struct, frozen=True, eq=False):
    """A periodic motion (dimensionless).

    Attributes
    ----------
    word : Word
    velocity : ndarray (N,)
        Relative velocity just before each impact [y_c]; positive at the bottom, negative at the top.
    time : ndarray (N,)
        Of each impact, ascending [t_c]; the forcing phase there is pi times it.
    coordinate : float
        What orders the sweep, see `Sweep.coordinate_of`: d, or gbar where the inclination varies.
    """

    word: Word
    velocity: Floats
    time: Floats
    coordinate: float

    __repr__ = brief

    @property
    def phase(self) -> Floats:
        """Forcing phase at each impact [rad], in [0, 2 pi)."""
        return np.mod(pi * self.time, 2 * pi)

    @property
    def durations(self) -> Floats:
        """Flight time from each impact to the next one, (N,) [t_c]."""
        return np.append(self.time[1:], self.time[0] + 2 * self.word.periods) - self.time

    @property
    def rests(self) -> tuple[int, ...]:
        """The impacts that have no velocity."""
        return tuple(np.flatnonzero(np.abs(self.velocity) < AT_ZERO).tolist())

    def rotated(self, first: int) -> Motion:
        """The motion with its impacts counted from another one, which is within the first forcing period."""
        time = np.concatenate([self.time[first:], self.time[:first] + 2 * self.word.periods])
        velocity = np.concatenate([self.velocity[first:], self.velocity[:first]])
        return Motion(self.word.rotated(first), velocity, time - 2 * np.floor(time[0] / 2), self.coordinate)

    def canonical(self) -> Motion:
        """The motion counted from where its word is the alphabetically first one; of several, the fastest impact."""
        firsts = self.word.firsts(self.word.canonical())
        return self.rotated(max(firsts, key=lambda i: abs(float(self.velocity[i]))))

    def mirrored(self) -> Motion:
        """The mirror image, a motion where gravity has no part along the capsule."""
        return replace(self, word=self.word.mirrored(), velocity=-self.velocity, time=self.time + 1)

    def representative(self, mirror: bool) -> Motion:
        """The one of its rotations and, with `mirror`, its mirror images that stands for all."""
        image = self.mirrored()
        exchanged = mirror and image.word.canonical().letters < self.word.canonical().letters
        return (image if exchanged else self).canonical()

    def times(self, count: int) -> Motion:
        """Several periods of the motion, as one."""
        period = 2 * self.word.periods
        time = np.concatenate([self.time + i * period for i in range(count)])
        word = Word(count * self.word.walls, count * self.word.periods)
        return Motion(word, np.tile(self.velocity, count), time, self.coordinate)

    def primitive(self) -> Motion:
        """The motion with the fewest impacts of which this is one period or several."""
        count = len(self.word)
        for i in self.word.firsts(self.word)[1:]:
            if count % i == 0 and self.apart(self.rotated(i)) < IMAGE:
                word = Word(self.word.walls[:i], self.word.periods * i // count)
                return Motion(word, self.velocity[:i], self.time[:i], self.coordinate)
        return self

    def with_impact(self, after: int, wall: int, time: float) -> Motion:
        """The motion with an impact of velocity zero in the flight after an impact."""
        walls = (*self.word.walls[: after + 1], wall, *self.word.walls[after + 1 :])
        return Motion(
            Word(walls, self.word.periods),
            np.insert(self.velocity, after + 1, 0.0),
            np.insert(self.time, after + 1, time),
            self.coordinate,
        )

    def without_impacts(self, which: Any) -> Motion:
        """The motion without some of its impacts, which have no velocity."""
        walls = tuple(wall for i, wall in enumerate(self.word.walls) if i not in which)
        velocity, time = np.delete(self.velocity, which), np.delete(self.time, which)
        return Motion(Word(walls, self.word.periods), velocity, time, self.coordinate)

    def apart(self, other: Motion) -> float:
        """Largest difference of velocity and time of the impacts, in the order given; inf for other words."""
        if self.word != other.word:
            return inf
        late = (self.time - other.time).tolist()
        whole = 2 * round(late[0] / 2)
        fast = (self.velocity - other.velocity).tolist()
        return float(max(*map(abs, fast), *(abs(difference - whole) for difference in late)))

    def distance(self, other: Motion, mirror: bool = False) -> float:
        """Least of `apart` over the impacts from which the other may be counted; inf for other words.

        With `mirror`, of its mirror image if that is nearer.
        """
        others = (other, other.mirrored()) if mirror else (other,)
        images = (image.rotated(i) for image in others for i in image.word.firsts(self.word))
        return min(map(self.apart, images), default=inf)
