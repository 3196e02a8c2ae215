"""What escapes add to the keys of a scenario: how long a motion must last under random kicks."""

from typing import Annotated

from vireport.scenario.demands import AT_LEAST, Demand, Need
from vireport.scenario.keys import positive

KEYS = {
    "requirements.lasts_at_least_periods": (
        Annotated[float | None, Demand(AT_LEAST, (Need.ESCAPE,))],
        positive(
            None,
            "Lasts at least",
            "periods",
            "Least mean number of forcing periods until the random kicks of disturbances.jitter_m_s lead out of a "
            "stable 1:1 motion at the design point. The 95 % interval must be above it; needs disturbances.escape and "
            "numba.",
            behind="phase_jitter_at_most_deg",
            example=1e6,
        ),
    )
}
