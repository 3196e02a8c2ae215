"""The section that a report opens with where the scenario says what the design must meet."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.gate import Criterion, capital
from vireport.report.pages import Block, Paragraph, Table, texts
from vireport.scenario import Parameter
from vireport.study import Study
from vireport.text import (
    ABSENT,
    words,
)

OUTCOMES = {True: "✓ met", False: "✗ NOT MET"}
"""In words, and in another shape: never by colour alone."""


def acceptance(study: Study) -> Iterator[Block]:
    """The outcome in a sentence, each requirement with its limit, value and margin, and where the values come from."""
    met, count = sum(one.passed for one in study.criteria), len(study.criteria)
    yield Paragraph(f"{met} of {count} requirement{'s' * (count != 1)} {'is' if met == 1 else 'are'} met.")
    yield Table(
        "Requirements",
        texts("Requirement", "Outcome", "Limit", "Value", "Margin"),
        tuple(map(_row, study.criteria)),
        "The margin is how far the value is on the right side of the limit, in the limit\u2019s unit; of a range, how "
        "far stable motion goes beyond it. What error bounds or a failed cross-check leave open counts as not met.",
    )
    if not study.solution.within_membrane:
        yield Paragraph(
            "Voltages and deflections are outside the membrane's geometry (VR010): they meet a limit, or do not, by "
            "the formulae alone."
        )
    remarks = tuple((words(one.title), capital(_named(words(one.why)))) for one in study.criteria if one.why)
    if remarks:
        yield Table("Where the values come from", texts("Requirement", "Remark"), remarks)


def _named(text: str) -> str:
    """A remark with symbols and units in place of the keys of parameters."""
    for swept in Parameter:
        text = text.replace(swept, f"*{swept.symbol}* [{swept.unit}]")
    return text


def _row(one: Criterion) -> tuple[str, ...]:
    title, limit, value, margin = map(words, (one.title, one.limit, one.value_text, one.margin_text or ABSENT))
    return title, OUTCOMES[one.passed], limit, value, margin
