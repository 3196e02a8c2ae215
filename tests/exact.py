"""What the tests compare motions with, in 40 digits by the printed equations (`vireport.study.checks.reference`).

A motion of a sweep is a list of four unknowns here: velocity before the bottom impact, phase there, q - 1/2, and the
value of the swept parameter. The functions are to be called within `reference.precise()`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mpmath import mp, mpf
from raw_flights import Flights

from vireport.motions.one_to_one import Motions
from vireport.motions.orbits import Orbits
from vireport.motions.stability import flight_jacobians
from vireport.motions.sweep import Sweep
from vireport.physics.energy import Membrane
from vireport.physics.groups import Groups, map_restitution
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter
from vireport.study.checks import reference

STEP = mpf(10) ** -25
"""Step of the differences that give the direction across a curve of motions."""


def return_determinant(orbit: Orbits, r: float) -> Any:
    """Determinant of DP from the entries of both flights' Jacobians: r^4 for every motion."""
    (a11, a12, a21, a22), (b11, b12, b21, b22) = flight_jacobians(orbit, r)
    return (a11 * a22 - a12 * a21) * (b11 * b22 - b12 * b21)


def unknowns(motions: Motions, row: int) -> list[float]:
    """The motion of a row, as it was computed."""
    return [float(getattr(motions, name)[row]) for name in ("velocity_bottom", "phi_bottom", "u", "sweep_value")]


def residuals(sweep: Sweep, x: Sequence[Any]) -> list[Any]:
    """Of the two maps closed after n periods: zero for a motion."""
    d, gbar = reference.groups(sweep.device, sweep.parameter, x[3])
    state = (x[0], x[1], x[2])
    return reference.periodicity(
        state, d, gbar, map_restitution(sweep.device.restitution, mpf), sweep.device.period_ratio
    )


def _scale(x: Any) -> Any:
    """Size of a velocity or phase; 1 for one that is zero but for rounding."""
    return abs(x) if abs(x) > 1e-12 else 1


def motion_near(sweep: Sweep, x: Sequence[Any], *more: reference.Equations) -> list[Any]:
    """The nearest motion of a sweep, or the one that fulfils further equations."""
    return reference.newton(
        lambda y: [*residuals(sweep, y), *(residual for equations in more for residual in equations(y))],
        list(x),
        [_scale(x[0]), _scale(x[1]), 1, abs(x[3]) or 1],
    )


def all_quantities(sweep: Sweep, x: Sequence[Any], membrane: Membrane) -> dict[str, Any]:
    """The numbers of a motion and of its impacts, by the names of `Motions` and `Voltages`."""
    r, n = mpf(sweep.device.restitution), sweep.device.period_ratio
    d, gbar = reference.groups(sweep.device, sweep.parameter, x[3])
    state = (x[0], x[1], x[2])
    velocity_top, trace = reference.velocity_top(state, gbar, r, n), reference.trace(state, gbar, r, n)
    names = Parameter.AMPLITUDE, Parameter.FREQUENCY
    force, frequency = (mpf(x[3] if name is sweep.parameter else getattr(sweep.device, name)) for name in names)
    unit = force / (2 * mpf(sweep.device.capsule_mass_kg) * frequency)
    impacts = (reference.voltage(unit * abs(velocity), membrane) for velocity in (x[0], velocity_top))
    (deep_bottom, bottom), (deep_top, top) = impacts
    return {
        "velocity_bottom": x[0],
        "phi_bottom": x[1],
        "q": x[2] + mpf(1) / 2,
        "sweep_value": x[3],
        "velocity_top": velocity_top,
        "d": d,
        "gbar": gbar,
        "trace": trace,
        "phi_top": mp.fmod(x[1] + 2 * n * mp.pi * (x[2] + mpf(1) / 2), 2 * mp.pi),
        "determinant": r**4,
        "discriminant": trace**2 - 4 * r**4,
        "wall_gap": reference.wall_gap(state, d, gbar, r, n),
        "bottom_v": bottom,
        "top_v": top,
        "average_v": (bottom + top) / 2,
        "deflection_m": max(deep_bottom, deep_top),
    }


def error_of(value: float, exact: Any, name: str) -> float:
    """How far a number is from the exact one; phases are compared on the circle."""
    away = mpf(float(value)) - exact
    if name.startswith("phi"):
        away = mp.fmod(away + 3 * mp.pi, 2 * mp.pi) - mp.pi
    return float(abs(away))


def _across(sweep: Sweep, x: list[Any]) -> tuple[Any, Any]:
    """The direction across the curve of motions, in q and phase."""
    base = mp.matrix(residuals(sweep, x))
    columns = []
    for i in range(4):
        step = STEP * (abs(x[3]) if i == 3 else 1)
        columns.append((mp.matrix(residuals(sweep, [*x[:i], x[i] + step, *x[i + 1 :]])) - base) / step)
    tangent = [
        (-1) ** i * mp.det(mp.matrix([[columns[k][row] for k in range(4) if k != i] for row in range(3)]))
        for i in range(4)
    ]
    return -tangent[1], tangent[2]


def exact_row(sweep: Sweep, m: Motions, row: int, membrane: Membrane) -> dict[str, Any]:
    """The exact motion next to a row: straight across the curve."""
    given = [mpf(x) for x in unknowns(m, row)]
    near = motion_near(sweep, given)
    normal = _across(sweep, near)

    def aside(x: list[Any]) -> list[Any]:
        return [((x[2] - given[2]) * normal[1] - (x[1] - given[1]) * normal[0]) / mp.norm(mp.matrix(normal))]

    return all_quantities(sweep, motion_near(sweep, near, aside), membrane)


def exact_at(sweep: Sweep, m: Motions, row: int, value: float, membrane: Membrane) -> dict[str, Any]:
    """The exact motion at a value of the swept parameter."""
    start = [mpf(x) for x in unknowns(m, row)[:3]]
    scale = [_scale(start[0]), _scale(start[1]), 1]
    state = reference.newton(lambda x: residuals(sweep, [*x, mpf(value)]), start, scale)
    return all_quantities(sweep, [*state, mpf(value)], membrane)


def printed_maps(word: Word, x: list[Any], d: Any, gbar: Any, r: Any) -> list[Any]:
    """Velocity and position at the end of each flight less those of the next impact, by the raw flight."""
    return Flights(Groups(d, gbar, r)).missed(*x, period=2 * word.periods, walls=word.walls)


def printed_trace(word: Word, x: list[Any], d: Any, gbar: Any, r: Any) -> Any:
    """Trace of the return map in (velocity, phase), each flight's derivatives by differences of the printed flight."""
    count, step, product = len(word), mpf(10) ** -60, mp.eye(2)
    for i, wall in enumerate(word.walls):
        j = (i + 1) % count
        duration = x[count + j] - x[count + i] + (0 if j else 2 * word.periods)
        at = [duration, -r * x[i], mp.pi * x[count + i]]

        def fly(t, after, phase, wall=wall):
            return mp.matrix(reference.flight(t, wall * d / 2, after, phase, gbar))

        by_time, by_speed, by_phase = (
            (fly(*[v + step * (k == n) for k, v in enumerate(at)]) - fly(*at)) / step for n in range(3)
        )
        columns = []
        for direction, turned in ((-r * by_speed, 0), (by_phase, 1)):
            later = -direction[0] / by_time[0]
            columns.append([direction[1] + by_time[1] * later, turned + mp.pi * later])
        product = mp.matrix(columns).T * product
    return product[0, 0] + product[1, 1]
