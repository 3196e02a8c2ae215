"""The motion while a parameter changes slowly, as in an experiment: each value goes on from where the last one ended.

Turns values of a parameter into the motions that are met on the way, and into the jumps from one motion to another,
each between two values as close as was asked for. What is met depends on the direction: that is hysteresis.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import count
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.records import brief
from vireport.physics.groups import Groups
from vireport.simulation.attractors import (
    BLOCK,
    BUDGET,
    KEPT,
    Attractor,
    Outcome,
    search,
)
from vireport.simulation.cycles import separation
from vireport.simulation.events import (
    BOTTOM,
    Impact,
    check_model,
    check_start,
)
from vireport.simulation.follower import Trajectory
from vireport.simulation.kernel import PHASE, VELOCITY, WALL

Array = NDArray[np.float64]

CLOSE = 0.05
"""Distance of two motions, in phase [rad] and velocity [y_c], up to which one is the other at the next value. A
continuous change falls below it as values are halved: at a period doubling with the square root of their distance."""

RESOLUTION = 1e-6
"""Width of the interval that a jump is located in, over that of the whole range."""

PATIENCE = 20
"""Times the impacts asked for, until a motion counts as not periodic: next to a fold it lingers where it was."""

AWAY = 100
"""Times the resolution: how far from a periodic motion one that is not periodic is looked at. The nearer the fold where
the cycle ends, the longer it stays beside it."""

MOST_STEPS = 400
"""Steps between two values, some 60 to a jump; one that is found later has the interval that is left."""


class Conditions(NamedTuple):
    """The groups at a value of the parameter, and the unit of velocity y_c there [m/s]."""

    groups: Groups[float]
    velocity_unit: float


class Stage(Struct, frozen=True, eq=False):
    """The motion at one value of a parameter that changes slowly.

    Attributes
    ----------
    value : float
    attractor : Attractor
    impacts : ndarray (n, 3)
        Wall, phase [rad] and velocity [y_c] of each in one period, or of the last ones; none of a ball that rests.
    last : Impact
        The state that it ended in, from which the next value starts.
    """

    value: float
    attractor: Attractor
    impacts: Array
    last: Impact

    @property
    def untold(self) -> bool:
        """Whether no cycle of the motion is known: it is not periodic, or so long that rounding decides."""
        return self.attractor.cycle is None and self.attractor.outcome in (Outcome.APERIODIC, Outcome.STICKING)

    def distance(self, other: Stage, mirror: bool = False) -> float:
        """Largest distance between an impact of one motion and the nearest of the other, in phase and velocity.

        An impact of low velocity counts with that, as impacts come and go with velocity zero. Motions that are not
        periodic, or whose cycle rounding does not tell, are not told from one another. With `mirror` the mirror image
        of the other counts as well.
        """
        if self.untold and other.untold:
            return 0.0
        image = other.impacts * (-1, 1, -1) + (0, np.pi, 0)
        others = (other.impacts, image) if mirror else (other.impacts,)
        return min(max(_aside(self.impacts, image), _aside(image, self.impacts)) for image in others)


class Jump(Struct, frozen=True, eq=False):
    """A discontinuous change, somewhere between the values of two stages: from the motion of one to the other's."""

    before: Stage
    after: Stage

    @property
    def value(self) -> float:
        """The middle of the interval that it lies in."""
        return (self.before.value + self.after.value) / 2

    @property
    def off(self) -> float:
        """How far from there it may be: half of that interval."""
        return abs(self.after.value - self.before.value) / 2


class Course(Struct, frozen=True, eq=False):
    """The result of a slow sweep: the motions at its values, in their order, and the jumps between them."""

    stages: tuple[Stage, ...]
    jumps: tuple[Jump, ...]

    __repr__ = brief


def course(
    values: Sequence[float],
    at: Callable[[float], Conditions],
    start: Stage | None = None,
    impacts: int = 1000,
) -> Course:
    """Follow the motion from value to value.

    The forcing phase and the velocity in m/s stay as they are when the parameter changes.

    Parameters
    ----------
    values : sequence of float
        Of the parameter, ascending or descending.
    at : callable
        The conditions at a value.
    start : Stage, optional
        To begin from; by default the ball lies on the bottom membrane.
    impacts : int
        `PATIENCE` times as many without a period in sight make a motion one that is not periodic.
    """
    # Below some spacings of a double the steps would stand still.
    resolution = max(RESOLUTION * abs(values[-1] - values[0]), 8 * float(np.spacing(np.abs(values).max())))
    track = _Track(at, PATIENCE * impacts, resolution, (min(values), max(values)))
    stage = track.reached(start, values[0])
    stages, jumps = [stage], []
    for value in values[1:]:
        stage, passed = track.followed(stage, value)
        stages.append(stage)
        jumps += passed
    return Course(tuple(stages), tuple(jumps))


