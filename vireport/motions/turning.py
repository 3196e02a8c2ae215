"""Turning points of the ball in its flights, which say whether a solution of the equations is a motion.

The conditions of a motion are about the ends of each flight only: between them the ball may pass through a membrane.
The turning points are the zeros of Z', and Z' is monotone between the zeros of Z'' = gbar + cos(phase), which have a
closed form. So every turning point is certain to be located, without sampling: `turning_points` for arrays of flights,
`turns` for one motion in Python's numbers, with which a motion is followed ten times as fast. A ball with friction must
not turn at all: `slowest` and `slow_places` have its least speed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import acos, cos, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.motions.orbits import Orbits
from vireport.motions.roots import newton_root
from vireport.physics import flight
from vireport.physics.flight import Flight
from vireport.physics.forcing import Harmonic, force_rate, unaccelerated, unaccelerated_by, wave
from vireport.physics.groups import Groups, Restitution, by_wall
from vireport.physics.motion import Motion
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

SMALLEST_STEP = 1e-6
"""Newton step [t_c] that ends the search for a turning point: the error of the time goes with its square and, as Z' is
zero there, the error of the position with its fourth power."""

BISECTIONS = 60
"""Largest number of bracketed Newton steps; they settle within ten, and bisection alone in sixty."""

SHORT = 1e-3
"""Time since the impact [t_c] below which a touch of the membrane left is taken from the expansion of the flight in
time: in doubles the distance covered so soon is lost against the length of the capsule."""

SETTLED = 1e-8
"""Newton step [t_c] that ends the search for a turning point of one motion, which is solved for afterwards."""


class Turns(Struct, frozen=True, eq=False):
    """Turning points in an array of flights.

    Attributes
    ----------
    index : ndarray of int
        Number of the flight; a flight that turns several times has several entries.
    time : ndarray
        Since the flight began [t_c].
    covered, room : ndarray
        Distance from the membrane left, and to the other one [x_c]; negative beyond it.
    back : ndarray of bool
        Whether the ball turns back towards the membrane left, rather than away from it again.
    """

    index: Ints
    time: Floats
    covered: Floats
    room: Floats
    back: NDArray[np.bool_]

    @property
    def gap(self) -> Floats:
        """Distance to the membrane that the ball turns back from [x_c]; negative beyond it."""
        return np.where(self.back, self.room, self.covered)


class ForcedFlights(Struct, frozen=True, eq=False):
    """Flights of one direction with the force during them.

    Attributes
    ----------
    way : Flight
        Arrays of one length.
    phase : ndarray
        Forcing phase at the beginning of each [rad].
    harmonics : sequence of Harmonic
        Harmonics of the force.
    """

    way: Flight
    phase: Floats
    harmonics: Sequence[Harmonic] = ()

    def select(self, index: Any) -> ForcedFlights:
        """The flights picked by an index or mask."""
        return ForcedFlights(self.way.select(index), self.phase[index], self.harmonics)

    def speed(self, time: Floats) -> Floats:
        """Velocity away from the membrane left, at times since the beginning of each flight [y_c]."""
        phase = self.phase + np.pi * time
        # Of a sine the impulse is the sine of the phase itself: its cosine need not be computed.
        impulse = wave(np.sin(phase), np.cos(phase), self.harmonics).impulse if self.harmonics else np.sin(phase)
        return np.asarray(self.way.speed(time, impulse))

    def covered(self, time: Floats) -> Floats:
        """Distance from the membrane left, at times since the beginning of each flight [x_c]."""
        phase = self.phase + np.pi * time
        path = wave(np.sin(phase), np.cos(phase), self.harmonics).path if self.harmonics else np.cos(phase)
        return np.asarray(self.way.covered(time, path))


def turning_points(
    flights: ForcedFlights, returns: bool, nearest: bool = False, settled: float = SMALLEST_STEP
) -> Iterator[Turns]:
    """Locate every turning point of flights, or those that can be the `nearest` to a membrane.

    Parameters
    ----------
    flights : ForcedFlights
    returns : bool
        Whether the flights come back to the membrane that they left.
    nearest : bool
        In flights from one membrane to the other, only the turning points that can be nearest to a membrane.
    settled : float
        Newton step that ends the search for a turning point [t_c].

    Yields
    ------
    Turns
        In no order of time.
    """
    if flights.harmonics:
        brackets = _between(flights, _unaccelerated(flights.way.gbar, flights.harmonics))
    else:
        brackets = _returning(flights) if returns else _crossing(flights, nearest)
    for bracket in brackets:
        if bracket.which.size:
            part = flights.select(bracket.which)
            time = _turning_times(part, bracket, settled)
            covered = part.covered(time)
            yield Turns(bracket.which, time, covered, part.way.d - covered, bracket.back)


class TurnBrackets(NamedTuple):
    """Times between which flights turn once, as arrays of one length.

    Attributes
    ----------
    which : ndarray of int
        Numbers of the flights.
    low, high : ndarray
        Since the beginning of each flight [t_c].
    guess : ndarray
        Guess at the time when the flight turns [t_c]; it may be outside.
    back : ndarray of bool
        Whether the ball turns back towards the membrane left.
    """

    which: Ints
    low: Floats
    high: Floats
    guess: Floats
    back: NDArray[np.bool_]


def _crossing(flights: ForcedFlights, nearest: bool) -> Iterator[TurnBrackets]:
    """Bracket the turning points of flights from one membrane to the other.

    A flight leaves one wall and arrives at the other with velocities of the same sign, so Z' can only change sign
    in pairs, around an extremum of Z' of the other sign: where Z' is positive at such an extremum of an upward
    flight (or negative in a downward one), there is exactly one zero on either side. The other extrema need not be
    looked at, which is half of the work.
    """
    way, phase = flights.way, flights.phase
    # Z' is largest at phase `turn`, the wrong way for an upward flight, and smallest at -turn, for a downward one.
    # Where gbar > 1, Z'' never vanishes; then Z' is not of the wrong sign at phase pi either.
    turn = np.arccos(np.clip(-way.gbar, -1.0, 1.0))
    rise, fall = 2 * turn / np.pi, 2 - 2 * turn / np.pi
    since, until = (rise, fall) if way.direction < 0 else (fall, rise)
    first, laps = np.mod(-way.direction * turn - phase, 2 * np.pi) / np.pi, _laps(way)
    parts = []
    for time in (first + 2 * lap for lap in range(laps)):
        # Of all flights, as to select those that last so long takes longer.
        slowest = np.where(time < way.duration, flights.speed(time), 0.0)
        wrong = np.flatnonzero(slowest < 0)
        parts.append((wrong, time[wrong], slowest[wrong]))
    index, middle, speed = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    if nearest and laps > 2:
        near = _may_be_nearest(flights, index, middle, -speed * np.maximum(since, until)[index])
        index, middle, speed = index[near], middle[near], speed[near]
    # Next to its extremum Z' is a parabola, of which the size of the second derivative is pi sin(turn).
    with np.errstate(divide="ignore"):
        apart = np.sqrt(-2 * speed / (np.pi * np.sin(turn[index])))
    within = np.ones(len(index), dtype=bool)
    yield TurnBrackets(index, np.maximum(middle - since[index], 0.0), middle, middle - apart, within)
    end = np.minimum(middle + until[index], way.duration[index])
    yield TurnBrackets(index, middle, end, middle + apart, ~within)


def _laps(way: Flight) -> int:
    """Forcing periods that the longest flight touches: it has fewer extrema of Z' of either kind. NaN are ignored."""
    return int(np.ceil(np.fmax.reduce(way.duration, initial=0.0) / 2)) + 1


