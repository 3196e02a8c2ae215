"""The margin that a designer acts on: the least one by rigid impacts, by compliant membranes or neglected effects."""

from __future__ import annotations

from enum import StrEnum
from math import inf
from typing import TYPE_CHECKING

from msgspec import Struct

from vireport.design.margins import Margin
from vireport.scenario.parameters import ScalarInput
from vireport.study.judging.alerts import is_near_critical
from vireport.study.judging.evidence import Evidence
from vireport.study.result_records import MarginToUseData

if TYPE_CHECKING:
    from vireport.design.effects import Shift


class LimitedBy(StrEnum):
    """Which model leaves the least margin."""

    RIGID = "rigid"
    COMPLIANT = "compliant"
    EFFECT = "effect"


class MarginToUse(Struct, frozen=True, eq=False):
    """The least margin of a stable motion of the design point, and what limits it.

    Attributes
    ----------
    parameter : ScalarInput
        The input that varies.
    relative : float or None
        Margin over the design value; 0 or negative where nothing is left. None where stable motion is lost altogether,
        or where the design value is zero.
    limited_by : LimitedBy
    end : Margin
        The nearest end by rigid impacts.
    shift : Shift or None
        The neglected effect that limits it.
    """

    parameter: ScalarInput
    relative: float | None
    limited_by: LimitedBy
    end: Margin
    shift: Shift | None = None

    @property
    def gone(self) -> bool:
        """Whether nothing is left: stable motion ends before the design point, or is not there."""
        if self.limited_by is LimitedBy.RIGID:
            return False
        return self.relative is None or self.relative <= 0

    @property
    def small(self) -> bool:
        """Whether less is left than common tolerances of masses and lengths."""
        return self.gone or is_near_critical(self.relative)

    @property
    def data(self) -> MarginToUseData:
        """The margin as results.json has it."""
        effect = self.shift.effect if self.shift is not None else None
        return MarginToUseData(
            parameter=self.parameter,
            relative=self.relative,
            limited_by=self.limited_by,
            effect=None if effect is None else effect.left_out,
            change=None if effect is None else effect.size or None,
            gone=self.gone,
        )


def margin_to_use(evidence: Evidence) -> MarginToUse | None:
    """Take the least of the known margins of a design point; None without a design point, or without an end.

    An end that is not known with compliant membranes is not taken into account: the verdict says so.
    """
    design, long_contacts, effects = evidence.solution.design, evidence.own_stiffness, evidence.effects
    end = design.nearest if design is not None else None
    if end is None:
        return None
    rigid = None if end.relative is None else end.size
    choices = [(end.size, MarginToUse(end.parameter, rigid, LimitedBy.RIGID, end))]
    compliant = long_contacts.end_of(end.parameter, end.point) if long_contacts is not None else None
    if long_contacts is not None and long_contacts.margin_gone:
        choices.append((-inf, MarginToUse(end.parameter, None, LimitedBy.COMPLIANT, end)))
    elif compliant is not None and compliant.compliant_margin is not None:
        soft = compliant.compliant_margin
        choices.append((soft, MarginToUse(end.parameter, soft, LimitedBy.COMPLIANT, end)))
    worst = effects.worst if effects is not None else None
    if worst is not None and effects is not None and effects.end is not None and worst.room < inf:
        choices.append((worst.room, MarginToUse(effects.end.parameter, worst.left, LimitedBy.EFFECT, end, worst)))
    return min(choices, key=lambda choice: choice[0])[1]
