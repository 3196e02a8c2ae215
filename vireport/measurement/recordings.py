"""Raw signals as they were recorded: channels with names and units from CSV, WAV and MATLAB files, read strictly.

A channel is named by what it is: the membrane that it hears, the quantity and the unit, such as ``bottom_voltage_v``.
Nothing is guessed: without a unit, with a name that is not known, or with times that are not those of a clock, a
recording is refused, with what is allowed.
"""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from difflib import get_close_matches
from enum import Enum
from functools import partial
from itertools import pairwise
from math import isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np
from msgspec import Struct

from vireport.base.errors import Mistake, Mistakes, ScenarioError, UsageError, VireportError
from vireport.base.reading import ANYWHERE, ReadingPlace
from vireport.base.records import brief
from vireport.measurement.flights import Array
from vireport.measurement.matlab import vectors
from vireport.measurement.records import (
    LONGEST_LINE,
    LONGEST_TITLE,
    first_long_line,
    no_number,
    with_line_feeds,
)
from vireport.measurement.sound_files import read_sound
from vireport.scenario.document import LARGEST_FILE, join
from vireport.scenario.document import read as read_document
from vireport.text.foreign import visible

LARGEST_RECORDING = 2_000_000_000
"""Bytes of a file."""

FEWEST_SAMPLES = 64

UNITS = {
    "voltage": {"kv": 1e3, "v": 1.0, "mv": 1e-3},
    "sound": {"pa": 1.0, "v": 1.0, "mv": 1e-3, "fs": 1.0},
    "acceleration": {"m_s2": 1.0, "g": 9.80665},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
}
"""Of each quantity the units that end a column's name, in SI units; fs is the full scale of a sound card."""

ALIKE, CLOSE = 0.6, 0.8
"""Similarities by `difflib` from which a name may be a misspelling of another, and from which it surely is."""

RATE = "sampling_rate_hz"
UNUSED = "unused"
"""What the names of channels begin with that are not looked at."""

LIKELY = 12
"""Columns among which names are looked for, and for which they are proposed."""

GAP = 1.75
"""Steps over the usual one from which samples are missing."""

MOST_GAPS = 0.001
"""Share of steps that may be gaps: beyond, the steps are unequal."""

UNEVEN = 0.5
"""Steps by which a time may be off an even clock, as those are that were rounded."""

FINEST, COARSEST = 1e-9, 1e6
"""Steps that a clock can have [s]."""

LARGEST_VALUE = 1e12
"""Of a signal, in SI units: beyond what is measured, and far below what overflows."""

SIGNALS = "time_s", "voltage_v", "acceleration_m_s2"
"""Names for the columns of a file that has none, as an example."""

LONGEST_HEAD = 400
"""Characters of a first line that is proposed."""

EXAMPLE = "time_s,bottom_voltage_v,top_voltage_v,acceleration_m_s2"


class HeardPlace(Enum):
    """The place that a channel records: a membrane, either of them, or the capsule's acceleration."""

    BOTTOM = "bottom"
    TOP = "top"
    EITHER = "either"
    CAPSULE = "capsule"


def _names() -> Iterator[tuple[str, tuple[HeardPlace | None, float]]]:
    """Every name that a channel can have, with what it hears, None of times, and its unit in SI units."""
    of_quantity: dict[str, dict[str, HeardPlace | None]] = {
        "acceleration": {"": HeardPlace.CAPSULE},
        "time": {"": None},
    }
    of_membranes: dict[str, HeardPlace | None] = {
        "bottom_": HeardPlace.BOTTOM,
        "top_": HeardPlace.TOP,
        "": HeardPlace.EITHER,
    }
    for quantity, units in UNITS.items():
        for head, place in of_quantity.get(quantity, of_membranes).items():
            yield from ((f"{head}{quantity}_{unit}", (place, size)) for unit, size in units.items())


NAMES: Mapping[str, tuple[HeardPlace | None, float]] = dict(_names())
"""The names of channels, see `_names`."""


class Channel(Struct, frozen=True, eq=False):
    """A signal of a recording, by what it hears.

    Attributes
    ----------
    name : str
        As in the file.
    place : HeardPlace
    values : Array (n,)
        In SI units, or in shares of full scale.
    """

    name: str
    place: HeardPlace
    values: Array

    __repr__ = brief


