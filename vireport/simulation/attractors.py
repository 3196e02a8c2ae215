"""Attractors of the simulated motion: for one start, or for many parameters and starts at once.

A ball is followed in blocks of impacts. After each block the last impacts are tested: does the ball rest for ever, ride
on a membrane again and again, or nearly repeat a cycle, which Newton's method then makes exact? The transient is not a
fixed number of impacts: near a critical point it lasts ln(tolerance)/ln|multiplier| periods.
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

# Impacts of the first block; each block is twice as long as the last, until the budget is used up.
BLOCK = 512
# Impacts kept for recurrences and Lyapunov exponents.
KEPT = 4096
# A transient has ended at this distance from the cycle, in phase [rad] and velocity [y_c].
SETTLED = 1e-9
# Below this multiplier one more period is all that is needed.
FAST = 1e-3
# A trajectory that is cut before it has settled approaches a cycle only if its distance from it has fallen below this
# share of what it was.
SLOWER = 0.9
# Within this distance, in phase [rad] and velocity [y_c], it approaches an attracting cycle even so: towards r = 1 it
# winds around the cycle for millions of periods, now nearer and now farther.
APPROACHING = 1e-5
# After a flight longer than this [t_c] rounding leaves less than three digits of the forcing phase.
LONGEST_FLIGHT = 1e12
# Numbers of impacts of a motion that is not periodic: those that are kept, and those that a diagram shows.
LAST, DRAWN = 256, 64
# Impacts until a slow approach to a cycle is given up.
BUDGET = 200_000
# Relative change of velocity that takes a ball off a cycle that repels.
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
"""Outcome, cycle, Lyapunov exponent and distance of an attractor on which the ball strikes no membrane, by the status
of the event search."""

STOPS = Outcome.REST, Outcome.HELD, Outcome.FREE
"""Outcomes that describe an attractor completely, whatever impacts came before."""


def motion_name(outcome: Outcome, word: str, period: int) -> str:
    """The name of an attractor: its word and its period in forcing periods, or its outcome where it has no word."""
    if not word:
        return outcome.value
    return word_name(word, period)


class Attractor(Struct, frozen=True, eq=False):
    """The attractor in whose basin a start lies: a periodic or chaotic motion, or a state of rest.

    Parameters
    ----------
    outcome : Outcome
        Its kind.
    cycle : SimulatedMotion or None
        One period, verified on the return map, if it is periodic; None for a motion with rest that is so long that
        rounding decides how it repeats.
    lyapunov : float
        Largest Lyapunov exponent per forcing period: of the cycle, or of the last impacts of a motion that is
        not periodic. -inf where the ball comes to rest, nan where it meets no membrane again or is not resolved.
    distance : float
        Distance from the last impact to the cycle, in phase [rad] and velocity [y_c]. Large only if the budget ended a
        transient that was still approaching it.
    impacts : int
        Number of impacts simulated.
    last : array (n, 3)
        Wall, phase [rad] and velocity [y_c] of the last impacts of a motion without a cycle, at most `LAST`.
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
        """The word and its period, or the outcome where there is no word."""
        return motion_name(self.outcome, self.word, self.period)


class Diagram(Struct, frozen=True, eq=False):
    """Bifurcation diagram found by simulation alone: one entry per impact that is drawn.

    Parameters
    ----------
    index : array of int
        Number of the parameter.
    wall, phase, velocity : array
        Membrane, forcing phase [rad] and velocity [y_c] of the impact.
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
    """Find the attractor that one start leads to.

    Parameters
    ----------
    groups : Groups
        Groups of the device, as numbers.
    start : Impact or InFlight
        State to begin with.
    budget : int
        Largest number of impacts. Periodic motions use as many as their transient needs.
    compiled : bool
        Whether to compile the search, where numba is there.

    Raises
    ------
    ValueError
        If the groups describe no device, or the start is impossible.
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
    compiled: bool = True,
) -> list[tuple[Attractor, ...]]:
    """Find the attractors that m starts lead to at each of n parameters.

    Parameters
    ----------
    groups : Groups
        Of devices, as arrays (n,) or numbers, broadcast against each other.
    starts : sequence of Impact or InFlight, or array (n, m, 4)
        Starts that are tried at every parameter; or rows of `random_starts`, different at each parameter.
    impacts : int
        Impacts that are simulated first from all starts, on all cores.
    budget : int
        Largest number of impacts for starts that have not settled by then.
    workers : int, optional
        Threads; the number of processors by default. The result does not depend on it.
    compiled : bool
        Whether to compile the search, where numba is there.

    Returns
    -------
    list of tuple of Attractor
        n tuples of m. Equal cycles of one parameter are one object.

    Raises
    ------
    ValueError
        If the groups describe no device, a start is impossible or there is none.
    """
    model = check_model(groups)
    first = start_rows(starts, model[:, 0])
    n, m = first.shape[:2]
    cores = (os.cpu_count() or 1) if workers is None else workers
    # As many as the longest cycle needs: most starts have settled by then, and of the others `search` follows more.
    keep = cycles.MAX_IMPACTS + 1
    rows, summary = follow_impacts(
        np.repeat(model, m, axis=0), first.reshape(n * m, -1), impacts, keep, cores, compiled
    )
    by_parameter = []
    for i in range(n):
        remembered: list[SimulatedMotion] = []
        ends = []
        for k in range(i * m, (i + 1) * m):
            happened = rows[k, max(0, rows.shape[1] - int(summary[k, 0]) - 1) :]
            ends.append(search(Trajectory(model[i], happened, summary[k], KEPT, compiled), budget, budget, remembered))
        by_parameter.append(tuple(ends))
    return by_parameter


