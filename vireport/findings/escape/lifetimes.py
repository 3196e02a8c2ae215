"""How long a motion lasts under random kicks of one size, by simulation of many balls in lockstep.

A ball has left when its undisturbed continuation after a kick would not return. Whether it would is looked up on a grid
over the impacts about the motion; where the grid does not clearly say that it returns, the ball is followed.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, inf, log, pi, sqrt

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.base.shares import OUTSIDE
from vireport.findings.escape.least_kicks import impact_rows, kicked, leaving
from vireport.findings.outcomes.deviations import chained, flight_matrices, growth, kick_effects, spread_by
from vireport.findings.outcomes.returning import Core
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import wrapped
from vireport.simulation.events import check_model, follow_impacts
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, VELOCITY, WALL

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

CELLS, REACH = 128, 6.0
"""Cells of the grid along either axis, and its half width in standard deviations of the linear spread."""

UNKNOWN, BOUNDARY, RETURNS = -1, 0, 1
"""What is known of a cell of the grid or of its corner."""

BALLS, ESCAPES = 4096, 1000
"""Balls that are followed together, and escapes after the transient that are enough: a mean is known to 3 %."""

CHECKED = 64
"""One in so many of the impacts that the grid says to return is followed as a check."""

PAST = 0.01
"""Share of a small disturbance that is left after the transient."""

GROUPS, FEWEST = 10, 50
"""Most groups of periods in which escapes are counted, and fewest escapes for which their rates are compared."""


class ReturnGrid:
    """Which impacts about a motion return to it, undisturbed: a grid that is filled where it is asked.

    A cell counts as one of return only if it and the cells about it have corners that all return; all other impacts
    are followed. So no ball is said to have left that was not followed, and a part of the basin's outside is passed
    over only where it is thinner than a cell. A cell in which a check finds an impact that leaves is followed from then
    on.

    Attributes
    ----------
    followed : int
        Impacts that were followed as the grid does not say that they return.
    checked, wrong : int
        Impacts in cells of return that were followed to check these, and how many of them do not return.
    """

    def __init__(self, groups: Groups[float], cores: Sequence[Core], kick: float) -> None:
        self.groups, self.cores, self.motion = groups, cores, cores[0].motion
        self.followed = self.checked = self.wrong = 0
        self.half = _reach(groups, self.motion, kick)
        self.corner = np.full((len(self.half), CELLS + 3, CELLS + 3), UNKNOWN, dtype=np.int8)
        self.cell = np.full((len(self.half), CELLS, CELLS), UNKNOWN, dtype=np.int8)

    def leaving(self, rows: Floats) -> Mask:
        """Which impacts, rows of `check_start` (n, 4), do not return: a mask (n,)."""
        cells = np.full(len(rows), -1)
        for impact, wall in enumerate(self.motion.word.walls):
            at = np.flatnonzero(rows[:, 0] == wall)
            off = np.stack([wrapped(rows[at, 3] - self.motion.phase[impact]) / pi, rows[at, 2]])
            off[1] -= self.motion.velocity[impact]
            place = (off / self.half[impact][:, None] + 1) * (CELLS / 2)
            inside = ((place >= 0) & (place < CELLS)).all(axis=0)
            column, row = place[:, inside].astype(np.intp)
            unknown = self.cell[impact, column, row] == UNKNOWN
            if unknown.any():
                self._fill(impact, wall, np.unique(column[unknown] * CELLS + row[unknown]))
            cells[at[inside]] = (impact * CELLS + column) * CELLS + row
        state = self.cell.reshape(-1)
        known = (cells >= 0) & (state[cells] == RETURNS)
        out, doubtful, trusted = np.zeros(len(rows), dtype=bool), np.flatnonzero(~known), np.flatnonzero(known)
        # Some of the impacts that the grid says to return are followed as well.
        some = trusted[::CHECKED]
        asked = np.concatenate([doubtful, some])
        if len(asked):
            out[asked] = leaving(self.groups, rows[asked], self.cores)
        wrong = some[out[some]]
        state[cells[wrong]] = BOUNDARY
        self.followed, self.checked, self.wrong = (
            self.followed + len(doubtful),
            self.checked + len(some),
            self.wrong + len(wrong),
        )
        return out

    def _fill(self, impact: int, wall: int, cells: NDArray[np.intp]) -> None:
        """Label some cells of an impact by their corners and those of the cells about them."""
        offsets = np.arange(4)
        column, row = (
            part[:, None, None] + shift
            for part, shift in zip(np.divmod(cells, CELLS), (offsets[:, None], offsets[None]), strict=True)
        )
        column, row = np.broadcast_arrays(column, row)
        needed = np.unique(column * (CELLS + 3) + row)
        new = needed[self.corner[impact].ravel()[needed] == UNKNOWN]
        at = (np.stack(np.divmod(new, CELLS + 3)) - 1) * (2 / CELLS) - 1
        time, speed = at * self.half[impact][:, None]
        phase, velocity = self.motion.phase[impact] + pi * time, self.motion.velocity[impact] + speed
        # A velocity away from the membrane belongs to no impact.
        label, possible = np.full(len(new), BOUNDARY, dtype=np.int8), wall * velocity > 0
        rows = impact_rows(wall, phase[possible], velocity[possible])
        label[possible] = np.where(leaving(self.groups, rows, self.cores), BOUNDARY, RETURNS)
        self.corner[impact].ravel()[new] = label
        agree = (self.corner[impact, column, row] == RETURNS).all(axis=(1, 2))
        self.cell[impact].ravel()[cells] = np.where(agree, RETURNS, BOUNDARY)


def _reach(groups: Groups[float], motion: Motion, kick: float) -> Floats:
    """Half widths of the grid in time [t_c] and velocity [y_c] at each impact, (N, 2), by the linear spread."""
    matrices, effects = flight_matrices(groups, motion), kick_effects(groups, motion)
    spreads = spread_by(matrices, effects[:, :, None] * effects[:, None, :])
    # A kick k just after an impact acts as a deviation k/r of the velocity just before it.
    variances = spreads.diagonal(axis1=1, axis2=2).copy()
    variances[:, 1] += [groups.restitution_at(wall) ** -2 for wall in motion.word.walls]
    half = REACH * kick * np.sqrt(variances)
    # 1 t_c either way holds all phases; wider cells would hold more than one part of the basin.
    return np.asarray(np.minimum(half, [1.0, float(np.abs(motion.velocity).max())]))


class Lifetime(Struct, frozen=True, eq=False):
    """How long balls stayed with a motion under kicks of one size; times in forcing periods.

    Attributes
    ----------
    kick : float
        Standard deviation of the kicks [y_c].
    transient : float
        Time after which little is left of how the balls began.
    escaped : ndarray (n,)
        Times of the escapes, in order of the number of impacts.
    laps : ndarray of int (n,)
        Whole periods of the motion from the end of the transient to each escape; negative within the transient.
    staying : ndarray (m,)
        Times up to which the balls that did not escape were followed.
    followed_laps : int
        Whole periods of the motion after the transient through which all of these were followed.
    left : ndarray (n, 4)
        The impacts, rows of `check_start`, after which the balls that escaped do not return.
    impacts : int
        Number of impacts simulated in all.
    """

    kick: float
    transient: float
    escaped: Floats
    laps: NDArray[np.int64]
    staying: Floats
    followed_laps: int
    left: Floats
    impacts: int

    __repr__ = brief

    @property
    def late(self) -> int:
        """Number of escapes after the transient."""
        return int((self.escaped > self.transient).sum())

    @property
    def mean(self) -> float:
        """Mean time to escape; inf where no ball escaped after the transient but some stayed longer."""
        return self._estimate()[0]

    @property
    def error(self) -> float:
        """Standard error of the logarithm of the mean."""
        mean, error = self._estimate()
        return error / mean

    @property
    def interval(self) -> tuple[float, float]:
        """The ends of the 95 % interval of the mean."""
        from scipy.special import gammaincinv  # type: ignore[import-untyped]

        mean, error = self._estimate()
        if mean == inf:  # at this rate, as few escapes in all of that time have a probability of 2.5 %
            followed = float(self.escaped.sum() + self.staying.sum())
            return followed / float(gammaincinv(len(self.escaped) + 1, 1 - OUTSIDE)), inf
        # So many exponential times have a mean with this relative error.
        count = (mean / error) ** 2
        low, high = (mean * count / float(gammaincinv(count, end)) for end in (1 - OUTSIDE, OUTSIDE))
        return low, high

    def _estimate(self) -> tuple[float, float]:
        """The mean time and its standard error.

        Up to the end of the transient, the times are taken as observed. After it, the mean time is the total time that
        all balls spent, those that stayed included, divided by the number of escapes.
        """
        every = np.concatenate([self.escaped, self.staying])
        later = np.maximum(every - self.transient, 0.0)
        passes = later > 0
        # Balls that were followed in the transient alone tell nothing of what comes after it.
        if not self.late and len(self.staying):
            return inf, inf
        residual = float(later.sum()) / self.late if self.late else 0.0
        part = np.minimum(every, self.transient) + residual * passes
        # The time up to the end of the transient and the time from there on are independent.
        variance = float(part.var()) / len(every)
        if self.late:
            variance += (float(passes.mean()) * residual) ** 2 / self.late
        return float(part.mean()), sqrt(variance)

    @property
    def p_value(self) -> float | None:
        """Probability that escapes at a constant rate after the transient fit one no better; None of under `FEWEST`.

        By the chi-square of the escapes in up to `GROUPS` groups of periods, each with about as many. Whole periods are
        counted, as most balls may leave after one of the impacts; a constant rate makes the times exponential.
        """
        from scipy.special import chdtrc

        counts = np.bincount(self.laps[(self.laps >= 0) & (self.laps < self.followed_laps)])
        total = int(counts.sum())
        if total < FEWEST:
            return None
        before = np.cumsum(counts) - counts
        at_risk = len(self.staying) + int((self.laps >= 0).sum()) - before
        rate = total / float(at_risk.sum())
        group = np.minimum(before * GROUPS // total, GROUPS - 1)
        seen, spent = np.bincount(group, counts), np.bincount(group, at_risk)
        used = spent > 0
        expected = rate * spent[used]
        square = float(((seen[used] - expected) ** 2 / (expected * (1 - rate))).sum()) if rate < 1 else 0.0
        return float(chdtrc(used.sum() - 1, square)) if used.sum() > 1 else None


def lifetime(
    grid: ReturnGrid, kick: float, seed: int, budget: int, escapes: int = ESCAPES, balls: int = BALLS
) -> Lifetime:
    """Follow balls from a motion under kicks until enough of them have left it.

    Parameters
    ----------
    grid : ReturnGrid
        Of the motion.
    kick : float
        Standard deviation of the normal kicks [y_c], added to the velocity just after each impact from the second one
        on, independent of one another.
    seed : int
        Of the kicks.
    budget : int
        Number of simulated impacts, of all balls together, after which no further escape is waited for.
    escapes : int
        Number of escapes after the transient that are enough.
    balls : int
        Number of balls, all of which begin at the first impact of the motion.
    """
    groups, motion, random = grid.groups, grid.motion, np.random.default_rng(seed)
    laps = transient_laps(groups, motion)
    model, count = np.repeat(check_model(groups), balls, axis=0), len(motion.word)
    states = np.repeat(impact_rows(motion.word.walls[0], motion.phase[:1], motion.velocity[:1]), balls, axis=0)
    age, step, impacts, late = np.zeros(balls), 0, 0, 0
    times, before, left = [np.zeros(0)], [np.zeros(0, dtype=np.int64)], [np.zeros((0, 4))]
    while len(states) and impacts < budget and (late < escapes or step < (laps + GROUPS) * count):
        rows, _ = follow_impacts(model[: len(states)], states, 1, 2)
        impacts, step, last = impacts + len(states), step + 1, rows[:, 1]
        age = age + (rows[:, 1, FLIGHT] + rows[:, 0, SETTLING] + rows[:, 0, RIDING]) / 2
        kicks = kick * random.standard_normal(len(last))
        states = impact_rows(last[:, WALL], last[:, PHASE], kicked(groups, last[:, WALL], last[:, VELOCITY], kicks))
        out = grid.leaving(states)
        if out.any():
            times.append(age[out])
            before.append(np.full(int(out.sum()), (step - 1) // count - laps))
            left.append(states[out])
            late += int(out.sum()) if before[-1][0] >= 0 else 0
            states, age = states[~out], age[~out]
    transient = float(laps * motion.word.periods)
    # Where all balls have left, the last period is not cut off.
    whole = step // count - laps if len(states) else step
    parts = np.concatenate(times), np.concatenate(before), age, whole, np.concatenate(left)
    return Lifetime(kick, transient, *parts, impacts)


def transient_laps(groups: Groups[float], motion: Motion) -> int:
    """Whole periods of a motion until only `PAST` of a small disturbance is left; at least 1."""
    slowest = growth(chained(flight_matrices(groups, motion)))
    return max(ceil(log(PAST) / log(slowest)), 1) if slowest > 0 else 1
