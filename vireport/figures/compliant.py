"""Draws what solvers make of stiff membranes, and how the compliant motion tends to the rigid one; with its words."""

from __future__ import annotations

from math import ceil, floor, log10

import numpy as np
from matplotlib.figure import Figure

from vireport.figures.axes import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION, style
from vireport.figures.curves import Floats
from vireport.figures.drawing import GUIDE, Look
from vireport.figures.panel import Panel
from vireport.figures.sheet import ACROSS, BOTTOM, LEFT, ROW, Entry, Page, Ticks, blank, wrapped
from vireport.text import significant
from vireport.trust import (
    ADAPTIVE,
    FIXED,
    WRONG,
    Compliance,
    Outcome,
    SolverRun,
    factor_text,
    findings,
    quantity_label,
)

NAME, TITLE = "figure-stiffness", "Solvers on stiff membranes, and the way to rigid impacts"

HIGH = 2.9, 2.2
"""Heights of the panels [in]."""

BETWEEN = 0.66
"""Between them: tick labels, a label and a line of text [in]."""

MARKERS = dict(zip((FIXED, *ADAPTIVE), ("x", "o", "s", "^", "v", "D", "P"), strict=True))
STIFFNESSES = (BLUE, ORANGE, VERMILION)
SIZES = (3.6, 5.0, 6.8)
MARK: Look = {"linestyle": "none", "markersize": 5.0, "markeredgewidth": 1.0, "zorder": 3.0}
HOLLOW = {"markerfacecolor": "white"}
QUANTITIES = {"velocity": (BLUE, "o"), "phase": (GREEN, "s"), "critical value": (PURPLE, "^")}
THEORY: Look = {"color": GREY, "linewidth": 0.9, "linestyle": (0, (5, 2)), "zorder": 2.2}

HIGHEST = 10.0
"""Error at which runs are drawn that are farther off, or did not reach the end."""


def figure_stiffness(made: Compliance) -> Figure:
    """Error against run time for each solver at three stiffnesses, and the distance from the rigid motion over K.

    Parameters
    ----------
    made : Compliance
        With runs.
    """
    shown = shown_factors(made)
    solvers: list[Entry] = [(name, MARK | {"marker": marker, "color": BLACK}) for name, marker in MARKERS.items()]
    colours: list[Entry] = [
        (f"K times {factor_text(f)}", MARK | {"marker": "o", "color": colour, "markersize": size})
        for f, colour, size in zip(shown, STIFFNESSES, SIZES, strict=False)
    ]
    hollow: list[Entry] = [("hollow or at the top: failed", MARK | HOLLOW | {"marker": "o", "color": BLACK})]
    legend = wrapped([solvers, colours + hollow])
    with style():
        height = BOTTOM + HIGH[1] + BETWEEN + HIGH[0] + ROW * len(legend) + 0.10
        page = Page(blank(height), height)
        page.heading([], legend)
        _errors(page, made, shown)
        _rates(page, made)
        return page.figure


