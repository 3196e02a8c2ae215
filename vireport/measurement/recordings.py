"""Raw signals as they were recorded: channels with names and units from the columns of any file that is read.

A channel is named by what it is: the membrane that it hears, the quantity and the unit, such as ``bottom_voltage_v``.
Columns of a file have such names themselves, or a `record:` block says which column is which signal. Nothing is
guessed: without a unit, or with times that run back, a recording is refused, with what is allowed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from enum import Enum
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from vireport.base.errors import Mistakes, ScenarioError, UsageError, VireportError
from vireport.base.reading import ANYWHERE, ReadingPlace
from vireport.base.records import brief
from vireport.measurement.flights import Array, Mask
from vireport.measurement.readers import WAV, reader_of
from vireport.measurement.tables import (
    LARGEST_FILE_OF_SIGNALS,
    UNITS,
    UNUSED,
    RecordedTable,
    Title,
    column_of,
    unit_size,
)
from vireport.measurement.text_files import LONGEST_TITLE
from vireport.scenario.blocks import LayoutBlock
from vireport.scenario.document import LARGEST_FILE, join
from vireport.scenario.document import read as read_document
from vireport.text.foreign import visible

FEWEST_SAMPLES = 64

ALIKE, CLOSE = 0.6, 0.8
"""Similarities by `difflib` from which a name may be a misspelling of another, and from which it surely is."""

LIKELY = 12
"""Columns among which names are looked for, and for which they are proposed."""

GAP = 1.75
"""Steps over the usual one from which samples are missing."""

MOST_GAPS = 0.001
"""Share of steps that may be gaps: beyond, the steps are unequal."""

UNEVEN = 0.5
"""Steps by which a time may be off an even clock, as those are that were rounded."""

WIDE_GAP = 10.0
"""Steps over the usual one from which samples are missing where the steps are unequal."""

ROUNDED = 0.01
"""Steps by which a time is off an even clock and no more is said of it."""

SAME_STEP = 0.01
"""Share by which the steps of times and that of a file's rate may differ: some of them are rounded."""

FINEST, COARSEST = 1e-9, 1e6
"""Steps that a clock can have [s]."""

LARGEST_VALUE = 1e12
"""Of a signal, in SI units: beyond what is measured, and far below what overflows."""

EXAMPLE = "time_s,bottom_voltage_v,top_voltage_v,acceleration_m_s2"

HOW = "vireport identify --inspect FILE shows what is in it, and the record: block that says what its columns are"


class HeardPlace(Enum):
    """What a channel records: a membrane, either of them, or the capsule's acceleration or displacement."""

    BOTTOM = "bottom"
    TOP = "top"
    EITHER = "either"
    CAPSULE = "capsule"
    DISPLACEMENT = "displacement"


def _names() -> Iterator[tuple[str, tuple[HeardPlace | None, float]]]:
    """Every name that a channel can have, with what it hears, None of times, and its unit in SI units."""
    of_quantity: dict[str, dict[str, HeardPlace | None]] = {
        "acceleration": {"": HeardPlace.CAPSULE},
        "displacement": {"": HeardPlace.DISPLACEMENT},
        "time": {"": None},
    }
    of_membranes: dict[str, HeardPlace | None] = {
        "bottom_": HeardPlace.BOTTOM,
        "top_": HeardPlace.TOP,
        "": HeardPlace.EITHER,
    }
    for quantity, units in UNITS.items():
        for head, place in of_quantity.get(quantity, of_membranes).items():
            for unit, size in units.items():
                yield f"{head}{quantity}_{unit.lower().replace('/', '_')}", (place, size)


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


class FlawKind(Enum):
    """What is wrong with samples that were left out."""

    MISSING = "missing"
    REPEATED = "repeated"


class Flaw(Struct, frozen=True):
    """Samples that were left out: how many, and the row and the time of the first, in a signal or "" of times."""

    kind: FlawKind
    signal: str
    count: int
    row: int
    at_s: float


