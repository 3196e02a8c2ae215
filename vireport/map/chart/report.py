"""What the templates of the report of a chart know: the verdict of the design point, regions, loci, their meetings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct

from vireport.map.chart.chart import Chart
from vireport.map.chart.opening import chart_opening
from vireport.map.chart.regions import PIXELS, ROOM
from vireport.map.chart.tables import points_table
from vireport.map.chart.words import Naming, naming, words_given
from vireport.scenario.loading import Loaded
from vireport.study.judging.alerts import Alert
from vireport.study.judging.opening import WordedOpening
from vireport.study.provenance import Provenance
from vireport.text.formatting import Exactness, subtitle
from vireport.text.tables import Table
from vireport.text.templates import Words

if TYPE_CHECKING:
    from vireport.figures.style import Picture
    from vireport.map.chart.network import FollowedLocus


class ChartReport(Struct, frozen=True, eq=False, dict=True):
    """The object `report` of the templates of `vireport map --over`.

    Attributes
    ----------
    chart : Chart
        With its regions.
    loaded : Loaded
        The scenario.
    pictures : mapping of str to Picture
    provenance : Provenance
    templates : Path, optional
        A folder whose templates come before ours.
    """

    chart: Chart
    loaded: Loaded
    pictures: Mapping[str, Picture]
    provenance: Provenance
    templates: Path | None = None
    template: str = "chart.typ.j2"

    @property
    def title(self) -> str:
        """That of the scenario, "" where it has none."""
        return self.loaded.scenario.title or ""

    @property
    def heading(self) -> str:
        """What is charted."""
        return self.say("heading", self.chart.plane)

    @property
    def subtitle(self) -> str:
        """Title and file of the scenario."""
        return subtitle(self.title, self.provenance.scenario_name)

    @cached_property
    def named(self) -> Naming:
        """How motions are named."""
        return naming(self.chart, self.templates)

    @cached_property
    def given(self) -> dict[str, Any]:
        """What the words of the chart are told by."""
        return words_given(self.chart, self.named)

    def say(self, macro: str, *values: Any) -> str:
        """What a macro of the words of charts says."""
        return Words("chart", self.templates)(macro, *values)

    @property
    def verdict(self) -> WordedOpening:
        """What it opens with: of a stable 1:1 motion at the design point that is what a run says of it."""
        return chart_opening(self.chart, self.named).worded(self.templates)

    @property
    def exactness(self) -> Exactness:
        """How exact all numbers are."""
        return self.chart.exactness

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """What must be known of the design point, as a run says it."""
        return self.chart.alerts

    def bounding(self) -> Iterator[tuple[int, FollowedLocus]]:
        """The loci on which stable motions end, by their numbers in chart.json."""
        yield from ((n, locus) for n, locus in enumerate(self.chart.loci, 1) if locus.bounds_stability.any())

    @property
    def narrowest(self) -> float:
        """Share of a range that a region is wide at least."""
        return 2 * ROOM / PIXELS

    def points(self) -> Table:
        """The points of codimension two."""
        return points_table(self.chart)

    @property
    def listing(self) -> str:
        """The scenario as given."""
        return self.loaded.document.text
