"""The motion of a device that is switched on: the ball lies on the bottom membrane, and the force sets in.

For gbar < 1 a ball that is pressed onto the bottom membrane when the force sets in leaves it at the first zero of the
pressing acceleration, with velocity 0 and at phase arccos(-gbar), whenever the force set in. So one trajectory is the
answer for all these moments, and if the ball ever lies on the bottom again, the motion repeats exactly from there: a
rest cycle. A ball that is not pressed leaves at once, at a phase that depends on when the force sets in.

None of this is in the paper. It rests on the flight and the impact law alone, Eqs. (2.8)-(2.12).
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from math import ceil, exp, nan
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.design.recovery import largest_modulus
from vireport.motions.one_to_one import Motions
from vireport.physics.groups import Groups
from vireport.physics.numbers import wrapped
from vireport.physics.word import word_name
from vireport.simulation.attractors import STOPPED, Outcome, find_attractor
from vireport.simulation.cycles import (
    REACH,
    SimulatedMotion,
    attracting,
    chain_growth,
    laps,
    rest_cycle,
    separation,
)
from vireport.simulation.events import BOTTOM, check_model, start_of
from vireport.simulation.follower import ROUNDINGS, TWINS, Trajectory, twins
from vireport.simulation.kernel import FLIGHT, PHASE, RIDING, SETTLING, VELOCITY, WALL
from vireport.simulation.release import presses

Floats = NDArray[np.float64]

State = tuple[float, float, float, float]
"""Wall (0 in flight), position [x_c], velocity before the impact, or in flight [y_c], and phase [rad]."""

BLOCK = 64
"""Number of impacts simulated before it is tested whether the motion is settled."""

TRANSIENT = 1024
"""Number of impacts in which a ball usually reaches a stable 1:1 motion or rest; then other motions are looked for."""

SHORT_TRANSIENT = 256
"""Number of impacts after which other motions are looked for where no 1:1 motion is stable."""

BUDGET = 1024
"""Number of impacts in the search for other motions: some 10 ms not compiled. Of 312 random devices called
chaotic 57 settle within 300,000 impacts after all; with a budget of 600 it would be 24 %, with 1500 still 15 %."""

SETTLED = 0.01
"""Difference from the final motion, in phase [rad] and relative in velocity, below which a motion is settled."""

CONTRACTING = 0.01
"""Distance from a stable motion in phase [rad] and velocity [y_c] up to which its linearised map decides, over 1 less
the modulus of its multiplier: next to a fold the width of the basin goes with that difference, next to a period
doubling with its root, see `CONTRACTING_FLIP`."""

CONTRACTING_FLIP = 0.02
"""The same distance over the root of that difference, where the multiplier is negative: disturbances change sides, and
terms of second order cancel over two periods."""

OF_GAP = 0.1
"""Largest distance from a stable motion up to which its linearised map decides, over the gap of its turning points:
beyond it another impact may come in between."""

REPEATED = 1e-9
"""Distance from a motion of another word, in phase [rad] and velocity [y_c], up to which impacts repeat it."""

PASSES = 3
"""Number of impacts on the bottom membrane, in a row, that must be near to a stable 1:1 motion."""

SLOW_FLIP = 0.02
"""Distance from a stable 1:1 motion in phase [rad] and velocity [y_c] up to which a motion that strikes alike, in twice
its period or more, is the same on its way: next to a period doubling disturbances die out too slowly to tell."""

COMPILED = 4
"""Factor on all numbers of impacts where the simulation is compiled."""

LEAST_EXPONENT = 0.02
"""Lyapunov exponent per period above which a motion is chaotic; next to critical points it is hardly above 0."""

LOST = 1e-3
"""Error that rounding has grown to [rad, y_c], up to which the outcome is certain. Beyond it the ball is followed again
from starts a few roundings off, which must end alike."""

LONGEST_PRINTED = 16
"""Largest number of letters of a word that are shown for a motion with rest."""


class Destination(StrEnum):
    """Where a ball ends that starts from rest; the value is its name in results.json."""

    ONE_TO_ONE = "reaches_1_1"
    OTHER_MOTION = "other_motion"
    REST_CYCLE = "rest_cycle"
    CHAOTIC = "chaotic"
    AT_REST = "at_rest"
    UNDECIDED = "undecided"


class Target(NamedTuple):
    """A stable 1:1 motion by its impact on the bottom membrane, and the radius within which its linearised map decides.

    Phase [rad], velocity [y_c], and a distance in either. A `Core` of `findings.outcomes` is wider, but its simulation
    takes longer than to follow one ball.
    """

    phase: float
    velocity: float
    radius: float

    def distance(self, bottom: Floats) -> float:
        """Largest distance of impacts on the bottom membrane, rows of the simulation, from the motion's impact."""
        return float(separation(bottom[:, PHASE] - self.phase, bottom[:, VELOCITY] - self.velocity).max())

    @staticmethod
    def of(motions: Motions) -> tuple[Target, ...]:
        """The targets of the stable ones among some motions."""
        stable = motions.select(motions.stable_mask)
        return targets_of(stable.phi_bottom, stable.velocity_bottom, stable.trace, stable.wall_gap, stable.decay)


