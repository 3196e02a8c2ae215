"""Where the ball turns in its flights: whether a solution of the equations is a motion.

The conditions of a motion only know the ends of each flight. The turning points between are the zeros of Z', and Z' is
monotone between the zeros of Z'' = gbar + cos(phase), which have a closed form. So every turning point is certain to be
located, without sampling: `turning_points` for arrays of flights, `turns` for one motion in Python's numbers, with
which a motion is followed ten times as fast.
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
from vireport.physics.groups import Groups, by_wall
from vireport.physics.motion import Motion
from vireport.physics.numbers import FLOATS
from vireport.physics.word import Word

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

SMALLEST_STEP = 1e-10
"""Newton step [t_c] that ends the search for a turning point: with Z' zero there, the position moves by its square."""

BISECTIONS = 60
"""Steps of a bracketed Newton iteration; it settles within ten, and bisection alone in sixty."""

SHORT = 1e-3
"""Time since the impact [t_c], below which a touch is a ball that comes back before it has left. It comes from its
expansion, for in doubles the distance covered is lost against the length of the capsule."""

SETTLED = 1e-8
"""Newton step [t_c] that ends the search for a turning point of one motion, which is solved for afterwards."""


class Turns(Struct, frozen=True, eq=False):
    """Turning points of one flight of each of some motions, some of them.

    Attributes
    ----------
    index : ndarray of int
        Which of the motions; one that turns several times is there as often.
    time : ndarray
        Since the flight began [t_c].
    covered, room : ndarray
        Distance from the membrane left, and to the other one; negative beyond it.
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
        """Distance to the membrane that the ball turns back from."""
        return np.where(self.back, self.room, self.covered)


def turning_points(
    way: Flight,
    phase: Floats,
    returns: bool,
    nearest: bool = False,
    settled: float = SMALLEST_STEP,
    harmonics: Sequence[Harmonic] = (),
) -> Iterator[Turns]:
    """Every turning point of one flight of each motion, or those that can be the `nearest` to a membrane.

    Parameters
    ----------
    way : Flight
        Arrays of one length.
    phase : ndarray
        Forcing phase at which each begins [rad].
    returns : bool
        Whether the flights come back to the membrane that they left.
    nearest : bool
        Of flights across, only what can be nearest to a membrane.
    settled : float
        Newton step that ends the search for a turning point [t_c].
    harmonics : sequence of Harmonic
        Of the force.
    """
    if harmonics:
        brackets = _between(way, phase, _unaccelerated(way.gbar, harmonics), harmonics)
    else:
        brackets = _returning(way, phase) if returns else _crossing(way, phase, nearest)
    for index, low, high, back in brackets:
        if index.size:
            part, start = way.select(index), phase[index]
            time = _at_rest(part, start, low, high, settled, harmonics)
            covered = part.covered(time, _path(start + np.pi * time, harmonics))
            yield Turns(index, time, covered, part.d - covered, back)


Brackets = Iterator[tuple[Ints, Floats, Floats, NDArray[np.bool_]]]
"""Flights, two times between which each turns once, and whether it turns back towards the membrane left."""


def _crossing(way: Flight, phase: Floats, nearest: bool) -> Brackets:
    """Turning points of flights from one membrane to the other.

    A flight leaves one wall and arrives at the other with velocities of the same sign, so Z' can only change sign
    in pairs, around an extremum of Z' of the other sign: where Z' is positive at such an extremum of an upward
    flight (or negative in a downward one), there is exactly one zero on either side. The other extrema need not be
    looked at, which is half of the work.
    """
    # Z' is largest at phase `turn`, the wrong way for an upward flight, and smallest at -turn, for a downward one.
    # Where gbar > 1, Z'' never vanishes; then Z' is not of the wrong sign at phase pi either.
    turn = np.arccos(np.clip(-way.gbar, -1.0, 1.0))
    rise, fall = 2 * turn / np.pi, 2 - 2 * turn / np.pi
    since, until = (rise, fall) if way.direction < 0 else (fall, rise)
    first = np.mod(-way.direction * turn - phase, 2 * np.pi) / np.pi
    times = first[:, None] + 2 * np.arange(_laps(way))
    index, lap = np.nonzero(times < way.duration[:, None])
    slowest = times[index, lap]
    speed = way.select(index).speed(slowest, np.sin(phase[index] + np.pi * slowest))
    wrong = speed < 0
    index, middle, speed = index[wrong], slowest[wrong], speed[wrong]
    if nearest and times.shape[1] > 2:
        near = _may_be_nearest(way, phase, index, middle, -speed * np.maximum(since, until)[index])
        index, middle = index[near], middle[near]
    within = np.ones(len(index), dtype=bool)
    yield index, np.maximum(middle - since[index], 0.0), middle, within
    yield index, middle, np.minimum(middle + until[index], way.duration[index]), ~within


def _laps(way: Flight) -> int:
    """More than the extrema of Z' of one kind in any of the flights; NaN are left out."""
    return int(np.ceil(np.fmax.reduce(way.duration, initial=0.0) / 2)) + 1


