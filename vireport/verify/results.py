"""What `vireport verify` writes as records: accuracy.json, and the outcomes of extreme cases."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import field

from vireport.base.records import ResultsBlock
from vireport.study.provenance import Provenance
from vireport.study.result_records import ADDED, AddedBlocks
from vireport.verify.rows import CaseOutcome, CaseVerdict


class AccuracyFile(ResultsBlock, frozen=True, kw_only=True):
    """The file accuracy.json.

    Attributes
    ----------
    scenario_sha256
        digest of the scenario
    added
        `accuracy`, and `compliant`, [as in results.json](results.md#compliant-membranes)
    provenance
        [as in results.json](results.md)
    """

    scenario_sha256: str
    added: AddedBlocks = field(name=ADDED)
    provenance: Provenance


class CaseData(ResultsBlock, frozen=True, kw_only=True):
    """An extreme case and its outcome.

    Attributes
    ----------
    group, case
        its name
    found
        the answer, the refusal, or what went wrong, in words
    error, bound
        error against 40 digits, and the largest that is allowed; null where the answer is no number
    seconds : s
        time that it took
    verdict
        `passed`, `failed` or `does not apply`
    """

    group: str
    case: str
    found: str
    error: float | None
    bound: float | None
    seconds: float
    verdict: CaseVerdict


def cases_data(outcomes: Sequence[CaseOutcome]) -> list[CaseData]:
    """Each case and its outcome."""
    return [
        CaseData(
            group=row.group,
            case=row.name,
            found=finding.text,
            error=finding.error,
            bound=None if finding.error is None else finding.bound,
            seconds=round(seconds, 3),
            verdict=verdict,
        )
        for row, verdict, finding, seconds in outcomes
    ]
