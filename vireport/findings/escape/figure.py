"""Figure of the mean time until kicks lead out of a motion, against their size: simulations and the law."""

from __future__ import annotations

from math import log
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vireport.figures.captions import pictured
from vireport.figures.layout import Entry, blank, finished
from vireport.figures.style import DASHED, Color, Look, Picture, style
from vireport.findings.escape.escape import Escape, MotionEscape
from vireport.findings.escape.lifetimes import Lifetime
from vireport.study.plan import AnyTask

HEIGHT = 3.0
"""Height of the panel with its ticks and labels [in]."""

FARTHEST = 60.0
"""Largest ln T, T in forcing periods, for which the axis is extended to the kicks of the scenario."""

SIMULATED: Look = {"color": Color.BLUE, "marker": "o", "markersize": 4.0, "linestyle": "none"}
LAW: Look = {"color": Color.BLACK, "linewidth": 1.0}
BEYOND: Look = {"color": Color.BLACK, "linewidth": 1.0, "linestyle": DASHED}
DESIGN: Look = {"color": Color.VERMILION, "marker": "D", "markersize": 5.0, "linestyle": "none"}


def picture(escape: Escape, name: AnyTask, templates: Path | None = None) -> Picture:
    """The figure, with its caption, of the motion with a law that lasts least; there must be one."""
    drawn = escape.drawn
    assert drawn is not None
    means = [level.mean for level in drawn.levels]
    facts = {
        "levels": len(means),
        "least_periods": min(means),
        "most_periods": max(means),
        "kick_m_s": escape.kick_m_s,
        "log_periods": drawn.log_periods,
        "extrapolated": drawn.extrapolated,
        "axis": drawn.log_periods <= FARTHEST,
    }
    return pictured(name, facts, figure_escape(drawn, escape.velocity_unit), templates)


def figure_escape(drawn: MotionEscape, velocity_unit: float) -> Figure:
    """Draw ln T, T the mean number of forcing periods, against 1/sigma^2 [s^2/m^2]; the unit of velocity is in m/s."""
    law = drawn.law
    assert law is not None
    simulated = [*drawn.levels, *([] if drawn.simulated is None else [drawn.simulated])]
    inverse = np.array([1 / level.kick**2 for level in simulated])
    last = max(float(inverse.max()), 1 / drawn.kick**2 if drawn.log_periods <= FARTHEST else 0.0)
    scale = velocity_unit**-2
    with style():
        figure, panels = blank(1)
        axes = panels[0, 0]
        for ends, look in (((inverse.min(), inverse.max()), LAW), ((inverse.max(), last), BEYOND)):
            line = np.array(ends)
            axes.plot(line * scale, law.offset + law.exponent * line, **look)
        for level in drawn.levels:
            _point(axes, level, scale, SIMULATED)
        marks: list[Entry] = [("simulated", SIMULATED), ("law for small kicks", LAW)]
        if drawn.simulated is not None:
            _point(axes, drawn.simulated, scale, DESIGN)
        elif drawn.log_periods <= FARTHEST:
            axes.plot(scale / drawn.kick**2, drawn.log_periods, **DESIGN)
        if drawn.simulated is not None or drawn.log_periods <= FARTHEST:
            marks.append(("kicks of the scenario", DESIGN))
        axes.set(xlabel="1/σ² [s²/m²]", ylabel="ln T, T in forcing periods")
        return finished(figure, HEIGHT, [], [marks])


def _point(axes: Axes, level: Lifetime, scale: float, look: Look) -> None:
    """Draw the mean time of a simulation with its 95 % interval; `scale` converts 1/sigma^2 from y_c^-2 to s^2/m^2."""
    at = scale / level.kick**2
    low, high = level.interval
    axes.plot([at, at], [log(low), log(high)], color=look["color"], linewidth=1.0)
    axes.plot(at, log(level.mean), **look)
