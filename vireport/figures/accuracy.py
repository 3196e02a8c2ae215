"""Draws the work-precision diagram: error against run time, a panel for each quantity, a line for each method."""

from __future__ import annotations

from math import ceil, floor, log10
from string import ascii_lowercase

import numpy as np
from matplotlib.figure import Figure

from vireport.figures.axes import (
    BLACK,
    BLUE,
    DASH_DOTTED,
    DASHED,
    DOTTED,
    GREEN,
    GREY,
    LIGHT,
    ORANGE,
    PURPLE,
    SKY,
    SOLID,
    VERMILION,
    WARNING,
    style,
)
from vireport.figures.drawing import Look
from vireport.figures.panel import Panel
from vireport.figures.sheet import BOTTOM, LEFT, RIGHT, ROW, WIDTH, Entry, Page, Place, blank, wrapped
from vireport.text import significant
from vireport.trust import (
    ACCURACIES,
    CLOSED,
    EXPLICIT,
    NAMES,
    PRINTED,
    RK4,
    SETTLING,
    SIMULATED,
    WHOLE,
    MethodRun,
    WorkPrecision,
    power,
    seconds,
    task_name,
)

LOOKS: dict[str, Look] = {
    CLOSED: {"color": VERMILION, "marker": "*", "markersize": 8.0, "linestyle": SOLID, "linewidth": 1.8},
    WHOLE: {"color": VERMILION, "marker": "X", "markersize": 7.0, "linestyle": "none"},
    PRINTED: {"color": BLACK, "marker": "o", "markersize": 4.0, "linestyle": SOLID},
    EXPLICIT: {"color": GREEN, "marker": "s", "markersize": 4.0, "linestyle": SOLID},
    SIMULATED: {"color": GREEN, "marker": "D", "markersize": 4.0, "linestyle": DASHED},
    SETTLING: {"color": SKY, "marker": "P", "markersize": 5.0, "linestyle": SOLID},
    RK4: {"color": BLUE, "marker": "v", "markersize": 4.5, "linestyle": SOLID},
    "SciPy RK45": {"color": ORANGE, "marker": "^", "markersize": 4.5, "linestyle": SOLID},
    "SciPy DOP853": {"color": PURPLE, "marker": "p", "markersize": 5.0, "linestyle": DASHED},
    "SciPy Radau": {"color": GREY, "marker": "h", "markersize": 5.0, "linestyle": DASH_DOTTED},
    "SciPy LSODA": {"color": WARNING, "marker": "d", "markersize": 5.0, "linestyle": DOTTED},
}
"""Of each method, apart by colour and by marker."""

LINE: Look = {"linewidth": 1.0, "markeredgecolor": "white", "markeredgewidth": 0.4, "zorder": 3.0}
FAILED: Look = {"linestyle": "none", "markerfacecolor": "white", "markeredgewidth": 1.0, "zorder": 3.5}
LEVEL: Look = {"color": LIGHT, "linewidth": 0.6, "zorder": 1.0}

SMALLEST = 1e-17
"""Error as which a smaller one is drawn."""

HIGHEST = 1.0
"""Error at which the axis ends; runs that failed stand on it."""

HIGH, UNDER, APART = 2.35, 0.62, 0.62
"""Height of a panel, room under it, and between two beside each other [in]."""

RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

NAME, TITLE = "figure-accuracy", "Error against run time"


def figure_accuracy(work: WorkPrecision) -> Figure:
    """The work-precision diagram of a study.

    Parameters
    ----------
    work : WorkPrecision
        With something to compare.
    """
    names = [name for name in NAMES if any(run.method == name for run in work.runs)]
    legend: list[Entry] = [(f" {name} ", LINE | LOOKS[name]) for name in names]
    if any(run.failed and run.seconds for run in work.runs):
        legend.append(("failed (open, at the top)", FAILED | {"color": BLACK, "marker": "o", "markersize": 5.0}))
    with style():
        lines = wrapped([legend])
        rows = max(1, ceil(len(work.quantities) / 2))
        over = ROW * (1 + len(lines)) + 0.30
        height = rows * (HIGH + UNDER) + (rows - 1) * 0.12 + over
        page = Page(blank(height), height)
        page.heading([(headline(work), BLACK)], lines)
        across = (WIDTH - LEFT - RIGHT - APART) / 2
        for k, one in enumerate(work.quantities):
            row, column = divmod(k, 2)
            bottom = height - over - HIGH - row * (HIGH + UNDER + 0.12)
            place = (LEFT + column * (across + APART), max(bottom, BOTTOM), across, HIGH)
            _panel(page, place, work, one.key, one.task, k)
        return page.figure


def words(work: WorkPrecision) -> tuple[str, str, str, str]:
    """Name, title, caption and alternative text of the diagram."""
    return NAME, TITLE, caption(work), alt_text(work)


