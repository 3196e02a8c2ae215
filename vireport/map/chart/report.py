"""What the page of a chart knows, the page of a map whose plane is filled by exact regions."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import ClassVar

from vireport.map.chart.chart import Chart
from vireport.map.chart.design import ChartMargin
from vireport.map.chart.opening import chart_opening
from vireport.map.chart.regions import PIXELS, ROOM
from vireport.map.chart.tables import points_table
from vireport.map.chart.words import Naming, naming
from vireport.map.design import MapDesign, MapMargin
from vireport.map.report import MapReport
from vireport.motions.events import Event
from vireport.scenario.parameters import Named
from vireport.study.judging.opening import WordedOpening
from vireport.text.formatting import ROUGHLY, capital, percent, rounded_text
from vireport.text.said import words_of
from vireport.text.tables import Table, worded_table

_said = words_of("chart")


ENDS = {Event.SWEEP_END: "end_sweep_end", Event.CLOSED: "end_closed"}
"""Macros for ends of curves at which nothing happens."""


class ChartReport(MapReport, frozen=True, eq=False, dict=True, kw_only=True):
    """The object `report` of the templates of `vireport map --over`.

    Attributes
    ----------
    chart : Chart
        Plane, curves (`loci`), points (`meetings`), regions, design point and limits.
    """

    chart: Chart

    words: ClassVar[str] = "chart"
    section: ClassVar[str] = "sections/regions.typ.j2"

    @property
    def axes(self) -> tuple[Named, ...]:
        """The two inputs of the chart."""
        return self.chart.plane.inputs

    @property
    def design(self) -> MapDesign | None:
        """The design point in the plane, with its `inputs`, `inside`, `margins` and `study`; None without one."""
        return self.chart.design

    @property
    def heading(self) -> str:
        """The heading of the report: what is charted over which inputs."""
        return self.say("heading", self.chart.plane)

    @cached_property
    def named(self) -> Naming:
        """Names of the motions in the chart, with what they mean."""
        return naming(self.chart, self.templates)

    @property
    def verdict(self) -> WordedOpening:
        """What the page opens with: as a run, where a 1:1 motion is stable at the design point."""
        return chart_opening(self.chart, self.named).worded(self.templates)

    @property
    def motion_name(self) -> str:
        """The first of the motions that are stable at the design point; "" where none is."""
        design = self.chart.design
        return self.named.of(design.motions[0].kind) if design is not None and design.motions else ""

    def beyond(self, margin: MapMargin) -> tuple[str, ...]:
        """Names of the motions that are stable beyond a margin around the design point."""
        return (self.named.motions(margin.beyond),) if isinstance(margin, ChartMargin) else ()

    def regions(self) -> Table:
        """Table of the regions with what is stable in each, the largest first."""
        rows = [
            (
                capital(self.named.long(region_set.kinds, self.chart.limits)),
                percent(region_set.share),
                str(len(region_set.regions)),
                *(rounded_text(float(value), self.exactness) for value in region_set.regions[0].inputs),
            )
            for region_set in self.chart.regions.sets
        ]
        plane = self.chart.plane
        heads = [axis.head for axis in self.axes]
        return worded_table(self.say, "regions", "tnnnn", rows, *heads, note=self.say("regions_note", plane.swept))

    def bands(self) -> Iterator[str | Table]:
        """Table of bands too narrow to be seen, with what is stable in them."""
        inputs = self.chart.plane.inputs
        if self.chart.unmeasured:
            yield self.say("unmeasured", self.chart.unmeasured)
        if self.chart.narrow:
            rows = [
                (
                    self.say("band_name", band),
                    inputs[band.varied].show(band.least, ROUGHLY),
                    inputs[band.varied].show(band.most, ROUGHLY),
                    inputs[band.varied].quantity,
                )
                for band in self.chart.narrow
            ]
            yield worded_table(self.say, "bands", "tnnt", rows, note=self.say("bands_note"))

    def _ending(self, event: Event) -> str:
        """What a curve begins or ends with."""
        return self.say(ENDS[event]) if event in ENDS else self.say("end", event)

    def points(self) -> Table:
        """Table of the points of codimension two."""
        return points_table(self.chart, self.templates)

    def curves(self) -> Iterator[str | Table]:
        """Table of the curves on which stable motions end, by their numbers in chart.json."""
        rows = [
            (
                str(number),
                locus.event.words,
                str(locus.word),
                str(len(locus.x)),
                self._ending(locus.events[0][1]),
                self._ending(locus.events[-1][1]),
            )
            for number, locus in enumerate(self.chart.loci, 1)
            if locus.bounds_stability.any()
        ]
        if rows:
            yield worded_table(self.say, "curves", "tttntt", rows, note=self.say("curves_note"))
        else:
            yield self.say("no_curves")

    def left_out(self) -> Table:
        """Table of what the report lacks, with the reasons."""
        chart, swept = self.chart, self.chart.plane.swept
        lacking = [
            _said("lacks_motions", chart.limits) if swept else _said("lacks_words"),
            _said("lacks_curves", swept),
            _said("lacks_narrow", 2 * ROOM / PIXELS),
            *([_said("lacks_ends", chart.not_followed)] if chart.not_followed else []),
            _said("lacks_from_rest"),
        ]
        return worded_table(self.say, "left_out", "tt", [what.parts(self.templates) for what in lacking])
