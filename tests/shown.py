"""What a page or a terminal shows, read back: numbers with digits and units, cells of tables, numbers in sentences.

A number that is shown is compared with what it should be in SI units, so that a column with another quantity, a wrong
factor and a wrong unit in its head all fail, whatever the program computed on the way.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from functools import lru_cache
from itertools import takewhile

from msgspec import Struct

NUMBER = r"[−+-]?\d+(?:\.\d+)?(?: × 10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|e[+-]\d+)?"
PREFIXES = {"n": -9, "µ": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9}
WITHOUT_PREFIX = ("", "%", "°", "rad", "g", "kg", "m/s²", "N/mʰ", "s")
"""Units that stand as they are; masses are given in grams, and g as an acceleration has no prefix either."""

ROUNDING = 1e-11
"""Relative difference between a number that is computed here and the program's: other formulae, other rounding."""

INVISIBLE = dict.fromkeys((0x2060, 0x00AD))
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
_UNIT_IN_HEAD = re.compile(r" ?\[([^\[\]]*)\]")


class Amount(Struct, frozen=True):
    """A number that should be shown: its value in `unit`, and how many significant digits are wanted at least."""

    value: float | None
    unit: str = ""
    digits: int = 3

    def faults(self, number: str, prefix: str) -> str:
        """What is wrong with a number that is shown with a prefix of the unit, or ""."""
        shown = Decimal(number.replace(" × 10", "e").translate(_SUPERSCRIPTS))
        scale, expected = Decimal(1).scaleb(PREFIXES[prefix]), Decimal(self.value)
        # Noughts at the end of a whole number may stand for digits that are not known.
        last = shown.as_tuple().exponent if "." in number or "e" in number else shown.normalize().as_tuple().exponent
        place = Decimal(1).scaleb(last) * scale
        error, forgiven = abs(shown * scale - expected), Decimal(ROUNDING) * abs(expected)
        wanted = Decimal(1).scaleb(expected.adjusted() - self.digits + 1) if expected else place
        if error > min(place, wanted) * Decimal("0.500001") + forgiven:
            return f"{number} {prefix}{self.unit} is shown, and not {self.value:.12g} {self.unit}"
        return ""


class Bound(Amount):
    """An error bound that should be shown: rounded up, to two digits."""

    def faults(self, number: str, prefix: str) -> str:
        shown = float(number.replace(" × 10", "e").translate(_SUPERSCRIPTS)) * 10.0 ** PREFIXES[prefix]
        holds, digits = Decimal(repr(shown)) >= Decimal(self.value), Decimal(repr(shown)).normalize().as_tuple().digits
        return (
            ""
            if holds and shown <= 1.1 * self.value and len(digits) <= 2
            else f"{number} is no bound of {self.value} in two digits"
        )


class Rounded(Amount):
    """A number that is rounded to the side that holds: up where `up`, else down, and by no more than a thousandth."""

    up: bool = False

    def faults(self, number: str, prefix: str) -> str:
        shown = float(number.replace(" × 10", "e").translate(_SUPERSCRIPTS)) * 10.0 ** PREFIXES[prefix]
        low, high = (1.0, 1 + 1e-3) if self.up else (1 - 1e-3, 1.0)
        held = low * self.value <= shown <= high * self.value
        return "" if held else f"{number} {self.unit} is no bound, rounded to its side, of {self.value:.12g}"


class Below(Amount):
    """A size of which only a limit is known: of rounding, say."""

    def faults(self, number: str, prefix: str) -> str:
        shown = float(number.replace(" × 10", "e").translate(_SUPERSCRIPTS)) * 10.0 ** PREFIXES[prefix]
        return "" if 0 <= shown <= self.value else f"{number} is not below {self.value}"


