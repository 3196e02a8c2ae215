"""Scenarios side by side: their critical points, stable ranges, margins and voltages, what changed most first.

What is compared is what scenarios have in common. A swept value stands beside another only where both scenarios
sweep the same parameter; across lengths, forces and frequencies, places are compared in d, as the paper does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vireport.comparison.differences import Difference, Member
from vireport.comparison.quantities import differences
from vireport.comparison.variants import Variant, variants
from vireport.errors import NumericalError, UsageError
from vireport.scenario import (
    Loaded,
    to_dict,
)
from vireport.study import (
    SCHEMA_VERSION,
    Study,
    analyse,
)

if TYPE_CHECKING:
    from vireport.progress import Progress
Item = str | Path | Loaded | Study
Vary = Sequence[str] | Mapping[str, Sequence[object]]

MOST = 48
"""Scenarios in one comparison: twelve rows of figures; more are the matter of a map, not of a comparison."""

NOT_COMPARED = ("schema_version", "title")
"""Keys of a scenario that have no part in its results."""


FIGURES = ("figure-2", "figure-4", "figure-7")
"""Those of which there is one for all scenarios."""


@dataclass(frozen=True, slots=True)
class Setting:
    """A value that the scenarios do not share.

    Attributes
    ----------
    path : str
        Dotted, as in a scenario.
    values : tuple
        Plain values, one for each scenario; None where it is not given.
    """

    path: str
    values: tuple[Any, ...]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Scenarios and what distinguishes their results.

    Attributes
    ----------
    names : tuple of str
        One for each scenario, no two alike.
    studies : tuple of Study
    quantities : tuple of Difference
        All that is compared, what changed most first.
    settings : tuple of Setting
        The values by which the scenarios differ.
    """

    names: tuple[str, ...]
    studies: tuple[Study, ...]
    quantities: tuple[Difference, ...]
    settings: tuple[Setting, ...]

    @property
    def members(self) -> tuple[Member, ...]:
        """Names and studies together."""
        return tuple(Member(name, study) for name, study in zip(self.names, self.studies, strict=True))

    @cached_property
    def differences(self) -> tuple[Difference, ...]:
        """The quantities that differ by more than rounding."""
        return tuple(one for one in self.quantities if one.differs)

    def to_dict(self) -> dict[str, Any]:
        """The comparison as plain data, ready for JSON."""
        scenarios = [
            {
                "name": name,
                "file": Path(study.loaded.document.name).name,
                "sha256": study.loaded.sha256,
                "overrides": list(study.loaded.overrides),
                "scenario": to_dict(study.scenario),
            }
            for name, study in zip(self.names, self.studies, strict=True)
        ]
        return {
            "schema_version": SCHEMA_VERSION,
            "scenarios": scenarios,
            "settings": [{"path": one.path, "values": _plain(one.values)} for one in self.settings],
            "quantities": [one.to_dict() for one in self.quantities],
        }

    def rows(self) -> list[dict[str, Any]]:
        """A row for each quantity, for a data frame; the scenarios are columns by their names."""
        return [
            {
                "quantity": one.quantity,
                "group": one.group,
                "unit": one.unit,
                **dict(zip(self.names, one.values, strict=True)),
                "change": one.change,
                "differs": one.differs,
                "sentence": one.sentence,
            }
            for one in self.quantities
        ]

    def _repr_html_(self) -> str:
        from vireport.comparison.notebook import comparison_html

        return comparison_html(self)


def compare(
    items: Sequence[Item] | Item,
    vary: Vary | None = None,
    names: Sequence[str] | None = None,
    overrides: str | Sequence[str] | Mapping[str, object] = (),
    progress: Progress | None = None,
) -> Comparison:
    """Solve scenarios and compare what comes out.

    Parameters
    ----------
    items : sequence of str, Path, Loaded or Study
        Scenario files, loaded scenarios or solved ones. A solved one is solved again only where it is varied.
    vary : mapping of str to sequence, or sequence of str, optional
        Values of keys, ``{"inclination_deg": [0, 15]}`` or ``["inclination_deg=0,15"]``; of several keys every
        combination is taken, the last one varying fastest.
    names : sequence of str, optional
        One for each item, or where a single item is varied, one for each variant.
    overrides : sequence of str, or mapping, optional
        Set over every scenario, before it is varied.
    progress : callable, optional
        Told each scenario as it begins.

    Raises
    ------
    UsageError
        For fewer than two scenarios, too many, or names that do not fit.
    ScenarioError
        Where a scenario cannot be used, with the mistakes of all variants.
    NumericalError
        Where a scenario cannot be solved; it is named.
    """
    given = [items] if isinstance(items, str | Path | Loaded | Study) else list(items)
    found = variants(given, vary, names, overrides, MOST)
    if len(found) < 2:
        raise UsageError("a comparison needs at least two scenarios, or one and values to vary (--vary key=1,2,3)")
    say = progress or (lambda what: None)
    studies = []
    for k, variant in enumerate(found, 1):
        say(f"solving {k} of {len(found)}: {variant.name}")
        studies.append(variant.study or _solved(variant, say))
    members = [Member(variant.name, study) for variant, study in zip(found, studies, strict=True)]
    scenarios = [study.scenario for study in studies]
    return Comparison(
        tuple(member.name for member in members), tuple(studies), differences(members), settings_of(scenarios)
    )


def _solved(variant: Variant, say: Progress) -> Study:
    try:
        return analyse(variant.loaded, progress=lambda what: say(f"{variant.name}: {what}"))
    except NumericalError as error:
        raise NumericalError(f"{variant.name}: {error}") from error


def settings_of(scenarios: Sequence[Any]) -> tuple[Setting, ...]:
    """The values by which scenarios differ, in the order of the scenario format."""
    flat = [flattened(to_dict(scenario)) for scenario in scenarios]
    paths = dict.fromkeys(path for values in flat for path in values)
    found = []
    for path in paths:
        values = tuple(one.get(path) for one in flat)
        if path not in NOT_COMPARED and any(value != values[0] for value in values):
            found.append(Setting(path, values))
    return tuple(found)


def left_out(comparison: Comparison, figure: str) -> list[tuple[str, str]]:
    """The scenarios that a figure, one of `FIGURES`, does not show, and why."""
    found = []
    for name, study in zip(comparison.names, comparison.studies, strict=True):
        if study.solution.sweep is None:
            found.append((name, "it has no sweep"))
        elif figure == "figure-7" and study.solution.membrane is None:
            found.append((name, "device.ball_mass_kg is not given"))
    return found


def flattened(block: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """The values of nested blocks by their dotted paths; what is not given is left out."""
    found: dict[str, Any] = {}
    for key, value in block.items():
        if isinstance(value, Mapping):
            found |= flattened(value, f"{path}{key}.")
        elif value is not None:
            found[f"{path}{key}"] = value
    return found


def _plain(values: Sequence[Any]) -> list[Any]:
    return [list(value) if isinstance(value, tuple) else value for value in values]
