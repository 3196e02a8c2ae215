"""Raw signals as they were recorded: channels with names and units from CSV, WAV and MATLAB files, read strictly.

A channel is named by what it is: the membrane that it hears, the quantity and the unit, such as ``bottom_voltage_v``.
Nothing is guessed: without a unit, with a name that is not known, or with times that are not those of a clock, a
recording is refused, with what is allowed.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from enum import Enum
from itertools import pairwise
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import Struct

from vireport.base import Mistake, ScenarioError, UsageError, VireportError, brief, install_command
from vireport.measurement.decimals import decimal_rows
from vireport.measurement.flights import Array
from vireport.measurement.records import contents
from vireport.text import visible

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

RATE = "sampling_rate_hz"
UNUSED = "unused"
"""What the names of channels begin with that are not looked at."""

GAP = 1.75
"""Steps over the usual one from which samples are missing."""

MOST_GAPS = 0.001
"""Share of steps that may be gaps: beyond, the steps are unequal."""

UNEVEN = 0.5
"""Steps by which a time may be off an even clock, as those are that were rounded."""

HDF5 = b"\x89HDF\r\n\x1a\n"
"""With which a file of that format begins."""

NUMERIC = "double", "single", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
"""What MATLAB calls arrays of real numbers, which complex ones are as well: these are told by their type."""

EXAMPLE = "time_s,bottom_voltage_v,top_voltage_v,acceleration_m_s2"


class HeardPlace(Enum):
    """What a channel hears."""

    BOTTOM = "bottom"
    TOP = "top"
    EITHER = "either"
    CAPSULE = "capsule"


class Channel(Struct, frozen=True, eq=False):
    """A signal.

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
    """Signals on one clock.

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
        """Of each channel."""
        return len(self.channels[0].values)

    @property
    def start_s(self) -> float:
        """Time of the first sample."""
        return self.stretches[0].start_s

    @property
    def end_s(self) -> float:
        """Time of the last sample."""
        last = self.stretches[-1]
        return last.start_s + (last.last - last.first - 1) * self.step_s

    def of(self, *places: HeardPlace) -> tuple[Channel, ...]:
        """The channels that hear some places."""
        return tuple(channel for channel in self.channels if channel.place in places)


def read_recording(path: str) -> Recording:
    """Read a recording: a CSV file with times, a WAV file with its notes beside it, or a MATLAB file.

    Raises
    ------
    UsageError
        If the file cannot be read, or is not of a kind that is known.
    ScenarioError
        With what is wrong in it.
    """
    name = visible(path)
    readers: Mapping[str, Callable[[str, bytes], Recording]] = {
        ".csv": _of_csv,
        ".wav": lambda name, data: _of_wav(name, data, path),
        ".mat": _of_mat,
    }
    reader = readers.get(Path(path).suffix.lower())
    if reader is None:
        raise UsageError(f"{name} is no record of signals (allowed: a file that ends in .csv, .wav or .mat)")
    return reader(name, _bytes(path))


def _bytes(path: str) -> bytes:
    data = contents(path, LARGEST_RECORDING)
    if len(data) > LARGEST_RECORDING:
        raise _refused(visible(path), "", f"the file is larger than {LARGEST_RECORDING // 10**9} GB (cut the record)")
    return data


def _refused(name: str, path: str, message: str, line: int = 1) -> VireportError:
    """What is wrong in a file; one that is no text has no lines."""
    if name.lower().endswith((".wav", ".mat")):
        return UsageError(f"{name}: {path}: {message}" if path else f"{name}: {message}")
    return ScenarioError(name, [Mistake(line, path, message)])


def _known(title: str) -> tuple[HeardPlace | None, float] | None:
    """What a name stands for, and its unit in SI units; a place of None is the time's. None where it is not known."""
    for place in (*HeardPlace, None):
        quantities = {HeardPlace.CAPSULE: ("acceleration",), None: ("time",)}.get(place, ("voltage", "sound"))
        for quantity in quantities:
            head = f"{place.value}_{quantity}" if place in (HeardPlace.BOTTOM, HeardPlace.TOP) else quantity
            for unit, size in UNITS[quantity].items():
                if title == f"{head}_{unit}":
                    return place, size
    return None


def _allowed() -> tuple[str, ...]:
    """Every name that a channel can have."""
    names = []
    for quantity, units in UNITS.items():
        heads = ("bottom_", "top_", "") if quantity in ("voltage", "sound") else ("",)
        names += [f"{head}{quantity}_{unit}" for head in heads for unit in units]
    return tuple(names)