def targets_of(
    phase: Floats, velocity: Floats, trace: Floats, wall_gap: Floats, decay: Floats | float
) -> tuple[Target, ...]:
    """Stable 1:1 motions by their impacts on the bottom membrane, their traces, gaps, and r^2; arrays of one length."""
    loss = 1 - largest_modulus(trace, decay)
    radius = np.minimum(np.where(trace < 0, CONTRACTING_FLIP * np.sqrt(loss), CONTRACTING * loss), OF_GAP * wall_gap)
    return tuple(Target(*map(float, row)) for row in zip(phase, velocity, radius, strict=True))


class FromRest(Struct, frozen=True):
    """The motion or state in which the ball ends when a device is switched on.

    Attributes
    ----------
    destination : Destination
    word : str
        Impacts of one period, "" where it is not periodic, or rounding does not tell its period; a tilde marks ever
        lower hops and the rest that follows.
    periods : int
        Forcing periods of one period of the motion; 0 where there is no word.
    settles_after : int or None
        Forcing periods from when the ball first leaves the membrane until its impacts stay within 1 % of the motion; 0
        for a rest cycle that begins there; None where it never settles, or it is not known when.
    cycle : SimulatedMotion or None
        One period, where it was simulated.
    creeping : bool
        Whether it is undecided because the ball, with friction, stops too often on its way to be followed.
    """

    destination: Destination
    word: str = ""
    periods: int = 0
    settles_after: int | None = None
    cycle: SimulatedMotion | None = None
    creeping: bool = False

    @classmethod
    def on(cls, cycle: SimulatedMotion, ratio: int, settles_after: int | None = None) -> FromRest:
        """The end of a ball in a simulated motion; `ratio` are the forcing periods of a 1:1 motion."""
        one_to_one = (cycle.word, cycle.period) == ("BT", ratio)
        moving = Destination.ONE_TO_ONE if one_to_one else Destination.OTHER_MOTION
        kind = Destination.REST_CYCLE if cycle.sticks else moving
        return cls(kind, cycle.word, cycle.period, settles_after, cycle)

    @classmethod
    def without_cycle(cls, outcome: Outcome, lyapunov: float = nan) -> FromRest:
        """The end of a ball in no known cycle, by the outcome and the Lyapunov exponent of its last impacts."""
        if outcome is Outcome.REST:
            return cls(Destination.AT_REST)
        chaotic = outcome is Outcome.APERIODIC and lyapunov > LEAST_EXPONENT
        return cls(Destination.CHAOTIC if chaotic else Destination.UNDECIDED, creeping=outcome is Outcome.CREEPING)

    @property
    def is_one_to_one(self) -> bool:
        """Whether the device comes to a 1:1 motion."""
        return self.destination is Destination.ONE_TO_ONE

    @property
    def is_motion(self) -> bool:
        """Whether the device comes to a periodic motion without rest."""
        return self.destination in (Destination.ONE_TO_ONE, Destination.OTHER_MOTION)

    @property
    def decided(self) -> bool:
        """Whether the end of the ball does not depend on rounding."""
        return self.destination is not Destination.UNDECIDED

    @property
    def kind(self) -> tuple[Destination, str, int]:
        """Destination, word and periods, which distinguish outcomes; no word for rest cycles, whose hops may differ."""
        return self.destination, "" if self.destination is Destination.REST_CYCLE else self.word, self.periods

    @property
    def name(self) -> str:
        """The outcome in words: word and period of the motion, or a description where it has none."""
        if self.creeping:
            return CREEPS
        if not self.word:
            return NAMES[self.destination]
        if self.destination is not Destination.REST_CYCLE:
            return word_name(self.word, self.periods)
        often = f"{self.periods} forcing periods" if self.periods > 1 else "forcing period"
        return f"rest every {often}" + (f" ({self.word})" if len(self.word) <= LONGEST_PRINTED else "")


NAMES = {
    Destination.REST_CYCLE: "rest again and again, at irregular times",
    Destination.CHAOTIC: Outcome.APERIODIC.value,
    Destination.AT_REST: Outcome.REST.value,
    Destination.UNDECIDED: "a motion that rounding hides",
}
"""Names of destinations whose motion has no word, for the reader."""

CREEPS = "a ball that creeps under friction, and stops too often on its way to be followed"
"""Name of an outcome that is not decided as the ball creeps under friction."""


