"""What the templates of a comparison know: the ranking, all numbers side by side, the settings."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import TYPE_CHECKING

from vireport.comparison.comparison import (
    ACROSS,
    FEW_NAMES,
    FIGURES,
    Comparison,
    columns,
    left_out,
)
from vireport.comparison.differences import Difference, digits_apart, listed
from vireport.comparison.quantities import Entry, Group
from vireport.comparison.ranking import margins_table, ranking_table
from vireport.gate import SWEEP_END, WordedVerdict
from vireport.scenario import Parameter
from vireport.study import Provenance
from vireport.text import (
    ABSENT,
    Severity,
    Table,
    capital,
    numbers,
    significant,
    texts,
    words,
    written,
)

if TYPE_CHECKING:
    from vireport.figures import Picture


@dataclass(frozen=True, eq=False)
class ComparisonReport:
    """The object `report` of the templates of `vireport compare`.

    Attributes
    ----------
    comparison : Comparison
    pictures : mapping of str to Picture
        Of `compare_pictures`, by their names.
    provenance : Provenance
        Of `comparison_provenance`.
    """

    comparison: Comparison
    pictures: Mapping[str, Picture]
    provenance: Provenance
    template: str = "comparison.typ.j2"
    live: str = ""

    @property
    def title(self) -> str:
        """The names of the scenarios, where they are few."""
        names = self.comparison.names
        return f"Comparison of {listed(names) if len(names) <= FEW_NAMES else f'{len(names)} scenarios'}"

    @property
    def verdict(self) -> WordedVerdict:
        """Which scenario is best, and why."""
        best = [one for one in self.comparison.ranking if one.rank == 1]
        status, stable = best[0].study.verdict.status, best[0].stable
        word = f"Best: {listed([one.name for one in best])}" if stable else "No stable motion"
        return WordedVerdict(status, word, self.comparison.headline)

    def ranking(self) -> Table:
        """The scenarios, the best first."""
        return _inert(ranking_table(self.comparison.ranking))

    def margins(self) -> Table | None:
        """The nearest end of stable motion along each input; None where no scenario has one."""
        table = margins_table(self.comparison.ranking)
        return None if table is None else _inert(table)

    @property
    def swept(self) -> list[Parameter]:
        """The parameters that the scenarios sweep."""
        studies = self.comparison.studies
        return list(dict.fromkeys(x.solution.sweep.parameter for x in studies if x.solution.sweep is not None))

    def critical_points(self) -> Iterator[Table]:
        """The critical points of all scenarios."""
        return _side_by_side(self.comparison, "Critical points", [Group.CRITICAL_POINT])

    def quantities(self) -> Iterator[Table]:
        """All quantities of all scenarios but the critical points."""
        groups = [group for group in Group if group is not Group.CRITICAL_POINT]
        return _side_by_side(self.comparison, "Stable ranges, margins and voltages", groups)

    def settings(self) -> Iterator[Table]:
        """The values by which scenarios differ, a scenario in each row."""
        names = self.comparison.names
        for part in columns(len(self.comparison.settings)):
            settings = self.comparison.settings[part]
            rows = tuple((name, *(written(one.values[k]) for one in settings)) for k, name in enumerate(names))
            head = (*texts("Scenario"), *numbers(*(one.path for one in settings)))
            yield _inert(Table("Values that are not the same in all scenarios", head, rows))

    def alerts(self) -> Table | None:
        """The alerts with the scenarios that raise them; None where there is none."""
        names: dict[tuple[bool, str, str, str], list[str]] = {}
        for name, study in zip(self.comparison.names, self.comparison.studies, strict=True):
            for alert in study.alerts:
                key = (alert.severity is not Severity.WARNING, alert.code, capital(alert.severity), words(alert.title))
                names.setdefault(key, []).append(name)
        rows = tuple((*key[1:], _plain(listed(whose))) for key, whose in sorted(names.items()))
        note = "The report of a scenario by itself has the cause with its numbers, and the remedy."
        return (
            Table("Alerts of the scenarios", texts("Code", "Severity", "Alert", "Scenarios"), rows, note)
            if rows
            else None
        )

    def left_out(self) -> Iterator[tuple[str, str]]:
        """What is not in the report, and why."""
        for figure in FIGURES:
            names: dict[str, list[str]] = {}
            for name, why in left_out(self.comparison, figure):
                names.setdefault(why, []).append(name)
            yield from ((f"{capital(figure)} of {listed(whose)}", capital(why)) for why, whose in names.items())

    def origins(self) -> Iterator[tuple[str, str, str, str]]:
        """Name, file, what was set over it, and hash of each scenario."""
        for name, study in zip(self.comparison.names, self.comparison.studies, strict=True):
            loaded = study.loaded
            yield name, _file(loaded.document.name), " ".join(loaded.overrides) or ABSENT, loaded.sha256

    @property
    def listing(self) -> str:
        """The files, each once, as YAML documents; the one file as it stands."""
        documents = [study.loaded.document for study in self.comparison.studies]
        files = dict.fromkeys((_file(document.name), document.text) for document in documents)
        if len(files) == 1:
            return next(iter(files))[1]
        return "\n---\n".join(f"# {name}\n{text.rstrip()}" for name, text in files) + "\n"


def _inert(table: Table) -> Table:
    """A table whose rows begin with the names of scenarios, which are not markup."""
    return replace(table, rows=tuple((_plain(name), *cells) for name, *cells in table.rows))


def _plain(text: str) -> str:
    """A text in which only U_ave has a subscript: the names of scenarios are not markup."""
    return re.sub(r"(?<!\w)([^\W\d_])_(?!ave\b)", "\\1\u2060_", text.replace("*", "\u2217"))


def _side_by_side(comparison: Comparison, title: str, groups: Sequence[Group]) -> Iterator[Table]:
    """The quantities of some groups in a row each, with as many scenarios beside one another as fit."""
    names = comparison.names
    chosen = [quantity for quantity in comparison.quantities if quantity.group in groups]
    for part in columns(len(names)) if chosen else ():
        given = [x for x in chosen if any(entry.value is not None or entry.finding for entry in x.entries[part])]
        rows = tuple(_row(quantity, part) for quantity in given)
        caption = f"{title}: {listed(names[part])}" if len(names) > ACROSS else title
        head = (*texts("Quantity"), *numbers(*map(_plain, names[part]), "Apart"))
        yield Table(_plain(caption), head, rows, _plain(_reasons(names[part], part, given)))


def _row(quantity: Difference, chosen: slice) -> tuple[str, ...]:
    digits = digits_apart([value for value in quantity.values if value is not None], "1")
    cells = [_cell(entry, digits) for entry in quantity.entries[chosen]]
    return (_plain(quantity.heading), *cells, quantity.apart)


def _cell(entry: Entry, digits: int) -> str:
    if entry.value is None:
        return "none" if entry.finding else ABSENT
    note = "sweep" if entry.note == SWEEP_END else entry.note
    return f"{significant(entry.value, digits)} ({note})" if note else significant(entry.value, digits)


def _reasons(names: Sequence[str], part: slice, chosen: Sequence[Difference]) -> str:
    """Why there are dashes."""
    reasons: dict[str, dict[str, None]] = {}
    for quantity in chosen:
        for name, entry in zip(names, quantity.entries[part], strict=True):
            if entry.value is None and not entry.finding:
                reasons.setdefault(entry.note, {})[name] = None
    texts = "; ".join(f"{reason} ({listed(list(names))})" for reason, names in reasons.items())
    return f"A dash: {texts}." if texts else ""


def _file(name: str) -> str:
    return PurePath(name).name
