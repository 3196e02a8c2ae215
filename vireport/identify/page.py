"""What the template of the page of an identification knows."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct

from vireport.scenario.loading import Loaded
from vireport.study.judging.alerts import Alert
from vireport.study.judging.opening import Opening, WordedOpening
from vireport.study.provenance import Provenance
from vireport.text.formatting import subtitle
from vireport.text.tables import Table
from vireport.text.templates import Words

if TYPE_CHECKING:
    from vireport.figures.style import Picture


class IdentifyReport(Struct, frozen=True, eq=False):
    """The object `report` of the templates of `vireport identify`.

    Attributes
    ----------
    opening : Opening
    parts : tuple of str or Table
        All that is known, in numbers.
    alerts : tuple of Alert
        On the record.
    record : str
        Name of the record.
    loaded : Loaded
        The scenario.
    pictures : mapping of str to Picture
    provenance : Provenance
    templates : Path, optional
        A folder whose templates come before ours.
    """

    opening: Opening
    parts: tuple[str | Table, ...]
    alerts: tuple[Alert, ...]
    record: str
    loaded: Loaded
    pictures: Mapping[str, Picture]
    provenance: Provenance
    templates: Path | None = None
    template: str = "identify.typ.j2"

    @property
    def title(self) -> str:
        """Title of the scenario, "" where it has none."""
        return self.loaded.scenario.title or ""

    @property
    def heading(self) -> str:
        """The heading of the page, with the name of the record."""
        return Words("identify", self.templates)("heading", self.record)

    @property
    def subtitle(self) -> str:
        """Title and file of the scenario."""
        return subtitle(self.title, self.provenance.scenario_name)

    @property
    def verdict(self) -> WordedOpening:
        """Verdict, sentence, facts and tiles that the page opens with, in words."""
        return self.opening.worded(self.templates)

    @property
    def listing(self) -> str:
        """The text of the scenario file that the report prints."""
        return self.loaded.document.text