def _may_be_nearest(way: Flight, phase: Floats, index: Ints, middle: Floats, reach: Floats) -> NDArray[np.bool_]:
    """Which times of slowest flight have next to them the turning point that is nearest to a wall, or may have it.

    One of the two turning points is nearer to a wall than the ball is in the middle between them, but by no more than
    what it flies back from there: `reach`, its speed there times the time that it has.
    """
    part = way.select(index)
    covered = part.covered(middle, np.cos(phase[index] + np.pi * middle))
    room = np.minimum(covered, part.d - covered)
    least = np.full(len(phase), np.inf)
    np.minimum.at(least, index, room)
    return np.asarray(room - reach <= least[index])


def _returning(way: Flight, phase: Floats) -> Brackets:
    """Where flights back to the membrane that they left turn: between extrema of Z' at which its signs differ."""
    # Here Z' has the other sign at the end than at the start: it changes sign an odd number of times, and the pairs of
    # `_crossing` are no help. Between extrema, ends included, Z' is monotone.
    turn = np.arccos(np.clip(-way.gbar, -1.0, 1.0))
    yield from _between(way, phase, np.stack([turn, -turn]), ())


def _between(way: Flight, phase: Floats, still: Floats, harmonics: Sequence[Harmonic]) -> Brackets:
    """Where flights turn between the phases `still` without acceleration, of each flight a column."""
    extrema = np.mod(still - phase, 2 * np.pi) / np.pi
    laps = np.repeat(2 * np.arange(_laps(way)), len(still))
    moments = np.tile(np.sort(extrema, axis=0), (_laps(way), 1)) + laps[:, None]
    # Where there are fewer phases than of others, the end of the flight stands for the rest: it belongs after them all.
    times = np.sort(np.fmin(moments, way.duration), axis=0)
    times = np.concatenate([np.zeros((1, len(phase))), times, way.duration[None]])
    speeds = way.speed(times, _impulse(phase + np.pi * times, harmonics))
    if harmonics:
        # Without restitution a flight begins at rest: what rounding makes of that is no turn.
        speeds[0] = way.direction * way.velocity
    piece, index = np.nonzero(speeds[:-1] * speeds[1:] < 0)
    yield index, times[piece, index], times[piece + 1, index], speeds[piece, index] > 0


def _unaccelerated(gbar: Floats, harmonics: Sequence[Harmonic]) -> Floats:
    """The phases at which Z'' is zero, of each gbar a column; NaN where there are fewer than of others."""
    different, which = np.unique(gbar, return_inverse=True)
    return unaccelerated_by(different, harmonics)[which.ravel()].T


