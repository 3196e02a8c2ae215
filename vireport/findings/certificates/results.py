"""Record of results.json on the proof of a critical point."""

from __future__ import annotations

from vireport.base.records import ResultsBlock
from vireport.motions.events import Event

PRECISIONS = (192, 384, 768)
"""Bits of the arithmetic, tried in this order: next to a horizontal capsule cancellation may take seventy."""

Enclosure = tuple[str, str]
"""A decimal number below and one above."""


class Certificate(ResultsBlock, frozen=True):
    """What is proved of a critical point.

    Attributes
    ----------
    label, kind
        those of the critical point
    proved
        whether exactly one point fulfils its equations near the one stated, with impact velocities of the right signs
        and, where a turning point of the ball touches a membrane, within its flight
    reason
        why it is not proved; empty where it is
    sweep_value, d, gbar, q, phi_bottom_rad, velocity_bottom
        of the [critical point](#critical-points), each as a decimal number below and one above; null where nothing is
        proved
    bits
        precision of the arithmetic
    bound_holds
        whether it is proved that the swept value as stated, a double, is within its stated error bound
    radius
        half the width in q (relative to q − 1/2) and phase of the box in which the point is the only one; 0 if none
    side
        what the trace's proved slope along the sweep says: `stable above`, `focus below`, ...; empty for a fold or a
        grazing point, where the trace has none, and where a range of foci is too short for its ends to be told apart.
        Above is at larger swept values
    admissible
        whether the ball is proved to stay between the membranes (or proved not to); null where it is undecided
    mirror_proved
        whether the mirror image is proved likewise; null where there is none
    beyond
        numbers of the motion (`u`, `phi`, `d`, ...) as stated whose own error bounds are not proved to hold
    """

    label: str
    kind: Event
    proved: bool
    reason: str
    sweep_value: Enclosure | None = None
    d: Enclosure | None = None
    gbar: Enclosure | None = None
    q: Enclosure | None = None
    phi_bottom_rad: Enclosure | None = None
    velocity_bottom: Enclosure | None = None
    bits: int = PRECISIONS[-1]
    bound_holds: bool = False
    radius: float = 0.0
    side: str = ""
    admissible: bool | None = None
    mirror_proved: bool | None = None
    beyond: tuple[str, ...] = ()