class Unbroken(Struct, frozen=True):
    """Samples without a gap: from row `first` up to but without `last`, the first of them at `start_s`."""

    first: int
    last: int
    start_s: float


class Recording(Struct, frozen=True, eq=False):
    """The signals of one recording, sampled on one clock.

    Attributes
    ----------
    name : str
        Of the file.
    step_s : float
        Time from a sample to the next.
    stretches : tuple of Unbroken
        In the order of time; between them samples are missing.
    channels : tuple of Channel
    uneven_s : float
        By how much times were off an even clock, on which they are put.
    """

    name: str
    step_s: float
    stretches: tuple[Unbroken, ...]
    channels: tuple[Channel, ...]
    uneven_s: float = 0.0

    __repr__ = brief

    @property
    def samples(self) -> int:
        """Number of samples of each channel."""
        return len(self.channels[0].values)

    @property
    def start_s(self) -> float:
        """Time of the first sample."""
        return self.stretches[0].start_s

    @property
    def end_s(self) -> float:
        """Time of the last sample of a channel [s]."""
        last = self.stretches[-1]
        return last.start_s + (last.last - last.first - 1) * self.step_s

    def of(self, *places: HeardPlace) -> tuple[Channel, ...]:
        """The channels that record at any of some places."""
        return tuple(channel for channel in self.channels if channel.place in places)


def read_recording(path: str, place: ReadingPlace = ANYWHERE) -> Recording:
    """Read a recording: a CSV file with times, a WAV file with its notes, or a MATLAB file.

    Parameters
    ----------
    path : str
    place : ReadingPlace, optional
        Where the file is looked for, and its notes.

    Raises
    ------
    UsageError
        If the file cannot be read, or is not of a kind that is known.
    ScenarioError
        With what is wrong in it.
    """
    name = visible(place.path_of(path))
    readers: Mapping[str, Callable[[str, bytes], Recording]] = {
        ".csv": _of_csv,
        ".wav": lambda name, data: _of_wav(name, data, _notes(path, place)),
        ".mat": _of_mat,
    }
    reader = readers.get(Path(path).suffix.lower())
    if reader is None:
        raise UsageError(f"{name} is no record of signals (allowed: a file that ends in .csv, .wav or .mat)")
    return reader(name, place.read(path, LARGEST_RECORDING))


def _refused(name: str, path: str, message: str, line: int = 1) -> VireportError:
    """An error about a part of a file: at a line of a text, by name and path of others."""
    if name.lower().endswith((".wav", ".mat")):
        return UsageError(f"{name}: {path}: {message}" if path else f"{name}: {message}")
    return ScenarioError(name, [Mistake(line, path, message)])


def _require_names(name: str, titles: list[str], timed: bool) -> None:
    """Refuse names that are not those of channels, or channels that do not tell impacts on both membranes.

    Parameters
    ----------
    name : str
        Of the file.
    titles : list of str
        The names.
    timed : bool
        Whether one of them must be of times.

    Raises
    ------
    UsageError, ScenarioError
        With all mistakes in them.
    """
    mistakes, hinted = Mistakes(), set[str]()
    taken = [title for title in titles if not title.startswith(UNUSED)]
    # What has no names at all, of which nothing is shown: it may be a file that was not meant to be read.
    if timed and taken and not any(title in NAMES or _meant(title, CLOSE) for title in taken[:LIKELY]):
        count = max(len(titles), 2)
        line = ",".join((*SIGNALS, *(f"{UNUSED}_{k}" for k in range(1, LIKELY)))[:count])
        raise _refused(
            name,
            "",
            "the first line names no signal with its unit (allowed there: names for each column, and numbers alone "
            f"from the second line on; write what its columns are, such as {line})",
        )
    for column, title in enumerate(titles, 1):
        if title in taken and title not in NAMES:
            mistakes.add(1, visible(title[:LONGEST_TITLE]), partial(_unknown, title, column, hinted))
    for title, count in Counter(taken).items():
        if count > 1:
            mistakes.add(1, visible(title[:LONGEST_TITLE]), "stands twice (each once)")
    if mistakes:
        raise ScenarioError(name, mistakes.reported, mistakes.more)
    places = [NAMES[title][0] for title in taken]
    if timed and places.count(None) != 1:
        raise _refused(
            name, "", f"one column of times is needed (allowed: time_s, time_ms or time_us, as in {EXAMPLE})"
        )
    for place in HeardPlace:
        if places.count(place) > 1:
            raise _refused(name, "", f"two signals are of the same kind, {place.value} (allowed: one of each)")
    of_membranes, either = {HeardPlace.BOTTOM, HeardPlace.TOP} & set(places), HeardPlace.EITHER in places
    if (
        len(of_membranes) == 1
        or (of_membranes and either)
        or not (of_membranes or either or HeardPlace.CAPSULE in places)
    ):
        raise _refused(
            name,
            "",
            "impacts on both membranes are needed (allowed: bottom_... and top_..., or one signal such as voltage_v "
            "or sound_pa whose sign tells them apart, positive at the bottom, or acceleration_m_s2 alone)",
        )


