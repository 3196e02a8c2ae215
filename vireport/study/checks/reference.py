"""The model in 40-digit arithmetic, from the printed equations alone: what the package's answers are judged by.

It shares no line with the solution or the simulation: motions are closed by the maps (3.3)-(3.6) and not by the
equations (3.9)-(3.12) that the solution makes of them, traces are by (A.4) and voltages by (5.1)-(5.5) as printed.
Numbers of the package enter as the exact values of their doubles. A state is (velocity before the bottom impact,
phase there, u = q - 1/2). Without a guess, motions and turning points are sampled in doubles and then taken to 40
digits. Imports mpmath: to be imported where it is used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from mpmath import mp as mp  # type: ignore[import-untyped]
from mpmath import mpf as mpf
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import NumericalError
from vireport.physics.device import Device
from vireport.physics.energy import Membrane
from vireport.physics.groups import Restitution, Restitutions, by_wall, map_restitution
from vireport.physics.numbers import Arithmetic, Functions
from vireport.scenario.parameters import Parameter

Floats = NDArray[np.float64]

DIGITS = 60
"""Working precision: 40 digits are left where twenty cancel, as they do for a gbar of 1e-16."""

SETTLED = 40
"""Decades below its scale to which Newton's last step has fallen."""

NOTHING = 1e-25
"""Size of a guess that is zero but for rounding: in it as a unit the equations would look degenerate."""

MOST_STEPS = 40
"""Newton steps, of which six are usual from a guess in doubles; near a double root each gains but a factor of two."""

VOLTAGE_DIGITS = 420
"""Digits of a voltage: at 1e-300 m/s the deflection is 1e-168 m, and the formulae subtract its square from 1."""

SHORTEST = 1e-10
"""Time after an impact from which turning points are looked for; a ball that hardly rebounds turns at once."""

OFF_CENTRE = 1 - 1.7e-9
"""Factor that keeps the samples of q off the round values at which the three equations are dependent."""

State = tuple[Any, Any, Any]
"""Velocity before the bottom impact [y_c], phase there [rad], q - 1/2; of mpf."""

Equations = Callable[[list[Any]], list[Any]]
"""Residuals of some unknowns."""

Residuals = Callable[..., list[Any]]
"""Residuals of a motion that is to be a special one: of its state, d and gbar, and of unknowns beyond them."""


class ReferenceOrbit(Struct, frozen=True):
    """A motion with one impact on each membrane, to 40 digits.

    Attributes
    ----------
    value : mpf
        The swept parameter, in its unit.
    velocity, velocity_top : mpf
        Just before the impacts at the bottom and at the top [y_c].
    phase : mpf
        At the bottom impact [rad], near the guess.
    q : mpf
        Share of the period from bottom to top.
    velocity_unit : mpf
        y_c [m/s].
    """

    value: Any
    velocity: Any
    velocity_top: Any
    phase: Any
    q: Any
    velocity_unit: Any


def precise() -> Any:
    """Context in which the functions below are to be called that take numbers of mpmath; contexts may be nested."""
    return mp.workdps(DIGITS)


def reference_orbit(
    device: Device, parameter: Parameter, guess: Sequence[float], kind: str | None = None
) -> ReferenceOrbit:
    """The motion at a value of a parameter, or the critical point near that value.

    A pitchfork is a double point of the curve of motions; on the symmetric motions (q = 1/2, equal speeds) alone it
    is a simple one, and is solved for there.

    Parameters
    ----------
    device : Device
    parameter : str
        The one that is swept.
    guess : sequence of four floats
        Velocity before the bottom impact [y_c], phase there [rad] and q, to a few digits, and the value of the
        parameter: exact for a motion, a guess for a critical point.
    kind : str, optional
        ``period_doubling``, ``fold`` or ``pitchfork``.

    Raises
    ------
    NumericalError
        If Newton's steps do not settle.
    """
    n = device.period_ratio
    with precise():
        r, (velocity, phase, q, value) = map_restitution(device.restitution, mpf), map(mpf, guess)
        start = [velocity, phase, q - mpf(1) / 2]
        try:
            if kind is None:
                state = motion(start, *groups(device, parameter, value), r, n)
            else:
                *solved, value = with_trace(device, parameter, kind, [*start, value], kind == "pitchfork")
                state = solved[0], solved[1], solved[2]
        except ArithmeticError as error:
            raise NumericalError(str(error)) from error
        top = velocity_top(state, groups(device, parameter, value)[1], r, n)
        unit = velocity_unit(device, parameter, value)
        return ReferenceOrbit(value, state[0], top, state[1], mpf(1) / 2 + state[2], unit)


