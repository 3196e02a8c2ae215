"""The extreme cases of the periodic motions: restitution, inclination, gravity, length, units, q, sweeps, voltage."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from math import inf
from typing import Any

import numpy as np
from msgspec.structs import replace

from vireport.checks import reference as exact
from vireport.extremes.harvester import Harvester, SweepRange
from vireport.extremes.judge import (
    BOUND,
    ROWS,
    SEED,
    SPACING,
    Case,
    CaseFinding,
    NotThereError,
    count,
    examine,
    motion_errors,
    require_finite,
)
from vireport.motions import (
    Motions,
    Orbits,
    motions_of,
    orbits,
    sample,
)
from vireport.physics import (
    NO_GRAVITY,
    Device,
    Restitutions,
    Voltages,
    by_wall,
    each,
    impact_speed,
    voltages,
)
from vireport.scenario import DRIVING, Parameter
from vireport.study import Study
from vireport.text import AlertCode

NEARLY_LOSSLESS = 1e-8
"""Bound at r = 1 - 1e-6, where rounding is magnified by 1/(1-r)."""

ONE_ULP = 1.1102230246251565e-16
"""Spacing of doubles below 1."""

MANY = 1_000_000

LOSSY = 0.5
"""Restitution of one membrane where that of the other is the extreme."""

NEARLY_ALIKE = 2e-9
"""Difference of two restitutions that is hardly enough for a scenario to take them as different."""

BOUNCY = 0.8
"""Restitution at which there are motions for gbar around 1."""

BEYOND = (1e4, 1e5)
"""Range of d without any motion."""

NO_LIFT = 1e-300
"""Deflection and voltage below which any of them counts as zero [m], [V]."""

RAISED = 4 / 3
"""Factor on the value of a parameter, so that taking the device's own in its place is noticed."""

MOTIONS = "all motions, branches and critical points, as in 40 digits"


def motion_cases(harvester: Harvester) -> Iterator[Case]:
    """Every case that needs no simulation."""
    for cases in (_restitution, _inclination, _gravity, _length, _units, _shares, _sweeps, _membrane):
        yield from cases(harvester)


def _motions(
    group: str,
    name: str,
    answer: Callable[[], Study],
    expected: str = MOTIONS,
    bound: float = BOUND,
    refusal: str = "",
    answers: bool = False,
) -> Case:
    """A study that must be as in 40 digits, or be refused."""
    return Case(group, name, expected, answer, partial(examine, bound=bound), refusal=refusal, answers=answers)


def _restitution(harvester: Harvester) -> Iterator[Case]:
    group = "restitution"

    def over(r: float | Restitutions) -> Callable[[], Study]:
        return harvester.with_device(restitution=r).over

    for name, r in (("0", 0.0), ("1e-12", 1e-12)):
        yield _motions(group, f"r = {name}", over(r))
    yield _motions(group, "r = 1 - 1e-6", over(1 - 1e-6), bound=NEARLY_LOSSLESS)
    for name, r in (("1 - 1e-12", 1 - 1e-12), ("1", 1.0)):
        yield _motions(group, f"r = {name}", over(r), "refused: motions come in continua", refusal="restitution")
    other = LOSSY
    for name, of_each in (
        ("0 at the bottom alone", (0.0, other)),
        ("0 at the top alone", (other, 0.0)),
        ("1 - 1e-6 at the bottom alone", (1 - 1e-6, other)),
        ("1 - 1e-6 at the top alone", (other, 1 - 1e-6)),
        ("0 at the bottom, 1 - 1e-6 at the top", (0.0, 1 - 1e-6)),
        ("2e-9 apart", (other + NEARLY_ALIKE, other)),
    ):
        yield _motions(group, f"r = {name}", over(Restitutions(*of_each)))
    level = harvester.with_device(inclination_deg=0.0, restitution=Restitutions(other + NEARLY_ALIKE, other))
    yield _motions(group, "r = 2e-9 apart, horizontal", level.over)


def _inclination(harvester: Harvester) -> Iterator[Case]:
    for beta in (0.0, 1e-9, 0.01, 89.999999, 90.0):
        yield _motions("inclination", f"beta = {beta:.12g} deg", harvester.with_device(inclination_deg=beta).over)


