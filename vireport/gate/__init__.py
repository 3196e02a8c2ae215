"""What a study comes to: requirements, alerts and the verdict."""

from vireport.gate.alerts import Alert, alerts, longest_contact
from vireport.gate.requirements import MARGINS, Criterion, Evidence, Question, assess, unmet
from vireport.gate.verdict import SWEEP_END, Fact, Verdict, mirror_images, range_text, verdict_of

__all__ = [
    "MARGINS",
    "SWEEP_END",
    "Alert",
    "Criterion",
    "Evidence",
    "Fact",
    "Question",
    "Verdict",
    "alerts",
    "assess",
    "longest_contact",
    "mirror_images",
    "range_text",
    "unmet",
    "verdict_of",
]