def headline(work: WorkPrecision) -> str:
    """What the times are of."""
    m = work.machine
    return f"Median time of one solution; {m.processor}, {m.python}"


def caption(work: WorkPrecision) -> str:
    """The caption: what is drawn and how."""
    what = ", ".join(f"({ascii_lowercase[k]}) {_error_of(work, one.key)}" for k, one in enumerate(work.quantities))
    return (
        "Error against 40-digit arithmetic over the time of one solution, both on logarithmic axes; down and to the "
        f"left is better. {what}. "
        "Along a line a method is tried with finer and finer settings: the Newton correction at which it stops, the "
        "change of a lap at which the simulation counts as settled, the steps of RK4, rtol = atol of SciPy's solvers. "
        "Bars: quartiles of the time, where they are apart. Open markers at the top: runs that failed, at the time "
        f"after which they did. An error below {power(SMALLEST)} is drawn as that. "
        "The cross needs no guess, and finds every motion and critical point. "
        "Times are of one machine and differ from run to run; errors do not."
    )


def alt_text(work: WorkPrecision) -> str:
    """A description for those who do not see it."""
    told = []
    for name in NAMES:
        parts = []
        for task in work.tasks:
            best = work.best(name, task, ACCURACIES[0])
            good = [run for run in work.runs if (run.method, run.task) == (name, task) and not run.failed]
            if good:
                least = significant(min(run.error for run in good), 2)
                reach = (
                    f"{seconds(best.seconds)} to {power(ACCURACIES[0])}" if best else f"not to {power(ACCURACIES[0])}"
                )
                parts.append(f"{task_name(work, task)} {reach}, least error {least}")
        if parts:
            told.append(f"{name}: {'; '.join(parts)}.")
    count = len(work.quantities)
    return f"{count} line charts of error over run time, both logarithmic. {' '.join(told)}"


def _panel(page: Page, place: Place, work: WorkPrecision, key: str, task: str, number: int) -> None:
    runs = [run for run in work.runs if run.task == task and run.seconds is not None]
    times = [log10(run.seconds.median) for run in runs if run.seconds is not None]
    x = (floor(2 * min(times)) / 2 - 0.1, ceil(2 * max(times)) / 2 + 0.1)
    panel = page.frame(place, x, (log10(SMALLEST) - 0.8, log10(HIGHEST) + 1.0), number == 0)
    for accuracy in ACCURACIES:
        panel.level(log10(accuracy), **LEVEL)
    for name in reversed(NAMES):
        _method(panel, [run for run in runs if run.method == name], key, LOOKS[name])
    decades = [float(k) for k in range(ceil(x[0]), floor(x[1]) + 1)]
    page.along_bottom(panel, place, (decades, [_time(k) for k in decades]), "time of one solution")
    marks = [float(k) for k in range(-16, 1, 4)]
    page.along_side(panel, place, (marks, [_power(round(k)) for k in marks]))
    left, bottom, _, high = place
    page.words(left, bottom + high + 0.07, f"({ascii_lowercase[number]}) {_error_of(work, key)}", va="bottom")


def _method(panel: Panel, runs: list[MethodRun], key: str, look: Look) -> None:
    good = [(run.seconds, max(run.errors[key], SMALLEST)) for run in runs if key in run.errors and run.seconds]
    if good:
        spreads = [(np.log10([s.low, s.high]), np.log10([error, error])) for s, error in good if s.high > 1.1 * s.low]
        panel.curves(spreads, color=look["color"], linewidth=0.8, zorder=2.0)
        x, y = np.log10([s.median for s, _ in good]), np.log10([error for _, error in good])
        panel.curves([(x, y)], **LINE | look)
    lost = [run.seconds.median for run in runs if run.failed and run.seconds]
    if lost:
        open_look = {"color": look["color"], "marker": look["marker"], "markersize": look["markersize"]}
        panel.marks(np.log10(lost), np.full(len(lost), log10(HIGHEST) + 0.4), **FAILED | open_look)


def _error_of(work: WorkPrecision, key: str) -> str:
    """What the vertical axis of a panel is."""
    if key == "phase":
        return "error of the phase φ [rad]"
    if key == "critical" and work.benchmark is not None and work.benchmark.point is not None:
        return f"relative error of {work.benchmark.motion.sweep.parameter.symbol} at {work.benchmark.point.label}"
    return {"velocity": "relative error of |Ż|", "voltage": "relative error of the voltage"}[key]


def _power(exponent: int) -> str:
    """A power of ten, as a label."""
    return f"10{str(exponent).translate(RAISED)}" if exponent else "1"


def _time(exponent: float) -> str:
    """A power of ten of seconds in a unit."""
    k = round(exponent)
    unit, power = next((u, k - p) for u, p in (("s", 0), ("ms", -3), ("µs", -6), ("ns", -9)) if k >= p or p == -9)
    return f"{10**power:g} {unit}"
