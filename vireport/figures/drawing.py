"""What the figures share beyond their axes: looks of lines and markers, design point, critical points."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from vireport.analysis import Branch
from vireport.figures.axes import (
    BLACK,
    BLUE,
    DASH_DOTTED,
    DASHED,
    DOTTED,
    GREEN,
    GREY,
    LETTERS_ALONG,
    LIGHT,
    SOLID,
    SPARSE,
    VERMILION,
    WARNING,
    along,
)
from vireport.figures.captions import conditions
from vireport.figures.curves import Curve, Event, Floats, Simulated, Stretch, events, solved, stretches
from vireport.figures.panel import Panel
from vireport.figures.sheet import Entry, Sheet, sheet
from vireport.study import Study

Look = dict[str, Any]

# Width tells the two impacts apart where colour does not, and where one curve lies on the other.
BOTTOM: Look = {"color": BLUE, "linewidth": 2.8}
TOP: Look = {"color": GREEN, "linewidth": 1.2}
STABLE: Look = {"linestyle": SOLID, "zorder": 2.5}
UNSTABLE: Look = {"linestyle": DASH_DOTTED, "zorder": 2.2}

AVERAGE: Look = {"color": VERMILION, "linewidth": 3.8, "linestyle": SOLID}
BOTTOM_VOLTAGE: Look = {"color": BLUE, "linewidth": 1.3, "linestyle": SOLID}
TOP_VOLTAGE: Look = {"color": BLUE, "linewidth": 1.3, "linestyle": DASHED}
UNSTABLE_VOLTAGE: Look = {"linestyle": DOTTED, "zorder": 2.2}
UNSTABLE_TOP_VOLTAGE: Look = UNSTABLE_VOLTAGE | {"linestyle": SPARSE}

BOUND: Look = {"color": VERMILION, "linewidth": 0.8, "linestyle": (0, (8, 2, 1, 2)), "zorder": 1.5}
DESIGN: Look = {"color": GREY, "linewidth": 0.9, "linestyle": (0, (2, 2)), "zorder": 1.4}
GUIDE: Look = {"color": LIGHT, "linewidth": 0.6, "zorder": 1.0}

POINT: Look = {
    "color": BLACK,
    "markersize": 5.0,
    "markeredgewidth": 0.5,
    "markeredgecolor": "white",
    "linestyle": "none",
    "zorder": 4.0,
}
CHOSEN: Look = {
    "marker": "P",
    "markersize": 6.5,
    "markeredgecolor": BLACK,
    "markeredgewidth": 0.6,
    "linestyle": "none",
    "zorder": 4.5,
}
CIRCLE: Look = {
    "marker": "o", "markersize": 4.5, "markerfacecolor": "none", "markeredgecolor": BLACK,
    "markeredgewidth": 0.8, "linestyle": "none", "zorder": 3.5,
}  # fmt: skip
STAR: Look = CIRCLE | {
    "marker": "*",
    "markersize": 8.5,
    "markerfacecolor": "white",
    "markeredgecolor": WARNING,
}

ROOM_FOR = 60
"""Simulated points beside one another up to which their markers have their full size."""

MARKERS: dict[str, Look] = {
    "node_focus": {"marker": "o"},
    "period_doubling": {"marker": "s"},
    "fold": {"marker": "d", "markersize": 6.5},
    "pitchfork": {"marker": "D"},
    "grazing": {"marker": "^", "markersize": 6.0},
}

NO_MOTION = "no admissible 1:1 motion in this sweep"


def crowded(look: Look, simulated: Simulated | None) -> Look:
    """The look of markers along the sweep, smaller where they are many, so that the curve beneath is seen."""
    points = len(np.unique(simulated.sweep_value)) if simulated else 0
    scale = max(min(1.0, (ROOM_FOR / max(points, 1)) ** 0.5), 0.4)
    return look | {key: look[key] * scale for key in ("markersize", "markeredgewidth")}


def point_legend(found: Iterable[Event]) -> list[Entry]:
    """The markers of the kinds of critical points that occur."""
    kinds = dict.fromkeys(event.point.kind for event in found)
    points: list[Entry] = [(f"{kind.letter} {kind.words}", POINT | MARKERS[kind]) for kind in kinds]
    return sorted(points, key=lambda entry: entry[0])


class Drawing:
    """A study being drawn: its axis along the sweep, its motions and its critical points.

    Parameters
    ----------
    study : Study
        With a sweep.
    room : int
        How many letters of the small size fit along the axis.
    """

    def __init__(self, study: Study, room: int = LETTERS_ALONG) -> None:
        self.study = study
        self.solution, sweep = solved(study)
        self.along = along(sweep, room)
        self.parts = stretches(self.solution)
        self.events = events(self.solution)

    def x(self, part: Stretch) -> Floats:
        """Where the motions of a stretch stand along the sweep."""
        return self.along.of(part.branch.motions)[part.rows]

    def sheet(self, panels: int, panel_height: float, legend: Sequence[Entry], note: str = "") -> Sheet:
        """A sheet with the conditions, a note if there is one, and the legend, the critical points in it."""
        head = [(conditions(self.study), BLACK)] + ([(note, WARNING)] if note else [])
        return sheet(self.along, panels, panel_height, head, [legend, point_legend(self.events)])

    def curves(self, panel: Panel, choose: Callable[[Stretch], Sequence[Curve]], stable: bool, look: Look) -> None:
        """Draw the curves chosen of each stretch that is stable, or of each that is not, with one look."""
        panel.curves([curve for part in self.parts if part.stable == stable for curve in choose(part)], **look)

    def design(self, panel: Panel, values: Sequence[Floats], colors: Sequence[str]) -> None:
        """Mark the design point, and the values of its motions; open where they are unstable."""
        design, device = self.study.solution.design, self.study.solution.device
        if design is None:
            return
        at = design.value if self.along.by_value else float(device.groups(design.parameter, design.value)[0])
        if not self.along.low <= at <= self.along.high:
            return
        panel.upright(np.array([at]), **DESIGN)
        motions = design.motions
        for value, color in zip(values, colors, strict=True):
            for chosen, face in ((motions.admissible & ~motions.stable, "white"), (motions.stable, color)):
                panel.marks(np.full(int(chosen.sum()), at), value[chosen], markerfacecolor=face, **CHOSEN)
        if panel.first:
            panel.tag("design", at)

    def letters(self, panel: Panel, values: Callable[[Branch], Sequence[Floats]]) -> None:
        """Mark the critical points on all curves of a panel, and letter each of them once."""
        if not self.parts:
            panel.say(NO_MOTION)
            return
        found = []
        for event in self.events:
            x = np.array([self.along.of(branch.motions)[row] for branch, row in event.places])
            each = np.array([[value[row] for value in values(branch)] for branch, row in event.places])
            found.append((event, np.repeat(x, each.shape[1]), each.ravel()))
        if found:
            panel.upright(np.unique(np.concatenate([x for _, x, _ in found])), **GUIDE)
        for kind in dict.fromkeys(event.point.kind for event, _, _ in found):
            x, y = (np.concatenate([entry[k] for entry in found if entry[0].point.kind is kind]) for k in (1, 2))
            panel.marks(x, y, **POINT | MARKERS[kind])
        panel.letters([(event.point.label, x, y) for event, x, y in found])
