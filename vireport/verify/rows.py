"""A row of the table of extreme cases, what comes of it when it is run, and the outcomes as text."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from enum import StrEnum
from textwrap import shorten
from time import perf_counter
from typing import NamedTuple, cast

from vireport.base.errors import NumericalError, VireportError
from vireport.study.judging.opening import Opening, Statement
from vireport.study.judging.verdict import Status
from vireport.text.formatting import ROUGHLY, rounded_text
from vireport.text.said import words_of

_said = words_of("verify")

BOUND = 1e-11
"""Relative error that an answer may have where nothing is degenerate; most stay below 1e-13."""

LONGEST_CELL = 190
"""Characters of what was found that a line shows: of a refusal the reason, not all that it says; JSON has all."""


class CaseFinding(NamedTuple):
    """The answer in words, and its error against 40 digits with the bound on it; None for an invariant."""

    text: str
    error: float | None = None
    bound: float = BOUND


class WrongAnswerError(Exception):
    """An answer that is wrong otherwise than by the size of an error."""


class NotThereError(Exception):
    """The device has no such point: the case does not apply to it."""


class Case(NamedTuple):
    """An extreme case with the check that it must pass.

    Attributes
    ----------
    group, name : str
    check : callable
        Asks the package for an answer and checks it against something from outside: 40-digit arithmetic, or a number
        known beforehand.
    refusal : str
        Where a refusal is right: what its reason must name, as a regular expression.
    answer : bool
        Whether an answer is right.
    """

    group: str
    name: str
    check: Callable[[], CaseFinding]
    refusal: str = ""
    answer: bool = True

    @property
    def title(self) -> str:
        """Group and name of the case, as it is listed."""
        return f"{self.group}: {self.name}"


class CaseVerdict(StrEnum):
    """The verdicts on a case: passed, failed, or does not apply to the device."""

    PASSED = "passed"
    FAILED = "failed"
    DOES_NOT_APPLY = "does not apply"


class CaseOutcome(NamedTuple):
    """A case with its verdict and what was found: an answer, a refusal, or what went wrong; and the time it took."""

    row: Case
    verdict: CaseVerdict
    finding: CaseFinding
    seconds: float = 0.0


def run(row: Case) -> CaseOutcome:
    """Run a case, with every warning an error. No time decides: it is that of the machine, and of what else it does."""
    start = perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            finding = row.check()
        verdict = CaseVerdict.PASSED if row.answer and (finding.error or 0.0) <= finding.bound else CaseVerdict.FAILED
    except NotThereError as absent:
        finding, verdict = CaseFinding(str(absent)), CaseVerdict.DOES_NOT_APPLY
    except VireportError as refusal:
        finding = CaseFinding(f"refused: {' '.join(str(refusal).split())}")
        verdict = CaseVerdict.PASSED if row.refusal and re.search(row.refusal, finding.text) else CaseVerdict.FAILED
    except Exception as fault:
        # Whatever it is, it is the finding: a table that stops at the first fault would not show the next.
        finding, verdict = CaseFinding(f"{type(fault).__name__}: {fault}"), CaseVerdict.FAILED
    return CaseOutcome(row, verdict, finding, perf_counter() - start)


def exit_status(outcomes: Sequence[CaseOutcome]) -> tuple[int, str]:
    """Exit code, and what keeps the cases from having passed."""
    verdicts = [outcome.verdict for outcome in outcomes]
    if failed := verdicts.count(CaseVerdict.FAILED):
        return 1, f"{failed} of {len(verdicts)} cases failed"
    if CaseVerdict.PASSED not in verdicts:
        return NumericalError.exit_code, "no case applies to this device"
    return 0, ""


def opening_of_cases(outcomes: Sequence[CaseOutcome]) -> Opening:
    """Choose what is said of the cases: whether all that apply pass, how many there are, the worst error, the time."""
    applying = [outcome for outcome in outcomes if outcome.verdict is not CaseVerdict.DOES_NOT_APPLY]
    failed = sum(outcome.verdict is CaseVerdict.FAILED for outcome in applying)
    if not applying:
        return Opening(Status.BAD, _said("word_none"), _said("none_applies"))
    status = Status.BAD if failed else Status.GOOD
    word, name = ("word_fail", "some_fail") if failed else ("word_pass", "all_pass")
    counts = (failed, len(applying)) if failed else (len(applying),)
    absent = len(outcomes) - len(applying)
    facts = (Statement(Status.NEUTRAL, _said("absent", absent)),) if absent else ()
    return Opening(status, _said(word), _said(name, *counts), facts, tuple(_tiles(applying)))


def _tiles(applying: Sequence[CaseOutcome]) -> Iterator[Statement]:
    answers = [outcome for outcome in applying if outcome.finding.error is not None]
    yield Statement(Status.NEUTRAL, _said("tile_cases", len(answers), len(applying) - len(answers)))
    # Where cases have other bounds, that which comes nearest to its own.
    worst = max(answers, key=lambda outcome: cast(float, outcome.finding.error) / outcome.finding.bound, default=None)
    if worst is not None:
        status = Status.BAD if worst.verdict is CaseVerdict.FAILED else Status.GOOD
        yield Statement(status, _said("tile_worst_case", worst.finding.error, worst.finding.bound, worst.row.title))
    yield Statement(Status.NEUTRAL, _said("tile_seconds", sum(outcome.seconds for outcome in applying)))


def as_text(outcomes: Sequence[CaseOutcome], every: bool = False) -> str:
    """The cases that failed, or every one, with a line each; then what is said of them together."""
    lines = []
    for row, verdict, finding, _ in outcomes:
        if every or verdict is CaseVerdict.FAILED:
            error = ""
            if finding.error is not None:
                error = (
                    f", error {rounded_text(finding.error, ROUGHLY)}, allowed {rounded_text(finding.bound, ROUGHLY)}"
                )
            mark = verdict.upper() if verdict is CaseVerdict.FAILED else verdict
            lines.append(f"{mark}  {row.title}: {shorten(finding.text, LONGEST_CELL, placeholder=' ...')}{error}")
    lines += [""] if lines else []
    return "\n".join((*lines, *opening_of_cases(outcomes).worded().lines)) + "\n"
