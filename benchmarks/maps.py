"""Processor time of a map over inclination and length, its memory, and how both grow; on a cluster, too.

The map of `examples/maps/map.yaml` with more cells, from the file to the finished Parquet file without pictures: on one
core, on all of them, and on two workers of a local Dask cluster. All processes count. The busiest one is what the map
takes on idle cores, where no other program disturbs it. Memory is that of the process and its workers together.

    python benchmarks/maps.py
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does

import math
import tempfile
import threading
import time
from pathlib import Path

from distributed import LocalCluster
from record import record

from vireport.map.cells.cells import map_plan
from vireport.map.cells.evaluation import evaluate
from vireport.map.cells.run import cores, run_map
from vireport.scenario.loading import loads_map

EXAMPLE = Path(__file__).parent.parent / "examples" / "maps" / "map.yaml"
COUNTS = {10_000: (100, 100), 100_000: (250, 400), 1_000_000: (1000, 1000)}
TICK = os.sysconf("SC_CLK_TCK")


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


def processor_times() -> dict[int, float]:
    """Processor time of this process and of all that descend from it [s], with children that have ended."""
    times = {}
    for pid in family(os.getpid()):
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        times[pid] = sum(map(int, fields[11:13])) / TICK
    times[0] = sum(os.times()[2:4])
    return times


class Watch(threading.Thread):
    """Samples the memory of this process and its workers until it is stopped."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.peak, self.done = 0, threading.Event()

    def run(self) -> None:
        """Sample until told to stop, and then once more: a small map is done before the first sample."""
        stopped = False
        while not stopped:
            stopped, memory = self.done.wait(0.05), 0
            for pid in family(os.getpid()):
                try:
                    memory += resident(pid)
                except OSError:
                    continue
            self.peak = max(self.peak, memory)


def measured(shape: tuple[int, int], **how: object) -> dict[str, float]:
    """Processor and wall time of a run [s], its peak memory and the size of its result [MB]."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "map.yaml"
        path.write_text(text_of(shape), encoding="utf-8")
        watch = Watch()
        watch.start()
        before, began = processor_times(), time.perf_counter()
        run_map(str(path), Path(name) / "out", draw=False, **how)
        wall, after = time.perf_counter() - began, processor_times()
        watch.done.set()
        watch.join()
        used = [after[pid] - before.get(pid, 0.0) for pid in after]
        size = (Path(name) / "out" / "map.parquet").stat().st_size
    return {
        "cells": math.prod(shape),
        "seconds": sum(used),
        "busiest_seconds": max(used),
        "wall_seconds": wall,
        "peak_mb": watch.peak / 1e6,
        "result_mb": size / 1e6,
    }


def share_of_cells(shape: tuple[int, int], whole: float) -> float:
    """Share of the processor time of a run that the cells themselves take."""
    plan, began = map_plan(loads_map(text_of(shape))), time.process_time()
    for index in range(plan.chunks):
        evaluate(plan, plan.numbers(index))
    return (time.process_time() - began) / whole


def growth(rows: list[dict[str, float]], name: str) -> float:
    """Power of the number of cells with which a quantity grows between the last two maps."""
    first, last = rows[-2:]
    return math.log(last[name] / first[name]) / math.log(last["cells"] / first["cells"])


def main() -> None:
    measured((10, 10), workers=1)  # imports what the first map would
    print("                cells    CPU s  busiest s   wall s  peak memory     result")
    rows: dict[str, list[dict[str, float]]] = {}

    def take(name: str, **how: object) -> None:
        for shape in COUNTS.values():
            row = measured(shape, **how)
            rows.setdefault(name, []).append(row)
            print(
                f"{name:>8s} {row['cells']:12,d}{row['seconds']:9.2f}{row['busiest_seconds']:11.2f}"
                f"{row['wall_seconds']:9.2f}{row['peak_mb']:10,.0f} MB{row['result_mb']:8.1f} MB",
                flush=True,
            )

    take("one", workers=1)
    take("cores", workers=cores())
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as cluster:
        take("cluster", scheduler=cluster.scheduler_address)
    one, all_cores, dask = (rows[name] for name in ("one", "cores", "cluster"))
    # What a cluster takes for a small map is what it takes to begin; the rest is by the cell.
    begins = dask[0]["busiest_seconds"] - one[0]["seconds"]
    by_cell = (dask[-1]["seconds"] - dask[0]["seconds"]) / (one[-1]["seconds"] - one[0]["seconds"])
    result = {
        "cores": cores(),
        "cores_ratio": all_cores[-1]["busiest_seconds"] / one[-1]["seconds"],
        "cluster_ratio": dask[-1]["seconds"] / one[-1]["seconds"],
        "cluster_begins_s": begins,
        "cluster_by_cell": by_cell,
        "exponent": growth(one, "seconds"),
        "memory_exponent": growth(one, "peak_mb"),
        "cells_share": share_of_cells(COUNTS[1_000_000], one[-1]["seconds"]),
    }
    print("\n".join(f"{name}: {value:.3g}" for name, value in result.items()))
    record("maps", **result, rows=rows)


if __name__ == "__main__":
    main()
