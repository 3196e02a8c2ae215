"""The extreme cases of the simulation: flights, slow impacts, chatter, rest, and very many impacts."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import pi
from typing import Any

import numpy as np

from vireport.extremes.checks import UNIT, Base, Case, Finding, NotThereError, count, require_finite
from vireport.scenario import Parameter
from vireport.simulation import (
    BOTTOM,
    FLIGHT,
    FREE,
    PHASE,
    REST,
    RIDING,
    SETTLING,
    TOP,
    TURN,
    VELOCITY,
    WALL,
    Impact,
    InFlight,
    check_model,
    check_start,
    follow,
    follow_one,
)

NEEDS = ("numba", "mpmath")

FLIGHT_BOUND = 1e-13
"""Relative error of a flight time where the ball does not nearly graze."""

SETTLING_BOUND = 1e-14
"""Absolute error of the time in which chatter dies out [t_c]: the kernel sums what is below 1e-15 in closed form."""

PULLING = 2.5
"""Phase [rad] at which the bottom membrane moves away from the ball, for a gbar up to 0.8."""

IMPACTS = 10_000_000
KEPT = 2000
COMPARED = 40

SMALLEST_HOP = 1e-26
"""Velocity at which the reference stops adding up hops one by one: what it then neglects is its square."""

HOP_DIGITS = 110
"""Working precision of hops, whose height is the square of their velocity."""

HOP = 1e-40
"""Relative error of the time of a hop."""

MOST_HOPS = 2000


def simulation_cases(base: Base) -> Iterator[Case]:
    """Every case of the simulation."""
    d, gbar = (float(x) for x in base.device.groups(Parameter.LENGTH, base.device.length_m))
    r = float(base.device.restitution)

    def case(name: str, expected: str, run: partial[Finding]) -> Case:
        return Case(name, "simulation", expected, run, NEEDS)

    first = "the first impact, as in 40 digits"
    for distance in (1e-9, 1e-3, 1.0, 1e3):
        yield case(f"flight, d = {distance:g}", first, partial(_one_flight, (distance, gbar, r), 0.7, 0.2))
    for restitution in (0.0, 1e-12, 1.0):
        yield case(f"flight, r = {restitution:g}", first, partial(_one_flight, (d, gbar, restitution), 0.7, 0.2))
    for name, tilt in (("1e-14", 1e-14), ("1 - 1.1e-16", 1 - UNIT / 2), ("1", 1.0), ("1 + 2.2e-16", 1 + UNIT)):
        yield case(f"flight, gbar = {name}", first, partial(_one_flight, (d, tilt, r), 0.7, 0.2))
    pulled = "it leaves the membrane: the first impact, as in 40 digits"
    yield case("impact at 1e-300, membrane pulling away", pulled, partial(_slow_leaving, (d, min(gbar, 0.5), r)))
    pressed = "it settles in no time, and rides until the release arccos(-gbar)"
    yield case("impact at 1e-300, membrane pressing", pressed, partial(_slow_settling, (d, min(gbar, 0.5), r)))
    apex = "the top is met where the apex lies beyond it, and not where it does not"
    for gap in (0.0, 1e-14, -1e-14):
        yield case(f"apex {gap:+g} from the membrane", apex, partial(_apex, gbar, gap))
    accumulating = "the hops die out just before the release: time to rest as in 40 digits"
    for left in (1e-1, 1e-3):
        run = partial(_chatter_before_release, (d, min(gbar, 0.5), min(max(r, 0.1), 0.9)), left)
        yield case(f"chatter {left:g} before the release", accumulating, run)
    for name, tilt, expected in (
        ("1 - 1e-12", 1 - 1e-12, "released again, however slowly"),
        ("1", 1.0, "at rest on the bottom for ever"),
        ("1 + 1e-12", 1 + 1e-12, "at rest on the bottom for ever"),
    ):
        yield case(f"a slow ball at gbar = {name}", expected, partial(_resting, (d, tilt, min(r, 0.9)), tilt >= 1))
    expected = "in flight for ever, and said to be so"
    yield case("no gravity, no drift, d = 1000", expected, partial(_free, r))
    expected = "the last flights satisfy the equations like the first ones, in 40 digits"
    yield case("10,000,000 impacts", expected, partial(_many_impacts, (d, gbar, r)))


def _first(model: tuple[float, float, float], start: Impact | InFlight) -> Any:
    rows, summary = follow_one(check_model(*model)[0], check_start(start, model[0]), 1)
    require_finite(rows[:, : VELOCITY + 1], "the impact")
    return rows[-1] if summary[0] else None


def _exact_flight(model: tuple[float, float, float], velocity: float, phase: float, row: Any) -> tuple[float, bool]:
    """Error of the time, phase and velocity of an impact that follows one on the bottom, and whether it is the first.

    Relative to the time and to 1 + |velocity|.
    """
    from vireport import reference as exact

    with exact.precise():
        d, gbar, r = (exact.mpf(x) for x in model)
        start, speed, angle = d / 2, -r * exact.mpf(velocity), exact.mpf(phase)
        wall = d / 2 * int(row[WALL])
        guess = float(row[FLIGHT])
        time = exact.newton(lambda x: [exact.flight(x[0], start, speed, angle, gbar)[0] - wall], [guess])[0]
        rate = exact.flight(time, start, speed, angle, gbar)[1]
        turned = (angle + exact.mp.pi * time - exact.mpf(float(row[PHASE]))) / (2 * exact.mp.pi)
        off = abs(turned - exact.mp.nint(turned)) * 2 * exact.mp.pi
        error = max(abs(guess - time) / time, off / (1 + time), abs(float(row[VELOCITY]) - rate) / (1 + abs(rate)))
        earlier = [exact.mpf(x) * time / 500 for x in range(1, 500)]
        inside = all(abs(exact.flight(t, start, speed, angle, gbar)[0]) <= d / 2 for t in earlier)
    return float(error), inside


def _one_flight(model: tuple[float, float, float], velocity: float, phase: float) -> Finding:
    """From the bottom, at a phase where the forcing throws the ball upwards (or holds it there, which is said)."""
    d, gbar, r = model
    if r * velocity < 1e-6 or gbar >= 1:
        phase = PULLING
    if d >= 1 and r > 0:
        velocity = max(velocity, 1.5 * (1 + float(np.sqrt(2 * gbar * d))) / r)
    row = _first(model, Impact(BOTTOM, velocity, phase))
    if row is None:
        return Finding("no further impact: the ball stays on the membrane", right=gbar >= 1)
    if r * velocity == 0 and gbar + np.cos(phase) > 0:
        return Finding(f"held until the membrane lets it go, then {row[FLIGHT]:.3g} t_c of flight")
    if row[FLIGHT] == 0:
        return Finding("the impact follows at once", right=False)
    released = r * velocity == 0
    error, first = _exact_flight(model, velocity, phase, row)
    where = "top" if row[WALL] == TOP else "bottom"
    text = f"{where} after {row[FLIGHT]:.6g} t_c at {row[VELOCITY]:.6g} y_c{', from rest' if released else ''}"
    return Finding(text if first else f"{text}, but an earlier impact was missed", error, FLIGHT_BOUND, first)


def _slow_leaving(model: tuple[float, float, float]) -> Finding:
    velocity, phase = 1e-300, PULLING
    row = _first(model, Impact(BOTTOM, velocity, phase))
    error, first = _exact_flight(model, velocity, phase, row)
    return Finding(f"{row[FLIGHT]:.6g} t_c later", error, FLIGHT_BOUND, first and row[FLIGHT] > 1e-3)


def _slow_settling(model: tuple[float, float, float]) -> Finding:
    from vireport import reference as exact

    rows, _ = follow_one(check_model(*model)[0], check_start(Impact(BOTTOM, 1e-300, 0.3), model[0]), 3)
    require_finite(rows[:, : VELOCITY + 1], "an impact")
    with exact.precise():
        release = (exact.mp.acos(-exact.mpf(model[1])) - exact.mpf(0.3)) / exact.mp.pi
        error = float(abs(rows[0, SETTLING] + rows[0, RIDING] - release) / release)
    text = f"settled in {rows[0, SETTLING]:.1e}, rode {rows[0, RIDING]:.6g} t_c"
    return Finding(text, error, FLIGHT_BOUND, rows[0, SETTLING] < 1e-290)


def _apex(gbar: float, gap: float) -> Finding:
    """A flight from the middle whose highest point is a hair inside or outside the top membrane, at -d/2."""
    from vireport import reference as exact

    phase, velocity = 2.0, -0.2
    with exact.precise():
        g, p, v = exact.mpf(gbar), exact.mpf(phase), exact.mpf(velocity)
        t = np.linspace(0.0, 2.0, 20001)[1:]
        rate = exact.flight(t, 0.0, velocity, phase, gbar, np)[1]
        index = np.flatnonzero((rate[1:] > 0) & (rate[:-1] <= 0))
        if not index.size:
            raise NotThereError("with this gravity the flight has no apex")
        time = exact.newton(lambda x: [exact.flight(x[0], 0, v, p, g)[1]], [float(t[index[0]])])[0]
        peak = -exact.flight(time, 0, v, p, g)[0]
        d = float(2 * (peak + exact.mpf(gap)))
        beyond = float(peak - exact.mpf(d) / 2)
    row = _first((d, gbar, 0.5), InFlight(0.0, velocity, phase))
    touched = row is not None and row[WALL] == TOP and abs(row[FLIGHT] - float(time)) < 1e-5
    right = touched == (beyond >= 0) or abs(beyond) < UNIT
    text = f"apex {beyond:+.1e} beyond it, {'met' if touched else 'not met'}"
    if not touched:
        return Finding(text, right=right)
    return Finding(f"{text} at {abs(row[VELOCITY]):.1e} y_c", abs(float(row[FLIGHT] - time)), 1e-6, right)


def _hops(model: tuple[float, float, float], velocity: float, phase: float) -> Any:
    """Time in which hops on the bottom die out, added up one by one in 40 digits; None where the ball gets away."""
    from vireport import reference as exact

    mp, mpf = exact.mp, exact.mpf
    with mp.workdps(HOP_DIGITS):
        d, g, r = (mpf(x) for x in model)
        speed, angle, total = r * mpf(velocity), mpf(phase), mpf(0)
        for _ in range(MOST_HOPS):
            press = g + mp.cos(angle)
            if press <= 0:
                return None
            if speed < SMALLEST_HOP:
                return total + 2 * speed / ((1 - r) * press)
            t = 2 * speed / press
            for _ in range(60):
                # Divided by t, the trivial zero at the start is gone.
                z, rate = exact.flight(t, mpf(0), -speed, angle, g)
                step = z / t / (rate / t - z / t**2)
                t -= step
                if not 0 < t < 2:
                    return None
                if abs(step) < HOP * t:
                    break
            else:
                return None
            lowest = exact.flight(t / 2, mpf(0), -speed, angle, g)[0]
            if not -d < lowest < 0 or rate <= 0:
                return None
            speed, angle, total = r * rate, angle + mp.pi * t, total + t
    return None


def _chatter_before_release(model: tuple[float, float, float], left: float) -> Finding:
    """The fastest ball that still settles before the release: found in 40 digits, then simulated."""
    turn = float(np.arccos(-model[1]))
    phase = turn - pi * left
    low, high = 0.0, 10 * left * left
    for _ in range(24):
        middle = (low + high) / 2
        low, high = (middle, high) if _hops(model, middle, phase) is not None else (low, middle)
    if low == 0:
        raise NotThereError("no ball settles so shortly before the release")
    low *= 1 - 1e-4
    exact = _hops(model, low, phase)
    rows, _ = follow_one(check_model(*model)[0], check_start(Impact(BOTTOM, low, phase), model[0]), 400)
    require_finite(rows[:, : VELOCITY + 1], "an impact")
    held = np.flatnonzero(rows[:, RIDING] + rows[:, SETTLING] > 0)
    if not held.size:
        return Finding("the ball never settled", right=False)
    found = float(rows[1 : held[0] + 1, FLIGHT].sum() + rows[held[0], SETTLING])
    # The nearer the release, the more a rounding of the phase changes the rest of the hops: each hop may make one.
    rounding = _hops(model, low, float(np.nextafter(phase, 0)))
    condition = abs(float(rounding - exact)) if rounding is not None else 1.0
    text = f"settled after {held[0]} hops and {found:.9g} t_c, {left - found:.2g} before the release"
    return Finding(text, abs(found - float(exact)), SETTLING_BOUND + 2 * int(held[0]) * condition)


def _resting(model: tuple[float, float, float], rests: bool) -> Finding:
    rows, summary = follow_one(check_model(*model)[0], check_start(Impact(BOTTOM, 1e-3, 0.0), model[0]), 1000)
    require_finite(rows[:, : VELOCITY + 1], "an impact")
    resting = summary[2] == REST
    text = "at rest" if resting else f"{count(int(summary[0]), 'impact')}, in motion"
    return Finding(text, right=bool(resting) == rests)


def _free(r: float) -> Finding:
    _, summary = follow_one(check_model(1e3, 0.0, r)[0], check_start(InFlight(0.0, 0.0, 0.0), 1e3), 5)
    free = summary[2] == FREE
    return Finding("in flight for ever" if free else "an impact", right=bool(free))


def _many_impacts(model: tuple[float, float, float]) -> Finding:
    """Ten million impacts at once; of the last flights, the residual of (2.12) in 40 digits."""
    from vireport import reference as exact

    kept, summary = follow(check_model(*model), np.array([[BOTTOM, 0.0, 0.7, 0.2]]), IMPACTS, keep=KEPT)
    rows, made = kept[0], int(summary[0, 0])
    rows = rows[max(0, len(rows) - made - 1) :]
    require_finite(rows[:, : VELOCITY + 1], "an impact")
    if made < IMPACTS:
        word = {REST: "at rest", FREE: "in flight for ever"}.get(int(summary[0, 2]), "stopped")
        return Finding(f"{word} after {count(made, 'impact')}", right=int(summary[0, 2]) in (REST, FREE))
    plain = [i for i in range(1, len(rows)) if rows[i - 1, RIDING] + rows[i - 1, SETTLING] == 0]
    worst = 0.0
    with exact.precise():
        d, gbar, r = (exact.mpf(x) for x in model)
        for i in plain[-COMPARED:]:
            before, after = ([exact.mpf(float(x)) for x in rows[k]] for k in (i - 1, i))
            z, rate = exact.flight(after[FLIGHT], before[WALL] * d / 2, -r * before[VELOCITY], before[PHASE], gbar)
            turned = (before[PHASE] + exact.mp.pi * after[FLIGHT] - after[PHASE]) / TURN
            off = abs(turned - exact.mp.nint(turned))
            worst = max(worst, float(abs(z - after[WALL] * d / 2)), float(abs(rate - after[VELOCITY])), float(off))
    inside = bool((np.sign(rows[1:, VELOCITY]) == rows[1:, WALL]).all())
    return Finding(f"{made:,} impacts", worst, 1e-14, inside)
