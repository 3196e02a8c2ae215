"""What an extreme case is, and the one function that judges it.

A case asks the package for an answer and checks it against something from outside: 40-digit arithmetic, a number
known beforehand, or the refusal that is due. Answer and check are apart, so that a fault can be planted between them
and must be seen. An exception other than a refusal, a warning of numpy, a number that is not finite and an error beyond
its bound all make a case fail, with their text in place of what was found.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable, Sequence
from enum import StrEnum
from importlib.util import find_spec
from math import isfinite
from time import perf_counter
from typing import Any

import numpy as np
from msgspec import Struct

from vireport.base import VireportError, install_command
from vireport.checks import reference as exact
from vireport.motions import (
    Event,
    Motions,
    Point,
    Symmetry,
)
from vireport.physics import Device, by_wall, each, wrapped
from vireport.scenario import Parameter
from vireport.study import Study
from vireport.text import AlertCode

SPACING = 2.220446049250313e-16
"""Spacing of doubles at 1."""

BOUND = 1e-11
"""Relative error that an answer may have where nothing is degenerate; most stay below 1e-13."""

MATCH = 1e-6
"""Distance in velocity, phase and q up to which a motion is one that the reference found without a guess."""

SHORT = 1e-3
"""Time after an impact [t_c] up to which a touch without restitution is the wall beginning to hold the ball."""

ROWS = 5
"""Motions of each branch that are compared, beside those at its critical points."""

SEED = 20190301
"""Seed of the rows that are compared, equal in every run."""


class CaseFinding(Struct, frozen=True):
    """What the check of a case found.

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


class Case(Struct, frozen=True):
    """One thing taken to its extreme.

    Attributes
    ----------
    group, name : str
    expected : str
        What the right answer is.
    answer : callable
        () -> what the package says.
    check : callable
        (answer) -> `CaseFinding`.
    needs : str
        Package without which it is left out, or "".
    refusal : str
        Where a refusal is right: what its reason must name, as a regular expression.
    answers : bool
        Whether an answer is right beside the refusal.
    """

    group: str
    name: str
    expected: str
    answer: Callable[[], Any]
    check: Callable[[Any], CaseFinding]
    needs: str = ""
    refusal: str = ""
    answers: bool = False


class NotThereError(Exception):
    """The device has no such point: the case does not apply to it."""


class CaseVerdict(StrEnum):
    """The verdicts on a case: passed, failed, does not apply to the device, or left out."""

    PASSED = "passed"
    FAILED = "failed"
    DOES_NOT_APPLY = "does not apply"
    LEFT_OUT = "left out"


class CaseOutcome(Struct, frozen=True):
    """A case and its verdict.

    Attributes
    ----------
    case : Case
    verdict : CaseVerdict
    found : str
        The answer, the reason of the refusal, why it does not apply or was left out, or what went wrong.
    error : float or None
        Relative, against 40 digits; None where it is a refusal or an invariant.
    bound : float or None
        That the error may have.
    seconds : float
    """

    case: Case
    verdict: CaseVerdict
    found: str
    error: float | None = None
    bound: float | None = None
    seconds: float = 0.0


def judge(case: Case) -> CaseOutcome:
    """Run one case, with every warning an error, and decide whether it passed."""
    if case.needs and find_spec(case.needs) is None:
        return CaseOutcome(case, CaseVerdict.LEFT_OUT, f"needs {case.needs}: {install_command(case.needs)}")
    start = perf_counter()
    finding = CaseFinding("")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            finding = case.check(case.answer())
        text, passed = finding.text, _passed(case, finding)
    except VireportError as refusal:
        text = " ".join(str(refusal).split())
        passed = bool(case.refusal) and re.search(case.refusal, text) is not None
        text = f"refused: {text}"
    except NotThereError as absent:
        return CaseOutcome(case, CaseVerdict.DOES_NOT_APPLY, str(absent), seconds=perf_counter() - start)
    except Exception as fault:
        # Whatever it is, it is the finding: a catalogue that stops at the first fault would not show the next.
        text, passed = f"{type(fault).__name__}: {fault}", False
    # No time decides: it is that of the machine, and of what else it does.
    verdict = CaseVerdict.PASSED if passed else CaseVerdict.FAILED
    return CaseOutcome(case, verdict, text, finding.error, finding.bound, perf_counter() - start)


def _passed(case: Case, finding: CaseFinding) -> bool:
    """Whether an answer is right: one was asked for, nothing else is wrong with it, and its error is in its bound."""
    if case.refusal and not case.answers:
        return False
    if finding.error is None:
        return finding.right
    return finding.right and isfinite(finding.error) and finding.bound is not None and finding.error <= finding.bound


