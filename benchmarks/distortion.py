"""What it costs to say which distortion of the force a design stands.

    python benchmarks/distortion.py

The peer is sequential quadratic programming (SLSQP of SciPy) on the same equations: the least harmonic for which the
motion's four conditions and the trace at the event hold. It is told the event, begins at the motion without harmonics,
and finds a nearest point of that one border; whether another border is nearer it does not ask. Times are of the
processor, on one core, for both orders.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from pathlib import Path

import numpy as np
from record import processor_time, record
from scipy.optimize import minimize

from vireport import load
from vireport.design.distortion import distortions
from vireport.design.lines import stable_ones
from vireport.design.margins import margins_of
from vireport.design.solution import solution_of
from vireport.motions.events import TRACE_LEVELS
from vireport.motions.periodicity import linearised, residuals, trace
from vireport.physics.device import Device
from vireport.physics.forcing import Harmonic
from vireport.physics.groups import Groups
from vireport.scenario.parameters import Parameter
from vireport.study.study import sweep_of

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
NAMES = "inclined", "horizontal", "stiff-membrane"


class Plane:
    """Cosine and sine of one harmonic as what varies, see `motions.Varied`."""

    def __init__(self, groups: Groups[float], order: int) -> None:
        self.groups, self.order = groups, order

    def at(self, varied):
        """The groups with a cosine and a sine."""
        return self.groups._replace(harmonics=(Harmonic(self.order, *varied),))

    def slopes(self, varied):
        """Derivatives of their numbers by these."""
        return np.vstack([np.zeros((4, 2)), np.eye(2)])


def by_programming(device: Device, motion, order: int, event) -> float:
    """The least harmonic of an order at which an event occurs, by SLSQP; nan where it does not converge."""
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    plane, level = Plane(groups, order), TRACE_LEVELS[event](groups.decay(motion.word.walls))
    start = np.array([*motion.velocity, *motion.time, 1e-3, 1e-3])
    found = minimize(
        lambda x: x[4] ** 2 + x[5] ** 2,
        start,
        jac=lambda x: np.array([0, 0, 0, 0, 2 * x[4], 2 * x[5]]),
        method="SLSQP",
        constraints=[
            {
                "type": "eq",
                "fun": lambda x: np.array(residuals(motion.word, x, plane)),
                "jac": lambda x: linearised(motion.word, x, plane)[1],
            },
            {"type": "eq", "fun": lambda x: trace(motion.word, x, plane) - level},
        ],
        options={"ftol": 1e-14, "maxiter": 200},
    )
    return float(np.hypot(found.x[4], found.x[5])) if found.success else float("nan")


def main() -> None:
    """Print and record the table."""
    rows = []
    for name in NAMES:
        scenario = load(EXAMPLES / f"{name}.yaml").scenario
        solution = solution_of(Device.of(scenario), None, sweep_of(scenario), True)
        device, motions = solution.device, solution.design.motions
        device = device.with_values({solution.parameter: solution.design.value})
        nearest = solution.design.endings()[0]
        motion = stable_ones(device, motions)[0].motion
        margins_ms, _ = processor_time(lambda device=device, motions=motions: margins_of(device, motions), 9)
        ours, found = processor_time(
            lambda device=device, motions=motions, nearest=nearest: distortions(device, motions, nearest), 9
        )
        known = [each for each in found if each.share is not None]
        peer, shares = processor_time(
            lambda device=device, motion=motion, known=known: [
                by_programming(device, motion, each.order, each.event) for each in known
            ],
            9,
        )
        rows.append(
            {
                "scenario": name, "ms": 1e3 * ours, "margins_ms": 1e3 * margins_ms, "peer_ms": 1e3 * peer,
                "ratio": peer / ours, "percent": [None if x.share is None else 100 * x.share for x in found],
                "peer_percent": [100 * share for share in shares if np.isfinite(share)],
            }
        )  # fmt: skip
        pairs = zip(known, shares, strict=True)
        print(
            f"{name:<16} {1e3 * ours:5.1f} ms, margins {1e3 * margins_ms:5.1f} ms; SLSQP {1e3 * peer:5.1f} ms: "
            + ", ".join(f"{100 * share:.6g} against {100 * x.share:.6g} %" for x, share in pairs)
        )
    record("distortion", distortion=rows)


if __name__ == "__main__":
    main()
