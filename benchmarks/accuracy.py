"""What `vireport verify` measures on the inclined example: error against run time, and compliant membranes.

    python benchmarks/accuracy.py [--every]

With ``--every`` each run stands in a row. The peers, Runge-Kutta with fixed steps and the solvers of SciPy, run in the
same process and by turns. The picture of the documentation is drawn from the same measurement.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
from pathlib import Path
from typing import Any

from record import record

from vireport import load
from vireport.findings.accuracy.methods import METHOD_NAMES, WHOLE
from vireport.findings.accuracy.workprecision import ACCURACIES
from vireport.findings.membranes.compliance import Compliance
from vireport.findings.membranes.solvers import FIXED, STEPS, RunOutcome
from vireport.verify.outputs import files, measured_study, text, with_accuracy_block

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def compliant(comparison: Compliance) -> dict[str, Any]:
    """What docs/accuracy.md says of compliant membranes: shifts with the scenario's own, the rate, what survives."""
    own, runs = comparison.rungs[0], comparison.runs
    coarse = [
        run.factor
        for run in runs
        if (run.solver, run.setting) == (FIXED, STEPS[0]) and run.outcome is RunOutcome.OVERFLOW
    ]
    explicit = [run.factor for run in runs if run.solver in ("RK45", "DOP853") and run.outcome is RunOutcome.SOLVED]
    return {
        "contact_percent": [50 * touch.duration for touch in (own.orbit.top, own.orbit.bottom)],
        "shift_percent": {criterion.name: 100 * abs(criterion.shift) for criterion in comparison.criteria},
        "critical_value": own.critical_value,
        "exponent": comparison.convergence[0].exponent,
        "order": comparison.order,
        "overflow_from": min(coarse),
        "survived_to": max(explicit),
    }


def main() -> None:
    """Print, draw and record the study."""
    study = measured_study(
        with_accuracy_block(load(EXAMPLES / "inclined.yaml")), lambda step: print(step, file=sys.stderr)
    )
    print(text(study, every="--every" in sys.argv))
    columns = [(task, accuracy) for task in study.findings["checks"].tasks for accuracy in ACCURACIES]
    best = {name: [study.findings["checks"].best(name, *column) for column in columns] for name in METHOD_NAMES}
    microseconds = {name: [run and 1e6 * run.seconds.median for run in runs] for name, runs in best.items()}
    record(
        "accuracy",
        columns=columns,
        without_guess_us=microseconds.pop(WHOLE),
        us=microseconds,
        compliant=compliant(study.findings["membranes"]),
    )
    picture = EXAMPLES / "pictures" / "inclined-figure-accuracy.png"
    picture.write_bytes(files(study)["figure-accuracy.png"])


if __name__ == "__main__":
    main()
