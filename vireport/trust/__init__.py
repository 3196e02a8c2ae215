"""The analytic answer held against simulation, other methods and compliant membranes."""

from vireport.trust.accuracy_text import (
    COLUMNS,
    about_times,
    broken,
    factor_head,
    factor_rows,
    failure_rows,
    order_rows,
    plain,
    power,
    reference_rows,
    seconds,
    setup,
    summary_rows,
    task_name,
    verdicts,
    without_guess,
)
from vireport.trust.compliance import (
    FAIR_MARGIN,
    GOOD_MARGIN,
    GRADES,
    Compliance,
    Convergence,
    Rigid,
    Rung,
    phase_shift,
)
from vireport.trust.compliant import TOLERANCE
from vireport.trust.compliant_orbits import CompliantOrbit
from vireport.trust.contenders import CLOSED, EXPLICIT, NAMES, PRINTED, RK4, SETTLING, SIMULATED, WHOLE
from vireport.trust.crosscheck import CrossCheck, crosscheck, is_one_to_one
from vireport.trust.findings import factor_text, findings, setting_text
from vireport.trust.paper import ComparedRow, Comparison, comparison
from vireport.trust.paper_cases import PAPER
from vireport.trust.penalty import ADAPTIVE, FIXED, WRONG, Outcome, SolverRun
from vireport.trust.stiffness import compliance
from vireport.trust.workprecision import ACCURACIES, MethodRun, WorkPrecision, measure

__all__ = [
    "ACCURACIES",
    "ADAPTIVE",
    "CLOSED",
    "COLUMNS",
    "EXPLICIT",
    "FAIR_MARGIN",
    "FIXED",
    "GOOD_MARGIN",
    "GRADES",
    "NAMES",
    "PAPER",
    "PRINTED",
    "RK4",
    "SETTLING",
    "SIMULATED",
    "TOLERANCE",
    "WHOLE",
    "WRONG",
    "ComparedRow",
    "Comparison",
    "Compliance",
    "CompliantOrbit",
    "Convergence",
    "CrossCheck",
    "MethodRun",
    "Outcome",
    "Rigid",
    "Rung",
    "SolverRun",
    "WorkPrecision",
    "about_times",
    "broken",
    "comparison",
    "compliance",
    "crosscheck",
    "factor_head",
    "factor_rows",
    "factor_text",
    "failure_rows",
    "findings",
    "is_one_to_one",
    "measure",
    "order_rows",
    "phase_shift",
    "plain",
    "power",
    "reference_rows",
    "seconds",
    "setting_text",
    "setup",
    "summary_rows",
    "task_name",
    "verdicts",
    "without_guess",
]
