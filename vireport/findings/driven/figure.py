"""Figure of the impacts under a recorded motion of the shaker, along the record, with its caption."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from vireport.figures.captions import pictured
from vireport.figures.layout import Entry, blank, finished, letter_of, title
from vireport.figures.style import DASHED, Color, Look, Picture, style
from vireport.findings.driven.driven import Driven
from vireport.study.plan import AnyTask

HEIGHT = 4.2
"""Height of both panels with their ticks and labels [in]."""

MOST_DRAWN = 8000
"""Impacts; of more, every so many."""

BOTTOM: Look = {"color": Color.BLUE, "marker": ".", "markersize": 2.5, "linestyle": "none"}
TOP: Look = {"color": Color.GREEN, "marker": ".", "markersize": 2.5, "linestyle": "none"}
PREDICTED: Look = {"color": Color.BLACK, "linewidth": 0.8, "linestyle": DASHED}


def picture(driven: Driven, name: AnyTask, templates: Path | None = None) -> Picture:
    """The figure of the impacts along the record, with its caption."""
    facts = {
        "impacts": len(driven.times_s),
        "every": _every(driven),
        "share": driven.share_of_1_1,
        "predicted": driven.predicted is not None,
    }
    return pictured(name, facts, figure_driven(driven), templates)


def _every(driven: Driven) -> int:
    return -(-max(len(driven.times_s), 1) // MOST_DRAWN)


def figure_driven(driven: Driven) -> Figure:
    """Draw speed and phase of each impact against the time of the record."""
    drawn = np.arange(len(driven.times_s)) % _every(driven) == 0
    with style():
        figure, panels = blank(2, sharex=True)
        speeds, phases = panels[:, 0]
        for wall, look in ((1.0, BOTTOM), (-1.0, TOP)):
            mine = drawn & (driven.walls == wall)
            speeds.plot(driven.times_s[mine], driven.speeds_m_s[mine], **look)
            phases.plot(driven.times_s[mine], driven.phases[mine] / (2 * np.pi), **look)
        legend: list[Entry] = [("bottom", BOTTOM), ("top", TOP)]
        if driven.predicted is not None:
            for speed in (driven.predicted.speed_bottom_m_s, driven.predicted.speed_top_m_s):
                speeds.axhline(speed, **PREDICTED)
            legend.append(("periodic motion", PREDICTED))
        speeds.set(ylabel="relative speed [m/s]", xlim=(driven.settled_s, driven.recording.end_s))
        speeds.set_ylim(bottom=0.0)
        phases.set(ylim=(0, 1), xlabel="time of the record [s]", ylabel="phase [periods]")
        for k, (axes, text) in enumerate(((speeds, "speed of each impact"), (phases, "its phase in the best sine"))):
            title(axes, f"({letter_of(k)}) {text}")
        return finished(figure, HEIGHT, [], [legend])
