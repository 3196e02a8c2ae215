"""Motions singled out by an event, to the last digit of a double: solved in decimals, with error bounds."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, localcontext
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.motions.motion import Motion
from vireport.motions.paths import Curve, Event
from vireport.motions.periodicity import (
    Model,
    linearised,
    residuals,
    trace,
)
from vireport.motions.sweep import Sweep
from vireport.motions.switching import at_rest
from vireport.physics import COMPLEX, DIGITS, DecimalOps

Floats = NDArray[np.float64]

SETTLED, FARTHEST = 1e-28, 1e-3
"""Correction still due up to which a double is certain, and the one at which the point has been left for another."""

MOST_STEPS = 12
"""Corrections, of which two are usual."""

STEP = 1e-100
"""Of imaginary steps: derivatives by them are free of differences, and so exact up to rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class PolishedPoint:
    """A motion singled out by an event.

    Attributes
    ----------
    motion : Motion
        Correctly rounded; at a grazing point with the touches as impacts of velocity zero.
    d, gbar : float
        Correctly rounded.
    sweep_value, error_bound : float
        In the unit of the swept parameter; inf where the conditions do not settle in decimals, as where several events
        coincide.
    """

    motion: Motion
    d: float
    gbar: float
    sweep_value: float
    error_bound: float


def polished(sweep: Sweep, curve: Curve, motion: Motion, event: Event) -> PolishedPoint:
    """Solve the conditions of a motion and of an event together, from the motion as it was found in doubles."""
    with localcontext() as context:
        context.prec = DIGITS
        ops = DecimalOps()
        model = Model(sweep.level_in(ops), ops.exact(sweep.device.restitution))
        x = _Conditions(curve, motion, event).solved(model, ops)
        if x is None:
            d, gbar = curve.model.groups(motion.coordinate)
            return PolishedPoint(motion, float(d), float(gbar), float(sweep.value(d, gbar)), inf)
        d, gbar = model.groups(x[-1])
        exact = sweep.value(d, gbar, ops)
        value = float(exact)
        error = max(abs(float(exact - Decimal(value))), float(np.spacing(abs(value))))
        rounded = np.array([float(number) for number in x])
        rounded[list(at_rest(curve.motion(rounded)))] = 0.0
        return PolishedPoint(curve.motion(rounded), float(d), float(gbar), value, error)


@dataclass(frozen=True, slots=True)
class _Conditions:
    """Conditions of a motion and of an event, in the unknowns that its symmetry leaves."""

    curve: Curve
    motion: Motion
    event: Event

    def solved(self, model: Model, ops: DecimalOps) -> list[Decimal] | None:
        """The unknowns of the motion, by corrections with a Jacobian in doubles; None where they do not settle."""
        guess = self.reduced(self.curve.vector(self.motion))
        try:
            inverse = np.linalg.inv(self._jacobian(np.array(guess)))
        except np.linalg.LinAlgError:
            return None
        y, last = [ops.exact(float(value)) for value in guess], SETTLED
        for _ in range(MOST_STEPS):
            step = inverse @ np.array([float(value) for value in self.residuals(y, model, ops)])
            y = [value - ops.exact(float(off)) for value, off in zip(y, step, strict=True)]
            size = float(np.abs(step).max())
            if not size < FARTHEST:
                return None
            if size * min(size / last, 1.0) < SETTLED:  # the next one, as each is about the same share of the last
                return self.whole(y)
            last = size
        return None

    def _jacobian(self, y: Floats) -> Floats:
        """Derivatives of the motion's conditions, and of the event's by imaginary steps."""
        model, steps = self.curve.model, y + 1j * STEP * np.eye(len(y))
        origin = np.array(self.whole(list(0 * y)))
        spread = np.stack([np.array(self.whole(list(unit))) - origin for unit in np.eye(len(y))], axis=1)
        matrix = linearised(self.curve.word, np.array(self.whole(y.tolist())), model)[1]
        gradient = [self._condition(self.whole(step), model, COMPLEX).imag / STEP for step in steps.tolist()]
        return np.vstack([(matrix @ spread)[: len(y) - 1], gradient])

    def reduced(self, x: Any) -> list[Any]:
        """Of a symmetric motion the first half of the impacts, else all that is given, and the coordinate."""
        count = len(self.curve.word)
        if self.event is not Event.PITCHFORK:
            return list(x)
        return [*x[: count // 2], *x[count : count + count // 2], x[-1]]

    def whole(self, y: list[Any]) -> list[Any]:
        """The unknowns of the motion: the second half of the impacts is the mirror image of the first."""
        if self.event is not Event.PITCHFORK:
            return y
        half, k = len(y) // 2, self.curve.word.periods
        velocity, time = y[:half], y[half:-1]
        return [*velocity, *(-v for v in velocity), *time, *(t + k for t in time), y[-1]]

    def residuals(self, y: list[Any], model: Model, ops: Any) -> list[Any]:
        """The motion's, of a symmetric one over the first half, and the event's."""
        word, x = self.curve.word, self.whole(y)
        return [*residuals(word, x, model, ops)[: len(y) - 1], self._condition(x, model, ops)]

    def _condition(self, x: list[Any], model: Model, ops: Any) -> Any:
        if self.event is Event.GRAZING:
            return x[at_rest(self.motion)[0]]
        decay = model.r ** len(self.curve.word)
        value = trace(self.curve.word, x, model, ops)
        if self.event is Event.NODE_FOCUS:
            return value - (2 * decay if value.real > 0 else -2 * decay)
        return value + (1 + decay * decay) * (1 if self.event is Event.PERIOD_DOUBLING else -1)
