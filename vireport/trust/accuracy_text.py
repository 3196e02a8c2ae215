"""The accuracy study in words and rows, for the report and for the terminal alike."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from textwrap import fill

from vireport.text import (
    ABSENT,
    TIMES,
    percent,
    quantity,
    significant,
)
from vireport.trust.contenders import CLOSED, NAMES, RK4, SETTLING, SOLVERS, WHOLE
from vireport.trust.timing import Spread
from vireport.trust.workprecision import ACCURACIES, Fastest, MethodRun, Order, WorkPrecision
from vireport.trust.yardstick import PHASE_OFF, VALUE_OFF, VELOCITY_OFF

ALIKE = 1.5
"""Factor up to which two methods are called about equally fast."""

SAME_LEAGUE = 3.0
"""Factor within which methods are said to be of one speed, once they have a good guess."""

BESIDE = 1e-9
"""Accuracy at which the whole sweep is set beside the integrators."""

COLUMNS = 110
"""Of a terminal: a paragraph is broken there."""

NOT_TRIED = "not tried"

Row = tuple[str, ...]


def power(value: float) -> str:
    """Print an error, an accuracy or a tolerance with two digits at the most: 1e-06 as 10⁻⁶."""
    return _bare(significant(float(f"{value:.1e}"), 2))


def _bare(text: str) -> str:
    """A power of ten without the factor 1."""
    return text.removeprefix(f"1 {TIMES} ")


def broken(text: str, indent: str = "") -> str:
    """A paragraph in lines for a terminal; all but the first are indented."""
    return fill(text, COLUMNS, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def seconds(spread: Spread | None) -> str:
    """Print a median with its quartiles, in the unit of the median: ``45.1 (44.9–45.3) µs``."""
    if spread is None:
        return ABSENT
    unit, scale = next((u, s) for u, s in (("s", 1.0), ("ms", 1e3), ("µs", 1e6)) if spread.median * s >= 1 or u == "µs")
    low, middle, high = (significant(x * scale, 3) for x in (spread.low, spread.median, spread.high))
    return f"{middle} {unit}" if low == high == middle else f"{middle} ({low}–{high}) {unit}"


def task_name(work: WorkPrecision, task: str) -> str:
    """What a task finds, in words."""
    if task == "orbit":
        return "the motion"
    point = work.yardstick.point if work.yardstick is not None else None
    return f"{point.label} ({point.kind.words})" if point is not None else "the critical point"


def setup(work: WorkPrecision) -> str:
    """What was measured, and how, in a paragraph."""
    stick = work.yardstick
    if stick is None:
        return f"Nothing is compared: {work.nothing}."
    swept = stick.orbit.sweep.parameter
    d, gbar = stick.orbit.groups(stick.value)
    what = f"the stable 1:1 motion at {swept.symbol} = {swept.show(stick.value, 9)}"
    groups = f"(d = {significant(d, 7)}, ḡ = {significant(gbar, 7)})"
    off = f"off by {significant(stick.off * PHASE_OFF, 2)} rad in the phase"
    guess = (
        f"All methods but the whole sweep start from the same guess, {off} and {percent(stick.off * VELOCITY_OFF)} in "
        "the velocity"
    )
    also = told = ""
    if stick.critical is not None:
        also = f", and {task_name(work, 'critical')} of the sweep"
        guess += f", and by {percent(-stick.off * VALUE_OFF)} in {swept.symbol} for the critical point"
        told = (
            " They take the critical point from differences of the return map, of fourth order, which leave some "
            "e^(4/5) of its error e; with the variational equations they would lose less."
        )
    return (
        f"Each method finds {what} {groups}{also}. "
        "Errors are against 40-digit arithmetic on the printed maps (3.3)–(3.6), trace (A.4) and voltage (5.1)–(5.5), "
        f"which shares no formula with the package; they are relative, and in rad for the phase. {guess}. "
        f"All but the {SETTLING} use the same iteration, Newton by differences with Broyden's updates, and differ in "
        f"what it is applied to; those that follow a flight differ in that flight alone.{told}"
    )


def reference_rows(work: WorkPrecision) -> Iterator[Row]:
    """The quantities: reference, and the errors of the closed form and of the whole sweep solved without a guess."""
    for one in work.quantities:
        errors = []
        for name in (CLOSED, WHOLE):
            found = [run.errors[one.key] for run in work.runs if run.method == name and one.key in run.errors]
            errors.append(power(found[-1]) if found else ABSENT)
        yield (quantity_name(work, one.key), one.reference, *errors)


def quantity_name(work: WorkPrecision, key: str) -> str:
    """A quantity with its symbol and unit."""
    if key != "critical" or work.yardstick is None or work.yardstick.point is None:
        names = {"velocity": "impact velocity Ż [y_c]", "phase": "phase φ [rad]", "voltage": "U_ave [V]"}
        return names.get(key, key)
    swept = work.yardstick.orbit.sweep.parameter
    return f"{work.yardstick.point.label}, {swept.symbol} [{swept.unit}]"


def summary_rows(work: WorkPrecision, task: str) -> Iterator[Row]:
    """For each method: time to each accuracy, smallest error, the evaluations for it, and runs that failed."""
    for name in NAMES:
        runs = [run for run in work.runs if (run.method, run.task) == (name, task)]
        if not runs:
            continue
        cells = []
        for accuracy in ACCURACIES:
            best = work.best(name, task, accuracy)
            cells.append(seconds(best.seconds) if best is not None else ABSENT)
        good = [run for run in runs if not run.failed]
        least = min(good, key=lambda run: run.error, default=None)
        count = f"{least.evaluations:,}" if least is not None and least.evaluations else ABSENT
        lost = f"{len(runs) - len(good)} of {len(runs)}" if len(good) < len(runs) else "none"
        yield (name, *cells, power(least.error) if least is not None else ABSENT, count, lost)


def run_rows(work: WorkPrecision, task: str) -> Iterator[Row]:
    """Every run: method, setting, time, evaluations, and the errors or that it failed."""
    keys = [one.key for one in work.quantities if one.task == task]
    for run in work.runs:
        if run.task == task:
            errors = [power(run.errors[key]) for key in keys] if run.errors else ["failed"] + [""] * (len(keys) - 1)
            count = f"{run.evaluations:,}" if run.evaluations else ABSENT
            yield (run.method, setting(run), seconds(run.seconds), count, *errors)


def failures(work: WorkPrecision) -> Iterator[Row]:
    """Runs that failed: method, what it was to find, setting and reason."""
    for run in work.runs:
        if run.failed:
            yield run.method, task_name(work, run.task), setting(run), run.failed
    for name, reason in work.absent:
        yield name, "everything", ABSENT, f"not tried: {reason}"


def failure_rows(work: WorkPrecision) -> Iterator[Row]:
    """The same in fewer rows: settings that failed for one reason share one."""
    for (name, task, reason), rows in groupby(failures(work), lambda row: (row[0], row[1], row[3])):
        settings = [row[2] for row in rows]
        ends = settings[0] if len(settings) == 1 else f"{settings[0]} to {settings[-1]}"
        yield name, task, ends, reason


def setting(run: MethodRun) -> str:
    """The setting of a run."""
    return _bare(significant(run.setting, 3)) if run.knob else ABSENT


def order_rows(work: WorkPrecision) -> Iterator[Row]:
    """Fitted orders beside those of theory."""
    for one in work.orders:
        theory = "–".join(significant(x, 2) for x in one.theory) or ABSENT
        yield (one.method, task_name(work, one.task), *_range(one), significant(one.fitted, 3), theory)


def _range(one: Order) -> Row:
    against = {"step": "steps a period", "tolerance": "tolerance", "evaluations": "evaluations"}[one.against]
    low, high = (f"{x:,.0f}" if one.against != "tolerance" else power(x) for x in (one.first, one.last))
    ends = f"{low} to {high}"
    return against, f"{ends} ({one.points} runs)"


def verdicts(work: WorkPrecision, accuracy: float) -> Iterator[str]:
    """Which method reaches an accuracy soonest, and which are about as soon: a sentence a task."""
    for one in work.fastest(accuracy):
        what = f"To {power(accuracy)}, {task_name(work, one.task)}:"
        if not one.method:
            yield f"{what} no method reaches it from the guess."
            continue
        yield f"{what} soonest by {one.method}, in {quantity(one.seconds, 's', 3)}{_factors(one)}."


def _factors(one: Fastest) -> str:
    near = [f"{name} ({factor(times)} times that)" for name, times in one.factors if times <= ALIKE]
    return f", about as soon by {', '.join(near)}" if near else ""


def factor_head(work: WorkPrecision) -> Row:
    """Heads of the columns of `factor_rows` behind the name of the method."""
    short = {task: task_name(work, task).removeprefix("the ").partition(" (")[0] for task in work.tasks}
    return tuple(f"{short[task]} to {power(a)}" for task in work.tasks for a in ACCURACIES)


def factor_rows(work: WorkPrecision) -> Iterator[Row]:
    """For each method that starts from the guess, how many times the time of the soonest it takes."""
    found = {(one.task, accuracy): one for accuracy in ACCURACIES for one in work.fastest(accuracy)}
    for name in (name for name in NAMES if name != WHOLE):
        tried = {run.task for run in work.runs if run.method == name}
        if tried:
            keys = [(task, a) for task in work.tasks for a in ACCURACIES]
            yield (name, *(_factor_cell(name, found[key]) if key[0] in tried else NOT_TRIED for key in keys))


def _factor_cell(name: str, one: Fastest) -> str:
    times = {one.method: 1.0, **dict(one.factors)}.get(name)
    return ABSENT if times is None else factor(times)


def without_guess(work: WorkPrecision) -> Iterator[str]:
    """What the guess-free solution costs and buys, beside the methods that need a guess."""
    stick = work.yardstick
    if stick is None:
        return
    for one in work.fastest(ACCURACIES[-1]):
        near = [one.method, *(name for name, times in one.factors if times <= SAME_LEAGUE)]
        if CLOSED in near and len(near) > 1:
            yield (
                f"From a good guess, {', '.join(near[:-1])} and {near[-1]} are within a factor of {SAME_LEAGUE:g} for "
                f"{task_name(work, one.task)}: what the closed form adds is that it needs no guess."
            )
    task = work.tasks[-1]
    whole = next((run for run in work.runs if (run.method, run.task) == (WHOLE, task)), None)
    if whole is None or whole.seconds is None or whole.failed:
        return
    what, time = task_name(work, task), whole.seconds.median
    of = (
        "motion and critical point of the sweep" if task == "critical" else "motion at the design point and its margins"
    )
    yield (
        f"Without a guess, every {of} together take {quantity(time, 's', 3)}, with an error of {power(whole.error)} "
        f"for {what}. No other method here says how many motions there are, or that none was missed."
    )
    best = [(name, work.best(name, task, BESIDE)) for name in (RK4, *(f"SciPy {solver}" for solver in SOLVERS))]
    told = [
        f"{name} {quantity(run.seconds.median, 's', 3)} ({factor(run.seconds.median / time)})"
        for name, run in best
        if run is not None and run.seconds is not None
    ]
    if told:
        yield (
            f"Beside that, for {what} alone, to {power(BESIDE)} and from a guess, the time and how many times that "
            f"whole solution it is: {', '.join(told)}."
        )


def factor(value: float) -> str:
    """Print how many times as long something takes; more than two digits would be noise."""
    rounded = float(f"{value:.2g}")
    return f"{rounded:,.0f}" if rounded >= 10 or value == 1 else f"{rounded:.1f}"


def about_times(work: WorkPrecision) -> str:
    """Where the times are from, and what not to read into them."""
    m = work.machine
    versions = ", ".join(f"{name} {version}" for name, version in m.libraries)
    return (
        f"Times are of one machine ({m.processor}, {m.cores} cores, {m.system}, {m.python}, {versions}): medians "
        f"with their quartiles, where these differ, of {work.repeats} sample{'s' * (work.repeats != 1)}"
        f"{', of fewer for the longest and of' if work.repeats > 1 else ', and of'} more for the shortest. They "
        "are the only numbers of this section that differ from run to run; errors, evaluations and failures do not. "
        "All methods are interpreted Python but for the flight of the simulation and the core of LSODA. Compiled, an "
        "integrator would be some tens of times faster, and so would the formulae; the evaluations, of the force or "
        "of a formula, do not depend on that. The flight is a pure quadrature, the easiest task an integrator can "
        f"have. The {SETTLING} needs no Newton iteration, but takes ever longer towards a critical point, which it "
        "cannot find."
    )


def plain(work: WorkPrecision, every: bool = False) -> str:
    """The study as a text for the terminal; with `every`, each run in a row."""
    parts = [broken(setup(work))]
    if work.yardstick is not None:
        parts.append(table(("quantity", "reference", "error, closed form", "error, whole sweep"), reference_rows(work)))
        for task in work.tasks:
            if every:
                keys = [f"error, {one.key}" for one in work.quantities if one.task == task]
                head: Row = (task_name(work, task), "setting", "time (quartiles)", "evaluations", *keys)
                parts.append(table(head, run_rows(work, task)))
            head = (
                task_name(work, task),
                *(f"to {power(a)}" for a in ACCURACIES),
                "least error",
                "evaluations",
                "failed",
            )
            parts.append(table(head, summary_rows(work, task)))
        parts.append(table(("order of convergence", "of", "against", "range", "fitted", "theory"), order_rows(work)))
        lost = list(failure_rows(work))
        if lost:
            parts.append(table(("failed", "task", "setting", "reason"), lost))
        parts.append(table(("times the soonest", *factor_head(work)), factor_rows(work)))
        said = [" ".join(verdicts(work, accuracy)) for accuracy in ACCURACIES]
        parts += [broken(text) for text in (*said, *without_guess(work), about_times(work))]
    return "\n\n".join(parts) + "\n"


def table(head: Row, rows: Iterator[Row] | list[Row]) -> str:
    """Rows under a head, in columns as wide as they need."""
    lines = [head, *rows]
    wide = [max(len(line[k]) for line in lines) for k in range(len(head))]
    return "\n".join("  ".join(cell.ljust(w) for cell, w in zip(line, wide, strict=True)).rstrip() for line in lines)
