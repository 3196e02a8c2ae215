"""Figure, with caption, of solvers on stiff membranes, and of how the compliant motion tends to the rigid one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vireport.figures.captions import pictured
from vireport.figures.labels import Label
from vireport.figures.layout import Entry, blank, finished
from vireport.figures.style import DASHED, GUIDE, Color, Look, Picture, style
from vireport.findings.membranes.compliance import Compliance
from vireport.findings.membranes.solvers import ADAPTIVE, FIXED, WRONG, RunOutcome
from vireport.findings.membranes.tables import quantity_label
from vireport.study.plan import AnyTask
from vireport.text.formatting import factor_text

HEIGHTS = 3.4, 2.7
"""Heights of the panels with their ticks and labels [in]."""

MARKERS = dict(zip((FIXED, *ADAPTIVE), ("x", "o", "s", "^", "D"), strict=True))
STIFFNESSES = (Color.BLUE, Color.ORANGE, Color.VERMILION)
SIZES = (3.6, 5.0, 6.8)
MARK: Look = {"linestyle": "none", "markersize": 5.0, "markeredgewidth": 1.0, "zorder": 3.0}
HOLLOW = {"markerfacecolor": "white"}
QUANTITIES = {"velocity": (Color.BLUE, "o"), "phase": (Color.GREEN, "s"), "critical value": (Color.PURPLE, "^")}
THEORY: Look = {"color": Color.GREY, "linewidth": 0.9, "linestyle": DASHED, "zorder": 2.2}

SMALLEST, LARGEST = 1e-16, 10.0
"""Errors as which smaller and larger ones are drawn, the larger one also where a run did not reach the end."""

SMALLEST_ON_AXIS = 1e-3
"""The axis of errors reaches down at least to here."""


def figure_stiffness(comparison: Compliance) -> Figure:
    """Draw the errors of solvers over run time at three stiffnesses, and the distance from the rigid motion over K.

    Parameters
    ----------
    comparison : Compliance
        With runs of solvers.
    """
    factors = drawn_factors(comparison)
    solvers: list[Entry] = [(name, MARK | {"marker": marker, "color": Color.BLACK}) for name, marker in MARKERS.items()]
    colors: list[Entry] = [
        (f"K times {factor_text(f)}", MARK | {"marker": "o", "color": color, "markersize": size})
        for f, color, size in zip(factors, STIFFNESSES, SIZES, strict=False)
    ]
    colors.append(("hollow or at the top: failed", MARK | HOLLOW | {"marker": "o", "color": Color.BLACK}))
    with style():
        figure, panels = blank(2, height_ratios=HEIGHTS)
        (errors, rates) = panels[:, 0]
        for axes, letter in ((errors, "a"), (rates, "b")):
            axes.set_title(f"({letter})", loc="left")
            axes.set_xscale("log")
            axes.set_yscale("log")
            for axis in (axes.xaxis, axes.yaxis):
                axis.set_major_formatter(lambda value, _: factor_text(value))
        _errors(errors, comparison, factors)
        names = _rates(rates, comparison)
        return finished(figure, sum(HEIGHTS), [], [solvers, colors], [(rates, names)], [errors, rates])


def picture(comparison: Compliance, name: AnyTask, templates: Path | None = None) -> Picture:
    """The figure of solvers and rates with its caption."""
    drawn = {
        "wrong": WRONG,
        "order": comparison.order,
        "failed": list(dict.fromkeys(run.solver for run in comparison.runs if run.outcome is not RunOutcome.SOLVED)),
        "exponents": [
            (quantity_label(comparison, quantity), quantity.exponent)
            for quantity in comparison.convergence
            if quantity.exponent
        ],
    }
    return pictured(name, drawn, figure_stiffness(comparison), templates)


def drawn_factors(comparison: Compliance) -> list[float]:
    """The softest, middle and stiffest membrane that solvers were tried on."""
    factors = sorted({run.factor for run in comparison.runs})
    return sorted({factors[0], factors[len(factors) // 2], factors[-1]}) if factors else []


def _errors(axes: Axes, comparison: Compliance, factors: list[float]) -> None:
    axes.set_xlabel("run time [ms]")
    axes.set_ylabel("error at the end of the period [–]")
    for run in comparison.runs:
        if run.factor in factors:
            k = factors.index(run.factor)
            look = MARK | {"marker": MARKERS[run.solver], "color": STIFFNESSES[k], "markersize": SIZES[k]}
            look |= {} if run.outcome is RunOutcome.SOLVED else HOLLOW
            height = LARGEST if run.error is None else min(max(run.error, SMALLEST), LARGEST)
            axes.plot(1e3 * run.seconds, height, **look)
    axes.axhline(WRONG, **GUIDE)
    axes.set_ylim(min(axes.get_ylim()[0], SMALLEST_ON_AXIS), 2 * LARGEST)
    axes.minorticks_off()


def _rates(axes: Axes, comparison: Compliance) -> list[Label]:
    """Draw the distances from rigid impacts, and return the names of the lines."""
    axes.set_xlabel("stiffness over the scenario's K [–]")
    axes.set_ylabel("distance from rigid [–], [rad]")
    names = []
    for quantity in comparison.convergence:
        at_rungs = zip(comparison.rungs, quantity.distances, strict=True)
        distances_by_factor = [(rung.factor, distance) for rung, distance in at_rungs if distance]
        if not distances_by_factor:
            continue
        factors, distances = np.array(distances_by_factor).T
        color, marker = QUANTITIES[quantity.quantity]
        # A line of the expected rate through the stiffest rung, where terms of higher order are least: where the points
        # leave it, the rate no longer holds.
        axes.plot(factors, distances[-1] * (factors / factors[-1]) ** -comparison.order, **THEORY)
        axes.plot(factors, distances, **MARK | {"color": color, "marker": marker})
        later = len(distances_by_factor) // 2
        names.append(Label(quantity_label(comparison, quantity), factors[later:], distances[later:]))
    axes.minorticks_off()
    return names
