"""The additions to a study, by which plan, requirements, verdict, results and report are extended."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from vireport.base.additions import declared


@cache
def findings() -> Mapping[str, Any]:
    """What each addition brings, a `study.finding.AddedFinding`, by its name, in the order of the rows."""
    return {finding.name: finding for finding in declared("finding")}


def with_results(results: Mapping[str, object]) -> Iterator[tuple[Any, object]]:
    """The additions that found something, each with what it found."""
    return ((finding, results[name]) for name, finding in findings().items() if name in results)
