"""Impacts as they were measured: a CSV of times and membranes, read strictly.

A misread time is a wrong restitution, so nothing is guessed: mistakes are listed with their lines, with what is there
and what is allowed, the first of them all together.
"""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterator
from difflib import get_close_matches
from functools import partial
from math import isfinite
from typing import NamedTuple

import numpy as np
from msgspec import Struct

from vireport.base.errors import Mistakes, ScenarioError, UsageError
from vireport.base.reading import ANYWHERE, ReadingPlace
from vireport.base.records import brief
from vireport.measurement.flights import Array
from vireport.measurement.tables import column_of, unit_size
from vireport.measurement.text_files import (
    LONGEST_CELL,
    LONGEST_LINE,
    LONGEST_TITLE,
    find_layout,
    first_long_line,
    head_lines,
    no_number,
    plain_text,
    with_line_feeds,
)
from vireport.scenario.blocks import DecimalMark, LayoutBlock
from vireport.scenario.parameters import Parameter
from vireport.text.foreign import visible

TIME, MEMBRANE = "time_s", "membrane"
UNUSED = "voltage_v", "velocity_m_s"
"""Columns that may be there; their numbers are checked, and have no part in what is identified."""

ERROR = "standard_error_s"
"""Of each time; by these it is weighted, where they are not alike."""

UTF_16 = b"\xff\xfe", b"\xfe\xff"
"""How such files begin, which spreadsheets call Unicode text."""

COLUMNS = TIME, MEMBRANE, *UNUSED, ERROR
ALIKE = 0.5
"""Similarity by `difflib` from which a name is taken for a misspelt column."""

SIDES = {"bottom": 1.0, "top": -1.0}
LARGEST_RECORD = 50_000_000
"""Bytes; an impact has some 20, so that these are beyond two million, which are read within half a gigabyte."""

FEWEST = 3
"""Impacts of which one is between two flights."""

LONGEST_FLIGHT, SHORTEST_FLIGHT = 20.0, 1e-3
"""In periods of the force: a median beyond them is of a time in another unit."""


LEAST_STEP = 1e-6
"""In periods of the force: of the digits that the numbers of a time leave, less than any clock's error."""


Rows = Iterator[tuple[int, list[str]]]
"""Cells of lines, with the numbers of these."""


