"""Candidates for motions with two to four impacts, in closed form as functions of their flight times.

Where the flight times are fixed, the conditions are linear and homogeneous in the velocities, the sine and cosine of
the phase, gbar and d. With three impacts they have one solution for each pair of flight times, without iteration; with
four, one for each triple, and one condition is left over. Motions that strike the bottom only do not depend on d, one
unknown less: with two impacts there is one solution for each flight time; with three a condition on two flight times is
left over, with four two on three.

Read `solution` (the linear system), `sweep_conditions` (what makes a solution one of a sweep), `Candidates`, and
`onto_sweep` (Newton's method for the flight times).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate, pairwise
from math import prod
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.motions.periodicity import Model, trace
from vireport.motions.sweep import Held, Level
from vireport.motions.turning import SMALLEST_STEP, ForcedFlights, Turns, turning_points
from vireport.physics import flight
from vireport.physics.flight import Flight
from vireport.physics.groups import Restitution, Restitutions, by_wall
from vireport.physics.motion import Motion
from vireport.physics.numbers import ARRAYS, Arithmetic, ContinuousFunctions
from vireport.physics.word import Word

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

NEWTON_STEPS, STEP, SETTLED = 6, 1e-7, 1e-8
"""Newton steps, the difference of flight times for derivatives [t_c], and the residual that is small enough to follow a
family from the motion: the step after it squares the residual."""

INWARD = 1 / 16
"""Distance from the ends of the sweep, as a share of it, at which motions are looked for on families that were met
beyond these ends."""


class FlightTimes(NamedTuple):
    """Flight times of motions of one word, numbers of any kind or arrays.

    Attributes
    ----------
    flights : sequence
        All flight times but the last [t_c].
    period : array_like or None
        Period of each motion [t_c]; None for the period of the word.
    time : list or None
        Times of all impacts [t_c], where the caller has them as arrays of fewer numbers than the sums of flight times;
        None to add these up.
    """

    flights: Sequence[Any]
    period: Any = None
    time: list[Any] | None = None


class HomogeneousSolution(NamedTuple):
    """The solution of the linear conditions at given flight times, up to a common factor.

    Attributes
    ----------
    vectors : list
        For each impact, what multiplies (sine, cosine, gbar) to give its velocity.
    time : list
        Times of the impacts [t_c]: zero at the first, or at the second where only one membrane is struck.
    sine, cosine : array_like
        Of the forcing phase at time zero, times the factor.
    gbar, d : array_like
        The groups times the factor; d is None where only one membrane is struck.
    excess : list
        The conditions left over: zero for flight times of a motion.
    rows, waves : sequence
        Where only one membrane is struck: the conditions, of which the first two were solved; and sine and cosine of pi
        times the time of each impact.
    """

    vectors: list[Any]
    time: list[Any]
    sine: Any
    cosine: Any
    gbar: Any
    d: Any
    excess: list[Any]
    rows: Sequence[Any] = ()
    waves: Sequence[Any] = ()

    @property
    def velocity(self) -> list[Any]:
        """Velocity before each impact, times the factor."""
        # With `waves` the vectors are for the phase at the impact itself, and are turned to that at time zero.
        turned = [_turned(*pair) for pair in zip(self.vectors, self.waves, strict=True)] if self.waves else self.vectors
        return [_product(vector, (self.sine, self.cosine, self.gbar)) for vector in turned]

    @property
    def positive(self) -> Any:
        """The group whose sign is that of the common factor."""
        return self.gbar if self.d is None else self.d

    def at(self, index: Any) -> HomogeneousSolution:
        """The solutions picked by an index, without their excess."""
        vectors, rows, waves = (
            [[y if isinstance(y, float) else y[index] for y in row] for row in part]
            for part in (self.vectors, self.rows, self.waves)
        )
        d = None if self.d is None else self.d[index]
        groups = self.sine[index], self.cosine[index], self.gbar[index], d
        return HomogeneousSolution(vectors, [t[index] for t in self.time], *groups, [], rows, waves)

    def by_others(self) -> HomogeneousSolution:
        """The solution by the last and the first condition instead of the first two, where one membrane is struck."""
        rows = [self.rows[-1], *self.rows[:-1]]
        sine, cosine, gbar = kernel = _cross(*rows[:2])
        excess = [_product(row, kernel) for row in rows[2:]]
        return self._replace(sine=sine, cosine=cosine, gbar=gbar, excess=excess, rows=rows)


def solution(word: Word, times: FlightTimes, r: Restitution, ops: ContinuousFunctions = ARRAYS) -> HomogeneousSolution:
    """Solve the linear conditions of motions with three or four impacts, or two to four on one membrane only.

    Parameters
    ----------
    word : Word
    times : FlightTimes
    r : float or Restitutions
        Restitution coefficient.
    ops
        Of the kind of number of the flight times.

    Source: Eqs. (2.11)-(2.13). Velocities are eliminated by (2.11); flights from a membrane to the same one do not
    depend on d, nor do two flights across and back together, which leaves two conditions, or three, on three unknowns.
    """
    flights, period, time = times
    count, walls = len(word), word.walls
    if word.one_sided:
        restitution = by_wall(r)[0 if walls[0] > 0 else 1]
        return _on_one_membrane(flights, 2.0 * word.periods if period is None else period, restitution, ops)
    if time is None:
        time = list(accumulate(flights, initial=flights[0] * 0.0))
    durations = [*flights, (2.0 * word.periods if period is None else period) - time[-1]]
    # Every quantity is a vector of three: what multiplies the sine and the cosine of the phase at the first impact, and
    # gbar.
    swings = [(1 / np.pi, 0.0)]
    for angle in (ops.pi * t for t in time[1:]):
        swings.append((ops.cos(angle) * (1 / np.pi), ops.sin(angle) * (1 / np.pi)))
    gains = [(b[0] - a[0], b[1] - a[1], t) for (a, b), t in zip(pairwise([*swings, swings[0]]), durations, strict=True)]
    # Each impact begins with -r times its velocity: v_(i+1) = gain_i - r v_i, which after a whole period is v_0 again
    # where v_0 = sum_i gain_i (-r)^(N-1-i)/[1 - (-r)^N], with the products of all r for the powers.
    bottom, top = by_wall(r)
    of_impact = [bottom if wall > 0 else top for wall in walls]
    if isinstance(r, Restitutions):
        kept = [prod(-restitution for restitution in of_impact[i:]) for i in range(count + 1)]
        decays = [after / (1 - kept[0]) for after in kept[1:]]
    else:
        decays = [(-r) ** (count - 1 - i) / (1 - (-r) ** count) for i in range(count)]
    velocities = [[sum(gain[part] * decay for gain, decay in zip(gains, decays, strict=True)) for part in range(3)]]
    for gain, restitution in zip(gains[:-1], of_impact[:-1], strict=True):
        velocities.append([g - v * restitution for g, v in zip(gain, velocities[-1], strict=True)])
    rows, across = [], []
    for i, (t, v, swing, restitution) in enumerate(zip(durations, velocities, swings, of_impact, strict=True)):
        drift = [v[0] * -restitution - swing[0], v[1] * -restitution - swing[1], t * 0.5 - v[2] * restitution]
        if walls[i] == walls[(i + 1) % count]:  # divided by the flight time, with which it vanishes
            middle, chord = ops.pi * (time[i] + t * 0.5), ops.sinc(t * 0.5) * (1 / np.pi)
            rows.append([drift[0] + chord * ops.cos(middle), drift[1] + chord * ops.sin(middle), drift[2]])
        else:
            sine, cosine = (gains[i][part] * (1 / np.pi) for part in (1, 0))
            across.append([drift[0] * t + sine, drift[1] * t - cosine, drift[2] * t])
    rows += [[x + y for x, y in zip(*both, strict=True)] for both in pairwise(across)]
    kernel = _cross(*rows[:2])
    # The first flight across is towards the top when the word begins at the bottom, and covers -d.
    towards = -next(wall for i, wall in enumerate(walls) if wall != walls[(i + 1) % count])
    d, excess = _product(across[0], kernel) * float(towards), [_product(row, kernel) for row in rows[2:]]
    return HomogeneousSolution(velocities, time, kernel[0], kernel[1], kernel[2], d, excess)


def _on_one_membrane(
    flights: Sequence[Any], period: Arithmetic, r: float, ops: ContinuousFunctions
) -> HomogeneousSolution:
    """Solve the conditions of motions with all impacts on the bottom; arguments are those of `solution`.

    Notes
    -----
    A flight that comes back to it after a time t begins, by (2.12), with the velocity gbar t/2 - p s + q c upwards,
    where p = (1 - sinc t)/pi, q = sinc(t/2) sin(pi t/2)/pi, and s and c are sine and cosine of the phase at its start;
    with those at its end it ends, by (2.11), with the velocity gbar t/2 + p s + q c downwards. At each impact the first
    is r times the second.
    """
    durations = [*flights, period - sum(flights[1:], flights[0])]
    halves = [t * 0.5 for t in durations]
    lead = [(1.0 - ops.sinc(t)) * (1 / np.pi) for t in durations]
    lift = [ops.sinc(half) * ops.sin(half * np.pi) * (1 / np.pi) for half in halves]
    time = [-flights[0], flights[0] * 0.0, *accumulate(flights[1:])]
    waves = [(0.0, 1.0) if i == 1 else (ops.sin(t * np.pi), ops.cos(t * np.pi)) for i, t in enumerate(time)]
    vectors = [(lead[i - 1], lift[i - 1], halves[i - 1]) for i in range(len(time))]
    rows = []
    for i, (p, q, half) in enumerate(vectors):
        balance = -lead[i] - p * r, lift[i] - q * r, halves[i] - half * r
        rows.append(balance if i == 1 else _turned(balance, waves[i]))
    rows = [*rows[1:], rows[0]]
    kernel = _cross(*rows[:2])
    excess = [_product(row, kernel) for row in rows[2:]]
    return HomogeneousSolution(vectors, time, kernel[0], kernel[1], kernel[2], None, excess, rows, waves)


def _turned(vector: Sequence[Any], wave: tuple[Any, Any]) -> list[Any]:
    """A vector for the phase at a time, as one for the phase at time zero.

    Parameters
    ----------
    vector : sequence
        What multiplies sine and cosine of the phase at the time, and gbar.
    wave : tuple
        Sine and cosine of pi times that time.
    """
    s, c, gbar = vector
    sine, cosine = wave
    return [s * cosine - c * sine, s * sine + c * cosine, gbar]


def sweep_conditions(x: HomogeneousSolution, model: Model) -> list[Any]:
    """Functions of a solution that are all zero if it is a motion of the sweep.

    Parameters
    ----------
    x : HomogeneousSolution
        In any kind of number.
    model : Model
        Groups over the sweep.

    Returns
    -------
    list
        What the sweep holds, gbar, d or d/gbar, less its value, if that is a condition; then the excess of the
        solution. Times a power of its factor, so that nothing is divided.
    """
    value = float(model.level.value)
    # Where only the bottom is struck any d above the ball's reach will do: the sweep's level is a condition only if it
    # is one of gbar.
    if x.d is None and model.level.held is not Held.GBAR:
        return x.excess
    if model.level.held is Held.RATIO:
        off = x.d - x.gbar * value
    else:
        held = x.d if model.level.held is Held.D else x.gbar
        # The common factor is the root of the sum of the squares.
        off = held * held - (x.sine * x.sine + x.cosine * x.cosine) * (value * value) if value else held
    return [off, *x.excess]


def _cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """Vector product, which both factors multiply to zero: the solution of two linear conditions on three unknowns."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _product(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Scalar product of two vectors of three."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


