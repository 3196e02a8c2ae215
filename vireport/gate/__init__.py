"""What a study comes to: requirements, alerts and the verdict."""

from vireport.gate.alerts import Alert, alerts, cause_of, longest_contact
from vireport.gate.requirements import MARGINS, Criterion, Evidence, Question, assess, unmet
from vireport.gate.verdict import SWEEP_END, Verdict, WordedFact, WordedVerdict, verdict_of

__all__ = [
    "MARGINS",
    "SWEEP_END",
    "Alert",
    "Criterion",
    "Evidence",
    "Question",
    "Verdict",
    "WordedFact",
    "WordedVerdict",
    "alerts",
    "assess",
    "cause_of",
    "longest_contact",
    "unmet",
    "verdict_of",
]
