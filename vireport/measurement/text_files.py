"""Tables of numbers as instruments export them as text: one description of a layout, found in the first lines.

Above the numbers may stand lines of properties, of names and of units, and beside them properties as well. Which marks
are decimals and delimiters is found out by what makes numbers of all lines; where two readings do, that is an error.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from math import isfinite

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from vireport.base.errors import ScenarioError, UsageError
from vireport.measurement.flights import Array
from vireport.measurement.tables import UNUSED, RecordedTable, Title, Wanted, unit_in
from vireport.scenario.blocks import DecimalMark, Delimiter, LayoutBlock, RecordedUnit
from vireport.text.foreign import visible

LONGEST_LINE = 100_000
"""Bytes; a row has some tens."""

LONGEST_TITLE, LONGEST_CELL = 60, 40
"""Characters of a column's name, and of a cell, that are shown."""

ENCODINGS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
"""With which a text begins that states its encoding."""

FORMATS = "text with lines of numbers, WAV, MATLAB, HDF5, TDMS, UFF 58, Parquet, npz"
"""The formats that are read."""

LONGEST_LETTER = 4
"""Bytes of a letter in UTF-8."""

HEAD_LINES, HEAD_BYTES = 400, 300_000
"""Of a file, in which the layout is looked for, besides lines to be skipped."""

MOST_BESIDE = 40
"""Lines of numbers that may have properties beside them."""

TYPICAL = 20
"""Last lines of the head that show what all lines are."""

NUMBER = {
    DecimalMark.POINT: re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"),
    DecimalMark.COMMA: re.compile(r"[-+]?(?:\d+,?\d*|,\d+)(?:[eE][-+]?\d+)?"),
}
MISSING = {"", "nan", "inf", "infinity", "∞"}
"""What stands for a number that is none, without its sign."""

TIME_STEPS = (
    *("sample interval", "sampling interval", "sampling period", "sample period", "xincrement", "x increment"),
    *("xinc", "increment", "delta x", "tinc", "time step", "time interval", "resolution"),
)
RATES = "sample rate", "sampling rate", "sampling frequency", "sample frequency", "sampling rate hz"
STARTS = "xorg", "xorigin", "x origin", "xstart", "xzero", "x0", "t0", "start"
OF_TIMES = "horizontal units", "xunits", "x units", "x unit label"
OF_VALUES = "vertical units", "yunits", "y units", "y unit label"
"""Properties that instruments call by these names: of the time base, and units."""

COUNTS = "sequence", "sample", "samples", "index", "point"
"""Names and units of columns that count samples."""

NO_UNIT = "value", "sequence"
"""What stands in a line of units and is none."""

VALUE = re.compile(r"(?:[^:]*:)?\s*([-+]?[\d.,]+(?:[eE][-+]?\d+)?)\s*([^\W\d]\S*)?")
"""A number with what is written behind it, as in Analog:5E-05 and 1.25 GSa/s."""

SIZES = {"": 1.0, "n": 1e-9, "u": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9}

IN_BRACKETS = re.compile(r"[(\[]([^\s()\[\]]+)[)\]]$")
"""The unit at the end of a name."""

ASSIGNS = re.compile(r"[:=,;\t]+")
"""What stands between a name and its value where nothing else does."""

ASSIGNED = re.compile(r"\s*(\w[\w ]*?)\s*=\s*(.+?)\s*")


class Maker(Struct, frozen=True):
    """An instrument or program whose export is known by its head, and its column of times in s if it states no unit."""

    name: str
    head: re.Pattern[str]
    times: str = ""


MAKERS = tuple(
    Maker(name, re.compile(head, re.MULTILINE), times)
    for name, head, times in (
        ("LabVIEW", r"^LabVIEW Measurement", "X_Value"),
        ("LeCroy", r"^LECROY", "Time"),
        ("Siglent", r"^Model Number,\s*SDS|^Sample Interval,Analog:", ""),
        ("Tektronix", r"^Firmware Version,|^Model(?: Number)?,(?:TDS|TBS|MSO|DPO|MDO)|^Pt Fmt,", ""),
        ("Keysight", r"^x-axis,|^XDispRange:|^XDispOrg", ""),
        ("Rigol", r"^X,CH\d|tInc\s*=", ""),
        ("Rohde & Schwarz", r"^\"?in s\"?[,;]", ""),
        ("PicoScope", r"^Time[,;\t]Channel [A-H]\b", ""),
        ("phyphox", r"^\"Time \(s\)\"[,;\t]", ""),
        ("WaveForms", r"^#Digilent WaveForms", ""),
        ("Saleae", r"^Time \[s\][,;\t]Channel \d", ""),
    )
)