def _lacking_unit(title: str) -> str:
    """A channel's name that a title is without its unit, or with a part of it; "" where there is none."""
    return next((name for name in NAMES if title in (name.rpartition("_")[0], name[:-5])), "")


def _meant(title: str, alike: float = ALIKE) -> str:
    """The channel's name that a misspelt one, or one without its unit, most likely stands for; "" without one."""
    short = title[:LONGEST_TITLE]
    return next(iter(get_close_matches(short, NAMES, 1, alike)), _lacking_unit(short))


def _unknown(title: str, column: int, hinted: set[str]) -> str:
    """Message about a name that is not a channel's, with the likely one, which is hinted at once in a file."""
    allowed = f"(allowed: names such as {EXAMPLE}, or {UNUSED}_...)"
    if not title:
        return f"column {column} has no name {allowed}"
    meant = _meant(title)
    hint = f"; did you mean '{meant}'?" if meant and meant not in hinted else ""
    hinted.add(meant)
    return f"the name {'has no unit' if _lacking_unit(title) else 'is no signal with a unit'}{hint} {allowed}"


Located = Callable[[int], tuple[int, Callable[[str], str]]]
"""From the number of a sample to its line in the file, and to the cell there under a column's name."""


class _Source(NamedTuple):
    """A file of signals as messages name it: its name, and its lines and cells where it is a text."""

    name: str
    located: Located | None = None

    def refused(self, title: str, row: int, number: float, message: str) -> VireportError:
        """An error about a sample: its line and cell where the file has some, or else its number and value."""
        if self.located is None:
            return _refused(self.name, title, f"sample {row + 1}, {number!r}, {message}")
        line, cell = self.located(row)
        return _refused(self.name, title, f"'{visible(cell(title)[:LONGEST_TITLE])}' {message}", line)


def _recorded(
    source: _Source, titles: list[str], columns: list[Array], times: Array | None, rate_hz: float
) -> Recording:
    """Make a recording of the columns of a file, whose names are those of channels.

    Parameters
    ----------
    source : _Source
    titles : list of str
        Names of the columns.
    columns : list of Array (n,)
        In the units of their names.
    times : Array (n,) or None
        Of the samples [s].
    rate_hz : float
        At which they were taken, without times.

    Raises
    ------
    UsageError, ScenarioError
        If a sample is no measured value, there are too few, or the times are not those of a clock.
    """
    name, channels = source.name, []
    for title, column in zip(titles, columns, strict=True):
        if title not in NAMES:
            continue
        place, size = NAMES[title]
        with np.errstate(over="ignore"):
            values = column if size == 1.0 else column * size
        # Both extremes are not finite if any sample is not: records are long, and most need no array of flags.
        largest = max(float(values.max(initial=0.0)), -float(values.min(initial=0.0)))
        if not isfinite(largest):
            row = int(np.flatnonzero(~np.isfinite(values))[0])
            raise source.refused(title, row, float(column[row]), "is not a finite number (allowed: finite ones)")
        if place is None:
            continue
        if largest > LARGEST_VALUE:
            row, allowed = int(np.abs(values).argmax()), f"(allowed: at most {LARGEST_VALUE:g} in SI units)"
            raise source.refused(title, row, float(column[row]), f"is no measured value {allowed}")
        channels.append(Channel(title, place, values))
    count = len(channels[0].values)
    if count < FEWEST_SAMPLES:
        raise _refused(name, "", f"{count} samples (at least {FEWEST_SAMPLES} are needed, and seconds of them for use)")
    if times is None:
        _require_clock(name, 1 / rate_hz)
        return Recording(name, 1 / rate_hz, (Unbroken(0, count, 0.0),), tuple(channels))
    title = next(title for title in titles if _is_of_times(title))
    step, stretches, uneven = _clock(source, title, times)
    return Recording(name, step, stretches, tuple(channels), uneven)


