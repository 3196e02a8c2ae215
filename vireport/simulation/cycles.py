"""Periodic motions found by simulation: recognised in rows of impacts, proved by Newton on the return map.

Turns the tail of a trajectory into a cycle with its word, its residual and its multipliers, or into nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, inf, log, nan, pi, sqrt

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.physics import flight
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import wrapped
from vireport.physics.word import Word
from vireport.simulation.events import as_start, check_model, follow_one, groups_of, harmonics_of, rebounds, rubs
from vireport.simulation.follower import Trajectory, twins
from vireport.simulation.kernel import (
    FLIGHT,
    PHASE,
    RIDING,
    SETTLING,
    TURN,
    VELOCITY,
    WALL,
)

Array = NDArray[np.float64]

# An impact this slow is a graze, where the map has no derivative; and logarithm of the steepest one worth a step.
SLOWEST, STEEPEST = 1e-100, 300.0
# Impacts in one period at most; longer ones count as not periodic.
MAX_IMPACTS = 64
EPS = 2.2e-16
# Two impacts this close in phase [rad] and velocity [y_c] are worth a Newton iteration.
NEAR = 1e-3
CANDIDATES = 4
NEWTON_STEPS = 12
# Rounding leaves some 1e-15 an impact; a cycle is one only below this residual.
RESIDUAL_TOL = 1e-12
# Error at the end of a lap that begins at a release, known exactly, up to which the lap is the true one.
STICK_TOL = 1e-6
# The same where the lap was gone again, a few roundings off, and ended alike.
LAP_TOL = 1e-2
# Newton leaves less than this between equal impacts; different impacts of one cycle are further apart.
SAME = 1e-9
# A cycle this far from the impact that suggested it, in phase [rad] and velocity [y_c], is another one.
REACH = 0.3
# Closer than this a trajectory is on a cycle, as far as rounding can tell.
ON_IT = 1e-11
# Change of an impact by which the sensitivity of a multiplier is found.
MOVED = 1e-7


class SimulatedMotion(Struct, frozen=True, eq=False):
    """One period of a periodic motion by the impacts of its simulation, and how well they repeat.

    Parameters
    ----------
    word : str
        Impacts in order, B for bottom and T for top: the alphabetically first of its rotations. A tilde marks
        infinitely many, ever lower hops on that membrane and the ride that follows.
    impacts : array (n, 6)
        Rows of the simulation, see `kernel`, from where the word begins.
    residual : float
        Largest difference in phase and velocity after one period of simulation; if the ball sticks, what
        rounding can have become between two rides.
    multipliers : pair of complex
        Eigenvalues of the product of the exact Jacobians, the larger first; zero if the ball sticks.
    """

    word: str
    impacts: Array
    residual: float
    multipliers: tuple[complex, complex]

    __repr__ = brief

    @property
    def period(self) -> int:
        """Period of the motion in forcing periods."""
        return _periods(self.impacts)

    @property
    def wall(self) -> NDArray[np.int8]:
        """Of each impact: +1 bottom or -1 top."""
        return self.impacts[:, WALL].astype(np.int8)

    @property
    def phase(self) -> Array:
        """Forcing phase of each impact [rad]."""
        return self.impacts[:, PHASE]

    @property
    def flight(self) -> Array:
        """Time from the impact or release before to each impact [t_c]."""
        return self.impacts[:, FLIGHT]

    @property
    def velocity(self) -> Array:
        """Velocity just before each impact [y_c]."""
        return self.impacts[:, VELOCITY]

    @property
    def sticks(self) -> bool:
        """Whether the ball rides on a membrane during a part of it."""
        return "~" in self.word

    @property
    def growth(self) -> float:
        """Modulus of the larger multiplier: below 1 the motion attracts."""
        return abs(self.multipliers[0])

    @property
    def lyapunov(self) -> float:
        """Largest Lyapunov exponent, per forcing period; -inf if the ball sticks."""
        return log(self.growth) / self.period if self.growth > 0 else -inf

    def distance(self, row: Array) -> float:
        """Distance of an impact from the nearest of the motion on its wall, in phase [rad] and velocity [y_c]."""
        apart = separation(self.phase - row[PHASE], self.velocity - row[VELOCITY])
        return float(np.min(apart[self.impacts[:, WALL] == row[WALL]], initial=inf))

    def motion(self, coordinate: float) -> Motion:
        """The motion without what its simulation tells of it, at a value of a sweep's coordinate; of one without rests.

        From here on the equations of periodic motions can take it for a start.
        """
        time = self.phase[0] / pi + np.concatenate([[0.0], np.cumsum(self.flight[1:])])
        return Motion(Word(tuple(self.wall.tolist()), self.period), self.velocity.copy(), time, coordinate)


def jacobians(model: Array, before: Array, after: Array, compiled: bool = False) -> Array:
    """Exact derivatives of impacts by the impacts before them, in (phase, velocity before the impact).

    From (2.11) and (2.12) with Z fixed: dt = -(t dv + Z_phi dphi)/Z', where v is the velocity the flight
    starts with and Z_phi a derivative at fixed time. Each determinant is r^2 times the ratio of the two
    velocities, so that the product of all r^2 is left after a cycle; of restitutions that fall with speed, that of r
    times the slope.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    before, after : array (n, 6)
        Rows of the impacts at the two ends of each flight.
    compiled : bool
        Whether to compile the search for the stops of a ball with friction, where numba is there.

    Returns
    -------
    array (n, 2, 2)
        Zero after a ball that stuck: it forgets.
    """
    if rubs(model):
        return _jacobians_with_friction(model, before, compiled)
    gbar = model[1]
    _, slope = rebounds(model, before[:, WALL], before[:, VELOCITY])
    t, speed = after[:, FLIGHT], after[:, VELOCITY]
    speed = np.where(np.abs(speed) < SLOWEST, SLOWEST, speed)
    x = pi * t
    sine, cosine = np.sin(before[:, PHASE]), np.cos(before[:, PHASE])
    rise = 2 * np.sin(x / 2) ** 2
    z_phase = -(sine * rise + cosine * _lag(x)) / pi**2
    end = np.cos(after[:, PHASE])
    for harmonic in harmonics_of(model):
        # S(phi + x) - S(phi) - x f(phi), S the impulse of the force f, is linear in the force.
        turned, way = harmonic.order * before[:, PHASE], harmonic.order * x
        s, c = np.sin(turned), np.cos(turned)
        of_cosine, of_sine = harmonic.cosine * c + harmonic.sine * s, harmonic.cosine * s - harmonic.sine * c
        z_phase = z_phase - (of_sine * 2 * np.sin(way / 2) ** 2 + of_cosine * _lag(way)) / (harmonic.order * pi**2)
        cosine = cosine + of_cosine
        end = (
            end
            + harmonic.cosine * np.cos(harmonic.order * after[:, PHASE])
            + harmonic.sine * np.sin(harmonic.order * after[:, PHASE])
        )
    pull = flight.acceleration(end, gbar)
    result = np.empty((len(t), 2, 2))
    result[:, 0, 0] = 1 - pi * z_phase / speed
    result[:, 0, 1] = pi * slope * t / speed
    result[:, 1, 0] = (end - cosine) / pi - pull * z_phase / speed
    result[:, 1, 1] = -slope * (1 - pull * t / speed)
    result[before[:, RIDING] + before[:, SETTLING] > 0] = 0.0
    return result


def _jacobians_with_friction(model: Array, before: Array, compiled: bool) -> Array:
    """`jacobians` of a ball with friction, over what it does between impacts."""
    from vireport.simulation import stops

    free = before[:, RIDING] + before[:, SETTLING] == 0
    result = np.zeros((len(before), 2, 2))
    result[free] = stops.jacobians(model, before[free], compiled)
    return result


def growth_bound(groups: Groups[float], cycle: SimulatedMotion) -> float:
    """Bound the error of a cycle's `growth`: rounding, and what its residual leaves open of its impacts.

    Each number of each impact is moved by a little on its own, and the changes of the multiplier are added up, so
    that none can cancel another's. Zero where the ball sticks, for then the multiplier is.
    """
    n, rows = len(cycle.impacts), cycle.impacts
    if cycle.sticks or not n:
        return 0.0
    model = check_model(groups)[0]
    walls, velocities = cycle.wall.tolist(), cycle.velocity.tolist()
    determinant = groups.decay(walls, velocities) ** 2 if groups.friction is None else None

    def grown(rows: Array) -> float:
        matrix, scale = product(jacobians(model, np.roll(rows, 1, axis=0), rows))
        if determinant is None:
            return float(np.abs(np.linalg.eigvals(matrix)).max()) * exp(min(scale, STEEPEST))
        return abs(multipliers(float(np.trace(matrix)) * exp(min(scale, STEEPEST)), determinant)[0])

    base, slopes = grown(rows), 0.0
    for row in range(n):
        for column in (PHASE, FLIGHT, VELOCITY):
            moved = rows.copy()
            moved[row, column] += MOVED
            slopes += abs(grown(moved) - base) / MOVED
    # An impact is off by what the residual becomes in all laps to come, and by rounding.
    off = cycle.residual / max(abs(1 - cycle.growth), MOVED) + 16 * EPS
    return 2 * slopes * off + 32 * n * EPS * max(base, 1.0)


def product(matrices: Array) -> tuple[Array, float]:
    """Product of a chain of matrices, the last one leftmost: a matrix of norm 1, and the norm's logarithm."""
    chain, scale = matrices, 0.0
    while len(chain) > 1:
        odd = chain[-1:] if len(chain) % 2 else chain[:0]
        chain = np.concatenate((chain[1::2] @ chain[: len(chain) - len(odd) : 2], odd))
        size = np.abs(chain).max(axis=(1, 2))
        if not size.all():
            return np.zeros((2, 2)), -inf
        chain = chain / size[:, None, None]
        scale += float(np.log(size).sum())
    size = float(np.abs(chain[0]).max())
    return (chain[0] / size, scale + log(size)) if size > 0 else (chain[0], -inf)


