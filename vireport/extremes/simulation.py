"""The extreme cases of the simulation: flights, slow impacts, chatter, rest, and very many impacts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from math import pi
from typing import Any

import numpy as np

from vireport.checks import reference as exact
from vireport.extremes.harvester import Harvester
from vireport.extremes.judge import (
    SPACING,
    Case,
    CaseFinding,
    NotThereError,
    count,
    require_finite,
)
from vireport.physics import Groups, each
from vireport.simulation import (
    BOTTOM,
    FLIGHT,
    FREE,
    PHASE,
    REST,
    RIDING,
    RUNNING,
    SETTLING,
    TOP,
    TURN,
    VELOCITY,
    WALL,
    Impact,
    InFlight,
    check_model,
    check_start,
    follow_impacts,
    follow_one,
)

FLIGHT_BOUND = 1e-13
"""Relative error of a flight time where the ball does not nearly graze."""

SETTLING_BOUND = 1e-14
"""Absolute error of the time in which chatter dies out [t_c]: the kernel sums what is below 1e-15 in closed form."""

APEX_BOUND = 1e-6
"""Absolute error of the time at which a ball grazes, which has half the digits."""

RESIDUAL_BOUND = 1e-14
"""Largest residual of an impact among very many, in position, velocity and phase."""

PULLING = 2.5
"""Phase [rad] at which the bottom membrane moves away from the ball, for a gbar up to 0.8."""

PRESSING = 0.3
"""Phase [rad] at which it presses against the ball."""

SLOW = 1e-300
"""Velocity of an impact [y_c] that hardly is one."""

SLOWEST_REBOUND = 1e-6
"""Velocity after an impact [y_c] below which a flight must start where the membrane moves away."""

IMPACTS = 10_000_000
KEPT = 2000
COMPARED = 40

EARLIER = 500
"""Times in a flight at which the ball must be between the membranes."""

SMALLEST_HOP = 1e-26
"""Velocity at which the reference stops adding up hops one by one: what it then neglects is its square."""

HOP_DIGITS = 110
"""Working precision of hops, whose height is the square of their velocity."""

HOP = 1e-40
"""Relative error of the time of a hop."""

MOST_HOPS, MOST_CORRECTIONS = 2000, 60
"""Most hops of one chatter, and most Newton corrections of the time of one hop."""

Start = Impact | InFlight

Rows = tuple[Any, Any]
"""Rows of impacts, and the summary, of `simulation.follow_one`."""


def simulation_cases(harvester: Harvester) -> Iterator[Case]:
    """Every case of the simulation."""
    d, gbar, r, *_ = harvester.groups
    slight, lossy = min(gbar, 0.5), each(r, lambda own: min(own, 0.9))
    bouncing = each(lossy, lambda own: max(own, 0.1))

    def case(name: str, expected: str, answer: Callable[[], Any], check: Callable[[Any], CaseFinding]) -> Case:
        return Case("simulation", name, expected, answer, check, needs="numba")

    def follows(name: str, expected: str, model: Groups[float], start: Start, impacts: int, check: Any) -> Case:
        return case(name, expected, partial(_followed, model, start, impacts), check)

    for name, model, start in (
        *((f"flight, d = {x:g}", Groups(x, gbar, r), None) for x in (1e-9, 1e-3, 1.0, 1e3)),
        *((f"flight, r = {x:g}", Groups(d, gbar, x), None) for x in (0.0, 1e-12, 1.0)),
        ("flight, gbar = 1e-14", Groups(d, 1e-14, r), None),
        ("flight, gbar = 1 - 1.1e-16", Groups(d, 1 - SPACING / 2, r), None),
        ("flight, gbar = 1", Groups(d, 1.0, r), None),
        ("flight, gbar = 1 + 2.2e-16", Groups(d, 1 + SPACING, r), None),
        ("impact at 1e-300, membrane pulling away", Groups(d, slight, r), Impact(BOTTOM, SLOW, PULLING)),
    ):
        thrown = start or _thrown(model)
        expected = "the first impact, as in 40 digits"
        yield follows(name, expected, model, thrown, 1, partial(_check_flight, model, thrown))
    expected = "it settles in no time, and rides until the release arccos(-gbar)"
    check = partial(_check_settling, slight)
    pressed = Impact(BOTTOM, SLOW, PRESSING)
    yield follows("impact at 1e-300, membrane pressing", expected, Groups(d, slight, r), pressed, 3, check)
    for gap in (0.0, 1e-14, -1e-14):
        expected = "the top is met where the apex lies beyond it, and not where it does not"
        yield case(f"apex {gap:+g} from the membrane", expected, partial(_apex, gbar, gap), _check_apex)
    for left in (1e-1, 1e-3):
        expected = "the hops die out just before the release: time to rest as in 40 digits"
        model = Groups(d, slight, bouncing)
        answer, check = partial(_chatter, model, left), partial(_check_chatter, model, left)
        yield case(f"chatter {left:g} before the release", expected, answer, check)
    slow, rest = Impact(BOTTOM, 1e-3, 0.0), "at rest on the bottom for ever"
    for name, model, begin, end, expected in (
        (
            "a slow ball at gbar = 1 - 1e-12",
            Groups(d, 1 - 1e-12, lossy),
            slow,
            RUNNING,
            "released, however slowly",
        ),
        ("a slow ball at gbar = 1", Groups(d, 1.0, lossy), slow, REST, rest),
        ("a slow ball at gbar = 1 + 1e-12", Groups(d, 1 + 1e-12, lossy), slow, REST, rest),
        ("no gravity, no drift, d = 1000", Groups(1e3, 0.0, r), InFlight(0.0, 0.0, 0.0), FREE, "in flight for ever"),
    ):
        yield follows(name, expected, model, begin, 1000, partial(_check_end, end))
    expected = "the last flights satisfy the equations like the first ones, in 40 digits"
    yield case(
        f"{IMPACTS:,} impacts",
        expected,
        partial(_many_impacts, harvester.groups),
        partial(_check_many, harvester.groups),
    )


def _followed(model: Groups[float], start: Start, impacts: int) -> Rows:
    rows, summary = follow_one(check_model(model)[0], check_start(start, model.d), impacts)
    require_finite(rows[:, : VELOCITY + 1], "an impact")
    return rows, summary


def _thrown(model: Groups[float]) -> Impact:
    """An impact on the bottom at which the forcing throws the ball upwards."""
    d, gbar, r = model.d, model.gbar, model.restitution_at(BOTTOM)
    velocity, phase = 0.7, 0.2
    if r * velocity < SLOWEST_REBOUND or gbar >= 1:
        phase = PULLING
    if d >= 1 and r > 0:
        velocity = max(velocity, 1.5 * (1 + float(np.sqrt(2 * gbar * d))) / r)
    return Impact(BOTTOM, velocity, phase)


def _exact_flight(model: Groups[float], start: Impact, row: Any) -> tuple[float, bool]:
    """Error of the time, phase and velocity of an impact that follows one on the bottom, and whether it is the first.

    Relative to the time and to 1 + |velocity|.
    """
    with exact.precise():
        d, gbar, r = (exact.mpf(x) for x in (model.d, model.gbar, model.restitution_at(BOTTOM)))
        left, speed, angle = d / 2, -r * exact.mpf(start.velocity), exact.mpf(start.phase)
        wall, duration = d / 2 * int(row[WALL]), float(row[FLIGHT])
        time = exact.newton(lambda x: [exact.flight(x[0], left, speed, angle, gbar)[0] - wall], [duration])[0]
        rate = exact.flight(time, left, speed, angle, gbar)[1]
        turned = (angle + exact.mp.pi * time - exact.mpf(float(row[PHASE]))) / (2 * exact.mp.pi)
        off = abs(turned - exact.mp.nint(turned)) * 2 * exact.mp.pi
        error = max(abs(duration - time) / time, off / (1 + time), abs(float(row[VELOCITY]) - rate) / (1 + abs(rate)))
        earlier = (exact.mpf(x) * time / EARLIER for x in range(1, EARLIER))
        inside = all(abs(exact.flight(t, left, speed, angle, gbar)[0]) <= d / 2 for t in earlier)
    return float(error), inside


def _check_flight(model: Groups[float], start: Impact, answer: Rows) -> CaseFinding:
    rows, summary = answer
    rebound = model.restitution_at(BOTTOM) * start.velocity
    if not summary[0]:
        return CaseFinding("no further impact: the ball stays on the membrane", right=model.gbar >= 1)
    row = rows[-1]
    if rebound == 0 and model.gbar + np.cos(start.phase) > 0:
        return CaseFinding(f"held until the membrane lets it go, then {row[FLIGHT]:.3g} t_c of flight")
    if row[FLIGHT] == 0:
        return CaseFinding("the impact follows at once", right=False)
    error, first = _exact_flight(model, start, row)
    where, rest = "top" if row[WALL] == TOP else "bottom", ", from rest" if rebound == 0 else ""
    text = f"{where} after {row[FLIGHT]:.6g} t_c at {row[VELOCITY]:.6g} y_c{rest}"
    return CaseFinding(text if first else f"{text}, but an earlier impact was missed", error, FLIGHT_BOUND, first)


def _check_settling(gbar: float, answer: Rows) -> CaseFinding:
    start = answer[0][0]
    with exact.precise():
        release = (exact.mp.acos(-exact.mpf(gbar)) - exact.mpf(PRESSING)) / exact.mp.pi
        error = float(abs(start[SETTLING] + start[RIDING] - release) / release)
    text = f"settled in {start[SETTLING]:.1e}, rode {start[RIDING]:.6g} t_c"
    return CaseFinding(text, error, FLIGHT_BOUND, start[SETTLING] < 1e-290)


def _apex(gbar: float, gap: float) -> tuple[Rows, float, float]:
    """A flight from the middle whose highest point is so far inside the top membrane: impacts, time and excess."""
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
    return _followed(Groups(d, gbar, 0.5), InFlight(0.0, velocity, phase), 1), float(time), beyond


def _check_apex(answer: tuple[Rows, float, float]) -> CaseFinding:
    (rows, summary), time, beyond = answer
    row = rows[-1]
    met = bool(summary[0]) and row[WALL] == TOP and abs(row[FLIGHT] - time) < 10 * APEX_BOUND
    right = met == (beyond >= 0) or abs(beyond) < SPACING
    text = f"apex {beyond:+.1e} beyond it, {'met' if met else 'not met'}"
    if not met:
        return CaseFinding(text, right=right)
    return CaseFinding(f"{text} at {abs(row[VELOCITY]):.1e} y_c", abs(float(row[FLIGHT]) - time), APEX_BOUND, right)


def _hops(model: Groups[float], velocity: float, phase: float) -> Any:
    """Time in which hops on the bottom die out, added up one by one in 40 digits; None where the ball gets away."""
    mp, mpf = exact.mp, exact.mpf
    with mp.workdps(HOP_DIGITS):
        d, g, r = (mpf(x) for x in (model.d, model.gbar, model.restitution_at(BOTTOM)))
        speed, angle, total = r * mpf(velocity), mpf(phase), mpf(0)
        for _ in range(MOST_HOPS):
            press = g + mp.cos(angle)
            if press <= 0:
                return None
            if speed < SMALLEST_HOP:
                return total + 2 * speed / ((1 - r) * press)
            time = _hop(2 * speed / press, speed, angle, g)
            if time is None:
                return None
            rate = exact.flight(time, mpf(0), -speed, angle, g)[1]
            if not -d < exact.flight(time / 2, mpf(0), -speed, angle, g)[0] < 0 or rate <= 0:
                return None
            speed, angle, total = r * rate, angle + mp.pi * time, total + time
    return None


def _hop(guess: Any, speed: Any, angle: Any, gbar: Any) -> Any:
    """Time until a ball that left the bottom is back there; None where it does not come back soon."""
    t = guess
    for _ in range(MOST_CORRECTIONS):
        # Divided by t, the trivial zero at the start is gone.
        z, rate = exact.flight(t, exact.mpf(0), -speed, angle, gbar)
        step = z / t / (rate / t - z / t**2)
        t -= step
        if not 0 < t < 2:
            return None
        if abs(step) < HOP * t:
            return t
    return None


Chatter = tuple[Any, float, float]
"""Rows of impacts, and the velocity and phase of the first."""


def _chatter(model: Groups[float], left: float) -> Chatter:
    """The fastest ball that still settles before the release: found in 40 digits, then simulated."""
    phase = float(np.arccos(-model.gbar)) - pi * left
    low, high = 0.0, 10 * left * left
    for _ in range(24):
        middle = (low + high) / 2
        low, high = (middle, high) if _hops(model, middle, phase) is not None else (low, middle)
    if low == 0:
        raise NotThereError("no ball settles so shortly before the release")
    low *= 1 - 1e-4
    return _followed(model, Impact(BOTTOM, low, phase), 400)[0], low, phase


def _check_chatter(model: Groups[float], left: float, answer: Chatter) -> CaseFinding:
    rows, velocity, phase = answer
    held = np.flatnonzero(rows[:, RIDING] + rows[:, SETTLING] > 0)
    if not held.size:
        return CaseFinding("the ball never settled", right=False)
    exact, hops = _hops(model, velocity, phase), int(held[0])
    settled = float(rows[1 : hops + 1, FLIGHT].sum() + rows[hops, SETTLING])
    # The nearer the release, the more a rounding of the phase changes the rest of the hops: each hop may make one.
    rounded = _hops(model, velocity, float(np.nextafter(phase, 0)))
    condition = abs(float(rounded - exact)) if rounded is not None else 1.0
    text = f"settled after {hops} hops and {settled:.9g} t_c, {left - settled:.2g} before the release"
    return CaseFinding(text, abs(settled - float(exact)), SETTLING_BOUND + 2 * hops * condition)


def _check_end(expected: int, answer: Rows) -> CaseFinding:
    """Whether the trajectory ends as it must, a count known beforehand."""
    impacts, end = int(answer[1][0]), int(answer[1][2])
    words = {REST: "at rest", FREE: "in flight for ever", RUNNING: f"{count(impacts, 'impact')}, in motion"}
    return CaseFinding(words[end], right=end == expected)


def _many_impacts(model: Groups[float]) -> Rows:
    """The last of ten million impacts, made at once."""
    rings, summary = follow_impacts(check_model(model), np.array([[BOTTOM, 0.0, 0.7, 0.2]]), IMPACTS, keep=KEPT)
    rows = rings[0][max(0, len(rings[0]) - int(summary[0, 0]) - 1) :]
    require_finite(rows[:, : VELOCITY + 1], "an impact")
    return rows, summary[0]


def _check_many(model: Groups[float], answer: Rows) -> CaseFinding:
    """Of the last flights, the residual of (2.12) in 40 digits."""
    rows, summary = answer
    if summary[2] != RUNNING:
        return _check_end(int(summary[2]), answer)
    plain = [i for i in range(1, len(rows)) if rows[i - 1, RIDING] + rows[i - 1, SETTLING] == 0]
    worst = 0.0
    with exact.precise():
        d, gbar, *_ = exactly = model.each(exact.mpf)
        for i in plain[-COMPARED:]:
            before, after = ([exact.mpf(float(x)) for x in rows[k]] for k in (i - 1, i))
            left = -exactly.restitution_at(int(before[WALL])) * before[VELOCITY]
            z, rate = exact.flight(after[FLIGHT], before[WALL] * d / 2, left, before[PHASE], gbar)
            turned = (before[PHASE] + exact.mp.pi * after[FLIGHT] - after[PHASE]) / TURN
            off = abs(turned - exact.mp.nint(turned))
            worst = max(worst, float(abs(z - after[WALL] * d / 2)), float(abs(rate - after[VELOCITY])), float(off))
    inside = bool((np.sign(rows[1:, VELOCITY]) == rows[1:, WALL]).all())
    return CaseFinding(f"{int(summary[0]):,} impacts", worst, RESIDUAL_BOUND, inside)
