"""The one iteration that every method of the accuracy study uses, so that only what it is applied to differs.

Newton's method with a Jacobian by differences, kept and corrected by Broyden's update while that converges, taken
anew where it does not. In one unknown this is the secant method. Plain floats: for one to four unknowns arrays take
several times as long.
"""

from __future__ import annotations

from collections.abc import Callable

from vireport.errors import NumericalError

MOST_STEPS = 30
"""Corrections, of which five to eight are usual from a guess with two digits."""

SLOW = 0.5
"""Ratio of a correction to the one before, with one Jacobian, above which the Jacobian is taken anew."""

LEAST_SHARE = 1 / 64
"""Of a correction, halved until the next one is smaller."""

LONGEST = 0.1
"""Largest correction of an unknown, all of which are of the order of one."""

Residual = Callable[[list[float]], list[float]]


def quasi_newton(residual: Residual, guess: list[float], difference: float, stop: float, noise: float) -> list[float]:
    """Solve residual(x) = 0 from a guess.

    Parameters
    ----------
    residual : callable
        As many numbers as unknowns, of the order of one.
    guess : list of float
    difference : float
        Step of forward differences.
    stop : float
        Correction after which the next x is the solution.
    noise : float
        Residual below which a standstill is rounding or the method's own irregularity.

    Raises
    ------
    NumericalError
        If the corrections do not settle.
    """
    x, value = list(guess), residual(guess)
    inverse, fresh, damped = _inverse(_jacobian(residual, x, value, difference)), True, 1.0
    for _ in range(MOST_STEPS):
        full = _times(inverse, value)
        longest = _norm(full)
        share = min(damped, LONGEST / longest if longest > 0 else 1.0)
        ahead = [a - share * s for a, s in zip(x, full, strict=True)]
        if longest <= stop:
            return ahead
        after = residual(ahead)
        # What the next correction would be with this Jacobian: unlike the residual, it knows no units.
        ratio = _norm(_times(inverse, after)) / longest
        if ratio > SLOW and _norm(value) <= noise:
            return x if _norm(value) <= _norm(after) else ahead
        if ratio > 1 and fresh:
            damped *= 0.5
            if damped < LEAST_SHARE:
                raise NumericalError(f"Newton's method left the motion: its residual grew to {_norm(after):.1g}")
            continue
        if ratio > SLOW and not fresh:
            if ratio < 1:
                x, value = ahead, after
            inverse, fresh = _inverse(_jacobian(residual, x, value, difference)), True
            continue
        change = [a - b for a, b in zip(after, value, strict=True)]
        inverse = _updated(inverse, [a - b for a, b in zip(ahead, x, strict=True)], change)
        x, value, fresh, damped = ahead, after, False, 1.0
    raise NumericalError(f"Newton's method did not settle: residual {_norm(value):.1g} after {MOST_STEPS} corrections")


def _times(matrix: list[list[float]], vector: list[float]) -> list[float]:
    return [sum([a * b for a, b in zip(row, vector, strict=True)]) for row in matrix]


def _norm(vector: list[float]) -> float:
    return max(abs(v) for v in vector)


def _jacobian(residual: Residual, x: list[float], value: list[float], difference: float) -> list[list[float]]:
    columns = []
    for k in range(len(x)):
        shifted = list(x)
        shifted[k] += difference
        columns.append([(a - b) / difference for a, b in zip(residual(shifted), value, strict=True)])
    return [list(row) for row in zip(*columns, strict=True)]


def _inverse(matrix: list[list[float]]) -> list[list[float]]:
    """Inverse by elimination with pivots."""
    count = len(matrix)
    rows = [[*row, *(float(i == k) for k in range(count))] for i, row in enumerate(matrix)]
    for i in range(count):
        pivot = max(range(i, count), key=lambda k: abs(rows[k][i]))
        if not abs(rows[pivot][i]) > 0:
            raise NumericalError("Newton's method: the Jacobian is singular")
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [a / rows[i][i] for a in rows[i]]
        for k in range(count):
            if k != i:
                rows[k] = [a - rows[k][i] * b for a, b in zip(rows[k], rows[i], strict=True)]
    return [row[count:] for row in rows]


def _updated(inverse: list[list[float]], step: list[float], change: list[float]) -> list[list[float]]:
    """Broyden's update of the inverse (Sherman and Morrison)."""
    moved = _times(inverse, change)
    weight = sum(s * m for s, m in zip(step, moved, strict=True))
    if weight == 0:
        return inverse
    left = [sum(step[i] * inverse[i][k] for i in range(len(step))) for k in range(len(step))]
    return [
        [a + (s - m) * row_k / weight for a, row_k in zip(row, left, strict=True)]
        for row, s, m in zip(inverse, step, moved, strict=True)
    ]
