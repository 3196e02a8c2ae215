"""What harmonics of the force cost: a motion of the surface, all motions at a design point, a sweep, and an impact.

    python benchmarks/harmonics.py

Forces are a sine, a sine with its second harmonic, and one with all up to the fifth. The peer is Newton's method on the
conditions of the raw flights from 200 random starts at the same design point: it claims nothing of what it misses.
Times are of the processor, on one core.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from math import pi
from pathlib import Path

import numpy as np
from msgspec.structs import replace
from record import processor_time, record

from vireport import load
from vireport.motions.diagram import solve
from vireport.motions.orbits import Dynamics, orbits_of
from vireport.motions.periodicity import linearised
from vireport.motions.pointwise import find_motions
from vireport.motions.sweep import Sweep
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups
from vireport.physics.word import Word
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import BOTTOM, Impact, check_model, check_start, follow_impacts

EXAMPLE = Path(__file__).resolve().parent.parent / "examples" / "inclined.yaml"
FORCES = {1: (), 2: (2,), 5: (2, 3, 4, 5)}
"""Highest order, and the orders of the harmonics."""

MANY, IMPACTS, STARTS = 100_000, 200_000, 200


class Fixed:
    """Groups that nothing varies."""

    def __init__(self, groups: Groups[float]) -> None:
        self.groups = groups

    def at(self, varied):
        """The groups."""
        return self.groups

    def slopes(self, varied):
        """No derivatives."""
        return np.zeros((len(self.groups.numbers), 0))


def by_newton(groups: Groups[float]) -> int:
    """Motions with impacts on the right sides that Newton's method finds from random starts."""
    rng, word, found = np.random.default_rng(1), Word((1, -1), 1), []
    for _ in range(STARTS):
        start = rng.uniform(0, 2)
        x = np.array([rng.uniform(0, 2), -rng.uniform(0, 2), start, start + rng.uniform(0, 2)])
        for _ in range(30):
            values, matrix = linearised(word, x, Fixed(groups))
            step = np.linalg.solve(matrix, values)
            x = x - step / max(1.0, 2 * float(np.abs(step).max()))
            if np.abs(step).max() < 1e-12:
                break
        place = np.array([x[0], x[1], np.mod(pi * x[2], 2 * pi), x[3] - x[2]])
        valid = np.abs(step).max() < 1e-12 and x[0] > 0 > x[1] and 0 < place[3] < 2
        if valid and all(np.abs(place - other).max() > 1e-6 for other in found):
            found.append(place)
    return len(found)


def main() -> None:
    """Print and record the table."""
    scenario, rows = load(EXAMPLE).scenario, []
    device, swept = Device.of(scenario), scenario.sweep
    rng = np.random.default_rng(0)
    u, phi = rng.uniform(-0.4, 0.4, MANY), rng.uniform(0, 2 * pi, MANY)
    for highest, orders in FORCES.items():
        force = tuple(Harmonic.of(order, 5.0 / order, 40.0 * order) for order in orders)
        own = replace(device, harmonics=force)
        groups = own.groups(Parameter.LENGTH, own.length_m)
        one = groups._replace(d=np.array([groups.d]), gbar=np.array([groups.gbar]))
        motion_s, _ = processor_time(lambda force=force: orbits_of(Dynamics(0.5, 1, force), u, phi), 5)
        point_s, found = processor_time(lambda one=one: find_motions(one, 1), 5)
        sweep_s, _ = processor_time(lambda own=own: solve(Sweep(own, swept.parameter, swept.from_, swept.to)))
        model, start = (
            check_model(groups.as_floats()),
            np.array([check_start(Impact(BOTTOM, 1.0, 0.5), float(groups.d))]),
        )
        follow_impacts(model, start, 10)
        impact_s, _ = processor_time(lambda model=model, start=start: follow_impacts(model, start, IMPACTS, 2))
        peer_s, peers = processor_time(lambda groups=groups: by_newton(groups.as_floats()), 1)
        row = {"order": highest, "motion_us": 1e6 * motion_s / MANY, "point_ms": 1e3 * point_s}
        row |= {"sweep_ms": 1e3 * sweep_s, "impacts_per_s": IMPACTS / impact_s, "found": len(found.cell)}
        rows.append(row | {"peer_found": peers, "peer_ms": 1e3 * peer_s, "ratio": peer_s / point_s})
        print(
            f"order {highest}: {row['motion_us']:.2f} us a motion, {row['point_ms']:.1f} ms for the {row['found']} of "
            f"a point, {row['sweep_ms']:.0f} ms a sweep, {row['impacts_per_s']:.3g} impacts/s; "
            f"Newton {1e3 * peer_s:.0f} ms, {peers}"
        )
    record("harmonics", harmonics=rows)


if __name__ == "__main__":
    main()
