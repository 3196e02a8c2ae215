"""What the extreme cases are made of: the device they are built around, and the judge in 40-digit arithmetic."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from vireport.analysis import (
    Change,
    CriticalKind,
    CriticalPoint,
    Family,
    Motions,
)
from vireport.physics import Device, Membrane
from vireport.scenario import (
    Loaded,
    Parameter,
    loads,
)
from vireport.study import (
    Study,
    analyse,
    device_of,
    membrane_of,
)

UNIT = 2.220446049250313e-16
"""Spacing of doubles at 1."""

BOUND = 1e-11
"""Relative error that an answer may have where nothing is degenerate; most stay below 1e-13."""

MATCH = 1e-6
"""Distance in velocity, phase and q up to which a motion is one that the reference found without a guess."""

SHORT = 1e-3
"""Time after an impact [t_c] up to which a touch without restitution is the wall beginning to hold the ball."""

WIDE = (0.02, 3.0)
"""Range of d in which 1:1 motions begin and end."""

ROWS = 5
"""Motions of each branch that are compared, beside those at its critical points."""

SEED = 20190301
"""Of the rows that are compared, the same in every run."""


@dataclass(frozen=True, slots=True)
class Finding:
    """What a case found.

    Attributes
    ----------
    text : str
    error : float or None
        Relative, against 40 digits; None where it is an invariant.
    bound : float or None
        That the error may have.
    right : bool
        Whether everything that is no error, such as a count, is as expected.
    """

    text: str
    error: float | None = None
    bound: float | None = None
    right: bool = True


@dataclass(frozen=True, slots=True)
class Case:
    """One thing taken to its extreme.

    Attributes
    ----------
    name, group : str
    expected : str
        What the right answer is.
    run : callable
        Finds it.
    needs : tuple of str
        Packages without which it is left out.
    refusal : str
        Where a refusal is right: what its reason must name, as a regular expression.
    answers : bool
        Whether an answer is right beside the refusal.
    """

    name: str
    group: str
    expected: str
    run: Callable[[], Finding]
    needs: tuple[str, ...] = ("mpmath",)
    refusal: str = ""
    answers: bool = False


class NotThereError(Exception):
    """The device has no such point: the case does not apply to it."""


@dataclass(frozen=True, slots=True)
class Base:
    """The device that the cases are built around.

    Attributes
    ----------
    device : vireport.model.Device
        With all its parameters given.
    membrane : Membrane
    span : tuple of float
        Sweep of the length, as factors of the device's.
    """

    device: Device
    membrane: Membrane
    span: tuple[float, float]

    def with_device(self, **changes: Any) -> Base:
        """The same with other values of the device."""
        return replace(self, device=replace(self.device, **changes))

    def with_groups(self, d: float | None = None, gbar: float | None = None) -> Base:
        """The same with these groups: the force gives gbar, at 90 degrees where the capsule was horizontal."""
        base, (own_d, own_gbar) = self, self.device.groups(Parameter.LENGTH, self.device.length_m)
        if gbar is not None:
            base = base if own_gbar > 0 else base.with_device(inclination_deg=90.0)
            x = base.device
            weight = x.groups(Parameter.LENGTH, x.length_m)[1] * x.amplitude_n
            base = base.with_device(amplitude_n=float(weight / gbar))
        return base.with_device(length_m=base.length(own_d if d is None else d))

    def length(self, d: float) -> float:
        """The length at which the device has this d [m]."""
        x = self.device
        return float(d * x.amplitude_n / (4 * x.capsule_mass_kg * x.frequency_hz**2))

    def text(self, sweep: tuple[Parameter, float, float] | None = None) -> str:
        """The device as a scenario."""
        x, ball = self.device, self.membrane
        lines = [
            "schema_version: 1",
            f"inclination_deg: {x.inclination_deg!r}",
            f"gravity_m_s2: {x.gravity_m_s2!r}",
            f"period_ratio: {x.period_ratio}",
            f"excitation: {{amplitude_n: {x.amplitude_n!r}, frequency_hz: {x.frequency_hz!r}}}",
            "device:",
            f"  capsule_mass_kg: {x.capsule_mass_kg!r}",
            f"  ball_mass_kg: {ball.ball_mass_kg!r}",
            f"  restitution: {x.restitution!r}",
            f"  length_m: {x.length_m!r}",
            "  membrane:",
            *(
                f"    {field.name}: {getattr(ball, field.name)!r}"
                for field in fields(Membrane)
                if field.name != "ball_mass_kg"
            ),
        ]
        if sweep is not None:
            lines.append(f"sweep: {{parameter: {sweep[0]}, from: {sweep[1]!r}, to: {sweep[2]!r}}}")
        return "\n".join(lines) + "\n"

    def study(self, sweep: tuple[Parameter, float, float] | None = None, formats: Sequence[str] = ("json",)) -> Study:
        """Everything that a run finds out about the device, and about a sweep."""
        return analyse(loads(self.text(sweep), "extreme case"), formats)

    def over(self, d: tuple[float, float] = WIDE, formats: Sequence[str] = ("json",)) -> Study:
        """The study with the length swept over a range of d."""
        return self.study((Parameter.LENGTH, self.length(d[0]), self.length(d[1])), formats)


PAPER = Base(
    Device(0.1245, 0.5, 9.8, 0.6934, 3.0, 2.0, 45.0),
    Membrane(4.0847e5, 2.6, 6.3e-3, 5.0e-3, 2000.0, 0.0041),
    (0.59 / 0.6934, 0.75 / 0.6934),
)
"""The device of the paper's Fig. 3 (c)-(d), and the sweep of its Fig. 2 (d)-(f)."""


