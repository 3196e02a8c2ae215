"""Error against run time: every method on this scenario's own motion and critical point, against 40 digits.

A table of runs, one for each method, setting and task, judged by one function. All methods start from one guess, wrong
in the second or third digit. Errors and counts are the same in every run of the study; times are not.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec
from math import inf, log10
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import NumericalError, install_command
from vireport.base.progress import Progress, WorkStep, counted, portion
from vireport.base.records import ResultsBlock, brief
from vireport.base.timing import (
    Machine,
    Spread,
    machine,
    timed_in_turns,
)
from vireport.findings.accuracy.benchmark import (
    Benchmark,
    BenchmarkProblem,
    MeasuredQuantity,
    MethodTask,
    SolvedMotion,
    benchmark_of,
)
from vireport.findings.accuracy.flights import Budget
from vireport.findings.accuracy.methods import (
    CLOSED,
    METHODS,
    WHOLE,
    Knob,
    Method,
)
from vireport.text.formatting import ROUGHLY, rounded_text

if TYPE_CHECKING:
    from vireport.design.solution import Solution

ACCURACIES = (1e-6, 1e-9, 1e-12)
"""Errors at which the methods are ranked."""

WRONG = 0.1
"""Error from which a method has found something else than what was asked for: far more than the guess is off."""

ELSEWHERE = 1e-6
"""A third of the least error from which a run has found something else, where its setting alone limits the error."""

ASYMPTOTIC = 0.03
"""Error above which a run is left out of a fitted order."""

FLOOR = 1e-13
"""Error below which rounding is seen, and a run is left out of a fitted order."""

SAME_LEAGUE = 3.0
"""Factor over the time of the closed form within which a method is said to be as fast."""

LEAST_POINTS = 3
"""Fewest points that an order of convergence is fitted to."""

BUSY = 0.2
"""Distance of the quartiles of a time over its median, in half of all, from which the machine did something else: on an
idle one it is some per cent."""

SOLVING_SHARE = 0.6
"""Share of the time that solving takes, as measured; timing the solutions takes the rest."""

FAILURES = (NumericalError, ArithmeticError, ValueError, Warning)
"""What a method that fails raises; warnings of the integrators count as failures."""


class MethodRun(ResultsBlock, frozen=True):
    """One method with one setting on one task.

    Attributes
    ----------
    method
        its name
    knob, setting
        what was set, `stop`, `change`, `steps` or `rtol`, empty where nothing was, and its value
    task
        as of a quantity
    errors
        by the `key` of the quantity; empty where it failed
    seconds
        of one solution, or once until it failed; null where it was not tried
    evaluations
        of the force, or of a formula with a sine and a cosine; 0 where they are not counted
    failed
        the reason; empty where it did not fail
    """

    method: str
    knob: Knob
    setting: float
    task: MethodTask
    errors: dict[str, float]
    seconds: Spread | None
    evaluations: int
    failed: str = ""

    @property
    def error(self) -> float:
        """The largest error of the task's quantities; infinite where it failed."""
        return max(self.errors.values(), default=inf)


class Order(ResultsBlock, frozen=True):
    """A fitted order of convergence beside the theoretical one.

    Attributes
    ----------
    method, task
        of the runs
    against
        `step`, `tolerance` or `evaluations`: error ~ step^order, tolerance^order, evaluations^(−order)
    fitted, theory
        the orders; of theory, a list
    first, last
        ends of the range that was fitted, coarse to fine: steps a period, tolerances or numbers of evaluations
    points
        number of runs in it
    """

    method: str
    task: MethodTask
    against: str
    fitted: float
    theory: tuple[float, ...]
    first: float
    last: float
    points: int


class UntriedMethod(ResultsBlock, frozen=True):
    """A method that could not be tried.

    Attributes
    ----------
    method, why
        its name, and why
    """

    method: str
    why: str


