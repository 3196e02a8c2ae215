"""Flights of sets of states in affine arithmetic: where each of them ends, proved for every state of a set.

A set is a parallelogram about a state just before an impact, or about the shocks of a range of moments and sizes. The
simulation of its middle is only a guess of where flights end. It is proved, all roundings included, that every state of
a set meets the same membrane, at a time that is enclosed to second order in the size of the set, and none before.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.physics import flight
from vireport.physics.affine import AFFINE, AFFINE_ROUNDING, Affine, between
from vireport.physics.groups import Groups
from vireport.simulation.events import check_model, follow_impacts
from vireport.simulation.kernel import FLIGHT, TURN, VELOCITY, WALL

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]

FIRST, SECOND, ERRORS, TIME = 0, 1, slice(2, 4), 4
"""Noise symbols of the affine numbers of a set: of its two coordinates, two of the errors that its rounding up to a
parallelogram has collected, and one of time within a flight."""

SYMBOLS = 5

WIDER = 2.0
"""Width of the tube in which the end of a flight is looked for, over the largest Newton correction in its middle."""

THINNEST = 1e-13
"""Least width of that tube, of the size of rounding."""

PARTS, HALVINGS = 6, 5
"""Parts of a flight, and how often one is halved before it is left open whether the ball meets a membrane there."""

SLOW, LONGEST_TOUCH, MISSED_BY = 0.3, 0.3, 1e-9
"""Largest velocity [y_c] of an impact of which neighbours may miss the membrane, largest time [t_c] until they would
turn, and the distance from the membrane at which they are then thought to turn, over the half length."""


class Sets(Struct, frozen=True, eq=False):
    """Sets of states that begin flights, k in all.

    Attributes
    ----------
    wall : ndarray of int (k,)
        The membrane that is left: 1 bottom, -1 top.
    time : Affine
        Of the impact there [t_c]; the forcing phase is pi times it.
    after : Affine
        Relative velocity just after it [y_c], away from the membrane.
    offset : Affine
        Distance from the membrane at which the flight begins [x_c]: 0 but for a shock, after which the ball flies as if
        it had left from elsewhere with another velocity.
    since : Affine
        Time after the impact from which on the flight is followed [t_c]: 0, or that of the shock.
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


class ImpactSets(Struct, frozen=True, eq=False):
    """Sets of states just before impacts, k in all.

    Attributes
    ----------
    proved : ndarray of bool (k,)
        Whether all states of the set that began the flights come there, with no impact in between; else the other
        fields are undefined.
    wall : ndarray of int (k,)
        The membrane that is struck: 1 bottom, -1 top.
    time, velocity : Affine
        Time by the clock of the impact before [t_c], and velocity just before the impact [y_c].
    duration : Affine
        Time since the impact before [t_c].
    """

    proved: Mask
    wall: Ints
    time: Affine
    velocity: Affine
    duration: Affine

    def __getitem__(self, rows: Any) -> ImpactSets:
        return ImpactSets(*(getattr(self, name)[rows] for name in self.__struct_fields__))


def joined(parts: Sequence[ImpactSets]) -> ImpactSets:
    """Several arrays of sets as one, in their order."""
    columns = zip(*([getattr(part, name) for name in ImpactSets.__struct_fields__] for part in parts), strict=True)
    return ImpactSets(*(_concatenated(list(column)) for column in columns))


def _concatenated(parts: list[Any]) -> Any:
    if not isinstance(parts[0], Affine):
        return np.concatenate(parts)
    linear = np.concatenate([part.linear for part in parts], axis=1)
    return Affine(np.concatenate([x.centre for x in parts]), linear, np.concatenate([x.radius for x in parts]))


def exact(value: Floats) -> Affine:
    """Doubles (k,) as affine numbers without any error."""
    return Affine(value, np.zeros((SYMBOLS, len(value))), np.zeros(len(value)))


def enclosed(groups: Groups[float]) -> Groups[Any]:
    """Groups as affine numbers that enclose the exact ones, from doubles that a dozen roundings may have changed.

    The restitution is a number of the scenario, and so exact.
    """
    d, gbar = exact(np.array([groups.d])), exact(np.array([groups.gbar]))
    d.radius[:], gbar.radius[:] = AFFINE_ROUNDING * groups.d, AFFINE_ROUNDING * groups.gbar
    return Groups(d, gbar, groups.restitution)


def restitutions(groups: Groups[Any], wall: Ints) -> Floats:
    """Restitution coefficients at membranes (k,), 1 bottom and -1 top."""
    return np.asarray(np.where(wall > 0, groups.restitution_at(1), groups.restitution_at(-1)), dtype=float)