def diagram(attractors_by_parameter: Sequence[Sequence[Attractor]]) -> Diagram:
    """Bifurcation diagram from simulation alone, each impact labelled by the word of its motion.

    Cycles are drawn once; of motions that are not periodic the last `DRAWN` impacts are drawn.

    Parameters
    ----------
    attractors_by_parameter : sequence of sequences of Attractor
        As `attractors` returns them.
    """
    labels: dict[str | Outcome, int] = {}
    parts: list[tuple[Array, int, int]] = []
    for i, ends in enumerate(attractors_by_parameter):
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
    """Follow a ball, block by block, until it is on an attractor that is recognised.

    Recognised are, in this order: a flight too long to be computed, a cycle that is remembered, a ride on a membrane
    that has released the ball before, a cycle that the last impacts nearly repeat, and, when the patience is over, a
    motion that is not periodic; and states in which the ball strikes no membrane any more.

    Parameters
    ----------
    ball : Trajectory
        The ball, which is moved on to the attractor.
    patience, budget : int
        Impacts to spend while nothing periodic is in sight, and while a periodic motion is being approached.
    remembered : list of SimulatedMotion
        Cycles of the same parameter; a new one is appended.
    """
    model, compiled, block = ball.model, ball.compiled, BLOCK
    released_before = np.empty((0, 2))

    def end(outcome: Outcome, cycle: SimulatedMotion | None, lyapunov: float, distance: float) -> Attractor:
        whole = cycle is not None or outcome in STOPS
        return Attractor(outcome, cycle, lyapunov, distance, ball.impacts, *(() if whole else (_last(ball.rows),)))

    while ball.moving:
        rows = ball.rows
        if unresolved(rows):
            return end(Outcome.UNRESOLVED, None, nan, inf)
        near = [cycle for cycle in remembered if cycle.distance(rows[-1]) <= SETTLED]
        laps, states = cycles.laps(rows), cycles.released(rows[1:])
        # A second release in one state, even if the impacts from the first one on are not kept any more, makes the
        # motion periodic.
        if not near and (laps or cycles.same_release(released_before[:, None], states).any()):
            rests = (cycles.rest_cycle(model, rows[lap], compiled) for lap in laps)
            cycle = next((cycle for cycle in rests if cycle is not None), None)
            return end(Outcome.STICKING, cycle and _remembered(cycle, remembered), -inf, 0.0)
        cycle = near[0] if near else cycles.approached(model, rows, compiled)
        if cycle is not None and cycle.sticks:
            return end(Outcome.STICKING, cycle, -inf, 0.0)
        if cycle is not None and cycle.growth >= 1:
            ball.rows = rows.copy()
            ball.rows[-1, VELOCITY] *= 1 + NUDGE  # on a cycle that repels: rounding alone might keep it there
        elif cycle is not None:
            before = distance = cycle.distance(rows[-1])
            if distance > SETTLED and ball.impacts < budget:
                # The multiplier of the cycle tells how many impacts the rest of the approach takes.
                ball.go_on(min(_transient(cycle, distance), budget - ball.impacts))
                distance = cycle.distance(ball.rows[-1])
            if distance <= SETTLED or (ball.impacts >= budget and distance < max(SLOWER * before, APPROACHING)):
                cycle = _remembered(cycle, remembered)
                return end(Outcome.PERIODIC, cycle, cycle.lyapunov, distance)
        if ball.impacts >= min(patience, budget):
            return end(Outcome.APERIODIC, None, cycles.exponent(model, ball.rows, compiled), inf)
        released_before = np.concatenate([released_before, cycles.released(ball.rows)])
        ball.go_on(min(block, budget - ball.impacts))
        block *= 2
    return end(*STOPPED[ball.status])


def _last(rows: Array) -> Array:
    """Wall, phase and velocity of the last impacts of a motion without a cycle, at most `LAST`."""
    return rows[-LAST:, [WALL, PHASE, VELOCITY]]


def unresolved(rows: Array) -> bool:
    """Whether one of the flights between impacts, rows of `kernel`, was too long for the forcing phase at its end."""
    return bool(rows[:, FLIGHT].max() > LONGEST_FLIGHT)


def _transient(cycle: SimulatedMotion, distance: float) -> int:
    """Impacts of a linear approach to a cycle from a distance [rad, y_c] until it has settled, and one period more."""
    periods = ceil(log(distance / SETTLED) / -log(max(cycle.growth, FAST)))
    return (periods + 1) * len(cycle.wall)


def _remembered(cycle: SimulatedMotion, remembered: list[SimulatedMotion]) -> SimulatedMotion:
    """The first of the remembered cycles that equals a cycle; if none does, the cycle itself, which is remembered."""
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
