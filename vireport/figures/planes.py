"""The design point with its margins in a plane of two inputs, as charts and maps mark it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from vireport.figures.style import HALO, Color, Look

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
