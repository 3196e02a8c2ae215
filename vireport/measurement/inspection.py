"""What is in a file of signals: its columns as they are, its clock, and which signals these may be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct

from vireport.base.reading import ANYWHERE
from vireport.base.records import ResultsBlock, brief
from vireport.measurement.flights import Array
from vireport.measurement.readers import reader_of
from vireport.measurement.recordings import GAP, NAMES
from vireport.measurement.tables import LARGEST_FILE_OF_SIGNALS, UNITS, RecordedTable, Title
from vireport.scenario.blocks import LayoutBlock
from vireport.text.foreign import visible

LONGEST_PLATEAU = 3
"""Samples at the least or the largest value, one after the other, from which a signal is clipped there."""


class InspectedColumn(ResultsBlock, frozen=True):
    """A column of a file of signals.

    Attributes
    ----------
    number
        from 1, as a `record:` block may have it
    title
        what the file says of it
    least, largest, mean : unit of the file
        of its numbers; null where it has none
    missing
        samples that are no finite numbers
    clipped
        samples in plateaus at its least and its largest value
    """

    number: int
    title: Title
    least: float | None = None
    largest: float | None = None
    mean: float | None = None
    missing: int = 0
    clipped: int = 0


class InspectedClock(ResultsBlock, frozen=True):
    """The times of a file of signals.

    Attributes
    ----------
    column
        number of the column that has them; null where they follow from a rate
    step_s, start_s : s
        the usual step, and the first time
    spread : 1
        share of the usual step within which nine steps in ten are
    gaps, repeated, back : s
        times before which samples are missing, that stand again, and that are before the one above them
    """

    column: int | None
    step_s: float
    start_s: float
    spread: float = 0.0
    gaps: tuple[float, ...] = ()
    repeated: tuple[float, ...] = ()
    back: tuple[float, ...] = ()


class Inspection(Struct, frozen=True, eq=False):
    """What is in a file of signals.

    Attributes
    ----------
    name : str
    table : RecordedTable
    samples : int
    columns : tuple of InspectedColumn
    clock : InspectedClock or None
    """

    name: str
    table: RecordedTable
    samples: int
    columns: tuple[InspectedColumn, ...]
    clock: InspectedClock | None

    __repr__ = brief

    @property
    def times(self) -> Array:
        """Times of the samples [s], or their numbers without a clock."""
        if self.clock is None:
            return np.arange(self.samples, dtype=float)
        if self.clock.column is None:
            return np.asarray(self.clock.start_s + self.clock.step_s * np.arange(self.samples))
        return _seconds_of(self.table, self.clock.column - 1)


def inspect(path: str, keys: LayoutBlock | None = None) -> Inspection:
    """Look at a file of signals.

    Parameters
    ----------
    path : str
    keys : LayoutBlock, optional
        What is said of its text; its columns are looked at as the file has them.

    Raises
    ------
    UsageError, ScenarioError
        If it cannot be read.
    """
    keys, name = keys or LayoutBlock(), visible(path)
    data = ANYWHERE.read(path, LARGEST_FILE_OF_SIGNALS)

    def numeric(titles: Sequence[Title]) -> list[int]:
        return [k for k, title in enumerate(titles) if title.numeric]

    table = reader_of(name, data).read(name, data, keys, numeric)
    samples = max((len(values) for values in table.columns.values()), default=0)
    columns = tuple(_column(k, title, table.columns.get(k)) for k, title in enumerate(table.titles))
    return Inspection(name, table, samples, columns, _clock_of(table, keys))


def _column(k: int, title: Title, values: Array | None) -> InspectedColumn:
    finite = None if values is None else values[np.isfinite(values)]
    if values is None or finite is None or not len(finite):
        return InspectedColumn(k + 1, title, missing=0 if values is None else len(values))
    ends = float(finite.min()), float(finite.max())
    clipped = 0 if title.unit in UNITS["time"] or ends[0] == ends[1] else sum(_plateaus(finite, end) for end in ends)
    return InspectedColumn(k + 1, title, *ends, float(finite.mean()), len(values) - len(finite), clipped)


def _plateaus(values: Array, end: float) -> int:
    """Samples that are at an end of the range together with their neighbours."""
    at_end = np.concatenate([[False], values == end, [False]])
    edges = np.flatnonzero(np.diff(at_end.astype(np.int8)))
    lengths = edges[1::2] - edges[::2]
    return int(lengths[lengths >= LONGEST_PLATEAU].sum())


def _seconds_of(table: RecordedTable, k: int) -> Array:
    """Times of a column [s]."""
    unit = table.titles[k].unit
    return np.asarray(table.columns[k] * (1.0 if unit is None else UNITS["time"][unit]))


def _clock_of(table: RecordedTable, keys: LayoutBlock) -> InspectedClock | None:
    """The clock of a file: its only column of times, or its rate."""
    of_time = [k for k, title in enumerate(table.titles) if k in table.columns and title.unit in UNITS["time"]]
    of_time += [k for k, title in enumerate(table.titles) if k in table.columns and is_times(title)]
    if len(of_time) != 1:
        step = 1 / keys.sampling_rate_hz if keys.sampling_rate_hz else table.step_s
        return InspectedClock(None, step, table.start_s) if step and not of_time else None
    times = _seconds_of(table, of_time[0])
    times = times[np.isfinite(times)]
    steps = np.diff(times)
    if not len(steps) or not (usual := float(np.median(steps))) > 0:
        return None
    low, high = (float(end) for end in np.quantile(steps, [0.05, 0.95]))
    places = (steps > GAP * usual, steps == 0, steps < 0)
    gaps, repeated, back = (tuple(times[1:][where].tolist()) for where in places)
    return InspectedClock(of_time[0] + 1, usual, float(times[0]), (high - low) / usual, gaps, repeated, back)


def is_times(title: Title) -> bool:
    """Whether a column is named as times with their unit, as in time_ms."""
    return title.name in NAMES and NAMES[title.name][0] is None


def record_lines(inspection: Inspection) -> Iterator[str]:
    """The lines of a `record:` block for a file: what is certain as keys, and remarks on what is needed besides."""
    yield "record:"
    yield "  columns:"
    clock = inspection.clock
    rows = [column for column in inspection.columns if column.least is not None]
    rows = [column for column in rows if clock is None or column.number != clock.column]
    voltages, accelerations, displacements = (
        [row.number for row in rows if row.title.unit in UNITS[quantity]]
        for quantity in ("voltage", "acceleration", "displacement")
    )
    if clock is not None and clock.column is not None:
        yield f"    time_s: {_column_text(inspection, inspection.columns[clock.column - 1])}"
    names = {1: ["voltage_v"], 2: ["bottom_voltage_v", "top_voltage_v"]}.get(len(voltages), [])
    certain = dict(zip(voltages, names, strict=False))
    for places, signal in ((accelerations, "acceleration_m_s2"), (displacements, "displacement_m")):
        if len(places) == 1:
            certain[places[0]] = signal
    for row in rows:
        text = _column_text(inspection, row)
        if row.number in certain:
            remark = "  # or top_voltage_v" if certain[row.number] == "bottom_voltage_v" else ""
            yield f"    {certain[row.number]}: {text}{remark}"
        else:
            yield f"    # ...: {text}  # {'which signal is it?' if row.title.unit else 'which signal, in which unit?'}"
    if clock is None:
        yield "  # sampling_rate_hz: 1000.0  # or time_s above: the file has neither times nor a rate that are certain"


def _column_text(inspection: Inspection, column: InspectedColumn) -> str:
    """What a `record:` block says of a column: its name where no other has it, or else its number; and its unit."""
    name = column.title.name
    unique = [title.name for title in inspection.table.titles].count(name) == 1
    named: object = name if name and unique and visible(name) == name else column.number
    unit = "" if column.title.unit is None else f", unit: {column.title.unit}"
    quoted = '"' + named.replace("\\", "\\\\").replace('"', '\\"') + '"' if isinstance(named, str) else named
    return f"{{column: {quoted}{unit}}}"