def reference_voltage(orbit: ReferenceOrbit, membrane: Membrane) -> Any:
    """U_ave of a motion [V], Eq. (5.1).

    Parameters
    ----------
    orbit : ReferenceOrbit
    membrane : Membrane
    """
    with precise():
        speeds = (orbit.velocity_unit * velocity for velocity in (orbit.velocity, orbit.velocity_top))
        return sum(voltage(speed, membrane)[1] for speed in speeds) / 2


def digits(number: Arithmetic, count: int) -> str:
    """A number as text with so many digits."""
    with precise():
        return str(mp.nstr(number, count))


def _at(device: Device, parameter: Parameter, value: Arithmetic) -> dict[str, Any]:
    """The parameters of a device, of which one has a value."""
    names = "length_m", "amplitude_n", "frequency_hz", "inclination_deg"
    return {name: mpf(value if name == parameter else getattr(device, name)) for name in names}


def groups(device: Device, parameter: Parameter, value: Arithmetic) -> tuple[Any, Any]:
    """Return d and gbar of a device whose `parameter` has `value`, Eqs. (2.5) and (2.6)."""
    x, mass = _at(device, parameter, value), mpf(device.capsule_mass_kg)
    force, omega = x[Parameter.AMPLITUDE], 2 * mp.pi * x[Parameter.FREQUENCY]
    supported = mass + mpf(device.ball_mass_kg) if device.recoils else mass
    weight = supported * mpf(device.gravity_m_s2) * mp.sin(x[Parameter.INCLINATION] * mp.pi / 180)
    return x[Parameter.LENGTH] * mass * omega**2 / (force * mp.pi**2), weight / force


def velocity_unit(device: Device, parameter: Parameter, value: Arithmetic) -> Any:
    """y_c of a device whose `parameter` has `value` [m/s], Eq. (2.5)."""
    x = _at(device, parameter, value)
    return x[Parameter.AMPLITUDE] * mp.pi / (mpf(device.capsule_mass_kg) * 2 * mp.pi * x[Parameter.FREQUENCY])


def flight(t: Any, start: Any, speed: Any, phase: Arithmetic, gbar: Any, ops: Functions = mp) -> tuple[Any, Any]:
    """Z and Z' a time t after leaving `start` with `speed`, Eqs. (2.11) and (2.12) with (3.13)."""
    pi = ops.pi
    f1, f1_start = ops.sin(pi * t + phase) / pi, ops.sin(phase) / pi
    f2, f2_start = -ops.cos(pi * t + phase) / pi**2, -ops.cos(phase) / pi**2
    position = start + speed * t + gbar / 2 * t**2 + f2 - f2_start - f1_start * t
    return position, speed + gbar * t + f1 - f1_start


def periodicity(state: State, d: Arithmetic, gbar: Arithmetic, r: Restitution, n: int) -> list[Any]:
    """Residuals of the maps (3.3)-(3.6) closed by (3.1): where and how fast the flight up and the flight down end."""
    velocity, phase, u = state
    up = 2 * n * (mpf(1) / 2 + u)
    at_bottom, at_top = by_wall(r)
    top, speed = flight(up, d / 2, -at_bottom * velocity, phase, gbar)
    bottom, back = flight(2 * n - up, -d / 2, -at_top * speed, phase + mp.pi * up, gbar)
    return [top + d / 2, bottom - d / 2, back - velocity]


def velocity_top(state: State, gbar: Arithmetic, r: Restitution, n: int) -> Any:
    """Velocity before the top impact, Eq. (3.8), by the momentum over a period where the membranes are not alike."""
    bottom, top = by_wall(r)
    return (gbar * 2 * n - (1 + bottom) * state[0]) / (1 + top)