class TextLayout(Struct, frozen=True):
    """How a text has its numbers.

    Attributes
    ----------
    delimiter : Delimiter
    decimal : DecimalMark
    first : int
        Line with the first numbers, from 0.
    cells : int
        In a line of numbers.
    numeric : tuple of int
        Places of the columns that have numbers.
    titles : tuple of Title
        Of all columns.
    properties : mapping of str to tuple of str
        Values that stand above or beside the numbers, by name.
    maker : str
    counts : tuple of int
        Places of the columns that count samples.
    """

    delimiter: Delimiter
    decimal: DecimalMark
    first: int
    cells: int
    numeric: tuple[int, ...]
    titles: tuple[Title, ...] = ()
    properties: Mapping[str, tuple[str, ...]] = {}
    maker: str = ""
    counts: tuple[int, ...] = ()

    def split(self, line: str) -> list[str]:
        """Cells of a line."""
        return split_line(line, self.delimiter)

    def value(self, cell: str) -> float | None:
        """The number in a cell, NaN where it is missing, None where the cell holds something else."""
        return number_in(cell, self.decimal)


def split_line(line: str, delimiter: Delimiter) -> list[str]:
    """Cells of a line of text, without quotes and blanks around them."""
    if delimiter is Delimiter.BLANKS:
        return line.split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    quoted = next(csv.reader([line.replace("\r", " ")], delimiter=delimiter.value, skipinitialspace=True))
    return [cell.strip() for cell in quoted]


def split_head(line: str, delimiter: Delimiter, count: int) -> list[str]:
    """Cells of a line above numbers, of which there are so many columns: names may have blanks in them."""
    cells = split_line(line, delimiter)
    if delimiter is Delimiter.BLANKS and len(cells) != count:
        cells = re.split(r"\t|\s{2,}", line.strip())
    return cells if len(cells) > 1 else [part.strip() for part in ASSIGNS.split(line.strip(' "'), maxsplit=1)]


def number_in(cell: str, decimal: DecimalMark) -> float | None:
    """The number that a cell has; NaN of one that is missing, infinite or blank, None of a text."""
    if cell.isascii() and NUMBER[decimal].fullmatch(cell):
        return float(cell.replace(",", "."))
    return float("nan") if cell.lower().lstrip("+-") in MISSING else None


def read_text(name: str, data: bytes, keys: LayoutBlock, wanted: Wanted) -> RecordedTable:
    """Read the columns of a text that are wanted.

    Raises
    ------
    UsageError, ScenarioError
        If it is no text, if no lines of numbers are in it, or a line is not as the others.
    """
    data = plain_text(name, data)
    skipped = keys.skip_rows or 0
    lines = head_lines(data, skipped)
    layout = find_layout(name, lines, keys)
    step, start = time_base(name, layout)
    # Numbers of samples become times where the file says how far apart they are.
    titles = tuple(
        replace(title, unit=RecordedUnit.S) if step and k in layout.counts else title
        for k, title in enumerate(layout.titles)
    )
    places = list(wanted(titles))
    place = 0
    for _ in range(layout.first):
        place = data.find(b"\n", place) + 1
    rows = _numbers(name, data, place, layout, places)
    columns = {k: np.ascontiguousarray(rows[:, i]) for i, k in enumerate(places)}
    for k in set(places) & set(layout.counts) if step else ():
        columns[k] = start + step * columns[k]
    kind = f"{layout.maker} export" if layout.maker else "text"
    head = f"{layout.first} head line{'s' * (layout.first != 1)}"
    return RecordedTable(f"{kind}: {head}", titles, columns, step, start, partial(_cell_of, data, layout))


