"""Events of motions when an input of the device varies, and the trace of the return map at which they occur."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from typing import Any


class Event(StrEnum):
    """An event at a motion of a family, or at a point of a locus.

    The values are those of results.json. A family ends at `GRAZING`, `STOP`, `ZERO_VELOCITY`, `SWEEP_END`, `CLOSED`
    and `LOST`, `STOP` being where a ball with friction comes to a stop between two impacts; at a period doubling or
    pitchfork only where it turns back there as its own image. `DEGENERATE_GRAZING`, `CUSP` and `DEGENERATE_DOUBLING`
    are points of loci: where folds and period doublings of the motion with the further impact begin at a grazing point;
    where two loci of folds end together; where period doublings change from soft to hard, and a locus of folds begins.
    """

    PERIOD_DOUBLING = "period_doubling"
    FOLD = "fold"
    PITCHFORK = "pitchfork"
    NODE_FOCUS = "node_focus"
    GRAZING = "grazing"
    STOP = "stop_in_flight"
    ZERO_VELOCITY = "zero_velocity"
    SWEEP_END = "sweep_end"
    CLOSED = "closed_curve"
    LOST = "not_followed"
    DEGENERATE_GRAZING = "degenerate_grazing"
    CUSP = "cusp"
    DEGENERATE_DOUBLING = "degenerate_period_doubling"

    @property
    def words(self) -> str:
        """Name of the event in words."""
        names = {Event.NODE_FOCUS: "node to focus", Event.DEGENERATE_DOUBLING: "degenerate period doubling"}
        return names.get(self, self.replace("_", " "))

    @property
    def letter(self) -> str:
        """Letter of the labels of the event's points: the paper's A, B and C, and G and S for what it does not treat.

        G is grazing, S where a ball with friction comes to a stop in its flight.
        """
        letters = {Event.NODE_FOCUS: "A", Event.PERIOD_DOUBLING: "B", Event.GRAZING: "G", Event.STOP: "S"}
        return letters.get(self, "C")


CRITICAL = Event.PERIOD_DOUBLING, Event.FOLD, Event.PITCHFORK, Event.NODE_FOCUS, Event.GRAZING, Event.STOP
"""Events of critical points, which have labels."""

TRACE_LEVELS: dict[Event, Callable[[Any], Any]] = {
    Event.PERIOD_DOUBLING: lambda decay: -(1 + decay * decay),
    Event.FOLD: lambda decay: 1 + decay * decay,
    Event.PITCHFORK: lambda decay: 1 + decay * decay,
    Event.NODE_FOCUS: lambda decay: 2 * decay,
}
"""Trace of the return map at an event, by `decay`, the product of the restitution coefficients over the impacts.

The determinant is decay^2 (r^4 for a 1:1 motion, (A.3)), so that the multipliers are the roots of
lambda^2 - tr lambda + decay^2: one is -1 at tr = -(1 + decay^2), one is 1 at tr = 1 + decay^2, and both are equal,
Delta = 0, at the ends of a range of foci, tr = 2 decay and tr = -2 decay.
"""
