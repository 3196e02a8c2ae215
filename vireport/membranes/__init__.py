"""Membranes with their own stiffness: the motion with long contacts, and the stiff equations of it."""

from vireport.membranes.compliance import Compliance, Grade, compliance, compliance_data
from vireport.membranes.compliance_tables import (
    Findings,
    comparison_with_rigid,
    factor_text,
    findings,
    lost,
    quantity_label,
    solvers_on_stiff_membranes,
    verdict,
)
from vireport.membranes.own_stiffness import (
    OwnStiffness,
    StabilityEnd,
    own_stiffness,
    own_stiffness_data,
)
from vireport.membranes.stiff_solvers import ADAPTIVE, FIXED, WRONG, RunOutcome, SolverRun

__all__ = [
    "ADAPTIVE",
    "FIXED",
    "WRONG",
    "Compliance",
    "Findings",
    "Grade",
    "OwnStiffness",
    "RunOutcome",
    "SolverRun",
    "StabilityEnd",
    "comparison_with_rigid",
    "compliance",
    "compliance_data",
    "factor_text",
    "findings",
    "lost",
    "own_stiffness",
    "own_stiffness_data",
    "quantity_label",
    "solvers_on_stiff_membranes",
    "verdict",
]