def trace(state: State, gbar: Arithmetic, r: Restitution, n: int, ops: Functions = mp) -> Any:
    """Tr(DP) by Eq. (A.4), each flight with the r of its impact; with numpy for `ops`, of arrays."""
    bottom, top = by_wall(r)
    velocity, phase, u = state
    period = 2 * n
    up = period * (0.5 + u)
    down = period - up
    f0, f1, f2 = ops.cos(phase), ops.cos(phase + ops.pi * up), ops.cos(phase + ops.pi * period)
    s3 = -velocity_top(state, gbar, r, n)
    s1 = up * f0 - bottom * velocity + gbar * up
    s2 = down * f1 + top * s3 + gbar * down
    return (
        (bottom + bottom * up * (gbar + f1) / s3) * (top - top * down * (gbar + f2) / velocity)
        + bottom * up * (gbar + f1 - (gbar + f2) * s2 / velocity) / s3
        - top * down * (gbar + f0 + (gbar + f1) * s1 / s3) / velocity
        - s2 * s1 / (velocity * s3)
    )


def symmetric_velocity(phase: Arithmetic, r: Any) -> Any:
    """Velocity at either impact of a symmetric motion: (3.9) at q = 1/2 and gbar = 0, for odd n."""
    return 2 * mp.sin(phase) / (mp.pi * (1 - r))


def newton(function: Equations, guess: list[Any], scale: list[Any] | None = None) -> list[Any]:
    """Solve function(x) = 0 from a guess; with more unknowns than equations, for the nearest solution.

    Distances are measured in `scale`, the size of each unknown by default.

    Raises
    ------
    ArithmeticError
        If the steps do not settle.
    """
    x = [mpf(value) for value in guess]
    sizes = [mpf(value) for value in scale] if scale else [abs(value) for value in x]
    scale = [size if size > NOTHING else mpf(1) for size in sizes]
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
    raise ArithmeticError("the 40-digit reference did not settle from its guess")


def special_motion(
    device: Device, parameter: Parameter, condition: Residuals, guess: list[Any], symmetric: bool
) -> list[Any]:
    """The motion of a sweep at which a condition holds: state, swept value, and the unknowns beyond them.

    A symmetric one is looked for among the symmetric motions alone, whose velocity and q are known.
    """
    r, n = map_restitution(device.restitution, mpf), device.period_ratio

    def equations(x: list[Any]) -> list[Any]:
        state = (symmetric_velocity(x[1], r), x[1], mpf(0)) if symmetric else (x[0], x[1], x[2])
        d, gbar = groups(device, parameter, x[3])
        closed = periodicity(state, d, gbar, r, n)
        if symmetric:  # two of the equations then say no more than what the velocity and q are
            closed = [x[0] - state[0], x[2], closed[0]]
        return [*closed, *condition(state, d, gbar, *x[4:])]

    return newton(equations, guess)


def with_trace(device: Device, parameter: Parameter, kind: str, guess: list[Any], symmetric: bool) -> list[Any]:
    """The motion of a sweep whose trace is that of a kind of critical point: state and swept value.

    The trace is -(1 + r^4) at a period doubling, 2 r^2 or -2 r^2, whichever is nearer, at a change between node and
    focus, and 1 + r^4 at a fold or pitchfork; with r_b r_t for r^2 where the membranes are not alike.
    """
    r, n = map_restitution(device.restitution, mpf), device.period_ratio
    bottom, top = by_wall(r)
    target = 1 + (bottom * top) ** 2  # written out, not read from the package: this is what its table is checked by
    if kind == "period_doubling":
        target = -target
    elif kind == "node_focus":
        near = trace((guess[0], guess[1], guess[2]), groups(device, parameter, guess[3])[1], r, n)
        target = 2 * bottom * top if near >= 0 else -2 * bottom * top
    return special_motion(device, parameter, lambda x, d, gbar: [trace(x, gbar, r, n) - target], guess, symmetric)


def motion(guess: list[Any], d: Arithmetic, gbar: Arithmetic, r: Restitution, n: int) -> State:
    """The motion near a guess of (velocity, phase, u) for given d and gbar."""
    velocity, phase, u = newton(lambda x: periodicity((x[0], x[1], x[2]), d, gbar, r, n), guess)
    return velocity, phase, u