def _may_be_nearest(flights: ForcedFlights, index: Ints, middle: Floats, reach: Floats) -> NDArray[np.bool_]:
    """Whether the turning point nearest to a wall may be next to each of some times of slowest flight.

    One of the two turning points is nearer to a wall than the ball is in the middle between them, but by no more than
    `reach`.

    Parameters
    ----------
    flights : ForcedFlights
    index : ndarray of int
        The flight of each time.
    middle : ndarray
        Times at which the ball flies back fastest, since the beginning of the flight [t_c].
    reach : ndarray
        The speed then times the longest time for which the ball can fly back [x_c].
    """
    part = flights.select(index)
    covered = part.covered(middle)
    room = np.minimum(covered, part.way.d - covered)
    least = np.full(len(flights.phase), np.inf)
    np.minimum.at(least, index, room)
    return np.asarray(room - reach <= least[index])


def _returning(flights: ForcedFlights) -> Iterator[TurnBrackets]:
    """Bracket the turning points of flights back to the membrane that they left, between extrema of Z'."""
    # Here Z' has the other sign at the end than at the start: it changes sign an odd number of times, and the pairs of
    # `_crossing` are no help. Between extrema, ends included, Z' is monotone.
    turn = np.arccos(np.clip(-flights.way.gbar, -1.0, 1.0))
    yield from _between(flights, np.stack([turn, -turn]))