class Recording(Struct, frozen=True, eq=False):
    """The signals of one recording, sampled on one clock.

    Attributes
    ----------
    name : str
        Of the file.
    step_s : float
        Time from a sample to the next [s].
    stretches : tuple of Unbroken
        In the order of time; between them samples are missing.
    channels : tuple of Channel
    uneven_s : float
        Largest distance of the times from an even clock [s].
    even : bool
        Whether the times are put on that clock; else they are used as they are, and `step_s` is the usual step.
    clock : ndarray (n,) or None
        Times of the samples where they are off an even clock [s].
    reading : str
        As what the file was read.
    flaws : tuple of Flaw
    """

    name: str
    step_s: float
    stretches: tuple[Unbroken, ...]
    channels: tuple[Channel, ...]
    uneven_s: float = 0.0
    even: bool = True
    clock: Array | None = None
    reading: str = ""
    flaws: tuple[Flaw, ...] = ()

    __repr__ = brief

    @property
    def samples(self) -> int:
        """Number of samples of each channel."""
        return len(self.channels[0].values)

    @property
    def start_s(self) -> float:
        """Time of the first sample [s]."""
        return self.stretches[0].start_s

    @property
    def end_s(self) -> float:
        """Time of the last sample of a channel [s]."""
        last = self.stretches[-1]
        return float(self.times_of(last, np.array([last.last - 1.0]))[0])

    def times_of(self, stretch: Unbroken, rows: NDArray[Any]) -> Array:
        """Times of samples of a stretch by their rows, and between them of fractions of rows [s]."""
        if self.even or self.clock is None:
            return np.asarray(stretch.start_s + (rows - stretch.first) * self.step_s)
        clock = self.clock[stretch.first : stretch.last]
        return np.asarray(np.interp(rows, np.arange(stretch.first, stretch.last), clock))

    @property
    def times(self) -> Array:
        """Times of all samples [s]."""
        return np.concatenate([self.times_of(part, np.arange(part.first, part.last)) for part in self.stretches])

    @property
    def step_spread_s(self) -> float:
        """Standard deviation of the steps between samples, without gaps [s]."""
        steps = np.diff(self.times)
        return float(steps[steps <= WIDE_GAP * self.step_s].std())

    def row_of(self, stretch: Unbroken, time_s: float) -> float:
        """Row, with its fraction, of a time in a stretch."""
        if self.even or self.clock is None:
            return stretch.first + (time_s - stretch.start_s) / self.step_s
        rows = np.arange(stretch.first, stretch.last)
        return float(np.interp(time_s, self.clock[stretch.first : stretch.last], rows))

    def of(self, *places: HeardPlace) -> tuple[Channel, ...]:
        """The channels that record at any of some places."""
        return tuple(channel for channel in self.channels if channel.place in places)


def read_recording(path: str, place: ReadingPlace = ANYWHERE, keys: LayoutBlock | None = None) -> Recording:
    """Read a recording from a file of any format that is known by its content.

    Parameters
    ----------
    path : str
    place : ReadingPlace, optional
        Where the file is looked for, and the notes of a WAV file.
    keys : LayoutBlock, optional
        What its columns are, where they are not named as signals.

    Raises
    ------
    UsageError
        If the file cannot be read, or is not of a kind that is known.
    ScenarioError
        With what is wrong in it.
    """
    keys, name = keys or LayoutBlock(), visible(place.path_of(path))
    data = place.read(path, LARGEST_FILE_OF_SIGNALS)
    reader = reader_of(name, data)
    named = keys.columns is not None
    notes = _notes(path, place) if reader is WAV and not named else None
    signals: list[_Signal] = []

    def wanted(titles: Sequence[Title]) -> list[int]:
        if notes is not None:
            signals.extend(_noted(notes, titles))
        else:
            signals.extend(_mapped(name, titles, keys) if named else _named(name, titles))
        return [signal.column for signal in signals]

    table = reader.read(name, data, keys, wanted)
    return _recorded(name, table, signals, keys)


class _Signal(NamedTuple):
    """A signal by its name, its column in the file, and the size of 1 there in SI units."""

    name: str
    column: int
    size: float


def _refused(name: str, path: str, message: str) -> UsageError:
    """An error about a part of a file."""
    return UsageError(f"{name}: {path}: {message}" if path else f"{name}: {message}")


