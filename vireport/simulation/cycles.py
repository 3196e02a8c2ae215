"""Periodic motions found by simulation: recognised in the last impacts of a trajectory, made exact by Newton's method.

Where the last impacts nearly repeat themselves, the return map has a fixed point near by: Newton's method finds it,
with exact Jacobians, and the product of these over one period gives its multipliers. A ball that rides on a membrane
again and again needs no Newton: it leaves that membrane in one state, and so repeats exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, inf, log, nan, pi

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.physics import flight
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion, multipliers
from vireport.physics.numbers import wrapped
from vireport.physics.word import Word
from vireport.simulation.events import (
    BOTTOM,
    TOP,
    as_start,
    check_model,
    follow_one,
    groups_of,
    harmonics_of,
    rebounds,
    rubs,
)
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
# Largest number of impacts in one period; a longer motion counts as not periodic.
MAX_IMPACTS = 64
EPS = 2.2e-16
# Two impacts this close in phase [rad] and velocity [y_c] are worth a Newton iteration.
NEAR = 1e-3
CANDIDATES = 4
NEWTON_STEPS = 12
# Rounding leaves some 1e-15 an impact; a cycle is one only below this residual.
RESIDUAL_TOL = 1e-12
# A residual this small is rounding, which no further step makes less.
ROUNDED = 4 * EPS
# A lap begins at a release, in a state that is known exactly. Error at its end up to which it is the true lap.
STICK_TOL = 1e-6
# The same error where two twins of the lap, a few roundings off, ended alike.
LAP_TOL = 1e-2
# Newton leaves less than this between equal impacts; different impacts of one cycle are further apart.
SAME = 1e-9
# Releases this close in phase [rad] are at one zero of the acceleration, which is known to rounding.
SAME_RELEASE = 1e-6
# A cycle this far from the impact that suggested it, in phase [rad] and velocity [y_c], is another one.
REACH = 0.3
# Closer than this a trajectory is on a cycle, as far as rounding can tell.
ON_IT = 1e-11
# Change of an impact over which the sensitivity of a multiplier is a difference.
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
        Largest difference in phase [rad] and velocity [y_c] after one period of simulation; if the ball sticks, the
        error that rounding can have grown to between two rides.
    multipliers : pair of complex
        Eigenvalues of the product of the exact Jacobians, the one of larger modulus first; zero if the ball sticks.
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
        """Membrane of each impact: +1 bottom or -1 top."""
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
        """Modulus of the larger multiplier, by which small deviations grow in a period: below 1 the motion attracts."""
        return abs(self.multipliers[0])

    @property
    def lyapunov(self) -> float:
        """Largest Lyapunov exponent, per forcing period; -inf if the ball sticks."""
        return log(self.growth) / self.period if self.growth > 0 else -inf

    def distance(self, row: Array) -> float:
        """Distance of an impact, a row of `kernel`, from the nearest one of the motion on the same membrane [rad, y_c].

        Infinite if the motion strikes that membrane nowhere.
        """
        apart = separation(self.phase - row[PHASE], self.velocity - row[VELOCITY])
        return float(np.min(apart[self.impacts[:, WALL] == row[WALL]], initial=inf))

    def motion(self, coordinate: float) -> Motion:
        """The motion as a guess for the equations of periodic motions, at a value of a sweep's coordinate.

        It must be without rest.
        """
        time = self.phase[0] / pi + np.concatenate([[0.0], np.cumsum(self.flight[1:])])
        return Motion(Word(tuple(self.wall.tolist()), self.period), self.velocity.copy(), time, coordinate)


def jacobians(model: Array, before: Array, after: Array, compiled: bool = False) -> Array:
    """Jacobians of the impact map: derivatives of impacts by those before, in (phase, velocity before the impact).

    Exact, from (2.11) and (2.12) with Z fixed: dt = -(t dv + Z_phi dphi)/Z', where v is the velocity the flight
    starts with and Z_phi a derivative at fixed time. Each determinant is r^2 times the ratio of the two
    velocities, so that the product of all r^2 is left after a cycle; with restitutions that fall with speed, of all r
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
        Zero after an impact at which the ball stuck: it forgets.
    """
    if rubs(model):
        return _jacobians_with_friction(model, before, compiled)
    gbar = model[1]
    _, slope = rebounds(model, before[:, WALL], before[:, VELOCITY])
    t, speed = after[:, FLIGHT], after[:, VELOCITY]
    speed = np.where(np.abs(speed) < SLOWEST, SLOWEST, speed)
    x = pi * t
    sine, cosine = np.sin(before[:, PHASE]), np.cos(before[:, PHASE])
    # 1 - cos x without the cancellation of short flights, as x - sin x in `_lag`.
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
    """The `jacobians` for a ball with friction, over its stops between impacts."""
    from vireport.simulation import stops

    free = before[:, RIDING] + before[:, SETTLING] == 0
    result = np.zeros((len(before), 2, 2))
    result[free] = stops.jacobians(model, before[free], compiled)
    return result


def growth_bound(groups: Groups[float], cycle: SimulatedMotion) -> float:
    """Bound the error of a cycle's `growth` by rounding, and by the error of its impacts that its residual implies.

    Phase, flight and velocity of each impact are moved a little one at a time, and the changes of the multiplier are
    added up, so that none can cancel another's. Zero where the ball sticks, for then the multiplier is zero.
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
        return float(abs(multipliers(np.trace(matrix) * exp(min(scale, STEEPEST)), determinant)[0]))

    base, slopes = grown(rows), 0.0
    for row in range(n):
        for column in (PHASE, FLIGHT, VELOCITY):
            moved = rows.copy()
            moved[row, column] += MOVED
            slopes += abs(grown(moved) - base) / MOVED
    # Newton's residual is that of one lap: the fixed point is as far as the geometric series of all laps to come.
    error = cycle.residual / max(abs(1 - cycle.growth), MOVED) + 16 * EPS
    return 2 * slopes * error + 32 * n * EPS * max(base, 1.0)