def at(phase: Arithmetic, u: Arithmetic, guess: list[Any], r: Restitution, n: int) -> tuple[Any, Any, Any]:
    """Velocity, gbar and d of the one motion with this phase and q, from a guess of the three."""
    velocity, gbar, d = newton(lambda x: periodicity((x[0], phase, u), x[2], x[1], r, n), guess, [1, 1, 1])
    return velocity, gbar, d


def flights(
    state: State, d: Arithmetic, gbar: Arithmetic, r: Restitution, n: int
) -> Iterator[tuple[Any, Any, Any, Any]]:
    """Start, speed, phase and duration of the flight up and of the flight down."""
    velocity, phase, u = state
    up = 2 * n * (mpf(1) / 2 + u)
    bottom, top = by_wall(r)
    yield d / 2, -bottom * velocity, phase, up
    yield -d / 2, -top * velocity_top(state, gbar, r, n), phase + mp.pi * up, 2 * n - up


def symmetric_motions(d: Arithmetic, r: Any, n: int) -> Iterator[State]:
    """Symmetric motions of a horizontal capsule: d = n (1+r) Zd/2 - 2 cos(phi)/pi^2 with `symmetric_velocity`."""
    sine, cosine = n * (1 + r) / (mp.pi * (1 - r)), -2 / mp.pi**2
    ratio = d / mp.hypot(sine, cosine)
    if abs(ratio) <= 1:
        for sign in (1, -1):
            phase = mp.atan2(sine, cosine) + sign * mp.acos(ratio)
            yield symmetric_velocity(phase, r), phase, mpf(0)


def voltage(speed: Arithmetic, membrane: Membrane) -> tuple[Any, Any]:
    """Deflection (5.5) [m] and U_imp - Uin (5.2)-(5.4) [V] of an impact at `speed` [m/s], of either sign."""
    with mp.workdps(VOLTAGE_DIGITS):
        h, k, uin = mpf(membrane.exponent), mpf(membrane.stiffness), mpf(membrane.bias_voltage_v)
        rc, rb = mpf(membrane.active_radius_m), mpf(membrane.ball_radius_m)
        ball = mpf(membrane.ball_mass_kg)
        mass = ball / (1 + ball / mpf(membrane.free_capsule_kg))
        delta = ((h + 1) / (2 * k) * mass * mpf(speed) ** 2) ** (1 / (h + 1))
        root = mp.sqrt(rc**2 + delta**2 - 2 * delta * rb)
        cosine = (-2 * rb * (delta - rb) + 2 * rc * root) / (2 * (rc**2 + (delta - rb) ** 2))
        area = 2 * mp.pi * rb**2 * (1 - cosine) + (mp.pi * rc**2 - mp.pi * rb**2 * (1 - cosine**2)) / cosine
        return delta, (area / (mp.pi * rc**2)) ** 2 * uin - uin


def turning_points(state: State, d: Arithmetic, gbar: Arithmetic, r: Restitution, n: int) -> list[tuple[Any, int, Any]]:
    """Zeros of Z' in the flights: gap to the nearer wall, flight, time.

    Z' is monotone between the zeros of Z'' = gbar + cos, so that each interval between those has one zero or none.
    """
    turns = []
    for k, (start, speed, phase, duration) in enumerate(flights(state, d, gbar, r, n)):

        def rate(t: Arithmetic, start: Arithmetic = start, speed: Arithmetic = speed, phase: Arithmetic = phase) -> Any:
            return flight(t, start, speed, phase, gbar)[1]

        for zero in _zeros(rate, _bends(phase, gbar, duration)):
            z = flight(zero, start, speed, phase, gbar)[0]
            turns.append((min(d / 2 - z, d / 2 + z), k, zero))
    return turns


def _bends(phase: Arithmetic, gbar: Any, duration: Arithmetic) -> list[Any]:
    """The ends of a flight, but for its first instant, and the zeros of Z'' between them."""
    times = [mpf(SHORTEST), duration]
    if gbar < 1:
        for side in (1, -1):
            first = (side * mp.acos(-gbar) - phase) / mp.pi
            times += [first + 2 * k for k in range(int(mp.ceil(-first / 2)), int((duration - first) / 2) + 1)]
    return sorted(t for t in times if SHORTEST <= t <= duration)


