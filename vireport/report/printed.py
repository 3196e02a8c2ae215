"""The paper's numbers beside ours as tables, for the report of one of its scenarios and for that of all of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from pathlib import Path

from vireport.motions.diagram import TableRow
from vireport.motions.events import Event
from vireport.study.checks.paper import (
    PAPER,
    Agreement,
    ComparedRow,
    ComparedTypes,
    Misprint,
    PaperComparison,
    PrintedQuantity,
)
from vireport.text.formatting import ABSENT, capital, rounded_text
from vireport.text.said import Said, spoken, words_of
from vireport.text.tables import Table, worded_table
from vireport.text.templates import Words

_said = words_of("paper")


def paper_section(compared: PaperComparison, templates: Path | None = None) -> tuple[str | Table, ...]:
    """The section of a report on one of the paper's scenarios: which one it is, numbers, types and slips.

    Parameters
    ----------
    compared : PaperComparison
    templates : Path, optional
        A folder whose words come before the package's own.
    """
    lead = _said("lead", PAPER, _said(compared.case.name)).words(templates)
    types = [types_table([compared], templates)] if compared.types else []
    return lead, numbers_table([compared], templates), *types, misprints_table([compared], templates)


def numbers_table(compared: Sequence[PaperComparison], templates: Path | None = None) -> Table:
    """Every number that the paper prints of some scenarios, and ours."""
    rows = ([spoken(cell, templates) for cell in _number(row, one.case.panels)] for one in compared for row in one.rows)
    return worded_table(Words("paper", templates), "numbers", "tnntt", rows)


def quantity_of(row: ComparedRow, panels: str) -> Said:
    """What a row compares: its place in the paper and its symbol; `panels` are those of its sweep in Fig. 2."""
    place, symbol = place_of(row, panels), symbol_of(row)
    return _said("quantity_at", place, symbol, row.d) if row.d else _said("quantity", place, symbol)


def place_of(row: ComparedRow, panels: str) -> str:
    """Where in the paper a row is from; letters of critical points are told apart by the panels of their sweep."""
    point = row.quantity in (PrintedQuantity.POINT_PHASE, PrintedQuantity.POINT_D)
    return f"{row.of} of Fig. 2{panels}" if point else row.of


def _number(row: ComparedRow, panels: str) -> Iterator[str | Said]:
    yield quantity_of(row, panels)
    yield row.printed or ABSENT
    yield rounded_text(row.ours, row.error)
    yield "" if row.agrees is None else _said("agrees" if row.agrees else "differs")
    yield _remark(row)


def symbol_of(row: ComparedRow) -> Said:
    """The symbol of what a row compares, with its unit."""
    return _said(f"symbol_{row.quantity}")


def _remark(row: ComparedRow) -> Said:
    """How far a number of ours agrees, and what it is to be read with."""
    if row.agreement is Agreement.NOT_PRINTED:
        return _said("letter_alone")
    remark = _said("off_by", row.gap) if row.agreement is Agreement.DIFFERS else _said(row.agreement)
    if row.phase is not None:
        remark = _said("at_mirrored_impact" if row.mirrored else "at_impact", remark, row.phase.impact)
        if row.phase.kind is Event.PITCHFORK:
            remark = _said("at_pitchfork", remark)
    return _said("take_d", remark) if row.quantity is PrintedQuantity.LENGTH else remark


def types_table(compared: Sequence[PaperComparison], templates: Path | None = None) -> Table:
    """The paper's Table 1 with the numbers of its intervals, and the type that each has by the solution."""
    rows = (
        [spoken(cell, templates) for cell in row]
        for one in compared
        for types in one.types
        for row in _intervals(types, one.case.panels)
    )
    return worded_table(Words("paper", templates), "types", "ttnnttt", rows)


def _intervals(types: ComparedTypes, panels: str) -> Iterator[tuple[str | Said, ...]]:
    motion = f"{capital(types.family)}, Fig. 2{panels}"
    for printed, row in zip_longest(types.printed, types.intervals):
        ours, ends = (ABSENT, (ABSENT, ABSENT)) if row is None else (row.stability, (row.d_start, row.d_end))
        printed_ends = (end if isinstance(end, str) else rounded_text(end) for end in ends)
        outcome = _said("agrees" if row is not None and printed is ours else "cut_row")
        yield motion, ABSENT if row is None else _interval(row), *printed_ends, printed or ABSENT, ours, outcome


def _interval(row: TableRow) -> Said:
    start, end = (None if point is None else point.label for point in (row.start_point, row.end_point))
    if start is None and end is None:
        return _said("throughout")
    if start is None or end is None:
        return _said("up_to", end) if start is None else _said("beyond", start)
    return _said("from_to", start, end)


def misprints_table(compared: Sequence[PaperComparison], templates: Path | None = None) -> Table:
    """The slips in the paper's text that concern some of its scenarios, each once."""
    slips = [slip for slip in Misprint if any(slip in one.case.misprints for one in compared)]
    rows = (_said(f"slip_{slip}").parts(templates) for slip in slips)
    return worded_table(Words("paper", templates), "misprints", "tttt", rows)
