"""Time that a call takes, with its spread, and the machine it was taken on."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from math import ceil
from pathlib import Path
from timeit import Timer

import numpy as np

from vireport.base.records import ResultsBlock

SAMPLE, MOST_CALLS = 2e-3, 100
"""A call shorter than this [s] is timed as one of several in a row, and of how many at the most."""

LONG, FEW = 0.04, 3
"""A call longer than this [s] is timed so many times at the most: no warming up shows in it."""

LONGEST = 0.5
"""A call longer than this [s] is timed once."""

SHORT, MORE = 3e-3, 5
"""A call shorter than this [s] is sampled so many times as often: it costs little, and a busy machine disturbs it."""

COMPUTING = ("numpy", "scipy", "numba", "mpmath")
"""Packages that the times depend on."""


class Spread(ResultsBlock, frozen=True, eq=True):
    """Median and quartiles of the time that one call takes.

    Attributes
    ----------
    median, low, high : s
        median, and quartiles
    """

    median: float
    low: float
    high: float


class Machine(ResultsBlock, frozen=True):
    """The machine of a measurement.

    Attributes
    ----------
    processor, cores, system, python
        its processor, number of cores, system, and version of Python
    libraries
        names and versions of the packages that the times depend on
    """

    processor: str
    cores: int
    system: str
    python: str
    libraries: tuple[tuple[str, str], ...]


def timed_in_turns(
    calls: Sequence[Callable[[], object]], repeats: int, progress: Callable[[int], object] | None = None
) -> list[Spread]:
    """Time that each call takes, without collection of garbage.

    One sample of each is taken before the next of any, so that a slow minute of the machine falls on all alike.

    Parameters
    ----------
    calls : sequence of callable
        Called before, so that what is loaded or compiled at a first call is not timed.
    repeats : int
        Samples of each, at least one; fewer of long ones (`LONG`, `LONGEST`), more of short ones (`SHORT`).
    progress : callable, optional
        Called with the number of each round as it begins.
    """
    timers = [Timer(call) for call in calls]
    first = [timer.timeit(1) for timer in timers]
    counts = [min(MOST_CALLS, max(1, ceil(SAMPLE / max(t, 1e-6)))) for t in first]
    rounds = [repeats if t < LONG else 0 if t > LONGEST else min(repeats, FEW) - 1 for t in first]
    times = [[t] if t >= LONG else [] for t in first]
    for k in range(repeats):
        if progress is not None:
            progress(k + 1)
        for i, (timer, count) in enumerate(zip(timers, counts, strict=True)):
            if k < rounds[i]:
                times[i] += [timer.timeit(count) / count for _ in range(MORE if first[i] < SHORT else 1)]
    return [_spread(taken) for taken in times]


def _spread(times: list[float]) -> Spread:
    low, median, high = np.percentile(times, [25, 50, 75])
    return Spread(float(median), float(low), float(high))


def machine() -> Machine:
    """Describe the machine, without its name."""
    versions = [(name, _version(name)) for name in COMPUTING]
    return Machine(
        _processor(),
        os.cpu_count() or 1,
        f"{platform.system()} {platform.machine()}",
        f"{platform.python_implementation()} {platform.python_version()}",
        tuple((name, number) for name, number in versions if number),
    )


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def _processor() -> str:
    """Model of the processor; Linux tells it in a file."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(models, "") or platform.processor() or platform.machine()
