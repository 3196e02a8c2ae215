"""What shocks to the motion at the design point lead to, in the plane of their moment and size, with its words."""

from __future__ import annotations

from itertools import cycle, islice
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from vireport.base.errors import NumericalError
from vireport.figures.captions import pictured
from vireport.figures.layout import Entry, blank, finished
from vireport.figures.style import GUIDE, Color, Look, Picture, Pixel, style
from vireport.findings.outcomes.manifold import ShockLine
from vireport.findings.outcomes.outcomes import Outcomes
from vireport.findings.outcomes.plane import OutcomePlane
from vireport.findings.outcomes.steps import FIGURE_SHOCKS
from vireport.findings.outcomes.withstood import Withstood, shocks_around
from vireport.physics.device import Device
from vireport.scenario.parameters import Parameter

HEIGHT = 3.3
"""Height of the panel with its ticks and labels [in]."""

RETURNING = Pixel.LIGHT
"""Colour of shocks that return."""

OTHERS = Pixel.ORANGE, Pixel.PURPLE, Pixel.SKY, Pixel.GREEN, Pixel.GREY
"""Colours of those that lead elsewhere, in the order in which that was met."""

MANIFOLD: Look = {"color": Color.BLUE, "linewidth": 0.8}
LEAST: Look = {"color": Color.VERMILION, "linewidth": 2.2, "marker": "o", "markersize": 5.0, "markevery": [1]}


def picture(outcomes: Outcomes, device: Device, templates: Path | None = None) -> Picture | None:
    """The figure with its words; None where no shock leads out, or what they lead to is not told apart."""
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
    colors = [RETURNING, *islice(cycle(OTHERS), len(plane.outcomes) - 1)]
    present = [number for number in range(len(colors)) if plane.share(number)]
    with style():
        figure, panels = blank(1)
        axes = panels[0, 0]
        # Forcing periods last two units of time.
        right, top = plane.x[-1] / 2, plane.y[-1] * unit
        image = np.array([to_rgb(color) for color in colors])[plane.outcome]
        axes.imshow(image, extent=(0.0, right, -top, top), origin="lower", aspect="auto", interpolation="nearest")
        for line in lines:
            axes.plot(line.time / 2, line.jump * unit, **MANIFOLD)
        named: list[Entry] = [(plane.outcomes[k].name, {"color": colors[k], "linewidth": 5.0}) for k in present]
        marks: list[Entry] = [("onto the unstable motion", MANIFOLD)] if lines else []
        if shock is not None:
            for time in shock.motion.time - shock.motion.time[0]:
                axes.axvline(time / 2, **GUIDE)
            if shock.jump is not None:
                time = (shock.motion.time[shock.impact] - shock.motion.time[0] + shock.delay) / 2
                axes.plot([time, time], [0.0, shock.sign * shock.jump * unit], **LEAST)
                marks.append(("least shock", LEAST))
        axes.set(xlim=(0.0, right), ylim=(-top, top))
        axes.set(xlabel="moment after the first impact [forcing periods]", ylabel="jump of the velocity [m/s]")
        return finished(figure, HEIGHT, [], [named, marks])