class Candidates(Struct, frozen=True, eq=False):
    """Solutions of the conditions of one word, as arrays; not all of them need be motions.

    Attributes
    ----------
    word : Word
    velocity, time : ndarray (N, n)
        Of each impact [y_c], [t_c].
    gbar, d : ndarray (n,)
        The groups of each; where only one membrane is struck, d is nan until a value is chosen.
    excess : ndarray (m, n)
        See `HomogeneousSolution`.
    r : float or Restitutions
        Restitution coefficient.
    """

    word: Word
    velocity: Floats
    time: Floats
    gbar: Floats
    d: Floats
    excess: Floats
    r: Any

    def __getitem__(self, index: Any) -> Candidates:
        """The candidates picked by an index or mask."""
        parts = (self.velocity[:, index], self.time[:, index], self.gbar[index], self.d[index], self.excess[:, index])
        return Candidates(self.word, *parts, self.r)

    def coordinate(self, level: Level) -> Floats:
        """The sweep's coordinate of each candidate."""
        return np.asarray(self.gbar if level.held is Held.D else self.d)

    def motion(self, i: int, level: Level) -> Motion:
        """The motion of candidate i, with the sweep's coordinate."""
        return Motion(self.word, self.velocity[:, i], self.time[:, i], float(self.coordinate(level)[i]))

    @property
    def trace(self) -> Floats:
        """Trace of the return map's Jacobian, whose determinant is the product of r^2 over the impacts."""
        x = [*self.velocity, *self.time, self.gbar]
        return np.asarray(trace(self.word, x, Model(Level(Held.D, self.d), self.r), ARRAYS))

    def turns(self, period: Any = None, settled: float = SMALLEST_STEP) -> Iterator[tuple[int, Turns]]:
        """The turning points of the ball, each after the number of the impact that begins its flight.

        Parameters
        ----------
        period : ndarray (n,), optional
            Period of each candidate [t_c]; by default that of the word.
        settled : float
            Newton step that ends the search for a turning point [t_c].
        """
        walls, whole = self.word.walls, 2.0 * self.word.periods if period is None else period
        ends = [*self.time[1:], self.time[0] + whole]
        for i, (wall, start, end) in enumerate(zip(walls, self.time, ends, strict=True)):
            phase, velocity = np.pi * start, flight.reflect(self.velocity[i], by_wall(self.r)[0 if wall > 0 else 1])
            way = Flight(-wall, velocity, np.sin(phase), np.cos(phase), end - start, self.gbar, self.d)
            returns = wall == walls[(i + 1) % len(walls)]
            for part in turning_points(ForcedFlights(way, phase), returns, settled=settled):
                yield i, part

    @property
    def gap(self) -> Floats:
        """Least distance of the ball from a membrane that it turns back from [x_c]; infinite if it never turns.

        Zero or less where a candidate is no motion, also because of its velocities or a negative d.
        """
        speeds = self.velocity * np.array(self.word.walls)[:, None]
        sound = (speeds > 0).all(axis=0) & (self.d > 0)
        gap, rows = np.where(sound, np.inf, 0.0), np.flatnonzero(sound)
        for _, part in self[rows].turns():
            np.minimum.at(gap, rows[part.index], part.gap)
        return gap

    @property
    def admissible(self) -> Mask:
        """Whether candidates are motions: impacts from within, and the ball between the membranes at all times."""
        return np.asarray(self.gap > 0)