def after_impact(groups: Groups[Any], impacts: ImpactSets, rows: Any) -> Sets:
    """Sets of states just after impacts, with which the next flights begin, for some rows of the impacts."""
    wall, count = impacts.wall[rows], len(impacts.wall[rows])
    time, velocity = merged(impacts.time[rows], impacts.velocity[rows])
    # Whole periods are subtracted: the rounding of pi times the time would grow with the time.
    time = time - 2.0 * np.floor(time.centre / 2)
    return Sets(wall, time, velocity * -restitutions(groups, wall), exact(np.zeros(count)), exact(np.zeros(count)))


def merged(time: Affine, velocity: Affine) -> tuple[Affine, Affine]:
    """Enclosures of sets in which all errors are in the two symbols `ERRORS`: a rectangle instead of a zonotope.

    Lohner's method: the rectangle has the axes of the longest error, as a box along time and velocity would grow with
    each flight (the wrapping effect).

    Parameters
    ----------
    time, velocity : Affine (k,)

    Returns
    -------
    time, velocity : Affine (k,)
        Without radius.
    """
    spread = np.stack([time.linear[ERRORS], velocity.linear[ERRORS]])  # coordinate, symbol, set
    rest = np.stack([time.radius, velocity.radius])
    size = np.hypot(spread[0], spread[1])
    longest = spread[:, np.argmax(size, axis=0), np.arange(spread.shape[2])]
    largest = size.max(axis=0)
    axis = np.where(largest > 0, longest / np.where(largest > 0, largest, 1.0), [[1.0], [0.0]])
    axes = np.stack([axis, np.stack([-axis[1], axis[0]])])  # axis, coordinate, set: orthogonal to rounding
    reach = np.abs(np.einsum("ack,cek->aek", axes, spread)).sum(axis=1) + np.einsum("ack,ck->ak", np.abs(axes), rest)
    reach += AFFINE_ROUNDING * (np.abs(spread).sum(axis=(0, 1)) + rest.sum(axis=0)) + 1e-300
    linear = [time.linear.copy(), velocity.linear.copy()]
    for coordinate, columns in enumerate(linear):
        columns[ERRORS] = axes[:, coordinate] * reach
    count = np.zeros(len(time.centre))
    return Affine(time.centre, linear[0], count), Affine(velocity.centre, linear[1], count)


class _Flights(Struct, frozen=True, eq=False):
    """Flights of sets of states, (2.11) and (2.12) in affine arithmetic.

    Attributes
    ----------
    sets : Sets
        The states with which the flights begin.
    groups : Groups of Affine
    sine, cosine : Affine (k,)
        Of the forcing phase at the impact with which the flights begin.
    """

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
        """Distance covered less that of the membrane at the end, which is the other one where `far`."""
        target: Affine = self.groups.d * far.astype(float)
        return self.covered(t, cosine) - target


def next_impacts(groups: Groups[Any], sets: Sets, guesses: Floats) -> ImpactSets:
    """Follow sets to their next impacts.

    Parameters
    ----------
    groups : Groups of Affine
        Of the device, see `enclosed`.
    sets : Sets
    guesses : ndarray (k, 3)
        For the middle of each set the membrane that it meets, the time after `since`, the velocity, see `simulated`.
    """
    way, at = _ends(groups, sets, guesses)
    rows = np.flatnonzero(at.proved)
    if rows.size:
        at.proved[rows] = _touches(way[rows], at.wall[rows] != sets.wall[rows], at.duration[rows]).surely_free
    return at


@np.errstate(all="ignore")
def impacts_past_a_touch(groups: Groups[Any], sets: Sets, guesses: Floats) -> tuple[Ints, ImpactSets, ImpactSets]:
    """Follow sets of which some states touch a membrane and others do not: each kind separately.

    Parameters
    ----------
    groups : Groups of Affine
    sets : Sets
    guesses : ndarray (k, 3)
        Ends of the flights as if no membrane were touched, see `simulated_past`.

    Returns
    -------
    rows : ndarray of int
        The sets for which both kinds are proved to be enclosed.
    past, touching : ImpactSets
        For these sets the next impacts of the states that do not touch, and the touches: all times and velocities that
        they may have.
    """
    way, past = _ends(groups, sets, guesses)
    rows = np.flatnonzero(past.proved)
    if not rows.size:
        return rows, past[rows], past[rows]
    touch = _touches(way[rows], past.wall[rows] != sets.wall[rows], past.duration[rows])
    # One membrane only, and not at an end of the flight: else touches cannot be told from the other impacts.
    once = (touch.near != touch.far) & (touch.first > 0) & (touch.last < 1) & ~touch.beyond
    rows, touch = rows[once], _Touches(*(column[once] for column in touch))
    flights, since = way[rows], sets.since[rows]
    passed = since + (past.duration[rows] - since) * between(touch.first, touch.last, TIME, SYMBOLS)
    speed = flights.speed(passed, flights.waves(passed)[0])
    # A touch is an impact with a velocity between zero and the largest in that time: a better bound is not needed, as
    # the ball leaves as slowly.
    fastest = np.maximum(np.where(touch.far, speed.upper, -speed.lower), 0.0)
    wall = np.where(touch.far, -sets.wall[rows], sets.wall[rows])
    linear, size = np.zeros((SYMBOLS, len(rows))), fastest / 2
    struck = Affine(wall * size, linear, size * (1 + AFFINE_ROUNDING))
    proved = np.ones(len(rows), dtype=bool)
    return rows, past[rows], ImpactSets(proved, wall, _forgotten(sets.time[rows] + passed), struck, _forgotten(passed))