def _require_known(name: str, titles: list[str], timed: bool) -> None:
    """Refuse names of channels of which something is not known.

    Raises
    ------
    ScenarioError
        With all of them.
    """
    mistakes, taken = [], [title for title in titles if not title.startswith(UNUSED)]
    for title in taken:
        if _known(title) is None:
            close = get_close_matches(title, _allowed(), 1, 0.6)
            lacks = any(title == head for known in _allowed() for head in (known.rpartition("_")[0], known[:-5]))
            hint = " has no unit" if lacks else " is no signal with a unit"
            meant = f"; did you mean '{close[0]}'?" if close else ""
            mistakes.append(
                Mistake(
                    1, visible(title[:60]), f"the name{hint}{meant} (allowed: names such as {EXAMPLE}, or {UNUSED}_...)"
                )
            )
    mistakes += [Mistake(1, visible(x[:60]), "stands twice (each once)") for x in set(taken) if taken.count(x) > 1]
    if mistakes:
        raise ScenarioError(name, mistakes)
    places = [known[0] for title in taken if (known := _known(title))]
    if timed and places.count(None) != 1:
        raise _refused(
            name, "", f"one column of times is needed (allowed: time_s, time_ms or time_us, as in {EXAMPLE})"
        )
    for place in HeardPlace:
        if places.count(place) > 1:
            raise _refused(name, "", f"two signals are of the same kind, {place.value} (allowed: one of each)")
    each, either = {HeardPlace.BOTTOM, HeardPlace.TOP} & set(places), HeardPlace.EITHER in places
    if len(each) == 1 or (each and either) or not (each or either or HeardPlace.CAPSULE in places):
        raise _refused(
            name,
            "",
            "impacts on both membranes are needed (allowed: bottom_... and top_..., or one signal such as voltage_v "
            "or sound_pa whose sign tells them apart, positive at the bottom, or acceleration_m_s2 alone)",
        )


def _recorded(name: str, titles: list[str], columns: list[Array], times: Array | None, rate_hz: float) -> Recording:
    """A recording of columns, with times or else with a rate; names are known already."""
    channels = []
    for title, column in zip(titles, columns, strict=True):
        known = None if title.startswith(UNUSED) else _known(title)
        if known is None or known[0] is None:
            continue
        values = column if known[1] == 1.0 else column * known[1]
        if not isfinite(float(values.min(initial=0.0))) or not isfinite(float(values.max(initial=0.0))):
            row = int(np.flatnonzero(~np.isfinite(values))[0])
            raise _refused(name, title, f"sample {row + 1} is not a finite number (allowed: finite ones)")
        channels.append(Channel(title, known[0], values))
    count = len(channels[0].values)
    if count < FEWEST_SAMPLES:
        raise _refused(name, "", f"{count} samples (at least {FEWEST_SAMPLES} are needed, and seconds of them for use)")
    if times is None:
        return Recording(name, 1 / rate_hz, (Unbroken(0, count, 0.0),), tuple(channels))
    step, stretches, uneven = _clock(name, times)
    return Recording(name, step, stretches, tuple(channels), uneven)


def _clock(name: str, times: Array) -> tuple[float, tuple[Unbroken, ...], float]:
    """The step of times, the stretches without gaps, and by how much times are off an even clock."""
    steps = np.diff(times)
    if not np.isfinite(times).all():
        row = int(np.flatnonzero(~np.isfinite(times))[0])
        raise _refused(name, "time", f"sample {row + 1} is not a finite number (allowed: finite ones)")
    if (steps <= 0).any():
        row = int(np.flatnonzero(steps <= 0)[0]) + 1
        raise _refused(
            name,
            "time",
            f"sample {row + 1}, {float(times[row])!r}, is not after the one before it (allowed: ascending times, "
            "written with enough digits)",
        )
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP * usual)
    even = steps <= GAP * usual
    step = float(steps[even].mean())
    if len(gaps) > max(MOST_GAPS * len(steps), 3):
        raise _refused(name, "time", f"{_unequal(steps)} (allowed: samples at equal steps, with few gaps)")
    ends = np.concatenate([[0], gaps + 1, [len(times)]]).tolist()
    stretches, worst = [], 0.0
    for first, last in pairwise(ends):
        own = times[first:last]
        late = own - step * np.arange(len(own))
        start = float((late.min() + late.max()) / 2)
        worst = max(worst, float(late.max() - late.min()) / 2)
        stretches.append(Unbroken(first, last, start))
    if worst > UNEVEN * step:
        raise _refused(name, "time", f"{_unequal(steps)} (allowed: samples at equal steps, with few gaps)")
    return step, tuple(stretches), worst


def _unequal(steps: Array) -> str:
    low, high = np.quantile(steps, [0.01, 0.99])
    return f"the steps are unequal, mostly {low:.4g} to {high:.4g} s"