def base_of(loaded: Loaded | None) -> Base:
    """The device of a scenario, in the middle of its sweep where it gives no design point; the paper's for None."""
    if loaded is None:
        return PAPER
    scenario, device = loaded.scenario, device_of(loaded.scenario)
    span = PAPER.span
    if scenario.sweep is not None:
        name, ends = scenario.sweep.parameter, (scenario.sweep.from_, scenario.sweep.to)
        if getattr(device, name) is None:
            middle: dict[str, Any] = {name: sum(ends) / 2}
            device = replace(device, **middle)
        if name == Parameter.LENGTH.value:
            span = ends[0] / device.length_m, ends[1] / device.length_m
    membrane = membrane_of(scenario)
    if membrane is None:
        mass = PAPER.membrane.ball_mass_kg / PAPER.device.capsule_mass_kg * device.capsule_mass_kg
        membrane = replace(PAPER.membrane, ball_mass_kg=float(mass))
    return Base(device, membrane, span)


def require_finite(value: Any, name: str = "result") -> None:
    """Look for NaN and inf in everything that a result holds; FloatingPointError names the place."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        if not np.isfinite(value).all():
            raise FloatingPointError(f"{name} holds a number that is not finite")
    elif isinstance(value, float):
        if not np.isfinite(value):
            raise FloatingPointError(f"{name} is {value}")
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            require_finite(getattr(value, field.name), f"{name}.{field.name}")
    elif isinstance(value, tuple | list):
        for one in value:
            require_finite(one, name)


def examine(study: Study, bound: float = BOUND, degenerate: bool = False) -> Finding:
    """Compare a study with 40-digit arithmetic: the motions of its design point, rows of its branches, critical points.

    Parameters
    ----------
    study : Study
        With a design point.
    bound : float
        Of the errors relative to 1: of velocities, phases, q, swept value, and of the trace to
        (1 + |trace|)(1 + 1/v), for it is divided by the impact velocities v.
    degenerate : bool
        Whether the design point is itself a critical point. Its motions are then compared with the nearest exact ones,
        for those at the same length are far away (a double root) or do not exist.
    """
    problems = []
    parts: list[Any] = [study.solution.design, study.solution.stable_ranges, study.solution.table]
    parts += [part for branch in study.solution.branches for part in (branch.motions, branch.voltages)]
    parts += [study.solution.critical_points]
    require_finite(tuple(part for part in parts if part is not None))
    device = study.solution.device
    error = 0.0
    said = []
    if study.solution.design is not None:
        motions = study.solution.design.motions
        error = max([0.0, *errors(motions, range(len(motions)), device, study.solution.design.parameter, degenerate)])
        said.append(count(len(motions), "motion"))
        if not degenerate:
            problems += _incomplete(study)
        if not motions.stable.any() and "VR003" not in {alert.code for alert in study.alerts}:
            problems.append("no alert says that there is no stable motion")
    if study.solution.sweep is not None:
        rng = np.random.default_rng(SEED)
        for branch in study.solution.branches:
            inner = np.array([i for i in range(1, len(branch.motions) - 1) if not branch.marks[i]], dtype=int)
            rows = rng.permutation(inner)[:ROWS]
            error = max([error, *errors(branch.motions, rows, device, study.solution.sweep.parameter, True)])
        said.append(count(len(study.solution.branches), "branch", "es"))
        if not study.solution.stable_ranges and "VR001" not in {alert.code for alert in study.alerts}:
            problems.append("no alert says that the sweep has no stable motion")
        for point in study.solution.critical_points:
            own, stated = point_error(point, device, study.solution.sweep.parameter)
            error = max(error, own if stated < BOUND else 0.0)
            if own > max(stated, UNIT):
                problems.append(f"{point.label} is off by {own:.1e}, stated {stated:.1e}")
        labels = " ".join(point.label for point in study.solution.critical_points)
        said.append(labels or "no critical point")
    return Finding("; ".join(problems) or ", ".join(said), error, bound, not problems)


def count(number: int, noun: str, plural: str = "s") -> str:
    """Write a number of things."""
    return f"{number or 'no'} {noun}{plural if number != 1 else ''}"


def errors(
    motions: Motions, rows: Sequence[int] | Any, device: Device, parameter: Parameter, near: bool
) -> list[float]:
    """Error of some motions against 40 digits, each the largest over its numbers.

    With `near` the swept value is not held: the reference is the nearest motion of the sweep.
    """
    from vireport import reference as exact
    from vireport.extremes.search import pressing, wall_gap

    found = []
    r, n = exact.mpf(device.restitution), device.period_ratio
    with exact.precise():
        for i in rows:
            given = [float(getattr(motions, name)[i]) for name in ("velocity_bottom", "phi_bottom")]
            given += [float(motions.q[i] - 0.5), float(motions.sweep_value[i])]
            held = exact.mpf(given[3])

            def residual(x: list[Any], held: Any = held) -> list[Any]:
                d, gbar = exact.groups(device, parameter, x[3] if near else held)
                return exact.periodicity((x[0], x[1], x[2]), d, gbar, r, n)

            x = exact.newton(residual, given, [1, 1, 1, held or 1]) if near else exact.newton(residual, given[:3])
            value = x[3] if near else held
            d, gbar = exact.groups(device, parameter, value)
            state = x[0], x[1], x[2]
            trace = exact.trace(state, gbar, r, n)
            slowest = min(abs(x[0]), abs(exact.velocity_top(state, gbar, r, n)))
            pairs = [
                (motions.velocity_bottom[i], x[0], 1 + abs(x[0])),
                (motions.velocity_top[i], exact.velocity_top(state, gbar, r, n), 1 + abs(x[0])),
                (_turned(motions.phi_bottom[i], x[1], exact), x[1], 1),
                (motions.q[i], x[2] + exact.mpf(0.5), 1),
                (motions.d[i], d, d),
                (motions.sweep_value[i], value, abs(value) or 1),
                (motions.trace[i], trace, (1 + abs(trace)) * (1 + 1 / slowest)),
            ]
            press = min(abs(pressing(state, gbar, n, top)) for top in (False, True))
            if r > 0 or press > MATCH:  # without restitution the gap jumps where the wall begins to hold the ball
                pairs.append((motions.wall_gap[i], wall_gap(state, d, gbar, r, n), 1))
            found.append(max(float(abs(exact.mpf(float(a)) - b) / scale) for a, b, scale in pairs))
    return found


def _turned(phase: float, to: Any, exact: Any) -> Any:
    """A phase, whole turns nearer to another."""
    return phase + 2 * exact.mp.pi * exact.mp.nint((to - phase) / (2 * exact.mp.pi))


def _incomplete(study: Study) -> list[str]:
    """Motions of the design point that the reference finds without a guess and the study does not have."""
    from vireport import reference as exact
    from vireport.extremes.search import all_motions, wall_gap

    device = study.solution.device
    assert study.solution.design is not None
    motions, parameter = study.solution.design.motions, study.solution.design.parameter
    r, n = exact.mpf(device.restitution), device.period_ratio
    missing = []
    with exact.precise():
        d, gbar = exact.groups(device, parameter, study.solution.design.value)
        for state in all_motions(d, gbar, r, n):
            velocity, phase, q = float(state[0]), float(state[1]), float(state[2]) + 0.5
            apart = np.abs(motions.velocity_bottom - velocity) + np.abs(motions.q - q)
            apart = apart + np.abs(np.angle(np.exp(1j * (motions.phi_bottom - phase))))
            if np.min(apart, initial=np.inf) > MATCH and wall_gap(state, d, gbar, r, n) > 0:
                missing.append(f"a motion at q = {q:.6g}, velocity {velocity:.6g} was not found")
    return missing


def point_error(point: CriticalPoint, device: Device, parameter: Parameter) -> tuple[float, float]:
    """Relative error of a critical point's swept value against 40 digits, and the bound that is stated of it."""
    value = float(exact_value(point, device, parameter))
    scale = abs(value) or 1.0
    return abs(point.point.sweep_value - value) / scale, point.point.error_bound / scale


