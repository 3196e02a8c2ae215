"""The extreme cases of the periodic motions: restitution, inclination, gravity, length, units, q, sweeps, voltage."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import inf

import numpy as np

from vireport.analysis import (
    Held,
    Level,
    coefficients,
    level_terms,
    motions_of,
    orbits,
    sample,
)
from vireport.extremes.checks import (
    BOUND,
    ROWS,
    SEED,
    UNIT,
    Base,
    Case,
    Finding,
    NotThereError,
    count,
    errors,
    examine,
    require_finite,
)
from vireport.physics import (
    NO_GRAVITY,
    Device,
)
from vireport.scenario import Parameter
from vireport.study import FORMATS

NEARLY_LOSSLESS = 1e-8
"""Bound at r = 1 - 1e-6, where rounding is magnified by 1/(1-r)."""

SCALE_BOUND = 1e-12
"""Bound of what may change where only the units do: the groups are rounded anew, and a branch magnifies that."""

ONE_ULP = 1.1102230246251565e-16
"""Spacing of doubles below 1."""

MANY = 1_000_000

MOTIONS = "all motions, branches and critical points, as in 40 digits"


def motion_cases(base: Base) -> Iterator[Case]:
    """Every case that needs no simulation."""
    yield from _restitution(base)
    yield from _inclination(base)
    yield from _gravity(base)
    yield from _length(base)
    yield from _units(base)
    yield from _shares(base)
    yield from _sweeps(base)
    yield from _membrane(base)


def _over(base: Base, bound: float = BOUND) -> Finding:
    return examine(base.over(), bound)


def _restitution(base: Base) -> Iterator[Case]:
    for r, name in ((0.0, "r = 0"), (1e-12, "r = 1e-12")):
        yield Case(name, "restitution", MOTIONS, partial(_over, base.with_device(restitution=r)))
    lossless = base.with_device(restitution=1 - 1e-6)
    yield Case("r = 1 - 1e-6", "restitution", MOTIONS, partial(_over, lossless, NEARLY_LOSSLESS))
    for r, name in ((1 - 1e-12, "r = 1 - 1e-12"), (1.0, "r = 1")):
        refused = partial(_over, base.with_device(restitution=r))
        yield Case(name, "restitution", "refused: motions come in continua", refused, refusal="restitution")


def _inclination(base: Base) -> Iterator[Case]:
    for beta in (0.0, 1e-9, 0.01, 89.999999, 90.0):
        tilted = base.with_device(inclination_deg=beta)
        yield Case(f"beta = {beta:.12g} deg", "inclination", MOTIONS, partial(_over, tilted))


def _with_exact_gravity(base: Base, gbar: float) -> Base:
    """The device whose gbar is this double exactly, or the nearest there is."""
    start = base.with_groups(gbar=gbar)
    best, least = start, inf
    for steps in range(-8, 9):
        force = float(start.device.amplitude_n + steps * np.spacing(start.device.amplitude_n))
        one = start.with_device(amplitude_n=force)
        apart = abs(float(one.device.groups(Parameter.LENGTH, 1.0)[1]) - gbar)
        if apart < least:
            best, least = one, apart
    return best


def _gravity(base: Base) -> Iterator[Case]:
    values = {
        "1 - 1e-12": 1 - 1e-12,
        "1 - 1.1e-16": 1 - ONE_ULP,
        "1": 1.0,
        "1 + 2.2e-16": 1 + UNIT,
        "1 + 1e-12": 1 + 1e-12,
    }
    bouncy = base.with_device(restitution=max(float(base.device.restitution), 0.8))
    for name, gbar in values.items():
        for one in [base] if bouncy == base else [base, bouncy]:
            what = f"gbar = {name}" + ("" if one is base else ", r = 0.8")
            yield Case(what, "gravity over forcing", MOTIONS, partial(_over, _with_exact_gravity(one, gbar)))
    for gbar in (1e-14, 1e-9, 100.0):
        yield Case(f"gbar = {gbar:g}", "gravity over forcing", MOTIONS, partial(_over, base.with_groups(gbar=gbar)))
    lost = partial(_nearly_horizontal, base)
    yield Case("gbar = 5e-16", "gravity over forcing", "refused: gravity is lost in rounding", lost, refusal="gbar")


def _nearly_horizontal(base: Base) -> Finding:
    """So slight a tilt that gravity is below `NO_GRAVITY`."""
    upright = float(base.with_device(inclination_deg=90.0).device.groups(Parameter.LENGTH, 1.0)[1])
    tilted = base.with_device(inclination_deg=float(np.degrees(5e-16 / upright)))
    return examine(tilted.over(), 10 * NO_GRAVITY)


def _length(base: Base) -> Iterator[Case]:
    for d in (1e-9, 1e-6, 1e-3, 1e-1, 1.0, 10.0, 1e3):
        expected = "all motions, as in 40 digits" if d < 10 else "no motion, and an alert that says so"
        yield Case(f"d = {d:g}", "length", expected, partial(_at_length, base, d))


def _at_length(base: Base, d: float) -> Finding:
    return examine(base.with_groups(d=d).study())


def _units(base: Base) -> Iterator[Case]:
    """The groups held: s ~ 1/f^2; s and g ~ F; s, g and F/M by M, over twelve decades each."""
    for what in ("frequency", "force", "capsule mass"):
        for power in (-6, -3, 3, 6):
            expected = "the same motions and critical points"
            name = f"{what} x 1e{power:+d}, groups held"
            yield Case(name, "units", expected, partial(_rescaled, base, what, 10.0**power))


def _rescaled(base: Base, what: str, k: float) -> Finding:
    x = base.device
    if what == "frequency":
        other = base.with_device(frequency_hz=x.frequency_hz * k, length_m=x.length_m / k**2)
    elif what == "force":
        other = base.with_device(
            amplitude_n=x.amplitude_n * k, length_m=x.length_m * k, gravity_m_s2=x.gravity_m_s2 * k
        )
    else:
        heavier = Device(
            x.capsule_mass_kg * k,
            x.restitution,
            x.gravity_m_s2 / k,
            x.length_m / k,
            x.amplitude_n,
            x.frequency_hz,
            x.inclination_deg,
            x.period_ratio,
        )
        other = Base(heavier, replace(base.membrane, ball_mass_kg=base.membrane.ball_mass_kg * k), base.span)
    one, two = base.over(), other.over()
    judged = examine(two)
    first, second = one.solution.critical_points, two.solution.critical_points
    if [point.label for point in first] != [point.label for point in second]:
        return Finding("other critical points than in the units of the scenario", right=False)
    change = max([abs(a.point.d / b.point.d - 1) for a, b in zip(first, second, strict=True)], default=0.0)
    text = f"{judged.text}; d of the critical points changed by {change:.1e}"
    return Finding(text, max(judged.error or 0.0, change), SCALE_BOUND, judged.right)


def _shares(base: Base) -> Iterator[Case]:
    r = float(base.device.restitution)
    if r > 1 - 1e-6:
        return
    expected = "the symmetric motion: Zd = 2 sin(phi)/(pi (1-r))"
    yield Case("q = 1/2, horizontal", "share of the period", expected, partial(_on_surface, base, 0.0, 0.0))
    expected = "a motion, though (3.10) divides by zero there"
    critical = 1 / (1 + r) - 0.5
    if 0 < critical < 0.5:
        yield Case("q = 1/(1+r)", "share of the period", expected, partial(_on_surface, base, critical, None))
    for name, u in (("q = 0", -0.5), ("q = 1e-12", -0.5 + 1e-12), ("q = 1 - 1e-12", 0.5 - 1e-12), ("q = 1", 0.5)):
        expected = "d = 0: no capsule" if abs(u) == 0.5 else "finite, as in 40 digits"
        yield Case(name, "share of the period", expected, partial(_on_surface, base, u, None))


def _on_surface(base: Base, u: float, gbar: float | None) -> Finding:
    """The solutions at a given q, on both sheets, and whether a run over the length finds the ones that are motions."""
    from vireport import reference as exact

    r, n = float(base.device.restitution), base.device.period_ratio
    own = float(base.device.groups(Parameter.LENGTH, base.device.length_m)[1])
    own = own if gbar is None else gbar
    if u == 0.0 or abs(u) > 0.49:
        phase = np.linspace(0.1, 3.0, 30)  # gbar is then what belongs to it: for q = 1/2 it is zero
    else:
        a, b, c = (float(x) for x in level_terms(Level(Held.GBAR, own), coefficients(np.array(u), r, n), u, r, n))
        size = float(np.hypot(a, b))
        if size == 0 or abs(c) > size:
            return Finding("no solution at this q, on either sheet")
        phase = np.arctan2(a, b) + np.array([1.0, -1.0]) * np.arccos(c / size)
    found = orbits(np.full(len(phase), u), phase, r, n)
    require_finite(found)
    if abs(u) == 0.5:
        return Finding(f"d = {np.abs(found.d).max():.1e}", float(np.abs(found.d).max()), 10 * UNIT)
    worst = 0.0
    with exact.precise():
        for i, phi in enumerate(phase):
            start = [float(found.velocity_bottom[i]), float(found.gbar[i]), float(found.d[i])]
            velocity, exact_gbar, d = exact.at(exact.mpf(float(phi)), exact.mpf(u), start, exact.mpf(r), n)
            scale = 1 + abs(velocity)
            for a, b in ((start[0], velocity), (start[1], exact_gbar), (start[2], d)):
                worst = max(worst, float(abs(a - b) / scale))
    real = (found.velocity_bottom > 0) & (found.velocity_top < 0) & (found.d > 0)
    for d in found.d[real][:2] if abs(u) < 0.49 else []:
        study = base.with_device(inclination_deg=base.device.inclination_deg if own else 0.0).with_groups(d=float(d))
        motions = examine(study.study())
        worst = max(worst, motions.error or 0.0)
        if not motions.right:
            return motions
    return Finding(f"{count(len(phase), 'solution')}, {count(int(real.sum()), 'motion')}", worst, BOUND)


def _sweeps(base: Base) -> Iterator[Case]:
    group, s = "sweep", float(base.device.length_m)
    refused = partial(_swept, base, (Parameter.LENGTH, s, s))
    yield Case("of no width", group, "refused as an invalid scenario", refused, refusal="sweep.to")
    hair = partial(_swept, base, (Parameter.LENGTH, s, float(np.nextafter(s, inf))))
    yield Case("one spacing of doubles wide", group, "refused as an invalid scenario", hair, refusal="sweep.to")
    narrow = partial(_swept, base, (Parameter.LENGTH, s, s * (1 + 2e-9)))
    yield Case("relative width 2e-9", group, "the motions there, as in 40 digits", narrow)
    yield Case("reversed", group, "the same numbers to the last bit", partial(_reversed, base))
    yield Case("1,000,000 points", group, f"{ROWS * 8} of them as in 40 digits", partial(_million, base))
    everything: tuple[tuple[Parameter, float, float], ...] = (
        (Parameter.LENGTH, 1e-15, 1e15),
        (Parameter.AMPLITUDE, 1e-15, 1e15),
        (Parameter.FREQUENCY, 1e-15, 1e15),
        (Parameter.INCLINATION, 0.0, 90.0),
    )
    for sweep in everything:
        name = f"{sweep[0]} from {sweep[1]:g} to {sweep[2]:g}"
        yield Case(name, group, MOTIONS, partial(_swept, base, sweep))
    for name, low, high in (("at 90 deg, 1e-7 deg wide", 90 - 1e-7, 90.0), ("at 0 deg, 1e-16 deg wide", 0.0, 1e-16)):
        expected = "gbar is one double at both ends: answered or refused"
        yield Case(
            name,
            group,
            expected,
            partial(_swept, base, (Parameter.INCLINATION, low, high)),
            refusal="sweep|inclination",
            answers=True,
        )
    expected = "no branch, and an alert that says so"
    yield Case("beyond every motion", group, expected, partial(_empty, base))
    expected = "every picture is drawn, and says that there is none"
    yield Case("beyond every motion, drawn", group, expected, partial(_drawn, base))


def _swept(base: Base, sweep: tuple[Parameter, float, float]) -> Finding:
    return examine(base.study(sweep))


def _reversed(base: Base) -> Finding:
    length = float(base.device.length_m)
    low, high = base.span[0] * length, base.span[1] * length
    one, two = base.study((Parameter.LENGTH, low, high)), base.study((Parameter.LENGTH, high, low))
    rows = 0
    same = [c.point for c in one.solution.critical_points] == [c.point for c in two.solution.critical_points]
    for a, b in zip(one.solution.branches, two.solution.branches, strict=True):
        rows += len(a.motions)
        same = same and np.array_equal(a.motions.sweep_value, b.motions.sweep_value)
        same = same and np.array_equal(a.motions.velocity_bottom, b.motions.velocity_bottom)
    return Finding(f"{count(rows, 'motion')}, {'the same' if same else 'not the same'}", right=same)


def _million(base: Base) -> Finding:
    """A million motions of the longest branch at once, some of them compared."""
    study = base.over()
    assert study.solution.diagram is not None
    if not study.solution.branches:
        raise NotThereError("the device has no branch of motions")
    curve = study.solution.diagram.curve
    samples = sample(curve)
    longest = max(range(len(curve.strands)), key=lambda k: int(np.sum((samples.which == k) & (samples.validity > 0))))
    w = samples.w[(samples.which == longest) & (samples.validity > 0)]
    orbit = curve.at(np.full(MANY, longest), np.linspace(w.min(), w.max(), MANY))
    motions = motions_of(curve.sweep, curve.level, orbit)
    real = np.flatnonzero((motions.velocity_bottom > 0) & (motions.velocity_top < 0))
    rows = np.random.default_rng(SEED).choice(real, ROWS * 8, replace=False)
    worst = max(errors(motions, rows, study.solution.device, Parameter.LENGTH, True))
    return Finding(f"{len(motions):,} motions, {int(motions.admissible[real].sum()):,} admissible", worst, BOUND)


def _empty(base: Base) -> Finding:
    study = base.over((1e4, 1e5))
    found = examine(study)
    return Finding(found.text, found.error, found.bound, found.right and not study.solution.branches)


def _drawn(base: Base) -> Finding:
    from vireport.figures import pictures

    drawn = pictures(base.over((1e4, 1e5), FORMATS))
    silent = [one.name for one in drawn if "no " not in f"{one.caption} {one.alt}".lower()]
    text = f"{', '.join(silent)} does not say so" if silent else f"{count(len(drawn), 'picture')}, each says so"
    return Finding(text, right=bool(drawn) and not silent)


def _membrane(base: Base) -> Iterator[Case]:
    active, ball = base.membrane.active_radius_m, base.membrane.ball_radius_m
    for name, delta in (
        ("0", 0.0),
        ("1e-9 of rb", 1e-9 * ball),
        ("rb", ball),
        ("2 rb", 2 * ball),
        ("Rc", active),
        ("100 Rc", 100 * active),
    ):
        expected = "0 V" if delta == 0 else "the voltage of (5.2)-(5.5), as in 40 digits"
        yield Case(f"deflection {name}", "membrane", expected, partial(_deflected, base, delta))
    gentle = partial(_struck, base, 1e-300)
    yield Case("impact at 1e-300 m/s", "membrane", "no more volts than a double can hold", gentle)
    expected = "an alert with the depth"
    yield Case("a run with deflections over Rc", "membrane", expected, partial(_too_deep, base))


def _deflected(base: Base, delta: float) -> Finding:
    m = base.membrane
    return _struck(
        base, (2 * m.stiffness / (m.ball_mass_kg * (m.exponent + 1))) ** 0.5 * delta ** ((m.exponent + 1) / 2)
    )


def _struck(base: Base, speed: float) -> Finding:
    from vireport import reference as exact
    from vireport.physics import voltages

    membrane = base.membrane
    found = voltages(np.array([speed]), np.array([-speed]), membrane)
    require_finite(found)
    delta, volts = exact.voltage(speed, membrane)
    pairs = ((found.deflection_m[0], delta), (found.average_v[0], volts))
    worst = max(0.0 if b < 1e-300 and a < 1e-300 else float(abs(a - b) / abs(b)) for a, b in pairs)
    return Finding(f"{found.deflection_m[0]:.4g} m, {found.average_v[0]:.4g} V", worst, BOUND)


def _too_deep(base: Base) -> Finding:
    """The deepest admissible impact of a run, and the alert where that is deeper than the membrane is wide."""
    study = base.over()
    deepest = study.solution.deepest_m
    alert = next((one for one in study.alerts if one.code == "VR010"), None)
    text = alert.cause.split(". ")[0] if alert else f"no alert at {deepest:.3g} m"
    return Finding(text, right=(alert is not None) == (deepest > base.membrane.active_radius_m))