class WorkPrecision(Struct, frozen=True, eq=False):
    """The study of one scenario.

    Attributes
    ----------
    nothing : str
        Why nothing can be compared, or "".
    benchmark : Benchmark or None
        The targets and the exact answers; None where nothing can be compared.
    absent : tuple of UntriedMethod
    repeats : int
        Samples of each time.
    """

    nothing: str
    benchmark: Benchmark | None
    runs: tuple[MethodRun, ...]
    orders: tuple[Order, ...]
    absent: tuple[UntriedMethod, ...]
    machine: Machine
    repeats: int

    __repr__ = brief

    @property
    def unsteadiness(self) -> float | None:
        """Distance of the quartiles of a time over its median: that of the middle run; None where none was repeated."""
        times = [run.seconds for run in self.runs if run.seconds is not None]
        shares = [(repeats.high - repeats.low) / repeats.median for repeats in times if repeats.high > repeats.low]
        return median(shares) if shares else None

    @property
    def busy(self) -> bool:
        """Whether the machine did something else while times were taken."""
        return (self.unsteadiness or 0.0) > BUSY

    @property
    def quantities(self) -> tuple[MeasuredQuantity, ...]:
        """The quantities that the methods had to find."""
        return self.benchmark.quantities if self.benchmark is not None else ()

    @property
    def tasks(self) -> tuple[MethodTask, ...]:
        """The motion and, where there is one, the critical point."""
        return tuple(dict.fromkeys(quantity.task for quantity in self.quantities))

    def runs_of(self, method: str, task: MethodTask) -> tuple[MethodRun, ...]:
        """The runs of a method on a task, from coarse to fine."""
        return tuple(run for run in self.runs if (run.method, run.task) == (method, task))

    def best(self, method: str, task: MethodTask, accuracy: float) -> MethodRun | None:
        """The fastest run of a method on a task that is as accurate as that."""
        good = (run for run in self.runs_of(method, task) if run.error <= accuracy)
        return min(good, key=lambda run: run.seconds.median if run.seconds else inf, default=None)

    def as_fast(self) -> list[str]:
        """Methods that reach the finest accuracy of the last task about as fast as the closed form, from a guess."""
        task, finest = self.tasks[-1], ACCURACIES[-1]
        closed = self.best(CLOSED, task, finest)
        if closed is None or closed.seconds is None:
            return []
        others = (name for name in dict.fromkeys(run.method for run in self.runs) if name not in (CLOSED, WHOLE))
        best = {name: self.best(name, task, finest) for name in others}
        limit = SAME_LEAGUE * closed.seconds.median
        return [name for name, run in best.items() if run and run.seconds and run.seconds.median <= limit]

    def without_guess(self) -> MethodRun | None:
        """The solution of the whole sweep, on the last task."""
        return self.best(WHOLE, self.tasks[-1], ACCURACIES[0])

    def fastest(self, task: MethodTask, accuracy: float) -> float:
        """The shortest median time [s] in which a method reaches an accuracy from the guess, infinite where none does.

        The solution of the whole sweep needs no guess and answers more; it does not count.
        """
        tried = dict.fromkeys(run.method for run in self.runs if run.method != WHOLE)
        best = (self.best(name, task, accuracy) for name in tried)
        return min((run.seconds.median for run in best if run and run.seconds), default=inf)


def measure(solution: Solution, repeats: int = 5, progress: Progress | None = None) -> WorkPrecision:
    """Measure error and run time of every method on a scenario.

    Parameters
    ----------
    solution : Solution
    repeats : int
        Samples of each time, at least 1.
    progress : callable, optional
        Called with each method as it begins.

    Raises
    ------
    NumericalError
        If the reference cannot be computed.
    """
    benchmark = benchmark_of(solution)
    if benchmark is None:
        reason = "there is no stable admissible 1:1 motion to measure on"
        return WorkPrecision(reason, None, (), (), (), machine(), repeats)
    return compare(benchmark, METHODS, repeats, progress)


