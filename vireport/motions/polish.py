"""Newton's method in decimals for a motion at which one further equation holds, as at a critical point.

The unknowns are velocities and times of the impacts, and what varies of the device. A touch of a membrane is an impact
of velocity zero, so that grazing needs no further unknowns. With 45 digits the result is correct to the last digit of a
double even where half of them cancel.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from decimal import Context, Decimal, localcontext
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.motions.conditions import Equation
from vireport.motions.periodicity import Varied, linearised, residuals
from vireport.physics.groups import Groups
from vireport.physics.motion import Motion
from vireport.physics.numbers import ARRAYS, DIGITS, FLOATS, IMAGINARY_STEP, DecimalOps
from vireport.physics.word import Word

Floats = NDArray[np.float64]

DECIMALS = DecimalOps()
"""Numbers in which motions are solved for, with `DIGITS` digits within `in_decimals`."""

SETTLED = 1e-32
"""Size of the next correction that ends the search: small enough for the difference of nearly equal flight times."""

FARTHEST = 1e-3
"""Distance from the guess beyond which a solution is another motion, or none."""

SLOW = 0.05
"""Share of the last correction beyond which the Jacobian is evaluated anew."""

DOUBLE_JACOBIANS, MOST_JACOBIANS = 4, 8
"""Number of Jacobians in doubles, of which one is usual, before they are evaluated in decimals; and number of both.
Next to a degenerate point the derivatives in doubles have no digits left."""

MOST_STEPS = 12
"""Largest number of corrections with one Jacobian, of which three are usual."""

FINE_STEP = Decimal("1e-18")
"""Step of differences in decimals: far below any scale of a motion, far above their rounding."""

Function = Callable[[list[Any]], list[Any]]
"""(unknowns) -> residuals, as many as unknowns."""


def in_decimals() -> AbstractContextManager[Context]:
    """Context in which decimals have `DIGITS` digits."""
    return localcontext(prec=DIGITS)


def newton(
    exact: Function,
    jacobian: Callable[[list[float]], Floats],
    guess: Sequence[Any],
    reach: float = FARTHEST,
    watched: slice = slice(None),
) -> list[Decimal]:
    """Solve equations in decimals, by corrections with a Jacobian in doubles.

    Parameters
    ----------
    exact : callable
        The equations in decimals.
    jacobian : callable
        Their derivatives in doubles: (unknowns) -> (equations, unknowns).
    guess : sequence of float or Decimal
    reach : float
        Farthest from the guess that the solution may be.
    watched : slice
        The unknowns to which `reach` applies.

    Raises
    ------
    NumericalError
        If the corrections do not settle, or lead farther.
    """
    start = [value if isinstance(value, Decimal) else Decimal(float(value)) for value in guess]
    x = start
    for attempt in range(MOST_JACOBIANS):
        matrix = jacobian([float(value) for value in x]) if attempt < DOUBLE_JACOBIANS else _differences(exact, x)
        # Only residuals have to be exact. With a Jacobian in doubles each correction is a small share of the last, that
        # by which it is wrong; in decimals each derivative would take two evaluations of all equations.
        inverse, last = _inverse(matrix), 0.0
        for _ in range(MOST_STEPS):
            step = inverse @ np.array([float(value) for value in exact(x)])
            x = [value - Decimal(float(off)) for value, off in zip(x, step, strict=True)]
            size = float(np.abs(step).max())
            if not max(abs(float(a - b)) for a, b in zip(x[watched], start[watched], strict=True)) < reach:
                raise NumericalError(f"{_near(guess)} was lost (correction {size:.1g})")
            # With one Jacobian each correction is about the same share of the last one: size^2/last is the size of the
            # next, which need not be made if it is below `SETTLED`.
            if size < SETTLED or (last and size * size < SETTLED * last and size < last):
                return x
            if last and size > SLOW * last:
                break
            last = size
    raise NumericalError(f"{_near(guess)} did not settle (last correction {size:.1g})")


def _near(guess: Sequence[Any]) -> str:
    """Words for the motion at which Newton's method fails, by its unknowns."""
    return f"the motion near {', '.join(f'{float(value):.6g}' for value in guess)}"


def _differences(exact: Function, x: list[Decimal]) -> Floats:
    """Jacobian by central differences in decimals, rounded to doubles."""
    columns = []
    for i, value in enumerate(x):
        step = FINE_STEP * max(abs(value), FINE_STEP)
        ahead, behind = (exact([*x[:i], value + sign * step, *x[i + 1 :]]) for sign in (1, -1))
        columns.append([float((a - b) / (2 * step)) for a, b in zip(ahead, behind, strict=True)])
    return np.array(columns).T


def _inverse(matrix: Floats) -> Floats:
    """Inverse of a Jacobian, whose rows are first brought to one size."""
    # Elimination chooses its pivots by size, and next to a touch the last row, a trace times small velocities, is
    # decades smaller than the others.
    size = np.max(np.abs(matrix), axis=1)
    if np.all(np.isfinite(matrix)) and size.all():
        try:
            with np.errstate(over="ignore"):  # a condition within the subnormal numbers
                inverse = np.asarray(np.linalg.inv(matrix / size[:, None]) / size)
        except np.linalg.LinAlgError as error:
            raise NumericalError("a critical point is degenerate: two of its conditions coincide") from error
        if np.all(np.isfinite(inverse)):
            return inverse
    raise NumericalError("a critical point is degenerate: its conditions do not depend on the motion")


