"""What a study comes to: requirements, alerts and the verdict."""

from vireport.gate.alerts import LONG_CONTACT, Alert, alerts, cause_of
from vireport.gate.designs import DISPLACED, RINGS, Designs, extreme, keeps_motion
from vireport.gate.evidence import Criterion, Evidence, Limit, Question
from vireport.gate.impacts import generated, impacts_of
from vireport.gate.requirements import (
    REQUIREMENTS,
    OfMargin,
    OfMotions,
    OfRun,
    OfShaker,
    Requirement,
    assess,
    required,
    unmet,
)
from vireport.gate.verdict import SWEEP_END, Status, Verdict, WordedFact, WordedVerdict, verdict_of

__all__ = [
    "DISPLACED",
    "LONG_CONTACT",
    "REQUIREMENTS",
    "RINGS",
    "SWEEP_END",
    "Alert",
    "Criterion",
    "Designs",
    "Evidence",
    "Limit",
    "OfMargin",
    "OfMotions",
    "OfRun",
    "OfShaker",
    "Question",
    "Requirement",
    "Status",
    "Verdict",
    "WordedFact",
    "WordedVerdict",
    "alerts",
    "assess",
    "cause_of",
    "extreme",
    "generated",
    "impacts_of",
    "keeps_motion",
    "required",
    "unmet",
    "verdict_of",
]
