"""The pages of the PDFs of every example and of a comparison: filled, nothing parted that belongs together, legible."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import groupby, pairwise
from typing import Any

import pytest
from conftest import EXAMPLES, first
from msgspec import Struct
from pypdf import PageObject, PdfReader

from vireport.cli.app import main

NAMES = (
    *("horizontal", "inclined-forcing", "stiff-membrane", "simulated"),
    *("design-point", "best-design", "ci/passing", "ci/failing"),
)
COMPARED = ("horizontal", "inclined", "inclined-forcing")
CASES = first(0, [("inclined", "a4"), ("inclined", "letter"), *((name, "a4") for name in (*NAMES, "comparison"))])
EMPTY_FROM = 40.0
"""Height without text from which it counts as empty: more than that between the ticks of a figure [pt]."""

MOST_EMPTY, LEAST_OF_THE_LAST = 0.45, 0.2
"""Of the height of a page between its margins: what a figure leaves blank that stands on the next page, as none floats
into another section, and how far down the last page begins to be worth its paper."""

MOST_WORDS, MOST_NUMBERS = 150, 25
"""Of a first page, but for the numbers at ticks."""

OF_ANSWERS_ALONE = ("inclined", "horizontal", "inclined-forcing", "stiff-membrane", "design-point")
"""Examples whose first page says nothing of requirements."""

BEFORE_APPENDIX = {"simulated": 6}
"""Most pages before the appendix, where a scenario asks for sections of its own."""

MOST_PAGES = {"simulated": 11}

PAPERS = {"a4": (595.28, 841.89), "letter": (612.0, 792.0)}
TOP, FOOT, FOOTER = 54.0, 48.0, 32.0
"""Margins, and below which the footer is [pt]."""

HEADING, AFTER_HEADING = 20.0, 75.0
"""Height of a heading, and within which its content begins [pt]."""

LETTERING = 6.95
"""Least size of digits [pt]."""

LOWEST_OF_THE_FIRST = 0.3
"""Height over the foot of the sheet at which the first page ends at the latest, over that of the sheet."""

SECTION = 14.0
"""Size of the title of a section [pt]."""

POINTS = ("design-point", "best-design")
"""Examples without a sweep, and so without figures of the paper."""

SECTIONS = {
    "Impact velocity": ("The paper’s figures", "Along the sweep"),
    "The device and its motion": ("Key figure", "Design point"),
    "What moves the nearest end of stable motion": ("Margins",),
    "Phase portraits and time series": ("Simulation",),
    "Displacement of the capsule and the ball": ("Simulation",),
    "Bifurcation diagram by simulation": ("Simulation",),
    "Generated voltage": ("The paper’s figures", "Along the sweep"),
    "Electrical cycle of each impact": ("Voltage",),
    "Discriminant and eigenvalues": ("The paper’s figures", "Along the sweep"),
    "All scenarios on one axis": ("Along the sweep",),
}
"""Of figures, by their titles."""

WHOLE_UP_TO = 14
"""Rows of a table that is never split."""


class Text(Struct, frozen=True):
    words: str
    height: float
    size: float
    plain: bool
    """Whether it is in the typeface of text."""


class Report(Struct, frozen=True):
    """A PDF, and what is printed on each page, from the top down."""

    name: str
    paper: str
    reader: PdfReader
    texts: list[list[Text]]


def texts(page: PageObject) -> list[Text]:
    places = []

    def note(words: str, outer: Any, inner: Any, font: Any, size: float) -> None:
        if words.strip():
            height = inner[4] * outer[1] + inner[5] * outer[3] + outer[5]
            scale = (inner[0] * inner[3] - inner[1] * inner[2]) * (outer[0] * outer[3] - outer[1] * outer[2])
            places.append(Text(words.strip(), height, abs(scale) ** 0.5 * size, "LibertinusSerif" in font["/BaseFont"]))

    page.extract_text(visitor_text=note)
    return sorted((text for text in places if text.height > FOOTER), key=lambda text: -text.height)


@pytest.fixture(scope="module", params=CASES, ids=" ".join)
def report(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Report:
    name, paper = request.param
    folder = tmp_path_factory.mktemp("pages")
    command, names = ("compare", COMPARED) if name == "comparison" else ("run", (name,))
    options = ["--format", "pdf", "--paper", paper, "-q", "-o", str(folder)]
    assert main([command, *(str(EXAMPLES / f"{name}.yaml") for name in names), *options]) == (name == "ci/failing")
    reader = PdfReader(folder / "report.pdf")
    return Report(name, paper, reader, [texts(page) for page in reader.pages])


def test_no_page_is_nearly_empty(report: Report) -> None:
    width, height = PAPERS[report.paper]
    first, *others, last = report.texts
    assert height - TOP - last[-1].height > LEAST_OF_THE_LAST * (height - TOP - FOOT)
    # What a figure fills between its ticks and labels is not empty.
    assert first[-1].height < LOWEST_OF_THE_FIRST * height or report.name == "comparison"
    for number, page in enumerate(others, 2):
        ends = [height - TOP, *(text.height for text in page if text.height < height - TOP), FOOT]
        empty = sum(above - below for above, below in pairwise(ends) if above - below > EMPTY_FROM)
        assert empty < MOST_EMPTY * (height - TOP - FOOT), number
    for page in report.reader.pages:
        assert [float(x) for x in page.mediabox] == pytest.approx([0, 0, width, height], abs=0.1)


def test_the_first_page_is_the_answer_in_few_words_and_numbers_and_margins_begin_the_second(report: Report) -> None:
    if report.name == "comparison":
        return  # which has no margins
    reader = report.reader
    # Numbers alone in a line are those of ticks.
    lines = [line for line in reader.pages[0].extract_text().splitlines() if re.search(r"[^\W\d]", line)]
    assert re.fullmatch(r"vireport \S+ Page 1 of \d+", lines[-1])
    printed = " ".join(lines[:-1])
    if report.name in OF_ANSWERS_ALONE:
        assert len(re.findall(r"[^\W\d_]{2,}[\w’-]*", printed)) <= MOST_WORDS
        assert len(re.findall(r"\d+(?:[.:]\d+)*", printed)) <= MOST_NUMBERS
    begins = {str(item.title): reader.get_destination_page_number(item) for item in flat(reader.outline)}
    assert begins["Margins"] == 1
    assert begins["Appendix"] <= BEFORE_APPENDIX.get(report.name, 4)


def test_no_heading_is_parted_from_its_content(report: Report) -> None:
    reader, pages = report.reader, report.texts
    for heading in flat(reader.outline):
        page, top = pages[reader.get_destination_page_number(heading)], float(heading.top)
        assert [text for text in page if top - AFTER_HEADING < text.height < top - HEADING], heading.title


def flat(outline: list[Any]) -> Iterator[Any]:
    for item in outline:
        if isinstance(item, list):
            yield from flat(item)
        else:
            yield item


def test_a_table_is_whole_on_a_page_or_split_with_its_head_repeated_and_no_row_alone(report: Report) -> None:
    reader = report.reader
    numbers = {page.indirect_reference.idnum: k for k, page in enumerate(reader.pages)}
    top = PAPERS[report.paper][1] - TOP
    lines = [lines_of(text for text in page if text.height < top) for page in report.texts]
    tables = list(elements(reader.trailer["/Root"]["/StructTreeRoot"], "/Table"))
    assert len(tables) > 8
    for table in tables:
        rows = [{numbers[page] for page in pages_of(row)} for row in elements(table, "/TR")]
        first, *others = sorted(set().union(*rows))
        assert len(rows) > WHOLE_UP_TO or not others
        assert all(len(row) == 1 for row in rows)
        assert not others or min(Counter(number for row in rows[1:] for number in row).values()) > 1
        for other in others:
            assert any(len(line) > 1 for line in lines[first] & lines[other])


def lines_of(page: Iterable[Text]) -> set[tuple[str, ...]]:
    """What stands at one height on a page, each as its words."""
    return {tuple(text.words for text in line) for _, line in groupby(page, lambda text: round(text.height, 1))}


def elements(node: Any, kind: str) -> Iterator[Any]:
    """The elements of a kind in the structure tree below a node."""
    for child in below(node):
        if child.get("/S") == kind:
            yield child
        else:
            yield from elements(child, kind)


def below(node: Any) -> list[Any]:
    children = node.get("/K", [])
    inner = [child.get_object() for child in (children if isinstance(children, list) else [children])]
    return [child for child in inner if isinstance(child, dict)]


def pages_of(node: Any) -> Iterator[int]:
    """The pages that an element of the structure tree is on."""
    if "/Pg" in node:
        yield node.raw_get("/Pg").idnum
    for child in below(node):
        yield from pages_of(child)


def test_figures_stand_in_their_sections(report: Report) -> None:
    section, places = "", {}
    for text, following in pairwise(text for page in report.texts for text in page):
        if text.size == pytest.approx(SECTION, abs=0.1):
            section = text.words
        elif re.fullmatch(r"Figure\s\d+\.", text.words):
            places[following.words.partition(",")[0].rstrip(".")] = section
    assert bool(places) == (report.name not in POINTS)
    assert not {title: section for title, section in places.items() if section not in SECTIONS[title]}


def test_figures_of_the_paper_have_its_numbers_and_no_others_have_any(report: Report) -> None:
    captions = [re.fullmatch(r"Figure\s(\d+)\.", text.words) for page in report.texts for text in page]
    numbers = [int(match[1]) for match in captions if match]
    of_the_paper = [] if report.name in POINTS else [2, 4, 7]
    assert numbers == ([3, 6, *of_the_paper] if report.name == "simulated" else of_the_paper)


def test_lettering_can_be_read(report: Report) -> None:
    """Digits stand in figures, tables and sentences; in subscripts and equations they are of another typeface."""
    sizes = [text.size for page in report.texts for text in page if text.plain and text.words[0].isdigit()]
    assert len(sizes) > 150
    assert min(sizes) > LETTERING


def test_a_report_is_short(report: Report) -> None:
    assert len(report.reader.pages) <= MOST_PAGES.get(report.name, 10) + (report.paper == "letter")  # which is shorter
