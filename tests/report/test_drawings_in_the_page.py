"""The figures in an HTML page: all of what is drawn, as elements of it, and no script that runs."""

from __future__ import annotations

import re
import shlex

import pytest
from bs4 import BeautifulSoup
from msgspec.structs import replace
from pages import tidy

from vireport.figures import pictures
from vireport.report import Report, render_html
from vireport.study import Study, provenance_of, with_pages


def report_of(study: Study) -> Report:
    origin = with_pages(provenance_of(study.loaded, "vireport run test.yaml"), drawn=True)
    return Report(study, {picture.name: picture for picture in pictures(study)}, origin)


def elements(drawing: str) -> list[tuple[str, dict[str, str], str]]:
    """The elements of a drawing in their order: name, attributes, text of its own."""
    shown = []
    for element in BeautifulSoup(drawing, "html.parser").find_all(True):
        attributes = {name: tidy(str(value)) for name, value in element.attrs.items() if name != "xmlns"}
        shown.append((element.name, attributes, tidy("".join(element.find_all(string=True, recursive=False)))))
    return shown


@pytest.fixture(scope="module")
def drawn(study_of) -> tuple[Report, str]:
    """A report with figures along a sweep, and its page."""
    report = report_of(study_of("horizontal"))
    return report, render_html(report).decode()


def test_the_page_has_every_element_that_is_drawn_and_its_text(drawn) -> None:
    report, page = drawn
    assert "<img" not in page
    drawings = re.findall("<svg .*?</svg>", page, re.DOTALL)
    drawn_in_page = {re.search('data-figure="(.*?)"', drawing)[1]: drawing for drawing in drawings}
    assert len(drawings) == len(report.pictures)
    assert drawn_in_page.keys() == report.pictures.keys()
    for name, picture in report.pictures.items():
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
