"""Records of compare.json: what is written, with the names that scripts rely on."""

from __future__ import annotations

from typing import Any

from vireport.base.records import ResultsBlock
from vireport.report.changes.table import ComparedRowData
from vireport.study.result_records import MarginToUseData


class ComparedData(ResultsBlock, frozen=True, kw_only=True):
    """A scenario that is compared.

    Attributes
    ----------
    name, file, sha256, overrides
        its name, the scenario's file and digest, and the values that `--set` and `--vary` replaced
    scenario
        the scenario as understood
    """

    name: str
    file: str
    sha256: str
    overrides: list[str]
    scenario: dict[str, Any]


class SettingData(ResultsBlock, frozen=True, kw_only=True):
    """A value by which scenarios differ.

    Attributes
    ----------
    path, values
        of a key of the scenarios, with the value of each scenario
    """

    path: str
    values: list[Any]


class RankedData(ResultsBlock, frozen=True, kw_only=True):
    """A scenario and its place among those that it is compared with.

    Attributes
    ----------
    scenario, rank
        name of the scenario, and its rank from 1; the same for scenarios that differ in nothing that is ranked by
    verdict, conclusions
        in words, and all that holds against it
    requirements_met, requirements
        numbers of requirements that are met, and of all
    stable
        whether there is stable motion, at the design point where there is one, that no simulation contradicts
    margin_to_use
        as of [results.json](results.md#effects)
    smallest_margin, margin_limited : 1
        smallest margin by rigid impacts alone; null, and `margin_limited` false, where stable motion ends nowhere;
        both null where it is not known
    margin_parameter, margin_kind
        the input and kind of that end; null without one
    u_ave_v, u_per_second_v : V, V/s
        mean voltage of the stable motion at the design point, of several the least, and voltage per second; null
        without one
    from_rest
        outcome when it is switched on, as of [results.json](results.md#disturbances)
    recovery_periods : forcing periods
        until 1 % is left of a small disturbance; null where it is not known
    least_jump_m_s : m/s
        least shock that leads out of the motion; null where none that was tried does, or none was tried
    stable_range
        ranges of the swept parameter with stable motion, as pairs
    """

    scenario: str
    rank: int
    verdict: str
    conclusions: list[str]
    requirements_met: int
    requirements: int
    stable: bool
    margin_to_use: MarginToUseData | None
    smallest_margin: float | None
    margin_limited: bool | None
    margin_parameter: str | None
    margin_kind: str | None
    u_ave_v: float | None
    u_per_second_v: float | None
    from_rest: str | None
    recovery_periods: float | None
    least_jump_m_s: float | None
    stable_range: list[list[float]]


class CompareData(ResultsBlock, frozen=True, kw_only=True):
    """Scenarios and what distinguishes their results: compare.json without its provenance.

    Attributes
    ----------
    schema_version
        1
    scenarios
        those that are compared, in their order
    settings
        values by which they differ
    ranking
        the scenarios, the best first
    quantities
        all computed numbers
    """

    schema_version: int
    scenarios: list[ComparedData]
    settings: list[SettingData]
    ranking: list[RankedData]
    quantities: list[ComparedRowData]
