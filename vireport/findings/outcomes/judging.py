"""Judge the requirements on shocks and kicks, and the share of starts that come to motions of required words."""

from __future__ import annotations

from enum import auto
from typing import TYPE_CHECKING

from vireport.base.errors import NumericalError
from vireport.findings.outcomes.outcomes import Outcomes
from vireport.study.judging.evidence import Evidence, Judgement, Limit, held_against
from vireport.text.formatting import percent
from vireport.text.patterns import Pattern, Phrase
from vireport.text.requirements import Remark

if TYPE_CHECKING:
    from vireport.findings.outcomes.attracting import AttractingMotion, AttractingMotions


class ShockRemark(Pattern, file="disturbances"):
    """Sentences on where a value comes from, and why a requirement on shocks is not met."""

    NO_MOTION = auto()
    UNDECIDED = auto()
    TRIED = auto()
    NONE_LEADS_OUT = auto()
    STARTS = auto()


def outcomes_of(evidence: Evidence) -> Outcomes:
    """The outcomes of other starts that a study has found; empty ones where it did not look for them."""
    outcomes: Outcomes = evidence.findings.get("outcomes", Outcomes())
    return outcomes


def judged_shock(evidence: Evidence, limit: Limit) -> Judgement:
    """Judge the least shock of motions of the required words or, where none leads out, the largest that was tried."""
    outcomes = outcomes_of(evidence)
    withstood, attracting = outcomes.withstood, outcomes.attracting
    if evidence.allowed and attracting is not None:
        withstood = attracting.withstood(allowed_motions(evidence, attracting))
        if withstood is None:
            raise NumericalError(ShockRemark.NO_MOTION.said())
    if withstood is None:
        raise NumericalError(Remark.NOT_STABLE.said())
    if withstood.searched_to_m_s is None or withstood.shock is None:
        raise NumericalError(ShockRemark.UNDECIDED.said(reason=withstood.shock_unknown))
    # Where nothing leads out, all that may be claimed is what was tried.
    tried = withstood.shock.tried
    if withstood.jump_m_s is not None:
        return held_against(withstood.jump_m_s, limit, ShockRemark.TRIED.said(count=tried))
    return held_against(withstood.searched_to_m_s, limit, ShockRemark.NONE_LEADS_OUT.said(count=tried))


def judged_jitter(evidence: Evidence, limit: Limit) -> Judgement:
    """Judge the largest standard deviation of the phase [deg] of an impact under the kicks of the scenario."""
    withstood = outcomes_of(evidence).withstood
    if withstood is None:
        raise NumericalError(Remark.NOT_STABLE.said())
    if withstood.phase_deg is None or withstood.spread is None:
        raise NumericalError(ShockRemark.UNDECIDED.said(reason=withstood.jitter_unknown))
    # What linear theory neglects counts as an error bound: a value nearer to the limit than that decides nothing.
    return held_against(withstood.phase_deg, limit, bound=withstood.spread.error * withstood.phase_deg)


def share_of_starts(evidence: Evidence, attracting: AttractingMotions) -> Phrase | None:
    """A phrase on the share of random starts that come to a motion of a required word; None where it is unknown."""
    if attracting.others is None:
        return None
    shares = [motion.share or 0.0 for motion in allowed_motions(evidence, attracting)]
    return ShockRemark.STARTS.said(share=percent(sum(shares)), total=attracting.starts)


def allowed_motions(evidence: Evidence, attracting: AttractingMotions) -> list[AttractingMotion]:
    """The stable motions without rests whose words are required."""
    return [row for row in attracting.motions if row.motion is not None and evidence.allows(row.motion.word.letters)]