def plain_text(name: str, data: bytes) -> bytes:
    """The bytes of a text in UTF-8 with lines that end by LF.

    Raises
    ------
    UsageError, ScenarioError
        If it is no text, or has a line that is too long for a row.
    """
    stated = next((encoding for mark, encoding in ENCODINGS.items() if data.startswith(mark)), "")
    try:
        if stated:
            data = data.decode(stated).encode()
    except UnicodeDecodeError as error:
        raise UsageError(f"{name}: the file is no {stated.upper()} (allowed: a text that is complete)") from error
    if (zero := data.find(b"\0")) >= 0:
        line = data.count(b"\n", 0, zero) + 1
        raise ScenarioError.in_line(name, line, "", f"a zero byte: this is no text (allowed: {FORMATS})")
    try:
        data[:HEAD_BYTES].decode()
    except UnicodeDecodeError as error:
        # Names alone can have other letters than ASCII; a letter that is cut in two is none.
        if error.start < HEAD_BYTES - LONGEST_LETTER:
            data = data.decode("cp1252", "replace").encode()
    data = with_line_feeds(data)
    if (long := first_long_line(data)) is not None:
        line = data.count(b"\n", 0, long) + 1
        allowed = "(allowed: a sample of each signal)"
        raise ScenarioError.in_line(name, line, "", f"a line of more than {LONGEST_LINE} bytes {allowed}")
    return data


def with_line_feeds(data: bytes) -> bytes:
    """The bytes of a text with its lines ended as on all systems of today; some programs end them by CR alone."""
    return data.replace(b"\r", b"\n") if b"\n" not in data else data


def first_long_line(data: bytes) -> int | None:
    """Where the first line begins that is too long for a row; None where none is."""
    start = 0
    while len(data) - start > LONGEST_LINE:
        end = data.rfind(b"\n", start, start + LONGEST_LINE)
        if end < 0:
            return start
        start = end + 1
    return None


def head_lines(data: bytes, skipped: int) -> list[str]:
    """The first lines of a file, each of which is complete; those that are skipped are empty."""
    place = 0
    for _ in range(skipped):
        place = data.find(b"\n", place) + 1 or len(data)
    part = data[place : place + HEAD_BYTES]
    lines = part.decode("utf-8", "replace").split("\n")[:HEAD_LINES]
    if len(part) == HEAD_BYTES and place + HEAD_BYTES < len(data) and len(lines) < HEAD_LINES:
        lines = lines[:-1]
    return [""] * skipped + [line.rstrip("\r") for line in lines]


def find_layout(name: str, lines: Sequence[str], keys: LayoutBlock) -> TextLayout:
    """The layout of a text by its first lines.

    Raises
    ------
    ScenarioError
        If they have no numbers, or can be read in two ways.
    """
    if not any(line.strip() for line in lines):
        raise ScenarioError.in_line(name, 1, "", "the file is empty (allowed: names and units, and numbers below them)")
    ways = [layout for way in _ways(keys) if (layout := _laid_out(lines, *way)) is not None]
    if not ways:
        how = f"{FORMATS}; record.skip_rows, record.delimiter and record.decimal say where the numbers of a text are"
        raise ScenarioError.in_line(name, 1, "", f"no lines of numbers were found in it (allowed: {how})")
    fewest = min(_texts(lines, way) for way in ways)
    ways = [way for way in ways if _texts(lines, way) == fewest]
    agreeing = [way for way in ways if _names_fit(lines, way)]
    best = (agreeing or ways)[0]
    if any(_differ(lines, best, way) for way in (agreeing or ways)[1:]):
        line_text = visible(lines[best.first][:LONGEST_TITLE])
        message = f"'{line_text}' can be read in two ways: commas between columns, or decimal commas"
        allowed = "(allowed: record.decimal or record.delimiter, which decide)"
        raise ScenarioError.in_line(name, best.first + 1, "", f"{message} {allowed}")
    return _described(name, lines, best)


def _ways(keys: LayoutBlock) -> Iterator[tuple[Delimiter, DecimalMark]]:
    """Pairs of marks that a text may have, those that are stated alone."""
    order = (Delimiter.SEMICOLON, Delimiter.TAB, Delimiter.COMMA, Delimiter.BLANKS)
    for delimiter in (keys.delimiter,) if keys.delimiter else order:
        for decimal in (keys.decimal,) if keys.decimal else DecimalMark:
            if delimiter.value != decimal.value:
                yield delimiter, decimal


