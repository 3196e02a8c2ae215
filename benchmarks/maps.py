"""Cells per second of a map over inclination and length, its memory, and whether both stay as the map grows.

The map of `examples/maps/map.yaml` with more cells, on all cores and on one; the time is that of the whole run, from
the file to the finished Parquet file without pictures. Memory is that of the process and its workers together.

    python benchmarks/maps.py
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does

import sys
import tempfile
import threading
import time
from pathlib import Path
from statistics import median

from record import record

from vireport.map.cells.cells import map_plan
from vireport.map.cells.evaluation import evaluate
from vireport.map.cells.run import cores, run_map
from vireport.scenario.loading import loads_map

EXAMPLE = Path(__file__).parent.parent / "examples" / "maps" / "map.yaml"
COUNTS = {10_000: (100, 100), 100_000: (250, 400), 1_000_000: (1000, 1000)}
GOAL = 200_000


def text_of(shape: tuple[int, int]) -> str:
    text = EXAMPLE.read_text(encoding="utf-8")
    return text.replace("count: 60", f"count: {shape[0]}").replace("count: 80", f"count: {shape[1]}")


def family(pid: int) -> list[int]:
    """A process and all that descend from it."""
    members = [pid]
    try:
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                members += family(int(child))
    except OSError:
        pass
    return members


def resident(pid: int) -> int:
    """Bytes of memory of a process, what it shares with others counted in parts."""
    for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
        if line.startswith("Pss:"):
            return 1024 * int(line.split()[1])
    return 0


class Watch(threading.Thread):
    """Samples the memory of this process and its workers until it is stopped."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.peak, self.done = 0, threading.Event()

    def run(self) -> None:
        """Sample until told to stop."""
        while not self.done.wait(0.1):
            self.sample()

    def sample(self) -> None:
        """Look once."""
        memory = 0
        for pid in family(os.getpid()):
            try:
                memory += resident(pid)
            except OSError:
                continue
        self.peak = max(self.peak, memory)


def measured(shape: tuple[int, int], workers: int) -> tuple[float, int, int]:
    """Seconds of a run, its peak memory, and the size of its result."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "map.yaml"
        path.write_text(text_of(shape), encoding="utf-8")
        watch = Watch()
        watch.start()
        began = time.perf_counter()
        run_map(str(path), Path(name) / "out", workers=workers, draw=False)
        took = time.perf_counter() - began
        watch.done.set()
        watch.join()
        watch.sample()
        return took, watch.peak, (Path(name) / "out" / "map.parquet").stat().st_size


def used(text: str) -> float:
    """Processor time of a whole run on one core, with nothing watching [s]."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "map.yaml"
        path.write_text(text, encoding="utf-8")
        began = time.process_time()
        run_map(str(path), Path(name) / "out", workers=1, draw=False)
        return time.process_time() - began


def overheads(shape: tuple[int, int], repeats: int = 3) -> tuple[float, float]:
    """Overhead of splitting into chunks, against chunks of 250,000 cells, and of all that is not the cells themselves.

    Each is taken in turns with what it is compared with, so that both see the same machine.
    """
    text, plan = text_of(shape), map_plan(loads_map(text_of(shape)))
    chunking, beside = [], []
    for _ in range(repeats):
        whole, coarse = used(text), used(f"{text.rstrip()}\n  chunk_cells: 250000\n")
        began = time.process_time()
        for index in range(plan.chunks):
            evaluate(plan, plan.numbers(index))
        chunking.append(whole / coarse - 1)
        beside.append(1 - (time.process_time() - began) / whole)
    return median(chunking), median(beside)


def main() -> None:
    rows = []
    chunking, beside = overheads(COUNTS[1_000_000])
    print(f"1,000,000 cells on one core: splitting into chunks costs {100 * chunking:.1f} %,")
    print(f"all that is not the cells themselves (reading, writing twice, merging) {100 * beside:.1f} %\n")
    print("     cells  workers       s    cells/s  peak memory     result")
    for workers in dict.fromkeys((1, cores())):
        first: tuple[int, float] | None = None
        for count, shape in COUNTS.items():
            took, peak, size = measured(shape, workers)
            print(
                f"{count:10,d}{workers:9d}{took:8.2f}{count / took:11,.0f}{peak / 1e6:10,.0f} MB{size / 1e6:8.1f} MB",
                flush=True,
            )
            if first is not None and count == 1_000_000:
                rate = (count - first[0]) / (took - first[1])
                print(f"{'':27s}{rate:9,.0f}  from {first[0]:,} cells on{f' (goal: {GOAL:,})' if workers > 1 else ''}")
            first = first or (count, took)
            sizes = {"peak_mb": peak / 1e6, "result_mb": size / 1e6}
            rows.append({"workers": workers, "cells": count, "seconds": took, "per_second": count / took, **sizes})
    record("maps", chunking_percent=100 * chunking, beside_percent=100 * beside, rows=rows)


if __name__ == "__main__":
    sys.exit(main())
