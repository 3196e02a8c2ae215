"""What the motions are called: their stability, their family, their critical points, and why a branch ends."""

from __future__ import annotations

from enum import IntEnum, StrEnum


class Stability(StrEnum):
    """Table 1's types of a motion. An unstable focus cannot be: |lambda| = r^2 < 1 where the eigenvalues are complex.

    Arrays hold `code`, the place of a member among the others.
    """

    STABLE_NODE = "stable node"
    STABLE_FOCUS = "stable focus"
    UNSTABLE_NODE = "unstable node"

    @property
    def code(self) -> int:
        """Index that stands for the type in an array."""
        return STABILITIES.index(self)

    @property
    def attracts(self) -> bool:
        """Whether motions nearby approach it."""
        return self is not Stability.UNSTABLE_NODE


STABILITIES = tuple(Stability)
"""The types by their codes."""


class Family(StrEnum):
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
        return {CriticalKind.NODE_FOCUS: "A", CriticalKind.PERIOD_DOUBLING: "B", CriticalKind.GRAZING: "G"}.get(
            self, "C"
        )


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
    BOTTOM_REST = "the impact at the bottom loses its velocity"
    TOP_REST = "the impact at the top loses its velocity"
    PITCHFORK = "pitchfork"
    CLOSED = "closed curve"


class StrandEvent(IntEnum):
    """What can happen along a strand of the level curve; the columns of `Curve.event_values`."""

    DOUBLING = 0
    FOCUS_BELOW = 1
    FOCUS_ABOVE = 2
    MEETING = 3
    GRAZING = 4
    BOTTOM_REST = 5
    TOP_REST = 6
    START = 7
    END = 8

    @property
    def at_rest(self) -> bool:
        """Whether an impact velocity vanishes there."""
        return self in (StrandEvent.BOTTOM_REST, StrandEvent.TOP_REST)

    @property
    def kind(self) -> CriticalKind:
        """Kind of the critical point; a meeting of motions is a fold unless it is shown to be a pitchfork."""
        return KINDS[self]

    @property
    def change(self) -> Change:
        """What happens there."""
        return CHANGES[self]


KINDS = {
    StrandEvent.DOUBLING: CriticalKind.PERIOD_DOUBLING,
    StrandEvent.FOCUS_BELOW: CriticalKind.NODE_FOCUS,
    StrandEvent.FOCUS_ABOVE: CriticalKind.NODE_FOCUS,
    StrandEvent.MEETING: CriticalKind.FOLD,
    StrandEvent.GRAZING: CriticalKind.GRAZING,
    StrandEvent.BOTTOM_REST: CriticalKind.GRAZING,
    StrandEvent.TOP_REST: CriticalKind.GRAZING,
}
CHANGES = {
    StrandEvent.DOUBLING: Change.DOUBLING,
    StrandEvent.FOCUS_BELOW: Change.TYPE,
    StrandEvent.FOCUS_ABOVE: Change.TYPE,
    StrandEvent.MEETING: Change.MEETING,
    StrandEvent.GRAZING: Change.TOUCH,
    StrandEvent.BOTTOM_REST: Change.BOTTOM_REST,
    StrandEvent.TOP_REST: Change.TOP_REST,
}
