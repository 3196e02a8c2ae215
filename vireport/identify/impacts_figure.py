"""Measured impacts: by how much the time of each differs from the fit's, or where nothing fits, when each comes.

Without a fit, impacts stand at their places within the period of the force.
"""

from __future__ import annotations

from math import ceil
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from vireport.base.shares import NORMAL_95
from vireport.figures.curves import Floats
from vireport.figures.layout import MARGIN_X, blank, finished, fit_vertically, prefix, widened
from vireport.figures.style import GUIDE, Color, Look, NotebookFigure, Picture, style
from vireport.identify.record_figure import BOTTOM, TOP
from vireport.measurement.identification import Fitted
from vireport.measurement.inquiry import Identification
from vireport.measurement.records import Record
from vireport.text.formatting import PREFIXES
from vireport.text.templates import Words

HEIGHT, HIGHER = 1.25, 1.35
"""Of the panel of a membrane, and how much higher it is on the first page of a PDF [in]."""

MOST_DRAWN = 3000
"""Impacts beyond which only every second, third, ... is drawn."""

NAME = "figure-impacts"
SIDES = ("top", -1.0, TOP), ("bottom", 1.0, BOTTOM)
BAND: Look = {"color": Color.FILL_A, "alpha": 0.6, "linewidth": 0, "zorder": 0.5}


def impacts_picture(answer: Identification, record: Record, templates: Path | None = None) -> Picture:
    """Draw the timing errors of impacts, or without a fit their phases, with title and caption.

    Parameters
    ----------
    answer : Identification
    record : Record
        That was answered from.
    templates : Path, optional
        A folder whose words come before the package's own.
    """
    words = Words("figures/impacts", templates)
    fitted = answer.fit if isinstance(answer.fit, Fitted) else None
    kind = "phases" if fitted is None else "errors"

    facts = {
        "impacts": len(record.times) if fitted is None else len(fitted.kept),
        "every": _every(len(record.times)),
        "weighted": record.errors is not None,
        "name": Path(record.name).name,
    }
    title, caption, alt = (words(f"figure_impacts_{kind}_{part}", facts) for part in ("title", "caption", "alt"))
    drawn = figure_phases(answer, record) if fitted is None else figure_errors(fitted, answer.origin_s)
    return Picture(NAME, title, caption, alt, drawn, on_paper=HIGHER * len(SIDES))


def figure_errors(fitted: Fitted, origin_s: float) -> Figure:
    """What each time has over the fitted one, a panel for each membrane, with the band of the timing error.

    Times with standard errors of their own are compared in units of these, counted in that of the median impact.
    """
    kept = fitted.kept
    errors = fitted.adjusted.errors / kept.errors
    power = prefix([errors])
    reach = NORMAL_95 * fitted.adjusted.timing_error_s / 10.0**power
    with style():
        figure, panels = _panels(kept.times + origin_s, kept.walls, errors / 10.0**power)
        for axes in panels:
            axes.axhspan(-reach, reach, **BAND)
            axes.axhline(0.0, **GUIDE)
            axes.set_ylabel(f"error [{PREFIXES[power]}s]")
            _label(axes, reach, "95 %", Color.GREY)
        fit_vertically(panels, 4)
        return finished(figure, HEIGHT * len(SIDES), [], [], aligned=panels)


def figure_phases(answer: Identification, record: Record) -> Figure:
    """The place of each impact within the period of the force, a panel for each membrane."""
    times = record.times - answer.origin_s
    phases = times * float(answer.inquiry.model.device.frequency_hz) % 1
    with style():
        figure, panels = _panels(record.times, record.walls, phases)
        for axes in panels:
            axes.set(ylim=(0, 1), ylabel="phase [periods]")
        return finished(figure, HEIGHT * len(SIDES), [], [], aligned=panels)


def _panels(times: Floats, walls: Floats, y: Floats) -> tuple[NotebookFigure, list[Any]]:
    """A panel for each membrane, as they are above one another, named on the right."""
    figure, panels = blank(len(SIDES), sharex=True, sharey=True)
    every = _every(len(times))
    for axes, (name, wall, look) in zip(panels[:, 0], SIDES, strict=True):
        mine = walls == wall
        axes.plot(times[mine][::every], y[mine][::every], **look | {"markersize": 2.0})
        axes.annotate(
            name, (1.0, 0.0), xycoords="axes fraction", xytext=(5, 1), textcoords="offset points", va="bottom",
            color=look["color"], annotation_clip=False,
        )  # fmt: skip
    panels[-1, 0].set(xlim=widened(times[0], times[-1], MARGIN_X), xlabel="time [s]")
    return figure, list(panels[:, 0])


def _label(axes: Any, height: float, text: str, color: str) -> None:
    """Write a text on the right of a panel, at a height of its axis."""
    axes.annotate(
        text, (1.0, height), xycoords=axes.get_yaxis_transform(), xytext=(5, 0), textcoords="offset points",
        va="center", color=color, annotation_clip=False,
    )  # fmt: skip


def _every(count: int) -> int:
    """The step between the impacts that are drawn, of so many in all."""
    return max(1, ceil(count / MOST_DRAWN))