def compare(
    benchmark: Benchmark, methods: Iterable[Method], repeats: int, progress: Progress | None = None
) -> WorkPrecision:
    """Measure error and run time of some methods on a benchmark."""
    trials: list[tuple[MethodRun, Callable[[], SolvedMotion | float] | None]] = []
    orders: list[Order] = []
    absent: list[UntriedMethod] = []
    every, say = list(methods), progress or (lambda what: None)
    solving, timing = portion(say, 0.0, SOLVING_SHARE), portion(say, SOLVING_SHARE, 1.0)
    for k, method in enumerate(every):
        if method.needs and find_spec(method.needs) is None:
            why = f"needs the package {method.needs}: {install_command(method.needs)}"
            absent.append(UntriedMethod(method.name, why))
            continue
        solving(WorkStep(f"accuracy: {method.name}", k / len(every)))
        tasks = (
            (MethodTask.ORBIT, benchmark.motion, method.motion),
            (MethodTask.CRITICAL, benchmark.critical, method.critical),
        )
        for task, target, solver in tasks:
            if target is not None and solver is not None:
                ladder = list(_ladder(method, task, target, solver, benchmark))
                trials += ladder
                orders += _orders(method, task, [run for run, _ in ladder])

    def timed(turn: int) -> None:
        timing(counted("accuracy: run times", turn, repeats))

    spreads = iter(timed_in_turns([call for _, call in trials if call is not None], repeats, timed))
    runs = tuple(run if call is None else replace(run, seconds=next(spreads)) for run, call in trials)
    return WorkPrecision("", benchmark, runs, tuple(orders), tuple(absent), machine(), repeats)


def _ladder(
    method: Method,
    task: MethodTask,
    target: BenchmarkProblem,
    solver: Callable[[BenchmarkProblem, float, Budget], SolvedMotion | float],
    benchmark: Benchmark,
) -> Iterator[tuple[MethodRun, Callable[[], SolvedMotion | float] | None]]:
    """The runs of a method on a task from coarse to fine, and what is to be timed where they did not fail.

    Finer ones than one that spent the budget are not tried.
    """
    exhausted = False
    for setting in method.settings:
        budget = Budget(method.most)

        def call(setting: float = setting, budget: Budget = budget) -> SolvedMotion | float:
            budget.spent = 0
            return solver(target, setting, budget)

        run = MethodRun(method.name, method.knob, setting, task, {}, None, 0)
        if exhausted:
            yield replace(run, failed="not tried: a coarser setting spent the budget"), None
            continue
        started = perf_counter()
        errors, failed = _judged(call, benchmark, _limit(method, setting))
        took = perf_counter() - started
        run = replace(run, errors=errors, evaluations=budget.spent, failed=failed)
        yield (replace(run, seconds=Spread(took, took, took)), None) if failed else (run, call)
        exhausted = budget.spent > budget.most


def _judged(
    call: Callable[[], SolvedMotion | float], benchmark: Benchmark, limit: float
) -> tuple[dict[str, float], str]:
    """Errors of what a method finds, or why it failed."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            errors = benchmark.errors(call())
    except FAILURES as error:
        return {}, str(error) or type(error).__name__
    largest = max(errors.values())
    return ({}, f"found something else, {rounded_text(largest, ROUGHLY)} away") if largest > limit else (errors, "")


def _limit(method: Method, setting: float) -> float:
    """Error from which a run has found something else; less where nothing but Newton's stop limits it."""
    return WRONG if method.knob.limits_accuracy else min(WRONG, 3 * max(setting, ELSEWHERE))


class FittedAxis(NamedTuple):
    """What an error is fitted against: its values in the runs, and the sign and the size of the exponent by theory."""

    against: str
    sign: int
    theory: float
    values: list[float]


def _orders(method: Method, task: MethodTask, ladder: list[MethodRun]) -> Iterator[Order]:
    """Orders of convergence over the runs between the first digits and rounding, by least squares of the logarithm."""
    runs, axes = [run for run in ladder if FLOOR < run.error < ASYMPTOTIC], []
    if method.order is not None:
        against, sign = ("step", -1) if method.knob is Knob.STEPS else ("tolerance", 1)
        axes.append(FittedAxis(against, sign, method.order, [run.setting for run in runs]))
    if method.cost_order is not None:
        axes.append(FittedAxis("evaluations", -1, method.cost_order, [float(run.evaluations) for run in runs]))
    for against, sign, theory, x in axes:
        if len(set(x)) >= LEAST_POINTS:
            slope = np.polyfit([log10(value) for value in x], [log10(run.error) for run in runs], 1)[0]
            yield Order(method.name, task, against, sign * float(slope), (theory,), x[0], x[-1], len(x))
