"""Flights of sets of states in affine arithmetic: where each of them ends, proved for every state of a set.

A set is a parallelogram about a state just before an impact, or about the shocks of a range of moments and sizes. The
simulation says where the flight from its middle ends; that is believed of nothing. That every state of a set meets the
same membrane, at a time that is enclosed to second order in the size of the set, and meets no membrane before, is
proved, all roundings included.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.physics import AFFINE, AFFINE_ROUNDING, Affine, Groups, between, flight
from vireport.simulation import FLIGHT, TURN, WALL, check_model, follow_impacts

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

FIRST, SECOND, ERRORS, TIME = 0, 1, slice(2, 4), 4
"""Symbols of a set: its two coordinates, two of what has been rounded up since, and one of time within a flight."""

SYMBOLS = 5

WIDER = 2.0
"""Width of the tube in which the end of a flight is looked for, over what the middle of the tube asks for."""

THINNEST = 1e-13
"""Least width of that tube, of the size of rounding."""

PARTS, HALVINGS = 6, 5
"""Parts of a flight, and how often one is halved before it is left open whether the ball meets a membrane there."""

BLOCK = 4096
"""Sets followed at once: their numbers stay in the processor's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Sets:
    """Sets of states that begin flights, one for each of k.

    Attributes
    ----------
    wall : ndarray of int (k,)
        The membrane that is left: 1 bottom, -1 top.
    time : Affine
        Of the impact there [t_c]; the forcing phase is pi times it.
    after : Affine
        Relative velocity just after it [y_c], away from the membrane.
    offset : Affine
        Distance from the membrane with which the flight begins: 0, but for a shock, which is as if the ball had left
        with the velocity that it has then, from elsewhere.
    since : Affine
        Time after the impact from which on the flight is followed: 0, or that of the shock.
    """

    wall: Ints
    time: Affine
    after: Affine
    offset: Affine
    since: Affine

    def __getitem__(self, rows: Any) -> Sets:
        return Sets(self.wall[rows], self.time[rows], self.after[rows], self.offset[rows], self.since[rows])

    def __len__(self) -> int:
        return len(self.wall)


@dataclass(frozen=True, slots=True, eq=False)
class Impacts:
    """Sets of states just before impacts, one for each of k.

    Attributes
    ----------
    proved : ndarray of bool (k,)
        Whether all states of the set before come there, with no impact in between; the others are undefined.
    wall : ndarray of int (k,)
    time, velocity : Affine
        [t_c], by the clock of the impact before; velocity just before [y_c].
    duration : Affine
        Time since the impact before [t_c].
    """

    proved: Mask
    wall: Ints
    time: Affine
    velocity: Affine
    duration: Affine


def exact(value: Floats) -> Affine:
    """Doubles as the numbers that they are."""
    return Affine(value, np.zeros((SYMBOLS, len(value))), np.zeros(len(value)))


def enclosed(groups: Groups[float]) -> Groups[Any]:
    """The groups as computed in doubles, by at most a dozen roundings, with a bound of these; r is exact."""
    d, gbar = exact(np.array([groups.d])), exact(np.array([groups.gbar]))
    d.radius[:], gbar.radius[:] = AFFINE_ROUNDING * groups.d, AFFINE_ROUNDING * groups.gbar
    return Groups(d, gbar, groups.restitution)


def restitutions(groups: Groups[Any], wall: Ints) -> Floats:
    """Restitution coefficients of membranes."""
    return np.asarray(np.where(wall > 0, groups.restitution_at(1), groups.restitution_at(-1)), dtype=float)


def after_impact(groups: Groups[Any], impacts: Impacts, rows: Any) -> Sets:
    """The sets that begin the next flights, by the impacts that end those before: some of them."""
    wall, count = impacts.wall[rows], len(impacts.wall[rows])
    time, velocity = merged(impacts.time[rows], impacts.velocity[rows])
    time = time - 2.0 * np.floor(time.centre / 2)
    return Sets(wall, time, velocity * -restitutions(groups, wall), exact(np.zeros(count)), exact(np.zeros(count)))


