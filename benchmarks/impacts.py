"""Impacts per second: the event search of this package beside other ways of doing it.

All on one core, in one run, by the processor's time, at the period-1 orbit of 45 degrees, 3 N and d = 0.4604. The error
is the distance of the last bottom impact from that orbit, which attracts, so that it shows the error of a flight and
not a sum of them. `misses` says what a method can pass over: the event search of this package passes over nothing.

The closest peers know the flight in closed form, too: they look for the next impact in equal steps of time, and solve
for it by Newton's method. `impacts.c` does so with a polynomial for sine and cosine, for one trajectory and for 512 in
lockstep, compiled by gcc where that is there; numba's calls the library's sine. Each takes the step that is fastest on
this very orbit. The C fuses products with sums, a fifth of its time; the search of this package does not, as NumPy
cannot, and impacts are to be the same to the last bit however they are found.

    python benchmarks/impacts.py
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from math import cos, log, pi, radians, sin
from pathlib import Path

import numpy as np
from numba import njit
from record import processor_time, record
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
LANES = 512
MISSES = {
    "vireport": "nothing",
    "numba": "hops and peaks shorter than its step",
    "C": "hops and peaks shorter than its step",
    "heyoka": "contacts after a bounce that are within its cooldown",
    "solve_ivp": "two crossings within one of its steps",
}
"""By the beginnings of the names of methods, what impacts they can miss."""
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
    began = time.process_time()
    rows, summary = follow_impacts(MODEL, start, impacts, keep=16)
    took = time.process_time() - began
    error = distance(*rows[0, -1, [VELOCITY, PHASE]])
    return impacts, took, f"{summary[0, 1] / impacts:.2f} sine-cosine pairs", error


def ours_together(impacts: int = 2000) -> Measured:
    models, starts = np.repeat(MODEL, LANES, axis=0), np.tile(check_start(Impact(BOTTOM, SPEED, PHI), D), (LANES, 1))
    began = time.process_time()
    rows, summary = follow_impacts(models, starts, impacts, keep=16)
    took = time.process_time() - began
    work = f"{summary[0, 1] / impacts:.2f} sine-cosine pairs"
    return impacts * LANES, took, work, distance(*rows[0, -1, [VELOCITY, PHASE]])


def compiled_c(folder: str) -> dict[str, Callable[[float, int], Measured]] | None:
    """The functions of `impacts.c`, each of the step and the number of impacts; None without gcc."""
    if shutil.which("gcc") is None:
        return None
    library = Path(folder) / "impacts.so"
    source = Path(__file__).with_name("impacts.c")
    subprocess.run(
        ["gcc", "-O3", "-march=native", "-fno-trapping-math", "-shared", "-fPIC", "-o", library, source, "-lm"],
        check=True,
    )
    peers, real = ctypes.CDLL(str(library)), ctypes.c_double
    several = np.ctypeslib.ndpointer(float)
    peers.one.argtypes, peers.one.restype = [real] * 6 + [ctypes.c_long, several], real
    peers.lockstep.argtypes, peers.lockstep.restype = [real] * 3 + [several, several, real, ctypes.c_long], real

    def one(h: float, impacts: int) -> Measured:
        last = np.zeros(2)
        began = time.process_time()
        evaluations = peers.one(D, GBAR, R, SPEED, PHI, h, impacts, last)
        took = time.process_time() - began
        return impacts, took, f"{evaluations:.3g} evaluations of the flight, steps of 1/{1 / h:.0f}", distance(*last)

    def lockstep(h: float, impacts: int) -> Measured:
        speeds, phases, each = np.full(LANES, SPEED), np.full(LANES, PHI), impacts // LANES
        began = time.process_time()
        evaluations = peers.lockstep(D, GBAR, R, speeds, phases, h, each)
        took = time.process_time() - began
        work = f"{evaluations:.3g} evaluations of the flight, steps of 1/{1 / h:.0f}"
        return each * LANES, took, work, distance(speeds[0], phases[0])

    return {"C, one trajectory": one, f"C, {LANES} trajectories in lockstep": lockstep}


def heyoka_batch(impacts: int = 40_000, size: int = 4) -> Measured:
    """Several trajectories in one integrator, in the registers of the processor."""
    import heyoka as hy

    z, v = hy.make_vars("z", "v")
    seen: list[tuple[float, float]] = []

    def reflect(wall: int) -> Callable[..., bool]:
        def callback(state, _, lane: int) -> bool:
            if lane == 0 and wall == BOTTOM:
                seen.append((state.state[1, 0], pi * state.time[0] + PHI))
            state.state[1, lane] *= -R
            return True

        return callback

    integrator = hy.taylor_adaptive_batch(
        [(z, v), (v, GBAR + hy.cos(pi * hy.time + PHI))],
        np.tile([[D / 2], [-R * SPEED]], size),
        t_events=[
            hy.t_event_batch(z - D / 2, callback=reflect(BOTTOM), direction=hy.event_direction.positive),
            hy.t_event_batch(z + D / 2, callback=reflect(TOP), direction=hy.event_direction.negative),
        ],
    )
    began = time.process_time()
    integrator.propagate_until([impacts / size] * size)
    took = time.process_time() - began
    return impacts, took, f"{size} trajectories at once, order {integrator.order}", distance(*seen[-1])


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
    began = time.process_time()
    steps = integrator.propagate_until(float(impacts))[3]
    took = time.process_time() - began
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
    began = time.process_time()
    for _ in range(impacts):
        run = solve_ivp(rate, (t, t + 9), (z, v), "DOP853", rtol=1e-10, atol=1e-12, events=(bottom, top))
        wall = BOTTOM if len(run.t_events[0]) else TOP
        t, speed, calls = run.t[-1], run.y[1, -1], calls + run.nfev
        if wall == BOTTOM:
            last = speed, pi * t + PHI
        z, v = wall * D / 2, -R * speed
    return impacts, time.process_time() - began, f"{calls / impacts:.0f} right-hand sides", distance(*last)


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
    began = time.process_time()
    evaluations, velocity, phase = _closed_form(D, GBAR, R, SPEED, PHI, h, impacts)
    took = time.process_time() - began
    work = f"{evaluations / impacts:.3g} evaluations of the flight, steps of 1/{1 / h:.0f}"
    return impacts, took, work, distance(velocity, phase)


def fastest(scan: Callable[[float, int], Measured], impacts: int = 400_000) -> Callable[[], Measured]:
    """A scan with the step that is fastest here; none has an error of its own."""
    best = min(SCAN_STEPS, key=lambda h: min(scan(h, impacts // 10)[1] for _ in range(3)))
    return lambda: scan(best, impacts)


def best_of(methods: dict[str, Callable[[], Measured]], times: int = 7) -> dict[str, Measured]:
    """The fastest of several runs of each, in turn, so that all suffer alike from a busy machine."""
    rounds = [{name: method() for name, method in methods.items()} for _ in range(times)]
    return {
        name: min((one[name] for one in rounds), key=lambda measured: measured[1] / measured[0]) for name in methods
    }


def first_call(cache: str) -> tuple[float, float]:
    """Seconds of the processor that a new process needs to import the compiler, and for its first impact."""
    code = (
        "import time, numpy, vireport.simulation.events as e; from vireport.physics.groups import Groups\n"
        "a = time.process_time()\n"
        "import numba; b = time.process_time()\n"
        "e.follow_impacts(e.check_model(Groups(.4, .2, .5)), numpy.array([[1., 0., 1., 0.]]), 1)\n"
        "print(b - a, time.process_time() - b)"
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


def growth(counts: tuple[int, ...] = (1000, 10_000, 100_000), impacts: int = 40) -> dict[str, object]:
    """Processor time and memory of many random starts, and the powers of their number with which both grow."""
    rows, random = [], np.random.default_rng(0)
    for count in counts:
        models, starts = np.repeat(MODEL, count, axis=0), np.ones((count, 4))
        starts[:, 1], starts[:, 2:] = 0.0, random.uniform((0.2, 0.0), (2.0, 2 * pi), (count, 2))
        took, _ = processor_time(lambda models=models, starts=starts: follow_impacts(models, starts, impacts, keep=1))
        tracemalloc.start()
        follow_impacts(models, starts, impacts, keep=1)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        rows.append({"starts": count, "impacts": impacts, "seconds": took, "peak_mb": peak / 1e6})
        print(f"{count:9,d} starts {took:9.4f} s, {peak / 1e6:7.2f} MB")
    first, last = rows[0], rows[-1]
    powers = {
        f"{name}_exponent": log(last[name] / first[name]) / log(last["starts"] / first["starts"])
        for name in ("seconds", "peak_mb")
    }
    return {"rows": rows, **powers}


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
        f"model = e.check_model(Groups({D}, {GBAR}, {R})); e.follow_impacts(model, start, 1); a = time.process_time()\n"
        f"e.follow_impacts(model, start, {impacts}); print((time.process_time() - a) / {impacts})"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(run.stdout)


def main() -> None:
    simulation = start_up()
    cores = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
    if cores:
        os.sched_setaffinity(0, {min(cores)})
    methods = {"vireport": ours, f"vireport, {LANES} trajectories together": ours_together}
    with tempfile.TemporaryDirectory() as folder:
        scans = {"numba, closed form": scanned, **(compiled_c(folder) or {})}
        methods.update({name: fastest(scan) for name, scan in scans.items()})
        try:
            import heyoka as _  # noqa: F401
        except ImportError as missing:
            print(f"heyoka not measured: {missing}")
        else:
            methods |= {"heyoka taylor_adaptive": heyoka, "heyoka taylor_adaptive_batch": heyoka_batch}
        methods["solve_ivp DOP853"] = dop853
        measured = best_of(methods)
    print(f"\n{'one core':38s}{'impacts/s':>12s}{'slower by':>11s}   {'per impact':46s}{'error':>8s}   can miss")
    rows: list[dict[str, str | float]] = []
    for name, (impacts, took, work, error) in measured.items():
        rate = impacts / took
        slower = rows[0]["per_second"] / rate if rows else 1.0
        misses = next(words for word, words in MISSES.items() if name.startswith(word))
        compiled = "ours" if "solve_ivp" in name else "both"
        rows.append({
            "method": name, "compiled": compiled, "per_second": rate, "slower": slower, "work": work, "error": error,
            "misses": misses,
        })  # fmt: skip
        print(f"{name:38s}{rate:12,.0f}{slower:11,.2f}   {work:46s}{error:8.0e}   {misses}")
    starts = growth()
    if cores:
        os.sched_setaffinity(0, cores)
    record("impacts", simulation=simulation, methods=rows, starts=starts)


if __name__ == "__main__":
    main()
