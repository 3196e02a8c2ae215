"""The section that a report opens with where the scenario says what the design must meet."""

from __future__ import annotations

from collections.abc import Iterator

from vireport.alerts import AlertCode
from vireport.gate import Criterion, Remark
from vireport.report.pages import Block, Paragraph
from vireport.scenario import ScalarInput
from vireport.study import Study
from vireport.text import ABSENT, Table, capital, texts, words

OUTCOMES = {True: "✓ met", False: "✗ NOT MET"}
"""In words, and in another shape: never by colour alone."""


def acceptance(study: Study) -> Iterator[Block]:
    """The outcome in a sentence, each requirement with its limit, value and margin, and where the values come from."""
    if not study.criteria:
        return
    met, count = sum(criterion.passed for criterion in study.criteria), len(study.criteria)
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
            f"Voltages and deflections are outside the membrane's geometry ({AlertCode.OUTSIDE_MEMBRANE_GEOMETRY}): "
            "they meet a limit, or do not, by the formulae alone."
        )
    remarks = tuple(
        (words(criterion.title), capital(_remark(criterion.outcome.remark)))
        for criterion in study.criteria
        if criterion.outcome.why
    )
    if remarks:
        yield Table("Where the values come from", texts("Requirement", "Remark"), remarks)


def _remark(parts: Remark) -> str:
    """A remark with inputs by their symbols and units."""
    return "".join(
        f"*{part.symbol}* [{part.unit}]".removesuffix(" []") if isinstance(part, ScalarInput) else words(part)
        for part in parts
    )


def _row(criterion: Criterion) -> tuple[str, ...]:
    texts = (criterion.title, criterion.limit.text, criterion.outcome.text, criterion.margin_text or ABSENT)
    title, limit, value, margin = map(words, texts)
    return title, OUTCOMES[criterion.passed], limit, value, margin