class StartingDevice(NamedTuple):
    """A device that is switched on, with the 1:1 motions that its ball may come to.

    Attributes
    ----------
    groups : Groups
        Its groups as Python's numbers.
    targets : sequence of Target
        The stable 1:1 motions; empty where there is none.
    ratio : int
        Forcing periods of a 1:1 motion.
    """

    groups: Groups[float]
    targets: Sequence[Target] = ()
    ratio: int = 1


def from_rest(device: StartingDevice, compiled: bool = False) -> FromRest:
    """The motion or state that a ball comes to if it is pressed onto the bottom membrane when the force sets in.

    Where a force with harmonics presses it several times a period, the worst outcome: one that is no 1:1 motion.

    Parameters
    ----------
    device : StartingDevice
    compiled : bool
        Whether to compile the simulation, where numba is there.
    """
    outcomes = pressed_outcomes(device, compiled)
    return outcomes[0][1] if outcomes else FromRest(Destination.AT_REST)


def pressed_outcomes(device: StartingDevice, compiled: bool) -> list[tuple[float, FromRest]]:
    """The outcome of each release after the share of moments that lead to it; outcomes that are no 1:1 motion first."""
    ends = [
        (share, started((float(BOTTOM), 0.0, 0.0, phase), device, compiled, released=True))
        for phase, share, _ in presses(device.groups)
    ]
    return sorted(ends, key=lambda end: end[1].is_one_to_one)


