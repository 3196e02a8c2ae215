"""The conditions of a periodic motion with any sequence of impacts, their derivatives, and its trace.

For each flight two equations, of the maps P1 to P4 (2.13): velocity (2.11) and position (2.12) at its end. The unknowns
are the velocities and times of the N impacts and the coordinate of the sweep, so that motions are curves in a space of
2N + 1 dimensions. The formulae serve every kind of number, see `vireport.physics.numbers`.

`residuals` has the conditions, `linearised` them with their Jacobian matrix, `trace` the trace of the return map. How
the groups depend on what varies is a `Grouped`: `Model` for a sweep; other packages have lines and planes of inputs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import cos, inf, log, pi, sin
from typing import Any, NamedTuple, Protocol

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.motions.stability import flight_jacobian, product_trace
from vireport.motions.sweep import Held, Level, Sweep
from vireport.physics import flight
from vireport.physics.device import MOVES
from vireport.physics.forcing import Harmonic, Wave, wave
from vireport.physics.groups import Groups, Restitutions, by_wall, map_restitution
from vireport.physics.numbers import FLOATS, Arithmetic, ExactFunctions, Functions
from vireport.physics.word import Word

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

BEYOND = 100.0
"""Range of a sweep over the range with motions on both membranes, from which the latter scales the coordinate."""


class Grouped(Protocol):
    """The dimensionless groups as a function of numbers of a device that vary."""

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """The groups at values of the numbers that vary."""


class Varied(Grouped, Protocol):
    """The groups as a function of numbers that vary, with derivatives."""

    def slopes(self, varied: Sequence[Any]) -> Floats:
        """Derivatives of `Groups.numbers` (4 for a sine) by the numbers that vary, (numbers, len(varied))."""


class Variation(Varied, Protocol):
    """The groups as a function of one number that varies, along which motions are followed."""

    @property
    def horizontal(self) -> bool:
        """Whether motions have mirror images, whatever varies: no gravity along the capsule, and equal ends."""


class Model(Struct, frozen=True):
    """The groups over a sweep as a function of its coordinate: a line in the plane of d and gbar, or of restitutions.

    The coordinate is the last of the unknowns of a motion, after velocities and times.

    Attributes
    ----------
    level : Level
    r : array_like or Restitutions
        Restitution of the device.
    harmonics : tuple of Harmonic
        Harmonics of the force.
    """

    level: Level
    r: Any
    harmonics: tuple[Harmonic, ...] = ()

    @property
    def horizontal(self) -> bool:
        """Whether motions have mirror images: no gravity along the capsule, and all else alike at both ends."""
        return self.level.symmetric(self.r, self.harmonics)

    def groups(self, coordinate: Any) -> Groups[Any]:
        """The groups at a value of the coordinate that orders the sweep."""
        if self.level.held is Held.D:
            return Groups(self.level.value, coordinate, self.r, self.harmonics)
        if self.level.varied is not None:
            d, gbar, restitution = self.level.d, self.level.value, self.level.restitution(self.r, coordinate)
            friction = None if self.level.friction is None else self.level.friction.constant
            return Groups(d, gbar, restitution, self.harmonics, friction)
        gbar = self.level.value if self.level.held is Held.GBAR else coordinate / self.level.value
        friction = None if self.level.friction is None else self.level.friction.at(gbar, coordinate)
        return Groups(coordinate, gbar, self.r, self.harmonics, friction)

    def decay(self, walls: Sequence[int], coordinate: Arithmetic) -> Any:
        """The root of the determinant of the return map of a motion, see `Groups.decay`.

        Parameters
        ----------
        walls : sequence of int
            Membranes of the impacts, 1 bottom, -1 top.
        coordinate : array_like
        """
        r = self.level.restitution(self.r, coordinate)
        # For membranes that are alike as a power, which is rounded once, not N times.
        return Groups(0.0, 0.0, r).decay(walls) if isinstance(r, Restitutions) else r ** len(walls)

    def determinant(self, walls: Sequence[int], coordinate: Arithmetic) -> Any:
        """The determinant of the return map of a motion: the product of r^2 over its impacts."""
        r = self.level.restitution(self.r, coordinate)
        return Groups(0.0, 0.0, r).decay(walls) ** 2 if isinstance(r, Restitutions) else r ** (2 * len(walls))

    @property
    def slope(self) -> tuple[float, float]:
        """Derivatives of d and gbar by the coordinate."""
        if self.level.varied is not None:
            return 0.0, 0.0
        if self.level.held is Held.D:
            return 0.0, 1.0
        return 1.0, 0.0 if self.level.held is Held.GBAR else 1.0 / self.level.value

    def reach(self, periods: int) -> float:
        """A coordinate far beyond all motions that strike both membranes; infinite where the coordinate is not d.

        Notes
        -----
        In a time t between impacts the speed changes by at most (1 + gbar) t, and in each period, 2 k, an impact leaves
        at most r of it: the speed is below 2 k (1 + gbar)/(1 - r), and so d below 2 k times that. Where the force
        varies, gbar is bounded as for one impact in a period, gbar < (1 + r)/[pi k (1 - r)]. Only a sweep that goes
        `BEYOND` is measured by less than itself.
        """
        if self.level.held in (Held.D, Held.BOTH):
            return inf
        r = max(by_wall(self.r))
        most = (1 + r) / (1 - r)
        gbar = self.level.value if self.level.held is Held.GBAR else most
        if self.level.friction is not None:
            gbar = gbar + self.level.friction.constant
        farthest = (2 * periods) ** 2 * (1 + gbar) / (1 - r)
        # Harmonics add as much to a speed, or to gbar, as they are of the force.
        pushed = BEYOND * (1 + sum(harmonic.share for harmonic in self.harmonics))
        return pushed * float(farthest if self.level.held is Held.GBAR else min(farthest, self.level.value * most))

    def at(self, varied: Sequence[Any]) -> Groups[Any]:
        """The groups where the coordinate is the only entry of `varied`."""
        return self.groups(varied[0])

    def slopes(self, varied: Sequence[Any]) -> Floats:
        """Derivatives of `Groups.numbers` by the coordinate, (numbers, 1): zero for the harmonics."""
        friction = self.level.friction
        by_d, by_gbar = self.slope
        bounces = (0.0, 0.0) if self.level.varied is None else MOVES[self.level.varied]
        rubbing = [] if friction is None else [friction.by_gbar * by_gbar + friction.by_d * by_d]
        return np.array([[by_d, by_gbar, *bounces, *[0.0] * (2 * len(self.harmonics)), *rubbing]]).T


@lru_cache(maxsize=8)
def model_of(sweep: Sweep, ops: ExactFunctions) -> Model:
    """The groups over a sweep, in a kind of number."""
    # Cached: many points of one sweep are solved for.
    device = sweep.device
    harmonics = tuple(harmonic.exact(ops) for harmonic in device.harmonics)
    return Model(sweep.level_in(ops), map_restitution(device.restitution, ops.exact), harmonics)


class Leg(NamedTuple):
    """A flight of a motion: numbers of the impacts at its ends, flight time [t_c], and the force at both impacts."""

    start: int
    end: int
    duration: Any
    starts: Wave
    ends: Wave


def legs(word: Word, time: Sequence[Any], groups: Groups[Any], ops: Functions = FLOATS) -> Iterator[Leg]:
    """The flights of a motion from the times of its impacts, in order; the last one ends with the first impact."""
    count, harmonics = len(word), groups.harmonics
    pi, sin, cos = ops.pi, ops.sin, ops.cos
    waves = [wave(sin(phase), cos(phase), harmonics) for phase in [pi * t for t in time]]
    for i in range(count):
        j = (i + 1) % count
        duration = time[j] - time[i] + (0 if j > i else 2 * word.periods)
        yield Leg(i, j, duration, waves[i], waves[j])


def residuals(word: Word, x: Sequence[Any], model: Grouped, ops: Functions = FLOATS) -> list[Any]:
    """The conditions of a motion: velocity and position at the end of each flight less those of the next impact.

    Parameters
    ----------
    word : Word
    x : sequence
        The N velocities [y_c], the N times [t_c] and the numbers that vary.
    model : Grouped
        The groups, in the kind of number of `ops`.

    Returns
    -------
    list
        2N numbers: velocity and position for each flight in turn; all zero for a motion.

    Source: Eqs. (2.11)-(2.13).
    """
    count, values = len(word), []
    groups = model.at(x[2 * count :])
    d = groups.d
    # Velocity and position at a given time, two conditions for each flight. The time of the next impact, which a
    # simulation follows, has no closed form: as an unknown it needs none.
    for leg in legs(word, x[count : 2 * count], groups, ops):
        after, t = groups.after(word.walls[leg.start], x[leg.start]), leg.duration
        way = (word.walls[leg.end] - word.walls[leg.start]) // 2
        covered, speed = groups.flown(t, after, leg.starts, leg.ends, way, ops.pi)
        values += [speed - x[leg.end], covered - way * d]
    return values


def linearised(word: Word, x: Floats, model: Varied) -> tuple[Floats, Floats]:
    """The `residuals`, (2N,), and their derivatives by the unknowns, (2N, len(x))."""
    # Written out by hand and in Python's numbers: this is evaluated at each correction of each step of all families,
    # where arrays of a few numbers cost more than the arithmetic.
    count, row = len(word), x.tolist()
    groups = model.at(row[2 * count :])
    d = groups.d
    values, by_impacts, by_groups = [], [], []  # lists, whose entries are written ten times as fast
    walls = word.walls
    for i, j, t, starts, ends in legs(word, row[count : 2 * count], groups):
        wall, before = walls[i], row[i]
        r, slope = groups.rebound(wall, before)
        after = flight.reflect(before, r)
        way = (walls[j] - wall) // 2
        gbar = groups.gravity(way)
        pull_start, pull_end = flight.acceleration(starts.force, gbar), flight.acceleration(ends.force, gbar)
        covered, speed = groups.flown(t, after, starts, ends, way)
        values += [speed - row[j], covered - way * d]
        by_impacts += [-slope, -pull_start, -slope * t, -after - pull_start * t, -1.0, pull_end, speed]
        of_bottom, of_top, *of_law = _by_restitution(groups, wall, before)
        by_velocity, by_way = [0.0, t, of_bottom, of_top], [-way, t * t / 2, of_bottom * t, of_top * t]
        if groups.harmonics:
            more = [_by_harmonic(harmonic.order, row[count + i], row[count + j], t) for harmonic in groups.harmonics]
            by_velocity += [slope for pair in more for slope in pair[0]]
            by_way += [slope for slopes_of in more for slope in slopes_of[1]]
        if of_law:
            by_velocity, by_way = by_velocity + of_law, by_way + [by_number * t for by_number in of_law]
        if groups.friction is not None:
            by_velocity.append(-way * t)
            by_way.append(-way * t * t / 2)
        by_groups += [by_velocity, by_way]
    # A motion with one impact has the same impact at both ends of its flight: bincount adds their derivatives.
    entries = np.asarray(np.bincount(_places(count, len(row)), by_impacts, 2 * count * len(row)), float)
    matrix = entries.reshape(2 * count, len(row))
    matrix[:, 2 * count :] = np.array(by_groups) @ model.slopes(row[2 * count :])
    return np.array(values), matrix


def _by_restitution(groups: Groups[float], wall: int, velocity: float) -> tuple[float, ...]:
    """Derivatives of the velocity after an impact by r at the bottom and at the top; with a law, by its numbers too."""
    law = groups.law
    if law is None:
        return (-velocity, 0.0) if wall > 0 else (0.0, -velocity)
    r, slope = law.at(wall, velocity)
    if r == slope and law.exponent:  # r is at its upper limit, see `restitution_at_speed`
        return 0.0, 0.0, 0.0, 0.0
    stated = law.bottom if wall > 0 else law.top
    by_stated = -velocity * (r / stated) if stated else -velocity
    share = wall * velocity / law.speed
    by_exponent = -velocity * r * log(share) if share > 0 else 0.0
    by_speed = velocity * r * law.exponent / law.speed
    return (by_stated, 0.0, by_exponent, by_speed) if wall > 0 else (0.0, by_stated, by_exponent, by_speed)


def _by_harmonic(order: int, start: float, end: float, t: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Derivatives of velocity and position at the end of a flight by the cosine and sine coefficients of a harmonic.

    Parameters
    ----------
    order : int
    start, end : float
        Times of the impacts at the ends of the flight [t_c].
    t : float
        Flight time [t_c].
    """
    # The flight is linear in the force: the derivatives are the flights with cos jx, or sin jx, in the place of cos x.
    turns = order * pi
    s0, c0, s1, c1 = sin(turns * start), cos(turns * start), sin(turns * end), cos(turns * end)
    velocity = (s1 - s0) / turns, (c0 - c1) / turns
    position = (c0 - c1) / turns**2 - s0 * t / turns, (s0 - s1) / turns**2 + c0 * t / turns
    return velocity, position


