"""Impacts per second: the event search of this package beside three ways of doing without it.

All on one core, in one run, at the period-1 orbit of 45 degrees, 3 N and d = 0.4604. The error is the
distance of the last bottom impact from that orbit, which attracts, so that it shows the error of a flight and
not a sum of them.

The closest peer knows the flight in closed form, too: it looks for the next impact in equal steps of time, and
solves for it by Newton's method. It takes the step that is fastest on this very orbit. A scan with such a step passes
over short hops and over peaks beyond a membrane between two of its times; the event search of this package takes no
step, and passes over none.

    python benchmarks/impacts.py
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from math import cos, pi, radians, sin

import numpy as np
from numba import njit
from record import record
from scipy.integrate import solve_ivp

from vireport.physics.groups import Groups
from vireport.simulation.events import (
    BOTTOM,
    TOP,
    Impact,
    check_model,
    check_start,
    follow_impacts,
    follow_one,
)
from vireport.simulation.kernel import PHASE, VELOCITY

D, R = 0.4604, 0.5
GBAR = 0.1245 * 9.8 * sin(radians(45)) / 3
SPEED, PHI = 1.00400474, 0.56672469
MODEL = check_model(Groups(D, GBAR, R))
SCAN_STEPS = [1 / n for n in (1, 2, 3, 4, 6, 8, 12, 16, 32)]

Measured = tuple[int, float, str, float]


def orbit() -> tuple[float, float]:
    """Velocity and phase at the bottom, to rounding."""
    row = follow_one(MODEL[0], (1.0, 0.0, SPEED, PHI), 200)[0][-1]
    return float(row[VELOCITY]), float(row[PHASE])


def distance(velocity: float, phase: float) -> float:
    best = orbit()
    turned = (phase - best[1] + pi) % (2 * pi) - pi
    return max(abs(velocity - best[0]), abs(turned))


def ours(impacts: int = 1_000_000) -> Measured:
    start = np.array([check_start(Impact(BOTTOM, SPEED, PHI), D)])
    began = time.perf_counter()
    rows, summary = follow_impacts(MODEL, start, impacts, keep=16)
    took = time.perf_counter() - began
    error = distance(*rows[0, -1, [VELOCITY, PHASE]])
    return impacts, took, f"{summary[0, 1] / impacts:.2f} sine-cosine pairs", error


def heyoka(impacts: int = 40_000) -> Measured:
    import heyoka as hy

    z, v = hy.make_vars("z", "v")
    seen: list[tuple[float, float]] = []

    def reflect(wall: int) -> Callable[..., bool]:
        def callback(state, *_) -> bool:
            if wall == BOTTOM:
                seen.append((state.state[1], pi * state.time + PHI))
            else:
                seen.append((0.0, 0.0))
            state.state[1] *= -R
            return True

        return callback

    integrator = hy.taylor_adaptive(
        [(z, v), (v, GBAR + hy.cos(pi * hy.time + PHI))],
        [D / 2, -R * SPEED],
        t_events=[
            hy.t_event(z - D / 2, callback=reflect(BOTTOM), direction=hy.event_direction.positive),
            hy.t_event(z + D / 2, callback=reflect(TOP), direction=hy.event_direction.negative),
        ],
    )
    began = time.perf_counter()
    steps = integrator.propagate_until(float(impacts))[3]
    took = time.perf_counter() - began
    last = next(pair for pair in reversed(seen) if pair[0] > 0)
    return len(seen), took, f"{steps / len(seen):.2f} steps of order {integrator.order}", distance(*last)


def dop853(impacts: int = 300) -> Measured:
    def rate(t: float, y: np.ndarray) -> tuple[float, float]:
        return y[1], GBAR + cos(pi * t + PHI)

    def bottom(t: float, y: np.ndarray) -> float:
        return y[0] - D / 2

    def top(t: float, y: np.ndarray) -> float:
        return y[0] + D / 2

    bottom.terminal = top.terminal = True  # type: ignore[attr-defined]
    bottom.direction, top.direction = 1, -1  # type: ignore[attr-defined]
    t, z, v, calls, last = 0.0, D / 2, -R * SPEED, 0, (0.0, 0.0)
    began = time.perf_counter()
    for _ in range(impacts):
        run = solve_ivp(rate, (t, t + 9), (z, v), "DOP853", rtol=1e-10, atol=1e-12, events=(bottom, top))
        wall = BOTTOM if len(run.t_events[0]) else TOP
        t, speed, calls = run.t[-1], run.y[1, -1], calls + run.nfev
        if wall == BOTTOM:
            last = speed, pi * t + PHI
        z, v = wall * D / 2, -R * speed
    return impacts, time.perf_counter() - began, f"{calls / impacts:.0f} right-hand sides", distance(*last)


@njit(error_model="numpy")
def _flown(t, z, v, gbar, phase):  # type: ignore[no-untyped-def]
    """Position, velocity and acceleration at a time after a start with a phase: z'' = gbar + cos(pi t + phase)."""
    sine, cosine = sin(pi * t + phase), cos(pi * t + phase)
    speed = v - sin(phase) / pi
    position = z + t * (speed + gbar * t / 2) + (cos(phase) - cosine) / pi**2
    return position, speed + gbar * t + sine / pi, gbar + cosine


@njit(error_model="numpy")
def _closed_form(d, gbar, r, speed, phi, h, impacts):  # type: ignore[no-untyped-def]
    z, v, phase, evaluations, last_v, last_phase = d / 2, -r * speed, phi, 0, 0.0, 0.0
    for _ in range(impacts):
        t = h
        position, velocity, acceleration = _flown(t, z, v, gbar, phase)
        evaluations += 1
        while abs(position) <= d / 2:
            t += h
            position, velocity, acceleration = _flown(t, z, v, gbar, phase)
            evaluations += 1
        low, high, wall = t - h, t, d / 2 if position > 0 else -d / 2
        for _ in range(60):
            step = (wall - position) / velocity
            if abs(step) < 1e-8:
                break  # another step would change nothing: Newton's method squares the error
            t += step
            if not low < t < high:
                t = (low + high) / 2
            position, velocity, acceleration = _flown(t, z, v, gbar, phase)
            evaluations += 1
            if abs(position) > d / 2:
                high = t
            else:
                low = t
        t, velocity = t + step, velocity + acceleration * step
        phase = (phase + pi * t) % (2 * pi)
        if wall > 0:
            last_v, last_phase = velocity, phase
        z, v = wall, -r * velocity
    return evaluations, last_v, last_phase


def scanned(h: float, impacts: int) -> Measured:
    """The flight in closed form, looked at in steps of time."""
    _closed_form(D, GBAR, R, SPEED, PHI, h, 1)
    began = time.perf_counter()
    evaluations, velocity, phase = _closed_form(D, GBAR, R, SPEED, PHI, h, impacts)
    took = time.perf_counter() - began
    work = f"{evaluations / impacts:.3g} evaluations of the flight, steps of 1/{1 / h:.0f}"
    return impacts, took, work, distance(velocity, phase)


def closed_form(impacts: int = 400_000) -> Callable[[], Measured]:
    """The same with the step that is fastest here; none has an error of its own."""
    fastest = min(SCAN_STEPS, key=lambda h: min(scanned(h, impacts // 10)[1] for _ in range(3)))
    return lambda: scanned(fastest, impacts)


def best_of(method: Callable[[], Measured], times: int = 5) -> Measured:
    return min((method() for _ in range(times)), key=lambda measured: measured[1] / measured[0])


def first_call(cache: str) -> tuple[float, float]:
    """Seconds a new process needs to import the compiler, and for its first impact."""
    code = (
        "import time, numpy, vireport.simulation.events as e; from vireport.physics.groups import Groups\n"
        "a = time.perf_counter()\n"
        "import numba; b = time.perf_counter()\n"
        "e.follow_impacts(e.check_model(Groups(.4, .2, .5)), numpy.array([[1., 0., 1., 0.]]), 1)\n"
        "print(b - a, time.perf_counter() - b)"
    )
    run = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "NUMBA_CACHE_DIR": cache},
        capture_output=True,
        text=True,
        check=True,
    )
    importing, calling = map(float, run.stdout.split())
    return importing, calling


def start_up() -> dict[str, float]:
    with tempfile.TemporaryDirectory() as cache:
        cold, warm = first_call(cache), min(first_call(cache) for _ in range(3))
    print(f"first simulation ever   {sum(cold):5.2f} s (import {cold[0]:.2f}, compile {cold[1]:.2f})")
    print(f"first of a later run    {sum(warm):5.2f} s (import {warm[0]:.2f}, load    {warm[1]:.2f})")
    return {"first_s": sum(cold), "later_s": sum(warm), "interpreted_us": 1e6 * interpreted()}


def interpreted(impacts: int = 5000) -> float:
    """Seconds an impact takes without numba."""
    code = (
        "import sys, time, numpy; sys.modules['numba'] = None\n"
        "import vireport.simulation.events as e; from vireport.physics.groups import Groups\n"
        f"start = numpy.array([e.check_start(e.Impact(1, {SPEED}, {PHI}), {D})])\n"
        f"model = e.check_model(Groups({D}, {GBAR}, {R})); e.follow_impacts(model, start, 1); a = time.perf_counter()\n"
        f"e.follow_impacts(model, start, {impacts}); print((time.perf_counter() - a) / {impacts})"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(run.stdout)


def main() -> None:
    simulation = start_up()
    cores = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
    if cores:
        os.sched_setaffinity(0, {min(cores)})
    methods: dict[str, tuple[Callable[[], Measured], str]] = {
        "vireport": (ours, "ours"),
        "closed form, scan and Newton": (closed_form(), "both"),
        "heyoka taylor_adaptive": (heyoka, "both"),
        "solve_ivp DOP853": (dop853, "ours"),
    }
    head = f"{'one core':30s}{'impacts/s':>12s}{'slower by':>11s}   {'compiled':10s}{'per impact':46s}{'error':>8s}"
    print(f"\n{head}")
    rows: list[dict[str, str | float]] = []
    for name, (method, compiled) in methods.items():
        try:
            impacts, took, work, error = best_of(method)
        except ImportError as missing:
            print(f"{name:30s}not measured: {missing}")
            continue
        rate = impacts / took
        slower = rows[0]["per_second"] / rate if rows else 1.0
        row = {"method": name, "compiled": compiled, "per_second": rate, "slower": slower, "work": work, "error": error}
        rows.append(row)
        print(f"{name:30s}{rate:12,.0f}{slower:11,.1f}   {compiled:10s}{work:46s}{error:8.0e}")
    if cores:
        os.sched_setaffinity(0, cores)
    record("impacts", simulation=simulation, methods=rows)


if __name__ == "__main__":
    main()
