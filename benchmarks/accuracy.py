"""Error against run time of every method on the inclined example, and by what factors they differ at equal error.

    python benchmarks/accuracy.py [--every]

With ``--every`` each run stands in a row. The peers, Runge-Kutta with fixed steps and the solvers of SciPy, run in the
same process and by turns.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
from pathlib import Path

from vireport import analyse, load
from vireport.trust.accuracy_text import factor, plain, power, task_name
from vireport.trust.workprecision import ACCURACIES, measure

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def main() -> None:
    """Print the study and the factors at equal error."""
    study = analyse(load(EXAMPLES / "inclined.yaml"))
    work = measure(study.solution, progress=lambda step: print(step, file=sys.stderr))
    print(plain(work, every="--every" in sys.argv))
    print("Factors at equal error, the soonest method being 1")
    for accuracy in ACCURACIES:
        for one in work.fastest(accuracy):
            print(f"  {power(accuracy):>10}  {task_name(work, one.task)}")
            for name, times in ((one.method, 1.0), *one.factors):
                print(f"  {'':>10}    {name:<26}{factor(times):>8}")


if __name__ == "__main__":
    main()