def _zeros(function: Callable[[Any], Any], ends: Sequence[Any]) -> Iterator[Any]:
    """Zeros where a function changes its sign from one end to the next."""
    values = [function(t) for t in ends]
    for low, high, before, after in zip(ends, ends[1:], values, values[1:], strict=False):
        if (before > 0) != (after > 0):
            yield mp.findroot(function, (low, high), solver="anderson", verify=False)


def pressing(state: State, gbar: Arithmetic, n: int, at_top: bool) -> Any:
    """Acceleration Z'' at an impact, which changes its sign where a wall begins to hold the ball."""
    later = mp.pi * 2 * n * (mpf(1) / 2 + state[2]) if at_top else 0
    return gbar + mp.cos(state[1] + later)


def short_touch(state: State, gbar: Arithmetic, r: Restitution, n: int, which: int) -> tuple[Any, Any]:
    """Pressing acceleration, and time after the impact, at which a ball that hardly rebounds touches the wall again.

    Its distance from the wall, v t - a t^2/2 - j t^3/6, and its velocity vanish where a = (-8 j v/3)^(1/2) and
    t = -3 a/(2 j).
    """
    velocity, phase, u = state
    later = mp.pi * 2 * n * (mpf(1) / 2 + u) if which else 0
    jerk = (1 if which else -1) * mp.pi * mp.sin(phase + later)
    speed = by_wall(r)[1 if which else 0] * abs(velocity_top(state, gbar, r, n) if which else velocity)
    press = mp.sqrt(max(-8 * jerk * speed / 3, 0))
    return press, -3 * press / (2 * jerk)


def wall_gap(state: State, d: Arithmetic, gbar: Arithmetic, r: Restitution, n: int) -> Any:
    """Smallest distance to a membrane at the turning points, d where the ball never turns back."""
    return min([d, *(gap for gap, _, _ in turning_points(state, d, gbar, r, n))])


def all_motions(d: Any, gbar: Any, r: Restitution, n: int) -> list[State]:
    """Every solution of (3.9)-(3.11) for given d and gbar with impacts of the right sign, found without a guess.

    For each q the three equations are linear in the velocity, sin(phi) and cos(phi); q solves the problem where
    sin^2 + cos^2 = 1. That is sampled in doubles, in every decade next to q = 0, 1/2 and 1; the zeros are then taken
    to 40 digits. Two solutions that nearly meet (a fold) may fall between two samples.
    """
    alike = not isinstance(r, Restitutions)
    states = [*symmetric_motions(d, r, n)] if alike and gbar == 0 and n % 2 else []
    for guess in _crossings(float(d), float(gbar), map_restitution(r, float), n):
        try:
            states.append(motion(guess, d, gbar, r, n))
        except ArithmeticError:
            continue  # next to q = 0 or 1 the equations degenerate; what is lost there passes through a membrane
    return [state for state in states if state[0] > 0 > velocity_top(state, gbar, r, n)]


def _crossings(d: float, gbar: float, r: Restitution, n: int) -> Iterator[list[float]]:
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


def _linear(u: Floats, d: float, gbar: float, r: Any, n: int) -> tuple[Floats, Floats]:
    """sin^2 + cos^2 - 1, and (velocity, sin, cos), from (3.9)-(3.11) at each u, in doubles."""
    if not u.size:
        return u, np.empty((0, 3))
    period, pi, ones = 2 * n, np.pi, np.ones_like(u)
    up, down, a = n + period * u, n - period * u, pi * (n + period * u)
    reach = up * down / (2 * period)
    r, top = by_wall(r)
    share = (1 + r) / (1 + top)
    matrix = np.array(
        [
            [(r - share) * ones, -(np.cos(a) - 1) / pi, -np.sin(a) / pi],
            [r * up - down, period / pi * ones, 0 * ones],
            [2 * (1 + r) * reach, -np.sin(a) / pi**2, (np.cos(a) - 1) / pi**2],
        ]
    ).transpose(2, 0, 1)
    right = np.array([-gbar * (period / (1 + top) - up), period / 2 * (up - down) * gbar, d + reach * gbar * period]).T
    solution = np.linalg.solve(matrix, right[..., None])[..., 0]
    return np.sum(solution[:, 1:] ** 2, axis=1) - 1, solution
