"""The least kicks that lead out of a motion: of all sequences of kicks the one with the least sum of squares.

With independent normal kicks of standard deviation sigma the density of a sequence k is proportional to exp(-sum k^2 /
(2 sigma^2)). For small sigma the most probable of all sequences that lead out gives the rate of escape, up to a factor
that is not exponential: ln T = a + Q/sigma^2, Q being half the least sum of squares (Freidlin and Wentzell, for a map
with kicks).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import pi

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.findings.outcomes.impact_map import forwards
from vireport.findings.outcomes.returning import Core, endings
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import ARRAYS, IMAGINARY_STEP
from vireport.simulation.events import check_model, follow_impacts
from vireport.simulation.kernel import FLIGHT, TURN, VELOCITY, WALL

Floats = NDArray[np.float64]

SIZES, EDGES = 400, 3
"""Sizes of a single kick that are tried, up to the largest impact velocity; most edges of the basin used among them."""

SECTIONS, NARROWEST = 33, 4e-16
"""Parts into which the bracket of an edge is cut in a step, and its width at the end [y_c], which is rounding."""

TOGETHER, LONGEST = 1e-5, 600
"""Difference [t_c, y_c] up to which two balls on either side of an edge count as on it; impacts they are followed."""

LEAD, MOST_LEAD, SETTLED = 8, 1024, 1e-4
"""Periods of the motion before the single kick, at first and at most; relative fall of Q at which more do not help."""

STEPS, CONVERGED = 300, 1e-11
"""Steps of the minimisation at most, and the relative fall of the sum at which it ends."""

ARRIVES = 1e-6
"""Difference of times [t_c] within which the simulation must find the impacts of a path again."""


class KickedPath(Struct, frozen=True, eq=False):
    """Impacts from a motion to the edge of its basin, with the kicks that lead there.

    Attributes
    ----------
    walls : ndarray of int (n,)
        The membrane of each impact: 1 bottom, -1 top.
    time : ndarray (n,)
        Of the impacts [t_c]; the forcing phase is pi times that.
    kicks : ndarray (n - 2,)
        Added to the velocity just after each impact but the first and the last one [y_c].
    """

    walls: NDArray[np.int64]
    time: Floats
    kicks: Floats

    __repr__ = brief

    @property
    def exponent(self) -> float:
        """Half the sum of the squared kicks, Q [y_c^2]."""
        return 0.5 * float(self.kicks @ self.kicks)


class LeastKicks(Struct, frozen=True, eq=False):
    """The way out of a motion with the least kicks that were found: a local minimum, so that Q is an upper bound.

    Attributes
    ----------
    path : KickedPath or None
        None where the simulation confirms none that takes less than the single kick.
    shock : float
        Least single kick found just after an impact that leads out [y_c]; half its square is at least Q of the path.
    """

    path: KickedPath | None
    shock: float

    __repr__ = brief


def kicked(groups: Groups[float], walls: Floats, before: Floats, kicks: Floats | float) -> Floats:
    """Velocities before impacts, (n,) [y_c], that without a kick are followed by the same flights as some with a kick.

    A kick that drives the ball back onto the membrane makes it strike once more at once; no kick follows this impact.
    """
    r = np.where(walls > 0, groups.restitution_at(1), groups.restitution_at(-1))
    after = -r * before + kicks
    return np.asarray(np.where(walls * after < 0, -after / r, after))


def leaving(groups: Groups[float], rows: Floats, cores: Sequence[Core]) -> NDArray[np.bool_]:
    """Which starts, rows of `check_start`, do not return to the motion of the first core, undisturbed."""
    return np.asarray(endings(groups, rows, cores) != 0)


def impact_rows(walls: Floats | int, phase: Floats | float, before: Floats) -> Floats:
    """Rows of `check_start`, (n, 4), for impacts at a forcing phase [rad] with a velocity just before [y_c]."""
    rows = np.zeros((len(before), 4))
    # The first remainder of a phase just below 0 is rounded up to a whole turn, which is refused for a start.
    rows[:, 0], rows[:, 2], rows[:, 3] = walls, before, np.mod(phase, TURN) % TURN
    return rows


def least_kicks(groups: Groups[float], cores: Sequence[Core]) -> LeastKicks | None:
    """Find the sequence of kicks with the least sum of squares that leads out of the motion of the first core.

    Parameters
    ----------
    groups : Groups
        Of the device; without friction, as flights are parabolas and cosines here.
    cores : sequence of Core
        Of the stable motions that are known.

    Returns
    -------
    LeastKicks or None
        None where no single kick that was tried leads out.

    Notes
    -----
    The times of two impacts determine the flight between them, with its velocities at both ends. So a path is a list of
    times. A kick is what the rebound lacks for the next flight, and depends on three successive times: a least-squares
    problem without constraints. The first flight is one of the motion; the last one follows the edge of its basin, onto
    which a single kick takes the ball. As balls on both sides of the edge stay together for a while, bisection finds
    that kick. Several single kicks serve as first guesses. The longer the path, the smaller the sum.
    """
    paths, shocks = [], []
    for shock, impact, walls, time in edge_shocks(groups, cores):
        shocks.append(shock)
        path = _settled(groups, cores[0].motion, impact, walls, time)
        if path is not None and _is_flown(groups, path):
            paths.append(path)
    if not shocks:
        return None
    least, path = min(shocks), min(paths, key=lambda path: path.exponent, default=None)
    # The single kick is a sequence, too: what takes more than that is not the least, and would promise too much.
    return LeastKicks(None if path is None or path.exponent > least**2 / 2 else path, least)


def edge_rows(groups: Groups[float], motion: Motion) -> Floats:
    """Starts just after single kicks of all sizes that are tried, rows of `check_start` (n, 4)."""
    return np.concatenate([_knocked(groups, motion, *way)(_sizes(motion)) for way in _ways(motion)])


def _sizes(motion: Motion) -> Floats:
    return float(np.abs(motion.velocity).max()) * np.arange(SIZES + 1) / SIZES


def _ways(motion: Motion) -> Iterator[tuple[int, float]]:
    """The impacts of a motion, each with either sign of a kick."""
    return ((impact, sign) for impact in range(len(motion.word)) for sign in (1.0, -1.0))


def _knocked(groups: Groups[float], motion: Motion, impact: int, sign: float) -> Callable[[Floats], Floats]:
    """A function from sizes of a kick [y_c] just after an impact of a motion to starts, rows of `check_start`."""

    def start(size: Floats) -> Floats:
        walls = np.full(len(size), float(motion.word.walls[impact]))
        before = kicked(groups, walls, np.full(len(size), motion.velocity[impact]), sign * size)
        return impact_rows(walls, motion.phase[impact], before)

    return start


def edge_shocks(groups: Groups[float], cores: Sequence[Core]) -> Iterator[tuple[float, int, NDArray[np.int64], Floats]]:
    """Single kicks just after impacts that bring the ball onto the edge of the basin, and the ball's way along it.

    Yields
    ------
    shock : float
        Size of the kick [y_c].
    impact : int
        Index of the motion's impact just before the kick.
    walls, time : ndarray (n,)
        Membranes and times [t_c] of that impact and those that follow.
    """
    motion, sizes = cores[0].motion, _sizes(cores[0].motion)
    for impact, sign in _ways(motion):
        start, wall = _knocked(groups, motion, impact, sign), motion.word.walls[impact]
        out = leaving(groups, start(sizes), cores)
        # Kicks that drive the ball back onto the membrane begin no flight.
        usual = sign * wall * sizes < abs(float(groups.after(wall, motion.velocity[impact])))
        for k in np.flatnonzero(out[1:] & ~out[:-1] & usual[1:])[:EDGES]:
            low, high = float(sizes[k]), float(sizes[k + 1])
            while high - low > NARROWEST:
                between = np.linspace(low, high, SECTIONS + 1)
                first = int(np.argmax([*leaving(groups, start(between[1:-1]), cores), True]))
                if between[first] == low and between[first + 1] == high:
                    break
                low, high = float(between[first]), float(between[first + 1])
            yield high, impact, *_along_edge(groups, start(np.array([low, high])), float(motion.time[impact]))


def _along_edge(groups: Groups[float], starts: Floats, begins: float) -> tuple[NDArray[np.int64], Floats]:
    """Membranes and times [t_c], (n,), of the impacts that two balls on either side of an edge have in common."""
    rows, _ = follow_impacts(np.repeat(check_model(groups), 2, axis=0), starts, LONGEST)
    time = np.cumsum(rows[:, :, FLIGHT], axis=1)
    apart = np.maximum(np.abs(time[0] - time[1]), np.abs(rows[0, :, VELOCITY] - rows[1, :, VELOCITY]))
    alike = (rows[0, :, WALL] == rows[1, :, WALL]) & (apart < TOGETHER)
    count = int(np.argmin([*alike, False]))
    return rows[0, :count, WALL].astype(np.int64), begins + time[0, :count]


def _settled(
    groups: Groups[float], motion: Motion, impact: int, walls: NDArray[np.int64], time: Floats
) -> KickedPath | None:
    """The least kicks near a single one: periods of the motion are put before it until Q falls no more."""
    if len(time) < 4:
        return None
    period, lead, before = 2 * motion.word.periods, LEAD, np.inf
    # The motion's impacts up to the one of the kick, which the path itself begins with.
    of_period = np.roll(np.array(motion.word.walls), -impact)
    times = np.roll(motion.time, -impact) + period * (np.arange(len(of_period)) >= len(of_period) - impact)

    def led(count: int, walls: NDArray[np.int64], time: Floats) -> tuple[NDArray[np.int64], Floats]:
        earlier = time[0] - times[0] + np.concatenate([times - period * k for k in range(count, 0, -1)])
        return np.concatenate([np.tile(of_period, count), walls]), np.concatenate([earlier, time])

    walls, time = led(lead, walls, time)
    while True:
        time, kicks = _least_squares(groups, walls, time)
        path = KickedPath(walls, time, kicks)
        if path.exponent > (1 - SETTLED) * before or lead >= MOST_LEAD:
            return path
        before = path.exponent
        walls, time = led(lead, walls, time)
        lead *= 2


def kicks_along(groups: Groups[float], walls: NDArray[np.int64], time: Floats) -> Floats:
    """The kicks, (n - 2,) [y_c], that take a ball through impacts at times (n,) [t_c]; complex for complex times."""
    begun, now = (groups.wave(pi * part, ARRAYS) for part in (time[:-1], time[1:]))
    elapsed = time[1:] - time[:-1]
    covered, gained = groups.flown(elapsed, 0.0, begun, now)
    after = (np.diff(walls) * groups.d / 2 - covered) / elapsed
    r = np.where(walls[1:-1] > 0, groups.restitution_at(1), groups.restitution_at(-1))
    return np.asarray(after[1:] + r * (after + gained)[:-1])


def _derivatives(groups: Groups[float], walls: NDArray[np.int64], time: Floats) -> Floats:
    """Derivatives of each kick by the times of the impact before its own, of its own and of the next, (3, n - 2)."""
    rows = np.arange(len(time) - 2)
    by = np.empty((3, len(rows)))
    for colour in range(3):
        stepped = time.astype(complex)
        stepped[colour::3] += 1j * IMAGINARY_STEP
        slopes = kicks_along(groups, walls, stepped).imag / IMAGINARY_STEP
        by[(colour - rows) % 3, rows] = slopes
    return by


def _least_squares(groups: Groups[float], walls: NDArray[np.int64], time: Floats) -> tuple[Floats, Floats]:
    """Times with the least sum of squared kicks, and the kicks, by Levenberg-Marquardt; two times at each end stay."""
    from scipy.linalg import solveh_banded  # type: ignore[import-untyped]

    free, damping = slice(2, len(time) - 2), 1e-3
    kicks = kicks_along(groups, walls, time)
    for _ in range(STEPS):
        by, count = _derivatives(groups, walls, time), len(time)
        normal, gradient = np.zeros((3, count)), np.zeros(count)
        # Kick i depends on times i, i + 1, i + 2: the normal matrix has five diagonals, of which three are stored.
        for a in range(3):
            gradient[a : a + count - 2] += by[a] * kicks
            for b in range(a, 3):
                normal[2 - (b - a), b : b + count - 2] += by[a] * by[b]
        inner = normal[:, free].copy()
        inner[0, :2] = inner[1, 0] = 0.0  # products with the times that are held
        while True:
            damped = inner.copy()
            damped[2] *= 1 + damping
            step = np.zeros(count)
            step[free] = -solveh_banded(damped, gradient[free])
            with np.errstate(all="ignore"):
                stepped = kicks_along(groups, walls, time + step)
            ordered = (np.diff(time + step) > 0).all()
            fall = 1 - float(stepped @ stepped) / float(kicks @ kicks) if ordered else -1.0
            if fall > 0 or damping > 1e12:
                break
            damping *= 8
        if not fall > 0:
            break
        time, kicks, damping = time + step, stepped, max(damping / 4, 1e-12)
        if fall < CONVERGED:
            break
    return time, kicks


def _is_flown(groups: Groups[float], path: KickedPath) -> bool:
    """Whether the simulation finds the impacts of a path again: no flight meets a membrane before its end."""
    before = path.time[:-1]
    begun, now = (groups.wave(pi * part, ARRAYS) for part in (before, path.time[1:]))
    elapsed = np.diff(path.time)
    covered, _ = groups.flown(elapsed, 0.0, begun, now)
    after = (np.diff(path.walls) * groups.d / 2 - covered) / elapsed
    if (path.walls[:-1] * after >= 0).any():
        return False
    ends = forwards(groups, path.walls[:-1], before, after, compiled=True)
    return bool(((ends.wall == path.walls[1:]) & (np.abs(ends.time - path.time[1:]) < ARRIVES)).all())