def _is_of_times(title: str) -> bool:
    """Whether a column of some name has times."""
    return title in NAMES and NAMES[title][0] is None


def _times(titles: list[str], columns: list[Array]) -> Array:
    """The times [s] among the columns of a file, of which one has times."""
    title, column = next(pair for pair in zip(titles, columns, strict=True) if _is_of_times(pair[0]))
    with np.errstate(over="ignore"):
        return column * NAMES[title][1]


def _require_clock(name: str, step: float) -> None:
    """Refuse steps between samples that no clock has.

    Raises
    ------
    UsageError, ScenarioError
    """
    if not FINEST <= step <= COARSEST:
        raise _refused(name, "time", f"samples are {step:.3g} s apart (allowed: {FINEST:g} to {COARSEST:g} s)")


def _clock(source: _Source, title: str, times: Array) -> tuple[float, tuple[Unbroken, ...], float]:
    """The step of times [s], the stretches without gaps, and the largest distance of a time from an even clock [s].

    Raises
    ------
    UsageError, ScenarioError
        If the times do not ascend at equal steps.
    """
    name, steps = source.name, np.diff(times)
    if (steps <= 0).any():
        row = int(np.flatnonzero(steps <= 0)[0]) + 1
        message = "is not after the time before it (allowed: ascending times, written with enough digits)"
        raise source.refused(title, row, float(times[row]), message)
    # The median tells gaps from steps, whatever their number. But it has the rounding of one written time, of which the
    # mean of all steps has a part only.
    usual = float(np.median(steps))
    _require_clock(name, usual)
    gaps = np.flatnonzero(steps > GAP * usual)
    even = steps <= GAP * usual
    step = float(steps[even].mean())
    if len(gaps) > max(MOST_GAPS * len(steps), 3):
        raise _refused(name, title, _unequal(steps))
    ends = np.concatenate([[0], gaps + 1, [len(times)]]).tolist()
    stretches, worst = [], 0.0
    for first, last in pairwise(ends):
        stretch_times = times[first:last]
        late = stretch_times - step * np.arange(len(stretch_times))
        # In the middle, where the largest distance of a time from the even clock is least.
        start = float((late.min() + late.max()) / 2)
        worst = max(worst, float(late.max() - late.min()) / 2)
        stretches.append(Unbroken(first, last, start))
    if worst > UNEVEN * step:
        raise _refused(name, title, _unequal(steps))
    return step, tuple(stretches), worst


def _unequal(steps: Array) -> str:
    """Message about times at unequal steps [s], and what to do about them."""
    low, high = np.quantile(steps, [0.01, 0.99])
    how = f"interpolate the signals at steps of {float(np.median(steps)):.4g} s first, as by cubic splines"
    allowed = f"(allowed: samples at equal steps, with few gaps; {how})"
    return f"the steps are unequal, mostly {low:.4g} to {high:.4g} s {allowed}"


def _of_csv(name: str, data: bytes) -> Recording:
    """Read a recording from the bytes of a CSV file."""
    data = with_line_feeds(data)
    end = data.find(b"\n")
    if (start := first_long_line(data)) is not None:
        line = data.count(b"\n", 0, start) + 1
        raise _refused(name, "", f"a line of more than {LONGEST_LINE} bytes (allowed: a sample of each signal)", line)
    try:
        head = data[: end if end >= 0 else len(data)].decode("utf-8-sig").strip()
    except UnicodeDecodeError as error:
        raise _refused(name, "", _no_utf_8(error)) from None
    if not head:
        raise _refused(name, "", f"the first line is empty (allowed: names and units, {EXAMPLE})")
    for sign, what in ((";", "semicolons"), ("\t", "tabs")):
        if sign in head and "," not in head:
            raise _refused(name, "", f"columns are separated by {what} (allowed: commas, and points in numbers)")
    titles = [title.strip().strip('"').strip() for title in head.split(",")]
    _require_names(name, titles, timed=True)
    used = [k for k, title in enumerate(titles) if not title.startswith(UNUSED)]
    if end < 0 or not data[end:].strip():
        raise _refused(name, "", f"no sample follows the names (at least {FEWEST_SAMPLES} are needed)")
    rows = _numbers(name, data, end, titles, used)
    columns = [np.ascontiguousarray(rows[:, k]) for k in range(len(used))]
    del rows  # the columns are copies: a long record need not be in memory twice
    names = [titles[k] for k in used]
    times = _times(names, columns)
    return _recorded(_Source(name, partial(_cell_of, data, titles)), names, columns, times, 0.0)