class Said:
    """A text with amounts: `Said("from {} to {}", Amount(...), Amount(...))`; braces stand for amounts and texts."""

    def __init__(self, text: str, *amounts: Amount | str) -> None:
        parts, self.amounts = text.split("{}"), [given for given in amounts if isinstance(given, Amount)]
        assert len(parts) == len(amounts) + 1
        patterns = [_pattern(given) if isinstance(given, Amount) else re.escape(given) for given in amounts]
        joined = zip(map(re.escape, parts), [*patterns, ""], strict=True)
        self.words, self.pattern = text, re.compile("".join(part for pair in joined for part in pair))

    def faults(self, text: str, whole: bool = False) -> str:
        """What is wrong with a text in which this should stand, or which it should be, or ""."""
        found = (self.pattern.fullmatch if whole else self.pattern.search)(plain(text))
        if found is None:
            return f"not said: {self.words!r} as {self.pattern.pattern}"
        groups = iter(found.groups())
        pairs = [(next(groups), next(groups)) for _ in self.amounts]
        return "; ".join(
            wrong
            for given, (number, prefix) in zip(self.amounts, pairs, strict=True)
            if given.value is not None and (wrong := given.faults(number, prefix or ""))
        )


def _pattern(given: Amount) -> str:
    if given.value is None:
        return "()()—"
    if given.unit == "°":
        return rf"({NUMBER})()°"
    if given.unit in WITHOUT_PREFIX:
        return rf"({NUMBER})(){' ' + re.escape(given.unit) if given.unit else ''}"
    return rf"({NUMBER}) ([nµmkMG]?){re.escape(given.unit)}"


ANYTHING = object()
"""Of a cell that is words only, and held elsewhere."""

Cell = Amount | Said | str | object
Row = Mapping[str, Cell]


@lru_cache(maxsize=64)  # whole pages are read over and over
def plain(text: str) -> str:
    """A text with ordinary spaces, and without what is not seen."""
    return " ".join(text.translate(INVISIBLE).replace("\u00a0", " ").split())


def split_head(title: str) -> tuple[str, str | None]:
    """A head without its unit, and the unit, None where it has none."""
    found = _UNIT_IN_HEAD.search(title)
    return plain(_UNIT_IN_HEAD.sub("", title)), found[1] if found else None


def cell_faults(text: str, unit: str | None, expected: Cell) -> str:
    """What is wrong with a cell below a head with a unit, or ""."""
    text = plain(text)
    if expected is ANYTHING:
        return ""
    if isinstance(expected, Said):
        return expected.faults(text, whole=True)
    if isinstance(expected, str):
        return "" if text == expected else f"{text!r} is shown, and not {expected!r}"
    assert isinstance(expected, Amount)
    shown = text if unit is None else f"{text}{'' if unit == '°' else ' '}{unit}"
    if expected.value is None:
        return "" if text in ("—", "") else f"{text!r} is shown of what is not known"
    return Said("{}", expected).faults(shown, whole=True)


def table_faults(head: Sequence[str], rows: Sequence[Sequence[str]], expected: Sequence[Row]) -> Iterator[str]:
    """What is wrong with a table: every column is to be expected, and every row."""
    titles: list[str] = []
    units = []
    for title in head:
        name, unit = split_head(title)
        units.append(unit)
        count = sum(other.rstrip(" 23") == name for other in titles)
        titles.append(f"{name} {count + 1}" if count else name)
    if len(rows) != len(expected):
        yield f"{len(rows)} rows, and not {len(expected)}"
    for number, (row, known) in enumerate(zip(rows, expected, strict=False), 1):
        if set(known) != set(titles):
            yield f"columns {titles} are shown, and {list(known)} are held"
            return
        for title, unit, text in zip(titles, units, row, strict=True):
            if wrong := cell_faults(text, unit, known[title]):
                yield f"row {number}, {title}: {wrong}"


class TerminalTable(Struct, frozen=True):
    """A table on a terminal: what stands above it, its head and its rows."""

    caption: str
    head: list[str]
    rows: list[list[str]]


def terminal_tables(text: str) -> list[TerminalTable]:
    """Read the tables of a terminal: lines with wide gaps below a caption, columns where all lines have one."""
    tables = []
    for block in re.split(r"\n\s*\n", text):
        caption, *lines = block.splitlines()
        lines = list(takewhile(lambda line: "  " in line.strip(), lines))
        if len(lines) > 1:
            columns = _columns(lines)
            head, *rows = [[line[start:end].strip() for start, end in columns] for line in lines]
            tables.append(TerminalTable(caption.strip(), head, rows))
    return tables


def _columns(lines: Sequence[str]) -> list[tuple[int, int]]:
    width = max(map(len, lines))
    blank = "".join(" " if all(line[k : k + 1] in ("", " ") for line in lines) else "x" for k in range(width))
    return [found.span() for found in re.finditer(r"x(?:x| (?! ))*", blank)]