def exponent(model: Array, rows: Array, compiled: bool = False) -> float:
    """Largest Lyapunov exponent per forcing period, since the ball last stuck; a product of Jacobians."""
    stuck = np.flatnonzero(rows[:, RIDING] + rows[:, SETTLING] > 0)
    free = rows[stuck[-1] + 1 :] if len(stuck) else rows[rows[:, WALL] != 0]
    span = float(np.sum(free[1:, FLIGHT]))
    return chain_growth(model, free, compiled) / (span / 2) if span > 0 else nan


def recurrences(rows: Array) -> list[int]:
    """Numbers of impacts, ascending, after which the last impact came close to where it had been."""
    last, past = rows[-1], rows[-2 : -MAX_IMPACTS - 2 : -1]
    apart = separation(past[:, PHASE] - last[PHASE], past[:, VELOCITY] - last[VELOCITY])
    lengths: list[int] = (np.flatnonzero((apart < NEAR) & (past[:, WALL] == last[WALL])) + 1).tolist()
    return lengths[:CANDIDATES]


def refine(model: Array, rows: Array, length: int, compiled: bool = True) -> SimulatedMotion | None:
    """Periodic motion of `length` impacts near the last rows, by Newton's method on the return map.

    Returns None if the iteration leaves the word it began with, sticks, or stops short of `RESIDUAL_TOL`.
    """
    recent = rows[-length:]
    first = recent[np.argmax(np.abs(recent[:, VELOCITY]))].copy()  # far from grazing, where the map is smooth
    best: tuple[float, Array, Array] | None = None
    word: Array | None = None
    for _ in range(NEWTON_STEPS):
        lap, summary = follow_one(model, as_start(first), length, compiled=compiled)
        word = lap[:, WALL] if word is None else word
        held = lap[:, SETTLING].any() or lap[:, RIDING].any()
        if summary[0] < length or held or not np.array_equal(lap[:, WALL], word) or word[0] != word[-1]:
            break
        gap = np.array([wrapped(lap[-1, PHASE] - lap[0, PHASE]), lap[-1, VELOCITY] - lap[0, VELOCITY]])
        matrix, scale = product(jacobians(model, lap[:-1], lap[1:], compiled))
        matrix = matrix * exp(min(scale, STEEPEST))
        residual = float(np.abs(gap).max())
        if best is None or residual < best[0]:
            best = residual, lap, matrix
        elif best[0] <= RESIDUAL_TOL:
            break  # rounding is all that is left
        system = matrix - np.eye(2)
        if residual == 0.0 or abs(np.linalg.det(system)) < RESIDUAL_TOL:
            break
        step = np.linalg.solve(system, -gap)
        first[PHASE] = (first[PHASE] + step[0]) % TURN
        first[VELOCITY] += step[1]
        if first[WALL] * first[VELOCITY] <= 0:
            break
    if best is None or best[0] > RESIDUAL_TOL:
        return None
    residual, lap, matrix = best
    shorter = _divisor(lap)
    if shorter < length:
        return refine(model, lap[: shorter + 1], shorter, compiled)
    if _periods(lap[1:]) == 0:
        return None  # a lap so short that nothing changes in it
    # Friction that stops the ball on its way takes from the determinant, which is the product of r^2 otherwise.
    determinant = float(np.linalg.det(matrix)) if rubs(model) else _determinant(model, lap[1:])
    return _cycle(lap[1:], residual, multipliers(float(np.trace(matrix)), determinant))