class _Track(Struct, frozen=True, eq=False):
    at: Callable[[float], Conditions]
    patience: int
    resolution: float
    ends: tuple[float, float]

    def reached(self, before: Stage | None, value: float, patience: int | None = None) -> Stage:
        """What the motion of a stage becomes at another value, or the ball that lay on the bottom membrane."""
        groups, unit = self.at(value)
        start = Impact(BOTTOM, 0.0, 0.0)
        if before is not None:
            start = before.last
            # Velocities are dimensionless, and their unit changes with the parameter: the ball keeps its velocity in
            # m/s.
            start = replace(start, velocity=start.velocity * self.at(before.value).velocity_unit / unit)
        ball = Trajectory.begun(check_model(groups)[0], check_start(start, groups.d), BLOCK, KEPT)
        attractor = search(ball, patience or self.patience, BUDGET, [])
        cycle, impacts = attractor.cycle, attractor.last
        if cycle is not None:
            impacts = cycle.impacts[:, [WALL, PHASE, VELOCITY]]
        wall, _, velocity, phase = ball.last
        return Stage(value, attractor, impacts, Impact(int(wall), velocity, phase))

    def apart(self, stage: Stage, other: Stage) -> bool:
        """Whether two motions differ; one that is not periodic may stay near the other for long, and leave."""
        if stage.distance(other) > CLOSE:
            return True
        periodic, aperiodic = sorted((stage, other), key=lambda stage: stage.untold)
        if periodic.attractor.cycle is None or not aperiodic.untold:
            return False
        # A chaotic motion may stay beside the cycle that it came from for long. A little farther on it
        # leaves sooner; if it does, the two are different motions.
        away = aperiodic.value + AWAY * np.copysign(self.resolution, aperiodic.value - periodic.value)
        groups = self.at(float(np.clip(away, *self.ends))).groups
        ball = Trajectory.begun(check_model(groups)[0], check_start(aperiodic.last, groups.d), KEPT, KEPT)
        for _ in range(BUDGET // KEPT):
            if _aside(ball.rows[:, [WALL, PHASE, VELOCITY]], periodic.impacts) > CLOSE:
                return True
            ball.go_on(KEPT)
        return False

    def followed(self, stage: Stage, target: float) -> tuple[Stage, list[Jump]]:
        """The motion at another value, and the jumps on the way there.

        Steps are halved where the motion becomes another one: one that is too long may end beyond the starts that
        are drawn to a motion, where a shorter one does not.
        """
        jumps: list[Jump] = []
        step = target - stage.value
        for attempt in count():
            last = abs(step) >= abs(target - stage.value)
            value = target if last else stage.value + step
            ahead = self.reached(stage, value)
            if stage.attractor.cycle is not None and ahead.attractor.cycle is None and stage.distance(ahead) <= CLOSE:
                ahead = self.reached(stage, value, BUDGET)  # still on its way, as far as one can see
            apart = self.apart(stage, ahead)
            if apart and abs(step) > self.resolution and attempt < MOST_STEPS:
                step /= 2
                continue
            if apart:
                # Before a jump is reported the motion is given the whole budget of impacts: a slow transient looks like
                # another motion.
                ahead = self.reached(stage, value, BUDGET)
                jumps += [Jump(stage, ahead)] if self.apart(stage, ahead) else []
            # Steps grow again after a jump, which is narrow, so that what is halved at one is not paid for along the
            # rest.
            stage, step = ahead, 2 * step
            if last:
                break
        return stage, jumps


def _aside(impacts: Array, others: Array) -> float:
    """Largest distance of an impact from the nearest of others, or its velocity where that is less."""
    speed = np.abs(impacts[:, 2])
    if not len(others):
        return float(speed.max(initial=0.0))
    impact = impacts[:, None]
    apart = separation(impact[..., 1] - others[:, 1], impact[..., 2] - others[:, 2])
    apart[impact[..., 0] != others[:, 0]] = np.inf
    return float(np.minimum(apart.min(axis=1), speed).max(initial=0.0))
