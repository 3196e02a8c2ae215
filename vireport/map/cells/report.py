"""What the templates of the report of a map know: its design point, what the cells hold, the figures, the columns."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct

from vireport.map.cells.cells import MapPlan
from vireport.map.cells.design import MapDesign
from vireport.map.cells.evaluation import schema_of
from vireport.map.cells.findings import MapFindings
from vireport.motions.stability import STABILITIES, Stability
from vireport.scenario.loading import LoadedMap
from vireport.study.judging.alerts import Alert
from vireport.study.judging.opening import Opening, Statement, WordedOpening
from vireport.study.judging.verdict import Status
from vireport.study.provenance import Provenance
from vireport.text.formatting import OF_A_MODEL, Exactness, subtitle
from vireport.text.said import words_of
from vireport.text.templates import Words

if TYPE_CHECKING:
    from vireport.design.margins import Margin
    from vireport.figures.style import Picture

_said = words_of("map")


class MapColumn(Struct, frozen=True):
    """A column of the finished map; its unit is "1" for a pure number and "" for words."""

    name: str
    type: str
    unit: str


class MapReport(Struct, frozen=True, eq=False, dict=True):
    """The object `report` of the templates of `vireport map`.

    Attributes
    ----------
    plan : MapPlan
    loaded : LoadedMap
        The map file.
    found : MapFindings
    design : MapDesign or None
    digest : str
        SHA-256 of the finished map.
    pictures : mapping of str to Picture
    provenance : Provenance
    templates : Path, optional
        A folder whose templates come before ours.
    """

    plan: MapPlan
    loaded: LoadedMap
    found: MapFindings
    design: MapDesign | None
    digest: str
    pictures: Mapping[str, Picture]
    provenance: Provenance
    templates: Path | None = None
    template: str = "map.typ.j2"

    @property
    def title(self) -> str:
        """That of the map file, "" where it has none."""
        return self.loaded.scenario.title or ""

    @property
    def heading(self) -> str:
        """What is mapped."""
        return self.say("over", self.plan)

    @property
    def subtitle(self) -> str:
        """Title and name of the map file."""
        return subtitle(self.title, self.provenance.scenario_name)

    def say(self, macro: str, *values: Any) -> str:
        """What a macro of the words of maps says."""
        return Words("map", self.templates)(macro, *values)

    @cached_property
    def verdict(self) -> WordedOpening:
        """That of a run of the design point; without one, what the cells hold."""
        if self.design is not None:
            return self.design.study.opening.worded(self.templates)
        missed = (_said("sentence", _said("missed", self.found)),) if self.found.missed else ()
        bullets = (_said("only_unstable", self.found), *missed, _said("give_design"))
        facts = tuple(Statement(Status.NEUTRAL, fact) for fact in bullets)
        headline = _said("headline", self.plan, self.found)
        return Opening(Status.NEUTRAL, _said("word"), headline, facts).worded(self.templates)

    @property
    def exactness(self) -> Exactness:
        """How exact all numbers are: as those of the run of the design point."""
        return OF_A_MODEL if self.design is None else self.design.study.evidence.exactness

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """What must be known of the design point, as a run says it."""
        return () if self.design is None else self.design.study.alerts

    @cached_property
    def ends(self) -> list[tuple[int, Margin]]:
        """Along which axis the motion of the design point ends, and its margin; those of one axis together."""
        ends = () if self.design is None else self.design.ends(self.plan.names)
        return sorted(ends, key=lambda end: (end[0], end[1].distance))

    @property
    def types(self) -> list[tuple[Stability | None, int]]:
        """Cells by the type of their motion."""
        return [(kind, self.found.stability[kind]) for kind in (*STABILITIES, None)]

    @property
    def outcomes(self) -> list[tuple[str, int]]:
        """What cells come to from rest, and how many do."""
        from vireport.map.cells.figures import outcomes_of

        return outcomes_of(self.found)

    @property
    def columns(self) -> list[MapColumn]:
        """The columns of the finished map."""
        units = [((field.metadata or {}).get(b"unit", b"").decode(), field) for field in schema_of(self.plan)]
        return [MapColumn(field.name, _plain_type(field.type), unit) for unit, field in units]

    @property
    def listing(self) -> str:
        """The map file as given."""
        return self.loaded.text


def _plain_type(kind: Any) -> str:
    """The type of the values of a column: of coded words, that of the words."""
    return str(getattr(kind, "value_type", kind))
