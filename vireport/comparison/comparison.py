"""Scenarios side by side: which is best, and their stable ranges, margins, voltages and critical points.

Scenarios are compared in what they have in common. Swept values are compared directly only where both scenarios sweep
the same parameter; across lengths, forces and frequencies they are compared in d, as the paper does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct

from vireport.base.additions import ADDITIONS
from vireport.base.errors import NumericalError, UsageError
from vireport.base.progress import WorkStep
from vireport.base.records import plain
from vireport.comparison.opening import comparison_opening
from vireport.comparison.ranking import RANK_BY, Merit, Ranked, rank_studies, ranking_table, remarks
from vireport.comparison.results import CompareData, ComparedData, SettingData
from vireport.comparison.variants import Item, Variant, Vary, variants
from vireport.report.changes.quantities import QuantityGroup, compared_scenarios
from vireport.report.changes.table import NO_DIFFERENCE, Axes, ComparisonRow, axes_of, comparison_rows
from vireport.scenario.blocks import to_dict
from vireport.study.plan import Task, plan
from vireport.study.result_records import SCHEMA_VERSION
from vireport.study.study import Study, analyse
from vireport.text.foreign import visible
from vireport.text.formatting import Exactness
from vireport.text.said import Said, words_of
from vireport.text.tables import html_table

_said = words_of("compare")

if TYPE_CHECKING:
    from vireport.base.progress import Progress
    from vireport.study.judging.opening import Opening

COMPARED_FIGURES = ("figure-2", "figure-4", "figure-7")
"""Figures that are drawn of each scenario, beside one another."""

OVERLAY = "figure-variants"
"""All scenarios on one axis."""

BESIDE_ONE_ANOTHER = 5
"""Scenarios beside one another in a table or a figure; of more there are several."""

FEW_NAMES = 3
"""Files up to which their names stand in the provenance, and scenarios up to which theirs stand in the title."""


class Comparison(Struct, frozen=True, eq=False, dict=True):
    """Scenarios side by side: their ranking, and the quantities by which their results differ.

    Attributes
    ----------
    names : tuple of str
        Name of each scenario; no two are alike.
    studies : tuple of Study
        Results of each scenario, in the order of the names.
    axes : Axes
        Whether values along the sweeps are compared in the swept input or in d.
    table : tuple of ComparisonRow
        All rows, by groups; in each group those that differ most first.
    rank_by : tuple of Merit
        Criteria of the ranking beyond those that always count.
    """

    names: tuple[str, ...]
    studies: tuple[Study, ...]
    axes: Axes
    table: tuple[ComparisonRow, ...]
    rank_by: tuple[Merit, ...] = ()

    def __repr__(self) -> str:
        names = ", ".join(self.names) if len(self.names) <= BESIDE_ONE_ANOTHER else f"{len(self.names)} scenarios"
        return f"<Comparison of {visible(names)}: {self.headline}>"

    @property
    def by_name(self) -> dict[str, Study]:
        """The studies by the names of their scenarios."""
        return dict(zip(self.names, self.studies, strict=True))

    @property
    def exactness(self) -> Exactness:
        """How exact the numbers of all scenarios are, which determines how many digits are shown."""
        return _exactness(self.studies)

    @cached_property
    def quantities(self) -> tuple[ComparisonRow, ...]:
        """The rows of computed numbers."""
        return tuple(row for row in self.table if not row.is_statement)

    @cached_property
    def differences(self) -> tuple[ComparisonRow, ...]:
        """The rows of computed numbers that differ by more than rounding."""
        return tuple(row for row in self.quantities if row.differs)

    @cached_property
    def settings(self) -> tuple[ComparisonRow, ...]:
        """The rows of scenario values that differ; the quantity of a row is the path of the key."""
        return tuple(row for row in self.table if row.group is QuantityGroup.SCENARIO and row.differs)

    @cached_property
    def ranking(self) -> tuple[Ranked, ...]:
        """The scenarios, the best first."""
        return rank_studies(self.by_name, self.rank_by)

    @cached_property
    def opening(self) -> Opening:
        """What the report opens with: the best scenario and why, what others lack, and the numbers of the best."""
        return comparison_opening(self.ranking)

    @property
    def headline(self) -> str:
        """One sentence: which scenario is best, and why."""
        return self.opening.worded().sentence

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on scenarios that have no margin, or no voltage, to compare."""
        return tuple(remark.words() for remark in remarks(self.ranking))

    def to_dict(self, templates: Path | None = None) -> dict[str, Any]:
        """Give the comparison as plain data, ready for JSON.

        Parameters
        ----------
        templates : Path, optional
            A folder whose words come before the package's own: of sentences, all else is the same with any.
        """
        data: dict[str, Any] = plain(
            CompareData(
                schema_version=SCHEMA_VERSION,
                scenarios=[
                    ComparedData(
                        name=name,
                        file=Path(study.loaded.document.name).name,
                        sha256=study.loaded.sha256,
                        overrides=list(study.loaded.overrides),
                        scenario=to_dict(study.scenario),
                    )
                    for name, study in self.by_name.items()
                ],
                settings=[SettingData(path=row.quantity, values=list(row.values)) for row in self.settings],
                ranking=[scenario.data for scenario in self.ranking],
                quantities=[row.data(templates) for row in self.quantities],
            )
        )
        return data

    def rows(self) -> list[dict[str, Any]]:
        """Give a row for each scenario, for a data frame: its rank, the values by which it differs, all quantities.

        A quantity is a column named with its unit in brackets; None where a scenario has none of it.
        """
        ranked = {scenario.name: scenario.to_dict() for scenario in self.ranking}
        return [
            ranked[name]
            | {"stable_range": "; ".join(f"{start!r} to {end!r}" for start, end in ranked[name]["stable_range"])}
            | {row.quantity: row.values[k] for row in self.settings}
            | {row.heading: row.values[k] for row in self.quantities}
            for k, name in enumerate(self.names)
        ]

    def _repr_html_(self) -> str:
        """Which scenario is best and why, and the ranking, for a notebook."""
        table = ranking_table(self.ranking)
        head = html_table([column.title for column in table.columns], table.rows)
        return f"<p><strong>{escape(self.headline)}</strong></p>\n{head}"


