"""The one table of a comparison: a row for each quantity with what every scenario has of it, and how far that differs.

`compare` and `diff`, the terminal, Markdown, the report and the files read these rows.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from operator import itemgetter
from pathlib import Path
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from vireport.base.records import ResultsBlock, plain
from vireport.report.changes.quantities import Along, ComparedQuantity, ComparedScenario, QuantityGroup
from vireport.report.changes.sentences import side_by_side
from vireport.scenario.parameters import DesignInput, Parameter
from vireport.text.foreign import visible
from vireport.text.formatting import OF_A_MODEL, Exactness, rounded_text
from vireport.text.said import Said, spoken

NO_DIFFERENCE = 1e-9
"""Relative difference up to which two numbers are the same: polished ones agree to far more, and no device is made
to less."""

LONGEST_VALUES = 120
"""Characters of the values that the one line of a row shows."""

SAME_INPUT = 1e-12
"""Relative difference up to which a value of the scenario is the same: it is read from a text, and only rounding is
forgiven."""


class ComparedRowData(ResultsBlock, frozen=True, kw_only=True):
    """A quantity of all scenarios.

    Attributes
    ----------
    quantity, group, unit
        what is compared, in words, its group, and its unit, 1 where it has none
    values, notes
        of each scenario; null where it has none, and why, or what there is to say about it
    change : 1
        largest difference over the largest size; null where there are no two values, or only some scenarios have one
    differs
        whether that is more than rounding
    sentence
        what differs, with the numbers
    """

    quantity: str
    group: str
    unit: str
    values: list[float | None]
    notes: list[str]
    change: float | None
    differs: bool
    sentence: str


class ComparisonRow(Struct, frozen=True):
    """One quantity of all scenarios.

    Attributes
    ----------
    name : str or Said
        What is compared.
    group : QuantityGroup
    unit : str
        Of the values; "1" where they have none, "" for a statement.
    cells : tuple of ComparedQuantity
        One for each scenario, in their order.
    change : float or None
        Largest difference over the largest size, from 0 to 2; None where there are no two values to compare, or
        where the quantity exists in some scenarios and not in others. Since a baseline it is relative to the value
        before, with its sign.
    differs : bool
        Whether that is more than rounding. True with `change` None: it exists in some scenarios only, or what differs
        is no number.
    said : Said or None
        What differs, with the numbers; None for a statement of a comparison.
    """

    name: str | Said
    group: QuantityGroup
    unit: str
    cells: tuple[ComparedQuantity, ...]
    change: float | None
    differs: bool
    said: Said | None = None

    def __repr__(self) -> str:
        values = ", ".join(rounded_text(value) if isinstance(value, float) else str(value) for value in self.values)
        return f"<ComparisonRow {visible(self.heading)}: {visible(values, LONGEST_VALUES)}>"

    @property
    def quantity(self) -> str:
        """The compared quantity in the words of the package."""
        return str(spoken(self.name))

    @property
    def heading(self) -> str:
        """The quantity with its unit in brackets, where it has one."""
        return self.headed()

    def headed(self, templates: Path | None = None) -> str:
        """The quantity with its unit, if any, in the words of a user's folder of templates before the package's own."""
        name = str(spoken(self.name, templates))
        return name if self.unit in ("1", "") else f"{name} [{self.unit}]"

    @property
    def is_statement(self) -> bool:
        """Whether the values are stated in words or by the scenarios, and are no numbers that were computed."""
        return not self.unit

    @property
    def values(self) -> tuple[Any, ...]:
        """One for each scenario; None where it has none."""
        return tuple(cell.value for cell in self.cells)

    @property
    def before(self) -> object:
        """Value in the first scenario, which is the baseline where there is one."""
        return self.cells[0].value

    @property
    def after(self) -> object:
        """Value in the last scenario, which is that of now where there is a baseline."""
        return self.cells[-1].value

    @property
    def notes(self) -> tuple[str, ...]:
        """Why a value is None, or what there is to say about it, in the package's own words; "" else."""
        return tuple(spoken(cell.note) for cell in self.cells)

    @property
    def sentence(self) -> str:
        """What differs, in the package's own words; "" for a statement of a comparison."""
        return self.worded()

    def worded(self, templates: Path | None = None) -> str:
        """What differs, in the words of a user's folder of templates before the package's own."""
        return "" if self.said is None else self.said.words(templates)

    def data(self, templates: Path | None = None) -> ComparedRowData:
        """The row as compare.json has it, with the sentence in the words of a folder of templates."""
        return ComparedRowData(
            quantity=self.quantity,
            group=self.group,
            unit=self.unit,
            values=list(self.values),
            notes=list(self.notes),
            change=self.change,
            differs=self.differs,
            sentence=self.worded(templates),
        )

    def to_dict(self, templates: Path | None = None) -> dict[str, Any]:
        """Give plain data, ready for JSON."""
        data: dict[str, Any] = plain(self.data(templates))
        return data


class Axes(Struct, frozen=True):
    """The inputs in which places are compared: the first always, the others where several scenarios have them."""

    always: tuple[Along, ...]
    shared: tuple[Along, ...] = ()


