"""The catalogue of extreme cases around a harvester, and its outcomes as a table and as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from vireport.base import NumericalError, WorkStep
from vireport.design import SMALLEST_LOSS
from vireport.extremes.critical import critical_cases
from vireport.extremes.harvester import harvester_of
from vireport.extremes.judge import (
    Case,
    CaseOutcome,
    CaseVerdict,
    judge,
)
from vireport.extremes.motions import motion_cases
from vireport.extremes.simulation import simulation_cases
from vireport.physics import RESTITUTIONS
from vireport.scenario import Loaded
from vireport.text import Column, Table, plain_table

if TYPE_CHECKING:
    from vireport.base import Progress

COLUMNS = (
    Column("case", width=26),
    Column("expected", width=28),
    Column("found", width=34),
    Column("error", width=8),
    Column("time", width=6),
    Column("verdict", width=8),
)
"""Columns of the table; with two spaces between them a line is 120 characters."""

LONGEST_CELL = 190
"""Characters of what was found that the table shows: of a refusal the reason, not all that it says; JSON has all."""


def catalogue(loaded: Loaded | None = None) -> tuple[Case, ...]:
    """Every case around the device of a scenario, or around the paper's.

    Raises
    ------
    NumericalError
        If the device is itself one of those that are refused.
    """
    harvester = harvester_of(loaded)
    device = harvester.device
    for own in RESTITUTIONS[:1] if device.alike else RESTITUTIONS[1:]:
        if 1 - device.value_of(own) >= SMALLEST_LOSS:
            continue
        raise NumericalError(
            f"{own.path}: {device.value_of(own)!r} is itself an extreme that is refused: impacts with "
            f"hardly any loss (allowed here: at most 1 - {SMALLEST_LOSS:g})"
        )
    return (*motion_cases(harvester), *critical_cases(harvester), *simulation_cases(harvester))


def run_catalogue(loaded: Loaded | None = None, progress: Progress | None = None) -> tuple[CaseOutcome, ...]:
    """Run every case around the device of a scenario, or around the paper's.

    Parameters
    ----------
    loaded : Loaded or None
        From `scenario.load`.
    progress : callable, optional
        Called with each case as it begins.
    """
    outcomes, cases, say = [], catalogue(loaded), progress or (lambda what: None)
    for k, case in enumerate(cases):
        say(WorkStep(f"{case.group}: {case.name}", k / len(cases)))
        outcomes.append(judge(case))
    return tuple(outcomes)


def exit_status(outcomes: Sequence[CaseOutcome]) -> tuple[int, str]:
    """Exit code, and what keeps the catalogue from having passed: a failure, or cases that could not be run."""
    verdicts = [outcome.verdict for outcome in outcomes]
    failed, left_out = verdicts.count(CaseVerdict.FAILED), verdicts.count(CaseVerdict.LEFT_OUT)
    if failed:
        return 1, f"{failed} of {len(verdicts)} cases failed"
    if left_out:
        return NumericalError.exit_code, f"{left_out} of {len(verdicts)} cases could not be run"
    if CaseVerdict.PASSED not in verdicts:
        return NumericalError.exit_code, "no case applies to this device"
    return 0, ""


def table_text(outcomes: Sequence[CaseOutcome]) -> str:
    """A table for each group of cases, and a last line that counts the verdicts."""
    parts = []
    for group, members in groupby(outcomes, key=lambda outcome: outcome.case.group):
        table = Table(group.upper(), COLUMNS, tuple(_row(outcome) for outcome in members))
        parts.append(f"{table.caption}\n{plain_table(table)}")
    return "\n\n".join((*parts, summary(outcomes))) + "\n"


def summary(outcomes: Sequence[CaseOutcome]) -> str:
    """How many cases there are of each verdict, the largest share of a bound that was used, and the time.

    A line for each failure, and for each reason to leave cases out, follows.
    """
    verdicts = [outcome.verdict for outcome in outcomes]
    shares = [
        o.error / o.bound for o in outcomes if o.verdict is CaseVerdict.PASSED and o.error is not None and o.bound
    ]
    counted = ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in CaseVerdict if verdict in verdicts)
    used = f"; the largest error of those passed is {max(shares):.2g} of its bound" if shares else ""
    lines = [f"{len(outcomes)} cases: {counted}{used}; {sum(o.seconds for o in outcomes):.1f} s"]
    lines += [f"failed: {o.case.group}: {o.case.name}" for o in outcomes if o.verdict is CaseVerdict.FAILED]
    lines += sorted({f"left out: {o.found}" for o in outcomes if o.verdict is CaseVerdict.LEFT_OUT})
    return "\n".join(lines)


def table_data(outcomes: Iterable[CaseOutcome]) -> list[dict[str, Any]]:
    """The outcomes as plain data, ready for JSON: a dictionary a case, its text not cut."""
    return [
        {
            "group": outcome.case.group,
            "case": outcome.case.name,
            "expected": outcome.case.expected,
            "found": "" if outcome.verdict is CaseVerdict.LEFT_OUT else outcome.found,
            "error": outcome.error,
            "bound": outcome.bound,
            "seconds": round(outcome.seconds, 3),
            "verdict": outcome.verdict,
            "needs": outcome.found if outcome.verdict is CaseVerdict.LEFT_OUT else None,
        }
        for outcome in outcomes
    ]


def _row(outcome: CaseOutcome) -> tuple[str, ...]:
    """The cells of one case, its error over its bound."""
    error = "" if outcome.error is None else f"{outcome.error:.1e} <{outcome.bound or 0:.0e}"
    verdict = "FAILED" if outcome.verdict is CaseVerdict.FAILED else outcome.verdict
    text = shorten(outcome.found, LONGEST_CELL, placeholder=" ...")
    return (outcome.case.name, outcome.case.expected, text, error, f"{outcome.seconds:.2f} s", verdict)
