"""The words of comparisons: one table of messages, and the sentences that are made of them.

Names of quantities and notes on their values are with the quantities: they are data of compare.json.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from enum import StrEnum

from vireport.changes.quantities import STANDARD_ERRORS, ComparedQuantity
from vireport.text.formatting import OF_A_MODEL, ROUGHLY, Exactness, capital, errors_apart, percent, quantity, shown

TOLD_ONE_BY_ONE = 4
"""Scenarios up to which a sentence has the number of each."""

VARIED = re.compile(r"(?P<key>.+ =|[^\d=]+(?= [-+.]?\d)) (?P<value>.+)")
"""The name of a variant of one key: ``restitution_exponent = -0.1``, or ``length 0.7 m``."""


class Message(StrEnum):
    """What is said of comparisons; names in braces are filled in."""

    # A quantity of several scenarios.
    OF = "{number} for {names}"
    OF_WITH_NOTE = "{number} for {names} ({note})"
    EQUALS = "{symbol} = "
    FROM_TO = "{symbol} from {low} to {high}"
    APART = "{text} ({share} apart)"
    LACKING = "{text}; {missing} {names}."
    OTHERS = "the {count} others"
    ONLY_SOME = "only some"
    OTHER_TYPE = "type"
    COUNT = "{different} of {count} quantities differ"

    # What has changed since a baseline.
    NEW = "{what}: new, {after}."
    GONE = "{what}: gone, was {before}."
    MOVED = "{what}: {before} to {after}."
    MOVED_BY = "{what}: {before} to {after} ({share})."
    NONE = "none"
    CHANGES = "{count} change{s} since {baseline}"
    NO_CHANGE = "No change beyond tolerance since {baseline}"
    TOLERANCE = "Numbers are the same within a relative difference of {tolerance} and their error bounds."
    IDENTICAL = "identical to the results in {baseline}"
    NOT_IDENTICAL = "not identical to the results in {baseline}: {count} value{s} ({paths})"
    OF_BASELINE = "{label} of the baseline"

    # The ranking.
    PERIODS = "{count} periods"
    MORE_THAN = "more than {size}"
    OF_THEM = "{part} of {count}"
    NOT_KNOWN = "not known"
    NO_DESIGN_POINT = "No design point, and so no margin to compare: {names}."
    NO_BALL_MASS = "No device.ball_mass_kg, and so no voltage to compare: {names}."
    ALL = "all"

    # Figures.
    ALL_ON_ONE_AXIS = "All scenarios on one axis"
    OVER = "Over the {parameter}"
    OVER_D = "Over d, as the sweeps are of different parameters"
    CAPTION = "{axis}: impact velocity at the bottom and U_ave of the branches with stable motion, numbered as ranked."
    OVERLAID = (
        "impact velocity on the bottom membrane, and U_ave by the paper's formulae, of the branches with stable 1:1 "
        "motion, or of all where none is stable, numbered as they are ranked"
    )
    NOT_DRAWN = "not drawn: {names}"
    NO_STABLE_VOLTAGE = "no voltages where there is no stable motion: {names}"
    LINE_CHARTS = "Line charts of {count} scenarios. {axis}: {overlaid}. Stable ranges: {ranges}."
    HAS_NO_SWEEP = "it has no sweep"
    SHARED_AXES = ", on axes that the panels of a row share"
    PANELS = "{columns} column{cs} of {panels} panel{ps}."

    # Captions of tables, and notes below them.
    SWEEP_END = "sweep"
    TITLE = "Comparison of {names}"
    SCENARIOS = "{count} scenarios"
    RANKING = "Ranking, the best first"
    RANKED_BY = (
        "Ranked by requirements missed, stable 1:1 motion, {asked}margin to use and voltage. The margin to use is the "
        "least of what rigid impacts, soft membranes and neglected effects leave. The mean voltage is U_ave of the "
        "stable motion at the design point, by the paper's formulae; of several motions it is the least. The voltage "
        "per second is the sum over the impacts of a second."
    )
    MARGINS = "Margins in each input, by rigid impacts"
    DISTANCES = (
        "Distance from the design point to the first point at which the stable motion ends, also where another takes "
        "over, over the design value: B period doubling, C fold or pitchfork, G grazing. From an inclination of 0° the "
        "distance is in degrees."
    )
    CRITICAL_POINTS = "Critical points"
    QUANTITIES = "Stable ranges, margins and voltages"
    OF_SCENARIOS = "{caption}: {names}"
    DASHES = "A dash: {reasons}."
    SETTINGS = "Values that are not the same in all scenarios"
    ALERTS = "Alerts of the scenarios"
    CAUSES = "The report of a scenario by itself has the cause with its numbers, and the remedy."


def listed(parts: Sequence[str]) -> str:
    """Join words to a list; names of variants of one key are drawn together.

    Examples
    --------
    >>> listed(["one", "two", "three"]), listed(["beta = 0", "beta = 15"]), listed(["inclination 0°", "inclination 9°"])
    ('one, two and three', 'beta = 0 and 15', 'inclination 0° and 9°')
    """
    if len(parts) == 1:
        return parts[0]
    # Only where nothing else in a part could be taken for the next one: a number told with its name has " for ".
    varied = [VARIED.fullmatch(part) for part in parts]
    plain = not any("," in part or " for " in part for part in parts)
    if plain and len({path and path["key"] for path in varied}) == 1:
        parts = [parts[0], *(path["value"] for path in varied[1:] if path)] if varied[0] else parts
    if any("," in part for part in parts[:-1]) and len(parts) > 2:
        return f"{'; '.join(parts[:-1])}; and {parts[-1]}"
    return f"{', '.join(parts[:-1])} and {parts[-1]}"


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
    return f"{shown(value, error)}{separator}{unit if unit != '1' else ''}"


def side_by_side(
    of: ComparedQuantity, cells: Mapping[str, ComparedQuantity], change: float, error: Exactness = OF_A_MODEL
) -> str:
    """Tell the numbers of scenarios by their names, of many the least and the largest, and how far they are apart."""
    with_value = {name: cell for name, cell in cells.items() if cell.value is not None}
    texts = printed([cell.value for cell in with_value.values()], of.unit, error, alike=not change)
    numbers = dict(zip(with_value, texts, strict=True))

    def told(number: str, names: Sequence[str]) -> str:
        note = with_value[names[0]].note
        message = Message.OF_WITH_NOTE if note else Message.OF
        return message.format(number=number, names=listed(names), note=note)

    equals = Message.EQUALS.format(symbol=of.symbol) if of.symbol else ""
    if not change and len(with_value) > 1:
        number = next(iter(numbers.values()))
        notes = dict.fromkeys(cell.note for cell in with_value.values())
        alike = ([name for name, cell in with_value.items() if cell.note == note] for note in notes)
        text = equals + "; ".join(told(number, names) for names in alike)
    elif len(with_value) <= TOLD_ONE_BY_ONE:
        text = equals + listed([told(number, [name]) for name, number in numbers.items()])
    else:
        ends = (choose(with_value, key=lambda name: with_value[name].value) for choose in (min, max))
        low, high = (told(numbers[name], [name]) for name in ends)
        text = Message.FROM_TO.format(symbol=of.symbol, low=low, high=high).lstrip()
    text = f"{capital(of.subject)}: {text}"
    if change and of.unit != STANDARD_ERRORS:
        text = Message.APART.format(text=text, share=percent(change))
    lacking = [name for name, cell in cells.items() if cell.finding]
    if not lacking:
        return f"{text}."
    others = len(lacking) > TOLD_ONE_BY_ONE and len(lacking) + len(with_value) == len(cells)
    names = Message.OTHERS.format(count=len(lacking)) if others else listed(lacking)
    return Message.LACKING.format(text=text, missing=of.missing, names=names)


def before_and_after(values: Sequence[float | str | None], unit: str, error: Exactness = OF_A_MODEL) -> list[str]:
    """Print both sides of a change, numbers with so many digits that they differ."""
    numbers = iter(printed([value for value in values if isinstance(value, float)], unit, error))
    return [next(numbers) if isinstance(value, float) else value or Message.NONE for value in values]


def since_baseline(
    what: str, values: Sequence[float | str | None], unit: str, change: float | None, error: Exactness = OF_A_MODEL
) -> str:
    """Tell what is new, gone, or not as it was, numbers as exact as `error` says."""
    before, after = before_and_after(values, unit, error)
    if values[0] is None:
        return Message.NEW.format(what=what, after=after)
    if values[1] is None:
        return Message.GONE.format(what=what, before=before)
    message = Message.MOVED if change is None else Message.MOVED_BY
    return message.format(what=what, before=before, after=after, share=percent(change, signed=True))
