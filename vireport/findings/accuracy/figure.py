"""The work-precision diagram with caption: error against run time, a panel for each quantity, a line per method."""

from __future__ import annotations

from itertools import zip_longest
from math import ceil
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from vireport.figures.captions import pictured
from vireport.figures.layout import (
    Entry,
    blank,
    columns_of,
    finished,
    letter_of,
)
from vireport.figures.style import (
    DASH_DOTTED,
    DASHED,
    DOTTED,
    GUIDE,
    Color,
    Look,
    Picture,
    style,
)
from vireport.findings.accuracy.methods import (
    CLOSED,
    EXPLICIT,
    METHOD_NAMES,
    PRINTED,
    RK4,
    SIMULATED,
    SIMULATED_TRANSIENT,
    WHOLE,
)
from vireport.findings.accuracy.tables import power, seconds, task_name
from vireport.findings.accuracy.workprecision import ACCURACIES, MethodRun, WorkPrecision
from vireport.study.plan import AnyTask
from vireport.text.formatting import factor_text

LOOKS: dict[str, Look] = {
    CLOSED: {"color": Color.VERMILION, "marker": "*", "markersize": 8.0, "linestyle": "-", "linewidth": 1.8},
    WHOLE: {"color": Color.VERMILION, "marker": "X", "markersize": 7.0, "linestyle": "none"},
    PRINTED: {"color": Color.BLACK, "marker": "o", "markersize": 4.0, "linestyle": "-"},
    EXPLICIT: {"color": Color.GREEN, "marker": "s", "markersize": 4.0, "linestyle": "-"},
    SIMULATED: {"color": Color.GREEN, "marker": "D", "markersize": 4.0, "linestyle": DASHED},
    SIMULATED_TRANSIENT: {"color": Color.SKY, "marker": "P", "markersize": 5.0, "linestyle": "-"},
    RK4: {"color": Color.BLUE, "marker": "v", "markersize": 4.5, "linestyle": "-"},
    "SciPy RK45": {"color": Color.ORANGE, "marker": "^", "markersize": 4.5, "linestyle": "-"},
    "SciPy DOP853": {"color": Color.PURPLE, "marker": "p", "markersize": 5.0, "linestyle": DASHED},
    "SciPy Radau": {"color": Color.GREY, "marker": "h", "markersize": 5.0, "linestyle": DASH_DOTTED},
    "SciPy LSODA": {"color": Color.WARNING, "marker": "d", "markersize": 5.0, "linestyle": DOTTED},
}
"""Look of each method, which colour and marker each tell apart."""

LINE: Look = {"linewidth": 1.0, "markeredgecolor": "white", "markeredgewidth": 0.4, "zorder": 3.0}
FAILED: Look = {"linestyle": "none", "markerfacecolor": "white", "markeredgewidth": 1.0, "zorder": 3.5}

SMALLEST = 1e-17
"""Error as which a smaller one is drawn."""

FAILED_AT = 2.5
"""Error at which runs that failed are drawn."""

LIMITS, ERRORS = (1.5e-18, 10.0), (1e-16, 1e-12, 1e-8, 1e-4, 1.0)
"""Ends of the axis of errors, and its ticks."""

SPREAD = 1.1
"""Ratio of the quartiles of the time from which they are drawn."""

HEIGHT = 2.9
"""Height of a row of panels [in]."""