def _laid_out(lines: Sequence[str], delimiter: Delimiter, decimal: DecimalMark) -> TextLayout | None:
    """Lines of numbers as two marks give them; None where they give none."""
    rows = [(k, split_line(line, delimiter)) for k, line in enumerate(lines) if line.strip()]
    typical = [cells for _, cells in rows[-TYPICAL:]]
    counts = [len(cells) for cells in typical]
    width = max(set(counts), key=counts.count)
    typical = [
        cells for cells in typical if len(cells) == width and any(NUMBER[decimal].fullmatch(cell) for cell in cells)
    ]
    if not typical:
        return None
    values = [[number_in(cell, decimal) for cell in cells] for cells in typical]
    numeric = tuple(
        k for k in range(width) if all(row[k] is not None for row in values) and any(cells[k] for cells in typical)
    )
    if not numeric:
        return None
    blank = [k for k in range(width) if not any(cells[k] for cells in typical)]

    def is_row(cells: list[str], strict: bool) -> bool:
        if len(cells) != width or not any(cells[k] for k in numeric):
            return False
        return all(number_in(cells[k], decimal) is not None for k in numeric) and not (
            strict and any(cells[k] for k in blank)
        )

    begin = next((i for i, (_, cells) in enumerate(rows) if is_row(cells, True)), None)
    if begin is None:
        return None
    # Properties may stand beside the first rows, in columns that are empty below.
    while begin and blank and is_row(rows[begin - 1][1], False):
        begin -= 1
    return TextLayout(delimiter, decimal, rows[begin][0], width, numeric)


def _texts(lines: Sequence[str], way: TextLayout) -> int:
    """Cells of the first row of numbers that are texts; one with a mark in it counts twice."""
    texts = [cell for cell in way.split(lines[way.first]) if cell and way.value(cell) is None]
    return sum(1 + any(mark in cell for mark in ",;\t") for cell in texts)


def _head_of(lines: Sequence[str], way: TextLayout) -> list[list[str]]:
    """The cells of the lines above the numbers that are not blank, the nearest first."""
    above = reversed(lines[: way.first])
    return [split_head(line, way.delimiter, len(way.numeric)) for line in above if line.strip()]


def _names_fit(lines: Sequence[str], way: TextLayout) -> bool:
    """Whether the line above the numbers has a name for each column."""
    head = _head_of(lines, way)
    return bool(head) and len([cell for cell in head[0] if cell]) == len(way.numeric)


def _differ(lines: Sequence[str], way: TextLayout, other: TextLayout) -> bool:
    """Whether two readings give other numbers of the first row."""
    both = ([layout.value(cell) for cell in layout.split(lines[layout.first])] for layout in (way, other))
    first, second = ([value for value in values if value is not None and isfinite(value)] for values in both)
    return first != second


def _described(name: str, lines: Sequence[str], way: TextLayout) -> TextLayout:
    """A layout with the names, units and properties that stand above and beside the numbers."""
    head = _head_of(lines, way)
    if head and len(head[0]) == way.cells and _is_wrong_row(head[0], way):
        raise _wrong_cell(name, head[0], way, way.first)
    units: list[str] = []
    rest = head
    # A line of units has nothing else, and a line with names above it.
    if len(head) > 1 and _are_units(head[0], way) and _are_names(head[1], way, counted=True):
        units, rest = head[0], head[1:]
    names = rest[0] if rest and _are_names(rest[0], way, counted=bool(units)) else []
    if not names and head and _are_units(head[0], way):
        names, rest = head[0], head
    properties = dict(_properties(rest[1:] if names else rest, way, lines))
    properties |= _of_names(names, units)
    makers = "\n".join(lines[: way.first + MOST_BESIDE])
    maker = next((row for row in MAKERS if row.head.search(makers)), None)
    titles = [Title.of(*(row[k] if k < len(row) else "" for row in (names, units))) for k in range(way.cells)]
    blank = [k for k, cell in enumerate(way.split(lines[way.first])) if not cell and k not in way.numeric]
    for k in range(way.cells):
        if k not in way.numeric:
            titles[k] = Title(titles[k].name or (UNUSED if k in blank else ""), None, False)
    counts: list[int] = []
    ascending = len(way.numeric) > 1 and _ascends(lines, way)
    for k in way.numeric:
        stated = units[k] if k < len(units) else ""
        if {titles[k].name.lower(), stated.lower()} & set(COUNTS):
            counts.append(k)
        elif titles[k].unit is None and maker is not None and maker.times and titles[k].name == maker.times:
            titles[k] = Title(titles[k].name, RecordedUnit.S)
        elif titles[k].unit is None:
            kinds = OF_TIMES if k == way.numeric[0] and ascending else OF_VALUES
            titles[k] = Title(titles[k].name, unit_in(_property_of(properties, kinds, k).rpartition(":")[2]))
    made_by = "" if maker is None else maker.name
    return replace(way, titles=tuple(titles), properties=properties, maker=made_by, counts=tuple(counts))