def _of_csv(name: str, data: bytes) -> Recording:
    end = data.find(b"\n")
    try:
        head = data[: end if end >= 0 else len(data)].decode("utf-8-sig").strip()
    except UnicodeDecodeError as error:
        message = f"byte 0x{error.object[error.start]:02X} is not UTF-8 (save the file as CSV in UTF-8)"
        raise _refused(name, "", message) from None
    if not head:
        raise _refused(name, "", f"the first line is empty (allowed: names and units, {EXAMPLE})")
    for sign, what in ((";", "semicolons"), ("\t", "tabs")):
        if sign in head and "," not in head:
            raise _refused(name, "", f"columns are separated by {what} (allowed: commas, and points in numbers)")
    titles = [title.strip().strip('"').strip() for title in head.split(",")]
    _require_known(name, titles, timed=True)
    used = [k for k, title in enumerate(titles) if not title.startswith(UNUSED)]
    if end < 0 or not data[end:].strip():
        raise _refused(name, "", f"no sample follows the names (at least {FEWEST_SAMPLES} are needed)")
    rows = decimal_rows(data, end + 1, len(titles))
    rows = _other_rows(name, data, end, titles, used) if rows is None else rows[:, used]
    columns = [np.ascontiguousarray(rows[:, k]) for k in range(len(used))]
    del rows
    names = [titles[k] for k in used]
    (k, size), *_ = ((k, known[1]) for k, title in enumerate(names) if (known := _known(title)) and known[0] is None)
    return _recorded(name, names, columns, columns[k] * size, 0.0)


