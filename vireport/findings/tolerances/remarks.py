"""What is remarked on a yield that is required."""

from __future__ import annotations

from vireport.text.patterns import Pattern


class YieldRemark(Pattern):
    """Where a value comes from, and why the requirement is not met."""

    NO_TOLERANCES = "there are no tolerances"
    PROVED = "every device within the tolerances is proved to have stable motion"
    COUNTED = "{count} of {total} random devices have stable motion"
