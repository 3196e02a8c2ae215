"""Time an orbit of a branch takes, with stability, admissibility and voltages, and how it grows with their number.

    python benchmarks/branch.py

Processor times, of orbits in blocks that the processor's cache holds, as a map computes them. The least time is that of
the sines, powers and other functions that an orbit needs where the ball never turns back in a flight, and of writing
its numbers to memory.

The peer solves the same orbits as scripts in this field do: Newton's method on (3.15)-(3.17) from the neighbouring
orbit, one at a time.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from pathlib import Path

import numpy as np
from record import processor_time, record

from vireport import analyse, load
from vireport.motions.one_to_one import motions_of
from vireport.physics.energy import voltages

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
SIZES = (10_000, 100_000, 1_000_000)
BLOCK = 8192

FUNCTIONS = {
    np.sin: 8,  # of q, of the phase, of half the parameter, of the phases of slowest flight; with the cosines
    np.arctan2: 3,
    np.arccos: 3,
    np.hypot: 1,
    np.mod: 6,
    np.power: 3,  # of (5.5)
    np.sqrt: 2,
}
"""Functions of which an orbit needs so many."""

NUMBERS = 18
"""Numbers that are kept of an orbit: fields of `Motions`, and voltages."""


def longest_part(w: np.ndarray, valid: np.ndarray) -> tuple[float, float]:
    """Ends of the longest range of parameters in which all orbits are motions."""
    edges = np.flatnonzero(np.diff([False, *valid, False])).reshape(-1, 2)
    first, end = max(edges, key=lambda edge: w[edge[1] - 1] - w[edge[0]])
    return w[first], w[end - 1]


def least_time() -> dict[str, float]:
    """Time of the functions that an orbit needs, and of writing its numbers [us]."""
    x, size = np.linspace(0.1, 0.9, BLOCK), 100 * BLOCK
    functions = 0.0
    for function, count in FUNCTIONS.items():
        arguments = (x, x) if function.nin == 2 else (x,)
        taken, _ = processor_time(lambda f=function, a=arguments: [f(*a) for _ in range(100)], 5)
        functions += count * taken / size
    written, _ = processor_time(lambda: [np.concatenate([x] * 100) for _ in range(NUMBERS)], 5)
    return {"functions_us": 1e6 * functions, "memory_us": 1e6 * written / size}


def main() -> None:
    """Print and record the table."""
    orbits, newton = [], []
    for name in ("horizontal", "inclined", "inclined-forcing"):
        study = analyse(load(EXAMPLES / f"{name}.yaml"))
        curve = study.solution.diagram.curve
        samples = curve.sampled()
        valid = samples.validity > 0
        strand = np.bincount(samples.which[valid]).argmax()
        on_strand = samples.which == strand
        ends = longest_part(samples.w[on_strand], valid[on_strand])
        for size in SIZES:
            blocks = np.array_split(np.linspace(*ends, size), -(-size // BLOCK))

            def evaluate(blocks=blocks, strand=strand, study=study, curve=curve) -> None:
                for w in blocks:
                    motions = motions_of(curve.sweep, curve.at(strand, w))
                    unit = study.solution.device.velocity_unit(curve.sweep.parameter, motions.sweep_value)
                    voltages(unit * motions.velocity_bottom, unit * motions.velocity_top, study.solution.membrane)

            seconds, _ = processor_time(evaluate)
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
    record("branch", orbits=orbits, newton=newton, ratios=ratios, exponents=exponents(orbits), **least_time())


def exponents(orbits: list[dict]) -> list[float]:
    """Power of the number of orbits with which the time of each scenario grows."""
    by_name: dict[str, list[dict]] = {}
    for row in orbits:
        by_name.setdefault(row["scenario"], []).append(row)
    ends = [(rows[0], rows[-1]) for rows in by_name.values()]
    return [
        1 + np.log(last["us_per_orbit"] / first["us_per_orbit"]) / np.log(last["orbits"] / first["orbits"])
        for first, last in ends
    ]


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
    start = time.process_time()
    for row in rows:
        for _ in range(30):
            value = residual(x, branch.d[row], branch.gbar[row])
            columns = [(residual(x + 1e-7 * e, branch.d[row], branch.gbar[row]) - value) / 1e-7 for e in np.eye(3)]
            step = np.linalg.lstsq(np.stack(columns, axis=1), value)[0]
            x = x - step
            if np.abs(step).max() < 1e-12:
                break
    return (time.process_time() - start) / len(rows)


if __name__ == "__main__":
    main()
