"""Figures, with captions, of what shocks to the motion at the design point and impacts on the bottom lead to."""

from __future__ import annotations

from itertools import cycle, islice
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from vireport.base.errors import NumericalError
from vireport.figures.captions import pictured
from vireport.figures.layout import Entry, blank, finished
from vireport.figures.style import GUIDE, Color, Look, Picture, Pixel, style
from vireport.findings.outcomes.basin import Basins
from vireport.findings.outcomes.manifold import ShockLine
from vireport.findings.outcomes.outcomes import Outcomes
from vireport.findings.outcomes.plane import OutcomePlane
from vireport.findings.outcomes.steps import FIGURE_BASIN, FIGURE_SHOCKS
from vireport.findings.outcomes.withstood import Withstood, shocks_around
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter
from vireport.simulation.events import BOTTOM

HEIGHT = 3.3
"""Height of the panel with its ticks and labels [in]."""

RETURNING = Pixel.LIGHT
"""Colour of shocks that return."""

OTHERS = Pixel.ORANGE, Pixel.PURPLE, Pixel.SKY, Pixel.GREEN, Pixel.GREY
"""Colours of those that lead elsewhere, in the order in which that was met."""

MANIFOLD: Look = {"color": Color.BLUE, "linewidth": 0.8}
LEAST: Look = {"color": Color.VERMILION, "linewidth": 2.2, "marker": "o", "markersize": 5.0, "markevery": [1]}


def shocks_picture(outcomes: Outcomes, device: Device, templates: Path | None = None) -> Picture | None:
    """The figure of the plane of shocks, captioned; None where no shock leads out, or ends cannot be told apart."""
    withstood, attracting = outcomes.withstood_in_use, outcomes.attracting
    if withstood is None or withstood.shock is None or attracting is None:
        return None
    groups = device.groups(Parameter.LENGTH, device.length_m).as_floats()
    try:
        plane, lines = shocks_around(groups, attracting.recognised, withstood.shock)
    except NumericalError:  # another stable motion is too near a critical point for its returns to be told
        return None
    if plane.share(0) == 1:
        return None
    facts = {
        "motion": withstood.shock.motion.word.name,
        "points": len(plane.x),
        "returned": plane.share(0),
        "largest_m_s": float(plane.y[-1]) * withstood.velocity_unit,
        "least_m_s": withstood.jump_m_s,
        "manifold": bool(lines),
        "outcomes": [(of.name, plane.share(number)) for number, of in enumerate(plane.outcomes)],
    }
    return pictured(FIGURE_SHOCKS, facts, figure_shocks(plane, lines, withstood), templates)


def figure_shocks(plane: OutcomePlane, lines: list[ShockLine], withstood: Withstood) -> Figure:
    """The plane of shocks: time within the period against the jump, coloured by outcome, with the least one."""
    unit, shock = withstood.velocity_unit, withstood.shock
    with style():
        figure, panels = blank(1)
        axes = panels[0, 0]
        # A forcing period lasts 2 t_c.
        right, top = plane.x[-1] / 2, plane.y[-1] * unit
        named = _coloured(axes, plane, (0.0, right, -top, top))
        for line in lines:
            axes.plot(line.time / 2, line.jump * unit, **MANIFOLD)
        marks: list[Entry] = [("onto the unstable motion", MANIFOLD)] if lines else []
        if shock is not None:
            for time in shock.motion.time - shock.motion.time[0]:
                axes.axvline(time / 2, **GUIDE)
            if shock.jump is not None:
                time = (shock.motion.time[shock.impact] - shock.motion.time[0] + shock.delay) / 2
                axes.plot([time, time], [0.0, shock.sign * shock.jump * unit], **LEAST)
                marks.append(("least shock", LEAST))
        axes.set(xlabel="moment after the first impact [forcing periods]", ylabel="jump of the velocity [m/s]")
        return finished(figure, HEIGHT, [], [named, marks])


def _coloured(axes: Axes, plane: OutcomePlane, extent: tuple[float, float, float, float]) -> list[Entry]:
    """Colour a plane by its outcomes; returns the entries of the legend."""
    colors = [RETURNING, *islice(cycle(OTHERS), len(plane.outcomes) - 1)]
    image = np.array([to_rgb(color) for color in colors])[plane.outcome]
    axes.imshow(image, extent=extent, origin="lower", aspect="auto", interpolation="nearest")
    axes.set(xlim=extent[:2], ylim=extent[2:])
    present = [number for number in range(len(colors)) if plane.share(number)]
    return [(plane.outcomes[k].name, {"color": colors[k], "linewidth": 5.0}) for k in present]


MOTION: Look = {
    "color": Pixel.BLACK,
    "linestyle": "none",
    "marker": "o",
    "markersize": 5.0,
    "markeredgecolor": Pixel.WHITE,
    "markeredgewidth": 0.8,
}


def basin_picture(basins: Basins, templates: Path | None = None) -> Picture:
    """The figure of the basins with its caption."""
    facts = {
        "points": len(basins.plane.x),
        "fastest_m_s": basins.fastest_m_s,
        "marked": bool(basins.motions),
        "shares": basins.shares,
    }
    return pictured(FIGURE_BASIN, facts, figure_basin(basins), templates)


def figure_basin(basins: Basins) -> Figure:
    """Phase against velocity just before the impact, coloured by what it leads to, with the motions' own impacts."""
    plane = basins.plane
    with style():
        figure, panels = blank(1)
        axes = panels[0, 0]
        named = _coloured(axes, plane, (0.0, 360.0, 0.0, basins.fastest_m_s))
        for motion in basins.motions:
            bottom = np.array(motion.word.walls) == BOTTOM
            velocity = motion.velocity[bottom] * basins.velocity_unit
            axes.plot(np.degrees(motion.phase[bottom]) % 360, velocity, **MOTION)
        marks: list[Entry] = [("stable motion", MOTION)] if basins.motions else []
        axes.set(xticks=range(0, 361, 60))
        axes.set(xlabel="forcing phase at the bottom impact [°]", ylabel="velocity just before [m/s]")
        return finished(figure, HEIGHT, [], [named, marks])
