"""Grazing points: where a turning point of the ball comes to touch a membrane, and a branch of motions ends."""

from __future__ import annotations

import math
from typing import Any

from vireport.analysis.admissibility import turning_points
from vireport.analysis.critical import Condition, Point, polish
from vireport.analysis.orbits import Orbits
from vireport.analysis.sweep import Sweep
from vireport.physics import flight

SHORT = 1e-3
"""Time since the impact, below which a touch is a ball that comes back before it has left. It is found from its
expansion, for in doubles the distance covered is lost against the length of the capsule."""


def polish_grazing(sweep: Sweep, orbit: Orbits, symmetric: bool) -> Point:
    """Polish a grazing point.

    Parameters
    ----------
    sweep : Sweep
    orbit : Orbits
        The motion as far as it is known (arrays of length one).
    symmetric : bool
        As in `critical.polish`.

    Raises
    ------
    NumericalError
        If it does not settle.
    """
    r, n = sweep.device.restitution, sweep.device.period_ratio
    u, phi = float(orbit.u[0]), float(orbit.phi[0])
    nearest = _nearest_turn(orbit, r, n)
    if nearest is None or (nearest[1] < SHORT and nearest[3]):
        upward = nearest[2] if nearest else bool(abs(_pressing(orbit, True)[0]) < abs(_pressing(orbit, False)[0]))
        return _polish_short(sweep, u, phi, orbit, upward, symmetric)
    _, time, upward, at_start = nearest
    return polish(sweep, u, phi, touch(upward, at_start), (time,), symmetric)


def _nearest_turn(orbit: Orbits, r: float, n: int) -> tuple[float, float, bool, bool] | None:
    """The turning point nearest to a wall: distance, time in its flight, whether upward, whether at the wall left."""
    found = [
        (abs(float(gap[0])), float(turn.time[0]), turn.upward, at_start)
        for turn in turning_points(orbit, r, n)
        for at_start, gap in ((True, turn.from_start_wall), (False, turn.from_end_wall))
    ]
    return min(found) if found else None


def _pressing(orbit: Orbits, upward: bool) -> Any:
    """Acceleration at the start of a flight, towards the wall that it leaves."""
    return orbit.gbar + orbit.cos_phi if upward else -(orbit.gbar + orbit.cos_top)


def _polish_short(sweep: Sweep, u: float, phi: float, orbit: Orbits, upward: bool, symmetric: bool) -> Point:
    """Polish a touch shortly after the impact.

    v t = a t^2/2 + j t^3/6 and v = a t + j t^2/2 give a = (-8 j v/3)^(1/2) and t = -3 a/(2 j).

    For r = 0 the ball starts at rest, and the touch is where the membrane begins to hold it: a = 0.
    """
    rate = -math.pi * float(orbit.sin_phi[0]) if upward else math.pi * float(orbit.sin_top[0])
    speed = abs(float(orbit.velocity_bottom[0] if upward else orbit.velocity_top[0]))
    pressing = math.sqrt(max(-8 * rate * sweep.device.restitution * speed / 3, 0.0))

    def pressed(orbit: Orbits, more: Any, r: Any, ops: Any) -> list[Any]:
        return [_pressing(orbit, upward) - type(r)(pressing)]

    point = polish(sweep, u, phi, pressed, (), symmetric)
    if pressing == 0:
        return point
    return polish(sweep, point.u, point.phi, touch(upward, True), (-1.5 * pressing / rate,), symmetric)


def touch(upward: bool, at_start: bool) -> Condition:
    """At rest, and on the wall left or on the one to arrive at, a time `more[0]` after the flight began."""

    def condition(orbit: Orbits, more: Any, r: Any, ops: Any) -> list[Any]:
        t = more[0]
        if upward:
            before, sine, cosine, sign = orbit.velocity_bottom, orbit.sin_phi, orbit.cos_phi, -1
        else:
            before, sine, cosine, sign = orbit.velocity_top, orbit.sin_top, orbit.cos_top, 1
        sin_t, cos_t = ops.sin(ops.pi * t), ops.cos(ops.pi * t)
        later_sine, later_cosine = sine * cos_t + cosine * sin_t, cosine * cos_t - sine * sin_t
        after = flight.reflect(before, r)
        covered = sign * flight.displacement(t, after, sine, cosine, later_cosine, orbit.gbar, pi=ops.pi)
        return [
            flight.velocity(t, after, sine, later_sine, orbit.gbar, pi=ops.pi),
            covered / t if at_start else covered - orbit.d,
        ]

    return condition