@np.errstate(all="ignore")  # what is not defined is not finite, and proves nothing
def _ends(groups: Groups[Any], sets: Sets, guesses: Floats) -> tuple[_Flights, ImpactSets]:
    """Flights of sets and the impacts that end them, as if no membrane were on the way; `proved` of the ends only."""
    phase = AFFINE.pi * sets.time
    way = _Flights(sets, groups, AFFINE.sin(phase), AFFINE.cos(phase))
    wall = np.where(guesses[:, 0] > 0, 1, -1)
    far = wall != sets.wall
    duration, ends = _duration(way, far, sets.since.centre + guesses[:, 1])
    ends &= guesses[:, 0] != 0
    # All states must cross the membrane outwards; where some graze it, the flights of the others do not end there.
    speed = _forgotten(way.speed(duration, way.waves(duration)[0]))
    ends &= np.where(far, speed.lower > 0, speed.upper < 0)
    return way, ImpactSets(ends, wall, sets.time + duration, speed * way.away, duration)


def _duration(way: _Flights, far: Mask, guess: Floats) -> tuple[Affine, Mask]:
    """Time of flight to a membrane, enclosed, and whether every state of the set surely meets it once in that time.

    An interval Newton step: in a tube about the linear prediction of the time, in which the velocity is not zero, the
    distance from the membrane has exactly one zero if a Newton step from the middle of the tube stays inside it.
    """
    start = exact(np.nan_to_num(guess))
    sine, cosine = way.waves(start)
    distance, speed = way.missed(start, cosine, far), way.speed(start, sine).centre
    # dt/dp = -(dy/dp)/y': the tube follows the set to first order, and need only hold the curvature.
    middle = Affine(start.centre - distance.centre / speed, -distance.linear / speed, np.zeros(len(guess)))
    missed = way.missed(middle, way.waves(middle)[1], far)
    size = (np.abs(missed.centre) + missed.reach) * (1 + AFFINE_ROUNDING)
    width = WIDER * size / np.abs(speed) + THINNEST
    linear = middle.linear.copy()
    linear[TIME] += width
    tube = Affine(middle.centre, linear, middle.radius)
    speeds = way.speed(tube, way.waves(tube)[0])
    proved = size < width * np.where(far, speeds.lower, -speeds.upper)
    # Where the flight is followed from a time within the tube, its end is later: the ball is between the membranes.
    proved &= (middle - way.sets.since).lower + width > 0
    return _forgotten(middle - missed / speeds), proved


def _forgotten(x: Affine) -> Affine:
    """An affine number whose dependence on the time symbol is made a part of its radius."""
    linear = x.linear.copy()
    rest, linear[TIME] = np.abs(x.linear[TIME]), 0.0
    return Affine(x.centre, linear, x.radius + rest)


class _Touches(NamedTuple):
    """Parts of flights in which the ball may meet a membrane before their ends, arrays (k,).

    Attributes
    ----------
    near, far : ndarray of bool
        Whether the membrane that was left may be met, and the other one.
    beyond : ndarray of bool
        Whether all states of a set are beyond a membrane at some time.
    first, last : ndarray
        Ends of the parts, as shares of the flight.
    """

    near: Mask
    far: Mask
    beyond: Mask
    first: Floats
    last: Floats

    @property
    def surely_free(self) -> Mask:
        """Which flights surely meet no membrane before their ends."""
        return ~(self.near | self.far | self.beyond)


