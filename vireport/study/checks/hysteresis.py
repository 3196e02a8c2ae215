"""A slow sweep, up and down as in an experiment: where the motion jumps, and where it depends on the direction.

Like all simulation, it does not use the formulae of the solution.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import ClassVar

from msgspec import Struct

from vireport.base.records import brief
from vireport.motions.sweep import Sweep
from vireport.scenario.blocks import Direction, SimulationBlock
from vireport.simulation.following import CLOSE, RESOLUTION, Conditions, Course, Stage, course


class Loop(Struct, frozen=True, eq=False):
    """A range of the parameter in which the motion depends on the direction, with the motions within.

    It ends at jumps, or at the ends of the sweep.
    """

    low: float
    high: float
    up: Stage
    down: Stage

    @property
    def width(self) -> float:
        """Width of the loop in the unit of the swept parameter."""
        return self.high - self.low


class Hysteresis(Struct, frozen=True, eq=False):
    """The motions that a slow sweep comes to, upwards and downwards.

    Attributes
    ----------
    courses : dict of Direction to Course
        Upwards and downwards, as far as the scenario asks for it.
    resolution : float
        Width of the interval in which a jump is located, over that of the sweep.
    mirror : bool
        Whether the mirror image of a motion counts as the same: the capsule is horizontal and its ends are alike.
    """

    courses: dict[Direction, Course]
    mirror: bool

    resolution: ClassVar[float] = RESOLUTION

    __repr__ = brief

    @property
    def loops(self) -> tuple[Loop, ...]:
        """Ranges in which the motion depends on the direction, ascending; none unless both directions were followed."""
        if len(self.courses) < 2:
            return ()
        return tuple(_loops(self.courses[Direction.UP], self.courses[Direction.DOWN], self.mirror))


def follow_sweep(sweep: Sweep, values: list[float], block: SimulationBlock) -> Hysteresis:
    """Follow the motion through values of a sweep as the scenario asks; downwards from where upwards has ended."""

    def at(value: float) -> Conditions:
        groups = sweep.device.groups(sweep.parameter, value).as_floats()
        return Conditions(groups, float(sweep.device.velocity_unit(sweep.parameter, value)))

    ascending = sorted(values)
    courses: dict[Direction, Course] = {}
    if block.follow is not Direction.DOWN:
        courses[Direction.UP] = course(ascending, at, impacts=block.impacts)
    if block.follow is not Direction.UP:
        start = courses[Direction.UP].stages[-1] if courses else None
        courses[Direction.DOWN] = course(ascending[::-1], at, start, block.impacts)
    return Hysteresis(courses, sweep.level.horizontal and sweep.device.alike and sweep.parameter.keeps_symmetry)


def _loops(up: Course, down: Course, mirror: bool) -> Iterator[Loop]:
    """The loops between jumps, where both motions change continuously: one value tells whether they are the same."""
    rising, falling = ({jump.value: jump for jump in course.jumps} for course in (up, down))
    ends = [up.stages[0].value, *sorted([*rising, *falling]), up.stages[-1].value]
    stages = list(zip(up.stages, reversed(down.stages), strict=True))
    for low, high in pairwise(ends):
        within = [pair for pair in stages if low < pair[0].value < high]
        if not within and low in falling and high in rising:
            within = [(rising[high].before, falling[low].before)]
        pair = within[len(within) // 2] if within else None
        if pair is not None and pair[0].distance(pair[1], mirror) > CLOSE:
            yield Loop(low, high, *pair)
