"""Keys of a scenario for disturbances: the block `disturbances`, and requirements on shocks and kicks."""

from typing import Annotated

from vireport.scenario.demands import AT_LEAST, AT_MOST, Demand, Need
from vireport.scenario.keys import Block, WhenGiven, key, positive
from vireport.scenario.parameters import SMALLEST

LONGEST_RAMP = 1000.0
"""Forcing periods over which a force is ramped up: minutes, at the frequencies of such devices."""


class DisturbancesBlock(Block):
    """What the device does when it is switched on; without the block, only what takes some milliseconds."""

    ramp_periods: float = key(
        0.0,
        "Ramp",
        "periods",
        "Forcing periods in which the amplitude of the force is ramped up when the device is switched on; 0: at once.",
        example=20.0,
        ge=0.0,
        le=LONGEST_RAMP,
    )
    jitter_m_s: float | None = positive(
        None,
        "Jitter",
        "m/s",
        "Standard deviation of the velocity just after each impact. With it, the report has the spread of the impacts.",
        example=0.01,
    )
    jitter_restitution: float | None = key(
        None,
        "Scatter of restitution",
        "1",
        "Standard deviation of the restitution coefficient from one impact to the next, alike on both membranes and "
        "independent of the kicks of jitter_m_s. With it, the report has the spread of the impacts.",
        example=0.02,
        ge=SMALLEST,
        le=1.0,
    )
    prove: bool = key(
        False,
        "Prove",
        "",
        "Whether to prove that the motion is reached from rest, from which share of all impacts and of all moments of "
        "switching on, and up to which jump of the velocity all die out.",
        addition="proofs",
        example=True,
    )
    basin: bool = key(
        False,
        "Basins",
        "",
        "Whether to draw which impacts on the bottom membrane lead to which motion, and to give the share of each.",
        example=True,
    )
    escape: bool = key(
        False,
        "Escape",
        "",
        "Whether to find out how long the stable 1:1 motions last until random kicks, jitter_m_s, lead out of them.",
        addition="escape",
        example=True,
    )


KEYS = {
    "disturbances": (
        WhenGiven[DisturbancesBlock] | None,
        key(
            None,
            "Disturbances",
            "",
            "What the device does when it is switched on. Left out, only the outcome from rest at once, and how fast "
            "small disturbances die out.",
            in_map="a map has no disturbances block (delete it; map.from_rest and map.shock are for each cell)",
        ),
    ),
    "requirements.survives_shock_m_s": (
        Annotated[float | None, Demand(AT_LEAST, (Need.DISTURBANCES,))],
        positive(
            None,
            "Survives a shock of",
            "m/s",
            "Least jump of the relative velocity that leads out of a stable 1:1 motion at the design point; needs "
            "numba.",
            behind="withstands_distortion_percent",
            example=0.3,
        ),
    ),
    "requirements.phase_jitter_at_most_deg": (
        Annotated[float | None, Demand(AT_MOST, (Need.JITTER,))],
        positive(
            None,
            "Phase jitter at most",
            "deg",
            "Largest standard deviation of the phase of an impact under the random kicks of disturbances.jitter_m_s "
            "and disturbances.jitter_restitution.",
            behind="survives_shock_m_s",
            example=5.0,
        ),
    ),
}
