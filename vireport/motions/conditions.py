"""The one equation that holds at an event of a motion besides the conditions of the motion itself.

Level curves, paths, loci in two inputs and the solution in decimals all take it from `Condition`: so an event is the
same for each of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from decimal import Decimal
from math import prod
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.motions.events import TRACE_LEVELS, Event
from vireport.motions.periodicity import weighted_trace
from vireport.motions.turning import slow_places
from vireport.physics import flight
from vireport.physics.forcing import force_rate
from vireport.physics.groups import Groups
from vireport.physics.numbers import ARRAYS, IMAGINARY_STEP, Arithmetic, ExactFunctions
from vireport.physics.word import Word

Floats = NDArray[np.float64]

TIME_STEPS = 3
"""Newton steps from doubles to decimals for the time at which the ball is slowest: each doubles the digits."""

Equation = Callable[[Sequence[Any], Groups[Any], Any], Any]
"""(velocities, times and what varies; groups; functions of the kind of number) -> a number, zero at the event."""


class Condition(Struct, frozen=True):
    """The equation that holds where an event of a motion occurs.

    Attributes
    ----------
    event : Event
    rests : tuple of int
        Impacts of velocity zero; the first one is the touch at a grazing point, or the impact that loses its velocity.
        The trace in conditions is of the motion without them.
    sign : int
        Sign of the trace, where the type changes between node and focus; at an end of the sweep, 1 for the upper one.
    held : int or None
        For a ball with restitution zero that grazes at the very time of an impact: that impact, at which the membrane
        begins to hold the ball.
    stops : int or None
        The impact that begins the flight in which a ball with friction comes to a stop.
    """

    event: Event
    rests: tuple[int, ...] = ()
    sign: int = 1
    held: int | None = None
    stops: int | None = None

    def excess(self, trace: Arithmetic, decay: Arithmetic) -> Any:
        """The trace less its value at the event; `decay` as in `TRACE_LEVELS`."""
        return trace - self.sign * TRACE_LEVELS[self.event](decay)

    def trace(self, excess: Arithmetic, decay: Arithmetic) -> Any:
        """The trace from its `excess`, the inverse of that method."""
        return excess + self.sign * TRACE_LEVELS[self.event](decay)

    def value(self, word: Word, x: Sequence[Any], groups: Groups[Any], ops: ExactFunctions) -> Any:
        """The function of a motion that is zero where the condition holds, in any kind of number.

        Parameters
        ----------
        word : Word
        x : sequence
            The N velocities and N times of the impacts [y_c, t_c].
        groups : Groups
        ops
            Functions of the kind of number, see `vireport.physics.numbers`.

        Notes
        -----
        The trace is multiplied by the velocities of all impacts that have one, so that it has no pole where one of them
        vanishes.
        """
        if self.stops is not None:
            return _least_speed(word, x, groups, ops, self.stops)
        if self.held is not None:
            return groups.pull(groups.wave(ops.pi * x[len(word) + self.held], ops).force)
        if self.event in (Event.GRAZING, Event.ZERO_VELOCITY):
            return x[self.rests[0]]
        if self.event is Event.DEGENERATE_GRAZING:
            return weighted_trace(word, x, groups, ops)
        # An impact without velocity is a touch: the multipliers are those of the motion without it, whose trace is
        # finite.
        count = len(word)
        kept = [i for i in range(count) if i not in self.rests]
        word = Word(tuple(word.walls[i] for i in kept), word.periods)
        x = [x[i] for i in (*kept, *(count + i for i in kept))]
        level = self.sign * TRACE_LEVELS[self.event](groups.decay(word.walls, x[: len(kept)]))
        return weighted_trace(word, x, groups, ops) - level * prod(x[: len(kept)])

    def equation(self, word: Word) -> Equation:
        """The `value` for the motions of one word, as a further equation for `polish.solve_motion`."""
        return lambda x, groups, ops: self.value(word, x, groups, ops)

    def linearised(self, word: Word, x: Floats, groups: Groups[float], gradients: Floats) -> tuple[float, Floats]:
        """The value and its gradient by the unknowns, both divided by the length of the gradient.

        Parameters
        ----------
        word : Word
        x : ndarray
            Velocities and times of the impacts, and what varies of the device.
        groups : Groups
        gradients : ndarray, shape (numbers, varied)
            Of `Groups.numbers` by what varies.
        """
        unknowns = 2 * len(word)
        # A touch is one of the unknowns itself.
        if self.event is Event.GRAZING and self.held is None:
            return float(x[self.rests[0]]), np.eye(1, len(x), self.rests[0])[0]
        # Every number is moved by an imaginary step in its own column: the derivatives come in one evaluation, exact.
        at = np.append(x[:unknowns], groups.numbers)
        steps = list(at[:, None] + 1j * IMAGINARY_STEP * np.eye(len(at)))
        values = self.value(word, steps[:unknowns], groups.with_numbers(steps[unknowns:]), ARRAYS)
        slopes = np.imag(values) / IMAGINARY_STEP
        gradient = np.append(slopes[:unknowns], slopes[unknowns:] @ gradients)
        # The trace times all velocities may be of any size; divided by its gradient it is a distance, as the other
        # conditions are, so that one tolerance fits all.
        length = float(np.linalg.norm(gradient)) or 1.0
        return float(np.real(values[0])) / length, gradient / length


def held_at_once(time: Floats, groups: Groups[Any]) -> Condition:
    """Grazing of a ball with restitution zero at the time of an impact, the one where Z'' is nearest to zero."""
    pressed = np.abs(groups.pull(groups.wave(np.pi * time, ARRAYS).force))
    return Condition(Event.GRAZING, held=int(np.argmin(pressed)))


def stopped(word: Word, x: Sequence[float], groups: Groups[float]) -> Condition:
    """The condition that a ball with friction comes to a stop, in the flight in which it is slowest."""
    count = len(word)
    slow = min(slow_places(word, x[:count], x[count : 2 * count], groups), key=lambda place: place.speed)
    return Condition(Event.STOP, stops=slow.after)


def _least_speed(word: Word, x: Sequence[Any], groups: Groups[Any], ops: ExactFunctions, after: int) -> Any:
    """The least speed onward in the flight that begins with impact `after`, in any kind of number.

    The time is located in doubles and refined in the kind of number by Newton's steps to the zero of Z''. An error of
    the time enters the speed, which is extremal then, with its square only.
    """
    count, wall = len(word), word.walls[after]
    near = [_double(number) for number in x[: 2 * count]]
    doubles = groups.map_numbers(_double)
    places = slow_places(word, near[:count], near[count:], doubles)
    t = ops.exact(min((place for place in places if place.after == after), key=lambda place: place.speed).time)
    way = (word.walls[(after + 1) % count] - wall) // 2
    for _ in range(TIME_STEPS):
        phase = ops.pi * t
        pull = groups.pull(groups.wave(phase, ops).force, way)
        t = t - pull / (ops.pi * force_rate(ops.sin(phase), ops.cos(phase), groups.harmonics))
    start, velocity = x[count + after], groups.after(wall, x[after])
    begun, slowest = groups.wave(ops.pi * start, ops), groups.wave(ops.pi * t, ops)
    return way * flight.velocity(t - start, velocity, begun.impulse, slowest.impulse, groups.gravity(way), ops.pi)


def _double(number: Any) -> float:
    """A number of any kind as a double; of arrays with imaginary steps, the real part that all entries share."""
    return float(number) if isinstance(number, Decimal) else float(np.real(np.ravel(number)[0]))
