"""What tolerances bring to a study: whether every device within them works, how many do, and the yield required."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from vireport.base.progress import Progress
from vireport.study.finding import AddedFinding
from vireport.study.plan import DESIGN, AddedTask, DeclaredStep, has_block

if TYPE_CHECKING:
    from vireport.findings.tolerances.tolerances import Tolerances
    from vireport.study.judging.evidence import Evidence
    from vireport.study.judging.opening import FactPlace, Statement
    from vireport.study.judging.requirements import Requirement
    from vireport.study.judging.verdict import AddedAnswer, Verdict
    from vireport.study.result_records import AddedBlocks
    from vireport.study.study import Study

QUESTION = "Do all devices within the tolerances work?"


class TolerancesFinding(AddedFinding["Tolerances"]):
    """Tolerances as an addition to a study."""

    name = "tolerances"
    section = "sections/tolerances.typ.j2"
    files = ("worst.yaml",)

    def steps(self) -> Iterator[DeclaredStep]:
        """The step that assesses tolerances; it runs where the scenario has the block and a design point."""
        task = AddedTask(self.name, "whether every device within the tolerances has stable motion, and the yield")
        yield DeclaredStep(task, (has_block(self.name), DESIGN), "the scenario has a tolerances block")

    def find(self, study: Study, say: Progress) -> Tolerances:
        """Decide whether every device works, and estimate how many do."""
        say("proving that every device within the tolerances works")
        from vireport.findings.tolerances.tolerances import assess_tolerances, half_widths

        device, block = study.solution.device, study.scenario.tolerances
        assert block is not None
        widths = half_widths(device, block)
        return assess_tolerances(device, widths, study.solution.membrane, block.distribution, block.samples)

    def results(self, tolerances: Tolerances | None, study: Study) -> AddedBlocks:
        """The block `tolerances` of results.json."""
        if tolerances is None:
            return {self.name: None}
        from vireport.findings.tolerances.results import tolerances_data

        return {self.name: tolerances_data(tolerances, study.scenario)}

    def requirements(self) -> Iterator[Requirement]:
        """The requirement of a least yield within the tolerances."""
        from vireport.findings.tolerances.judging import judged_yield, may_yield
        from vireport.study.judging.requirements import OfRun, Requirement

        quantity = OfRun(judged_yield, may_yield)
        yield Requirement("yield_at_least_percent", QUESTION, quantity, self.name)

    def answers(self, tolerances: Tolerances, evidence: Evidence) -> Iterator[AddedAnswer[Tolerances]]:
        """The answer, good where every device is proved to work; otherwise a required yield decides."""
        from vireport.study.judging.verdict import AddedAnswer, AddedConclusion, Status, Weight

        if tolerances.proved:
            yield AddedAnswer(QUESTION, Status.GOOD, tolerances, name=self.name)
            return
        refuted = tolerances.worst is not None
        concludes = AddedConclusion(
            "NOT_EVERY_DEVICE" if refuted else "TOLERANCES_OPEN",
            Status.CAUTION,
            "Stable, but not for every device within the tolerances"
            if refuted
            else "Stable, but tolerances not decided",
            Weight.NOT_EVERY_DEVICE,
            self.name,
        )
        yield AddedAnswer(QUESTION, Status.CAUTION, tolerances, name=self.name, concludes=concludes)

    def facts(self, verdict: Verdict) -> Mapping[FactPlace, Iterable[Statement]]:
        """A statement on how many devices within the tolerances keep stable 1:1 motion."""
        from vireport.study.judging.opening import FactPlace, Statement
        from vireport.text.said import Said

        answer = verdict.added.get(self.name)
        if answer is None:
            return {}
        tolerances = answer.data
        stable, count = tolerances.sampled.stable, tolerances.sampled.samples
        tried = "every_device_tried" if stable == count else "some_devices_fail" if stable else "no_device_works"
        name = "every_device_proved" if tolerances.proved else tried
        return {FactPlace.AFTER_MARGIN: [Statement(answer.status, Said(name, (tolerances,), self.name))]}

    def written(self, tolerances: Tolerances, study: Study) -> Mapping[str, bytes]:
        """The worst device found as a scenario, where one fails."""
        if tolerances.worst is None:
            return {}
        from vireport.findings.tolerances.results import worst_scenario

        return {"worst.yaml": worst_scenario(study.scenario, tolerances.worst).encode()}


FINDING = TolerancesFinding()