def axes_of(scenarios: Iterable[ComparedScenario], same: float) -> Axes:
    """Choose in what the places of several scenarios are compared.

    A swept parameter, where no scenario sweeps another, with d beside it only where d is not the same multiple of it
    in all of them, to a relative difference `same`. Otherwise d, and the parameters that some share. Without any sweep
    there are only margins, in all inputs.
    """
    sweeping = [scenario for scenario in scenarios if scenario.swept is not None]
    swept = [scenario.swept for scenario in sweeping]
    if not swept:
        return Axes(tuple(DesignInput))
    if len(set(swept)) > 1:
        return Axes(("d",), tuple(parameter for parameter in Parameter if swept.count(parameter) > 1))
    (parameter,) = {parameter for parameter in swept if parameter is not None}
    if not parameter.moves_d:
        return Axes((parameter,))
    sweep = sweeping[0].scenario.sweep
    multiples = [scenario.d(parameter, sweep.from_) for scenario in sweeping] if sweep is not None else [0.0]
    return Axes((parameter,), () if max(multiples) - min(multiples) <= same * max(multiples) else ("d",))


def comparison_rows(
    scenarios: Mapping[str, ComparedScenario],
    axes: Axes,
    tolerance: float = NO_DIFFERENCE,
    exactness: Exactness = OF_A_MODEL,
) -> tuple[ComparisonRow, ...]:
    """Compare all that can be compared, by groups: in each what only some scenarios have first, then what changed most.

    Settings and requirements keep the order of the scenarios, and alerts have that of their codes.

    Parameters
    ----------
    scenarios : mapping of str to ComparedScenario
        By their names.
    axes : Axes
        In which places are compared.
    tolerance : float
        Relative difference that is none; error bounds are added to it.
    exactness : Exactness
        How exact the numbers of all scenarios are.
    """
    compared = {of.identity: of for scenario in scenarios.values() for of in scenario.quantities.values()}
    alike = Counter(of.name for of in compared.values())
    order = (None, *axes.always, *axes.shared, *DesignInput)
    rows = []
    for of in compared.values():
        cells = {name: scenario.quantity(of) for name, scenario in scenarios.items()}
        named = of.with_family() if of.family and alike[of.name] > 1 else of
        with_value = sum(cell.value is not None for cell in cells.values())
        in_an_input = of.group is QuantityGroup.MARGIN and of.axis != "d"
        if with_value and (of.axis is None or of.axis in axes.always or in_an_input):
            row = _row(named, cells, tolerance, exactness)
        elif with_value > 1 and of.axis in axes.shared:
            # Places in a parameter that only some sweep stand beside those in d, which say what a scenario lacks.
            row = _row(
                named, {name: replace(cell, finding=False) for name, cell in cells.items()}, tolerance, exactness
            )
        else:
            continue
        rows.append((_rank(row, spoken(of.subject), order.index(of.axis)), row))
    return tuple(row for _, row in sorted(rows, key=itemgetter(0)))


def _rank(row: ComparisonRow, subject: str, place: int) -> tuple[int, bool, bool, float, str, int]:
    """Order rows by groups; in each what only some scenarios have, then what changed most, then what did not."""
    group = list(QuantityGroup).index(row.group)
    if row.is_statement:
        return group, False, False, 0.0, subject if row.group is QuantityGroup.ALERT else "", 0
    only_some = row.differs and row.change is None
    return group, not only_some, not row.differs, -(row.change or 0.0), subject, place


def _row(
    of: ComparedQuantity, cells: Mapping[str, ComparedQuantity], tolerance: float, exactness: Exactness
) -> ComparisonRow:
    """Compare what the scenarios have of one quantity."""
    entries = tuple(cells.values())
    if of.is_statement:
        differs = not all(same_statement(entries[0].value, cell.value) for cell in entries)
        return ComparisonRow(of.name, of.group, of.unit, entries, None, differs)
    with_value = [cell for cell in entries if cell.value is not None]
    values = [cell.value for cell in with_value]
    absent = any(cell.finding for cell in entries)
    spread, size = max(values) - min(values), max(map(abs, values))
    # Any two values may be off by both their bounds: of more than two, the largest two bounds hold for every pair.
    scale, bounds = max(size, *(cell.scale for cell in with_value)), sum(sorted(cell.bound for cell in with_value)[-2:])
    apart = spread > max(tolerance, of.tolerance) * scale + bounds
    share = spread / size if apart else 0.0
    types = of.group is QuantityGroup.DESIGN_POINT and len({cell.note for cell in with_value}) > 1
    change = None if absent or len(with_value) < 2 else share
    differs, said = absent or apart or types, side_by_side(of, cells, share, exactness)
    return ComparisonRow(of.name, of.group, of.unit, entries, change, differs, said)


def same_statement(value: Any, other: Any) -> bool:
    """Tell whether two values of a scenario, or statements, are the same but for rounding."""
    # True is 1 in Python, but a switch is no number: neither may pass for the other.
    if any(isinstance(side, bool) or not isinstance(side, int | float) for side in (value, other)):
        return bool(value == other)
    return bool(abs(other - value) <= SAME_INPUT * max(abs(value), abs(other)))