def _between(flights: ForcedFlights, still: Floats) -> Iterator[TurnBrackets]:
    """Bracket the turning points of flights between phases of zero acceleration.

    Parameters
    ----------
    flights : ForcedFlights
    still : ndarray (m, n)
        Phases at which Z'' is zero [rad], a column for each of the n flights; NaN where it has fewer than m.
    """
    way, phase = flights.way, flights.phase
    extrema = np.mod(still - phase, 2 * np.pi) / np.pi
    laps = np.repeat(2 * np.arange(_laps(way)), len(still))
    moments = np.tile(np.sort(extrema, axis=0), (_laps(way), 1)) + laps[:, None]
    # Where there are fewer phases than of others, the end of the flight stands for the rest: it belongs after them all.
    times = np.sort(np.fmin(moments, way.duration), axis=0)
    times = np.concatenate([np.zeros((1, len(phase))), times, way.duration[None]])
    speeds = flights.speed(times)
    if flights.harmonics:
        # Without restitution a flight begins at rest: what rounding makes of that is no turn.
        speeds[0] = way.direction * way.velocity
    piece, index = np.nonzero(speeds[:-1] * speeds[1:] < 0)
    low, high = times[piece, index], times[piece + 1, index]
    yield TurnBrackets(index, low, high, (low + high) / 2, speeds[piece, index] > 0)


def _unaccelerated(gbar: Floats, harmonics: Sequence[Harmonic]) -> Floats:
    """The phases at which Z'' is zero, a column for each gbar; NaN in columns that have fewer than others."""
    different, which = np.unique(gbar, return_inverse=True)
    return unaccelerated_by(different, harmonics)[which.ravel()].T


def _turning_times(flights: ForcedFlights, bracket: TurnBrackets, settled: float) -> Floats:
    """Times at which a monotone Z' is zero, one in each bracket of the flights."""

    def speed(t: Floats, which: Ints) -> tuple[Floats, Floats]:
        part = flights if t.size == flights.phase.size else flights.select(which)
        angle = part.phase + np.pi * t
        force = wave(np.sin(angle), np.cos(angle), part.harmonics)
        return part.way.speed(t, force.impulse), part.way.pressing(force.force)

    # Newton, not secants: the slope, Z'', costs one cosine of an angle whose sine is needed anyway.
    return newton_root(speed, bracket.low, bracket.high, bracket.guess, ~bracket.back, settled)


def flight_turns(orbit: Orbits, flights: tuple[Flight, Flight], nearest: bool = False) -> Iterator[tuple[int, Turns]]:
    """The turning points of 1:1 motions, by the impact that begins the flight: 0 for the bottom, 1 for the top."""
    up, down = flights
    for part in turning_points(ForcedFlights(up, orbit.phi, orbit.harmonics), False, nearest):
        yield 0, part
    top = np.arctan2(orbit.sin_top, orbit.cos_top)
    for part in turning_points(ForcedFlights(down, top, orbit.harmonics), False, nearest):
        yield 1, part


def slowest(orbit: Orbits, r: Restitution) -> tuple[Floats, Ints]:
    """Least speed onward in the flights of 1:1 motions, and the impact (0 or 1) that begins that flight.

    The speed [y_c] is negative where the ball would move back in a flight: friction would then change its sign, so that
    this is not the motion that was solved for. Parameters are those of `wall_gap`.
    """
    top = np.arctan2(orbit.sin_top, orbit.cos_top)
    ends = np.abs(np.stack([orbit.velocity_bottom, orbit.velocity_top]))
    struck = np.stack(np.broadcast_arrays(*by_wall(r), ends[0])[:2]) * ends
    speeds = np.minimum(struck, ends[::-1])
    for i, (way, phase) in enumerate(zip(orbit.flights(r), (orbit.phi, top), strict=True)):
        flights = ForcedFlights(way, phase, orbit.harmonics)
        if orbit.harmonics:
            still = _unaccelerated(way.gbar, orbit.harmonics)
        else:
            still = -way.direction * np.arccos(np.clip(-way.gbar, -1.0, 1.0))[None]
        first = np.mod(still - phase, 2 * np.pi) / np.pi
        laps = 2 * np.arange(_laps(way))
        times = (first[None] + laps[:, None, None]).reshape(len(laps) * len(first), len(phase))
        speeds_at = flights.speed(times)
        inside = times < way.duration
        speeds[i] = np.minimum(speeds[i], np.where(inside, speeds_at, np.inf).min(axis=0, initial=np.inf))
    return speeds.min(axis=0), speeds.argmin(axis=0)


