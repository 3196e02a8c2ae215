"""Error against run time: every method on this scenario's own motion and critical point, against 40 digits.

Turns a study into measured runs. All methods start from one guess, wrong in the second or third digit, and use one
iteration, so that they differ in what it is applied to. Errors and counts are the same in every run; times are not.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from math import inf, log10
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from vireport.errors import NumericalError
from vireport.progress import Progress
from vireport.trust.contenders import WHOLE, Contender, contenders
from vireport.trust.integrators import Budget
from vireport.trust.timing import Machine, Spread, machine, timed_in_turns
from vireport.trust.yardstick import Quantity, Yardstick, yardstick

if TYPE_CHECKING:
    from vireport.analysis import Solution

ACCURACIES = (1e-6, 1e-9, 1e-12)
"""At which the methods are ranked."""

WRONG = 0.1
"""Error from which a method has found something else than what was asked for: far more than the guess is off."""

ELSEWHERE = 1e-6
"""The same, over three, where a method has no error of its own but that of differences."""

ASYMPTOTIC = 0.03
"""Error above which a run is left out of a fitted order."""

FLOORS = {"orbit": 1e-13, "critical": 1e-11}
"""Error below which rounding is seen, and a run is left out of a fitted order: of a lap, and of the differences of laps
that the multipliers are taken from."""

LEAST_POINTS = 3
"""Of a fit."""

LOST = (NumericalError, ArithmeticError, ValueError, Warning)
"""What a method that fails raises; warnings of the integrators count as failures."""


@dataclass(frozen=True, slots=True)
class MethodRun:
    """One method with one setting on one task.

    Attributes
    ----------
    method, knob : str
        As in `Contender`.
    setting : float
    task : str
        ``orbit`` or ``critical``.
    errors : dict
        By the key of the quantity; empty where it failed.
    seconds : Spread or None
        Of one solution, or once until it failed; None where it was not tried.
    evaluations : int
        Of the force, or of a formula with a sine and a cosine; 0 where they are not counted.
    failed : str
        The reason, or "".
    """

    method: str
    knob: str
    setting: float
    task: str
    errors: dict[str, float]
    seconds: Spread | None
    evaluations: int
    failed: str = ""

    @property
    def error(self) -> float:
        """The largest error of the task's quantities; infinite where it failed."""
        return max(self.errors.values(), default=inf)


@dataclass(frozen=True, slots=True)
class Order:
    """A fitted order of convergence beside the theoretical one.

    Attributes
    ----------
    method, task : str
    against : str
        ``step``, ``tolerance`` or ``evaluations``: error ~ step^order, tolerance^order, evaluations^(-order).
    fitted : float
    theory : tuple of float
        The range that theory gives; empty where it gives none.
    first, last : float
        Ends of the range that was fitted, coarse to fine: steps a period, tolerances or numbers of evaluations.
    points : int
    """

    method: str
    task: str
    against: str
    fitted: float
    theory: tuple[float, ...]
    first: float
    last: float
    points: int


