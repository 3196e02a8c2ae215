"""What is read of any file of signals: columns with the names and units that the file states, and its time base."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

from msgspec import Struct

from vireport.base.errors import UsageError
from vireport.base.records import ResultsBlock, brief
from vireport.measurement.flights import Array
from vireport.scenario.blocks import ColumnBlock, RecordedUnit
from vireport.text.foreign import visible

LARGEST_FILE_OF_SIGNALS = 2_000_000_000
"""Bytes of a file."""

UNUSED = "unused"
"""What the names of columns begin with that have nothing."""

UNITS: Mapping[str, Mapping[RecordedUnit, float]] = {
    "voltage": {RecordedUnit.KV: 1e3, RecordedUnit.V: 1.0, RecordedUnit.MV: 1e-3, RecordedUnit.UV: 1e-6},
    "sound": {RecordedUnit.PA: 1.0, RecordedUnit.V: 1.0, RecordedUnit.MV: 1e-3, RecordedUnit.FS: 1.0},
    "acceleration": {RecordedUnit.M_S2: 1.0, RecordedUnit.G: 9.80665, RecordedUnit.MM_S2: 1e-3},
    "displacement": {RecordedUnit.M: 1.0, RecordedUnit.MM: 1e-3, RecordedUnit.UM: 1e-6},
    "time": {RecordedUnit.S: 1.0, RecordedUnit.MS: 1e-3, RecordedUnit.US: 1e-6, RecordedUnit.NS: 1e-9},
}
"""Of each quantity its units, in SI units; FS is the full scale of a sound card."""

WORDS = {
    **dict.fromkeys(("s", "sec", "second", "seconds"), RecordedUnit.S),
    **dict.fromkeys(("msec", "millisecond", "milliseconds"), RecordedUnit.MS),
    **dict.fromkeys(("usec", "microsecond", "microseconds"), RecordedUnit.US),
    **dict.fromkeys(("v", "volt", "volts"), RecordedUnit.V),
    **dict.fromkeys(("millivolt", "millivolts"), RecordedUnit.MV),
    **dict.fromkeys(("m/s^2", "m/s**2", "m/s/s", "ms-2"), RecordedUnit.M_S2),
    "mm/s^2": RecordedUnit.MM_S2,
    "pascal": RecordedUnit.PA,
}
"""Units as instruments spell them, in small letters."""

SIGNS = str.maketrans({"µ": "u", "μ": "u", "²": "2"})


def unit_in(text: str) -> RecordedUnit | None:
    """The unit that a text states, also in brackets; None where it states none that is known.

    Examples
    --------
    >>> unit_in("(ms)").value, unit_in("Volt").value, unit_in("[m/s²]").value, unit_in("rpm")
    ('ms', 'V', 'm/s2', None)
    """
    plain = text.strip(" ()[]").removeprefix("in ").translate(SIGNS)
    return next((unit for unit in RecordedUnit if unit == plain), WORDS.get(plain.lower()))


LONGEST_TITLE, LONGEST_SHOWN, MOST_SHOWN = 200, 60, 12
"""Characters of a column's name, those of it that are shown, and columns that are."""

NAME_AND_UNIT = re.compile(r"(.*?)(?:\s*[(\[]([^()\[\]]*)[)\]]|\s+in (\S+)|^in (\S+)|(?<=\d)(V))\s*$")
"""A name with its unit behind it: Time (s), CH1 [V], C1 in V, CH1V."""


class Title(ResultsBlock, frozen=True):
    """What a file says of a column.

    Attributes
    ----------
    name
        its name, "" where it has none
    unit
        that which the file states; null where it states none that is known
    numeric
        whether it has numbers
    """

    name: str
    unit: RecordedUnit | None = None
    numeric: bool = True

    @classmethod
    def of(cls, text: str, unit: str = "") -> Title:
        """The title in a text, which may state the unit where a line of units does not.

        Examples
        --------
        >>> [(title.name, title.unit.value) for title in (Title.of("C1 in V"), Title.of("Time", "(ms)"))]
        [('C1', 'V'), ('Time', 'ms')]
        """
        stated = unit_in(unit) if unit else None
        text = text.strip()[:LONGEST_TITLE]
        parts = NAME_AND_UNIT.match(text)
        within = unit_in(next(filter(None, parts.groups()[1:]), "")) if parts else None
        if parts is None or within is None:
            return cls(text, stated)
        return cls(parts[1].strip(), stated or within)


Wanted = Callable[[Sequence[Title]], Sequence[int]]
"""The places of the columns to be read, by the titles of all."""

Located = Callable[[int], tuple[int, Callable[[int], str]]]
"""From the number of a sample to its line in the file, and to the cell there of a column."""


class RecordedTable(Struct, frozen=True, eq=False):
    """Columns of a file of signals.

    Attributes
    ----------
    reading : str
        As what the file was read, in words: its maker or format, and lines of its head.
    titles : tuple of Title
        Of all columns.
    columns : mapping of int to ndarray (n,)
        Those that were wanted, by their places, in the units of the file; a number that is missing is NaN.
    step_s, start_s : float
        Time base of the file [s]; a step of 0 is none.
    located : callable, optional
        Of a text.
    """

    reading: str
    titles: tuple[Title, ...]
    columns: Mapping[int, Array]
    step_s: float = 0.0
    start_s: float = 0.0
    located: Located | None = None

    __repr__ = brief


def column_of(path: str, block: ColumnBlock, titles: Sequence[Title]) -> int:
    """Place of the column that a `record:` block names, by its name or its number.

    Raises
    ------
    UsageError
        If there is none, or several.
    """
    number = block.column
    if isinstance(number, int):
        if number <= len(titles):
            return number - 1
        raise UsageError(f"{path}: {number} is no column (allowed: 1 to {len(titles)})")
    places = [k for k, title in enumerate(titles) if title.name == number.strip()]
    if len(places) == 1:
        return places[0]
    few = ", ".join(visible(title.name[:LONGEST_SHOWN]) for title in titles[:MOST_SHOWN] if title.name)
    what = f"{len(places)} columns have this name" if places else "no column has this name"
    raise UsageError(f"{path}: '{visible(number)}': {what} (allowed: {few}; or a number from 1 to {len(titles)})")


def unit_size(path: str, signal: str, block: ColumnBlock, title: Title) -> float:
    """Size of the unit of a column in SI units, as its block says, or else the file.

    Raises
    ------
    UsageError
        If neither does, or it is a unit of something else.
    """
    quantity = next(quantity for quantity in UNITS if quantity in signal)
    unit, units = block.unit or title.unit, UNITS[quantity]
    allowed = ", ".join(units)
    if unit is None:
        raise UsageError(f"{path}: is needed, as the file does not state it (allowed: {allowed})")
    if unit not in units:
        whose = "" if block.unit else " of the file"
        how = f"{allowed}; a sensor that was recorded in other units has record.columns.{signal}.scale, too"
        raise UsageError(f"{path}: {unit}{whose} is no unit of {quantity} (allowed: {how})")
    return units[unit]
