"""What the templates of a comparison know: the ranking, all numbers side by side, the settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePath
from typing import TYPE_CHECKING

from msgspec import Struct
from msgspec.structs import replace

from vireport.comparison.comparison import (
    BESIDE_ONE_ANOTHER,
    COMPARED_FIGURES,
    FEW_NAMES,
    Comparison,
    columns,
    left_out,
)
from vireport.comparison.ranking import margins_table, ranking_table, remarks
from vireport.report.changes.quantities import DESIGN_VOLTAGE, QuantityGroup
from vireport.report.changes.sentences import NOTHING, listed
from vireport.report.changes.table import ComparisonRow
from vireport.scenario.parameters import Parameter
from vireport.study.judging.opening import WordedOpening
from vireport.study.provenance import Provenance
from vireport.study.results import SWEEP_END
from vireport.text.foreign import unmarked
from vireport.text.formatting import ABSENT, Exactness, apart, capital, percent, rounded_text, words, written
from vireport.text.said import Said, spoken, words_of
from vireport.text.tables import Table, numbers, texts, worded_table

if TYPE_CHECKING:
    from vireport.figures.style import Picture


_said = words_of("compare")

IN_OTHER_TABLES = QuantityGroup.DESIGN_POINT, QuantityGroup.STABLE_RANGE, QuantityGroup.MARGIN
"""What ranking and margins tell in fewer rows."""


class ComparisonReport(Struct, frozen=True, eq=False):
    """The object `report` of the templates of `vireport compare`.

    Attributes
    ----------
    comparison : Comparison
        What `vireport.compare` returns.
    pictures : mapping of str to Picture
        Figures by their names.
    provenance : Provenance
        Version, Python, libraries, command and timestamp.
    templates : Path, optional
        The user's folder, whose templates come before those of the package.
    template : str
        The template that the report begins with.
    """

    comparison: Comparison
    pictures: Mapping[str, Picture]
    provenance: Provenance
    templates: Path | None = None
    template: str = "comparison.typ.j2"

    @property
    def title(self) -> str:
        """Names of the scenarios or, if they are many, their number."""
        names = self.comparison.names
        few = len(names) <= FEW_NAMES
        return self._say(_said("title", listed(names) if few else _said("scenarios", len(names))))

    def _say(self, said: Said) -> str:
        return said.words(self.templates)

    @property
    def verdict(self) -> WordedOpening:
        """What the page opens with: which scenario is best, and why."""
        worded = self.comparison.opening.worded(self.templates)
        facts = tuple((status, unmarked(text)) for status, text in worded.facts)
        return replace(worded, word=unmarked(worded.word), sentence=unmarked(worded.sentence), facts=facts)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on the ranking."""
        return tuple(unmarked(self._say(remark)) for remark in remarks(self.comparison.ranking))

    def ranking(self) -> Table:
        """Table of the scenarios, the best first."""
        return _inert(ranking_table(self.comparison.ranking, self.templates))

    def margins(self) -> Table | None:
        """Table of the nearest end of stable motion along each input; None where no scenario has one."""
        table = margins_table(self.comparison.ranking, self.templates)
        return None if table is None else _inert(table)

    def say(self, macro: str, *values: object) -> str:
        """What a macro of `words/compare.j2` says of some values."""
        return self._say(_said(macro, *values))

    @property
    def swept(self) -> list[Parameter]:
        """The parameters that the scenarios sweep."""
        sweeps = (study.solution.sweep for study in self.comparison.studies)
        return list(dict.fromkeys(sweep.parameter for sweep in sweeps if sweep is not None))

    def quantities(self) -> Iterator[Table]:
        """Tables of the other quantities, one in each row, with as many scenarios beside one another as fit."""
        comparison, names = self.comparison, self.comparison.names
        chosen = [
            row for row in comparison.quantities if row.group not in IN_OTHER_TABLES and row.name != DESIGN_VOLTAGE.name
        ]
        first, last = _said("quantities_heads").parts(self.templates)
        for part in columns(len(names)) if chosen else ():
            rows = [row for row in chosen if any(cell.value is not None or cell.finding for cell in row.cells[part])]
            lines = tuple(
                (
                    unmarked(capital(row.headed(self.templates))),
                    *_numbers(row, part, comparison.exactness, self.templates),
                    spoken(_difference(row), self.templates),
                )
                for row in rows
            )
            head = (*texts(first), *numbers(*map(unmarked, names[part]), last))
            caption = _said("quantities")
            if len(names) > BESIDE_ONE_ANOTHER:
                caption = _said("of_scenarios", caption, listed(names[part]))
            note = _dashes(names[part], part, rows)
            yield Table(unmarked(self._say(caption)), head, lines, "" if note is None else unmarked(self._say(note)))

    def settings(self) -> Iterator[Table]:
        """Tables of the values by which scenarios differ; the more numerous, scenarios or keys, are the rows."""
        names, settings = tuple(map(unmarked, self.comparison.names)), self.comparison.settings
        keys = tuple(row.quantity for row in settings)
        cells = [[written(value) for value in row.values] for row in settings]
        caption, *heads = _said("settings").parts(self.templates)
        if len(keys) > len(names):
            down, across, head = keys, names, texts(heads[1])
        else:
            down, across, head = names, keys, texts(heads[0])
            cells = [list(row) for row in zip(*cells, strict=True)]
        for part in columns(len(across)):
            rows = tuple((name, *row[part]) for name, row in zip(down, cells, strict=True))
            yield Table(caption, (*head, *numbers(*across[part])), rows)

    def alerts(self) -> Table | None:
        """Table of the alerts with the scenarios that raise them; None without alerts."""
        names: dict[tuple[int, str, str, str], list[str]] = {}
        for name, study in self.comparison.by_name.items():
            for alert in study.alerts:
                key = (
                    alert.severity.rank,
                    alert.code,
                    capital(alert.severity),
                    words(alert.title.words(self.templates)),
                )
                names.setdefault(key, []).append(name)
        rows = tuple((*key[1:], unmarked(self._listed(raising))) for key, raising in sorted(names.items()))
        return worded_table(self.say, "alerts", "tttt", rows) if rows else None

    def _listed(self, names: Sequence[str]) -> str:
        return str(spoken(listed(names), self.templates))

    def left_out(self) -> Table:
        """Table of the figures that scenarios lack in the report, with the reasons."""
        figures: dict[tuple[Said, str], list[str]] = {}
        for figure in COMPARED_FIGURES:
            names: dict[Said, list[str]] = {}
            for name, why in left_out(self.comparison, figure):
                names.setdefault(why, []).append(name)
            for why, lacking in names.items():
                figures.setdefault((why, self._listed(lacking)), []).append(figure.removeprefix("figure-"))
        rows = [
            (
                unmarked(self.say("figures_of" if numbers[1:] else "figure_of", self._listed(numbers), lacking)),
                capital(self._say(why)),
            )
            for (why, lacking), numbers in figures.items()
        ]
        others = [_said(macro).parts(self.templates) for macro in ("lacks_margins", "lacks_sections")]
        return worded_table(self.say, "left_out", "tt", [*rows, *others])

    def origins(self) -> tuple[Table, Table]:
        """Two tables: files of the scenarios with what was set over them, and their SHA-256."""
        loaded = {unmarked(name): study.loaded for name, study in self.comparison.by_name.items()}
        rows = [(name, _file(of.document.name), " ".join(of.overrides) or ABSENT) for name, of in loaded.items()]
        hashes = [(name, of.sha256) for name, of in loaded.items()]
        return worded_table(self.say, "origins", "tcc", rows), worded_table(self.say, "hashes", "tc", hashes)

    @property
    def listing(self) -> str:
        """Text of the scenario files, each once, as YAML documents."""
        documents = [study.loaded.document for study in self.comparison.studies]
        files = dict.fromkeys((_file(document.name), document.text) for document in documents)
        if len(files) == 1:
            return next(iter(files))[1]
        return "\n---\n".join(f"# {name}\n{text.rstrip()}" for name, text in files) + "\n"