def _gravity(harvester: Harvester) -> Iterator[Case]:
    group = "gravity over forcing"
    bouncy = harvester
    if min(by_wall(harvester.device.restitution)) < BOUNCY:
        bouncy = harvester.with_device(restitution=BOUNCY)
    for name, gbar in (
        ("1 - 1e-12", 1 - 1e-12),
        ("1 - 1.1e-16", 1 - ONE_ULP),
        ("1", 1.0),
        ("1 + 2.2e-16", 1 + SPACING),
        ("1 + 1e-12", 1 + 1e-12),
    ):
        yield _motions(group, f"gbar = {name}", _with_exact_gravity(harvester, gbar).over)
        if bouncy != harvester:
            yield _motions(group, f"gbar = {name}, r = {BOUNCY}", _with_exact_gravity(bouncy, gbar).over)
    for gbar in (1e-14, 1e-9, 100.0):
        yield _motions(group, f"gbar = {gbar:g}", harvester.with_groups(gbar=gbar).over)
    # So slight a tilt that gravity is below `NO_GRAVITY`.
    upright = harvester.with_device(inclination_deg=90.0).groups[1]
    tilted = harvester.with_device(inclination_deg=float(np.degrees(5e-16 / upright)))
    expected = "refused: gravity is lost in rounding"
    yield _motions(group, "gbar = 5e-16", tilted.over, expected, bound=10 * NO_GRAVITY, refusal="gbar")


def _with_exact_gravity(harvester: Harvester, gbar: float) -> Harvester:
    """The harvester whose gbar is this double exactly, or the nearest there is."""
    start = harvester.with_groups(gbar=gbar)
    force = start.device.amplitude_n
    nearby = (start.with_device(amplitude_n=float(force + steps * np.spacing(force))) for steps in range(-8, 9))
    return min(nearby, key=lambda changed: abs(changed.groups[1] - gbar))


def _length(harvester: Harvester) -> Iterator[Case]:
    for d in (1e-9, 1e-6, 1e-3, 1e-1, 1.0, 10.0, 1e3):
        expected = "all motions, as in 40 digits" if d < 10 else "no motion, and an alert that says so"
        yield _motions("length", f"d = {d:g}", harvester.with_groups(d=d).study, expected)


SCALINGS: tuple[tuple[str, dict[str, int]], ...] = (
    ("frequency", {"frequency_hz": 1, "length_m": -2}),
    ("force", {"amplitude_n": 1, "length_m": 1, "gravity_m_s2": 1}),
    ("capsule mass", {"capsule_mass_kg": 1, "ball_mass_kg": 1, "length_m": -1, "gravity_m_s2": -1}),
)
"""What holds the groups: powers with which the numbers of the device go."""


def _units(harvester: Harvester) -> Iterator[Case]:
    """The groups held over twelve decades of each unit."""
    x = harvester.device
    for what, powers in SCALINGS:
        for decades in (-6, -3, 3, 6):
            k = 10.0**decades
            scaled = harvester.with_device(**{name: getattr(x, name) * k**power for name, power in powers.items()})
            name = f"{what} x 1e{decades:+d}, groups held"
            yield _motions("units", name, scaled.over, "the same motions and critical points")
    answer, check = partial(_velocity_units, x), partial(_check_velocity_units, x)
    yield Case("units", "y_c = F/(2 M f)", "the unit of velocity, as in 40 digits", answer, check)


def _velocity_units(device: Device) -> dict[Parameter, float]:
    """The unit of velocity [m/s] with each parameter as the one that is swept, a third above the device's value."""
    return {
        parameter: float(device.velocity_unit(parameter, RAISED * getattr(device, parameter))) for parameter in DRIVING
    }


def _check_velocity_units(device: Device, answer: dict[Parameter, float]) -> CaseFinding:
    errors = [0.0]
    with exact.precise():
        for parameter, unit in answer.items():
            right = exact.velocity_unit(device, parameter, RAISED * getattr(device, parameter))
            errors.append(float(abs(unit - right) / right))
    return CaseFinding(f"{answer[Parameter.LENGTH]:.6g} m/s", max(errors), 10 * SPACING)