@lru_cache
def _places(count: int, width: int) -> Ints:
    """Places in the flattened matrix (2 count, width) of the seven derivatives of each flight by its two impacts."""
    start = np.arange(count)
    end, velocity = np.roll(start, -1), 2 * start * width
    position = velocity + width
    by_start = velocity + start, velocity + count + start, position + start, position + count + start
    by_end = velocity + end, velocity + count + end, position + count + end
    return np.stack([*by_start, *by_end], axis=1).ravel()


def trace(word: Word, x: Sequence[Any], model: Grouped, ops: Functions = FLOATS) -> Any:
    """Trace of the return map of a motion, the product of the Jacobians of its flights.

    Its determinant is the square of `Groups.decay`. Parameters are those of `residuals`; all velocities must differ
    from zero.

    Source: Eqs. (A.1), (A.2).
    """
    count, walls, flights = len(word), word.walls, []
    groups = model.at(x[2 * count :])
    for i, j, duration, starts, ends in legs(word, x[count : 2 * count], groups, ops):
        r, slope = groups.rebound(walls[i], x[i])
        gbar = groups.gravity((walls[j] - walls[i]) // 2)
        pulls = flight.acceleration(starts.force, gbar), flight.acceleration(ends.force, gbar)
        flights.append(flight_jacobian(duration, (x[i], x[j]), pulls, r, slope))
    return product_trace(flights)


def weighted_trace(word: Word, x: Sequence[Any], groups: Groups[Any], ops: Functions = FLOATS) -> Any:
    """The trace times the product of all velocities, which has no pole where a velocity is zero.

    Parameters are those of `residuals`, with the groups in the place of the model.
    """
    count, flights = len(word), []
    for leg in legs(word, x[count : 2 * count], groups, ops):
        (r, slope), speed = groups.rebound(word.walls[leg.start], x[leg.start]), x[leg.end]
        way = (word.walls[leg.end] - word.walls[leg.start]) // 2
        start, end = groups.pull(leg.starts.force, way), groups.pull(leg.ends.force, way)
        time, velocity = start * leg.duration - r * x[leg.start], slope * leg.duration
        flights.append((time, velocity, time * end - start * speed, velocity * end - slope * speed))
    return product_trace(flights)