def _named(name: str, titles: Sequence[Title]) -> list[_Signal]:
    """The signals of a file whose columns are named as such."""
    names = [title.name for title in titles]
    _require_names(name, names)
    return [_Signal(title, k, NAMES[title][1]) for k, title in enumerate(names) if title in NAMES]


def _mapped(name: str, titles: Sequence[Title], keys: LayoutBlock) -> list[_Signal]:
    """The signals of a file whose columns a `record:` block says.

    Raises
    ------
    UsageError
        If a column is not there, or its unit is not stated, or none of its signal's quantity.
    """
    signals = []
    for signal in type(keys.columns).model_fields if keys.columns is not None else ():
        block = getattr(keys.columns, signal)
        if block is None:
            continue
        path = f"record.columns.{signal}"
        if signal not in NAMES:
            raise UsageError(f"{path}: is of a file of impacts (allowed here: signals, such as acceleration_m_s2)")
        k = column_of(f"{name}: {path}.column", block, titles)
        size = unit_size(f"{name}: {path}.unit", signal, block, titles[k])
        signals.append(_Signal(signal, k, size * block.scale * block.sign))
    of_time = [k for k, title in enumerate(titles) if title.unit in UNITS["time"]]
    if keys.columns is not None and keys.columns.time_s is None and keys.sampling_rate_hz is None and of_time:
        if len(of_time) > 1:
            named = ", ".join(visible(titles[k].name) for k in of_time)
            raise _refused(name, "record.columns.time_s", f"is needed: {named} all have times (allowed: one of them)")
        unit = titles[of_time[0]].unit
        assert unit is not None
        signals.append(_Signal("time_s", of_time[0], UNITS["time"][unit]))
    _require_signals(name, [NAMES[signal.name][0] for signal in signals])
    return signals


def _require_names(name: str, titles: list[str]) -> None:
    """Refuse names that are not those of channels, or channels that do not tell impacts on both membranes.

    Raises
    ------
    UsageError, ScenarioError
        With all mistakes in them.
    """
    mistakes, hinted = Mistakes(), set[str]()
    taken = [title for title in titles if not title.startswith(UNUSED)]
    # What has no names at all, of which nothing is shown: it may be a file that was not meant to be read.
    if not any(title in NAMES or _meant(title, CLOSE) for title in taken[:LIKELY]):
        raise _refused(
            name, "", f"no column is named as a signal with its unit (allowed: names such as {EXAMPLE}; {HOW})"
        )
    for column, title in enumerate(titles, 1):
        if title in taken and title not in NAMES:
            mistakes.add(1, visible(title[:LONGEST_TITLE]), partial(_unknown, title, column, hinted))
    for title, count in Counter(taken).items():
        if count > 1:
            mistakes.add(1, visible(title[:LONGEST_TITLE]), "stands twice (each once)")
    if mistakes:
        raise ScenarioError(name, mistakes.reported, mistakes.more)
    _require_signals(name, [NAMES[title][0] for title in taken])


def _require_signals(name: str, places: list[HeardPlace | None]) -> None:
    """Refuse signals that do not tell impacts on both membranes, or of which two are of one kind.

    Raises
    ------
    UsageError
    """
    if places.count(None) > 1:
        raise _refused(name, "", f"two columns have times (allowed: one, as in {EXAMPLE})")
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


