"""Error against run time of every method on the inclined example, and by what factors they differ at equal error.

    python benchmarks/accuracy.py [--every] [--picture]

With ``--every`` each run stands in a row; with ``--picture`` the work-precision diagram is drawn for the README. The
peers, Runge-Kutta with fixed steps and the solvers of SciPy, run in the same process and by turns.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
from pathlib import Path

from vireport import analyse, load
from vireport.figures.accuracy import NAME, figure_accuracy
from vireport.figures.axes import style
from vireport.figures.pixels import png_of
from vireport.text import plain_text
from vireport.trust import measure, measurements, ranking

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def main() -> None:
    """Print the study; draw the picture where it is asked for."""
    study = analyse(load(EXAMPLES / "inclined.yaml"))
    work = measure(study.solution, progress=lambda step: print(step, file=sys.stderr))
    print(plain_text((*measurements(work, every="--every" in sys.argv), *ranking(work))))
    if "--picture" in sys.argv:
        with style():
            data = png_of(figure_accuracy(work))[0]
        (EXAMPLES / "pictures" / f"inclined-{NAME}.png").write_bytes(data)


if __name__ == "__main__":
    main()
