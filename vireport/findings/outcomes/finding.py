"""What other starts bring to a study: moments, windows, shocks, coexisting motions, jitter and basins."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vireport.base.errors import UsageError
from vireport.base.progress import Progress
from vireport.findings.outcomes.keys import DisturbancesBlock
from vireport.findings.outcomes.steps import (
    BASINS,
    COEXISTENCE,
    FIGURE_BASIN,
    FIGURE_SHOCKS,
    JITTER,
    MOMENTS,
    SHOCK,
    WINDOWS,
    steps,
)
from vireport.scenario.keys import block_of, value_at
from vireport.study.finding import AddedFinding
from vireport.study.plan import DeclaredStep, plan, simulation_compiles
from vireport.text.requirements import Question

if TYPE_CHECKING:
    from vireport.design.switched_on import SwitchedOn
    from vireport.findings.outcomes.outcomes import Outcomes
    from vireport.scenario.blocks import Scenario
    from vireport.study.judging.evidence import Evidence
    from vireport.study.judging.opening import FactPlace, Statement
    from vireport.study.judging.requirements import Requirement
    from vireport.study.judging.verdict import AddedAnswer, Status, Verdict
    from vireport.study.result_records import DisturbancesData
    from vireport.study.study import Study
    from vireport.text.patterns import Phrase

BLOCK = "disturbances"
"""The block of a scenario that asks for it; its keys in results.json and its words have the same name."""

BUMPS, KICKS = "Which bumps does it withstand?", "How much does it jitter?"
"""Its questions."""


class OutcomesFinding(AddedFinding["Outcomes"]):
    """What starts other than a ball at rest come to, as an addition to a study."""

    name = "outcomes"
    section = "sections/disturbances.typ.j2"
    extends = BLOCK

    def steps(self) -> Iterator[DeclaredStep]:
        """The six steps of a run and the two figures."""
        return steps()

    def refuse_undecidable(self, scenario: Scenario) -> None:
        """Refuse a shock to be survived where the search for it lacks what it needs."""
        if value_at(scenario, "requirements.survives_shock_m_s") is None:
            return
        if (why := plan(scenario).reason(SHOCK)) is not None:
            raise UsageError(f"requirements.survives_shock_m_s cannot be judged: {why}")

    def switched_on(self, study: Study, say: Progress) -> tuple[SwitchedOn, Outcomes] | None:
        """What the device does when it is switched on as the block says, at any moment, and near the design point."""
        moments, windows = study.plan.runs(MOMENTS), study.plan.runs(WINDOWS)
        block = block_of(study.scenario, BLOCK, DisturbancesBlock)
        if block is None or not (moments or windows):
            return None
        say("following the ball from rest")
        from vireport.findings.outcomes.outcomes import Outcomes, outcomes_along, switched_on_by

        if moments:
            return switched_on_by(study.solution, block, simulation_compiles(), windows)
        from vireport.design.switched_on import SwitchedOn, switched_on_at_once

        strip = outcomes_along(study.solution, compiled=windows)
        answer = SwitchedOn(None, over_sweep=strip) if strip else switched_on_at_once(study.solution, compiled=windows)
        return answer, Outcomes()

    def find(self, study: Study, say: Progress) -> Outcomes:
        """Look for the least shock, follow random starts, and draw basins, as the plan says."""
        from vireport.findings.outcomes.outcomes import Outcomes, with_basins, with_coexistence, with_shocks

        outcomes: Outcomes = study.findings.get(self.name, Outcomes())
        if study.plan.runs(SHOCK, JITTER):
            say("looking for the least shock")
            outcomes = with_shocks(outcomes, study, study.plan.runs(SHOCK))
        if study.plan.runs(COEXISTENCE):
            say("following random starts")
            outcomes = with_coexistence(outcomes, study)
        if study.plan.runs(BASINS):
            say("drawing the basin from impacts on the bottom")
            outcomes = with_basins(outcomes, study)
        return outcomes

    def results_within(self, block: DisturbancesData, outcomes: Outcomes | None) -> DisturbancesData:
        """The block on disturbances with what other starts come to."""
        from vireport.findings.outcomes.outcomes import Outcomes
        from vireport.findings.outcomes.results import disturbances_with_outcomes

        return disturbances_with_outcomes(block, outcomes or Outcomes())

    def requirements(self) -> Iterator[Requirement]:
        """The requirements on the least shock and on the largest spread of the phases."""
        from vireport.findings.outcomes.judging import judged_jitter, judged_shock
        from vireport.study.judging.requirements import OfRun, Requirement

        yield Requirement("survives_shock_m_s", BUMPS, OfRun(judged_shock, dear=True), BLOCK)
        yield Requirement("phase_jitter_at_most_deg", KICKS, OfRun(judged_jitter, dear=True), BLOCK)

    def share_of_starts(self, outcomes: Outcomes, evidence: Evidence) -> Phrase | None:
        """A phrase on the share of random starts that come to a motion of a required word; None where it is unknown."""
        from vireport.findings.outcomes.judging import share_of_starts

        return None if outcomes.attracting is None else share_of_starts(evidence, outcomes.attracting)

    def answers(self, outcomes: Outcomes, evidence: Evidence) -> Iterator[AddedAnswer[Outcomes]]:
        """The answers on the least shock, on what speaks against starting from rest, and on the jitter."""
        from vireport.study.judging.verdict import (
            AddedAnswer,
            AddedConclusion,
            Status,
            Weight,
            judged_by,
            stable_motions,
        )

        motions = stable_motions(evidence)
        withstood = outcomes.withstood if not motions.narrow else None
        if withstood is not None and (withstood.shock is not None or withstood.shock_unknown):
            # Good only where one is required: nothing else says how large the shocks of a device are.
            status = Status.GOOD if judged_by(BUMPS, evidence.criteria) else Status.NEUTRAL
            yield AddedAnswer(BUMPS, status, outcomes, name="shock")
        end = evidence.from_rest if evidence.solution.design is not None and motions.types else None
        if end is not None and outcomes.narrow and (end.is_one_to_one or evidence.required_motions_met):
            word = "Stable, reached from rest within narrow limits only"
            concludes = AddedConclusion("WINDOW_NARROW", Status.CAUTION, word, Weight.MARGIN, BLOCK)
            yield AddedAnswer(Question.FROM_REST, Status.CAUTION, outcomes, name="window", concludes=concludes)
        if withstood is not None and withstood.jitter is not None:
            status = Status.CAUTION if withstood.jitter_unknown else Status.NEUTRAL
            yield AddedAnswer(KICKS, status, outcomes, name="jitter")

    def facts(self, verdict: Verdict) -> Mapping[FactPlace, Iterable[Statement]]:
        """What helps to start the device, what else it does near the design point, and what it withstands."""
        from vireport.study.judging.opening import FactPlace

        return {FactPlace.AFTER_MOTION: _starting(verdict), FactPlace.LAST: _withstanding(verdict)}

    def pictures(self, outcomes: Outcomes, study: Study, templates: Path | None) -> Iterator[Any]:
        """The figures of what shocks lead to, and of the basins on the section of impacts."""
        if study.plan.runs(FIGURE_SHOCKS):
            from vireport.findings.outcomes.figures import shocks_picture

            if (plane := shocks_picture(outcomes, study.solution.device, templates)) is not None:
                yield plane
        if study.plan.runs(FIGURE_BASIN) and outcomes.basins is not None:
            from vireport.findings.outcomes.figures import basin_picture

            yield basin_picture(outcomes.basins, templates)


def _fact(status: Status, name: str, *values: object) -> Statement:
    from vireport.study.judging.opening import Statement
    from vireport.text.said import Said

    return Statement(status, Said(name, values, BLOCK))


def _starting(verdict: Verdict) -> Iterator[Statement]:
    """What helps where switching on at once does not, and what else the device does near the design point."""
    from vireport.findings.outcomes.judging import outcomes_of
    from vireport.study.judging.verdict import Status

    evidence, disturbances = verdict.evidence, outcomes_of(verdict.evidence)
    if verdict.from_rest is None or evidence.from_rest is None:
        return
    if evidence.is_reached_from_rest:
        if disturbances.narrow:
            yield _fact(Status.CAUTION, "window_is_narrow", disturbances)
    elif disturbances.ramp is not None:
        yield _fact(
            Status.CAUTION,
            "ramp_helps" if disturbances.ramp.periods is not None else "no_ramp_helps",
            disturbances.ramp,
        )
    elif disturbances.share is None:  # without a block no ramp is tried
        yield _fact(Status.CAUTION, "may_start_slowly")


def _withstanding(verdict: Verdict) -> Iterator[Statement]:
    """The least shock, and how far random kicks spread the impacts."""
    if (bumps := verdict.added.get("shock")) is not None:
        shock = bumps.data.withstood
        name = "shock_not_known" if shock.shock is None else "shock_none" if shock.jump_m_s is None else "shock_least"
        yield _fact(bumps.status, name, shock)
    if (kicks := verdict.added.get("jitter")) is not None:
        spread = kicks.data.withstood
        yield _fact(kicks.status, "jitter" if spread.spread is not None else "jitter_not_known", spread)


FINDING = OutcomesFinding()
