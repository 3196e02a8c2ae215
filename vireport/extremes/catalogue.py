"""The table of extreme cases around a harvester, and what came of them as text and as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from vireport.base.errors import NumericalError
from vireport.base.progress import WorkStep
from vireport.design.solution import SMALLEST_LOSS
from vireport.extremes.critical import critical_rows
from vireport.extremes.harvester import harvester_of
from vireport.extremes.motions import motion_rows
from vireport.extremes.rows import Case, CaseOutcome, CaseVerdict, run
from vireport.extremes.simulation import simulation_rows
from vireport.physics.device import RESTITUTIONS
from vireport.scenario.loading import Loaded
from vireport.text.tables import Column, Table, plain_table

if TYPE_CHECKING:
    from vireport.base.progress import Progress

COLUMNS = (Column("case", width=42), Column("found", width=44), Column("error", width=14), Column("verdict", width=14))
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
    for restitution in RESTITUTIONS[:1] if device.alike else RESTITUTIONS[1:]:
        if 1 - device.value_of(restitution) < SMALLEST_LOSS:
            raise NumericalError(
                f"{restitution.path}: {device.value_of(restitution)!r} is itself an extreme that is refused: impacts "
                f"with hardly any loss (allowed here: at most 1 - {SMALLEST_LOSS:g})"
            )
    return (*motion_rows(harvester), *critical_rows(harvester), *simulation_rows(harvester))


def run_catalogue(loaded: Loaded | None = None, progress: Progress | None = None) -> tuple[CaseOutcome, ...]:
    """Run every case around the device of a scenario, or around the paper's; `progress` is called with each."""
    outcomes, rows, say = [], catalogue(loaded), progress or (lambda what: None)
    for k, row in enumerate(rows):
        say(WorkStep(row.title, k / len(rows)))
        outcomes.append(run(row))
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
    """A row for each case; then how many there are of each verdict, and a line for each that failed."""
    cells = []
    for row, verdict, found, _ in outcomes:
        error = "" if found.error is None else f"{found.error:.1e} <{found.bound:.0e}"
        text = shorten(found.text, LONGEST_CELL, placeholder=" ...")
        cells.append((row.title, text, error, "FAILED" if verdict is CaseVerdict.FAILED else verdict))
    verdicts = [outcome.verdict for outcome in outcomes]
    counts = ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in CaseVerdict if verdict in verdicts)
    lines = [f"{len(outcomes)} cases: {counts}; {sum(outcome.seconds for outcome in outcomes):.1f} s"]
    lines += [f"failed: {outcome.row.title}" for outcome in outcomes if outcome.verdict is CaseVerdict.FAILED]
    return "\n".join((plain_table(Table("", COLUMNS, tuple(cells))), "", *lines)) + "\n"


def table_data(outcomes: Sequence[CaseOutcome]) -> list[dict[str, Any]]:
    """The outcomes as plain data, ready for JSON."""
    return [
        {
            "group": row.group,
            "case": row.name,
            "found": found.text,
            "error": found.error,
            "bound": None if found.error is None else found.bound,
            "seconds": round(seconds, 3),
            "verdict": verdict,
        }
        for row, verdict, found, seconds in outcomes
    ]
