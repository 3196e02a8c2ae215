"""What a ball from rest comes to, looked at briefly: along a sweep, around the design point and at other moments.

Without the compiler, which takes longer to start than all of it. What has not settled after some 500 impacts is not
decided here; `from_rest` goes on.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import takewhile
from operator import itemgetter

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base import brief
from vireport.design import Solution
from vireport.disturbances.from_rest import Destination, FromRest, rested, unpressed
from vireport.disturbances.windows import groups_at
from vireport.motions import Sweep
from vireport.physics import Device, Groups
from vireport.scenario import DesignInput, Parameter, ScalarInput
from vireport.simulation import BOTTOM, REST, RUNNING, Cycle, approached, as_start, check_model, follow_one, presses

Floats = NDArray[np.float64]

VALUES = 21
"""Values along a sweep, its ends among them: 30 to 60 ms for the paper's sweeps, and 150 ms where all is chaotic."""

STEPS = 0.01, 0.02, 0.05, 0.1
"""Distances from the design point to either side, over its value, where no values along a sweep are known. Gaps between
values are not halved for the edge in them: at F = 5.31 N that told 4.172 N, but from 4.196 N on there are others."""

MOMENTS = 8
"""Moments at which the force sets in while the ball is not pressed down, evenly over them."""

IMPACTS = 96, 160, 256
"""Impacts after which it is looked whether they nearly repeat, one after another."""

BUDGET = 1000
"""Impacts after which no further value or moment is looked at: some 15 ms of each."""


class Met(Struct, frozen=True, eq=False):
    """What a ball from rest comes to at a value of an input.

    Attributes
    ----------
    value : float
        Of the input.
    d : float
        The group d there.
    end : FromRest
        Not decided where it has not settled.
    """

    value: float
    d: float
    end: FromRest

    __repr__ = brief

    @property
    def motion(self) -> Cycle | None:
        """The periodic motion without rests that it comes to."""
        return self.end.cycle if self.end.is_motion else None


class Nearby(Struct, frozen=True, eq=False):
    """What a ball from rest comes to beside what it comes to at the design point.

    Attributes
    ----------
    pressed : float
        Share of the moments at which the force may set in in which it presses the ball down and leads to the same.
    moments : tuple of FromRest
        What others lead to.
    parameter : ScalarInput
        The input that is swept, or that in which stable motion ends first.
    value : float
        Of it, at the design point.
    values : tuple of Met
        What values of it lead to, ascending.
    end : FromRest
        What the design point comes to.
    """

    pressed: float
    moments: tuple[FromRest, ...]
    parameter: ScalarInput
    value: float
    values: tuple[Met, ...]
    end: FromRest

    __repr__ = brief

    @property
    def moments_alike(self) -> int:
        """Of those other moments, how many lead to the motion of the design point."""
        return sum(each.kind == self.end.kind for each in self.moments)

    @property
    def alike(self) -> tuple[Met, ...]:
        """The values around the design point, without one between them that leads to something else."""
        below, above = self._sides
        return (*reversed(list(takewhile(self._is_alike, below))), *takewhile(self._is_alike, above))

    @property
    def beyond(self) -> tuple[Met, ...]:
        """The next value to either side, that leads to something else."""
        return tuple(
            other for other in (next((x for x in side if not self._is_alike(x)), None) for side in self._sides) if other
        )

    @property
    def _sides(self) -> tuple[list[Met], list[Met]]:
        """The values below and above the design point, from there on; none where all are on one side."""
        below, above = (
            [x for x in self.values if x.value <= self.value],
            [x for x in self.values if x.value > self.value],
        )
        return (below[::-1], above) if below and (above or below[-1].value == self.value) else ([], [])

    def _is_alike(self, other: Met) -> bool:
        return other.end.kind == self.end.kind


def met_along(sweep: Sweep) -> tuple[Met, ...]:
    """What a ball comes to that lies on the bottom membrane when the force sets in, at values along a sweep.

    Parameters
    ----------
    sweep : Sweep

    Returns
    -------
    tuple of Met
        Ascending.
    """
    values = np.linspace(min(sweep.start, sweep.end), max(sweep.start, sweep.end), VALUES).tolist()
    each = (sweep.device.groups(sweep.parameter, value).as_floats() for value in values)
    ratio = sweep.device.period_ratio
    return tuple(Met(value, groups.d, _met(groups, ratio)[0]) for value, groups in zip(values, each, strict=True))


