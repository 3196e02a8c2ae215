"""What the page of a map of cells knows: what they hold, where quantities are largest, the columns of its file."""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar

from msgspec import Struct

from vireport.map.cells.cells import MapPlan
from vireport.map.cells.evaluation import schema_of
from vireport.map.cells.figures import outcomes_of
from vireport.map.cells.findings import MapFindings
from vireport.map.design import MapDesign
from vireport.map.report import MapReport
from vireport.motions.stability import STABILITIES, Stability
from vireport.scenario.parameters import Named
from vireport.study.judging.opening import Opening, Statement, WordedOpening
from vireport.study.judging.verdict import Status
from vireport.text.said import words_of

_said = words_of("map")


class MapColumn(Struct, frozen=True):
    """A column of the finished map; its unit is "1" for a pure number and "" for words."""

    name: str
    type: str
    unit: str


class CellsReport(MapReport, frozen=True, eq=False, dict=True, kw_only=True):
    """The object `report` of the templates of `vireport map` of a map file.

    Attributes
    ----------
    plan : MapPlan
    findings : MapFindings
    design : MapDesign or None
    digest : str
        SHA-256 of the finished map.
    """

    plan: MapPlan
    findings: MapFindings
    design: MapDesign | None
    digest: str

    words: ClassVar[str] = "map"
    section: ClassVar[str] = "sections/cells.typ.j2"

    @property
    def axes(self) -> tuple[Named, ...]:
        """The axes of the map."""
        return self.plan.named

    @property
    def heading(self) -> str:
        """What is mapped."""
        return self.say("over", self.plan)

    @property
    def motion_name(self) -> str:
        """That of 1:1 motions, of which alone cells are, where one is stable at the design point."""
        design = None if self.design is None or self.design.study is None else self.design.study.solution.design
        return self.say("motion_name") if design is not None and design.motions.stable_mask.any() else ""

    @cached_property
    def verdict(self) -> WordedOpening:
        """That of a run of the design point; without one, what the cells hold."""
        if self.design is not None and self.design.study is not None:
            return self.design.study.opening.worded(self.templates)
        findings = self.findings
        missed = (_said("sentence", _said("missed", findings)),) if findings.missed else ()
        bullets = (_said("only_unstable", findings), *missed, _said("give_design"))
        facts = tuple(Statement(Status.NEUTRAL, fact) for fact in bullets)
        headline = _said("headline", self.plan, findings)
        return Opening(Status.NEUTRAL, _said("word"), headline, facts).worded(self.templates)

    @property
    def types(self) -> list[tuple[Stability | None, int]]:
        """Cells by the type of their motion."""
        return [(kind, self.findings.stability[kind]) for kind in (*STABILITIES, None)]

    @property
    def outcomes(self) -> list[tuple[str, int]]:
        """What cells come to from rest, and how many do."""
        return outcomes_of(self.findings)

    @property
    def columns(self) -> list[MapColumn]:
        """The columns of the finished map."""
        units = [((field.metadata or {}).get(b"unit", b"").decode(), field) for field in schema_of(self.plan)]
        return [MapColumn(field.name, _plain_type(field.type), unit) for unit, field in units]


def _plain_type(kind: Any) -> str:
    """The type of the values of a column: of coded words, that of the words."""
    return str(getattr(kind, "value_type", kind))