def started(
    start: State, device: StartingDevice, compiled: bool, again: bool = True, released: bool = False
) -> FromRest:
    """Follow a ball from a state at an impact or in flight, and name the motion or state in which it ends.

    Parameters
    ----------
    start : tuple
        Wall, position, velocity and phase, as `simulation.check_start` gives them.
    device : StartingDevice
    compiled : bool
        Whether to compile the simulation, where numba is there.
    again : bool
        Whether to follow the ball once more, from a few roundings off, where rounding grows too much.
    released : bool
        Whether the ball starts as the bottom membrane releases it: if it lies there again, it has then come back. A
        ball that is not pressed down when the force sets in leaves at another phase.
    """
    targets, ratio = device.targets, device.ratio
    most = (TRANSIENT if targets else SHORT_TRANSIENT) * (COMPILED if compiled else 1)
    ball = Trajectory.begun(check_model(device.groups)[0], start, BLOCK, compiled=compiled)
    approached: SimulatedMotion | None = None
    while True:
        recognised = rested(ball, ratio, released) or _arrived(ball.rows, targets, ratio)
        if recognised is None and not targets:
            approached = _approached(ball, approached)
            recognised = _recurred(ball, approached, ratio)
        if recognised is not None or not ball.moving or len(ball.rows) > most:
            break
        # By a quarter of what there is: `rested` looks through all impacts, so that equal blocks would take a time that
        # grows with the square of their number.
        ball.go_on(max(BLOCK, len(ball.rows) // 4), whole=True)
    if recognised is None and not ball.moving:
        return FromRest.without_cycle(STOPPED[ball.status][0])
    end, way = recognised or _elsewhere(device, ball)
    # In chaos rounding grows too much on every way, which says nothing against chaos.
    if again and end.destination is not Destination.CHAOTIC and _lost(ball.model, way, compiled):
        for twin in twins(ball.rows[1], len(TWINS)):
            if started(twin, device, compiled, again=False).kind != end.kind:
                return FromRest(Destination.UNDECIDED)
    return end


def _lost(model: Floats, rows: Floats, compiled: bool) -> bool:
    """Whether rounding has grown too much over these impacts for their end to be known."""
    resting = np.flatnonzero(_held(rows) > 0)
    free = rows[resting[-1] + 1 :] if len(resting) else rows[1:]
    return len(free) > 1 and exp(min(chain_growth(model, free, compiled), 100.0)) * ROUNDINGS > LOST


def _held(rows: Floats) -> Floats:
    """Time on the membrane after each impact, in ever lower hops and at rest [t_c]."""
    held: Floats = rows[:, SETTLING] + rows[:, RIDING]
    return held


def _times(rows: Floats) -> Floats:
    """Forcing periods from when the ball first leaves the membrane to each impact."""
    held = _held(rows)
    spent = np.concatenate([[0.0], held[1:-1]]) if len(rows) > 1 else np.zeros(0)
    times: Floats = np.concatenate([[0.0], np.cumsum(rows[1:, FLIGHT] + spent)]) / 2
    return times


def rested(ball: Trajectory, ratio: int, released: bool) -> tuple[FromRest, Floats] | None:
    """The rest cycle, and the impacts to its end, once a membrane has released the ball twice in one state; else None.

    The first row counts where it is the start of a ball that a membrane has `released`.
    """
    lap = next(iter(laps(ball.rows, released)), None)
    if lap is None:
        return None
    cycle, way = rest_cycle(ball.model, ball.rows[lap], ball.compiled), ball.rows[: lap.stop]
    before = ceil(float(_times(way)[lap.start - 1]))
    end = FromRest(Destination.REST_CYCLE, settles_after=before) if cycle is None else FromRest.on(cycle, ratio, before)
    return end, way


def _arrived(rows: Floats, targets: Sequence[Target], ratio: int) -> tuple[FromRest, Floats] | None:
    """The 1:1 motion, and the impacts until it was settled, once its linearised map decides; else None."""
    if len(rows) < 2 * PASSES:
        return None
    recent = rows[-2 * PASSES :]
    bottom = recent[recent[:, WALL] == BOTTOM]
    # Several in a row: on its way elsewhere an impact may come near a motion by chance.
    for target in targets if len(bottom) == PASSES else ():
        if target.distance(bottom) < target.radius:
            near = np.abs(wrapped(rows[:, PHASE] - target.phase)) < SETTLED
            near &= np.abs(rows[:, VELOCITY] - target.velocity) < SETTLED * target.velocity
            settles, way = _settled(near | (rows[:, WALL] != BOTTOM), rows)
            return FromRest(Destination.ONE_TO_ONE, "BT", ratio, settles), way
    return None


def _settled(near: NDArray[np.bool_], rows: Floats) -> tuple[int | None, Floats]:
    """Forcing periods until all later impacts are `near` a motion, None if the last is not, and impacts until then."""
    first = int(np.flatnonzero(~near)[-1]) + 1 if not near.all() else 0
    return ceil(float(_times(rows)[first])) if first < len(rows) else None, rows[: first + 1]


def _elsewhere(device: StartingDevice, ball: Trajectory) -> tuple[FromRest, Floats]:
    """The end of a ball that reaches neither a target nor a rest cycle, and the impacts until it was settled."""
    budget = BUDGET * (COMPILED if ball.compiled else 1)
    end = find_attractor(device.groups, start_of(np.array(ball.last)), budget, ball.compiled)
    if end.cycle is None:
        return FromRest.without_cycle(end.outcome, end.lyapunov), ball.rows
    ball.go_on(end.impacts, whole=True)
    return _on(end.cycle, ball.rows, device.targets, device.ratio)


def _approached(ball: Trajectory, before: SimulatedMotion | None) -> SimulatedMotion | None:
    """The attracting cycle that the last impacts of a ball nearly repeat; the one of the block before if still near it.

    A cycle takes longer to compute than a block of impacts, and a slow approach to one takes many blocks.
    """
    if before is not None and before.distance(ball.rows[-1]) < REACH:
        return before
    return attracting(ball)


def _recurred(ball: Trajectory, cycle: SimulatedMotion | None, ratio: int) -> tuple[FromRest, Floats] | None:
    """An approached cycle that the last impact repeats as far as rounding tells, and the impacts until then; or None.

    Only where no 1:1 motion is stable: a slow approach to a stable one looks like a motion of twice its period.
    """
    if cycle is None or cycle.distance(ball.rows[-1]) > REPEATED:
        return None
    return _on(cycle, ball.rows, (), ratio)


def _on(cycle: SimulatedMotion, rows: Floats, targets: Sequence[Target], ratio: int) -> tuple[FromRest, Floats]:
    """A motion that the last impacts are on, and the impacts until it was settled."""
    settles, way = _settled(_near(cycle, rows), rows)
    if _flips_slowly(cycle, targets, ratio):
        return FromRest(Destination.ONE_TO_ONE, "BT", ratio, settles, cycle), way
    return FromRest.on(cycle, ratio, settles), way


def _flips_slowly(cycle: SimulatedMotion, targets: Sequence[Target], ratio: int) -> bool:
    """Whether what looks like a motion of twice the period or more is a stable 1:1 motion on its way."""
    count = cycle.period // ratio
    if cycle.word != "BT" * count or cycle.period != count * ratio:
        return False
    bottom = cycle.impacts[cycle.wall == BOTTOM]
    return any(target.distance(bottom) < SLOW_FLIP for target in targets)


def _near(cycle: SimulatedMotion, rows: Floats) -> NDArray[np.bool_]:
    """Whether each impact is one of a cycle's, to within `SETTLED`."""
    scale = SETTLED * max(float(np.abs(cycle.velocity).max()), SETTLED)
    near = cycle.wall == rows[:, WALL, None]
    near &= np.abs(wrapped(cycle.phase - rows[:, PHASE, None])) < SETTLED
    near &= np.abs(cycle.velocity - rows[:, VELOCITY, None]) < scale
    return np.asarray(near.any(axis=1))