def candidates_above(word: Word, flights: Floats, r: Restitution, period: Floats | None = None) -> Candidates:
    """The solutions of the conditions at given flight times.

    Parameters
    ----------
    word : Word
        Three or four impacts, or two to four on the bottom only.
    flights : ndarray (N - 1, n)
        All flight times but the last [t_c].
    r : float or Restitutions
        Restitution coefficient.
    period : ndarray (n,), optional
        Period of each motion [t_c]; by default that of the word.

    Notes
    -----
    The negative of a solution solves the conditions too: returned is the one with positive d, or positive gbar where
    only one membrane is struck. NaN at flight times with more solutions than these two.
    """
    x = solution(word, FlightTimes(list(flights), period), r)
    with np.errstate(invalid="ignore", divide="ignore"):
        # sin^2 + cos^2 = 1 fixes the size of the factor, and d > 0 (gbar > 0) its sign.
        scale = np.copysign(1 / np.hypot(x.sine, x.cosine), x.positive)
        start = np.arctan2(scale * x.sine, scale * x.cosine) / np.pi % 2
        groups = scale * x.gbar, scale * (np.nan if x.d is None else x.d)
        excess = scale * np.reshape(x.excess, (len(x.excess), len(scale)))
        return Candidates(word, scale * np.stack(x.velocity), start + np.stack(x.time), *groups, excess, r)


