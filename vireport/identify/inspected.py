"""What `vireport identify --inspect` says of a file of signals: text, a picture of its columns, or JSON."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vireport.base.encoding import json_text
from vireport.cli.outcome import CommandOutcome
from vireport.identify.results import InspectedData
from vireport.measurement.inspection import Inspection, inspect, record_lines
from vireport.measurement.recordings import time_text
from vireport.scenario.blocks import LayoutBlock
from vireport.text.foreign import visible
from vireport.text.formatting import rounded_text
from vireport.text.tables import Table, plain_text, worded_table
from vireport.text.templates import Words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURE = "figure-inspected.png"

WORDS = Words("identify")

LONGEST_NAME = 40
"""Characters of a column's name in a table."""

MOST_DRAWN, HEIGHT = 8, 1.1
"""Columns that are drawn, and height of a panel [in]."""


def outcome(file: str, keys: LayoutBlock | None, json: bool) -> CommandOutcome:
    """Inspect a file of signals.

    Raises
    ------
    UsageError, ScenarioError
        If it cannot be read.
    """
    inspection = inspect(file, keys)
    block = "\n".join(record_lines(inspection))
    if json:
        data = InspectedData(
            file=inspection.name,
            reading=inspection.table.reading,
            samples=inspection.samples,
            columns=inspection.columns,
            clock=inspection.clock,
            record=block,
        )
        return CommandOutcome(f"{json_text(data)}\n")
    from vireport.figures.style import Picture

    picture = Picture("figure-inspected", "", "", "", figure_of(inspection))
    text = f"{plain_text(_parts(inspection))}\n\n{WORDS('inspected_paste')}\n\n{block}\n"
    return CommandOutcome("", text, {PICTURE: picture.png}, stale=(PICTURE,))


def _parts(inspection: Inspection) -> Iterator[str | Table]:
    clock = inspection.clock
    yield f"{Path(inspection.name).name}: " + WORDS(
        "inspected", inspection, "" if clock is None else time_text(clock.step_s)
    )
    rows = []
    for column in inspection.columns:
        numbers = (
            "" if value is None else rounded_text(value) for value in (column.least, column.largest, column.mean)
        )
        name = visible(column.title.name, LONGEST_NAME)
        counts = (str(count or "") for count in (column.missing, column.clipped))
        rows.append((str(column.number), name, column.title.unit or "", *numbers, *counts))
    yield worded_table(WORDS, "inspected_columns", "nttnnnnn", rows)
    yield WORDS("inspected_clock", clock)


def figure_of(inspection: Inspection) -> Figure:
    """Each column of a file that has numbers, against time or the number of the sample."""
    from vireport.figures.layout import blank, finished, title
    from vireport.figures.style import Color, literal, style
    from vireport.identify.record_figure import drawn_rows

    clock, times = inspection.clock, inspection.times
    drawn = [c for c in inspection.columns if c.least is not None and (clock is None or c.number != clock.column)]
    drawn = drawn[:MOST_DRAWN] or list(inspection.columns[:1])
    with style():
        figure, panels = blank(len(drawn), 1)
        for axes, column in zip(panels[:, 0], drawn, strict=True):
            values = inspection.table.columns.get(column.number - 1, np.empty(0))
            rows = drawn_rows(values, np.flatnonzero(np.isfinite(values)))
            gaps = () if clock is None else clock.gaps
            at = np.searchsorted(times[rows], gaps)  # where samples are missing there is no line
            x, y = np.insert(times[rows], at, gaps), np.insert(values[rows], at, np.nan)
            axes.plot(x, y, color=Color.BLUE, linewidth=0.6)
            unit = f" [{column.title.unit}]" if column.title.unit else ""
            title(axes, literal(f"{column.number}: {visible(column.title.name, LONGEST_NAME)}{unit}"))
        panels[-1, 0].set_xlabel("sample" if clock is None else "time [s]")
        return finished(figure, HEIGHT * len(drawn) + 0.4, [], [])