def _impulse(phase: Any, harmonics: Sequence[Harmonic]) -> Any:
    """The impulse of the force at a phase: of a sine its sine."""
    return wave(np.sin(phase), np.cos(phase), harmonics).impulse if harmonics else np.sin(phase)


def _path(phase: Any, harmonics: Sequence[Harmonic]) -> Any:
    """The path of the force at a phase: of a sine its cosine."""
    return wave(np.sin(phase), np.cos(phase), harmonics).path if harmonics else np.cos(phase)


def _at_rest(
    way: Flight, phase: Floats, low: Floats, high: Floats, settled: float, harmonics: Sequence[Harmonic]
) -> Floats:
    """Zero of a monotone Z' between two times where its sign differs."""

    def speed(t: Floats, which: Ints) -> tuple[Floats, Floats]:
        part = way if t.size == phase.size else way.select(which)
        angle = phase[which] + np.pi * t
        force = wave(np.sin(angle), np.cos(angle), harmonics)
        return part.speed(t, force.impulse), part.pressing(force.force)

    # Newton, not secants: the slope, Z'', costs one cosine of an angle whose sine is needed anyway.
    rising = way.speed(high, _impulse(phase + np.pi * high, harmonics)) > 0
    return newton_root(speed, low, high, rising, settled)


def flight_turns(orbit: Orbits, flights: tuple[Flight, Flight], nearest: bool = False) -> Iterator[tuple[int, Turns]]:
    """The turning points of 1:1 motions, by the impact that begins the flight: 0 for the bottom, 1 for the top."""
    up, down = flights
    for part in turning_points(up, orbit.phi, False, nearest, harmonics=orbit.harmonics):
        yield 0, part
    top = np.arctan2(orbit.sin_top, orbit.cos_top)
    for part in turning_points(down, top, False, nearest, harmonics=orbit.harmonics):
        yield 1, part


def slowest(orbit: Orbits, r: Any) -> tuple[Floats, Ints]:
    """Least speed onward in the flights of 1:1 motions, and the impact (0 or 1) that begins the flight with it.

    Negative where the ball would move back in a flight, as one with friction does not on the way that is solved for:
    friction would be against that, too. Parameters are those of `wall_gap`.
    """
    top = np.arctan2(orbit.sin_top, orbit.cos_top)
    ends = np.abs(np.stack([orbit.velocity_bottom, orbit.velocity_top]))
    struck = np.stack(np.broadcast_arrays(*by_wall(r), ends[0])[:2]) * ends
    speeds = np.minimum(struck, ends[::-1])
    for i, (way, phase) in enumerate(zip(orbit.flights(r), (orbit.phi, top), strict=True)):
        if orbit.harmonics:
            still = _unaccelerated(way.gbar, orbit.harmonics)
        else:
            still = -way.direction * np.arccos(np.clip(-way.gbar, -1.0, 1.0))[None]
        first = np.mod(still - phase, 2 * np.pi) / np.pi
        laps = 2 * np.arange(_laps(way))
        times = (first[None] + laps[:, None, None]).reshape(len(laps) * len(first), len(phase))
        speeds_at = way.speed(times, _impulse(phase + np.pi * times, orbit.harmonics))
        inside = times < way.duration
        speeds[i] = np.minimum(speeds[i], np.where(inside, speeds_at, np.inf).min(axis=0, initial=np.inf))
    return speeds.min(axis=0), speeds.argmin(axis=0)


