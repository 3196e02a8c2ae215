"""What the judge of the extreme cases finds without a guess: every turning point of a motion, and every motion.

Sampled in doubles from the printed equations, then taken to 40 digits by `highprecision`; within its `precise`.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vireport.reference import State, flight, flights, motion, mp, mpf, newton, symmetric_motions, velocity_top

SHORTEST = 1e-10
"""Time after an impact from which turning points are looked for; a ball that hardly rebounds turns at once."""

OFF_CENTRE = 1 - 1.7e-9
"""Factor that keeps the samples of q off the round values at which the three equations are dependent."""


def turning_points(state: State, d: Any, gbar: Any, r: Any, n: int) -> list[tuple[Any, int, Any]]:
    """Zeros of Z' in the flights, where its sign changes between samples: gap to the nearer wall, flight, time."""
    found = []
    for k, (start, speed, phase, duration) in enumerate(flights(state, d, gbar, r, n)):
        short = np.geomspace(SHORTEST, 1e-3, 600)
        t = np.linspace(0.0, float(duration), 4000 * n)[1:-1]
        t = np.sort(
            np.concatenate([t, *(x[x < float(duration)] for x in (short, float(duration) - short) if x[0] > 0)])
        )
        rate = flight(t, float(start), float(speed), float(phase), float(gbar), np)[1]
        for i in np.flatnonzero((rate[1:] > 0) != (rate[:-1] > 0)):
            leaving = start, speed, phase, gbar
            zero = _turn(leaving, mpf(float(t[i])), mpf(float(t[i + 1])), bool(rate[i + 1] > 0))
            z = flight(zero, *leaving)[0]
            found.append((min(d / 2 - z, d / 2 + z), k, zero))
    return found


def _turn(leaving: tuple[Any, Any, Any, Any], low: Any, high: Any, rising: bool) -> Any:
    """Zero of Z' between two times."""
    for step in range(200):
        if step == 16:
            try:
                zero = newton(partial(_rate, leaving), [(low + high) / 2])[0]
            except ArithmeticError:
                zero = low  # nearly a double zero: by bisection alone
            if low < zero < high:
                return zero
        middle = (low + high) / 2
        low, high = (low, middle) if (_rate(leaving, [middle])[0] > 0) == rising else (middle, high)
    return (low + high) / 2


def _rate(leaving: tuple[Any, Any, Any, Any], x: list[Any]) -> list[Any]:
    return [flight(x[0], *leaving)[1]]


def pressing(state: State, gbar: Any, n: int, at_top: bool) -> Any:
    """Acceleration Z'' at an impact, which changes its sign where a wall begins to hold the ball."""
    later = mp.pi * 2 * n * (mpf(1) / 2 + state[2]) if at_top else 0
    return gbar + mp.cos(state[1] + later)


def short_touch(state: State, gbar: Any, r: Any, n: int, which: int) -> tuple[Any, Any]:
    """Pressing acceleration, and time after the impact, at which a ball that hardly rebounds touches the wall again.

    Its distance from the wall, v t - a t^2/2 - j t^3/6, and its velocity vanish where a = (-8 j v/3)^(1/2) and
    t = -3 a/(2 j).
    """
    velocity, phase, u = state
    later = mp.pi * 2 * n * (mpf(1) / 2 + u) if which else 0
    jerk = (1 if which else -1) * mp.pi * mp.sin(phase + later)
    speed = r * abs(velocity_top(state, gbar, r, n) if which else velocity)
    press = mp.sqrt(max(-8 * jerk * speed / 3, 0))
    return press, -3 * press / (2 * jerk)


def wall_gap(state: State, d: Any, gbar: Any, r: Any, n: int) -> Any:
    """Smallest distance to a membrane at the turning points, d where the ball never turns back."""
    return min([d, *(gap for gap, _, _ in turning_points(state, d, gbar, r, n))])


def all_motions(d: Any, gbar: Any, r: Any, n: int) -> list[State]:
    """Every solution of (3.9)-(3.11) for given d and gbar with impacts of the right sign, found without a guess.

    For each q the three equations are linear in the velocity, sin(phi) and cos(phi); q solves the problem where
    sin^2 + cos^2 = 1. That is sampled in doubles, in every decade next to q = 0, 1/2 and 1; the zeros are then taken
    to 40 digits. Two solutions that nearly meet (a fold) may fall between two samples.
    """
    found = [*symmetric_motions(d, r, n)] if gbar == 0 and n % 2 else []
    for guess in _crossings(float(d), float(gbar), float(r), n):
        try:
            found.append(motion(guess, d, gbar, r, n))
        except ArithmeticError:
            continue  # next to q = 0 or 1 the equations degenerate; what is lost there passes through a membrane
    return [state for state in found if state[0] > 0 > velocity_top(state, gbar, r, n)]


def _crossings(d: float, gbar: float, r: float, n: int) -> Iterator[list[float]]:
    """Guesses of (velocity, phase, u), in doubles, where sin^2 + cos^2 - 1 changes its sign along q."""
    smallest = max(gbar * 1e-3, 1e-13) if gbar else 1e-7
    decades = np.geomspace(smallest, 1e-3, 400)
    edge = 0.5 - np.geomspace(1e-8, 1e-3, 120)
    u = np.sort(np.concatenate([OFF_CENTRE * np.linspace(-0.5, 0.5, 8000 * n)[1:-1], decades, -decades, edge, -edge]))
    excess, _ = _linear(u, d, gbar, r, n)
    index = np.flatnonzero((excess[1:] > 0) != (excess[:-1] > 0))
    low, high = u[index], u[index + 1]
    rising = excess[index + 1] > 0
    for _ in range(60):
        middle = (low + high) / 2
        upper = (_linear(middle, d, gbar, r, n)[0] > 0) == rising
        low, high = np.where(upper, low, middle), np.where(upper, middle, high)
    for x, (velocity, sine, cosine) in zip(high, _linear(high, d, gbar, r, n)[1], strict=True):
        yield [float(velocity), float(np.arctan2(sine, cosine)), float(x)]


def _linear(
    u: NDArray[np.float64], d: float, gbar: float, r: float, n: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """sin^2 + cos^2 - 1, and (velocity, sin, cos), from (3.9)-(3.11) at each u, in doubles."""
    if not u.size:
        return u, np.empty((0, 3))
    period, pi, one = 2 * n, np.pi, np.ones_like(u)
    up, down, a = n + period * u, n - period * u, pi * (n + period * u)
    reach = up * down / (2 * period)
    matrix = np.array(
        [
            [(r - 1) * one, -(np.cos(a) - 1) / pi, -np.sin(a) / pi],
            [r * up - down, period / pi * one, 0 * one],
            [2 * (1 + r) * reach, -np.sin(a) / pi**2, (np.cos(a) - 1) / pi**2],
        ]
    ).transpose(2, 0, 1)
    right = np.array([-gbar * (period / (1 + r) - up), period / 2 * (up - down) * gbar, d + reach * gbar * period]).T
    solution = np.linalg.solve(matrix, right[..., None])[..., 0]
    return np.sum(solution[:, 1:] ** 2, axis=1) - 1, solution
