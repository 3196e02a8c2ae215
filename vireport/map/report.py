"""What the templates of the report of a map know, whatever fills its plane."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from msgspec import Struct

from vireport.map.design import MapDesign, MapMargin, alerts_of, exactness_of
from vireport.scenario.loading import Loaded, LoadedMap
from vireport.scenario.parameters import Named
from vireport.study.judging.alerts import Alert
from vireport.study.judging.opening import WordedOpening
from vireport.study.provenance import Provenance
from vireport.text.formatting import Exactness, percent, subtitle
from vireport.text.tables import Table, worded_table
from vireport.text.templates import Words

if TYPE_CHECKING:
    from vireport.figures.style import Picture


class MapReport(Struct, frozen=True, eq=False, dict=True):
    """The object `report` of the templates of `vireport map`.

    Attributes
    ----------
    loaded : Loaded or LoadedMap
        The scenario or map file.
    pictures : mapping of str to Picture
        Figures by their names, that of the first page first.
    provenance : Provenance
        Version, file with its SHA-256, Python, libraries, command and timestamp.
    templates : Path or None
        The user's folder, whose templates come before those of the package.
    words : str
        Name of the file of words.
    section : str
        The template that says what fills the plane.
    """

    loaded: Loaded | LoadedMap
    pictures: Mapping[str, Picture]
    provenance: Provenance
    templates: Path | None

    template: ClassVar[str] = "map.typ.j2"
    words: ClassVar[str]
    section: ClassVar[str]

    @property
    def axes(self) -> tuple[Named, ...]:
        """The inputs along the axes."""
        raise NotImplementedError

    @property
    def design(self) -> MapDesign | None:
        """The design point with its `inputs`, `inside`, `margins` and `study`; None without one."""
        raise NotImplementedError

    @property
    def verdict(self) -> WordedOpening:
        """What the page opens with, in words: `sentence`, `status`, `facts` and `tiles`."""
        raise NotImplementedError

    @property
    def heading(self) -> str:
        """The heading of the page."""
        raise NotImplementedError

    @property
    def motion_name(self) -> str:
        """What the motion is called whose ends are margins of the design point; "" where none is stable."""
        raise NotImplementedError

    def beyond(self, margin: MapMargin) -> tuple[str, ...]:
        """Further cells of the row of a margin: what is stable beyond it, where that is known."""
        return ()

    @property
    def title(self) -> str:
        """Title of the file; "" without one."""
        return self.loaded.scenario.title or ""

    @property
    def subtitle(self) -> str:
        """Title and name of the file."""
        return subtitle(self.title, self.provenance.scenario_name)

    @property
    def listing(self) -> str:
        """Text of the file."""
        return self.loaded.document.text

    @property
    def exactness(self) -> Exactness:
        """How exact the numbers are, which says how many digits are printed."""
        return exactness_of(self.design)

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """The alerts of a run of the design point."""
        return alerts_of(self.design)

    def say(self, macro: str, *values: object) -> str:
        """What a macro of the words of the map says of some values."""
        return Words(self.words, self.templates)(macro, *values)

    @property
    def place(self) -> str:
        """Where the design point is, in words."""
        values = self.design.inputs if self.design is not None else ()
        return ", ".join(varied.place(value) for varied, value in zip(self.axes, values, strict=False))

    @property
    def margins(self) -> Table | None:
        """Where the motion of the design point ends along the axes; None where no end is known."""
        if self.design is None or not self.design.margins:
            return None
        said = Words("map", self.templates)
        rows = tuple(
            (
                self.axes[margin.axis].quantity,
                self.axes[margin.axis].show(margin.value, self.exactness),
                self.axes[margin.axis].signed(margin.distance),
                percent(margin.relative, signed=True),
                said("handover" if margin.taken_over else "end", margin.event),
                *self.beyond(margin),
            )
            for margin in self.design.margins
        )
        beyond = len(rows[0]) > len("tnnnt")
        heads = self.motion_name, self.place, beyond
        return worded_table(said, "margins", "tnnntt" if beyond else "tnnnt", rows, *heads, note=said("margins_note"))
