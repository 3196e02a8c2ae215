"""What is said of compared quantities: sentences as data, which `templates/words/changes.j2` words.

Names of quantities and notes on their values are with the quantities.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from vireport.report.changes.quantities import STANDARD_ERRORS, ComparedQuantity
from vireport.text.formatting import OF_A_MODEL, ROUGHLY, Exactness, errors_apart, percent, quantity, rounded_text
from vireport.text.said import Said, words_of

SAID_ONE_BY_ONE = 4
"""Scenarios up to which a sentence has the number of each."""

VARIED = re.compile(r"(?P<key>.+ =|[^\d=]+(?= [-+.]?\d)) (?P<value>.+)")
"""The name of a variant of one key: ``restitution_exponent = -0.1``, or ``length 0.7 m``."""

_said = words_of("changes")

NOTHING = _said("nothing")
"""Said instead of a value that there is not."""


def listed(names: Sequence[str]) -> str | Said:
    """Make a list of names; those of variants of one key are drawn together.

    Examples
    --------
    >>> listed(["one"]), listed(["one", "two", "three"]).words(), listed(["beta = 0", "beta = 15"]).words()
    ('one', 'one, two and three', 'beta = 0 and 15')
    """
    # Only where nothing else in a name could be taken for the next one.
    varied = [VARIED.fullmatch(name) for name in names]
    plain = not any("," in name or " for " in name for name in names)
    if plain and len(names) > 1 and len({match and match["key"] for match in varied}) == 1:
        names = [names[0], *(match["value"] for match in varied[1:] if match)] if varied[0] else names
    return _enumeration(names, any("," in name for name in names[:-1]))


def _enumeration(parts: Sequence[str | Said], have_commas: bool) -> str | Said:
    """Make a list of parts, with semicolons where there are commas within them."""
    if len(parts) == 1:
        return parts[0]
    macro = "listed_apart" if have_commas and len(parts) > 2 else "listed"
    return _said(macro, list(parts[:-1]), parts[-1])


def printed(values: Sequence[float], unit: str, error: Exactness = OF_A_MODEL, *, alike: bool = False) -> list[str]:
    """Print values with their unit, "" or "1" for none, so that those that differ are told apart.

    Parameters
    ----------
    values : sequence of float
    unit : str
    error : Exactness
        How exact they are; shares and standard errors have two digits.
    alike : bool
        Whether they are the same but for rounding.
    """
    error = ROUGHLY if unit in ("%", STANDARD_ERRORS) else error
    if alike or unit == STANDARD_ERRORS:
        return [_with_unit(value, unit, error) for value in values]
    return [
        _with_unit(value, unit, error_of_value)
        for value, error_of_value in zip(values, errors_apart(values, error), strict=True)
    ]


def _with_unit(value: float, unit: str, error: float | Exactness) -> str:
    if unit == "%":
        return percent(value / 100, error if isinstance(error, Exactness) else error / 100, signed=True)
    if unit == "V":
        return quantity(value, unit, error)
    separator = "" if unit in ("°", "1", "") else " "
    return f"{rounded_text(value, error)}{separator}{unit if unit != '1' else ''}"


def side_by_side(
    of: ComparedQuantity, cells: Mapping[str, ComparedQuantity], change: float, error: Exactness = OF_A_MODEL
) -> Said:
    """Say the numbers of scenarios by their names, of many the least and the largest, and how far they are apart."""
    with_value = {name: cell for name, cell in cells.items() if cell.value is not None}
    texts = printed([cell.value for cell in with_value.values()], of.unit, error, alike=not change)
    numbers = dict(zip(with_value, texts, strict=True))

    def number_for(number: str, names: Sequence[str]) -> Said:
        note = with_value[names[0]].note
        return (
            _said("number_with_note", number, listed(names), note) if note else _said("number", number, listed(names))
        )

    symbol = (of.symbol,) if of.symbol else ()
    text: str | Said
    if len(with_value) > SAID_ONE_BY_ONE and change:
        ends = (choose(with_value, key=lambda name: with_value[name].value) for choose in (min, max))
        text = _said(
            "symbol_from_to" if symbol else "from_to", *symbol, *(number_for(numbers[name], [name]) for name in ends)
        )
    else:
        if not change and len(with_value) > 1:
            number = next(iter(numbers.values()))
            notes = dict.fromkeys(cell.note for cell in with_value.values())
            alike = ([name for name, cell in with_value.items() if cell.note == note] for note in notes)
            text = _said("groups", [number_for(number, names) for names in alike])
        else:
            parts = [number_for(number, [name]) for name, number in numbers.items()]
            # No note of ours has a comma.
            noted = ((name, with_value[name].note) for name in [*with_value][:-1])
            have_commas = any("," in text for texts in noted for text in texts if isinstance(text, str))
            text = _enumeration(parts, have_commas)
        text = _said("equals", *symbol, text) if symbol else text
    if change and of.unit != STANDARD_ERRORS:
        text = _said("apart", text, percent(change))
    lacking = [name for name, cell in cells.items() if cell.finding]
    if not lacking:
        return _said("compared", of.subject, text)
    others = len(lacking) > SAID_ONE_BY_ONE and len(lacking) + len(with_value) == len(cells)
    names = _said("others", len(lacking)) if others else listed(lacking)
    return _said("compared_lacking", of.subject, text, of.missing, names)


def before_and_after(
    values: Sequence[float | str | None], unit: str, error: Exactness = OF_A_MODEL
) -> list[str | Said]:
    """Print both sides of a change, numbers with so many digits that they differ."""
    numbers = iter(printed([value for value in values if isinstance(value, float)], unit, error))
    return [next(numbers) if isinstance(value, float) else value or NOTHING for value in values]


def since_baseline(
    what: str | Said,
    values: Sequence[float | str | None],
    unit: str,
    change: float | None,
    error: Exactness = OF_A_MODEL,
) -> Said:
    """Say what is new, gone, or not as it was, numbers as exact as `error` says."""
    before, after = before_and_after(values, unit, error)
    if values[0] is None:
        return _said("new", what, after)
    if values[1] is None:
        return _said("gone", what, before)
    if change is None:
        return _said("moved", what, before, after)
    return _said("moved_by", what, before, after, percent(change, signed=True))
