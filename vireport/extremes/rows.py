"""A row of the table of extreme cases, and what comes of it when it is run."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from enum import StrEnum
from importlib.util import find_spec
from time import perf_counter
from typing import Any, NamedTuple

from vireport.base.errors import VireportError, install_command

BOUND = 1e-11
"""Relative error that an answer may have where nothing is degenerate; most stay below 1e-13."""


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
    """An extreme case.

    Attributes
    ----------
    group, name : str
    check : callable
        Asks the package for an answer and checks it against something from outside: 40-digit arithmetic, or a number
        known beforehand.
    of : tuple
        What `check` is called with.
    refusal : str
        Where a refusal is right: what its reason must name, as a regular expression.
    answer : bool
        Whether an answer is right.
    simulated : bool
        Whether it takes compiled code.
    """

    group: str
    name: str
    check: Callable[..., CaseFinding]
    of: tuple[Any, ...] = ()
    refusal: str = ""
    answer: bool = True
    simulated: bool = False

    @property
    def title(self) -> str:
        """Group and name."""
        return f"{self.group}: {self.name}"


class CaseVerdict(StrEnum):
    """The verdicts on a case: passed, failed, does not apply to the device, or left out."""

    PASSED = "passed"
    FAILED = "failed"
    DOES_NOT_APPLY = "does not apply"
    LEFT_OUT = "left out"


class CaseOutcome(NamedTuple):
    """A case with its verdict and what was found: an answer, a refusal, or what went wrong; and the time it took."""

    row: Case
    verdict: CaseVerdict
    found: CaseFinding
    seconds: float = 0.0


def run(row: Case) -> CaseOutcome:
    """Run a case, with every warning an error. No time decides: it is that of the machine, and of what else it does."""
    if row.simulated and find_spec("numba") is None:
        return CaseOutcome(row, CaseVerdict.LEFT_OUT, CaseFinding(f"needs numba: {install_command('numba')}"))
    start = perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = row.check(*row.of)
        verdict = CaseVerdict.PASSED if row.answer and (found.error or 0.0) <= found.bound else CaseVerdict.FAILED
    except NotThereError as absent:
        found, verdict = CaseFinding(str(absent)), CaseVerdict.DOES_NOT_APPLY
    except VireportError as refusal:
        found = CaseFinding(f"refused: {' '.join(str(refusal).split())}")
        verdict = CaseVerdict.PASSED if row.refusal and re.search(row.refusal, found.text) else CaseVerdict.FAILED
    except Exception as fault:
        # Whatever it is, it is the finding: a table that stops at the first fault would not show the next.
        found, verdict = CaseFinding(f"{type(fault).__name__}: {fault}"), CaseVerdict.FAILED
    return CaseOutcome(row, verdict, found, perf_counter() - start)
