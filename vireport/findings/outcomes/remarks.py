"""What is remarked on requirements of shocks and kicks."""

from __future__ import annotations

from vireport.text.patterns import Pattern


class ShockRemark(Pattern):
    """Where a value comes from, and why a requirement is not met."""

    NO_MOTION = "no stable motion of a word that is required is known at the design point"
    UNDECIDED = "not decided: {reason}"
    TRIED = "by {count} shocks tried: evidence, not proof"
    NONE_LEADS_OUT = "none leads out up to there, by {count} shocks tried: evidence, not proof"
    STARTS = "{share} of {total} random starts"