def exact_value(point: CriticalPoint, device: Device, parameter: Parameter, gap: float = 0.0) -> Any:
    """The swept value of a critical point, solved from the printed conditions; of a near graze, with its gap."""
    from vireport import reference as exact
    from vireport.extremes.search import pressing, short_touch, turning_points

    n, p, symmetric = device.period_ratio, point.point, point.family is Family.SYMMETRIC
    with exact.precise():
        r = exact.mpf(device.restitution)
        start = (exact.mpf(p.velocity_bottom), exact.mpf(p.phi), exact.mpf(p.u))
        d, gbar = exact.groups(device, parameter, p.sweep_value)

        def solved(condition: Any, x: list[Any]) -> list[Any]:
            return exact.special_motion(device, parameter, condition, x, symmetric)

        x = [*start, exact.mpf(p.sweep_value)]
        if point.kind is not CriticalKind.GRAZING:
            target = 1 + r**4
            if point.kind is CriticalKind.PERIOD_DOUBLING:
                target = -target
            elif point.kind is CriticalKind.NODE_FOCUS:
                target = 2 * r * r if exact.trace(start, gbar, r, n) >= 0 else -2 * r * r
            return solved(lambda state, d, gbar: [exact.trace(state, gbar, r, n) - target], x)[3]
        if point.change.at_rest:
            at_top = point.change is Change.TOP_REST
            return solved(lambda state, d, g: [exact.velocity_top(state, g, r, n) if at_top else state[0]], x)[3]
        turn = min(turning_points(start, d, gbar, r, n), key=lambda one: abs(one[0]), default=None)
        if turn is None or abs(turn[0]) > MATCH or (r == 0 and turn[2] < SHORT):
            # A ball that hardly rebounds touches the wall it is leaving, at about the time at which that ceases to
            # press; without any rebound, exactly then.
            which = int(abs(pressing(start, gbar, n, True)) < abs(pressing(start, gbar, n, False)))
            press, time = short_touch(start, gbar, r, n, which)
            sign = -1 if which else 1
            x = solved(lambda state, d, g: [sign * pressing(state, g, n, bool(which)) - press], x)
            if r == 0:
                return x[3]
        else:
            _, which, time = turn

        def touch(state: Any, d: Any, gbar: Any, time: Any) -> list[Any]:
            left, speed, phase, _ = list(exact.flights(state, d, gbar, r, n))[which]
            z, rate = exact.flight(time, left, speed, phase, gbar)
            return [rate, d / 2 - abs(z) - gap]

        return solved(touch, [*x, time])[3]
