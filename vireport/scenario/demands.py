"""What keys of requirements say without being judged: how a value is held against its limit, and what that needs."""

from __future__ import annotations

from enum import Enum, StrEnum
from typing import Self

from msgspec import Struct

from vireport.scenario.parameters import Parameter


class LimitKind(Enum):
    """How a value is held against a limit; the value is the text of the limit."""

    AT_LEAST = "at least {0:.12g} {unit}"
    AT_MOST = "at most {0:.12g} {unit}"
    RANGE = "from {0:.12g} to {1:.12g} {unit}"
    AGREEMENT = "every stable motion found again to {0:.12g}"
    WORDS = "only {words}"
    HELD = "required"


AT_LEAST, AT_MOST, RANGE, AGREEMENT, WORDS, HELD = LimitKind


class Need(StrEnum):
    """The path of what a scenario must give for a requirement to be judged.

    Attributes
    ----------
    why : str
        Beginning of the message where it is not given.
    paths : tuple of str
        Of which one is enough.
    """

    why: str
    paths: tuple[str, ...]

    def __new__(cls, path: str, why: str = "", *others: str) -> Self:
        """Make the member whose value is `path`."""
        member = str.__new__(cls, path)
        member._value_, member.why, member.paths = path, why, (path, *others)
        return member

    SWEEP = "sweep", "a range of the swept parameter, or a motion that is followed along it, needs"
    BALL_MASS = "device.ball_mass_kg", "voltage and deflection need"
    DIELECTRIC = "device.membrane.thickness_m", "power, efficiency and field need"
    TOLERANCES = "tolerances", "a yield needs"
    SIMULATION = "simulation", "a cross-check needs"
    DISTURBANCES = "disturbances", "a shock needs"
    JITTER = "disturbances.jitter_m_s", "a spread of phases needs", "disturbances.jitter_restitution"
    ESCAPE = "disturbances.escape", "a lifetime needs"


class Demand(Struct, frozen=True, eq=False):
    """What the keys of a requirement say without being judged: the first half of its row.

    Keys that carry the same object are one requirement: the two ends of a range, or lists that are joined.

    Attributes
    ----------
    kind : LimitKind
    needs : tuple of Need
    at_design : bool
        Whether it is judged at the design point, so that a swept parameter needs a design value.
    over : Parameter or None
        What a range is of, which itself needs no design value; None for the swept parameter.
    usual : float or None
        The limit that holds beside other requirements where none is given and the quantity is evaluated; None where
        nothing is required then.
    """

    kind: LimitKind
    needs: tuple[Need, ...] = ()
    at_design: bool = True
    over: Parameter | None = None
    usual: float | None = None
