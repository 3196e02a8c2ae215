"""How far the rigid model is from compliant membranes: a ladder of stiffnesses, and solvers on the stiff equations."""

from vireport.membranes.compliance import Compliance, Grade, compliance, compliance_data
from vireport.membranes.compliance_tables import (
    Findings,
    comparison_with_rigid,
    findings,
    lost,
    quantity_label,
    solvers_on_stiff_membranes,
    verdict,
)
from vireport.membranes.stiff_solvers import FIXED, WRONG, RunOutcome, SolverRun

__all__ = [
    "FIXED",
    "WRONG",
    "Compliance",
    "Findings",
    "Grade",
    "RunOutcome",
    "SolverRun",
    "comparison_with_rigid",
    "compliance",
    "compliance_data",
    "findings",
    "lost",
    "quantity_label",
    "solvers_on_stiff_membranes",
    "verdict",
]
