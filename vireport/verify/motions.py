"""Extreme cases of the periodic motions: restitution, inclination, gravity, length, units, sweeps, voltage."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from math import inf
from typing import Any

import numpy as np

from vireport.physics.device import NO_GRAVITY
from vireport.physics.energy import impact_speed, voltages
from vireport.physics.groups import Restitutions, by_wall
from vireport.scenario.parameters import Parameter
from vireport.study.checks import reference as exact
from vireport.study.study import Study
from vireport.text.formatting import quantity
from vireport.verify.compared import SPACING, examine, require_finite
from vireport.verify.harvester import Harvester
from vireport.verify.rows import BOUND, Case, CaseFinding

NEARLY_LOSSLESS = 1e-8
"""Bound at r = 1 - 1e-6, where rounding is magnified by 1/(1-r)."""

LOSSY, NEARLY_ALIKE = 0.5, 0.5 + 2e-9
"""Restitution of one membrane where that of the other is the extreme, and one that hardly differs from it."""

BOUNCY = 0.8
"""Restitution at which there are motions for gbar around 1."""

NO_LIFT = 1e-300
"""Deflection and voltage below which any of them counts as zero [m], [V]."""

RESTITUTIONS: tuple[tuple[str, float | Restitutions, float], ...] = (
    ("0", 0.0, BOUND),
    ("1e-12", 1e-12, BOUND),
    ("1 - 1e-6", 1 - 1e-6, NEARLY_LOSSLESS),
    ("0 at the bottom alone", Restitutions(0.0, LOSSY), BOUND),
    ("0 at the top alone", Restitutions(LOSSY, 0.0), BOUND),
    ("1 - 1e-6 at the bottom alone", Restitutions(1 - 1e-6, LOSSY), BOUND),
    ("1 - 1e-6 at the top alone", Restitutions(LOSSY, 1 - 1e-6), BOUND),
    ("0 at the bottom, 1 - 1e-6 at the top", Restitutions(0.0, 1 - 1e-6), BOUND),
    ("2e-9 apart", Restitutions(NEARLY_ALIKE, LOSSY), BOUND),
)

AROUND_ONE = (
    ("1 - 1e-12", 1 - 1e-12),
    ("1 - 1.1e-16", 1 - SPACING / 2),
    ("1", 1.0),
    ("1 + 2.2e-16", 1 + SPACING),
    ("1 + 1e-12", 1 + 1e-12),
)
"""Values of gbar."""

SCALINGS: tuple[tuple[str, dict[str, int]], ...] = (
    ("frequency", {"frequency_hz": 1, "length_m": -2}),
    ("force", {"amplitude_n": 1, "length_m": 1, "gravity_m_s2": 1}),
    ("capsule mass", {"capsule_mass_kg": 1, "ball_mass_kg": 1, "length_m": -1, "gravity_m_s2": -1}),
)
"""What holds the groups: powers with which the numbers of the device go."""


def motion_rows(harvester: Harvester) -> Iterator[Case]:
    """Every case that needs no simulation: all motions, branches and critical points as in 40 digits, or a refusal."""
    h, device = harvester, harvester.device
    for name, r, bound in RESTITUTIONS:
        yield _row("restitution", f"r = {name}", h.with_device(restitution=r).over, bound)
    for name, r in (("1 - 1e-12", 1 - 1e-12), ("1", 1.0)):  # motions come in continua
        yield _row("restitution", f"r = {name}", h.with_device(restitution=r).over, refusal="restitution", answer=False)
    level = h.with_device(inclination_deg=0.0, restitution=Restitutions(NEARLY_ALIKE, LOSSY))
    yield _row("restitution", "r = 2e-9 apart, horizontal", level.over)

    for beta in (0.0, 1e-9, 0.01, 89.999999, 90.0):
        yield _row("inclination", f"beta = {beta:.12g} deg", h.with_device(inclination_deg=beta).over)

    bouncy = h.with_device(restitution=BOUNCY) if min(by_wall(device.restitution)) < BOUNCY else h
    for name, gbar in AROUND_ONE:
        yield _row("gravity over forcing", f"gbar = {name}", _with_exact_gravity(h, gbar).over)
        if bouncy != h:
            case = f"gbar = {name}, r = {BOUNCY}"
            yield _row("gravity over forcing", case, _with_exact_gravity(bouncy, gbar).over)
    for gbar in (1e-14, 1e-9, 100.0):
        yield _row("gravity over forcing", f"gbar = {gbar:g}", h.with_groups(gbar=gbar).over)
    # So slight a tilt that gravity is below `NO_GRAVITY`: it is lost in rounding.
    upright = h.with_device(inclination_deg=90.0).groups[1]
    tilted = h.with_device(inclination_deg=float(np.degrees(5e-16 / upright)))
    yield _row("gravity over forcing", "gbar = 5e-16", tilted.over, 10 * NO_GRAVITY, refusal="gbar", answer=False)

    for d in (1e-9, 1e-6, 1e-3, 1e-1, 1.0, 10.0, 1e3):
        yield _row("length", f"d = {d:g}", h.with_groups(d=d).study)

    for what, powers in SCALINGS:
        for decades in (-6, -3, 3, 6):
            changes = {name: getattr(device, name) * 10.0 ** (decades * power) for name, power in powers.items()}
            yield _row("units", f"{what} x 1e{decades:+d}, groups held", h.with_device(**changes).over)

    yield from _sweeps(h)

    m = h.membrane
    depths = {"0": 0.0, "1e-9 of rb": 1e-9 * m.ball_radius_m, "rb": m.ball_radius_m, "2 rb": 2 * m.ball_radius_m}
    depths |= {"Rc": m.active_radius_m, "100 Rc": 100 * m.active_radius_m}
    speeds = {f"deflection {name}": float(impact_speed(depth, m)) for name, depth in depths.items()}
    for name, speed in (speeds | {"impact at 1e-300 m/s": 1e-300}).items():
        yield Case("membrane", name, partial(_voltage, h, speed))


def _row(group: str, name: str, ask: Callable[[], Study], bound: float = BOUND, **more: Any) -> Case:
    """A study that must be as in 40 digits, or be refused."""
    return Case(group, name, lambda: examine(ask(), bound), **more)


def _with_exact_gravity(harvester: Harvester, gbar: float) -> Harvester:
    """The harvester whose gbar is this double exactly, or the nearest there is."""
    start = harvester.with_groups(gbar=gbar)
    force = start.device.amplitude_n
    nearby = (start.with_device(amplitude_n=float(force + steps * np.spacing(force))) for steps in range(-8, 9))
    return min(nearby, key=lambda changed: abs(changed.groups[1] - gbar))


def _sweeps(h: Harvester) -> Iterator[Case]:
    group, length, s = "sweep", Parameter.LENGTH, float(h.device.length_m)
    for name, end in (("of no width", s), ("one spacing of doubles wide", float(np.nextafter(s, inf)))):
        yield _row(group, name, partial(h.study, (length, s, end)), refusal="sweep.to", answer=False)
    yield _row(group, "relative width 2e-9", partial(h.study, (length, s, s * (1 + 2e-9))))
    yield _row(group, "reversed", partial(h.study, (length, h.span[1] * s, h.span[0] * s)))
    for parameter in (length, Parameter.AMPLITUDE, Parameter.FREQUENCY):
        yield _row(group, f"{parameter} from 1e-15 to 1e+15", partial(h.study, (parameter, 1e-15, 1e15)))
    yield _row(group, "inclination_deg from 0 to 90", partial(h.study, (Parameter.INCLINATION, 0.0, 90.0)))
    # There gbar is one double at both ends.
    for name, low, high in (("at 90 deg, 1e-7 deg wide", 90 - 1e-7, 90.0), ("at 0 deg, 1e-16 deg wide", 0.0, 1e-16)):
        ask = partial(h.study, (Parameter.INCLINATION, low, high))
        yield _row(group, name, ask, refusal="sweep|inclination")
    yield _row(group, "beyond every motion", partial(h.over, (1e4, 1e5)))


def _voltage(harvester: Harvester, speed: float) -> CaseFinding:
    """The voltage of an impact by Eqs. (5.2)-(5.5), held against 40 digits."""
    answer = voltages(np.array([speed]), np.array([-speed]), harvester.membrane)
    require_finite(answer)
    depth, volts = float(answer.deflection_m[0]), float(answer.average_v[0])
    pairs = zip((depth, volts), exact.voltage(speed, harvester.membrane), strict=True)
    errors = [0.0 if b < NO_LIFT and a < NO_LIFT else float(abs(a - b) / abs(b)) for a, b in pairs]
    return CaseFinding(f"{quantity(depth, 'm')}, {quantity(volts, 'V')}", max(errors))