def _other_rows(name: str, data: bytes, end: int, titles: list[str], used: list[int]) -> Array:
    """The rows after the first line, which ends at a place, where they are not plain decimal numbers alone.

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
    """The first row of a file that is no row of numbers, with what is wrong with it."""
    for line, row in enumerate(io.BytesIO(data), 1):
        if line == 1 or not row.strip():
            continue
        cells = row.decode("utf-8", "replace").strip().split(",")
        if len(cells) != len(titles):
            comma = " A decimal comma?" if len(cells) > len(titles) else ""
            message = f"{len(cells)} values for {len(titles)} columns.{comma} (allowed: points in numbers)"
            return _refused(name, "", message, line)
        for k in used:
            try:
                float(cells[k].strip().strip('"'))
            except ValueError:
                given = visible(cells[k].strip()[:40])
                message = f"'{given}' is not a number (allowed: numbers with a decimal point)"
                return _refused(name, titles[k], message, line)
    return _refused(name, "", "rows cannot be read as numbers (allowed: numbers, with commas between columns)")


def _of_wav(name: str, data: bytes, path: str) -> Recording:
    from scipy.io import wavfile  # type: ignore[import-untyped]

    scales = _notes(f"{path}.yaml", name)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)
            rate, samples = wavfile.read(io.BytesIO(data))
    except Exception as error:  # of bytes that are no WAV file, it may raise anything
        raise UsageError(f"{name} cannot be read as WAV: {visible(str(error), 200)}") from error
    samples = samples.reshape(len(samples), -1)
    if samples.shape[1] != len(scales):
        raise _refused(
            f"{name}.yaml",
            "channels",
            f"names {len(scales)} channels, and the file has {samples.shape[1]} (allowed: all of them)",
        )
    columns = []
    for k, full in enumerate(scales.values()):
        own = samples[:, k].astype(float)
        if samples.dtype == np.uint8:
            own -= 128
        # What is floating is in shares of full scale already; of integers the largest is full scale.
        largest = (
            1.0
            if samples.dtype.kind == "f"
            else 128.0
            if samples.dtype == np.uint8
            else -float(np.iinfo(samples.dtype).min)
        )
        own *= full / largest
        columns.append(own)
    return _recorded(name, list(scales), columns, None, float(rate))


def _notes(path: str, name: str) -> dict[str, float]:
    """The channels of a WAV file, each with its full scale in its unit, from the notes beside it."""
    import yaml

    shown = visible(path)
    allowed = "channels: with a line for each channel in its order, such as bottom_sound_fs: 1 or acceleration_m_s2: 49"
    if not Path(path).is_file():
        raise UsageError(f"{name} does not say what its channels are: {shown} is missing (allowed there: {allowed})")
    try:
        own: Any = yaml.safe_load(_bytes(path))
    except (yaml.YAMLError, ValueError) as error:
        raise UsageError(f"{shown} is no YAML: {visible(str(error), 200)} (allowed: {allowed})") from error
    channels = own.get("channels") if isinstance(own, dict) and set(own) == {"channels"} else None
    if not isinstance(channels, dict) or not channels:
        raise _refused(shown, "", f"has no channels (allowed: {allowed})")
    for title, full in channels.items():
        if isinstance(full, bool) or not isinstance(full, int | float) or not isfinite(full) or full == 0:
            message = f"got {visible(repr(full), 40)} (allowed: full scale in the unit, negative if turned about)"
            raise _refused(shown, visible(str(title)[:60]), message)
    titles = list(map(str, channels))
    _require_known(shown, titles, timed=False)
    if any(title.startswith("time") for title in titles):
        raise _refused(shown, "channels", "a WAV file has no channel of times (its rate is in the file)")
    return dict(zip(titles, map(float, channels.values()), strict=True))


def _of_mat(name: str, data: bytes) -> Recording:
    try:
        names, own = (_variables_of_hdf5 if _is_hdf5(data) else _variables)(name, data)
    except VireportError:
        raise
    except Exception as error:  # of bytes that are no MATLAB file, it may raise anything
        raise UsageError(f"{name} cannot be read as a MATLAB file: {visible(str(error), 200)}") from error
    if not names:
        raise _refused(name, "", f"the file has no variables (allowed: vectors named as columns, {EXAMPLE})")
    used = [title for title in names if not title.startswith(UNUSED)]
    columns = []
    for title in used:
        values = own[title]
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiu" or values.size != max(values.shape):
            raise _refused(name, title, "is no vector of real numbers (allowed: one)")
        columns.append(np.asarray(values, dtype=float).ravel())
    if len(lengths := {len(column) for column in columns}) > 1:
        raise _refused(name, "", f"vectors of {min(lengths)} to {max(lengths)} samples (allowed: all of one length)")
    timed = [k for k, title in enumerate(used) if title.startswith("time")]
    if len(timed) + (RATE in own) != 1:
        raise _refused(name, "", f"either the vector time_s or the number {RATE} is needed (allowed: one of them)")
    if timed:
        size = UNITS["time"][used[timed[0]].removeprefix("time_")]
        return _recorded(name, used, columns, columns[timed[0]] * size, 0.0)
    rate = own[RATE]
    if rate.size != 1 or rate.dtype.kind not in "fiu" or not isfinite(hertz := float(rate.ravel()[0])) or hertz <= 0:
        raise _refused(name, RATE, "is no positive number (allowed: samples in a second)")
    return _recorded(name, used, columns, None, hertz)


def _variables(name: str, data: bytes) -> tuple[list[str], Mapping[str, Any]]:
    """The names in a MATLAB file up to version 7, but for the rate, and what is used of them."""
    from scipy.io import loadmat, whosmat

    names = [title for title, *_ in whosmat(io.BytesIO(data)) if title != RATE]
    if names:
        _require_known(name, names, timed=False)
    return names, loadmat(io.BytesIO(data), variable_names=[x for x in (*names, RATE) if not x.startswith(UNUSED)])


def _is_hdf5(data: bytes) -> bool:
    """Whether a MATLAB file is one of version 7.3: HDF5 behind a block of text."""
    return HDF5 in (data[:8], data[512:520])


def _variables_of_hdf5(name: str, data: bytes) -> tuple[list[str], Mapping[str, Any]]:
    """The names in a MATLAB file of version 7.3, and what is used of them.

    Arrays are transposed there, and an attribute says what they are.
    """
    try:
        import h5py  # type: ignore[import-untyped]
    except ImportError as error:
        needed = f"is a MATLAB file of version 7.3, which needs h5py: {install_command('h5py')}"
        raise UsageError(f"{name} {needed}") from error

    with h5py.File(io.BytesIO(data), "r") as file:
        # Beside variables there are groups of MATLAB's own, such as #refs#. A link may lead out of the file.
        titles = [title for title in file if not title.startswith("#")]
        names = [title for title in titles if title != RATE]
        if names:
            _require_known(name, names, timed=False)
        used = [title for title in titles if not title.startswith(UNUSED)]
        inside = [title for title in used if isinstance(file.get(title, getlink=True), h5py.HardLink)]
        read = {title: _array_of(file[title]) if title in inside else np.empty(0, dtype=object) for title in used}
    return names, read


def _array_of(stored: Any) -> Any:
    """The numbers of a variable of version 7.3; nothing where they are characters, structures or empty."""
    kind = stored.attrs.get("MATLAB_class", b"")
    kind = kind.decode("ascii", "replace") if isinstance(kind, bytes) else str(kind)
    if kind not in NUMERIC or "MATLAB_empty" in stored.attrs or not hasattr(stored, "dtype"):
        return np.empty(0, dtype=object)
    return np.asarray(stored[()]).T
