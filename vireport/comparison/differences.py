"""One quantity of several scenarios: a number for each, how far they are apart, and a sentence that says so."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from vireport.gate import capital
from vireport.study import Study
from vireport.text import (
    MOST_DIGITS,
    percent,
)

SAME = 1e-9
"""Relative difference up to which two numbers are the same: polished ones agree to far more, and no device is made
to less."""

SAMPLED = 1e-5
"""The same for the extremes of a curve, which are taken of its samples."""

TOLD_ONE_BY_ONE = 4
"""Scenarios up to which a sentence has the number of each."""

FEWEST_DIGITS = 6
"""Of a number in a sentence."""

GROUPS = ("design point", "critical point", "stable range", "margin", "voltage")
Group = Literal["design point", "critical point", "stable range", "margin", "voltage"]

Printed = Callable[[float, int], str]
"""Writes a value with so many digits, and its unit."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One quantity of all scenarios.

    Attributes
    ----------
    quantity : str
        What it is, in words.
    group : str
        One of `GROUPS`.
    unit : str
        "1" where it has none.
    values : tuple of float or None
        One for each scenario, in their order.
    notes : tuple of str
        Why a value is None, or what there is to say about it; "" else.
    change : float or None
        Largest difference over the largest size, from 0 to 2; None where there are no two values to compare, or
        where the quantity exists in some scenarios and not in others.
    differs : bool
        Whether that is more than rounding. True with `change` None: it exists in some scenarios only.
    sentence : str
    """

    quantity: str
    group: Group
    unit: str
    values: tuple[float | None, ...]
    notes: tuple[str, ...]
    change: float | None
    differs: bool
    sentence: str

    def to_dict(self) -> dict[str, Any]:
        """Plain data, ready for JSON."""
        plain = {name: getattr(self, name) for name in self.__slots__}
        return plain | {"values": list(self.values), "notes": list(self.notes)}


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """A scenario of a comparison."""

    name: str
    study: Study


@dataclass(frozen=True, slots=True)
class Entry:
    """A quantity of one scenario.

    Attributes
    ----------
    value : float or None
    note : str
        Why there is none, or a remark.
    absent : bool
        Whether that there is none is a finding, and not only something that was not asked for.
    bound : float
        Error bound of the value.
    """

    value: float | None
    note: str = ""
    absent: bool = False
    bound: float = 0.0


def rank(one: Difference) -> tuple[bool, bool, float, int]:
    """Order of quantities: what only some scenarios have, then what changed most, then what did not."""
    only_some = one.differs and one.change is None
    return not only_some, not one.differs, -(one.change or 0.0), GROUPS.index(one.group)


def difference(
    subject: str,
    symbol: str,
    group: Group,
    unit: str,
    members: Sequence[Member],
    entries: Sequence[Entry],
    printed: Printed,
    missing: str = "",
    tolerance: float = SAME,
) -> Iterator[Difference]:
    """A quantity, where any scenario has it.

    Parameters
    ----------
    subject, symbol : str
        What it is, and what stands for its number ("" where nothing does).
    group, unit : str
    members : sequence of Member
    entries : sequence of Entry
        One for each.
    printed : callable
    missing : str
        What is said of scenarios that do not have it, before their names.
    tolerance : float
        Relative difference that is none.
    """
    known = [entry.value for entry in entries if entry.value is not None]
    if not known:
        return
    absent = any(entry.absent for entry in entries)
    spread, size = max(known) - min(known), max(abs(value) for value in known)
    bounds = sum(sorted(entry.bound for entry in entries)[-2:])
    apart = spread > tolerance * size + bounds
    change = spread / size if apart else 0.0
    kinds = {entry.note for entry in entries if entry.value is not None}
    yield Difference(
        f"{subject}, {symbol}" if symbol else subject,
        group,
        unit,
        tuple(entry.value for entry in entries),
        tuple(entry.note for entry in entries),
        None if absent or len(known) < 2 else change,
        absent or apart or (group == "design point" and len(kinds) > 1),
        _sentence(subject, symbol, [member.name for member in members], entries, printed, missing, change),
    )


def _sentence(
    subject: str,
    symbol: str,
    names: Sequence[str],
    entries: Sequence[Entry],
    printed: Printed,
    missing: str,
    change: float,
) -> str:
    """The numbers by name, and how far they are apart; of many scenarios the least and the largest."""
    having = [(who, entry.note, entry.value) for who, entry in zip(names, entries, strict=True)]
    found = [(who, note, value) for who, note, value in having if value is not None]
    digits = _digits([value for _, _, value in found], printed)
    lead = f"{symbol} = " * bool(symbol)
    if not change and found and len(found) > 1:
        notes = {note: [who for who, other, _ in found if other == note] for _, note, _ in found}
        number = printed(found[0][2], digits)
        told = lead + "; ".join(_told(number, listed(whose), note) for note, whose in notes.items())
    elif len(found) <= TOLD_ONE_BY_ONE:
        told = lead + listed([_told(printed(value, digits), who, note) for who, note, value in found])
    else:
        ends = min(found, key=lambda one: one[2]), max(found, key=lambda one: one[2])
        low, high = (_told(printed(value, digits), who, note) for who, note, value in ends)
        told = f"{symbol} " * bool(symbol) + f"from {low} to {high}"
    text = f"{capital(subject)}: {told}" + (f" ({percent(change)} apart)" if change else "")
    lacking = [who for who, entry in zip(names, entries, strict=True) if entry.absent]
    if not lacking:
        return f"{text}."
    others = len(lacking) > TOLD_ONE_BY_ONE and len(lacking) + len(found) == len(entries)
    return f"{text}; {missing} {f'the {len(lacking)} others' if others else listed(lacking)}."


def _told(number: str, who: str, note: str) -> str:
    return f"{number} in {who} ({note})" if note else f"{number} in {who}"


def _digits(values: Sequence[float], printed: Printed) -> int:
    """As many digits as set apart the numbers that differ."""
    apart = len({float(f"{value:.14g}") for value in values})
    digits = range(FEWEST_DIGITS, MOST_DIGITS)
    return next((k for k in digits if len({printed(value, k) for value in values}) >= apart), MOST_DIGITS)


def listed(parts: Sequence[str]) -> str:
    """Words as a list; names of variants of one key are drawn together.

    Examples
    --------
    >>> listed(["one", "two", "three"]), listed(["beta = 0", "beta = 15", "beta = 30"])
    ('one, two and three', 'beta = 0, 15 and 30')
    """
    if len(parts) == 1:
        return parts[0]
    keys = {part.rpartition(" = ")[0] for part in parts}
    if len(keys) == 1 and all(keys) and not any("," in part or " in " in part for part in parts):
        parts = [parts[0], *(part.rpartition(" = ")[2] for part in parts[1:])]
    if any("," in part for part in parts[:-1]) and len(parts) > 2:
        return f"{'; '.join(parts[:-1])}; and {parts[-1]}"
    return f"{', '.join(parts[:-1])} and {parts[-1]}"
