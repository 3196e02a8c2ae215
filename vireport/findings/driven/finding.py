"""What a recorded motion of the shaker brings to a study: what the device does under it, and what is predicted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vireport.base.progress import Progress
from vireport.study.finding import AddedFinding
from vireport.study.judging.alerts import doubted
from vireport.study.plan import DESIGN, OUTPUT, PICTURES, AddedTask, DeclaredStep, Precondition
from vireport.text.alerts import AlertCode, Sentence

if TYPE_CHECKING:
    from vireport.findings.driven.driven import Driven
    from vireport.study.judging.evidence import Evidence
    from vireport.study.judging.verdict import AddedAnswer
    from vireport.study.result_records import AddedBlocks
    from vireport.study.study import Study

FIGURE = "figure-driven"


class DrivenFinding(AddedFinding["Driven"]):
    """A recorded motion of the shaker, driven through the device, as an addition to a study."""

    name = "driven"
    section = "sections/driven.typ.j2"

    def steps(self) -> Iterator[DeclaredStep]:
        """The device under the record, and its figure; both are listed where there is a record."""
        why = "excitation.record is given"
        record = Precondition(lambda scenario, _: scenario.excitation.record, "excitation.record is not given")
        what = "the recorded acceleration of the shaker driven through the device, from impact to impact"
        yield DeclaredStep(AddedTask(self.name, what), (DESIGN, OUTPUT), why, (record,))
        drawn = AddedTask(FIGURE, "impacts under the recorded acceleration of the shaker (figure-driven)")
        yield DeclaredStep(drawn, (DESIGN, PICTURES), why, (record,))

    def find(self, study: Study, say: Progress) -> Driven:
        """Drive the device with the record."""
        from vireport.findings.driven.driven import driven_by

        return driven_by(study.loaded, study.solution.device, study.solution.membrane, say)

    def results(self, driven: Driven | None, study: Study) -> AddedBlocks:
        """The block `driven` of results.json, where there is a record."""
        if driven is None:
            return {}
        from vireport.findings.driven.results import driven_data

        return {self.name: driven_data(driven)}

    def answers(self, driven: Driven, evidence: Evidence) -> Iterator[AddedAnswer[Driven]]:
        """The answer that a doubtful record speaks against the device; none where the record raises no doubt."""
        from vireport.study.judging.verdict import AddedAnswer, AddedConclusion, Status, Weight

        if not driven.doubts:
            return
        word = "Stable, but the record of the shaker is doubtful"
        concludes = AddedConclusion("RECORD_DOUBTFUL", Status.CAUTION, word, Weight.DIGITS, self.name)
        question = "Is the record of the shaker right?"
        yield AddedAnswer(question, Status.CAUTION, driven, name=self.name, concludes=concludes)

    def causes(self, driven: Driven, evidence: Evidence) -> Mapping[AlertCode, Iterable[Sentence]]:
        """What may be wrong with the record."""
        return {AlertCode.RECORD_DOUBTFUL: map(doubted, driven.doubts)}

    def pictures(self, driven: Driven, study: Study, templates: Path | None) -> Iterator[Any]:
        """The impacts along the record."""
        drawn = study.plan.running(FIGURE)
        if drawn is not None:
            from vireport.findings.driven.figure import picture

            yield picture(driven, drawn, templates)


FINDING = DrivenFinding()
