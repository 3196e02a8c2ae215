"""What escapes bring to a study: how long the stable motions last under random kicks, and what is required of that."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vireport.base.errors import UsageError
from vireport.base.progress import Progress
from vireport.scenario.keys import value_at
from vireport.study.finding import AddedFinding, AddedQuantity
from vireport.study.plan import (
    DESIGN,
    NUMBA,
    OUTPUT,
    PICTURES,
    AddedTask,
    DeclaredStep,
    Precondition,
    Task,
    plan,
)

if TYPE_CHECKING:
    from vireport.findings.escape.escape import Escape
    from vireport.scenario.blocks import Scenario
    from vireport.study.judging.evidence import Evidence
    from vireport.study.judging.opening import FactPlace, Statement
    from vireport.study.judging.requirements import Requirement
    from vireport.study.judging.verdict import AddedAnswer, Verdict
    from vireport.study.result_records import AddedBlocks
    from vireport.study.study import Study

QUESTION = "How long does it last?"

REQUIRED = "requirements.lasts_at_least_periods"

FIGURE = "figure-escape"


class EscapeFinding(AddedFinding["Escape"]):
    """How long the stable 1:1 motions of the design point last, as an addition to a study."""

    name = "escape"
    section = "sections/escape.typ.j2"
    within = "disturbances"

    def steps(self) -> Iterator[DeclaredStep]:
        """One step and its figure, listed where the scenario asks for it."""
        wanted = Precondition(lambda scenario, _: value_at(scenario, "disturbances.escape"), "escape is false")
        needed = Precondition(
            lambda scenario, formats: formats or value_at(scenario, REQUIRED) is not None, OUTPUT.otherwise
        )
        why = "disturbances.escape is true"
        task = AddedTask(self.name, "how long the stable 1:1 motions last under random kicks, and what they come to")
        costs = f"{task.what}: some seconds"
        yield DeclaredStep(task, (DESIGN, NUMBA, needed), why, (wanted,), costs=lambda _: costs)
        drawn = AddedTask(FIGURE, "the mean time until kicks lead out of a motion, by their size (figure-escape)")
        yield DeclaredStep(drawn, (DESIGN, NUMBA, PICTURES), why, (wanted,), before=Task.FIGURE_CYCLE)

    def refuse_undecidable(self, scenario: Scenario) -> None:
        """Refuse a lifetime that is required where the simulation lacks what it needs."""
        if value_at(scenario, REQUIRED) is not None and (why := plan(scenario).reason(self.name)) is not None:
            raise UsageError(f"{REQUIRED} cannot be judged: {why}")

    def find(self, study: Study, say: Progress) -> Escape | None:
        """Follow balls under kicks until they leave the stable motions."""
        say("kicking balls out of the stable motions")
        from vireport.findings.escape.escape import escape_of

        return escape_of(study.solution, value_at(study.scenario, "disturbances.jitter_m_s"))

    def results(self, escape: Escape | None, study: Study) -> AddedBlocks:
        """The block `escape` of results.json; {} where it was not computed."""
        if escape is None:
            return {}
        from vireport.findings.escape.results import escape_data

        return {self.name: escape_data(escape)}

    def compared(self, blocks: Mapping[str, Any]) -> Iterator[AddedQuantity]:
        """The number of periods of the motion that lasts least, or why there is none."""
        motions = blocks.get(self.name, {"motions": []})["motions"]
        if motions:
            # A motion of which nothing is known, not even a lower end, counts as the one that lasts least.
            least = min(motions, key=lambda of: _lasting(of["periods"], of["low_95"], of["log_periods"]))
            bound = 0.0 if least["periods"] is None else (least["high_95"] - least["low_95"]) / 2
            yield AddedQuantity("mean_time", least["periods"], "forcing periods", bound, least["reason"] or "")

    def requirements(self) -> Iterator[Requirement]:
        """The requirement on the mean number of periods that the motion lasting least reaches."""
        from vireport.findings.escape.judging import judged_lifetime
        from vireport.study.judging.requirements import OfRun, Requirement

        yield Requirement("lasts_at_least_periods", QUESTION, OfRun(judged_lifetime, dear=True), self.name)

    def answers(self, escape: Escape, evidence: Evidence) -> Iterator[AddedAnswer[Escape]]:
        """How long the motion that lasts least lasts; good only where a lifetime is required and reached."""
        from vireport.study.judging.verdict import AddedAnswer, Status, judged_by

        status = Status.GOOD if judged_by(QUESTION, evidence.criteria) else Status.NEUTRAL
        if escape.shortest.unknown:
            status = Status.CAUTION
        yield AddedAnswer(QUESTION, status, escape, name=self.name)

    def facts(self, verdict: Verdict) -> Mapping[FactPlace, Iterable[Statement]]:
        """The mean time, or why there is none."""
        from vireport.study.judging.opening import FactPlace, Statement
        from vireport.text.said import Said

        if (answer := verdict.added.get(self.name)) is None:
            return {}
        return {FactPlace.LAST: [Statement(answer.status, Said("lasts", (answer.data,), self.name))]}

    def pictures(self, escape: Escape, study: Study, templates: Path | None) -> Iterator[Any]:
        """The figure of the mean time against the size of the kicks, where the law for small kicks is known."""
        drawn = study.plan.running(FIGURE)
        if drawn is not None and escape.drawn is not None:
            from vireport.findings.escape.figure import picture

            yield picture(escape, drawn, templates)


def _lasting(periods: float | None, low: float | None, logarithm: float | None) -> float:
    """Periods by which motions are ranked."""
    if periods is not None:
        return periods
    return -inf if low is None and logarithm is None else inf


FINDING = EscapeFinding()
