"""Periodic motions of any word as records of their impacts, and the distance of two motions.

Times are in t_c, half a forcing period; the forcing phase is pi t.
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
from vireport.physics.numbers import Arithmetic
from vireport.physics.word import Word

Floats = NDArray[np.float64]

SAME = 1e-7
"""Difference of velocity [y_c] and time [t_c] up to which two motions are the same: between the error of a solution
(1e-12) and the distance of different motions at one value of the swept parameter."""

AT_ZERO = 1e-9
"""Size of a velocity or gap that counts as zero at an event: far above rounding, far below those that are not zero."""

SAME_TOUCH = 1e-3
"""Time [t_c] from an impact without velocity within which a turning point is the same touch: the ball's distance from
the membrane grows with the square of that time, and stays below 1e-9 for 1e-4 at most."""

IMAGE = 1e-5
"""Difference of velocity [y_c] and time [t_c] up to which a motion is its own image where a family turns back as its
image: the equations are singular at such a motion, and half the digits of `SAME` are left."""


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
        Time of each impact, ascending [t_c]; its forcing phase is pi times the time.
    coordinate : float
        Coordinate of the sweep or path that the motion is on; for a sweep d, gbar or a restitution, see `Sweep`.
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
        """Numbers of the impacts without velocity, at which the ball only touches a membrane."""
        return tuple(np.flatnonzero(np.abs(self.velocity) < AT_ZERO).tolist())

    def rotated(self, first: int) -> Motion:
        """The motion with its impacts counted from impact `first`, whose time is in the first forcing period."""
        time = np.concatenate([self.time[first:], self.time[:first] + 2 * self.word.periods])
        velocity = np.concatenate([self.velocity[first:], self.velocity[:first]])
        return Motion(self.word.rotated(first), velocity, time - 2 * np.floor(time[0] / 2), self.coordinate)

    def canonical(self) -> Motion:
        """The motion with its word in canonical form; if several impacts give that, counted from the fastest one."""
        firsts = self.word.firsts(self.word.canonical())
        return self.rotated(max(firsts, key=lambda i: abs(float(self.velocity[i]))))

    def mirrored(self) -> Motion:
        """The mirror image, which is a motion of a horizontal capsule."""
        return replace(self, word=self.word.mirrored(), velocity=-self.velocity, time=self.time + 1)

    def representative(self, mirror: bool) -> Motion:
        """The motion that stands for all rotations of this one and, with `mirror`, of its mirror image."""
        image = self.mirrored()
        exchanged = mirror and image.word.canonical().letters < self.word.canonical().letters
        return (image if exchanged else self).canonical()

    def times(self, count: int) -> Motion:
        """`count` periods of the motion as one motion of a longer word."""
        period = 2 * self.word.periods
        time = np.concatenate([self.time + i * period for i in range(count)])
        word = Word(count * self.word.walls, count * self.word.periods)
        return Motion(word, np.tile(self.velocity, count), time, self.coordinate)

    def primitive(self) -> Motion:
        """The motion with the fewest impacts of which this is a whole number of periods; itself, if that is one."""
        count = len(self.word)
        for i in self.word.firsts(self.word)[1:]:
            if count % i == 0 and self.apart(self.rotated(i)) < IMAGE:
                word = Word(self.word.walls[:i], self.word.periods * i // count)
                return Motion(word, self.velocity[:i], self.time[:i], self.coordinate)
        return self

    def with_impact(self, after: int, wall: int, time: float) -> Motion:
        """The motion with an impact of velocity zero put in at a time of the flight that begins with impact `after`."""
        walls = (*self.word.walls[: after + 1], wall, *self.word.walls[after + 1 :])
        return Motion(
            Word(walls, self.word.periods),
            np.insert(self.velocity, after + 1, 0.0),
            np.insert(self.time, after + 1, time),
            self.coordinate,
        )

    def without_impacts(self, which: Any) -> Motion:
        """The motion without impacts that have no velocity, by their numbers."""
        walls = tuple(wall for i, wall in enumerate(self.word.walls) if i not in which)
        velocity, time = np.delete(self.velocity, which), np.delete(self.time, which)
        return Motion(Word(walls, self.word.periods), velocity, time, self.coordinate)

    def apart(self, other: Motion) -> float:
        """Largest difference of velocity [y_c] and time [t_c] of the impacts, in their order; inf for other words."""
        if self.word != other.word:
            return inf
        late = (self.time - other.time).tolist()
        # Whole forcing periods later it is the same motion.
        whole = 2 * round(late[0] / 2)
        fast = (self.velocity - other.velocity).tolist()
        return float(max(*map(abs, fast), *(abs(difference - whole) for difference in late)))

    def distance(self, other: Motion, mirror: bool = False) -> float:
        """Least of `apart` over all impacts from which the other motion may be counted; inf for other words.

        With `mirror` also over its mirror image.
        """
        others = (other, other.mirrored()) if mirror else (other,)
        images = (image.rotated(i) for image in others for i in image.word.firsts(self.word))
        return min(map(self.apart, images), default=inf)


def multipliers(trace: Arithmetic, determinant: Arithmetic) -> NDArray[np.complex128]:
    """Both eigenvalues of a linearised return map, (..., 2), the one of larger modulus first; nan where the trace is.

    `motions.stability.eigenvalues` has their real parts by size, as figures show them, with all digits next to Delta=0.

    Parameters
    ----------
    trace, determinant : array_like
        Of the map.
    """
    # The smaller one comes from the product, as the difference would cancel.
    trace = np.asarray(trace)
    root = np.sqrt(trace.astype(complex) ** 2 - 4 * determinant)
    large = (trace + np.where(trace < 0, -root, root)) / 2
    with np.errstate(invalid="ignore"):  # of nan
        return np.stack([large, determinant / np.where(large == 0, 1, large)], axis=-1)
