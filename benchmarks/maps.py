"""Cells per second of a map over inclination and length, its memory, and whether both stay as the map grows.

The map of `examples/maps/map.yaml` with more cells, on all cores and on one; the time is that of the whole run, from
the file to the finished Parquet file without pictures. Memory and processor time are those of the process and its
workers together, sampled; the overhead is the share of processor time that does not go into the cells: starting
processes, and writing what is found twice, as chunks and as one file.

    python benchmarks/maps.py
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does

import sys
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path

from vireport.map_plan import map_plan
from vireport.map_run import cores, run_map
from vireport.map_scenario import loads_map
from vireport.mapping import evaluate_chunk

EXAMPLE = Path(__file__).parent.parent / "examples" / "maps" / "map.yaml"
COUNTS = {10_000: (100, 100), 100_000: (250, 400), 1_000_000: (1000, 1000)}
GOAL = 200_000


def text_of(shape: tuple[int, int]) -> str:
    text = EXAMPLE.read_text(encoding="utf-8")
    return text.replace("count: 60", f"count: {shape[0]}").replace("count: 80", f"count: {shape[1]}")


def family(pid: int) -> list[int]:
    """A process and all that descend from it."""
    found = [pid]
    try:
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                found += family(int(child))
    except OSError:
        pass
    return found


def resident(pid: int) -> int:
    """Bytes of memory of a process, what it shares with others counted in parts."""
    for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
        if line.startswith("Pss:"):
            return 1024 * int(line.split()[1])
    return 0


def processor(pid: int) -> float:
    """Seconds of processor time of a process."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Watch(threading.Thread):
    """Samples memory and processor time of this process and its workers until it is stopped."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.peak, self.done = 0, threading.Event()
        self.first, self.last = {os.getpid(): processor(os.getpid())}, {}

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
                self.last[pid] = processor(pid)
            except OSError:
                continue
        self.peak = max(self.peak, memory)

    @property
    def used(self) -> float:
        """Seconds of processor time since the start."""
        return sum(self.last.values()) - sum(self.first.values())


def measured(shape: tuple[int, int], workers: int) -> tuple[float, float, int, int]:
    """Seconds of a run, its processor time and peak memory, and the size of its result."""
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
        return took, watch.used, watch.peak, (Path(name) / "out" / "map.parquet").stat().st_size


def pure(chunks: int = 6) -> float:
    """Seconds of work for each cell on one core, without a file or another process."""
    plan = map_plan(loads_map(text_of(COUNTS[1_000_000])))
    evaluate_chunk(replace(plan, chunk_cells=1000), 0)
    took = []
    for k in range(chunks):
        began = time.process_time()
        evaluate_chunk(plan, k * plan.chunks // chunks)
        took.append(time.process_time() - began)
    return sum(took) / (chunks * plan.chunk_cells)


def main() -> None:
    each = pure()
    print(
        f"one core, the cells alone: {1 / each:,.0f} cells/s of processor time; load of this machine now: "
        f"{os.getloadavg()[0]:.1f} on {cores()} cores\n"
    )
    print("     cells  workers       s    cells/s  processor s  overhead   peak memory     result")
    for workers in dict.fromkeys((1, cores())):
        first: tuple[int, float] | None = None
        for count, shape in COUNTS.items():
            took, used, peak, size = measured(shape, workers)
            print(
                f"{count:10,d}{workers:9d}{took:8.2f}{count / took:11,.0f}{used:13.2f}"
                f"{100 * (1 - count * each / used):8.0f} %{peak / 1e6:11,.0f} MB{size / 1e6:8.1f} MB",
                flush=True,
            )
            if first is not None and count == 1_000_000:
                rate = (count - first[0]) / (took - first[1])
                print(f"{'':27s}{rate:9,.0f}  from {first[0]:,} cells on{f' (goal: {GOAL:,})' if workers > 1 else ''}")
            first = first or (count, took)


if __name__ == "__main__":
    sys.exit(main())