def merged(time: Affine, velocity: Affine) -> tuple[Affine, Affine]:
    """The same sets, or larger ones, whose rest is a parallelogram of two symbols instead of one that has sides.

    By the axes of its longer side: sides that have become nearly parallel would otherwise blow up (Lohner's method).
    """
    spread = np.stack([time.linear[ERRORS], velocity.linear[ERRORS]])  # coordinate, symbol, set
    rest = np.stack([time.radius, velocity.radius])
    size = np.hypot(spread[0], spread[1])
    longest = spread[:, np.argmax(size, axis=0), np.arange(spread.shape[2])]
    largest = size.max(axis=0)
    along = np.where(largest > 0, longest / np.where(largest > 0, largest, 1.0), [[1.0], [0.0]])
    axes = np.stack([along, np.stack([-along[1], along[0]])])  # axis, coordinate, set: orthogonal to rounding
    reach = np.abs(np.einsum("ack,cek->aek", axes, spread)).sum(axis=1) + np.einsum("ack,ck->ak", np.abs(axes), rest)
    reach += AFFINE_ROUNDING * (np.abs(spread).sum(axis=(0, 1)) + rest.sum(axis=0)) + 1e-300
    linear = [time.linear.copy(), velocity.linear.copy()]
    for coordinate, columns in enumerate(linear):
        columns[ERRORS] = axes[:, coordinate] * reach
    count = np.zeros(len(time.centre))
    return Affine(time.centre, linear[0], count), Affine(velocity.centre, linear[1], count)


@dataclass(frozen=True, slots=True, eq=False)
class _Flights:
    """The formulae of the flights of some sets, and what they share."""

    sets: Sets
    groups: Groups[Any]
    sine: Affine
    cosine: Affine

    def __getitem__(self, rows: Any) -> _Flights:
        return _Flights(self.sets[rows], self.groups, self.sine[rows], self.cosine[rows])

    @property
    def away(self) -> Floats:
        """Sign of a velocity away from the membrane left."""
        return np.asarray(-self.sets.wall, dtype=float)

    def waves(self, t: Affine) -> tuple[Affine, Affine]:
        """Sine and cosine of the phase a time after the impact."""
        angle = AFFINE.pi * (self.sets.time + t)
        return AFFINE.sin(angle), AFFINE.cos(angle)

    def covered(self, t: Affine, cosine: Affine) -> Affine:
        """Distance from the membrane left."""
        moved: Affine = flight.displacement(
            t, self.sets.after, self.sine, self.cosine, cosine, self.groups.gbar, pi=AFFINE.pi
        )
        return self.sets.offset + moved * self.away

    def speed(self, t: Affine, sine: Affine) -> Affine:
        """Velocity away from the membrane left."""
        velocity: Affine = flight.velocity(t, self.sets.after, self.sine, sine, self.groups.gbar, pi=AFFINE.pi)
        return velocity * self.away

    def missed(self, t: Affine, cosine: Affine, far: Mask) -> Affine:
        """Distance covered less that at which the membrane is that is to be met."""
        target: Affine = self.groups.d * far.astype(float)
        return self.covered(t, cosine) - target


def next_impacts(groups: Groups[Any], sets: Sets, guesses: Floats) -> Impacts:
    """Follow sets to their next impacts.

    Parameters
    ----------
    groups : Groups of Affine
        Of the device, see `enclosed`.
    sets : Sets
    guesses : ndarray (k, 2)
        The membrane that the middle of each set meets, and how long after `since`, see `simulated`.
    """
    with np.errstate(all="ignore"):  # what is not defined is not finite, and proves nothing
        phase = AFFINE.pi * sets.time
        way = _Flights(sets, groups, AFFINE.sin(phase), AFFINE.cos(phase))
        wall = np.where(guesses[:, 0] > 0, 1, -1)
        far = wall != sets.wall
        duration, ends = _duration(way, far, sets.since.centre + guesses[:, 1])
        ends &= guesses[:, 0] != 0
        speed = _forgotten(way.speed(duration, way.waves(duration)[0]))
        ends &= np.where(far, speed.lower > 0, speed.upper < 0)
        rows = np.flatnonzero(ends)
        if rows.size:
            ends[rows] = _free(way[rows], far[rows], duration[rows])
    return Impacts(ends, wall, sets.time + duration, speed * way.away, duration)


