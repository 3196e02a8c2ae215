"""Largest errors of the answers in the catalogue of extreme cases.

python benchmarks/extremes.py
"""

from __future__ import annotations

from record import record

from vireport.verify.catalogue import run_catalogue
from vireport.verify.rows import BOUND, CaseVerdict, as_text


def main() -> None:
    """Print and record the catalogue."""
    outcomes = run_catalogue()
    print(as_text(outcomes, every=True))
    answers = [outcome.found for outcome in outcomes if outcome.found.error is not None]
    usual = [found.error for found in answers if found.bound <= BOUND]
    record(
        "extremes",
        cases=len(outcomes),
        passed=sum(outcome.verdict is CaseVerdict.PASSED for outcome in outcomes),
        usual=len(usual),
        largest_usual_error=max(usual),
        largest_error=max(found.error for found in answers),
    )


if __name__ == "__main__":
    main()
