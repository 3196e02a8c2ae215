"""What the page of a chart knows, the page of a map whose plane is filled by exact regions."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

from vireport.map.chart.chart import Chart
from vireport.map.chart.design import ChartMargin
from vireport.map.chart.opening import chart_opening
from vireport.map.chart.regions import PIXELS, ROOM
from vireport.map.chart.tables import points_table
from vireport.map.chart.words import Naming, naming
from vireport.map.design import MapDesign, MapMargin
from vireport.map.report import MapReport
from vireport.scenario.parameters import Named
from vireport.study.judging.opening import WordedOpening
from vireport.text.tables import Table

if TYPE_CHECKING:
    from vireport.map.chart.network import FollowedLocus


class ChartReport(MapReport, frozen=True, eq=False, dict=True, kw_only=True):
    """The object `report` of the templates of `vireport map --over`.

    Attributes
    ----------
    chart : Chart
    """

    chart: Chart

    words: ClassVar[str] = "chart"
    section: ClassVar[str] = "sections/regions.typ.j2"

    @property
    def axes(self) -> tuple[Named, ...]:
        """The inputs."""
        return self.chart.plane.inputs

    @property
    def design(self) -> MapDesign | None:
        """The design point in the plane."""
        return self.chart.design

    @property
    def heading(self) -> str:
        """What is charted."""
        return self.say("heading", self.chart.plane)

    @cached_property
    def named(self) -> Naming:
        """How motions are named."""
        return naming(self.chart, self.templates)

    @property
    def verdict(self) -> WordedOpening:
        """What it opens with: of a stable 1:1 motion at the design point that is what a run says of it."""
        return chart_opening(self.chart, self.named).worded(self.templates)

    @property
    def motion_name(self) -> str:
        """The first of the motions that are stable at the design point; "" where none is."""
        design = self.chart.design
        return self.named.of(design.motions[0].kind) if design is not None and design.motions else ""

    def beyond(self, margin: MapMargin) -> tuple[str, ...]:
        """What is stable beyond a margin."""
        return (self.named.motions(margin.beyond),) if isinstance(margin, ChartMargin) else ()

    def bounding(self) -> Iterator[tuple[int, FollowedLocus]]:
        """The loci on which stable motions end, by their numbers in chart.json."""
        yield from ((n, locus) for n, locus in enumerate(self.chart.loci, 1) if locus.bounds_stability.any())

    @property
    def narrowest(self) -> float:
        """Share of a range that a region is wide at least."""
        return 2 * ROOM / PIXELS

    def points(self) -> Table:
        """The points of codimension two."""
        return points_table(self.chart, self.templates)