def product(matrices: Array) -> tuple[Array, float]:
    """Product of a chain of matrices (n, 2, 2), the last one leftmost: scaled to norm 1, and the norm's logarithm."""
    chain, scale = matrices, 0.0
    # Neighbours are multiplied pairwise, all at once: as many products, in log2(n) operations on arrays. Each is
    # scaled, as those of a chaotic motion overflow after some hundreds.
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
    """Largest Lyapunov exponent per forcing period over impacts (n, 6) since the ball last stuck; nan without any."""
    stuck = np.flatnonzero(rows[:, RIDING] + rows[:, SETTLING] > 0)
    free = rows[stuck[-1] + 1 :] if len(stuck) else rows[rows[:, WALL] != 0]
    span = float(np.sum(free[1:, FLIGHT]))
    return chain_growth(model, free, compiled) / (span / 2) if span > 0 else nan


def recurrences(rows: Array) -> list[int]:
    """Candidates for the number of impacts in a cycle, ascending: the last one nearly repeats the one so many ago."""
    last, past = rows[-1], rows[-2 : -MAX_IMPACTS - 2 : -1]
    apart = separation(past[:, PHASE] - last[PHASE], past[:, VELOCITY] - last[VELOCITY])
    lengths: list[int] = (np.flatnonzero((apart < NEAR) & (past[:, WALL] == last[WALL])) + 1).tolist()
    return lengths[:CANDIDATES]


