"""The tables of the accuracy study, for the report and for the terminal alike; the report's template has the words."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from math import isfinite

from vireport.checks.benchmark import MethodTask
from vireport.checks.methods import CLOSED, NAMES, WHOLE
from vireport.checks.timing import Spread
from vireport.checks.workprecision import (
    ACCURACIES,
    MethodRun,
    Order,
    WorkPrecision,
)
from vireport.text import (
    ABSENT,
    TIMES,
    Table,
    numbers,
    significant,
    texts,
)

NOT_TRIED = "not tried"

Row = tuple[str, ...]


def measurements(work: WorkPrecision, every: bool = False) -> Iterator[Table]:
    """The reference, and what each method reaches; with `every`, each run in a row."""
    if work.benchmark is None:
        return
    yield Table(
        "Quantities in 40-digit arithmetic, and the errors of the closed form",
        (*texts("Quantity"), *numbers("Reference", "Closed form", "Whole sweep, no guess")),
        tuple(_reference_rows(work)),
        "Errors are relative, and in rad for the phase.",
    )
    for task in work.tasks:
        if every:
            errors = (f"Error, {quantity.key}" for quantity in work.quantities if quantity.task == task)
            yield Table(
                f"Every run: {task_name(work, task)}",
                (*texts("Method"), *numbers("Setting", "Time", "Evaluations", *errors)),
                tuple(_run_rows(work, task)),
            )
        yield Table(
            f"Time to an accuracy: {task_name(work, task)}",
            (
                *texts("Method"),
                *numbers(*(f"to {power(a)}" for a in ACCURACIES), "Least error", "Evaluations", "Failed"),
            ),
            tuple(_summary_rows(work, task)),
            "Median and quartiles of the fastest run with no larger error of any quantity; a dash where there is none. "
            "Least error and evaluations are of the most accurate run. The whole sweep needs no guess, and finds "
            "everything.",
        )


def ranking(work: WorkPrecision) -> Iterator[Table]:
    """By what factors methods are slower than the fastest, fitted orders, and what failed."""
    if work.benchmark is None:
        return
    short = {task: task_name(work, task).removeprefix("the ").partition(" (")[0] for task in work.tasks}
    yield Table(
        "Times over that of the fastest method",
        (*texts("Method"), *numbers(*(f"{short[task]} to {power(a)}" for task in work.tasks for a in ACCURACIES))),
        tuple(_factor_rows(work)),
        "The fastest that starts from the guess is 1. A dash: the accuracy is not reached.",
    )
    if work.orders:
        yield Table(
            "Orders of convergence",
            (*texts("Method", "Of", "Against"), *numbers("Range", "Fitted", "Theory")),
            tuple(_order_row(work, order) for order in work.orders),
            "Least squares of the logarithms over the runs with an error below 3 % and above rounding. Against "
            "evaluations, the order is that of the method, as far as the interpolant on which SciPy finds the impact "
            "lets it be; coarse settings also take fewer Newton steps. LSODA varies its order.",
        )
    if failures := tuple(_failure_rows(work)):
        yield Table("Runs that failed", texts("Method", "Task", "Setting", "Reason"), failures)


def task_name(work: WorkPrecision, task: MethodTask) -> str:
    """What a task finds, in words."""
    if task is MethodTask.ORBIT:
        return "the motion"
    point = work.benchmark.point if work.benchmark is not None else None
    return f"{point.label} ({point.event.words})" if point is not None else "the critical point"


def power(value: float) -> str:
    """Print an error, an accuracy or a tolerance with two digits at the most: 1e-06 as 10⁻⁶."""
    return _bare(significant(float(f"{value:.1e}"), 2))


def seconds(spread: Spread | None) -> str:
    """Print a median with its quartiles, in the unit of the median: ``45.1 (44.9–45.3) µs``."""
    if spread is None:
        return ABSENT
    unit, scale = next((u, s) for u, s in (("s", 1.0), ("ms", 1e3), ("µs", 1e6)) if spread.median * s >= 1 or u == "µs")
    low, middle, high = (significant(x * scale, 3) for x in (spread.low, spread.median, spread.high))
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


def _reference_rows(work: WorkPrecision) -> Iterator[Row]:
    """The quantities: reference, and the errors of the closed form and of the whole sweep solved without a guess."""
    for quantity in work.quantities:
        errors = []
        for name in (CLOSED, WHOLE):
            reached = [run.errors[quantity.key] for run in work.runs_of(name, quantity.task) if run.errors]
            errors.append(power(reached[-1]) if reached else ABSENT)
        yield (_quantity_name(work, quantity.key), quantity.reference, *errors)


def _quantity_name(work: WorkPrecision, key: str) -> str:
    if key == "critical" and work.benchmark is not None and work.benchmark.point is not None:
        swept = work.benchmark.motion.sweep.parameter
        return f"{work.benchmark.point.label}, {swept.symbol} [{swept.unit}]"
    return {"velocity": "impact velocity Ż [y_c]", "phase": "phase φ [rad]", "voltage": "U_ave [V]"}[key]


def _summary_rows(work: WorkPrecision, task: MethodTask) -> Iterator[Row]:
    """For each method: time to each accuracy, smallest error, the evaluations for it, and runs that failed."""
    for name in NAMES:
        runs = work.runs_of(name, task)
        if not runs:
            continue
        best = [work.best(name, task, accuracy) for accuracy in ACCURACIES]
        cells = [seconds(run.seconds) if run is not None else ABSENT for run in best]
        good = [run for run in runs if not run.failed]
        least = min(good, key=lambda run: run.error, default=None)
        failed = f"{len(runs) - len(good)} of {len(runs)}" if len(good) < len(runs) else "none"
        yield (name, *cells, power(least.error) if least else ABSENT, _count(least), failed)


def _run_rows(work: WorkPrecision, task: MethodTask) -> Iterator[Row]:
    """Every run: method, setting, time, evaluations, and the errors or that it failed."""
    keys = [quantity.key for quantity in work.quantities if quantity.task == task]
    for run in work.runs:
        if run.task == task:
            errors = [power(run.errors[key]) for key in keys] if run.errors else ["failed"] + [""] * (len(keys) - 1)
            yield (run.method, _setting(run), seconds(run.seconds), _count(run), *errors)


def _count(run: MethodRun | None) -> str:
    return f"{run.evaluations:,}" if run is not None and run.evaluations else ABSENT


def _setting(run: MethodRun) -> str:
    return _bare(significant(run.setting, 3)) if run.knob else ABSENT


def _failure_rows(work: WorkPrecision) -> Iterator[Row]:
    """Runs that failed: method, what it was to find, settings and reason; settings that failed alike share a row."""
    failed = [run for run in work.runs if run.failed]
    for (name, task, reason), runs in groupby(failed, lambda run: (run.method, run.task, run.failed)):
        settings = [_setting(run) for run in runs]
        ends = settings[0] if len(settings) == 1 else f"{settings[0]} to {settings[-1]}"
        yield name, task_name(work, task), ends, reason
    for name, reason in work.absent:
        yield name, "everything", ABSENT, f"{NOT_TRIED}: {reason}"


def _order_row(work: WorkPrecision, order: Order) -> Row:
    against = {"step": "steps a period", "tolerance": "tolerance", "evaluations": "evaluations"}[order.against]
    low, high = (f"{x:,.0f}" if order.against != "tolerance" else power(x) for x in (order.first, order.last))
    ends = f"{low} to {high} ({order.points} runs)"
    theory = "–".join(significant(x, 2) for x in order.theory) or ABSENT
    return order.method, task_name(work, order.task), against, ends, significant(order.fitted, 3), theory


def _factor_rows(work: WorkPrecision) -> Iterator[Row]:
    """For each method, how many times the time of the fastest it takes."""
    fastest = {(task, accuracy): work.fastest(task, accuracy) for task in work.tasks for accuracy in ACCURACIES}
    for name in NAMES:
        cells = []
        for (task, accuracy), time in fastest.items():
            best = work.best(name, task, accuracy)
            reached = best is not None and best.seconds is not None and isfinite(time)
            cells.append(factor(best.seconds.median / time) if reached else ABSENT)  # type: ignore[union-attr]
            if not work.runs_of(name, task):
                cells[-1] = NOT_TRIED
        if set(cells) != {NOT_TRIED}:
            yield (name, *cells)