class Sweepable(Struct, frozen=True):
    """A parameter that may vary in a record, as a column of it, and the ends of the scenario's sweep of it."""

    parameter: Parameter
    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Whether a value is within the sweep."""
        return self.low <= value <= self.high

    @property
    def allowed(self) -> str:
        """Message about a value outside the sweep."""
        return f"outside the sweep (allowed: {self.low:g} to {self.high:g} {self.parameter.unit})"


class Record(Struct, frozen=True, eq=False):
    """Impacts in the order of time.

    Attributes
    ----------
    name : str
        Of the file.
    times : Array (n,)
        Strictly ascending [s].
    walls : Array (n,)
        1 at the bottom membrane, -1 at the top one.
    unused : tuple of str
        Columns that were read and are not used.
    force_maximum_s : float or None
        Time at which the force is known to have a maximum, other than 0 [s].
    swept : Array (n,) or None
        Value of the swept parameter at each impact, in its unit; None where the file has no such column.
    errors : Array (n,) or None
        Standard errors of the times [s]; None where nothing is said of them.
    """

    name: str
    times: Array
    walls: Array
    unused: tuple[str, ...] = ()
    force_maximum_s: float | None = None
    swept: Array | None = None
    errors: Array | None = None

    __repr__ = brief

    @property
    def relative(self) -> Array | None:
        """Standard errors of the times over their median; None where they are equal."""
        if self.errors is None or np.ptp(self.errors) == 0:
            return None
        return np.asarray(self.errors / np.median(self.errors))


def read_record(
    path: str, frequency_hz: float, swept: Sweepable | None = None, keys: LayoutBlock | None = None
) -> Record:
    """Read a record of impacts.

    Parameters
    ----------
    path : str
        Of a CSV file in UTF-8 with the columns ``time_s`` and ``membrane`` (bottom or top).
    frequency_hz : float
        Of the force, by which times in another unit are recognised.
    swept : Sweepable, optional
        A parameter that may have a column, and the range of its values.
    keys : LayoutBlock, optional
        Names of the columns and layout of the file, if these differ from the above.

    Raises
    ------
    UsageError
        If the file cannot be read.
    ScenarioError
        With the mistakes in it, by their lines.
    """
    return parse_record(record_contents(path), visible(path), frequency_hz, swept, keys)


def record_contents(path: str, place: ReadingPlace = ANYWHERE) -> bytes:
    """The bytes of a record, looked for at a place.

    Raises
    ------
    UsageError
        If the file cannot be read, or is too large.
    """
    return place.read(path, LARGEST_RECORD)


def parse_record(
    data: bytes, name: str, frequency_hz: float, swept: Sweepable | None = None, keys: LayoutBlock | None = None
) -> Record:
    """Read a record from the bytes of a file; see `read_record`."""
    mistakes = Mistakes()
    layout, rows = _strict(name, data, swept) if keys is None else _mapped(name, data, keys, swept)
    times, walls, errors, values, lines = _values(rows, layout, swept, mistakes)
    if not mistakes:
        _require_order(times, lines, mistakes)
    if mistakes:
        raise ScenarioError(name, mistakes.reported, mistakes.more)
    if len(times) < FEWEST:
        count = f"{len(times)} impact{'s' * (len(times) != 1)}"
        raise ScenarioError.in_line(
            name, lines[-1] if lines else 1, "", f"{count} (at least {FEWEST} are needed, and some tens to be of use)"
        )
    stated_errors, swept_values = (np.array(column) if column else None for column in (errors, values))
    record = Record(name, np.array(times), np.array(walls), layout.unused, swept=swept_values, errors=stated_errors)
    # Along a sweep of the frequency, the scenario's frequency may be far from the recorded ones.
    if swept_values is not None and swept is not None and swept.parameter is Parameter.FREQUENCY:
        frequency_hz = float(np.median(swept_values))
    _require_seconds(record, lines[0], frequency_hz)
    return record


def _strict(name: str, data: bytes, swept: Sweepable | None) -> tuple[_Layout, Rows]:
    """The columns of a CSV file that are named as those of a record, and its rows.

    Raises
    ------
    ScenarioError
        If it is no such file.
    """
    if data[:2] in UTF_16:
        raise ScenarioError.in_line(name, 1, "", "the file is UTF-16 (allowed: save it as CSV in UTF-8)")
    data = with_line_feeds(data)
    if (start := first_long_line(data)) is not None:
        line = data.count(b"\n", 0, start) + 1
        raise ScenarioError.in_line(
            name, line, "", f"a line of more than {LONGEST_LINE} bytes (allowed: an impact on each)"
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ScenarioError.in_line(
            name,
            line,
            "",
            f"byte 0x{data[error.start]:02X} is not UTF-8 (allowed: CSV in UTF-8)",
        ) from None
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise ScenarioError.in_line(name, line, "", "a zero byte: this is no text (allowed: CSV in UTF-8)")
    rows = _lines_of(name, text)
    return _columns(rows, name, swept), rows


def _lines_of(name: str, text: str) -> Rows:
    """The rows of a text with commas, with the numbers of their lines.

    Raises
    ------
    ScenarioError
        Where a quote is not closed: the file ends before the row does.
    """
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        # A row in which a quoted cell has line breaks ends some lines further down.
        yield from ((reader.line_num, row) for row in reader)
    except csv.Error as error:
        raise ScenarioError.in_line(name, reader.line_num, "", f"{error} (allowed: CSV with commas)") from None


def _mapped(name: str, data: bytes, keys: LayoutBlock, swept: Sweepable | None) -> tuple[_Layout, Rows]:
    """The columns of a record that a `record:` block says, and its rows.

    Raises
    ------
    UsageError, ScenarioError
        If the layout is not found, or the columns are not in it.
    """
    data = plain_text(name, data)
    text = find_layout(name, head_lines(data, keys.skip_rows or 0), keys)
    places = {title.name: k for k, title in enumerate(text.titles) if title.name}
    unit = 1.0
    for signal in (TIME, MEMBRANE):
        block = getattr(keys.columns, signal) if keys.columns is not None else None
        if block is not None:
            path = f"{name}: record.columns.{signal}"
            places[signal] = column_of(f"{path}.column", block, text.titles)
            if signal == TIME:
                unit = block.scale * unit_size(f"{path}.unit", TIME, block, text.titles[places[TIME]])
        elif signal not in places:
            raise UsageError(f"{name}: record.columns.{signal}: is needed, as no column has this name")
    rows = (
        (line, text.split(row))
        for line, row in enumerate(data.decode("utf-8", "replace").split("\n"), 1)
        if line > text.first
    )
    allowed = {*COLUMNS, *(() if swept is None else (swept.parameter.value,))}
    places = {title: k for title, k in places.items() if title in allowed}
    return _Layout(places, tuple(x for x in UNUSED if x in places), text.cells, unit, text.decimal), rows


class _Layout(NamedTuple):
    """The columns of a record.

    Attributes
    ----------
    places : dict of str to int
        By name.
    unused : tuple of str
        Those whose numbers are not used.
    columns : int
        How many there are.
    unit_s : float
        Unit of the times [s].
    decimal : DecimalMark
    """

    places: dict[str, int]
    unused: tuple[str, ...]
    columns: int
    unit_s: float = 1.0
    decimal: DecimalMark = DecimalMark.POINT


def _columns(rows: Rows, name: str, swept: Sweepable | None) -> _Layout:
    """Read the head of a record, its first line that is not blank.

    Raises
    ------
    ScenarioError
        If it names no columns of a record, or some twice, or not those that are needed.
    """
    line, head = next(((line, row) for line, row in rows if any(cell.strip() for cell in row)), (1, []))
    example = f"the first line is {TIME},{MEMBRANE}"
    if not head:
        raise ScenarioError.in_line(name, 1, "", f"the file is empty ({example}, an impact on each that follows)")
    if len(head) == 1 and any(sign in head[0] for sign in ";\t"):
        what = "semicolons" if ";" in head[0] else "tabs"
        raise ScenarioError.in_line(
            name, line, "", f"columns are separated by {what} (allowed: commas, and points in numbers)"
        )
    titles = [cell.strip() for cell in head]
    allowed = COLUMNS if swept is None else (*COLUMNS, swept.parameter.value)
    # What is no record at all, of which nothing is shown: it may be a file that was not meant to be read.
    alike = (get_close_matches(title[:LONGEST_TITLE], allowed, 1, ALIKE) for title in titles[: len(allowed)])
    if set(titles).isdisjoint(allowed) and not any(alike):
        raise ScenarioError.in_line(
            name, line, "", f"no column is known by its name ({example}, an impact on each that follows)"
        )
    mistakes = Mistakes()
    for title in titles:
        if title not in allowed:
            mistakes.add(line, visible(title[:LONGEST_TITLE]), partial(_unknown, title, allowed))
    count = Counter(titles)
    for title in allowed:
        if count[title] > 1:
            mistakes.add(line, title, "the column stands twice (allowed: once)")
    for title in (TIME, MEMBRANE):
        if title not in count:
            mistakes.add(line, title, f"the column is missing ({example})")
    if mistakes:
        raise ScenarioError(name, mistakes.reported, mistakes.more)
    return _Layout({title: k for k, title in enumerate(titles)}, tuple(x for x in UNUSED if x in count), len(titles))


def _unknown(title: str, allowed: tuple[str, ...]) -> str:
    """Message about a column with a name that is not allowed, with the likely one."""
    close = get_close_matches(title[:LONGEST_TITLE], allowed, 1, ALIKE)
    hint = f"; did you mean '{close[0]}'?" if close else ""
    what = f"unknown column{hint}" if title else "a column without a name"
    return f"{what} (allowed: {', '.join(allowed)})"


def _values(
    rows: Rows, layout: _Layout, swept: Sweepable | None, mistakes: Mistakes
) -> tuple[list[float], list[float], list[float], list[float], list[int]]:
    """Read the impacts of a record, a row each.

    Parameters
    ----------
    rows : iterator of (int, list of str)
        Lines with their cells.
    layout : _Layout
    swept : Sweepable or None
    mistakes : Mistakes
        To which mistakes in the rows are added.

    Returns
    -------
    times, walls, errors, values : list of float
        For all impacts; errors and values of the swept parameter are empty without their columns.
    lines : list of int
    """
    times, walls, errors, values, lines = [], [], [], [], []
    places, head = layout.places, layout.columns
    swept_column = None if swept is None else places.get(swept.parameter.value)
    time, membrane, others = places[TIME], places[MEMBRANE], [(name, places[name]) for name in layout.unused]
    for line, row in rows:
        if not row or (len(row) == 1 and not row[0].strip()):
            continue
        # A file that is no record has a mistake in each of its lines.
        if mistakes.countless:
            break
        if len(row) != head:
            mistakes.add(line, "", partial(_wrong_count, row, head))
            continue
        if layout.decimal is DecimalMark.COMMA:
            row = [cell.replace(",", ".") for cell in row]
        number = _number(row[time], line, TIME, mistakes)
        side = SIDES.get(row[membrane].strip())
        if side is None:
            mistakes.add(line, MEMBRANE, partial(_no_membrane, row[membrane]))
        for name, place in others:
            if row[place].strip():
                _number(row[place], line, name, mistakes)
        if swept is not None and swept_column is not None:
            value = _number(row[swept_column], line, swept.parameter.value, mistakes)
            if value is not None and not swept.holds(value):
                mistakes.add(line, swept.parameter.value, f"got {value:g}, {swept.allowed}")
            values.append(np.nan if value is None else value)
        error = _number(row[places[ERROR]], line, ERROR, mistakes) if ERROR in places else None
        if error is not None and error <= 0:
            mistakes.add(line, ERROR, f"{error!r} is not above 0 (allowed: the standard error of the time)")
        if error is not None:
            errors.append(error)
        if number is not None and side is not None:
            times.append(number * layout.unit_s)
            walls.append(side)
            lines.append(line)
    return times, walls, errors, values, lines


def _wrong_count(row: list[str], head: int) -> str:
    """Message about a row with another number of cells than the head."""
    hint = " A decimal comma?" if len(row) > head else " Semicolons?" if ";" in row[0] else ""
    count = f"{len(row)} value{'s' * (len(row) != 1)} for {head} columns.{hint}"
    return f"{count} (allowed: commas between columns, and points in numbers)"


def _no_membrane(text: str) -> str:
    """Message about a cell that names no membrane."""
    cell = visible(text.strip()[:LONGEST_CELL])
    close = get_close_matches(cell.lower(), SIDES, 1)
    hint = f"; did you mean '{close[0]}'?" if close else ""
    return f"'{cell}' is no membrane{hint} (allowed: bottom, top)"


def _number(text: str, line: int, column: str, mistakes: Mistakes) -> float | None:
    """The number in a cell; None of a cell without a finite one, which is added to the mistakes."""
    cell = text.strip()
    # Python's numbers may have underscores, and digits of other scripts: what measures writes neither.
    try:
        value = float(cell) if cell.isascii() and "_" not in cell else None
    except ValueError:
        value = None
    if value is None or not isfinite(value):
        mistakes.add(line, column, partial(no_number, cell))
        return None
    return value


def _require_order(times: list[float], lines: list[int], mistakes: Mistakes) -> None:
    """Add the impacts that are not after the one before them to the mistakes."""
    allowed = "(allowed: ascending times, each once)"
    for k in (np.flatnonzero(np.diff(times) <= 0) + 1).tolist():
        which = "that" if times[k] == times[k - 1] else "before that"
        mistakes.add(lines[k], TIME, f"{times[k]!r} s is {which} of line {lines[k - 1]} {allowed}")


def _require_seconds(record: Record, line: int, frequency_hz: float) -> None:
    """Refuse times that are in another unit than seconds, or too far from 0 to have their digits.

    Raises
    ------
    ScenarioError
    """
    step = float(np.spacing(np.abs(record.times).max())) * frequency_hz
    if LEAST_STEP < step <= 1:
        what = f"so far from 0 that a double has steps of {step:.2g} periods of the force"
        raise ScenarioError.in_line(
            record.name, line, TIME, f"times are {what} (allowed: count them from the record's beginning)"
        )
    periods = float(np.median(np.diff(record.times))) * frequency_hz
    if SHORTEST_FLIGHT <= periods <= LONGEST_FLIGHT:
        return
    likely = " The times look like milliseconds." if LONGEST_FLIGHT < periods < 1e3 * LONGEST_FLIGHT else ""
    raise ScenarioError.in_line(
        record.name,
        line,
        TIME,
        f"half of the flights are {'longer' if periods > 1 else 'shorter'} than {periods:.3g} periods of the force."
        f"{likely} "
        f"(allowed: seconds, and excitation.frequency_hz in Hz: a median of {SHORTEST_FLIGHT:g} to {LONGEST_FLIGHT:g})",
    )