class Solved(Struct, frozen=True, eq=False):
    """A motion whose equations are solved in decimals.

    Attributes
    ----------
    word : Word
    x : list of Decimal
        Velocities and times of the impacts [y_c, t_c], and the numbers that vary.
    groups : Groups of Decimal
        Groups of the device that has the motion.
    symmetric : bool
        Whether it was solved for as a motion that is its own mirror image: it then is one exactly.
    """

    word: Word
    x: list[Decimal]
    groups: Groups[Decimal]
    symmetric: bool

    def mirrored(self, first: int) -> Solved:
        """The mirror image with its impacts counted from the image of impact `first`; within `in_decimals`."""
        count, period = len(self.word), 2 * self.word.periods
        velocity, time = self.x[:count], self.x[count : 2 * count]
        # The image is half a forcing period later, less whole periods: its first impact is within the first period.
        late = 1 - 2 * ((time[first] + 1) // 2)
        x = [
            *(-v for v in (*velocity[first:], *velocity[:first])),
            *(t + late for t in (*time[first:], *(t + period for t in time[:first]))),
            *self.x[2 * count :],
        ]
        return replace(self, word=self.word.mirrored().rotated(first), x=x)


def solve_motion(
    grouped: Callable[[Any], Varied],
    guess: Motion,
    equation: Equation,
    symmetric: bool = False,
    reach: float = FARTHEST,
) -> Solved:
    """Solve the conditions of a motion and one further equation together; within `in_decimals`.

    Parameters
    ----------
    grouped : callable
        (kind of number) -> how the groups depend on what varies; called with `DECIMALS`, `ARRAYS` and `FLOATS`.
    guess : Motion
        Good to a few digits, with its touches as impacts of velocity zero.
    equation : callable
        Zero at the motion that is solved for.
    symmetric : bool
        Whether the motion is its own mirror image. Then only the first half of its impacts is solved for, of which the
        second half is the image: with all unknowns the equations are singular at a pitchfork, and q = 1/2 is not exact.
    reach : float
        Farthest that the motion may be from the guess, in time [t_c]. Velocities are not limited: next to r = 1 they
        change much with small changes of time.

    Returns
    -------
    Solved

    Raises
    ------
    NumericalError
        If the corrections do not settle.
    """
    word, count = guess.word, len(guess.word)
    half, k = count // 2, guess.word.periods
    back = [i for i, wall in enumerate(word.walls) if wall == word.walls[(i + 1) % count]]
    # Made once and not in `conditions`: worked out anew at each correction they took a tenth of the time.
    exact, arrays, floats = (grouped(ops) for ops in (DECIMALS, ARRAYS, FLOATS))

    def whole(y: list[Any]) -> list[Any]:
        """All unknowns of the motion, from those that are solved for."""
        if not symmetric:
            return y
        # After half a period of the motion, k t_c, every impact is the mirror image of one half a period before.
        velocity, time = y[:half], y[half:-1]
        return [*velocity, *(-v for v in velocity), *time, *(t + k for t in time), y[-1]]

    def duration(x: Sequence[Any], i: int) -> Any:
        flown = (x[count + i + 1] if i + 1 < count else x[count] + 2 * k) - x[count + i]
        if not flown:
            raise NumericalError(f"two impacts of {word.letters} come at one time")
        return flown

    # A flight back to the membrane that it left covers nothing in no time either: divided by its duration, the distance
    # only vanishes where the ball has been away. Touches a moment after an impact are lost otherwise.
    def conditions(y: list[Any]) -> list[Any]:
        x = whole(y)
        values = residuals(word, x, exact, DECIMALS)
        for i in back:
            values[2 * i + 1] /= duration(x, i)
        # Of a symmetric motion the second half of the conditions repeats the first one, and is left out.
        return [*values[: len(y) - 1], equation(x, exact.at(x[2 * count :]), DECIMALS)]

    def jacobian(y: list[float]) -> Floats:
        x = whole(y)
        values, rows = linearised(word, np.array(x), floats)
        for i in back:
            by_times = np.zeros(len(x))
            by_times[[count + i, count + (i + 1) % count]] += -1.0, 1.0
            rows[2 * i + 1] -= values[2 * i + 1] / duration(x, i) * by_times
            rows[2 * i + 1] /= duration(x, i)
        if symmetric:
            rows = rows[: 2 * half]
            by_velocity, by_time = np.split(rows[:, : 2 * count], 2, axis=1)
            moved = by_velocity[:, :half] - by_velocity[:, half:], by_time[:, :half] + by_time[:, half:]
            rows = np.hstack([*moved, rows[:, 2 * count :]])
        # The equation comes without derivatives: each unknown is an array, moved in its own column only.
        steps = whole(list(np.array(y)[:, None] + 1j * IMAGINARY_STEP * np.eye(len(y))))
        slope = np.imag(equation(steps, arrays.at(steps[2 * count :]), ARRAYS)) / IMAGINARY_STEP
        return np.vstack([rows, slope])

    start = [*guess.velocity.tolist(), *guess.time.tolist(), guess.coordinate]
    if symmetric:
        start = [*start[:half], *start[count : count + half], start[-1]]
    times = slice(half, 2 * half) if symmetric else slice(count, 2 * count)
    x = whole(newton(conditions, jacobian, start, reach, times))
    return Solved(word, x, exact.at(x[2 * count :]), symmetric)