def refine(model: Array, rows: Array, length: int, compiled: bool = True) -> SimulatedMotion | None:
    """Solve for the periodic motion of some impacts near the end of a trajectory, by Newton's method on the return map.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    rows : array (n, 6)
        Impacts, see `kernel`.
    length : int
        Impacts of one period, at most n.
    compiled : bool
        Whether to compile the search, where numba is there.

    Returns
    -------
    SimulatedMotion or None
        None if the iteration leaves the word it began with, sticks, or stops short of `RESIDUAL_TOL`.
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
        if residual <= ROUNDED or abs(np.linalg.det(system)) < RESIDUAL_TOL:
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
    # Friction that stops the ball on its way reduces the determinant, which is the product of r^2 otherwise.
    determinant = float(np.linalg.det(matrix)) if rubs(model) else _determinant(model, lap[1:])
    larger, smaller = multipliers(np.trace(matrix), determinant).tolist()
    return _cycle(lap[1:], residual, (larger, smaller))


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


def laps(rows: Array, released: bool = False) -> list[slice]:
    """The first lap from each membrane that releases the ball twice in one state, the bottom first.

    From one state the ball always moves alike: one lap shows that the motion is periodic. If so much happens in it that
    rounding alone decides when the next ride comes, its cycle still cannot be computed.

    Parameters
    ----------
    rows : array (n, 6)
        Impacts, see `kernel`.
    released : bool
        Whether the first row is the start of a ball that a membrane releases there.

    Returns
    -------
    list of slice
        Rows of each lap: after the impact whose ride ends with the release, up to the next one.
    """
    rides = _rides(rows, released)
    if len(rides) < 2:
        return []
    states, of_walls = releases(rows[rides]), []
    again = np.tril(same_release(states[:, None], states), -1)
    for wall in (BOTTOM, TOP):
        second = np.flatnonzero(again.any(axis=1) & (states[:, 0] == wall))[:1]
        of_walls += [slice(rides[np.argmax(again[k])] + 1, rides[k] + 1) for k in second]
    return of_walls


def _rides(rows: Array, released: bool = False) -> NDArray[np.intp]:
    """Rows of impacts after which the ball rides on a membrane and is released; parameters are those of `laps`."""
    rides = (rows[:, RIDING] > 0) & np.isfinite(rows[:, RIDING])
    rides[:1] |= released
    return np.flatnonzero(rides)


def releases(rows: Array) -> Array:
    """Wall and phase of the releases, (k, 2), from the k impacts before the rides that they end."""
    return np.stack([rows[:, WALL], rows[:, PHASE] + pi * (rows[:, SETTLING] + rows[:, RIDING])], axis=1)


def released(rows: Array) -> Array:
    """Wall and phase of all releases, (k, 2), during some impacts."""
    return releases(rows[_rides(rows)])


def same_release(states: Array, others: Array) -> NDArray[np.bool_]:
    """Whether releases are in one state, by wall and phase: a force with harmonics may have several a period."""
    late = np.abs(wrapped(states[..., 1] - others[..., 1]))
    return np.asarray((states[..., 0] == others[..., 0]) & (late < SAME_RELEASE))


def rest_cycle(model: Array, lap: Array, compiled: bool = True) -> SimulatedMotion | None:
    """The cycle of a ball that rides on a membrane once a lap; None where rounding decides how the lap goes.

    This is decided by the growth of rounding over the lap or, where that is too large, by twins of the lap that start a
    few roundings away: they must end in the same ride.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    lap : array (n, 6)
        Impacts since the release, up to the one after which the ball rides.
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
    """The cycle that the last impacts of a trajectory nearly repeat: one that attracts, or a repelling one they are on.

    Parameters
    ----------
    model : array (6 + 3 h,)
        A row of `check_model`.
    rows : array (n, 6)
        Impacts, see `kernel`.
    compiled : bool
        Whether to compile the search, where numba is there.
    """
    repelling = None
    for length in recurrences(rows):
        cycle = refine(model, rows, length, compiled)
        distance = cycle.distance(rows[-1]) if cycle is not None else inf
        if cycle is not None and cycle.growth < 1 and distance < REACH:
            return cycle
        if distance <= ON_IT:
            repelling = repelling or cycle
    return repelling


def attracting(ball: Trajectory) -> SimulatedMotion | None:
    """The attracting cycle that the last impacts of a ball nearly repeat, and so surely approach; None without one."""
    cycle = approached(ball.model, ball.rows, ball.compiled)
    return cycle if cycle is not None and cycle.growth < 1 else None


Struck = tuple[str, float, bool]
"""The letter of an impact, its speed, and whether the ball settles or rides after it."""


def word_of(rows: Array) -> list[str]:
    """Letters of the impacts; ever slower hops that end in a ride are one letter with a tilde."""
    return _letters(_struck(rows))


def _struck(rows: Array) -> list[Struck]:
    """Letters, speeds and stays of impacts as plain numbers: arrays are slow to spell every rotation of a cycle by."""
    stays = (rows[:, RIDING] + rows[:, SETTLING] > 0).tolist()
    walls = ["B" if wall > 0 else "T" for wall in rows[:, WALL].tolist()]
    return list(zip(walls, np.abs(rows[:, VELOCITY]).tolist(), stays, strict=True))


def _letters(impacts: Sequence[Struck]) -> list[str]:
    """The letters of impacts as `word_of` spells them."""
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
    """Logarithm of the factor by which a small deviation grows from the first of some impacts (n, 6) to the last."""
    plain = rows.copy()
    # Time on a membrane after the first impact is over by then: it must not make the derivative zero.
    plain[:, [SETTLING, RIDING]] = 0.0
    return product(jacobians(model, plain[:-1], plain[1:], compiled))[1] if len(rows) > 1 else 0.0


def _cycle(rows: Array, residual: float, eigenvalues: tuple[complex, complex]) -> SimulatedMotion:
    """One period, begun where its word is alphabetically first; where several begin so, at the fastest impact."""
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
