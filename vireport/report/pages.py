"""What a report is made of: sections of paragraphs, tables, pictures and equations, ready to be set.

Templates go through these and neither compute nor format. In texts, ``*x*`` is a symbol and ``x_c`` has a
subscript; cells of number and code columns, titles and listings are taken as they stand, so that a scenario's
own text never is markup.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from vireport.alerts import Severity
from vireport.gate import Verdict
from vireport.study import Provenance
from vireport.text import Table

if TYPE_CHECKING:
    from vireport.figures import Picture


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Running text."""

    kind: ClassVar[str] = "paragraph"
    text: str


@dataclass(frozen=True, slots=True)
class Subheading:
    """A heading within a section."""

    kind: ClassVar[str] = "subheading"
    text: str


@dataclass(frozen=True, slots=True)
class Notice:
    """An alert.

    Attributes
    ----------
    severity : Severity
    code, title, cause, remedy : str
    """

    kind: ClassVar[str] = "notice"
    severity: Severity
    code: str
    title: str
    cause: str
    remedy: str


@dataclass(frozen=True, slots=True)
class Figure:
    """A picture.

    Attributes
    ----------
    name, title, caption, alt : str
    svg : bytes
        As a file.
    """

    kind: ClassVar[str] = "figure"
    name: str
    title: str
    caption: str
    alt: str
    svg: bytes


@dataclass(frozen=True, slots=True)
class Equation:
    """A display equation.

    Attributes
    ----------
    name : str
    number : str
        In the paper, or "".
    alt : str
        In words.
    typst, mathml : str
        Markup that is ours, and taken as such.
    note : str
        What is to be said about it, or "".
    """

    kind: ClassVar[str] = "equation"
    name: str
    number: str
    alt: str
    typst: str
    mathml: str
    note: str


@dataclass(frozen=True, slots=True)
class Listing:
    """A text as it stands, line by line."""

    kind: ClassVar[str] = "listing"
    title: str
    text: str


Block = Paragraph | Subheading | Table | Notice | Figure | Equation | Listing


@dataclass(frozen=True, slots=True)
class Section:
    """A section of the report.

    Attributes
    ----------
    key : str
        Its anchor.
    title : str
    blocks : tuple of Block
    """

    key: str
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, slots=True)
class ReportModel:
    """All that both templates know.

    Attributes
    ----------
    title : str
        Of the scenario; free text.
    verdict : Verdict
    sections : tuple of Section
        In the order of the page; the verdict stands before them.
    scenario_text : str
        The file, for the PDF to carry.
    pictures : tuple of Picture
        All that the sections show.
    live : str
        What makes figures of the HTML page live, or "".
    provenance : Provenance
    """

    title: str
    verdict: Verdict
    sections: tuple[Section, ...]
    scenario_text: str
    pictures: tuple[Picture, ...]
    live: str
    provenance: Provenance


def content(parts: Iterable[str | Table]) -> Iterator[Block]:
    """Paragraphs and tables that a feature gives for the terminal and the report alike."""
    for part in parts:
        yield Paragraph(part) if isinstance(part, str) else part


def section(key: str, title: str, blocks: Iterable[Block]) -> tuple[Section, ...]:
    """Make a section of what there is; none where there is nothing."""
    present = tuple(blocks)
    return (Section(key, title, present),) if present else ()
