"""Several scenarios on one axis: impact velocity and mean voltage along what they sweep, a colour for each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vireport.design.point import DesignPoint
from vireport.figures.curves import DrawnCurve, Floats, joined
from vireport.figures.labels import Label
from vireport.figures.layout import (
    MARGIN_X,
    Entry,
    blank,
    finished,
    fit_vertically,
    folded,
    prefix,
    round_ticks,
    widened,
)
from vireport.figures.style import (
    Color,
    Look,
    literal,
    sheet,
    style,
)
from vireport.figures.sweeps import (
    DESIGN,
    MARKERS,
    POINT,
    Drawing,
    of_stability,
    point_legend,
    stability_legend,
)
from vireport.figures.ticks import set_ticks
from vireport.motions.branches import Branch
from vireport.scenario.parameters import Parameter
from vireport.text.formatting import PREFIXES

SCENARIO_COLORS = (
    *(Color.BLUE, Color.VERMILION, Color.GREEN, Color.PURPLE),
    *(Color.ORANGE, Color.SKY, Color.BLACK, Color.GREY),
)
"""Colours of the scenarios; there are no more in one figure than colours that can be told apart."""

HEIGHT, AXIS = 2.5, 0.55
"""Heights of a panel, and of the ticks and the label below the last one [in]."""

WIDTH: Look = {"linewidth": 1.6}
LABELLED = 12
"""Places along a curve at which its number may stand."""

SMALLER: Look = {"markersize": 6.5}
"""Size of the design points, of which there are several."""

Values = Callable[[Drawing, Branch | DesignPoint], Floats | None]


def overlay(drawings: Mapping[str, Drawing], over: Parameter | None) -> Figure:
    """Draw the motions of scenarios over one another, with the numbers of the legend beside the curves.

    Voltages are those of scenarios with stable motion, where there is one: another would only flatten their axis.

    Parameters
    ----------
    drawings : mapping of str to Drawing
        By the names of the scenarios; as many as `SCENARIO_COLORS` at most.
    over : Parameter or None
        What all sweep; None for d.
    """
    drawn, looks = list(drawings.values()), [{"color": color} for color in SCENARIO_COLORS]
    rows: list[tuple[str, Values]] = [("impact velocity, bottom [m/s]", _speed)]
    steady = [drawing for drawing in drawn if has_stable(drawing)] or drawn
    volts = [
        voltages.average_v
        for drawing in steady
        for part in drawing.parts
        if (voltages := part.branch.voltages_by_motion) is not None
    ]
    if volts:
        power = prefix(volts)
        label = f"mean voltage Uₐᵥₑ [{PREFIXES[power]}V]"
        rows.append((label, lambda one, motions: _voltage(motions, power) if one in steady else None))
    with style():
        figure, panels = blank(len(rows), sharex="col")
        labels = []
        for (label, values), axes in zip(rows, panels[:, 0], strict=True):
            axes.set_ylabel(label)
            curves = [_draw(axes, x, over, values, look) for x, look in zip(drawn, looks, strict=False)]
            numbered = enumerate(zip(curves, SCENARIO_COLORS, strict=False), 1)
            labels.append((axes, [Label(str(k), x, y, color=color) for k, ((x, y), color) in numbered]))
            fit_vertically([axes])
        _dress(panels[-1, 0], drawn, over)
        letters = sheet().letters(sheet().across)
        names = (folded(f"{k} {literal(name)}", letters) for k, name in enumerate(drawings, 1))
        scenarios: list[Entry] = [(name, look | WIDTH) for name, look in zip(names, looks, strict=False)]
        legends = [[*scenarios, *stability_legend(drawn), *point_legend(drawn)]]
        return finished(figure, HEIGHT * len(rows) + AXIS, [], legends, labels, panels[:, 0])


def has_stable(drawing: Drawing) -> bool:
    """Whether a scenario has stable motion along its sweep."""
    return any(part.stable for part in drawing.parts)


def _speed(drawing: Drawing, motions: Branch | DesignPoint) -> Floats:
    device, impacts = drawing.study.solution.device, motions.motions
    return np.asarray(
        device.velocity_unit(drawing.axis.sweep.parameter, impacts.sweep_value) * np.abs(impacts.velocity_bottom)
    )


def _voltage(motions: Branch | DesignPoint, power: int) -> Floats | None:
    return None if motions.voltages_by_motion is None else motions.voltages_by_motion.average_v / 10.0**power


def _at(motions: Branch | DesignPoint, over: Parameter | None) -> Floats:
    return np.asarray(motions.motions.d if over is None else motions.motions.sweep_value)


def _draw(axes: Axes, drawing: Drawing, over: Parameter | None, values: Values, look: Look) -> DrawnCurve:
    """Draw the motions of one scenario; return where its number may stand: on its longest stable stretch, if any."""
    stretches = []
    for stable in (False, True):
        parts = [
            (_at(part.branch, over)[part.rows], y[part.rows])
            for part in drawing.parts
            if part.stable is stable and (y := values(drawing, part.branch)) is not None
        ]
        if parts:
            drawn = of_stability(look | WIDTH, stable)
            axes.add_artist(Line2D(*joined(parts), **drawn))
        for x, y in parts:
            axes.update_datalim(np.column_stack([x, y]))
            stretches.append((stable, float(np.ptp(x)), x, y))
    for event in drawing.events:
        for branch, row in event.places:
            if (y := values(drawing, branch)) is not None:
                marker = POINT | MARKERS[event.point.event] | look
                axes.add_artist(Line2D([_at(branch, over)[row]], [y[row]], **marker))
    design = drawing.study.solution.design
    if design is not None and drawing.design_at is not None and (y := values(drawing, design)) is not None:
        chosen = design.motions.stable_mask
        marker = DESIGN | SMALLER | {"markerfacecolor": look["color"]}
        axes.add_artist(Line2D(_at(design, over)[chosen], y[chosen], **marker))
    *_, x, y = max(stretches, key=lambda stretch: stretch[:2], default=(False, 0.0, np.empty(0), np.empty(0)))
    step = max(len(x) // LABELLED, 1)
    return x[::-step], y[::-step]


def _dress(axes: Axes, drawings: Sequence[Drawing], over: Parameter | None) -> None:
    """Give the axis along the sweeps, which holds all of them, its limits, ticks and label."""
    sweeps = [drawing.axis.sweep for drawing in drawings]
    ends = [(sweep.start, sweep.end) if over is not None else sweep.coordinate_range for sweep in sweeps]
    low, high = (float(choose(np.ravel(ends))) for choose in (np.min, np.max))
    axes.set_xlim(*widened(low, high, MARGIN_X))
    set_ticks(axes.xaxis, *round_ticks(low, high, sheet().across))
    swept = "distance d = 4 M s f² / F [–]" if over is None else over.label
    axes.set_xlabel(swept)
