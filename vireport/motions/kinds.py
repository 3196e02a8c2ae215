"""What distinguishes motions, critical points and the ends of branches."""

from __future__ import annotations

from enum import IntEnum, StrEnum


class Symmetry(StrEnum):
    """Whether a motion is its own mirror image, as some of a horizontal capsule are."""

    SYMMETRIC = "symmetric"
    ASYMMETRIC = "asymmetric"


class CriticalKind(StrEnum):
    """What changes at a critical point."""

    PERIOD_DOUBLING = "period_doubling"
    FOLD = "fold"
    PITCHFORK = "pitchfork"
    NODE_FOCUS = "node_focus"
    GRAZING = "grazing"

    @property
    def words(self) -> str:
        """Name for the reader."""
        return "node to focus" if self is CriticalKind.NODE_FOCUS else self.replace("_", " ")

    @property
    def letter(self) -> str:
        """Letter of its labels; the paper's A, B, C, and G for grazing, which it does not treat."""
        letters = {CriticalKind.NODE_FOCUS: "A", CriticalKind.PERIOD_DOUBLING: "B", CriticalKind.GRAZING: "G"}
        return letters.get(self, "C")


class Change(StrEnum):
    """What happens at a critical point."""

    BOTTOM_REST = "the impact at the bottom loses its velocity"
    TOP_REST = "the impact at the top loses its velocity"
    TOUCH = "a turning point of the ball touches a membrane"
    DOUBLING = "lambda = -1"
    MEETING = "lambda = 1, two motions meet"
    HANDOVER = "lambda = 1, the symmetric motion passes its stability to two asymmetric ones"
    TYPE = "Delta = 0, the type changes between node and focus"

    @property
    def at_rest(self) -> bool:
        """Whether an impact velocity vanishes there."""
        return self in (Change.BOTTOM_REST, Change.TOP_REST)


class BranchEnd(StrEnum):
    """Why a branch of motions begins or ends."""

    SWEEP = "end of the sweep"
    BOTTOM_REST = Change.BOTTOM_REST.value
    TOP_REST = Change.TOP_REST.value
    PITCHFORK = "pitchfork"
    CLOSED = "closed curve"


class StrandEvent(IntEnum):
    """What can happen along a strand of the level curve; the columns of `Curve.event_values`.

    Attributes
    ----------
    kind : CriticalKind
        Of the critical point; a meeting of motions is a fold unless it is shown to be a pitchfork. The ends of the
        sweep, START and END, are none.
    change : Change
        What happens there.
    """

    kind: CriticalKind
    change: Change

    def __new__(cls, column: int, kind: CriticalKind | None = None, change: Change | None = None) -> StrandEvent:
        """Number the members, and give them what they stand for."""
        member = int.__new__(cls, column)
        member._value_ = column
        if kind is not None and change is not None:
            member.kind, member.change = kind, change
        return member

    DOUBLING = 0, CriticalKind.PERIOD_DOUBLING, Change.DOUBLING
    FOCUS_BELOW = 1, CriticalKind.NODE_FOCUS, Change.TYPE
    FOCUS_ABOVE = 2, CriticalKind.NODE_FOCUS, Change.TYPE
    MEETING = 3, CriticalKind.FOLD, Change.MEETING
    GRAZING = 4, CriticalKind.GRAZING, Change.TOUCH
    BOTTOM_REST = 5, CriticalKind.GRAZING, Change.BOTTOM_REST
    TOP_REST = 6, CriticalKind.GRAZING, Change.TOP_REST
    START = 7
    END = 8

    @property
    def at_rest(self) -> bool:
        """Whether an impact velocity vanishes there."""
        return self in (StrandEvent.BOTTOM_REST, StrandEvent.TOP_REST)

    @property
    def ends_sweep(self) -> bool:
        """Whether it is the sweep that begins or ends there."""
        return self in (StrandEvent.START, StrandEvent.END)
