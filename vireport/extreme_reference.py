"""The model in 40-digit arithmetic, to judge the extreme cases by: written from the printed equations alone.

It shares no line with the solution or the simulation. Numbers of the package enter as the exact values of their
doubles. Everything is dimensionless but for `groups` and `voltage`; a state is (velocity at the bottom impact, phase
there, u = q - 1/2). Needs mpmath.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from mpmath import mp as mp  # type: ignore[import-untyped]
from mpmath import mpf as mpf
from numpy.typing import NDArray

from vireport.model import PARAMETERS, Device, Parameter

DIGITS = 60
"""Working precision: 40 digits are left where twenty cancel, as they do for a gbar of 1e-16."""

SETTLED = 40
"""Decades below its scale to which Newton's last step has fallen."""

MOST_STEPS = 40
"""Newton steps, of which six are usual from a guess in doubles; near a double root each gains but a factor of two."""

VOLTAGE_DIGITS = 420
"""Of a voltage: at 1e-300 m/s the deflection is 1e-168 m, and the formulae subtract its square from 1."""

SHORTEST = 1e-10
"""Time after an impact from which turning points are looked for; a ball that hardly rebounds turns at once."""

OFF_CENTRE = 1 - 1.7e-9
"""Factor that keeps the samples of q off the round values at which the three equations are dependent."""

State = tuple[Any, Any, Any]
"""Velocity before the bottom impact [y_c], phase there [rad], q - 1/2."""

precise: Any = mp.workdps(DIGITS)
"""Context in which the functions below are to be called."""


def groups(device: Device, parameter: Parameter, value: Any) -> tuple[Any, Any]:
    """Return d and gbar of a device whose `parameter` has `value`, Eqs. (2.5) and (2.6)."""
    x = {name: mpf(getattr(device, name)) for name in PARAMETERS}
    x[parameter] = mpf(value)
    mass, force = mpf(device.capsule_mass_kg), x["amplitude_n"]
    length_unit = force * mp.pi**2 / (mass * (2 * mp.pi * x["frequency_hz"]) ** 2)
    weight = mass * mpf(device.gravity_m_s2) * mp.sin(x["inclination_deg"] * mp.pi / 180)
    return x["length_m"] / length_unit, weight / force


def flight(t: Any, start: Any, speed: Any, phase: Any, gbar: Any, ops: Any = mp) -> tuple[Any, Any]:
    """Z and Z' a time t after leaving `start` with `speed`, Eqs. (2.11) and (2.12) with (3.13)."""
    pi = ops.pi
    f1, f1_start = ops.sin(pi * t + phase) / pi, ops.sin(phase) / pi
    f2, f2_start = -ops.cos(pi * t + phase) / pi**2, -ops.cos(phase) / pi**2
    position = start + speed * t + gbar / 2 * t**2 + f2 - f2_start - f1_start * t
    return position, speed + gbar * t + f1 - f1_start


def periodicity(state: State, d: Any, gbar: Any, r: Any, n: int) -> list[Any]:
    """Residuals of (3.9), (3.10) and (3.11), the second multiplied out."""
    velocity, phase, u = state
    period = mpf(2 * n)
    up = period * (mpf(1) / 2 + u)
    down, a, pi = period - up, mp.pi * up, mp.pi
    sine, cosine = mp.sin(phase), mp.cos(phase)
    reach = up * down / (2 * period) * (2 * (1 + r) * velocity - gbar * period)
    return [
        (r - 1) * velocity - (mp.cos(a) - 1) / pi * sine - mp.sin(a) / pi * cosine + gbar * (period / (1 + r) - up),
        (r * up - down) * velocity + period / pi * sine - period / 2 * (up - down) * gbar,
        (mp.cos(a) - 1) / pi**2 * cosine - mp.sin(a) / pi**2 * sine + reach - d,
    ]


def velocity_top(state: State, gbar: Any, r: Any, n: int) -> Any:
    """Velocity before the top impact, Eq. (3.8)."""
    return gbar * 2 * n / (1 + r) - state[0]


def trace(state: State, gbar: Any, r: Any, n: int, ops: Any = mp) -> Any:
    """Tr(DP) by Eq. (A.4); with numpy for `ops`, of arrays."""
    velocity, phase, u = state
    period = 2 * n
    up = period * (0.5 + u)
    down = period - up
    f0, f1, f2 = ops.cos(phase), ops.cos(phase + ops.pi * up), ops.cos(phase + ops.pi * period)
    s3 = velocity - gbar * period / (r + 1)
    s1 = up * f0 - r * velocity + gbar * up
    s2 = down * f1 + r * s3 + gbar * down
    return (
        (r + r * up * (gbar + f1) / s3) * (r - r * down * (gbar + f2) / velocity)
        + r * up * (gbar + f1 - (gbar + f2) * s2 / velocity) / s3
        - r * down * (gbar + f0 + (gbar + f1) * s1 / s3) / velocity
        - s2 * s1 / (velocity * s3)
    )


