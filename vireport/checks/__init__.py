"""What the answers are held against: simulation, ball arithmetic, 40 digits, the paper's numbers, and other methods.

Two modules are imported as such, by what needs them: `reference`, which imports mpmath, and `certificates`, which
imports python-flint.
"""

from typing import TYPE_CHECKING

from vireport.base import deferred
from vireport.checks.crosscheck import CrossCheck, MotionCount, crosscheck, is_one_to_one
from vireport.checks.hysteresis import Hysteresis
from vireport.checks.paper import PAPER, Agreement, Misprint, PaperComparison, compare_with_paper
from vireport.checks.reproduction import Reproduction, reproduce

if TYPE_CHECKING:
    from vireport.checks.accuracy_tables import measurements, power, ranking, seconds, task_name
    from vireport.checks.methods import (
        CLOSED,
        EXPLICIT,
        METHOD_NAMES,
        PRINTED,
        RK4,
        SIMULATED,
        SIMULATED_TRANSIENT,
        SOLVERS,
        WHOLE,
    )
    from vireport.checks.rootfinding import Floats, find_root
    from vireport.checks.timing import machine, timed_in_turns
    from vireport.checks.workprecision import ACCURACIES, MethodRun, WorkPrecision, accuracy_data, measure
else:
    __getattr__ = deferred(__name__, "timing", "rootfinding", "methods", "workprecision", "accuracy_tables")

__all__ = [
    "ACCURACIES",
    "CLOSED",
    "EXPLICIT",
    "METHOD_NAMES",
    "PAPER",
    "PRINTED",
    "RK4",
    "SIMULATED",
    "SIMULATED_TRANSIENT",
    "SOLVERS",
    "WHOLE",
    "Agreement",
    "CrossCheck",
    "Floats",
    "Hysteresis",
    "MethodRun",
    "Misprint",
    "MotionCount",
    "PaperComparison",
    "Reproduction",
    "WorkPrecision",
    "accuracy_data",
    "compare_with_paper",
    "crosscheck",
    "find_root",
    "is_one_to_one",
    "machine",
    "measure",
    "measurements",
    "power",
    "ranking",
    "reproduce",
    "seconds",
    "task_name",
    "timed_in_turns",
]
