"""Time an orbit of a branch takes, with stability, admissibility and voltages, and how it grows with their number.

    python benchmarks/branch.py

The peer solves the same orbits as scripts in this field do: Newton's method on (3.15)-(3.17) from the neighbouring
orbit, one at a time.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from record import record

from vireport import analyse, load
from vireport.motions.one_to_one import motions_of
from vireport.physics.energy import voltages

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
SIZES = (10_000, 100_000, 1_000_000)


def median_time(function: Callable[[], object], repeats: int = 5) -> float:
    """Median wall time of a call."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def main() -> None:
    """Print and record the table."""
    orbits, newton = [], []
    for name in ("horizontal", "inclined", "inclined-forcing"):
        study = analyse(load(EXAMPLES / f"{name}.yaml"))
        curve = study.solution.diagram.curve
        samples = curve.sampled()
        valid = samples.validity > 0
        strand = np.bincount(samples.which[valid]).argmax()
        w_valid = samples.w[valid & (samples.which == strand)]
        for size in SIZES:
            w = np.linspace(w_valid.min(), w_valid.max(), size)
            which = np.full(size, strand)

            def evaluate(which=which, w=w, study=study, curve=curve) -> None:
                motions = motions_of(curve.sweep, curve.at(which, w))
                unit = study.solution.device.velocity_unit(curve.sweep.parameter, motions.sweep_value)
                voltages(unit * motions.velocity_bottom, unit * motions.velocity_top, study.solution.membrane)

            seconds = median_time(evaluate)
            print(f"{name:<18} {size:>9,} orbits   {1e3 * seconds:8.1f} ms   {1e9 * seconds / size:6.0f} ns an orbit")
            orbits.append({"scenario": name, "orbits": size, "us_per_orbit": 1e6 * seconds / size})
        newton.append({"scenario": name, "us_per_orbit": 1e6 * newton_time(study)})
        print(f"{'':<18} {'Newton, one at a time':>16}   {1e3 * newton[-1]['us_per_orbit']:26.0f} ns an orbit")
    ratios = [
        peer["us_per_orbit"] / row["us_per_orbit"]
        for peer in newton
        for row in orbits
        if row["scenario"] == peer["scenario"]
    ]
    record("branch", orbits=orbits, newton=newton, ratios=ratios)


def newton_time(study) -> float:
    """Seconds an orbit by Newton's method on the three printed equations, started from the neighbour."""
    branch = study.solution.branches[0].motions
    r = study.solution.device.restitution
    rows = np.linspace(0, len(branch) - 1, 60).astype(int)

    def residual(x: np.ndarray, d: float, gbar: float) -> np.ndarray:
        v, phi, q = x
        up, down, a = 2 * q, 2 * (1 - q), 2 * np.pi * q
        return np.array(
            [
                (r - 1) * v
                - ((np.cos(a) - 1) * np.sin(phi) + np.sin(a) * np.cos(phi)) / np.pi
                + gbar * (2 / (1 + r) - up),
                (r * up - down) * v + 2 / np.pi * np.sin(phi) - (up - down) * gbar,
                ((np.cos(a) - 1) * np.cos(phi) - np.sin(a) * np.sin(phi)) / np.pi**2
                + up * down / 4 * (2 * (1 + r) * v - 2 * gbar)
                - d,
            ]
        )

    x = np.array([branch.velocity_bottom[0], branch.phi_bottom[0], branch.q[0]])
    start = time.perf_counter()
    for row in rows:
        for _ in range(30):
            value = residual(x, branch.d[row], branch.gbar[row])
            columns = [(residual(x + 1e-7 * e, branch.d[row], branch.gbar[row]) - value) / 1e-7 for e in np.eye(3)]
            step = np.linalg.lstsq(np.stack(columns, axis=1), value)[0]
            x = x - step
            if np.abs(step).max() < 1e-12:
                break
    return (time.perf_counter() - start) / len(rows)


if __name__ == "__main__":
    main()