def _shares(harvester: Harvester) -> Iterator[Case]:
    r = by_wall(harvester.device.restitution)[0]
    if r > 1 - 1e-6:
        return
    shares = [("q = 1/2", 0.0, "finite, as in 40 digits")]
    if harvester.device.alike:
        shares = [("q = 1/2, horizontal", 0.0, "the symmetric motion: Zd = 2 sin(phi)/(pi (1-r))")]
    if r > 0:
        shares.append(("q = 1/(1+r)", 1 / (1 + r) - 0.5, "a motion, though (3.10) divides by zero there"))
    for name, u in (("q = 0", -0.5), ("q = 1e-12", -0.5 + 1e-12), ("q = 1 - 1e-12", 0.5 - 1e-12), ("q = 1", 0.5)):
        shares.append((name, u, "d = 0: no capsule" if abs(u) == 0.5 else "finite, as in 40 digits"))
    for name, u, expected in shares:
        answer, check = partial(_surface_at, harvester, u), partial(_check_surface, harvester)
        yield Case("share of the period", name, expected, answer, check)


def _surface_at(harvester: Harvester, u: float) -> Orbits:
    """The solutions at a given q and at many phases; gbar is what belongs to it: for q = 1/2 it is zero."""
    phase = np.linspace(0.1, 3.0, 30)
    return orbits(np.full(len(phase), u), phase, harvester.device.restitution, harvester.device.period_ratio)


def _check_surface(harvester: Harvester, solutions: Orbits) -> CaseFinding:
    require_finite(solutions)
    if abs(solutions.u[0]) == 0.5:
        return CaseFinding(f"d = {np.abs(solutions.d).max():.1e}", float(np.abs(solutions.d).max()), 10 * SPACING)
    r, n, errors = each(harvester.device.restitution, exact.mpf), harvester.device.period_ratio, [0.0]
    with exact.precise():
        for row in zip(solutions.u, solutions.phi, solutions.velocity_bottom, solutions.gbar, solutions.d, strict=True):
            u, phi, *given = map(float, row)
            solved = exact.at(exact.mpf(phi), exact.mpf(u), given, r, n)
            scale = 1 + abs(solved[0])
            errors += [float(abs(a - b) / scale) for a, b in zip(given, solved, strict=True)]
    real = (solutions.velocity_bottom > 0) & (solutions.velocity_top < 0) & (solutions.d > 0)
    text = f"{count(len(solutions.phi), 'solution')}, {count(int(real.sum()), 'motion')}"
    return CaseFinding(text, max(errors), BOUND)


def _sweeps(harvester: Harvester) -> Iterator[Case]:
    group, s = "sweep", float(harvester.device.length_m)

    def swept(name: str, sweep: SweepRange, *more: Any, **rest: Any) -> Case:
        return _motions(group, name, partial(harvester.study, sweep), *more, **rest)

    invalid: dict[str, Any] = {"expected": "refused as an invalid scenario", "refusal": "sweep.to"}
    yield swept("of no width", (Parameter.LENGTH, s, s), **invalid)
    yield swept("one spacing of doubles wide", (Parameter.LENGTH, s, float(np.nextafter(s, inf))), **invalid)
    narrow = (Parameter.LENGTH, s, s * (1 + 2e-9))
    yield swept("relative width 2e-9", narrow, "the motions there, as in 40 digits")
    yield swept("reversed", (Parameter.LENGTH, harvester.span[1] * s, harvester.span[0] * s))
    expected, check = f"{ROWS * 8} of them as in 40 digits", partial(_check_million, harvester.device)
    yield Case(group, f"{MANY:,} points", expected, partial(_million, harvester), check)
    for parameter in (Parameter.LENGTH, Parameter.AMPLITUDE, Parameter.FREQUENCY):
        yield swept(f"{parameter} from 1e-15 to 1e+15", (parameter, 1e-15, 1e15))
    yield swept(f"{Parameter.INCLINATION} from 0 to 90", (Parameter.INCLINATION, 0.0, 90.0))
    one_double: dict[str, Any] = {"refusal": "sweep|inclination", "answers": True}
    for name, low, high in (("at 90 deg, 1e-7 deg wide", 90 - 1e-7, 90.0), ("at 0 deg, 1e-16 deg wide", 0.0, 1e-16)):
        expected = "gbar is one double at both ends: answered or refused"
        yield swept(name, (Parameter.INCLINATION, low, high), expected, **one_double)
    expected = "no branch, and an alert that says so"
    yield Case(group, "beyond every motion", expected, partial(harvester.over, BEYOND), _check_empty)