def _inert(table: Table) -> Table:
    """Make a table whose rows begin with the names of scenarios, which are not markup."""
    return replace(table, rows=tuple((unmarked(name), *cells) for name, *cells in table.rows))


def _numbers(row: ComparisonRow, part: slice, exactness: Exactness, templates: Path | None) -> Iterator[str]:
    """Print what some scenarios have of a quantity, in so many digits that all that differ are told apart."""
    values = [value for value in row.values if value is not None]
    printed = apart(values, exactness) if row.change != 0 else [rounded_text(value, exactness) for value in values]
    texts = dict(zip(values, printed, strict=True))
    for cell in row.cells[part]:
        if cell.value is None:
            yield NOTHING.words(templates) if cell.finding else ABSENT
        else:
            note = _said("sweep_end") if cell.note == SWEEP_END else cell.note
            number = _said("noted", texts[cell.value], note) if note else texts[cell.value]
            yield spoken(number, templates)


def _difference(row: ComparisonRow) -> str | Said:
    """How far apart the values are."""
    if row.change is None:
        return _said("only_some") if row.differs else ABSENT
    return percent(row.change)


def _dashes(names: Sequence[str], part: slice, rows: Sequence[ComparisonRow]) -> Said | None:
    """Why there are dashes; None where there is none."""
    reasons: dict[str | Said, dict[str, None]] = {}
    for row in rows:
        for name, cell in zip(names, row.cells[part], strict=True):
            if cell.value is None and not cell.finding:
                reasons.setdefault(cell.note, {})[name] = None
    parts = [_said("dash", reason, listed(list(lacking))) for reason, lacking in reasons.items()]
    return _said("dashes", parts) if parts else None


def _file(name: str) -> str:
    return PurePath(name).name