def wall_gap(orbit: Orbits, r: Restitution) -> Floats:
    """Smallest distance of the ball from a membrane at the turning points of 1:1 motions [x_c].

    Parameters
    ----------
    orbit : Orbits
        Arrays of motions with velocity_bottom > 0 > velocity_top.
    r : float or ndarray, or Restitutions
        Restitution coefficient.

    Returns
    -------
    ndarray
        Negative where the ball would have to pass through a membrane, zero at grazing, and d where it never turns back.
        With friction it is d too, or, where the ball would turn back, which is no motion, its least speed onward, <= 0.
    """
    if orbit.friction is not None:
        speed, _ = slowest(orbit, r)
        return np.where(speed > 0, orbit.d, speed)
    # d, where the ball never turns back: no turning point can be farther from both membranes.
    gap = np.array(orbit.d, dtype=float)
    for _, part in flight_turns(orbit, orbit.flights(r), nearest=True):
        np.minimum.at(gap.reshape(-1), part.index, np.minimum(part.covered, part.room))
    return gap


class Touch(NamedTuple):
    """A turning point near a wall: distance [x_c], flight time [t_c], whether upward, and whether at the wall left."""

    distance: float
    time: float
    upward: bool
    at_start: bool


def touches(orbit: Orbits, flights: tuple[Flight, Flight]) -> list[Touch]:
    """The turning points of one 1:1 motion (arrays of length one), for each wall, by ascending distance from it."""
    return sorted(
        Touch(abs(float(distance)), float(time), after == 0, at_start)
        for after, part in flight_turns(orbit, flights)
        for at_start, gap in ((True, part.covered), (False, part.room))
        for distance, time in zip(gap, part.time, strict=True)
    )


class NearTouch(NamedTuple):
    """The turning point of a motion that becomes a touch of a membrane at a grazing point next to it.

    Attributes
    ----------
    after : int
        The impact that begins its flight.
    at_start : bool
        Whether the membrane is the one that the flight left.
    time : float
        Since the flight began [t_c].
    acceleration : float or None
        Towards the membrane left, as the flight begins [-], if the touch follows at once (within `SHORT`); else None.
    """

    after: int
    at_start: bool
    time: float
    acceleration: float | None


def near_touch(motion: Motion, groups: Groups[float]) -> NearTouch:
    """The turning point of a motion that is nearest to a membrane.

    A ball that touches again shortly after an impact has v t = a t^2/2 + j t^3/6 and v = a t + j t^2/2, which give the
    acceleration a = (-8 j v/3)^(1/2) towards the wall that it leaves, and t = -3 a/(2 j).
    """
    walls, times = motion.word.walls, motion.time.tolist()
    nearest = min(turns(motion, groups), key=lambda turn: abs(turn.gap), default=None)
    if nearest is not None:
        since, at_start = nearest.time - times[nearest.after], nearest.wall == walls[nearest.after]
        if not (since < SHORT and at_start):
            return NearTouch(nearest.after, at_start, since, None)
    waves = [(sin(pi * t), cos(pi * t)) for t in times]
    pressed = [abs(groups.pull(wave(*at, groups.harmonics).force)) for at in waves]
    after = nearest.after if nearest is not None else pressed.index(min(pressed))
    jerk = -walls[after] * pi * force_rate(*waves[after], groups.harmonics)
    speed = abs(float(groups.after(walls[after], float(motion.velocity[after]))))
    acceleration = sqrt(max(8 * jerk * speed / 3, 0.0))
    return NearTouch(after, True, 1.5 * acceleration / jerk if acceleration else 0.0, acceleration)


class Turn(NamedTuple):
    """A turning point of the ball in one motion.

    Attributes
    ----------
    after : int
        The impact that begins its flight.
    time : float
        Time on the clock of the motion [t_c].
    wall : int
        The membrane that the ball turns back from: 1 bottom, -1 top.
    gap : float
        Distance from that membrane [x_c]; negative beyond it.
    held : bool
        Whether the ball has not left the membrane yet, which is no touch: with restitution zero it starts at rest, and
        turns at once if the membrane still presses it.
    """

    after: int
    time: float
    wall: int
    gap: float
    held: bool = False