def room(level: Level, largest: Arithmetic, gbar: Arithmetic, norm: Arithmetic = 1.0) -> Any:
    """The d to give to motions that strike one membrane only and do not depend on it.

    Parameters
    ----------
    level : Level
        Level of the sweep.
    largest : array_like
        Largest d of the sweep, which is taken where the sweep varies d at constant gbar.
    gbar : array_like
        Of the motions, perhaps times a factor.
    norm : array_like
        This factor.
    """
    if level.held is Held.D:
        return norm * level.value
    return gbar * (level.value if level.held is Held.RATIO else largest / level.value)


def search_end(model: Model, word: Word, low: float, high: float) -> float:
    """Upper end of the range of the coordinate in which motions of a word are looked for.

    Motions on one membrane exist at all d above the ball's reach. Where the sweep covers many decades of d, they are
    looked for at the lower ones, where their gaps keep digits.
    """
    if not (word.one_sided and model.level.held is Held.GBAR):
        return high
    return min(high, max(2 * low, model.reach(word.periods)))


def within(motions: Candidates, level: Level, low: float, high: float) -> tuple[Candidates, NDArray[np.intp]]:
    """The candidates that are motions in the range of the sweep's coordinate, and their indices."""
    gap = motions.gap
    if motions.word.one_sided and level.held is Held.GBAR:  # motions at all d above the ball's reach: one is chosen
        motions = replace(motions, d=high - np.minimum(gap, high - low) / 2)
    coordinate = motions.coordinate(level)
    rows = np.flatnonzero((gap > 0) & (coordinate > low) & (coordinate < high))
    return motions[rows], rows


