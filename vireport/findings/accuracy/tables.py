"""The tables of the accuracy study, for the report and for the terminal, in the words of ``words/accuracy.j2``."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from vireport.base.timing import Spread
from vireport.findings.accuracy.benchmark import MethodTask
from vireport.findings.accuracy.methods import CLOSED, METHOD_NAMES, WHOLE
from vireport.findings.accuracy.workprecision import (
    ACCURACIES,
    MethodRun,
    Order,
    WorkPrecision,
)
from vireport.text.formatting import ABSENT, ROUGHLY, TIMES, exact, rounded_text
from vireport.text.tables import Table, worded_table

if TYPE_CHECKING:
    from vireport.text.templates import Words

Row = tuple[str, ...]


def measurements(work: WorkPrecision, every: bool = False, templates: Path | None = None) -> Iterator[Table]:
    """The reference, and what each method reaches.

    Parameters
    ----------
    work : WorkPrecision
    every : bool
        Whether each run has a row of its own, too.
    templates : Path, optional
        A folder whose ``words/accuracy.j2`` comes before the package's own.
    """
    if work.benchmark is None:
        return
    say = _words(templates)
    yield worded_table(say, "reference", "tnnn", _reference_rows(work, say), note=say("reference_note"))
    accuracies = [power(accuracy) for accuracy in ACCURACIES]
    for task in work.tasks:
        name = task_name(work, task, templates)
        if every:
            keys = [quantity.key for quantity in work.quantities if quantity.task == task]
            yield worded_table(say, "runs", f"tnnn{'n' * len(keys)}", _run_rows(work, task, say), name, keys)
        kinds, rows = f"t{'n' * len(accuracies)}nnn", _summary_rows(work, task, say)
        yield worded_table(say, "times", kinds, rows, name, accuracies, note=say("times_note"))


def ranking(work: WorkPrecision, templates: Path | None = None) -> Iterator[Table]:
    """Factors by which methods are slower than the fastest, fitted orders, and what failed.

    The folder of templates is that of `measurements`.
    """
    if work.benchmark is None:
        return
    say, point = _words(templates), work.benchmark.point
    tasks, accuracies = [say("short_task", task, point) for task in work.tasks], [power(a) for a in ACCURACIES]
    kinds, note = f"t{'n' * len(tasks) * len(accuracies)}", say("fastest_note")
    yield worded_table(say, "fastest", kinds, _factor_rows(work, say), tasks, accuracies, note=note)
    if work.orders:
        rows = (_order_row(work, order, say) for order in work.orders)
        yield worded_table(say, "orders", "tttnnn", rows, note=say("orders_note"))
    if failures := list(_failure_rows(work, say)):
        yield worded_table(say, "failed_runs", "tttt", failures)


def _words(templates: Path | None) -> Words:
    from vireport.text.templates import Words

    return Words("accuracy", templates)


def task_name(work: WorkPrecision, task: MethodTask, templates: Path | None = None) -> str:
    """What a task finds, in words."""
    return _task(work, task, _words(templates))


def _task(work: WorkPrecision, task: MethodTask, say: Words) -> str:
    return say("task", task, work.benchmark.point if work.benchmark is not None else None)


def power(value: float) -> str:
    """Print an error, an accuracy or a tolerance with two digits at the most: 1e-06 as 10⁻⁶."""
    return _bare(rounded_text(value, ROUGHLY))


def seconds(spread: Spread | None) -> str:
    """Print a median with its quartiles, in the unit of the median: ``45.1 (44.9–45.3) µs``."""
    if spread is None:
        return ABSENT
    unit, scale = next((u, s) for u, s in (("s", 1.0), ("ms", 1e3), ("µs", 1e6)) if spread.median * s >= 1 or u == "µs")
    low, middle, high = (rounded_text(x * scale) for x in (spread.low, spread.median, spread.high))
    return f"{middle} {unit}" if low == high == middle else f"{middle} ({low}–{high}) {unit}"


def factor(value: float) -> str:
    """Print how many times as long something takes; more than two digits would be noise."""
    rounded = float(f"{value:.2g}")
    if rounded < 1:
        return f"{rounded:g}"
    return f"{rounded:,.0f}" if rounded >= 10 or value == 1 else f"{rounded:.1f}"


def _bare(text: str) -> str:
    """A power of ten without the factor 1."""
    return text.removeprefix(f"1 {TIMES} ")


def _reference_rows(work: WorkPrecision, say: Words) -> Iterator[Row]:
    """The quantities: reference, and the errors of the closed form and of the whole sweep solved without a guess."""
    benchmark = work.benchmark
    point, swept = (None, None) if benchmark is None else (benchmark.point, benchmark.motion.sweep.parameter)
    for quantity in work.quantities:
        errors = []
        for name in (CLOSED, WHOLE):
            errors_by_run = [run.errors[quantity.key] for run in work.runs_of(name, quantity.task) if run.errors]
            errors.append(power(errors_by_run[-1]) if errors_by_run else ABSENT)
        yield (say("quantity", quantity.key, point, swept), quantity.reference, *errors)


def _summary_rows(work: WorkPrecision, task: MethodTask, say: Words) -> Iterator[Row]:
    """For each method: time to each accuracy, smallest error, the evaluations for it, and runs that failed."""
    for name in METHOD_NAMES:
        runs = work.runs_of(name, task)
        if not runs:
            continue
        best = [work.best(name, task, accuracy) for accuracy in ACCURACIES]
        cells = [seconds(run.seconds) if run is not None else ABSENT for run in best]
        good = [run for run in runs if not run.failed]
        least = min(good, key=lambda run: run.error, default=None)
        failed = say("failures", len(runs) - len(good), len(runs))
        yield (name, *cells, power(least.error) if least else ABSENT, _count(least), failed)


def _run_rows(work: WorkPrecision, task: MethodTask, say: Words) -> Iterator[Row]:
    """Every run: method, setting, time, evaluations, and the errors or that it failed."""
    keys = [quantity.key for quantity in work.quantities if quantity.task == task]
    for run in work.runs:
        if run.task == task:
            nothing = [say("failed"), *[""] * (len(keys) - 1)]
            errors = [power(run.errors[key]) for key in keys] if run.errors else nothing
            yield (run.method, _setting(run), seconds(run.seconds), _count(run), *errors)


def _count(run: MethodRun | None) -> str:
    return f"{run.evaluations:,}" if run is not None and run.evaluations else ABSENT


def _setting(run: MethodRun) -> str:
    return _bare(exact(run.setting)) if run.knob else ABSENT


def _failure_rows(work: WorkPrecision, say: Words) -> Iterator[Row]:
    """Runs that failed: method, what it was to find, settings and reason; settings that failed alike share a row."""
    failed = [run for run in work.runs if run.failed]
    for (name, task, reason), runs in groupby(failed, lambda run: (run.method, run.task, run.failed)):
        settings = [_setting(run) for run in runs]
        yield name, _task(work, task, say), say("settings", settings[0], settings[-1]), reason
    for untried in work.absent:
        yield untried.method, say("everything"), ABSENT, say("not_tried", untried.why)


def _order_row(work: WorkPrecision, order: Order, say: Words) -> Row:
    low, high = (f"{x:,.0f}" if order.against != "tolerance" else power(x) for x in (order.first, order.last))
    against, ends = say("against", order.against), say("fitted_over", low, high, order.points)
    theory = "–".join(exact(x) for x in order.theory) or ABSENT
    return order.method, _task(work, order.task, say), against, ends, rounded_text(order.fitted), theory


def _factor_rows(work: WorkPrecision, say: Words) -> Iterator[Row]:
    """For each method, how many times the time of the fastest it takes."""
    fastest = {(task, accuracy): work.fastest(task, accuracy) for task in work.tasks for accuracy in ACCURACIES}
    not_tried = say("not_tried")
    for name in METHOD_NAMES:
        cells = []
        for (task, accuracy), time in fastest.items():
            best = work.best(name, task, accuracy)
            timed = best is not None and best.seconds is not None and isfinite(time)
            cells.append(factor(best.seconds.median / time) if timed else ABSENT)  # type: ignore[union-attr]
            if not work.runs_of(name, task):
                cells[-1] = not_tried
        if set(cells) != {not_tried}:
            yield (name, *cells)
