"""What the template of the report on the paper knows."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct

from vireport.paper.opening import paper_opening
from vireport.paper.reproduction import ReproducedPaper
from vireport.report.printed import misprints_table, numbers_table, types_table
from vireport.study.checks.paper import PAPER
from vireport.study.judging.opening import WordedOpening
from vireport.study.provenance import Provenance
from vireport.text.tables import Table
from vireport.text.templates import Words

if TYPE_CHECKING:
    from vireport.figures.style import Picture


class PaperReport(Struct, frozen=True, eq=False):
    """The object `report` of the templates of `vireport paper`.

    Attributes
    ----------
    paper : ReproducedPaper
    pictures : mapping of str to Picture
    provenance : Provenance
    templates : Path, optional
        A folder whose templates come before ours.
    """

    paper: ReproducedPaper
    pictures: Mapping[str, Picture]
    provenance: Provenance
    templates: Path | None = None
    template: str = "paper.typ.j2"

    @property
    def title(self) -> str:
        """Title of the page on the paper."""
        return Words("reproduction", self.templates)("heading")

    @property
    def subtitle(self) -> str:
        """Reference of the paper, under the title."""
        return PAPER

    @property
    def verdict(self) -> WordedOpening:
        """Sentence, facts and tiles that the page opens with, in words."""
        return paper_opening(self.paper).worded(self.templates)

    @property
    def overrides(self) -> tuple[str, ...]:
        """Values that replaced those of the paper's scenarios, as ``path=value``."""
        return self.paper.overrides

    def numbers(self) -> tuple[str | Table, ...]:
        """Every printed number beside ours, with what is to be known for reading them."""
        return Words("paper", self.templates)("which_phase"), numbers_table(self.paper.compared, self.templates)

    def table_1(self) -> Table:
        """Table 1 with the numbers of its intervals."""
        return types_table(self.paper.compared, self.templates)

    def slips(self) -> Table:
        """The slips in the paper's text."""
        return misprints_table(self.paper.compared, self.templates)

    @property
    def listing(self) -> str:
        """The scenarios as given, one after the other."""
        return "\n".join(study.loaded.document.text for study in self.paper.studies)
