"""Judge whether the stable motions last as many forcing periods under random kicks as is required."""

from __future__ import annotations

from enum import auto

from vireport.base.errors import NumericalError
from vireport.findings.escape.escape import Escape, Unlimited
from vireport.study.judging.evidence import Evidence, Judgement, Limit, held_against
from vireport.text.patterns import Pattern
from vireport.text.requirements import Remark


class LifetimeRemark(Pattern, file="escape"):
    """Sentences on where a mean number of periods comes from, and why the requirement is not met."""

    SIMULATED = auto()
    EXTRAPOLATED = auto()
    BEYOND_USE = auto()
    LONGER = auto()
    OPEN = auto()


def judged_lifetime(evidence: Evidence, limit: Limit) -> Judgement:
    """Judge the mean number of periods of the motion that lasts least, with the lower half of its interval as error.

    Raises
    ------
    NumericalError
        Where no motion is stable, or nothing is known of how long one lasts.
    """
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
    # Where no ball left, or too few did, only the lower end that the simulated time gives may be claimed.
    return held_against(low, limit, LifetimeRemark.LONGER.said(reason=least.reason))
