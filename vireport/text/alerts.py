"""Alerts by their codes; all their words are in `words/alerts.json`: what they mean, what to do, and what raises them.

`vireport.study.judging` finds where they are raised, and the numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from enum import StrEnum
from textwrap import fill
from typing import NamedTuple

from msgspec import Struct

from vireport.base.errors import UsageError
from vireport.text.patterns import Phrase
from vireport.text.terms import TERMS

FILE = "alerts"
"""The file of patterns."""

EXPLANATION_WIDTH = 100
"""Columns of a line of explanation."""


class AlertCode(StrEnum):
    """What alerts are known by, outside of this package too."""

    NO_STABLE_MOTION = "VR001"
    INADMISSIBLE_SOLUTIONS = "VR002"
    DESIGN_NOT_STABLE = "VR003"
    SEVERAL_STABLE_MOTIONS = "VR004"
    NEAR_CRITICAL_POINT = "VR005"
    ROUGH_CRITICAL_POINT = "VR006"
    NEAR_GRAZING = "VR007"
    ILL_CONDITIONED = "VR008"
    SENSITIVE_TO_RESTITUTION = "VR009"
    DEEP_DEFLECTION = "VR010"
    LONG_CONTACT = "VR011"
    SENSITIVE_TO_BALL_MASS = "VR012"
    NOT_RIGID = "VR013"
    ADMISSIBILITY_UNDECIDED = "VR014"
    IMPLAUSIBLE_INPUT = "VR015"
    BREAKDOWN = "VR016"
    MORE_ENERGY_THAN_LOST = "VR017"
    RECORD_DOUBTFUL = "VR018"
    SIMULATION_DISAGREES = "VR020"
    COEXISTING_MOTIONS = "VR021"
    CHATTER = "VR022"


class Severity(StrEnum):
    """Whether the numbers cannot be, whether a reader should not act on them as they are, or what else they tell.

    With an error no verdict is good.
    """

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"

    @property
    def rank(self) -> int:
        """Place among all alerts, the gravest first."""
        return list(Severity).index(self)


class Sentence(NamedTuple):
    """A sentence on what raises an alert: the name of its pattern, after the alert's code, and what it takes.

    A list of sentences is printed with the format of its place between them.
    """

    name: str
    values: Mapping[str, object] = {}


class Explanation(Struct, frozen=True, eq=False):
    """What an alert is known by, how grave it is, and its words.

    `severity` is that of the alert, unless one of its sentences is `milder`.
    """

    code: AlertCode
    severity: Severity
    milder: Mapping[str, Severity] = {}

    @property
    def title(self) -> Phrase:
        """Title of the alert, as pages have it."""
        return self._said(Sentence("title"))

    @property
    def meaning(self) -> Phrase:
        """Why the alert matters, in a sentence."""
        return self._said(Sentence("meaning"))

    @property
    def remedy(self) -> Phrase:
        """What to do about the alert."""
        return self._said(Sentence("remedy"))

    @property
    def severities(self) -> str:
        """All that it may have, the mildest first."""
        return " or ".join([*dict.fromkeys(self.milder.values()), self.severity])

    def severity_of(self, sentences: Iterable[Sentence]) -> Severity:
        """The severity of an alert with these sentences."""
        return next((self.milder[name] for name, _ in sentences if name in self.milder), self.severity)

    def cause(self, sentences: Iterable[Sentence]) -> Phrase:
        """What raises it, with its numbers."""
        return Phrase(FILE, "cause", {"sentences": list(map(self._said, sentences))})

    def _said(self, sentence: Sentence) -> Phrase:
        values = {
            name: list(map(self._said, value)) if isinstance(value, list) else value
            for name, value in sentence.values.items()
        }
        return Phrase(FILE, f"{self.code}.{sentence.name}", values)


CATALOGUE = (
    Explanation(AlertCode.NO_STABLE_MOTION, Severity.WARNING),
    Explanation(AlertCode.INADMISSIBLE_SOLUTIONS, Severity.NOTE),
    Explanation(AlertCode.DESIGN_NOT_STABLE, Severity.WARNING),
    Explanation(AlertCode.SEVERAL_STABLE_MOTIONS, Severity.NOTE),
    Explanation(AlertCode.NEAR_CRITICAL_POINT, Severity.WARNING),
    Explanation(AlertCode.ROUGH_CRITICAL_POINT, Severity.WARNING),
    Explanation(AlertCode.NEAR_GRAZING, Severity.WARNING),
    Explanation(AlertCode.ILL_CONDITIONED, Severity.WARNING),
    Explanation(AlertCode.SENSITIVE_TO_RESTITUTION, Severity.WARNING),
    Explanation(AlertCode.DEEP_DEFLECTION, Severity.WARNING, {"deep": Severity.NOTE}),
    Explanation(AlertCode.LONG_CONTACT, Severity.WARNING),
    Explanation(AlertCode.SENSITIVE_TO_BALL_MASS, Severity.NOTE),
    Explanation(AlertCode.NOT_RIGID, Severity.WARNING),
    Explanation(AlertCode.ADMISSIBILITY_UNDECIDED, Severity.WARNING),
    Explanation(AlertCode.IMPLAUSIBLE_INPUT, Severity.WARNING),
    Explanation(AlertCode.BREAKDOWN, Severity.ERROR),
    Explanation(AlertCode.MORE_ENERGY_THAN_LOST, Severity.ERROR),
    Explanation(AlertCode.RECORD_DOUBTFUL, Severity.WARNING),
    Explanation(AlertCode.SIMULATION_DISAGREES, Severity.WARNING),
    Explanation(AlertCode.COEXISTING_MOTIONS, Severity.NOTE),
    Explanation(AlertCode.CHATTER, Severity.NOTE),
)
"""All alerts, in the order of their codes."""


def explanation(code: str | None = None) -> str:
    """Text on one alert or one term, or on all alerts.

    Raises
    ------
    UsageError
        If there is neither such a code nor such a term.
    """
    if code is None:
        return "\n".join(map(_explained, CATALOGUE))
    entry = next((entry for entry in CATALOGUE if entry.code == code.strip().upper()), None)
    if entry is not None:
        return _explained(entry)
    words = " ".join(code.lower().replace("-", " ").replace("_", " ").split())
    term = next((term for term in TERMS if term.lower().replace("_", " ") == words), None)
    if term is None:
        number = re.fullmatch(r"(?:vr)?0*(\d{1,3})", words.replace(" ", ""))
        close = [f"VR{int(number[1]):03}"] if number else get_close_matches(words, TERMS, 1)
        if close and close[0] in (*AlertCode, *TERMS):
            raise UsageError(f"there is no alert and no term {code!r}; did you mean '{close[0]}'?")
        allowed = ", ".join([*AlertCode, *TERMS])
        raise UsageError(f"there is no alert and no term {code!r} (allowed: {allowed})")
    return f"{term}\n{fill(TERMS[term], EXPLANATION_WIDTH, initial_indent='  ', subsequent_indent='  ')}\n"


def _explained(entry: Explanation) -> str:
    paragraphs = (f"Cause: {entry.meaning}", f"Remedy: {entry.remedy}")
    lines = [fill(text, EXPLANATION_WIDTH, initial_indent="  ", subsequent_indent="  ") for text in paragraphs]
    return "\n".join([f"{entry.code} ({entry.severities}): {entry.title}", *lines, ""])
