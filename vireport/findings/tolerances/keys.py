"""What tolerances add to the keys of a scenario: the yield that is required. Their block itself is of the core."""

from typing import Annotated

from vireport.scenario.demands import AT_LEAST, Demand, Need
from vireport.scenario.keys import key

KEYS = {
    "requirements.yield_at_least_percent": (
        Annotated[float | None, Demand(AT_LEAST, (Need.TOLERANCES,))],
        key(
            None,
            "Yield at least",
            "%",
            "Least share of the devices within the tolerances that have a stable 1:1 motion. The 95 % interval of the "
            "yield must be above it; 100 needs the proof that all have one.",
            behind="field_at_most_percent",
            example=99.0,
            gt=0.0,
            le=100.0,
        ),
    )
}
