"""The outcomes of the extreme cases as a table for the terminal, and as plain data for machines."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from textwrap import wrap
from typing import Any

from vireport.extremes.catalogue import Outcome

NAME, EXPECTED, FOUND, ERROR, TIME, VERDICT = 26, 28, 34, 8, 6, 8
"""Widths of the columns; with two spaces between them a line is 120 characters."""

HEAD = ("case", "expected", "found", "error", "time", "verdict")
WIDTHS = (NAME, EXPECTED, FOUND, ERROR, TIME, VERDICT)
MOST_LINES = 6
"""Of one cell; what is longer, a refusal with its whole reason, is cut there: the machine form has all of it."""


def table_text(outcomes: Sequence[Outcome]) -> str:
    """Return the table, a part for each group, and a last line that counts the verdicts."""
    lines = [_line(HEAD), _line(["-" * width for width in WIDTHS])]
    for group, members in groupby(outcomes, key=lambda outcome: outcome.case.group):
        lines += ["", group.upper()]
        for outcome in members:
            lines += _rows(outcome)
    return "\n".join([*lines, "", summary(outcomes), ""])


def summary(outcomes: Sequence[Outcome]) -> str:
    """How many cases passed, failed and were left out, the largest share of a bound that was used, and the time.

    A line for each failure, and for each reason to leave cases out, follows.
    """
    verdicts = [outcome.verdict for outcome in outcomes]
    shares = [o.error / o.bound for o in outcomes if o.passed and o.error is not None and o.bound]
    counted = ", ".join(
        f"{verdicts.count(word)} {word}" for word in ("passed", "failed", "left out") if word in verdicts
    )
    used = f"; the largest error of those passed is {max(shares):.2g} of its bound" if shares else ""
    lines = [f"{len(outcomes)} cases: {counted}{used}; {sum(o.seconds for o in outcomes):.1f} s"]
    lines += [f"failed: {o.case.group}: {o.case.name}" for o in outcomes if o.verdict == "failed"]
    lines += sorted({f"left out: {o.needs}" for o in outcomes if o.needs})
    return "\n".join(lines)


def table_data(outcomes: Iterable[Outcome]) -> list[dict[str, Any]]:
    """Return the outcomes as plain data, ready for JSON: a dictionary a case, its text not cut."""
    return [
        {
            "group": outcome.case.group,
            "case": outcome.case.name,
            "expected": outcome.case.expected,
            "found": outcome.found,
            "error": outcome.error,
            "bound": outcome.bound,
            "seconds": round(outcome.seconds, 3),
            "verdict": outcome.verdict,
            "needs": outcome.needs or None,
        }
        for outcome in outcomes
    ]


def _rows(outcome: Outcome) -> list[str]:
    """The lines of one case: its text wrapped, its error over its bound."""
    error = [] if outcome.error is None else [f"{outcome.error:.1e}"]
    error += [f"<{outcome.bound:.0e}" if outcome.bound else "exact"] if error else []
    verdict = outcome.verdict if outcome.verdict != "failed" else "FAILED"
    cells = [
        _wrapped(outcome.case.name, NAME),
        _wrapped(outcome.case.expected, EXPECTED),
        _wrapped(outcome.needs or outcome.found, FOUND),
        error,
        [f"{outcome.seconds:.2f} s"],
        [verdict],
    ]
    height = max(map(len, cells))
    return [_line([cell[i] if i < len(cell) else "" for cell in cells]) for i in range(height)]


def _wrapped(text: str, width: int) -> list[str]:
    lines = wrap(text, width, break_on_hyphens=False) or [""]
    if len(lines) > MOST_LINES:
        lines = [*lines[: MOST_LINES - 1], lines[MOST_LINES - 1][: width - 4] + " ..."]
    return lines


def _line(cells: Sequence[str]) -> str:
    return "  ".join(f"{cell:<{width}}" for cell, width in zip(cells, WIDTHS, strict=True)).rstrip()