def _determinant(model: Array, lap: Array) -> float:
    """Product of r^2 over the impacts of a cycle, or of r and its slope."""
    walls = lap[:, WALL]
    if groups_of(model).law is not None:
        return float(np.prod(rebounds(model, walls, lap[:, VELOCITY])))
    struck = int(np.count_nonzero(walls > 0))
    bottom, top = float(model[2]), float(model[3])
    if bottom == top:
        return bottom ** (2 * len(walls))
    return float(bottom ** (2 * struck) * top ** (2 * (len(walls) - struck)))


def laps(rows: Array) -> list[Array]:
    """Impacts from a release to the next ride on the same membrane, the last ones on either; none if there are none.

    Released from a membrane the ball always moves alike: one lap is enough to know that the motion is periodic. Where
    so much happens in it that rounding alone decides when the next ride comes, only its cycle cannot be computed.
    """
    rides = _rides(rows)
    ridden = (rides[rows[rides, WALL] == wall] for wall in (1, -1))
    return [rows[on_wall[-2] + 1 : on_wall[-1] + 1] for on_wall in ridden if len(on_wall) > 1]


def released(rows: Array) -> set[float]:
    """The membranes that have released the ball after a ride."""
    return set(rows[_rides(rows), WALL].tolist())


def _rides(rows: Array) -> NDArray[np.intp]:
    return np.flatnonzero((rows[:, RIDING] > 0) & np.isfinite(rows[:, RIDING]))


