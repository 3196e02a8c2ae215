"""The figures in an HTML page: all of what is drawn, as elements of it, and no script that runs."""

from __future__ import annotations

import gc
import re
import shlex
import weakref
from html.parser import HTMLParser

import pytest
from msgspec.structs import replace
from pages import render_html, tidy

from vireport.figures.pictures import pictures
from vireport.figures.style import Picture
from vireport.report.context import Report
from vireport.report.templates import fill
from vireport.study.provenance import provenance_of, with_pages
from vireport.study.study import Study


def report_of(study: Study) -> Report:
    origin = with_pages(provenance_of(study.loaded, "vireport run test.yaml"), drawn=True)
    return Report(study, {picture.name: picture for picture in pictures(study)}, origin)


class Elements(HTMLParser):
    """The elements of a drawing in their order: name, attributes, text within them alone."""

    def __init__(self, drawing: str) -> None:
        super().__init__()
        self.all: list[tuple[str, dict[str, str], list[str]]] = []
        self.open: list[int] = []
        self.feed(drawing)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.open.append(len(self.all))
        self.all.append((tag, {name: tidy(value or "") for name, value in attrs if name != "xmlns"}, []))

    def handle_endtag(self, tag: str) -> None:
        assert self.all[self.open.pop()][0] == tag

    def handle_data(self, data: str) -> None:
        if self.open:
            self.all[self.open[-1]][2].append(data)


def elements(drawing: str) -> list[tuple[str, dict[str, str], str]]:
    return [(tag, attributes, tidy("".join(texts))) for tag, attributes, texts in Elements(drawing).all]


@pytest.fixture(scope="module")
def drawn(study_of) -> tuple[Report, str]:
    """A report with figures along a sweep, and its page."""
    report = report_of(study_of("horizontal"))
    return report, render_html(report).decode()


class Pictures(dict[str, Picture]):
    """Those of a report; of a plain dict nobody can tell whether it is still held."""


def test_the_figures_of_a_report_are_let_go_with_it(study_of) -> None:
    study = study_of("inclined")
    report = Report(study, Pictures(), provenance_of(study.loaded, "vireport run test.yaml"))
    assert fill(report)
    held = weakref.ref(report.pictures)
    del report
    gc.collect()
    assert held() is None


@pytest.mark.slow
def test_the_page_has_every_element_that_is_drawn_and_its_text(drawn) -> None:
    report, page = drawn
    assert "<img" not in page
    drawings = re.findall("<svg .*?</svg>", page, re.DOTALL)
    drawn_in_page = {re.search('data-figure="(.*?)"', drawing)[1]: drawing for drawing in drawings}
    assert len(drawings) == len(report.pictures)
    assert drawn_in_page.keys() == report.pictures.keys()
    for name, picture in report.pictures.items():
        assert len(elements(picture.inline)) > 30
        assert elements(drawn_in_page[name]) == elements(picture.inline)


def test_no_two_things_of_a_page_have_the_same_identifier(drawn) -> None:
    _, page = drawn
    identifiers = re.findall(' id="([^"]*)"', page)
    assert len(set(identifiers)) == len(identifiers)
    assert set(re.findall(r'(?:href="|url\()#([^")]*)', page)) <= set(identifiers)


def test_no_script_runs_and_the_policy_of_a_page_allows_none(drawn) -> None:
    _, page = drawn
    assert re.findall(r"<script([^>]*)>", page) == [
        f' type="application/json" id="{name}-data"' for name in ("scenario", "results")
    ]
    assert "default-src 'none'; img-src data:" in page
    assert "script-src" not in page


def test_a_page_has_the_command_that_opens_the_bench(study_of, drawn) -> None:
    assert "vireport explore horizontal.yaml</code>" in drawn[1]
    over = Report(study_of("horizontal", "title=a 'b'"), {}, drawn[0].provenance).explored
    assert shlex.split(over) == ["vireport", "explore", "horizontal.yaml", "--set", "title=a 'b'"]
    unnamed = replace(drawn[0].provenance, scenario_name="<stdin>")
    assert Report(drawn[0].study, {}, unnamed).explored == ""
