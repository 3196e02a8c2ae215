"""What a study comes to: requirements, alerts and the verdict."""

from vireport.gate.alerts import Alert, alerts
from vireport.gate.criteria import Criterion, unmet
from vireport.gate.explanations import explanation
from vireport.gate.requirements import assess
from vireport.gate.verdict import Fact, Verdict, verdict_of
from vireport.gate.wording import SWEEP_END, capital, range_text

__all__ = [
    "SWEEP_END",
    "Alert",
    "Criterion",
    "Fact",
    "Verdict",
    "alerts",
    "assess",
    "capital",
    "explanation",
    "range_text",
    "unmet",
    "verdict_of",
]
