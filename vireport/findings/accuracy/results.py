"""Error against run time as records of results.json and accuracy.json."""

from __future__ import annotations

from vireport.base.records import ResultsBlock
from vireport.base.timing import Machine
from vireport.findings.accuracy.benchmark import MeasuredQuantity
from vireport.findings.accuracy.workprecision import MethodRun, Order, UntriedMethod, WorkPrecision


class AccuracyData(ResultsBlock, frozen=True, kw_only=True):
    """Errors and times of every method and setting. Times differ from run to run; nothing else does.

    Attributes
    ----------
    nothing
        why nothing can be compared; else null
    value : as in the scenario
        the swept parameter, where the motion is; null where nothing can be compared
    repeats
        samples of each time
    unsteadiness : 1
        distance of the quartiles of a time over its median, that of the middle run; null where none was repeated
    busy
        whether the machine did something else while times were taken
    machine
        that of the measurement
    quantities
        what the methods are to find
    runs
        each method with each setting
    orders
        fitted orders of convergence
    left_out
        methods that could not be tried
    """

    nothing: str | None
    value: float | None
    repeats: int
    unsteadiness: float | None
    busy: bool
    machine: Machine
    quantities: tuple[MeasuredQuantity, ...]
    runs: tuple[MethodRun, ...]
    orders: tuple[Order, ...]
    left_out: tuple[UntriedMethod, ...]


def accuracy_data(work: WorkPrecision) -> AccuracyData:
    """Errors and times of every method and setting."""
    return AccuracyData(
        nothing=work.nothing or None,
        value=work.benchmark.value if work.benchmark is not None else None,
        repeats=work.repeats,
        unsteadiness=work.unsteadiness,
        busy=work.busy,
        machine=work.machine,
        quantities=work.quantities,
        runs=work.runs,
        orders=work.orders,
        left_out=work.absent,
    )