def onto_sweep(
    word: Word, flights: Floats, model: Model, farthest: float, coordinate: Floats | None = None
) -> tuple[Candidates, Floats]:
    """Solve for motions of a sweep next to given flight times, by Newton's method.

    Parameters
    ----------
    word : Word
    flights : ndarray (N - 1, n)
        All flight times but the last of each guess [t_c].
    model : Model
        Groups over the sweep.
    farthest : float
        Most that a flight time may change [t_c].
    coordinate : ndarray (n,), optional
        Value of the sweep's coordinate that each motion must have.

    Returns
    -------
    Candidates
        Of the guesses for which the method settles.
    ndarray (N - 1, m)
        Their flight times but the last.
    """
    start, flights, settled = flights, flights.copy(), np.zeros(flights.shape[1], dtype=bool)
    steps, rows = STEP * np.eye(len(flights), len(flights) + 1, 1)[:, :, None], np.arange(flights.shape[1])
    for _ in range(NEWTON_STEPS):
        if not rows.size:
            break
        at = None if coordinate is None else coordinate[rows]
        with np.errstate(all="ignore"):
            values = _conditions(word, flights[:, None, rows] + steps, model, at)
            value, slope = values[:, 0, :, None], (values[:, 1:] - values[:, :1]) / STEP
            square = slope.transpose(0, 2, 1) @ slope
            size = np.linalg.det(square)
        regular = np.isfinite(size) & (size > np.finfo(float).tiny)
        rows, value, slope, square = rows[regular], value[regular], slope[regular], square[regular]
        # There may be fewer conditions than flight times: S (S^T S)^-1 f is the shortest step on which the linearised
        # ones vanish.
        moved = flights[:, rows] - (slope @ np.linalg.solve(square, value))[:, :, 0].T
        near = (np.abs(moved - start[:, rows]).max(axis=0) < farthest) & (moved > 0).all(axis=0)
        # The last flight has what the others leave of the period.
        near &= moved.sum(axis=0) < 2 * word.periods
        flights[:, rows] = moved
        ends = np.abs(value).max(axis=(1, 2), initial=0.0) < SETTLED
        settled[rows[near & ends]] = True
        rows = rows[near & ~ends]
    flights = flights[:, settled]
    return candidates_above(word, flights, model.r), flights


def into_range(
    motions: Candidates, flights: Floats, model: Model, farthest: float, limits: tuple[float, float]
) -> Floats:
    """Flight times of motions, and those of motions inside the range on families that were met outside it.

    A family may be in the range for less than a cell, and its motion nearest to a guess outside.

    Parameters
    ----------
    motions : Candidates
        On the sweep's level.
    flights : ndarray (N - 1, n)
        Their flight times but the last [t_c].
    model : Model
        Groups over the sweep.
    farthest : float
        Most that a flight time may change [t_c].
    limits : tuple of float
        Range of the coordinate.
    """
    value, inward = motions.coordinate(model.level), INWARD * (limits[1] - limits[0])
    inside = np.clip(value, limits[0] + inward, limits[1] - inward)
    rows = np.flatnonzero((value <= limits[0]) | (value >= limits[1]))
    _, moved = onto_sweep(motions.word, flights[:, rows], model, farthest, inside[rows])
    return np.concatenate([flights, moved], axis=1)


def _conditions(word: Word, flights: Floats, model: Model, coordinate: Floats | None) -> Floats:
    """Conditions that are zero for motions of a sweep, at flight times (N - 1, m, n): (n, m, conditions)."""
    level, x = model.level, solution(word, FlightTimes(list(flights)), model.r)
    # Divided by the factor, whose size changes with the flight times: otherwise Newton's steps would follow it too.
    scale, values = np.copysign(1 / np.hypot(x.sine, x.cosine), x.positive), x.excess
    if level.held is Held.GBAR or not word.one_sided:
        if level.held is Held.RATIO:
            off = x.d / level.value - x.gbar
        else:
            off = (x.d if level.held is Held.D else x.gbar) - level.value / scale
        values = [off, *values]
    if coordinate is not None:
        d = x.gbar * level.value if x.d is None else x.d  # on one membrane that of `room`, at a ratio that is held
        values = [*values, (x.gbar if level.held is Held.D else d) - coordinate / scale]
    return np.reshape([scale * value for value in values], (len(values), *scale.shape)).T