def _ascends(lines: Sequence[str], way: TextLayout) -> bool:
    """Whether the first column of numbers is one of times: each above the one before."""
    rows = (way.split(line) for line in lines[way.first : way.first + TYPICAL] if line.strip())
    values = [way.value(cells[way.numeric[0]]) for cells in rows if len(cells) == way.cells]
    return all(a is not None and b is not None and a < b for a, b in pairwise(values))


def _is_wrong_row(cells: list[str], way: TextLayout) -> bool:
    """Whether the line above the numbers is one of them, with a mistake in it."""
    values = [way.value(cells[k]) for k in way.numeric]
    return values[0] is not None and any(cells[k] for k in way.numeric) and any(value is None for value in values)


def _are_units(cells: list[str], way: TextLayout) -> bool:
    stated = [cells[k] for k in way.numeric if k < len(cells) and cells[k]]
    return bool(stated) and all(unit_in(cell) is not None or cell.lower() in NO_UNIT or cell == "()" for cell in stated)


def _are_names(cells: list[str], way: TextLayout, counted: bool) -> bool:
    """Whether cells are names of the columns of numbers; some instruments name channels 1, 2, ... above units."""
    stated = [cells[k] for k in way.numeric if k < len(cells)]
    texts = [cell for cell in stated if cell and way.value(cell) is None]
    return bool(texts) and all(way.value(cell) is None or not cell or (counted and cell.isdigit()) for cell in stated)