def _million(harvester: Harvester) -> Motions:
    """A million motions of the longest branch at once."""
    diagram = harvester.over().solution.diagram
    assert diagram is not None
    if not diagram.branches:
        raise NotThereError("the device has no branch of motions")
    curve = diagram.curve
    samples = sample(curve)
    longest = max(range(len(curve.strands)), key=lambda k: int(np.sum((samples.which == k) & (samples.validity > 0))))
    w = samples.w[(samples.which == longest) & (samples.validity > 0)]
    orbit = curve.at(np.full(MANY, longest), np.linspace(w.min(), w.max(), MANY))
    return motions_of(curve.sweep, curve.level, orbit)


def _check_million(device: Device, motions: Motions) -> CaseFinding:
    """Some of them compared, chosen at random."""
    real = np.flatnonzero((motions.velocity_bottom > 0) & (motions.velocity_top < 0))
    rows = np.random.default_rng(SEED).choice(real, ROWS * 8, replace=False)
    text = f"{len(motions):,} motions, {int(motions.admissible_mask[real].sum()):,} admissible"
    return CaseFinding(text, max(motion_errors(motions, rows, device, Parameter.LENGTH, near=True)), BOUND)


def _check_empty(study: Study) -> CaseFinding:
    judged = examine(study)
    return replace(judged, right=judged.right and not study.solution.branches)


def _membrane(harvester: Harvester) -> Iterator[Case]:
    group, m = "membrane", harvester.membrane
    depths = {
        "0": 0.0,
        "1e-9 of rb": 1e-9 * m.ball_radius_m,
        "rb": m.ball_radius_m,
        "2 rb": 2 * m.ball_radius_m,
        "Rc": m.active_radius_m,
        "100 Rc": 100 * m.active_radius_m,
    }
    speeds = {f"deflection {name}": float(impact_speed(x, m)) for name, x in depths.items()}
    for name, speed in (speeds | {"impact at 1e-300 m/s": 1e-300}).items():
        at = np.array([speed])
        answer, check = partial(voltages, at, -at, m), partial(_check_volts, harvester, speed)
        yield Case(group, name, "the voltage of (5.2)-(5.5), as in 40 digits", answer, check)
    check = partial(_check_too_deep, harvester)
    yield Case(group, "a run with deflections over Rc", "an alert with depth and area", harvester.over, check)


def _check_volts(harvester: Harvester, speed: float, answer: Voltages) -> CaseFinding:
    require_finite(answer)
    pairs = zip((answer.deflection_m[0], answer.average_v[0]), exact.voltage(speed, harvester.membrane), strict=True)
    errors = [0.0 if b < NO_LIFT and a < NO_LIFT else float(abs(a - b) / abs(b)) for a, b in pairs]
    return CaseFinding(f"{answer.deflection_m[0]:.4g} m, {answer.average_v[0]:.4g} V", max(errors), BOUND)


def _check_too_deep(harvester: Harvester, study: Study) -> CaseFinding:
    """The deepest stable impact of a run, and the alert where that is deeper than the membrane is wide."""
    deepest = 0.0 if study.solution.stretch is None else study.solution.stretch.depth_m
    alert = next((alert for alert in study.alerts if alert.code is AlertCode.DEEP_DEFLECTION), None)
    text = alert.cause.split(". ")[0] if alert else f"no alert at {deepest:.3g} m"
    return CaseFinding(text, right=(alert is not None) == (deepest > harvester.membrane.active_radius_m))