@dataclass(frozen=True, slots=True)
class Fastest:
    """Which method reaches an accuracy soonest.

    Attributes
    ----------
    task : str
    accuracy : float
    method : str
        "" where none does.
    seconds : float
    factors : tuple of (str, float)
        Of each other method that reaches it too: how many times as long it takes, ascending.
    short : tuple of str
        Methods that do not reach it.
    """

    task: str
    accuracy: float
    method: str
    seconds: float
    factors: tuple[tuple[str, float], ...]
    short: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class WorkPrecision:
    """The study of one scenario.

    Attributes
    ----------
    nothing : str
        Why nothing can be compared, or "".
    yardstick : Yardstick or None
        The tasks and the reference; None where nothing can be compared.
    runs : tuple of MethodRun
    orders : tuple of Order
    absent : tuple of (str, str)
        Methods that could not be tried, and why.
    machine : Machine
    repeats : int
    """

    nothing: str
    yardstick: Yardstick | None
    runs: tuple[MethodRun, ...]
    orders: tuple[Order, ...]
    absent: tuple[tuple[str, str], ...]
    machine: Machine
    repeats: int

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What was to be found."""
        return self.yardstick.quantities if self.yardstick is not None else ()

    @property
    def tasks(self) -> tuple[str, ...]:
        """``orbit`` and, where there is a critical point, ``critical``."""
        return tuple(dict.fromkeys(quantity.task for quantity in self.quantities))

    def best(self, method: str, task: str, accuracy: float) -> MethodRun | None:
        """The fastest run of a method on a task that is as accurate as that."""
        good = (r for r in self.runs if (r.method, r.task) == (method, task) and r.error <= accuracy)
        return min(good, key=lambda run: run.seconds.median if run.seconds else inf, default=None)

    def fastest(self, accuracy: float) -> tuple[Fastest, ...]:
        """Which method reaches an accuracy soonest from the guess, for each task.

        The solution of the whole sweep needs no guess and answers more; it is not ranked.
        """
        found = []
        for task in self.tasks:
            tried = dict.fromkeys(run.method for run in self.runs if run.task == task and run.method != WHOLE)
            best = {name: self.best(name, task, accuracy) for name in tried}
            times = sorted((run.seconds.median, name) for name, run in best.items() if run and run.seconds)
            first = times[0] if times else (inf, "")
            factors = tuple((name, seconds / first[0]) for seconds, name in times[1:])
            short = tuple(name for name, run in best.items() if run is None)
            found.append(Fastest(task, accuracy, first[1], first[0], factors, short))
        return tuple(found)


def measure(solution: Solution, repeats: int = 5, progress: Progress | None = None) -> WorkPrecision:
    """Measure error and run time of every method on a scenario.

    Parameters
    ----------
    solution : Solution
    repeats : int
        Samples of each time, at least 1.
    progress : callable, optional
        Told each method as it begins.

    Raises
    ------
    NumericalError
        If mpmath is missing, or the reference cannot be computed.
    """
    stick = yardstick(solution)
    if stick is None:
        reason = "there is no stable admissible 1:1 motion to measure on"
        return WorkPrecision(reason, None, (), (), (), machine(), repeats)
    label = stick.point.label if stick.point is not None else ""
    tried, absent = contenders(solution, stick.orbit, stick.critical, label)
    return compare(stick, tried, absent, repeats, progress)


def compare(
    stick: Yardstick,
    tried: Iterable[Contender],
    absent: tuple[tuple[str, str], ...],
    repeats: int,
    progress: Progress | None = None,
) -> WorkPrecision:
    """Measure given methods; see `measure`."""
    trials: list[tuple[MethodRun, Callable[[], Any] | None]] = []
    orders: list[Order] = []
    for one in tried:
        if progress is not None:
            progress(f"accuracy: {one.name}")
        for task, solver in (("orbit", one.orbit), ("critical", one.critical)):
            if solver is not None:
                ladder = list(_ladder(one, task, solver, stick))
                trials += ladder
                orders += _orders(one, task, [run for run, _ in ladder])
    spreads = iter(timed_in_turns([solve for _, solve in trials if solve is not None], repeats, progress))
    runs = tuple(run if solve is None else replace(run, seconds=next(spreads)) for run, solve in trials)
    return WorkPrecision("", stick, runs, tuple(orders), absent, machine(), repeats)


def _ladder(
    one: Contender, task: str, solver: Callable[[float, Budget], Any], stick: Yardstick
) -> Iterator[tuple[MethodRun, Callable[[], Any] | None]]:
    """The runs of a method from coarse to fine, and what is to be timed where they did not fail.

    Finer ones than one that spent the budget are not tried.
    """
    exhausted = ""
    for setting in one.settings:
        budget = Budget(one.most)

        def solve(setting: float = setting, budget: Budget = budget) -> Any:
            budget.spent = 0
            return solver(setting, budget)

        if exhausted:
            yield MethodRun(one.name, one.knob, setting, task, {}, None, 0, exhausted), None
            continue
        errors: dict[str, float] = {}
        started, failed = perf_counter(), ""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                errors = stick.errors(solve())
        except LOST as error:
            failed = str(error) or type(error).__name__
            exhausted = "not tried: a coarser setting spent the budget" if budget.spent > budget.most else ""
        took = perf_counter() - started
        far = max(errors.values(), default=0.0)
        if far > _limit(one.knob, setting):
            failed = f"found something else, {far:.2g} away"
        run = MethodRun(one.name, one.knob, setting, task, {} if failed else errors, None, budget.spent, failed)
        yield (replace(run, seconds=Spread(took, took, took)), None) if failed else (run, solve)


def _limit(knob: str, setting: float) -> float:
    """Error from which a run has found something else; less where nothing but Newton's stop limits it."""
    return min(WRONG, 3 * max(setting, ELSEWHERE)) if knob in ("stop", "") else WRONG


def _orders(one: Contender, task: str, ladder: list[MethodRun]) -> Iterator[Order]:
    """Least squares of the logarithm of the error, over the runs between the first digits and rounding."""
    if one.order is None:
        return
    good = [run for run in ladder if FLOORS[task] < run.error < ASYMPTOTIC]
    against = "step" if one.knob == "steps" else "tolerance"
    sign = -1 if against == "step" else 1
    # Multipliers from differences keep e^(4/5) of the error e of a lap that is irregular on the scale of e.
    theory = (one.order,) if task == "orbit" or against == "step" else (0.8 * one.order, one.order)
    yield from _fit(one.name, task, against, good, [run.setting for run in good], sign, theory)
    if one.cost_order is not None:
        theory = (one.cost_order,) if task == "orbit" else (0.8 * one.cost_order, one.cost_order)
        yield from _fit(one.name, task, "evaluations", good, [float(r.evaluations) for r in good], -1, theory)


def _fit(
    method: str, task: str, against: str, runs: list[MethodRun], x: list[float], sign: int, theory: tuple[float, ...]
) -> Iterator[Order]:
    if len(set(x)) < LEAST_POINTS:
        return
    slope = np.polyfit([log10(value) for value in x], [log10(run.error) for run in runs], 1)[0]
    yield Order(method, task, against, sign * float(slope), theory, x[0], x[-1], len(x))