def wall_gap(orbit: Orbits, r: Any) -> Floats:
    """Smallest distance between the ball and a membrane at the turning points of 1:1 motions [x_c].

    Parameters
    ----------
    orbit : Orbits
        Arrays of motions with velocity_bottom > 0 > velocity_top.
    r : float or ndarray, or Restitutions
        Restitution coefficient.

    Returns
    -------
    ndarray
        Negative where the ball would have to pass through a membrane, zero at grazing, and d where it crosses from
        wall to wall without ever turning back. Where a ball with friction would turn back, the equations are not those
        of a motion: then negative, the speed back.
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
    """A turning point near a wall: its distance, its time in the flight, which flight, and which wall."""

    distance: float
    time: float
    upward: bool
    at_start: bool


def touches(orbit: Orbits, flights: tuple[Flight, Flight]) -> list[Touch]:
    """The turning points of one 1:1 motion (arrays of length one) with their distance from either wall, in order."""
    return sorted(
        Touch(abs(float(distance)), float(time), after == 0, at_start)
        for after, part in flight_turns(orbit, flights)
        for at_start, gap in ((True, part.covered), (False, part.room))
        for distance, time in zip(gap, part.time, strict=True)
    )


class NearTouch(NamedTuple):
    """The turning point of a motion that is as good as a touch of a membrane.

    Attributes
    ----------
    after : int
        The impact that its flight begins with.
    at_start : bool
        Whether the membrane is the one that the flight left.
    time : float
        Since the flight began [t_c].
    acceleration : float or None
        Towards the membrane left, as the flight begins, where the ball is back before it has really left.
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
    """A turning point of the ball: the flight it is in, its time, the wall it is turned towards, and its distance.

    `held` is whether the ball has not left yet: without restitution it starts at rest, and where the membrane still
    presses it, it turns next to it at once. That is no touch.
    """

    after: int
    time: float
    wall: int
    gap: float
    held: bool = False


def turns(motion: Motion, groups: Groups[float]) -> Iterator[Turn]:
    """Every turning point of a motion, with its distance from the wall that the ball turns back from.

    The distance is negative where the ball would have passed through the membrane.
    """
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
                time = _rest(low, high, (start, after, begun.impulse), groups)
                towards = 1 if low[1] > 0 else -1
                # From the wall that it left: of Z itself, half of a large d would leave no digit of the gap.
                path = wave(sin(pi * time), cos(pi * time), harmonics).path if harmonics else cos(pi * time)
                way = flight.displacement(time - start, after, begun.impulse, begun.path, path, gbar)
                held = after == 0 and wall == towards and time - start < SHORT
                yield Turn(i, time, towards, (0.0 if wall == towards else d) - towards * way, held)


def _rest(
    low: tuple[float, float], high: tuple[float, float], flown: tuple[float, float, float], groups: Groups[float]
) -> float:
    """Time at which a monotone Z' is zero, between two times with its values there.

    `flown` are the time, Z' and the impulse of the force at the beginning of the flight.
    """
    start, after, impulse = flown
    (a, before), (b, behind) = low, high
    # where it would be if Z' were half a wave, as it is where gbar = 0
    # Z' = A + B cos(pi s) over a share s of the way, with A + B and A - B at the ends, vanishes at cos(pi s) = -A/B.
    t = a + (b - a) * acos((before + behind) / (behind - before)) / pi
    for _ in range(BISECTIONS):
        phase = pi * t
        force = wave(sin(phase), cos(phase), groups.harmonics)
        value = flight.velocity(t - start, after, impulse, force.impulse, groups.gbar)
        slope = groups.pull(force.force)
        a, b = (a, t) if (value > 0) == (behind > 0) else (t, b)
        new = t - value / slope if slope else a
        if abs(new - t) < SETTLED and slope:
            return new
        t = new if a < new < b else (a + b) / 2
    return t


class Slowest(NamedTuple):
    """Where a flight is slowest: the impact that it begins with, the time, and the speed onward there."""

    after: int
    time: float
    speed: float


def slow_places(word: Word, velocity: Sequence[float], time: Sequence[float], groups: Groups[float]) -> list[Slowest]:
    """Every extremum of Z' in the flights across of one motion, with the speed onward there.

    Parameters
    ----------
    word : Word
        Of flights from one membrane to the other.
    velocity, time : sequence of float
        Of its impacts.
    groups : Groups
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