def nearby(solution: Solution, end: FromRest, along: tuple[Met, ...] = ()) -> Nearby | None:
    """What a ball from rest comes to from other moments of switching on, and at values of an input nearby.

    Parameters
    ----------
    solution : Solution
    end : FromRest
        What the design point comes to.
    along : tuple of Met
        What is known along the sweep.

    Returns
    -------
    Nearby or None
        None where a short look does not tell what the design point comes to, so that it tells of nothing beside it.
    """
    device, design = solution.device, solution.design
    groups, ratio = device.groups(Parameter.LENGTH, device.length_m).as_floats(), device.period_ratio
    releases = presses(groups)
    pressed = [each.share for each in releases if _ending(groups, each.release, ratio, True)[0].kind == end.kind]
    if design is None or not pressed:
        return None
    phases = unpressed(releases, MOMENTS)
    # Every second one first, as the budget may not last for all.
    moments = _within_budget(_ending(groups, phase, ratio, False) for phase in (*phases[::2], *phases[1::2]))
    ends = design.limits()
    swept = solution.sweep.parameter if solution.sweep is not None else None
    varied = swept or (ends[0].parameter if ends else DesignInput.LENGTH)
    values = along or tuple(_around(device, varied))
    return Nearby(sum(pressed), tuple(moments), varied, float(device.value_of(varied)), values, end)


def _around(device: Device, varied: ScalarInput) -> list[Met]:
    """What the ball comes to a little below and above the device's own value of an input, ascending."""
    own, (low, high) = float(device.value_of(varied)), varied.limits
    values = np.array([own * (1 + sign * step) for step in STEPS for sign in (-1, 1)])
    values = values[(low <= values) & (values <= high)] if own else np.empty(0)
    groups = groups_at(device, varied, values)
    each = [groups.each(itemgetter(i)).as_floats() for i in range(len(values))]
    ends = _within_budget(_met(one, device.period_ratio) for one in each)
    met = (Met(value, one.d, end) for value, one, end in zip(values.tolist(), each, ends, strict=False))
    return sorted(met, key=lambda one: one.value)


def _within_budget(ends: Iterable[tuple[FromRest, int]]) -> Iterator[FromRest]:
    """The first outcomes, as far as their impacts are not too many."""
    spent = 0
    for end, impacts in ends:
        yield end
        spent += impacts
        if spent > BUDGET:
            return


def _met(groups: Groups[float], ratio: int) -> tuple[FromRest, int]:
    """What it comes to where it is pressed down at first, and in how many impacts that was seen."""
    releases = presses(groups)
    return _ending(groups, releases[0].release, ratio, True) if releases else (FromRest(Destination.AT_REST), 0)


def _ending(groups: Groups[float], phase: float, ratio: int, released: bool) -> tuple[FromRest, int]:
    """What it comes to that leaves the bottom membrane at a phase, and in how many impacts that was seen.

    It comes back there, if ever, only where the membrane has `released` it, see `rested`.
    """
    model, start, spent = check_model(groups)[0], (float(BOTTOM), 0.0, 0.0, phase), 0
    for impacts in IMPACTS:
        rows, status = follow_one(model, start, impacts, compiled=False)
        spent += len(rows)
        if status[2] != RUNNING:
            return FromRest(Destination.AT_REST if status[2] == REST else Destination.UNDECIDED), spent
        if (known := rested(model, rows, released, compiled=False)) is not None:
            return known[0], spent
        cycle = approached(model, rows, compiled=False)
        if cycle is not None and cycle.growth < 1:
            one_to_one = (cycle.word, cycle.period) == ("BT", ratio)
            moving = Destination.ONE_TO_ONE if one_to_one else Destination.OTHER_MOTION
            kind = Destination.REST_CYCLE if cycle.sticks else moving
            return FromRest(kind, cycle.word, cycle.period, cycle=cycle), spent
        start, released = as_start(rows[-1]), False
    return FromRest(Destination.UNDECIDED), spent