def _recorded(name: str, table: RecordedTable, signals: Sequence[_Signal], keys: LayoutBlock) -> Recording:
    """Make a recording of the signals in a table.

    Raises
    ------
    UsageError, ScenarioError
        If a sample is no measured value, there are too few, or the times are not those of a clock.
    """
    values = {signal: table.columns[signal.column] * signal.size for signal in signals}
    of_time = [signal for signal in signals if NAMES[signal.name][0] is None]
    step = 1 / keys.sampling_rate_hz if keys.sampling_rate_hz else table.step_s
    if of_time and keys.sampling_rate_hz:
        raise UsageError(f"{name}: has times, and record.sampling_rate_hz is given (leave one of them out)")
    if not of_time and not step:
        how = f"a column of times, as in {EXAMPLE}; a rate in the file; or record.sampling_rate_hz"
        raise _refused(name, "", f"it has no times (allowed: {how})")
    count = len(next(iter(values.values())))
    if of_time:
        times: Array = values[of_time[0]]
    else:
        _require_clock(name, step)
        times = np.asarray(table.start_s + step * np.arange(count), dtype=np.float64)
    kept, flaws = np.ones(count, dtype=bool), []
    for signal, column in values.items():
        # Both extremes are finite if all samples are: records are long, and most need no array of flags.
        if np.isfinite(column.max(initial=0.0)) and np.isfinite(column.min(initial=0.0)):
            continue
        lost = ~np.isfinite(column)
        flaws.append(_flaw(FlawKind.MISSING, signal.name, lost, times))
        kept &= ~lost
    if of_time and (again := _repeated(times, kept)).any():
        flaws.append(_flaw(FlawKind.REPEATED, "", again, times))
        kept &= ~again
    if flaws:
        values, times = {signal: column[kept] for signal, column in values.items()}, times[kept]
    if len(times) < FEWEST_SAMPLES:
        few = f"{len(times)} samples" + (f" of {count} that are numbers" if flaws else "")
        raise _refused(name, "", f"{few} (at least {FEWEST_SAMPLES} are needed, and seconds of them for use)")
    channels, rows = [], np.flatnonzero(kept) if flaws else None
    for signal, column in values.items():
        place = NAMES[signal.name][0]
        if place is None:
            continue
        if max(float(column.max()), -float(column.min())) > LARGEST_VALUE:
            row, allowed = int(np.abs(column).argmax()), f"(allowed: at most {LARGEST_VALUE:g} in SI units)"
            raise _of_sample(
                name, table, signal, row if rows is None else int(rows[row]), f"is no measured value {allowed}"
            )
        channels.append(Channel(signal.name, place, column))
    reading = f"{table.reading}, {count:,} samples"
    if not of_time and not flaws:
        parts = (Unbroken(0, count, table.start_s),)
        return Recording(name, step, parts, tuple(channels), reading=f"{reading} at {time_text(step)}")
    try:
        step, stretches, uneven, even = _clock(name, times)
    except _RunsBack as error:
        row = error.row if rows is None else int(rows[error.row])
        message = "is not after the time before it (allowed: ascending times, written with enough digits)"
        raise _of_sample(name, table, of_time[0], row, message) from None
    if of_time and table.step_s and abs(step / table.step_s - 1) > SAME_STEP:
        what = f"its times are {time_text(step)} apart, and its head says {time_text(table.step_s)}"
        raise _refused(name, "", f"{what} (allowed: times and a rate that agree; leave out record.columns.time_s)")
    reading = f"{reading} at {time_text(step)}"
    clock = times if uneven > ROUNDED * step else None
    return Recording(name, step, stretches, tuple(channels), uneven, even, clock, reading, tuple(flaws))


