"""Impacts per second: the event search of this package beside three ways of doing without it.

All on one core, in one run, at the period-1 orbit of 45 degrees, 3 N and d = 0.4604. The error is the
distance of the last bottom impact from that orbit, which attracts, so that it shows the error of a flight and
not a sum of them.

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

from vireport.physics import Groups
from vireport.simulation import (
    BOTTOM,
    PHASE,
    TOP,
    VELOCITY,
    Impact,
    InFlight,
    attractors,
    check_model,
    check_start,
    diagram,
    follow_impacts,
    follow_one,
)

D, R = 0.4604, 0.5
GBAR = 0.1245 * 9.8 * sin(radians(45)) / 3
SPEED, PHI = 1.00400474, 0.56672469
MODEL = check_model(Groups(D, GBAR, R))
GOALS = {"heyoka taylor_adaptive": 15, "solve_ivp DOP853": 3000}
RK4_STEP = 1 / 256
FIGURE_2 = [
    Impact(BOTTOM, 0.7, 0.2),
    Impact(BOTTOM, 0.3, 2.0),
    Impact(TOP, -0.5, 4.0),
    InFlight(0.0, 0.4, 1.0),
]

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
def _rk4_step(t, z, v, h, gbar, phi):  # type: ignore[no-untyped-def]
    a1 = gbar + cos(pi * t + phi)
    a2 = gbar + cos(pi * (t + h / 2) + phi)
    a4 = gbar + cos(pi * (t + h) + phi)
    return z + h * v + h * h / 6 * (a1 + 2 * a2), v + h / 6 * (a1 + 4 * a2 + a4)


@njit(error_model="numpy")
def _rk4(d, gbar, r, speed, phi, h, impacts):  # type: ignore[no-untyped-def]
    t, z, v, calls, last_v, last_t = 0.0, d / 2, -r * speed, 0, 0.0, 0.0
    for _ in range(impacts):
        while True:
            nz, nv = _rk4_step(t, z, v, h, gbar, phi)
            calls += 3
            if abs(nz) > d / 2:
                break
            t, z, v = t + h, nz, nv
        low, high = 0.0, h
        for _ in range(50):
            middle = (low + high) / 2
            nz, nv = _rk4_step(t, z, v, middle, gbar, phi)
            calls += 3
            if abs(nz) > d / 2:
                high = middle
            else:
                low = middle
        wall = 1.0 if nz > 0 else -1.0
        t += low
        if wall > 0:
            last_v, last_t = nv, t
        z, v = wall * d / 2, -r * nv
    return calls, last_v, last_t


def rk4(impacts: int = 20_000) -> Measured:
    _rk4(D, GBAR, R, SPEED, PHI, RK4_STEP, 1)
    began = time.perf_counter()
    calls, velocity, t = _rk4(D, GBAR, R, SPEED, PHI, RK4_STEP, impacts)
    took = time.perf_counter() - began
    return impacts, took, f"{calls / impacts:.0f} cosines", distance(velocity, pi * t + PHI)


def best_of(method: Callable[[], Measured], times: int = 5) -> Measured:
    return min((method() for _ in range(times)), key=lambda measured: measured[1] / measured[0])


def first_call(cache: str) -> tuple[float, float]:
    """Seconds a new process needs to import the compiler, and for its first impact."""
    code = (
        "import time, numpy, vireport.simulation.events as e; a = time.perf_counter()\n"
        "import numba; b = time.perf_counter()\n"
        "e.follow(e.check_model(.4, .2, .5), numpy.array([[1., 0., 1., 0.]]), 1)\n"
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
        "import vireport.simulation.events as e\n"
        f"start = numpy.array([e.check_start(e.Impact(1, {SPEED}, {PHI}), {D})])\n"
        f"model = e.check_model({D}, {GBAR}, {R}); e.follow(model, start, 1); a = time.perf_counter()\n"
        f"e.follow(model, start, {impacts}); print((time.perf_counter() - a) / {impacts})"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(run.stdout)


def on_all_cores() -> None:
    d = np.linspace(0.05, 0.6, 200)
    for gbar, name in ((0.0, "horizontal"), (GBAR, "45 deg, 3 N")):
        model = check_model(Groups(np.repeat(d, len(FIGURE_2)), gbar, R))
        starts = np.array([check_start(start, value) for value in d for start in FIGURE_2])
        rates = []
        for workers in (1, os.cpu_count() or 1):
            took = []
            for _ in range(3):
                began = time.perf_counter()
                summary = follow_impacts(model, starts, 10_000, 64, workers)[1]
                took.append(time.perf_counter() - began)
            rates.append(f"{summary[:, 0].sum() / min(took) / 1e6:.1f} million/s on {workers}")
        took = []
        for _ in range(3):
            began = time.perf_counter()
            diagram(attractors(Groups(d, gbar, R), FIGURE_2))
            took.append(time.perf_counter() - began)
        overlay = f"overlay of 200 x 4 x 1,000: {min(took):.2f} s"
        print(f"figure 2, {name:12s}  impacts {', '.join(rates)}; {overlay}")


def main() -> None:
    simulation = start_up()
    cores = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
    if cores:
        os.sched_setaffinity(0, {min(cores)})
    methods: dict[str, Callable[[], Measured]] = {
        "vireport": ours,
        "heyoka taylor_adaptive": heyoka,
        "solve_ivp DOP853": dop853,
        "RK4 and bisection": rk4,
    }
    print(f"\n{'one core':24s}{'impacts/s':>12s}{'slower by':>11s}   {'per impact':28s}{'error':>8s}")
    rows: list[dict[str, str | float]] = []
    for name, method in methods.items():
        try:
            impacts, took, work, error = best_of(method)
        except ImportError as missing:
            print(f"{name:24s}not measured: {missing}")
            continue
        rate = impacts / took
        slower = rows[0]["per_second"] / rate if rows else 1.0
        rows.append({"method": name, "per_second": rate, "slower": slower, "work": work, "error": error})
        goal = f"  (goal: {GOALS[name]:,})" if name in GOALS else ""
        print(f"{name:24s}{rate:12,.0f}{slower:11,.1f}   {work:28s}{error:8.0e}{goal}")
    if cores:
        os.sched_setaffinity(0, cores)
    record("impacts", simulation=simulation, methods=rows)
    print()
    on_all_cores()


if __name__ == "__main__":
    main()
