"""Attractors of the simulated motion: for one start, or for many parameters and starts at once.

Turns parameters and starts into cycles that are verified, or into the answer that none was reached.
The transient is not a fixed number of impacts: near a critical point it lasts ln(tolerance)/ln|multiplier|
periods.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from enum import StrEnum
from math import ceil, inf, log, nan
from typing import Any

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.physics.groups import Groups
from vireport.physics.word import word_name
from vireport.simulation import cycles
from vireport.simulation.cycles import SimulatedMotion
from vireport.simulation.events import (
    Start,
    check_model,
    check_start,
    follow_impacts,
    start_rows,
)
from vireport.simulation.follower import Trajectory
from vireport.simulation.kernel import (
    CREEPING,
    FLIGHT,
    FREE,
    HELD,
    PHASE,
    REST,
    VELOCITY,
    WALL,
)

Array = NDArray[np.float64]

# First impacts to look for recurrences in; doubled until the budget is used up.
BLOCK = 512
# Impacts kept for recurrences and Lyapunov exponents.
KEPT = 4096
# A transient has ended at this distance from the cycle, in phase [rad] and velocity [y_c].
SETTLED = 1e-9
# Below this multiplier one more period is all that is needed.
FAST = 1e-3
# Of a trajectory cut before it has settled: if it came closer by less than this, it is not on its way.
SLOWER = 0.9
# This close, in phase [rad] and velocity [y_c], it is on its way to a cycle that attracts even so: towards r = 1 it
# winds around it for millions of periods, now nearer and now farther.
BESIDE = 1e-5
# After a flight longer than this [t_c] rounding leaves less than three digits of the forcing phase.
LONGEST_FLIGHT = 1e12
# Impacts kept of a motion that is not periodic, and those of them that a diagram shows.
LAST, DRAWN = 256, 64
# Impacts until a slow approach to a cycle is given up.
BUDGET = 200_000
# Relative change of velocity that takes a start off an orbit that repels.
NUDGE = 1e-6


class Outcome(StrEnum):
    """The ways in which a trajectory ends."""

    PERIODIC = "periodic"
    APERIODIC = "chaotic, or not periodic within the budget"
    STICKING = "chatter with sticking, periodic"
    REST = "at rest on the bottom membrane"
    HELD = "held by friction for ever, off the bottom membrane"
    CREEPING = "creeping under friction: it stops so often on its way that it is not followed to its end"
    FREE = "in flight between the membranes for ever, reaching neither"
    UNRESOLVED = "not resolved: flights so long that rounding loses the forcing phase"


STOPPED: dict[float, tuple[Outcome, None, float, float]] = {
    REST: (Outcome.REST, None, -inf, 0.0),
    HELD: (Outcome.HELD, None, -inf, 0.0),
    CREEPING: (Outcome.CREEPING, None, nan, inf),
    FREE: (Outcome.FREE, None, nan, 0.0),
}
"""Of a ball that strikes a membrane no more, by the search's status: what it comes to, and an attractor's numbers."""

STOPS = Outcome.REST, Outcome.HELD, Outcome.FREE
"""Outcomes that are told without any impacts."""


def motion_name(outcome: Outcome, word: str, period: int) -> str:
    """The word of a motion and its period, or what the motion is where it has none."""
    if not word:
        return outcome.value
    return word_name(word, period)


class Attractor(Struct, frozen=True, eq=False):
    """The motion or state that a start leads to.

    Parameters
    ----------
    outcome : Outcome
        Its kind.
    cycle : SimulatedMotion or None
        One period, verified on the return map, if it is periodic; None of a motion with rest that is so long that
        rounding does not tell it.
    lyapunov : float
        Largest Lyapunov exponent per forcing period: of the cycle, or of the last impacts of a motion that is
        not periodic. -inf where the ball comes to rest, nan where it meets no membrane again or is not resolved.
    distance : float
        From the last impact to the cycle, in phase [rad] and velocity [y_c]. Large only if the budget ended a
        transient that was still approaching it.
    impacts : int
        Impacts simulated.
    last : array (n, 3)
        Wall, phase [rad] and velocity [y_c] of the last ones of a motion without a cycle, at most `LAST`.
    """

    outcome: Outcome
    cycle: SimulatedMotion | None
    lyapunov: float
    distance: float
    impacts: int
    last: Array = field(default_factory=lambda: np.empty((0, 3)))

    __repr__ = brief

    @property
    def word(self) -> str:
        """Impacts of one period, such as BTBBT; empty if it is not periodic."""
        return self.cycle.word if self.cycle else ""

    @property
    def period(self) -> int:
        """Period of the motion in forcing periods; 0 if it is not periodic."""
        return self.cycle.period if self.cycle else 0

    @property
    def name(self) -> str:
        """The word and its period, or what the motion is where it has none."""
        return motion_name(self.outcome, self.word, self.period)


class Diagram(Struct, frozen=True, eq=False):
    """Bifurcation diagram found by simulation alone: one entry per impact that is drawn.

    Parameters
    ----------
    index : array of int
        Which parameter.
    wall, phase, velocity : array
        The impact.
    label : array of int
        Index into `labels`.
    labels : tuple of str or Outcome
        Words, or the outcome where there is no word.
    """

    index: NDArray[np.int64]
    wall: NDArray[np.int8]
    phase: Array
    velocity: Array
    label: NDArray[np.int64]
    labels: tuple[str | Outcome, ...]

    __repr__ = brief


def find_attractor(groups: Groups[float], start: Start, budget: int = BUDGET, compiled: bool = True) -> Attractor:
    """Attractor that one start leads to.

    Parameters
    ----------
    groups : Groups
        Of the device, as numbers.
    start : Impact or InFlight
        State to begin with.
    budget : int
        Impacts to spend at most. Periodic motions use what their transient needs.
    compiled : bool
        Whether to compile the search, where numba is there.
    """
    model = check_model(groups)[0]
    ball = Trajectory.begun(model, check_start(start, groups.d), min(BLOCK, budget), KEPT, compiled)
    return search(ball, budget, budget, [])


def attractors(
    groups: Groups[Any],
    starts: Sequence[Start] | Array,
    impacts: int = 1000,
    budget: int = 20_000,
    workers: int | None = None,
) -> list[tuple[Attractor, ...]]:
    """Attractors that some starts lead to, for each of many parameters.

    Parameters
    ----------
    groups : Groups
        Of devices, as arrays (n,) or numbers, broadcast against each other.
    starts : sequence of Impact or InFlight, or array (n, m, 4)
        Tried at every parameter; or for each parameter its own, as rows of `random_starts`.
    impacts : int
        Simulated of each at once, on all cores.
    budget : int
        Impacts of those that have not settled by then.
    workers : int, optional
        Threads; the number of processors by default. The result does not depend on it.
    """
    model = check_model(groups)
    first = start_rows(starts, model[:, 0])
    n, m = first.shape[:2]
    cores = (os.cpu_count() or 1) if workers is None else workers
    keep = cycles.MAX_IMPACTS + 1
    rows, summary = follow_impacts(np.repeat(model, m, axis=0), first.reshape(n * m, -1), impacts, keep, cores)
    reached = []
    for i in range(n):
        remembered: list[SimulatedMotion] = []
        ends = []
        for k in range(i * m, (i + 1) * m):
            happened = rows[k, max(0, rows.shape[1] - int(summary[k, 0]) - 1) :]
            ends.append(search(Trajectory(model[i], happened, summary[k], KEPT), budget, budget, remembered))
        reached.append(tuple(ends))
    return reached


def diagram(reached: Sequence[Sequence[Attractor]]) -> Diagram:
    """Bifurcation diagram from simulation alone, each impact labelled by the word of its motion.

    Cycles are drawn once; of motions that are not periodic the last `DRAWN` impacts are.

    Parameters
    ----------
    reached : sequence of sequences of Attractor
        For each parameter, what its starts lead to, as from `attractors`.
    """
    labels: dict[str | Outcome, int] = {}
    parts: list[tuple[Array, int, int]] = []
    for i, ends in enumerate(reached):
        drawn: set[int] = set()
        for end in ends:
            label, cycle = labels.setdefault(end.word or end.outcome, len(labels)), end.cycle
            if cycle is None and end.outcome in (Outcome.APERIODIC, Outcome.STICKING):
                parts.append((end.last[-DRAWN:], i, label))
            elif cycle is not None and id(cycle) not in drawn:
                drawn.add(id(cycle))
                parts.append((cycle.impacts[:, [WALL, PHASE, VELOCITY]], i, label))
    impacted = np.concatenate([part for part, _, _ in parts]) if parts else np.zeros((0, 3))
    sizes = [len(part) for part, _, _ in parts]
    return Diagram(
        np.repeat(np.array([i for _, i, _ in parts], dtype=np.int64), sizes),
        impacted[:, 0].astype(np.int8),
        impacted[:, 1],
        impacted[:, 2],
        np.repeat(np.array([label for _, _, label in parts], dtype=np.int64), sizes),
        tuple(labels),
    )


def search(ball: Trajectory, patience: int, budget: int, remembered: list[SimulatedMotion]) -> Attractor:
    """Follow a ball until it is known what it leads to.

    Parameters
    ----------
    ball : Trajectory
        Has its last impacts afterwards.
    patience, budget : int
        Impacts to spend while nothing periodic is in sight, and while a periodic motion is being approached.
    remembered : list of SimulatedMotion
        Collects those of one parameter.
    """
    model, compiled, block = ball.model, ball.compiled, BLOCK
    before_this: set[float] = set()

    def end(outcome: Outcome, cycle: SimulatedMotion | None, lyapunov: float, distance: float) -> Attractor:
        whole = cycle is not None or outcome in STOPS
        return Attractor(outcome, cycle, lyapunov, distance, ball.impacts, *(() if whole else (_last(ball.rows),)))

    while ball.moving:
        rows = ball.rows
        if unresolved(rows):
            return end(Outcome.UNRESOLVED, None, nan, inf)
        near = [cycle for cycle in remembered if cycle.distance(rows[-1]) <= SETTLED]
        laps = cycles.laps(rows)
        if not near and (laps or before_this & cycles.released(rows[1:])):
            rests = (cycles.rest_cycle(model, lap, compiled) for lap in laps)
            cycle = next((cycle for cycle in rests if cycle is not None), None)
            return end(Outcome.STICKING, cycle and _remembered(cycle, remembered), -inf, 0.0)
        cycle = near[0] if near else cycles.approached(model, rows, compiled)
        if cycle is not None and cycle.sticks:
            return end(Outcome.STICKING, cycle, -inf, 0.0)
        if cycle is not None and cycle.growth >= 1:
            ball.rows = rows.copy()
            ball.rows[-1, VELOCITY] *= 1 + NUDGE  # on an orbit that repels: rounding alone might keep it there
        elif cycle is not None:
            before = distance = cycle.distance(rows[-1])
            if distance > SETTLED and ball.impacts < budget:
                # The multiplier of the cycle tells how many impacts the rest of the approach takes.
                ball.go_on(min(_transient(cycle, distance), budget - ball.impacts))
                distance = cycle.distance(ball.rows[-1])
            if distance <= SETTLED or (ball.impacts >= budget and distance < max(SLOWER * before, BESIDE)):
                cycle = _remembered(cycle, remembered)
                return end(Outcome.PERIODIC, cycle, cycle.lyapunov, distance)
        if ball.impacts >= min(patience, budget):
            return end(Outcome.APERIODIC, None, cycles.exponent(model, ball.rows, compiled), inf)
        before_this |= cycles.released(ball.rows)
        ball.go_on(min(block, budget - ball.impacts))
        block *= 2
    return end(*STOPPED[ball.status])


def _last(rows: Array) -> Array:
    return rows[-LAST:, [WALL, PHASE, VELOCITY]]


def unresolved(rows: Array) -> bool:
    """Whether a flight among these impacts was too long for its end to be known."""
    return bool(rows[:, FLIGHT].max() > LONGEST_FLIGHT)


def _transient(cycle: SimulatedMotion, distance: float) -> int:
    """Impacts until a linear approach from this distance has settled, and one period more."""
    periods = ceil(log(distance / SETTLED) / -log(max(cycle.growth, FAST)))
    return (periods + 1) * len(cycle.wall)


def _remembered(cycle: SimulatedMotion, remembered: list[SimulatedMotion]) -> SimulatedMotion:
    """The cycle as first found, so that equal ones are the same object."""
    alike = (
        other
        for other in remembered
        if (other.word, other.period, len(other.wall)) == (cycle.word, cycle.period, len(cycle.wall))
    )
    for other in alike:
        if cycles.separation(other.phase - cycle.phase, other.velocity - cycle.velocity).max() <= SETTLED:
            return other
    remembered.append(cycle)
    return cycle
