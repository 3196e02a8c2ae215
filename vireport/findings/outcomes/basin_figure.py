"""Basins of attraction on the section of impacts on the bottom membrane, with its words."""

from __future__ import annotations

from itertools import cycle, islice
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from vireport.figures.captions import pictured
from vireport.figures.layout import Entry, blank, finished
from vireport.figures.style import Look, Picture, Pixel, style
from vireport.findings.outcomes.basin import Basins
from vireport.findings.outcomes.shocks_figure import HEIGHT, OTHERS, RETURNING
from vireport.findings.outcomes.steps import FIGURE_BASIN
from vireport.simulation.events import BOTTOM

MOTION: Look = {
    "color": Pixel.BLACK,
    "linestyle": "none",
    "marker": "o",
    "markersize": 5.0,
    "markeredgecolor": Pixel.WHITE,
    "markeredgewidth": 0.8,
}


def picture(basins: Basins, templates: Path | None = None) -> Picture:
    """The figure with its words."""
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
    colors = [RETURNING, *islice(cycle(OTHERS), len(plane.outcomes) - 1)]
    with style():
        figure, panels = blank(1)
        axes = panels[0, 0]
        image = np.array([to_rgb(color) for color in colors])[plane.outcome]
        extent = (0.0, 360.0, 0.0, basins.fastest_m_s)
        axes.imshow(image, extent=extent, origin="lower", aspect="auto", interpolation="nearest")
        for motion in basins.motions:
            bottom = np.array(motion.word.walls) == BOTTOM
            velocity = motion.velocity[bottom] * basins.velocity_unit
            axes.plot(np.degrees(motion.phase[bottom]) % 360, velocity, **MOTION)
        present = [number for number in range(len(colors)) if plane.share(number)]
        named: list[Entry] = [(plane.outcomes[k].name, {"color": colors[k], "linewidth": 5.0}) for k in present]
        marks: list[Entry] = [("stable motion", MOTION)] if basins.motions else []
        axes.set(xlim=extent[:2], ylim=extent[2:], xticks=range(0, 361, 60))
        axes.set(xlabel="forcing phase at the bottom impact [°]", ylabel="velocity just before [m/s]")
        return finished(figure, HEIGHT, [], [named, marks])
