"""What a study comes to: requirements, alerts and the verdict."""

from vireport.gate.alerts import Alert, AlertCode, Severity, alerts, explanation
from vireport.gate.requirements import Criterion, Remark, assess, unmet
from vireport.gate.verdict import SWEEP_END, Fact, Question, Status, Verdict, capital, range_text, verdict_of

__all__ = [
    "SWEEP_END",
    "Alert",
    "AlertCode",
    "Criterion",
    "Fact",
    "Question",
    "Remark",
    "Severity",
    "Status",
    "Verdict",
    "alerts",
    "assess",
    "capital",
    "explanation",
    "range_text",
    "unmet",
    "verdict_of",
]
