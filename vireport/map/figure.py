"""The drawing of a plane of two inputs: axes with ticks and units, the design point with its margins, the legend.

What fills the plane is drawn by `chart` and by `cells`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vireport.design.plane import Plane
from vireport.figures.alongside import Paper
from vireport.figures.layout import Entry, blank, finished, panel_size, round_ticks
from vireport.figures.style import HALO, Color, Look, NotebookFigure, sheet
from vireport.map.design import MapDesign
from vireport.text.formatting import ROUGHLY
from vireport.text.templates import Words

HEIGHT = 4.1
"""Height of the panel with its axes, at the width of a report's figures [in]."""


def panel_height() -> float:
    """Height of the panel with its axes on the sheet [in]."""
    return HEIGHT * min(1.0, sheet().width / 5)


def plane_panel(plane: Plane, scale_width: float = 0.0) -> tuple[NotebookFigure, Axes]:
    """A figure with the axes of a plane: its ranges, round ticks, and names with symbols and units.

    Parameters
    ----------
    plane : Plane
    scale_width : float
        Width that a scale of colours takes beside the panel [in].
    """
    figure, ((axes,),) = blank(1)
    axes.set(xlim=(plane.low[0], plane.high[0]), ylim=(plane.low[1], plane.high[1]))
    for axis, k, room in ((axes.xaxis, 0, sheet().across - scale_width), (axes.yaxis, 1, panel_height())):
        axis.set_ticks(*round_ticks(float(plane.low[k]), float(plane.high[k]), room))
        axis.set_label_text(plane.inputs[k].label)
    return figure, axes


def paper_of(axes: Axes) -> Paper:
    """The panel as it is written on, once its axes are final."""
    return Paper(axes, panel_size(axes, panel_height()))


def mark_on_plane(
    paper: Paper, plane: Plane, design: MapDesign | None, said: Words, on_pixels: bool = False, **look: object
) -> list[Entry]:
    """Draw a design point with the nearer margin along each input; what the legend must say of it.

    Parameters
    ----------
    paper : Paper
    plane : Plane
    design : MapDesign or None
        None where there is none, or it has no place in the plane.
    said : Words
    on_pixels : bool
        Whether cells lie behind it, which may be as dark as the bars.
    """
    if design is None:
        return []
    nearest = [margin for axis in (0, 1) if (margin := design.nearest(axis)) is not None]
    ends = mark_design(paper.axes, design.inputs, [(margin.axis, margin.value) for margin in nearest], on_pixels)
    texts = [plane.inputs[margin.axis].signed(margin.distance, ROUGHLY) for margin in nearest]
    named = paper.mark(design.inputs, ends, texts, said("design_point"), **look)
    return [] if named else [(said("design_point"), DESIGN | {"markersize": 6.0})]


def plane_finished(figure: NotebookFigure, legends: Sequence[Sequence[Entry]], warning: str = "") -> Figure:
    """Lay the figure out under its legends, and under a warning if there is one."""
    return finished(figure, panel_height(), [(warning, Color.WARNING)] if warning else [], legends)


DESIGN: Look = {
    "linestyle": "none", "marker": "P", "markersize": 9.0, "zorder": 4.0,
    "markerfacecolor": Color.WHITE, "markeredgecolor": Color.BLACK, "markeredgewidth": 1.2,
}  # fmt: skip

BAR: Look = {"color": Color.BLACK, "linewidth": 1.1, "zorder": 3.5}
CAP: Look = BAR | {"marker": "o", "markersize": 3.6, "markerfacecolor": Color.WHITE, "linestyle": "none", "zorder": 3.6}
"""Look of a margin, and of the place where it ends."""

BEHIND: Look = {"color": Color.WHITE, "linewidth": HALO, "zorder": 3.4, "solid_capstyle": "round"}
"""Look of the white behind a margin, where it lies on the pixels of a map."""


def mark_design(
    axes: Axes, at: Sequence[float], ends: Iterable[tuple[int, float]], on_pixels: bool = False
) -> list[tuple[float, float]]:
    """Draw a design point, and a bar to each end of its motion: with an arrow where that is beyond the frame.

    Parameters
    ----------
    axes : Axes
        With its final limits.
    at : sequence of float
        The design point.
    ends : iterable of (int, float)
        Along which of the two inputs, and the value of that input there.
    on_pixels : bool
        Whether there is a map behind it, which may be as dark as the bars.

    Returns
    -------
    list of (float, float)
        Where each bar ends, within the frame.
    """
    axes.add_artist(Line2D(*np.array(at)[:, None], **DESIGN))
    marked = []
    for varied, value in ends:
        end, limits = np.array(at, dtype=float), (axes.get_xlim(), axes.get_ylim())[varied]
        end[varied] = np.clip(value, min(limits), max(limits))
        if on_pixels:
            axes.add_artist(Line2D(*np.array([at, end]).T, **BEHIND))
        axes.add_artist(Line2D(*np.array([at, end]).T, **BAR))
        onward = (("<", ">"), ("v", "^"))[varied][value > at[varied]]
        beyond: Look = {} if end[varied] == value else {"marker": onward, "markersize": 6.0}
        axes.add_artist(Line2D(*end[:, None], **CAP | beyond))
        marked.append((float(end[0]), float(end[1])))
    return marked
