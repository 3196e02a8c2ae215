"""Declarations of requirements: how a value is compared with its limit, and what a scenario must give for that."""

from __future__ import annotations

from enum import Enum, StrEnum
from typing import Self

from msgspec import Struct

from vireport.scenario.parameters import Parameter


class LimitKind(Enum):
    """How a quantity is compared with a limit; the value is the text of the limit."""

    AT_LEAST = "at least {0:.12g} {unit}"
    AT_MOST = "at most {0:.12g} {unit}"
    RANGE = "from {0:.12g} to {1:.12g} {unit}"
    AGREEMENT = "every stable motion found again to {0:.12g}"
    WORDS = "only {words}"
    HELD = "required"


AT_LEAST, AT_MOST, RANGE, AGREEMENT, WORDS, HELD = LimitKind


class Need(StrEnum):
    """The path of a key that a scenario must give for a requirement to be judged.

    Attributes
    ----------
    why : str
        Beginning of the message where the key is not given.
    paths : tuple of str
        Paths of which one is enough.
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
    """The declaration of a requirement, which its keys carry.

    Keys that carry the same object are one requirement: the two ends of a range, or lists that are joined.

    Attributes
    ----------
    kind : LimitKind
    needs : tuple of Need
    at_design : bool
        Whether it is judged at the design point, so that a swept parameter needs a design value.
    over : Parameter or None
        The parameter of a range, which needs no design value itself; None for the swept parameter.
    usual : float or None
        The limit that holds beside other requirements if none is given and the quantity is evaluated; None for no such
        limit.
    """

    kind: LimitKind
    needs: tuple[Need, ...] = ()
    at_design: bool = True
    over: Parameter | None = None
    usual: float | None = None
