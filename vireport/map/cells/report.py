"""What the page of a map of cells knows: what they hold, where quantities are largest."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from vireport.map.cells.cells import MapPlan
from vireport.map.cells.figures import map_pictures, outcomes_of
from vireport.map.cells.findings import MapFindings, findings_of
from vireport.map.design import MapDesign, MapMargin, nearest_either_way
from vireport.map.outputs import MapOutput, drawn
from vireport.map.report import MapReport
from vireport.motions.stability import STABILITIES
from vireport.scenario.loading import Loaded, LoadedMap
from vireport.scenario.parameters import DesignInput, Named
from vireport.study.judging.opening import Opening, Statement, WordedOpening
from vireport.study.judging.verdict import Status
from vireport.study.plan import Task
from vireport.study.study import Study, analyse
from vireport.text.formatting import capital, rounded_text
from vireport.text.said import words_of
from vireport.text.tables import Table, worded_table

if TYPE_CHECKING:
    from vireport.map.cells.store import Store


_said = words_of("map")


class CellsReport(MapReport, frozen=True, eq=False, dict=True, kw_only=True):
    """The object `report` of the templates of `vireport map` of a map file.

    Attributes
    ----------
    plan : MapPlan
        Axes, sampling and device of the map.
    findings : MapFindings
        Counts of the cells by what they hold, and their largest values.
    design : MapDesign or None
        The design point with its `inputs`, `inside`, `margins` and `study`; None without one.
    """

    plan: MapPlan
    findings: MapFindings
    design: MapDesign | None

    words: ClassVar[str] = "map"
    section: ClassVar[str] = "sections/cells.typ.j2"

    @property
    def axes(self) -> tuple[Named, ...]:
        """The inputs along the axes of the map."""
        return self.plan.named

    @property
    def heading(self) -> str:
        """The heading of the report: what is mapped over which inputs."""
        return self.say("over", self.plan)

    @property
    def motion_name(self) -> str:
        """Name of the 1:1 motion, if it is stable at the design point; else ""."""
        design = None if self.design is None or self.design.study is None else self.design.study.solution.design
        return self.say("motion_name") if design is not None and design.motions.stable_mask.any() else ""

    @cached_property
    def verdict(self) -> WordedOpening:
        """What the page opens with: as a run of the design point or, without one, what the cells hold."""
        if self.design is not None and self.design.study is not None:
            return self.design.study.opening.worded(self.templates)
        findings = self.findings
        missed = (_said("sentence", _said("missed", findings)),) if findings.missed else ()
        bullets = (_said("only_unstable", findings), *missed, _said("give_design"))
        facts = tuple(Statement(Status.NEUTRAL, fact) for fact in bullets)
        headline = _said("headline", self.plan, findings)
        return Opening(Status.NEUTRAL, _said("word"), headline, facts).worded(self.templates)

    def cells(self) -> Table:
        """Table of the numbers of cells by the type of their motion."""
        counts = [(self.say("kind", kind), self.findings.stability[kind]) for kind in (*STABILITIES, None)]
        return worded_table(self.say, "cells", "tnn", self._counted(counts))

    def values(self) -> Iterator[Table]:
        """Tables of the largest values and, where asked for, of what cells come to from rest."""
        findings, heads = self.findings, [axis.head for axis in self.axes]
        if findings.largest:
            rows = [
                (
                    capital(self.say("quantity", name)),
                    self.say("value", name, best.value),
                    *(rounded_text(value, self.exactness) for value in best.inputs),
                )
                for name, best in findings.largest.items()
            ]
            note = self.say("largest_note", self.plan.membrane is not None)
            yield worded_table(self.say, "largest", "tn" + "n" * len(heads), rows, heads, note=note)
        if findings.from_rest:
            note = self.say("sentence", self.say("missed", findings)) if findings.missed else ""
            yield worded_table(self.say, "from_rest", "tnn", self._counted(outcomes_of(findings)), note=note)

    def _counted(self, counts: Iterable[tuple[str, int]]) -> list[tuple[str, str, str]]:
        """Rows of what so many cells have."""
        return [(capital(name), f"{count:,}", self.say("share", count, self.findings.cells)) for name, count in counts]

    def left_out(self) -> Table:
        """Table of what the report lacks, with the reasons."""
        contents = {
            "motions": False,
            "figures": bool(self.pictures),
            "from_rest": self.plan.from_rest,
            "shock": self.plan.shock,
            "voltage": self.plan.membrane is not None,
        }
        rows = [_said(f"lacks_{name}").parts(self.templates) for name, present in contents.items() if not present]
        return worded_table(self.say, "left_out", "tt", rows)


def report_of(store: Store, loaded: LoadedMap, design: Loaded | None, output: MapOutput) -> CellsReport:
    """What a finished map comes to, with its figures drawn.

    Parameters
    ----------
    store : Store
        With the finished map.
    loaded : LoadedMap
        The map file.
    design : Loaded, optional
        Its design point.
    output : MapOutput
    """
    plan, templates = store.plan, output.templates
    findings, at_design = findings_of(plan, store.result), map_design(design, plan)
    pictures = drawn(output, lambda: map_pictures(plan, store.result, findings, at_design, templates))
    return CellsReport(
        loaded,
        pictures,
        output.provenance(loaded, pictures),
        templates,
        plan=plan,
        findings=findings,
        design=at_design,
    )


def map_design(loaded: Loaded | None, plan: MapPlan) -> MapDesign | None:
    """Solve the scenario at the design point of a map; None where it has none.

    Parameters
    ----------
    loaded : Loaded or None
        `LoadedMap.design`.
    plan : MapPlan

    Raises
    ------
    NumericalError
        As a run of it.
    """
    if loaded is None:
        return None
    study = analyse(loaded, (Task.JSON,))
    device, mass = study.solution.device, study.scenario.device.ball_mass_kg
    values = {varied.value: device.value_of(varied) for varied in DesignInput} | {"ball_mass_kg": mass}
    inputs = tuple(float(values[name]) for name in plan.names)
    inside = all(low <= value <= high for value, (low, high) in zip(inputs, plan.ends, strict=True))
    return MapDesign(inputs, nearest_either_way(_ends(study, plan.names)), study, inside)


def _ends(study: Study, names: tuple[str, ...]) -> Iterator[MapMargin]:
    """Where the stable motions of a design point end along the axes of a map, or others take over."""
    design = study.solution.design
    for end in design.limits() if design is not None and design.motions.stable_mask.any() else ():
        if end.parameter.value in names:
            axis = names.index(end.parameter.value)
            yield MapMargin(axis, end.event, end.sweep_value, end.distance, end.error_bound, end.taken_over)