def symmetric_velocity(phase: Any, r: Any) -> Any:
    """Velocity at either impact of a symmetric motion: (3.9) at q = 1/2 and gbar = 0, for odd n."""
    return 2 * mp.sin(phase) / (mp.pi * (1 - r))


def newton(function: Callable[[list[Any]], list[Any]], guess: list[Any], scale: list[Any] | None = None) -> list[Any]:
    """Solve function(x) = 0 from a guess; with more unknowns than equations, for the nearest solution.

    Distances are measured in `scale`, the size of each unknown by default.

    Raises
    ------
    ArithmeticError
        If the steps do not settle.
    """
    x = [mpf(value) for value in guess]
    scale = [mpf(value) for value in scale] if scale else [abs(value) or mpf(1) for value in x]
    h = mpf(10) ** (-DIGITS // 2)
    for _ in range(MOST_STEPS):
        value = mp.matrix(function(x))
        columns = []
        for i, size in enumerate(scale):
            shifted = list(x)
            shifted[i] += h * size
            columns.append((mp.matrix(function(shifted)) - value) / h)
        jacobian = mp.matrix([[column[k] for column in columns] for k in range(len(value))])
        try:
            if len(x) == len(value):
                step = mp.lu_solve(jacobian, value)
            else:
                step = jacobian.T * mp.lu_solve(jacobian * jacobian.T, value)
        except ZeroDivisionError as error:
            raise ArithmeticError("the 40-digit reference is degenerate") from error
        x = [a - size * step[i] for i, (a, size) in enumerate(zip(x, scale, strict=True))]
        if mp.norm(step) < mpf(10) ** -SETTLED:
            return x
    raise ArithmeticError("the 40-digit reference did not settle")


def motion(guess: list[Any], d: Any, gbar: Any, r: Any, n: int) -> State:
    """The motion near a guess of (velocity, phase, u) for given d and gbar."""
    velocity, phase, u = newton(lambda x: periodicity((x[0], x[1], x[2]), d, gbar, r, n), guess)
    return velocity, phase, u


def at(phase: Any, u: Any, guess: list[Any], r: Any, n: int) -> tuple[Any, Any, Any]:
    """Velocity, gbar and d of the one motion with this phase and q, from a guess of the three."""
    velocity, gbar, d = newton(lambda x: periodicity((x[0], phase, u), x[2], x[1], r, n), guess, [1, 1, 1])
    return velocity, gbar, d


def flights(state: State, d: Any, gbar: Any, r: Any, n: int) -> Iterator[tuple[Any, Any, Any, Any]]:
    """Start, speed, phase and duration of the flight up and of the flight down."""
    velocity, phase, u = state
    up = 2 * n * (mpf(1) / 2 + u)
    yield d / 2, -r * velocity, phase, up
    yield -d / 2, -r * velocity_top(state, gbar, r, n), phase + mp.pi * up, 2 * n - up


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


def symmetric_motions(d: Any, r: Any, n: int) -> Iterator[State]:
    """Symmetric motions of a horizontal capsule: d = n (1+r) Zd/2 - 2 cos(phi)/pi^2 with `symmetric_velocity`."""
    sine, cosine = n * (1 + r) / (mp.pi * (1 - r)), -2 / mp.pi**2
    ratio = d / mp.hypot(sine, cosine)
    if abs(ratio) <= 1:
        for sign in (1, -1):
            phase = mp.atan2(sine, cosine) + sign * mp.acos(ratio)
            yield symmetric_velocity(phase, r), phase, mpf(0)


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


def voltage(speed: Any, mass: Any, k: Any, h: Any, active: Any, ball: Any, bias: Any) -> tuple[Any, Any]:
    """Deflection (5.5) [m] and U_imp - Uin (5.2)-(5.4) [V] of an impact at `speed` [m/s]."""
    with mp.workdps(VOLTAGE_DIGITS):
        return _voltage(*(mpf(x) for x in (speed, mass, k, h, active, ball, bias)))


def _voltage(speed: Any, mass: Any, k: Any, h: Any, active: Any, ball: Any, bias: Any) -> tuple[Any, Any]:
    delta = ((h + 1) * mass * speed**2 / (2 * k)) ** (1 / (h + 1))
    depth = delta - ball
    cosine = (active * mp.sqrt(active**2 + depth**2 - ball**2) - ball * depth) / (active**2 + depth**2)
    area = mp.pi * ((active**2 - ball**2 * (1 - cosine**2)) / cosine) + 2 * mp.pi * ball**2 * (1 - cosine)
    return delta, bias * ((area / (mp.pi * active**2)) ** 2 - 1)