@np.errstate(all="ignore")
def _touches(way: _Flights, far: Mask, duration: Affine) -> _Touches:
    """Find the parts of flights in which it is not ruled out that the ball meets a membrane before the end.

    The flight is cut into parts, and open ones are halved. Next to a membrane, where the distance is zero at one end,
    the sign of the velocity decides, or that of the acceleration: a convex function is above its tangent.
    """
    count, parts, since = len(far), 1, way.sets.since
    near, opposite, beyond = np.zeros((3, count), dtype=bool)
    touch = _Touches(near, opposite, beyond, np.full(count, np.inf), np.full(count, -np.inf))
    # The ball never leaves a membrane with a velocity towards it; after a shock it may have any velocity.
    leaves = (since.reach == 0) | (way.speed(since, way.waves(since)[0]).lower > 0)
    row, place = np.arange(count), np.zeros(count, dtype=np.intp)
    # First the whole flight: just before its end, a shock leaves the ball next to the membrane that it is to meet.
    for into in (PARTS, *(2,) * HALVINGS, 0):
        part, since = way[row], way.sets.since[row]
        time = since + (duration[row] - since) * between(place / parts, (place + 1) / parts, TIME, SYMBOLS)
        sine, cosine = part.waves(time)
        covered, speed = part.covered(time, cosine), part.speed(time, sine)
        left, bend = -covered + part.groups.d, part.groups.pull(cosine) * part.away
        first, last, across = place == 0, place == parts - 1, far[row]
        rising, falling = speed.lower > 0, speed.upper < 0
        # Clear of the membrane left: above zero all the time, or rising from it at first, or falling to it at last.
        clear = (covered.lower > 0) | (first & (rising | (leaves[row] & (bend.lower > 0))))
        clear |= last & ~across & (falling | (bend.lower > 0))
        # Short of the other membrane, likewise.
        short = (left.lower > 0) | (first & falling) | (last & across & (rising | (bend.upper < 0)))
        touch.beyond[row[(covered.upper < 0) | (left.upper < 0)]] = True
        still = ~(clear & short) & ~touch.beyond[row]
        if not into or not still.any():
            break
        row, place = np.repeat(row[still], into), (into * place[still, None] + np.arange(into)).ravel()
        parts *= into
    touch.near[row[still & ~clear]] = touch.far[row[still & ~short]] = True
    np.minimum.at(touch.first, row[still], place[still] / parts)
    np.maximum.at(touch.last, row[still], (place[still] + 1) / parts)
    return touch


def simulated(groups: Groups[float], rows: Floats, compiled: bool) -> Floats:
    """Ends of flights by the simulation, (k, 3): membrane, 0 for none; flight time [t_c]; velocity before [y_c].

    Parameters
    ----------
    groups : Groups
    rows : ndarray (k, 4)
        Of `check_start`.
    compiled : bool
        Whether to compile the search, where numba is there.
    """
    impacts, summary = follow_impacts(np.repeat(check_model(groups), len(rows), axis=0), rows, 1, 1, compiled=compiled)
    last = impacts[:, -1]
    return np.stack([np.where(summary[:, 0] == 1, last[:, WALL], 0.0), last[:, FLIGHT], last[:, VELOCITY]], axis=1)


def simulated_past(groups: Groups[float], sets: Sets, guesses: Floats, compiled: bool) -> Floats:
    """Simulated next impacts as if middles that strike a membrane slowly had just missed it.

    Parameters and result are as of `simulated`; `guesses` are its result.
    """
    wall, time, velocity = guesses.T
    phase = pi * (sets.time.centre + sets.since.centre + time)
    # A ball that just misses turns after about |v/Z''|: from there, next to the membrane and at rest, it flies on.
    turn = np.abs(velocity) / np.abs(groups.pull(np.cos(phase)))
    slow = np.flatnonzero((wall != 0) & (np.abs(velocity) < SLOW) & (turn < LONGEST_TOUCH))
    rows = np.zeros((len(slow), 4))
    rows[:, 1] = wall[slow] * groups.d / 2 * (1 - MISSED_BY)
    rows[:, 3] = np.mod(phase[slow] + pi * turn[slow], TURN) % TURN
    past = guesses.copy()
    past[slow] = simulated(groups, rows, compiled)
    past[slow, 1] += time[slow] + turn[slow]
    return past


def middles(groups: Groups[float], sets: Sets) -> Floats:
    """The middle of each set that begins at an impact, as a row of `check_start`, (k, 4)."""
    rows = np.zeros((len(sets), 4))
    rows[:, 0] = sets.wall
    # A start on a membrane is given by the velocity just before the impact.
    rows[:, 2] = -sets.after.centre / restitutions(groups, sets.wall)
    rows[:, 3] = np.mod(pi * sets.time.centre, TURN) % TURN
    return rows
