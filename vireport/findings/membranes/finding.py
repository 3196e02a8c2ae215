"""What compliant membranes bring to a study: whether rigid impacts are a good model, and how solvers do on them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vireport.base.progress import Progress
from vireport.scenario.keys import value_at
from vireport.study.finding import AddedFinding
from vireport.study.plan import BALL, PICTURES, AddedTask, DeclaredStep, Precondition, Task, has_block
from vireport.text.alerts import AlertCode, Sentence

if TYPE_CHECKING:
    from vireport.findings.membranes.compliance import Compliance
    from vireport.study.judging.evidence import Evidence
    from vireport.study.judging.verdict import AddedAnswer
    from vireport.study.result_records import AddedBlocks
    from vireport.study.study import Study

FIGURE = "figure-stiffness"
RESULTS = "compliant"
"""The step, and the key of results.json."""


class MembranesFinding(AddedFinding["Compliance"]):
    """The ladder of stiffnesses and stiff solvers as an addition to a study."""

    name = "membranes"
    section = "sections/compliant.typ.j2"
    within = "appendix"

    def steps(self) -> Iterator[DeclaredStep]:
        """The steps of a run: the motion with compliant membranes, and its figure."""
        compliant = Precondition(
            lambda scenario, _: value_at(scenario, "accuracy.compliant_membrane"),
            "accuracy.compliant_membrane is false",
        )
        accuracy, why = has_block("accuracy"), "the scenario has an accuracy block"
        solved = AddedTask(RESULTS, "the motion with compliant membranes, and solvers on stiff ones")
        yield DeclaredStep(
            solved,
            (accuracy, compliant, BALL),
            why,
            costs=lambda _: f"{solved.what}: some ten seconds",
            before=Task.OWN_STIFFNESS,
        )
        drawn = AddedTask(FIGURE, "solvers on stiff membranes")
        yield DeclaredStep(drawn, (compliant, PICTURES), why, (accuracy, BALL), before=Task.FIGURE_DIAGRAM)

    def find(self, study: Study, say: Progress) -> Compliance:
        """Follow the motion from rigid membranes to the scenario's own, and try solvers on the way."""
        from vireport.findings.membranes.compliance import compliance

        ladder, repeats = (value_at(study.scenario, f"accuracy.{key}") for key in ("ladder", "repeats"))
        return compliance(study.solution, ladder, repeats, say)

    def contradicts_rigid_impacts(self, compliance: Compliance) -> bool:
        """Whether the rigid model is not good enough."""
        return compliance.grade is not None and compliance.grade.contradicts

    def results(self, compliance: Compliance | None, study: Study) -> AddedBlocks:
        """The block `compliant` of results.json; null where it was not computed."""
        if compliance is None:
            return {RESULTS: None}
        from vireport.findings.membranes.results import compliance_data

        return {RESULTS: compliance_data(compliance)}

    def answers(self, compliance: Compliance, evidence: Evidence) -> Iterator[AddedAnswer[Compliance]]:
        """The answer on whether the rigid model is good enough, where there is a comparison."""
        from vireport.study.judging.verdict import AddedAnswer, AddedConclusion, Status, Weight

        if compliance.grade is None:
            return
        status, concludes = (Status.GOOD, Status.CAUTION, Status.BAD)[compliance.grade], None
        if compliance.grade.contradicts:
            word = "Stable, by a rigid model that is not good enough"
            concludes = AddedConclusion("NOT_RIGID", Status.CAUTION, word, Weight.MARGIN, "compliant")
        yield AddedAnswer("Is the rigid model good enough?", status, compliance, name=self.name, concludes=concludes)

    def causes(self, compliance: Compliance, evidence: Evidence) -> Mapping[AlertCode, Iterable[Sentence]]:
        """Causes of alerts: what the real stiffness of the membranes shifts too far, or which motion it ends."""
        from vireport.findings.membranes.compliance import moved_or_lost

        # Without a stable motion the rigid model claims nothing of the device.
        if not evidence.impacts[0].size or not self.contradicts_rigid_impacts(compliance):
            return {}
        return {AlertCode.NOT_RIGID: moved_or_lost(compliance)}

    def pictures(self, compliance: Compliance, study: Study, templates: Path | None) -> Iterator[Any]:
        """The figure of the errors of solvers, and of the rates at which the motion tends to the rigid one."""
        drawn = study.plan.running(FIGURE)
        if drawn is not None and compliance.runs:
            from vireport.findings.membranes.figure import picture

            yield picture(compliance, drawn, templates)

    def parts(self, compliance: Compliance, templates: Path | None) -> Mapping[str, object]:
        """The verdict on the rigid model, tables of shifts and of solvers, and where a motion is lost."""
        from vireport.findings.membranes.tables import comparison_with_rigid, lost, solvers_on_stiff_membranes, verdict

        return {
            "verdict": verdict(compliance, templates),
            "comparison": list(comparison_with_rigid(compliance, templates)),
            "lost": list(lost(compliance, templates)),
            "solvers": list(solvers_on_stiff_membranes(compliance, templates)),
        }


FINDING = MembranesFinding()