def figure_accuracy(work: WorkPrecision) -> Figure:
    """Draw the work-precision diagram of a study.

    Parameters
    ----------
    work : WorkPrecision
        With something to compare.
    """
    names = [name for name in METHOD_NAMES if any(run.method == name for run in work.runs)]
    legend: list[Entry] = [(name, LINE | LOOKS[name]) for name in names]
    if any(run.failed and run.seconds for run in work.runs):
        legend.append(("failed (open, at the top)", FAILED | {"color": Color.BLACK, "marker": "o", "markersize": 5.0}))
    columns = columns_of(2)
    rows = ceil(len(work.quantities) / columns)
    with style():
        figure, panels = blank(rows, columns)
        for k, (axes, quantity) in enumerate(zip_longest(panels.ravel(), work.quantities)):
            if quantity is None:
                axes.remove()
                continue
            axes.set_title(f"({letter_of(k)})", loc="left")
            axes.set_ylabel(_error_of(work, quantity.key))
            axes.set_xlabel("time of one solution")
            _draw(axes, [run for run in work.runs if run.task == quantity.task], quantity.key)
        return finished(figure, HEIGHT * rows, [(headline(work), Color.BLACK)], [legend])


def picture(work: WorkPrecision, name: AnyTask, templates: Path | None = None) -> Picture:
    """The work-precision diagram with its caption."""
    return pictured(name, error_facts(work, templates), figure_accuracy(work), templates)


def error_facts(work: WorkPrecision, templates: Path | None = None) -> dict[str, object]:
    """Numbers for the caption: the panels, and the time to an accuracy and the least error of each method."""
    methods = []
    for name in METHOD_NAMES:
        best_runs = []
        for task in work.tasks:
            best = work.best(name, task, ACCURACIES[0])
            good = [run.error for run in work.runs if (run.method, run.task) == (name, task) and not run.failed]
            if good:
                best_runs.append((task_name(work, task, templates), seconds(best.seconds) if best else "", min(good)))
        if best_runs:
            methods.append((name, best_runs))
    return {
        "panels": [(letter_of(k), _error_of(work, quantity.key)) for k, quantity in enumerate(work.quantities)],
        "smallest": power(SMALLEST),
        "accuracy": power(ACCURACIES[0]),
        "methods": methods,
    }


def headline(work: WorkPrecision) -> str:
    """The line over the figure that says what was timed."""
    m = work.machine
    return f"Median time of one solution; {m.processor}, {m.python}"


def _draw(axes: Axes, runs: list[MethodRun], key: str) -> None:
    """Draw the runs of one task on a panel with logarithmic axes."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(*LIMITS)
    for accuracy in ACCURACIES:
        axes.axhline(accuracy, **GUIDE)
    for name in reversed(METHOD_NAMES):
        _method(axes, [run for run in runs if run.method == name], key, LOOKS[name])
    axes.set_yticks(ERRORS, [factor_text(error) for error in ERRORS])
    axes.xaxis.set_major_formatter(EngFormatter("s"))
    axes.minorticks_off()


def _method(axes: Axes, runs: list[MethodRun], key: str, look: Look) -> None:
    """Draw one method: median times with their quartiles where these are apart, and at the top what failed."""
    good = [(run.seconds, max(run.errors[key], SMALLEST)) for run in runs if key in run.errors and run.seconds]
    if good:
        medians, errors = np.array([time.median for time, _ in good]), np.array([error for _, error in good])
        apart = np.array([time.high > SPREAD * time.low for time, _ in good])
        quartiles = np.array([[time.median - time.low, time.high - time.median] for time, _ in good]).T * apart
        axes.errorbar(medians, errors, xerr=quartiles, elinewidth=0.8, **LINE | look)
    failed = [run.seconds.median for run in runs if run.failed and run.seconds]
    marker = {key: look[key] for key in ("color", "marker", "markersize")}
    axes.plot(failed, [FAILED_AT] * len(failed), **FAILED | marker)


def _error_of(work: WorkPrecision, key: str) -> str:
    """Label of the vertical axis of a panel."""
    if key == "phase":
        return "error of the phase φ [rad]"
    if key == "critical" and work.benchmark is not None and work.benchmark.point is not None:
        return f"relative error of {work.benchmark.motion.sweep.parameter.symbol} at {work.benchmark.point.label} [–]"
    return {"velocity": "relative error of |Ż| [–]", "voltage": "relative error of the voltage [–]"}[key]
