"""Answers of the package compared with 40 digits: the motions of a study, its branches and its critical points."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from msgspec import Struct

from vireport.checks import reference as exact
from vireport.extremes.rows import BOUND, CaseFinding, WrongAnswerError
from vireport.motions.events import Event
from vireport.motions.one_to_one import Motions
from vireport.motions.points import Point
from vireport.physics.device import Device
from vireport.physics.groups import by_wall, map_restitution
from vireport.physics.motion import Symmetry
from vireport.physics.numbers import wrapped
from vireport.scenario.parameters import Parameter
from vireport.study.study import Study
from vireport.text.alerts import AlertCode
from vireport.text.formatting import ROUGHLY, shown

SPACING = 2.220446049250313e-16
"""Spacing of doubles at 1."""

MATCH = 1e-6
"""Distance in velocity, phase and q up to which a motion is one that the reference found without a guess."""

SHORT = 1e-3
"""Time after an impact [t_c] up to which a touch without restitution is the wall beginning to hold the ball."""

ROWS = 5
"""Motions of each branch that are compared, beside those at its critical points."""

SEED = 20190301
"""Seed of the rows that are compared, equal in every run."""


def require_finite(value: Any, name: str = "result") -> None:
    """Look for NaN and inf in everything that a result holds; FloatingPointError names the place."""
    if isinstance(value, float) or (isinstance(value, np.ndarray) and value.dtype.kind == "f"):
        if not np.isfinite(value).all():
            raise FloatingPointError(f"{name} is not finite")
    elif isinstance(value, Struct):
        for field in value.__struct_fields__:
            require_finite(getattr(value, field), f"{name}.{field}")
    elif isinstance(value, tuple | list):
        for part in value:
            require_finite(part, name)


def examine(study: Study, bound: float = BOUND, degenerate: bool = False) -> CaseFinding:
    """Compare a study with 40 digits: the motions of its design point, rows of its branches, critical points.

    Parameters
    ----------
    study : Study
    bound : float
        Of the errors relative to 1: of velocities, phases, q, swept value, and of the trace to
        (1 + |trace|)(1 + 1/v), for it is divided by the impact velocities v.
    degenerate : bool
        Whether the design point is itself a critical point. Its motions are then compared with the nearest exact ones,
        for those at the same length are far away (a double root) or do not exist.
    """
    solution, design, codes = study.solution, study.solution.design, {alert.code for alert in study.alerts}
    parts: list[Any] = [design, solution.stable_ranges, solution.table, solution.critical_points]
    parts += [part for branch in solution.branches for part in (branch.motions, branch.voltages_by_motion)]
    require_finite([part for part in parts if part is not None])
    errors, texts = [0.0], []
    if design is not None:
        motions = design.motions
        errors += motion_errors(motions, range(len(motions)), solution.device, design.parameter, degenerate)
        if not degenerate:
            _require_all_motions(study)
        if not motions.stable_mask.any() and AlertCode.DESIGN_NOT_STABLE not in codes:
            raise WrongAnswerError("no alert says that there is no stable motion")
        texts.append(f"motions: {len(motions)}")
    if solution.sweep is not None:
        rng = np.random.default_rng(SEED)
        for branch in solution.branches:
            marked = {mark.row for mark in branch.family.marks}
            inner = np.array([i for i in range(1, len(branch.motions) - 1) if i not in marked], dtype=int)
            rows = rng.permutation(inner)[:ROWS]
            errors += motion_errors(branch.motions, rows, solution.device, solution.sweep.parameter, near=True)
        if not solution.stable_ranges and AlertCode.NO_STABLE_MOTION not in codes:
            raise WrongAnswerError("no alert says that the sweep has no stable motion")
        errors.append(point_errors(solution.critical_points, solution.device, solution.sweep.parameter))
        labels = " ".join(point.label for point in solution.critical_points) or "none"
        texts.append(f"branches: {len(solution.branches)}, critical points: {labels}")
    return CaseFinding(", ".join(texts), max(errors), bound)


def motion_errors(
    motions: Motions, rows: Iterable[int], device: Device, parameter: Parameter, near: bool = False
) -> list[float]:
    """Error of some motions against 40 digits, each the largest over its numbers.

    With `near` the swept value is not held: the reference is the nearest motion of the sweep.
    """
    errors = []
    r, n = map_restitution(device.restitution, exact.mpf), device.period_ratio
    with exact.precise():
        for i in rows:
            start = [float(getattr(motions, name)[i]) for name in ("velocity_bottom", "phi_bottom")]
            start.append(float(motions.q[i] - 0.5))
            held = exact.mpf(float(motions.sweep_value[i]))

            def residual(x: list[Any], held: Any = held) -> list[Any]:
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


def _require_all_motions(study: Study) -> None:
    """Look for motions of the design point that the reference finds without a guess and the study does not have."""
    device, design = study.solution.device, study.solution.design
    assert design is not None
    r, n, m = map_restitution(device.restitution, exact.mpf), device.period_ratio, design.motions
    with exact.precise():
        d, gbar = exact.groups(device, design.parameter, design.value)
        for state in exact.all_motions(d, gbar, r, n):
            velocity, phase, u = map(float, state)
            apart = np.abs(m.velocity_bottom - velocity) + np.abs(m.q - 0.5 - u) + np.abs(wrapped(m.phi_bottom - phase))
            if np.min(apart, initial=np.inf) > MATCH and exact.wall_gap(state, d, gbar, r, n) > 0:
                raise WrongAnswerError(f"a motion at q = {shown(u + 0.5)}, velocity {shown(velocity)} was not found")


def point_errors(points: Iterable[Point], device: Device, parameter: Parameter) -> float:
    """Largest relative error of the swept values of critical points, of which none may be beyond what is stated."""
    errors = [0.0]
    for point in points:
        value = float(critical_motion(point, device, parameter)[3])
        error, stated = (x / (abs(value) or 1.0) for x in (abs(point.sweep_value - value), point.error_bound))
        if error > max(stated, SPACING):
            raise WrongAnswerError(f"{point.label} is off by {shown(error, ROUGHLY)}, stated {shown(stated, ROUGHLY)}")
        errors.append(error if stated < BOUND else 0.0)
    return max(errors)


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
            # A ball that hardly rebounds touches the wall it is leaving, at about the time at which that ceases to
            # press; without any rebound, exactly then.
            which = int(abs(exact.pressing(start, gbar, n, True)) < abs(exact.pressing(start, gbar, n, False)))
            press, time = exact.short_touch(start, gbar, r, n, which)
            sign = -1 if which else 1
            x = solved(lambda state, d, g: [sign * exact.pressing(state, g, n, bool(which)) - press], x)
            if by_wall(r)[which] == 0:
                return x

        def touch(state: Any, d: Any, gbar: Any, time: Any) -> list[Any]:
            left, speed, phase, _ = list(exact.flights(state, d, gbar, r, n))[which]
            z, rate = exact.flight(time, left, speed, phase, gbar)
            return [rate, d / 2 - abs(z) - gap]

        return solved(touch, [*x, time])