def _rows(data: bytes) -> Iterator[tuple[int, bytes]]:
    """The lines below the first that are not blank, with their numbers."""
    return ((line, row) for line, row in enumerate(io.BytesIO(data), 1) if line > 1 and row.strip())


def _cell_of(data: bytes, titles: list[str], row: int) -> tuple[int, Callable[[str], str]]:
    """Line of a sample in a file, and what stands there in a column."""
    line, cells_of_row = next(row_cells for k, row_cells in enumerate(_rows(data)) if k == row)
    cells = cells_of_row.decode("utf-8", "replace").split(",")
    return line, lambda title: cells[titles.index(title)].strip()


def _no_utf_8(error: UnicodeDecodeError) -> str:
    """Message about a byte that is no UTF-8."""
    return f"byte 0x{error.object[error.start]:02X} is not UTF-8 (save the file as CSV in UTF-8)"


def _numbers(name: str, data: bytes, end: int, titles: list[str], used: list[int]) -> Array:
    """Read the numbers of the columns that are used, (n, columns), below the first line, which ends at byte `end`.

    Raises
    ------
    ScenarioError
        With the first row that is wrong.
    """
    stream = io.BytesIO(data)
    stream.seek(end + 1)
    try:
        # Of columns that are not used nothing need be a number.
        some = used if len(used) < len(titles) else None
        rows = np.loadtxt(stream, delimiter=",", usecols=some, ndmin=2, comments=None, quotechar='"', encoding="utf-8")
    except (ValueError, UnicodeDecodeError):
        raise _wrong_row(name, data, titles, used) from None
    # More values than columns would not be seen where some are not used: a decimal comma makes them.
    if rows.shape[1] != len(used) or data.count(b",", end) != len(rows) * (len(titles) - 1):
        raise _wrong_row(name, data, titles, used)
    return rows


def _wrong_row(name: str, data: bytes, titles: list[str], used: list[int]) -> VireportError:
    """The error about the first row of a file that is no row of numbers."""
    for line, row in _rows(data):
        try:
            cells = row.decode("utf-8").strip().split(",")
        except UnicodeDecodeError as error:
            k = row.count(b",", 0, error.start)
            return _refused(
                name, visible((titles[k] if k < len(titles) else "")[:LONGEST_TITLE]), _no_utf_8(error), line
            )
        if len(cells) == len(titles) + 1 and not cells[-1].strip():
            named = visible(",".join((*titles, f"{UNUSED}_{len(cells)}")), LONGEST_HEAD)
            message = (
                f"the row ends with a comma, and so has a column without a name (write as the first line: {named})"
            )
            return _refused(name, "", message, line)
        if len(cells) != len(titles):
            comma = " A decimal comma?" if len(cells) > len(titles) else ""
            message = f"{len(cells)} values for {len(titles)} columns.{comma} (allowed: points in numbers)"
            return _refused(name, "", message, line)
        for k in used:
            cell = cells[k].strip().strip('"').strip()
            try:
                numeric = cell.isascii() and "_" not in cell and isfinite(float(cell))
            except ValueError:
                numeric = False
            if not numeric:
                return _refused(name, titles[k], no_number(cell), line)
    return _refused(name, "", "rows cannot be read as numbers (allowed: numbers, with commas between columns)")


def _of_wav(name: str, data: bytes, notes: Notes) -> Recording:
    """Read a recording from the bytes of a WAV file and its notes."""
    sound = read_sound(name, data)
    if len(sound.channels) != len(notes.full_scales):
        count = f"names {len(notes.full_scales)} channels, and the file has {len(sound.channels)}"
        raise _refused(notes.name, "channels", f"{count} (allowed: all of them)", notes.line)
    columns = [full * samples for full, samples in zip(notes.full_scales.values(), sound.channels, strict=True)]
    return _recorded(_Source(name), list(notes.full_scales), columns, None, sound.rate_hz)


