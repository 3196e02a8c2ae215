"""What a study comes to: requirements, alerts and the verdict."""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.gate.alerts import (
    LONG_CONTACT,
    NEAR_CRITICAL,
    Alert,
    alerts,
    cause_of,
    input_alerts,
    named_alerts,
    record_alerts,
)
from vireport.gate.evidence import Criterion, Evidence, Limit, Question, unmet
from vireport.gate.stretch import STATED_FIELD_V_M

if TYPE_CHECKING:
    from vireport.gate.designs import DISPLACED, RINGS, Designs, extreme, keeps_motion
    from vireport.gate.impacts import generated, impacts_of
    from vireport.gate.least_margin import margin_to_use
    from vireport.gate.opening import (
        Opening,
        OpeningFact,
        Said,
        WordedOpening,
        gravest,
        margin_said,
        opening_of,
    )
    from vireport.gate.requirements import (
        REQUIREMENTS,
        OfMargin,
        OfMotions,
        OfRun,
        OfShaker,
        Requirement,
        assess,
        required,
        spared,
    )
    from vireport.gate.verdict import Conclusion, Status, Verdict, verdict_of
else:
    __getattr__ = deferred(__name__, "least_margin", "impacts", "designs", "verdict", "opening", "requirements")

__all__ = [
    "DISPLACED",
    "LONG_CONTACT",
    "NEAR_CRITICAL",
    "REQUIREMENTS",
    "RINGS",
    "STATED_FIELD_V_M",
    "Alert",
    "Conclusion",
    "Criterion",
    "Designs",
    "Evidence",
    "Limit",
    "OfMargin",
    "OfMotions",
    "OfRun",
    "OfShaker",
    "Opening",
    "OpeningFact",
    "Question",
    "Requirement",
    "Said",
    "Status",
    "Verdict",
    "WordedOpening",
    "alerts",
    "assess",
    "cause_of",
    "extreme",
    "generated",
    "gravest",
    "impacts_of",
    "input_alerts",
    "keeps_motion",
    "margin_said",
    "margin_to_use",
    "named_alerts",
    "opening_of",
    "record_alerts",
    "required",
    "spared",
    "unmet",
    "verdict_of",
]
