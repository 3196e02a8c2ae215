"""The least number of periods that is required, held against that of a run."""

from __future__ import annotations

from enum import auto

from vireport.base.errors import NumericalError
from vireport.findings.escape.escape import Escape, Unlimited
from vireport.study.judging.evidence import Evidence, Judgement, Limit, held_against
from vireport.text.patterns import Pattern
from vireport.text.requirements import Remark


class LifetimeRemark(Pattern, file="escape"):
    """Where a value comes from, and why the requirement is not met."""

    SIMULATED = auto()
    EXTRAPOLATED = auto()
    BEYOND_USE = auto()
    LONGER = auto()
    OPEN = auto()


def judged_lifetime(evidence: Evidence, limit: Limit) -> Judgement:
    """The mean number of periods of the motion that lasts least, and the lower end of its interval."""
    escape: Escape | None = evidence.findings.get("escape")
    if escape is None:
        raise NumericalError(Remark.NOT_STABLE.said())
    least = escape.shortest
    low, _ = least.interval
    if least.periods is not None and low is not None:
        remark = LifetimeRemark.EXTRAPOLATED if least.extrapolated else LifetimeRemark.SIMULATED
        return held_against(least.periods, limit, remark.said(), least.periods - low)
    if least.reason == Unlimited.BEYOND_USE:
        return Judgement(None, LifetimeRemark.BEYOND_USE.said(), None, True, LifetimeRemark.EXTRAPOLATED.said())
    if low is None:
        raise NumericalError(LifetimeRemark.OPEN.said(reason=least.reason))
    # Where none left, or too few, all that may be claimed is what was simulated.
    return held_against(low, limit, LifetimeRemark.LONGER.said(reason=least.reason))
