"""What a measurement of methods brings to a study: their errors against 40 digits, and their run times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vireport.base.errors import install_command
from vireport.base.progress import Progress
from vireport.findings.accuracy.keys import AccuracyBlock
from vireport.scenario.keys import block_of
from vireport.study.finding import AddedFinding
from vireport.study.plan import MPMATH, NUMBA, PICTURES, AddedTask, DeclaredStep, Task, has_block, simulation_compiles

if TYPE_CHECKING:
    from vireport.findings.accuracy.workprecision import WorkPrecision
    from vireport.scenario.blocks import Scenario
    from vireport.study.result_records import AddedBlocks
    from vireport.study.study import Study

STEP = "accuracy"
"""The block of a scenario that asks for it, the step, and the key of results.json."""

FIGURE = "figure-accuracy"

FEWER = "without some of the methods"
"""What the measurement is without the package that compiles the simulation."""


class ChecksFinding(AddedFinding["WorkPrecision"]):
    """Error against run time of several methods as an addition to a study."""

    name = "checks"
    section = "sections/accuracy.typ.j2"
    within = "appendix"

    def steps(self) -> Iterator[DeclaredStep]:
        """The measurement, and its figure."""
        block, why = has_block(STEP), "the scenario has an accuracy block"
        measured = AddedTask(STEP, "error against run time of several methods")

        def costs(scenario: Scenario) -> str:
            lacking = "" if simulation_compiles() else f", without those that need numba: {install_command('numba')}"
            return f"{measured.what}: about a minute{lacking}"

        yield DeclaredStep(measured, (block, MPMATH), why, (), NUMBA, FEWER, costs, before=Task.OWN_STIFFNESS)
        drawn = AddedTask(FIGURE, "work-precision diagram")
        yield DeclaredStep(drawn, (MPMATH, PICTURES), why, (block,), before=Task.FIGURE_DIAGRAM)

    def find(self, study: Study, say: Progress) -> WorkPrecision:
        """Try every method on the motion and the critical point of the scenario."""
        from vireport.findings.accuracy.workprecision import measure

        block = block_of(study.scenario, "accuracy", AccuracyBlock)
        assert block is not None
        return measure(study.solution, block.repeats, say)

    def results(self, measured_errors: WorkPrecision | None, study: Study) -> AddedBlocks:
        """The block `accuracy` of results.json; null where it was not computed."""
        if measured_errors is None:
            return {STEP: None}
        from vireport.findings.accuracy.results import accuracy_data

        return {STEP: accuracy_data(measured_errors)}

    def pictures(self, measured_errors: WorkPrecision, study: Study, templates: Path | None) -> Iterator[Any]:
        """Errors over run times, where there is something to compare."""
        drawn = study.plan.running(FIGURE)
        if drawn is not None and measured_errors.quantities:
            from vireport.findings.accuracy.figure import picture

            yield picture(measured_errors, drawn, templates)

    def parts(self, measured_errors: WorkPrecision, templates: Path | None) -> Mapping[str, object]:
        """What each method reaches, and which is the fastest."""
        from vireport.findings.accuracy.tables import measurements, ranking

        return {
            "measurements": list(measurements(measured_errors, templates=templates)),
            "fastest": list(ranking(measured_errors, templates)),
        }


FINDING = ChecksFinding()