def _properties(head: list[list[str]], way: TextLayout, lines: Sequence[str]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Names and values of what stands above the numbers, or beside the first of them."""
    beside_rows = [way.split(line)[: way.numeric[0]] for line in lines[way.first :][:MOST_BESIDE] if line.strip()]
    for cells in (*head, *beside_rows):
        if len(cells) > 1 and cells[0]:
            key = cells[0][:LONGEST_TITLE].rstrip(":")
            name, unit = Title.of(key), IN_BRACKETS.search(key)
            yield _property_name(name.name), (*cells[1:], unit[1] if unit else "")


def _property_name(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", " ", text.lower()).strip()


def _of_names(names: list[str], units: list[str]) -> dict[str, tuple[str, ...]]:
    """Properties in the line of names: with their values below, or behind a sign of equality."""
    below: dict[str, tuple[str, ...]] = {
        _property_name(title): (unit,) for title, unit in zip(names, units, strict=False) if title and unit
    }
    assigned = (ASSIGNED.fullmatch(title) for title in names)
    return {**below, **{_property_name(match[1]): (match[2],) for match in assigned if match}}


def _property_of(properties: Mapping[str, tuple[str, ...]], names: Sequence[str], column: int = 1) -> str:
    """The text of the first property of some names, of a column where each has its own; "" without one."""
    cells = next((properties[name] for name in names if name in properties), ())
    stated = [cell for cell in cells if cell]
    # The values of a property begin in the second column.
    return cells[column - 1] if 0 < column <= len(cells) and cells[column - 1] else (stated or [""])[0]


def time_base(name: str, layout: TextLayout) -> tuple[float, float]:
    """Step and start of the times by the properties of a text [s]; a step of 0 is none.

    Raises
    ------
    ScenarioError
        If a step or a rate is not above 0.
    """
    step = _quantity(layout, TIME_STEPS)
    rate = _quantity(layout, RATES) if step is None else None
    if step is None and rate is not None:
        step = 1 / rate if rate > 0 else -1.0
    if step is not None and not 0 < step < np.inf:
        message = "the time between samples that its head states is not above 0 (allowed: above 0)"
        raise ScenarioError.in_line(name, 1, "", message)
    return step or 0.0, _quantity(layout, STARTS) or 0.0


def _quantity(layout: TextLayout, names: Sequence[str]) -> float | None:
    """A property of the time base in SI units; None where it is not there."""
    texts = next((layout.properties[name] for name in names if name in layout.properties), ())
    match = next((match for text in texts if text and (match := VALUE.fullmatch(text.strip()))), None)
    value = number_in(match[1], layout.decimal) if match else None
    if match is None or value is None or not isfinite(value):
        return None
    unit = match[2] or next((text for text in texts if text and text != match[0]), "")
    unit = unit.strip("() ").translate({ord("µ"): "u", ord("μ"): "u"})
    time_unit = unit_in(unit)
    if time_unit is not None and time_unit.value.endswith("s"):
        return value * SIZES[time_unit.value[:-1]]
    prefix = unit[:1] if re.match(r"[kMG](?:Hz|Sa|S)", unit) else ""
    return value * SIZES[prefix]


def _rows(data: bytes, layout: TextLayout) -> Iterator[tuple[int, bytes]]:
    """The lines of numbers that are not blank, with their numbers."""
    return ((line, row) for line, row in enumerate(io.BytesIO(data), 1) if line > layout.first and row.strip())


def _cell_of(data: bytes, layout: TextLayout, row: int) -> tuple[int, Callable[[int], str]]:
    """Line of a sample in a file, and what stands there in a column."""
    line, text = next(pair for k, pair in enumerate(_rows(data, layout)) if k == row)
    cells = layout.split(text.decode("utf-8", "replace"))
    return line, lambda k: cells[k]


def _numbers(name: str, data: bytes, place: int, layout: TextLayout, used: list[int]) -> Array:
    """Read the numbers (n, columns) of the columns that are used, from a place in the bytes on.

    Raises
    ------
    ScenarioError
        With the first row that is wrong.
    """
    body = data[place:]
    if layout.decimal is DecimalMark.COMMA:
        body = body.replace(b",", b".")
    mark = layout.delimiter.encode()
    try:
        rows = _loaded(body, layout, used)
    except ValueError:
        try:
            rows = _loaded(_with_missing(body, mark), layout, used)
        except ValueError:
            message = "rows cannot be read as numbers (allowed: numbers alone)"
            wrong = _first_wrong_row(name, data, layout, used)
            raise wrong or ScenarioError.in_line(name, layout.first + 1, "", message) from None
    # More values than columns would not be seen where some are not used: a decimal comma makes them.
    if layout.delimiter is not Delimiter.BLANKS and body.count(mark) != len(rows) * (layout.cells - 1):
        wrong = _first_wrong_row(name, data, layout, used)
        if wrong is not None:
            raise wrong
    return rows


def _loaded(body: bytes, layout: TextLayout, used: list[int]) -> Array:
    delimiter = None if layout.delimiter is Delimiter.BLANKS else layout.delimiter.value
    if not body.strip():
        return np.empty((0, len(used)))
    read = partial(np.loadtxt, comments=None, usecols=used, ndmin=2, quotechar='"', encoding="utf-8")
    return np.asarray(read(io.BytesIO(body), delimiter=delimiter))


def _with_missing(body: bytes, mark: bytes) -> bytes:
    """Rows of numbers with a word in each cell that is blank, and for what is beyond the range of an instrument."""
    between = re.escape(mark)
    body = re.sub(rb"(?m)^(?=" + between + rb")", b"nan", body)
    body = re.sub(between + rb"[ ]*(?=" + between + rb"|\r?\n|\r?\Z)", mark + b"nan", body)
    return body.replace("∞".encode(), b"inf")


def _first_wrong_row(name: str, data: bytes, layout: TextLayout, used: list[int]) -> ScenarioError | None:
    """The error about the first row of a file that is no row of numbers; None where none is told apart."""
    for line, row in _rows(data, layout):
        cells = layout.split(row.decode("utf-8", "replace"))
        if len(cells) != layout.cells:
            comma = " A decimal comma?" if len(cells) > layout.cells else ""
            how = "rows that are alike; record.delimiter and record.decimal say what the marks are"
            message = f"{len(cells)} values for {layout.cells} columns.{comma} (allowed: {how})"
            return ScenarioError.in_line(name, line, "", message)
        if any(cells[k] and layout.value(cells[k]) is None for k in used):
            return _wrong_cell(name, cells, layout, line, used)
    return None


def _wrong_cell(
    name: str, cells: list[str], layout: TextLayout, line: int, used: Sequence[int] | None = None
) -> ScenarioError:
    """The error about the first cell of a row that is no number."""
    k = next(k for k in (layout.numeric if used is None else used) if layout.value(cells[k]) is None)
    title = layout.titles[k].name if layout.titles else f"column {k + 1}"
    return ScenarioError.in_line(name, line, visible(title[:LONGEST_TITLE]), no_number(cells[k]))


def no_number(text: str) -> str:
    """Message about a cell that holds no finite number."""
    hint = "; decimal comma?" if text.count(",") == 1 else ""
    what = f"'{visible(text[:LONGEST_CELL])}' is not a finite number{hint}" if text else "is empty"
    return f"{what} (allowed: a number with a decimal point, such as 0.2345)"
