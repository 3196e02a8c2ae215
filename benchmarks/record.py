"""Keeps what a benchmark measured, with machine and date, in `benchmarks/results`: the figures of docs/accuracy.md."""

from __future__ import annotations

import json
import os
import statistics
import time
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

from vireport.base.records import plain
from vireport.base.timing import machine

RESULTS = Path(__file__).resolve().parent / "results"
LOAD = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
"""Of the machine when the benchmark begins: what runs beside it disturbs the times, and the ratios less."""


def processor_time(function: Callable[[], Any], repeats: int = 3) -> tuple[float, Any]:
    """Median processor time of a call, and what it returns."""
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        result = function()
        times.append(time.process_time() - begin)
    return statistics.median(times), result


def record(name: str, **measured: Any) -> None:
    """Write `benchmarks/results/<name>.json`."""
    here = plain(machine())
    here["libraries"] = dict(here["libraries"])
    content = {"date": date.today().isoformat(), "machine": here, "load": LOAD, **measured}
    text = json.dumps(content, indent=1, allow_nan=False) + "\n"
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / f"{name}.json").write_text(text, encoding="utf-8")
