"""Slow sweeps as in an experiment: the motion at each value of a parameter starts from the state at the value before.

It gives the attractors at values of a parameter, and the jumps from one to another, each located between two values to
within `RESOLUTION`. Both depend on the direction of the sweep: that is hysteresis.
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
continuous change falls below it as steps are halved: at a period doubling with the square root of the step."""

RESOLUTION = 1e-6
"""Width of the interval that a jump is located in, over that of the whole range."""

PATIENCE = 20
"""Number of impacts after which a motion counts as not periodic, over `impacts` of `course`: next to a fold it lingers
where the cycle was."""

AWAY = 100
"""Distance in the parameter, over the resolution, from a periodic motion to where a motion that is not periodic is
tested again: the nearer the fold where the cycle ends, the longer a motion lingers at it."""

MOST_STEPS = 400
"""Largest number of steps between two values, some 60 to a jump; a jump after so many is located less sharply."""


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
        Wall, phase [rad] and velocity [y_c] of the impacts of one period, or of the last ones; none if the ball rests.
    last : Impact
        The last state, from which the next value starts.
    """

    value: float
    attractor: Attractor
    impacts: Array
    last: Impact

    @property
    def without_cycle(self) -> bool:
        """Whether no cycle of the motion is known: it is not periodic, or so long that rounding decides."""
        return self.attractor.cycle is None and self.attractor.outcome in (Outcome.APERIODIC, Outcome.STICKING)

    def distance(self, other: Stage, mirror: bool = False) -> float:
        """Largest distance between an impact of one motion and the nearest of the other, in phase and velocity.

        The distance of an impact is at most its speed, as impacts come and go with velocity zero. Motions that are not
        periodic, or whose cycle rounding does not resolve, count as equal. With `mirror` the mirror image of the other
        motion counts as well.
        """
        if self.without_cycle and other.without_cycle:
            return 0.0
        image = other.impacts * (-1, 1, -1) + (0, np.pi, 0)
        others = (other.impacts, image) if mirror else (other.impacts,)
        return min(max(_farthest(self.impacts, image), _farthest(image, self.impacts)) for image in others)


class Jump(Struct, frozen=True, eq=False):
    """A discontinuous change of the motion, somewhere between the values of two stages of a slow sweep."""

    before: Stage
    after: Stage

    @property
    def value(self) -> float:
        """The middle of the interval of the parameter in which the jump lies."""
        return (self.before.value + self.after.value) / 2

    @property
    def off(self) -> float:
        """Half of the interval of the parameter in which the jump lies: the largest error of `value`."""
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
        Values of the parameter, ascending or descending.
    at : callable
        The conditions at a value.
    start : Stage, optional
        Stage to begin from; by default the ball lies on the bottom membrane.
    impacts : int
        A motion without a period after `PATIENCE` times as many impacts counts as not periodic.
    """
    # Below some spacings of a double the steps would stand still.
    resolution = max(RESOLUTION * abs(values[-1] - values[0]), 8 * float(np.spacing(np.abs(values).max())))
    track = _Track(at, PATIENCE * impacts, resolution, (min(values), max(values)))
    stage = track.continued(start, values[0])
    stages, jumps = [stage], []
    for value in values[1:]:
        stage, passed = track.followed(stage, value)
        stages.append(stage)
        jumps += passed
    return Course(tuple(stages), tuple(jumps))


class _Track(Struct, frozen=True, eq=False):
    """A slow sweep between two ends of a parameter.

    Attributes
    ----------
    at : callable
        Conditions at a value of the parameter.
    patience : int
        Impacts until a motion counts as not periodic.
    resolution : float
        Width of the interval in which a jump is located.
    ends : tuple of float
        Least and largest value.
    """

    at: Callable[[float], Conditions]
    patience: int
    resolution: float
    ends: tuple[float, float]

    def continued(self, before: Stage | None, value: float, patience: int | None = None) -> Stage:
        """The motion at a value of the parameter, from the last state of a stage at another value.

        Parameters
        ----------
        before : Stage or None
            None for a ball that lies on the bottom membrane.
        value : float
            Of the parameter.
        patience : int, optional
            Number of impacts until the motion counts as not periodic; by default that of the sweep.
        """
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
        """Whether the motions of two stages differ, by more than `CLOSE` or as one leaves the other in the long run."""
        if stage.distance(other) > CLOSE:
            return True
        periodic, aperiodic = sorted((stage, other), key=lambda stage: stage.without_cycle)
        if periodic.attractor.cycle is None or not aperiodic.without_cycle:
            return False
        # A chaotic motion may linger near the cycle that has vanished at a fold. A little farther from the fold it
        # leaves sooner; if it does, the two are different motions.
        away = aperiodic.value + AWAY * np.copysign(self.resolution, aperiodic.value - periodic.value)
        groups = self.at(float(np.clip(away, *self.ends))).groups
        ball = Trajectory.begun(check_model(groups)[0], check_start(aperiodic.last, groups.d), KEPT, KEPT)
        for _ in range(BUDGET // KEPT):
            if _farthest(ball.rows[:, [WALL, PHASE, VELOCITY]], periodic.impacts) > CLOSE:
                return True
            ball.go_on(KEPT)
        return False

    def followed(self, stage: Stage, target: float) -> tuple[Stage, list[Jump]]:
        """The stage at another value, and the jumps on the way there.

        Steps are halved where the motion becomes another one: after too long a step the last state may lie outside the
        basin of a motion that still exists, and after a shorter step inside.
        """
        jumps: list[Jump] = []
        step = target - stage.value
        for attempt in count():
            last = abs(step) >= abs(target - stage.value)
            value = target if last else stage.value + step
            ahead = self.continued(stage, value)
            if stage.attractor.cycle is not None and ahead.attractor.cycle is None and stage.distance(ahead) <= CLOSE:
                ahead = self.continued(stage, value, BUDGET)  # it may still be on its way to the cycle
            apart = self.apart(stage, ahead)
            if apart and abs(step) > self.resolution and attempt < MOST_STEPS:
                step /= 2
                continue
            if apart:
                # Before a jump is reported the motion has the whole budget of impacts: a slow transient looks like
                # another motion.
                ahead = self.continued(stage, value, BUDGET)
                jumps += [Jump(stage, ahead)] if self.apart(stage, ahead) else []
            # Steps grow again after a jump, which is narrow, so that what is halved at one is not paid for along the
            # rest.
            stage, step = ahead, 2 * step
            if last:
                break
        return stage, jumps


def _farthest(impacts: Array, others: Array) -> float:
    """Largest distance of an impact from the nearest of others on its membrane, or its speed where that is less.

    Impacts are rows (n, 3) of wall, phase [rad] and velocity [y_c].
    """
    speed = np.abs(impacts[:, 2])
    if not len(others):
        return float(speed.max(initial=0.0))
    impact = impacts[:, None]
    apart = separation(impact[..., 1] - others[:, 1], impact[..., 2] - others[:, 2])
    apart[impact[..., 0] != others[:, 0]] = np.inf
    return float(np.minimum(apart.min(axis=1), speed).max(initial=0.0))
