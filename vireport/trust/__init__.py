"""The analytic answer held against simulation, other methods and compliant membranes."""

from vireport.trust.accuracy_tables import measurements, power, ranking, seconds, task_name
from vireport.trust.compliance import Compliance, Grade, compliance, compliance_data
from vireport.trust.compliance_tables import (
    Findings,
    comparison_with_rigid,
    factor_text,
    findings,
    lost,
    quantity_label,
    solvers_on_stiff_membranes,
    verdict,
)
from vireport.trust.crosscheck import CrossCheck, MotionCount, crosscheck, is_one_to_one
from vireport.trust.hysteresis import Hysteresis
from vireport.trust.methods import CLOSED, EXPLICIT, NAMES, PRINTED, RK4, SETTLING, SIMULATED, WHOLE
from vireport.trust.paper import PAPER, PaperComparison, compare_with_paper
from vireport.trust.reproduction import Reproduction, reproduce
from vireport.trust.stiff_solvers import ADAPTIVE, FIXED, WRONG, Outcome, SolverRun
from vireport.trust.workprecision import ACCURACIES, MethodRun, WorkPrecision, accuracy_data, measure

__all__ = [
    "ACCURACIES",
    "ADAPTIVE",
    "CLOSED",
    "EXPLICIT",
    "FIXED",
    "NAMES",
    "PAPER",
    "PRINTED",
    "RK4",
    "SETTLING",
    "SIMULATED",
    "WHOLE",
    "WRONG",
    "Compliance",
    "CrossCheck",
    "Findings",
    "Grade",
    "Hysteresis",
    "MethodRun",
    "MotionCount",
    "Outcome",
    "PaperComparison",
    "Reproduction",
    "SolverRun",
    "WorkPrecision",
    "accuracy_data",
    "compare_with_paper",
    "comparison_with_rigid",
    "compliance",
    "compliance_data",
    "crosscheck",
    "factor_text",
    "findings",
    "is_one_to_one",
    "lost",
    "measure",
    "measurements",
    "power",
    "quantity_label",
    "ranking",
    "reproduce",
    "seconds",
    "solvers_on_stiff_membranes",
    "task_name",
    "verdict",
]