def rest_cycle(model: Array, lap: Array, compiled: bool = True) -> SimulatedMotion | None:
    """Motion of the impacts from a release to the next ride on the same membrane; None where rounding makes the lap.

    That is told by how much rounding has grown at its end or, where it has grown too much for that, by whether the lap
    ends in the same ride when it is gone again, a few roundings off.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    lap : array (n, 6)
        Impacts since the release, the last one being that after which the ball rides.
    compiled : bool
        Whether to compile the search, where numba is there.
    """
    growth, periods = chain_growth(model, lap, compiled), _periods(lap)
    if not periods:
        return None
    if growth > log(LAP_TOL / EPS):
        return None
    if growth > log(STICK_TOL / EPS):
        for start in twins(lap[0], 2):
            again, _ = follow_one(model, start, len(lap) - 1, compiled=compiled)
            # Not the number of the last hops, which rounding decides: that the ball rides, and after the same way.
            alike = len(again) == len(lap) and np.array_equal(again[:, WALL], lap[:, WALL])
            if not alike or not again[-1, RIDING] > 0:
                return None
    elif len(word_of(lap)) > MAX_IMPACTS:
        return None
    return _cycle(lap, EPS * exp(growth), (0j, 0j))


def approached(model: Array, rows: Array, compiled: bool = True) -> SimulatedMotion | None:
    """Periodic motion near the last rows that attracts, or one that does not but on which they lie."""
    resting = None
    for length in recurrences(rows):
        cycle = refine(model, rows, length, compiled)
        distance = cycle.distance(rows[-1]) if cycle is not None else inf
        if cycle is not None and cycle.growth < 1 and distance < REACH:
            return cycle
        if distance <= ON_IT:
            resting = resting or cycle
    return resting


def attracting(ball: Trajectory) -> SimulatedMotion | None:
    """The motion that a ball surely comes to: its last impacts nearly repeat, next to a cycle that attracts."""
    cycle = approached(ball.model, ball.rows, ball.compiled)
    return cycle if cycle is not None and cycle.growth < 1 else None


