"""How long a run takes against the floor that its imports and its drawing set, measured in turn in one run.

    python benchmarks/startup.py [RUNS]

Each line is the median of the ratios of neighbouring runs, with the medians of both, after one of each that compiles
modules and templates for those that follow. A run with --json is to take at most 2.2 times its floor, a report 1.6
times. The floors are processes that do nothing of ours:

- command: imports numpy, yaml, typer and pydantic, and runs a command that does nothing: only then do the last two
import what they are made of;
- report: imports what a report needs, draws as many empty panels in as many figures of the same sizes, saved as SVG and
those of the sweep as PNG, too, and compiles an empty page to PDF and to HTML: what a report is made of.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from record import record

ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
"""In which Python keeps what it compiles, as where a package is installed."""

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"

SWEEP, PAGES = ((3, 5.27), (2, 5.8), (1, 4.4)), ((1, 2.9), (2, 3.3), (1, 2.04))
"""Panels and height [in] of each figure that a report of the examples has: those of the sweep, and the others."""

COMMAND = """
import numpy, yaml, typer
from pydantic import BaseModel
app = typer.Typer(rich_markup_mode=None)
@app.command()
def command(name: str) -> None: ...
app(["name"], standalone_mode=False)
"""

REPORT = f"""{COMMAND}
import io, jinja2, typst
from matplotlib.figure import Figure
from matplotlib.backends.backend_agg import FigureCanvasAgg
for figures, suffixes in (({SWEEP}, ("png", "svg")), ({PAGES}, ("svg",))):
    for panels, height in figures:
        figure = Figure(figsize=(6.7, height))
        FigureCanvasAgg(figure)
        for i in range(panels):
            figure.add_subplot(panels, 1, i + 1)
        for suffix in suffixes:
            figure.savefig(io.BytesIO(), dpi=150, format=suffix)
for suffix in ("pdf", "html"):
    typst.Compiler(b"empty").compile(format=suffix)
"""


def seconds(command: list[str]) -> float:
    """Wall time of a process."""
    start = time.perf_counter()
    subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True, env=ENVIRONMENT)
    return time.perf_counter() - start


def compare(name: str, floor: str, command: list[str], runs: int) -> dict[str, str | float]:
    """Time a command and its floor in turn; their medians [ms] and the median of their ratios."""
    pairs = []
    for _ in range(runs + 1):
        pairs.append((seconds([sys.executable, "-c", floor]), seconds(command)))
    floors, ours = zip(*pairs[1:], strict=True)
    ratio = statistics.median(b / a for a, b in pairs[1:])
    took, floor_took = (1e3 * statistics.median(times) for times in (ours, floors))
    print(f"{name:<28} {took:7.0f} ms   floor {floor_took:6.0f} ms   ratio {ratio:.2f}", flush=True)
    return {"what": name, "ms": took, "floor_ms": floor_took, "ratio": ratio}


def main() -> None:
    """Print and record the table."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    vireport = [str(Path(sys.executable).with_name("vireport"))]
    files = {name: str(EXAMPLES / f"{name}.yaml") for name in ("horizontal", "inclined", "inclined-forcing")}
    for option in ("--version", "--help"):
        compare(option, COMMAND, [*vireport, option], runs)
    results = [
        compare(f"{name} --json", COMMAND, [*vireport, "run", file, "--json"], runs) for name, file in files.items()
    ]
    with tempfile.TemporaryDirectory() as folder:
        reports = [
            compare(f"{name}, full report", REPORT, [*vireport, file, "-o", folder], runs)
            for name, file in files.items()
        ]
    record("startup", runs=runs, results=results, reports=reports)


if __name__ == "__main__":
    main()