class Notes(Struct, frozen=True):
    """Names and full scales of the channels of a WAV file, from the notes that come with it.

    Attributes
    ----------
    name : str
        Of the notes.
    line : int
        In which the channels begin.
    full_scales : dict of str to float
    """

    name: str
    line: int
    full_scales: dict[str, float]


def _notes(path: str, place: ReadingPlace) -> Notes:
    """Read the notes that come with a WAV file, as strictly as a scenario.

    Raises
    ------
    UsageError, ScenarioError
        If there are none, or something is wrong with them.
    """
    file_name = visible(place.path_of(f"{path}.yaml"))
    allowed = "channels: with a line for each channel in its order, such as bottom_sound_fs: 1 or acceleration_m_s2: 49"
    try:
        text = place.read(f"{path}.yaml", LARGEST_FILE)
    except UsageError as error:
        if isinstance(error.__cause__, FileNotFoundError):
            name = visible(place.path_of(path))
            raise UsageError(
                f"{name} does not say what its channels are: {file_name} is missing (allowed there: {allowed})"
            ) from error
        raise
    document = read_document(text, file_name)
    if document.mistakes:
        # The others of a few lines follow from it, or are alike.
        raise ScenarioError(file_name, sorted(document.mistakes, key=lambda mistake: mistake.line)[:1])
    keys = document.data
    channels = keys.get("channels") if isinstance(keys, dict) and set(keys) == {"channels"} else None
    if not isinstance(channels, dict) or not channels:
        raise _refused(file_name, "", f"has no channels (allowed: {allowed})", document.line_of(""))
    titles = list(channels)
    _require_names(file_name, titles, timed=False)
    line = document.line_of("channels")
    if any(map(_is_of_times, titles)):
        raise _refused(file_name, "channels", "a WAV file has no channel of times (its rate is in the file)", line)
    for title, full in channels.items():
        if isinstance(full, bool) or not isinstance(full, int | float) or not 0 < abs(full) <= LARGEST_VALUE:
            key = join("channels", title)
            value_text = visible(document.written.get(key, "a block of keys or a list"), LONGEST_TITLE)
            value_text = f"'{value_text}'" if isinstance(full, str) and value_text[:1] not in "'\"" else value_text
            message = f"got {value_text} (allowed: full scale in the unit, negative if turned about)"
            raise _refused(file_name, key, message, document.line_of(key))
    return Notes(file_name, line, {title: float(full) for title, full in channels.items()})


def _of_mat(name: str, data: bytes) -> Recording:
    """Read a recording from the bytes of a MATLAB file."""

    def wanted(titles: list[str]) -> list[str]:
        names = [title for title in titles if title != RATE]
        if not names:
            raise _refused(name, "", f"the file has no variables (allowed: vectors named as columns, {EXAMPLE})")
        _require_names(name, names, timed=False)
        return [title for title in titles if not title.startswith(UNUSED)]

    vectors_of_file = vectors(name, data, wanted, LARGEST_RECORDING)
    used = [title for title in vectors_of_file if title != RATE]
    columns = []
    for title in used:
        values = vectors_of_file[title]
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiu" or values.size != max(values.shape):
            raise _refused(name, title, "is no vector of real numbers (allowed: one)")
        columns.append(np.asarray(values, dtype=float).ravel())
    if len(lengths := {len(column) for column in columns}) > 1:
        raise _refused(name, "", f"vectors of {min(lengths)} to {max(lengths)} samples (allowed: all of one length)")
    timed = sum(map(_is_of_times, used))
    if timed + (RATE in vectors_of_file) != 1:
        raise _refused(name, "", f"either the vector time_s or the number {RATE} is needed (allowed: one of them)")
    if timed:
        return _recorded(_Source(name), used, columns, _times(used, columns), 0.0)
    rate = vectors_of_file[RATE]
    if rate.size != 1 or rate.dtype.kind not in "fiu" or not isfinite(hertz := float(rate.ravel()[0])) or hertz <= 0:
        raise _refused(name, RATE, "is no positive number (allowed: samples in a second)")
    return _recorded(_Source(name), used, columns, None, hertz)