def multipliers(trace: float, determinant: float) -> tuple[complex, complex]:
    """Eigenvalues of a 2x2 matrix, the larger first, without the cancellation of the textbook formula."""
    inside = trace * trace / 4 - determinant
    if inside < 0:
        return complex(trace / 2, sqrt(-inside)), complex(trace / 2, -sqrt(-inside))
    large = trace / 2 + (sqrt(inside) if trace >= 0 else -sqrt(inside))
    return complex(large), complex(determinant / large if large != 0 else 0.0)


Struck = tuple[str, float, bool]
"""The letter of an impact, its speed, and whether the ball settles or rides after it."""


def word_of(rows: Array) -> list[str]:
    """Letters of the impacts; ever slower hops that end in a ride are one letter with a tilde."""
    return _letters(_struck(rows))


def _struck(rows: Array) -> list[Struck]:
    """What a word is made of. As plain numbers: each turn of a cycle has its word, and rows of arrays are slow."""
    stays = (rows[:, RIDING] + rows[:, SETTLING] > 0).tolist()
    walls = ["B" if wall > 0 else "T" for wall in rows[:, WALL].tolist()]
    return list(zip(walls, np.abs(rows[:, VELOCITY]).tolist(), stays, strict=True))


def _letters(impacts: Sequence[Struck]) -> list[str]:
    letters: list[str] = []
    falling, last = 0, inf  # impacts on this membrane at the end, each slower than the one before
    for letter, speed, stays in impacts:
        again = bool(letters) and letters[-1] == letter
        falling = falling + 1 if again and speed < last else 1
        last = speed
        letters.append(letter)
        if stays:
            letters[-falling:] = [letter + "~"]
    return letters


def chain_growth(model: Array, rows: Array, compiled: bool = False) -> float:
    """Logarithm of what a small difference at the first of these impacts is multiplied by until the last."""
    plain = rows.copy()
    plain[:, [SETTLING, RIDING]] = 0.0
    return product(jacobians(model, plain[:-1], plain[1:], compiled))[1] if len(rows) > 1 else 0.0


def _cycle(rows: Array, residual: float, eigenvalues: tuple[complex, complex]) -> SimulatedMotion:
    """Motion that starts where its word does; of equal words, with the fastest impact."""
    n = len(rows)
    impacts = _struck(rows)
    letters = _letters(impacts)
    word = min("".join(letters[i:] + letters[:i]) for i in range(len(letters)))
    turns = [i for i in range(n) if "".join(_letters(impacts[i:] + impacts[:i])) == word]
    rows = np.roll(rows, -max(turns, key=lambda i: abs(float(rows[i, VELOCITY]))), axis=0)
    rows.setflags(write=False)
    return SimulatedMotion(word, rows, residual, eigenvalues)


def _periods(rows: Array) -> int:
    """Forcing periods that these flights and rides take."""
    return round(float(np.sum(rows[:, FLIGHT] + rows[:, SETTLING] + rows[:, RIDING])) / 2)


def _divisor(lap: Array) -> int:
    """Smallest number of impacts after which the lap repeats itself."""
    n = len(lap) - 1
    for length in range(1, n):
        if n % length == 0:
            a, b = lap[:-length], lap[length:]
            apart = separation(a[:, PHASE] - b[:, PHASE], a[:, VELOCITY] - b[:, VELOCITY])
            if np.array_equal(a[:, WALL], b[:, WALL]) and apart.max() < SAME:
                return length
    return n


def separation(phase: Array, velocity: Array) -> Array:
    """The larger of two differences, of phases [rad] around the circle and of velocities."""
    apart: Array = np.maximum(np.abs(wrapped(phase)), np.abs(velocity))
    return apart


def _lag(x: Array) -> Array:
    """Return x - sin x, by its series where the difference would lose digits."""
    short = np.abs(x) < 0.5
    q = np.where(short, x, 0.0) ** 2
    series = x * q / 6 * (1 - q / 20 * (1 - q / 42 * (1 - q / 72 * (1 - q / 110 * (1 - q / 156)))))
    lag: Array = np.where(short, series, x - np.sin(x))
    return lag
