"""Motions and critical points of the package, against those that 40 digits give by the printed equations."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from vireport.motions.events import Event
from vireport.motions.one_to_one import Motions
from vireport.motions.points import Point
from vireport.physics.device import Device
from vireport.physics.groups import by_wall, map_restitution
from vireport.physics.motion import Symmetry
from vireport.physics.numbers import Arithmetic
from vireport.scenario.parameters import Parameter
from vireport.study.checks import reference as exact

MATCH = 1e-6
"""Distance in velocity, phase and q up to which a motion is one that the reference found without a guess."""

SHORT = 1e-3
"""Time after an impact [t_c] up to which a touch without restitution is the wall beginning to hold the ball."""


def motion_errors(
    motions: Motions, rows: Iterable[int], device: Device, parameter: Parameter, near: bool = False
) -> list[float]:
    """Errors of some motions against 40 digits: for each motion the largest error of its numbers.

    With `near` the swept value is not held: the reference is the nearest motion of the sweep.
    """
    errors = []
    r, n = map_restitution(device.restitution, exact.mpf), device.period_ratio
    with exact.precise():
        for i in rows:
            start = [float(getattr(motions, name)[i]) for name in ("velocity_bottom", "phi_bottom")]
            start.append(float(motions.q[i] - 0.5))
            held = exact.mpf(float(motions.sweep_value[i]))

            def residual(x: list[Any], held: Arithmetic = held) -> list[Any]:
                d, gbar = exact.groups(device, parameter, x[3] if near else held)
                return exact.periodicity((x[0], x[1], x[2]), d, gbar, r, n)

            x = exact.newton(residual, [*start, held], [1, 1, 1, held or 1]) if near else exact.newton(residual, start)
            value, state = x[3] if near else held, (x[0], x[1], x[2])
            d, gbar = exact.groups(device, parameter, value)
            trace, top = exact.trace(state, gbar, r, n), exact.velocity_top(state, gbar, r, n)
            turns = exact.mp.nint((x[1] - float(motions.phi_bottom[i])) / (2 * exact.mp.pi))
            pairs = [
                (motions.velocity_bottom[i], x[0], 1 + abs(x[0])),
                (motions.velocity_top[i], top, 1 + abs(x[0])),
                (float(motions.phi_bottom[i]) + 2 * exact.mp.pi * turns, x[1], 1),
                (motions.q[i], x[2] + exact.mpf(0.5), 1),
                (motions.d[i], d, d),
                (motions.sweep_value[i], value, abs(value) or 1),
                (motions.trace[i], trace, (1 + abs(trace)) * (1 + 1 / min(abs(x[0]), abs(top)))),
            ]
            # Without restitution the gap jumps where the wall begins to hold the ball.
            lossy = (at_top for at_top, wall in zip((False, True), by_wall(r), strict=True) if wall == 0)
            if all(abs(exact.pressing(state, gbar, n, at_top)) > MATCH for at_top in lossy):
                pairs.append((motions.wall_gap[i], exact.wall_gap(state, d, gbar, r, n), 1))
            errors.append(max(float(abs(exact.mpf(a) - b) / scale) for a, b, scale in pairs))
    return errors


def critical_motion(point: Point, device: Device, parameter: Parameter, gap: float = 0.0) -> list[Any]:
    """The motion of a critical point, solved from the printed conditions; of a near graze, with its gap.

    Velocity and phase at the bottom, u = q - 1/2 and the swept value; of a touch its time as well.
    """
    n, p = device.period_ratio, point.closed
    symmetric = device.alike and point.symmetry is Symmetry.SYMMETRIC
    with exact.precise():
        r = map_restitution(device.restitution, exact.mpf)
        start = (exact.mpf(p.velocity_bottom), exact.mpf(p.phi_bottom), exact.mpf(p.u))
        x = [*start, exact.mpf(point.sweep_value)]

        def solved(condition: Any, x: list[Any]) -> list[Any]:
            return exact.special_motion(device, parameter, condition, x, symmetric)

        if point.event is not Event.GRAZING:
            return exact.with_trace(device, parameter, point.event, x, symmetric)
        if point.rest is not None:
            at_top = point.rest == 1
            return solved(lambda state, d, g: [exact.velocity_top(state, g, r, n) if at_top else state[0]], x)
        d, gbar = exact.groups(device, parameter, point.sweep_value)
        turns = exact.turning_points(start, d, gbar, r, n)
        distance, which, time = min(turns, key=lambda turn: abs(turn[0]), default=(exact.mpf(1), 0, exact.mpf(0)))
        if abs(distance) > MATCH or (by_wall(r)[which] == 0 and time < SHORT):
            # A ball that hardly rebounds touches the membrane it is leaving at about the time at which the acceleration
            # ceases to press; without any rebound, exactly then.
            which = int(abs(exact.pressing(start, gbar, n, True)) < abs(exact.pressing(start, gbar, n, False)))
            press, time = exact.short_touch(start, gbar, r, n, which)
            sign = -1 if which else 1
            x = solved(lambda state, d, g: [sign * exact.pressing(state, g, n, bool(which)) - press], x)
            if by_wall(r)[which] == 0:
                return x

        def touch(state: Any, d: Any, gbar: Any, time: Arithmetic) -> list[Any]:
            left, speed, phase, _ = list(exact.flights(state, d, gbar, r, n))[which]
            z, rate = exact.flight(time, left, speed, phase, gbar)
            return [rate, d / 2 - abs(z) - gap]

        return solved(touch, [*x, time])