def time_text(step: float) -> str:
    """A time between samples for the sentence that says how a file was read."""
    size, unit = next((pair for pair in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")) if step >= pair[0]), (1e-9, "ns"))
    return f"{step / size:.6g} {unit}"


def _flaw(kind: FlawKind, signal: str, where: Mask, times: Array) -> Flaw:
    """Samples that are left out, of a signal."""
    row = int(np.flatnonzero(where)[0])
    # The time itself may be what is missing.
    at = float(times[row]) if np.isfinite(times[row]) else float(np.nanmin(times[row:], initial=np.inf))
    return Flaw(kind, signal, int(where.sum()), row, at)


def _repeated(times: Array, kept: Mask) -> Mask:
    """Whether a time is that of the sample before it that is kept."""
    again = np.zeros(len(times), dtype=bool)
    rows = np.flatnonzero(kept)
    again[rows[1:]] = np.diff(times[rows]) == 0
    return again


def _of_sample(name: str, table: RecordedTable, signal: _Signal, row: int, message: str) -> VireportError:
    """An error about a sample: its line and cell where the file has some, or else its number and value."""
    title = table.titles[signal.column].name or signal.name
    if table.located is None:
        number = float(table.columns[signal.column][row])
        return _refused(name, visible(title), f"sample {row + 1}, {number!r}, {message}")
    line, cell = table.located(row)
    cell_text = visible(cell(signal.column)[:LONGEST_TITLE])
    return ScenarioError.in_line(name, line, visible(title[:LONGEST_TITLE]), f"'{cell_text}' {message}")


class _RunsBack(Exception):
    """Times run back at a row."""

    def __init__(self, row: int) -> None:
        self.row = row


def _require_clock(name: str, step: float) -> None:
    """Refuse steps between samples that no clock has.

    Raises
    ------
    UsageError, ScenarioError
    """
    if not FINEST <= step <= COARSEST:
        raise _refused(name, "time", f"samples are {step:.3g} s apart (allowed: {FINEST:g} to {COARSEST:g} s)")


def _clock(name: str, times: Array) -> tuple[float, tuple[Unbroken, ...], float, bool]:
    """The clock of a recording.

    Returns
    -------
    step, stretches, off : float, tuple of Unbroken, float
        The usual step [s], the stretches without gaps, and the largest distance of a time from an even clock [s].
    even : bool
        Whether all times are within half a step of an even clock.

    Raises
    ------
    UsageError
        If no clock has such steps.
    _RunsBack
        If the times do not ascend.
    """
    steps = np.diff(times)
    if (steps <= 0).any():
        raise _RunsBack(int(np.flatnonzero(steps <= 0)[0]) + 1)
    # The median tells gaps from steps, whatever their number, but has the rounding error of a single written time; the
    # mean of all steps has only a part of it.
    usual = float(np.median(steps))
    _require_clock(name, usual)
    gaps = np.flatnonzero(steps > GAP * usual)
    step = float(steps[steps <= GAP * usual].mean())
    even = len(gaps) <= max(MOST_GAPS * len(steps), 3)
    if not even:
        gaps, step = np.flatnonzero(steps > WIDE_GAP * usual), usual
    ends = np.concatenate([[0], gaps + 1, [len(times)]]).tolist()
    stretches, worst = [], 0.0
    for first, last in pairwise(ends):
        stretch_times = times[first:last]
        late = stretch_times - step * np.arange(len(stretch_times))
        # In the middle, where the largest distance of a time from the even clock is least.
        start = float((late.min() + late.max()) / 2)
        worst = max(worst, float(late.max() - late.min()) / 2)
        stretches.append(Unbroken(first, last, start))
    if even and worst <= UNEVEN * step:
        return step, tuple(stretches), worst, True
    used = tuple(Unbroken(stretch.first, stretch.last, float(times[stretch.first])) for stretch in stretches)
    return usual, used, worst, False


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
        raise ScenarioError.in_line(file_name, document.line_of(""), "", f"has no channels (allowed: {allowed})")
    titles = list(channels)
    _require_names(file_name, titles)
    line = document.line_of("channels")
    if any(NAMES.get(title, (HeardPlace.CAPSULE,))[0] is None for title in titles):
        raise ScenarioError.in_line(
            file_name, line, "channels", "a WAV file has no channel of times (its rate is in the file)"
        )
    for title, full in channels.items():
        if isinstance(full, bool) or not isinstance(full, int | float) or not 0 < abs(full) <= LARGEST_VALUE:
            key = join("channels", title)
            value_text = visible(document.written.get(key, "a block of keys or a list"), LONGEST_TITLE)
            value_text = f"'{value_text}'" if isinstance(full, str) and value_text[:1] not in "'\"" else value_text
            message = f"got {value_text} (allowed: full scale in the unit, negative if turned about)"
            raise ScenarioError.in_line(file_name, document.line_of(key), key, message)
    return Notes(file_name, line, {title: float(full) for title, full in channels.items()})


def _noted(notes: Notes, titles: Sequence[Title]) -> list[_Signal]:
    """The signals of a WAV file by its notes."""
    if len(titles) != len(notes.full_scales):
        count = f"names {len(notes.full_scales)} channels, and the file has {len(titles)}"
        raise ScenarioError.in_line(notes.name, notes.line, "channels", f"{count} (allowed: all of them)")
    rows = enumerate(notes.full_scales.items())
    return [_Signal(title, k, full * NAMES[title][1]) for k, (title, full) in rows if title in NAMES]
