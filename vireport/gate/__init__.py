"""What a study comes to: requirements, alerts and the verdict."""

from vireport.gate.alerts import Alert, alerts, longest_contact
from vireport.gate.designs import DISPLACED, RINGS, Designs, extreme, keeps_motion
from vireport.gate.evidence import Criterion, Evidence, Judgement, Limit, Question
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
from vireport.gate.verdict import SWEEP_END, Fact, Verdict, mirror_images, range_text, verdict_of

__all__ = [
    "DISPLACED",
    "REQUIREMENTS",
    "RINGS",
    "SWEEP_END",
    "Alert",
    "Criterion",
    "Designs",
    "Evidence",
    "Fact",
    "Judgement",
    "Limit",
    "OfMargin",
    "OfMotions",
    "OfRun",
    "OfShaker",
    "Question",
    "Requirement",
    "Verdict",
    "alerts",
    "assess",
    "extreme",
    "generated",
    "impacts_of",
    "keeps_motion",
    "longest_contact",
    "mirror_images",
    "range_text",
    "required",
    "unmet",
    "verdict_of",
]
