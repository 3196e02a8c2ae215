"""The quantities of several scenarios side by side: how far they are apart, and a sentence that says so."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Any

from vireport.comparison.quantities import (
    Axes,
    Entry,
    Group,
    Quantities,
    Quantity,
)
from vireport.scenario import DesignInput
from vireport.text import (
    ABSENT,
    MOST_DIGITS,
    capital,
    percent,
    quantity,
    significant,
)

SAME = 1e-9
"""Relative difference up to which two numbers are the same: polished ones agree to far more, and no device is made
to less."""

TOLD_ONE_BY_ONE = 4
"""Scenarios up to which a sentence has the number of each."""

FEWEST_DIGITS = 6
"""Of a number in a sentence; a share has three fewer, a voltage two."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One quantity of all scenarios.

    Attributes
    ----------
    of : Quantity
    entries : tuple of Entry
        One for each scenario, in their order.
    change : float or None
        Largest difference over the largest size, from 0 to 2; None where there are no two values to compare, or
        where the quantity exists in some scenarios and not in others.
    differs : bool
        Whether that is more than rounding. True with `change` None: it exists in some scenarios only.
    sentence : str
    """

    of: Quantity
    entries: tuple[Entry, ...]
    change: float | None
    differs: bool
    sentence: str

    @property
    def quantity(self) -> str:
        """What is compared, in words."""
        return self.of.name

    @property
    def group(self) -> Group:
        """Kind of what is compared."""
        return self.of.group

    @property
    def unit(self) -> str:
        """Of the values; "1" where they have none."""
        return self.of.unit

    @property
    def values(self) -> tuple[float | None, ...]:
        """One for each scenario."""
        return tuple(entry.value for entry in self.entries)

    @property
    def notes(self) -> tuple[str, ...]:
        """Why a value is None, or what there is to say about it; "" else."""
        return tuple(entry.note for entry in self.entries)

    @property
    def heading(self) -> str:
        """The quantity with its unit, for the head of a row."""
        return capital(self.quantity) + ("" if self.unit == "1" else f" [{self.unit}]")

    @property
    def apart(self) -> str:
        """How far apart the values are, in words."""
        if self.change is None:
            return "only some" if self.differs else ABSENT
        return percent(self.change) if self.change else "type" if self.differs else "0 %"

    def to_dict(self) -> dict[str, Any]:
        """Plain data, ready for JSON."""
        names = ("quantity", "group", "unit", "values", "notes", "change", "differs", "sentence")
        plain = {name: getattr(self, name) for name in names}
        return plain | {"values": list(self.values), "notes": list(self.notes)}


def differences(members: Mapping[str, Quantities], axes: Axes, tolerance: float = SAME) -> tuple[Difference, ...]:
    """Compare all that can be compared, by groups: in each what only some scenarios have first, then what changed most.

    Parameters
    ----------
    members : mapping of str to Quantities
        By the names of the scenarios.
    axes : Axes
        In which places are compared.
    tolerance : float
        Relative difference that is none; error bounds are added to it.
    """
    compared = []
    for of in dict.fromkeys(of for member in members.values() for of in member.entries):
        entries = {name: member.entry(of) for name, member in members.items()}
        known = sum(entry.value is not None for entry in entries.values())
        if known and (of.axis is None or of.axis in axes.always or (of.group is Group.MARGIN and of.axis != "d")):
            compared.append(_difference(of, entries, tolerance))
        elif known > 1 and of.axis in axes.shared:
            entries = {name: replace(entry, finding=False) for name, entry in entries.items()}
            compared.append(_difference(of, entries, tolerance))
    order = (None, *axes.always, *axes.shared, *DesignInput)
    return tuple(sorted(compared, key=lambda x: (*_rank(x), x.of.subject, order.index(x.of.axis))))


def _rank(difference: Difference) -> tuple[int, bool, bool, float]:
    """Order: by groups; in each what only some scenarios have, then what changed most, then what did not."""
    differs, change = difference.differs, difference.change
    return list(Group).index(difference.group), not (differs and change is None), not differs, -(change or 0.0)


def _difference(of: Quantity, entries: Mapping[str, Entry], tolerance: float) -> Difference:
    known = [entry for entry in entries.values() if entry.value is not None]
    values = [entry.value for entry in known if entry.value is not None]
    absent = any(entry.finding for entry in entries.values())
    spread, size = max(values) - min(values), max(map(abs, values))
    scale, bounds = max(size, *(entry.scale for entry in known)), sum(sorted(entry.bound for entry in known)[-2:])
    apart = spread > max(tolerance, of.tolerance) * scale + bounds
    change = spread / size if apart else 0.0
    types = of.group is Group.DESIGN_POINT and len({entry.note for entry in known}) > 1
    return Difference(
        of,
        tuple(entries.values()),
        None if absent or len(known) < 2 else change,
        absent or apart or types,
        _sentence(of, entries, change),
    )


def printed(value: float, unit: str, digits: int = FEWEST_DIGITS) -> str:
    """Print a value with its unit, "1" for none."""
    if unit == "%":
        return percent(value / 100, digits - 3, signed=True)
    if unit == "V":
        return quantity(value, unit, digits - 2)
    separator = "" if unit in ("°", "1") else " "
    return f"{significant(value, digits)}{separator}{unit if unit != '1' else ''}"


def digits_apart(values: Sequence[float], unit: str) -> int:
    """As many digits as tell apart the numbers that differ."""
    apart = len({float(f"{value:.14g}") for value in values})
    digits = range(FEWEST_DIGITS, MOST_DIGITS)
    return next((k for k in digits if len({printed(value, unit, k) for value in values}) >= apart), MOST_DIGITS)


def _sentence(of: Quantity, entries: Mapping[str, Entry], change: float) -> str:
    """The numbers by name, and how far they are apart; of many scenarios the least and the largest."""
    known = [(name, entry.note, entry.value) for name, entry in entries.items() if entry.value is not None]
    digits = digits_apart([value for _, _, value in known], of.unit)
    numbers = {name: printed(value, of.unit, digits) for name, _, value in known}
    lead = f"{of.symbol} = " * bool(of.symbol)
    if not change and len(known) > 1:
        names = {note: [name for name, other, _ in known if other == note] for _, note, _ in known}
        number = numbers[known[0][0]]
        text = lead + "; ".join(_in(number, listed(whose), note) for note, whose in names.items())
    elif len(known) <= TOLD_ONE_BY_ONE:
        text = lead + listed([_in(numbers[name], name, note) for name, note, _ in known])
    else:
        ends = (choose(known, key=itemgetter(2)) for choose in (min, max))
        low, high = (_in(numbers[name], name, note) for name, note, _ in ends)
        text = f"{of.symbol} " * bool(of.symbol) + f"from {low} to {high}"
    text = f"{capital(of.subject)}: {text}" + (f" ({percent(change)} apart)" if change else "")
    lacking = [name for name, entry in entries.items() if entry.finding]
    if not lacking:
        return f"{text}."
    others = len(lacking) > TOLD_ONE_BY_ONE and len(lacking) + len(known) == len(entries)
    return f"{text}; {of.missing} {f'the {len(lacking)} others' if others else listed(lacking)}."


def _in(number: str, name: str, note: str) -> str:
    return f"{number} in {name} ({note})" if note else f"{number} in {name}"


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