def compare(
    items: Sequence[Item] | Item,
    vary: Vary | None = None,
    names: Sequence[str] | None = None,
    overrides: str | Sequence[str] | Mapping[str, object] = (),
    progress: Progress | None = None,
    rank_by: Sequence[str] = (),
    allow_outside: bool = False,
) -> Comparison:
    """Solve scenarios, compare their results and rank them.

    Parameters
    ----------
    items : sequence of str, Path, Loaded or Study
        Paths of scenario files, results of `load` or of `analyse`. A study is solved again only if it is varied.
    vary : mapping of str to sequence, or sequence of str, optional
        Values of keys: ``{"inclination_deg": [0, 15]}`` or ``["inclination_deg=0,15"]``. Several keys give every
        combination, the last key varying fastest.
    names : sequence of str, optional
        A name for each item or, if a single item is varied, for each variant.
    overrides : sequence of str, or mapping, optional
        Values that replace those of every scenario, before it is varied.
    progress : callable, optional
        Called with the name of each scenario as its solution begins.
    rank_by : sequence of str, optional
        `from-rest`, `recovery` or `shock`, what matters most first: these count after stable motion and before the
        margin.
    allow_outside : bool
        Whether records that scenario files name may be outside of their folders.

    Returns
    -------
    Comparison
        The scenarios with their results, rows and ranking.

    Raises
    ------
    UsageError
        For fewer than two scenarios, too many, names that do not fit, or a ranking by what some scenario cannot have.
    ScenarioError
        Where a scenario cannot be used, with the mistakes of all variants.
    NumericalError
        Where a scenario cannot be solved, with its name.
    """
    chosen = variants(items, vary, names, overrides, allow_outside)
    if len(chosen) < 2:
        raise UsageError("a comparison needs at least two scenarios, or one and values to vary (--vary key=1,2,3)")
    merits = _merits_asked(rank_by, chosen)
    say = progress or (lambda what: None)
    studies = []
    for number, variant in enumerate(chosen, 1):
        say(WorkStep(f"solving {variant.name}", (number - 1) / len(chosen), f"{number} of {len(chosen)}"))
        studies.append(variant.study or _solved(variant, say))
    scenarios = compared_scenarios(
        {variant.name: study.results() for variant, study in zip(chosen, studies, strict=True)}
    )
    axes = axes_of(scenarios.values(), NO_DIFFERENCE)
    rows = comparison_rows(scenarios, axes, exactness=_exactness(studies))
    return Comparison(tuple(scenarios), tuple(studies), axes, rows, merits)


def _exactness(studies: Sequence[Study]) -> Exactness:
    """The exactness of the least exact study, which counts for the numbers of all."""
    return max((study.evidence.exactness for study in studies), key=lambda of_study: of_study.relative)


def _merits_asked(names: Sequence[str], chosen: Sequence[Variant]) -> tuple[Merit, ...]:
    """The merits to rank scenarios by, where every scenario computes them.

    Raises
    ------
    UsageError
    """
    allowed = [name for name, merit in RANK_BY.items() if merit is not Merit.SHOCK or "outcomes" in ADDITIONS]
    for name in names:
        if name not in allowed:
            raise UsageError(f"scenarios cannot be ranked by {name!r} (allowed: {', '.join(allowed)})")
        task = "shock" if RANK_BY[name] is Merit.SHOCK else Task.FROM_REST
        for variant in chosen:
            steps = variant.study.plan if variant.study is not None else plan(variant.loaded.scenario)
            why = steps.reason(task)
            if why is not None:
                raise UsageError(f"{variant.name} cannot be ranked by {name}: {why}")
    return tuple(dict.fromkeys(RANK_BY[name] for name in names))


def _solved(variant: Variant, say: Progress) -> Study:
    try:
        # Without the step's share of the work: the share that is shown is that of all scenarios.
        return analyse(variant.loaded, progress=lambda what: say(f"{variant.name}: {what}"))
    except NumericalError as error:
        raise NumericalError(f"{variant.name}: {error}") from error


def left_out(comparison: Comparison, figure: str) -> list[tuple[str, Said]]:
    """List the scenarios that a figure, one of `COMPARED_FIGURES`, does not show, and why."""
    missing: list[tuple[str, Said]] = []
    for name, study in comparison.by_name.items():
        if study.solution.sweep is None:
            missing.append((name, _said("has_no_sweep")))
        elif study.solution.on_table:
            missing.append((name, _said("is_table")))
        elif figure == "figure-7" and study.solution.membrane is None:
            missing.append((name, _said("has_no_ball_mass")))
    return missing


def columns(count: int, per_page: int = BESIDE_ONE_ANOTHER) -> list[slice]:
    """Split so many columns into groups of nearly one size, such as 5 into 3 and 2, each of which fits on a page."""
    groups = -(-count // per_page)
    ends = [-(-k * count // groups) for k in range(groups + 1)] if groups else []
    return [slice(first, last) for first, last in pairwise(ends)]