def shown_factors(made: Compliance) -> list[float]:
    """The softest, middle and stiffest membrane that solvers were tried on."""
    factors = sorted({run.factor for run in made.runs})
    return sorted({factors[0], factors[len(factors) // 2], factors[-1]}) if factors else []


def caption(made: Compliance) -> str:
    """What is drawn and how."""
    return (
        "(a) Error of solvers that take the whole equation over one period in one go, in (Z, Z\u2032) at its end, "
        "against run time: the shape of a marker is the solver, its colour and size the stiffness. A marker is hollow "
        f"where the error exceeds {WRONG:g}, and at the top where the run did not reach the end; the fixed-step RK4 "
        "is a cross. (b) Relative distance of the velocity at the bottom and of the critical point, and distance of "
        "the phase [rad], from their rigid values; the dashed lines have the slope expected, "
        f"K^({significant(-made.order, 3)}). {_slopes(made)}"
    )


def alt_text(made: Compliance) -> str:
    """A description for those who do not see it."""
    return " ".join(["Two scatter charts with logarithmic axes.", *findings(made), _slopes(made)])


def _slopes(made: Compliance) -> str:
    fitted = [f"{quantity_label(made, one)} {significant(one.exponent, 4)}" for one in made.convergence if one.exponent]
    return f"Fitted exponents: {', '.join(fitted)}." if fitted else "No exponent could be fitted."


def _errors(page: Page, made: Compliance, shown: list[float]) -> None:
    place = (LEFT, BOTTOM + HIGH[1] + BETWEEN, ACROSS, HIGH[0])
    runs = [run for run in made.runs if run.factor in shown]
    times = np.array([1e3 * run.seconds for run in runs])
    errors = np.array([_height(run) for run in runs])
    x, y = _decades(times), (min(_decades(errors)[0], -3.0), log10(HIGHEST) + 0.25)
    panel = _panel(page, place, x, y, ("run time [ms]", "error at the end of the period [–]"), "a")
    panel.level(log10(WRONG), **GUIDE)
    for run, time, error in zip(runs, times, errors, strict=True):
        k = shown.index(run.factor)
        look = MARK | {"marker": MARKERS[run.solver], "color": STIFFNESSES[k], "markersize": SIZES[k]}
        look |= {} if run.outcome is Outcome.SOLVED else HOLLOW
        panel.marks(np.array([log10(time)]), np.array([log10(error)]), **look)


def _height(run: SolverRun) -> float:
    return HIGHEST if run.error is None else min(max(run.error, 1e-16), HIGHEST)


def _rates(page: Page, made: Compliance) -> None:
    place = (LEFT, BOTTOM, ACROSS, HIGH[1])
    factors = np.array([rung.factor for rung in made.rungs])
    known = [d for one in made.convergence for d in one.distances if d]
    x, y = _decades(factors), _decades(np.array(known or [1.0]))
    panel = _panel(page, place, x, y, ("stiffness over the scenario's K [–]", "distance from rigid [–], [rad]"), "b")
    names = []
    for one in made.convergence:
        at = np.array([k for k, d in enumerate(one.distances) if d], dtype=int)
        if not len(at):
            continue
        colour, marker = QUANTITIES[one.quantity]
        logs = np.log10(factors[at]), np.log10(np.array([float(one.distances[k] or 1.0) for k in at]))
        panel.curves([(logs[0], logs[1][-1] - made.order * (logs[0] - logs[0][-1]))], **THEORY)
        panel.marks(*logs, **MARK | {"color": colour, "marker": marker})
        names.append((quantity_label(made, one), logs[0][len(at) // 2 :], logs[1][len(at) // 2 :]))
    panel.letters(names)


def _panel(
    page: Page,
    place: tuple[float, float, float, float],
    x: tuple[float, float],
    y: tuple[float, float],
    labels: tuple[str, str],
    letter: str,
) -> Panel:
    panel = page.frame(place, x, y, first=letter == "a")
    page.along_bottom(panel, place, _ticks(x, 12), labels[0])
    page.along_side(panel, place, _ticks(y, 8))
    page.words(0.08, place[1] + place[3] / 2, labels[1], rotation=90, ha="left", va="center")
    page.words(0.05, place[1] + place[3], f"({letter})", ha="left", va="center")
    return panel


def _decades(values: Floats) -> tuple[float, float]:
    """Limits of a logarithmic axis that holds positive values."""
    low, high = log10(values.min()), log10(values.max())
    room = max(0.06 * (high - low), 0.15)
    return low - room, high + room


def _ticks(limits: tuple[float, float], most: int) -> Ticks:
    """Whole powers of ten within limits, at most so many."""
    powers = range(ceil(limits[0]), floor(limits[1]) + 1)
    powers = powers[:: max(1, ceil(len(powers) / most))]
    return [float(p) for p in powers], [factor_text(10.0**p) for p in powers]