def turns(motion: Motion, groups: Groups[float]) -> Iterator[Turn]:
    """Locate every turning point of a motion, in order of time."""
    d, gbar, _, harmonics, *_ = groups
    # Z'' is zero at the same times of each forcing period, of a sine at `lift` and 2 - `lift`, with the sine `swing`
    # and its opposite.
    if harmonics:
        still = [(x / pi, wave(sin(x), cos(x), harmonics).impulse) for x in unaccelerated(gbar, harmonics)]
    elif gbar < 1:
        lift = acos(-gbar) / pi
        swing = sin(pi * lift)
        still = [(lift, swing), (2 - lift, -swing)]
    else:
        still = []
    walls, times, velocities = motion.word.walls, motion.time.tolist(), motion.velocity.tolist()
    times.append(times[0] + 2 * motion.word.periods)
    velocities.append(velocities[0])
    for i, wall in enumerate(walls):
        start, end, after, phase = times[i], times[i + 1], groups.after(wall, velocities[i]), pi * times[i]
        begun = wave(sin(phase), cos(phase), harmonics)
        laps = range(2 * int(start // 2), 2 * int(end // 2) + 1, 2)
        inner = [(lap + t, impulse) for lap in laps for t, impulse in still if start < lap + t < end]
        speeds = [(t, flight.velocity(t - start, after, begun.impulse, impulse, gbar)) for t, impulse in inner]
        for low, high in pairwise([(start, after), *speeds, (end, velocities[i + 1])]):
            if low[1] * high[1] < 0:
                time = _turning_time(low, high, (start, after, begun.impulse), groups)
                towards = 1 if low[1] > 0 else -1
                # Distances are counted from the wall left, not from the middle of the capsule as Z is: half of a large
                # d would leave no digit of the gap.
                path = wave(sin(pi * time), cos(pi * time), harmonics).path if harmonics else cos(pi * time)
                way = flight.displacement(time - start, after, begun.impulse, begun.path, path, gbar)
                held = after == 0 and wall == towards and time - start < SHORT
                yield Turn(i, time, towards, (0.0 if wall == towards else d) - towards * way, held)


def _turning_time(
    low: tuple[float, float], high: tuple[float, float], begun: tuple[float, float, float], groups: Groups[float]
) -> float:
    """Time at which Z' is zero in a part of a flight in which it is monotone, to about `SETTLED` squared [t_c].

    Parameters
    ----------
    low, high : (float, float)
        Time [t_c] and Z' [y_c] at both ends of the part, at which Z' has different signs.
    begun : (float, float, float)
        Time [t_c], Z' [y_c] and impulse of the force [-] at the beginning of the flight.
    groups : Groups
    """
    start, after, impulse = begun
    (a, at_a), (b, at_b) = low, high
    # The first guess is exact for gbar = 0, where Z' is half a wave: Z' = A + B cos(pi s) over a share s of the way,
    # with A + B and A - B at the ends, vanishes at cos(pi s) = -A/B.
    t = a + (b - a) * acos((at_a + at_b) / (at_b - at_a)) / pi
    for _ in range(BISECTIONS):
        phase = pi * t
        force = wave(sin(phase), cos(phase), groups.harmonics)
        value = flight.velocity(t - start, after, impulse, force.impulse, groups.gbar)
        slope = groups.pull(force.force)
        # [a, b] always holds the zero, so that a Newton step that leaves it can be replaced by its middle.
        a, b = (a, t) if (value > 0) == (at_b > 0) else (t, b)
        new = t - value / slope if slope else a
        if abs(new - t) < SETTLED and slope:
            return new
        t = new if a < new < b else (a + b) / 2
    return t


class Slowest(NamedTuple):
    """An extremum of Z' in a flight: the impact that begins the flight, time [t_c], and speed onward then [y_c]."""

    after: int
    time: float
    speed: float


def slow_places(word: Word, velocity: Sequence[float], time: Sequence[float], groups: Groups[float]) -> list[Slowest]:
    """Every extremum of Z' in the flights of one motion, with the speed towards the other membrane then.

    Parameters
    ----------
    word : Word
        With impacts on both membranes in turn: the direction of each flight is that of its friction.
    velocity, time : sequence of float
        Of its impacts [y_c], [t_c].
    groups : Groups
        With friction.
    """
    places, count = [], len(word)
    for i, wall in enumerate(word.walls):
        j = (i + 1) % count
        start, end = time[i], time[j] + (0 if j > i else 2 * word.periods)
        way = (word.walls[j] - wall) // 2
        gravity, after = groups.gravity(way), groups.after(wall, velocity[i])
        impulse = groups.wave(pi * start, FLOATS).impulse
        if groups.harmonics:
            still = unaccelerated(gravity, groups.harmonics)
        else:
            still = (-way * acos(-gravity),) if abs(gravity) <= 1 else ()
        for phase in still:
            first = start + (phase / pi - start) % 2
            for lap in range(max(int((end - first) // 2) + 1, 0)):
                t = first + 2 * lap
                swing = groups.wave(pi * t, FLOATS).impulse
                places.append(Slowest(i, t, way * flight.velocity(t - start, after, impulse, swing, gravity)))
    return places