def _duration(way: _Flights, far: Mask, guess: Floats) -> tuple[Affine, Mask]:
    """Time until the membrane is met, and whether it surely is at one time in a tube about a linear prediction."""
    start = exact(np.nan_to_num(guess))
    sine, cosine = way.waves(start)
    distance, speed = way.missed(start, cosine, far), way.speed(start, sine).centre
    # dt/dp = -(dy/dp)/y': the tube goes along with the set, and need only hold what bends.
    middle = Affine(start.centre - distance.centre / speed, -distance.linear / speed, np.zeros(len(guess)))
    missed = way.missed(middle, way.waves(middle)[1], far)
    size = (np.abs(missed.centre) + missed.reach) * (1 + AFFINE_ROUNDING)
    width = WIDER * size / np.abs(speed) + THINNEST
    linear = middle.linear.copy()
    linear[TIME] += width
    tube = Affine(middle.centre, linear, middle.radius)
    speeds = way.speed(tube, way.waves(tube)[0])
    met = size < width * np.where(far, speeds.lower, -speeds.upper)
    # Where the flight is followed from within the tube on, the end is not before: the ball is between the membranes.
    met &= (middle - way.sets.since).lower + width > 0
    return _forgotten(middle - missed / speeds), met


def _forgotten(x: Affine) -> Affine:
    """The number, with what depends on time as a part of its rest."""
    linear = x.linear.copy()
    rest, linear[TIME] = np.abs(x.linear[TIME]), 0.0
    return Affine(x.centre, linear, x.radius + rest)


def _free(way: _Flights, far: Mask, duration: Affine) -> Mask:
    """Whether the ball surely meets no membrane before the end of its flight.

    The flight is cut into parts, and those are halved that are open. Next to a membrane, where the distance is zero at
    one end, the sign of the velocity settles it, or that of the acceleration: what is convex is above its tangent.
    """
    count, parts = len(far), 1
    free, since = np.ones(count, dtype=bool), way.sets.since
    leaves = way.speed(since, way.waves(since)[0]).lower > 0
    row, place = np.arange(count), np.zeros(count, dtype=np.intp)
    # The whole first: just before its end a shock leaves the ball next to the membrane that it is about to meet.
    for into in (PARTS, *(2,) * HALVINGS):
        part, since = way[row], way.sets.since[row]
        time = since + (duration[row] - since) * between(place / parts, (place + 1) / parts, TIME, SYMBOLS)
        sine, cosine = part.waves(time)
        covered, speed, bend = part.covered(time, cosine), part.speed(time, sine), part.groups.pull(cosine) * part.away
        left = -covered + part.groups.d
        first, last, across = place == 0, place == parts - 1, far[row]
        rising, falling = speed.lower > 0, speed.upper < 0
        clear = (covered.lower > 0) | (first & (rising | (leaves[row] & (bend.lower > 0))))
        clear |= last & ~across & (falling | (bend.lower > 0))
        beyond = (left.lower > 0) | (first & falling) | (last & across & (rising | (bend.upper < 0)))
        free[row[(covered.upper < 0) | (left.upper < 0)]] = False
        still = ~(clear & beyond) & free[row]
        row, place = np.repeat(row[still], into), (into * place[still, None] + np.arange(into)).ravel()
        parts *= into
        if not row.size:
            return free
    free[row] = False
    return free


def simulated(groups: Groups[float], rows: Floats, compiled: bool) -> Floats:
    """Where flights end by the simulation: the membrane met, 0 for none, and the time until then, (k, 2).

    Parameters
    ----------
    groups : Groups
    rows : ndarray (k, 4)
        Of `check_start`.
    compiled : bool
        Whether to compile the search, where numba is there.
    """
    found, summary = follow_impacts(np.repeat(check_model(groups), len(rows), axis=0), rows, 1, 1, compiled=compiled)
    last = found[:, -1]
    return np.stack([np.where(summary[:, 0] == 1, last[:, WALL], 0.0), last[:, FLIGHT]], axis=1)


def middles(groups: Groups[float], sets: Sets) -> Floats:
    """The middle of each set that begins at an impact, as a row of `check_start`, (k, 4)."""
    rows = np.zeros((len(sets), 4))
    rows[:, 0] = sets.wall
    # A start on a membrane is given by the velocity just before the impact.
    rows[:, 2] = -sets.after.centre / restitutions(groups, sets.wall)
    rows[:, 3] = np.mod(pi * sets.time.centre, TURN) % TURN
    return rows