def combined(findings: Iterable[CaseFinding], text: str | None = None, bound: float | None = BOUND) -> CaseFinding:
    """The largest error of several findings; what is not right, or else what is said of each, or the text given."""
    parts = tuple(findings)
    problems = [part.text for part in parts if not part.right]
    errors = [part.error for part in parts if part.error is not None]
    said = ", ".join(part.text for part in parts) if text is None else text
    largest = float(np.max(errors)) if errors else None
    return CaseFinding("; ".join(problems) or said, largest, bound if errors else None, not problems)


def require_finite(value: Any, name: str = "result") -> None:
    """Look for NaN and inf in everything that a result holds; FloatingPointError names the place."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        if not np.isfinite(value).all():
            raise FloatingPointError(f"{name} holds a number that is not finite")
    elif isinstance(value, float):
        if not np.isfinite(value):
            raise FloatingPointError(f"{name} is {value}")
    elif isinstance(value, Struct):
        for field in value.__struct_fields__:
            require_finite(getattr(value, field), f"{name}.{field}")
    elif isinstance(value, tuple | list):
        for part in value:
            require_finite(part, name)


def count(number: int, noun: str, plural: str = "s") -> str:
    """Write a number of things."""
    return f"{number or 'no'} {noun}{plural if number != 1 else ''}"


def examine(study: Study, bound: float = BOUND, degenerate: bool = False) -> CaseFinding:
    """Compare a study with 40-digit arithmetic: the motions of its design point, rows of its branches, critical points.

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
    solution = study.solution
    parts: list[Any] = [solution.design, solution.stable_ranges, solution.table, solution.critical_points]
    parts += [part for branch in solution.branches for part in (branch.motions, branch.voltages_by_motion)]
    require_finite(tuple(part for part in parts if part is not None))
    findings = [_examine_design(study, degenerate)] if solution.design is not None else []
    if solution.sweep is not None:
        findings += [_examine_branches(study), *_examine_points(study)]
    return combined(findings, bound=bound)


def _examine_design(study: Study, degenerate: bool) -> CaseFinding:
    """The motions of the design point: their numbers, that none is missing, and the alert where none is stable."""
    design = study.solution.design
    assert design is not None
    motions = design.motions
    errors = motion_errors(motions, range(len(motions)), study.solution.device, design.parameter, degenerate)
    problems = [] if degenerate else _missing_motions(study)
    if not motions.stable_mask.any() and AlertCode.DESIGN_NOT_STABLE not in {alert.code for alert in study.alerts}:
        problems.append("no alert says that there is no stable motion")
    text = "; ".join(problems) or count(len(motions), "motion")
    return CaseFinding(text, max(errors, default=0.0), BOUND, not problems)


def _examine_branches(study: Study) -> CaseFinding:
    """Some rows of each branch, and the alert where none is stable."""
    solution = study.solution
    assert solution.sweep is not None
    rng, errors = np.random.default_rng(SEED), [0.0]
    for branch in solution.branches:
        marked = {mark.row for mark in branch.family.marks}
        inner = np.array([i for i in range(1, len(branch.motions) - 1) if i not in marked], dtype=int)
        rows = rng.permutation(inner)[:ROWS]
        errors += motion_errors(branch.motions, rows, solution.device, solution.sweep.parameter, near=True)
    if not solution.stable_ranges and AlertCode.NO_STABLE_MOTION not in {alert.code for alert in study.alerts}:
        return CaseFinding("no alert says that the sweep has no stable motion", max(errors), BOUND, right=False)
    return CaseFinding(count(len(solution.branches), "branch", "es"), max(errors), BOUND)


def _examine_points(study: Study) -> list[CaseFinding]:
    """The critical points, each against the bound that is stated of it."""
    solution, errors, problems = study.solution, [0.0], []
    assert solution.sweep is not None
    for point in solution.critical_points:
        error, stated = point_error(point, solution.device, solution.sweep.parameter)
        errors.append(error if stated < BOUND else 0.0)
        if error > max(stated, SPACING):
            problems.append(CaseFinding(f"{point.label} is off by {error:.1e}, stated {stated:.1e}", right=False))
    labels = " ".join(point.label for point in solution.critical_points)
    return [CaseFinding(labels or "no critical point", max(errors), BOUND), *problems]


