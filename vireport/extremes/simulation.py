"""Extreme cases of the simulation: flights, slow impacts, rest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from vireport.checks import reference as exact
from vireport.extremes.compared import SPACING, require_finite
from vireport.extremes.harvester import Harvester
from vireport.extremes.rows import Case, CaseFinding, WrongAnswerError
from vireport.physics.groups import Groups, each
from vireport.simulation.events import BOTTOM, TOP, Impact, InFlight, check_model, check_start, follow_one
from vireport.simulation.kernel import FLIGHT, FREE, PHASE, REST, RIDING, RUNNING, SETTLING, VELOCITY, WALL

FLIGHT_BOUND = 1e-13
"""Relative error of a flight time where the ball does not nearly graze."""

PULLING, PRESSING = 2.5, 0.3
"""Phases [rad] at which the bottom membrane moves away from the ball, for a gbar up to 0.8, and presses against it."""

SLOW = 1e-300
"""Velocity of an impact [y_c] that hardly is one."""

SLOWEST_REBOUND = 1e-6
"""Velocity after an impact [y_c] below which a flight must start where the membrane moves away."""

EARLIER = 500
"""Times in a flight at which the ball must be between the membranes."""


def simulation_rows(harvester: Harvester) -> Iterator[Case]:
    """Every case of the simulation."""
    d, gbar, r, *_ = harvester.groups
    slight, lossy = min(gbar, 0.5), each(r, lambda wall: min(wall, 0.9))
    for name, model, start in (
        *((f"d = {x:g}", Groups(x, gbar, r), None) for x in (1e-9, 1e-3, 1.0, 1e3)),
        *((f"r = {x:g}", Groups(d, gbar, x), None) for x in (0.0, 1e-12, 1.0)),
        ("gbar = 1e-14", Groups(d, 1e-14, r), None),
        ("gbar = 1 - 1.1e-16", Groups(d, 1 - SPACING / 2, r), None),
        ("gbar = 1", Groups(d, 1.0, r), None),
        ("gbar = 1 + 2.2e-16", Groups(d, 1 + SPACING, r), None),
        ("impact at 1e-300, membrane pulling away", Groups(d, slight, r), Impact(BOTTOM, SLOW, PULLING)),
    ):
        yield Case("simulation", f"flight, {name}", _flight, (model, start or _thrown(model)), simulated=True)
    pressed = Groups(d, slight, r)
    yield Case("simulation", "impact at 1e-300, membrane pressing", _settling, (pressed,), simulated=True)
    dropped = Impact(BOTTOM, 1e-3, 0.0)
    for name, model, begin, end in (
        ("a slow ball at gbar = 1 - 1e-12", Groups(d, 1 - 1e-12, lossy), dropped, RUNNING),
        ("a slow ball at gbar = 1", Groups(d, 1.0, lossy), dropped, REST),
        ("a slow ball at gbar = 1 + 1e-12", Groups(d, 1 + 1e-12, lossy), dropped, REST),
        ("no gravity, no drift, d = 1000", Groups(1e3, 0.0, r), InFlight(0.0, 0.0, 0.0), FREE),
    ):
        yield Case("simulation", name, _end, (model, begin, end), simulated=True)


def _followed(model: Groups[float], start: Impact | InFlight, impacts: int) -> tuple[Any, Any]:
    """Rows of impacts, and the summary, of `simulation.follow_one`."""
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


def _flight(model: Groups[float], start: Impact) -> CaseFinding:
    """The impact that follows one on the bottom: the first there is, and its time, phase and velocity."""
    rows, summary = _followed(model, start, 1)
    rebound, row = model.restitution_at(BOTTOM) * start.velocity, rows[-1]
    if not summary[0]:
        if model.gbar < 1:
            raise WrongAnswerError("no further impact")
        return CaseFinding("the ball stays on the membrane")
    if rebound == 0 and model.gbar + np.cos(start.phase) > 0:
        return CaseFinding(f"held until the membrane lets it go, then {row[FLIGHT]:.3g} t_c of flight")
    if row[FLIGHT] == 0:
        raise WrongAnswerError("the impact follows at once")
    with exact.precise():
        d, gbar, r = (exact.mpf(x) for x in (model.d, model.gbar, model.restitution_at(BOTTOM)))
        left, speed, angle = d / 2, -r * exact.mpf(start.velocity), exact.mpf(start.phase)
        wall, duration = d / 2 * int(row[WALL]), float(row[FLIGHT])
        time = exact.newton(lambda x: [exact.flight(x[0], left, speed, angle, gbar)[0] - wall], [duration])[0]
        rate = exact.flight(time, left, speed, angle, gbar)[1]
        turns = (angle + exact.mp.pi * time - float(row[PHASE])) / (2 * exact.mp.pi)
        turned = abs(turns - exact.mp.nint(turns)) * 2 * exact.mp.pi
        error = max(
            abs(duration - time) / time, turned / (1 + time), abs(float(row[VELOCITY]) - rate) / (1 + abs(rate))
        )
        earlier = (exact.mpf(x) * time / EARLIER for x in range(1, EARLIER))
        if any(abs(exact.flight(t, left, speed, angle, gbar)[0]) > d / 2 for t in earlier):
            raise WrongAnswerError(f"an impact before {duration:.6g} t_c was missed")
    where = "top" if row[WALL] == TOP else "bottom"
    return CaseFinding(f"{where} after {duration:.6g} t_c at {row[VELOCITY]:.6g} y_c", float(error), FLIGHT_BOUND)


def _settling(model: Groups[float]) -> CaseFinding:
    """It settles in no time, and rides until the release at arccos(-gbar)."""
    start = _followed(model, Impact(BOTTOM, SLOW, PRESSING), 3)[0][0]
    with exact.precise():
        release = (exact.mp.acos(-exact.mpf(model.gbar)) - exact.mpf(PRESSING)) / exact.mp.pi
        error = float(abs(float(start[SETTLING]) + float(start[RIDING]) - release) / release)
    if start[SETTLING] >= 1e-290:
        raise WrongAnswerError(f"it settled in {start[SETTLING]:.1e} t_c")
    return CaseFinding(f"it rode {start[RIDING]:.6g} t_c", error, FLIGHT_BOUND)


def _end(model: Groups[float], start: Impact | InFlight, expected: int) -> CaseFinding:
    """How the trajectory ends."""
    summary = _followed(model, start, 1000)[1]
    ends = {REST: "at rest", FREE: "in flight for ever", RUNNING: "in motion"}
    if int(summary[2]) != expected:
        raise WrongAnswerError(f"{ends.get(int(summary[2]), 'lost')}, and not {ends[expected]}")
    return CaseFinding(ends[expected])
