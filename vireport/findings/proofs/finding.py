"""Proofs as an addition to a study: a motion is reached from rest, from a share of all starts, and survives shocks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from msgspec.structs import replace

from vireport.base.progress import Progress
from vireport.findings.outcomes.steps import SHOCK
from vireport.scenario.keys import value_at
from vireport.study.finding import AddedFinding
from vireport.study.plan import DESIGN, FLINT, OUTPUT, AddedTask, DeclaredStep, Precondition

if TYPE_CHECKING:
    from vireport.findings.proofs.proved import Proved
    from vireport.study.result_records import DisturbancesData
    from vireport.study.study import Study


class ProofsFinding(AddedFinding["Proved"]):
    """Proofs in ball arithmetic about switching on and shocks, as an addition to a study."""

    name = "proofs"
    section = "sections/proofs.typ.j2"
    within = "disturbances"
    extends = "disturbances"

    def steps(self) -> Iterator[DeclaredStep]:
        """The step that proves, listed where the scenario requests proofs."""
        requested = Precondition(
            lambda scenario, _: value_at(scenario, "disturbances.prove"), "nothing is to be proved"
        )
        what = "proof that the motion is reached from rest, and of a bound of the shocks that it survives"
        yield DeclaredStep(
            AddedTask("proof", what), (DESIGN, FLINT, OUTPUT), "disturbances.prove is true", (requested,)
        )

    def find(self, study: Study, say: Progress) -> Proved | None:
        """Prove what can be proved of the stable motions."""
        from vireport.findings.proofs.proved import proved_of

        if study.switched_on is None:
            return None
        withstood = study.findings["outcomes"].withstood, study.plan.runs(SHOCK)
        return proved_of(study.solution, study.switched_on, *withstood, say)

    def results_within(self, block: DisturbancesData, proved: Proved | None) -> DisturbancesData:
        """The block on disturbances with what is proved: of the start from rest, of shocks, and with what it takes."""
        if proved is None:  # what proofs take is not imported
            from_rest = block.from_rest and replace(block.from_rest, proved=None)
            return replace(
                block, from_rest=from_rest, shock=block.shock and replace(block.shock, proved_m_s=None), proof=None
            )
        from vireport.findings.proofs.results import disturbances_with_proofs

        return disturbances_with_proofs(block, proved)


FINDING = ProofsFinding()