def motion_errors(
    motions: Motions, rows: Sequence[int] | Any, device: Device, parameter: Parameter, near: bool
) -> list[float]:
    """Error of some motions against 40 digits, each the largest over its numbers.

    With `near` the swept value is not held: the reference is the nearest motion of the sweep.
    """
    errors = []
    r, n = each(device.restitution, exact.mpf), device.period_ratio
    with exact.precise():
        for i in rows:
            given = [float(getattr(motions, name)[i]) for name in ("velocity_bottom", "phi_bottom")]
            given += [float(motions.q[i] - 0.5), float(motions.sweep_value[i])]
            held = exact.mpf(given[3])

            def residual(x: list[Any], held: Any = held) -> list[Any]:
                d, gbar = exact.groups(device, parameter, x[3] if near else held)
                return exact.periodicity((x[0], x[1], x[2]), d, gbar, r, n)

            x = exact.newton(residual, given, [1, 1, 1, held or 1]) if near else exact.newton(residual, given[:3])
            value, state = x[3] if near else held, (x[0], x[1], x[2])
            d, gbar = exact.groups(device, parameter, value)
            trace, top = exact.trace(state, gbar, r, n), exact.velocity_top(state, gbar, r, n)
            pairs = [
                (motions.velocity_bottom[i], x[0], 1 + abs(x[0])),
                (motions.velocity_top[i], top, 1 + abs(x[0])),
                (_turned(motions.phi_bottom[i], x[1]), x[1], 1),
                (motions.q[i], x[2] + exact.mpf(0.5), 1),
                (motions.d[i], d, d),
                (motions.sweep_value[i], value, abs(value) or 1),
                (motions.trace[i], trace, (1 + abs(trace)) * (1 + 1 / min(abs(x[0]), abs(top)))),
            ]
            held = (at_top for at_top, own in zip((False, True), by_wall(r), strict=True) if own == 0)
            # Without restitution the gap jumps where the wall begins to hold the ball.
            if all(abs(exact.pressing(state, gbar, n, at_top)) > MATCH for at_top in held):
                pairs.append((motions.wall_gap[i], exact.wall_gap(state, d, gbar, r, n), 1))
            errors.append(max(float(abs(exact.mpf(float(a)) - b) / scale) for a, b, scale in pairs))
    return errors


def _turned(phase: float, to: Any) -> Any:
    """A phase, whole turns nearer to another."""
    return phase + 2 * exact.mp.pi * exact.mp.nint((to - phase) / (2 * exact.mp.pi))


def _missing_motions(study: Study) -> list[str]:
    """Motions of the design point that the reference finds without a guess and the study does not have."""
    device, design = study.solution.device, study.solution.design
    assert design is not None
    r, n = each(device.restitution, exact.mpf), device.period_ratio
    missing = []
    with exact.precise():
        d, gbar = exact.groups(device, design.parameter, design.value)
        for state in exact.all_motions(d, gbar, r, n):
            if distance_to(design.motions, state) > MATCH and exact.wall_gap(state, d, gbar, r, n) > 0:
                q, velocity = float(state[2]) + 0.5, float(state[0])
                missing.append(f"a motion at q = {q:.6g}, velocity {velocity:.6g} was not found")
    return missing


def distance_to(motions: Motions, state: Sequence[Any]) -> float:
    """Distance of a state (velocity, phase, u) to the nearest of some motions, infinite where there is none."""
    velocity, phase, u = (float(number) for number in state)
    apart = np.abs(motions.velocity_bottom - velocity) + np.abs(motions.q - 0.5 - u)
    apart = apart + np.abs(wrapped(motions.phi_bottom - phase))
    return float(np.min(apart, initial=np.inf))


def point_error(point: Point, device: Device, parameter: Parameter) -> tuple[float, float]:
    """Relative error of a critical point's swept value against 40 digits, and the bound that is stated of it."""
    value = float(exact_value(point, device, parameter))
    scale = abs(value) or 1.0
    return abs(point.sweep_value - value) / scale, point.error_bound / scale


def exact_value(point: Point, device: Device, parameter: Parameter, gap: float = 0.0) -> Any:
    """The swept value of a critical point, solved from the printed conditions; of a near graze, with its gap."""
    n, p = device.period_ratio, point.closed
    symmetric = device.alike and point.symmetry is Symmetry.SYMMETRIC
    with exact.precise():
        r = each(device.restitution, exact.mpf)
        start = (exact.mpf(p.velocity_bottom), exact.mpf(p.phi_bottom), exact.mpf(p.u))
        x = [*start, exact.mpf(point.sweep_value)]

        def solved(condition: Any, x: list[Any]) -> list[Any]:
            return exact.special_motion(device, parameter, condition, x, symmetric)

        if point.event is not Event.GRAZING:
            return exact.with_trace(device, parameter, point.event, x, symmetric)[3]
        if point.rest is not None:
            at_top = point.rest == 1
            return solved(lambda state, d, g: [exact.velocity_top(state, g, r, n) if at_top else state[0]], x)[3]
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
                return x[3]

        def touch(state: Any, d: Any, gbar: Any, time: Any) -> list[Any]:
            left, speed, phase, _ = list(exact.flights(state, d, gbar, r, n))[which]
            z, rate = exact.flight(time, left, speed, phase, gbar)
            return [rate, d / 2 - abs(z) - gap]

        return solved(touch, [*x, time])[3]
