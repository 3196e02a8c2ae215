"""Points of codimension two, where loci meet, end or touch, and their solution in decimals."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal, localcontext
from functools import partial
from math import inf
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.map.chart.loci import Locus
from vireport.map.chart.plane import DevicePlane
from vireport.motions.conditions import Condition
from vireport.motions.events import Event
from vireport.motions.periodicity import linearised, residuals
from vireport.motions.polish import FARTHEST, newton
from vireport.physics.motion import Motion
from vireport.physics.numbers import DIGITS, FLOATS, DecimalOps
from vireport.physics.word import Word

Floats = NDArray[np.float64]

STEP = 1e-6
"""Step of central differences in doubles: the cube root of their rounding, at which the difference is best."""

AT_CUSP = Decimal("1e-12"), 1e-4
"""Steps along the null vector, of derivatives of the trace in decimals and in doubles."""

AT_DEGENERATE = Decimal("1e-12"), 1e-2
"""Amplitudes of doubled motions that are taken instead of derivatives by it, in decimals and in doubles."""


class Meeting(Struct, frozen=True, eq=False):
    """A point of codimension two, where loci meet, end or touch.

    Attributes
    ----------
    events : tuple of Event
        The two events there, the second one `GRAZING` where a membrane is touched.
    motion : Motion
        With its touches as impacts of velocity zero.
    inputs, error_bound : tuple of float
        Values of the two inputs and bounds of their errors, in their units; inf where no bound is known.
    """

    events: tuple[Event, Event]
    motion: Motion
    inputs: tuple[float, float]
    error_bound: tuple[float, float]

    @property
    def word(self) -> str:
        """The word of the motion without touches."""
        return self.motion.without_impacts(self.motion.rests).word.canonical().letters


def meeting(plane: DevicePlane, motion: Motion, p: Floats, events: tuple[Event, Event]) -> Meeting:
    """Solve for a point in decimals, with the conditions of the motion and of both events; else leave it as it is."""
    size, doubled = 2 * len(motion.word), events[1] is Event.DEGENERATE_DOUBLING
    guess = [*motion.velocity.tolist(), *motion.time.tolist(), *p.tolist()]
    conditions, further = _conditions(plane, motion, guess, events)
    reach = inf if doubled else FARTHEST  # changes with the amplitude may have any size
    with localcontext() as context:
        context.prec = DIGITS * (2 if doubled else 1)
        decimals, doubles = (partial(conditions, replace(plane, ops=ops)) for ops in (DecimalOps(), FLOATS))
        try:
            x = newton(decimals, partial(_differences, doubles, (size, size + 1)), [*guess, *further], reach)
        except NumericalError:
            return Meeting(events, motion, (float(p[0]), float(p[1])), (inf, inf))
        value = [float(number) for number in x[: size + 2]]
        errors = [max(abs(float(x[i] - Decimal(value[i]))), float(np.spacing(abs(value[i])))) for i in (size, size + 1)]
    rounded = np.array(value[:size])
    rounded[list(motion.rests)] = 0.0
    exact = replace(motion, velocity=rounded[: size // 2], time=rounded[size // 2 :])
    return Meeting(events, exact, (value[size], value[size + 1]), (errors[0], errors[1]))


def _differences(function: Callable[[list[float]], list[float]], relative: tuple[int, ...], x: list[float]) -> Floats:
    """Derivatives by central differences, with steps relative to the size of some unknowns."""
    columns = []
    for i, value in enumerate(x):
        step = STEP * (abs(value) if i in relative and value else 1.0)
        ends = (function([*x[:i], value + sign * step, *x[i + 1 :]]) for sign in (1, -1))
        columns.append([(a - b) / (2 * step) for a, b in zip(*ends, strict=True)])
    return np.array(columns).T


MeetingConditions = Callable[[DevicePlane, list[Any]], list[Any]]
"""What is zero at a point, in the kind of number of the plane."""


def _conditions(
    plane: DevicePlane, motion: Motion, guess: list[float], events: tuple[Event, Event]
) -> tuple[MeetingConditions, list[float]]:
    """The conditions of a point, and a guess of the unknowns that they have besides motion and inputs."""
    size, word = 2 * len(motion.word), motion.word
    if events[1] is Event.CUSP:
        normal = np.asarray(
            np.linalg.svd(linearised(word, np.array(guess), plane.local(guess[size:]))[1][:, :size])[2][-1]
        )
        return partial(_at_cusp, word, normal), normal.tolist()
    if events[1] is Event.DEGENERATE_DOUBLING:
        _, _, away = Locus(word, plane, Condition(events[0])).doubled(np.array(guess))
        normal = np.concatenate(np.split(away[:-2], 4)[::2])  # of the first period
        normal /= np.linalg.norm(normal)
        return partial(_at_degenerate, word, normal), [*normal.tolist(), *[0.0] * (2 * size)]
    return partial(_at_grazing, motion, events[0]), []


def _at_grazing(motion: Motion, event: Event, plane: DevicePlane, x: list[Any]) -> list[Any]:
    """The conditions where a membrane is touched, and touched again or another event happens."""
    rests, place = motion.rests, 2 * len(motion.word)
    # Of a symmetric motion the touches of the second half are those of the first.
    free = rests[: len(rests) // 2] if event is Event.PITCHFORK else rests
    conditions = [Condition(Event.GRAZING, (rest,)) for rest in free]
    if event is not Event.GRAZING:
        conditions.append(Condition(event, rests))
    values = (condition.value(motion.word, x[:place], plane.at(x[place:]), plane.ops) for condition in conditions)
    return [*Locus(motion.word, plane, Condition(event)).residuals(x, plane), *values]


def _at_cusp(word: Word, normal: Floats, plane: DevicePlane, x: list[Any]) -> list[Any]:
    """The conditions of a motion and of its null vector, along which the trace does not change, by differences."""
    size, exact = 2 * len(word), plane.ops.exact
    at, way, p = x[:size], x[size + 2 :], x[size : size + 2]
    step = exact(AT_CUSP[plane.ops is FLOATS])
    ends = [[*(value + sign * step * v for value, v in zip(at, way, strict=True)), *p] for sign in (1, -1)]
    groups, fold = plane.at(p), Condition(Event.FOLD)
    ahead, behind = (
        [*residuals(word, end, plane, plane.ops), fold.value(word, end[:size], groups, plane.ops)] for end in ends
    )
    changes = [(a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)]
    length = sum(exact(float(n)) * v for n, v in zip(normal, way, strict=True)) - 1
    return [*residuals(word, [*at, *p], plane, plane.ops), *changes, length]


def _at_degenerate(word: Word, normal: Floats, plane: DevicePlane, x: list[Any]) -> list[Any]:
    """The conditions of motions that begin at a period doubling, with two amplitudes for the same inputs.

    The unknowns are mean and difference of the two periods of such a motion for an amplitude of zero, the difference
    over the amplitude, and how both change with its square. The conditions are even functions of the amplitude.
    """
    size, count = 2 * len(word), len(word)
    p, mean, away = x[size : size + 2], x[:size], x[size + 2 : 2 * size + 2]
    mean_change, away_change = x[2 * size + 2 : 3 * size + 2], x[3 * size + 2 :]
    twice = Word(2 * word.walls, 2 * word.periods)
    amplitude = plane.ops.exact(AT_DEGENERATE[plane.ops is FLOATS])

    def conditions(e: Any) -> list[Any]:
        centre = [m + e * e * a for m, a in zip(mean, mean_change, strict=True)]
        off = [e * (n + e * e * b) for n, b in zip(away, away_change, strict=True)]
        first, second = ([c + sign * o for c, o in zip(centre, off, strict=True)] for sign in (1, -1))
        later = [t + 2 * word.periods for t in second[count:]]
        values = residuals(twice, [*first[:count], *second[:count], *first[count:], *later, *p], plane, plane.ops)
        pairs = list(zip(values[:size], values[size:], strict=True))
        return [*((a + b) / 2 for a, b in pairs), *((a - b) / (2 * e) for a, b in pairs)]

    once, again = conditions(amplitude), conditions(2 * amplitude)
    lengths = (
        sum(plane.ops.exact(float(n)) * v for n, v in zip(normal, vector, strict=True))
        for vector in (away, away_change)
    )
    changes = ((b - a) / amplitude**2 for a, b in zip(once, again, strict=True))
    return [*once, *changes, next(lengths) - 1, next(lengths)]
